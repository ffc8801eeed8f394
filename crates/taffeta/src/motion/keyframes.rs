//! Motion by keyframes: rigid for colliders, affine for pins; and scales over time, for loads.

use crate::scene::{Keyframe, Rotation, ScaleKey};
use glam::DQuat;

/// A motion over time: linear between keyframes, from rest at t = 0, staying after the last.
#[derive(Clone, Debug, Default)]
pub struct Track {
    keys: Vec<Keyframe>,
    /// The scene's keyframes, once the program moves it from frame to frame.
    of_scene: Option<Vec<Keyframe>>,
    /// When it comes to a halt for good [s].
    stays_from: Option<f64>,
}

/// Where a motion has brought things: x = rotation · deform · (x₀ − pivot) + pivot + translate.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pose {
    /// Rotation matrix, by rows; of pins times the matrix that deforms.
    pub rotation: [[f64; 3]; 3],
    /// Image of the origin [m].
    pub shift: [f64; 3],
}

impl Pose {
    /// No motion.
    pub const REST: Self =
        Self { rotation: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]], shift: [0.0; 3] };

    /// Image of a point [m].
    pub fn apply(&self, x: [f64; 3]) -> [f64; 3] {
        let turned = self.turn(x);
        std::array::from_fn(|i| turned[i] + self.shift[i])
    }

    /// Image of a direction.
    pub fn turn(&self, x: [f64; 3]) -> [f64; 3] {
        self.rotation.map(|row| row[0] * x[0] + row[1] * x[1] + row[2] * x[2])
    }

    /// The rigid motion from `before` to `self`: what carries a place from where it was to where it is.
    pub fn since(&self, before: &Self) -> Self {
        let rotation: [[f64; 3]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..3).map(|k| self.rotation[i][k] * before.rotation[j][k]).sum())
        });
        let shift = std::array::from_fn(|i| {
            let carried: f64 = (0..3).map(|j| rotation[i][j] * before.shift[j]).sum();
            self.shift[i] - carried
        });
        Self { rotation, shift }
    }

    /// Velocity field of the rigid motion from `before` to `self` in `h` seconds, as seen at the end:
    /// v(x) = spin · x + drift, where x moved from `before`(`self`⁻¹(x)).
    pub fn velocity_from(&self, before: &Self, h: f64) -> ([[f64; 3]; 3], [f64; 3]) {
        let back: [[f64; 3]; 3] = std::array::from_fn(|i| {
            std::array::from_fn(|j| (0..3).map(|k| before.rotation[i][k] * self.rotation[j][k]).sum())
        });
        let spin =
            std::array::from_fn(|i| std::array::from_fn(|j| (f64::from(u8::from(i == j)) - back[i][j]) / h));
        let drift = std::array::from_fn(|i| {
            let carried: f64 = (0..3).map(|j| back[i][j] * self.shift[j]).sum();
            (carried - before.shift[i]) / h
        });
        (spin, drift)
    }
}

impl Track {
    /// A motion through `keys`, whose times ascend.
    pub fn new(keys: &[Keyframe]) -> Self {
        let mut all = keys.to_vec();
        if all.first().is_some_and(|first| first.t > 0.0) {
            let first = &all[0];
            let rotate = first.rotate.map(|r| Rotation { degrees: 0.0, ..r });
            all.insert(0, Keyframe { rotate, pivot: first.pivot, ..Keyframe::default() });
        }
        Self { keys: all, ..Self::default() }
    }

    /// Whether keyframes say what comes after time `t` [s].
    pub fn goes_on_after(&self, t: f64) -> bool {
        self.of_scene.is_none() && self.keys.last().is_some_and(|last| last.t > t)
    }

    /// Goes from where it is at time `t` [s] to `to`, and stays there. Of several such wishes for one time the last counts.
    pub fn go_to(&mut self, t: f64, to: Keyframe) {
        let from = if self.is_wished(t) { self.keys.first() } else { self.keys.last() };
        let from = from.cloned().unwrap_or(Keyframe { rotate: to.rotate.map(still), ..Keyframe::default() });
        self.follow_program(vec![Keyframe { t, ..from }, to]);
    }

    /// Whether the program wants it to go on after time `t` [s].
    fn is_wished(&self, t: f64) -> bool {
        self.of_scene.is_some() && self.keys.len() > 1 && self.keys.last().is_some_and(|last| last.t > t)
    }

