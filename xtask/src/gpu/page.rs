//! The page of a device.

use super::report::{Report, Row, Scene, Speed};
use std::fmt::Write;

/// The grid of Va, Choi and Hong 2021, and what is asked of it: sub-steps a second at least, and the share of the copy
/// bandwidth that is the goal.
const LARGEST_OF_2021: [u32; 2] = [1368, 5717];
const FLOOR: f64 = 3000.0;
const GOAL: f64 = 0.6;
const OURS: [&str; 3] = ["plain", "tiled", "best"];

/// The page as Markdown.
pub fn of(report: &Report) -> String {
    [
        head(report),
        targets(report),
        kernels(report),
        speeds(report),
        costs(report),
        checks(report),
        faults(report),
    ]
    .concat()
}

fn head(report: &Report) -> String {
    let device = &report.device;
    let commit = report.commit.as_deref().unwrap_or("an unknown commit");
    let mut page = format!(
        "# {}\n\nWritten by `cargo xtask gpu --merge` from what `taffeta gpu-check` \
         measured in {:.0} s: taffeta {} ({commit}), {}, {}, driver {}, host {}.\n\n{}\n",
        device.name,
        report.seconds,
        report.version,
        device.api,
        device.kind,
        device.driver,
        device.host,
        report.verdict()
    );
    if report.quick {
        page.push_str("\nIt was a quick check: small scenes and few frames alone.\n");
    }
    if !report.only.is_empty() {
        page.push_str(&format!("\nOnly parts were run whose names contain {}.\n", report.only.join(" or ")));
    }
    if !report.complete {
        page.push_str("\n**The check did not come to its end.**\n");
    }
    page
}

fn targets(report: &Report) -> String {
    let speed = report.speed("grid", LARGEST_OF_2021, "best");
    let steps = speed.map(|speed| 1e3 / speed.ms_per_substep.median);
    let share = speed.and_then(|speed| speed.copy_fraction);
    let met = |value: Option<f64>, aim: f64| match value {
        Some(value) if value >= aim => "yes",
        Some(_) => "no",
        None => "",
    };
    let not = || "not measured".to_owned();
    format!(
        "\n## Targets\n\n| grid of 1368 × 5717 = 7,820,856 nodes | asked | measured | met |\n|---|---|---|---|\n\
         | floor | {FLOOR:.0} sub-steps/s | {} | {} |\n| goal | {:.0} % of the copy bandwidth | {} | {} |\n\n\
         For scale: Va, Choi and Hong 2021 report 34.81 frames/s of it on a GTX 1070.\n",
        steps.map_or_else(not, |steps| format!("{steps:.0} sub-steps/s")),
        met(steps, FLOOR),
        GOAL * 1e2,
        share.map_or_else(not, |share| format!("{:.1} %", share * 1e2)),
        met(share, GOAL)
    )
}

/// Our kernels, by the size of the grid.
fn kernels(report: &Report) -> String {
    let mut sizes: Vec<[u32; 2]> =
        report.speeds.iter().filter(|one| one.part == "kernels").map(|one| one.n).collect();
    sizes.dedup();
    let mut page = "\n## Kernels by the size of the grid\n\nMicroseconds a sub-step of grids with all springs, median of \
                    batches.\n\n| grid | plain | tiled | best |\n|---|---:|---:|---:|\n"
        .to_owned();
    for n in sizes {
        let time = |kernels| report.speed("kernels", n, kernels).map(|one| one.ms_per_substep.median * 1e3);
        let cells = OURS.map(|kernels| cell(time(kernels), |us| format!("{us:.2}")));
        // Writing to a string cannot fail.
        let _ = writeln!(page, "| {} × {} | {} |", n[0], n[1], cells.join(" | "));
    }
    page
}

fn cell(value: Option<f64>, words: impl Fn(f64) -> String) -> String {
    value.map_or_else(|| "–".to_owned(), words)
}

fn speeds(report: &Report) -> String {
    let copy = report.copy.as_ref().map_or_else(
        || "which was not measured".to_owned(),
        |copy| {
            format!(
                "{:.0} GB/s by a kernel and {:.0} between buffers",
                copy.kernel_gb_per_s, copy.buffer_gb_per_s
            )
        },
    );
    let mut page = format!(
        "\n## Speed\n\nFrames of 34 sub-steps, no wait between frames; median, least and most of some batches. GB/s counts \
         64 bytes a node and sub-step: position and velocity, in and out. The share is of the better copy: {copy}. `n` is \
         rows and columns, for bodies their number and the nodes of each.\n\n\
         | part | n | kernels | nodes | springs | µs a sub-step: median | min | max | M nodes/s | M springs/s | GB/s | of copy \
         |\n|---|---|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|\n"
    );
    report.speeds.iter().for_each(|speed| page.push_str(&row(speed)));
    page
}

