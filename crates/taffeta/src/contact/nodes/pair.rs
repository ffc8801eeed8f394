//! The contact response of two nodes that are closer than the thickness of their cloth.
//!
//! Source: S2 ("CUDA Cloth Simulation"), "Calculation", step 5: proximity of particles, elastic collision along the
//! line between them. Added to this are masses, restitution, Coulomb friction and a separation speed, which parts
//! nodes that are too close (Baumgarte, "Stabilization of Constraints and Integrals of Motion in Dynamical Systems",
//! 1972). It carries weight: the overlap of two layers grows until their impulses carry what lies on them.
//!
//! A node with several contacts takes part in each with a fraction of its mass (Tonge, Benevolenski, Voroshilov,
//! "Mass Splitting for Jitter-Free Parallel Rigid Body Simulation", 2012). So the order does not matter and no energy
//! is gained: no fraction gains any, and their mean has at most their energy. Proofs: docs/models/contact.md.

use crate::real::{Real, add, dot, scale, sub};

/// The material of a surface, or of two surfaces in contact.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMaterial<T> {
    /// Distance between nodes in contact [m].
    pub thickness: T,
    /// Coulomb coefficient.
    pub friction: T,
    /// Fraction of the normal speed that is returned.
    pub restitution: T,
}

/// The response of the first node of a pair; the second gets the opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange<T> {
    /// Impulse: change of momentum [N·s].
    pub impulse: [T; 3],
    /// Change of position times mass [kg·m].
    pub shift: [T; 3],
}

/// The response of a pair. `d` [m] and `v` [m/s] are position and velocity of the first node relative to the second,
/// `mobility` [1/kg] is that of [`mobility`], `h` [s] the sub-step that has just ended, and `most` the largest
/// separation in a sub-step, relative to the thickness. Nodes at one position separate along y.
#[inline(always)]
pub fn exchange<T: Real>(
    d: [T; 3],
    v: [T; 3],
    mobility: T,
    material: &ContactMaterial<T>,
    (h, most): (T, T),
) -> Exchange<T> {
    let distance = dot(d, d).sqrt();
    let is_separated = distance > T::ZERO;
    let by = if is_separated { distance } else { T::ONE };
    let normal = if is_separated { [d[0] / by, d[1] / by, d[2] / by] } else { [T::ZERO, T::ONE, T::ZERO] };
    let speed = dot(v, normal);
    let (missing, limit) = (material.thickness - distance, most * material.thickness);
    let at_most = |way: T| if way < limit { way } else { limit };
    let approach = if speed < T::ZERO { -speed } else { T::ZERO };
    let (bounce, soft) = (material.restitution * approach, T::ONE - material.restitution);
    // The overlap of this sub-step is removed with the approach. Older overlap gives a separation speed that grows
    // with it, paid for by the energy that the impact has lost.
    let fresh = if h * approach < missing { h * approach } else { missing };
    let release = soft * (at_most((missing - fresh) * T::from_f64(FIRM)) / h);
    let after = if bounce > release { bounce } else { release };
    // Nodes that separate fast enough get no impulse, and hence no friction.
    let gained = if after > speed { after - speed } else { T::ZERO };
    let tangential = sub(v, scale(normal, speed));
    let (slip, grip) = (dot(tangential, tangential).sqrt(), material.friction * gained);
    let lost = if slip > grip { grip / slip } else { T::ONE };
    let friction = scale(tangential, if gained > T::ZERO { -lost } else { T::ZERO });
    // Friction takes its distance back, as with colliders, and so does the stopped approach. If no energy is lost,
    // half of the overlap is removed by position, less what the nodes separate by themselves.
    let left = material.restitution * at_most(missing * T::from_f64(0.5)) - h * (speed + gained);
    let push = soft * fresh + if left > T::ZERO { left } else { T::ZERO };
    let mass = if mobility > T::ZERO { T::ONE / mobility } else { T::ZERO };
    Exchange {
        impulse: scale(add(scale(normal, gained), friction), mass),
        shift: scale(add(scale(normal, push), scale(friction, h)), mass),
    }
}

/// Fraction of the overlap that is removed in a sub-step.
pub const FIRM: f64 = 0.2;

/// Shortest time in which nodes at one position separate by their thickness [s].
pub const RELEASE: f64 = 0.02;

/// Largest separation in a sub-step of `h` [s], relative to the thickness.
pub fn max_separation(h: f64) -> f64 {
    (h / RELEASE).min(1.0)
}

/// The mobility of a pair [1/kg]: the sum of the inverse masses of its nodes, each times its number of contacts.
#[inline(always)]
pub fn mobility<T: Real>(inverse_mass: [T; 2], contacts: [u32; 2]) -> T {
    let count = |contacts: u32| T::from_f64(f64::from(contacts));
    inverse_mass[0] * count(contacts[0]) + inverse_mass[1] * count(contacts[1])
}