    fn follow_program(&mut self, keys: Vec<Keyframe>) {
        let before = std::mem::replace(&mut self.keys, keys);
        self.of_scene.get_or_insert(before);
    }

    /// Where the program has brought it at time `t` [s]; `None` where it follows the scene.
    pub fn brought(&self, t: f64) -> Option<&Keyframe> {
        self.of_scene.as_ref()?;
        let t = self.stays_from.map_or(t, |from| t.min(from));
        if self.is_wished(t) { self.keys.first() } else { self.keys.last() }
    }

    /// Puts it where the program had brought it, or has it follow the scene again.
    pub fn bring_back(&mut self, to: Option<&Keyframe>) {
        match to {
            Some(key) => self.follow_program(vec![key.clone()]),
            None => {
                if let Some(keys) = self.of_scene.take() {
                    self.keys = keys;
                }
            }
        }
    }

    /// Carries it along at once: from where it is at time `t` [s], first the turn about the origin, then the shift [m].
    pub fn carry(&mut self, t: f64, turn: Rotation, shift: [f64; 3]) {
        let from = if self.is_wished(t) { self.keys.first() } else { self.keys.last() };
        let from = from.cloned().unwrap_or_default();
        let whole = DQuat::from(turn) * from.rotate.map_or(DQuat::IDENTITY, DQuat::from);
        let by = pose(&Keyframe { rotate: Some(turn), translate: shift, ..Keyframe::default() });
        let center = by.apply(std::array::from_fn(|i| from.pivot[i] + from.translate[i]));
        let translate = std::array::from_fn(|i| center[i] - from.pivot[i]);
        self.follow_program(vec![Keyframe { t, translate, rotate: Some(whole.into()), ..from }]);
    }

    /// Has it stay for good where it is at a time [s], whatever the scene or the program want after that; or does not.
    pub fn stay_from(&mut self, time: Option<f64>) {
        self.stays_from = time;
    }

    /// Whether anything moves between two times [s].
    pub fn moves_over(&self, [from, to]: [f64; 2]) -> bool {
        self.pose(from) != self.pose(to) || self.turns_within([from, to]).next().is_some()
    }

    /// The times of its keyframes between two times [s].
    pub fn turns_within(&self, [from, to]: [f64; 2]) -> impl Iterator<Item = f64> {
        let to = self.stays_from.map_or(to, |stays| to.min(stays));
        self.keys.iter().map(|key| key.t).filter(move |&t| from < t && t < to)
    }

    /// Whether nothing moves.
    pub fn is_still(&self) -> bool {
        self.keys.is_empty()
    }

    /// The pose at time `t` [s].
    pub fn pose(&self, t: f64) -> Pose {
        let t = self.stays_from.map_or(t, |from| t.min(from));
        let Some(after) = self.keys.iter().position(|key| key.t > t) else {
            return self.keys.last().map_or(Pose::REST, pose);
        };
        if after == 0 {
            return pose(&self.keys[0]);
        }
        let (a, b) = (&self.keys[after - 1], &self.keys[after]);
        pose_of(a, b, (t - a.t) / (b.t - a.t))
    }
}

/// The pose of a keyframe.
pub fn pose(key: &Keyframe) -> Pose {
    pose_of(key, key, 0.0)
}

/// The pose a share `s` of the way from `a` to `b`.
fn pose_of(a: &Keyframe, b: &Keyframe, s: f64) -> Pose {
    let mix = |p: [f64; 3], q: [f64; 3]| -> [f64; 3] { std::array::from_fn(|i| p[i] + s * (q[i] - p[i])) };
    let (translate, pivot) = (mix(a.translate, b.translate), mix(a.pivot, b.pivot));
    let mut rotation = turn_between(a.rotate, b.rotate, s);
    if a.deform.is_some() || b.deform.is_some() {
        let [p, q] = [a, b].map(|key| key.deform.unwrap_or(Pose::REST.rotation));
        let deform: [[f64; 3]; 3] = std::array::from_fn(|i| mix(p[i], q[i]));
        rotation = rotation.map(|row| std::array::from_fn(|j| (0..3).map(|k| row[k] * deform[k][j]).sum()));
    }
    let moved = rotation.map(|row| row[0] * pivot[0] + row[1] * pivot[1] + row[2] * pivot[2]);
    Pose { rotation, shift: std::array::from_fn(|i| pivot[i] - moved[i] + translate[i]) }
}

