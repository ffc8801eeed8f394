//! One run: how far it is from the reference, and how long it takes.

use super::method::Method;
use super::plan::Entry;
use super::reference::{Distance, Reference};
use super::rk4::{Number, Room, State};
use super::scenes::{Case, FRAME};
use serde::{Deserialize, Serialize};
use serde_json::Value;
use std::time::Instant;
use taffeta::diagnostics::FrameReport;
use taffeta::{Precision, Simulation};

/// A run is repeated until it was run so often, or for so long [s]; but so often at least, where it is a small one.
const REPEATS: usize = 7;
const LEAST: usize = 3;
const ENOUGH: f64 = 1.5;
/// A spring may get longer than in the reference by this share of its length; beyond that the sheet has crumpled.
const SMOOTH: f64 = 0.05;
/// The plain method has blown up where a spring is so many times as long as at rest.
const RUNAWAY: f64 = 20.0;

/// What is kept of a run.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Run {
    /// The scene.
    pub scene: String,
    /// How springs were solved.
    pub method: Method,
    /// Sub-steps in a frame.
    pub steps: u32,
    /// Length of a sub-step [s].
    pub step: f64,
    /// Bits of a number.
    pub bits: u32,
    /// Threads.
    pub threads: usize,
    /// Simulated time [s].
    pub seconds: f64,
    /// The frame in which it blew up.
    pub diverged: Option<u32>,
    /// Distance from the reference by how far it moved; of what did not blow up.
    pub error: Option<f64>,
    /// Largest l/L after any frame, and that of the reference.
    pub max_stretch: f64,
    /// See `max_stretch`.
    pub reference_stretch: f64,
    /// Energy at the end beyond that of the reference, by the reference's largest kinetic energy.
    pub energy: Option<f64>,
    /// Wall time of a simulated second [ms]: least, median and most of so many runs; of what did not blow up.
    pub wall_ms: Option<[f64; 3]>,
    /// How often it was run.
    pub runs: usize,
    /// Iterations: mean over frames of the most in a sub-step, and the most.
    pub iterations: (f64, u32),
    /// Sub-steps that ended beyond the tolerance.
    pub capped: u32,
    /// Sub-steps in a frame of the reference, and the distance of a run in half as many from it.
    pub reference_steps: u32,
    /// See `reference_steps`.
    pub reference: f64,
    /// Nodes.
    pub nodes: usize,
    /// Springs.
    pub springs: usize,
    /// What computed, in words.
    pub device: String,
}

impl Run {
    /// What is kept of a run.
    pub fn read(value: &Value) -> Option<Self> {
        Self::deserialize(value).ok()
    }

    /// Whether it neither blew up nor crumpled.
    pub fn holds(&self) -> bool {
        self.error.is_some() && self.max_stretch < self.reference_stretch + SMOOTH
    }

    /// Median wall time of a simulated second [ms].
    pub fn cost(&self) -> Option<f64> {
        self.wall_ms.map(|[_, median, _]| median)
    }
}

/// What runs frames from the start on.
trait Runner {
    /// Back to the start.
    fn restart(&mut self) -> Result<(), String>;
    /// A frame; whether it is good.
    fn frame(&mut self) -> bool;
    /// Places of all nodes [m].
    fn places(&self) -> Vec<[f64; 3]>;
    /// Largest l/L.
    fn max_stretch(&self) -> f64;
    /// Energy [J].
    fn energy(&self) -> f64;
    /// Most iterations of a sub-step in the last frame, and sub-steps that ended beyond the tolerance.
    fn iterations(&self) -> [u32; 2];
    /// What it is.
    fn described(&self) -> Described;
}

/// What runs.
struct Described {
    /// On which it runs, in words.
    device: String,
    springs: usize,
    threads: usize,
}

/// Runs what an entry says.
///
/// # Errors
/// Where the scene cannot be built. A run that blows up is a result.
pub fn run(entry: &Entry, reference: &Reference) -> Result<Run, String> {
    let Entry { case, method, steps } = *entry;
    let mut runner = runner(entry)?;
    let Described { device, springs, threads } = runner.described();
    let mut run = Run {
        scene: case.name.to_owned(),
        method,
        steps,
        step: FRAME / f64::from(steps),
        bits: if method == Method::Rk4F64 { 64 } else { 32 },
        threads,
        seconds: case.seconds(),
        reference_stretch: reference.max_stretch,
        reference_steps: reference.steps,
        reference: reference.halved,
        nodes: reference.frames[0].len(),
        springs,
        device,
        ..Run::default()
    };
    measure(&mut *runner, reference, &mut run);
    if run.diverged.is_none() {
        let least = if case.steps.is_some() { 1 } else { LEAST };
        time(&mut *runner, (case.frames, least), &mut run)?;
    }
    Ok(run)
}

