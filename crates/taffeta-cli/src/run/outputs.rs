//! The files of a run.

use super::format::{Format, Poses, stems, write_poses};
use super::plan::Plan;
use crate::summary::Summary;
use serde::{Deserialize, Serialize};
use std::io;
use std::path::{Path, PathBuf};
use taffeta::{Precision, Simulation};
use taffeta_io::files;
use taffeta_io::output::{Begin, FrameSink, FrameTable, Positions, Vtu, check_file};
use taffeta_io::program::{Failure, complain};

/// Where the files of a run end.
#[derive(Clone, Debug, Default, Serialize, Deserialize)]
pub struct Mark {
    /// Frames in the caches, the start included.
    frames: u64,
    /// Lengths of each cache's files.
    caches: Vec<Vec<u64>>,
    /// Length of the table.
    table: u64,
}

/// The files of a run, under way.
pub struct Outputs {
    dir: PathBuf,
    formats: Vec<Format>,
    caches: Vec<Box<dyn FrameSink>>,
    table: FrameTable,
    positions: Buffer,
    /// Where the files end that have the same, whole frames.
    mark: Mark,
}

impl Outputs {
    /// Starts all files of a run, or takes them up; `dt` is the length of a frame [s].
    pub fn open(plan: &Plan, simulation: &Simulation, dt: f64) -> Result<Self, Failure> {
        let (dir, begin) = (&plan.dir, plan.begin());
        refuse_inputs(plan, simulation)?;
        let refuse = |error| unwritable(dir, error);
        let bodies = simulation.bodies();
        let columns: Vec<_> =
            bodies.iter().map(|body| (body.name.clone(), body.rest_volume.is_some(), body.pins)).collect();
        let mut caches = Vec::new();
        for format in &plan.formats {
            caches.extend(format.caches(plan, simulation, dt).map_err(refuse)?);
        }
        let table = FrameTable::open(&dir.join("frames.csv"), &columns, begin).map_err(refuse)?;
        remove_earlier(plan).map_err(refuse)?;
        let positions = Buffer::of(simulation.precision());
        let mut outputs = Self {
            dir: dir.clone(),
            formats: plan.formats.clone(),
            caches,
            table,
            positions,
            mark: Mark::default(),
        };
        outputs.mark = outputs.here(0);
        Ok(outputs)
    }

    /// Adds the simulation's frame, with the number of its intersections where they are counted, which took `ms` [ms].
    pub fn frame(&mut self, simulation: &Simulation, intersections: Option<u64>, ms: f64) -> io::Result<()> {
        self.positions.fill(simulation);
        let time = simulation.report().time;
        for cache in &mut self.caches {
            cache.frame(time, &self.positions.view())?;
        }
        self.table.row(simulation.report(), intersections, ms)?;
        self.mark = self.here(self.mark.frames + 1);
        Ok(())
    }

    /// Where the files end now, with `frames` frames.
    fn here(&self, frames: u64) -> Mark {
        Mark {
            frames,
            caches: self.caches.iter().map(|cache| cache.mark()).collect(),
            table: self.table.mark(),
        }
    }

    /// Goes back to where a checkpoint says the files ended; the simulation is there already.
    pub fn rewind(&mut self, mark: &Mark, simulation: &Simulation) -> io::Result<()> {
        self.positions.fill(simulation);
        self.mark = mark.clone();
        for (cache, lengths) in self.caches.iter_mut().zip(&mark.caches) {
            cache.rewind(mark.frames, lengths)?;
        }
        self.table.rewind(mark.table)
    }

    /// Drops a frame that not all files could take. A file that cannot even be cut stays a `.part`.
    pub fn go_back(&mut self) {
        let mark = &self.mark;
        for (cache, lengths) in self.caches.iter_mut().zip(&mark.caches) {
            if let Err(error) = cache.rewind(mark.frames, lengths) {
                complain(&format!("error: {error}"));
            }
        }
        if let Err(error) = self.table.rewind(mark.table) {
            complain(&format!("error: {error}"));
        }
    }

    /// Puts all frames so far on the disk, and says where the files end.
    pub fn sync(&mut self) -> io::Result<Mark> {
        self.caches.iter_mut().try_for_each(|cache| cache.sync())?;
        self.table.sync()?;
        Ok(self.mark.clone())
    }

    /// Frames in the caches, the start included.
    pub fn frames(&self) -> u64 {
        self.mark.frames
    }

    /// Completes all files with the frames that were added. Returns the names of those that it could, and the first
    /// thing that went wrong.
    pub fn finish(self, simulation: &Simulation, poses: Poses) -> (Vec<String>, Option<io::Error>) {
        let (mut files, mut failed) = (Vec::new(), None);
        let mut take = |result: io::Result<Vec<PathBuf>>| match result {
            Ok(done) => files.extend(done),
            Err(error) => failed = failed.take().or(Some(error)),
        };
        for cache in self.caches {
            take(cache.finish());
        }
        take(self.table.finish().map(|path| vec![path]));
        if poses != Poses::None {
            take(write_poses(&self.dir, &self.formats, simulation, &self.positions.view(), poses));
        }
        let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
        (files.iter().filter_map(name).collect(), failed)
    }
}