/// About one axis angles are mixed (so a full turn is a full turn); between axes, quaternions the short way.
fn turn_between(a: Option<Rotation>, b: Option<Rotation>, s: f64) -> [[f64; 3]; 3] {
    let (a, b) = match (a, b) {
        (None, None) => return Pose::REST.rotation,
        (Some(a), None) => (a, still(a)),
        (None, Some(b)) => (still(b), b),
        (Some(a), Some(b)) => (a, b),
    };
    let (u, v) = (unit(a.axis), unit(b.axis));
    let same = (0..3).map(|i| u[i] * v[i]).sum::<f64>() > 1.0 - 1e-12;
    if same || a.degrees == 0.0 {
        let from = if same { a.degrees } else { 0.0 };
        return matrix(quaternion(v, from + s * (b.degrees - from)));
    }
    matrix(slerp(quaternion(u, a.degrees), quaternion(v, b.degrees), s))
}

/// No turn about the same axis.
fn still(rotation: Rotation) -> Rotation {
    Rotation { degrees: 0.0, ..rotation }
}

fn unit(a: [f64; 3]) -> [f64; 3] {
    let length = (a[0] * a[0] + a[1] * a[1] + a[2] * a[2]).sqrt();
    if length > 0.0 { a.map(|c| c / length) } else { [0.0, 1.0, 0.0] }
}

/// Quaternion [w, x, y, z] of a turn about a unit axis.
fn quaternion(axis: [f64; 3], degrees: f64) -> [f64; 4] {
    let half = degrees.to_radians() / 2.0;
    let (sine, cosine) = (libm::sin(half), libm::cos(half));
    [cosine, sine * axis[0], sine * axis[1], sine * axis[2]]
}

fn slerp(p: [f64; 4], q: [f64; 4], s: f64) -> [f64; 4] {
    let dot: f64 = (0..4).map(|i| p[i] * q[i]).sum();
    let q = if dot < 0.0 { q.map(|c| -c) } else { q };
    let angle = libm::acos(dot.abs().min(1.0));
    let (a, b) = if angle < 1e-9 {
        (1.0 - s, s)
    } else {
        let sine = libm::sin(angle);
        (libm::sin((1.0 - s) * angle) / sine, libm::sin(s * angle) / sine)
    };
    std::array::from_fn(|i| a * p[i] + b * q[i])
}

fn matrix([w, x, y, z]: [f64; 4]) -> [[f64; 3]; 3] {
    [
        [1.0 - 2.0 * (y * y + z * z), 2.0 * (x * y - w * z), 2.0 * (x * z + w * y)],
        [2.0 * (x * y + w * z), 1.0 - 2.0 * (x * x + z * z), 2.0 * (y * z - w * x)],
        [2.0 * (x * z - w * y), 2.0 * (y * z + w * x), 1.0 - 2.0 * (x * x + y * y)],
    ]
}

