//! Where leaves are, as frames that turn along, and how their nodes move in these.
//!
//! The distance of two leaves does not change where both turn together. So a bound of how near they may have come since they
//! were last looked at compares the frame of the second, seen from the first, with what it was then, and adds what nodes have
//! moved in their frames. Cloth that swings thus needs to be looked at far less often than it moves. Where nodes tremble, a bound
//! by how leaves have moved against each other, without any turn, is less.

use crate::real::{Real, add, cross, dot, scale, sub};
use crate::topology::LANES;

/// The frame of a leaf.
#[derive(Clone, Copy, Debug)]
pub struct Pose<T> {
    /// The mean of its nodes [m], and unit vectors.
    origin: [T; 3],
    axes: [[T; 3]; 3],
    /// Distance of its nodes from the origin [m].
    radius: T,
    /// How far nodes have moved in frames like this, in all [m].
    drift: f64,
    /// How all nodes have moved, and how far from that each may have, in all [m].
    moved: [f64; 4],
}

impl<T: Real> Pose<T> {
    /// No frame yet.
    pub const NONE: Self = Self {
        origin: [T::ZERO; 3],
        axes: [[T::ONE, T::ZERO, T::ZERO], [T::ZERO, T::ONE, T::ZERO], [T::ZERO, T::ZERO, T::ONE]],
        radius: T::ZERO,
        drift: 0.0,
        moved: [0.0; 4],
    };

    /// Follows nodes that are at `now` [m], whose sums by `weights` are the frame, and which have moved by `by` since, as
    /// [`motion`](crate::contact::clusters::packed::motion) defines it [m]. `local` are their positions in the frame.
    #[inline(always)]
    pub fn follow(
        &mut self,
        now: &[[T; LANES]; 3],
        by: &[f64; 4],
        weights: &[[T; LANES]; 3],
        local: &mut [[T; LANES]; 3],
    ) {
        for (moved, by) in self.moved.iter_mut().zip(by) {
            *moved += by;
        }
        let first = [now[0][0], now[1][0], now[2][0]];
        let [origin, one, other] = sums(now, first, weights);
        self.origin = add(first, origin);
        self.axes = axes(one, other);
        let (mut far, mut moved) = ([T::ZERO; LANES], [T::ZERO; LANES]);
        for (axis, local) in local.iter_mut().enumerate() {
            let [x, y, z] = self.axes[axis];
            for lane in 0..LANES {
                let way = sub([now[0][lane], now[1][lane], now[2][lane]], self.origin);
                let along = way[0] * x + way[1] * y + way[2] * z;
                let by = along - local[lane];
                far[lane] += along * along;
                moved[lane] += by * by;
                local[lane] = along;
            }
        }
        let mut lost = false;
        for moved in &moved {
            let is_known = *moved < T::FAR;
            lost |= !is_known;
        }
        let mut half = LANES / 2;
        while half > 0 {
            for lane in 0..half {
                far[lane] = if far[lane + half] > far[lane] { far[lane + half] } else { far[lane] };
                moved[lane] = if moved[lane + half] > moved[lane] { moved[lane + half] } else { moved[lane] };
            }
            half /= 2;
        }
        self.radius = far[0].sqrt();
        // With a margin for rounding.
        let by = moved[0].sqrt().to_f64() * 1.0001 + self.radius.to_f64() * 1e-6;
        self.drift += if lost { f64::INFINITY } else { by };
    }
}

/// Weights of the nodes of a leaf, which lie at `x` [m] at the start, by lane: what positions give with them is the leaf's frame,
/// the mean of all, and two vectors along which it lies. All nodes take part, so that the frame does not follow each that trembles.
pub fn weights(x: &[[f64; 3]]) -> [[f64; LANES]; 3] {
    let share = 1.0 / x.len() as f64;
    let middle = x.iter().fold([0.0; 3], |sum, &x| add(sum, scale(x, share)));
    let ways: Vec<[f64; 3]> = x.iter().map(|&x| sub(x, middle)).collect();
    let farthest = |measure: &dyn Fn([f64; 3]) -> f64| {
        ways.iter().copied().max_by(|&a, &b| measure(a).total_cmp(&measure(b))).unwrap_or_default()
    };
    let squared = |way: [f64; 3]| dot(way, way).max(f64::MIN_POSITIVE);
    let one = farthest(&squared);
    let off = |way: [f64; 3]| sub(way, scale(one, dot(way, one) / squared(one)));
    let other = off(farthest(&|way| squared(off(way))));
    let mut weights = [[0.0; LANES]; 3];
    for (lane, &way) in ways.iter().enumerate() {
        weights[0][lane] = share;
        weights[1][lane] = share * dot(way, one) / squared(one);
        weights[2][lane] = share * dot(way, other) / squared(other);
    }
    weights
}

