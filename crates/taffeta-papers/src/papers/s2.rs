//! S2: cloth that touches itself.

use crate::contact::{Contact, Rung};
use crate::report::look::{Look, speed, speeds};
use crate::report::page::{Plot, Section};
use crate::report::table::{Cell, Table};
use crate::runs::job::{Job, Quick};
use taffeta_plot::{Series, log_log};

/// Sides of the sheets that S2 has, and of larger ones.
const SIDES: [u32; 7] = [5, 10, 20, 40, 80, 120, 160];
const LARGER: [u32; 2] = [320, 640];
/// The side of which S2 gives numbers.
const PUBLISHED_SIDE: u32 = 160;
/// The largest that a quick look takes.
const QUICK_SIDE: u32 = 40;

/// S2's programs and ours, what each adds, and its speed-up over the first.
const RUNGS: [(Rung, &str, Option<f64>); 8] = [
    (Rung::Serial, "one thread, every node looks at all others", Some(1.0)),
    (Rung::Naive, "GPU, every node looks at all others", Some(108.51)),
    (Rung::Constants, "what is not written is constant", Some(110.88)),
    (Rung::Squared, "squared distances", Some(154.90)),
    (Rung::Swapped, "buffers exchange their roles", Some(154.68)),
    (Rung::Scanned, "bins, filled from all nodes", Some(156.70)),
    (Rung::Refreshed, "bins, filled from those around them", Some(1635.58)),
    (Rung::Binned, "ours: clusters of nodes, looked at when they may touch", None),
];

fn name(rung: Rung, side: u32) -> String {
    format!("s2-{}-{side}", rung.name())
}

/// Ours on one thread, and on a GPU.
const SINGLE: &str = "s2-binned-1t-160";
const ON_GPU: &str = "s2-binned-gpu-160";

/// All runs.
pub fn jobs() -> Vec<Job> {
    let mut jobs = Vec::new();
    let run = |rung, side| Contact { rung, side, frames: None, threads: None, gpu: false };
    let quick = |side| if side <= QUICK_SIDE { Quick::Frames(3) } else { Quick::Out };
    for (rung, ..) in RUNGS {
        for side in SIDES {
            let job = |quick| Job::contact(name(rung, side), run(rung, side), quick);
            jobs.push(if Rung::LADDER.contains(&rung) {
                job(Quick::Whole).on_gpu()
            } else {
                job(quick(side))
            });
        }
    }
    for side in LARGER {
        let long = Contact { frames: Some(10), ..run(Rung::Binned, side) };
        jobs.push(Job::contact(name(Rung::Binned, side), long, Quick::Out));
    }
    let ours = run(Rung::Binned, PUBLISHED_SIDE);
    jobs.push(Job::contact(SINGLE.to_owned(), Contact { threads: Some(1), ..ours }, Quick::Out));
    jobs.push(Job::contact(ON_GPU.to_owned(), Contact { gpu: true, ..ours }, Quick::Whole).on_gpu());
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
         the fair comparison of devices is that of the table below. S2 does not say how large its bins are: ours have a side of one and \
         a half thicknesses and 32 places. It measures a GTX 1660 Ti against a Ryzen 7 3750H.",
        &["program", "what is new", "S2", "ours", "on"],
    );
    let serial = look.at(&name(Rung::Serial, PUBLISHED_SIDE)).ok().and_then(|kept| median(&kept.result));
    for (rung, what, published) in RUNGS {
        let job = name(rung, PUBLISHED_SIDE);
        let up = look.cell(&job, |value| Some(format!("{:.2}", serial? / median(value)?)));
        let device = look.cell(&job, |value| value["device"].as_str().map(str::to_owned));
        ladder.row(vec![Cell::words(rung.name()), Cell::words(what), Cell::theirs(published, 2), up, device]);
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
                &name(Rung::Serial, side),
                Cell::none(),
                "in method alone: written again from S2's text, our scene and machine",
            );
            table.row(row);
        }
        let alike = "no: S2's is on a GPU";
        table.row(speed(
            look,
            &label("ours, as many threads as help"),
            &name(Rung::Binned, side),
            published(side),
            alike,
        ));
    }
    table.row(speed(
        look,
        "160 × 160, ours, 1 thread",
        SINGLE,
        published(PUBLISHED_SIDE),
        "no: S2's is on a GPU",
    ));
    table.row(speed(look, "160 × 160, ours, GPU", ON_GPU, published(PUBLISHED_SIDE), "no: another GPU"));
    for rung in Rung::LADDER {
        let job = name(rung, PUBLISHED_SIDE);
        table.row(speed(
            look,
            &format!("160 × 160, S2's {}", rung.name()),
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
    let of = |rung: Rung| {
        let point = |side: u32| {
            let kept = look.at(&name(rung, side)).ok()?;
            Some((kept.result["nodes"].as_f64()?, median(&kept.result)?))
        };
        SIDES.into_iter().chain(LARGER).filter_map(point).collect::<Vec<_>>()
    };
    RUNGS.iter().map(|(rung, ..)| Series::of(rung.name(), of(*rung))).collect()
}
