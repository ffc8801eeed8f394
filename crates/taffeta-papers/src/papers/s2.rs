//! S2: cloth that touches itself.

use crate::report::look::{Look, speed, speeds};
use crate::report::page::{Plot, Section};
use crate::report::plot::{Series, log_log};
use crate::report::table::{Cell, Table};
use crate::runs::job::{Job, Quick};

/// Sides of the sheets that S2 has, and of larger ones.
const SIDES: [u32; 7] = [5, 10, 20, 40, 80, 120, 160];
const LARGER: [u32; 2] = [320, 640];
/// The side of which S2 gives numbers.
const PUBLISHED_SIDE: u32 = 160;
/// The largest that a quick look takes.
const QUICK_SIDE: u32 = 40;

/// S2's programs, what each adds, and its speed-up over the first.
const RUNGS: [(&str, &str, Option<f64>); 8] = [
    ("serial", "one thread, every node looks at all others", Some(1.0)),
    ("naive", "GPU, every node looks at all others", Some(108.51)),
    ("constants", "what is not written is constant", Some(110.88)),
    ("squared", "squared distances", Some(154.90)),
    ("swapped", "buffers exchange their roles", Some(154.68)),
    ("scanned", "bins, filled from all nodes", Some(156.70)),
    ("refreshed", "bins, filled from those around them", Some(1635.58)),
    ("binned", "ours: clusters of nodes, looked at when they may touch", None),
];

fn name(rung: &str, side: u32) -> String {
    format!("s2-{rung}-{side}")
}

/// All runs.
pub fn jobs() -> Vec<Job> {
    let mut jobs = Vec::new();
    for (rung, ..) in RUNGS {
        for side in SIDES.into_iter().chain(LARGER) {
            let words = format!("bench contact --n {side} --rungs {rung} --json");
            let quick = if side <= QUICK_SIDE { Quick::Frames(3) } else { Quick::Out };
            let own = rung == "binned";
            match rung {
                "serial" if !LARGER.contains(&side) => jobs.push(Job::bench(name(rung, side), words, quick)),
                "binned" => {
                    let long = if LARGER.contains(&side) { " --frames 10" } else { "" };
                    jobs.push(Job::bench(name(rung, side), format!("{words}{long}"), quick));
                }
                _ if !own && rung != "serial" && !LARGER.contains(&side) => {
                    jobs.push(Job::bench(name(rung, side), words, Quick::Whole).on_gpu());
                }
                _ => {}
            }
        }
    }
    let single = format!("bench contact --n {PUBLISHED_SIDE} --rungs binned --json --threads 1");
    jobs.push(Job::bench(name("binned-1t", PUBLISHED_SIDE), single, Quick::Out));
    let gpu = format!("bench contact --n {PUBLISHED_SIDE} --rungs binned --json --backend gpu");
    jobs.push(Job::bench(name("binned-gpu", PUBLISHED_SIDE), gpu, Quick::Whole).on_gpu());
    jobs
}

/// What came out.
pub fn sections(look: &Look) -> Vec<Section> {
    vec![ladder(look), times(look)]
}

fn ladder(look: &Look) -> Section {
    let mut ladder = Table::new(
        "s2-ladder",
        "Speed-up over the serial program on the CPU of the first row, also where a GPU's row comes from another machine; 160 × 160 \
         nodes, 34 sub-steps a frame, with self-collision. S2's serial program looks at all pairs on one thread, which nobody would \
         ship: the fair row for a CPU is the last one (on as many threads as help; on one thread it stands in the table below), and \
         the fair comparison of devices is that of the table below. S2 measures a GTX 1660 Ti against a Ryzen 7 3750H.",
        &["program", "what is new", "S2", "ours", "on"],
    );
    let serial = look.at(&name("serial", PUBLISHED_SIDE)).ok().and_then(|kept| median(&kept.result));
    for (rung, what, published) in RUNGS {
        let job = name(rung, PUBLISHED_SIDE);
        let up = look.cell(&job, |value| Some(format!("{:.2}", serial? / median(value)?)));
        let device = look.cell(&job, |value| value["device"].as_str().map(str::to_owned));
        ladder.row(vec![Cell::words(rung), Cell::words(what), Cell::theirs(published, 2), up, device]);
    }
    Section::new("S2: how nodes find each other").table(ladder)
}

fn median(line: &serde_json::Value) -> Option<f64> {
    line["ms_per_frame"]["median"].as_f64()
}

fn times(look: &Look) -> Section {
    let mut table = speeds(
        "s2-times",
        "Frames of 34 sub-steps of S2's scene: a sheet held at one edge falls on a ball, on the floor and on itself; the first 60 \
         frames are not timed. Sizes, masses and stiffness are ours: S2 prints none. It prints about 5 ms a frame on an RTX 4070 for \
         160 × 160 nodes. Serial frames are single sub-steps, timed and multiplied by 34 (at 160 × 160 three of them), and so is \
         their spread.",
        "S2, ms a frame",
    );
    let published = |side| Cell::theirs((side == PUBLISHED_SIDE).then_some(5.0), 0);
    for side in SIDES.into_iter().chain(LARGER) {
        let label = |what: &str| format!("{side} × {side}, {what}");
        if !LARGER.contains(&side) {
            let row = speed(
                look,
                &label("serial"),
                &name("serial", side),
                Cell::none(),
                "in method alone: written again from S2's text, our scene and machine",
            );
            table.row(row);
        }
        let alike = "no: S2's is on a GPU";
        table.row(speed(
            look,
            &label("ours, as many threads as help"),
            &name("binned", side),
            published(side),
            alike,
        ));
    }
    let job = name("binned-1t", PUBLISHED_SIDE);
    table.row(speed(
        look,
        "160 × 160, ours, 1 thread",
        &job,
        published(PUBLISHED_SIDE),
        "no: S2's is on a GPU",
    ));
    let job = name("binned-gpu", PUBLISHED_SIDE);
    table.row(speed(look, "160 × 160, ours, GPU", &job, published(PUBLISHED_SIDE), "no: another GPU"));
    for (rung, ..) in RUNGS.iter().filter(|(rung, ..)| !["serial", "binned"].contains(rung)) {
        let job = name(rung, PUBLISHED_SIDE);
        table.row(speed(
            look,
            &format!("160 × 160, S2's {rung}"),
            &job,
            Cell::none(),
            "in method alone: written again from its text, another GPU",
        ));
    }
    let caption = "Time of a frame by the number of nodes".to_owned();
    let plot = Plot {
        name: "s2-times".to_owned(),
        svg: log_log(&caption, "nodes", "ms a frame", &points(look)),
        caption,
    };
    Section::new("S2: time of a frame").table(table).plot(plot)
}

/// Nodes and milliseconds of each rung.
fn points(look: &Look) -> Vec<Series> {
    let of = |rung: &str| {
        let point = |side: u32| {
            let kept = look.at(&name(rung, side)).ok()?;
            Some((kept.result["nodes"].as_f64()?, median(&kept.result)?))
        };
        SIDES.into_iter().chain(LARGER).filter_map(point).collect::<Vec<_>>()
    };
    RUNGS.iter().map(|(rung, ..)| Series::of(*rung, of(rung))).collect()
}
