//! What cloth does in figures 11 to 15, and beside them.

use super::costs::gain;
use super::springs::{self, ALL, LOOK, TWO};
use crate::papers::curve;
use crate::report::look::Look;
use crate::report::page::{Picture, Section};
use crate::report::table::{Cell, Table};
use crate::runs::behaviour::Behaviour;
use crate::runs::job::{Job, Quick};
use std::collections::HashSet;

/// A scene in some variants.
struct Figure {
    name: &'static str,
    title: &'static str,
    words: &'static str,
    scene: &'static str,
    /// Whether any of its springs are solved for.
    solved: bool,
    /// Whether the cloth is drawn.
    pictured: bool,
    variants: Vec<Variant>,
}

/// A variant of a figure's scene.
struct Variant {
    /// Of its run; variants of two figures may be one run.
    job: &'static str,
    /// In a table.
    label: &'static str,
    sets: Vec<String>,
    quick: Quick,
}

fn variant(job: &'static str, label: &'static str, sets: &[&str], quick: Quick) -> Variant {
    Variant { job, label, sets: sets.iter().map(|&set| set.to_owned()).collect(), quick }
}

fn figures() -> Vec<Figure> {
    let all = |k| springs::cloth(&ALL, k);
    let two = |k| springs::cloth(&TWO, k);
    vec![
        Figure {
            name: "s1-fig11",
            scene: "s1_fig11",
            solved: false,
            pictured: true,
            title: "Figure 11: springs at 5 ms",
            words: "In figures 11 to 15 a sheet of 32 × 32 nodes of 0.15 kg and 2 × 2 m falls from 4 cm above a ball and lies on it, or \
                    slides off to the floor: S1 names neither masses nor sizes, and of the stiffnesses only the 1,000 N/m of figure \
                    13 and the 200 N/m of figure 15. Constraints are as compliant as their springs are stiff, unless it says \
                    *printed*; S1's are not.\n\nS1: soft springs look like rubber, stiff ones less so. So it is here between 200 and 2,000 N/m, though not at every \
                    step between: the largest stretch is that of one spring in one fold. At 2,000 N/m the step is close to the \
                    longest at which these springs are stable at rest (5.4 ms), and past that of folded cloth.",
            variants: vec![
                variant("s1-fig11-200", "200 N/m", &[], LOOK),
                variant("s1-fig11-500", "500 N/m", &[&all(500.0)], Quick::Out),
                variant("s1-fig11-1000", "1,000 N/m", &[&all(1000.0)], Quick::Out),
                variant("s1-fig11-2000", "2,000 N/m", &[&all(2000.0)], LOOK),
            ],
        },
        Figure {
            name: "s1-fig12",
            scene: "s1_fig12",
            solved: true,
            pictured: true,
            title: "Figure 12: ICE at 5 ms",
            words: "S1: with structural and shear springs alone the cloth is stretched more than with all. So it is here once \
                    the cloth lies.",
            variants: vec![
                variant("s1-fig12-all", "all springs", &[], LOOK),
                variant("s1-fig12-two", "structural and shear", &[&two(2000.0)], LOOK),
                variant("s1-fig12-stiff", "all, 20,000 N/m", &[&all(2e4)], Quick::Out),
            ],
        },
        Figure {
            name: "s1-fig13",
            scene: "s1_fig13",
            solved: true,
            pictured: true,
            title: "Figure 13: ACAD at 5 ms",
            words: "Stiff springs give hard cloth, soft ones soft cloth, as S1 has it. A constraint that closes its gap to L in \
                    one step gives its ends the more speed the shorter the step is; one that aims at the length at which \
                    it became active, 1.1 L, does not.",
            variants: vec![
                variant("s1-fig13-200", "200 N/m", &[], LOOK),
                variant("s1-fig13-500", "500 N/m", &[&all(500.0)], Quick::Out),
                variant("s1-fig13-1000", "1,000 N/m", &[&all(1000.0)], Quick::Out),
                variant(
                    "s1-fig13-1000-to",
                    "1,000 N/m, to 1.1 L",
                    &[&all(1000.0), "solver.acad.target=0.1"],
                    Quick::Out,
                ),
            ],
        },
        Figure {
            name: "s1-fig14",
            scene: "s1_fig14",
            solved: true,
            pictured: true,
            title: "Figure 14: ICE at 16 ms",
            words: "S1: with all types of springs it is more stable and accurate; so it is here. A constraint acts along its \
                    direction at the start of a step, and waves across cloth under a tension T grow where h² T/(m L) > 1: \
                    with stiffer springs and without bend springs sooner.",
            variants: vec![
                variant("s1-fig14-all", "all springs", &[], LOOK),
                variant("s1-fig14-two", "structural and shear", &[&two(2000.0)], LOOK),
                variant("s1-fig14-stiff", "all, 20,000 N/m", &[&all(2e4)], Quick::Out),
                variant("s1-fig14-two-stiff", "structural and shear, 20,000 N/m", &[&two(2e4)], Quick::Out),
            ],
        },
        Figure {
            name: "s1-fig15",
            scene: "s1_fig15",
            solved: true,
            pictured: true,
            title: "Figure 15: springs and ACAD at 16 ms, 200 N/m",
            words: "Springs alone blow up and ACAD, here corrected, does not but stretches, as S1 has it. As printed, with an accurate \
                    solve, a constraint closes its whole gap in one step: it blows up within a frame, soon after the first springs \
                    are 10 % too long. The table ends with the frame before. Why: `s1-acad` among the errata.",
            variants: vec![
                variant("s1-fig15-springs", "springs", &["solver.method=springs"], LOOK),
                variant("s1-fig15-acad", "ACAD", &[], LOOK),
                variant("s1-fig15-printed", "ACAD as printed", &["solver.acad.form=printed"], LOOK),
                variant("s1-fig15-ice", "ICE", &["solver.method=ice"], Quick::Out),
            ],
        },
        printed_ice(),
        printed_acad(),
        acad_options(),
        hanging(),
    ]
}

