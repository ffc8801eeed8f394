//! How far nodes move, and whether all pairs are listed that this may bring together.

use super::{Scratch, TriangleContact};
use crate::contact::triangles::cpu::pairs::Place;
use crate::contact::triangles::filter::reach;
use crate::cpu::shared::Shared;
use crate::cpu::worker::Worker;
use crate::real::Real;
use std::ops::Range;

/// Stretch up to which the filter keeps its least distance of edges.
const STRETCH: f64 = 2.0;
/// Least and largest distance that nodes may move between two searches, relative to the mean edge, and for how many sub-steps
/// a search is to last.
const BUDGET: [f64; 2] = [0.05, 0.4];
const STEPS: f64 = 24.0;

/// How far nodes move.
#[derive(Clone, Copy, Debug)]
pub struct Motion {
    /// Largest squared distance [m²].
    most: f64,
    /// Extremes by axis [m].
    low: [f64; 3],
    high: [f64; 3],
    /// Largest coordinate [m].
    pub far: f64,
}

impl Motion {
    pub const NONE: Self =
        Self { most: 0.0, low: [f64::INFINITY; 3], high: [f64::NEG_INFINITY; 3], far: 0.0 };

    pub fn add(&mut self, way: [f64; 3]) {
        self.most = self.most.max(way.iter().map(|x| x * x).sum());
        for ((low, high), way) in self.low.iter_mut().zip(&mut self.high).zip(way) {
            (*low, *high) = (low.min(way), high.max(way));
        }
    }

    pub fn join(self, other: Self) -> Self {
        Self {
            most: self.most.max(other.most),
            low: std::array::from_fn(|axis| self.low[axis].min(other.low[axis])),
            high: std::array::from_fn(|axis| self.high[axis].max(other.high[axis])),
            far: self.far.max(other.far),
        }
    }

    /// The same where no node goes more than `cap` [m] of its way.
    pub fn bound(&mut self, cap: f64) {
        self.most = self.most.min(cap * cap);
        for axis in 0..3 {
            self.low[axis] = self.low[axis].clamp(-cap, 0.0);
            self.high[axis] = self.high[axis].clamp(0.0, cap);
        }
    }

    /// Largest motion of any node [m].
    pub fn most(&self) -> f64 {
        self.most.sqrt() * (1.0 + 1e-5)
    }

    /// Bound of the relative motion of any two nodes [m], where some may have been held back.
    pub fn extent(&self, held: bool) -> f64 {
        let (low, high) = if held { (0.0, 0.0) } else { (f64::INFINITY, f64::NEG_INFINITY) };
        let along = |axis: usize| (self.high[axis].max(high) - self.low[axis].min(low)).max(0.0);
        (0..3).map(|axis| along(axis) * along(axis)).sum::<f64>().sqrt() * (1.0 + 1e-5)
    }
}

impl<T: Real> TriangleContact<T> {
    /// How all nodes of surfaces move to some positions, and corners of colliders to where they will be. All workers call it.
    pub(super) fn motion(&self, worker: &Worker<'_, T>, to: &[Shared<T>]) -> Motion {
        let mut own = Motion::NONE;
        let mut note = |place: usize, to: &[Shared<T>]| {
            // SAFETY: a worker's own place, or corner.
            let at = |columns: &[Shared<T>], axis: usize| unsafe { *columns[axis].item(place) }.to_f64();
            let from: [f64; 3] = std::array::from_fn(|axis| at(&self.before, axis));
            own.add(std::array::from_fn(|axis| at(to, axis) - from[axis]));
            own.far = from.iter().fold(own.far, |far, x| far.max(x.abs()));
        };
        self.each_place(worker, |place| note(place, to));
        self.corners_of(worker).for_each(|place| note(place, &self.after));
        // SAFETY: its own; all read after the barrier, and write again after another one.
        *unsafe { self.motion.item(worker.index) } = own;
        worker.synchronise();
        // SAFETY: as above.
        let all = unsafe { self.motion.read() }.iter().fold(Motion::NONE, |all, one| all.join(*one));
        worker.synchronise();
        all
    }

