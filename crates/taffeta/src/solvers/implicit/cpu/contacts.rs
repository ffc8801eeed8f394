//! Contacts of surfaces in the system: what they add to it, and which bodies they join.

use crate::contact::triangles::cpu::TriangleContact;
use crate::contact::triangles::cpu::solved::{NO_BODY, System};
use crate::real::{Real, add, scale};
use crate::solvers::implicit::cpu::ImplicitWorker;
use crate::solvers::implicit::cpu::columns::Columns;
use crate::solvers::implicit::cpu::tables::Table;
use crate::solvers::implicit::implicit::is_held;

/// Where contacts find the nodes of the system.
pub struct Places {
    /// By place: its body, or [`NO_BODY`].
    bodies: Vec<u32>,
    /// The first place of each worker's share of the finest level.
    shares: Vec<u32>,
}

impl Places {
    /// Those of a level that so many workers share.
    pub fn new<T>(table: &Table<T>, workers: usize) -> Self {
        let mut bodies = vec![NO_BODY; table.places];
        for (number, places) in (0..).zip(&table.bodies) {
            bodies[places.clone()].fill(number);
        }
        let chunks = &table.chunks;
        let first = |worker: usize| chunks.get(chunks.len() * worker / workers);
        let shares = (0..workers).map(|worker| match first(worker) {
            Some(chunk) if worker > 0 => chunk.part.start as u32,
            Some(_) => 0,
            None => table.places as u32,
        });
        Self { shares: shares.collect(), bodies }
    }

    /// The body of a node.
    pub fn body_of(&self, node: u32) -> usize {
        self.bodies[node as usize] as usize
    }

    /// How many workers share the level.
    pub fn workers(&self) -> usize {
        self.shares.len()
    }

    /// Bytes that they take.
    pub fn bytes(&self) -> usize {
        4 * (self.bodies.len() + self.shares.len())
    }
}

/// Bodies that contacts or seams join share one system: their sums are taken together.
#[derive(Clone, Debug, Default)]
pub struct Joined {
    /// By body: the first of those that it shares a system with.
    first: Vec<usize>,
    /// By body: whether a contact holds it, or what it is joined with.
    held: Vec<bool>,
}

impl Joined {
    /// Bodies that are joined by pairs; or held, by pairs with [`NO_BODY`].
    fn new(bodies: usize, links: impl Iterator<Item = [u32; 2]>) -> Self {
        let mut all = Self { first: (0..bodies).collect(), held: vec![false; bodies] };
        for [one, other] in links {
            let one = all.first_of(one as usize);
            if other == NO_BODY {
                all.held[one] = true;
                continue;
            }
            let other = all.first_of(other as usize);
            let (least, most) = (one.min(other), one.max(other));
            all.first[most] = least;
            all.held[least] |= all.held[most];
        }
        for body in 0..bodies {
            let first = all.first_of(body);
            (all.first[body], all.held[body]) = (first, all.held[first]);
        }
        all
    }

    fn first_of(&self, mut body: usize) -> usize {
        while self.first[body] != body {
            body = self.first[body];
        }
        body
    }

    /// Sums of bodies, of all that each is joined with.
    pub fn together<const N: usize>(&self, mut sums: Vec<[f64; N]>) -> Vec<[f64; N]> {
        for (body, &first) in self.first.iter().enumerate().filter(|&(body, &first)| first < body) {
            let own = sums[body];
            sums[first].iter_mut().zip(own).for_each(|(sum, own)| *sum += own);
        }
        for (body, &first) in self.first.iter().enumerate() {
            sums[body] = sums[first];
        }
        sums
    }

    /// Whether a contact holds a body.
    pub fn is_held(&self, body: usize) -> bool {
        self.held.get(body).is_some_and(|&held| held)
    }
}

