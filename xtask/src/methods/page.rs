//! The page of ways to solve springs.

use super::cell::FRAME;
use super::run::{EARLY, Run};
use super::way::Way;
use std::fmt::Write;

/// Errors at which ways are compared.
const WANTED: [f64; 3] = [1e-1, 1e-2, 1e-3];

const HEAD: &str = "# Explicit or implicit springs

Written by `cargo xtask methods`, which runs everything on the CPU in 32 bits and keeps a line of each run in
[methods/runs.jsonl](methods/runs.jsonl). `cargo xtask methods 10k` runs one size, `--quick` takes a short look at small ones and
writes it into the target folder, `--plots-only` writes this page again. References are kept in the target folder;
`--references-only` makes them beforehand, and machines that are busy otherwise may do that: times they must not take.

- *springs*: `solver.method = \"springs\"`, explicit, in sub-steps that are just stable (a twentieth to spare), half and a quarter
  as long; and in one a frame, which is not stable.
- *dual*: `solver.method = \"ice\"`, `form = \"compliant\"`, as it is by default: to a residual of 1e-3 or for 200 iterations.
- *dual, solved*: the same, for up to 5,000 iterations.
- *primal*: `solver.method = \"ice\"`, `form = \"primal\"`, as it is by default: to a residual of 1e-3 or for 200 iterations of
  conjugate gradients, each with a cycle over coarser grids.

Which equations these are: [springs.md](../models/springs.md), [ice.md](../models/ice.md).

## What is run

A square sheet of 1 m and 0.2 kg with all three kinds of springs hangs from its upper edge, flat, and swings out at 3 rad/s, 5 %
faster at one side. It is the same cloth on any grid: springs of k [N/m] make a membrane with C₁₁ = 6 k (4 k of it from bend
springs), C₁₂ = k, C₆₆ = k, whatever the spacing is. What resists folding, bend springs too, vanishes as the spacing does. There is
no damping, no drag and no contact. Cloth under pull is chosen because its motion can be told: slack cloth folds at random, and
there no two runs agree.

*Error* is √(Σ |x − x_ref|²/Σ |x_ref − x_start|²) over all nodes and all frames of 1/60 s: distance from the reference by the way
that was gone. The *reference* is explicit as well, but in 64 bits, in half the steps that are just stable, and started half a
step early, which makes it exact to second order. How far off it is in twice these steps stands beside it: its own error is a
quarter of that while the error is one of steps, and not of folds at random. Larger sheets run for a shorter time, for a
reference of a million nodes takes minutes for a thirtieth of a second.

*Time* is wall time by simulated time, of frames alone, each with its report: the median of up to five runs, with the least and
the most. Below 1 s a second it is faster than real time. All ways are of first order; what the half step between velocity
and place does to a body that starts from rest, h t g/2 in each of them, does not show here, for the sheet starts in the middle of
its swing.

## What limits each of them

- *Springs* are stable in steps of at most √(4 m/(10.1 k)), m the mass of a node. The number of steps grows with √(k nodes), and
  their work with nodes on top. In such steps the error is smaller than anybody sees; what is left of it where k is large is
  rounding, which decides how the sheet wrinkles.
- *Dual*: implicit along springs, explicit across. What swings is not damped; waves across the pull T grow where h² T/(m L) > 1,
  that is in fine sheets. Iterations grow with nodes along an edge.
- *Primal*: implicit across springs as well, so it holds in any step; but then a long step damps the swing itself. Iterations hardly
  grow with size and stiffness.
- Both of these damp the bounce along springs with which the sheet starts, at a rate of h ω²/2 (ω = 85/s at 100 N/m, more where it
  is stiffer). Real cloth does not bounce for long either. Here it is an error: of 1k nodes over half a second 4e-3 at 100 N/m and
  7e-4 at 1,000 N/m, below which the dual form gets in steps far shorter than 1/1000 s alone.
";

/// The page of all runs, which are in order.
pub fn page(runs: &[Run]) -> String {
    let mut page = HEAD.to_owned();
    let mut devices: Vec<String> =
        runs.iter().map(|run| format!("{}, {}, commit {}", run.machine, run.device, run.commit)).collect();
    devices.sort();
    devices.dedup();
    // Writing to a string cannot fail.
    let _ = write!(page, "\nMeasured on: {}.\n", devices.join("; "));
    page += "\n![Error by wall time, for each size and stiffness](methods/error-by-time.svg)\n";
    page += &wins(runs);
    page += &one_step(runs);
    page += &early(runs);
    sizes(runs).iter().for_each(|of_size| page += &all(of_size));
    page
}

