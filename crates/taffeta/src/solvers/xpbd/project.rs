//! How far a spring, or a limit between two nodes of a coarser level, moves its ends.
//!
//! Miles Macklin, Matthias Müller, Nuttapong Chentanez, "XPBD: Position-Based Simulation of Compliant Constrained
//! Dynamics", MIG 2016, eq. 18 and 26, with one iteration a sub-step (Macklin et al., "Small Steps in Physics Simulation",
//! SCA 2019), so that multipliers start from 0. The square root of a length l is replaced by its first two terms around the length
//! at rest, as in Thomas Jakobsen, "Advanced Character Physics", GDC 2001: l ≈ (l² + L²)/(2L).

use crate::real::Real;

/// Damping, relative to a mass, that takes nearly all motion along a spring: more would only resist what limits do, until cloth blows up.
const DAMPED: f64 = 8.0;

/// The spring constants of a sub-step of length h: k h² and d h [kg].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stiffness<T> {
    pub elastic: T,
    pub damping: T,
}

impl<T: Real> Stiffness<T> {
    /// Of stiffness [N/m] and damping [kg/s] in a sub-step [s], shared evenly by so many sweeps: springs that yield are as stiff with any
    /// number of them. Damping counts up to [`DAMPED`] times the mass of the lightest node [kg].
    pub fn new([k, d]: [f64; 2], h: f64, sweeps: usize, lightest: f64) -> Self {
        let share = 1.0 / sweeps as f64;
        let damping = (share * d * h).min(DAMPED * lightest);
        Self { elastic: T::from_f64(share * k * h * h), damping: T::from_f64(damping) }
    }

    /// What both ends of a spring are moved by, divided by their inverse masses and along the vector d between them [kg]: the first
    /// forwards, the second backwards. `squared` is |d|², `rest` L² [m²], `inverse_mass` the sum of both ends [1/kg], and `change` d·(d − d₀),
    /// where d₀ was the vector at the start of the sub-step [m²].
    ///
    /// (k h² (|d|² − L²)/(|d|² + L²) + d h d·(d − d₀)/|d|²) / (1 + (k h² + d h) w)
    #[inline(always)]
    pub fn pull(self, squared: T, rest: T, inverse_mass: T, change: T) -> T {
        let Self { elastic, damping } = self;
        let both = squared + rest;
        let rate = if squared > T::ZERO { change / squared } else { T::ZERO };
        let pull = elastic * (squared - rest) + damping * rate * both;
        pull / (both * ((elastic + damping) * inverse_mass + T::ONE))
    }

    /// The same without damping.
    #[inline(always)]
    pub fn undamped(self, squared: T, rest: T, inverse_mass: T) -> T {
        self.elastic * (squared - rest) / ((squared + rest) * (self.elastic * inverse_mass + T::ONE))
    }
}

/// The same for a limit, which is rigid, and acts only where its ends are too far apart: (|d|² − L²) / ((|d|² + L²) w).
#[inline(always)]
pub fn limit<T: Real>(squared: T, rest: T, inverse_mass: T) -> T {
    let pull = (squared - rest) / ((squared + rest) * inverse_mass);
    if squared > rest && inverse_mass > T::ZERO { pull } else { T::ZERO }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Distance of two nodes of 1/w kg each after a correction.
    fn after(distance: f64, pull: f64, w: f64) -> f64 {
        distance * (1.0 - 2.0 * w * pull)
    }

    #[test]
    fn a_rigid_limit_closes_all_of_a_small_stretch_and_nothing_else() {
        let w = 5.0;
        for stretch in [1e-3, 1e-2] {
            let distance: f64 = 0.3 * (1.0 + stretch);
            let left = after(distance, limit(distance * distance, 0.09, 2.0 * w), w) / 0.3 - 1.0;
            // The root is exact to second order.
            assert!(left.abs() < stretch * stretch, "{left} of {stretch}");
        }
        assert_eq!(limit(0.0899, 0.09, 2.0 * w), 0.0);
        assert_eq!(limit(0.0901, 0.09, 0.0), 0.0);
    }

    #[test]
    fn a_spring_bears_a_load_at_its_own_stretch() {
        // In each sub-step gravity opens a spring by g h², and it closes by as much, at the stretch m g/k.
        let (m, k, h, rest) = (0.02, 400.0, 1e-3, 0.5);
        let stiffness = Stiffness::<f64>::new([k, 0.0], h, 1, m);
        let fall = 9.81 * h * h;
        let before = rest + m * 9.81 / k + fall;
        let pull = stiffness.pull(before * before, rest * rest, 1.0 / m, 0.0);
        let closed = before * pull / m;
        assert!((closed / fall - 1.0).abs() < 2e-3, "{closed} of {fall}");
    }

    #[test]
    fn damping_takes_from_what_has_changed() {
        // No stretch, ends that have come apart by 1 mm: of it damping takes 2 w d h/(1 + 2 w d h).
        let (d, h, w, rest) = (0.3, 0.01, 4.0, 0.5);
        let stiffness = Stiffness::<f64>::new([0.0, d], h, 1, 0.25);
        let change = rest * 1e-3;
        let pull = stiffness.pull(rest * rest, rest * rest, 2.0 * w, change);
        let taken = 2.0 * w * pull * rest;
        let share = 2.0 * w * d * h / (1.0 + 2.0 * w * d * h);
        assert!((taken - 1e-3 * share).abs() < 1e-15, "{taken}");
    }

    #[test]
    fn damping_takes_at_most_what_there_is_however_long_the_spring() {
        // Ends that come apart at ten times the length at rest keep some of that, with any damping.
        let (rest, before, now) = (0.01_f64, 0.1, 0.11);
        for d in [1.0, 1e3, 1e6] {
            let stiffness = Stiffness::<f64>::new([0.0, d], 0.01, 1, 0.02);
            let w = 50.0;
            let pull = stiffness.pull(now * now, rest * rest, 2.0 * w, now * (now - before));
            let taken = 2.0 * w * pull * now;
            assert!(taken > 0.0 && taken <= (now - before) * (1.0 + 1e-12), "{taken}");
        }
    }

    #[test]
    fn ends_at_one_place_stay_finite() {
        let stiffness = Stiffness::<f32>::new([1e9, 0.1], 1e-2, 1, 1e-6);
        assert!(stiffness.pull(0.0, 0.01, 0.0, 0.0).is_finite());
        assert!(stiffness.pull(1e18, 1e-8, 2e6, 1e18).is_finite());
    }
}
