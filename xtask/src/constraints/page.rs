//! The page of springs as constraints.

use super::experiment::{Experiment, Variant, command};
use super::run::{MOMENTS, Run};
use super::speed::{self, Size, Speed, Timing};
use std::fmt::Write;

const HEAD: &str = "# Springs as constraints

Written by `cargo xtask constraints`, which runs every experiment on the CPU in 32 bits, keeps a line of each run and the curves
in [constraints/](constraints), and draws them (`cargo xtask constraints fig15` runs one; `--plots-only` writes this page
again).

S1 is Va, Choi, Hong, \"Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents\", 2021. *ICE*, implicit
constraint enforcement, makes every spring a constraint, *ACAD* those that are too long. Unless it says *printed*, a
constraint is as compliant as its spring is stiff, which S1's are not. In figures 11 to 15 a sheet of 32 × 32 nodes of 0.15 kg
and 2 × 2 m falls from 4 cm above a ball and lies on it or slides off to the floor: S1 names neither masses nor sizes, and of the
stiffnesses only the 1,000 N/m of figure 13 and the 200 N/m of figure 15. The equations, and what was mended in them:
[ice.md](../models/ice.md), [acad.md](../models/acad.md).
";

const TABLE: &str = "
| run | largest l/L | at | l/L at the end | most energy beyond the start, J | at | iterations: mean, most | largest residual | \
stopped early | constraints, %: mean, most |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";

const COST: &str = "
## Figures 9 and 10: what it costs

Mean time of a step over the steps in which the cloth touches the ball or the floor, of three runs the middle one; here on a
CPU, without drawing, energies and stretch of every step measured; S1's frames are one step each on a GTX 1070, drawing
included, so that its milliseconds bound those of a step from above. Figure 9: the drop at 16 ms with 20,000 N/m and 0.1 kg a
node, each step solved to a residual of 1e-3; its first row is this engine's goal of 500 steps a second. Figure 10: 32 × 32
nodes. S1 says of ICE there that it is barely real-time.

| what | nodes | springs | threads | ms a step | steps/s | iterations: mean, most | largest residual | constraints, % | \
largest l/L | most energy beyond the start, J | S1: fps | S1: ms |
|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";

const SIZES: &str = "
## Cost by the number of constraints

The same cloth of 2 × 2 m by finer and finer sheets, which need shorter steps; over frames in which it lies on the ball.

| command | nodes | constraints | ms a step | iterations | ms for a million constraints and iterations | largest residual |
|---|---:|---:|---:|---:|---:|---:|
";

/// The page of all that was kept.
pub fn page(all: &[Experiment], runs: &[Run], speeds: &[Speed], sizes: &[Size]) -> String {
    let mut page = HEAD.to_owned();
    let mut devices: Vec<String> = runs
        .iter()
        .map(|run| (&run.machine, &run.device, &run.commit))
        .chain(speeds.iter().map(|speed| (&speed.machine, &speed.device, &speed.commit)))
        .chain(sizes.iter().map(|size| (&size.machine, &size.device, &size.commit)))
        .map(|(machine, device, commit)| format!("{machine}, {device}, commit {commit}"))
        .collect();
    devices.sort();
    devices.dedup();
    // Writing to a string cannot fail.
    let _ = write!(page, "\nMeasured on: {}.\n", devices.join("; "));
    page += COST;
    speed::all().iter().for_each(|timing| page += &costs(timing, speeds));
    if !sizes.is_empty() {
        page += SIZES;
        sizes.iter().for_each(|size| page += &cost(size));
    }
    all.iter().for_each(|experiment| page += &section(experiment, runs));
    page
}

fn costs(timing: &Timing, speeds: &[Speed]) -> String {
    let mut rows = String::new();
    for speed in speeds.iter().filter(|speed| speed.command == timing.command()) {
        let Speed { nodes, springs, threads, ms_per_step, iterations: (mean, most), residual, .. } = speed;
        let published = timing
            .published
            .map_or_else(|| " | ".to_owned(), |rate| format!("{rate:.2} | {:.2}", 1e3 / rate));
        let _ = writeln!(
            rows,
            "| {} | {nodes} | {springs} | {threads} | {ms_per_step:.3} | {:.0} | {mean:.1}, {most} | {residual:.1e} | {:.1} | {} | \
             {} | {published} |",
            timing.label,
            1e3 / ms_per_step,
            speed.active * 1e2,
            short(speed.max_stretch),
            gained(speed.energy_gain)
        );
    }
    rows
}

