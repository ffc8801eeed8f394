//! A surface in numbers: how it hangs together, how large it is, and what is odd about it.

mod parts;
mod sets;
mod sides;

pub use parts::Part;
pub(crate) use parts::is_orientable;
pub(crate) use sides::Sides;

use crate::topology::measure::{area, bounds, length, volume};
use crate::topology::{Edges, Surface};

/// A surface in numbers.
///
/// ```
/// use taffeta::scene::{Mesh, Torus};
/// use taffeta::topology::{Inspection, shapes};
///
/// let ring = shapes::surface(&Mesh::Torus(Torus { major: 0.3, minor: 0.1, rings: 24, segments: 12 }))?;
/// let found = Inspection::new(&ring);
/// assert_eq!((found.genus, found.euler, found.holes), (Some(1), 0, 0));
/// let volume = found.volume.expect("it is closed");
/// assert!((volume / (2.0 * 0.3 * (0.1 * std::f64::consts::PI).powi(2)) - 1.0).abs() < 0.1);
/// # Ok::<(), String>(())
/// ```
#[derive(Clone, Debug)]
#[non_exhaustive]
pub struct Inspection {
    /// Edges, and the triangles at each.
    pub edges: Edges,
    /// Number of boundary loops: holes, and the outer border of a sheet.
    pub holes: usize,
    /// Number of borders that end, at edges with more than two triangles.
    pub open_borders: usize,
    /// Parts whose triangles hang together by edges, in the order of their first triangle.
    pub parts: Vec<Part>,
    /// Number of parts, if those that touch at a node count as one.
    pub joined_parts: usize,
    /// Nodes at which the surface is several sheets or parts that only touch, ascending.
    pub bow_ties: Vec<u32>,
    /// Whether the triangles can be turned so that all neighbours agree on their sides.
    pub orientable: bool,
    /// Nodes of triangles − edges + triangles.
    pub euler: i64,
    /// Number of handles of all parts; `None` where that has no meaning: at edges with more than two triangles, or
    /// where a part is not orientable.
    pub genus: Option<u64>,
    /// Area [m²].
    pub area: f64,
    /// Volume inside [m³], of a closed surface.
    pub volume: Option<f64>,
    /// Lower and upper corner of the box around the nodes [m].
    pub bounds: [[f64; 3]; 2],
    /// Shortest edge [m], by its nodes.
    pub shortest: (f64, [u32; 2]),
    /// Longest edge [m], by its nodes.
    pub longest: (f64, [u32; 2]),
    /// The thinnest triangle and its aspect: longest edge over the height upon it; 2/√3 if all edges are equal.
    pub thinnest: (f64, usize),
}

impl Inspection {
    /// Measures a surface with triangles.
    ///
    /// # Panics
    /// Where the surface names a node that is not there.
    pub fn new(surface: &Surface) -> Self {
        let (nodes, triangles) = (&surface.nodes, &surface.triangles);
        let edges = Edges::new(nodes.len(), triangles, &surface.links);
        let sides = Sides::new(nodes.len(), triangles, &edges);
        let found = parts::find(nodes, triangles, &edges, &sides);
        let borders = edges.borders();
        let lengths = || edges.pairs.iter().map(|pair| (length(nodes, *pair), *pair));
        let aspects = triangles.iter().map(|t| aspect(nodes, *t)).zip(0..);
        Self {
            holes: borders.loops.len(),
            open_borders: borders.ends,
            joined_parts: found.joined,
            bow_ties: found.bow_ties,
            orientable: found.parts.iter().all(|part| part.orientable),
            euler: found.nodes as i64 - edges.pairs.len() as i64 + triangles.len() as i64,
            genus: found.parts.iter().map(|part| part.genus).sum(),
            area: triangles.iter().map(|t| area(nodes, *t)).sum(),
            volume: edges.is_closed().then(|| volume(nodes, triangles)),
            bounds: bounds(nodes),
            shortest: lengths().fold((f64::INFINITY, [0; 2]), |a, b| if b.0 < a.0 { b } else { a }),
            longest: lengths().fold((0.0, [0; 2]), |a, b| if b.0 > a.0 { b } else { a }),
            thinnest: aspects.fold((0.0, 0), |a, b| if b.0 > a.0 { b } else { a }),
            parts: found.parts,
            edges,
        }
    }
}

/// Longest edge of a triangle over the height upon it.
fn aspect(nodes: &[[f64; 3]], triangle: [u32; 3]) -> f64 {
    let [a, b, c] = triangle;
    let longest = [[a, b], [b, c], [c, a]].map(|pair| length(nodes, pair)).into_iter().fold(0.0, f64::max);
    longest * longest / (2.0 * area(nodes, triangle))
}

#[cfg(test)]
mod tests;
