//! What springs as constraints cost: figures 9 and 10, the goal, and the cost by the number of constraints.

use super::experiment::{ALL_KINDS, TWO_KINDS, command, load, of_kinds};
use crate::lines::{self, Line};
use crate::program;
use crate::results::measure;
use serde::{Deserialize, Serialize};
use std::path::Path;
use std::time::Instant;
use taffeta::{Options, Simulation};
use taffeta_io::program::processor;

/// A scene whose steps are timed while the cloth touches something.
pub struct Timing {
    /// What the user calls it.
    pub name: &'static str,
    /// In the table.
    pub label: &'static str,
    pub scene: &'static str,
    /// What differs from the scene.
    pub sets: Vec<String>,
    /// Frames a second that Va, Choi and Hong 2021 publish (GTX 1070, drawing included).
    pub published: Option<f64>,
}

/// Stiffness of all springs of the constraints of figure 9 [N/m].
const STIFF: f64 = 2e4;
/// Runs, of which the middle one counts.
const RUNS: usize = 3;
/// Time that is run [s].
const SECONDS: f64 = 4.8;
/// Sides of the sheets whose cost is compared: the last has about a million constraints.
const SIDES: [u32; 6] = [34, 64, 102, 204, 289, 409];

/// All of them.
pub fn all() -> Vec<Timing> {
    let fig9 = |label, side: u32, kinds: &[&str], published| Timing {
        name: "fig9",
        label,
        scene: "s1_fig14",
        sets: vec![
            format!("body.cloth.mesh.grid.rows={side}"),
            format!("body.cloth.mesh.grid.cols={side}"),
            "body.cloth.node_mass=0.1".to_owned(),
            of_kinds("cloth", kinds, STIFF, 0.1),
            "solver.ice.max_iterations=2000".to_owned(),
        ],
        published: Some(published),
    };
    let fig10 = |label, method: &str, published| Timing {
        name: "fig10",
        label,
        scene: "s1_fig13",
        sets: vec![format!("solver.method={method}"), of_kinds("cloth", &ALL_KINDS, 1000.0, 0.1)],
        published,
    };
    let large =
        |label, sets: Vec<String>| Timing { name: "fig10", label, scene: "s1_fig15", sets, published: None };
    vec![
        fig9("ICE, all springs", 34, &ALL_KINDS, 31.95),
        fig9("ICE, structural and shear", 32, &TWO_KINDS, 66.06),
        fig9("ICE, structural and shear", 38, &TWO_KINDS, 44.25),
        fig10("springs, 5 ms, 1,000 N/m", "springs", Some(222.46)),
        fig10("ACAD, 5 ms, 1,000 N/m", "acad", Some(206.44)),
        fig10("ICE, 5 ms, 1,000 N/m", "ice", None),
        large("ACAD, 16 ms, 200 N/m", Vec::new()),
        large("ICE, 16 ms, 200 N/m", vec!["solver.method=ice".to_owned()]),
    ]
}

/// Numbers of threads that are timed.
pub fn threads() -> Vec<usize> {
    let mut threads = vec![1, std::thread::available_parallelism().map_or(1, usize::from)];
    threads.dedup();
    threads
}

/// A timing on a number of threads: a line of `speeds.jsonl`.
#[derive(Clone, Serialize, Deserialize)]
pub struct Speed {
    pub command: String,
    pub threads: usize,
    pub nodes: usize,
    pub springs: usize,
    /// Steps in which nodes touched something.
    pub steps: usize,
    /// Mean of those [ms]: of the runs the middle one.
    pub ms_per_step: f64,
    /// Mean and most over those.
    pub iterations: (f64, u32),
    /// The largest.
    pub residual: f64,
    pub active: f64,
    /// Largest l/L, and the most energy beyond that at the start [J], over all steps.
    pub max_stretch: f64,
    pub energy_gain: f64,
    /// The processor in words.
    pub machine: String,
    pub device: String,
    pub commit: String,
}

impl Line for Speed {
    const FILE: &str = "speeds.jsonl";
    fn same(&self, other: &Self) -> bool {
        self.command == other.command && self.threads == other.threads
    }
}

impl Timing {
    /// The command that runs it.
    pub fn command(&self) -> String {
        command(self.scene, &self.sets)
    }
}

/// Times a scene. Its frames are one step each.
pub fn measure(timing: &Timing, threads: usize, commit: &str) -> Result<Speed, String> {
    let runs: Result<Vec<Speed>, String> = (0..RUNS).map(|_| once(timing, threads, commit)).collect();
    let mut runs = runs?;
    runs.sort_by(|a, b| a.ms_per_step.total_cmp(&b.ms_per_step));
    Ok(runs.swap_remove(RUNS / 2))
}

