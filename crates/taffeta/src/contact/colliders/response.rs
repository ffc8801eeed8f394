//! Contact response: position and velocity of a node that is inside a collider.
//!
//! The new position is put back onto the surface, the inward normal speed is removed or reflected (restitution e),
//! and Coulomb friction takes at most μ times the normal impulse from the tangential speed relative to the
//! collider's own motion. Va, Choi, Hong 2021 (S1), algorithm 4, adds unit vectors to velocities instead, which has
//! no unit and depends on the step; this is the textbook impulse form (Baraff, Witkin, "Physically Based Modeling",
//! SIGGRAPH course notes, 2001).

use crate::real::{Real, add, dot, norm, scale, sub};

/// A contact of one node with a surface.
#[derive(Clone, Copy, Debug)]
pub struct ContactPoint<T> {
    /// How far the node is inside [m], above 0.
    pub depth: T,
    /// Outward unit normal.
    pub normal: [T; 3],
    /// Velocity of the surface at the node [m/s].
    pub surface_velocity: [T; 3],
    /// Coulomb coefficient.
    pub friction: T,
    /// Fraction of the normal speed that is returned.
    pub restitution: T,
}

/// Position [m] and velocity [m/s] after contact, at the end of a step `h` [s].
///
/// Friction also takes back the distance that the tangential speed has covered in this step. Otherwise a node that
/// sticks would creep by h² g sin α a step.
#[inline(always)]
pub fn respond<T: Real>(x: [T; 3], v: [T; 3], contact: &ContactPoint<T>, h: T) -> ([T; 3], [T; 3]) {
    let lifted = add(x, scale(contact.normal, contact.depth));
    let relative = sub(v, contact.surface_velocity);
    let approach = -dot(relative, contact.normal);
    // A node that is separating gets no impulse, and hence no friction.
    let approach = if approach > T::ZERO { approach } else { T::ZERO };
    let impulse = (T::ONE + contact.restitution) * approach;
    let friction = friction_of(relative, contact.normal, contact.friction * impulse);
    let velocity = add(add(v, scale(contact.normal, impulse)), friction);
    (add(lifted, scale(friction, h)), velocity)
}

/// Change of velocity by friction that takes at most `most` [m/s] from the tangential part of a relative velocity.
#[inline(always)]
pub fn friction_of<T: Real>(relative: [T; 3], normal: [T; 3], most: T) -> [T; 3] {
    let tangential = sub(relative, scale(normal, dot(relative, normal)));
    let slip = norm(tangential);
    let lost = if slip > most { most / slip } else { T::ONE };
    let lost = if most > T::ZERO { lost } else { T::ZERO };
    scale(tangential, -lost)
}

/// Squared sine of the angle below which a wedge counts as two opposite faces, about 10°. The way out of a narrower
/// wedge is so long that a node pinched between a ball and a floor would be thrown across the scene.
pub const NARROW: f64 = 0.03;

/// The shortest translation [m] out of two half-spaces, each given by depth (below 0: outside) and outward unit
/// normal. If one of them is sufficient, or if they are opposite, only the first is left.
pub fn leave_both<T: Real>((depth, normal): (T, [T; 3]), (other, across): (T, [T; 3])) -> [T; 3] {
    let alone = scale(normal, depth);
    let cosine = dot(normal, across);
    let room = T::ONE - cosine * cosine;
    if depth * cosine >= other || room <= T::from_f64(NARROW) {
        return alone;
    }
    let (a, b) = ((depth - cosine * other) / room, (other - cosine * depth) / room);
    add(scale(normal, a), scale(across, b))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn contact(friction: f64, restitution: f64) -> ContactPoint<f64> {
        ContactPoint {
            depth: 0.1,
            normal: [0.0, 1.0, 0.0],
            surface_velocity: [1.0, 0.0, 0.0],
            friction,
            restitution,
        }
    }

    #[test]
    fn a_bounce_gives_back_its_share_and_lifts_to_the_surface() {
        let (x, v) = respond([0.0, -0.1, 0.0], [1.0, -2.0, 0.0], &contact(0.5, 0.25), 0.01);
        assert_eq!((x, v), ([0.0, 0.0, 0.0], [1.0, 0.5, 0.0]));
    }

    #[test]
    fn friction_takes_at_most_mu_times_the_normal_impulse() {
        // Relative slip 3 along x, normal impulse 2, μ = 0.5: 1 is taken, 2 remains, plus the surface's own 1.
        let (x, v) = respond([0.0, -0.1, 0.0], [4.0, -2.0, 0.0], &contact(0.5, 0.0), 0.01);
        assert_eq!(v, [3.0, 0.0, 0.0]);
        assert!((x[0] + 0.01).abs() < 1e-15);
        // μ = 2 sticks to the moving surface.
        assert_eq!(respond([0.0; 3], [4.0, -2.0, 0.0], &contact(2.0, 0.0), 0.01).1, [1.0, 0.0, 0.0]);
    }

    #[test]
    fn a_node_that_leaves_is_only_lifted() {
        let v = [4.0, 2.0, 0.0];
        assert_eq!(respond([0.0, -0.1, 0.0], v, &contact(2.0, 1.0), 0.01), ([0.0, 0.0, 0.0], v));
    }

    #[test]
    fn the_way_out_of_a_wedge_ends_on_both_faces() {
        let (n, m) = ([0.0, 1.0, 0.0], [0.8, -0.6, 0.0]);
        let way: [f64; 3] = leave_both((0.1, n), (0.02, m));
        assert!((dot(way, n) - 0.1).abs() < 1e-15 && (dot(way, m) - 0.02).abs() < 1e-15);
        // A face that is left anyway does not matter, nor does one that faces the first.
        assert_eq!(leave_both((0.1, n), (0.02, [0.6, 0.8, 0.0])), [0.0, 0.1, 0.0]);
        assert_eq!(leave_both((0.1, n), (0.02, [0.0, -1.0, 0.0])), [0.0, 0.1, 0.0]);
    }

    #[test]
    fn a_node_pinched_between_two_faces_is_not_thrown() {
        for degrees in 1..180 {
            let (sine, cosine) = (180.0 - f64::from(degrees)).to_radians().sin_cos();
            let way = leave_both((0.1, [0.0, 1.0, 0.0]), (0.1, [sine, cosine, 0.0]));
            assert!(dot(way, way).sqrt() < 0.1 * 12.0, "{degrees}°: {way:?}");
        }
    }
}
