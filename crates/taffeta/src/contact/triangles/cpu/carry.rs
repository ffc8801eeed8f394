//! Colliders that move, on the CPU.

use super::{Scratch, TriangleContact, read};
use crate::contact::triangles::carry::{
    PUSHES, Phase, Pushed, farther, go_on, longest_push, longest_way, parts_of, reach_of_pushes,
};
use crate::contact::triangles::closest::{Closest, EdgeEdge, Pair, VertexTriangle};
use crate::contact::triangles::cpu::motion::Motion;
use crate::contact::triangles::cpu::narrow_phase::{Close, by_sixteen};
use crate::contact::triangles::filter::push_apart;
use crate::contact::triangles::surfaces::{Corners, Kind};
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, scale, sub};
use std::sync::atomic::Ordering;

/// A node, and the way that it is pushed [m].
pub type Push<T> = (u32, [T; 3]);

impl<T: Real> TriangleContact<T> {
    /// Moves the corners of colliders all their way, and what is in their way with them. All workers call it. Returns whether
    /// any corner moves.
    pub(super) fn carry(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>) -> bool {
        let Some(corners) = worker.substep.extensions.get::<Corners<T>>() else { return false };
        let Motion { corners: most, far, .. } = self.measure_corners(worker, corners);
        if most <= 0.0 {
            return false;
        }
        let parts = parts_of(most, self.surfaces.thinnest);
        let longest = longest_push(most, parts);
        for part in (0..parts).take_while(|_| !worker.is_stopped()) {
            let ends = [part, part + 1].map(|part| f64::from(part) / f64::from(parts));
            self.go_part_of_corners(worker, corners, ends);
            worker.synchronise();
            self.look(worker, scratch, None, reach_of_pushes(longest));
            self.push(worker, scratch, far, longest);
            self.each_run(worker, |run| {
                run.for_each(|place| self.put(&self.before, place, self.get(&self.after, place)));
            });
        }
        self.rest_corners(worker);
        true
    }

    /// Has nodes that are in the way of corners give way in a part of the motion, each at most `longest` [m] along an axis.
    fn push(&self, worker: &Worker<'_, T>, scratch: &mut Scratch<T>, far: f64, longest: f64) {
        let mut phase = Phase::Push;
        for round in (0..).take_while(|_| !worker.is_stopped()) {
            let mut pushed = Pushed::default();
            match phase {
                Phase::Push | Phase::Squeeze => {
                    let squeezed = phase == Phase::Squeeze;
                    pushed.waiting = self.send_pushes(worker, &scratch.close, T::from_f64(far), squeezed);
                    worker.synchronise();
                    pushed.moved = self.take_pushes(worker, T::from_f64(longest));
                }
                Phase::Restart => self.restart(worker),
                Phase::Stop => pushed.moved = self.stop(worker, scratch, far, round + 1 < PUSHES),
                Phase::Over => break,
            }
            self.found[worker.index].set_pushed(pushed);
            worker.synchronise();
            let pushed = self.found.iter().fold(Pushed::default(), |all, found| all.join(found.pushed()));
            phase = phase.next(round, pushed);
            if phase == Phase::Stop {
                scratch.squeezed = pushed.waiting.max(scratch.squeezed);
            }
            worker.synchronise();
        }
    }

    /// Puts a worker's nodes back.
    fn restart(&self, worker: &Worker<'_, T>) {
        self.each_run(worker, |run| {
            for place in run {
                self.put(&self.target, place, [T::ZERO; 3]);
                self.put(&self.after, place, self.get(&self.before, place));
            }
        });
    }

    /// Has nodes stop before planes between the sides of pairs without a collider; if they may go `together`, of those alone whose
    /// sides do not end apart. Returns whether any does.
    fn stop(
        &self,
        worker: &Worker<'_, T>,
        Scratch { close, memory, .. }: &mut Scratch<T>,
        far: f64,
        together: bool,
    ) -> bool {
        let is_node = |place: &u32| (*place as usize) < self.surfaces.places;
        memory.close.clear();
        memory.close.extend(close.iter().flatten().filter(|pair| pair.nodes.iter().all(is_node)).cloned());
        for sixteen in by_sixteen(&memory.close) {
            self.limit(worker, &sixteen, (far, together), |place, part, _| {
                // The order of bits is that of the numbers, for none is below zero.
                self.parts[place].fetch_min(part.to_f64().to_bits(), Ordering::Relaxed);
            });
        }
        worker.synchronise();
        let mut any = false;
        self.each_run(worker, |run| {
            for place in run {
                let part = f64::from_bits(self.parts[place].swap(1_f64.to_bits(), Ordering::Relaxed));
                any |= part < 1.0;
                let way = scale(self.get(&self.target, place), T::from_f64(part));
                self.put(&self.target, place, way);
                self.put(&self.after, place, add(self.get(&self.before, place), way));
            }
        });
        any
    }

    /// How far corners go, and the largest coordinate.
    fn measure_corners(&self, worker: &Worker<'_, T>, corners: &Corners<T>) -> Motion {
        let own = worker.part(corners.before.len().min(corners.after.len()));
        let mut motion = Motion { corners: longest_way(corners, own), ..Motion::default() };
        let mut note = |place: usize| {
            motion.far =
                self.get(&self.before, place).iter().fold(motion.far, |far, x| far.max(x.abs().to_f64()));
        };
        self.each_run(worker, |run| run.for_each(&mut note));
        self.corners_of(worker).for_each(&mut note);
        let all = self.join(worker, motion);
        worker.synchronise();
        all
    }