fn runner(entry: &Entry) -> Result<Box<dyn Runner>, String> {
    let Entry { case, method, steps } = *entry;
    Ok(match method {
        Method::Rk4 => Box::new(Plain::<f32>::new(case, steps)?),
        Method::Rk4F64 => Box::new(Plain::<f64>::new(case, steps)?),
        _ => Box::new(Engine::new(case.simulation(method, steps, Precision::F32)?)),
    })
}

/// Everything but times.
fn measure(runner: &mut dyn Runner, reference: &Reference, run: &mut Run) {
    let energy = runner.energy();
    let (mut distance, mut sum) = (Distance::new(&reference.frames), 0.0);
    for frame in 1..reference.frames.len() as u32 {
        if !runner.frame() {
            run.diverged = Some(frame);
            return;
        }
        distance.add(&runner.places());
        run.max_stretch = run.max_stretch.max(runner.max_stretch());
        let [most, capped] = runner.iterations();
        sum += f64::from(most);
        run.iterations = (sum / f64::from(frame), run.iterations.1.max(most));
        run.capped += capped;
    }
    run.error = Some(distance.relative());
    run.energy = Some((runner.energy() - energy - reference.gained) / reference.kinetic);
}

/// Runs it again and again; only frames are timed.
fn time(runner: &mut dyn Runner, (frames, least): (u32, usize), run: &mut Run) -> Result<(), String> {
    let mut walls = Vec::new();
    while walls.len() < REPEATS && (walls.len() < least || walls.iter().sum::<f64>() < ENOUGH) {
        runner.restart()?;
        let start = Instant::now();
        let good = (0..frames).all(|_| runner.frame());
        walls.push(start.elapsed().as_secs_f64());
        if !good {
            return Err(format!("{}: a run that held did not when it was run again", run.scene));
        }
    }
    walls.sort_by(f64::total_cmp);
    run.runs = walls.len();
    run.wall_ms = Some([0, walls.len() / 2, walls.len() - 1].map(|index| 1e3 * walls[index] / run.seconds));
    Ok(())
}

/// A simulation of the engine.
struct Engine {
    simulation: Simulation,
    start: taffeta::Snapshot,
}

impl Engine {
    fn new(simulation: Simulation) -> Self {
        Self { start: simulation.snapshot(), simulation }
    }

    fn report(&self) -> &FrameReport {
        self.simulation.report()
    }
}

impl Runner for Engine {
    fn restart(&mut self) -> Result<(), String> {
        self.simulation.restore(&self.start).map_err(|error| error.to_string())
    }
    fn frame(&mut self) -> bool {
        self.simulation.step().is_ok()
    }
    fn places(&self) -> Vec<[f64; 3]> {
        let mut places = Vec::new();
        self.simulation.positions_f64(&mut places);
        places
    }
    fn max_stretch(&self) -> f64 {
        self.report().max_stretch
    }
    fn energy(&self) -> f64 {
        self.report().energy()
    }
    fn iterations(&self) -> [u32; 2] {
        [self.report().solver.iterations, self.report().solver.capped]
    }
    fn described(&self) -> Described {
        let simulation = &self.simulation;
        let springs = simulation.bodies().iter().flat_map(|body| &body.springs).map(|(_, count)| count);
        Described { device: simulation.device(), springs: springs.sum(), threads: simulation.threads() }
    }
}

/// The plain method of Runge and Kutta.
struct Plain<T> {
    system: super::rk4::System<T>,
    start: State<T>,
    state: State<T>,
    room: Room<T>,
    steps: u32,
}

impl<T: Number> Plain<T> {
    fn new(case: &Case, steps: u32) -> Result<Self, String> {
        let (system, start) = case.system()?;
        let start = State::of(&start);
        Ok(Self { system, state: start.clone(), room: Room::new(start.x.len()), start, steps })
    }
}

