//! The step in time of second order: Bossak's form of Newmark's method.
//!
//! Source: Wood, Bossak, Zienkiewicz, "An alpha modification of Newmark's method", International Journal for Numerical
//! Methods in Engineering 15, 1980. With velocity v, an acceleration a that each node remembers, and μ > 0:
//!
//! (1 + μ) a⁺ − μ a = w f(x⁺, v⁺) + what acts from outside,
//! v⁺ = v + h ((1 − γ) a + γ a⁺),    x⁺ = x + h v + h² ((½ − β) a + β a⁺),    γ = ½ + μ,    β = (1 + μ)²/4.
//!
//! In the velocity u = v⁺ this is a step of implicit Euler of another length from another state: with h' = h β/γ and
//! h″ = h γ/(1 + μ),
//!
//! M (u − ṽ) = h″ f(x̃ + h' u, u),    x⁺ = x̃ + h' u,
//! x̃ = x + (h − h') v + h² (½ − β − (1 − γ) β/γ) a,    ṽ = v + h (1 − γ + γ μ/(1 + μ)) a.
//!
//! Times h'/h″ it is the system of implicit Euler over h' with masses times h'/h″. Collisions are velocities that change at
//! once, and no part of a (Chen, Acary, Virlez, Brüls, "A nonsmooth generalized-α scheme for flexible multibody systems with
//! unilateral constraints", 2013).

use crate::assembly::Assembly;
use crate::plan::Substep;
use crate::real::{Real, add, scale, sub};

/// What a step leaves of an oscillation that is much shorter than it: the spectral radius at infinity.
const LEFT: f64 = 0.5;

/// Share of a first sub-step that is a step of its own: by implicit Euler, to find the acceleration at the start.
const FIRST: f64 = 1.0 / 64.0;

/// The numbers of a sub-step of second order.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scheme<T> {
    /// h' [s]: nodes come to x̃ + h' u.
    pub h: T,
    /// h'/h″: what masses are multiplied by.
    pub mass: T,
    /// What x̃ has of the velocity [s] and of the acceleration [s²].
    pub place: [T; 2],
    /// What ṽ has of the acceleration [s].
    pub velocity: T,
    /// h″/h: the share that outer forces have at the end of the step.
    pub outer: T,
    /// What a⁺ has of the change of velocity [1/s], and of the acceleration before.
    pub rate: [T; 2],
    /// h/h': springs' impulse in the whole step by that of the system.
    pub whole: T,
}

impl Scheme<f64> {
    /// Of a sub-step of length `h` [s].
    pub fn new(h: f64) -> Self {
        let mu = (1.0 - LEFT) / (1.0 + LEFT);
        let (gamma, beta) = (0.5 + mu, 0.25 * (1.0 + mu) * (1.0 + mu));
        let [inner, force] = [h * beta / gamma, h * gamma / (1.0 + mu)];
        Self {
            h: inner,
            mass: inner / force,
            place: [h - inner, h * h * (0.5 - beta - (1.0 - gamma) * beta / gamma)],
            velocity: h * (1.0 - gamma + gamma * mu / (1.0 + mu)),
            outer: force / h,
            rate: [1.0 / (h * gamma), (gamma - 1.0) / gamma],
            whole: h / inner,
        }
    }

    /// Of a sub-step before which no acceleration is known: implicit Euler.
    pub fn first(h: f64) -> Self {
        Self { h, mass: 1.0, place: [0.0; 2], velocity: 0.0, outer: 1.0, rate: [1.0 / h, 0.0], whole: 1.0 }
    }

    /// The same in numbers of another sort.
    pub fn rounded<U: Real>(&self) -> Scheme<U> {
        let to = U::from_f64;
        Scheme {
            h: to(self.h),
            mass: to(self.mass),
            place: self.place.map(to),
            velocity: to(self.velocity),
            outer: to(self.outer),
            rate: self.rate.map(to),
            whole: to(self.whole),
        }
    }
}

impl<T: Real> Scheme<T> {
    /// x̃ [m] of a node at `x` with velocity `v` and acceleration `a`.
    #[inline(always)]
    pub fn base_place(&self, x: [T; 3], v: [T; 3], a: [T; 3]) -> [T; 3] {
        add(x, add(scale(v, self.place[0]), scale(a, self.place[1])))
    }

