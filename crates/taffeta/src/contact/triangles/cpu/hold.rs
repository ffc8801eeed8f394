//! The filter: how far each node may go.

use super::{FilterRound, TriangleContact, positions, read};
use crate::contact::triangles::cpu::lanes::Limit;
use crate::contact::triangles::cpu::motion::Motion;
use crate::contact::triangles::cpu::narrow_phase::{Close, Sixteen, by_sixteen};
use crate::contact::triangles::cpu::untangle::lifts;
use crate::contact::triangles::filter::{JAMS, PROGRESS, SHARE, STRETCH, reach};
use crate::contact::triangles::tangle::Rule;
use crate::cpu::feature::Flow;
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, scale, sub};
use crate::step::FILTERS;
use crate::topology::LANES;
use std::sync::atomic::Ordering;

impl<T: Real> TriangleContact<T> {
    /// A way of which the square is given [m²], relative to an edge.
    pub(super) fn by_edge(&self, squared: f64) -> f64 {
        squared.sqrt() / self.surfaces.mean_edge
    }

    /// A round of the filter: nodes go towards where they would end, and stop where they might meet something. Who goes far
    /// goes in several rounds.
    pub(super) fn filter(&self, worker: &mut Worker<'_, T>) -> Flow {
        let scratch = self.scratch(worker);
        let (is_first, cap) = (scratch.stage == FilterRound::First, self.surfaces.longest_way());
        // SAFETY: written before a barrier, and again after another.
        let progress = unsafe { self.found.read() }.iter().map(|found| found.progress).fold(0.0, f64::max);
        let is_stuck = scratch.stage == FilterRound::More && progress < PROGRESS * cap;
        if is_stuck || scratch.stage == FilterRound::Over {
            scratch.stage = FilterRound::Over;
            worker.mark_moved(|_| false);
            return Flow::Done;
        }
        let mut is_carried = false;
        let ends = if is_first {
            scratch.note_forces(worker.substep);
            // What the last round of the last sub-step has taken of ways counts.
            let [most, last] = &mut scratch.taken;
            *most = most.max(std::mem::take(last));
            if self.by_edge(*most) > worker.substep.in_vain.taken() {
                // The others see it at the end of the sub-step.
                self.is_in_vain.store(true, Ordering::Relaxed);
            }
            is_carried = self.carry(worker);
            positions(self.state(worker))
        } else {
            self.go_on(worker);
            self.target()
        };
        let motion = self.measure_motion(worker, ends);
        if is_first && self.is_too_far(worker, motion.most) {
            self.is_in_vain.store(true, Ordering::Relaxed);
            let scratch = self.scratch(worker);
            // A little more, so that no rounding makes it less than too much.
            scratch.taken[0] = scratch.taken[0].max(1.001 * (motion.most - FILTERS as f64 * cap).powi(2));
            scratch.stage = FilterRound::Over;
            worker.mark_moved(|_| false);
            return Flow::Done;
        }
        let is_far = motion.most > cap;
        let in_rounds = is_far || !is_first;
        if in_rounds {
            self.go_part(worker, is_first, cap);
        }
        if in_rounds || is_carried || 2.0 * motion.change > SHARE * self.leaves.allowance {
            self.look(worker, None, 0.0);
        }
        self.limit_close(worker, motion.far);
        worker.synchronise();
        let motion = Motion { most: motion.most.min(cap), ..motion };
        let any = self.limit_around_held(worker, &motion);
        let scratch = self.scratch(worker);
        scratch.stage = if is_far { FilterRound::More } else { FilterRound::Over };
        scratch.responses.clear();
        if any || in_rounds {
            self.hold(worker, in_rounds);
        }
        self.list_by_tile(worker);
        Flow::Go
    }

