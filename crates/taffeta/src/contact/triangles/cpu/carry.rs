//! Colliders that move: what is in their way goes along, before nodes go where they would end.
//!
//! A collider goes all its way, so a plane between it and cloth that stands still may not exist. Here its motion is made first,
//! in parts, with all nodes at rest but those in its way: these go as the nearest point of the collider goes, and push others
//! in their way in turn. Afterwards colliders are at rest, and the filter keeps nodes apart from them as from all else. Only
//! what is pinned, or between two colliders, cannot give way.

use super::{TriangleContact, read};
use crate::contact::triangles::closest::{Closest, EdgeEdge, Pair, VertexTriangle};
use crate::contact::triangles::cpu::motion::Motion;
use crate::contact::triangles::cpu::narrow_phase::Close;
use crate::contact::triangles::filter::{ends_apart, reach_together};
use crate::contact::triangles::surfaces::{Corners, Kind};
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, scale, sub};

/// A node, and the way that it is pushed [m].
pub type Push<T> = (u32, [T; 3]);

/// How far corners go in one part of their motion, relative to the least thickness, and how many parts there are at most.
const PART: f64 = 0.5;
const PARTS: f64 = 64.0;
/// How often nodes that are pushed push others in one part.
const ROUNDS: usize = 64;

impl<T: Real> TriangleContact<T> {
    /// Moves the corners of colliders all their way, and what is in their way with them. All workers call it. Returns whether
    /// any corner moves.
    pub(super) fn carry(&self, worker: &Worker<'_, T>) -> bool {
        let Some(corners) = worker.substep.extensions.get::<Corners<T>>() else { return false };
        let Motion { corners: most, far, .. } = self.measure_corners(worker, corners);
        if most <= 0.0 {
            return false;
        }
        let parts = (most / (PART * self.surfaces.thinnest)).ceil().clamp(1.0, PARTS);
        for part in 0..parts as usize {
            self.go_part_of_corners(worker, corners, [part, part + 1].map(|part| part as f64 / parts));
            worker.synchronise();
            self.look(worker, None, reach_together(most / parts));
            for _ in 0..ROUNDS {
                self.send_pushes(worker, T::from_f64(far));
                worker.synchronise();
                let moved = self.take_pushes(worker);
                // SAFETY: its own; all read after the barrier, and it is written again after another.
                unsafe { self.found.item(worker.index) }.held = u64::from(moved);
                worker.synchronise();
                // SAFETY: as above.
                let any = unsafe { self.found.read() }.iter().any(|found| found.held > 0);
                worker.synchronise();
                if !any {
                    break;
                }
            }
            self.each_run(worker, |run| {
                run.for_each(|place| self.put(&self.before, place, self.get(&self.after, place)));
            });
        }
        self.rest_corners(worker);
        true
    }

    /// How far corners go, and the largest coordinate.
    fn measure_corners(&self, worker: &Worker<'_, T>, corners: &Corners<T>) -> Motion {
        let own = worker.part(corners.before.len().min(corners.after.len()));
        let ways = own.map(|corner| sub(corners.after[corner], corners.before[corner]));
        let squared = ways.map(|way| dot(way, way).to_f64()).fold(0.0, f64::max);
        let mut motion = Motion { corners: squared.sqrt(), ..Motion::default() };
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
            run.for_each(|place| self.put(&self.after, place, self.get(&self.before, place)));
        });
    }

    /// Sends ways to the nodes of all pairs that would come too near: those of the side that drives the other.
    fn send_pushes(&self, worker: &Worker<'_, T>, far: T) {
        let workers = self.found.len();
        for kind in Kind::ALL {
            for to in 0..workers {
                // SAFETY: its own; others read them after the next barrier.
                unsafe { self.pushes.item((kind as usize * workers + worker.index) * workers + to) }.clear();
            }
            for close in &self.scratch(worker).close[kind as usize] {
                let pushed = match kind {
                    Kind::VertexTriangle => self.pushed::<VertexTriangle>(close, far),
                    Kind::EdgeEdge => self.pushed::<EdgeEdge>(close, far),
                };
                let Some((nodes, way)) = pushed else { continue };
                for &node in nodes.iter().filter(|&&node| (node as usize) < self.surfaces.places) {
                    if worker.nodes.inverse_mass[node as usize] > T::ZERO {
                        let to = self.worker_of(node);
                        // SAFETY: as above.
                        let pushes = unsafe {
                            self.pushes.item((kind as usize * workers + worker.index) * workers + to)
                        };
                        pushes.push((node, way));
                    }
                }
            }
        }
    }

    /// The nodes of a pair that are in the way of the other side, and the way that this goes.
    fn pushed<'c, P: Pair>(&self, close: &'c Close<T>, far: T) -> Option<(&'c [u32], [T; 3])> {
        let (before, after) = (read(&self.before), read(&self.after));
        let at = |columns: [&[T]; 3], node: u32| columns.map(|column| column[node as usize]);
        let anchor = at(before, close.nodes[3]);
        let x = close.nodes.map(|node| sub(at(before, node), anchor));
        let moves = close.nodes.map(|node| sub(at(after, node), at(before, node)));
        if moves == [[T::ZERO; 3]; 4] {
            return None;
        }
        let Closest { weights, apart } = P::closest(x);
        if ends_apart::<T, P>(x, moves, apart, (close.thickness, far)) {
            return None;
        }
        let way = |nodes: std::ops::Range<usize>, sign: T| {
            nodes.fold([T::ZERO; 3], |sum, node| add(sum, scale(moves[node], sign * weights[node])))
        };
        let (first, second) = (way(0..P::FIRST, T::ONE), way(P::FIRST..4, -T::ONE));
        let (one, other) = close.nodes.split_at(P::FIRST);
        Some(if -dot(first, apart) > dot(second, apart) { (other, first) } else { (one, second) })
    }

    /// Has a worker's nodes go the longest way that was sent to each. Returns whether any goes farther than before.
    fn take_pushes(&self, worker: &Worker<'_, T>) -> bool {
        let workers = self.found.len();
        let mut any = false;
        for kind in 0..Kind::ALL.len() {
            for from in 0..workers {
                // SAFETY: its own mail, sent before a barrier.
                let pushes = unsafe { self.pushes.item((kind * workers + from) * workers + worker.index) };
                for &(node, way) in pushes.iter() {
                    let from = self.get(&self.before, node as usize);
                    let now = sub(self.get(&self.after, node as usize), from);
                    if dot(way, way) > dot(now, now) {
                        self.put(&self.after, node as usize, add(from, way));
                        any = true;
                    }
                }
            }
        }
        any
    }
}