/// Runs that follow each other and have the same of something.
fn groups<K: PartialEq>(runs: &[Run], key: impl Fn(&Run) -> K) -> Vec<&[Run]> {
    runs.chunk_by(|a, b| key(a) == key(b)).collect()
}

fn sizes(runs: &[Run]) -> Vec<&[Run]> {
    groups(runs, |run| run.side)
}

/// Runs of a size and a stiffness.
pub fn cells(runs: &[Run]) -> Vec<&[Run]> {
    groups(runs, |run| (run.side, run.k.to_bits()))
}

/// The fastest run of a cell that holds, with an error of at most so much.
fn fastest(cell: &[Run], error: f64) -> Option<&Run> {
    let near = cell.iter().filter(|run| run.holds() && run.error.is_some_and(|off| off <= error));
    near.min_by(|a, b| a.cost().total_cmp(&b.cost()))
}

fn wins(runs: &[Run]) -> String {
    let mut text = "\n## Which one is the fastest\n\nOf the runs of each way that are off by so much at most: the time [s] of the \
                    fastest by simulated second, with its step. Those do not count in \
                    which a spring gets longer than in the reference by 5 % of its length: waves of the spacing of nodes, which \
                    grow where a step is too long for what hangs in a sheet, hardly show in the error.\n"
        .to_owned();
    for error in WANTED {
        let _ = write!(text, "\n{}", sentence(runs, error));
    }
    text += "\n| nodes | k, N/m | way |";
    WANTED.iter().for_each(|error| text += &format!(" off by {} |", percent(*error)));
    text += "\n|---|---:|---|---:|---:|---:|\n";
    for cell in cells(runs) {
        for of_way in groups(cell, |run| run.way) {
            let Run { size, k, way, .. } = &of_way[0];
            let times = WANTED.map(|error| time(of_way, cell, error)).join(" | ");
            let _ = writeln!(text, "| {size} | {} | {} | {times} |", grouped(*k), way.label());
        }
    }
    text
}

/// Time and step of the fastest run of a way to an error; bold if none of its cell is faster.
fn time(of_way: &[Run], cell: &[Run], error: f64) -> String {
    let Some(run) = fastest(of_way, error) else { return String::new() };
    let first = fastest(cell, error).is_some_and(|first| first.key() == run.key());
    let bold = if first { "**" } else { "" };
    format!("{bold}{}{bold} ({})", digits(run.cost()), step(run))
}

/// Where each way is the fastest to an error.
fn sentence(runs: &[Run], error: f64) -> String {
    let of = |way: Way| {
        let won = |cell: &&&[Run]| fastest(cell, error).is_some_and(|run| run.way == way);
        let name = |cell: &[Run]| format!("{} at {} N/m", cell[0].size, grouped(cell[0].k));
        let cells: Vec<String> = cells(runs).iter().filter(won).map(|cell| name(cell)).collect();
        (!cells.is_empty()).then(|| format!("*{}* ({})", way.label(), cells.join(", ")))
    };
    let words: Vec<String> = Way::ALL.into_iter().filter_map(of).collect();
    let words = if words.is_empty() { "none".to_owned() } else { words.join("; ") };
    format!("- To {}: {words}.\n", percent(error))
}

fn one_step(runs: &[Run]) -> String {
    let mut text = "\n## One step a frame\n\nSteps of 1/60 s, as real-time programs want them. *Energy* is what the sheet has gained by the \
                    end beyond the reference, by the energy of its motion at the start: less than zero is damping. *Stopped early* are \
                    steps in which the iterations ran out.\n\n\
                    | nodes | k, N/m | way | error | largest l/L | energy | iterations: mean, most | stopped early | s a second |\n\
                    |---|---:|---|---:|---:|---:|---:|---:|---:|\n"
        .to_owned();
    for run in runs.iter().filter(|run| run.steps == 1) {
        let Run { size, k, way, .. } = run;
        let _ = writeln!(text, "| {size} | {} | {} | {} |", grouped(*k), way.label(), outcome(run));
    }
    text
}

