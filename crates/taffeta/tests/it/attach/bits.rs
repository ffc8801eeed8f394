//! The same bits however a scene runs.

use super::panel;
use crate::common::alike::Trial;
use crate::common::{build_as, levels};
use taffeta::scene::{Collider, Keyframe, Pin, Scene, Seam, SeamSide, Select};
use taffeta::{Precision, Simulation};

/// Panels of several tiles, sewn and touching each other, of which some seams tear, with tethers and pins that let go.
fn scene() -> Scene {
    let edge = |name: &str, col| SeamSide::new(name, Select::cols(col, col));
    let motion = vec![Keyframe::translate(1.0, [-0.2, 0.0, 0.0])];
    let breaking = Pin { select: Select::cols(0, 2), break_force: Some(0.35), motion, ..Pin::default() };
    let mut left =
        panel("left", 33, [-0.26, 0.0, 0.0]).pin(Select::nodes([0])).tether(0.02).collide_nodes(0.012);
    left.pins.push(breaking);
    Scene::new("sewn")
        .body(left)
        .body(panel("right", 33, [0.26, 0.0, 0.0]).collide_nodes(0.012))
        .body(panel("third", 33, [0.27, 0.05, 0.0]))
        .seam(
            Seam { break_force: Some(0.2), ..Seam::new(edge("left", 32), edge("right", 0)) }
                .closing(0.0, 0.1, 0.0),
        )
        .seam(
            Seam { k: Some(40.0), ..Seam::new(edge("third", 0), edge("left", 32)) }.closing(0.02, 0.1, 0.01),
        )
        .collider(Collider::sphere([0.0, -0.25, 0.0], 0.2))
        .time(0.005, 0.0005)
}

fn start(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = build_as(scene, precision, threads);
    simulation.disturb(1e-4, 4);
    simulation
}

const TRIAL: Trial = Trial { start, frames: 36 };

#[test]
fn any_number_of_threads_gives_the_same_bits_and_every_time() {
    TRIAL.with_any_threads(&[scene()], |report| report.broken > 3 && report.broken < 132);
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
    levels::assert_same("attach::bits::prints_hashes", 2);
}
