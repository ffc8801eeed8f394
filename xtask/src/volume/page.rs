//! The page of kept volumes.

use super::experiment::{ALL, Experiment, PUBLISHED_FALLS};
use super::run::Run;
use super::speed::Speed;
use std::fmt::Write;

const HEAD: &str = "# Kept volumes

Written by `cargo xtask volume`, which runs every experiment on the CPU in 32 bits, keeps a line of each run and the curves
in [volume/](volume), and draws them (`cargo xtask volume fall_sphere` runs one; `--plots-only` writes this page again). One
run by hand: `taffeta run scenes/fall_sphere.toml --backend cpu --set body.sphere.volume.form=none
--set body.sphere.springs.structural.k=100`. How volumes are kept, and what was mended in the paper:
[docs/models/volume.md](../models/volume.md).

S3 is Va, Choi, Hong, \"Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D\", 2023. *Springs only*
keeps no volume; *paper-shader* is S3's constraint as its authors' program has it; *kept* is ours (form `corrected`);
*projected* moves nodes in addition. `printed`, the equations as they stand in the paper, blows up.
";

const LOSSES: &str = "
## Volume lost

The largest and the mean difference from the volume to keep over all frames, in % of it; of 64 bodies, of the one that is off
most. More than 100 % is a body turned inside out. S3 gives the largest loss.

| experiment | k, N/m | springs only | | paper-shader | | kept | | projected | S3: springs only | S3: kept |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
| | | largest | mean | largest | mean | largest | mean | largest | largest | largest |
";

const SPEEDS: &str = "
## Speed

Sub-steps a second of the same bodies with the scene's own stiffness in free fall, so that all forms have the same to do; 25
rounds in which each form has its turn. *Added* is what keeping the volume costs: the median over the rounds, and the
quartiles. It should be at most 60 % from 20,000 triangles on, and 30 % is the aim. On hardware GPUs
nothing has been measured yet.

| bodies of | triangles | springs | threads | springs only | kept | added | projected | added |
|---|---:|---:|---:|---:|---:|---:|---:|---:|
";

const DIFFERENCES: &str = "
## What differs from S3

- S3 takes 400 frames (600 of the pressing) with steps of 1e-4 s, but does not say how many steps a frame has, nor the mass of
  a node, the size of a model or the height of the fall. Here a frame is 1/60 s in 34 steps, a node has 1 kg, the largest
  extent is 2 m, the lowest node starts 0.5 m above the floor, and every spring has a damping of 200 kg/s (none in the twists).
  S3's own step: `--set time.max_step=1e-4`.
- The paper-shader form takes back hardly anything of what contact takes in a step, so its loss grows with time and with the
  step: in the first two seconds of the sphere's fall 3.00 % with steps of 5e-4 s, 1.22 % with 2e-4 s, 0.61 % with 1e-4 s.
- The pressing is without weight here: these springs do not carry 1 kg a node, and lie flat before the plate comes, where S3's
  lose 80 % below it. The plate comes down at 0.4 m/s to half the body's height.
- The twists are without weight, too. S3 names no torque: 20 N·m for each of the 81 nodes of the top here. Undamped, it swings
  ever wider, so that its figures depend on how long it runs.
- The models are those that `cargo xtask models` fetches; S3's have other numbers of triangles. S3's 95.35 % and 5.61 % are
  means over its models, with k = 5,000 N/m.
- S3 writes of frames a second with drawing (GTX 1070: 54.5 armadillo, 39.39 dragon; i7-7700: bunny 44.23, armadillo 28.19,
  dragon 9.42; pressing 37.31 and 18.59; twist 123.69). Without the number of steps in a frame these cannot stand beside
  steps a second.
";

/// The page of all runs.
pub fn page(runs: &[Run], speeds: &[Speed]) -> String {
    let mut page = HEAD.to_owned();
    let of_run = |run: &Run| format!("{}, {}, commit {}", run.machine, run.device, run.commit);
    let of_speed = |speed: &Speed| format!("{}, {}, commit {}", speed.machine, speed.device, speed.commit);
    let mut devices: Vec<String> = runs.iter().map(of_run).chain(speeds.iter().map(of_speed)).collect();
    devices.sort();
    devices.dedup();
    // Writing to a string cannot fail.
    let _ = write!(page, "\nMeasured on: {}.\n", devices.join("; "));
    page += LOSSES;
    ALL.iter().for_each(|experiment| page += &losses(experiment, runs));
    page += &falls(runs);
    page += SPEEDS;
    for experiment in &ALL {
        let own = speeds.iter().filter(|speed| speed.scene == experiment.scene);
        own.for_each(|speed| page += &row(experiment, speed));
    }
    page += DIFFERENCES;
    page += &stand_ins(runs);
    page += "\n## Volume over time\n\nWith the scenes' own stiffness.\n";
    for experiment in ALL.iter().filter(|experiment| runs.iter().any(|run| run.scene == experiment.scene)) {
        let _ = write!(page, "\n![Volume over time: {}](volume/{}.svg)\n", experiment.what, experiment.scene);
    }
    page
}