/// Scale of a load at time `t`: linear between keys, constant outside, 1 without keys.
pub fn scale_at(keys: &[ScaleKey], t: f64) -> f64 {
    let Some(after) = keys.iter().position(|key| key.t > t) else {
        return keys.last().map_or(1.0, |key| key.scale);
    };
    if after == 0 {
        return keys[0].scale;
    }
    let (a, b) = (&keys[after - 1], &keys[after]);
    a.scale + (b.scale - a.scale) * (t - a.t) / (b.t - a.t)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(a: [f64; 3], b: [f64; 3]) -> bool {
        a.iter().zip(b).all(|(p, q)| (p - q).abs() < 1e-12)
    }

    #[test]
    fn a_quarter_turn_about_a_pivot_is_half_done_half_way() {
        let track = Track::new(&[Keyframe::rotate(2.0, [0.0, 2.0, 0.0], 90.0, [1.0, 0.0, 0.0])]);
        assert!(near(track.pose(2.0).apply([2.0, 0.5, 0.0]), [1.0, 0.5, -1.0]));
        let c = std::f64::consts::FRAC_1_SQRT_2;
        assert!(near(track.pose(1.0).apply([2.0, 0.5, 0.0]), [1.0 + c, 0.5, -c]));
        assert!(near(track.pose(9.0).apply([1.0, 7.0, 0.0]), [1.0, 7.0, 0.0]));
    }

    #[test]
    fn a_matrix_deforms_before_the_turn_and_leaves_the_pivot_in_place() {
        let deform = [[3.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 1.0, 1.0]];
        let turn = Keyframe::rotate(2.0, [0.0, 1.0, 0.0], 90.0, [1.0, 0.0, 0.0]);
        let track = Track::new(&[Keyframe { deform: Some(deform), ..turn }]);
        assert!(near(track.pose(2.0).apply([1.0, 0.0, 0.0]), [1.0, 0.0, 0.0]));
        // (1, 2, 0) from the pivot becomes (3, 2, 2), and x turns to −z, z to x.
        assert!(near(track.pose(2.0).apply([2.0, 2.0, 0.0]), [3.0, 2.0, -3.0]));
        // Half way: (2, 2, 1), turned by 45°.
        let c = std::f64::consts::FRAC_1_SQRT_2;
        assert!(near(track.pose(1.0).apply([2.0, 2.0, 0.0]), [1.0 + 3.0 * c, 2.0, -c]));
        // A key without one goes back.
        let track =
            Track::new(&[Keyframe::deform(1.0, deform, [0.0; 3]), Keyframe::translate(2.0, [0.0; 3])]);
        assert_eq!([1.0, 1.5, 2.0].map(|t| track.pose(t).apply([1.0, 0.0, 0.0])[0]), [3.0, 2.0, 1.0]);
    }

    #[test]
    fn a_full_turn_passes_the_half_turn() {
        let track = Track::new(&[Keyframe::rotate(1.0, [0.0, 0.0, 1.0], 360.0, [0.0; 3])]);
        assert!(near(track.pose(0.5).apply([1.0, 0.0, 0.0]), [-1.0, 0.0, 0.0]));
    }

    #[test]
    fn velocity_carries_the_old_place_to_the_new() {
        let track = Track::new(&[Keyframe {
            t: 1.0,
            translate: [1.0, 2.0, 3.0],
            rotate: Some(Rotation { axis: [1.0, 1.0, 0.0], degrees: 50.0 }),
            pivot: [0.3, 0.0, 0.0],
            deform: None,
        }]);
        let (before, after, h) = (track.pose(0.4), track.pose(0.5), 0.1);
        let (spin, drift) = after.velocity_from(&before, h);
        let x0 = [0.7, -0.2, 0.9];
        let (x1, x2) = (before.apply(x0), after.apply(x0));
        let v: [f64; 3] =
            std::array::from_fn(|i| spin[i].iter().zip(x2).map(|(s, x)| s * x).sum::<f64>() + drift[i]);
        assert!(near(v, std::array::from_fn(|i| (x2[i] - x1[i]) / h)));
    }

    #[test]
    fn what_a_program_moves_goes_straight_on_from_where_it_was() {
        let at = |t, x| Keyframe::translate(t, [x, 0.0, 0.0]);
        let mut track = Track::default();
        track.go_to(1.0, at(1.5, 9.0));
        track.go_to(1.0, at(1.5, 2.0));
        assert_eq!([1.0, 1.25, 7.0].map(|t| track.pose(t).shift[0]), [0.0, 1.0, 2.0]);
        track.go_to(1.5, at(2.0, 4.0));
        assert_eq!([1.5, 1.75, 2.0].map(|t| track.pose(t).shift[0]), [2.0, 3.0, 4.0]);
        assert!(!track.goes_on_after(1.5) && Track::new(&[at(3.0, 1.0)]).goes_on_after(1.5));
    }

    #[test]
    fn what_stays_for_good_goes_nowhere() {
        let mut track = Track::new(&[Keyframe::translate(2.0, [4.0, 0.0, 0.0])]);
        track.stay_from(Some(0.5));
        assert_eq!([0.25, 0.5, 1.0, 9.0].map(|t| track.pose(t).shift[0]), [0.5, 1.0, 1.0, 1.0]);
        track.go_to(3.0, Keyframe::translate(3.5, [7.0, 0.0, 0.0]));
        track.stay_from(None);
        assert_eq!(track.pose(3.5).shift[0], 7.0);
    }

    #[test]
    fn scales_are_linear_between_keys_and_constant_outside() {
        let keys = [ScaleKey { t: 1.0, scale: 2.0 }, ScaleKey { t: 3.0, scale: 4.0 }];
        assert_eq!([0.0, 2.0, 9.0].map(|t| scale_at(&keys, t)), [2.0, 3.0, 4.0]);
        assert_eq!(scale_at(&[], 5.0), 1.0);
    }
}
