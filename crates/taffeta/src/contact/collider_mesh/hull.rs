//! Convex hulls, by parry3d (Quickhull: Barber, Dobkin, Huhdanpaa 1996).

use crate::topology::Surface;
use parry3d_f64::math::Vector;
use parry3d_f64::transformation::try_convex_hull;

/// Thickness below which points count as flat, relative to their extent.
const FLAT: f64 = 1e-9;

/// The surface of the convex hull of some points [m]. The error is the reason why there is none.
pub fn hull(points: &[[f64; 3]]) -> Result<Surface, String> {
    let flat = "has no convex hull: its nodes do not span a volume; four that are not in a plane would do";
    let even = Even::of(points).ok_or(flat)?;
    let evened: Vec<Vector> = points.iter().map(|x| Vector::from_array(even.to(*x))).collect();
    let (corners, triangles) = try_convex_hull(&evened).map_err(|_| flat)?;
    let nodes: Vec<[f64; 3]> = corners.iter().map(|y| even.from([y.x, y.y, y.z])).collect();
    Ok(Surface::of_triangles(nodes, triangles))
}

/// An affine map that gives points the same spread in all directions. Hulls commute with it, and thin plates are not
/// taken for flat. With C = L Lᵀ the covariance, y = L⁻¹ (x − mean).
struct Even {
    mean: [f64; 3],
    /// Rows of L, a lower triangle.
    rows: [[f64; 3]; 3],
}

impl Even {
    /// `None` if the points are in a plane.
    fn of(points: &[[f64; 3]]) -> Option<Self> {
        let fraction = 1.0 / points.len() as f64;
        let mean = points.iter().fold([0.0; 3], |sum, x| [0, 1, 2].map(|i| sum[i] + x[i] * fraction));
        let mut rows = [[0.0; 3]; 3];
        for i in 0..3 {
            for j in 0..=i {
                let spread: f64 = points.iter().map(|x| (x[i] - mean[i]) * (x[j] - mean[j]) * fraction).sum();
                let known: f64 = (0..j).map(|k| rows[i][k] * rows[j][k]).sum();
                rows[i][j] = if i == j { (spread - known).sqrt() } else { (spread - known) / rows[j][j] };
            }
        }
        let extent: f64 = rows.iter().flatten().map(|x| x * x).sum::<f64>().sqrt();
        let thick = (0..3).all(|i| rows[i][i] > FLAT * extent);
        thick.then_some(Self { mean, rows })
    }

    fn to(&self, x: [f64; 3]) -> [f64; 3] {
        let mut y = [0.0; 3];
        for i in 0..3 {
            let known: f64 = (0..i).map(|k| self.rows[i][k] * y[k]).sum();
            y[i] = (x[i] - self.mean[i] - known) / self.rows[i][i];
        }
        y
    }

    fn from(&self, y: [f64; 3]) -> [f64; 3] {
        [0, 1, 2].map(|i| self.mean[i] + (0..=i).map(|k| self.rows[i][k] * y[k]).sum::<f64>())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::topology::{Edges, measure};

    #[test]
    fn the_hull_of_two_nested_cubes_is_the_outer_one() {
        let corner = |i: u32, size: f64| [0, 1, 2].map(|axis| if i >> axis & 1 == 1 { size } else { -size });
        let points: Vec<_> = (0..16).map(|i| corner(i % 8, if i < 8 { 1.0 } else { 0.5 })).collect();
        let cube = hull(&points).unwrap();
        assert_eq!(cube.triangles.len(), 12);
        assert!(Edges::new(cube.nodes.len(), &cube.triangles, &[]).is_closed());
        assert!((measure::volume(&cube.nodes, &cube.triangles) - 8.0).abs() < 1e-12);
        let thin: Vec<_> = points.iter().map(|&[x, y, z]| [x, x + 1e-4 * y, z]).collect();
        let plate = hull(&thin).unwrap();
        assert!((measure::volume(&plate.nodes, &plate.triangles) - 8e-4).abs() < 1e-15);
        assert!(hull(&[[0.0; 3], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0], [1.0, 0.0, 1.0]]).is_err());
        assert!(hull(&[]).is_err());
    }
}
