//! Steps of second order on the CPU: from where a system starts, what nodes remember, and where they come to.

use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::cpu::tile::Tile;
use crate::real::{Real, add, scale, sub};
use crate::solvers::implicit::cpu::columns::View;
use crate::solvers::implicit::cpu::{Implicit, ImplicitWorker};
use crate::step::Marks;
use crate::topology::LANES;
use std::ops::Range;

impl<'w, T: Real> ImplicitWorker<'w, '_, T> {
    /// Masses of the system [kg].
    pub fn masses(&self) -> &'w [T] {
        match self.second {
            // SAFETY: each chunk reads its own, or after a barrier.
            Some((history, _)) => unsafe { history.mass.read() },
            None => &self.worker.nodes.mass,
        }
    }

    /// Where a place comes to without velocity [m], and its velocity without springs [m/s].
    #[inline(always)]
    pub fn base(&self, place: usize) -> [[T; 3]; 2] {
        let Some((history, _)) = self.second else {
            return [self.worker.old_position(place), self.free_velocity(place)];
        };
        // SAFETY: each chunk reads its own.
        let [x, y, z, u, v, w] = unsafe { history.base.read() }.at(place);
        [[x, y, z], [u, v, w]]
    }

    /// The same of a chunk's places, by columns. No `find_base` may come while they are in use.
    pub fn bases(&self, part: &Range<usize>) -> [&[T]; 6] {
        let old = self.worker.old();
        std::array::from_fn(|axis| {
            // SAFETY: each chunk reads its own; free velocities were written before a barrier, and are written over after another.
            let column = unsafe {
                match self.second {
                    Some((history, _)) => history.base.read().column(axis),
                    None if axis < 3 => old[axis],
                    None => self.worker.next()[axis - 3].read(),
                }
            };
            &column[part.clone()]
        })
    }

    /// Finds both for a chunk, and its masses. Nodes that a surface holds go on with the velocity that it gives them, and with
    /// the acceleration that it lets them have.
    pub fn find_base(&self, part: &Range<usize>) {
        let Some((history, scheme)) = self.second else { return };
        let (nodes, hold, h) = (self.worker.nodes, self.hold(0), self.worker.substep.h);
        // SAFETY: only this chunk's places.
        let (base, masses, rate) =
            unsafe { (history.base.write::<6>(part), history.mass.write(part.clone()), history.rate.read()) };
        for (at, place) in part.clone().enumerate() {
            masses[at] = scheme.mass * nodes.mass[place];
            let (x, outside) = (self.worker.old_position(place), self.free_velocity(place));
            let [start, free] = if nodes.inverse_mass[place] > T::ZERO {
                let before = self.worker.old_velocity(place);
                let [v, a] = Self::motion(hold.predicted.get(place), before, rate.at(place));
                [scheme.base_place(x, v, a), scheme.free_velocity(v, a, sub(outside, before))]
            } else {
                [add(x, scale(outside, h - scheme.h)), outside]
            };
            for axis in 0..3 {
                (base[axis][at], base[3 + axis][at]) = (start[axis], free[axis]);
            }
        }
    }

    /// The velocity and the acceleration with which a node goes on, as a surface that holds it wants.
    #[inline(always)]
    fn motion(predicted: Option<&PredictedContact<T>>, v: [T; 3], a: [T; 3]) -> [[T; 3]; 2] {
        match predicted.filter(|predicted| predicted.in_contact()) {
            Some(predicted) => [predicted.carried_velocity(v), predicted.filtered(a)],
            None => [v, a],
        }
    }

    /// What springs changed of velocities in the last sub-step, beyond those that the system has without springs.
    #[inline(always)]
    pub fn changes(&self, change: &View<'_, T>, first: usize) -> [[T; LANES]; 3] {
        let mut changes = change.lanes(first);
        if self.second.is_some() {
            for (lane, place) in (first..first + LANES).enumerate() {
                let ([_, free], outside) = (self.base(place), self.free_velocity(place));
                (0..3).for_each(|axis| changes[axis][lane] += outside[axis] - free[axis]);
            }
        }
        changes
    }

    /// Remembers the acceleration of a place whose velocity has changed by `after` [m/s] of that without springs; makes of it
    /// what has changed of the velocity by outer forces alone. Returns the whole step by that of the system.
    #[inline(always)]
    pub fn keep_rate(&self, place: usize, after: &mut [T; 3], contact: Option<&PredictedContact<T>>) -> T {
        let Some((history, scheme)) = self.second else { return T::ONE };
        // SAFETY: only this chunk's places, which nobody reads meanwhile.
        let [x, y, z] = unsafe { history.rate.write(&(place..place + 1)) };
        let old = [x[0], y[0], z[0]];
        let [_, free] = self.base(place);
        let u = add(free, *after);
        let mut rate = [T::ZERO; 3];
        if self.worker.nodes.inverse_mass[place] > T::ZERO {
            let [v, a] = Self::motion(contact, self.worker.old_velocity(place), old);
            rate = match contact {
                Some(predicted) => {
                    predicted.filtered(scheme.next_rate(sub(u, predicted.friction_change()), v, a))
                }
                None => scheme.next_rate(u, v, a),
            };
        }
        [x[0], y[0], z[0]] = rate;
        *after = sub(u, self.free_velocity(place));
        scheme.whole
    }
}

impl<T: Real> Implicit<T> {
    /// Puts the nodes of a tile where steps of second order take them.
    pub(crate) fn place_nodes(&self, tile: &Tile<'_, T>) {
        let Some((history, scheme)) = self.work.history.as_ref().zip(tile.substep.scheme()) else { return };
        if !tile.marks.has(Marks::SOLVED) {
            return;
        }
        // SAFETY: found before a barrier.
        let base = unsafe { history.base.read() };
        for (_, run) in tile.plan.runs() {
            let [x, y, z, u, v, w] = tile.after(&run);
            for (axis, (position, velocity)) in [(x, u), (y, v), (z, w)].into_iter().enumerate() {
                let starts = &base.column(axis)[run.clone()];
                let free = &tile.nodes.inverse_mass[run.clone()];
                for (at, (&start, &inverse_mass)) in starts.iter().zip(free).enumerate() {
                    if inverse_mass > T::ZERO {
                        position[at] = start + scheme.h * velocity[at];
                    }
                }
            }
        }
    }
}
