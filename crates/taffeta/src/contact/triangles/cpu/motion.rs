//! Where nodes of surfaces are before and after a sub-step, or a round of the filter.

use super::{TriangleContact, positions};
use crate::contact::triangles::filter::bound_of;
use crate::cpu::shared::Shared;
use crate::cpu::simd::Kernel;
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, scale, sub};
use crate::topology::LANES;
use std::ops::Range;

/// How far nodes go.
#[derive(Clone, Copy, Debug, Default)]
pub struct Motion {
    /// The longest way of a node, and of a corner of a collider [m].
    pub most: f64,
    pub corners: f64,
    /// The longest way from where it was to go before impulses [m].
    pub change: f64,
    /// Largest coordinate [m].
    pub far: f64,
}

impl Motion {
    fn join(self, other: Self) -> Self {
        Self {
            most: self.most.max(other.most),
            corners: self.corners.max(other.corners),
            change: self.change.max(other.change),
            far: self.far.max(other.far),
        }
    }
}

/// The state of a worker's own node.
pub fn state_at<T: Real>(columns: &[Shared<T>; 6], place: usize) -> [T; 6] {
    // SAFETY: its own place; others read after a barrier.
    std::array::from_fn(|axis| unsafe { *columns[axis].item(place) })
}

/// Kernel: copies positions, and measures them.
struct Measure<'a, T> {
    /// Where nodes begin, and where they end [m].
    base: [&'a [T]; 3],
    ends: [&'a [T]; 3],
    /// Where they were to end; where they end, after it [m].
    after: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for Measure<'_, T> {
    /// The longest way, the longest one from where they were to end, both squared [m²], and the largest coordinate [m].
    type Output = [T; 3];

    #[inline(always)]
    fn run(self) -> [T; 3] {
        let Self { base, ends, after: [x, y, z] } = self;
        let count = x.len();
        let mut most = [[T::ZERO; LANES]; 3];
        let mut first = 0;
        while first < count {
            let lanes = LANES.min(count - first);
            for (lane, at) in (first..first + lanes).enumerate() {
                let from = [base[0][at], base[1][at], base[2][at]];
                let to = [ends[0][at], ends[1][at], ends[2][at]];
                let (way, change) = (sub(to, from), sub(to, [x[at], y[at], z[at]]));
                (x[at], y[at], z[at]) = (to[0], to[1], to[2]);
                let (way, change) = (dot(way, way), dot(change, change));
                let far = from[0].abs().max(from[1].abs()).max(from[2].abs());
                most[0][lane] = if way > most[0][lane] { way } else { most[0][lane] };
                most[1][lane] = if change > most[1][lane] { change } else { most[1][lane] };
                most[2][lane] = if far > most[2][lane] { far } else { most[2][lane] };
            }
            first += LANES;
        }
        let mut all = [T::ZERO; 3];
        for which in 0..3 {
            for lane in most[which] {
                all[which] = if lane > all[which] { lane } else { all[which] };
            }
        }
        all
    }
}

impl<T: Real> TriangleContact<T> {
    /// Sets where a worker's nodes are before and after the sub-step, and its corners of colliders where some move.
    pub(super) fn take(&self, worker: &Worker<'_, T>, corners: Option<[&[[T; 3]]; 2]>) {
        let (old, next) = (positions(worker.old()), positions(self.state(worker)));
        self.each_run(worker, |run| {
            for axis in 0..3 {
                // SAFETY: its own places; others read after a barrier.
                unsafe {
                    self.before[axis].write(run.clone()).copy_from_slice(&old[axis][run.clone()]);
                    self.after[axis].write(run.clone()).copy_from_slice(&next[axis][run.clone()]);
                }
            }
        });
        let Some(both) = corners else { return self.rest_corners(worker) };
        for place in self.corners_of(worker) {
            for (columns, corners) in [&self.before, &self.after].into_iter().zip(both) {
                if let Some(x) = corners.get(place - self.surfaces.places) {
                    self.put(columns, place, *x);
                }
            }
        }
    }

    /// Sets where a worker's nodes end, and measures the motion of all. All workers call it.
    pub(super) fn measure_motion(&self, worker: &Worker<'_, T>, ends: [&[T]; 3]) -> Motion {
        let mut own = Motion::default();
        self.each_run(worker, |run| {
            // SAFETY: its own places; others read after a barrier.
            let [base, after] = unsafe {
                [&self.before, &self.after]
                    .map(|columns| columns.each_ref().map(|one| one.write(run.clone())))
            };
            let base = base.map(|column| &*column);
            let ends = ends.map(|column| &column[run.clone()]);
            let [most, change, far] = worker.nodes.level.run(Measure { base, ends, after });
            let length = |squared: T| bound_of(squared.to_f64());
            let motion =
                Motion { most: length(most), change: length(change), far: far.to_f64(), ..Motion::default() };
            own = own.join(motion);
        });
        for place in self.corners_of(worker) {
            own.far = self.get(&self.before, place).iter().fold(own.far, |far, x| far.max(x.abs().to_f64()));
        }
        self.join(worker, own)
    }

    /// The longest ways of free nodes and of those that are held [m]. All workers call it, with the motion measured.
    pub(super) fn measure_ways(&self, worker: &Worker<'_, T>) -> [f64; 2] {
        let mut most = [T::ZERO; 2];
        self.each_run(worker, |run| {
            for place in run {
                let way = sub(self.get(&self.after, place), self.get(&self.before, place));
                let which = usize::from(worker.nodes.inverse_mass[place] == T::ZERO);
                most[which] = most[which].max(dot(way, way));
            }
        });
        let [free, pinned] = most.map(|squared| bound_of(squared.to_f64()));
        // Others may still read the motion that was measured before.
        worker.synchronise();
        let all = self.join(worker, Motion { most: free, change: pinned, ..Motion::default() });
        [all.most, all.change]
    }

    /// The motion of all workers. All call it, and again only after a barrier.
    pub(super) fn join(&self, worker: &Worker<'_, T>, own: Motion) -> Motion {
        self.motion.set(worker.index, [own.most, own.corners, own.change, own.far]);
        worker.synchronise();
        let motions =
            self.motion.iter().map(|[most, corners, change, far]| Motion { most, corners, change, far });
        motions.fold(Motion::default(), Motion::join)
    }

    /// Has nodes go at most `cap` [m] towards where they would end. Sets where they go from in later rounds.
    pub(super) fn go_part(&self, worker: &Worker<'_, T>, is_first: bool, cap: f64) {
        let cap = T::from_f64(cap);
        let next = worker.next();
        self.each_run(worker, |run| {
            for place in run {
                if is_first {
                    self.set_target(place, state_at(next, place));
                }
                let (from, target) = (self.get(&self.before, place), self.get(&self.target[..3], place));
                let way = sub(target, from);
                let length = dot(way, way).sqrt();
                let to = if length > cap { add(from, scale(way, cap / length)) } else { target };
                self.put(&next[..3], place, to);
                self.put(&self.after, place, to);
            }
        });
        worker.synchronise();
    }

    /// Starts another round of the filter where the last one has ended.
    pub(super) fn go_on(&self, worker: &Worker<'_, T>) {
        let next = positions(self.state(worker));
        self.each_run(worker, |run| {
            for (before, next) in self.before.iter().zip(next) {
                // SAFETY: its own places; others read after a barrier.
                let before = unsafe { before.write(run.clone()) };
                before.copy_from_slice(&next[run.clone()]);
            }
        });
        self.rest_corners(worker);
    }

    /// Corners of colliders stay where they are: they have gone all their way in the first round, or do not move.
    pub(super) fn rest_corners(&self, worker: &Worker<'_, T>) {
        for place in self.corners_of(worker) {
            self.put(&self.before, place, self.get(&self.after, place));
        }
    }

    pub(super) fn get(&self, columns: &[Shared<T>], place: usize) -> [T; 3] {
        // SAFETY: a worker's own place, or corner; others read after a barrier.
        std::array::from_fn(|axis| unsafe { *columns[axis].item(place) })
    }

    pub(super) fn put(&self, columns: &[Shared<T>], place: usize, x: [T; 3]) {
        for (column, x) in columns.iter().zip(x) {
            // SAFETY: as above.
            unsafe { *column.item(place) = x };
        }
    }

    /// The places of a worker's share of the corners of colliders.
    pub(super) fn corners_of(&self, worker: &Worker<'_, T>) -> Range<usize> {
        let own = worker.part(self.surfaces.corners().len());
        self.surfaces.places + own.start..self.surfaces.places + own.end
    }

    /// Does something with each run of a worker's places that have a surface.
    pub(super) fn each_run(&self, worker: &Worker<'_, T>, mut job: impl FnMut(Range<usize>)) {
        let has_surface = |run: &Range<usize>| self.surfaces.surface_of[run.start] != u32::MAX;
        for tile in &worker.nodes.tiles[worker.tiles.clone()] {
            tile.runs().map(|(_, run)| run).filter(has_surface).for_each(&mut job);
        }
    }
}
