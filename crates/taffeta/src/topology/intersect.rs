//! Where a surface passes through itself: all pairs of triangles that meet where they should not, found exactly.

use crate::topology::boxes::{Bounds, BoxTree, around, overlap};
use crate::topology::predicate::{Point, meet_beyond_corner, overlap_beyond_edge, triangles_meet};
use rayon::prelude::*;

/// How many pairs are named.
const NAMED: usize = 8;
/// How many pairs of triangles are looked at before the count ends. Surfaces have about ten pairs a triangle; far more
/// than that is a tangle, whose exact count helps nobody.
#[derive(Clone, Copy)]
struct Budget {
    all: u64,
    /// For the triangles of one leaf.
    leaf: u64,
    /// Leaves between two looks at `all`; the same for any number of threads, as the answer is to be.
    round: usize,
}

impl Budget {
    /// In a tangle a pair takes half a microsecond: with the last round one or two seconds on two cores, and more only
    /// for more triangles.
    fn of(triangles: usize) -> Self {
        Self { all: (1 << 22) + 32 * triangles as u64, leaf: 1 << 16, round: 64 }
    }
}

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
pub fn self_intersections(nodes: &[[f64; 3]], triangles: &[[u32; 3]]) -> Intersections {
    within(Budget::of(triangles.len()), nodes, triangles)
}

fn within(budget: Budget, nodes: &[Point], triangles: &[[u32; 3]]) -> Intersections {
    let mut all = Intersections { complete: true, ..Intersections::default() };
    if triangles.is_empty() {
        return all;
    }
    let search = Search { nodes, triangles, tree: BoxTree::new(nodes, triangles), budget };
    let leaves = search.tree.leaves();
    let mut tested = 0;
    for start in (0..leaves).step_by(budget.round) {
        if tested > budget.all {
            all.complete = false;
            break;
        }
        let round: Vec<Found> =
            (start..leaves.min(start + budget.round)).into_par_iter().map(|leaf| search.leaf(leaf)).collect();
        for found in round {
            tested += found.tested;
            all.add(found.pairs);
        }
    }
    all
}

impl Intersections {
    fn add(&mut self, found: Intersections) {
        self.crossing += found.crossing;
        self.folded += found.folded;
        self.complete &= found.complete;
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

struct Search<'a> {
    nodes: &'a [Point],
    triangles: &'a [[u32; 3]],
    tree: BoxTree,
    budget: Budget,
}

/// What a leaf's triangles meet in it and in later leaves.
struct Found {
    pairs: Intersections,
    tested: u64,
}

/// What two triangles share.
enum Meeting {
    Apart,
    Crossing,
    Folded,
}

impl Search<'_> {
    fn leaf(&self, leaf: usize) -> Found {
        let mut found = Found { pairs: Intersections { complete: true, ..Default::default() }, tested: 0 };
        let boxes: Vec<(u32, Bounds)> =
            self.tree.members(leaf).iter().map(|t| (*t, around(self.corners(*t)))).collect();
        self.tree.near(leaf, |other| {
            for (place, u) in self.tree.members(other).iter().enumerate() {
                let own = around(self.corners(*u));
                // In the leaf itself each pair once.
                let end = if other == leaf { place } else { boxes.len() };
                for (t, _) in boxes[..end].iter().filter(|(_, of)| overlap(of, &own)) {
                    found.tested += 1;
                    found.pair(*t.min(u), *t.max(u), self);
                }
            }
            found.pairs.complete = found.tested < self.budget.leaf;
            found.pairs.complete
        });
        found
    }

    fn corners(&self, triangle: u32) -> [Point; 3] {
        self.triangles[triangle as usize].map(|i| self.nodes[i as usize])
    }

    fn meeting(&self, t: u32, u: u32) -> Meeting {
        let [a, b] = [t, u].map(|i| self.corners(i));
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

impl Found {
    fn pair(&mut self, t: u32, u: u32, search: &Search) {
        match search.meeting(t, u) {
            Meeting::Apart => return,
            Meeting::Crossing => self.pairs.crossing += 1,
            Meeting::Folded => self.pairs.folded += 1,
        }
        self.pairs.name(&[[t, u]]);
    }
}

#[cfg(test)]
mod tests;
