//! What a scene does, as exactly as it can be had: the classical method of Runge and Kutta in 64 bits and short steps, kept in a
//! file; and how far a run is from it.

use super::Method;
use super::rk4::{Room, State};
use super::scenes::{Case, FRAME, FRAMES};
use serde::{Deserialize, Serialize};
use std::fs;
use std::path::Path;

/// How often as many steps the reference takes as are just stable.
const FINER: u32 = 16;

/// What is known of a scene's motion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Reference {
    /// The scene, as JSON.
    scene: String,
    /// Sub-steps in a frame.
    pub steps: u32,
    /// The start, and places of all nodes after each frame [m].
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
    let file = folder.join(format!("tournament-{}.json", case.name));
    let steps = FINER * case.fewest[1];
    let scene = described(case)?;
    let kept = fs::read(&file).ok().and_then(|bytes| serde_json::from_slice::<Reference>(&bytes).ok());
    if let Some(kept) = kept.filter(|kept| kept.scene == scene && kept.steps == steps) {
        return Ok(kept);
    }
    let mut reference = follow(case, steps)?;
    let half = follow(case, steps / 2)?;
    let mut distance = Distance::new(&reference.frames);
    half.frames[1..].iter().for_each(|places| distance.add(places));
    reference.halved = distance.relative();
    let told = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    let bytes = serde_json::to_vec(&reference).map_err(|error| told(&error))?;
    let part = file.with_extension("part");
    fs::create_dir_all(folder).map_err(|error| told(&error))?;
    fs::write(&part, bytes).and_then(|()| fs::rename(&part, &file)).map_err(|error| told(&error))?;
    Ok(reference)
}

/// All that a reference depends on: the scene, and the start, in JSON.
fn described(case: &Case) -> Result<String, String> {
    let (_, start) = case.system::<f64>()?;
    let all = (case.scene(Method::Springs, 1), start.x, start.v);
    serde_json::to_string(&all).map_err(|error| error.to_string())
}

/// Runs all frames.
fn follow(case: &Case, steps: u32) -> Result<Reference, String> {
    let (system, mut state) = case.system::<f64>()?;
    let mut room = Room::new(state.x.len());
    let (energy, mut kinetic, mut max_stretch) = (system.energy(&state), system.kinetic(&state), 0.0_f64);
    let mut frames = vec![state.x.clone()];
    for _ in 0..FRAMES {
        (0..steps).for_each(|_| system.step(&mut state, &mut room, FRAME / f64::from(steps)));
        kinetic = kinetic.max(system.kinetic(&state));
        max_stretch = max_stretch.max(system.max_stretch(&state));
        frames.push(State::places(&state));
    }
    if !state.is_finite() {
        return Err(format!("{}: {steps} steps in a frame are too few for a reference", case.title));
    }
    let gained = system.energy(&state) - energy;
    Ok(Reference { scene: described(case)?, steps, frames, kinetic, gained, max_stretch, halved: 0.0 })
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
        let file = folder.path().join("tournament-chain-soft.json");
        let when = fs::metadata(&file).unwrap().modified().unwrap();
        assert!(of(case, folder.path()).unwrap() == made);
        assert_eq!(fs::metadata(&file).unwrap().modified().unwrap(), when);
        // The error of the reference is a fifteenth of this.
        assert!(made.halved < 1e-6, "{:e}", made.halved);
    }
}
