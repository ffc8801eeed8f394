//! The shape in which a mesh is at rest: that of its nodes, or another one given for the corners of its triangles.

use crate::topology::measure::{area_of, bounds, cross, dot, length, norm, sub, volume};
use crate::topology::{Edges, Surface};

/// Share of a length within which places at rest count as one: what is written to seven digits still meets.
const SAME: f64 = 1e-6;

/// The shape of a surface at rest, times a factor.
///
/// ```
/// use taffeta::topology::{Edges, RestShape, shapes::grid_surface};
///
/// // Rest lengths of cloth that shrinks to nine tenths.
/// let sheet = grid_surface(2, 2, [0.3, 0.4]);
/// let rest = RestShape::of(&sheet, 0.9);
/// let lengths = rest.edge_lengths(&Edges::new(4, &sheet.triangles, &[]));
/// assert!(lengths.iter().any(|length| (length - 0.9 * 0.5).abs() < 1e-12), "the diagonal");
/// assert!((rest.areas().iter().sum::<f64>() - 0.81 * 0.12).abs() < 1e-12);
/// ```
pub struct RestShape<'a> {
    surface: &'a Surface,
    factor: f64,
    given: Option<&'a [[[f64; 3]; 3]]>,
    /// Whether the given shape lies in one plane: a pattern, which is not folded even where it overlaps itself.
    flat: bool,
}

impl<'a> RestShape<'a> {
    /// Of a surface, checked, all lengths times `factor`.
    pub fn of(surface: &'a Surface, factor: f64) -> Self {
        let given = surface.rest.as_deref();
        Self { surface, factor, given, flat: given.is_some_and(is_flat) }
    }

    /// Whether the shape is another than the surface's own.
    pub fn is_given(&self) -> bool {
        self.given.is_some()
    }

    /// Places of a triangle's corners [m].
    pub(crate) fn corners(&self, triangle: usize) -> [[f64; 3]; 3] {
        let corners = match self.given {
            Some(given) => given[triangle],
            None => self.surface.triangles[triangle].map(|node| self.surface.nodes[node as usize]),
        };
        corners.map(|place| place.map(|x| self.factor * x))
    }

    /// Area of each triangle [m²].
    pub fn areas(&self) -> Vec<f64> {
        (0..self.surface.triangles.len()).map(|t| area_of(self.corners(t))).collect()
    }

    /// Distance of two nodes [m] in the surface's own shape: for links, which have no other.
    pub fn distance(&self, pair: [u32; 2]) -> f64 {
        self.factor * length(&self.surface.nodes, pair)
    }

    /// Length of each edge [m]: the mean over its triangles, which differ where one side of a seam is gathered.
    pub fn edge_lengths(&self, edges: &Edges) -> Vec<f64> {
        let mut lengths: Vec<f64> = edges.pairs.iter().map(|pair| self.distance(*pair)).collect();
        if !self.is_given() {
            return lengths;
        }
        let with_triangles = lengths.iter_mut().zip(&edges.uses).filter(|(_, uses)| **uses > 0);
        with_triangles.for_each(|(length, _)| *length = 0.0);
        for (t, triangle) in self.surface.triangles.iter().enumerate() {
            let places = self.corners(t);
            for [from, to] in [[0, 1], [1, 2], [2, 0]] {
                let [a, b] = [triangle[from], triangle[to]];
                if let Ok(edge) = edges.pairs.binary_search(&[a.min(b), a.max(b)]) {
                    lengths[edge] += norm(sub(places[to], places[from])) / f64::from(edges.uses[edge]);
                }
            }
        }
        lengths
    }

    /// Places [m] of a, b, left, right of each hinge, in the order of [`Edges::hinges`]. Where the two triangles do
    /// not meet at rest, as on a seam, and everywhere on a pattern, both are laid flat at either side of their edge.
    pub fn hinges(&self, edges: &Edges) -> impl Iterator<Item = [[f64; 3]; 4]> {
        let inner = edges.pairs.iter().zip(&edges.triangles).zip(&edges.uses).filter(|(_, uses)| **uses == 2);
        inner.map(|((pair, sides), _)| {
            let [left, right] = sides.map(|t| self.side(*pair, t as usize));
            let edge = norm(sub(left[1], left[0]));
            let meet = [0, 1].iter().all(|&end| norm(sub(left[end], right[end])) <= SAME * edge);
            if meet && !self.flat { [left[0], left[1], left[2], right[2]] } else { unfold(left, right) }
        })
    }