    /// Sets corners where they are at two parts of their way; nodes are at rest.
    fn go_part_of_corners(&self, worker: &Worker<'_, T>, corners: &Corners<T>, parts: [f64; 2]) {
        for place in self.corners_of(worker) {
            let corner = place - self.surfaces.places;
            let (Some(&from), Some(&to)) = (corners.before.get(corner), corners.after.get(corner)) else {
                continue;
            };
            for (columns, part) in [&self.before, &self.after].into_iter().zip(parts) {
                let way = scale(sub(to, from), T::from_f64(part));
                self.put(columns, place, if part < 1.0 { add(from, way) } else { to });
            }
        }
        self.each_run(worker, |run| {
            for place in run {
                self.put(&self.after, place, self.get(&self.before, place));
                self.put(&self.target, place, [T::ZERO; 3]);
                self.put(&self.target[3..], place, [T::ZERO; 3]);
            }
        });
    }

    /// Sends ways to the nodes of all pairs that would come too near: those of the side that the other drives. Returns one more
    /// than the last node of those sides that are not pinned; 0 if there is none.
    fn send_pushes(&self, worker: &Worker<'_, T>, close: &[Vec<Close<T>>; 2], far: T, squeezed: bool) -> u32 {
        let workers = self.found.len();
        let is_free = |&node: &u32| worker.nodes.inverse_mass[node as usize] > T::ZERO;
        let mut waiting = 0;
        for kind in Kind::ALL {
            let list = |to: usize| self.pushes.of((kind as usize * workers + worker.index) * workers + to);
            let mut pushes: Vec<_> = (0..workers).map(list).collect();
            pushes.iter_mut().for_each(|pushes| pushes.clear());
            for close in &close[kind as usize] {
                let pushed = match kind {
                    Kind::VertexTriangle => self.pushed::<VertexTriangle>(close, far, squeezed),
                    Kind::EdgeEdge => self.pushed::<EdgeEdge>(close, far, squeezed),
                };
                let Some((nodes, way)) = pushed else { continue };
                if nodes.iter().all(is_free) {
                    waiting = nodes.iter().fold(waiting, |last, &node| last.max(node + 1));
                }
                for &node in nodes.iter().filter(|node| is_free(node)) {
                    pushes[self.worker_of(node)].push((node, way));
                }
            }
        }
        waiting
    }

    /// The nodes of a pair that are in the way of the other side, none of them a corner, and where they are to go [m].
    fn pushed<'c, P: Pair>(
        &self,
        close: &'c Close<T>,
        far: T,
        squeezed: bool,
    ) -> Option<(&'c [u32], [T; 3])> {
        let (before, after) = (read(&self.before), read(&self.after));
        let at = |columns: [&[T]; 3], node: u32| columns.map(|column| column[node as usize]);
        let anchor = at(before, close.nodes[3]);
        let x = close.nodes.map(|node| sub(at(before, node), anchor));
        let moves = close.nodes.map(|node| sub(at(after, node), at(before, node)));
        if moves == [[T::ZERO; 3]; 4] {
            return None;
        }
        let Closest { weights, apart } = P::closest(x);
        let push = push_apart::<T, P>(x, moves, apart, (close.thickness, far), squeezed)?;
        let way = |nodes: std::ops::Range<usize>, sign: T| {
            nodes.fold([T::ZERO; 3], |sum, node| add(sum, scale(moves[node], sign * weights[node])))
        };
        let (first, second) = (way(0..P::FIRST, T::ONE), way(P::FIRST..4, -T::ONE));
        let (one, other) = close.nodes.split_at(P::FIRST);
        let is_corner = |&place: &u32| place as usize >= self.surfaces.places;
        // A collider always does.
        let first_drives =
            is_corner(&one[0]) || !is_corner(&other[0]) && -dot(first, apart) > dot(second, apart);
        Some(if first_drives { (other, scale(push, -T::ONE)) } else { (one, push) })
    }

    /// Has a worker's nodes go on along each axis by the most that was sent to each, up to `most` [m] in all. Returns whether
    /// any does.
    fn take_pushes(&self, worker: &Worker<'_, T>, most: T) -> bool {
        let mut any = false;
        self.each_push(worker, |node, push| {
            let now = self.get(&self.target[3..], node);
            self.put(&self.target[3..], node, farther(now, push));
        });
        self.each_push(worker, |node, _| {
            // Of several pushes the first takes all.
            let push = self.get(&self.target[3..], node);
            self.put(&self.target[3..], node, [T::ZERO; 3]);
            let way = self.get(&self.target[..3], node);
            let new = go_on(way, push, most);
            any = any || new != way;
            self.put(&self.target[..3], node, new);
            self.put(&self.after, node, add(self.get(&self.before, node), new));
        });
        any
    }

    /// Does something with each push that was sent to a worker's nodes.
    fn each_push(&self, worker: &Worker<'_, T>, mut job: impl FnMut(usize, [T; 3])) {
        let workers = self.found.len();
        for mail in (0..Kind::ALL.len() * workers).map(|from| from * workers + worker.index) {
            self.pushes.read(mail).iter().for_each(|&(node, push)| job(node as usize, push));
        }
    }
}
