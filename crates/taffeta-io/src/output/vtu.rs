//! VTK: a `.vtu` file for each body and frame, and a `.pvd` file that gives them their times.
//!
//! The `.pvd` grows by the files of a frame when they are whole, and its length is where the frames end.

use super::part::{Part, check_file};
use super::vtu_mesh::Grid;
use super::{Begin, FrameSink, Positions, file_stems};
use crate::files::{self, in_file, sync_folder};
use std::fs::{File, read_dir, remove_dir, remove_file};
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use taffeta::Precision;
use taffeta::topology::Surface;

/// The folder of the `.vtu` files, beside the `.pvd`.
const FOLDER: &str = "vtu";
const START: &str = "<?xml version=\"1.0\"?>\n<VTKFile type=\"Collection\" version=\"1.0\" \
                     byte_order=\"LittleEndian\">\n<Collection>\n";
const END: &str = "</Collection>\n</VTKFile>\n";

/// Writes the `.pvd` and the `.vtu` files.
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// # let bodies: Vec<_> = simulation.bodies().iter().map(|b| (b.name.clone(), simulation.surface(b.handle).unwrap())).collect();
/// use taffeta_io::output::{Begin, FrameSink, Vtu, Positions};
///
/// let mut file = Box::new(Vtu::open(&folder.path().join("frames.pvd"), &bodies, Precision::F32, Begin::New)?);
/// let mut positions: Vec<[f32; 3]> = Vec::new();
/// for _ in 0..3 {
///     simulation.step()?;
///     simulation.positions_f32(&mut positions);
///     file.frame(simulation.report().time, &Positions::F32(&positions))?;
/// }
/// file.finish()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Vtu {
    pvd: Part,
    /// Length of the `.pvd` without its end [byte].
    length: u64,
    folder: PathBuf,
    frames: u64,
    vertices: usize,
    bodies: Vec<Body>,
    /// Files that may not be on the disk yet.
    unsynced: Vec<PathBuf>,
}

struct Body {
    stem: String,
    vertices: Range<usize>,
    grid: Grid,
}

impl Vtu {
    /// Starts the `.pvd` file at `path`, or takes it up; `bodies` are names and surfaces in the order of the
    /// positions. The `.vtu` files are in the folder `vtu` beside it, as `BODY_000012.vtu`. What an earlier run left
    /// there for bodies of these names goes with the first frame, not before.
    pub fn open(
        path: &Path,
        bodies: &[(String, Surface)],
        precision: Precision,
        begin: Begin,
    ) -> io::Result<Self> {
        let mut pvd = Part::open(path, begin)?;
        if begin == Begin::New {
            pvd.write_all(START.as_bytes())?;
            pvd.flush()?;
        }
        let folder = path.with_file_name(FOLDER);
        files::check_folder(&folder)?;
        let names: Vec<String> = bodies.iter().map(|(name, _)| name.clone()).collect();
        let length = pvd.len();
        let mut vtu =
            Self { pvd, length, folder, frames: 0, vertices: 0, bodies: Vec::new(), unsynced: Vec::new() };
        for (stem, (_, surface)) in file_stems(&names).into_iter().zip(bodies) {
            let vertices = vtu.vertices..vtu.vertices + surface.vertices.len();
            vtu.vertices = vertices.end;
            let grid = Grid::of(surface, precision)
                .ok_or_else(|| vtu.pvd.refuse(format!("{stem} is too large for 32-bit indices")))?;
            vtu.bodies.push(Body { stem, vertices, grid });
        }
        Ok(vtu)
    }

    /// Whether all is there that an earlier run of bodies called `stems` left where its mark was `mark`.
    pub fn check(path: &Path, stems: &[String], frames: u64, mark: &[u64]) -> io::Result<()> {
        mark.iter().try_for_each(|&length| check_file(path, length))?;
        let folder = path.with_file_name(FOLDER);
        let mut files = (0..frames).flat_map(|frame| stems.iter().map(move |stem| name_of(stem, frame)));
        files.try_for_each(|name| check_file(&folder.join(name), 1))
    }

    /// Removes the `.pvd` file at `path` and the `.vtu` files that it names.
    pub fn remove(path: &Path) -> io::Result<()> {
        let folder = path.with_file_name(FOLDER);
        let bytes = files::read(path, u64::MAX).map_err(|error| in_file(path, error))?;
        let text = String::from_utf8_lossy(&bytes);
        let names = text.lines().filter_map(|line| line.split_once(" file=\"vtu/")?.1.strip_suffix("\"/>"));
        // Only files within the folder, whatever the text says.
        for name in names.filter(|name| Path::new(name).file_name() == Some(name.as_ref())) {
            remove(&folder.join(name))?;
        }
        // Without the list nobody would know them after a power failure.
        sync_folder(&folder.join(FOLDER));
        // A folder with other files in it stays.
        let _ = remove_dir(&folder);
        remove(path)
    }