    /// Whether the rounds cannot bring a free node so far that little enough is left of its way, where no node goes farther than `most`
    /// [m]. All workers call it.
    fn is_too_far(&self, worker: &Worker<'_, T>, most: f64) -> bool {
        let (in_vain, edge) = (worker.substep.in_vain, self.surfaces.mean_edge);
        let reach = FILTERS as f64 * self.surfaces.longest_way();
        let is_beyond = |way: f64, pin: f64| way > reach + in_vain.farther(edge, pin);
        if !in_vain.pins_move || !is_beyond(most, 0.0) {
            return is_beyond(most, 0.0);
        }
        let [free, pinned] = self.measure_ways(worker);
        is_beyond(free, pinned)
    }

    /// Limits the ways of the nodes of all pairs that come near each other, if all nodes go all their way.
    fn limit_close(&self, worker: &Worker<'_, T>, far: f64) {
        let mut limited = false;
        for sixteen in self.scratch(worker).close.iter().flat_map(|close| by_sixteen(close)) {
            limited |= self.limit(worker, &sixteen, (far, true));
        }
        // SAFETY: its own; all read after the next barrier.
        unsafe { self.found.item(worker.index) }.held = u64::from(limited);
    }

    /// Limits the ways of the nodes of up to sixteen pairs. Returns whether any node is limited.
    pub(super) fn limit(
        &self,
        worker: &Worker<'_, T>,
        Sixteen { kind, count, nodes, thickness, .. }: &Sixteen<T>,
        (far, together): (f64, bool),
    ) -> bool {
        let places = self.surfaces.places as u32;
        let (before, after, far) = (read(&self.before), read(&self.after), T::from_f64(far));
        let mut parts = [[T::ONE; LANES]; 4];
        worker.nodes.level.run(Limit {
            kind: *kind,
            nodes,
            before,
            after,
            thickness: *thickness,
            far,
            together,
            parts: &mut parts,
        });
        let mut any = false;
        for (nodes, parts) in nodes.iter().zip(&parts) {
            for (&node, &part) in nodes.iter().zip(parts).take(*count) {
                if part < T::ONE && node < places {
                    // The order of bits is that of the numbers, for none is below zero.
                    self.parts[node as usize].fetch_min(part.to_f64().to_bits(), Ordering::Relaxed);
                    any = true;
                }
            }
        }
        any
    }

    /// Limits the ways of nodes around those that are held back: planes that go along hold only for who goes all the way.
    /// What this holds back may hold back others in turn. Returns whether any is.
    fn limit_around_held(&self, worker: &Worker<'_, T>, motion: &Motion) -> bool {
        for jam in 0..=JAMS {
            let scratch = self.scratch(worker);
            // SAFETY: written before a barrier, and again after another.
            let any = unsafe { self.found.read() }.iter().any(|found| found.held > 0);
            if !any {
                return jam > 0;
            }
            if worker.is_stopped() {
                return true;
            }
            scratch.stamp += 1;
            let held = self.mark_held(worker, jam == 0, scratch.stamp);
            worker.synchronise();
            // SAFETY: its own; all read after the next barrier.
            unsafe { self.found.item(worker.index) }.held = held;
            worker.synchronise();
            // SAFETY: as above.
            let any = unsafe { self.found.read() }.iter().any(|found| found.held > 0);
            worker.synchronise();
            let limited = any && self.limit_around(worker, motion, jam == JAMS);
            // SAFETY: as above.
            unsafe { self.found.item(worker.index) }.held = u64::from(limited);
            worker.synchronise();
        }
        true
    }

    /// Marks a worker's nodes that are held back and were not before, and their leaves. Returns how many they are.
    fn mark_held(&self, worker: &Worker<'_, T>, is_first: bool, stamp: u64) -> u64 {
        let scratch = self.scratch(worker);
        if is_first {
            scratch.first_stamp = stamp;
        }
        let mut count = 0;
        self.each_run(worker, |run| {
            for place in run {
                let is_held = self.parts[place].load(Ordering::Relaxed) < 1_f64.to_bits();
                if is_held && self.held[place].load(Ordering::Relaxed) < scratch.first_stamp {
                    self.held[place].store(stamp, Ordering::Relaxed);
                    for &leaf in self.leaves_by_place.of(place) {
                        self.marks[leaf as usize].store(stamp, Ordering::Relaxed);
                    }
                    count += 1;
                }
            }
        });
        count
    }