    /// Places [m] of an edge's ends and of the third corner, in one of its triangles.
    fn side(&self, ends: [u32; 2], t: usize) -> [[f64; 3]; 3] {
        let (triangle, places) = (self.surface.triangles[t], self.corners(t));
        let at = |node: u32| triangle.iter().position(|corner| *corner == node).unwrap_or(0);
        let [a, b] = ends.map(at);
        [places[a], places[b], places[3 - a - b]]
    }

    /// Places of the nodes [m], if each has one, as nowhere on a seam.
    pub fn nodes(&self) -> Option<Vec<[f64; 3]>> {
        let scaled = |places: &[[f64; 3]]| places.iter().map(|p| p.map(|x| self.factor * x)).collect();
        let Some(given) = self.given else { return Some(scaled(&self.surface.nodes)) };
        let [lo, hi] = bounds(given.as_flattened());
        let apart = SAME * norm(sub(hi, lo));
        let mut places = vec![[f64::NAN; 3]; self.surface.nodes.len()];
        for (node, place) in self.surface.triangles.as_flattened().iter().zip(given.as_flattened()) {
            let known = &mut places[*node as usize];
            if known[0].is_nan() {
                *known = *place;
            } else if norm(sub(*known, *place)) > apart {
                return None;
            }
        }
        places.iter().all(|place| !place[0].is_nan()).then(|| scaled(&places))
    }

    /// A normal of the plane in which the whole shape lies, if it does.
    pub(crate) fn plane(&self) -> Option<[f64; 3]> {
        let all: Vec<_> = (0..self.surface.triangles.len()).map(|t| self.corners(t)).collect();
        let largest =
            all.iter().max_by(|a, b| area_of(**a).total_cmp(&area_of(**b))).filter(|_| is_flat(&all))?;
        let normal = cross(sub(largest[1], largest[0]), sub(largest[2], largest[0]));
        let size = norm(normal);
        (size > 0.0).then(|| normal.map(|x| x / size))
    }

    /// Volume inside a closed surface [m³]; `None` where the given shape is open or flat.
    pub fn volume(&self) -> Option<f64> {
        if self.flat {
            return None;
        }
        self.nodes().map(|nodes| volume(&nodes, &self.surface.triangles))
    }
}

/// Whether all corners lie in the plane of the largest triangle.
fn is_flat(corners: &[[[f64; 3]; 3]]) -> bool {
    let normal = |&[a, b, c]: &[[f64; 3]; 3]| cross(sub(b, a), sub(c, a));
    let largest = corners.iter().max_by(|a, b| norm(normal(a)).total_cmp(&norm(normal(b))));
    let Some(largest) = largest else { return false };
    let (n, [lo, hi]) = (normal(largest), bounds(corners.as_flattened()));
    let off = SAME * norm(sub(hi, lo)) * norm(n);
    corners.as_flattened().iter().all(|place| dot(sub(*place, largest[0]), n).abs() <= off)
}

/// Two triangles, each an edge and a third corner, laid in one plane at either side of their edge, whose middles
/// meet; the edge gets the mean length.
fn unfold(left: [[f64; 3]; 3], right: [[f64; 3]; 3]) -> [[f64; 3]; 4] {
    let flat = |[a, b, c]: [[f64; 3]; 3]| {
        let edge = norm(sub(b, a));
        let middle = [0, 1, 2].map(|i| 0.5 * (a[i] + b[i]));
        let along = dot(sub(c, middle), sub(b, a)) / edge;
        (edge, along, 2.0 * area_of([a, b, c]) / edge)
    };
    let ((edge, left, above), (other, right, below)) = (flat(left), flat(right));
    let half = 0.25 * (edge + other);
    [[-half, 0.0, 0.0], [half, 0.0, 0.0], [left, above, 0.0], [right, -below, 0.0]]
}

#[cfg(test)]
mod tests;
