//! Runs what is wanted, one after the other, and writes the report.

use crate::papers::paper::Paper;
use crate::papers::{aims, limits, s1, s2, s3};
use crate::progress::Progress;
use crate::report::look::Look;
use crate::report::page::Section;
use crate::report::store::{self, Kept, Store};
use crate::report::write::{self, Head};
use crate::runs::job::{Job, Place, Quick, What};
use crate::runs::programs::Programs;
use crate::{errata, tournament};
use serde_json::Value;
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};
use taffeta_io::program::{Failure, processor};

/// What is to be reproduced.
pub struct Wanted {
    /// Of which papers; of all, errata, the tournament and the table of limits come with them.
    pub papers: Vec<Paper>,
    /// Where the report goes, and what is kept of runs.
    pub out: PathBuf,
    /// Whether a short look is enough.
    pub quick: bool,
    /// What another machine kept, for rows that cannot be measured here.
    pub merge: Option<PathBuf>,
    /// Whether nothing is run: the report is of what is there, whichever program left it.
    pub only_report: bool,
    /// The program `taffeta`, where it is not the one beside this program.
    pub taffeta: Option<PathBuf>,
    /// Whether a hardware GPU is there.
    pub gpu: bool,
}

/// How it ended.
#[derive(Debug)]
pub struct Done {
    /// The report.
    pub report: PathBuf,
    /// Runs that were made now, and that were there already.
    pub runs: [usize; 2],
    /// Runs that failed, with the reason.
    pub failed: Vec<(String, String)>,
}

/// Runs what is wanted and writes the report. What an earlier call in the same folder ran with the same program is not
/// run again.
///
/// # Errors
/// Bad input, before anything is made; a file that cannot be written; or that the user stopped it.
pub fn reproduce(wanted: &Wanted, progress: &Progress) -> Result<Done, Failure> {
    let brought = wanted.merge.as_deref().map_or(Ok(BTreeMap::new()), brought)?;
    let jobs = jobs(wanted);
    let programs = programs(&jobs, wanted)?;
    let mut store = opened(&wanted.out)?;
    let (mut missing, mut todo, mut known) = (BTreeMap::new(), Vec::new(), 0);
    for job in &jobs {
        match fate(job, wanted, &store, &brought, &programs) {
            Fate::Known => known += 1,
            Fate::Brought(kept) => store.keep(kept.clone()).map_err(at(&wanted.out))?,
            Fate::Missing(why) => drop(missing.insert(job.name.clone(), why)),
            Fate::Run => todo.push(job),
        }
    }
    if wanted.only_report && missing.len() == jobs.len() {
        let out = wanted.out.display();
        return Err(Failure::Input(format!("--only-report: {out} has no runs; without it they are made")));
    }
    let failed = run(&todo, wanted, &programs, &mut store, progress)?;
    missing.extend(failed.iter().cloned());
    let shown = jobs.iter().filter(|job| !missing.contains_key(&job.name));
    let shown: Vec<&Kept> = shown.filter_map(|job| store.get(&job.name)).collect();
    let sections = sections(wanted, &Look::new(&store, &missing));
    write::write(&wanted.out, &head(wanted, &shown), &sections, &store).map_err(Failure::Work)?;
    let runs = [todo.len() - failed.len(), known];
    Ok(Done { report: wanted.out.join("report.html"), runs, failed })
}

/// Runs jobs one after the other, and keeps what each leaves at once; returns those that failed, with the reason.
fn run(
    todo: &[&Job],
    wanted: &Wanted,
    programs: &Programs,
    store: &mut Store,
    progress: &Progress,
) -> Result<Vec<(String, String)>, Failure> {
    let (cache, stopped) = (wanted.out.join("references"), || progress.is_stopped());
    let place = Place { taffeta: programs.taffeta(), cache: &cache, stopped: &stopped };
    let mut failed = Vec::new();
    for (number, job) in (1..).zip(todo) {
        progress.begins(number, todo.len(), &job.command(wanted.quick));
        let result = job.run(wanted.quick, &place);
        if progress.is_stopped() {
            let out = wanted.out.display();
            return Err(Failure::Interrupted(format!(
                "stopped; what was run is in {out}, and the same command goes on"
            )));
        }
        match result {
            Ok(result) => {
                let (name, command) = (job.name.clone(), job.command(wanted.quick));
                let (machine, program) = (processor(), programs.hash(job.is_bench()).to_owned());
                let kept = Kept { name, command, machine, program, quick: wanted.quick, result };
                store.keep(kept).map_err(at(&wanted.out))?;
            }
            Err(why) => {
                progress.says(&format!("{}: {why}", job.name));
                failed.push((job.name.clone(), why));
            }
        }
    }
    Ok(failed)
}

