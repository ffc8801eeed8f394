//! Bodies that start with a velocity and a spin.

use crate::common::{add, build, build_as, cross, gpu, near, norm, positions, run, scale, sub, weightless};
use taffeta::scene::{Body, Cube, Icosphere, Internal, Mass, Mesh, Scene, Select};
use taffeta::{Options, Precision, Simulation};

/// Two balls of half a kilogram, 2 m apart along x about (1, 2, 3).
fn dumbbell() -> Body {
    let chain = Body::cloth("dumbbell", Mesh::chain(1, 2.0)).with_mass(Mass::Whole(1.0));
    chain.structural(100.0, 0.1).at([1.0, 2.0, 3.0])
}

/// On the CPU in 64 bits and in 32, and on the GPU, with how exactly that counts.
fn everywhere(scene: &Scene) -> [(Simulation, f64); 3] {
    let options = Options { gpu: Some(gpu().into()), ..Options::default() };
    let on_gpu = Simulation::new(scene, &options).unwrap();
    [(build(scene), 1e-14), (build_as(scene, Precision::F32, 1), 1e-6), (on_gpu, 1e-6)]
}

#[test]
fn a_body_starts_with_its_momentum_and_its_spin_about_its_centre() {
    // p = m v; L = x × p + I ω, with I = 1 kg · (1 m)² across the bar and nothing along it.
    let (velocity, spin) = ([3.0, -1.0, 0.5], [7.0, 2.0, -3.0]);
    let scene = weightless("", 0.01, 0.01).body(dumbbell().moving(velocity).spinning(spin));
    for (simulation, tolerance) in everywhere(&scene) {
        let report = simulation.report();
        let turning = add(cross([1.0, 2.0, 3.0], velocity), [0.0, 2.0, -3.0]);
        for axis in 0..3 {
            near("momentum", report.momentum[axis], velocity[axis], 10.0 * tolerance);
            near("angular momentum", report.angular_momentum[axis], turning[axis], 20.0 * tolerance);
        }
        // ½ m v² + ½ ω I ω.
        near("energy", report.kinetic, 0.5 * (10.25 + 13.0), 100.0 * tolerance);
    }
}

#[test]
fn a_body_that_spins_freely_keeps_its_angular_momentum_and_goes_straight_on() {
    let mut cube = Body::soft("cube", Mesh::Cube(Cube { size: 0.6, divisions: 4 }));
    cube.springs.internal = Some(Internal { count: 60, k: 100.0, d: 0.3, ..Internal::default() });
    let cube = cube.with_mass(Mass::Whole(2.0)).structural(200.0, 0.2).at([0.5, 0.0, 0.0]);
    let cube = cube.moving([2.0, 0.0, -1.0]).spinning([0.0, 3.0, 1.0]);
    let centre = |simulation: &Simulation| {
        let all = positions(simulation);
        scale(all.iter().fold([0.0; 3], |sum, &x| add(sum, x)), 1.0 / all.len() as f64)
    };
    // Equal masses, so that the centre of all nodes is that of mass.
    let mut scene = weightless("", 0.01, 1e-3).body(Body { mass: None, node_mass: Some(0.02), ..cube });
    scene.time.frames = 100;
    for (mut simulation, exact) in everywhere(&scene) {
        let (start, from) = (simulation.report().clone(), centre(&simulation));
        assert!(norm(start.angular_momentum) > 0.1, "{start:?}");
        run(&mut simulation, 100);
        let end = simulation.report();
        let turned = norm(sub(end.angular_momentum, start.angular_momentum)) / norm(start.angular_momentum);
        // A thousand steps with a rounding or two each.
        assert!(turned < 1e3 * exact, "{turned:e}");
        let went = sub(centre(&simulation), from);
        let off = norm(sub(went, [2.0, 0.0, -1.0]));
        assert!(off < 1e3 * exact, "{off:e} m");
        assert!(end.kinetic < 0.999 * start.kinetic, "what does not turn as a solid is damped");
    }
}

#[test]
fn nodes_that_pins_hold_stay_where_they_are() {
    let sheet = || {
        Body::cloth("sheet", Mesh::grid(4, 5, [0.4, 0.3]))
            .with_mass(Mass::Node(0.1))
            .structural(50.0, 0.05)
            .moving([0.0, 0.0, 2.0])
            .spinning([0.0, 1.0, 0.0])
    };
    let held = sheet().pin(Select::rows(0, 0));
    let breaking = sheet().pin_breaking(Select::rows(0, 0), 1e6);
    for body in [held, breaking] {
        for (mut simulation, tolerance) in everywhere(&weightless("", 1e-3, 1e-3).body(body)) {
            // 15 of 20 nodes; x of their common centre is 0, so the spin gives nothing along z.
            near("momentum", simulation.report().momentum[2], 15.0 * 0.1 * 2.0, 10.0 * tolerance);
            let before = positions(&simulation);
            run(&mut simulation, 1);
            let after = positions(&simulation);
            for (node, (a, b)) in before.iter().zip(&after).enumerate() {
                let moved = norm(sub(*a, *b));
                assert!(if node < 5 { moved < 1e-5 } else { moved > 1e-3 }, "{node}: {moved} m");
            }
        }
    }
}

#[test]
fn implicit_springs_start_with_the_velocity_as_well() {
    let ball = Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 2 }));
    let ball = ball.with_mass(Mass::Whole(1.0)).structural(1e4, 1.0).moving([0.0, 4.0, 0.0]);
    let mut scene = weightless("", 0.01, 0.01).body(ball).method(taffeta::scene::Method::Ice);
    for form in [taffeta::scene::ConstraintForm::Primal, taffeta::scene::ConstraintForm::Compliant] {
        scene.solver.ice.form = form;
        for (mut simulation, tolerance) in everywhere(&scene) {
            run(&mut simulation, 5);
            near("momentum", simulation.report().momentum[1], 4.0, 1e2 * tolerance);
        }
    }
}
