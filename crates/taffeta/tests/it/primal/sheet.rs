//! Sheets of stiff light cloth at steps far beyond what explicit springs, and directions of the last step, bear.

use super::{newton, with};
use crate::common::state::{noise, set, state};
use crate::common::{build, near, norm, run, sub, turned};
use taffeta::Simulation;
use taffeta::scene::{Body, Ice, Mass, Mesh, Scene, Select};

/// 34 rows of 34 nodes, a square metre, in the plane of x and y; `mass` [kg] a node, all springs of `k` [N/m].
fn sheet(k: f64, mass: f64, structural_alone: bool) -> Body {
    let mut body = Body::cloth("sheet", Mesh::grid(34, 34, [1.0, 1.0])).with_mass(Mass::Node(mass));
    body = body.structural(k, 0.0);
    if !structural_alone {
        body = body.shear(k, 0.0).bend(k, 0.0);
    }
    body.place = turned([1.0, 0.0, 0.0], 90.0, [0.0; 3]);
    body
}

/// In steps of `h` [s], with 1 mm of noise out of its plane where `held` does not say that a node is.
fn rough(body: Body, h: f64, ice: Ice, held: impl Fn(usize) -> bool) -> Simulation {
    let mut simulation = build(&with(Scene::new("sheet").time(h, h).body(body), ice));
    let ((mut x, v), mut random) = (state(&simulation), noise(34));
    assert!(norm(sub(x[33 * 34], [-0.5, -0.5, 0.0])) < 1e-12, "it hangs");
    x.iter_mut().enumerate().filter(|&(n, _)| !held(n)).for_each(|(_, x)| x[2] += 1e-3 * random());
    set(&mut simulation, &x, &v);
    // Energies are those of the start that it is now.
    simulation.disturb(0.0, 0);
    simulation
}

/// Largest stretch in some frames.
fn longest(simulation: &mut Simulation, frames: u32) -> f64 {
    let mut longest = 1.0_f64;
    for _ in 0..frames {
        run(simulation, 1);
        longest = longest.max(simulation.report().max_stretch);
    }
    longest
}

#[test]
fn with_structural_springs_alone_it_hangs_still_at_any_step() {
    // By springs h² n g/L = 2.8 stretches it to more than 1.5 times its length.
    for (h, ice) in [
        (0.016, newton(1)),
        (0.016, newton(2)),
        (0.008, newton(1)),
        (0.004, newton(1)),
        (0.016, Ice { warm_start: false, ..newton(1) }),
    ] {
        let body = sheet(1e5, 0.01, true).pin(Select::rows(0, 0));
        let mut hanging = rough(body, h, ice.clone(), |n| n < 34);
        // The noise goes, and what is left is the pull of 33 rows on the uppermost springs.
        let at_first = longest(&mut hanging, (0.5 / h) as u32);
        let then = longest(&mut hanging, (1.0 / h) as u32) - 1.0;
        let by_weight = 33.0 * 0.01 * 9.81 / 1e5 * 33.0;
        assert!(at_first < 1.03, "{h} s, {ice:?}: {at_first}");
        near("stretch", then, by_weight, 0.05 * by_weight);
    }
}

/// A flag held by one side, of springs of 1 MN/m, falls in its own plane: largest stretch, and largest energy above that
/// of the start by what it falls through.
fn fallen(mass: f64, structural_alone: bool, newton_steps: u32) -> [f64; 2] {
    let body = sheet(1e6, mass, structural_alone).pin(Select::cols(0, 0));
    let mut flag = rough(body, 1.0 / 60.0, newton(newton_steps), |n| n % 34 == 0);
    let start = flag.report().energy();
    let [mut least, mut most, mut stretch] = [start, start, 1.0_f64];
    for _ in 0..60 {
        stretch = stretch.max(longest(&mut flag, 1));
        let now = flag.report().energy();
        (least, most) = (least.min(now), most.max(now));
    }
    let gain = (most - start) / (start - least);
    [stretch, gain]
}

#[test]
fn a_flag_as_light_as_a_feather_falls_and_gains_no_energy() {
    for (mass, newton_steps) in [(1e-2, 1), (1e-2, 2), (1e-3, 1), (1e-3, 2), (1e-5, 1), (1e-5, 2)] {
        let [stretch, gain] = fallen(mass, false, newton_steps);
        assert!(stretch < 1.02 && gain < 0.03, "{mass} kg, {newton_steps}: {stretch}, {gain}");
    }
}

#[test]
fn a_flag_of_structural_springs_alone_does_not_blow_up() {
    // It collapses in its plane: directions turn by half a radian in a step, and what they miss is stretch.
    for (mass, newton_steps) in [(1e-2, 1), (1e-3, 1), (1e-3, 2), (1e-5, 1), (1e-5, 2)] {
        let [stretch, _] = fallen(mass, true, newton_steps);
        assert!(stretch < 1.3, "{mass} kg, {newton_steps}: {stretch}");
    }
    // At 10 g a node a second Newton step is enough.
    let [stretch, gain] = fallen(1e-2, true, 2);
    assert!(stretch < 1.05 && gain < 0.03, "{stretch}, {gain}");
}
