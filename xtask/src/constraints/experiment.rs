//! What is run: scenes in variants, as a user runs them with `--set`.

use crate::root;
use taffeta_io::Loaded;

/// A scene of `scenes/` in some variants, which stand beside each other.
pub struct Experiment {
    /// What the user calls it.
    pub name: &'static str,
    /// The file's name without its ending.
    pub scene: &'static str,
    /// Its heading on the page.
    pub title: &'static str,
    /// What is to be seen in it.
    pub words: &'static str,
    /// Whether the cloth is drawn.
    pub pictured: bool,
    pub variants: Vec<Variant>,
}

/// A run of an experiment.
pub struct Variant {
    /// In a table, and in a plot.
    pub label: &'static str,
    /// In names of files.
    pub slug: &'static str,
    /// What differs from the scene.
    pub sets: Vec<String>,
}

fn variant(label: &'static str, slug: &'static str, sets: &[&str]) -> Variant {
    Variant { label, slug, sets: sets.iter().map(|&set| set.to_owned()).collect() }
}

/// A variant in which all springs of the cloth are others: some kinds of one stiffness [N/m].
fn springs(label: &'static str, slug: &'static str, kinds: &[&str], k: f64) -> Variant {
    variant(label, slug, &[&of_kinds("cloth", kinds, k, 0.1)])
}

/// All springs of a body: some kinds of one stiffness `k` [N/m] and damping `d` [kg/s].
pub fn of_kinds(body: &str, kinds: &[&str], k: f64, d: f64) -> String {
    let each: Vec<String> = kinds.iter().map(|kind| format!("{kind}={{k={k},d={d}}}")).collect();
    format!("body.{body}.springs={{{}}}", each.join(","))
}

/// Kinds of springs.
pub const ALL_KINDS: [&str; 3] = ["structural", "shear", "bend"];
/// Those without bending.
pub const TWO_KINDS: [&str; 2] = ["structural", "shear"];
const PRINTED_ICE: &str = "solver.ice.form=printed";
const PRINTED_ACAD: &str = "solver.acad.form=printed";
const TARGET: &str = "solver.acad.target=0.1";
const SHORT: &str = "time.max_step=0.001";
const SWUNG: &str = "body.sheet.place.rotation.degrees=45";
const FEW: &str = "solver.ice.max_iterations=10";

/// The figures of Va, Choi and Hong 2021, then our own.
pub fn all() -> Vec<Experiment> {
    vec![fig11(), fig12(), fig13(), fig14(), fig15(), printed_ice(), printed_acad(), options(), hanging()]
}

fn fig11() -> Experiment {
    Experiment {
        name: "fig11",
        scene: "s1_fig11",
        title: "Figure 11: springs at 5 ms",
        words: "The stiffer the springs, the less the cloth looks like rubber, as S1 has it. At 2,000 N/m the step is close to the \
                longest at which these springs are stable at rest (5.4 ms), and past that of folded cloth.",
        pictured: true,
        variants: vec![
            variant("200 N/m", "200", &[]),
            springs("500 N/m", "500", &ALL_KINDS, 500.0),
            springs("1,000 N/m", "1000", &ALL_KINDS, 1000.0),
            springs("2,000 N/m", "2000", &ALL_KINDS, 2000.0),
        ],
    }
}

fn fig12() -> Experiment {
    Experiment {
        name: "fig12",
        scene: "s1_fig12",
        title: "Figure 12: ICE at 5 ms",
        words: "Without bend springs the cloth stretches more, as S1 has it, and folds more sharply.",
        pictured: true,
        variants: vec![
            variant("all springs", "all", &[]),
            springs("structural and shear", "two", &TWO_KINDS, 2000.0),
            springs("all, 20,000 N/m", "all-20000", &ALL_KINDS, 2e4),
        ],
    }
}

fn fig13() -> Experiment {
    Experiment {
        name: "fig13",
        scene: "s1_fig13",
        title: "Figure 13: ACAD at 5 ms",
        words: "Soft springs give soft cloth and stiff ones hard cloth, as S1 has it. A constraint that closes its gap to L in one \
                step gives its ends the more speed the shorter the step is; one that aims at the length at which it became \
                active, 1.1 L, does not.",
        pictured: true,
        variants: vec![
            variant("200 N/m", "200", &[]),
            springs("500 N/m", "500", &ALL_KINDS, 500.0),
            springs("1,000 N/m", "1000", &ALL_KINDS, 1000.0),
            variant("1,000 N/m, to 1.1 L", "1000-to", &[&of_kinds("cloth", &ALL_KINDS, 1000.0, 0.1), TARGET]),
        ],
    }
}

fn fig14() -> Experiment {
    Experiment {
        name: "fig14",
        scene: "s1_fig14",
        title: "Figure 14: ICE at 16 ms",
        words: "S1: the usage of all types of springs is more stable and accurate; so it is here. A constraint acts along its \
                direction at the start of a step, and waves across cloth under a tension T grow where h² T/(m L) > 1: with stiffer \
                springs and without bend springs sooner. Shorter steps (`max_step`) are the remedy, as figure 12 shows.",
        pictured: true,
        variants: vec![
            variant("all springs", "all", &[]),
            springs("structural and shear", "two", &TWO_KINDS, 2000.0),
            springs("all, 20,000 N/m", "all-20000", &ALL_KINDS, 2e4),
            springs("two kinds, 20,000 N/m", "two-20000", &TWO_KINDS, 2e4),
        ],
    }
}

