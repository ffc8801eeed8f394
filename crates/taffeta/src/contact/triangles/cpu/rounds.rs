//! Contacts of a sub-step, and the rounds in which their impulses are found.

use super::{FilterRound, Found, NO_SLOT, Scratch, Touched, TriangleContact, positions, read};
use crate::contact::triangles::cpu::contacts::{Active, Columns, What};
use crate::contact::triangles::cpu::lanes::motion;
use crate::contact::triangles::surfaces::Corners;
use crate::cpu::feature::Flow;
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, scale};

/// How far a contact may sink in by a sub-step, relative to its thickness, before another round corrects impulses.
const SINKS: f64 = 0.01;

impl<T: Real> TriangleContact<T> {
    /// Finds the contacts of the sub-step.
    pub(super) fn find(&self, worker: &mut Worker<'_, T>) {
        self.add_travel(self.scratch(worker));
        let moving = worker.substep.extensions.get::<Corners<T>>();
        let corners = moving.map(|corners| [&corners.before[..], &corners.after[..]]);
        if moving.is_none() {
            self.rest_corners(worker);
        }
        self.set(worker, &self.before, positions(worker.old()), corners.map(|both| both[0]));
        self.set(worker, &self.after, positions(self.state(worker)), corners.map(|both| both[1]));
        let motion = self.motion(worker, &self.after);
        let (before, after) = (read(&self.before), read(&self.after));
        let stride = self.reach(&motion);
        self.cover(worker, before, stride);
        let scratch = self.scratch(worker);
        (scratch.round, scratch.stage, scratch.seen) = (0, FilterRound::First, stride);
        scratch.contacts.clear();
        let columns = Columns {
            before,
            after,
            level: worker.nodes.level,
            h: worker.substep.h,
            travelled: scratch.travelled,
            stride,
        };
        for (number, list) in scratch.lists.iter_mut().enumerate() {
            list.find(number, &columns, &mut scratch.contacts);
        }
        let nearest = scratch.contacts.iter().map(|one| {
            let Active { contact, .. } = one;
            ((contact.gap + contact.thickness) / contact.thickness).to_f64()
        });
        let found = Found {
            contacts: scratch.contacts.len() as u64,
            nearest: nearest.fold(f64::INFINITY, f64::min),
            ..Found::default()
        };
        // SAFETY: its own; all read after the barrier.
        unsafe {
            *self.found.item(worker.index) = found;
            let places = self.surfaces.places as u32;
            self.mail.send_parts(worker.index, &scratch.contacts, places, |node| self.worker_of(node));
        }
        worker.synchronise();
        self.take_nodes(worker);
    }

    /// Counts the contacts of a worker's nodes, and keeps the state of these.
    fn take_nodes(&self, worker: &Worker<'_, T>) {
        let scratch = self.scratch(worker);
        for one in scratch.touched.drain(..) {
            scratch.slot[one.node as usize] = NO_SLOT;
            // SAFETY: its own node; others read after the barrier.
            *unsafe { self.counts.item(one.node as usize) } = 0;
        }
        let state = self.state(worker);
        // SAFETY: its own mail and nodes; others read counts after the barrier.
        unsafe {
            self.mail.each_part(worker.index, |part| {
                let place = part.node as usize;
                let count = self.counts.item(place);
                if *count == 0 {
                    let base = state.map(|column| column[place]);
                    let (node, zero) = (part.node, [T::ZERO; 3]);
                    scratch.touched.push(Touched { node, base, push: zero, sum: zero });
                }
                *count += 1;
            });
        }
        scratch.touched.sort_unstable_by_key(|one| (self.tile_of[one.node as usize], one.node));
        for (slot, one) in (0..).zip(&scratch.touched) {
            scratch.slot[one.node as usize] = slot;
        }
        // SAFETY: its own mail.
        unsafe { self.mail.each_part(worker.index, |part| part.node = scratch.slot[part.node as usize]) };
    }

