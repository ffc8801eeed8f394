//! The engine and the reference side by side.

use super::lists::grid_pairs;
use super::reference::Reference;
use super::{add, cross, farthest, near, norm, positions, run, scale};
use taffeta::Simulation;
use taffeta::scene::{Body, Mass, Mesh, Scene};

/// Two full steps and a short one in a frame.
pub const DT: f64 = 0.0025;
pub const STEP: f64 = 0.001;

pub fn scene(body: Body) -> Scene {
    let mut scene = Scene::new("oracle").time(DT, STEP).body(body);
    scene.world.drag = 0.03;
    scene.world.wind_force = [0.02, 0.01, -0.04];
    scene
}

pub fn reference(scene: &Scene, simulation: &Simulation, mass: Vec<f64>) -> Reference {
    let mut reference = Reference::new(positions(simulation), mass);
    reference.gravity = scene.world.gravity;
    reference.drag = scene.world.drag;
    reference.wind = scene.world.wind_force;
    reference.solver = scene.solver.clone();
    reference
}

/// Disturbs the engine, takes its places over, and compares twenty frames, sixty steps.
pub fn compare(simulation: Simulation, reference: Reference, amplitude: f64) {
    compare_for(simulation, reference, amplitude, 20);
}

/// The same for some `frames`.
pub fn compare_for(mut simulation: Simulation, mut reference: Reference, amplitude: f64, frames: u32) {
    simulation.disturb(amplitude, 7);
    reference.x = positions(&simulation);
    let mut touched = reference.obstacles.is_empty();
    for frame in 1..=frames {
        run(&mut simulation, 1);
        for h in [STEP, STEP, DT - 2.0 * STEP] {
            reference.step(h);
        }
        let apart = farthest(&positions(&simulation), &reference.x);
        assert!(apart < 1e-9, "frame {frame}: {apart:e} m apart");
        assert_eq!(simulation.report().contacts, reference.touched, "frame {frame}");
        touched |= reference.touched > 0;
    }
    let (report, [kinetic, gravitational, springs, folds]) = (simulation.report(), reference.energies());
    assert!(kinetic > 1e-4 && touched, "something moves, and touches what there is");
    near("kinetic", report.kinetic, kinetic, 1e-8 * kinetic);
    near("gravitational", report.gravitational, gravitational, 1e-8 * gravitational.abs().max(1.0));
    near("springs", report.springs, springs, 1e-7 * springs + 1e-12);
    near("hinges", report.energy_of("hinges"), folds, 1e-7 * folds + 1e-12);
    let momenta = reference.mass.iter().zip(&reference.v).map(|(&m, &v)| scale(v, m));
    let momentum = momenta.clone().fold([0.0; 3], add);
    let angular = momenta.zip(&reference.x).fold([0.0; 3], |sum, (p, &x)| add(sum, cross(x, p)));
    let size = norm(momentum) + norm(angular);
    for i in 0..3 {
        near("momentum", report.momentum[i], momentum[i], 1e-8 * size);
        near("angular momentum", report.angular_momentum[i], angular[i], 1e-8 * size);
    }
}

pub fn cloth(rows: u32, cols: u32, size: [f64; 2]) -> Body {
    Body::cloth("cloth", Mesh::grid(rows, cols, size))
        .with_mass(Mass::Node(0.05))
        .structural(80.0, 0.05)
        .shear(50.0, 0.03)
        .bend(30.0, 0.02)
}

pub fn join_grid(reference: &mut Reference, rows: usize, cols: usize) {
    for (down, across, spring) in [
        (0, 1, [80.0, 0.05]),
        (1, 0, [80.0, 0.05]),
        (1, 1, [50.0, 0.03]),
        (0, 2, [30.0, 0.02]),
        (2, 0, [30.0, 0.02]),
    ] {
        reference.join(grid_pairs(rows, cols, down, across), spring);
    }
}
