//! Which nodes are in contact.

use crate::contact::nodes::cpu::watch::{Groups, Least, Touching, Watched, is_over};
use crate::contact::nodes::cpu::{Found, PairWorker};
use crate::real::Real;
use crate::topology::LANES;

impl<T: Real> PairWorker<'_, T> {
    /// Finds which of its nodes are in contact.
    pub fn find_near(&mut self) {
        self.scratch.near.owners().iter().for_each(|&node| self.note_contacts(node, 0));
        self.scratch.near.clear();
        // SAFETY: written before a barrier, and again after the sub-step's last.
        let balls = unsafe { self.shared.balls.read() };
        let mut watch = std::mem::take(&mut self.scratch.watch);
        let mut least = T::FAR;
        for groups in &mut watch {
            if groups.is_due(balls) {
                let nearest = self.look_at_groups(groups);
                least = if nearest < least { nearest } else { least };
            }
        }
        self.scratch.watch = watch;
        let tile = |node: u32| self.pairs.tile[node as usize] as usize - self.first_tile;
        self.scratch.near.sort(tile);
        for (number, &node) in self.scratch.near.owners().iter().enumerate() {
            self.note_contacts(node, self.scratch.near.others(number).len());
        }
        let found = Found { ends: self.scratch.near.ends.len() as u64, nearest: least.to_f64().sqrt() };
        // SAFETY: each worker has its own; all read after a barrier.
        let slot = unsafe { self.shared.found.write(self.index..self.index + 1) };
        slot[0] = found;
    }

    fn note_contacts(&self, node: u32, count: usize) {
        // SAFETY: the node is in this worker's share; others read after the next barrier.
        let contacts = unsafe { self.shared.contacts.write(node as usize..node as usize + 1) };
        contacts[0] = count as u32;
    }

    /// Looks at what is due of two groups. Returns the least squared distance of nodes in contact, by that at which they
    /// touch.
    fn look_at_groups(&mut self, groups: &mut Groups) -> T {
        if is_over(groups.travelled, groups.fresh) {
            self.list(groups);
        }
        let (travelled, mut least) = (groups.travelled, T::FAR);
        groups.due = groups.fresh;
        for pair in &mut groups.pairs {
            if is_over(travelled, pair.due) {
                let nearest = self.look(pair, travelled);
                least = if nearest < least { nearest } else { least };
            }
            groups.due = if pair.due < groups.due { pair.due } else { groups.due };
        }
        least
    }

    /// The same of two clusters.
    fn look(&mut self, pair: &mut Watched, travelled: f64) -> T {
        let (packed, moved) = self.clusters();
        let left = pair.left(moved);
        if left > 0.0 {
            pair.due = travelled + left;
            return T::FAR;
        }
        let mask = self.pairs.apart.mask(pair.mask);
        let both = pair.clusters.map(|cluster| &packed[cluster as usize]);
        let least = self.level.run(Least { packed: both, mask });
        pair.note(self.pairs.gap(pair.clusters, least.sqrt()), travelled, moved);
        let reach = self.pairs.reach(pair.clusters);
        if least < reach * reach {
            let touching = self.level.run(Touching { packed: both, mask, reach });
            self.add_ends(pair.clusters, &touching);
            return least / (reach * reach);
        }
        T::FAR
    }

    /// Adds nodes in contact of two clusters.
    fn add_ends(&mut self, clusters: [u32; 2], touching: &[u16; LANES]) {
        let own = clusters.map(|cluster| self.own().contains(&(cluster as usize)));
        let [first, second] = clusters.map(|cluster| &self.pairs.nodes[cluster as usize]);
        let ends = &mut self.scratch.near.ends;
        for (&node, &bits) in first.iter().zip(touching) {
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
