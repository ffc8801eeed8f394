//! The files of a run.

use crate::console;
use crate::failure::Failure;
use crate::summary::Summary;
use clap::ValueEnum;
use std::io;
use std::path::{Path, PathBuf};
use taffeta::topology::Surface;
use taffeta::{Precision, Simulation};
use taffeta_io::output::{
    Begin, FrameSink, FrameTable, Npy, Pc2, Positions, Usd, file_stems, write_obj, write_ply,
};

/// A format of results.
#[derive(Clone, Copy, PartialEq, Eq, PartialOrd, Ord, ValueEnum)]
pub enum Format {
    /// All frames as a NumPy array: positions.npy
    Npy,
    /// All frames as a point cache for Blender, Maya, 3ds Max: BODY.pc2
    Pc2,
    /// All frames as USD: scene.usda
    Usda,
    /// The last frame: BODY.ply
    Ply,
    /// The last frame: BODY.obj
    Obj,
    /// For ParaView (not yet supported)
    Vtu,
}

/// The files of a run, under way.
pub struct Outputs {
    dir: PathBuf,
    formats: Vec<Format>,
    sinks: Vec<Box<dyn FrameSink>>,
    table: FrameTable,
    positions: Buffer,
}

impl Outputs {
    /// Starts all files in `dir`; `dt` is the length of a frame [s].
    pub fn create(dir: &Path, formats: &[Format], simulation: &Simulation, dt: f64) -> Result<Self, Failure> {
        let refuse = |error| {
            Failure::Input(format!(
                "--out {}: {error}; a folder that can be written to would do",
                dir.display()
            ))
        };
        std::fs::create_dir_all(dir).map_err(refuse)?;
        let mut formats = formats.to_vec();
        formats.sort_unstable();
        formats.dedup();
        let bodies = simulation.bodies();
        let columns: Vec<_> =
            bodies.iter().map(|body| (body.name.clone(), body.rest_volume.is_some())).collect();
        let mut sinks = Vec::new();
        for format in &formats {
            sinks.extend(format.sinks(dir, simulation, dt).map_err(refuse)?);
        }
        let table = FrameTable::open(&dir.join("frames.csv"), &columns, Begin::New).map_err(refuse)?;
        remove_earlier(dir).map_err(refuse)?;
        let positions = Buffer::of(simulation.precision());
        Ok(Self { dir: dir.to_owned(), formats, sinks, table, positions })
    }

    /// Adds the simulation's frame, which took `ms` [ms].
    pub fn frame(&mut self, simulation: &Simulation, ms: f64) -> io::Result<()> {
        self.positions.fill(simulation);
        let time = simulation.report().time;
        for sink in &mut self.sinks {
            sink.frame(time, &self.positions.view())?;
        }
        self.table.row(simulation.report(), ms)
    }

    /// Completes all files with the frames that were added and returns their names. After a divergence the state is not that of the last
    /// frame, and poses go without normals.
    pub fn finish(self, simulation: &Simulation, diverged: bool) -> io::Result<Vec<String>> {
        let mut files = Vec::new();
        for sink in self.sinks {
            files.extend(sink.finish()?);
        }
        files.push(self.table.finish()?);
        let stems = file_stems(&names(simulation));
        let mut first = 0;
        for (index, stem) in stems.iter().enumerate() {
            let surface = simulation.surface(index);
            let positions = self.positions.view().slice(first..first + surface.vertices.len());
            first += surface.vertices.len();
            let normals = if diverged { Vec::new() } else { simulation.normals(index) };
            if let Some(positions) = positions {
                let path = self.dir.join(stem);
                for format in &self.formats {
                    files.extend(format.pose(&path, &surface, &positions, &normals)?);
                }
            }
        }
        let name = |path: &PathBuf| path.file_name().map(|name| name.to_string_lossy().into_owned());
        Ok(files.iter().filter_map(name).collect())
    }
}

impl Format {
    /// The files that take all frames.
    fn sinks(self, dir: &Path, simulation: &Simulation, dt: f64) -> io::Result<Vec<Box<dyn FrameSink>>> {
        let bodies = simulation.bodies();
        Ok(match self {
            Self::Npy => {
                let vertices = bodies.iter().map(|body| body.vertices).sum();
                let path = dir.join("positions.npy");
                vec![Box::new(Npy::open(&path, vertices, simulation.precision(), Begin::New)?)]
            }
            Self::Pc2 => {
                let mut sinks: Vec<Box<dyn FrameSink>> = Vec::new();
                let mut first = 0;
                for (stem, body) in file_stems(&names(simulation)).iter().zip(bodies) {
                    let range = first..first + body.vertices;
                    first = range.end;
                    sinks.push(Box::new(Pc2::open(&dir.join(format!("{stem}.pc2")), range, Begin::New)?));
                }
                sinks
            }
            Self::Usda => {
                let surfaces = bodies.iter().enumerate();
                let surfaces: Vec<_> =
                    surfaces.map(|(index, body)| (body.name.clone(), simulation.surface(index))).collect();
                vec![Box::new(Usd::open(&dir.join("scene.usda"), dt, &surfaces, Begin::New)?)]
            }
            Self::Ply | Self::Obj | Self::Vtu => Vec::new(),
        })
    }

    /// The file with the last frame of one body; `path` has no ending.
    fn pose(
        self,
        path: &Path,
        surface: &Surface,
        positions: &Positions,
        normals: &[[f32; 3]],
    ) -> io::Result<Option<PathBuf>> {
        let with = |ending: &str| {
            let mut name = path.as_os_str().to_owned();
            name.push(ending);
            PathBuf::from(name)
        };
        match self {
            Self::Ply => write_ply(&with(".ply"), surface, positions, normals).map(Some),
            Self::Obj => write_obj(&with(".obj"), surface, positions, normals).map(Some),
            Self::Npy | Self::Pc2 | Self::Usda | Self::Vtu => Ok(None),
        }
    }
}

fn names(simulation: &Simulation) -> Vec<String> {
    simulation.bodies().iter().map(|body| body.name.clone()).collect()
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

/// Removes what an earlier run wrote here, by its summary: results of two runs must not lie side by side.
fn remove_earlier(dir: &Path) -> io::Result<()> {
    let path = dir.join("summary.json");
    let Ok(text) = std::fs::read_to_string(&path) else { return Ok(()) };
    let earlier: serde_json::Value = serde_json::from_str(&text).unwrap_or_default();
    let files = earlier["files"].as_array().into_iter().flatten().filter_map(|file| file.as_str());
    for file in files.filter(|file| Path::new(file).file_name() == Some(file.as_ref())) {
        match std::fs::remove_file(dir.join(file)) {
            Err(error) if error.kind() != io::ErrorKind::NotFound => return Err(error),
            _ => {}
        }
    }
    std::fs::remove_file(path)
}

/// Writes `summary.json`, which has its name only when it is whole.
pub fn write_summary(dir: &Path, summary: &Summary) -> Result<(), Failure> {
    let (path, part) = (dir.join("summary.json"), dir.join("summary.json.part"));
    let text = console::json(summary)? + "\n";
    std::fs::write(&part, text)
        .and_then(|()| std::fs::rename(&part, &path))
        .map_err(|error| Failure::Work(format!("{}: {error}", path.display())))
}
