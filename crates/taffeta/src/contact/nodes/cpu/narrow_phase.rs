//! The narrow phase: which nodes are in contact.

use crate::contact::clusters::bounds::{ClusterPair, GroupPair, is_over};
use crate::contact::clusters::packed::Packed;
use crate::contact::nodes::cpu::ContactWorker;
use crate::contact::nodes::cpu::exclusion_masks::Mask;
use crate::cpu::simd::Kernel;
use crate::real::{Real, dot, sub};
use crate::topology::LANES;
use std::sync::atomic::Ordering;

impl<T: Real> ContactWorker<'_, T> {
    /// Finds the contacts of its nodes.
    pub fn find_contacts(&mut self) {
        self.scratch.contact_list.owners().iter().for_each(|&node| self.note_contacts(node, 0));
        self.scratch.contact_list.clear();
        // SAFETY: written before a barrier, and again after the sub-step's last.
        let balls = unsafe { self.shared.balls.read() };
        let mut group_pairs = std::mem::take(&mut self.scratch.group_pairs);
        let mut least = T::FAR;
        for groups in &mut group_pairs {
            if groups.is_due(balls) {
                let nearest = self.narrow_phase(groups);
                least = if nearest < least { nearest } else { least };
            }
        }
        self.scratch.group_pairs = group_pairs;
        let tile = |node: u32| self.setup.tile[node as usize] as usize - self.first_tile;
        self.scratch.contact_list.sort(tile);
        for (number, &node) in self.scratch.contact_list.owners().iter().enumerate() {
            self.note_contacts(node, self.scratch.contact_list.others(number).len());
        }
        let ends = self.scratch.contact_list.ends.len() as f64;
        self.shared.found.set(self.index, [ends, least.to_f64().sqrt()]);
    }

    fn note_contacts(&self, node: u32, count: usize) {
        // The node is in this worker's share; others read after the next barrier.
        self.shared.contacts[node as usize].store(count as u32, Ordering::Relaxed);
    }

    /// Checks the pairs of clusters of two groups that are due. Returns the least squared distance of nodes in
    /// contact, relative to their contact distance.
    fn narrow_phase(&mut self, groups: &mut GroupPair<ClusterPair>) -> T {
        if is_over(groups.travelled, groups.fresh) {
            self.list_cluster_pairs(groups);
        }
        let (travelled, mut least) = (groups.travelled, T::FAR);
        groups.due = groups.fresh;
        for pair in &mut groups.pairs {
            if is_over(travelled, pair.due) {
                let nearest = self.narrow_phase_clusters(pair, travelled);
                least = if nearest < least { nearest } else { least };
            }
            groups.due = if pair.due < groups.due { pair.due } else { groups.due };
        }
        least
    }

    /// The same for two clusters.
    fn narrow_phase_clusters(&mut self, pair: &mut ClusterPair, travelled: f64) -> T {
        let (packed, moved) = self.clusters();
        let left = pair.left(moved);
        if left > 0.0 {
            pair.due = travelled + left;
            return T::FAR;
        }
        let mask = self.setup.exclusions.mask(pair.mask);
        let both = pair.clusters.map(|cluster| &packed[cluster as usize]);
        let least = self.level.run(Least { packed: both, mask });
        pair.note(self.setup.gap(pair.clusters, least.sqrt()), travelled, moved);
        let reach = self.setup.reach(pair.clusters);
        if least < reach * reach {
            let in_contact = self.level.run(InContact { packed: both, mask, reach });
            self.add_ends(pair.clusters, &in_contact);
            return least / (reach * reach);
        }
        T::FAR
    }

    /// Adds nodes in contact of two clusters.
    fn add_ends(&mut self, clusters: [u32; 2], in_contact: &[u16; LANES]) {
        let own = clusters.map(|cluster| self.own().contains(&(cluster as usize)));
        let [first, second] = clusters.map(|cluster| &self.setup.nodes[cluster as usize]);
        let ends = &mut self.scratch.contact_list.ends;
        for (&node, &bits) in first.iter().zip(in_contact) {
            let mut bits = bits;
            while bits != 0 {
                let other = second[bits.trailing_zeros() as usize];
                bits &= bits - 1;
                ends.extend(own[0].then_some([node, other]));
                ends.extend(own[1].then_some([other, node]));
            }
        }
    }
}

/// Kernel: least squared distance of nodes of two clusters that may collide [m²].
struct Least<'a, T> {
    packed: [&'a Packed<T>; 2],
    mask: &'a Mask,
}

impl<T: Real> Kernel for Least<'_, T> {
    type Output = T;
    #[inline(always)]
    fn run(self) -> T {
        let mask = self.mask.map(u32::from);
        let mut least = [T::FAR; LANES];
        for row in 0..LANES {
            let squared = squares(self.packed, row);
            for lane in 0..LANES {
                let nearer = squared[lane] < least[lane] && mask[lane] & (1 << row) == 0;
                least[lane] = if nearer { squared[lane] } else { least[lane] };
            }
        }
        least.into_iter().fold(T::FAR, |all, one| if one < all { one } else { all })
    }
}

/// Kernel: pairs of nodes of two clusters that are closer than `reach` [m].
struct InContact<'a, T> {
    packed: [&'a Packed<T>; 2],
    mask: &'a Mask,
    reach: T,
}

impl<T: Real> Kernel for InContact<'_, T> {
    /// By lane of the first, one bit for each lane of the second.
    type Output = [u16; LANES];
    #[inline(always)]
    fn run(self) -> [u16; LANES] {
        let (mask, reach) = (self.mask.map(u32::from), self.reach * self.reach);
        let mut in_contact = [0_u16; LANES];
        for (row, in_contact) in in_contact.iter_mut().enumerate() {
            let squared = squares(self.packed, row);
            let mut bits = 0_u32;
            for lane in 0..LANES {
                let near = squared[lane] < reach && mask[lane] & (1 << row) == 0;
                bits |= u32::from(near) << lane;
            }
            *in_contact = bits as u16;
        }
        in_contact
    }
}

/// Squared distances of a node of the first cluster from those of the second [m²].
#[inline(always)]
fn squares<T: Real>([a, b]: [&Packed<T>; 2], row: usize) -> [T; LANES] {
    let own = a.0.each_ref().map(|axis| axis[row]);
    let mut squared = [T::ZERO; LANES];
    for (lane, squared) in squared.iter_mut().enumerate() {
        let d = sub(own, [b.0[0][lane], b.0[1][lane], b.0[2][lane]]);
        *squared = dot(d, d);
    }
    squared
}
