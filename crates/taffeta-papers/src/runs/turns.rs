//! What keeping a volume costs: the same bodies by springs alone and with each form, in turns.

use crate::runs::scenes;
use serde_json::{Value, json};
use std::time::Instant;
use taffeta::scene::{Scene, VolumeForm};
use taffeta::{Options, Simulation};

/// The bodies of a scene, on so many threads; on as many as help, where nothing is said.
#[derive(Clone, Copy, Debug)]
pub struct Turns {
    /// The file's name without its ending.
    pub scene: &'static str,
    /// Worker threads.
    pub threads: Option<usize>,
}

/// The forms that are compared, that without a volume first.
const FORMS: [VolumeForm; 3] = [VolumeForm::None, VolumeForm::Corrected, VolumeForm::Projected];
/// Rounds, and the time in which a form has its turn in each [s], about.
const ROUNDS: (usize, f64) = (25, 0.05);
/// How far nodes start from their places [m], so that volumes change.
const DISTURBANCE: f64 = 1e-4;

/// Times the bodies of a scene in free fall: so all forms do the same, and no number becomes so small that processors are slow
/// with it.
///
/// # Errors
/// Where it cannot be run.
pub fn run(turns: &Turns) -> Result<Value, String> {
    measure(scenes::load(turns.scene, &[])?.scene, turns.threads, ROUNDS)
}

fn measure(mut scene: Scene, threads: Option<usize>, rounds: (usize, f64)) -> Result<Value, String> {
    (scene.colliders, scene.world.gravity) = (Vec::new(), [0.0, -9.81, 0.0]);
    let mut simulations = Vec::new();
    for form in FORMS {
        let kept = scene.bodies.iter_mut().filter_map(|body| body.volume.as_mut());
        kept.for_each(|volume| volume.form = form);
        let options = Options { threads, ..Options::default() };
        let mut simulation = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
        simulation.disturb(DISTURBANCE, 1);
        simulations.push(simulation);
    }
    let turns = simulations.iter_mut().map(|one| Ok((rounds.1 / frames(one, 1)?) as u32 + 1));
    let turns = turns.collect::<Result<Vec<u32>, String>>()?;
    let mut seconds = [const { Vec::new() }; 3];
    for _ in 0..rounds.0 {
        for ((simulation, &turn), seconds) in simulations.iter_mut().zip(&turns).zip(&mut seconds) {
            seconds.push(frames(simulation, turn)?);
        }
    }
    let ratio = |form: usize| {
        let ratios: Vec<f64> =
            seconds[form].iter().zip(&seconds[0]).map(|(with, without)| with / without).collect();
        [0.5, 0.25, 0.75].map(|part| quantile(&ratios, part))
    };
    let (bodies, substeps) = (simulations[0].bodies(), f64::from(scene.time.substeps()));
    let springs = bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count);
    Ok(json!({
        "device": simulations[0].device(),
        "triangles": bodies.iter().map(|body| body.triangles).sum::<usize>(),
        "springs": springs.sum::<usize>(),
        // With each form: the median over all rounds.
        "steps_per_s": seconds.each_ref().map(|seconds| substeps / quantile(seconds, 0.5)),
        // What the second and third form take, by the first: the median, and the quartiles, over all rounds.
        "ratio": [ratio(1), ratio(2)],
    }))
}

/// Time of one of some frames [s].
fn frames(simulation: &mut Simulation, count: u32) -> Result<f64, String> {
    let start = Instant::now();
    simulation.advance(count).map_err(|error| error.to_string())?;
    Ok(start.elapsed().as_secs_f64() / f64::from(count))
}

fn quantile(values: &[f64], part: f64) -> f64 {
    let mut values = values.to_vec();
    values.sort_by(f64::total_cmp);
    values[((values.len() - 1) as f64 * part).round() as usize]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quartiles_are_those_of_sorted_values() {
        let values = [5.0, 1.0, 4.0, 2.0, 3.0];
        assert_eq!([0.25, 0.5, 0.75].map(|part| quantile(&values, part)), [2.0, 3.0, 4.0]);
    }

    #[test]
    fn a_form_has_a_cost_by_that_of_springs_alone() {
        let scene = scenes::load("twist_pins", &[]).unwrap().scene;
        let line = measure(scene, Some(1), (3, 1e-3)).unwrap();
        assert_eq!((&line["springs"], &line["triangles"]), (&1777.into(), &768.into()));
        for path in ["/ratio/0/0", "/ratio/1/2", "/steps_per_s/2"] {
            assert!(line.pointer(path).and_then(Value::as_f64).is_some_and(|number| number > 0.0), "{line}");
        }
    }
}