/// Sums of positions, as seen from a place, by rows of weights.
#[inline(always)]
fn sums<T: Real>(x: &[[T; LANES]; 3], from: [T; 3], weights: &[[T; LANES]; 3]) -> [[T; 3]; 3] {
    let mut all = [[T::ZERO; 3]; 3];
    for (sum, weights) in all.iter_mut().zip(weights) {
        for ((sum, x), from) in sum.iter_mut().zip(x).zip(from) {
            let mut parts = [T::ZERO; LANES];
            for lane in 0..LANES {
                parts[lane] = (x[lane] - from) * weights[lane];
            }
            let mut half = LANES / 2;
            while half > 0 {
                for lane in 0..half {
                    parts[lane] += parts[lane + half];
                }
                half /= 2;
            }
            *sum = parts[0];
        }
    }
    all
}

/// Unit vectors, the first along `one`, the second in the plane of both; those of the scene if there is no such plane.
#[inline(always)]
fn axes<T: Real>(one: [T; 3], other: [T; 3]) -> [[T; 3]; 3] {
    let normal = cross(one, other);
    let (long, wide) = (dot(one, one), dot(normal, normal));
    let is_plane = wide > T::from_f64(1e-8) * long * dot(other, other) && wide > T::TINY;
    let [x, _, z] = Pose::<T>::NONE.axes;
    let (one, normal) = (if is_plane { one } else { x }, if is_plane { normal } else { z });
    let (long, wide) = (if is_plane { long } else { T::ONE }, if is_plane { wide } else { T::ONE });
    let first = scale(one, T::ONE / long.sqrt());
    let third = scale(normal, T::ONE / wide.sqrt());
    [first, cross(third, first), third]
}

/// How two leaves were to each other when they were last looked at.
#[derive(Clone, Copy, Debug)]
pub struct Then<T> {
    /// The frame of the second, seen from the first [m], and how far nodes of both had moved in their frames [m].
    origin: [T; 3],
    axes: [[T; 3]; 3],
    drift: f64,
    /// How the second had moved against the first, and how far from that nodes of both may have [m].
    moved: [f64; 4],
}

impl<T: Real> Then<T> {
    /// How they are now.
    pub fn new(a: &Pose<T>, b: &Pose<T>) -> Self {
        let (origin, axes) = seen_from(a, b);
        Self { origin, axes, drift: a.drift + b.drift, moved: moved_against(a, b) }
    }

    /// By how much the distance of any of their nodes may have changed [m].
    #[inline]
    pub fn changed(&self, a: &Pose<T>, b: &Pose<T>) -> f64 {
        let moved = moved_against(a, b);
        let by = sub([moved[0], moved[1], moved[2]], [self.moved[0], self.moved[1], self.moved[2]]);
        let straight = dot(by, by).sqrt() + (moved[3] - self.moved[3]);
        let (origin, axes) = seen_from(a, b);
        let by = sub(origin, self.origin);
        let mut turned = T::ZERO;
        for (now, then) in axes.into_iter().zip(self.axes) {
            let by = sub(now, then);
            turned += dot(by, by);
        }
        // A turn moves what is a metre from its axis by the root of half the sum of what it changes.
        let turned = (turned * T::from_f64(0.5001)).sqrt();
        let by = dot(by, by).sqrt().to_f64() + (turned * b.radius).to_f64();
        // With a margin for the rounding of frames.
        let rounding = 1e-6 * (origin[0].abs() + origin[1].abs() + origin[2].abs() + b.radius).to_f64();
        let turned = by + rounding + (a.drift + b.drift - self.drift);
        // Where nodes tremble this is less, and where leaves turn together that.
        if straight < turned { straight } else { turned }
    }
}

/// How `b` has moved against `a`, in all, and how far from that their nodes may have [m].
#[inline]
fn moved_against<T>(a: &Pose<T>, b: &Pose<T>) -> [f64; 4] {
    let [x, y, z] = [0, 1, 2].map(|axis| b.moved[axis] - a.moved[axis]);
    [x, y, z, a.moved[3] + b.moved[3]]
}

