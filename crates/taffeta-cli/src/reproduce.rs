//! `taffeta reproduce`: what three papers print, beside what comes out here.

use crate::console::{self, counted};
use crate::gpu;
use crate::run::unwritable;
use clap::ValueEnum;
use indicatif::{ProgressBar, ProgressStyle};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use taffeta_io::program::{Failure, RunLock, complain};
use taffeta_papers::{Done, Paper, Trouble, Wanted, Watch, reproduce};

/// Run the experiments of three papers, and write a report of theirs beside ours
///
/// Into the folder go report.html, which needs nothing else, the same as Markdown, tables as CSV, plots as SVG, pictures, and raw.jsonl, what
/// every run left. Stopped with Ctrl-C, the same command goes on where it was.
#[derive(clap::Args)]
pub struct Args {
    /// Which paper: S1: cloth, by springs and constraints. S2: cloth that touches itself. S3: bodies that keep their volume
    #[arg(value_enum)]
    what: What,
    /// Where the report goes
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// A short look of some minutes: fewer and shorter runs
    #[arg(long)]
    quick: bool,
    /// What a machine with a GPU has brought: its raw.jsonl, for rows that cannot be measured here
    #[arg(long, value_name = "FILE")]
    merge: Option<PathBuf>,
    /// Run nothing: write the report of what is in the folder
    #[arg(long)]
    only_report: bool,
}

#[derive(Clone, Copy, ValueEnum)]
enum What {
    /// Real-time cloth on compute shaders
    S1,
    /// CUDA cloth simulation
    S2,
    /// Volume constraints on surface meshes
    S3,
    /// All three, the errata, the methods at equal error, and the papers' limits
    All,
}

/// Runs the experiments and writes the report.
pub fn run(args: &Args) -> Result<(), Failure> {
    let papers = match args.what {
        What::S1 => vec![Paper::S1],
        What::S2 => vec![Paper::S2],
        What::S3 => vec![Paper::S3],
        What::All => Paper::ALL.to_vec(),
    };
    let _lock = lock(&args.out)?;
    let program = std::env::current_exe().map_err(|error| Failure::Work(format!("this program: {error}")))?;
    let wanted = Wanted {
        papers,
        out: args.out.clone(),
        quick: args.quick,
        merge: args.merge.clone(),
        only_report: args.only_report,
        program,
        gpu: gpu::open().is_ok_and(|gpu| !gpu.info().is_software()),
    };
    let watch = Bar::new()?;
    let done = reproduce(&wanted, &watch);
    watch.bar.finish_and_clear();
    match done {
        Ok(done) => tell(&done),
        Err(Trouble::Input(words)) => Err(Failure::Input(words)),
        Err(Trouble::Work(words)) => Err(Failure::Work(words)),
        Err(Trouble::Stopped) => Err(Failure::Interrupted(format!(
            "stopped; what was run is in {}, and the same command goes on",
            args.out.display()
        ))),
    }
}

/// Keeps other runs out of the folder.
fn lock(out: &Path) -> Result<RunLock, Failure> {
    if out.exists() && !out.is_dir() {
        return Err(Failure::Input(format!("--out {}: is a file; a folder would do", out.display())));
    }
    RunLock::take(out).map_err(|error| unwritable(out, error))
}

fn tell(done: &Done) -> Result<(), Failure> {
    let [now, before] = done.runs;
    let kept =
        if before == 0 { String::new() } else { format!(", {}", counted(before, "was there", "were there")) };
    console::say(&format!("{}{kept}: {}", counted(now, "run", "runs"), done.report.display()))?;
    if done.failed.is_empty() {
        return Ok(());
    }
    let words: Vec<String> = done.failed.iter().map(|(name, why)| format!("  {name}: {why}")).collect();
    let failed =
        counted(words.len(), "run failed; its numbers are open", "runs failed; their numbers are open");
    Err(Failure::Work(format!("{failed}:\n{}", words.join("\n"))))
}

/// Progress on a terminal; elsewhere a line each run.
struct Bar {
    bar: ProgressBar,
    stopped: Arc<AtomicBool>,
}

impl Bar {
    fn new() -> Result<Self, Failure> {
        let stopped = Arc::new(AtomicBool::new(false));
        let asked = Arc::clone(&stopped);
        ctrlc::set_handler(move || asked.store(true, Ordering::Relaxed))
            .map_err(|error| Failure::Work(format!("cannot listen for Ctrl-C: {error}")))?;
        let bar = ProgressBar::new(0);
        let template = "{bar:30} run {pos} of {len}, {elapsed} so far, {eta} left\n{wide_msg}";
        // The template is ours and right; were it not, the plain bar serves.
        bar.set_style(
            ProgressStyle::with_template(template).unwrap_or_else(|_| ProgressStyle::default_bar()),
        );
        Ok(Self { bar, stopped })
    }
}

impl Watch for Bar {
    fn begins(&self, number: usize, count: usize, command: &str) {
        self.bar.set_length(count as u64);
        self.bar.set_position(number as u64);
        self.bar.set_message(command.to_owned());
        if self.bar.is_hidden() {
            complain(&format!("{number} of {count}: {command}"));
        }
    }

    fn says(&self, words: &str) {
        self.bar.suspend(|| complain(words));
    }

    fn is_stopped(&self) -> bool {
        self.stopped.load(Ordering::Relaxed)
    }
}