fn cost(size: &Size) -> String {
    let Size { command, nodes, springs, ms_per_step, iterations, residual, .. } = size;
    let each = ms_per_step * 1e6 / (*springs as f64 * iterations.max(1.0));
    format!(
        "| `{command}` | {nodes} | {springs} | {ms_per_step:.2} | {iterations:.1} | {each:.2} | {residual:.1e} |\n"
    )
}

fn section(experiment: &Experiment, runs: &[Run]) -> String {
    let of = |variant: &Variant| {
        let same = |run: &&Run| run.experiment == experiment.name && run.variant == variant.slug;
        runs.iter().find(same).map(|run| row(variant, run))
    };
    let rows: String = experiment.variants.iter().filter_map(of).collect();
    if rows.is_empty() {
        return String::new();
    }
    let Experiment { name, scene, title, words, .. } = experiment;
    let mut text =
        format!("\n## {title}\n\n{words} Scene: [{scene}](../../scenes/{scene}.toml).\n{TABLE}{rows}");
    let _ = write!(text, "\n![{title}: over time](constraints/{name}.svg)\n");
    if experiment.pictured {
        let moments = MOMENTS.map(|seconds| format!("{seconds} s")).join(", ");
        let _ = write!(
            text,
            "\nThe cloth after {moments}; of what blows up, the last frame before it did.\n\n| | |\n|---|---|\n"
        );
        for Variant { label, slug, .. } in &experiment.variants {
            let _ = writeln!(text, "| {label} | ![{title}, {label}](constraints/{name}-{slug}.png) |");
        }
    }
    text += "\nBy hand:\n\n```sh\n";
    experiment.variants.iter().for_each(|variant| text += &format!("{}\n", command(scene, &variant.sets)));
    text + "```\n"
}

fn row(variant: &Variant, run: &Run) -> String {
    let at = |frame: u32| format!("{:.2} s", f64::from(frame) * run.dt);
    let end = match run.diverged {
        Some(frame) => format!("blows up at {}", at(frame)),
        None => format!("{:.3}", run.end_stretch),
    };
    let ((stretch, stretch_at), (gain, gain_at)) = (run.max_stretch, run.energy_gain);
    let ((mean, most), (active, most_active)) = (run.iterations, run.active);
    let (stretch, residual) = (short(stretch), run.residual);
    let gain_at = if gain > 0.0 { at(gain_at) } else { String::new() };
    let gain = gained(gain);
    let mut row =
        format!("| {} | {stretch} | {} | {end} | {gain} | {gain_at} |", variant.label, at(stretch_at));
    if most > 0 {
        let _ = writeln!(
            row,
            " {mean:.1}, {most} | {residual:.1e} | {} | {:.1}, {:.1} |",
            run.capped,
            active * 1e2,
            most_active * 1e2
        );
    } else {
        row += " | | | |\n";
    }
    row
}

/// Energy beyond that at the start.
fn gained(gain: f64) -> String {
    if gain > 0.0 { short(gain) } else { "none".to_owned() }
}

/// Three decimals, or two digits where those would say nothing.
fn short(number: f64) -> String {
    if number.abs() < 1e4 { format!("{number:.3}") } else { format!("{number:.1e}") }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::experiment;

    #[test]
    fn a_run_that_blows_up_says_when_and_one_without_constraints_has_no_iterations() {
        let all = experiment::all();
        let run = Run {
            experiment: "fig15".into(),
            variant: "springs".into(),
            dt: 0.016,
            diverged: Some(34),
            max_stretch: (2.5e7, 33),
            ..Run::default()
        };
        let page = page(&all, &[run], &[], &[]);
        assert!(
            page.contains("| springs | 2.5e7 | 0.53 s | blows up at 0.54 s | none |  | | | | |\n"),
            "{page}"
        );
        assert!(!page.contains("Figure 14: ICE"));
    }
}
