//! The broad phase: pairs of groups that are near each other, and pairs of clusters of two groups.

use crate::contact::clusters::bounds::{ClusterPair, Distances, GroupPair};
use crate::contact::clusters::tree::{Fill, Query};
use crate::contact::nodes::cpu::{ContactScratch, ContactWorker};
use crate::real::Real;

/// Distance up to which clusters are listed, relative to the mean diagonal of a cluster.
const LISTED: f64 = 0.5;

impl<T: Real> ContactWorker<'_, T> {
    /// Finds the pairs of groups that are near each other; `synchronise` waits for all workers.
    pub fn search(&mut self, synchronise: impl Fn()) {
        self.scratch.search.choose(self.setup.diagonals[1].max(self.setup.widest), 0.0);
        let (tree, own) = (self.tree(), self.own());
        // SAFETY: these are this worker's own; others read them after the next barrier.
        let (moved, boxes) =
            unsafe { (self.shared.moved.write(own.clone()), self.shared.boxes.write(tree.boxes.clone())) };
        moved.fill([0.0; 4]);
        // SAFETY: written before the last barrier.
        let packed = unsafe { self.shared.packed.read() };
        self.level.run(Fill { tree, packed: &packed[own], boxes });
        synchronise();
        let ContactScratch { group_pairs, spare, .. } = &mut *self.scratch;
        spare.extend(group_pairs.drain(..).map(|mut groups| {
            groups.pairs.clear();
            groups.pairs
        }));
        tree.groups.clone().for_each(|group| self.pair_with_neighbours(group));
    }

    /// Pairs a group with the groups near it. Two groups of this worker are paired once.
    fn pair_with_neighbours(&mut self, group: usize) {
        // SAFETY: written before the last barrier, and again in another search.
        let boxes = unsafe { self.shared.boxes.read() };
        let own = self.tree();
        let bound = &own.bound(boxes, group);
        let wide = T::from_f64(self.scratch.search.margin() + self.setup.widest);
        let ContactScratch { group_pairs, spare, around, stack, .. } = &mut *self.scratch;
        for tree in &self.setup.trees {
            around.clear();
            self.level.run(Query { tree, boxes, bound, squared: wide * wide, stack, found: around });
            for &other in around.iter() {
                if (other as usize) < group && own.groups.contains(&(other as usize)) {
                    continue;
                }
                let both = [other.min(group as u32), other.max(group as u32)];
                if !self.setup.do_groups_meet(both) {
                    continue;
                }
                group_pairs.push(GroupPair::new(both, spare.pop().unwrap_or_default()));
            }
        }
    }

    /// Lists the clusters of two groups that are near each other.
    pub(crate) fn list_cluster_pairs(&mut self, groups: &mut GroupPair<ClusterPair>) {
        let (packed, moved) = self.clusters();
        let [first, second] = groups.groups.map(|group| self.setup.groups[group as usize].clone());
        let squared = &mut self.scratch.squared;
        let both = [&packed[first.clone()], &packed[second.clone()]];
        self.level.run(Distances { packed: both, squared });
        let wide = T::from_f64(self.setup.widest + LISTED * self.setup.diagonals[0]);
        let (near, mut beyond) = (wide * wide, T::FAR);
        let mut old = self.scratch.spare.pop().unwrap_or_default();
        std::mem::swap(&mut old, &mut groups.pairs);
        let mut known = old.iter().peekable();
        for (a, squared) in first.zip(&self.scratch.squared) {
            for (b, &squared) in
                second.clone().zip(squared).filter(|(b, _)| *b >= a && self.setup.do_meet([a, *b]))
            {
                if squared >= near {
                    beyond = if squared < beyond { squared } else { beyond };
                    continue;
                }
                let clusters = [a as u32, b as u32];
                while known.next_if(|pair| pair.clusters < clusters).is_some() {}
                let pair = known.next_if(|pair| pair.clusters == clusters).copied();
                groups.pairs.push(pair.unwrap_or_else(|| {
                    let gap = self.setup.gap(clusters, squared.sqrt()).max(0.0);
                    let mask = self.setup.exclusions.find(clusters[0], clusters[1]);
                    ClusterPair::new(clusters, mask, gap, groups.travelled, moved)
                }));
            }
        }
        old.clear();
        self.scratch.spare.push(old);
        let left = beyond.sqrt().to_f64() * (1.0 - 1e-5) - self.setup.widest;
        groups.fresh = groups.travelled + left;
    }
}