/// Positions of the last good frame, in the run's precision.
enum Buffer {
    F32(Vec<[f32; 3]>),
    F64(Vec<[f64; 3]>),
}

impl Buffer {
    fn of(precision: Precision) -> Self {
        match precision {
            Precision::F32 => Self::F32(Vec::new()),
            Precision::F64 => Self::F64(Vec::new()),
        }
    }

    fn fill(&mut self, simulation: &Simulation) {
        match self {
            Self::F32(all) => simulation.positions_f32(all),
            Self::F64(all) => simulation.positions_f64(all),
        }
    }

    fn view(&self) -> Positions<'_> {
        match self {
            Self::F32(all) => Positions::F32(all),
            Self::F64(all) => Positions::F64(all),
        }
    }
}

/// A folder that results cannot be written to.
pub fn unwritable(dir: &Path, error: io::Error) -> Failure {
    use io::ErrorKind as Kind;
    let out = format!("--out {}: {error}", dir.display());
    match error.kind() {
        Kind::PermissionDenied
        | Kind::ReadOnlyFilesystem
        | Kind::NotFound
        | Kind::NotADirectory
        | Kind::AlreadyExists
        | Kind::InvalidFilename => Failure::Input(format!("{out}; a folder that can be written to would do")),
        Kind::IsADirectory | Kind::ResourceBusy | Kind::InvalidInput => Failure::Input(out),
        // A full or a broken disk.
        _ => Failure::Work(out),
    }
}

/// Refuses to go on with files that are not all there, before any of them is touched.
pub fn check_left(plan: &Plan, simulation: &Simulation, mark: &Mark) -> Result<(), Failure> {
    let stems = stems(simulation);
    let mut lengths = mark.caches.iter();
    let mut check = || {
        for format in plan.formats.iter().filter(|format| format.is_cache()) {
            format.check(&plan.dir, &stems, mark.frames, &mut lengths)?;
        }
        check_file(&plan.dir.join("frames.csv"), mark.table)
    };
    check().map_err(|error| {
        Failure::Input(format!("--resume: {error}; the files that the run left are needed to go on"))
    })
}

/// Refuses to write over what the scene was read from.
fn refuse_inputs(plan: &Plan, simulation: &Simulation) -> Result<(), Failure> {
    let stems = stems(simulation);
    let own = ["frames.csv", "summary.json"].map(str::to_owned);
    for name in plan.formats.iter().flat_map(|format| format.files(&stems)).chain(own) {
        let there = plan.dir.join(&name).canonicalize();
        if there.is_ok_and(|path| plan.inputs.contains(&path)) {
            return Err(Failure::Input(format!(
                "--out {}: `{name}` would be written over, and the scene is read from it; another folder would do",
                plan.dir.display()
            )));
        }
    }
    Ok(())
}

/// Removes what an earlier run wrote here, by its summary, and what is not to be taken up again: results of two runs,
/// or of two frames, must not lie side by side.
fn remove_earlier(plan: &Plan) -> io::Result<()> {
    let remove = |path: &Path| match std::fs::remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(error),
        removed => Ok(removed.is_ok()),
    };
    // After a power failure nothing must go on from it with the files of this run.
    if plan.begin() == Begin::New && remove(&plan.checkpoint())? {
        files::sync_folder(&plan.checkpoint());
    }
    let path = plan.dir.join("summary.json");
    let Ok(text) = files::read(&path, LONGEST_SUMMARY) else { return Ok(()) };
    let earlier: serde_json::Value = serde_json::from_slice(&text).unwrap_or_default();
    let files = earlier["files"].as_array().into_iter().flatten().filter_map(|file| file.as_str());
    for file in files.filter(|file| Path::new(file).file_name() == Some(file.as_ref())) {
        let path = plan.dir.join(file);
        if path.canonicalize().is_ok_and(|path| plan.inputs.contains(&path)) {
            continue;
        }
        if path.extension() == Some("pvd".as_ref()) && path.exists() {
            Vtu::remove(&path)?;
        }
        remove(&path)?;
    }
    // It names them until they are gone for good.
    files::sync_folder(&path);
    remove(&path).map(drop)
}

/// More than any summary has [byte].
const LONGEST_SUMMARY: u64 = 1 << 28;

/// Writes `summary.json`, which has its name only when it is whole.
pub fn write_summary(dir: &Path, summary: &Summary) -> io::Result<()> {
    let text = serde_json::to_string_pretty(summary)? + "\n";
    files::replace(&dir.join("summary.json"), &[text.as_bytes()])
}