    /// The velocity [m/s] without springs: ṽ, and what outer forces change, which is `outer` in the whole step.
    #[inline(always)]
    pub fn free_velocity(&self, v: [T; 3], a: [T; 3], outer: [T; 3]) -> [T; 3] {
        add(add(v, scale(a, self.velocity)), scale(outer, self.outer))
    }

    /// a⁺ [m/s²] of a node whose velocity has become `u`.
    #[inline(always)]
    pub fn next_rate(&self, u: [T; 3], v: [T; 3], a: [T; 3]) -> [T; 3] {
        add(scale(sub(u, v), self.rate[0]), scale(a, self.rate[1]))
    }
}

impl Assembly {
    /// The share of the first sub-step that is one of its own.
    pub fn first_share(&self) -> Option<f64> {
        self.solver.is_second_order().then_some(FIRST)
    }
}

/// The scheme of a sub-step that starts at time `t` [s] and is `h` long, where it is of second order.
pub fn parameters<T: Real>(assembly: &Assembly, [t, h]: [f64; 2], substep: &mut Substep<T>) {
    if assembly.solver.is_second_order() {
        let scheme = if t == 0.0 { Scheme::first(h) } else { Scheme::new(h) };
        substep.extensions.insert(scheme.rounded::<T>());
    }
}

impl<T: Real> Substep<T> {
    /// How the implicit solver steps in time, if at second order.
    pub fn scheme(&self) -> Option<&Scheme<T>> {
        self.extensions.get()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A step of x″ = −ω² x.
    fn step([x, v, a]: [f64; 3], omega: f64, scheme: &Scheme<f64>) -> [f64; 3] {
        let base = scheme.base_place([x, 0.0, 0.0], [v, 0.0, 0.0], [a, 0.0, 0.0])[0];
        let free = scheme.free_velocity([v, 0.0, 0.0], [a, 0.0, 0.0], [0.0; 3])[0];
        let k = omega * omega;
        let u = (scheme.mass * free - scheme.h * k * base) / (scheme.mass + scheme.h * scheme.h * k);
        let rate = scheme.next_rate([u, 0.0, 0.0], [v, 0.0, 0.0], [a, 0.0, 0.0])[0];
        [base + scheme.h * u, u, rate]
    }

    #[test]
    fn it_falls_as_bodies_do() {
        let scheme = Scheme::new(0.1);
        let (mut x, mut v, mut a) = ([0.0; 3], [1.0, 0.0, 0.0], [0.0, -10.0, 0.0]);
        for _ in 0..10 {
            let u = scheme.free_velocity(v, a, [0.0, -1.0, 0.0]);
            x = add(scheme.base_place(x, v, a), scale(u, scheme.h));
            (v, a) = (u, scheme.next_rate(u, v, a));
        }
        let off = [x[0] - 1.0, x[1] + 5.0, v[0] - 1.0, v[1] + 10.0, a[1] + 10.0];
        assert!(off.iter().all(|one: &f64| one.abs() < 1e-12), "{off:?}");
    }

    #[test]
    fn an_oscillation_keeps_its_height_and_one_far_too_short_dies() {
        let off = |h: f64| {
            let (mut state, scheme) = ([1.0, 0.0, -1.0], Scheme::new(h));
            for _ in 0..(3.0 / h).round() as usize {
                state = step(state, 1.0, &scheme);
            }
            (state[0] - 3.0_f64.cos()).hypot(state[1] + 3.0_f64.sin())
        };
        let order = (off(0.02) / off(0.01)).log2();
        assert!((order - 2.0).abs() < 0.02, "{order}");
        let (mut state, scheme) = ([1.0, 0.0, -1e12], Scheme::new(1.0));
        for _ in 0..3 {
            state = step(state, 1e6, &scheme);
        }
        let before = state[0];
        for _ in 0..20 {
            state = step(state, 1e6, &scheme);
        }
        assert!(state[0].abs() < before.abs().max(1.0) * 0.1, "{before} {}", state[0]);
    }
}
