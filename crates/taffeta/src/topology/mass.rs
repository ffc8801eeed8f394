//! Lumped masses: each triangle gives a third of its share to each corner, each link half to each end.

use crate::scene::{Kind, Mass};

/// What masses are shared out by.
///
/// ```
/// use taffeta::scene::{Kind, Mass};
/// use taffeta::topology::mass::{Shares, lump};
///
/// // Three nodes in a row, the second link twice as long as the first.
/// let links = ([[0, 1], [1, 2]].as_slice(), [0.1, 0.2].as_slice());
/// let shares = Shares { nodes: 3, triangles: (&[], &[]), links, volume: 0.0 };
/// let masses = lump(Mass::Whole(0.06), Kind::Cloth, &shares)?;
/// assert!(masses.iter().zip([0.01, 0.03, 0.02]).all(|(mass, expected)| (mass - expected).abs() < 1e-12));
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Shares<'a> {
    /// Number of nodes.
    pub nodes: usize,
    /// Triangles, and the area of each at rest [m²].
    pub triangles: (&'a [[u32; 3]], &'a [f64]),
    /// Links, and the length of each [m]; they count where there are no triangles.
    pub links: (&'a [[u32; 2]], &'a [f64]),
    /// What the surface encloses at rest [m³]; it counts for [`Mass::Volume`] alone.
    pub volume: f64,
}

/// Mass of each node [kg] of a mesh. A body without triangles is lumped by the lengths of its links.
///
/// ```
/// use taffeta::scene::{Kind, Mass};
/// use taffeta::topology::mass::{Shares, lump};
/// use taffeta::topology::{RestShape, shapes::grid_surface};
///
/// let sheet = grid_surface(4, 5, [0.4, 0.3]);
/// let areas = RestShape::of(&sheet, 1.0).areas();
/// let by = Shares { nodes: 20, triangles: (&sheet.triangles, &areas), links: (&[], &[]), volume: 0.0 };
/// let masses = lump(Mass::Area(0.2), Kind::Cloth, &by)?;
/// assert!((masses.iter().sum::<f64>() - 0.2 * 0.12).abs() < 1e-12);
/// assert!(lump(Mass::Volume(1e3), Kind::Cloth, &by).unwrap_err().contains("only closed soft bodies have a volume"));
/// # Ok::<(), String>(())
/// ```
pub fn lump(mass: Mass, kind: Kind, by: &Shares) -> Result<Vec<f64>, String> {
    let (triangles, areas) = by.triangles;
    let whole = match mass {
        Mass::Node(each) => return Ok(vec![each; by.nodes]),
        Mass::Area(_) if triangles.is_empty() => return Err(no_area()),
        Mass::Area(per_area) => per_area * areas.iter().sum::<f64>(),
        Mass::Whole(whole) => whole,
        Mass::Volume(_) if kind != Kind::Soft => return Err(no_volume()),
        Mass::Volume(density) if by.volume > 0.0 => density * by.volume,
        Mass::Volume(_) => {
            return Err(format!("encloses {} m³, more would do for `density`", by.volume));
        }
    };
    let shares = if triangles.is_empty() {
        shares(by.nodes, by.links.0, by.links.1)
    } else {
        shares(by.nodes, triangles, areas)
    };
    let total: f64 = shares.iter().sum();
    match shares.iter().position(|share| !share.is_normal()) {
        Some(node) => {
            Err(format!("node {node} is on no triangle, so that it gets no mass; `node_mass` would do"))
        }
        None => Ok(shares.into_iter().map(|share| whole * (share / total)).collect()),
    }
}

/// The size of each element, in equal parts to its nodes.
fn shares<const N: usize>(nodes: usize, elements: &[[u32; N]], sizes: &[f64]) -> Vec<f64> {
    let mut shares = vec![0.0; nodes];
    for (element, size) in elements.iter().zip(sizes) {
        let part = size / N as f64;
        element.iter().for_each(|node| shares[*node as usize] += part);
    }
    shares
}

/// Mass of each node [kg] of a grid, as [`lump`] gives it for the triangles of
/// [`grid_surface`](super::shapes::grid_surface); `size` as placed [m]. A single row or column is a chain.
///
/// ```
/// use taffeta::scene::Mass;
/// use taffeta::topology::mass::grid_lump;
///
/// // One square of 0.12 kg: two thirds of it to the nodes where the cut ends.
/// let masses = grid_lump(2, 2, [0.6, 1.0], Mass::Area(0.2))?;
/// assert!(masses.iter().zip([0.02, 0.04, 0.04, 0.02]).all(|(mass, expected)| (mass - expected).abs() < 1e-12));
/// # Ok::<(), String>(())
/// ```
pub fn grid_lump(rows: u32, cols: u32, size: [f64; 2], mass: Mass) -> Result<Vec<f64>, String> {
    let chain = rows < 2 || cols < 2;
    let whole = match mass {
        Mass::Node(each) => return Ok(vec![each; rows as usize * cols as usize]),
        Mass::Area(_) if chain => return Err(no_area()),
        Mass::Area(per_area) => per_area * size[0] * size[1],
        Mass::Whole(whole) => whole,
        Mass::Volume(_) => return Err(no_volume()),
    };
    if chain {
        let links = (rows * cols).saturating_sub(1).max(1);
        let ends = |i: u32| if i == 0 || i == links { 0.5 } else { 1.0 };
        return Ok((0..rows * cols).map(|i| whole * ends(i) / f64::from(links)).collect());
    }
    let squares = f64::from(rows - 1) * f64::from(cols - 1);
    let node = |r: u32, c: u32| whole * f64::from(sixths(r, c, rows, cols)) / (6.0 * squares);
    Ok((0..rows).flat_map(|r| (0..cols).map(move |c| node(r, c))).collect())
}

