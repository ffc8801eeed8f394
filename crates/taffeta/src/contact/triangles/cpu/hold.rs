//! The filter: how far each node may go.

use super::{Scratch, TriangleContact, positions, read};
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::triangles::cpu::lanes::Limit;
use crate::contact::triangles::cpu::motion::{Motion, state_at};
use crate::contact::triangles::cpu::narrow_phase::{Close, Sixteen, by_sixteen};
use crate::contact::triangles::cpu::untangle::lifts;
use crate::contact::triangles::filter::{JAMS, PROGRESS, SHARE, STRETCH, keeps_shape, reach};
use crate::contact::triangles::slide::{SLIDES, UNLIMITED, lift, out_of_solids, part, word};
use crate::contact::triangles::tangle::Rule;
use crate::cpu::feature::Flow;
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, norm, scale, sub};
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
    pub(super) fn filter(&self, worker: &mut Worker<'_, T>, scratch: &mut Scratch<T>) -> Flow {
        let progress = self.found.iter().map(|found| found.progress.get()).fold(0.0, f64::max);
        let cap = self.surfaces.longest_way();
        let round = scratch.filter_round.filter(|&round| round == 0 || progress >= PROGRESS * cap);
        scratch.filter_round = round;
        let Some(round) = round else {
            worker.mark_moved(|_| false);
            return Flow::Done;
        };
        let is_first = round == 0;
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
            is_carried = self.carry(worker, scratch);
            positions(self.state(worker))
        } else {
            self.go_on(worker);
            self.target()
        };
        let motion = self.measure_motion(worker, ends);
        if is_first && self.is_too_far(worker, motion.most) {
            self.is_in_vain.store(true, Ordering::Relaxed);
            // A little more, so that no rounding makes it less than too much.
            scratch.taken[0] = scratch.taken[0].max(1.001 * (motion.most - FILTERS as f64 * cap).powi(2));
            scratch.filter_round = None;
            worker.mark_moved(|_| false);
            return Flow::Done;
        }
        let is_far = motion.most > cap;
        let in_rounds = is_far || !is_first;
        if in_rounds {
            self.go_part(worker, is_first, cap);
        }
        if in_rounds || is_carried || 2.0 * motion.change > SHARE * self.leaves.allowance {
            self.look(worker, scratch, None, 0.0);
        }
        self.limit_close(worker, &scratch.close, motion.far);
        worker.synchronise();
        let motion = Motion { most: motion.most.min(cap), ..motion };
        let any = self.limit_around_held(worker, scratch, &motion);
        // The next round sees whether anyone got farther, or may.
        let another = is_far || any && round + 1 < SLIDES;
        scratch.filter_round = another.then_some(round + 1);
        scratch.responses.clear();
        if any || in_rounds {
            self.hold(worker, scratch, is_far, in_rounds);
        }
        self.list_by_tile(worker, scratch);
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
    fn limit_close(&self, worker: &Worker<'_, T>, close: &[Vec<Close<T>>; 2], far: f64) {
        let mut limited = false;
        for sixteen in close.iter().flat_map(|close| by_sixteen(close)) {
            limited |= self.limit_filter(worker, &sixteen, (far, true));
        }
        self.found[worker.index].is_held.store(limited, Ordering::Relaxed);
    }

    /// Limits the ways of the nodes of up to sixteen pairs. Returns whether any node is limited.
    fn limit_filter(&self, worker: &Worker<'_, T>, sixteen: &Sixteen<T>, how: (f64, bool)) -> bool {
        let mut any = false;
        self.limit(worker, sixteen, how, |place, part, away| {
            self.limits[place].fetch_min(word(part, away), Ordering::Relaxed);
            any = true;
        });
        any
    }

    /// Calls `note` with each node of up to sixteen pairs that may not make all its way: its place, the part that it may make, and what
    /// leads away from the other side.
    pub(super) fn limit(
        &self,
        worker: &Worker<'_, T>,
        Sixteen { kind, count, nodes, thickness, .. }: &Sixteen<T>,
        (far, together): (f64, bool),
        mut note: impl FnMut(usize, T, [T; 3]),
    ) {
        let places = self.surfaces.places as u32;
        let (before, after, far) = (read(&self.before), read(&self.after), T::from_f64(far));
        let (mut parts, mut apart) = ([[T::ONE; LANES]; 4], [[T::ZERO; LANES]; 3]);
        worker.nodes.level.run(Limit {
            kind: *kind,
            nodes,
            before,
            after,
            thickness: *thickness,
            far,
            together,
            parts: &mut parts,
            apart: &mut apart,
        });
        let first = kind.first();
        for lane in 0..*count {
            let (pair, parts) = (nodes.map(|nodes| nodes[lane]), parts.map(|parts| parts[lane]));
            let is_free = parts.iter().all(|&part| part >= T::ONE);
            if is_free || together && self.are_pinned_as_one(worker, pair) {
                continue;
            }
            let apart = apart.map(|lanes| lanes[lane]);
            for (which, (node, part)) in pair.into_iter().zip(parts).enumerate() {
                if part < T::ONE && node < places {
                    note(node as usize, part, if which < first { apart } else { apart.map(|along| -along) });
                }
            }
        }
    }

    /// Whether all nodes of a pair are pinned, and have kept their distances of the start before and after: pins move them as one, and
    /// none of them lags.
    fn are_pinned_as_one(&self, worker: &Worker<'_, T>, pair: [u32; 4]) -> bool {
        let is_pinned = |&node: &u32| {
            (node as usize) < self.surfaces.places && worker.nodes.inverse_mass[node as usize] <= T::ZERO
        };
        pair.iter().all(is_pinned) && {
            let start = pair.map(|node| self.start.each_ref().map(|column| column[node as usize]));
            let [before, after] =
                [&self.before, &self.after].map(|columns| pair.map(|node| self.get(columns, node as usize)));
            keeps_shape(start, before) && keeps_shape(start, after)
        }
    }

    /// Limits the ways of nodes around those that are held back: planes that go along hold only for who goes all the way.
    /// What this holds back may hold back others in turn. Returns whether any is.
    fn limit_around_held(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>, motion: &Motion) -> bool {
        let is_held = &self.found[worker.index].is_held;
        let any_held = || self.found.iter().any(|found| found.is_held.load(Ordering::Relaxed));
        for jam in 0..=JAMS {
            if !any_held() {
                return jam > 0;
            }
            if worker.is_stopped() {
                return true;
            }
            scratch.stamp += 1;
            let held = self.mark_held(worker, scratch, jam == 0);
            worker.synchronise();
            is_held.store(held, Ordering::Relaxed);
            worker.synchronise();
            let any = any_held();
            worker.synchronise();
            let limited = any && self.limit_around(worker, scratch, motion, jam == JAMS);
            is_held.store(limited, Ordering::Relaxed);
            worker.synchronise();
        }
        true
    }

    /// Marks a worker's nodes that are held back and were not before, and their leaves. Returns whether there are any.
    fn mark_held(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>, is_first: bool) -> bool {
        let stamp = scratch.stamp;
        if is_first {
            scratch.first_stamp = stamp;
        }
        let mut any = false;
        self.each_run(worker, |run| {
            for place in run {
                let is_held = self.limits[place].load(Ordering::Relaxed) < UNLIMITED;
                if is_held && self.held[place].load(Ordering::Relaxed) < scratch.first_stamp {
                    self.held[place].store(stamp, Ordering::Relaxed);
                    for &leaf in self.leaves_by_place.of(place) {
                        self.marks[leaf as usize].store(stamp, Ordering::Relaxed);
                    }
                    any = true;
                }
            }
        });
        any
    }

    /// Limits the ways of all pairs with a node that was marked last, or of `all` pairs. Returns whether any node is limited.
    fn limit_around(
        &self,
        worker: &Worker<'_, T>,
        scratch: &mut Scratch<T>,
        motion: &Motion,
        all: bool,
    ) -> bool {
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
                any |= self.limit_filter(worker, &sixteen, (motion.far, false));
            }
        });
        any
    }

    /// Lists the nodes that are held back, with their state; where nodes go in several rounds, all of them. Who may slide goes on in
    /// another round.
    fn hold(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>, is_far: bool, in_rounds: bool) {
        let [mut progress, mut taken, mut removed] = [T::ZERO; 3];
        self.each_run(worker, |run| {
            for place in run {
                let limit = self.limits[place].load(Ordering::Relaxed);
                if limit == UNLIMITED && !in_rounds {
                    self.set_target(place, state_at(worker.next(), place));
                    continue;
                }
                self.limits[place].store(UNLIMITED, Ordering::Relaxed);
                let held = self.hold_node(worker, place, limit, (is_far, in_rounds));
                progress = progress.max(held.progress);
                taken = taken.max(held.taken);
                removed = removed.max(held.removed);
                scratch.responses.push((place as u32, held.state));
            }
        });
        self.found[worker.index].progress.set(progress.sqrt().to_f64());
        scratch.taken = [scratch.taken[0].max(removed.to_f64()), taken.to_f64()];
    }

    /// Where a node goes in a round, with the word that limits it, and what is left of its way.
    fn hold_node(
        &self,
        worker: &Worker<'_, T>,
        place: usize,
        limit: u32,
        (is_far, in_rounds): (bool, bool),
    ) -> Held<T> {
        let (from, next) = (self.get(&self.before, place), state_at(worker.next(), place));
        let wanted = [next[0], next[1], next[2]];
        let to = if limit == UNLIMITED { wanted } else { add(from, scale(sub(wanted, from), part(limit))) };
        let target = if in_rounds { state_at(&self.target, place) } else { next };
        let goal = [target[0], target[1], target[2]];
        if in_rounds && to == goal {
            return Held { state: target, progress: T::ZERO, taken: T::ZERO, removed: T::ZERO };
        }
        // Who is held goes where its pin goes, however short the steps are.
        let is_free = worker.nodes.inverse_mass[place] > T::ZERO;
        let left = sub(wanted, to);
        let lift = if limit != UNLIMITED && is_free { lift(left, limit) } else { [T::ZERO; 3] };
        let (old, h) = (positions(worker.old()).map(|column| column[place]), worker.substep.h);
        let at = |x: [T; 3]| {
            let v = sub(x, old).map(|way| way / h);
            [x[0], x[1], x[2], v[0], v[1], v[2]]
        };
        let slides = lift != [T::ZERO; 3];
        let slid = add(left, lift);
        let goal =
            if slides { out_of_solids(met_by(worker, place), add(goal, lift), norm(left)) } else { goal };
        self.set_target(place, if slides { at(goal) } else { target });
        let squared = |way: [T; 3]| dot(way, way);
        let farther = if is_far { squared(sub(to, from)) } else { T::ZERO };
        let slid = squared(slid);
        Held {
            state: at(to),
            progress: if slides { farther.max(slid) } else { farther },
            taken: if is_free { squared(sub(goal, to)) } else { T::ZERO },
            removed: squared(lift),
        }
    }

    /// Sets where a node goes in the rounds that are left, and with what velocity it arrives.
    pub(super) fn set_target(&self, place: usize, [x, y, z, u, v, w]: [T; 6]) {
        self.put(&self.target[..3], place, [x, y, z]);
        self.put(&self.target[3..], place, [u, v, w]);
    }
}

/// The colliders that a node meets: none while it is led out of them, for it is not thrown out.
fn met_by<'w, T: Real>(worker: &Worker<'w, T>, place: usize) -> &'w [ColliderNow<T>] {
    let is_led = lifts(worker).binary_search_by_key(&(place as u32), |lift| lift.node).is_ok();
    if is_led { &[] } else { worker.substep.met_colliders().at(place) }
}

/// Where a node goes in a round of the filter.
struct Held<T> {
    state: [T; 6],
    /// How far it came, or will come along a plane, if that is a reason for another round; what is left of its way, and what no
    /// round gives back; squared [m²].
    progress: T,
    taken: T,
    removed: T,
}
