//! Contacts as part of an implicit step.
//!
//! A solver that did not know of contact would have cloth under tension, or in free fall, sink into what carries it, and
//! impulses after the step would move single nodes back: that stretches what is between them. So each contact that may come
//! about has an impulse in the system of a Newton step, by an augmented Lagrangian (Hestenes, "Multiplier and Gradient
//! Methods", 1969; for contact Simo and Laursen, "An augmented Lagrangian treatment of contact problems involving friction",
//! 1992):
//!
//! p = max(0, λ·n + κ (min(g, 0) − g⁺)/h) n − min(1, μ pₙ/|s|) s,    s = κ t − (λ − n (n·λ)).
//!
//! λ [N·s] is what the contact carried in the last sub-step, g and g⁺ are the gap where the sub-step begins and where it would
//! end [m], t is the slip there [m/s]. κ [kg] is a multiple of the mass that the contact moves if its nodes drag their
//! neighbours along as far as the diagonal of the system says; it decides how much of an impulse is found in one sub-step.

use crate::contact::triangles::impulse::LEVER;
use crate::real::{Real, Symmetric, add, cross, dot, norm, scale, sub, times};

/// Pairs that are nearer than this, relative to their thickness, may become contacts while the solver runs. Those from farther
/// away meet by the rounds after it: where they would meet is not known well enough before.
pub const NEAR: f64 = 1.25;
/// κ, relative to the mass that the diagonal of the system makes of a contact.
pub const STIFFNESS: f64 = 4.0;
/// Share of a force that the sub-step after the first starts from.
pub const NEW: f64 = 0.125;
/// A contact some of whose nodes colliders hold, and which makes them so many times as hard to move as alone, is none of the system.
pub const STIFF: f64 = 256.0;

/// A contact that may come about in a sub-step.
#[derive(Clone, Copy, Debug, Default)]
pub struct SolvedContact<T> {
    /// Its nodes by place, and their weights: the relative velocity of its sides is Σ w v.
    pub nodes: [u32; 4],
    pub weights: [T; 4],
    /// Unit normal, from the second side to the first.
    pub normal: [T; 3],
    /// Distance of the sides less their thickness where the sub-step begins [m].
    pub gap: T,
    /// How far an old overlap is to be removed in the sub-step [m].
    pub lead: T,
    /// Coulomb coefficient.
    pub friction: T,
    /// λ [N·s].
    pub first: [T; 3],
    /// A body of the system that takes part; none in a contact that is no part of it.
    pub body: u32,
    /// κ [kg].
    pub stiffness: T,
    /// p where the Newton step starts [N·s], and how much it takes back of relative velocities along the normal and across
    /// it [kg].
    pub impulse: [T; 3],
    pub along: T,
    pub across: T,
    /// p with what the Newton step has changed [N·s].
    pub applied: [T; 3],
    /// Whether one of its sides cannot move, so that coarser levels know of it, too.
    pub is_held: bool,
}

impl<T: Real> SolvedContact<T> {
    /// Finds κ by the inverse masses [1/kg] of its nodes, the inverse diagonal blocks of these in the system, and whether
    /// colliders hold them. A contact that would hardly give way because they do is left to the rounds after the solver: both
    /// its sides are held, and what it asks for has no end. Stiff cloth alone is no reason: it must be pushed as hard as it is.
    pub fn stiffen(&mut self, of: impl Fn(u32) -> (T, Symmetric<T>, bool)) {
        let (mut sum, mut most, mut alone) = (T::ZERO, T::ZERO, T::ZERO);
        let (mut moves, mut any_held) = ([false; 2], false);
        for (&node, &weight) in self.nodes.iter().zip(&self.weights) {
            let (inverse_mass, block, is_held) = of(node);
            any_held |= is_held && weight * inverse_mass != T::ZERO;
            let by_impulse = times(&block, self.normal);
            sum += weight * weight * dot(self.normal, by_impulse);
            most = most.max(weight.abs() * norm(by_impulse));
            alone += weight * weight * inverse_mass;
            moves[usize::from(weight < T::ZERO)] |= weight * inverse_mass != T::ZERO;
        }
        self.is_held = moves != [true; 2];
        let compliance = sum.max(most / T::from_f64(LEVER));
        let least = if any_held { alone } else { T::ZERO };
        let gives_way = compliance * T::from_f64(STIFF) > least && alone > T::ZERO;
        self.stiffness = if gives_way { T::from_f64(STIFFNESS) / compliance } else { T::ZERO };
    }

