//! Sheets of springs by size: figures 7 and 8.

use super::springs::{NEARLY, on_threads};
use crate::kernels::PaperKernels;
use crate::kernels::bench::{KernelRun, What, Which};
use crate::report::look::{Look, speed, speeds};
use crate::report::page::{Plot, Section};
use crate::report::table::Cell;
use crate::runs::job::{Job, Quick};
use taffeta_plot::{Series, log_log};

/// The run whose machine's limits stand for all.
pub const LIMITS: &str = "s1-grid-160-1t";

/// Sheets of figures 7 and 8: rows and columns.
const SHEETS: [[u32; 2]; 9] = [
    [32, 32],
    [64, 64],
    [96, 96],
    [160, 160],
    [256, 256],
    [512, 512],
    [1024, 1024],
    [2048, 2048],
    [1368, 5717],
];
/// The largest that a quick look takes.
const QUICK_NODES: u32 = 65_536;

/// Frames a second that S1 prints, by the number of nodes: on its GPU, on its CPU, and of Unity's own cloth.
const PUBLISHED: [(u32, [Option<f64>; 3]); 3] = [
    (9_216, [None, Some(44.83), None]),
    (65_536, [None, None, Some(44.08)]),
    (7_820_856, [Some(34.81), None, None]),
];

/// Beside those of theirs.
const NOT_ALIKE: &str = "no: theirs draws and collides with a ball, another machine";

/// The run of a sheet on as many threads as help.
pub fn name([rows, cols]: [u32; 2]) -> String {
    if rows == cols { format!("s1-grid-{rows}") } else { format!("s1-grid-{rows}x{cols}") }
}

fn words([rows, cols]: [u32; 2]) -> String {
    if rows == cols { format!("--n {rows}") } else { format!("--rows {rows} --cols {cols}") }
}

/// All runs.
pub fn jobs() -> Vec<Job> {
    let mut jobs = Vec::new();
    for sheet in SHEETS {
        let (name, words) = (name(sheet), words(sheet));
        let quick = if sheet[0] * sheet[1] <= QUICK_NODES { Quick::Frames(3) } else { Quick::Out };
        jobs.push(Job::bench(&name, format!("bench grid {words} --json"), quick));
        jobs.push(Job::bench(
            on_threads(&name, true),
            format!("bench grid {words} --json --threads 1"),
            quick,
        ));
        let gpu = Job::bench(
            format!("{name}-gpu"),
            format!("bench grid {words} --json --backend gpu"),
            Quick::Whole,
        );
        jobs.push(gpu.on_gpu());
        let printed =
            KernelRun { what: What::Grid, sides: sheet, kernels: Which::Paper(PaperKernels::NodeCentric) };
        jobs.push(Job::kernels(format!("{name}-gpu-printed"), printed));
    }
    jobs
}

/// What came out.
pub fn section(look: &Look) -> Section {
    let mut table = speeds(
        "s1-sheets",
        "Figures 7 and 8. A step of ours has the forces of theirs: all twelve springs of a node, with damping; theirs collides with a \
         ball and has normals as well. S1 prints frames a second, as its text reads of one step each, drawn in Unity on a GTX 1070 \
         or an i7-7700: its steps a second are at least these. Where it prints none for a size, there is none here; on its GPU it \
         has more than 200 in all of figure 7.",
        "S1, frames/s",
    );
    for sheet in SHEETS {
        let [rows, cols] = sheet;
        let printed =
            PUBLISHED.iter().find(|(nodes, _)| *nodes == rows * cols).map_or([None; 3], |row| row.1);
        let [on_gpu, on_cpu, unity] = printed.map(|fps| Cell::theirs(fps, 2));
        let name = name(sheet);
        let label = |what: &str| format!("{rows} × {cols}, {what}");
        table.row(speed(look, &label("CPU"), &on_threads(&name, true), on_cpu, NOT_ALIKE));
        table.row(speed(
            look,
            &label("CPU, as many threads as help"),
            &name,
            Cell::none(),
            "no: S1 has one thread there",
        ));
        table.row(speed(look, &label("GPU"), &format!("{name}-gpu"), on_gpu.clone(), NOT_ALIKE));
        let baseline = NEARLY;
        table.row(speed(look, &label("GPU, S1's kernels"), &format!("{name}-gpu-printed"), on_gpu, baseline));
        if unity != Cell::none() {
            let mut row = vec![Cell::words(label("Unity's cloth")), Cell::Theirs("65,536".to_owned())];
            row.resize(9, Cell::none());
            row.extend([unity, Cell::words("no: a closed program; others are below")]);
            table.row(row);
        }
    }
    let caption = "Steps a second by the number of nodes; S1's are frames a second, drawn".to_owned();
    let plot = Plot {
        name: "s1-sheets".to_owned(),
        svg: log_log(&caption, "nodes", "steps/s", &points(look)),
        caption,
    };
    Section::new("S1: mass–spring cloth by size").table(table).plot(plot)
}

/// Nodes and steps a second of each device.
fn points(look: &Look) -> Vec<Series> {
    let of = |ending: &str| {
        let point = |sheet: &[u32; 2]| {
            let kept = look.at(&format!("{}{ending}", name(*sheet))).ok()?;
            Some((kept.result["nodes"].as_f64()?, kept.result["steps_per_s"].as_f64()?))
        };
        SHEETS.iter().filter_map(point).collect::<Vec<_>>()
    };
    let published = |index: usize| {
        PUBLISHED.iter().filter_map(|(nodes, fps)| Some((f64::from(*nodes), fps[index]?))).collect::<Vec<_>>()
    };
    vec![
        Series::of("CPU, 1 thread", of("-1t")),
        Series::of("CPU, threads that help", of("")),
        Series::of("GPU", of("-gpu")),
        Series::of("S1: GTX 1070", published(0)),
        Series::of("S1: i7-7700", published(1)),
        Series::of("S1: Unity", published(2)),
    ]
}
