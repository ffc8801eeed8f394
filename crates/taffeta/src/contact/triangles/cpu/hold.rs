//! The filter: how far each node may go.

use super::{FilterRound, TriangleContact, positions, read};
use crate::contact::triangles::cpu::lanes::{Limit, gather};
use crate::cpu::feature::Flow;
use crate::cpu::shared::Shared;
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, scale, sub};
use crate::topology::LANES;
use std::sync::atomic::Ordering;

impl<T: Real> TriangleContact<T> {
    /// A round of the filter: nodes go towards where they would end, and stop where they might meet something. Who goes far
    /// goes in several rounds.
    pub(super) fn filter(&self, worker: &mut Worker<'_, T>) -> Flow {
        let scratch = self.scratch(worker);
        let is_first = scratch.stage == FilterRound::First;
        if scratch.stage == FilterRound::Over {
            worker.mark_moved(|_| false);
            return Flow::Done;
        }
        if is_first {
            scratch.note_forces(worker.substep.h, self.longest);
        } else {
            self.add_travel(scratch);
        }
        let old = positions(worker.old());
        let next = positions(self.state(worker));
        if is_first {
            self.set(worker, &self.after, next, None);
        } else {
            self.set(worker, &self.before, next, None);
            self.rest_corners(worker);
        }
        let cap = self.cap();
        let mut motion = self.motion(worker, if is_first { &self.after[..] } else { &self.target[..3] });
        let is_far = motion.most() > cap;
        if is_far || !is_first {
            self.go_part(worker, is_first, cap);
            motion.bound(cap);
        }
        let stride = self.reach(&motion);
        let searches = self.scratch(worker).searches;
        let base = read(&self.before);
        self.cover(worker, base, stride);
        let scratch = self.scratch(worker);
        let seen = is_first && searches == scratch.searches && stride <= scratch.seen;
        self.limit(worker, base, (stride, seen), motion.far);
        worker.synchronise();
        let scratch = self.scratch(worker);
        scratch.stage = if is_far { FilterRound::More } else { FilterRound::Over };
        scratch.motion = motion;
        let held = self.hold(worker, old, is_far || !is_first);
        // SAFETY: its own; all read after the next barrier.
        unsafe { self.found.item(worker.index) }.held += held;
        self.list_by_tile(worker);
        Flow::Go
    }

    /// Corners of colliders stay where they are: they have gone all their way in the first round, or do not move.
    pub(super) fn rest_corners(&self, worker: &Worker<'_, T>) {
        for place in self.corners_of(worker) {
            for (before, after) in self.before.iter().zip(&self.after) {
                // SAFETY: its own corners; others read after a barrier.
                unsafe { *before.item(place) = *after.item(place) };
            }
        }
    }

    /// Has nodes go at most `cap` [m] towards where they would end.
    fn go_part(&self, worker: &Worker<'_, T>, is_first: bool, cap: f64) {
        let cap = T::from_f64(cap);
        let next = worker.next();
        let get = |columns: &[Shared<T>], place: usize| -> [T; 3] {
            // SAFETY: a worker's own place; others read after a barrier.
            std::array::from_fn(|axis| unsafe { *columns[axis].item(place) })
        };
        let put = |columns: &[Shared<T>], place: usize, x: [T; 3]| {
            for (column, x) in columns.iter().zip(x) {
                // SAFETY: as above.
                unsafe { *column.item(place) = x };
            }
        };
        self.each_place(worker, |place| {
            if is_first {
                put(&self.target[..3], place, get(&next[..3], place));
                put(&self.target[3..], place, get(&next[3..], place));
            }
            let (from, target) = (get(&self.before, place), get(&self.target[..3], place));
            let way = sub(target, from);
            let length = dot(way, way).sqrt();
            let to = if length > cap { add(from, scale(way, cap / length)) } else { target };
            put(&next[..3], place, to);
            put(&self.after, place, to);
        });
        worker.synchronise();
    }

    /// Finds the part of its motion from `base` that each node may make. Whether all pairs that matter were `seen` there.
    fn limit(&self, worker: &Worker<'_, T>, base: [&[T]; 3], (stride, seen): (f64, bool), far: f64) {
        let scratch = self.scratch(worker);
        let (after, level, far) = (read(&self.after), worker.nodes.level, T::from_f64(far));
        let places = self.surfaces.places as u32;
        let mut parts = [[T::ONE; LANES]; 4];
        let near = T::from_f64(stride);
        for list in &mut scratch.lists {
            if !seen {
                list.wake(scratch.travelled + stride);
            }
            // A pair that is farther apart than that limits nobody.
            list.awake.retain(|(_, distance)| *distance <= near);
            for sixteen in list.awake.chunks(LANES) {
                let nodes = gather(sixteen.iter().map(|(pair, _)| &list.nodes[*pair as usize]));
                let (kind, parts) = (list.kind, &mut parts);
                let thickness = thickness(sixteen, &list.materials);
                let fixed = std::array::from_fn(|lane| [nodes[0][lane] >= places, nodes[3][lane] >= places]);
                let nodes = &nodes;
                level.run(Limit { kind, nodes, before: base, after, thickness, fixed, far, parts });
                for (nodes, parts) in nodes.iter().zip(&*parts) {
                    let held =
                        nodes.iter().zip(parts).filter(|(node, part)| **node < places && **part < T::ONE);
                    for (node, part) in held {
                        // The order of bits is that of the numbers, for none is below zero.
                        self.parts[*node as usize].fetch_min(part.to_f64().to_bits(), Ordering::Relaxed);
                    }
                }
            }
        }
    }

    /// Lists the nodes that are held back, with their state; where nodes go in several rounds, all of them. Returns how many
    /// are held back.
    fn hold(&self, worker: &Worker<'_, T>, old: [&[T]; 3], in_rounds: bool) -> u64 {
        let scratch = self.scratch(worker);
        let (base, next, h) = (read(&self.before), self.state(worker), worker.substep.h);
        scratch.responses.clear();
        let mut held = 0;
        self.each_place(worker, |place| {
            let part = T::from_f64(f64::from_bits(self.parts[place].load(Ordering::Relaxed)));
            held += u64::from(part < T::ONE);
            if part >= T::ONE && !in_rounds {
                return;
            }
            self.parts[place].store(1_f64.to_bits(), Ordering::Relaxed);
            let from = base.map(|column| column[place]);
            let wanted = [next[0][place], next[1][place], next[2][place]];
            let to = if part < T::ONE { add(from, scale(sub(wanted, from), part)) } else { wanted };
            // SAFETY: its own place.
            let target: [T; 6] = std::array::from_fn(|axis| unsafe { *self.target[axis].item(place) });
            let arrives = in_rounds && to == [target[0], target[1], target[2]];
            let v = if arrives {
                [target[3], target[4], target[5]]
            } else {
                sub(to, old.map(|column| column[place])).map(|way| way / h)
            };
            scratch.responses.push((place as u32, [to[0], to[1], to[2], v[0], v[1], v[2]]));
        });
        held
    }
}

/// Thickness of up to sixteen pairs [m].
fn thickness<T: Real>(pairs: &[(u32, T)], materials: &[[T; 2]]) -> [T; LANES] {
    let mut all = [T::ZERO; LANES];
    for (one, (pair, _)) in all.iter_mut().zip(pairs) {
        *one = materials[*pair as usize][0];
    }
    all
}