const PRINTED_ICE: &str = "solver.ice.form=printed";
const PRINTED_ACAD: &str = "solver.acad.form=printed";
const FEW: &str = "solver.ice.max_iterations=10";

fn printed_ice() -> Figure {
    let short = "time.max_step=0.005333333333333333";
    Figure {
        name: "s1-printed-ice",
        title: "ICE as printed",
        words: "S1's equation 11 has Φ = l² − L² and no compliance; with more springs than free directions there is no exact \
                solution, and the residual says so. S1 does not say how many iterations it takes: with few of them it holds for \
                longer.",
        scene: "s1_fig14",
        solved: true,
        pictured: false,
        variants: vec![
            variant("s1-fig14-all", "ours", &[], LOOK),
            variant("s1-printed-ice", "printed", &[PRINTED_ICE], LOOK),
            variant("s1-printed-ice-10", "printed, 10 iterations", &[PRINTED_ICE, FEW], Quick::Out),
            variant(
                "s1-printed-ice-10-short",
                "printed, 10 iterations, 5 ms",
                &[PRINTED_ICE, FEW, short],
                Quick::Out,
            ),
        ],
    }
}

fn printed_acad() -> Figure {
    let two = "solver.ice.max_iterations=2";
    Figure {
        name: "s1-printed-acad",
        title: "ACAD as printed, with few iterations",
        words: "As printed the constraint closes the whole gap in one step, and so injects energy; what few iterations leave of \
                the gap keeps the cloth bounded.",
        scene: "s1_fig15",
        solved: true,
        pictured: false,
        variants: vec![
            variant("s1-fig15-acad", "ours", &[], LOOK),
            variant("s1-fig15-printed", "printed", &[PRINTED_ACAD], LOOK),
            variant("s1-printed-acad-10", "printed, 10 iterations", &[PRINTED_ACAD, FEW], Quick::Out),
            variant("s1-printed-acad-2", "printed, 2 iterations", &[PRINTED_ACAD, two], Quick::Out),
        ],
    }
}

fn acad_options() -> Figure {
    let (epsilon, target) = ("solver.acad.epsilon=0.1", "solver.acad.target=0.1");
    Figure {
        name: "s1-acad-options",
        title: "ACAD: compliance and target",
        words: "ε is the compliance by the diagonal of the system, the target the length at which a constraint aims. With 0.1 kg \
                a node the springs that are no constraints are past their own stable step, and only boundedness can be asked.",
        scene: "s1_fig15",
        solved: true,
        pictured: false,
        variants: vec![
            variant("s1-fig15-acad", "ε = 0.3, to L", &[], LOOK),
            variant("s1-acad-1-0", "ε = 0.1, to L", &[epsilon], Quick::Out),
            variant("s1-acad-3-1", "ε = 0.3, to 1.1 L", &[target], Quick::Out),
            variant("s1-acad-1-1", "ε = 0.1, to 1.1 L", &[epsilon, target], Quick::Out),
            variant("s1-acad-light", "ε = 0.3, to L, 0.1 kg", &["body.cloth.node_mass=0.1"], Quick::Out),
        ],
    }
}