/// Sixths of a square that a node gets: one from each square of which it is the first or last corner, two where the
/// cut ends in it.
fn sixths(r: u32, c: u32, rows: u32, cols: u32) -> u32 {
    let [above, below] = [r > 0, r + 1 < rows].map(u32::from);
    let [left, right] = [c > 0, c + 1 < cols].map(u32::from);
    below * right + above * left + 2 * (below * left + above * right)
}

fn no_area() -> String {
    "a mass per area is given (`area_density`, or the density of a fabric), but the body has no area; a grid of 2 rows and \
     columns or more, or `mass` with springs, would do"
        .into()
}

fn no_volume() -> String {
    "`density` is given, but only closed soft bodies have a volume; `mass` or `node_mass` would do".into()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Cube, Mesh};
    use crate::topology::{Surface, measure, shapes};

    fn of(surface: &Surface, mass: Mass, kind: Kind) -> Result<Vec<f64>, String> {
        let nodes = &surface.nodes;
        let areas: Vec<f64> = surface.triangles.iter().map(|t| measure::area(nodes, *t)).collect();
        let lengths: Vec<f64> = surface.links.iter().map(|l| measure::length(nodes, *l)).collect();
        let by = Shares {
            nodes: nodes.len(),
            triangles: (&surface.triangles, &areas),
            links: (&surface.links, &lengths),
            volume: measure::volume(nodes, &surface.triangles),
        };
        lump(mass, kind, &by)
    }

    #[test]
    fn one_square_gives_a_third_where_the_cut_ends_and_a_sixth_elsewhere() {
        let masses = grid_lump(2, 2, [2.0, 3.0], Mass::Area(0.5)).unwrap();
        for (mass, expected) in masses.iter().zip([0.5, 1.0, 1.0, 0.5]) {
            assert!((mass - expected).abs() < 1e-15);
        }
    }

    #[test]
    fn grids_get_what_their_triangles_or_links_give() {
        for (rows, cols, size) in
            [(4, 5, [2.0, 1.0]), (2, 7, [0.3, 3.0]), (1, 6, [2.0, 0.0]), (5, 1, [0.0, 2.0])]
        {
            let surface = shapes::grid_surface(rows, cols, size);
            for mass in [Mass::Node(0.1), Mass::Whole(3.0), Mass::Area(0.2)] {
                let [grid, mesh] = [grid_lump(rows, cols, size, mass), of(&surface, mass, Kind::Cloth)];
                let (Ok(grid), Ok(mesh)) = (&grid, &mesh) else {
                    assert_eq!(grid, mesh);
                    assert!(matches!(mass, Mass::Area(_)) && surface.triangles.is_empty());
                    continue;
                };
                assert_eq!(grid.len(), mesh.len());
                assert!(grid.iter().zip(mesh).all(|(g, m)| (g - m).abs() < 1e-14), "{rows}×{cols} {mass:?}");
            }
        }
    }

    #[test]
    fn the_masses_add_up_to_the_whole() {
        let cube = shapes::surface(&Mesh::Cube(Cube { size: 0.5, divisions: 4 })).unwrap();
        for (mass, expected) in
            [(Mass::Whole(2.0), 2.0), (Mass::Area(2.0), 3.0), (Mass::Volume(1000.0), 125.0)]
        {
            let total: f64 = of(&cube, mass, Kind::Soft).unwrap().iter().sum();
            assert!((total - expected).abs() < 1e-12, "{mass:?}: {total}");
        }
        let chain = shapes::surface(&Mesh::chain(4, 2.0)).unwrap();
        assert_eq!(of(&chain, Mass::Whole(4.0), Kind::Cloth).unwrap(), [0.5, 1.0, 1.0, 1.0, 0.5]);
    }

    #[test]
    fn a_mass_that_cannot_be_shared_out_says_why() {
        let mut sheet = shapes::grid_surface(2, 2, [1.0; 2]);
        assert!(of(&sheet, Mass::Volume(1.0), Kind::Cloth).unwrap_err().contains("only closed soft bodies"));
        assert!(of(&sheet, Mass::Volume(1.0), Kind::Soft).unwrap_err().contains("encloses 0 m³"));
        sheet.nodes.push([5.0; 3]);
        assert!(of(&sheet, Mass::Whole(1.0), Kind::Cloth).unwrap_err().contains("node 4"));
        assert_eq!(of(&sheet, Mass::Node(1.0), Kind::Cloth).unwrap(), [1.0; 5]);
    }
}
