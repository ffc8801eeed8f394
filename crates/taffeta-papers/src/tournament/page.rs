//! The tournament as a part of a page.

use super::method::Method;
use super::plan::{Entry, entries};
use super::run::Run;
use super::scenes::{CASES, Case, SHEETS};
use crate::report::look::grouped;
use crate::report::page::{Plot, Section};
use crate::report::store::Kept;
use crate::report::table::{Cell, Table};
use taffeta_plot::{Series, log_log};

/// Errors at which methods are compared, and their names.
const WANTED: [(f64, &str); 3] = [(1e-1, "10 %"), (1e-2, "1 %"), (1e-3, "0.1 %")];

/// A run that was made.
struct Made<'a> {
    entry: Entry,
    kept: &'a Kept,
    run: Run,
}

impl Made<'_> {
    /// A number of its run.
    fn ours(&self, text: impl Fn(&Run) -> Option<String>) -> Cell {
        Cell::ours(Ok(self.kept), |value| Run::read(value).and_then(|run| text(&run)))
    }

    /// ACAD without a constraint is springs, to the bit.
    fn is_springs(&self) -> bool {
        self.entry.method == Method::Acad && self.run.iterations.1 == 0
    }

    fn is(&self, case: &Case, method: Method) -> bool {
        self.entry.case.name == case.name && self.entry.method == method
    }
}

/// What is compared, how, and what came out, of the runs that were made.
pub fn sections<'a>(kept: impl Fn(&str) -> Option<&'a Kept>) -> Vec<Section> {
    let made = |cases: &'static [Case]| {
        let made = |entry: Entry| {
            let kept = kept(&entry.name())?;
            Some(Made { entry, kept, run: Run::read(&kept.result)? })
        };
        entries(cases, false).into_iter().filter_map(made).collect::<Vec<Made>>()
    };
    let [small, sheets] = [made(&CASES), made(&SHEETS)];
    vec![of_small(&small), of_sheets(&small, &sheets)]
}

fn of_small(all: &[Made]) -> Section {
    let section = Section::new("Which method, for which error").words(INTRO);
    let section = section.table(fastest("tournament-fastest", &CASES, all));
    let section = CASES
        .iter()
        .filter(|case| all.iter().any(|made| made.entry.case.name == case.name))
        .fold(section, |section, case| section.plot(plot(case, all)));
    section.table(times("tournament-times", &CASES, all)).words(LIMITS).table(runs("tournament-runs", all))
}

fn of_sheets(small: &[Made], all: &[Made]) -> Section {
    let section = Section::new("Which method, for larger sheets").words(SHEETS_INTRO);
    let section = section.table(fastest("sheets-fastest", &SHEETS, all));
    let measured = [1e2, 1e3, 1e4].into_iter().filter(|k| all.iter().any(|made| made.entry.case.k == *k));
    let section = measured.fold(section, |section, k| section.plot(by_size(k, small, all)));
    section.table(times("sheets-times", &SHEETS, all)).words(SHEETS_LIMITS).table(runs("sheets-runs", all))
}

const SHEETS_INTRO: &str = "The sheet that swings, on finer and finer grids. It is a sheet of 1 m and 0.2 kg whatever the grid is: springs of \
    k [N/m] make a membrane with C₁₁ = 6 k (4 k of it from bend springs), C₁₂ = k, C₆₆ = k. What resists folding, bend springs too, \
    vanishes as the spacing does.

Runs are of as many threads as help, and of fewer frames where the reference costs more: 30 up to 10,000 nodes, 15 of 100,000, 2 of a \
    million. The reference is explicit springs in 64 bits, in half the steps that are just stable, started half a step early, which makes \
    it exact to second order: its own error is a quarter of the one that stands beside every run. *dual, solved* is *dual* for up to \
    5,000 iterations in place of 200.";

const SHEETS_LIMITS: &str = "What limits each of them:

- *springs* are stable in steps of at most √(4 m/(10.1 k)), m the mass of a node: the number of steps grows with √(k nodes), and their \
    work with nodes on top. What is left of their error where k is large is rounding, which decides how the sheet wrinkles.
