//! The bench on the start: how long it takes to build a scene.

use super::line::Spread;
use super::{Args, say};
use crate::run::{Backend, at_once, median};
use serde::Serialize;
use std::time::Instant;
use taffeta::scene::{Body, Icosphere, Mass, Mesh, Scene, Select};
use taffeta::{Options, Simulation};
use taffeta_io::program::Failure;

/// How often each scene is built.
const TIMES: usize = 15;

/// A share of the largest stable step however springs are folded: one that a bound tells to be stable, and one that it does not.
const SHARES: [f64; 2] = [0.8, 0.98];

/// The line that is printed for each scene.
#[derive(Serialize)]
struct Line {
    bench: &'static str,
    case: &'static str,
    nodes: usize,
    springs: usize,
    /// Sub-step by the largest stable one.
    share: f64,
    ms: Spread,
    /// With [`Options::find_largest_steps`].
    ms_with_largest_steps: Spread,
}

/// Sheets that hang side by side.
pub fn sheets() -> Scene {
    let sheet = |number: u32| {
        let body = Body::cloth(format!("sheet{number}"), Mesh::grid(20, 20, [0.5; 2]));
        let body =
            body.with_mass(Mass::Whole(0.1)).structural(100.0, 0.01).shear(50.0, 0.01).bend(10.0, 1e-3);
        body.pin(Select::nodes([0, 19])).at([f64::from(number % 10), 0.0, f64::from(number / 10)])
    };
    (0..100).map(sheet).fold(Scene::new("bench start"), Scene::body)
}

/// A ball of ten thousand nodes.
fn ball() -> Scene {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.3, subdivisions: 5 });
    let body = Body::cloth("ball", mesh).with_mass(Mass::Whole(1.0));
    Scene::new("bench start").body(body.structural(400.0, 0.05).bend(100.0, 0.02))
}

/// Builds some scenes and prints how long each took.
pub fn run(args: &Args) -> Result<(), Failure> {
    if args.backend == Backend::Gpu {
        return Err(Failure::Input("`bench start` is for the CPU".into()));
    }
    for (case, scene) in [("100 sheets of 20×20", sheets()), ("a ball of 10,242 nodes", ball())] {
        let largest = build(&scene, args, true)?.0.largest_stable_step_folded();
        for share in SHARES {
            let line = measure(case, &scene.clone().time(1.0 / 60.0, share * largest), share, args)?;
            say(&line, || line.table(), args)?;
        }
    }
    Ok(())
}

/// A scene that is ready, and how long that took [ms].
fn build(scene: &Scene, args: &Args, find_largest_steps: bool) -> Result<(Simulation, f64), Failure> {
    let options = Options {
        threads: at_once(args.threads),
        precision: args.precision.precision(),
        find_largest_steps,
        ..Options::default()
    };
    let start = Instant::now();
    let simulation = Simulation::new(scene, &options).map_err(|error| Failure::Work(error.to_string()))?;
    Ok((simulation, start.elapsed().as_secs_f64() * 1e3))
}

fn measure(case: &'static str, scene: &Scene, share: f64, args: &Args) -> Result<Line, Failure> {
    let mut times = [[0.0; TIMES]; 2];
    // By turns, so that what else the machine does falls on both.
    for i in 0..TIMES {
        for (find, times) in [false, true].into_iter().zip(&mut times) {
            times[i] = build(scene, args, find)?.1;
        }
    }
    let [ms, ms_with_largest_steps] = times.map(|times| Spread {
        min: times.into_iter().fold(f64::INFINITY, f64::min),
        median: median(&times),
        max: times.into_iter().fold(0.0, f64::max),
    });
    let simulation = build(scene, args, false)?.0;
    let bodies = simulation.bodies();
    Ok(Line {
        bench: "start",
        case,
        nodes: bodies.iter().map(|body| body.nodes).sum(),
        springs: bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum(),
        share,
        ms,
        ms_with_largest_steps,
    })
}

impl Line {
    /// For people.
    fn table(&self) -> String {
        let Self { case, share, .. } = self;
        let [ms, with] = [&self.ms, &self.ms_with_largest_steps]
            .map(|ms| format!("{:.1} ms ({:.1} to {:.1})", ms.median, ms.min, ms.max));
        format!(
            "start of {case} at {share} of the largest stable step\n  {ms}; with all largest steps {with}"
        )
    }
}
