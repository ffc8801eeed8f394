//! Where a surface passes through itself: all pairs of triangles that meet where they should not, found exactly.

use crate::topology::near_pairs::{Budget, near_pairs};
use crate::topology::predicate::{Point, meet_beyond_corner, overlap_beyond_edge, triangles_meet};

/// How many pairs are named.
const NAMED: usize = 8;

/// Pairs of triangles that meet.
///
/// ```
/// use taffeta::topology::self_intersections;
///
/// // Two sheets of one triangle each that pass through each other.
/// let flat = [[0.0, 0.0, 0.0], [0.4, 0.0, 0.0], [0.0, 0.0, 0.4]];
/// let upright = [[0.1, -0.1, 0.1], [0.1, 0.1, 0.1], [0.1, 0.1, 0.5]];
/// let found = self_intersections(&[flat, upright].concat(), &[[0, 1, 2], [3, 4, 5]]);
/// assert_eq!((found.crossing, found.folded), (1, 0));
/// assert!(found.complete && found.first == [[0, 1]]);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Intersections {
    /// Pairs without a common corner that have a point in common; one that touches counts.
    pub crossing: u64,
    /// Pairs with a common corner or edge that have a point in common beyond it.
    pub folded: u64,
    /// The first of both, by triangle: `[i, j]`, i < j, ascending; at most 8.
    pub first: Vec<[u32; 2]>,
    /// Whether all pairs were looked at. If not, there may be more than counted.
    pub complete: bool,
}

/// Finds all pairs of triangles that meet; all have an area. Corners at exactly one place are common, whether they are
/// one node or, as where parts only touch, several. Pairs with the same three corners count as folded. The same answer
/// for any number of threads.
///
/// ```
/// use taffeta::topology::{self_intersections, shapes::grid_surface};
///
/// let mut sheet = grid_surface(2, 3, [0.2, 0.1]);
/// assert_eq!(self_intersections(&sheet.nodes, &sheet.triangles).first.len(), 0);
/// // The last column is laid upon the first one.
/// (sheet.nodes[2], sheet.nodes[5]) = (sheet.nodes[0], sheet.nodes[3]);
/// assert!(self_intersections(&sheet.nodes, &sheet.triangles).folded > 0);
/// ```
///
/// # Panics
/// Where a triangle names a node that is not there.
pub fn self_intersections(nodes: &[[f64; 3]], triangles: &[[u32; 3]]) -> Intersections {
    within(Budget::of(triangles.len()), nodes, triangles)
}

fn within(budget: Budget, nodes: &[Point], triangles: &[[u32; 3]]) -> Intersections {
    let mut all = Intersections::default();
    let corners = |triangle: u32| triangles[triangle as usize].map(|node| nodes[node as usize]);
    let look = |found: &mut Intersections, pair: [u32; 2]| found.take(pair, meeting(pair.map(corners)));
    all.complete = near_pairs(budget, nodes, triangles, look, |found| all.add(found));
    all
}

impl Intersections {
    fn take(&mut self, pair: [u32; 2], meeting: Meeting) {
        match meeting {
            Meeting::Apart => return,
            Meeting::Crossing => self.crossing += 1,
            Meeting::Folded => self.folded += 1,
        }
        self.name(&[pair]);
    }

    fn add(&mut self, found: Self) {
        self.crossing += found.crossing;
        self.folded += found.folded;
        self.name(&found.first);
    }

    /// Keeps the first pairs.
    fn name(&mut self, pairs: &[[u32; 2]]) {
        if !pairs.is_empty() {
            self.first.extend_from_slice(pairs);
            self.first.sort_unstable();
            self.first.truncate(NAMED);
        }
    }
}

/// What two triangles share.
enum Meeting {
    Apart,
    Crossing,
    Folded,
}

fn meeting([a, b]: [[Point; 3]; 2]) -> Meeting {
    let folded = match a.iter().filter(|corner| b.contains(corner)).count() {
        0 if triangles_meet(a, b) => return Meeting::Crossing,
        0 => false,
        1 => meet_beyond_corner(shared_first(a, b), shared_first(b, a)),
        2 => {
            let [p, q, c] = own_last(a, b);
            overlap_beyond_edge([p, q], c, own_last(b, a)[2])
        }
        _ => true,
    };
    if folded { Meeting::Folded } else { Meeting::Apart }
}

/// Corners of `a`, turned so that the one that `b` has too is the first.
fn shared_first(a: [Point; 3], b: [Point; 3]) -> [Point; 3] {
    let first = a.iter().position(|corner| b.contains(corner)).unwrap_or(0);
    [0, 1, 2].map(|i| a[(first + i) % 3])
}

/// Corners of `a`, turned so that the one that `b` does not have is the last.
fn own_last(a: [Point; 3], b: [Point; 3]) -> [Point; 3] {
    let own = a.iter().position(|corner| !b.contains(corner)).unwrap_or(0);
    [1, 2, 3].map(|i| a[(own + i) % 3])
}

#[cfg(test)]
mod tests;