impl<T: Number> Runner for Plain<T> {
    fn restart(&mut self) -> Result<(), String> {
        self.state.clone_from(&self.start);
        Ok(())
    }
    fn frame(&mut self) -> bool {
        let h = T::of(FRAME / f64::from(self.steps));
        (0..self.steps).for_each(|_| self.system.step(&mut self.state, &mut self.room, h));
        // As the engine does after a frame.
        self.state.is_finite() && self.max_stretch() < RUNAWAY
    }
    fn places(&self) -> Vec<[f64; 3]> {
        self.state.places()
    }
    fn max_stretch(&self) -> f64 {
        self.system.max_stretch(&self.state)
    }
    fn energy(&self) -> f64 {
        self.system.energy(&self.state)
    }
    fn iterations(&self) -> [u32; 2] {
        [0; 2]
    }
    fn described(&self) -> Described {
        Described { device: "cpu, 1 thread, plain".to_owned(), springs: self.system.springs(), threads: 1 }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::tournament::reference;
    use crate::tournament::scenes::{CASES, SHEETS};

    #[test]
    fn explicit_methods_hold_in_the_fewest_steps_and_in_half_of_them_they_do_not() {
        for case in &CASES {
            for (method, fewest) in [Method::Springs, Method::Rk4F64].into_iter().zip(case.fewest) {
                let holds = |steps| {
                    let mut runner = runner(&Entry { case, method, steps }).unwrap();
                    (0..case.frames / 2).all(|_| runner.frame())
                };
                assert!(holds(fewest) && !holds(fewest / 2), "{} {method:?}", case.name);
            }
        }
    }

    #[test]
    fn errors_shrink_with_the_step_as_each_method_promises() {
        let folder = tempfile::tempdir().unwrap();
        let case = Case::named("chain-soft").unwrap();
        let reference = reference::of(case, folder.path()).unwrap();
        let error = |method, steps| run(&Entry { case, method, steps }, &reference).unwrap().error.unwrap();
        for (method, steps, ratio) in [
            (Method::Springs, 25, 2.0),
            (Method::Dual, 16, 2.0),
            (Method::Primal, 16, 2.0),
            (Method::Acad, 25, 2.0),
            (Method::Rk4F64, 18, 16.0),
        ] {
            let [coarse, fine] = [steps, 2 * steps].map(|steps| error(method, steps));
            assert!((coarse / fine / ratio - 1.0).abs() < 0.1, "{method:?}: {coarse:e}, {fine:e}");
        }
    }

    #[test]
    fn implicit_springs_of_a_sheet_come_nearer_to_its_reference_in_shorter_steps() {
        let folder = tempfile::tempdir().unwrap();
        let case: &Case = Box::leak(Box::new(SHEETS[0].shortened(3)));
        let reference = reference::of(case, folder.path()).unwrap();
        assert!(reference.halved < 1e-4, "{}", reference.halved);
        let made = |method, steps| run(&Entry { case, method, steps }, &reference).unwrap();
        let error = |method, steps| made(method, steps).error.unwrap();
        assert!(error(Method::Springs, 88) < 1e-3 && error(Method::Dual, 16) < 1e-2);
        assert!(error(Method::Primal, 1) > 2.0 * error(Method::Primal, 4));
        // To the tolerance, however many iterations that takes.
        let solved = made(Method::DualSolved, 1);
        assert!(solved.capped == 0 && solved.iterations.1 > 0, "{solved:?}");
    }

    #[test]
    fn the_engine_starts_where_the_plain_method_does() {
        for case in &CASES {
            let of = |method| runner(&Entry { case, method, steps: 100 }).unwrap();
            let [engine, plain] = [Method::Springs, Method::Rk4F64].map(of);
            let distance = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (a[i] - b[i]).abs()).sum::<f64>();
            let off = engine.places().iter().zip(&plain.places()).map(distance).fold(0.0, f64::max);
            assert!(off < 1e-6, "{}: {off:e}", case.name);
            let scale = plain.energy().abs() + 0.1;
            assert!((engine.energy() - plain.energy()).abs() < 1e-4 * scale, "{}", case.name);
            assert!((engine.max_stretch() - plain.max_stretch()).abs() < 1e-4, "{}", case.name);
            assert_eq!(engine.described().springs, plain.described().springs, "{}", case.name);
        }
    }
}