/// The frame of `b` seen from `a`.
#[inline]
fn seen_from<T: Real>(a: &Pose<T>, b: &Pose<T>) -> ([T; 3], [[T; 3]; 3]) {
    let from = |x: [T; 3]| [dot(a.axes[0], x), dot(a.axes[1], x), dot(a.axes[2], x)];
    (from(sub(b.origin, a.origin)), b.axes.map(from))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::clusters::packed::motion;
    use crate::real::{add, norm};
    use crate::topology::random::SplitMix64;

    /// Leaves that turn together, and a little against each other, and tremble: no distance of their nodes changes by more than
    /// the bound says, and the bound is small where they turn together.
    #[test]
    fn no_distance_changes_by_more_than_the_bound() {
        let mut random = SplitMix64::new(3);
        let mut vector = |size: f64| [0, 1, 2].map(|_| size * (2.0 * random.unit() - 1.0));
        let mut leaves: [Vec<[f64; 3]>; 2] = std::array::from_fn(|side| {
            (0..LANES).map(|_| add(vector(0.05), [0.2 * side as f64 + 3.0, 1.0, -2.0])).collect()
        });
        for (tremble, moves) in [(0.0, 1.0), (1e-5, 1.0), (1e-3, 1.0), (1e-3, 0.0)] {
            let mut poses = [Pose::<f32>::NONE; 2];
            let weights = leaves.each_ref().map(|leaf| weights(leaf).map(|row| row.map(|one| one as f32)));
            let (mut local, mut before) = ([[[0.0; LANES]; 3]; 2], [[[0.0; LANES]; 3]; 2]);
            let mut follow = |leaves: &[Vec<[f64; 3]>; 2]| {
                let mut now = [[[0.0; LANES]; 3]; 2];
                for (now, leaf) in now.iter_mut().zip(leaves) {
                    for (lane, x) in leaf.iter().enumerate() {
                        (0..3).for_each(|axis| now[axis][lane] = x[axis] as f32);
                    }
                }
                for side in 0..2 {
                    let by = motion(&now[side], &before[side], LANES);
                    poses[side].follow(&now[side], &by, &weights[side], &mut local[side]);
                }
                before = now;
                poses
            };
            let distances = |leaves: &[Vec<[f64; 3]>; 2]| -> Vec<f64> {
                leaves[0].iter().flat_map(|&a| leaves[1].iter().map(move |&b| norm(sub(a, b)))).collect()
            };
            let [a, b] = follow(&leaves);
            let (then, before) = (Then::new(&a, &b), distances(&leaves));
            for _ in 0..50 {
                let (spin, push) = ([0.01, 0.02, -0.015].map(|by| moves * by), vector(0.05 * moves));
                for leaf in &mut leaves {
                    let more = vector(tremble);
                    for x in leaf.iter_mut() {
                        let turned = add(*x, cross(add(spin, scale(more, 0.1 * moves)), *x));
                        // The length of an infinitesimal turn grows; this undoes it.
                        *x = add(add(scale(turned, norm(*x) / norm(turned)), push), vector(tremble));
                    }
                }
                let [a, b] = follow(&leaves);
                let changed =
                    distances(&leaves).into_iter().zip(&before).map(|(now, then)| (now - then).abs());
                let (most, bound) = (changed.fold(0.0, f64::max), then.changed(&a, &b));
                assert!(most <= bound, "{most} {bound}");
                assert!(tremble > 0.0 || bound < 0.03, "{bound}");
            }
        }
    }

    #[test]
    fn needles_and_points_have_a_frame_too() {
        for nodes in [[[1.0; LANES]; 3], std::array::from_fn(|_| std::array::from_fn(|lane| lane as f64))] {
            let x: Vec<[f64; 3]> =
                (0..LANES).map(|lane| nodes.map(|axis: [f64; LANES]| axis[lane])).collect();
            let weights = weights(&x);
            let (mut pose, mut local) = (Pose::<f64>::NONE, [[0.0; LANES]; 3]);
            pose.follow(&nodes, &[0.0; 4], &weights, &mut local);
            let drift = pose.drift;
            pose.follow(&nodes, &[0.0; 4], &weights, &mut local);
            assert!(drift.is_finite() && pose.drift - drift < 1e-4, "{pose:?}");
        }
    }
}
