//! What two nodes do to each other that have come nearer than the thickness of their cloth.
//!
//! Source: S2 ("CUDA Cloth Simulation"), "Calculation", step 5: proximity of particles, elastic collision along the line
//! between them. To this come masses, restitution, Coulomb friction, and a way apart: a speed by which nodes that are too
//! near part (Baumgarte, "Stabilization of Constraints and Integrals of Motion in Dynamical Systems", 1972). Weight rests
//! on it: what is missing between two layers grows until their impulses bear what lies on them.
//!
//! A node with several contacts takes part in each with its share of its mass (Tonge, Benevolenski, Voroshilov, "Mass
//! Splitting for Jitter-Free Parallel Rigid Body Simulation", 2012), so that no order matters and no energy is won: no
//! share wins any, and their mean has at most their energy. Proofs: docs/models/contact.md.

use crate::real::{Real, add, dot, scale, sub};

/// Two surfaces as they meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactMaterial<T> {
    /// Distance that is kept between their nodes [m].
    pub thickness: T,
    /// Coulomb coefficient.
    pub friction: T,
    /// Share of the normal speed given back.
    pub restitution: T,
}

/// What a pair does to its first node; to its second the opposite.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Exchange<T> {
    /// Change of momentum [N·s].
    pub impulse: [T; 3],
    /// Change of place times mass [kg·m].
    pub shift: [T; 3],
}

/// What a pair does: `d` [m] and `v` [m/s] are place and velocity of the first node less those of the second,
/// `mobility` [1/kg] as [`mobility`] says, `h` [s] the sub-step that has just gone by, `most` the longest way apart in one,
/// by the thickness. Nodes at one place part along y.
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
    // What went missing in this sub-step goes with the approach; what was missing before gives a speed, the more the
    // faster, paid for by what the impact has lost.
    let fresh = if h * approach < missing { h * approach } else { missing };
    let release = soft * (at_most((missing - fresh) * T::from_f64(FIRM)) / h);
    let after = if bounce > release { bounce } else { release };
    // Nodes that part fast enough get no impulse, and hence no friction.
    let gained = if after > speed { after - speed } else { T::ZERO };
    let tangential = sub(v, scale(normal, speed));
    let (slip, grip) = (dot(tangential, tangential).sqrt(), material.friction * gained);
    let lost = if slip > grip { grip / slip } else { T::ONE };
    let friction = scale(tangential, if gained > T::ZERO { -lost } else { T::ZERO });
    // Friction takes its way back, as with colliders, and so does what stops the approach. Where nothing is lost, nodes
    // that are too near are put apart: by half of what is missing, less what they part by themselves.
    let left = material.restitution * at_most(missing * T::from_f64(0.5)) - h * (speed + gained);
    let push = soft * fresh + if left > T::ZERO { left } else { T::ZERO };
    let mass = if mobility > T::ZERO { T::ONE / mobility } else { T::ZERO };
    Exchange {
        impulse: scale(add(scale(normal, gained), friction), mass),
        shift: scale(add(scale(normal, push), scale(friction, h)), mass),
    }
}

/// Share of what is missing that nodes make up for in a sub-step.
pub const FIRM: f64 = 0.2;

/// Time in which nodes that are at one place part by their thickness, at the soonest [s].
pub const RELEASE: f64 = 0.02;

/// Longest way apart in a sub-step of `h` [s], by the thickness.
pub fn max_separation(h: f64) -> f64 {
    (h / RELEASE).min(1.0)
}

/// How easily a pair gives way [1/kg]: inverse masses of its nodes, each of which has so many contacts, and as many shares.
#[inline(always)]
pub fn mobility<T: Real>(inverse_mass: [T; 2], contacts: [u32; 2]) -> T {
    let count = |contacts: u32| T::from_f64(f64::from(contacts));
    inverse_mass[0] * count(contacts[0]) + inverse_mass[1] * count(contacts[1])
}

/// How two surfaces meet of which each has a thickness, friction and restitution: at the mean distance, with the geometric
/// mean of their friction and the larger restitution.
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
