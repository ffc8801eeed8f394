//! The measured lines as tables.

use super::Line;
use std::fmt::Write;

/// What the engine aims at on a processor of two cores with AVX-512.
struct Target {
    what: &'static str,
    bench: &'static str,
    /// Of a grid: rows and columns; of a mesh: any.
    n: Option<[u32; 2]>,
    aim: f64,
    unit: &'static str,
    measured: fn(&Line) -> f64,
}

const TARGETS: [Target; 4] = [
    Target {
        what: "grid, n = 160",
        bench: "grid",
        n: Some([160, 160]),
        aim: 500.0,
        unit: "M particle-substeps/s",
        measured: |line| line.particle_substeps_per_s * 1e-6,
    },
    Target {
        what: "grid, n = 512",
        bench: "grid",
        n: Some([512, 512]),
        aim: 500.0,
        unit: "M particle-substeps/s",
        measured: |line| line.particle_substeps_per_s * 1e-6,
    },
    Target {
        what: "grid, 1368 × 5717",
        bench: "grid",
        n: Some([1368, 5717]),
        aim: 45.0,
        unit: "sub-steps/s",
        measured: |line| f64::from(line.substeps_per_frame) * 1e3 / line.ms_per_frame.median,
    },
    Target {
        what: "mesh, 1 M springs",
        bench: "mesh",
        n: None,
        aim: 400.0,
        unit: "M springs/s",
        measured: |line| line.springs_per_s * 1e-6,
    },
];

const HEAD: &str = "# Results

Written by `cargo xtask results`, which keeps every line it measures in the `.jsonl` files here; the tables and plots
show the last line of each command (`--plots-only` writes them again). A frame is one thirtieth of a second in 34
sub-steps. The shares are of what the same threads reach on the same machine: of a STREAM triad's bandwidth, counting
each node's position and velocity read and written once a sub-step, and of the peak of fused multiply-adds, counting
31 operations a spring.
";

/// Pages of their own, and what they are about.
pub const PAGES: [(&str, &str); 6] = [
    ("papers/report.md", "What three papers print beside what comes out here"),
    ("volume.md", "How well soft bodies keep their volume, and at what cost"),
    ("constraints.md", "What springs as constraints do and cost, beside published figures"),
    ("contact.md", "How fast nodes find each other, by clusters and by all pairs"),
    ("methods.md", "Which way of solving springs is the fastest to a wanted error"),
    ("colliders.md", "What meshes as colliders cost, and garments on a human"),
];

/// The page: where `pages` of their own and those of GPUs are, then for each processor its targets, plots and measurements.
pub fn readme(
    processors: &[(String, Vec<Line>)],
    gpus: &[(String, String)],
    pages: &[(&str, &str)],
) -> String {
    let mut page = HEAD.to_owned();
    pages.iter().for_each(|(file, about)| page += &format!("\n{about}: [{file}]({file}).\n"));
    if !gpus.is_empty() {
        let links: Vec<String> = gpus.iter().map(|(slug, name)| format!("[{name}]({slug}.md)")).collect();
        let _ = write!(page, "\nGPUs have pages of their own: {}.\n", links.join(", "));
    }
    for (slug, lines) in processors {
        let machine = lines.first().map_or(slug, |line| &line.machine);
        // Writing to a string cannot fail.
        let _ = write!(page, "\n## {machine}\n\n{}", targets(lines));
        let _ =
            write!(page, "\n![Time of a node's sub-step for grids of 1 k to 8 M nodes]({slug}-nodes.svg)\n");
        let _ = write!(page, "\n![Speed for each number of threads]({slug}-threads.svg)\n");
        let _ = write!(page, "\n{}", measurements(lines));
    }
    page
}

fn targets(lines: &[Line]) -> String {
    let mut table = "| target | aim | measured | met |\n|---|---|---|---|\n".to_owned();
    for target in &TARGETS {
        let hit =
            |line: &&Line| line.free() && line.bench == target.bench && target.n.is_none_or(|n| line.n == n);
        let (measured, met) = match lines.iter().find(hit).map(target.measured) {
            Some(measured) => (format!("{measured:.1}"), if measured >= target.aim { "yes" } else { "no" }),
            None => ("not measured".to_owned(), ""),
        };
        let _ = writeln!(table, "| {} | {} {} | {measured} | {met} |", target.what, target.aim, target.unit);
    }
    table
}

fn measurements(lines: &[Line]) -> String {
    let mut table = "| command | device | commit | ms a frame: min | median | max | M particle-substeps/s \
                     | of bandwidth | of peak FLOP/s |\n|---|---|---|---:|---:|---:|---:|---:|---:|\n"
        .to_owned();
    for line in lines {
        let ms = &line.ms_per_frame;
        let _ = writeln!(
            table,
            "| `{}` | {} | {} | {:.3} | {:.3} | {:.3} | {:.0} | {:.0} % | {:.0} % |",
            line.command,
            line.device,
            line.commit,
            ms.min,
            ms.median,
            ms.max,
            line.particle_substeps_per_s * 1e-6,
            line.limits.memory_fraction * 1e2,
            line.limits.fma_fraction * 1e2
        );
    }
    let mut notes: Vec<&String> = lines.iter().filter_map(|line| line.note.as_ref()).collect();
    notes.dedup();
    notes.iter().for_each(|note| table.push_str(&format!("\n{note}.\n")));
    table
}