/// The material of two surfaces in contact: the mean thickness, the geometric mean of friction, and the larger
/// restitution.
pub fn combine_materials<T: Real>(a: &ContactMaterial<T>, b: &ContactMaterial<T>) -> ContactMaterial<T> {
    ContactMaterial {
        thickness: (a.thickness + b.thickness) * T::from_f64(0.5),
        friction: (a.friction * b.friction).sqrt(),
        restitution: if a.restitution > b.restitution { a.restitution } else { b.restitution },
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::norm;

    const H: f64 = 0.001;

    fn material(friction: f64, restitution: f64) -> ContactMaterial<f64> {
        ContactMaterial { thickness: 0.1, friction, restitution }
    }

    /// What a pair of nodes of 1 kg with a contact each does.
    fn alone(d: [f64; 3], v: [f64; 3], how: &ContactMaterial<f64>) -> Exchange<f64> {
        exchange(d, v, 2.0, how, (H, max_separation(H)))
    }

    #[test]
    fn an_impact_gives_back_its_share_and_puts_apart_what_it_brought_near() {
        let along = |e: f64| {
            let done = alone([0.096, 0.0, 0.0], [-4.0, 0.0, 0.0], &material(0.0, e));
            [done.impulse[0], done.shift[0]]
        };
        for (e, [impulse, shift]) in [(0.0, [2.0, 0.002]), (0.5, [3.0, 0.001]), (1.0, [4.0, 0.0])] {
            let done = along(e);
            assert!((done[0] - impulse).abs() < 1e-12 && (done[1] - shift).abs() < 1e-15, "{e}: {done:?}");
        }
    }

    #[test]
    fn friction_is_bounded_by_the_normal_impulse() {
        let sliding = alone([0.0, 0.1, 0.0], [3.0, -2.0, 0.0], &material(0.5, 0.0));
        assert_eq!((sliding.impulse, sliding.shift), ([-0.5, 1.0, 0.0], [-0.5 * H, 0.0, 0.0]));
        let stuck = alone([0.0, 0.1, 0.0], [3.0, -2.0, 0.0], &material(2.0, 0.0));
        assert_eq!((stuck.impulse, stuck.shift), ([-1.5, 1.0, 0.0], [-1.5 * H, 0.0, 0.0]));
    }

    #[test]
    fn nodes_too_near_part_the_faster_the_more_is_missing_up_to_a_limit() {
        let speed = |distance: f64, v: f64, e: f64| {
            let done = alone([0.0, distance, 0.0], [0.0, v, 0.0], &material(0.0, e));
            (v + 2.0 * done.impulse[1], 2.0 * done.shift[1])
        };
        let near = |got: (f64, f64), expected: (f64, f64)| {
            assert!((got.0 - expected.0).abs() < 1e-9 && (got.1 - expected.1).abs() < 1e-12, "{got:?}");
        };
        near(speed(0.095, 0.0, 0.0), (FIRM * 0.005 / H, 0.0));
        near(speed(0.095, 0.0, 0.5), (FIRM * 0.005 / H * 0.5, 0.5 * 0.0025 - 0.5 * FIRM * 0.005));
        near(speed(0.05, 0.0, 0.0), (0.1 / RELEASE, 0.0));
        // Where nothing is lost they get no speed.
        near(speed(0.095, 0.0, 1.0), (0.0, 0.0025));
        near(speed(0.05, 0.0, 1.0), (0.0, 0.1 * H / RELEASE));
        // Fast enough by themselves.
        near(speed(0.095, 1.1, 0.0), (1.1, 0.0));
    }

    #[test]
    fn nodes_at_one_place_part_along_y_and_held_ones_stay() {
        let done = alone([0.0; 3], [0.0; 3], &material(0.3, 0.0));
        assert!(done.impulse[1] > 0.0 && done.impulse[0] == 0.0 && done.impulse[2] == 0.0);
        let held = exchange([0.0; 3], [1.0; 3], mobility([0.0; 2], [1; 2]), &material(0.3, 0.5), (H, 0.1));
        assert_eq!(held, Exchange::default());
    }

    /// Numbers from −1 to 1 in no order.
    fn some(n: u32) -> [f64; 3] {
        [0, 1, 2]
            .map(|axis| f64::from((3 * n + axis).wrapping_mul(2_654_435_761)) / f64::from(1_u32 << 31) - 1.0)
    }

    #[test]
    fn what_is_done_to_one_is_done_to_the_other_the_opposite_way() {
        for n in 0..1000 {
            let (d, v, how) = (scale(some(n), 0.06), some(n + 5000), material(0.3, f64::from(n % 3) * 0.5));
            let (there, back) = (alone(d, v, &how), alone(scale(d, -1.0), scale(v, -1.0), &how));
            assert_eq!((there.impulse, there.shift), (scale(back.impulse, -1.0), scale(back.shift, -1.0)));
        }
    }

    #[test]
    fn no_impact_wins_energy_however_many_contacts_there_are() {
        for n in 0..1000 {
            let (way, v) = (some(n), some(n + 5000));
            let contacts = [1 + n % 4, 1 + n / 4 % 5];
            let inverse_mass = [0.5 + f64::from(n % 7), f64::from(n % 5)];
            for e in [0.0, 0.3, 1.0] {
                let w = mobility(inverse_mass, contacts);
                // As near as they came in this sub-step, or nearer where nothing is lost.
                let speed = dot(v, way) / norm(way);
                let missing = if e < 1.0 { (-speed * H).max(0.0) } else { 0.05 };
                let d = scale(way, (0.1 - missing) / norm(way));
                let done = exchange(d, v, w, &material(0.4, e), (H, max_separation(H)));
                // Of the parts of both that meet, in the frame of their common motion.
                let after = add(v, scale(done.impulse, w));
                assert!(norm(after) <= norm(v) * (1.0 + 1e-12), "{n}, {e}: {v:?} {after:?}");
            }
        }
    }
}
