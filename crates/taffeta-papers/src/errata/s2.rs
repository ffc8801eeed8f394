//! Errata of S2.

use super::Erratum;
use super::finding::{Finding, NONE, found};
use super::vector::{Vector, cross, dot, norm, scale, sum};
use crate::papers::paper::Paper;
use std::collections::BTreeSet;

pub fn errata() -> Vec<Erratum> {
    vec![SHEAR, DAMPING, WIND, OBJECTS, ELASTIC, BINS]
}

const SHEAR: Erratum = Erratum {
    id: "s2-shear",
    paper: Paper::S2,
    place: "\"Structure\", the list of springs",
    printed: "\"shear springs (green): (i, j) connects to each (i+1, j+1), (i-1, j+1), (i-1, j+1), and \
              (i-1, j-1)\"",
    corrected: "(i+1, j+1), (i−1, j+1), **(i+1, j−1)** and (i−1, j−1)",
    why: "One diagonal stands twice and one is missing. Gathered by this list a spring pulls at one end \
          twice and at the other not at all, so the matrix of springs is not \"diagonally symmetric\", as \
          the article rightly wants it.",
    setting: "The shear springs of an inner particle, 100 N/m, in a sheet with particles 0.1 m apart that \
              is pulled to 1.1 times its size.",
    model: "[springs](models/springs.md#what-the-papers-print-and-what-we-changed)",
    experiment: shear,
};

fn shear() -> Vec<Finding> {
    let lists: [[[i32; 2]; 4]; 2] =
        [[[1, 1], [-1, 1], [-1, 1], [-1, -1]], [[1, 1], [-1, 1], [1, -1], [-1, -1]]];
    let different = lists.map(|list| BTreeSet::from(list).len() as f64);
    let both_ways =
        lists.map(|list| list.iter().filter(|[i, j]| list.contains(&[-i, -j])).count() as f64 / 4.0);
    let net = lists.map(|list| {
        norm(sum(list.map(|[i, j]| {
            let d = scale(0.11, [f64::from(i), f64::from(j), 0.0]);
            scale(100.0 * (norm(d) - 0.1 * 2f64.sqrt()) / norm(d), d)
        })))
    });
    vec![
        found("different shear neighbours", different[0], different[1], 4.0),
        found("share of springs that act on both ends", both_ways[0], both_ways[1], 1.0),
        found("force on an inner particle [N]", net[0], net[1], 0.0),
    ]
}

const DAMPING: Erratum = Erratum {
    id: "s2-damping",
    paper: Paper::S2,
    place: "\"Calculation\", step 1",
    printed: "\"Damping force: force applied to oppose a fraction of the motion\"",
    corrected: "f = c (Δv·d)/l · d/l: only the rate at which the spring gets longer",
    why: "The sentence does not say which motion. Where it is all of the motion of one end against the \
          other, a cloth that turns without changing its shape slows down in empty space, for nothing \
          balances the moment. Projected on the spring, as in S1's eq. 1 and S3's eq. 4, rigid motions are \
          left alone.",
    setting: "Two particles of 1 kg, 1 m apart, with damping of 0.5 kg/s: first they turn around each other \
              at 1 rad/s, then they part at 1 m/s.",
    model: "[springs](models/springs.md#what-the-papers-print-and-what-we-changed)",
    experiment: damping,
};

/// Power [W] and moment [N·m] of damping between two ends at d from each other.
fn damped(d: Vector, dv: Vector, projected: bool) -> [f64; 2] {
    let whole = scale(0.5, dv);
    let f = if projected { scale(dot(whole, d) / dot(d, d), d) } else { whole };
    [-dot(f, dv), -cross(d, f)[2]]
}

fn damping() -> Vec<Finding> {
    let d = [1.0, 0.0, 0.0];
    let [turning, parting] = [[0.0, 1.0, 0.0], [1.0, 0.0, 0.0]];
    let [printed, corrected] = [false, true].map(|projected| damped(d, turning, projected));
    let [printed_apart, corrected_apart] = [false, true].map(|projected| damped(d, parting, projected));
    // Half the mass at the distance of 1 m, at 1 rad/s.
    let spin = 0.5;
    vec![
        found("turning: power [W]", printed[0], corrected[0], 0.0),
        found(
            "turning: rate at which angular momentum is lost [1/s]",
            -printed[1] / spin,
            -corrected[1] / spin,
            0.0,
        ),
        found("parting: power [W]", printed_apart[0], corrected_apart[0], -0.5),
    ]
}