    /// Finds the impulse where the gap would become `gap` [m] in a step of `h` [s], at this relative velocity [m/s].
    pub fn linearise(&mut self, gap: T, velocity: [T; 3], h: T) {
        let (n, kappa) = (self.normal, self.stiffness);
        let least = self.lead + if self.gap < T::ZERO { self.gap } else { T::ZERO };
        let along = dot(self.first, n);
        let pressed = along + kappa * ((least - gap) / h);
        let pressed = if kappa > T::ZERO { pressed.max(T::ZERO) } else { T::ZERO };
        let slip = sub(velocity, scale(n, dot(velocity, n)));
        let drag = sub(scale(slip, kappa), sub(self.first, scale(n, along)));
        let (length, most) = (norm(drag), self.friction * pressed);
        let part = if length > most { most / length } else { T::ONE };
        let acts = pressed > T::ZERO;
        self.impulse = sub(scale(n, pressed), scale(drag, part));
        self.along = if acts { kappa } else { T::ZERO };
        self.across = if acts { kappa * part } else { T::ZERO };
        self.applied = self.impulse;
    }

    /// What it takes back of a relative velocity [N·s].
    #[inline(always)]
    pub fn times(&self, velocity: [T; 3]) -> [T; 3] {
        taken_back(velocity, self.normal, [self.along, self.across])
    }

    /// What nodes have of a vector, the second side's less the first's.
    #[inline(always)]
    pub fn relative(&self, of: impl Fn(u32) -> [T; 3]) -> [T; 3] {
        relative(self.nodes.map(of), self.weights)
    }

    /// C: it takes back C times a relative velocity.
    pub fn block(&self) -> Symmetric<T> {
        let ([x, y, z], more) = (self.normal, self.along - self.across);
        let outer = [x * x, y * y, z * z, x * y, x * z, y * z];
        std::array::from_fn(|one| more * outer[one] + if one < 3 { self.across } else { T::ZERO })
    }

    /// The diagonal block of one of its nodes with its share of the contact, as [`Self::soften`] has the inverse.
    pub fn stiffened_block(&self, corner: usize, block: &Symmetric<T>) -> Symmetric<T> {
        let (weight, [x, y, z]) = (self.weights[corner].abs(), self.normal);
        let (across, more) = (weight * self.across, weight * (self.along - self.across));
        let outer = [x * x, y * y, z * z, x * y, x * z, y * z];
        std::array::from_fn(|one| {
            let sum = block[one] + more * outer[one];
            if one < 3 { sum + across } else { sum }
        })
    }

    /// The inverse of a diagonal block with its share of the contact: no eigenvalue of the contact's part of the matrix is
    /// beyond 2 by these shares, for Σ |w| is 2.
    pub fn soften(&self, corner: usize, inverse: &Symmetric<T>) -> Symmetric<T> {
        let weight = self.weights[corner].abs();
        let [one, other] = across(self.normal);
        let mut all = with(inverse, self.normal, weight * self.along);
        if self.across > T::ZERO {
            all = with(&all, one, weight * self.across);
            all = with(&all, other, weight * self.across);
        }
        all
    }
}

/// What a contact takes back of a relative velocity, along its normal and across it [N·s].
#[inline(always)]
pub fn taken_back<T: Real>(velocity: [T; 3], normal: [T; 3], [by_along, by_across]: [T; 2]) -> [T; 3] {
    let along = scale(normal, dot(velocity, normal));
    add(scale(along, by_along), scale(sub(velocity, along), by_across))
}

/// What four nodes have of a vector, by their weights, whose sum is 0.
#[inline(always)]
pub fn relative<T: Real>([a, b, c, anchor]: [[T; 3]; 4], weights: [T; 4]) -> [T; 3] {
    let part = |of: [T; 3], weight: T| scale(sub(of, anchor), weight);
    add(add(part(a, weights[0]), part(b, weights[1])), part(c, weights[2]))
}

/// The force that a sub-step starts from [N], of what a contact had in the last one and before that: the impulse of an impact
/// is over with it, and would throw apart what has met. A force that stays is taken up in some sub-steps.
pub fn sustained<T: Real>(force: [T; 3], last: [T; 3]) -> [T; 3] {
    let most = T::from_f64(2.0) * norm(last) + T::from_f64(NEW) * norm(force);
    let length = norm(force);
    if length > most { scale(force, most / length) } else { force }
}

/// Two unit vectors that stand on a third and each other.
fn across<T: Real>(n: [T; 3]) -> [[T; 3]; 2] {
    let least = if n[0].abs() < n[1].abs() { 0 } else { 1 };
    let mut axis = [T::ZERO; 3];
    axis[least] = T::ONE;
    let one = cross(n, axis);
    let one = scale(one, T::ONE / norm(one));
    [one, cross(n, one)]
}

