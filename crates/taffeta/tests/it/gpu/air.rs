//! Air on the GPU against the same on the CPU.

use super::{STEP, flag, kept, on_gpu, small_gpu, soft, with};
use crate::common::{build_as, farthest, gpu, positions, run};
use taffeta::scene::{Air, Body, ConstraintForm, Gust, Icosphere, Mass, Mesh, Method, Scene, VolumeForm};
use taffeta::{GpuOptions, Options, Precision, Simulation, Stage};

/// A flag, a ball with hinges, a soft ball that keeps its volume and a chain in gusts.
fn gusty() -> Scene {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 2 });
    let ball = Body::cloth("ball", ball)
        .with_mass(Mass::Whole(0.5))
        .structural(50.0, 0.02)
        .hinge(1e-3, 1e-5)
        .at([0.0, 1.0, 2.0]);
    let chain = Body::cloth("chain", Mesh::chain(20, 1.0)).with_mass(Mass::Node(0.01)).structural(50.0, 0.0);
    let mut scene = flag().time(1.0 / 60.0, STEP / 2.0);
    scene.bodies.extend([
        ball,
        chain.at([0.0, 0.0, 4.0]),
        with(kept(VolumeForm::Corrected), soft("soft", 2, [0.0, 1.0, 6.0])),
    ]);
    let gust = Gust { speed: 3.0, length: 0.4, period: 0.3, seed: 11 };
    scene.world.air = Some(Air { velocity: [4.0, 0.5, 1.0], gust: Some(gust), ..Air::default() });
    scene
}

fn same(scene: &Scene, frames: u32) {
    let (mut cpu, mut on_gpu) = (build_as(scene, Precision::F32, 1), on_gpu(scene));
    for frame in 1..=frames {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        assert_eq!(farthest(&positions(&cpu), &positions(&on_gpu)), 0.0, "{}, frame {frame}", scene.title);
    }
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
}

#[test]
fn air_blows_as_on_the_cpu() {
    same(&gusty(), 12);
    // Without gusts and without anything else among the elements, bodies so small that they would be patches.
    let mut small = flag();
    small.bodies[0].mesh = Mesh::grid(9, 11, [0.5, 0.4]);
    small.bodies[0].pins.clear();
    small.world.air = Some(Air { velocity: [3.0, 0.0, 2.0], ..Air::default() });
    same(&small, 12);
}

#[test]
fn air_blows_on_springs_that_are_solved_for_by_nodes_as_on_the_cpu() {
    let mut scene = gusty().method(Method::Ice).time(1.0 / 60.0, 1.0 / 120.0);
    scene.bodies.truncate(3);
    scene.solver.ice.form = ConstraintForm::Primal;
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    run(&mut cpu, 5);
    run(&mut on_gpu, 5);
    // Sums over bodies are taken in another order.
    assert!(farthest(&positions(&cpu), &positions(&on_gpu)) < 1e-5);
}

#[test]
fn a_gpu_takes_over_in_the_wind_at_any_stage() {
    let scene = gusty();
    let mut cpu = build_as(&scene, Precision::F32, 1);
    run(&mut cpu, 2);
    for stage in [Stage::Loads, Stage::Springs, Stage::Integrate, Stage::Pins] {
        let mut scene = scene.clone();
        if stage > Stage::Volumes {
            scene.bodies.truncate(3);
        }
        let options = GpuOptions { from: stage, ..gpu().into() };
        let mut both =
            Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
        run(&mut both, 2);
        let places = positions(&both);
        assert_eq!(farthest(&positions(&cpu)[..places.len()], &places), 0.0, "{}", stage.name());
    }
}

#[test]
fn aero_triangles_are_split_with_their_bodies() {
    let scene = gusty();
    let options = Options { gpu: Some(GpuOptions::from(small_gpu(60_000))), ..Options::default() };
    let mut split = Simulation::new(&scene, &options).unwrap();
    let mut cpu = build_as(&scene, Precision::F32, 1);
    run(&mut cpu, 4);
    run(&mut split, 4);
    assert_eq!(cpu.state_hash(), split.state_hash());
}
