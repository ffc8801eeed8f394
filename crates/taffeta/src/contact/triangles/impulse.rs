//! The impulses of contacts between surfaces.
//!
//! A contact keeps the impulse that it ended with and starts the next sub-step from it, so a stack of many layers carries its
//! weight after some sub-steps, and then rests. In a round every contact corrects its impulse for the velocities that all
//! impulses together give, with colliders: sequential impulses with warm start (Catto, "Iterative Dynamics with Temporal
//! Coherence", 2005), all contacts at once, each with a part of a node's mass (Tonge, Benevolenski, Voroshilov, "Mass
//! Splitting for Jitter-Free Parallel Rigid Body Simulation", 2012). Friction stays in Coulomb's cone of the normal impulse.

use crate::real::{Real, add, dot, norm, scale, sub};

/// Part of an old overlap that is removed in a sub-step, by position alone.
pub const FIRM: f64 = 0.2;
/// Overlap that stays, relative to the thickness: with none at all contacts would come and go at rest.
pub const SLOP: f64 = 0.01;
/// Shortest time in which a contact separates by its thickness [s].
pub const RELEASE: f64 = 0.02;
/// A contact that carried an impulse remains one up to this distance, relative to the thickness.
pub const KEEPS: f64 = 1.05;

/// How far a contact may sink in by a sub-step, relative to its thickness, before another round corrects impulses.
pub const SINKS: f64 = 0.01;

/// A node gets at most so many times the velocity by which sides approach each other. A contact next to a pinned node could
/// otherwise be kept only by a lever: the free node of the smallest weight would fly off.
pub const LEVER: f64 = 2.0;

/// How much the relative velocity of a contact changes by an impulse [1/kg]. For each of its nodes: the size of its weight, and
/// the inverse of the contact's part of its mass [1/kg].
pub fn mobility<T: Real>(nodes: [(T, T); 4]) -> T {
    let (mut sum, mut most) = (T::ZERO, T::ZERO);
    for (weight, inverse_mass) in nodes {
        let alone = weight * inverse_mass;
        sum += weight * alone;
        most = if alone > most { alone } else { most };
    }
    sum.max(most / T::from_f64(LEVER))
}

/// What is known of a contact in a sub-step.
#[derive(Clone, Copy, Debug)]
pub struct Contact<T> {
    /// Unit normal, from the second side to the first.
    pub normal: [T; 3],
    /// Distance of the sides less their thickness where the sub-step begins [m].
    pub gap: T,
    /// Thickness [m], Coulomb coefficient.
    pub thickness: T,
    pub friction: T,
    /// How much friction [N·s] there is beside that: what the solver of an implicit step has left of it.
    pub grip: T,
    /// How far a collider comes nearer in the sub-step [m].
    pub advance: T,
    /// How much the relative velocity changes by an impulse [1/kg]: see [`mobility`].
    pub mobility: T,
}

/// What an impulse along a normal leaves of friction [N·s].
pub fn grip<T: Real>(impulse: [T; 3], normal: [T; 3], friction: T) -> T {
    let along = dot(impulse, normal);
    (friction * along - norm(sub(impulse, scale(normal, along)))).max(T::ZERO)
}

impl<T: Real> Contact<T> {
    /// The impulse [N·s] of the last sub-step as this one's first guess: in the cone of its normal.
    #[inline(always)]
    pub fn start(&self, last: [T; 3]) -> [T; 3] {
        let along = dot(last, self.normal);
        self.in_cone(along.max(T::ZERO), sub(last, scale(self.normal, along)))
    }

    /// The impulse after a round. `impulse` is that before it, `velocity` the relative velocity that the nodes have now [m/s],
    /// `h` the sub-step [s]. A gap may close in the sub-step, no more.
    #[inline(always)]
    pub fn correct(&self, impulse: [T; 3], velocity: [T; 3], h: T) -> [T; 3] {
        let by = T::ONE / if self.mobility > T::ZERO { self.mobility } else { T::ONE };
        let (speed, along) = (dot(velocity, self.normal), dot(impulse, self.normal));
        let wanted = -self.gap.max(T::ZERO) / h;
        let normal = (along + (wanted - speed) * by).max(T::ZERO);
        let slip = sub(velocity, scale(self.normal, speed));
        let across = sub(sub(impulse, scale(self.normal, along)), scale(slip, by));
        let new = self.in_cone(normal, across);
        if self.mobility > T::ZERO { new } else { [T::ZERO; 3] }
    }

    /// How far the contact would sink in by the sub-step at this relative velocity, relative to its thickness; one that cannot
    /// give way does not.
    #[inline(always)]
    pub fn sinks(&self, velocity: [T; 3], h: T) -> T {
        let way = -(dot(velocity, self.normal) * h + self.gap.max(T::ZERO)) / self.thickness;
        if self.mobility > T::ZERO { way } else { T::ZERO }
    }

    /// How far an overlap of earlier sub-steps is removed in this one [m].
    #[inline(always)]
    pub fn lead(&self, h: T) -> T {
        let missing = (-self.gap - T::from_f64(SLOP) * self.thickness).max(T::ZERO) * T::from_f64(FIRM);
        let most = self.thickness * h / T::from_f64(RELEASE);
        if missing < most { missing } else { most }
    }

