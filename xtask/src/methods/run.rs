//! One run beside the reference, and the line that is kept of it.

use super::cell::{Cell, FRAME};
use super::cloth;
use super::reference::{Distance, Reference};
use super::way::Way;
use crate::lines::Line;
use serde::{Deserialize, Serialize};
use std::time::Instant;
use taffeta::diagnostics::FrameReport;
use taffeta::{Precision, Simulation};
use taffeta_io::program::processor;

/// Times that a short run is run, at most.
const REPEATS: usize = 5;
/// Seconds after which it is not run again.
const ENOUGH: f64 = 3.0;
/// Stretch beyond that of the reference [1] up to which a sheet is one: waves of the spacing of nodes, which grow where a step is
/// too long for what hangs in a sheet, hardly show in the error.
pub const SMOOTH: f64 = 0.05;
/// Frames that all sizes have.
pub const EARLY: u32 = 2;

/// A run in numbers: a line of `runs.jsonl`.
#[derive(Clone, Default, Serialize, Deserialize)]
pub struct Run {
    pub size: String,
    pub side: u32,
    /// Stiffness [N/m].
    pub k: f64,
    pub way: Way,
    /// Sub-steps in a frame.
    pub steps: u32,
    /// Simulated time [s].
    pub seconds: f64,
    /// The frame in which it blew up.
    pub diverged: Option<u32>,
    /// Distance from the reference by how far it moved, over the first frames and over all; of what did not blow up.
    pub early_error: Option<f64>,
    pub error: Option<f64>,
    /// The same, of a run as the reference in twice its steps.
    pub reference: f64,
    /// Wall time of a simulated second [s]: least, median and most of so many runs.
    pub wall: [f64; 3],
    pub runs: usize,
    /// Largest l/L after any frame, and that of the reference.
    pub max_stretch: f64,
    pub reference_stretch: f64,
    /// Energy at the end beyond that of the reference, by the energy of the motion at the start.
    pub energy: f64,
    /// Iterations: mean over frames of the most in a sub-step, and the most.
    pub iterations: (f64, u32),
    /// Sub-steps that ended beyond the tolerance, and the largest residual by the right side.
    pub capped: u32,
    pub residual: f64,
    pub nodes: usize,
    pub springs: usize,
    pub threads: usize,
    /// The processor in words.
    pub machine: String,
    pub device: String,
    pub commit: String,
}

/// What a pass over all frames has shown.
#[derive(Default)]
struct Pass {
    reports: Vec<FrameReport>,
    /// Wall time of the frames [s].
    wall: f64,
    diverged: Option<u32>,
}

/// Runs a cell in one way, with so many sub-steps in a frame, on the CPU in 32 bits.
///
/// # Errors
/// Where the scene cannot be built. A run that blows up is a result.
pub fn run(cell: &Cell, way: Way, steps: u32, reference: &Reference, commit: &str) -> Result<Run, String> {
    let mut simulation = cloth::swinging(&cloth::scene(cell, way, steps), Precision::F32, false)?;
    let (start, energy) = (simulation.snapshot(), simulation.report().energy());
    let (mut distance, mut places, mut early_error) = (Distance::new(reference), Vec::new(), None);
    let first = pass(&mut simulation, cell.size.frames, |simulation| {
        simulation.positions_f64(&mut places);
        distance.add(&places);
        if simulation.frame() == EARLY {
            early_error = Some(distance.relative());
        }
    });
    let mut walls = vec![first.wall];
    while first.diverged.is_none() && walls.len() < REPEATS && walls.iter().sum::<f64>() < ENOUGH {
        simulation.restore(&start)?;
        walls.push(pass(&mut simulation, cell.size.frames, |_| ()).wall);
    }
    walls.sort_by(f64::total_cmp);
    let head = &reference.head;
    let gained = first.reports.last().map_or(0.0, |report| report.energy() - energy);
    let bodies = simulation.bodies();
    Ok(Run {
        size: cell.size.name.to_owned(),
        side: cell.size.side,
        k: cell.k,
        way,
        steps,
        seconds: cell.seconds(),
        diverged: first.diverged,
        early_error,
        error: first.diverged.is_none().then(|| distance.relative()),
        reference: head.doubled,
        reference_stretch: head.max_stretch,
        wall: [0, walls.len() / 2, walls.len() - 1].map(|index| walls[index] / cell.seconds()),
        runs: walls.len(),
        energy: (gained - head.gained) / head.kinetic,
        nodes: bodies.iter().map(|body| body.nodes).sum(),
        springs: bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum(),
        threads: simulation.threads(),
        machine: processor(),
        device: simulation.device(),
        commit: commit.to_owned(),
        ..summary(&first.reports)
    })
}