const WIND: Erratum = Erratum {
    id: "s2-wind",
    paper: Paper::S2,
    place: "\"Calculation\", step 2",
    printed: "\"Add wind/gravity force vector\", one for each particle",
    corrected: "gravity is an acceleration, m g for a particle of mass m; wind acts on areas: of each \
             triangle, by its normal and the flow against it",
    why: "Unless it is scaled with the mesh, which the article does not say, a force for each particle \
          makes a fine sheet heavier than a coarse one, and has it catch more wind; and a sheet catches as \
          much edge-on as face-on. So the article's meshes of 5 × 5 to 160 × 160 are not the same cloth.",
    setting: "A sheet of 1 m × 1 m in a wind that presses with 10 Pa: as 5 × 5 particles, face-on, which is \
              what 0.4 N for each is fitted to, and as others. Exact: pressure times the area that the wind \
              sees.",
    model: "[loads](models/loads.md#formulas), and [air](models/air.md) by triangle",
    experiment: || {
        let row = |name: &str, particles: u32, seen: f64| {
            found(format!("{name} [N]"), 0.4 * f64::from(particles), 10.0 * seen, 10.0 * seen)
        };
        vec![
            row("5 × 5, face-on", 25, 1.0),
            row("160 × 160, face-on", 25_600, 1.0),
            row("5 × 5, edge-on", 25, 0.0),
        ]
    },
};

const OBJECTS: Erratum = Erratum {
    id: "s2-objects",
    paper: Paper::S2,
    place: "\"Calculation\", steps 3 and 4",
    printed: "\"If colliding, cancel out the velocity and force component in the direction of the object \
              normal\"; for the floor \"in the z direction\"",
    corrected: "cancel only what points *into* the object, and put the particle back onto its surface",
    why: "As it stands what points outward is cancelled, too: a particle that has touched can never be \
          lifted off. And one that has sunk in stays there.",
    setting: "A particle of 1 kg in contact with the floor is lifted with 20 N against its weight, for a \
              second at 1 ms. Another lies 5 mm deep. Contact is within 10 mm.",
    model: "[colliders](models/collision.md#s1-and-s2-compared)",
    experiment: objects,
};

/// Height after a second under a force.
fn lifted(mut height: f64, force: f64, corrected: bool) -> f64 {
    let [mut v, h] = [0.0, 1e-3];
    for _ in 0..1000 {
        let mut a = force;
        if height < 0.01 {
            let inward = |x: f64| if corrected { x.max(0.0) } else { 0.0 };
            [a, v] = [inward(a), inward(v)];
            height = if corrected { height.max(0.0) } else { height };
        }
        v += h * a;
        height += h * v;
    }
    height
}

fn objects() -> Vec<Finding> {
    let [up, down] = [20.0 - 9.81, -9.81];
    // Symplectic Euler: n (n + 1)/2 steps' worth of h².
    let exact = up * 1000.0 * 1001.0 / 2.0 * 1e-6;
    vec![
        found("height of the lifted particle [m]", lifted(0.0, up, false), lifted(0.0, up, true), exact),
        found(
            "height of the sunk particle [mm]",
            1e3 * lifted(-5e-3, down, false),
            1e3 * lifted(-5e-3, down, true),
            0.0,
        ),
    ]
}

const ELASTIC: Erratum = Erratum {
    id: "s2-elastic",
    paper: Paper::S2,
    place: "\"Calculation\", step 5",
    printed: "\"Proximity check (per particle)\", \"If colliding, apply elastic collision\"",
    corrected: "where a particle has c contacts, each acts on a c-th of its mass: impulse J = −(1 + e) \
             Δv·n/(w_a c_a + w_b c_b)",
    why: "A particle that touches two others gets both answers in full. If each is found from the state \
          before the step, energy comes from nowhere; if one after the other, each particle in a thread of \
          its own, the partners do not know of it, and momentum is lost. With parts of the mass neither \
          happens, in any order.",
    setting: "Two particles of 1 kg at 1 m/s hit the same one at rest, side by side, all along one line. \
              Exact: both as one of 2 kg.",
    model: "[contact](models/contact.md#nodes-with-each-other)",
    experiment: elastic,
};

/// Velocities of the particle at rest and of the two that hit it.
fn hit_at_once(contacts: f64) -> [f64; 3] {
    // Both contacts: Δv = 1, masses and restitution 1.
    let impulse = 2.0 / (contacts + 1.0);
    [2.0 * impulse, 1.0 - impulse, 1.0 - impulse]
}

fn elastic() -> Vec<Finding> {
    let energy = |v: [f64; 3]| 0.5 * v.iter().map(|v| v * v).sum::<f64>();
    let momentum = |v: [f64; 3]| v.iter().sum::<f64>();
    // The first hit takes the particle to 1 m/s, the second finds no approach; the two know it at rest.
    let in_turn = [1.0, 0.0, 0.0];
    let [full, shared] = [1.0, 2.0].map(hit_at_once);
    vec![
        found("energy after, from the state before [J]", energy(full), energy(shared), 1.0),
        found("energy after, one by one [J]", energy(in_turn), energy(shared), 1.0),
        found("momentum after, one by one [kg·m/s]", momentum(in_turn), momentum(shared), 2.0),
        found("speed of the one that was hit [m/s]", full[0], shared[0], 4.0 / 3.0),
    ]
}

