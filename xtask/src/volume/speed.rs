//! What keeping a volume costs: the same bodies by springs alone and with each form, in turns.

use super::experiment::Experiment;
use crate::lines::Line;
use serde::{Deserialize, Serialize};
use std::time::Instant;
use taffeta::scene::VolumeForm;
use taffeta::{Options, Simulation};
use taffeta_io::program::processor;

/// The forms that are compared, that without a volume first.
const FORMS: [VolumeForm; 3] = [VolumeForm::None, VolumeForm::Corrected, VolumeForm::Projected];
/// Rounds, and the time in which a form has its turn in each [s], about.
const ROUNDS: (usize, f64) = (25, 0.05);
/// How far nodes start from their places [m], so that volumes change.
const DISTURBANCE: f64 = 1e-4;

/// The bodies of an experiment on a number of threads: a line of `speeds.jsonl`.
#[derive(Clone, Serialize, Deserialize)]
pub struct Speed {
    pub scene: String,
    pub threads: usize,
    pub triangles: usize,
    pub springs: usize,
    /// Sub-steps a second with each form: the median over all rounds.
    pub steps_per_s: [f64; 3],
    /// What the second and third form take, by the first: the median, and the quartiles, over all rounds.
    pub ratio: [[f64; 3]; 2],
    /// The processor in words.
    pub machine: String,
    pub device: String,
    pub commit: String,
}

impl Line for Speed {
    const FILE: &str = "speeds.jsonl";
    fn same(&self, other: &Self) -> bool {
        self.scene == other.scene && self.threads == other.threads
    }
}

/// Times the bodies of an experiment in free fall: so all forms do the same, and no number becomes so small that
/// processors are slow with it.
pub fn measure(experiment: &Experiment, threads: usize, commit: &str) -> Result<Speed, String> {
    let mut scene = experiment.load()?.scene;
    (scene.colliders, scene.world.gravity) = (Vec::new(), [0.0, -9.81, 0.0]);
    let substeps = f64::from(scene.time.substeps());
    let mut simulations = Vec::new();
    for form in FORMS {
        let kept = scene.bodies.iter_mut().filter_map(|body| body.volume.as_mut());
        kept.for_each(|volume| volume.form = form);
        let options = Options { threads: Some(threads), ..Options::default() };
        let mut simulation = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
        simulation.disturb(DISTURBANCE, 1);
        simulations.push(simulation);
    }
    let turns: Vec<u32> = simulations
        .iter_mut()
        .map(|one| Ok((ROUNDS.1 / frames(one, 1)?) as u32 + 1))
        .collect::<Result<_, String>>()?;
    let mut seconds = [const { Vec::new() }; 3];
    for _ in 0..ROUNDS.0 {
        for ((simulation, &turn), seconds) in simulations.iter_mut().zip(&turns).zip(&mut seconds) {
            seconds.push(frames(simulation, turn)?);
        }
    }
    let ratio = |form: usize| {
        let ratios: Vec<f64> =
            seconds[form].iter().zip(&seconds[0]).map(|(with, without)| with / without).collect();
        [0.5, 0.25, 0.75].map(|share| quantile(&ratios, share))
    };
    let bodies = simulations[0].bodies();
    Ok(Speed {
        scene: experiment.scene.to_owned(),
        threads,
        triangles: bodies.iter().map(|body| body.triangles).sum(),
        springs: bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum(),
        steps_per_s: seconds.each_ref().map(|seconds| substeps / quantile(seconds, 0.5)),
        ratio: [ratio(1), ratio(2)],
        machine: processor(),
        device: simulations[0].device(),
        commit: commit.to_owned(),
    })
}

/// Time of one of some frames [s].
fn frames(simulation: &mut Simulation, count: u32) -> Result<f64, String> {
    let start = Instant::now();
    simulation.advance(count).map_err(|error| error.to_string())?;
    Ok(start.elapsed().as_secs_f64() / f64::from(count))
}

fn quantile(values: &[f64], share: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * share).round() as usize]
}

impl Speed {
    /// What was measured.
    pub fn words(&self) -> String {
        let [springs, kept, projected] = self.steps_per_s.map(|rate| rate.round());
        format!("{}, {}: {springs}, {kept}, {projected} sub-steps/s", self.scene, self.device)
    }
}

#[cfg(test)]
mod tests {
    use super::quantile;

    #[test]
    fn quartiles_are_those_of_sorted_values() {
        let values = [5.0, 1.0, 4.0, 2.0, 3.0];
        assert_eq!([0.25, 0.5, 0.75].map(|share| quantile(&values, share)), [2.0, 3.0, 4.0]);
    }
}
