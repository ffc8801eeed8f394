//! Moving pins: by keyframes, or by the user.
//!
//! Motions are evaluated in 64 bits ([`crate::motion::keyframes`]). A sub-step is told the pose at its end and the rate at which
//! it was reached, (R₁ − R₀)/h and (s₁ − s₀)/h: in 32 bits, the difference of two rounded places over a short step
//! would be mostly noise.

use crate::motion::keyframes::Pose;
use crate::real::{Real, add, dot, scale, sub};

/// How many units in the last place of its coordinates a node may be off its way before it is taken to lag.
pub const WAY_ULPS: f64 = 32.0;

/// A pose x = R x₀ + s at the end of a sub-step, by rows (R, s), and its rate.
#[derive(Clone, Copy, Debug)]
pub struct Motion<T> {
    /// Rows; the last number of each in [m].
    pub place: [[T; 4]; 3],
    /// Rows [1/s]; the last number of each in [m/s].
    pub rate: [[T; 4]; 3],
}

impl<T: Real> Motion<T> {
    /// The motion that ends a step of `seconds` at `after`, having been at `before`.
    pub fn new(before: &Pose, after: &Pose, seconds: f64) -> Self {
        let row = |pose: &Pose, i: usize| {
            let [a, b, c] = pose.rotation[i];
            [a, b, c, pose.shift[i]]
        };
        let rate = |i: usize| {
            let (from, to) = (row(before, i), row(after, i));
            std::array::from_fn(|j| T::from_f64((to[j] - from[j]) / seconds))
        };
        Self {
            place: std::array::from_fn(|i| row(after, i).map(T::from_f64)),
            rate: std::array::from_fn(rate),
        }
    }

    /// Place [m] and velocity [m/s] of a node that starts at `start` [m].
    pub fn apply(&self, start: [T; 3]) -> ([T; 3], [T; 3]) {
        (affine(&self.place, start), affine(&self.rate, start))
    }
}

fn affine<T: Real>(rows: &[[T; 4]; 3], p: [T; 3]) -> [T; 3] {
    rows.map(|[a, b, c, s]| (a * p[0] + b * p[1] + c * p[2]) + s)
}

/// Place [m] and velocity [m/s] on the straight way from one place to another, when a `fraction` of the frame has gone by,
/// at `rate` shares a second.
pub fn on_the_way<T: Real>(from: [T; 3], to: [T; 3], fraction: T, rate: T) -> ([T; 3], [T; 3]) {
    (add(scale(from, T::ONE - fraction), scale(to, fraction)), scale(sub(to, from), rate))
}

/// The velocity [m/s] of a node that its pin wants at `place` after a step of `h` [s], by a motion of `velocity` that began at
/// `start`. Where surfaces have held the node back, at `before` and not on its way, it is that which makes up for it: springs
/// and contacts that are solved for then pull and push what is in its way along.
pub fn catching_up<T: Real>(
    (place, velocity): ([T; 3], [T; 3]),
    start: [T; 3],
    before: [T; 3],
    h: T,
) -> [T; 3] {
    let lag = sub(sub(place, scale(velocity, h)), before);
    let rounding = T::from_f64(WAY_ULPS) * T::EPSILON;
    if dot(lag, lag) > rounding * rounding * (dot(start, start) + dot(place, place)) {
        sub(place, before).map(|way| way / h)
    } else {
        velocity
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::motion::keyframes::Track;
    use crate::scene::Keyframe;

    #[test]
    fn places_follow_the_pose_and_velocities_are_their_differences() {
        let track = Track::new(&[Keyframe::rotate(1.0, [0.0, 1.0, 1.0], 80.0, [0.3, 0.0, 0.1])]);
        let (before, after, h) = (track.pose(0.5), track.pose(0.51), 0.01);
        let (x, v) = Motion::<f64>::new(&before, &after, h).apply([1.0, 2.0, -0.5]);
        let (from, to) = (before.apply([1.0, 2.0, -0.5]), after.apply([1.0, 2.0, -0.5]));
        for axis in 0..3 {
            assert!((x[axis] - to[axis]).abs() < 1e-15);
            assert!((v[axis] - (to[axis] - from[axis]) / h).abs() < 1e-12);
        }
    }

    #[test]
    fn velocities_in_32_bits_have_no_noise_from_a_short_step() {
        let track = Track::new(&[Keyframe::translate(1.0, [1.0, 0.0, 0.0])]);
        let h = 1e-5;
        let motion = Motion::<f32>::new(&track.pose(0.5), &track.pose(0.5 + h), h);
        assert!((motion.apply([7.0, 0.0, 0.0]).1[0] - 1.0).abs() < 1e-6);
    }

    #[test]
    fn only_who_lags_goes_faster_than_its_motion() {
        let (start, h) = ([3.0_f32, -2.0, 0.5], 1e-3);
        let velocity = [0.3, 0.1, -0.2];
        let before = [0.7, 0.1, 0.2_f32];
        let place = add(before, scale(velocity, h));
        let rounded = add(before, [1e-6, -1e-6, 1e-6]);
        assert_eq!(catching_up((place, velocity), start, rounded, h), velocity, "a few roundings are no lag");
        let behind = sub(before, [0.01, 0.0, 0.0]);
        let [x, y, z] = catching_up((place, velocity), start, behind, h);
        assert!((x - 10.3).abs() < 1e-3 && (y - 0.1).abs() < 1e-3 && (z + 0.2).abs() < 1e-3, "{x} {y} {z}");
        let at_rest = catching_up((before, [0.0; 3]), start, behind, h);
        assert!((at_rest[0] - 10.0).abs() < 1e-3, "the motion is over, and the node not there: {at_rest:?}");
    }

    #[test]
    fn a_way_begins_and_ends_exactly_where_it_should() {
        let (from, to) = ([0.1_f32, 7.7, -3.3], [0.7_f32, -0.3, 1e-7]);
        assert_eq!(on_the_way(from, to, 1.0, 60.0).0, to);
        assert_eq!(on_the_way(from, to, 0.0, 60.0).0, from);
        assert_eq!(on_the_way([1.0; 3], [2.0; 3], 0.5, 60.0), ([1.5; 3], [60.0; 3]));
    }
}