/// What all sizes were run for.
fn early(runs: &[Run]) -> String {
    let mut steps: Vec<u32> =
        runs.iter().filter(|run| run.way != Way::Springs).map(|run| run.steps).collect();
    steps.sort_unstable();
    steps.dedup();
    let mut text = format!(
        "\n## The same time for all sizes\n\nErrors after {:.3} s, by steps in a frame, and of explicit springs that are just stable. \
         So early the cloth still bounces in its length, which long steps cannot follow: by the short way that was gone errors are \
         larger than later on.\n\n| nodes | k, N/m | way |",
        f64::from(EARLY) * FRAME
    );
    steps.iter().for_each(|steps| text += &format!(" {steps} |"));
    let _ = writeln!(text, " springs |\n|---|---:|---|{}", "---:|".repeat(steps.len() + 1));
    let off = |run: Option<&Run>| {
        run.and_then(|run| run.early_error).map_or_else(String::new, |error| format!("{error:.1e}"))
    };
    for cell in cells(runs) {
        let explicit = off(cell.iter().find(|run| run.way == Way::Springs && run.steps > 1));
        for of_way in groups(cell, |run| run.way).into_iter().filter(|runs| runs[0].way != Way::Springs) {
            let Run { size, k, way, .. } = &of_way[0];
            let cells = steps.iter().map(|&steps| off(of_way.iter().find(|run| run.steps == steps)));
            let cells: Vec<String> = cells.collect();
            let _ = writeln!(
                text,
                "| {size} | {} | {} | {} | {explicit} |",
                grouped(*k),
                way.label(),
                cells.join(" | ")
            );
        }
    }
    text
}

fn all(of_size: &[Run]) -> String {
    let Run { size, side, nodes, springs, seconds, .. } = &of_size[0];
    let mut text = format!(
        "\n## All runs of {size}\n\n{side} × {side}: {nodes} nodes, {springs} springs; {seconds:.3} s.\n\n\
         | k, N/m | way | step | error | largest l/L | energy | iterations: mean, most | stopped early | s a second: median | least, \
         most (runs) | threads |\n|---:|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n"
    );
    for run in of_size {
        let [least, _, most] = run.wall.map(digits);
        let spread =
            if run.diverged.is_some() { " ".to_owned() } else { format!("{least}, {most} ({})", run.runs) };
        let _ = writeln!(
            text,
            "| {} | {} | {} | {} | {spread} | {} |",
            grouped(run.k),
            run.way.label(),
            step(run),
            outcome(run),
            run.threads
        );
    }
    text
}

/// Error, stretch, energy, iterations, early stops and time, as cells of a table.
fn outcome(run: &Run) -> String {
    let Run { max_stretch, energy, iterations: (mean, most), capped, .. } = run;
    let Some(error) = run.error else {
        let frame = run.diverged.unwrap_or_default();
        return format!("blows up in frame {frame} | | | | | ");
    };
    let iterations = if *most > 0 { format!("{mean:.0}, {most} | {capped}") } else { " | ".to_owned() };
    format!("{error:.1e} | {max_stretch:.3} | {energy:+.3} | {iterations} | {}", digits(run.cost()))
}

/// Length of a step, as a fraction of a second.
fn step(run: &Run) -> String {
    format!("1/{} s", (1.0 / run.step()).round())
}

/// Three digits.
fn digits(seconds: f64) -> String {
    let decimals = (2.0 - seconds.max(1e-6).log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{seconds:.decimals$}")
}

/// A whole number, in groups of three digits.
fn grouped(number: f64) -> String {
    let digits = format!("{number:.0}");
    let groups: Vec<&str> =
        digits.as_bytes().rchunks(3).rev().filter_map(|group| std::str::from_utf8(group).ok()).collect();
    groups.join(",")
}

fn percent(share: f64) -> String {
    format!("{} %", share * 100.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(way: Way, steps: u32, error: Option<f64>, cost: f64) -> Run {
        let diverged = if error.is_none() { Some(3) } else { None };
        let size = "1k".to_owned();
        Run {
            size,
            side: 32,
            k: 1e3,
            way,
            steps,
            error,
            diverged,
            wall: [cost; 3],
            runs: 1,
            ..Run::default()
        }
    }

    #[test]
    fn the_fastest_of_those_that_are_near_enough_wins_and_none_that_blew_up_or_crumpled() {
        let runs = [
            run(Way::Springs, 1, None, 0.001),
            run(Way::Springs, 90, Some(1e-4), 0.5),
            run(Way::Dual, 1, Some(0.05), 0.02),
            run(Way::Dual, 4, Some(0.008), 0.6),
            Run { max_stretch: 1.06, ..run(Way::Dual, 2, Some(0.008), 0.01) },
        ];
        let page = page(&runs);
        for row in [
            "| 1k | 1,000 | springs | 0.500 (1/5400 s) | **0.500** (1/5400 s) | **0.500** (1/5400 s) |\n",
            "| 1k | 1,000 | dual | **0.0200** (1/60 s) | 0.600 (1/240 s) |  |\n",
        ] {
            assert!(page.contains(row), "{page}");
        }
        assert!(page.contains("- To 10 %: *dual* (1k at 1,000 N/m).\n"), "{page}");
        assert!(page.contains("- To 1 %: *springs* (1k at 1,000 N/m).\n"), "{page}");
        assert!(page.contains("| 1k | 1,000 | springs | blows up in frame 3 | | | | |  |\n"), "{page}");
    }
}