/// The means over all falls that stand beside those of the paper.
fn falls(runs: &[Run]) -> String {
    let published = &PUBLISHED_FALLS;
    let mut row = format!("| all falls, mean | {} |", published.k);
    for form in ["none", "paper-shader", "corrected"] {
        let own = || {
            runs.iter()
                .filter(|run| run.scene.starts_with("fall_") && run.k == published.k && run.form == form)
        };
        let count = own().count().max(1) as f64;
        let mean = |pick: fn(&Run) -> f64| percent(own().map(pick).sum::<f64>() / count);
        let _ = write!(row, " {} | {} |", mean(|run| run.max_error), mean(|run| run.mean_error));
    }
    let _ = writeln!(row, " | {} | {} |", of_paper(published.springs), of_paper(published.kept));
    row
}

/// A row for each stiffness.
fn losses(experiment: &Experiment, runs: &[Run]) -> String {
    let own: Vec<&Run> = runs.iter().filter(|run| run.scene == experiment.scene).collect();
    let mut stiffnesses: Vec<f64> = own.iter().map(|run| run.k).collect();
    stiffnesses.sort_by(f64::total_cmp);
    stiffnesses.dedup();
    let mut rows = String::new();
    for k in stiffnesses {
        let find = |form: &str| own.iter().find(|run| run.form == form && run.k == k);
        let of = |form: &str, pick: fn(&Run) -> f64| match find(form) {
            Some(Run { diverged: Some(_), .. }) => "blows up".to_owned(),
            Some(run) => percent(pick(run)),
            None => String::new(),
        };
        let _ = write!(rows, "| [{}](../../scenes/{}.toml) | {k} |", experiment.what, experiment.scene);
        for form in ["none", "paper-shader", "corrected"] {
            let _ = write!(rows, " {} | {} |", of(form, |run| run.max_error), of(form, |run| run.mean_error));
        }
        let published = experiment.published.iter().find(|published| published.k == k);
        let _ = writeln!(
            rows,
            " {} | {} | {} |",
            of("projected", |run| run.max_error),
            of_paper(published.and_then(|published| published.springs)),
            of_paper(published.and_then(|published| published.kept))
        );
    }
    rows
}

fn row(experiment: &Experiment, speed: &Speed) -> String {
    let [springs, kept, projected] = speed.steps_per_s;
    let [of_kept, of_projected] = speed.ratio.map(|ratio| {
        let [median, low, high] = ratio.map(|ratio| (ratio - 1.0) * 1e2);
        format!("{median:.0} % ({low:.0} to {high:.0})")
    });
    let Speed { triangles, springs: count, threads, .. } = speed;
    format!(
        "| {} | {triangles} | {count} | {threads} | {springs:.0} | {kept:.0} | {of_kept} | {projected:.0} | {of_projected} |\n",
        experiment.what
    )
}

/// Which runs were not of the models they are named after.
fn stand_ins(runs: &[Run]) -> String {
    let mut notes: Vec<String> =
        runs.iter().filter(|run| run.note.is_some()).map(|run| run.scene.clone()).collect();
    notes.dedup();
    if notes.is_empty() {
        return String::new();
    }
    format!("- These ran with stand-ins, for the models were not there: {}.\n", notes.join(", "))
}

/// Two decimals, or two digits where that would be nothing.
fn percent(share: f64) -> String {
    let percent = share * 1e2;
    if percent >= 0.01 { format!("{percent:.2}") } else { format!("{percent:.1e}") }
}

fn of_paper(percent: Option<f64>) -> String {
    percent.map_or_else(String::new, |percent| format!("{percent:.2}"))
}

#[cfg(test)]
mod tests {
    use super::percent;

    #[test]
    fn small_losses_keep_two_digits() {
        assert_eq!([0.9535, 0.0364, 1.4e-5].map(percent), ["95.35", "3.64", "1.4e-3"]);
    }
}
