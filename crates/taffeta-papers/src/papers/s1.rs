//! S1: cloth by springs, by implicit constraints (ICE), and by springs that become constraints (ACAD).

mod others;

use crate::papers::curve;
use crate::report::look::{Look, short, speed, speeds};
use crate::report::page::{Picture, Plot, Section};
use crate::report::plot::{Series, log_log};
use crate::report::table::{Cell, Table};
use crate::runs::behaviour::{Behaviour, Scene};
use crate::runs::job::{Job, Quick, What};

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

/// A scene of figures 9 to 15, in a variant.
struct Variant {
    /// Of its run.
    job: &'static str,
    /// In a table.
    label: &'static str,
    scene: &'static str,
    sets: Vec<String>,
    quick: Quick,
}

/// All springs of the cloth: some kinds of one stiffness [N/m].
fn springs(kinds: &[&str], k: f64) -> String {
    let each: Vec<String> = kinds.iter().map(|kind| format!("{kind}={{k={k},d=0.1}}")).collect();
    format!("body.cloth.springs={{{}}}", each.join(","))
}

const ALL: [&str; 3] = ["structural", "shear", "bend"];
const TWO: [&str; 2] = ["structural", "shear"];

fn variant(
    job: &'static str,
    label: &'static str,
    scene: &'static str,
    sets: &[&str],
    quick: Quick,
) -> Variant {
    Variant { job, label, scene, sets: sets.iter().map(|&set| set.to_owned()).collect(), quick }
}

/// Frames of behaviour that a quick look takes.
const LOOK: Quick = Quick::Frames(60);

/// A figure of behaviour.
struct Figure {
    name: &'static str,
    title: &'static str,
    words: &'static str,
    variants: Vec<Variant>,
}

