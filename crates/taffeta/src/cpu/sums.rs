//! Sums in an order that depends on neither threads nor vector width.

use crate::real::Real;
use crate::topology::LANES;

/// Sixteen sums side by side.
#[derive(Clone, Copy)]
pub struct Sums<T>([T; LANES]);

impl<T: Real> Sums<T> {
    /// Of nothing.
    pub const ZERO: Self = Self([T::ZERO; LANES]);

    /// Adds a·b of up to sixteen numbers.
    #[inline(always)]
    pub fn add(&mut self, a: &[T], b: &[T]) {
        for ((sum, &a), &b) in self.0.iter_mut().zip(a).zip(b) {
            *sum += a * b;
        }
    }

    /// The sum of a·b over all numbers.
    #[inline(always)]
    pub fn of(a: &[T], b: &[T]) -> f64 {
        let mut sums = Self::ZERO;
        // Where their number is known, lanes stay in registers.
        let ((a, last_a), (b, last_b)) = (a.as_chunks::<LANES>(), b.as_chunks::<LANES>());
        a.iter().zip(b).for_each(|(a, b)| sums.add(a, b));
        sums.add(last_a, last_b);
        sums.total()
    }

    /// The sum of all.
    #[inline(always)]
    pub fn total(&self) -> f64 {
        let mut sum = 0.0;
        for lane in self.0 {
            sum += lane.to_f64();
        }
        sum
    }
}
