//! Runs the jobs of some groups, keeps what each found, and goes on where a run was stopped.

use crate::bench::{Bench, Extent, Job, Row, STOPPED};
use crate::groups::Group;
use crate::report::{Report, Section};
use serde::{Deserialize, Serialize};
use std::fs::{self, File};
use std::io::Write;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::thread;
use taffeta::taffeta_gpu::Gpu;

/// What is to be tested, and where its report goes.
pub struct Plan<'a> {
    /// The folder of the report.
    pub folder: &'a Path,
    /// Which groups.
    pub groups: Vec<&'static Group>,
    /// How much of them.
    pub extent: Extent,
    /// The GPU for what runs on one; without it those tests are left out.
    pub gpu: Option<Gpu>,
    /// Jobs at the same time.
    pub threads: usize,
    /// Whether what an earlier run in this folder has found is taken over.
    pub resumes: bool,
    /// The machine, for the report.
    pub machine: String,
}

/// Is asked between frames, and hears of jobs.
pub trait Progress: Sync {
    /// A job begins: its number from 0, how many there are, and what it does.
    fn begins(&self, number: usize, count: usize, title: &str);
    /// Whether the user wants to stop.
    fn is_stopped(&self) -> bool;
}

/// Why there is no report.
#[derive(Debug)]
pub enum Failure {
    /// The user stopped it: what is done is kept.
    Stopped,
    /// The folder cannot be written to, or what is in it not be read.
    Files(String),
}

/// What a job left.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
struct Done {
    version: String,
    is_quick: bool,
    group: String,
    title: String,
    rows: Vec<Row>,
    failure: Option<String>,
}

/// What jobs left, a line of JSON each, as soon as it is done.
struct Kept {
    path: PathBuf,
    all: Vec<Done>,
}

/// Runs all tests of a plan and writes the report.
///
/// # Errors
/// Where the user stops it, or the folder cannot be written to.
pub fn validate(plan: &Plan<'_>, progress: &dyn Progress) -> Result<Report, Failure> {
    let folder = plan.folder.join("scenes");
    fs::create_dir_all(&folder).map_err(|error| Failure::Files(format!("{}: {error}", folder.display())))?;
    let kept = Mutex::new(Kept::open(plan)?);
    let of_group = |group: &'static Group| (group.jobs)(plan.extent).into_iter().map(move |job| (group, job));
    let jobs: Vec<(&Group, Job)> = plan
        .groups
        .iter()
        .flat_map(|group| of_group(group))
        .filter(|(_, job)| plan.gpu.is_some() || !job.needs_gpu)
        .collect();
    let next = AtomicUsize::new(0);
    let work = || {
        let bench = Bench { folder: plan.folder, gpu: plan.gpu.as_ref(), progress };
        loop {
            let index = next.fetch_add(1, Ordering::Relaxed);
            let Some((group, job)) = jobs.get(index) else { return Ok(()) };
            if kept.lock().is_ok_and(|kept| kept.of(group, job).is_some()) {
                continue;
            }
            progress.begins(index, jobs.len(), &format!("{}: {}", group.name, job.title));
            let done = done(plan, group, job, &bench)?;
            // A worker that panicked has kept nothing half.
            kept.lock().unwrap_or_else(std::sync::PoisonError::into_inner).keep(done)?;
        }
    };
    let ends: Vec<Result<(), Failure>> = thread::scope(|scope| {
        let workers: Vec<_> = (0..plan.threads.max(1)).map(|_| scope.spawn(work)).collect();
        let failed = |_| Err(Failure::Files("a test ended the program's thread".into()));
        workers.into_iter().map(|worker| worker.join().unwrap_or_else(failed)).collect()
    });
    ends.into_iter().collect::<Result<(), Failure>>()?;
    let kept = kept.into_inner().unwrap_or_else(std::sync::PoisonError::into_inner);
    let report = report(plan, &jobs, &kept);
    report.write(plan.folder).map_err(Failure::Files)?;
    Ok(report)
}

/// Does a job.
fn done(plan: &Plan<'_>, group: &Group, job: &Job, bench: &Bench<'_>) -> Result<Done, Failure> {
    let (rows, failure) = match (job.run)(bench) {
        Ok(rows) => (rows, None),
        Err(why) if why == STOPPED => return Err(Failure::Stopped),
        Err(why) => (Vec::new(), Some(format!("{}: {why}", job.title))),
    };
    let (group, title, version) = (group.name.to_owned(), job.title.clone(), version());
    Ok(Done { version, is_quick: plan.extent == Extent::Quick, group, title, rows, failure })
}

fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// What all jobs left, group by group, in the order of the jobs.
fn report(plan: &Plan<'_>, jobs: &[(&Group, Job)], kept: &Kept) -> Report {
    let mut report = Report::new(version(), plan.machine.clone(), plan.extent);
    for group in &plan.groups {
        let own = jobs.iter().filter(|(other, _)| other.name == group.name);
        let done: Vec<&Done> = own.filter_map(|(group, job)| kept.of(group, job)).collect();
        let rows = done.iter().flat_map(|done| done.rows.iter().cloned()).collect();
        let failures = done.iter().filter_map(|done| done.failure.clone()).collect();
        report.groups.push(Section::new(group, rows, failures));
    }
    report
}

impl Kept {
    /// What the folder has of this plan, if it is to be gone on with; nothing otherwise.
    fn open(plan: &Plan<'_>) -> Result<Self, Failure> {
        let path = plan.folder.join("rows.jsonl");
        let files = |error: std::io::Error| Failure::Files(format!("{}: {error}", path.display()));
        let text = if plan.resumes && path.is_file() {
            fs::read_to_string(&path).map_err(files)?
        } else {
            String::new()
        };
        // A last line that was not written whole is none.
        let all: Vec<Done> = text
            .lines()
            .filter_map(|line| serde_json::from_str::<Done>(line).ok())
            .filter(|done| done.version == version() && done.is_quick == (plan.extent == Extent::Quick))
            .collect();
        let mut kept = Self { path: path.clone(), all: Vec::new() };
        File::create(&path).map_err(files)?;
        all.into_iter().try_for_each(|done| kept.keep(done))?;
        Ok(kept)
    }

    fn of(&self, group: &Group, job: &Job) -> Option<&Done> {
        self.all.iter().find(|done| done.group == group.name && done.title == job.title)
    }

    fn keep(&mut self, done: Done) -> Result<(), Failure> {
        let write = || -> std::io::Result<()> {
            let mut file = File::options().append(true).create(true).open(&self.path)?;
            writeln!(file, "{}", serde_json::to_string(&done)?)
        };
        write().map_err(|error| Failure::Files(format!("{}: {error}", self.path.display())))?;
        self.all.push(done);
        Ok(())
    }
}