    /// Limits the ways of all pairs with a node that was marked last, or of `all` pairs. Returns whether any node is limited.
    fn limit_around(&self, worker: &Worker<'_, T>, motion: &Motion, all: bool) -> bool {
        let scratch = self.scratch(worker);
        let (surfaces, level, stamp) = (&self.surfaces, worker.nodes.level, scratch.stamp);
        let digit = T::EPSILON.to_f64() * motion.far;
        let edge = STRETCH * surfaces.longest_edge;
        let reach_of = |most: f64| reach(most, surfaces.thickest, edge, digit);
        let most = reach_of(motion.most);
        let is_marked = |leaf: usize| all || self.marks[leaf].load(Ordering::Relaxed) == stamp;
        let is_held = |node: u32| {
            all || (node as usize) < surfaces.places
                && self.held[node as usize].load(Ordering::Relaxed) == stamp
        };
        let lifts = lifts(worker);
        let (pairs, memory) = (&mut scratch.pairs, &mut scratch.memory);
        self.leaves.cover(worker.index, pairs, surfaces, (level, most), || worker.synchronise());
        let mut any = false;
        self.leaves.each_marked(pairs, surfaces, (level, most), is_marked, |pair| {
            if worker.gives_up() {
                return;
            }
            // Ways may have changed by the allowance since they were bounded.
            let way = self.leaves.longest_way(pair.leaves) + self.leaves.allowance;
            let reach = T::from_f64(reach_of(way));
            self.look_at(pair, level).list(reach, memory);
            let is_kept = |close: &Close<T>| {
                close.nodes.iter().any(|&node| is_held(node)) && self.rule(lifts, close) == Rule::Apart
            };
            memory.close.retain(is_kept);
            for sixteen in by_sixteen(&memory.close) {
                any |= self.limit(worker, &sixteen, (motion.far, false));
            }
        });
        any
    }

    /// Lists the nodes that are held back, with their state; where nodes go in several rounds, all of them.
    fn hold(&self, worker: &Worker<'_, T>, in_rounds: bool) {
        let scratch = self.scratch(worker);
        let old = positions(worker.old());
        let (base, next, h) = (read(&self.before), self.state(worker), worker.substep.h);
        let (mut progress, mut taken) = (T::ZERO, T::ZERO);
        self.each_run(worker, |run| {
            for place in run {
                let part = T::from_f64(f64::from_bits(self.parts[place].load(Ordering::Relaxed)));
                if part >= T::ONE && !in_rounds {
                    continue;
                }
                self.parts[place].store(1_f64.to_bits(), Ordering::Relaxed);
                let from = base.map(|column| column[place]);
                let wanted = [next[0][place], next[1][place], next[2][place]];
                let to = if part < T::ONE { add(from, scale(sub(wanted, from), part)) } else { wanted };
                // SAFETY: its own place.
                let target: [T; 6] = std::array::from_fn(|axis| unsafe { *self.target[axis].item(place) });
                let arrives = in_rounds && to == [target[0], target[1], target[2]];
                if !arrives {
                    let way = sub(to, from);
                    progress = progress.max(dot(way, way));
                    let goal = if in_rounds { [target[0], target[1], target[2]] } else { wanted };
                    let left = sub(goal, to);
                    // Who is held goes where its pin goes, however short the steps are.
                    let is_free = worker.nodes.inverse_mass[place] > T::ZERO;
                    taken = taken.max(if is_free { dot(left, left) } else { T::ZERO });
                }
                let v = if arrives {
                    [target[3], target[4], target[5]]
                } else {
                    sub(to, old.map(|column| column[place])).map(|way| way / h)
                };
                scratch.responses.push((place as u32, [to[0], to[1], to[2], v[0], v[1], v[2]]));
            }
        });
        // SAFETY: its own; all read after a barrier.
        unsafe { self.found.item(worker.index) }.progress = progress.sqrt().to_f64();
        scratch.taken[1] = taken.to_f64();
    }
}
