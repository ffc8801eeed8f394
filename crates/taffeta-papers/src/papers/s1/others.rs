//! Other engines on the scene of figure 15, in place of Unity's cloth.

use super::springs::{ALL, cloth};
use crate::report::look::{Look, grouped, short};
use crate::report::page::Section;
use crate::report::table::{Cell, Table};
use crate::runs::job::{Job, Quick, What};

const SIDES: [u32; 4] = [32, 64, 96, 256];
const ENGINES: [&str; 2] = ["rapier3d", "rapier-cloth-core"];
/// What runs them.
const COMMAND: &str = "cargo run --release --manifest-path scripts/others/Cargo.toml -- --out others.jsonl";

fn own(side: u32) -> String {
    format!("s1-others-taffeta-{side}")
}

fn other(engine: &str, side: u32) -> String {
    format!("s1-other-{engine}-{side}")
}

/// All runs.
pub fn jobs() -> Vec<Job> {
    let ours = SIDES.iter().map(|&side| {
        let sets = [
            "solver.method=springs".to_owned(),
            "time.max_step=0.001".to_owned(),
            "time.frames=300".to_owned(),
            format!("body.cloth.mesh.grid.rows={side}"),
            format!("body.cloth.mesh.grid.cols={side}"),
            cloth(&ALL, 3e4).replace("d=0.1", "d=5"),
        ];
        let quick = if side <= 32 { Quick::Frames(60) } else { Quick::Out };
        Job::scene(own(side), "s1_fig15", &sets, quick).threads(1)
    });
    let theirs = ENGINES.iter().flat_map(|engine| {
        SIDES.iter().map(|&side| Job {
            name: other(engine, side),
            what: What::Elsewhere(COMMAND),
            gpu: false,
            quick: Quick::Whole,
        })
    });
    ours.chain(theirs).collect()
}

/// What came out.
pub fn section(look: &Look) -> Section {
    let mut table = Table::new(
        "s1-others",
        "In place of Unity's cloth, which is closed: engines in Rust on S1's sheet and ball, on one thread in 32 bits, over the frames \
         of 1/60 s (ours: 16 ms) in which the cloth touches the ball. Not like for like: materials, solvers and contact differ. \
         rapier3d has springs of 100 Hz, as in its own test of cloth, and rapier-cloth-core its default material but for soft \
         bending, as in its demonstration; ours has springs of 30,000 N/m, about as stiff as rapier3d's, in steps of 1 ms. Less \
         stretch is a stiffer cloth and more work: read both columns. Theirs are compiled for any x86-64, ours chooses AVX-512. At \
         256 × 256 they were stopped after a minute (60 and 77 frames, mostly of the impact), and 0.15 kg a node, as in all rows, \
         makes a sheet of 9.8 t. The run of each says how it was set up. bevy_silk is for an older Bevy and has no contact of its own.",
        &[
            "side",
            "engine",
            "nodes",
            "springs",
            "device",
            "steps a frame",
            "ms a frame: median (least to most)",
            "largest l/L",
        ],
    );
    for side in SIDES {
        table.row(row(look, side, "taffeta", &own(side)));
        for engine in ENGINES {
            table.row(row(look, side, engine, &other(engine, side)));
        }
    }
    Section::new("S1: other engines on the same scene").table(table)
}

fn row(look: &Look, side: u32, engine: &str, job: &str) -> Vec<Cell> {
    let side = Cell::words(format!("{side} × {side}"));
    if let Err(why) = look.at(job) {
        let mut row = vec![side, Cell::words(format!("{engine}: open: {why}")), Cell::Open(why)];
        row.resize(8, Cell::none());
        return row;
    }
    let count = |key: &'static str| {
        look.cell(job, move |value| Some(value[key].as_u64().map_or_else(|| "none".to_owned(), grouped)))
    };
    vec![
        side,
        Cell::words(engine),
        count("nodes"),
        count("springs"),
        look.cell(job, |value| value["device"].as_str().map(str::to_owned)),
        count("substeps_per_frame"),
        look.cell(job, |value| {
            let [median, min, max] = ["median", "min", "max"].map(|key| value["ms_per_frame"][key].as_f64());
            Some(format!("{} ({} to {})", short(median?), short(min?), short(max?)))
        }),
        look.number(job, "max_stretch", 1.0, 2),
    ]
}