fn figures() -> Vec<Figure> {
    let all = |k| springs(&ALL, k);
    let two = |k| springs(&TWO, k);
    vec![
        Figure {
            name: "s1-fig11",
            title: "Figure 11: springs at 5 ms",
            words: "S1: soft springs look like rubber, stiff ones less so. So it is here between 200 and 2,000 N/m, though not at every \
                    step between: the largest stretch is that of one spring in one fold. At 2,000 N/m the step is close to the \
                    longest at which these springs are stable at rest (5.4 ms), and past that of folded cloth.",
            variants: vec![
                variant("s1-fig11-200", "200 N/m", "s1_fig11", &[], LOOK),
                variant("s1-fig11-500", "500 N/m", "s1_fig11", &[&all(500.0)], Quick::Out),
                variant("s1-fig11-1000", "1,000 N/m", "s1_fig11", &[&all(1000.0)], Quick::Out),
                variant("s1-fig11-2000", "2,000 N/m", "s1_fig11", &[&all(2000.0)], LOOK),
            ],
        },
        Figure {
            name: "s1-fig12",
            title: "Figure 12: ICE at 5 ms",
            words: "S1: with structural and shear springs alone the cloth is stretched more than with all. So it is here once \
                    the cloth lies.",
            variants: vec![
                variant("s1-fig12-all", "all springs", "s1_fig12", &[], LOOK),
                variant("s1-fig12-two", "structural and shear", "s1_fig12", &[&two(2000.0)], LOOK),
                variant("s1-fig12-stiff", "all, 20,000 N/m", "s1_fig12", &[&all(2e4)], Quick::Out),
            ],
        },
        Figure {
            name: "s1-fig13",
            title: "Figure 13: ACAD at 5 ms",
            words: "Stiff springs give hard cloth, soft ones soft cloth, as S1 has it. A constraint that closes its gap to L in \
                    one step gives its ends the more speed the shorter the step is; one that aims at the length at which \
                    it became active, 1.1 L, does not.",
            variants: vec![
                variant("s1-fig13-200", "200 N/m", "s1_fig13", &[], LOOK),
                variant("s1-fig13-500", "500 N/m", "s1_fig13", &[&all(500.0)], Quick::Out),
                variant("s1-fig13-1000", "1,000 N/m", "s1_fig13", &[&all(1000.0)], Quick::Out),
                variant(
                    "s1-fig13-1000-to",
                    "1,000 N/m, to 1.1 L",
                    "s1_fig13",
                    &[&all(1000.0), "solver.acad.target=0.1"],
                    Quick::Out,
                ),
            ],
        },
        Figure {
            name: "s1-fig14",
            title: "Figure 14: ICE at 16 ms",
            words: "S1: with all types of springs it is more stable and accurate; so it is here. A constraint acts along its \
                    direction at the start of a step, and waves across cloth under a tension T grow where h² T/(m L) > 1: \
                    with stiffer springs and without bend springs sooner.",
            variants: vec![
                variant("s1-fig14-all", "all springs", "s1_fig14", &[], LOOK),
                variant("s1-fig14-two", "structural and shear", "s1_fig14", &[&two(2000.0)], LOOK),
                variant("s1-fig14-stiff", "all, 20,000 N/m", "s1_fig14", &[&all(2e4)], Quick::Out),
            ],
        },
        Figure {
            name: "s1-fig15",
            title: "Figure 15: springs and ACAD at 16 ms, 200 N/m",
            words: "Springs alone blow up and ACAD, here mended, does not but stretches, as S1 has it. As printed, with an accurate \
                    solve, a constraint closes its whole gap in one step: it blows up within a frame, soon after the first springs \
                    are 10 % too long. The table ends with the frame before. Why: `s1-acad` among the errata.",
            variants: vec![
                variant("s1-fig15-springs", "springs", "s1_fig15", &["solver.method=springs"], LOOK),
                variant("s1-fig15-acad", "ACAD", "s1_fig15", &[], LOOK),
                variant(
                    "s1-fig15-printed",
                    "ACAD as printed",
                    "s1_fig15",
                    &["solver.acad.form=printed"],
                    LOOK,
                ),
                variant("s1-fig15-ice", "ICE", "s1_fig15", &["solver.method=ice"], Quick::Out),
            ],
        },
    ]
}

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
            springs(kinds, 2e4),
            "solver.ice.max_iterations=2000".to_owned(),
        ],
        published: Some(published),
        quick,
    };
    let fig10 = |job, label, method: &str, published, quick| Timing {
        job,
        label,
        scene: "s1_fig13",
        sets: vec![format!("solver.method={method}"), springs(&ALL, 1000.0)],
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

/// Threads of the machine, and one.
fn on_threads(name: &str, single: bool) -> String {
    if single { format!("{name}-1t") } else { name.to_owned() }
}

fn sheet_name([rows, cols]: [u32; 2]) -> String {
    if rows == cols { format!("s1-grid-{rows}") } else { format!("s1-grid-{rows}x{cols}") }
}

fn sheet_words([rows, cols]: [u32; 2]) -> String {
    if rows == cols { format!("--n {rows}") } else { format!("--rows {rows} --cols {cols}") }
}

/// The sheets of the table of springs: rows, columns, kinds, what S1 prints, and what to say of it.
const COUNTED: [(&str, u32, &[&str], u32, &str); 4] = [
    ("s1-count-32", 32, &ALL, 5826, "fig. 10"),
    ("s1-count-34", 34, &ALL, 6598, "fig. 9"),
    (
        "s1-count-32-two",
        32,
        &TWO,
        3906,
        "fig. 9: S1 calls it the same model as that of 1,156 nodes; it has 1,024",
    ),
    ("s1-count-38-two", 38, &TWO, 5550, "fig. 9: S1 says 1,440 nodes; 38² is 1,444"),
];

/// All runs.
pub fn jobs() -> Vec<Job> {
    let mut jobs = Vec::new();
    for (name, side, kinds, ..) in COUNTED {
        let sets = vec![
            format!("body.cloth.mesh.grid.rows={side}"),
            format!("body.cloth.mesh.grid.cols={side}"),
            springs(kinds, 200.0),
        ];
        let scene = Scene { name: "s1_fig15", sets, threads: None, pictured: false };
        jobs.push(Job { name: name.to_owned(), what: What::Counts(scene), gpu: false, quick: Quick::Whole });
    }
    for sheet in SHEETS {
        let (name, words) = (sheet_name(sheet), sheet_words(sheet));
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
        let printed = format!("bench grid {words} --json --backend gpu --kernels node-centric");
        jobs.push(Job::bench(format!("{name}-gpu-printed"), printed, Quick::Whole).on_gpu());
    }
    for timing in timings() {
        let job = |name: String| Job::scene(name, timing.scene, &timing.sets, timing.quick);
        jobs.push(job(on_threads(timing.job, true)).threads(1));
        jobs.push(job(timing.job.to_owned()));
    }
    jobs.extend(others::jobs());
    let gpu = |n, words: &str| format!("bench {n} --n 34 --json --backend gpu{words}");
    jobs.push(Job::bench("s1-ice-gpu", gpu("ice", ""), Quick::Whole).on_gpu());
    jobs.push(Job::bench("s1-ice-gpu-printed", gpu("ice", " --kernels printed"), Quick::Whole).on_gpu());
    for variant in figures().iter().flat_map(|figure| &figure.variants) {
        jobs.push(Job::scene(variant.job, variant.scene, &variant.sets, variant.quick).pictured());
    }
    jobs
}

/// What came out.
pub fn sections(look: &Look) -> Vec<Section> {
    let mut sections = vec![counts(look), sheets(look), others::section(look), costs(look)];
    sections.extend(figures().iter().map(|figure| behaviour(look, figure)));
    sections
}

fn counts(look: &Look) -> Section {
    let columns = ["sheet", "nodes", "structural", "shear", "bend", "springs", "S1", "where"];
    let mut table = Table::new(
        "s1-springs",
        "Springs of a sheet of R × C nodes: structural R(C−1) + C(R−1), shear \
        2(R−1)(C−1), bend R(C−2) + C(R−2).",
        &columns,
    );
    for (name, side, _, published, place) in COUNTED {
        let kind = |kind: &'static str| {
            look.cell(name, move |value| Some(value["kinds"][kind].as_u64().unwrap_or(0).to_string()))
        };
        table.row(vec![
            Cell::words(format!("{side} × {side}")),
            look.count(name, "nodes"),
            kind("structural"),
            kind("shear"),
            kind("bend"),
            look.count(name, "springs"),
            Cell::Theirs(crate::report::look::grouped(published.into())),
            Cell::words(place),
        ]);
    }
    Section::new("S1: numbers of springs").table(table)
}