- *dual* is implicit along springs and explicit across. What swings is not damped; waves across the pull T grow where h² T/(m L) > 1, \
    that is in fine sheets. Iterations grow with nodes along an edge.
- *primal* is implicit across springs as well, so it holds in any step; but a long step damps the swing itself. Iterations hardly \
    grow with size and stiffness.
- Both of these damp the bounce along springs with which the sheet starts, at a rate of h ω²/2 (ω = 85/s at 100 N/m, more where it is \
    stiffer). Real cloth does not bounce for long either; here it is an error.";

const INTRO: &str = "A solver that takes longer steps is faster only if it is near enough to the truth with them. So each method runs \
         three scenes without contact in longer and shorter steps, and what counts is the time that it takes to a wanted error.

- **swing**: a sheet of 32 × 32 nodes and 1 m hangs from its upper edge and swings out at 3 rad/s, 5 % faster at one side. All \
         three kinds of springs; 0.2 g a node.
- **drum**: such a sheet is held all around, 5 % longer than at rest, and let go with a bump of 5 cm; damped springs, no gravity.
- **chain**: 100 links of 2 cm, let go from level and held at one end; 5 g a node.

Each is run soft and stiff, for 30 frames of 1/60 s, with:

- *springs*: `solver.method = \"springs\"`, explicit.
- *dual*: `solver.method = \"ice\"`, `form = \"compliant\"`, as it is by default.
- *primal*: `solver.method = \"ice\"`, `form = \"primal\"`, as it is by default.
- *acad*: `solver.method = \"acad\"`, as it is by default.
- *RK4*: the classical method of Runge and Kutta, in 32 bits and in 64. It is not a method of taffeta, but some plain code over a \
         list of springs without vector instructions; a baseline. S1 (section 4) says of it that it is nearer than explicit Euler, \
         and costs more.

All of the engine's runs are in 32 bits, and all runs on one thread. *Error* is √(Σ |x − x_ref|²/Σ |x_ref − x_start|²) over all \
         nodes and frames: distance from the reference, divided by the distance travelled. The reference is RK4 in 64 bits, in steps \
         a 16th as long as its longest stable ones; how far a run in steps twice as long is from it stands beside every run, and its own error is \
         less than a tenth of that. *Time* is wall time of frames alone, for each simulated second: the median of three to seven runs. \
         Below 1000 ms a second it is faster than real time.";

const LIMITS: &str = "What these scenes do not tell:

- They are taut. Slack cloth folds at random, and there no two runs agree for long.
- *acad* makes a constraint of a spring that is longer by 10 %, and that wants the length at rest back, whatever the stiffness is. \
Where there are some, as in the drum, it runs another material, and no step brings its error to zero. Where there are none it is \
*springs*, to the bit.
- In 32 bits rounding ends what shorter steps bring: a stiff spring feels the last digit of a place. Compare both of RK4.
- *dual* and *primal* damp what goes to and fro at ω at a rate of h ω²/2: *dual* what goes along springs, *primal* all. That is \
most of their error here, and hardly what is left when their iterations end. Who does not want cloth to ring may not mind it.
- Nothing here has more than 1,024 nodes. On larger sheets explicit steps get shorter, and *primal* gains.
- Runs in which a spring gets longer than in the reference by 5 % of its length are in the last table alone: long steps of *dual* and \
of *acad* may crumple what hangs, which hardly shows in the error.";

/// The fastest run of some that holds and is near enough.
fn best<'m, 'a>(all: impl Iterator<Item = &'m Made<'a>>, error: f64) -> Option<&'m Made<'a>>
where
    'a: 'm,
{
    let near = all.filter(|made| made.run.holds() && made.run.error.is_some_and(|off| off <= error));
    near.filter(|made| made.run.cost().is_some()).min_by(|a, b| {
        let cost = |made: &Made| made.run.cost().unwrap_or(f64::INFINITY);
        cost(a).total_cmp(&cost(b))
    })
}

