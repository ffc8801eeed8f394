//! All pairs of triangles whose boxes overlap, found with a tree of boxes and shared among threads.

use crate::topology::boxes::{Bounds, BoxTree, around, overlap};
use crate::topology::predicate::Point;
use rayon::prelude::*;

/// How many pairs of triangles are looked at before the search ends. Surfaces have about ten pairs a triangle; far more
/// than that is a tangle, whose exact count helps nobody.
#[derive(Clone, Copy)]
pub(crate) struct Budget {
    pub all: u64,
    /// For the triangles of one leaf.
    pub leaf: u64,
    /// Leaves between two looks at `all`; the same for any number of threads, as the answer is to be.
    pub round: usize,
}

impl Budget {
    /// In a tangle a pair takes half a microsecond: with the last round one or two seconds on two cores, and more only
    /// for more triangles.
    pub fn of(triangles: usize) -> Self {
        Self { all: (1 << 22) + 32 * triangles as u64, leaf: 1 << 16, round: 64 }
    }
}

/// Calls `look` with each pair [i, j], i < j, of triangles whose boxes overlap, and `take` with what it has found in leaf
/// after leaf. Returns whether it has looked at all of them. The same answer for any number of threads.
pub(crate) fn near_pairs<F: Default + Send>(
    budget: Budget,
    nodes: &[Point],
    triangles: &[[u32; 3]],
    look: impl Fn(&mut F, [u32; 2]) + Sync,
    mut take: impl FnMut(F),
) -> bool {
    if triangles.is_empty() {
        return true;
    }
    let search = Search { nodes, triangles, tree: BoxTree::new(nodes, triangles), most: budget.leaf, look };
    let leaves = search.tree.leaves();
    let (mut tested, mut complete) = (0, true);
    for start in (0..leaves).step_by(budget.round) {
        if tested > budget.all {
            return false;
        }
        let round: Vec<(F, u64)> =
            (start..leaves.min(start + budget.round)).into_par_iter().map(|leaf| search.leaf(leaf)).collect();
        for (found, in_leaf) in round {
            tested += in_leaf;
            complete &= in_leaf < budget.leaf;
            take(found);
        }
    }
    complete
}

struct Search<'a, L> {
    nodes: &'a [Point],
    triangles: &'a [[u32; 3]],
    tree: BoxTree,
    /// Pairs of a leaf after which its search ends.
    most: u64,
    look: L,
}

impl<L> Search<'_, L> {
    /// What triangles of a leaf have to do with each other and with those of later leaves, and how many pairs that are.
    fn leaf<F: Default>(&self, leaf: usize) -> (F, u64)
    where
        L: Fn(&mut F, [u32; 2]),
    {
        let (mut found, mut tested) = (F::default(), 0);
        let boxes: Vec<(u32, Bounds)> =
            self.tree.members(leaf).iter().map(|t| (*t, around(self.corners(*t)))).collect();
        self.tree.near(leaf, |other| {
            for (place, u) in self.tree.members(other).iter().enumerate() {
                let own = around(self.corners(*u));
                // In the leaf itself each pair once.
                let end = if other == leaf { place } else { boxes.len() };
                for (t, _) in boxes[..end].iter().filter(|(_, of)| overlap(of, &own)) {
                    tested += 1;
                    (self.look)(&mut found, [*t.min(u), *t.max(u)]);
                }
            }
            tested < self.most
        });
        (found, tested)
    }

    fn corners(&self, triangle: u32) -> [Point; 3] {
        self.triangles[triangle as usize].map(|i| self.nodes[i as usize])
    }
}
