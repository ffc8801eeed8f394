//! Bodies of many kinds, and what must be alike however their scene runs: threads, order of bodies, a simulation restored.

use super::compare::cloth;
use super::{build_as, positions, run, turned};
use taffeta::diagnostics::FrameReport;
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

/// How a scene is run that must have the same bits whatever runs it.
#[derive(Clone, Copy)]
pub struct Trial {
    /// Builds it, and gives it what moves it.
    pub start: fn(&Scene, Precision, usize) -> Simulation,
    /// Frames.
    pub frames: u32,
}

/// Nothing but the scene.
pub const PLAIN: Trial = Trial { start: build_as, frames: 4 };

/// With velocities by chance.
pub const SHAKEN: Trial = Trial { start: shaken, frames: 4 };

fn shaken(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = build_as(scene, precision, threads);
    simulation.disturb(0.002, 11);
    simulation
}

/// What does not depend on threads, nor on what was before: when neighbours are searched for does.
fn lasting(report: &FrameReport) -> FrameReport {
    FrameReport { pair_searches: 0, ..report.clone() }
}

impl Trial {
    /// The simulation at its end.
    pub fn ran(self, scene: &Scene, precision: Precision, threads: usize) -> Simulation {
        let mut simulation = (self.start)(scene, precision, threads);
        run(&mut simulation, self.frames);
        simulation
    }

    /// Any number of threads gives the same bits and every time; `works` tells whether there was something to do.
    pub fn with_any_threads(self, scenes: &[Scene], works: impl Fn(&FrameReport) -> bool) {
        for scene in scenes {
            for precision in [Precision::F32, Precision::F64] {
                let one = self.ran(scene, precision, 1);
                assert!(works(one.report()), "{:?}", one.report());
                for threads in [1, 2, 3, 8] {
                    let (many, what) = (self.ran(scene, precision, threads), &scene.solver);
                    assert_eq!(one.state_hash(), many.state_hash(), "{what:?}, {precision}, {threads}");
                    assert_eq!(
                        lasting(one.report()),
                        lasting(many.report()),
                        "{what:?}, {precision}, {threads}"
                    );
                }
            }
        }
    }

    /// Prints what `levels::assert_same` compares.
    pub fn print_hashes(self, scenes: &[Scene]) {
        for scene in scenes {
            for precision in [Precision::F32, Precision::F64] {
                let hash = self.ran(scene, precision, 2).state_hash();
                println!("hash|{:?} {precision} {hash:016x}", scene.solver);
            }
        }
    }

    /// Each body moves as if it were alone, and in any order.
    pub fn alone_and_in_any_order(self, scenes: &[Scene]) {
        for scene in scenes {
            let places = |bodies: &[Body], threads| {
                let scene = Scene { bodies: bodies.to_vec(), ..scene.clone() };
                positions(&self.ran(&scene, Precision::F32, threads))
            };
            let alone: Vec<_> =
                scene.bodies.iter().map(|body| places(std::slice::from_ref(body), 1)).collect();
            assert!(alone.concat() == places(&scene.bodies, 2), "{:?}", scene.solver);
            let turned: Vec<_> = scene.bodies.iter().rev().cloned().collect();
            let back: Vec<_> = alone.iter().rev().flatten().copied().collect();
            assert!(back == places(&turned, 2), "{:?}", scene.solver);
        }
    }

    /// A simulation restored half-way goes on bit by bit, wherever it was before.
    pub fn restored(self, scenes: &[Scene]) {
        let half = self.frames / 2;
        for scene in scenes {
            for precision in [Precision::F32, Precision::F64] {
                let mut whole = (self.start)(scene, precision, 1);
                run(&mut whole, half);
                let snapshot = whole.snapshot();
                run(&mut whole, self.frames - half);
                for threads in [1, 2] {
                    let mut again = build_as(scene, precision, threads);
                    run(&mut again, threads as u32 - 1);
                    again.restore(&snapshot).unwrap();
                    assert_eq!(again.snapshot(), snapshot, "what is restored is what was taken");
                    run(&mut again, self.frames - half);
                    let what = &scene.solver;
                    assert_eq!(again.state_hash(), whole.state_hash(), "{what:?}, {precision}");
                    assert_eq!(lasting(again.report()), lasting(whole.report()), "{what:?}, {precision}");
                }
            }
        }
    }
}

/// Whether it goes on from places and velocities alone as from all that is remembered: else they are those of a simulation
/// just built.
pub fn needs_no_more_than_the_state(scene: &Scene) -> bool {
    let mut whole = shaken(scene, Precision::F64, 1);
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
