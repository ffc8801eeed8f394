//! What the engine aims at on a processor of two cores with AVX-512, and meshes and drapes beside grids.

use super::s1::sheets;
use crate::report::look::{Look, speed, speeds};
use crate::report::page::Section;
use crate::report::table::{Cell, Table};
use crate::runs::job::{Job, Quick};
use serde_json::Value;

/// A speed, and what it should be.
struct Aim {
    what: &'static str,
    job: String,
    at_least: f64,
    unit: &'static str,
    of: fn(&Value) -> Option<f64>,
}

fn aims() -> Vec<Aim> {
    let particles = |value: &Value| Some(value["particle_substeps_per_s"].as_f64()? * 1e-6);
    let grid = |what, sheet, at_least, unit, of| Aim { what, job: sheets::name(sheet), at_least, unit, of };
    vec![
        grid("grid, n = 160", [160, 160], 500.0, "M particle-substeps/s", particles),
        grid("grid, n = 512", [512, 512], 500.0, "M particle-substeps/s", particles),
        grid("grid, 1368 × 5717", [1368, 5717], 45.0, "sub-steps/s", |value| value["steps_per_s"].as_f64()),
        Aim {
            what: "mesh, 1 M springs",
            job: MESH.to_owned(),
            at_least: 400.0,
            unit: "M springs/s",
            of: |value| Some(value["springs_per_s"].as_f64()? * 1e-6),
        },
    ]
}

const MESH: &str = "engine-mesh";
/// Benches beside those of grids, and what they are.
const BENCHES: [(&str, &str, &str); 4] = [
    (MESH, "bench mesh --json", "armadillo, 1 M springs, as many threads as help"),
    ("engine-mesh-1t", "bench mesh --json --threads 1", "armadillo, 1 M springs"),
    ("engine-drape", "bench drape --json", "160 × 160 on a ball, as many threads as help"),
    ("engine-drape-1t", "bench drape --json --threads 1", "160 × 160 on a ball"),
];

/// All runs.
pub fn jobs() -> Vec<Job> {
    BENCHES.iter().map(|&(name, words, _)| Job::bench(name, words, Quick::Out)).collect()
}

/// What came out.
pub fn section(look: &Look) -> Section {
    let mut table = Table::new(
        "aims",
        "What taffeta aims at on two cores with AVX-512; sheets of other sizes stand above.",
        &["bench", "aim: at least", "measured", "met"],
    );
    for Aim { what, job, at_least, unit, of } in aims() {
        table.row(vec![
            Cell::words(what),
            Cell::words(format!("{at_least} {unit}")),
            look.cell(&job, |value| Some(format!("{:.1}", of(value)?))),
            look.cell(&job, |value| Some(if of(value)? >= at_least { "yes" } else { "no" }.to_owned())),
        ]);
    }
    let mut others = speeds(
        "engine-benches",
        "A mesh whose springs are gathered, and a grid in contact. A frame is 1/30 s in 34 sub-steps. The fractions are of what the \
         same threads reach on the same machine: of a STREAM triad's bandwidth, counting each node's position and velocity read and \
         written once a sub-step, and of the peak of fused multiply-adds, counting 31 operations a spring.",
        "in a paper",
    );
    for (job, _, what) in BENCHES {
        others.row(speed(look, what, job, Cell::none(), "ours beside ours"));
    }
    Section::new("What the engine aims at").table(table).table(others)
}