    /// A round of impulses: corrects them for the velocities that those of the round before gave.
    pub(super) fn round(&self, worker: &mut Worker<'_, T>) -> Flow {
        let h = worker.substep.h;
        let scratch = self.scratch(worker);
        // SAFETY: written before a barrier, and again after another.
        let found = unsafe { self.found.read() };
        let contacts: u64 = found.iter().map(|found| found.contacts).sum();
        let last = scratch.round.wrapping_sub(1) % 2;
        let sinks = scratch.round < 2 || found.iter().any(|found| found.sinks[last] > SINKS);
        if contacts == 0 || !sinks {
            worker.mark_moved(|_| false);
            return Flow::Done;
        }
        if scratch.round == 0 {
            self.start(worker, scratch, h);
        } else {
            let state = self.state(worker);
            let (before, after) = (read(&self.before), read(&self.after));
            let v = |node: u32| match node as usize {
                place if place < self.surfaces.places => [3, 4, 5].map(|column| state[column][place]),
                place => motion(before, after, place).map(|way| way / h),
            };
            let mut sinks = T::ZERO;
            for one in &mut scratch.contacts {
                let velocity = one.velocity(v);
                sinks = sinks.max(one.contact.sinks(velocity, h));
                one.impulse = one.contact.correct(one.impulse, velocity, h);
            }
            // SAFETY: its own; all read after a barrier.
            unsafe { self.found.item(worker.index) }.sinks[scratch.round % 2] = sinks.to_f64();
        }
        let impulses = scratch.contacts.iter().map(|one| one.impulse);
        // SAFETY: its own; all read after the barrier.
        unsafe { self.mail.send(What::Impulses, worker.index, impulses) };
        worker.synchronise();
        let touched = &mut scratch.touched;
        if scratch.round == 0 {
            let more = |node: usize, vector| touched[node].push = add(touched[node].push, vector);
            // SAFETY: as above.
            unsafe { self.mail.sum(What::Pushes, worker.index, more) };
        }
        touched.iter_mut().for_each(|one| one.sum = [T::ZERO; 3]);
        let more = |node: usize, vector| touched[node].sum = add(touched[node].sum, vector);
        // SAFETY: as above.
        unsafe { self.mail.sum(What::Impulses, worker.index, more) };
        let w = &worker.nodes.inverse_mass;
        scratch.responses.clear();
        for Touched { node, base, push, sum } in &scratch.touched {
            let w = w[*node as usize];
            let change = scale(*sum, w);
            let way = add(scale(change, h), scale(*push, w));
            let state =
                std::array::from_fn(|axis| base[axis] + if axis < 3 { way[axis] } else { change[axis - 3] });
            scratch.responses.push((*node, state));
        }
        scratch.round += 1;
        self.list_by_tile(worker);
        Flow::Go
    }

    /// The first guess: impulses of the last sub-step, and what old overlaps ask for.
    fn start(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>, h: T) {
        // SAFETY: written before a barrier, and again after another.
        let counts = unsafe { self.counts.read() };
        let w = &worker.nodes.inverse_mass;
        let (before, after) = (read(&self.before), read(&self.after));
        let w = |place: usize| if place < self.surfaces.places { w[place] } else { T::ZERO };
        for one in &mut scratch.contacts {
            one.contact.mobility = (0..4).fold(T::ZERO, |sum, node| {
                let (weight, place) = (one.weights[node], one.nodes[node] as usize);
                sum + weight * weight * w(place) * T::from_f64(f64::from(counts[place]))
            });
            one.impulse = one.contact.start(one.impulse);
            let moved = (0..4).fold([T::ZERO; 3], |sum, node| match one.nodes[node] as usize {
                place if place < self.surfaces.places => sum,
                place => add(sum, scale(motion(before, after, place), one.weights[node])),
            });
            one.contact.advance = (-dot(one.contact.normal, moved)).max(T::ZERO);
        }
        let pushes = scratch.contacts.iter().map(|one| one.contact.push(h));
        // SAFETY: its own; all read after the barrier.
        unsafe { self.mail.send(What::Pushes, worker.index, pushes) };
    }

    /// Sorts the responses by tile, and marks tiles that have some.
    pub(super) fn list_by_tile(&self, worker: &Worker<'_, T>) {
        let scratch = self.scratch(worker);
        scratch.tiles.clear();
        for tile in worker.tiles.start..=worker.tiles.end {
            let before = |(node, _): &(u32, [T; 6])| (self.tile_of[*node as usize] as usize) < tile;
            scratch.tiles.push(scratch.responses.partition_point(before));
        }
        let any = |tile: usize| {
            let number = tile - worker.tiles.start;
            scratch.tiles[number] < scratch.tiles[number + 1]
        };
        worker.mark_moved(any);
    }
}
