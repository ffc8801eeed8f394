//! What a scene does, as exactly as it can be had, kept in a file; and how far a run is from it.
//!
//! Of a small scene it is the classical method of Runge and Kutta in 64 bits and short steps; of a large sheet explicit springs in
//! 64 bits, in half the steps that are just stable, started half a step early, which makes places exact to second order.

use super::rk4::{Room, State};
use super::scenes::{Case, FRAME};
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::{self, BufRead, BufReader, BufWriter, Read, Write};
use std::path::Path;

/// How often as many steps as are just stable the reference takes: by the method of Runge and Kutta, and by explicit springs.
const FINER: [u32; 2] = [16, 2];

/// What is known of a scene's motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// A hash of the scene and its start.
    scene: String,
    /// Sub-steps in a frame.
    pub steps: u32,
    /// Nodes.
    nodes: usize,
    /// The start, and places of all nodes after each frame [m].
    #[serde(skip)]
    pub frames: Vec<Vec<[f64; 3]>>,
    /// The largest kinetic energy of the start and after frames [J].
    pub kinetic: f64,
    /// Energy won until the end [J].
    pub gained: f64,
    /// Largest l/L after any frame.
    pub max_stretch: f64,
    /// How far off a run in half as many steps is.
    pub halved: f64,
}

/// Distance from a reference, over nodes and frames.
pub struct Distance<'a> {
    reference: &'a [Vec<[f64; 3]>],
    frame: usize,
    off: f64,
    moved: f64,
}

impl<'a> Distance<'a> {
    /// From the start of `reference` on: places at the start, and after each frame.
    pub fn new(reference: &'a [Vec<[f64; 3]>]) -> Self {
        Self { reference, frame: 0, off: 0.0, moved: 0.0 }
    }

    /// Takes the places after the next frame.
    pub fn add(&mut self, places: &[[f64; 3]]) {
        self.frame += 1;
        let (start, exact) = (&self.reference[0], &self.reference[self.frame]);
        self.off += squares(exact, places);
        self.moved += squares(exact, start);
    }

    /// √(Σ |x − x_ref|²/Σ |x_ref − x_start|²) over the nodes and frames so far.
    pub fn relative(&self) -> f64 {
        (self.off / self.moved).sqrt()
    }
}

