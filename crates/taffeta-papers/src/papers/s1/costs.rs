//! What ICE, ACAD and springs cost: figures 9 and 10.

use super::springs::{ALL, LOOK, NEARLY, TWO, cloth, on_threads};
use crate::kernels::bench::{KernelRun, What, Which};
use crate::kernels::{PaperKernels, Product};
use crate::report::look::{Look, short, speed, speeds};
use crate::report::page::Section;
use crate::report::table::{Cell, Table};
use crate::runs::job::{Job, Quick};

/// A speed of figures 9 and 10, with the frames a second that S1 prints.
struct Timing {
    job: &'static str,
    label: &'static str,
    scene: &'static str,
    sets: Vec<String>,
    published: Option<f64>,
    quick: Quick,
}

fn timings() -> Vec<Timing> {
    let fig9 = |job, label, side: u32, kinds: &[&str], published, quick| Timing {
        job,
        label,
        scene: "s1_fig14",
        sets: vec![
            format!("body.cloth.mesh.grid.rows={side}"),
            format!("body.cloth.mesh.grid.cols={side}"),
            "body.cloth.node_mass=0.1".to_owned(),
            cloth(kinds, 2e4),
            "solver.ice.max_iterations=2000".to_owned(),
        ],
        published: Some(published),
        quick,
    };
    let fig10 = |job, label, method: &str, published, quick| Timing {
        job,
        label,
        scene: "s1_fig13",
        sets: vec![format!("solver.method={method}"), cloth(&ALL, 1000.0)],
        published,
        quick,
    };
    vec![
        fig9("s1-fig9-all", "fig. 9: ICE, all springs", 34, &ALL, 31.95, LOOK),
        fig9("s1-fig9-two", "fig. 9: ICE, structural and shear, 32 × 32", 32, &TWO, 66.06, LOOK),
        fig9("s1-fig9-two-38", "fig. 9: ICE, structural and shear, 38 × 38", 38, &TWO, 44.25, Quick::Out),
        fig10("s1-fig10-springs", "fig. 10: springs", "springs", Some(222.46), Quick::Frames(120)),
        fig10("s1-fig10-acad", "fig. 10: ACAD", "acad", Some(206.44), Quick::Frames(120)),
        fig10("s1-fig10-ice", "fig. 10: ICE", "ice", None, Quick::Frames(120)),
    ]
}

/// Beside those of theirs.
const ON_GPU: &str = "no: S1's is on a GPU, and drawn";

/// All runs.
pub fn jobs() -> Vec<Job> {
    let mut jobs = Vec::new();
    for timing in timings() {
        let job = |name: String| Job::scene(name, timing.scene, &timing.sets, timing.quick);
        jobs.push(job(on_threads(timing.job, true)).threads(1));
        jobs.push(job(timing.job.to_owned()));
    }
    jobs.push(Job::bench("s1-ice-gpu", "bench ice --n 34 --json --backend gpu", Quick::Whole).on_gpu());
    let printed = Which::Paper(PaperKernels::Constraints(Product::Printed));
    let printed = KernelRun { what: What::Ice, sides: [34; 2], kernels: printed };
    jobs.push(Job::kernels("s1-ice-gpu-printed".to_owned(), printed));
    jobs.extend(SIZES.map(size_job));
    jobs
}

