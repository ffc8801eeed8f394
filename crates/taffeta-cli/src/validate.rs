//! `taffeta validate`: cloth beside theory.

use crate::{console, gpu};
use indicatif::{ProgressBar, ProgressStyle};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::thread::available_parallelism;
use taffeta_io::program::{Failure, complain, processor};
use taffeta_validate::{Extent, GROUPS, Group, Plan, Progress, Report, validate};

/// Hold cloth against theory: strips, plates, loops, pulls and drapes on several meshes and with all solvers
///
/// Writes report.html, report.json, report.md, plots, and each scene that was run. Ends with exit code 1 if a number is farther off
/// than it may be.
#[derive(clap::Args)]
pub struct Args {
    /// Groups of tests; all if none is named
    names: Vec<String>,
    /// Folder of the report
    #[arg(long, default_value = "out/validate")]
    out: PathBuf,
    /// Fewer meshes and loads, in a minute or two
    #[arg(long)]
    quick: bool,
    /// Go on where a run in the same folder was stopped
    #[arg(long)]
    resume: bool,
    /// Leave out what runs on a GPU
    #[arg(long)]
    no_gpu: bool,
    /// Tests at the same time [default: one a processor]
    #[arg(long)]
    threads: Option<usize>,
    /// Print the report as JSON
    #[arg(long)]
    json: bool,
}

/// Runs the tests and says what they found.
pub fn run(args: &Args) -> Result<(), Failure> {
    let groups = chosen(&args.names)?;
    let gpu = if args.no_gpu { None } else { gpu::open().ok() };
    if !args.no_gpu && gpu.is_none() {
        complain("there is no GPU: tests that run on one are left out");
    }
    let adapter = gpu.as_ref().map_or_else(String::new, |gpu| format!(", {}", gpu.info().name));
    let plan = Plan {
        folder: &args.out,
        groups,
        extent: if args.quick { Extent::Quick } else { Extent::Whole },
        gpu,
        threads: args.threads.unwrap_or_else(|| available_parallelism().map_or(1, usize::from)),
        resumes: args.resume,
        machine: format!("{}{adapter}", processor()),
    };
    let watch = Watch::new()?;
    let report = validate(&plan, &watch);
    watch.bar.finish_and_clear();
    match report {
        Ok(report) => say(args, &report),
        Err(taffeta_validate::Failure::Files(why)) => Err(Failure::Work(why)),
        Err(taffeta_validate::Failure::Stopped) => {
            let folder = args.out.display();
            Err(Failure::Interrupted(format!(
                "stopped; `taffeta validate --out {folder} --resume` goes on, with the same names and flags"
            )))
        }
    }
}

/// The groups of some names, or all.
fn chosen(names: &[String]) -> Result<Vec<&'static Group>, Failure> {
    let all: Vec<&str> = GROUPS.iter().map(|group| group.name).collect();
    if let Some(unknown) = names.iter().find(|name| !all.contains(&name.as_str())) {
        return Err(Failure::Input(format!("there are no tests `{unknown}`; {} would do", all.join(", "))));
    }
    let wanted = |group: &&Group| names.is_empty() || names.iter().any(|name| name == group.name);
    Ok(GROUPS.iter().filter(wanted).collect())
}

/// Prints what was found; numbers that are too far off are an error.
fn say(args: &Args, report: &Report) -> Result<(), Failure> {
    let [good, bad] = report.counts();
    if args.json {
        console::say(&console::json(report)?)?;
    } else {
        for section in &report.groups {
            let [good, bad] = section.counts();
            console::say(&format!("{:<14} {good:>4} passed {bad:>4} failed", section.name))?;
            for row in section.rows.iter().filter(|row| !row.passed()) {
                console::say(&format!("  {row}"))?;
            }
            section.failures.iter().try_for_each(|failure| console::say(&format!("  {failure}")))?;
        }
        console::say(&format!("report: {}", args.out.join("report.html").display()))?;
    }
    if bad > 0 {
        return Err(Failure::Work(format!(
            "{bad} of {} numbers are farther off than they may be",
            good + bad
        )));
    }
    Ok(())
}

/// Progress on a terminal, a line a test elsewhere, and Ctrl-C.
struct Watch {
    bar: ProgressBar,
    stopped: Arc<AtomicBool>,
}

impl Watch {
    fn new() -> Result<Self, Failure> {
        let stopped = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stopped);
        let stop = move || {
            if asked.swap(true, Ordering::Relaxed) {
                std::process::exit(130);
            }
        };
        ctrlc::set_handler(stop)
            .map_err(|error| Failure::Work(format!("cannot listen for Ctrl-C: {error}")))?;
        let bar = ProgressBar::new(0);
        let template = "{bar:30} test {pos} of {len}, {elapsed} so far, {eta} left\n{wide_msg}";
        // The template is ours and right; were it not, the plain bar serves.
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        Ok(Self { bar, stopped })
    }
}

impl Progress for Watch {
    fn begins(&self, number: usize, count: usize, title: &str) {
        self.bar.set_length(count as u64);
        self.bar.set_position(number as u64);
        self.bar.set_message(title.to_owned());
        if self.bar.is_hidden() {
            complain(&format!("{} of {count}: {title}", number + 1));
        }
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}