/// Runs all frames, and shows each; only the frames themselves are timed.
fn pass(simulation: &mut Simulation, frames: u32, mut show: impl FnMut(&Simulation)) -> Pass {
    let mut pass = Pass::default();
    for frame in 1..=frames {
        let start = Instant::now();
        let done = simulation.step().cloned();
        pass.wall += start.elapsed().as_secs_f64();
        let Ok(report) = done else {
            pass.diverged = Some(frame);
            break;
        };
        pass.reports.push(report);
        show(simulation);
    }
    pass
}

/// The numbers of all frames.
fn summary(reports: &[FrameReport]) -> Run {
    let solvers = || reports.iter().map(|report| report.solver);
    let sum = solvers().map(|solver| f64::from(solver.iterations)).fold(0.0, |sum, most| sum + most);
    Run {
        max_stretch: reports.iter().map(|report| report.max_stretch).fold(0.0, f64::max),
        iterations: (
            sum / reports.len().max(1) as f64,
            solvers().map(|solver| solver.iterations).max().unwrap_or(0),
        ),
        capped: solvers().map(|solver| solver.capped).sum(),
        residual: solvers().map(|solver| solver.residual).fold(0.0, f64::max),
        ..Run::default()
    }
}

impl Run {
    /// Length of a sub-step [s].
    pub fn step(&self) -> f64 {
        FRAME / f64::from(self.steps)
    }

    /// Median wall time of a simulated second [s].
    pub fn cost(&self) -> f64 {
        self.wall[1]
    }

    /// Whether it neither blew up nor got as rough as no cloth is.
    pub fn holds(&self) -> bool {
        self.error.is_some() && self.max_stretch < self.reference_stretch + SMOOTH
    }

    /// What is run, in the order of tables.
    pub fn key(&self) -> (u32, u64, Way, u32) {
        // Bits of positive numbers are in their order.
        (self.side, self.k.to_bits(), self.way, self.steps)
    }

    /// How the run went.
    pub fn words(&self) -> String {
        let Self { size, k, way, steps, energy, max_stretch, iterations: (mean, most), capped, .. } = self;
        let what = format!("{size}, {k} N/m, {}, {steps} a frame", way.label());
        let Some(error) = self.error else {
            return format!("{what}: blew up in frame {}", self.diverged.unwrap_or_default());
        };
        format!(
            "{what}: off by {error:.1e}, {:.3} s a second, stretch {max_stretch:.3}, energy {energy:+.3}, {mean:.1} iterations \
             (at most {most}), stopped early: {capped}",
            self.cost()
        )
    }
}

impl Line for Run {
    const FILE: &str = "runs.jsonl";
    fn same(&self, other: &Self) -> bool {
        self.key() == other.key()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::cell::{QUICK, Size};
    use crate::methods::reference;

    #[test]
    fn small_steps_are_near_the_reference_and_explicit_springs_in_one_step_blow_up() {
        let cell = Cell { size: Size { side: 8, frames: 2, ..QUICK[0] }, k: 1e4 };
        let fewest = cloth::fewest_steps(&cell).unwrap_or(1);
        let reference = reference::run(&cell, fewest, String::new()).ok();
        let of = |way, steps| run(&cell, way, steps, reference.as_ref()?, "").ok();
        let error = |way, steps| of(way, steps).and_then(|run| run.error).unwrap_or(f64::NAN);
        assert!(error(Way::Springs, fewest) < 1e-3 && error(Way::Dual, 16) < 1e-2);
        assert!(error(Way::Dual, 1) > 4.0 * error(Way::Dual, 16));
        assert!(of(Way::Springs, 1).is_some_and(|run| run.diverged.is_some()));
        let runs = of(Way::Dual, 1).map(|run| (run.runs, run.wall[0] <= run.wall[2]));
        assert_eq!(runs, Some((REPEATS, true)));
    }
}