/// What came out.
pub fn section(look: &Look) -> Section {
    let mut table = speeds(
        "s1-methods",
        "Figures 9 and 10, one step a frame as S1 has it, over the frames in which the cloth touches the ball or the floor. \
         S1 prints its step, stiffness, masses and tolerances for neither. Ours: figure 9, the drop at 16 ms with 20,000 N/m and \
         0.1 kg a node, solved to a residual of 1e-3 in every step, although h² T/(m L) > 1 there: these sheets gain energy, up \
         to 8 times what they had (table below), so they are work to time, not behaviour; figure 10, 32 × 32 nodes at 5 ms with \
         1,000 N/m. S1 says that ICE in figure 10 \"can barely obtain the performance of cloth simulation in real-time\".",
        "S1, frames/s",
    );
    for timing in timings() {
        for (threads, single) in [("1 thread", true), ("as many threads as help", false)] {
            let job = on_threads(timing.job, single);
            let label = format!("{}, {threads}", timing.label);
            table.row(speed(look, &label, &job, Cell::theirs(timing.published, 2), ON_GPU));
        }
    }
    table.row(speed(
        look,
        "fig. 9: ICE, all springs, GPU",
        "s1-ice-gpu",
        Cell::theirs(Some(31.95), 2),
        "no: theirs draws, another GPU, other masses and tolerances",
    ));
    let same = NEARLY;
    let published = Cell::theirs(Some(31.95), 2);
    table.row(speed(look, "fig. 9: ICE, GPU, S1's kernels", "s1-ice-gpu-printed", published, same));
    let mut solves = Table::new(
        "s1-solves",
        "What the solver did in these runs.",
        &[
            "run",
            "iterations a step",
            "largest residual",
            "springs that were constraints, %",
            "largest l/L",
            "most energy beyond the start, J",
        ],
    );
    for timing in timings() {
        let job = timing.job;
        solves.row(vec![
            Cell::words(timing.label),
            look.number(job, "iterations", 1.0, 1),
            look.cell(job, |value| Some(format!("{:.1e}", value["residual"].as_f64()?))),
            look.number(job, "active", 1e2, 1),
            look.number(job, "max_stretch", 1.0, 3),
            gain(look, job),
        ]);
    }
    Section::new("S1: ICE, ACAD and springs, cost").table(table).table(solves).table(sizes(look))
}

/// Sides of the sheets whose cost by ICE is compared: the last has about a million constraints.
const SIZES: [u32; 6] = [34, 64, 102, 204, 289, 409];

fn size_name(side: u32) -> String {
    format!("s1-ice-{side}")
}

fn size_job(side: u32) -> Job {
    let frames = if side > 100 { " --frames 10" } else { "" };
    let quick = if side <= 64 { Quick::Frames(3) } else { Quick::Out };
    Job::bench(size_name(side), format!("bench ice --n {side} --backend cpu --json{frames}"), quick)
}

fn sizes(look: &Look) -> Table {
    let mut table = Table::new(
        "s1-ice-sizes",
        "ICE by the number of constraints: the cloth of 2 × 2 m by finer and finer sheets, which need shorter steps, over frames in \
         which it lies on the ball.",
        &[
            "sheet",
            "nodes",
            "constraints",
            "ms a step",
            "iterations a step",
            "ms for a million constraints and iterations",
            "largest residual",
        ],
    );
    for side in SIZES {
        let job = &size_name(side);
        let ms = |value: &serde_json::Value| Some(1e3 / value["steps_per_s"].as_f64()?);
        table.row(vec![
            Cell::words(format!("{side} × {side}")),
            look.count(job, "nodes"),
            look.count(job, "springs"),
            look.cell(job, |value| Some(format!("{:.2}", ms(value)?))),
            look.number(job, "iterations", 1.0, 1),
            look.cell(job, |value| {
                let each = value["springs"].as_f64()? * value["iterations"].as_f64()?.max(1.0);
                Some(format!("{:.2}", ms(value)? * 1e6 / each))
            }),
            look.cell(job, |value| Some(format!("{:.1e}", value["residual"].as_f64()?))),
        ]);
    }
    table
}

/// Energy beyond the start; none, where it is never more.
pub fn gain(look: &Look, job: &str) -> Cell {
    look.cell(job, |value| {
        let gain = value["energy_gain"].as_f64()?;
        // Rounding of 32 bits.
        let least = 1e-5 * value["start_energy"].as_f64()?.abs();
        Some(if gain > least { short(gain) } else { "none".to_owned() })
    })
}
