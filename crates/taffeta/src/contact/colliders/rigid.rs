//! Rigid motions of colliders.

use crate::motion::keyframes::Pose;
use crate::real::{Real, add, dot, sub};

/// A rigid motion: rows of the rotation, and the image of the origin [m].
#[derive(Clone, Copy, Debug)]
pub struct Rigid<T> {
    pub rows: [[T; 3]; 3],
    pub shift: [T; 3],
}

impl<T: Real> Rigid<T> {
    /// The motion of a pose, in a backend's numbers.
    pub fn of(pose: &Pose) -> Self {
        Self { rows: pose.rotation.map(|row| row.map(T::from_f64)), shift: pose.shift.map(T::from_f64) }
    }

    /// The identity.
    pub fn rest() -> Self {
        Self::of(&Pose::REST)
    }

    /// Image of a place [m].
    #[inline(always)]
    pub fn apply(&self, x: [T; 3]) -> [T; 3] {
        let [a, b, c] = self.rows;
        add([dot(a, x), dot(b, x), dot(c, x)], self.shift)
    }

    /// The inverse image of a position [m].
    #[inline(always)]
    pub fn back(&self, x: [T; 3]) -> [T; 3] {
        let d = sub(x, self.shift);
        let [a, b, c] = self.rows;
        let along = |i: usize| a[i] * d[0] + b[i] * d[1] + c[i] * d[2];
        [along(0), along(1), along(2)]
    }

    /// Image of a direction.
    #[inline(always)]
    pub fn turn(&self, x: [T; 3]) -> [T; 3] {
        let [a, b, c] = self.rows;
        [dot(a, x), dot(b, x), dot(c, x)]
    }
}
