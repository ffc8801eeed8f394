//! Sums in f64, in an order that depends on neither threads nor vector width.

use crate::topology::LANES;

/// 16 sums side by side, added up in order at the end.
#[derive(Clone, Copy)]
pub struct Lanes(pub [f64; LANES]);

impl Lanes {
    /// Of nothing.
    pub const ZERO: Self = Self([0.0; LANES]);

    /// The sum of all, in order.
    #[inline(always)]
    pub fn total(&self) -> f64 {
        let mut sum = 0.0;
        for lane in self.0 {
            sum += lane;
        }
        sum
    }

    /// The largest of all.
    #[inline(always)]
    pub fn largest(&self) -> f64 {
        let mut largest = 0.0;
        for lane in self.0 {
            largest = if lane > largest { lane } else { largest };
        }
        largest
    }
}