fn hanging() -> Figure {
    let of_kinds = |kinds: &[&str]| springs::of("sheet", kinds, 1e5, 0.0);
    let (one, two) = (of_kinds(&ALL[..1]), of_kinds(&TWO));
    let (short, swung) = ("time.max_step=0.001", "body.sheet.place.rotation.degrees=45");
    Figure {
        name: "s1-hanging",
        title: "ICE on a hanging sheet of 100,000 N/m",
        words: "No figure of S1. At steps of 16 ms, where springs alone stand 0.2 ms. With all springs it hangs still, with two kinds \
                too; where only structural springs hold it, waves across them grow however well the system is solved, and so they \
                do with all springs where it swings. Short steps hold both.",
        scene: "hanging_ice",
        solved: true,
        pictured: true,
        variants: vec![
            variant("s1-hanging-all", "all springs", &[], LOOK),
            variant("s1-hanging-two", "structural and shear", &[&two], Quick::Out),
            variant("s1-hanging-one", "structural", &[&one], Quick::Out),
            variant("s1-hanging-one-short", "structural, steps of 1 ms", &[&one, short], Quick::Out),
            variant("s1-hanging-swung", "all springs, let go at 45°", &[swung], Quick::Out),
            variant("s1-hanging-swung-short", "the same, steps of 1 ms", &[swung, short], Quick::Out),
        ],
    }
}

/// All runs.
pub fn jobs() -> Vec<Job> {
    let mut seen = HashSet::new();
    let mut jobs = Vec::new();
    for figure in figures() {
        for Variant { job, sets, quick, .. } in figure.variants {
            if seen.insert(job) {
                let job = Job::scene(job, figure.scene, &sets, quick);
                jobs.push(if figure.pictured { job.pictured() } else { job });
            }
        }
    }
    jobs
}

/// What came out.
pub fn sections(look: &Look) -> Vec<Section> {
    figures().iter().map(|figure| section(look, figure)).collect()
}

const COLUMNS: [&str; 10] = [
    "run",
    "largest l/L",
    "l/L at the end",
    "most energy beyond the start, J",
    "blew up",
    "frames of",
    "ms",
    "iterations a step",
    "largest residual",
    "springs that were constraints, %",
];

fn section(look: &Look, figure: &Figure) -> Section {
    let columns = if figure.solved { &COLUMNS[..] } else { &COLUMNS[..7] };
    let mut table = Table::new(figure.name, "Of all frames.", columns);
    let mut section = Section::new(&format!("S1: {}", figure.title)).words(figure.words);
    let mut curves = Vec::new();
    let mut pictures = Vec::new();
    for variant in &figure.variants {
        let job = variant.job;
        let mut row = vec![
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
        ];
        if figure.solved {
            row.extend(solver(look, job));
        }
        table.row(row);
        if let Some(done) = look.of::<Behaviour>(job) {
            pictures.extend(done.png().filter(|_| figure.pictured).map(|png| Picture {
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

/// What the solver did: mean of the most iterations of a step, largest residual, mean share of springs that were constraints.
fn solver(look: &Look, job: &str) -> [Cell; 3] {
    let of = |text: fn(&serde_json::Value) -> Option<String>| {
        look.cell(job, move |value| {
            let ran = value["iterations"].as_f64()? > 0.0;
            if ran { text(value) } else { Some("–".to_owned()) }
        })
    };
    [
        of(|value| Some(format!("{:.1}", value["iterations"].as_f64()?))),
        of(|value| Some(format!("{:.1e}", value["residual"].as_f64()?))),
        of(|value| Some(format!("{:.1}", value["active"].as_f64()? * 1e2))),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::runs::scenes;
    use std::collections::HashMap;

    #[test]
    fn every_variant_can_be_read_and_one_name_is_one_run() {
        let mut known = HashMap::new();
        for figure in figures() {
            for Variant { job, sets, .. } in figure.variants {
                let loaded = scenes::load(figure.scene, &sets);
                assert!(loaded.is_ok(), "{job}: {:?}", loaded.err());
                let run = (figure.scene, sets);
                assert_eq!(known.entry(job).or_insert_with(|| run.clone()), &run, "{job}");
            }
        }
    }

    #[test]
    fn two_kinds_of_springs_leave_out_the_third() {
        let scene = scenes::load("s1_fig14", &[springs::cloth(&TWO, 2000.0)]).unwrap().scene;
        let springs = &scene.bodies[0].springs;
        assert_eq!(springs.shear.map(|spring| (spring.k, spring.d)), Some((2000.0, 0.1)));
        assert!(springs.structural.is_some() && springs.bend.is_none());
    }
}