/// The inverse of a matrix to which `by` times q qᵀ is added (Sherman and Morrison, 1950).
fn with<T: Real>(inverse: &Symmetric<T>, q: [T; 3], by: T) -> Symmetric<T> {
    let y = times(inverse, q);
    let part = by / (T::ONE + by * dot(q, y));
    let [a, b, c] = y;
    let taken = [a * a, b * b, c * c, a * b, a * c, b * c];
    std::array::from_fn(|one| inverse[one] - part * taken[one])
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 0.01;

    /// A vertex of 1 kg above the middle of a triangle of three nodes of 3 kg, `gap` [m] farther than its thickness.
    fn contact(gap: f64, first: [f64; 3]) -> SolvedContact<f64> {
        let third = 1.0 / 3.0;
        let mut one = SolvedContact {
            nodes: [0, 1, 2, 3],
            weights: [1.0, -third, -third, -third],
            normal: [0.0, 1.0, 0.0],
            gap,
            friction: 0.5,
            first,
            ..SolvedContact::default()
        };
        one.stiffen(|node| of_mass(if node == 0 { 1.0 } else { 3.0 }));
        one
    }

    fn of_mass(mass: f64) -> (f64, Symmetric<f64>, bool) {
        let w = 1.0 / mass;
        (w, [w, w, w, 0.0, 0.0, 0.0], false)
    }

    #[test]
    fn kappa_is_a_multiple_of_the_mass_that_moves() {
        // 1 kg, and 9 kg for the triangle: 0.9 kg.
        assert!((contact(0.0, [0.0; 3]).stiffness - STIFFNESS * 0.9).abs() < 1e-12);
        let mut held = contact(0.0, [0.0; 3]);
        held.stiffen(|_| (1.0, [1.0, 1e-3, 1.0, 0.0, 0.0, 0.0], true));
        assert_eq!(held.stiffness, 0.0, "colliders hold both sides along the normal");
        held.stiffen(|node| (1.0, [1.0, 1e-3, 1.0, 0.0, 0.0, 0.0], node > 3));
        assert!((held.stiffness - STIFFNESS * 750.0).abs() < 1e-9, "only cloth makes it stiff");
        held.stiffen(|_| (0.0, [0.0; 6], false));
        assert_eq!(held.stiffness, 0.0, "all are pinned");
    }

    #[test]
    fn a_gap_may_close_and_an_old_overlap_stay() {
        for (gap, end) in [(0.004, 0.001), (0.004, 0.0), (-0.002, -0.002), (-0.002, 0.0)] {
            let mut one = contact(gap, [0.0; 3]);
            one.linearise(end, [0.0, (end - gap) / H, 0.0], H);
            assert_eq!((one.impulse, one.along), ([0.0; 3], 0.0), "{gap} {end}");
        }
        let mut one = contact(0.004, [0.0; 3]);
        one.linearise(-0.001, [0.0, -0.5, 0.0], H);
        assert!((one.impulse[1] - one.stiffness * 0.1).abs() < 1e-12, "{:?}", one.impulse);
    }

    #[test]
    fn at_rest_it_carries_what_it_carried_and_no_more_friction_than_there_is() {
        let mut one = contact(0.0, [0.3, 1.0, 0.0]);
        one.linearise(0.0, [0.0; 3], H);
        assert_eq!(one.impulse, [0.3, 1.0, 0.0]);
        assert_eq!((one.along, one.across), (one.stiffness, one.stiffness));
        // It slides: half of the normal impulse, against the slip, and no stiffer than that.
        one.linearise(0.0, [0.0, 0.0, 2.0], H);
        let [x, y, z] = one.impulse;
        assert!((x.hypot(z) - 0.5).abs() < 1e-12 && y == 1.0 && z < 0.0, "{:?}", one.impulse);
        assert!(one.across < 0.1 * one.stiffness);
        // It lifts off.
        one.linearise(0.01, [0.0, 1.0, 0.0], H);
        assert_eq!(one.impulse, [0.0; 3]);
    }

    #[test]
    fn an_impact_is_over_with_its_sub_step_and_a_weight_is_taken_up() {
        let rest = [0.0, 8.0, 0.0];
        let mut last = sustained(rest, [0.0; 3]);
        assert_eq!(last, [0.0, 1.0, 0.0]);
        for expected in [3.0, 7.0, 8.0] {
            last = sustained(rest, last);
            assert_eq!(last[1], expected);
        }
        assert_eq!(sustained([0.0, 0.5, 0.0], last), [0.0, 0.5, 0.0]);
    }

    #[test]
    fn the_shares_of_the_diagonal_bear_the_contact() {
        let mut one = contact(0.0, [0.0, 1.0, 0.0]);
        one.linearise(0.0, [0.0; 3], H);
        // With shares alone, D: Σ v D v is at least half of the contact's own part, whatever v is.
        for v in [[1.0, -1.0, -1.0, -1.0], [1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.3, 0.1, -0.7, 0.9]]
        {
            let own = one.relative(|node| [0.0, v[node as usize], 0.2 * v[node as usize]]);
            let whole = dot(own, one.times(own));
            let shares: f64 = (0..4)
                .map(|corner| {
                    let before = 1e3;
                    let all = one.soften(corner, &[1.0 / before, 1.0 / before, 1.0 / before, 0.0, 0.0, 0.0]);
                    let at = v[corner] * v[corner];
                    let share = one.stiffened_block(corner, &[0.0; 6]);
                    assert!((1.0 / all[1] - before - share[1]).abs() < 1e-9 * before);
                    (1.0 / all[1] - before) * at + (1.0 / all[2] - before) * 0.04 * at
                })
                .sum();
            assert!(whole <= 2.0 * shares * (1.0 + 1e-9), "{v:?}: {whole} {shares}");
        }
    }
}