const BINS: Erratum = Erratum {
    id: "s2-bins",
    paper: Paper::S2,
    place: "\"GPU Implementations\", the last one",
    printed: "\"only the particles in the neighboring bins (a 3x3x3 area surrounding the current bin) were \
              considered\"; \"It is very unlikely that a particle will skip an entire bin over the course \
              of a frame\"",
    corrected: "fill bins from all particles (counting sort), each refresh; it costs as little for each \
             particle",
    why: "A particle that has skipped a bin is in no neighbouring bin's list, then or ever after: it passes \
          through all others. The narrower bins are, the less there is to look at, and the lower is the \
          speed for that.",
    setting: "The article does not print the size of a bin; here it is 20 mm. A particle moves evenly for \
              30 frames of 1/30 s.",
    model: "[contact](models/contact.md#nodes-with-each-other), where a node may go as far as it likes",
    experiment: bins,
};

const BIN: f64 = 0.02;

/// In how many frames some bin knows a particle at this speed [m/s].
fn known(speed: f64, corrected: bool) -> f64 {
    let bin = |frame: u32| (speed * f64::from(frame) / 30.0 / BIN).floor() as i64;
    let mut listed = Some(bin(0));
    let mut frames = 0.0;
    for frame in 1..=30 {
        let here = bin(frame);
        let near = listed.is_some_and(|there| (there - here).abs() <= 1);
        listed = (near || corrected).then_some(here);
        frames += f64::from(u8::from(listed.is_some()));
    }
    frames
}

fn bins() -> Vec<Finding> {
    let safe = BIN * 30.0;
    let mut findings: Vec<Finding> = [0.5, 1.5]
        .map(|speed| {
            let what = format!("frames of 30 in which the particle is in a bin, at {speed} m/s");
            found(what, known(speed, false), known(speed, true), 30.0)
        })
        .into();
    findings.push(found("speed up to which none is lost [m/s]", safe, NONE, NONE));
    findings.push(found("fall that reaches it [mm]", 1e3 * safe * safe / (2.0 * 9.81), NONE, NONE));
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_repeated_diagonal_pulls_a_particle_of_an_even_sheet() {
        let [different, both, net] = shear().try_into().unwrap();
        assert_eq!([different.printed, both.printed], [Some(3.0), Some(0.5)]);
        // Two springs too many of 100 N/m · 0.1 · 0.1 √2 m: one at either side of the diagonal.
        assert!((net.printed.unwrap() - 2.0 * 2f64.sqrt()).abs() < 1e-12);
        assert!(net.corrected.unwrap() < 1e-12);
    }

    #[test]
    fn only_projected_damping_leaves_a_rotation_alone() {
        let [power, lost, apart] = damping().try_into().unwrap();
        assert_eq!([power.printed, lost.printed], [Some(-0.5), Some(1.0)]);
        assert_eq!([power.corrected.map(f64::abs), lost.corrected.map(f64::abs)], [Some(0.0); 2]);
        assert_eq!(apart.printed, apart.corrected);
    }

    #[test]
    fn wind_by_particle_grows_with_the_mesh() {
        let forces = (WIND.experiment)();
        assert_eq!(forces[1].printed.unwrap() / forces[0].printed.unwrap(), 1024.0);
        assert_eq!(forces[2].printed, forces[0].printed);
    }

    #[test]
    fn what_is_lifted_leaves_and_what_has_sunk_comes_up() {
        let [up, sunk] = objects().try_into().unwrap();
        assert_eq!(up.printed, Some(0.0));
        assert!((up.corrected.unwrap() - up.exact.unwrap()).abs() < 1e-9);
        assert_eq!(sunk.printed, Some(-5.0));
    }

    #[test]
    fn full_impulses_win_energy_or_lose_momentum() {
        let [at_once, in_turn, momentum, _] = elastic().try_into().unwrap();
        assert_eq!([at_once.printed, in_turn.printed, momentum.printed], [Some(2.0), Some(0.5), Some(1.0)]);
        assert!((at_once.corrected.unwrap() - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_particle_that_skips_a_bin_is_lost_for_good() {
        assert_eq!([known(0.5, false), known(1.5, false), known(1.5, true)], [30.0, 0.0, 30.0]);
        assert_eq!(known(BIN * 30.0 * 0.999, false), 30.0);
    }
}