    /// The change of relative position by which an overlap of earlier sub-steps is removed, times the contact's mass [kg·m].
    #[inline(always)]
    pub fn push(&self, h: T) -> [T; 3] {
        let way = self.lead(h);
        // Who is in the way of a collider goes along with it.
        let way = if way > T::ZERO { way + self.advance } else { T::ZERO };
        let by = T::ONE / if self.mobility > T::ZERO { self.mobility } else { T::ONE };
        scale(self.normal, if self.mobility > T::ZERO { way * by } else { T::ZERO })
    }

    /// Normal and tangential parts put together, the tangential one no longer than friction allows.
    #[inline(always)]
    fn in_cone(&self, normal: T, across: [T; 3]) -> [T; 3] {
        let (length, most) = (norm(across), self.friction * normal + self.grip);
        let kept = if length > most { most / length } else { T::ONE };
        add(scale(self.normal, normal), scale(across, kept))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const H: f64 = 0.01;

    fn contact(gap: f64, friction: f64) -> Contact<f64> {
        // Two nodes of 1 kg.
        Contact {
            normal: [0.0, 1.0, 0.0],
            gap,
            thickness: 0.01,
            friction,
            grip: 0.0,
            advance: 0.0,
            mobility: 2.0,
        }
    }

    /// Relative velocity after an impulse.
    fn after(velocity: [f64; 3], impulse: [f64; 3]) -> [f64; 3] {
        add(velocity, scale(impulse, 2.0))
    }

    #[test]
    fn no_node_gets_more_than_twice_the_velocity_of_an_approach() {
        // A vertex above a triangle, one above an edge, and one close to a corner that is pinned.
        assert!((mobility([(1.0, 1.0), (0.25, 1.0), (0.25, 1.0), (0.5, 1.0)]) - 1.375).abs() < 1e-12);
        assert_eq!(mobility([(1.0, 0.0), (0.5, 2.0), (0.5, 2.0), (0.0, 2.0)]), 1.0);
        let near_a_pin = [(1.0, 0.0), (0.9, 0.0), (0.05, 3.0), (0.05, 3.0)];
        let change = 0.05 * 3.0 / mobility(near_a_pin);
        assert!((change - 2.0).abs() < 1e-12, "{change}");
        assert_eq!(mobility([(1.0, 0.0); 4]), 0.0);
    }

    #[test]
    fn an_approach_ends_where_the_gap_does() {
        let v = [0.0, -3.0, 0.0];
        assert_eq!(after(v, contact(0.0, 0.0).correct([0.0; 3], v, H)), [0.0; 3]);
        assert_eq!(after(v, contact(-0.004, 0.0).correct([0.0; 3], v, H)), [0.0; 3]);
        assert_eq!(after(v, contact(0.02, 0.0).correct([0.0; 3], v, H)), [0.0, -2.0, 0.0]);
        assert_eq!(contact(0.04, 0.0).correct([0.0; 3], v, H), [0.0; 3], "it does not get there");
    }

    #[test]
    fn an_impulse_that_is_too_large_is_taken_back_but_never_pulls() {
        let one = contact(0.0, 0.0);
        assert_eq!(one.correct([0.0, 3.0, 0.0], [0.0, 2.0, 0.0], H), [0.0, 2.0, 0.0]);
        assert_eq!(one.correct([0.0, 3.0, 0.0], [0.0, 9.0, 0.0], H), [0.0; 3]);
        assert_eq!(one.start([0.0, -1.0, 0.0]), [0.0; 3]);
    }

    #[test]
    fn friction_stays_in_the_cone() {
        let v = [3.0, -2.0, 0.0];
        assert_eq!(contact(0.0, 0.5).correct([0.0; 3], v, H), [-0.5, 1.0, 0.0], "it slides");
        assert_eq!(contact(0.0, 2.0).correct([0.0; 3], v, H), [-1.5, 1.0, 0.0], "it sticks");
        assert_eq!(contact(0.0, 0.5).start([4.0, 2.0, 0.0]), [1.0, 2.0, 0.0]);
        let pressed = Contact { grip: 0.25, ..contact(0.0, 0.5) };
        assert_eq!(pressed.correct([0.0; 3], v, H), [-0.75, 1.0, 0.0], "what is pressed already holds, too");
    }

    #[test]
    fn old_overlaps_are_removed_bit_by_bit_and_never_fast() {
        let push = |gap: f64| 2.0 * contact(gap, 0.0).push(H)[1];
        assert_eq!(push(0.001), 0.0);
        assert_eq!(push(-0.0001), 0.0, "a hundredth of the thickness stays");
        assert!((push(-0.0051) - FIRM * 0.005).abs() < 1e-15);
        assert!((push(-0.5) - 0.01 * H / RELEASE).abs() < 1e-15);
        let ahead = Contact { advance: 0.003, ..contact(-0.0051, 0.0) };
        assert!((2.0 * ahead.push(H)[1] - FIRM * 0.005 - 0.003).abs() < 1e-15, "a collider takes it along");
        assert_eq!(Contact { mobility: 0.0, ..contact(-0.005, 0.3) }.push(H), [0.0; 3]);
    }
}
