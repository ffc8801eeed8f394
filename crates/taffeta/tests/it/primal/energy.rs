//! Energy: implicit steps take some away, and add none where nothing else does.

use super::{accurate, newton, with};
use crate::common::compare::cloth;
use crate::common::state::stiffen;
use crate::common::{build, run, turned, weightless};
use taffeta::scene::{Body, Collider, Ice, Icosphere, Mass, Mesh, Scene, Select};

/// Largest energy that a step adds, and largest energy above that of the start, by the range of energies; and the largest
/// stretch, in some frames.
fn gains(scene: &Scene, frames: u32, stretched: f64) -> [f64; 3] {
    let mut simulation = build(scene);
    simulation.disturb(stretched, 5);
    let start = simulation.report().energy();
    let [mut last, mut least, mut gain, mut above, mut stretch] = [start, start, 0.0_f64, 0.0_f64, 1.0_f64];
    for _ in 0..frames {
        run(&mut simulation, 1);
        let now = simulation.report().energy();
        (gain, above, least) = (gain.max(now - last), above.max(now - start), least.min(now));
        last = now;
        stretch = stretch.max(simulation.report().max_stretch);
    }
    assert!(least < start, "it loses some");
    [gain / (start - least), above / (start - least), stretch]
}

#[test]
fn what_is_stretched_and_let_go_loses_energy_in_every_step() {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
    let mut sheet = cloth(20, 17, [1.6, 1.9]);
    stiffen(&mut sheet, 100.0);
    let ball = Body::soft("ball", ball).with_mass(Mass::Node(0.02)).structural(8000.0, 0.1).bend(800.0, 0.1);
    for body in [sheet, ball] {
        for ice in [newton(1), newton(2), accurate(1), accurate(2)] {
            let scene = with(weightless("let go", 0.01, 0.01).body(body.clone()), ice.clone());
            let [gain, ..] = gains(&scene, 100, 0.03);
            assert!(gain < 1e-9, "{}, {ice:?}: {gain:e}", body.name);
        }
    }
}

#[test]
fn what_hangs_loses_energy_in_every_step() {
    for ice in [newton(1), newton(2)] {
        let mut body = cloth(20, 17, [1.6, 1.9]).pin(Select::nodes([0, 16]));
        stiffen(&mut body, 100.0);
        body.place = turned([1.0, 0.1, 0.0], 40.0, [0.0; 3]);
        let scene = with(Scene::new("hangs").time(0.01, 0.01).body(body), ice.clone());
        let [gain, ..] = gains(&scene, 300, 0.003);
        assert!(gain < 1e-6, "{ice:?}: {gain:e}");
    }
}

#[test]
fn a_sheet_that_drops_on_a_sphere_never_gains_energy() {
    // S1, figure 15, of stiffer springs.
    let rough = |collider: Collider| collider.friction(0.3).restitution(0.0);
    for (k, ice) in [
        (2000.0, newton(1)),
        (2e4, newton(1)),
        (2e4, newton(2)),
        (2e4, Ice { max_iterations: 3, ..newton(1) }),
    ] {
        let body = Body::cloth("sheet", Mesh::grid(32, 32, [2.0, 2.0])).with_mass(Mass::Node(0.15));
        let body = body.structural(k, 0.1).shear(k, 0.1).bend(k, 0.1).at([0.0, 0.55, 0.0]);
        let scene = Scene::new("drop")
            .time(0.016, 0.016)
            .body(body)
            .collider(rough(Collider::sphere([0.0; 3], 0.5)).offset(0.01))
            .collider(rough(Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0])).offset(0.0));
        let [gain, above, stretch] = gains(&with(scene, ice.clone()), 200, 0.0);
        assert!(above == 0.0 && stretch < 1.6, "{k} N/m, {ice:?}: {above}, {gain:e}, {stretch}");
    }
}