/// The programs that make the runs; `taffeta` is among them where a bench is to be run.
fn programs(jobs: &[Job], wanted: &Wanted) -> Result<Programs, Failure> {
    let own = Programs::own()?;
    let benches = jobs.iter().any(|job| job.is_bench() && left_out(job, wanted).is_none());
    if benches { own.with_taffeta(wanted.taffeta.as_deref()) } else { Ok(own) }
}

/// What of a file went wrong.
fn at(what: &Path) -> impl Fn(std::io::Error) -> Failure {
    move |error| Failure::Work(format!("{}: {error}", what.display()))
}

/// What is kept in a folder, which is made if it is not there.
fn opened(out: &Path) -> Result<Store, Failure> {
    fs::create_dir_all(out.join("references")).map_err(at(out))?;
    Store::open(out).map_err(|error| match error.kind() {
        ErrorKind::InvalidData => Failure::Input(format!(
            "{}: {error}; the file stays as it is: remove that line, and the run that it should be of is made again",
            out.join(Store::FILE).display()
        )),
        _ => at(out)(error),
    })
}

/// What becomes of a run.
enum Fate<'a> {
    /// What it left is there.
    Known,
    /// Another machine or program has left something.
    Brought(&'a Kept),
    /// It is not made, for a reason.
    Missing(String),
    /// It is made.
    Run,
}

fn fate<'a>(
    job: &Job,
    wanted: &Wanted,
    store: &Store,
    brought: &'a BTreeMap<String, Kept>,
    programs: &Programs,
) -> Fate<'a> {
    let brought = brought.get(&job.name).filter(|_| is_brought(job));
    let serves =
        |kept: &&Kept| kept.program == programs.hash(job.is_bench()) && (wanted.quick || !kept.quick);
    let known = store.get(&job.name);
    let is_known = known.as_ref().is_some_and(serves) || wanted.only_report && known.is_some();
    match (left_out(job, wanted), brought) {
        (Some(_), Some(kept)) => Fate::Brought(kept),
        _ if is_known => Fate::Known,
        // What was brought earlier is there still.
        (Some(_), None) if is_brought(job) && known.is_some() => Fate::Known,
        (Some(why), None) => Fate::Missing(why),
        (None, _) => Fate::Run,
    }
}

/// Why a run is not made here.
fn left_out(job: &Job, wanted: &Wanted) -> Option<String> {
    if let What::Elsewhere(command) = job.what {
        return Some(format!("`{command}` writes a file for --merge"));
    }
    if job.gpu && !wanted.gpu {
        return Some("a hardware GPU and --merge".to_owned());
    }
    if wanted.only_report {
        return Some("was not run".to_owned());
    }
    if let Some(mesh) = job.mesh().filter(|mesh| !Path::new(mesh).is_file()) {
        return Some(format!("there is no {mesh}; `cargo xtask models` fetches it"));
    }
    (job.quick == Quick::Out && wanted.quick).then(|| "--quick leaves it out".to_owned())
}

/// Whether another machine or program may have left it.
fn is_brought(job: &Job) -> bool {
    job.gpu || matches!(job.what, What::Elsewhere(_))
}

fn is_all(wanted: &Wanted) -> bool {
    Paper::ALL.iter().all(|paper| wanted.papers.contains(paper))
}

fn jobs(wanted: &Wanted) -> Vec<Job> {
    let of = |paper: &Paper| match paper {
        Paper::S1 => s1::jobs(),
        Paper::S2 => s2::jobs(),
        Paper::S3 => s3::jobs(),
    };
    let mut jobs: Vec<Job> = wanted.papers.iter().flat_map(of).collect();
    if is_all(wanted) {
        jobs.extend(aims::jobs());
        let quick = tournament::names(true);
        jobs.extend(tournament::names(false).into_iter().map(|name| {
            let kind = if quick.contains(&name) { Quick::Whole } else { Quick::Out };
            Job::bout(name, kind)
        }));
    }
    jobs
}