    /// The places of a worker's share of the corners of colliders.
    pub(super) fn corners_of(&self, worker: &Worker<'_, T>) -> Range<usize> {
        let own = worker.part(self.surfaces.corners().len());
        self.surfaces.places + own.start..self.surfaces.places + own.end
    }

    /// Sets positions of a worker's places, and of its corners of colliders if some move.
    pub(super) fn set(
        &self,
        worker: &Worker<'_, T>,
        columns: &[Shared<T>; 3],
        x: [&[T]; 3],
        corners: Option<&[[T; 3]]>,
    ) {
        // SAFETY: its own places and corners; others read after a barrier.
        let put = |axis: usize, place: usize, x: T| unsafe { *columns[axis].item(place) = x };
        self.each_place(worker, |place| (0..3).for_each(|axis| put(axis, place, x[axis][place])));
        for place in corners.map_or(0..0, |_| self.corners_of(worker)) {
            if let Some(x) = corners.and_then(|corners| corners.get(place - self.surfaces.places)) {
                (0..3).for_each(|axis| put(axis, place, x[axis]));
            }
        }
    }

    /// Does something with each of a worker's places that has a surface.
    pub(super) fn each_place(&self, worker: &Worker<'_, T>, mut job: impl FnMut(usize)) {
        for tile in &worker.nodes.tiles[worker.tiles.clone()] {
            for (_, run) in tile.runs() {
                run.filter(|&place| self.surfaces.surface_of[place] != u32::MAX).for_each(&mut job);
            }
        }
    }

    /// The longest way that nodes go in one round of the filter [m].
    pub(super) fn cap(&self) -> f64 {
        self.surfaces.thickest.max(self.surfaces.mean_edge)
    }

    /// How much nearer than their thickness pairs must be listed for such a motion, which is cut at the longest way [m].
    pub(super) fn reach(&self, motion: &Motion) -> f64 {
        let surfaces = &self.surfaces;
        reach(motion.most().min(self.cap()), surfaces.thickest, STRETCH * surfaces.longest_edge)
    }

    /// Makes sure that all pairs are listed that are nearer than their thickness and `stride` [m] when nodes are at `x`. All
    /// workers call it.
    pub(super) fn cover(&self, worker: &Worker<'_, T>, x: [&[T]; 3], stride: f64) {
        let scratch = self.scratch(worker);
        let fits = scratch.travelled + stride < scratch.margin;
        if fits {
            return;
        }
        let own = worker.part(self.surfaces.leaves());
        // SAFETY: its own leaves; all read after the barrier.
        unsafe { self.boxes.set(&self.surfaces, own.clone(), x) };
        worker.synchronise();
        scratch.travelled = 0.0;
        let [least, most] = BUDGET.map(|share| share * self.surfaces.mean_edge);
        scratch.margin = (stride + (STEPS * scratch.stride).clamp(least, most)) * (1.0 + 1e-3);
        scratch.searches += 1;
        let place = Place {
            surfaces: &self.surfaces,
            boxes: &self.boxes,
            x,
            own,
            margin: T::from_f64(scratch.margin),
            level: worker.nodes.level,
        };
        scratch.search.run(&place, &mut scratch.lists);
        worker.synchronise();
    }

    /// Adds the motion of the last round of the filter to what nodes have moved since the search.
    pub(super) fn add_travel(&self, scratch: &mut Scratch<T>) {
        // SAFETY: written before a barrier, and again after another.
        let held = unsafe { self.found.read() }.iter().any(|found| found.held > 0);
        scratch.stride = std::mem::replace(&mut scratch.motion, Motion::NONE).extent(held);
        scratch.travelled += scratch.stride;
    }
}