fn row(speed: &Speed) -> String {
    let ms = &speed.ms_per_substep;
    format!(
        "| {} | {} × {} | {} | {} | {} | {:.2} | {:.2} | {:.2} | {:.0} | {:.0} | {:.1} | {} |\n",
        speed.part,
        speed.n[0],
        speed.n[1],
        speed.kernels,
        speed.nodes,
        speed.springs,
        ms.median * 1e3,
        ms.min * 1e3,
        ms.max * 1e3,
        speed.particle_substeps_per_s * 1e-6,
        speed.springs_per_s * 1e-6,
        speed.gb_per_s,
        cell(speed.copy_fraction, |share| format!("{:.1} %", share * 1e2))
    )
}

fn costs(report: &Report) -> String {
    let mut page = String::new();
    if let Some(cost) = &report.substep {
        let _ = write!(
            page,
            "\nA sub-step on its own costs {:.2} µs, and {:.4} ns a node of a grid.\n",
            cost.microseconds, cost.nanoseconds_per_node
        );
    }
    if let Some(read) = &report.read_back {
        let _ = write!(
            page,
            "\nA frame of a grid of {} × {} takes {:.3} ms, {:.3} ms where the host waits for its report, and {:.3} ms where \
             it waits for all positions and velocities.\n",
            read.n[0], read.n[1], read.ms_without_waiting, read.ms_with_report, read.ms_with_state
        );
    }
    page
}

fn checks(report: &Report) -> String {
    let mut page = "\n## Kernels beside their twins on the CPU\n\nThe largest difference, in units in the last place of the \
                    largest number of an output.\n\n| kernel | ulps | allowed | |\n|---|---:|---:|---|\n"
        .to_owned();
    report.parity.iter().for_each(|row| page.push_str(&kernel(row)));
    page.push_str(
        "\n## Scenes on both\n\n| scene | kernels | frames | largest distance [m] | allowed [m] | same bits twice | |\n\
         |---|---|---:|---:|---:|---|---|\n",
    );
    report.scenes.iter().for_each(|one| page.push_str(&scene(one)));
    page
}

fn kernel(row: &Row) -> String {
    let why = row.error.as_ref().or(row.place.as_ref()).filter(|_| !row.passed);
    let mark = why.map_or_else(|| mark(row.passed).to_owned(), |why| format!("{}: {why}", mark(row.passed)));
    format!(
        "| `{}` | {} | {} | {mark} |\n",
        row.name,
        cell(row.ulps, |ulps| format!("{ulps:.2}")),
        row.allowed
    )
}

fn scene(scene: &Scene) -> String {
    let why = scene.error.as_ref().map_or_else(String::new, |why| format!(": {why}"));
    format!(
        "| {} | {} | {} | {} | {:.0e} | {} | {}{why} |\n",
        scene.name,
        scene.kernels,
        scene.frames,
        cell(scene.apart, |apart| format!("{apart:.1e}")),
        scene.allowed,
        if scene.same_twice { "yes" } else { "no" },
        mark(scene.passed)
    )
}

fn mark(passed: bool) -> &'static str {
    if passed { "ok" } else { "**failed**" }
}

fn faults(report: &Report) -> String {
    if report.faults.is_empty() {
        return String::new();
    }
    let list: String = report.faults.iter().map(|fault| format!("- {fault}\n")).collect();
    format!("\n## Not measured\n\n{list}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gpu::report::EXAMPLE;

    #[test]
    fn the_page_says_what_was_asked_what_failed_and_how_fast_it_was() {
        let report: Report = serde_json::from_str(EXAMPLE).expect("an example");
        let page = of(&report);
        for part in [
            "**The GPU does NOT compute what the CPU does**: 1 of 2 kernels and 1 of 1 scenes agree.",
            "| floor | 3000 sub-steps/s | 4000 sub-steps/s | yes |",
            "| goal | 60 % of the copy bandwidth | 50.0 % | no |",
            "| 32 × 32 | – | – | 2.00 |",
            "| `fold_of` | – | 4 | **failed**: fold[3] is 1e0 on the CPU and NaN on the GPU |",
            "| flag | best | 20 | 2.0e-7 | 1e-4 | yes | ok |",
            "- mesh 1000×334, best: the GPU has no memory left",
        ] {
            assert!(page.contains(part), "{part}\n{page}");
        }
    }

    #[test]
    fn what_was_not_measured_is_said() {
        let mut report: Report = serde_json::from_str(EXAMPLE).expect("an example");
        report.speeds.clear();
        assert!(of(&report).contains("| floor | 3000 sub-steps/s | not measured |  |"));
    }
}