fn fig15() -> Experiment {
    Experiment {
        name: "fig15",
        scene: "s1_fig15",
        title: "Figure 15: springs and ACAD at 16 ms, 200 N/m",
        words: "Springs alone blow up, ACAD does not, as S1 has it.",
        pictured: true,
        variants: vec![
            variant("springs", "springs", &["solver.method=springs"]),
            variant("ACAD", "acad", &[]),
        ],
    }
}

fn printed_ice() -> Experiment {
    Experiment {
        name: "printed-ice",
        scene: "s1_fig14",
        title: "ICE as printed",
        words: "S1's equation 11 has Φ = l² − L² and no compliance; with more springs than free directions there is no exact \
                solution, and the residual says so.",
        pictured: false,
        variants: vec![
            variant("ours", "ours", &[]),
            variant("printed", "printed", &[PRINTED_ICE]),
            variant("printed, 10 iterations", "printed-10", &[PRINTED_ICE, FEW]),
            variant(
                "printed, 10 iterations, 5 ms",
                "printed-10-short",
                &[PRINTED_ICE, FEW, "time.max_step=0.005333333333333333"],
            ),
        ],
    }
}

fn printed_acad() -> Experiment {
    Experiment {
        name: "printed-acad",
        scene: "s1_fig15",
        title: "ACAD as printed",
        words: "As printed the constraint closes the whole gap in one step, and so injects energy.",
        pictured: false,
        variants: vec![
            variant("ours", "ours", &[]),
            variant("printed", "printed", &[PRINTED_ACAD]),
            variant("printed, 10 iterations", "printed-10", &[PRINTED_ACAD, FEW]),
            variant("printed, 2 iterations", "printed-2", &[PRINTED_ACAD, "solver.ice.max_iterations=2"]),
        ],
    }
}

fn options() -> Experiment {
    let epsilon = "solver.acad.epsilon=0.1";
    Experiment {
        name: "acad-options",
        scene: "s1_fig15",
        title: "ACAD: compliance and target",
        words: "ε is the compliance by the diagonal of the system, the target the length at which a constraint aims. With 0.1 kg \
                a node the springs that are no constraints are past their own stable step, and only boundedness can be asked.",
        pictured: false,
        variants: vec![
            variant("ε = 0.3, to L", "3-0", &[]),
            variant("ε = 0.1, to L", "1-0", &[epsilon]),
            variant("ε = 0.3, to 1.1 L", "3-1", &[TARGET]),
            variant("ε = 0.1, to 1.1 L", "1-1", &[epsilon, TARGET]),
            variant("ε = 0.3, to L, 0.1 kg", "3-0-light", &["body.cloth.node_mass=0.1"]),
        ],
    }
}

fn hanging() -> Experiment {
    let structural = of_kinds("sheet", &ALL_KINDS[..1], 1e5, 0.0);
    let two = of_kinds("sheet", &TWO_KINDS, 1e5, 0.0);
    Experiment {
        name: "hanging",
        scene: "hanging_ice",
        title: "A hanging sheet of 100,000 N/m",
        words: "At steps of 16 ms, where springs alone stand 0.2 ms. With all springs it hangs still, with two kinds too; where only \
                structural springs hold it, waves across them grow however well the system is solved, and so they do with all \
                springs where it swings. Short steps hold both.",
        pictured: true,
        variants: vec![
            variant("all springs", "all", &[]),
            variant("structural and shear", "two", &[&two]),
            variant("structural", "one", &[&structural]),
            variant("structural, steps of 1 ms", "one-short", &[&structural, SHORT]),
            variant("all springs, let go at 45°", "swung", &[SWUNG]),
            variant("the same, steps of 1 ms", "swung-short", &[SWUNG, SHORT]),
        ],
    }
}

impl Experiment {
    /// The scene of a variant.
    pub fn load(&self, variant: &Variant) -> Result<Loaded, String> {
        load(self.scene, &variant.sets)
    }
}

/// A scene of `scenes/`, changed as by `--set`.
pub fn load(scene: &str, sets: &[String]) -> Result<Loaded, String> {
    let file = root().join("scenes").join(scene).with_extension("toml");
    taffeta_io::load_scene(&file, sets).map_err(|error| error.to_string())
}

/// The command that runs it.
pub fn command(scene: &str, sets: &[String]) -> String {
    let sets: String = sets.iter().map(|set| format!(" --set '{set}'")).collect();
    format!("taffeta run scenes/{scene}.toml{sets}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn every_variant_can_be_read_and_has_files_of_its_own() {
        let mut files = HashSet::new();
        for experiment in all() {
            for variant in &experiment.variants {
                assert!(
                    files.insert((experiment.name, variant.slug)),
                    "{} {}",
                    experiment.name,
                    variant.slug
                );
                let loaded = experiment.load(variant);
                assert!(
                    loaded.is_ok_and(|loaded| loaded.notes.is_empty()),
                    "{}: {:?}",
                    experiment.name,
                    variant.sets
                );
            }
        }
    }

    #[test]
    fn two_kinds_of_springs_leave_out_the_third() {
        let loaded = load("s1_fig14", &[of_kinds("cloth", &TWO_KINDS, 2000.0, 0.1)]);
        let scene = loaded.map(|loaded| loaded.scene).unwrap_or_default();
        let springs = &scene.bodies[0].springs;
        assert_eq!(springs.shear.map(|spring| (spring.k, spring.d)), Some((2000.0, 0.1)));
        assert!(springs.structural.is_some() && springs.bend.is_none());
    }
}
