//! Newton steps: as many as a sub-step needs.

use super::{newton, with};
use crate::common::{build, positions, run};
use taffeta::Simulation;
use taffeta::scene::{Body, Ice, Mass, Material, Mesh, Scene, Select};

/// A flag of springs of 1 MN/m that starts level, held by two corners: flat, it has no stiffness against its weight.
fn flag() -> Body {
    let flag = Body::cloth("flag", Mesh::grid(20, 30, [1.5, 1.0])).with_mass(Mass::Node(5e-4));
    flag.structural(1e6, 0.1).shear(1e6, 0.1).bend(1e6, 0.1).pin(Select::nodes([0, 570]))
}

/// A sheet that swings a little.
fn calm() -> Body {
    let sheet = Body::cloth("calm", Mesh::grid(12, 10, [0.5, 0.5])).with_mass(Mass::Node(0.01));
    let sheet = sheet.structural(1e3, 0.1).shear(1e3, 0.1).pin(Select::rows(0, 0)).at([3.0, 0.0, 0.0]);
    Body { place: crate::common::turned([1.0, 0.0, 0.0], 89.0, [3.0, 0.0, 0.0]), ..sheet }
}

fn scene(bodies: impl IntoIterator<Item = Body>, ice: Ice) -> Simulation {
    let scene = Scene::new("flags").time(1.0 / 60.0, 1.0 / 60.0);
    build(&with(bodies.into_iter().fold(scene, Scene::body), ice))
}

/// Greatest energy above that of the start, by the range of energies, in 30 frames.
fn gain(ice: Ice) -> f64 {
    let mut flag = scene([flag()], ice);
    let start = flag.report().energy();
    let [mut least, mut most] = [start; 2];
    for _ in 0..30 {
        run(&mut flag, 1);
        let now = flag.report().energy();
        (least, most) = (least.min(now), most.max(now));
    }
    (most - start) / (start - least)
}

#[test]
fn what_starts_flat_gains_no_energy_where_one_step_gives_it_some() {
    let [one, automatic] = [newton(1), newton(0)].map(gain);
    assert!(one > 0.1 && automatic < 1e-6, "{one}, {automatic}");
    assert_eq!(Ice::default().newton_steps, 0, "it is the default");
}

#[test]
fn calm_cloth_takes_one_step_whatever_other_bodies_take() {
    let [mut automatic, mut one] = [newton(0), newton(1)].map(|ice| scene([calm()], ice));
    let mut beside = scene([flag(), calm()], newton(0));
    for simulation in [&mut automatic, &mut one, &mut beside] {
        run(simulation, 20);
    }
    assert_eq!(automatic.state_hash(), one.state_hash());
    assert_eq!(positions(&beside)[600..], positions(&automatic)[..]);
}

#[test]
fn a_strip_of_fabric_comes_to_rest_where_one_step_keeps_it_in_motion() {
    // Its edge is held, and its own weight bends it down in less time than a step takes.
    let strip = || {
        let held = Select::nodes([0, 13, 26, 39, 52]);
        Body {
            material: Some(Material::preset("cotton")),
            ..Body::cloth("strip", Mesh::grid(5, 13, [0.06, 0.02]))
        }
        .pin(held)
    };
    let left = |ice| {
        let mut simulation = scene([strip()], ice);
        run(&mut simulation, 300);
        let mut kinetic = || {
            run(&mut simulation, 1);
            simulation.report().kinetic
        };
        (0..60).map(|_| kinetic()).fold(0.0, f64::max)
    };
    let [one, automatic] = [newton(1), newton(0)].map(left);
    assert!(one > 1e-9 && automatic < 1e-11, "{one:e}, {automatic:e} J");
}

#[test]
fn each_step_may_take_all_iterations_and_what_runs_out_of_them_takes_no_further_one_by_itself() {
    let iterations = |newton_steps, max_iterations| {
        let ice = Ice { max_iterations, tolerance: 1e-4, ..newton(newton_steps) };
        let mut flag = scene([flag()], ice);
        run(&mut flag, 3);
        flag.report().solver.iterations
    };
    let all = [1, 3, 0].map(|newton_steps| iterations(newton_steps, 12));
    assert!(all[0] == 12 && all[1] > 24 && all[2] == 12, "{all:?}");
    let [one, automatic] = [1, 0].map(|newton_steps| iterations(newton_steps, 60));
    assert!(one < 60 && automatic > 60, "{one}, {automatic}");
}