    /// Gives the `.pvd` the `lines` of a frame, if any, after the first `length` bytes, and an end.
    fn list(&mut self, length: u64, lines: &str) -> io::Result<()> {
        self.pvd.cut(length)?;
        self.pvd.write_all(lines.as_bytes())?;
        self.length = self.pvd.len();
        self.pvd.write_all(END.as_bytes())?;
        self.pvd.flush()
    }

    /// The bodies' files in the folder with their frames, whole or not.
    fn files(&self) -> io::Result<Vec<(PathBuf, u64)>> {
        let mut files = Vec::new();
        if !self.folder.exists() {
            return Ok(files);
        }
        for entry in read_dir(&self.folder).map_err(|error| in_file(&self.folder, error))? {
            let path = entry.map_err(|error| in_file(&self.folder, error))?.path();
            let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
            if let Some(frame) = self.frame_of(name.strip_suffix(".part").unwrap_or(name)) {
                files.push((path, frame));
            }
        }
        Ok(files)
    }

    /// The frame that a file of this name holds, if it is one of ours.
    fn frame_of(&self, name: &str) -> Option<u64> {
        let (stem, number) = name.strip_suffix(".vtu")?.rsplit_once('_')?;
        let frame = number.parse().ok()?;
        self.bodies.iter().any(|body| body.stem == stem && body.file(frame) == name).then_some(frame)
    }
}

impl FrameSink for Vtu {
    fn frame(&mut self, time: f64, positions: &Positions) -> io::Result<()> {
        if positions.len() != self.vertices {
            let what = format!("{} vertices instead of {}", positions.len(), self.vertices);
            return Err(self.pvd.refuse(what));
        }
        if self.frames == 0 {
            files::create_folders(&self.folder).map_err(|error| in_file(&self.folder, error))?;
            self.files()?.iter().try_for_each(|(path, _)| remove(path))?;
        }
        let mut lines = String::new();
        for (index, body) in self.bodies.iter().enumerate() {
            let (stem, file) = (&body.stem, body.file(self.frames));
            let mut part = Part::open(&self.folder.join(&file), Begin::New)?;
            let own = positions.slice(body.vertices.clone()).unwrap_or(*positions);
            body.grid.write(&mut part, time, &own)?;
            self.unsynced.push(part.finish_later()?);
            lines += &format!(
                "<DataSet timestep=\"{time}\" part=\"{index}\" name=\"{stem}\" file=\"{FOLDER}/{file}\"/>\n"
            );
        }
        self.list(self.length, &lines)?;
        self.frames += 1;
        Ok(())
    }

    fn mark(&self) -> Vec<u64> {
        vec![self.length]
    }

    fn rewind(&mut self, frames: u64, mark: &[u64]) -> io::Result<()> {
        let (earlier, later): (Vec<_>, Vec<_>) = self
            .files()?
            .into_iter()
            .partition(|(path, frame)| *frame < frames && path.extension() == Some("vtu".as_ref()));
        let (there, needed) = (earlier.len() as u64, frames * self.bodies.len() as u64);
        if there != needed {
            let what = format!(
                "{FOLDER} holds {there} files of frames before {frames} and {needed} are needed: it is not what \
                 the earlier run left"
            );
            return Err(self.pvd.refuse(what));
        }
        later.iter().try_for_each(|(path, _)| remove(path))?;
        self.unsynced.retain(|path| later.iter().all(|(gone, _)| gone != path));
        self.frames = frames;
        mark.iter().try_for_each(|&length| self.list(length, ""))
    }

    fn sync(&mut self) -> io::Result<()> {
        for path in &self.unsynced {
            File::open(path).and_then(|file| file.sync_all()).map_err(|error| in_file(path, error))?;
        }
        self.unsynced.drain(..).take(1).for_each(|path| sync_folder(&path));
        self.pvd.sync()
    }

    /// Returns the `.pvd` alone, which names the others.
    fn finish(mut self: Box<Self>) -> io::Result<Vec<PathBuf>> {
        self.sync()?;
        Ok(vec![self.pvd.finish()?])
    }
}

impl Body {
    fn file(&self, frame: u64) -> String {
        name_of(&self.stem, frame)
    }
}

fn name_of(stem: &str, frame: u64) -> String {
    format!("{stem}_{frame:06}.vtu")
}

/// Removes a file, if it is there.
fn remove(path: &Path) -> io::Result<()> {
    match remove_file(path) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => Err(in_file(path, error)),
        _ => Ok(()),
    }
}