fn squares(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    let square = |(a, b): (&[f64; 3], &[f64; 3])| (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
    a.iter().zip(b).map(square).sum()
}

/// The reference of a scene: the one that `folder` has, or a new one, which is kept there.
///
/// # Errors
/// Where it cannot be run or kept.
pub fn of(case: &Case, folder: &Path) -> Result<Reference, String> {
    let file = folder.join(format!("tournament-{}.bin", case.name));
    let steps = match case.steps {
        None => FINER[0] * case.fewest[1],
        Some(_) => FINER[1] * case.fewest[0],
    };
    let scene = case.hash()?;
    let kept = read(&file, case.frames).ok();
    if let Some(kept) = kept.filter(|kept| kept.scene == scene && kept.steps == steps) {
        return Ok(kept);
    }
    let follow = |steps| match case.steps {
        None => by_runge_and_kutta(case, steps),
        Some(_) => by_springs(case, steps),
    };
    let mut reference = Reference { scene, ..follow(steps)? };
    let half = follow(steps / 2)?;
    let mut distance = Distance::new(&reference.frames);
    half.frames[1..].iter().for_each(|places| distance.add(places));
    reference.halved = distance.relative();
    fs::create_dir_all(folder)
        .and_then(|()| write(&file, &reference))
        .map_err(|error| format!("{}: {error}", file.display()))?;
    Ok(reference)
}

/// A line of JSON, then all places.
fn write(file: &Path, reference: &Reference) -> io::Result<()> {
    let part = file.with_extension("part");
    let mut out = BufWriter::new(File::create(&part)?);
    writeln!(out, "{}", serde_json::to_string(reference)?)?;
    let numbers = reference.frames.iter().flatten().flatten();
    numbers.into_iter().try_for_each(|number| out.write_all(&number.to_le_bytes()))?;
    out.flush()?;
    fs::rename(&part, file)
}

/// What [`write`] wrote of so many frames.
fn read(file: &Path, frames: u32) -> io::Result<Reference> {
    let mut input = BufReader::new(File::open(file)?);
    let mut line = String::new();
    input.read_line(&mut line)?;
    let mut reference: Reference = serde_json::from_str(&line)?;
    let mut bytes = [0; 8];
    let mut number = || input.read_exact(&mut bytes).map(|()| f64::from_le_bytes(bytes));
    let mut place = || Ok([number()?, number()?, number()?]);
    let mut frame = || (0..reference.nodes).map(|_| place()).collect::<io::Result<Vec<_>>>();
    reference.frames = (0..=frames).map(|_| frame()).collect::<io::Result<_>>()?;
    Ok(reference)
}

/// Runs all frames by the method of Runge and Kutta.
fn by_runge_and_kutta(case: &Case, steps: u32) -> Result<Reference, String> {
    let (system, mut state) = case.system::<f64>()?;
    let mut room = Room::new(state.x.len());
    let (energy, mut kinetic, mut max_stretch) = (system.energy(&state), system.kinetic(&state), 0.0_f64);
    let mut frames = vec![state.x.clone()];
    for _ in 0..case.frames {
        (0..steps).for_each(|_| system.step(&mut state, &mut room, FRAME / f64::from(steps)));
        kinetic = kinetic.max(system.kinetic(&state));
        max_stretch = max_stretch.max(system.max_stretch(&state));
        frames.push(State::places(&state));
    }
    if !state.is_finite() {
        return Err(format!("{}: {steps} steps in a frame are too few for a reference", case.title));
    }
    let gained = system.energy(&state) - energy;
    let (scene, nodes) = (String::new(), state.x.len());
    Ok(Reference { scene, steps, nodes, frames, kinetic, gained, max_stretch, halved: 0.0 })
}

/// Runs all frames by explicit springs.
fn by_springs(case: &Case, steps: u32) -> Result<Reference, String> {
    let mut simulation = case.verlet(steps)?;
    let (mut kinetic, energy) = (simulation.report().kinetic, simulation.report().energy());
    let mut max_stretch = 1.0_f64;
    let mut places = Vec::new();
    simulation.positions_f64(&mut places);
    let mut frames = vec![places.clone()];
    for _ in 0..case.frames {
        let report = simulation.step().map_err(|error| format!("{}, {steps} steps: {error}", case.title))?;
        kinetic = kinetic.max(report.kinetic);
        max_stretch = max_stretch.max(report.max_stretch);
        simulation.positions_f64(&mut places);
        frames.push(places.clone());
    }
    let gained = simulation.report().energy() - energy;
    let (scene, nodes) = (String::new(), places.len());
    Ok(Reference { scene, steps, nodes, frames, kinetic, gained, max_stretch, halved: 0.0 })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_relative_to_how_far_nodes_moved() {
        let exact = [vec![[0.0; 3]; 2], vec![[3.0, 0.0, 4.0]; 2], vec![[0.0, 5.0, 0.0]; 2]];
        let mut distance = Distance::new(&exact);
        distance.add(&[[3.0, 0.0, 4.0], [3.0, 0.5, 4.0]]);
        assert!((distance.relative() - (0.25_f64 / 50.0).sqrt()).abs() < 1e-15);
        distance.add(&[[0.0, 5.0, 0.5], [0.0, 5.0, 0.0]]);
        assert!((distance.relative() - (0.5_f64 / 100.0).sqrt()).abs() < 1e-15);
    }

    #[test]
    fn a_reference_is_run_once_and_then_read_bit_by_bit() {
        let folder = tempfile::tempdir().unwrap();
        let case = Case::named("chain-soft").unwrap();
        let made = of(case, folder.path()).unwrap();
        let file = folder.path().join("tournament-chain-soft.bin");
        let when = fs::metadata(&file).unwrap().modified().unwrap();
        assert!(of(case, folder.path()).unwrap() == made);
        assert_eq!(fs::metadata(&file).unwrap().modified().unwrap(), when);
        // The error of the reference is a fifteenth of this.
        assert!(made.halved < 1e-6, "{:e}", made.halved);
    }
}
