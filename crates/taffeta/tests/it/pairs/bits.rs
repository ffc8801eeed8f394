//! The same bits however a scene runs.

use super::sheets::sheet;
use crate::common::alike::Trial;
use crate::common::{build_as, levels, run, turned, warnings};
use taffeta::scene::{Body, Collider, Icosphere, Mass, Mesh, Scene, Select};
use taffeta::{Precision, Simulation};

/// Sheets of several tiles and a ball that fall on each other.
fn scene() -> Scene {
    let mut high = sheet("high", 33, 0.02, 0.018);
    high.place = turned([0.0, 1.0, 0.0], 30.0, [0.05, 0.14, 0.0]);
    let ball = Mesh::Icosphere(Icosphere { radius: 0.08, subdivisions: 3 });
    let ball = Body::soft("ball", ball)
        .with_mass(Mass::Whole(0.3))
        .structural(40.0, 0.05)
        .collide_nodes(0.016)
        .at([0.1, 0.25, 0.1]);
    Scene::new("heap")
        .body(sheet("low", 33, 0.02, 0.018).at([0.0, 0.11, 0.0]).pin(Select::nodes([0])))
        .body(high)
        .body(ball)
        .collider(Collider::sphere([0.0, 0.0, 0.0], 0.1).offset(0.0))
        .time(0.005, 0.001)
}

fn start(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = build_as(scene, precision, threads);
    simulation.disturb(1e-3, 4);
    simulation
}

const TRIAL: Trial = Trial { start, frames: 30 };

#[test]
fn any_number_of_threads_gives_the_same_bits_and_every_time() {
    TRIAL.with_any_threads(&[scene()], |report| report.pairs > 50 && report.contacts > 0);
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    TRIAL.restored(&[scene()]);
}

#[test]
#[ignore = "run by the test of vector instructions, in processes of their own"]
fn prints_hashes() {
    TRIAL.print_hashes(&[scene()]);
}

#[test]
fn any_vector_instructions_give_the_same_bits() {
    levels::assert_same("pairs::bits::prints_hashes", 2);
}

#[test]
fn neighbours_on_a_surface_do_not_touch_and_alone_it_moves_as_without_contact() {
    // Thicker than the nodes are apart, up to those two away, and not folded.
    let ball = Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: 3 });
    let ball = Body::soft("ball", ball).with_mass(Mass::Whole(0.3)).structural(400.0, 0.05);
    for (body, thickness) in [(sheet("sheet", 25, 0.02, 0.0), 0.03), (ball, 0.025)] {
        let fall = |thickness: Option<f64>| {
            let body = Body { self_collision: None, ..body.clone() };
            let body = thickness.into_iter().fold(body, Body::collide);
            let mut simulation = build_as(&Scene::new("").body(body).time(0.005, 0.0005), Precision::F64, 1);
            assert_eq!(warnings(&simulation).iter().find(|words| words.contains("moved apart")), None);
            simulation.disturb(2e-3, 1);
            run(&mut simulation, 20);
            (simulation.state_hash(), simulation.report().pairs)
        };
        assert_eq!(fall(Some(thickness)), fall(None), "{}", body.name);
    }
}