fn once(timing: &Timing, threads: usize, commit: &str) -> Result<Speed, String> {
    let scene = load(timing.scene, &timing.sets)?.scene;
    let options = Options { threads: Some(threads), ..Options::default() };
    let mut simulation = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
    let (mut seconds, mut solved) = (0.0, Vec::new());
    let (mut max_stretch, mut energy_gain) = (0.0_f64, f64::NEG_INFINITY);
    let start_energy = simulation.report().energy();
    for _ in 0..(SECONDS / scene.time.dt) as u32 {
        let start = Instant::now();
        simulation.step().map_err(|error| error.to_string())?;
        let took = start.elapsed().as_secs_f64();
        let report = simulation.report();
        max_stretch = max_stretch.max(report.max_stretch);
        energy_gain = energy_gain.max(report.energy() - start_energy);
        if report.contacts > 0 {
            seconds += took;
            solved.push(report.solver);
        }
    }
    let steps = solved.len().max(1) as f64;
    let bodies = simulation.bodies();
    Ok(Speed {
        command: timing.command(),
        threads,
        nodes: bodies.iter().map(|body| body.nodes).sum(),
        springs: bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum(),
        steps: solved.len(),
        ms_per_step: seconds * 1e3 / steps,
        iterations: (
            solved.iter().map(|report| f64::from(report.iterations)).sum::<f64>() / steps,
            solved.iter().map(|report| report.iterations).max().unwrap_or(0),
        ),
        residual: solved.iter().map(|report| report.residual).fold(0.0, f64::max),
        active: solved.iter().map(|report| report.active_fraction).sum::<f64>() / steps,
        max_stretch,
        energy_gain,
        machine: processor(),
        device: simulation.device(),
        commit: commit.to_owned(),
    })
}

impl Speed {
    /// What was measured.
    pub fn words(&self) -> String {
        format!(
            "{}, {}: {:.3} ms a step, {:.1} iterations",
            self.command, self.device, self.ms_per_step, self.iterations.0
        )
    }
}

/// A bench of a size: a line of `sizes.jsonl`.
#[derive(Clone, Serialize, Deserialize)]
pub struct Size {
    pub command: String,
    pub nodes: usize,
    pub springs: usize,
    pub ms_per_step: f64,
    pub iterations: f64,
    pub residual: f64,
    /// The processor in words.
    pub machine: String,
    pub device: String,
    pub commit: String,
}

impl Line for Size {
    const FILE: &str = "sizes.jsonl";
    fn same(&self, other: &Self) -> bool {
        self.command == other.command
    }
}

/// Measures all sizes with the bench, and keeps a line of each.
pub fn sizes(folder: &Path, commit: &str) -> Result<(), String> {
    if !program::build().arg("--quiet").status().map_err(|error| format!("cargo: {error}"))?.success() {
        return Err("the program was not built".into());
    }
    for side in SIDES {
        let frames = if side > 100 { " --frames 10" } else { "" };
        let words = format!("bench ice --n {side} --backend cpu --json{frames}");
        println!("taffeta {words}");
        let line = measure::bench(&words)?;
        let number =
            |key: &str| line[key].as_f64().ok_or_else(|| format!("taffeta {words}: its line has no {key}"));
        let size = Size {
            command: format!("taffeta {words}"),
            nodes: number("nodes")? as usize,
            springs: number("springs")? as usize,
            ms_per_step: 1e3 / number("steps_per_s")?,
            iterations: number("iterations")?,
            residual: number("residual")?,
            machine: processor(),
            device: line["device"].as_str().unwrap_or_default().to_owned(),
            commit: commit.to_owned(),
        };
        lines::keep(folder, &size)?;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn timings_can_be_read_and_have_the_published_numbers_of_springs() {
        let counts: Vec<usize> = all()
            .iter()
            .map(|timing| {
                let scene = load(timing.scene, &timing.sets).map(|loaded| loaded.scene).unwrap_or_default();
                assert_eq!(scene.time.max_step, Some(scene.time.dt), "{}", timing.label);
                let simulation = Simulation::new(&scene, &Options::default());
                let springs = simulation.map(|simulation| simulation.bodies()[0].springs.clone());
                springs.unwrap_or_default().iter().map(|(_, count)| count).sum()
            })
            .collect();
        assert_eq!(counts, [6598, 3906, 5550, 5826, 5826, 5826, 5826, 5826]);
    }
}