fn fastest(name: &'static str, cases: &[Case], all: &[Made]) -> Table {
    let caption = "The fastest method of taffeta to an error: its steps in a frame, and milliseconds of wall time for each simulated second.";
    let heads = WANTED.map(|(_, name)| format!("to {name}"));
    let mut table = Table::new(name, caption, &["scene", &heads[0], &heads[1], &heads[2]]);
    for case in cases {
        let own = || all.iter().filter(|made| made.entry.case.name == case.name);
        let cell = |(error, _)| match best(
            own().filter(|made| made.entry.method.of_engine() && !made.is_springs()),
            error,
        ) {
            Some(made) => made
                .ours(|run| Some(format!("{}, {}: {}", run.method.label(), run.steps, digits(run.cost()?)))),
            None if own().next().is_none() => Cell::Open(format!("runs of {}", case.title)),
            None => Cell::words("none of these"),
        };
        let [ten, one, tenth] = WANTED.map(cell);
        table.row(vec![Cell::words(case.title), ten, one, tenth]);
    }
    table
}

fn times(name: &'static str, cases: &[Case], all: &[Made]) -> Table {
    let caption = "Of each method the fastest run to an error: milliseconds of wall time for each simulated second, with steps in a frame.";
    let heads = WANTED.map(|(_, name)| format!("to {name}"));
    let columns = ["scene", "method", &heads[0], &heads[1], &heads[2]];
    let mut table = Table::new(name, caption, &columns);
    for case in cases {
        for method in Method::ALL {
            let own = || all.iter().filter(|made| made.is(case, method));
            if own().next().is_none() {
                continue;
            }
            let [ten, one, tenth] = WANTED.map(|(error, _)| match best(own(), error) {
                Some(made) => made.ours(|run| Some(format!("{} ({})", digits(run.cost()?), run.steps))),
                None => Cell::none(),
            });
            table.row(vec![Cell::words(case.title), Cell::words(method.label()), ten, one, tenth]);
        }
    }
    table
}

fn plot(case: &Case, all: &[Made]) -> Plot {
    let series = Method::ALL.map(|method| {
        let good = all.iter().filter(|made| made.is(case, method) && made.run.holds());
        good.fold(Series::new(method.label()), |series, Made { run, .. }| {
            let at = (run.cost().unwrap_or(f64::NAN), run.error.unwrap_or(f64::NAN));
            let label = if series.points.is_empty() { run.steps.to_string() } else { String::new() };
            series.point(at, label)
        })
    });
    let caption = format!(
        "Error against time, {}: lower is nearer, left is faster. Numbers are steps in a frame of the first run that holds; the next \
         have twice as many each.",
        case.title
    );
    Plot {
        name: format!("tournament-{}", case.name),
        caption,
        svg: log_log(case.title, "wall time for each simulated second, ms", "error", &series),
    }
}

/// Of sheets with springs of `k` [N/m]: the time to an error of 1 %, by the number of nodes.
fn by_size(k: f64, small: &[Made], sheets: &[Made]) -> Plot {
    let all = || small.iter().chain(sheets).filter(|made| made.entry.case.swings() && made.entry.case.k == k);
    let methods = Method::ALL.into_iter().filter(|method| method.of_engine() && *method != Method::Acad);
    let series: Vec<Series> = methods
        .map(|method| {
            let of = |case: &Case| best(all().filter(|made| made.is(case, method)), WANTED[1].0);
            let points = CASES.iter().chain(&SHEETS).filter_map(|case| {
                let run = &of(case)?.run;
                Some((run.nodes as f64, run.cost()?))
            });
            Series::of(method.label(), points)
        })
        .collect();
    let name = format!("sheets-{k}");
    let caption = format!("Time to an error of 1 %, springs of {} N/m", grouped(k as u64));
    let svg = log_log(&caption, "nodes", "wall time for each simulated second, ms", &series);
    Plot { name, caption, svg }
}

