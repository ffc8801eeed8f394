//! `taffeta-papers s1 | s2 | s3 | all`: the report.

use crate::drive::{self, Done, Wanted};
use crate::papers::paper::Paper;
use crate::progress::Progress;
use crate::report::look::grouped;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use taffeta::taffeta_gpu::{Choice, Gpu};
use taffeta_io::program::{self, Failure, RunLock};

/// Into the folder go report.html, which needs nothing else, the same as Markdown, tables as CSV, plots as SVG, pictures, and
/// raw.jsonl, what every run left. Stopped with Ctrl-C, the same command goes on where it was.
#[derive(clap::Args)]
pub struct Args {
    /// Where the report goes
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// A short look of a minute: fewer and shorter runs
    #[arg(long)]
    quick: bool,
    /// What another machine or program has brought: its raw.jsonl, for rows that cannot be measured here
    #[arg(long, value_name = "FILE")]
    merge: Option<PathBuf>,
    /// Run nothing: write the report of what is in the folder
    #[arg(long)]
    only_report: bool,
    /// The program `taffeta`, which the benches are run with [default: the one beside this program]
    #[arg(long, value_name = "PATH")]
    taffeta: Option<PathBuf>,
}

/// Runs the experiments and writes the report.
pub fn run(args: &Args, papers: &[Paper]) -> Result<(), Failure> {
    let _lock = lock(&args.out)?;
    let wanted = Wanted {
        papers: papers.to_vec(),
        out: args.out.clone(),
        quick: args.quick,
        merge: args.merge.clone(),
        only_report: args.only_report,
        taffeta: args.taffeta.clone(),
        gpu: Gpu::open(&Choice::from_env()).is_ok_and(|gpu| !gpu.info().is_software()),
    };
    let progress = Progress::new()?;
    let done = drive::reproduce(&wanted, &progress);
    progress.end();
    tell(&done?)
}

/// Keeps other runs out of the folder.
fn lock(out: &Path) -> Result<RunLock, Failure> {
    if out.exists() && !out.is_dir() {
        return Err(Failure::Input(format!("--out {}: is a file; a folder would do", out.display())));
    }
    RunLock::take(out).map_err(|error| {
        let words = format!("--out {}: {error}", out.display());
        if error.kind() == ErrorKind::StorageFull { Failure::Work(words) } else { Failure::Input(words) }
    })
}

fn tell(done: &Done) -> Result<(), Failure> {
    let [now, before] = done.runs;
    let kept =
        if before == 0 { String::new() } else { format!(", {}", counted(before, "was there", "were there")) };
    program::say(&format!("{}{kept}: {}", counted(now, "run", "runs"), done.report.display()))?;
    if done.failed.is_empty() {
        return Ok(());
    }
    let words: Vec<String> = done.failed.iter().map(|(name, why)| format!("  {name}: {why}")).collect();
    let failed =
        counted(words.len(), "run failed; its numbers are open", "runs failed; their numbers are open");
    Err(Failure::Work(format!("{failed}:\n{}", words.join("\n"))))
}

fn counted(count: usize, one: &str, many: &str) -> String {
    format!("{} {}", grouped(count as u64), if count == 1 { one } else { many })
}