impl<'w, T: Real> ImplicitWorker<'w, '_, T> {
    fn with_system<R>(&self, job: impl FnOnce(&System<'_, T>) -> R) -> R {
        // SAFETY: what was moved was written before a barrier.
        let moved = unsafe { self.shared.moved.read() };
        let Places { bodies, shares } = &self.primal.places;
        job(&System { bodies, shares, moved: std::array::from_fn(|axis| moved.column(axis)), h: self.h })
    }

    /// Finds the contacts that may come about in the step, and which bodies those and seams join.
    pub fn join_systems(&mut self) {
        if let Some(contacts) = self.contacts {
            self.with_system(|system| contacts.find_solved(self.worker, system));
        }
        let by_contacts = self.contacts.into_iter().flat_map(TriangleContact::solved_links);
        let by_seams = self.sewn.into_iter().flat_map(|sewn| sewn.links.iter().copied());
        self.scratch.joined = Joined::new(self.scratch.bodies.len(), by_contacts.chain(by_seams));
    }

    /// Adds contacts to the system that a Newton step has set up on the finest level.
    pub fn add_contacts(&mut self, is_first: bool) {
        let Some(contacts) = self.contacts_in_system() else { return };
        let is_met = |body: usize| self.scratch.bodies[body].met;
        // SAFETY: found before a barrier, and changed after another.
        let (inverse, own) =
            unsafe { (self.shared.levels[0].inverse.read(), self.shared.levels[0].own.read()) };
        self.with_system(|system| {
            let block = |place| (inverse.at(place), is_held(&own.at(place)));
            contacts.linearise_solved(self.worker, system, (is_first, is_met), block);
        });
        if is_first {
            self.weigh_contacts(&contacts.solved_of(self.worker));
        }
        self.worker.synchronise();
        if is_first {
            self.list_contacts();
        }
        let found = contacts.solved_contacts();
        self.each(0, |worker, chunk| {
            let part = &chunk.part;
            let here = &worker.shared.levels[0];
            // SAFETY: only this chunk's places.
            let (right, inverse, own) = unsafe {
                (
                    worker.shared.right.write::<3>(part),
                    here.inverse.write::<6>(part),
                    here.own.write::<6>(part),
                )
            };
            contacts.each_solved(&found, part, |place, contact, corner| {
                let at = place - part.start;
                let impulse = scale(contact.impulse, contact.weights[corner]);
                let all = contact.soften(corner, &std::array::from_fn(|one| inverse[one][at]));
                (0..3).for_each(|axis| right[axis][at] += impulse[axis]);
                (0..6).for_each(|one| inverse[one][at] = all[one]);
                if contact.is_held {
                    let all = contact.stiffened_block(corner, &std::array::from_fn(|one| own[one][at]));
                    (0..6).for_each(|one| own[one][at] = all[one]);
                }
            });
        });
        drop(found);
        self.worker.synchronise();
    }

    /// Contacts, if any are part of the system.
    pub fn contacts_in_system(&self) -> Option<&'w TriangleContact<T>> {
        self.contacts.filter(|contacts| contacts.has_solved())
    }

    /// Finds what contacts take back of a vector, for its product with the matrix of a level. All workers call it after a barrier;
    /// it ends with another.
    pub fn take_back(&self, level: usize, vector: &Columns<T>) {
        let Some(contacts) = self.contacts_in_system().filter(|_| level == 0) else { return };
        // SAFETY: found before a barrier, and changed after another.
        let vector = unsafe { vector.read() };
        let columns = [0, 1, 2].map(|axis| vector.column(axis));
        contacts.take_back(self.worker, columns);
        self.worker.synchronise();
    }

    /// Notes what a Newton step has changed of the impulses of contacts.
    pub fn note_contacts(&self) {
        let Some(contacts) = self.contacts else { return };
        // SAFETY: found before a barrier.
        let x = unsafe { self.shared.x.read() };
        let drift = |place: usize| {
            let body = self.primal.places.body_of(place as u32);
            self.scratch.bodies[body].drift.map(T::from_f64)
        };
        let is_met = |body: usize| self.scratch.bodies[body].met;
        contacts.apply_solved(self.worker, is_met, |place| add(x.at(place), drift(place)));
    }

    /// Has the rounds after the solver start from what it has found.
    pub fn keep_contacts(&self) {
        if let Some(contacts) = self.contacts {
            contacts.keep_solved(self.worker);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bodies_that_contacts_join_have_their_sums_together() {
        let joined = Joined::new(6, [[4, 2], [1, 4], [3, NO_BODY], [5, 3]].into_iter());
        let sums = joined.together((0..6).map(|body| [f64::from(body)]).collect());
        assert_eq!(sums, [[0.0], [7.0], [7.0], [8.0], [7.0], [8.0]]);
        let held: Vec<bool> = (0..6).map(|body| joined.is_held(body)).collect();
        assert_eq!(held, [false, false, false, true, false, true]);
    }
}