fn runs(name: &'static str, all: &[Made]) -> Table {
    let caption = "All runs. *Energy* is what was gained by the end beyond the reference, by the reference's largest kinetic energy. \
                   *Iterations* are the mean over frames of the most in a step, and the most.";
    let columns = [
        "scene",
        "method",
        "steps a frame",
        "step, µs",
        "error",
        "largest l/L",
        "reference's",
        "energy",
        "iterations",
        "ms a second",
        "least to most",
        "reference in twice its step",
    ];
    let mut table = Table::new(name, caption, &columns);
    for made in all {
        let Entry { case, method, .. } = made.entry;
        let error = |run: &Run| match (run.error, run.diverged) {
            (Some(error), _) => Some(format!("{error:.1e}")),
            (None, frame) => Some(format!("blows up in frame {}", frame?)),
        };
        let of_good = |text: fn(&Run) -> Option<String>| {
            if made.run.error.is_some() { made.ours(text) } else { Cell::none() }
        };
        let iterations = |run: &Run| Some(format!("{:.0}, {}", run.iterations.0, run.iterations.1));
        table.row(vec![
            Cell::words(case.title),
            Cell::words(method.label()),
            made.ours(|run| Some(run.steps.to_string())),
            made.ours(|run| Some(digits(1e6 * run.step))),
            made.ours(error),
            of_good(|run| Some(format!("{:.4}", run.max_stretch))),
            made.ours(|run| Some(format!("{:.4}", run.reference_stretch))),
            of_good(|run| run.energy.map(|energy| format!("{energy:+.1e}"))),
            if made.run.iterations.1 > 0 { made.ours(iterations) } else { Cell::none() },
            of_good(|run| run.cost().map(digits)),
            of_good(|run| {
                run.wall_ms.map(|[least, _, most]| format!("{} to {}", digits(least), digits(most)))
            }),
            made.ours(|run| Some(format!("{:.1e}", run.reference))),
        ]);
    }
    table
}

/// Three digits.
fn digits(number: f64) -> String {
    let decimals = (2.0 - number.max(1e-6).log10().floor()).clamp(0.0, 4.0) as usize;
    format!("{number:.decimals$}")
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::page::Block;

    fn kept(method: Method, steps: u32, error: Option<f64>, cost: f64, max_stretch: f64) -> Kept {
        let entry = Entry { case: &CASES[0], method, steps };
        let run = Run {
            method,
            steps,
            step: super::super::scenes::FRAME / f64::from(steps),
            error,
            diverged: if error.is_none() { Some(3) } else { None },
            wall_ms: error.map(|_| [cost; 3]),
            max_stretch,
            reference_stretch: 1.0,
            ..Run::default()
        };
        let text = String::new;
        Kept {
            name: entry.name(),
            command: text(),
            machine: text(),
            program: text(),
            quick: false,
            result: serde_json::to_value(run).unwrap(),
        }
    }

    #[test]
    fn the_fastest_is_near_enough_did_not_crumple_and_is_of_the_engine() {
        let all = [
            kept(Method::Springs, 10, None, 0.0, 1.0),
            kept(Method::Springs, 20, Some(1e-4), 50.0, 1.01),
            kept(Method::Dual, 1, Some(0.004), 5.0, 1.2),
            kept(Method::Dual, 2, Some(0.002), 40.0, 1.02),
            kept(Method::Primal, 1, Some(0.08), 7.0, 1.02),
            kept(Method::Rk4, 15, Some(1e-6), 1.0, 1.0),
        ];
        let [section, sheets] =
            sections(|name| all.iter().find(|kept| kept.name == name)).try_into().ok().unwrap();
        // No sheet was run, so there is nothing to draw.
        assert_eq!(sheets.blocks.len(), 5);
        let tables: Vec<String> = section
            .blocks
            .iter()
            .filter_map(|block| if let Block::Table(table) = block { Some(table.csv()) } else { None })
            .collect();
        let row = "\"swing, 100 N/m\",\"primal, 1: 7.00\",\"dual, 2: 40.0\",\"springs, 20: 50.0\"";
        assert!(tables[0].contains(row), "{}", tables[0]);
        assert!(tables[0].contains("\"drum, 30 N/m\",open,open,open\n"), "{}", tables[0]);
        assert!(tables[1].contains("\"swing, 100 N/m\",dual,40.0 (2),40.0 (2),\n"), "{}", tables[1]);
        assert!(tables[1].contains("RK4,1.00 (15),1.00 (15),1.00 (15)"), "{}", tables[1]);
        assert!(tables[2].contains("springs,10,1667,blows up in frame 3,"), "{}", tables[2]);
        let plots = section.blocks.iter().filter(|block| matches!(block, Block::Plot(_)));
        assert_eq!(plots.count(), 1);
    }
}