/// Beside ICE, ACAD and springs of figures 9 and 10.
const ON_GPU: &str = "no: S1's is on a GPU, and drawn";
const NEARLY: &str = "nearly: their kernels written again, without drawing, another GPU";
const NOT_ALIKE: &str = "no: theirs draws and collides with a ball, another machine";

fn sheets(look: &Look) -> Section {
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
        let name = sheet_name(sheet);
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
            let kept = look.at(&format!("{}{ending}", sheet_name(*sheet))).ok()?;
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

fn costs(look: &Look) -> Section {
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
    Section::new("S1: ICE, ACAD and springs, cost").table(table).table(solves)
}

/// Energy beyond the start; none, where it is never more.
fn gain(look: &Look, job: &str) -> Cell {
    look.cell(job, |value| {
        let gain = value["energy_gain"].as_f64()?;
        // Rounding of 32 bits.
        let least = 1e-5 * value["start_energy"].as_f64()?.abs();
        Some(if gain > least { short(gain) } else { "none".to_owned() })
    })
}

fn behaviour(look: &Look, figure: &Figure) -> Section {
    let columns = [
        "run",
        "largest l/L",
        "l/L at the end",
        "most energy beyond the start, J",
        "blew up",
        "frames of",
        "ms",
    ];
    let caption = "Stretch and energy of all frames.";
    let mut table = Table::new(figure.name, caption, &columns);
    let mut section = Section::new(&format!("S1: {}", figure.title)).words(figure.words);
    let mut curves = Vec::new();
    let mut pictures = Vec::new();
    for variant in &figure.variants {
        let job = variant.job;
        table.row(vec![
            Cell::words(variant.label),
            look.number(job, "max_stretch", 1.0, 3),
            look.number(job, "end_stretch", 1.0, 3),
            gain(look, job),
            look.cell(job, |value| {
                let frame = value["diverged"].as_u64();
                Some(frame.map_or_else(|| "no".to_owned(), |frame| format!("in frame {frame}")))
            }),
            look.count(job, "frames"),
            look.number(job, "dt", 1e3, 0),
        ]);
        if let Some(done) = look.of::<Behaviour>(job) {
            pictures.extend(done.png().map(|png| Picture {
                name: job.to_owned(),
                caption: format!("{}: after 0.32 s, 0.64 s and 4.8 s, or before it blew up", variant.label),
                png,
            }));
            curves.push((variant.label, done.curve));
        }
    }
    section = section.table(table).plot(curve::stretch(figure.name, figure.title, &curves));
    pictures.into_iter().fold(section, Section::picture)
}