fn sections(wanted: &Wanted, look: &Look) -> Vec<Section> {
    let of = |paper: &Paper| match paper {
        Paper::S1 => s1::sections(look),
        Paper::S2 => s2::sections(look),
        Paper::S3 => s3::sections(look),
    };
    let mut sections: Vec<Section> = wanted.papers.iter().flat_map(of).collect();
    if is_all(wanted) {
        sections.push(aims::section(look));
        sections.extend(tournament::sections(|name| look.at(name).ok()));
        sections.push(limits::section());
        sections.push(errata::section());
    }
    sections
}

fn head(wanted: &Wanted, shown: &[&Kept]) -> Head {
    let limits = shown.iter().find(|kept| kept.name == s1::sheets::LIMITS).and_then(|kept| {
        let limits = &kept.result["limits"];
        let [gflops, bytes] = [&limits["fma_gflop_per_s"], &limits["memory_gb_per_s"]].map(Value::as_f64);
        Some(format!(", of which one thread reaches {:.0} GFLOP/s and {:.0} GB/s", gflops?, bytes?))
    });
    let machines: BTreeSet<&str> = shown.iter().map(|kept| kept.machine.as_str()).collect();
    let limits = limits.unwrap_or_default();
    let cut = if shown.iter().any(|kept| kept.quick) {
        "\n\n**This is a quick look**: runs are cut short or left out, and their numbers are not for quoting."
    } else {
        ""
    };
    let papers: String =
        wanted.papers.iter().map(|paper| format!("- {}: {}.\n", paper.name(), paper.citation())).collect();
    let words = format!(
        "What papers on real-time cloth and soft bodies print, beside what taffeta {} does.\n\n{papers}\n\
         The runs are of: {}{limits}.{cut}",
        env!("CARGO_PKG_VERSION"),
        machines.into_iter().collect::<Vec<_>>().join(", "),
    );
    Head { title: "Papers on cloth and soft bodies, reproduced".to_owned(), words }
}

/// What another machine kept.
fn brought(file: &Path) -> Result<BTreeMap<String, Kept>, Failure> {
    let at = |error: &dyn std::fmt::Display| {
        Failure::Input(format!("--merge {}: {error}; a raw.jsonl of this program would do", file.display()))
    };
    let text = fs::read(file).map_err(|error| at(&error))?;
    let kept = store::lines(&text).map_err(|error| at(&error))?;
    if kept.is_empty() { Err(at(&"has no runs")) } else { Ok(kept) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    fn wanted(out: &Path) -> Wanted {
        let (papers, out) = (Paper::ALL.to_vec(), out.to_owned());
        Wanted { papers, out, quick: true, merge: None, only_report: false, taffeta: None, gpu: false }
    }

    #[test]
    fn names_of_runs_are_their_own_and_fit_into_an_address() {
        let mut names = HashSet::new();
        for job in jobs(&wanted(Path::new("out"))) {
            let fits = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '-';
            assert!(job.name.chars().all(fits), "{}", job.name);
            assert!(names.insert(job.name.clone()), "{} twice", job.name);
        }
    }

    #[test]
    fn without_any_run_every_table_is_there_and_open() {
        let folder = tempfile::tempdir().unwrap();
        let store = Store::open(folder.path()).unwrap();
        let sections = sections(&wanted(folder.path()), &Look::new(&store, &BTreeMap::new()));
        write::write(folder.path(), &head(&wanted(folder.path()), &[]), &sections, &store).unwrap();
        let page = fs::read_to_string(folder.path().join("report.html")).unwrap();
        for table in [
            "s1-springs",
            "s1-sheets",
            "s1-methods",
            "s1-fig15",
            "s2-ladder",
            "s3-loss",
            "s3-press",
            "limits",
        ] {
            assert!(page.contains(&format!("<table id=\"{table}\">")), "{table}");
        }
        assert!(page.contains("title=\"was not run\">open<") && !page.contains("href=\"#run-"));
    }

    #[test]
    fn what_needs_a_gpu_says_so_where_there_is_none() {
        let folder = Path::new("out");
        let jobs = jobs(&wanted(folder));
        let gpu = jobs.iter().find(|job| job.gpu).unwrap();
        assert!(left_out(gpu, &wanted(folder)).is_some_and(|why| why.contains("--merge")));
        let there = Wanted { gpu: true, ..wanted(folder) };
        assert!(left_out(gpu, &there).is_none());
        let meshed = jobs.iter().find(|job| job.mesh().is_some()).unwrap();
        assert!(left_out(meshed, &there).is_some_and(|why| why.contains("there is no models/bunny.ply")));
    }
}
