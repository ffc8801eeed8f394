//! Bodies of many kinds, and what must be alike however their scene runs: threads, order of bodies, a simulation restored.

use super::compare::cloth;
use super::{build_as, positions, run, turned};
use taffeta::diagnostics::SolverReport;
use taffeta::scene::{Body, Icosphere, Internal, Keyframe, Mass, Mesh, Method, Scene, Select, Solver};
use taffeta::{Precision, Simulation};

/// The same scene with all springs solved for at once.
pub fn with_ice(mut scene: Scene, ice: taffeta::scene::Ice) -> Scene {
    scene.solver = Solver { method: Method::Ice, ice, ..Solver::default() };
    scene
}

/// Nodes in a row with springs between neighbours.
pub fn chain(links: u32, length: f64, mass: f64, [k, d]: [f64; 2]) -> Body {
    Body::cloth("chain", Mesh::chain(links, length)).with_mass(Mass::Node(mass)).structural(k, d)
}

/// A sheet that a moving pin pulls, a soft ball with struts that lands on a floor at y = 0, a chain, and a sheet that nothing
/// holds.
pub fn moving() -> [Body; 4] {
    let pull = vec![Keyframe::translate(0.05, [0.05, 0.1, -0.02])];
    let mut sheet = cloth(24, 21, [2.0, 2.3]).pin_moving(Select::nodes([0, 20]), pull);
    sheet.place = turned([1.0, 0.2, 0.0], 70.0, [0.0, 2.0, 0.0]);
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
    let mut ball =
        Body::soft("ball", mesh).with_mass(Mass::Node(0.02)).structural(90.0, 0.05).bend(30.0, 0.01);
    ball.springs.internal = Some(Internal { count: 200, k: 60.0, d: 0.05, ..Internal::default() });
    let free = Body { name: "free".into(), ..cloth(5, 130, [12.9, 0.4]) }.hinge(1e-3, 1e-5);
    let chain = chain(300, 30.0, 0.02, [90.0, 0.05]).at([0.0, 1.0, 4.0]).pin(Select::nodes([150]));
    [sheet, ball.at([5.0, 0.49, 0.0]), chain, free.at([0.0, 1.0, 6.0])]
}

pub fn start(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = build_as(scene, precision, threads);
    simulation.disturb(0.002, 11);
    simulation
}

fn ran(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = start(scene, precision, threads);
    run(&mut simulation, 4);
    simulation
}

/// Any number of threads gives the same bits and every time; `works` tells whether there was something to solve.
pub fn with_any_threads(scenes: &[Scene], works: impl Fn(&SolverReport) -> bool) {
    for scene in scenes {
        for precision in [Precision::F32, Precision::F64] {
            let one = ran(scene, precision, 1);
            let solver = &one.report().solver;
            assert!(works(solver) && one.report().contacts > 0, "{solver:?}");
            for threads in [1, 2, 3, 8] {
                let many = ran(scene, precision, threads);
                assert_eq!(one.state_hash(), many.state_hash(), "{:?}, {precision}, {threads}", scene.solver);
                assert_eq!(one.report(), many.report(), "{:?}, {precision}, {threads}", scene.solver);
            }
        }
    }
}

/// Prints what `levels::assert_same` compares.
pub fn print_hashes(scenes: &[Scene]) {
    for scene in scenes {
        for precision in [Precision::F32, Precision::F64] {
            println!("hash|{:?} {precision} {:016x}", scene.solver, ran(scene, precision, 2).state_hash());
        }
    }
}

/// Each body moves as if it were alone, and in any order.
pub fn alone_and_in_any_order(scenes: &[Scene]) {
    for scene in scenes {
        let places = |bodies: &[Body], threads| {
            let mut simulation =
                build_as(&Scene { bodies: bodies.to_vec(), ..scene.clone() }, Precision::F32, threads);
            run(&mut simulation, 4);
            positions(&simulation)
        };
        let alone: Vec<_> = scene.bodies.iter().map(|body| places(std::slice::from_ref(body), 1)).collect();
        assert!(alone.concat() == places(&scene.bodies, 2), "{:?}", scene.solver);
        let turned: Vec<_> = scene.bodies.iter().rev().cloned().collect();
        let back: Vec<_> = alone.iter().rev().flatten().copied().collect();
        assert!(back == places(&turned, 2), "{:?}", scene.solver);
    }
}

/// A simulation restored goes on bit by bit, wherever it was before.
pub fn restored(scenes: &[Scene]) {
    for scene in scenes {
        for precision in [Precision::F32, Precision::F64] {
            let mut whole = start(scene, precision, 1);
            run(&mut whole, 2);
            let snapshot = whole.snapshot();
            run(&mut whole, 2);
            for threads in [1, 2] {
                let mut again = build_as(scene, precision, threads);
                run(&mut again, threads as u32 - 1);
                again.restore(&snapshot).unwrap();
                assert_eq!(again.snapshot(), snapshot, "what is restored is what was taken");
                run(&mut again, 2);
                assert_eq!(again.state_hash(), whole.state_hash(), "{:?}, {precision}", scene.solver);
                assert_eq!(again.report(), whole.report(), "{:?}, {precision}", scene.solver);
            }
        }
    }
}

/// Whether it goes on from places and velocities alone as from all that is remembered: else they are those of a simulation
/// just built.
pub fn needs_no_more_than_the_state(scene: &Scene) -> bool {
    let mut whole = start(scene, Precision::F64, 1);
    run(&mut whole, 2);
    let mut again = build_as(scene, Precision::F64, 1);
    let (mut snapshot, taken) = (again.snapshot(), whole.snapshot());
    (snapshot.state, snapshot.start, snapshot.report) = (taken.state, taken.start, taken.report);
    again.restore(&snapshot).unwrap();
    for simulation in [&mut whole, &mut again] {
        run(simulation, 2);
    }
    whole.state_hash() == again.state_hash()
}
