//! The same bits however a scene runs.

use super::{ball, ring};
use crate::common::alike::Trial;
use crate::common::{build_as, levels};
use taffeta::scene::{Body, Collider, Scene, Select, Volume, VolumeForm, VolumeWeights};
use taffeta::{Precision, Simulation};

/// Bodies of one tile and of several on a floor, each with another form.
fn scene() -> Scene {
    let mut weighted = Body { name: "weighted".into(), ..ball(2, VolumeForm::Corrected) }.at([6.0, 0.6, 0.0]);
    let weights = VolumeWeights { center: [6.0, 1.0, 0.0], radius: 0.4 };
    weighted.volume = Some(Volume { weights: Some(weights), target: Some(1.1), ..Volume::default() });
    let mut blown = Body { name: "blown".into(), ..ball(3, VolumeForm::None) }.at([8.0, 0.6, 0.0]);
    blown.volume = Some(Volume { pressure: Some(40.0), ..Volume::default() });
    let large = Body { name: "large".into(), ..ball(4, VolumeForm::Projected) }.at([4.0, 0.51, 0.0]);
    Scene::new("volumes")
        .body(ball(3, VolumeForm::Corrected).at([0.0, 0.55, 0.0]))
        .body(ring(VolumeForm::Projected).at([2.0, 0.25, 0.0]).pin(Select::nodes([7])))
        .body(large)
        .body(weighted)
        .body(blown)
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
        .time(0.005, 0.001)
}

/// Each body is pushed at one node.
fn start(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = build_as(scene, precision, threads);
    for body in 0..scene.bodies.len() {
        let name = scene.bodies[body].name.clone();
        simulation.apply_force(simulation.body(&name).unwrap(), 5, [3.0, -20.0, 1.0]).unwrap();
    }
    simulation
}

const TRIAL: Trial = Trial { start, frames: 15 };

#[test]
fn any_number_of_threads_gives_the_same_bits_and_every_time() {
    TRIAL.with_any_threads(&[scene()], |report| report.contacts > 0);
}

#[test]
#[ignore = "run by the test of vector instructions, in processes of their own"]
fn prints_hashes() {
    TRIAL.print_hashes(&[scene()]);
}

#[test]
fn any_vector_instructions_give_the_same_bits() {
    levels::assert_same("volume::bits::prints_hashes", 2);
}

#[test]
fn each_body_moves_as_if_it_were_alone_and_in_any_order() {
    TRIAL.alone_and_in_any_order(&[scene()]);
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    TRIAL.restored(&[scene()]);
}
