//! USD in its text form: a mesh or curve for each body, with points and extents for each frame.
//!
//! A frame adds to all bodies, but the file has one body after the other. The first body's points stream into the file
//! itself; all that comes after them streams into parts of its own, which `finish` appends.

use super::part::{Part, check_file};
use super::usd_mesh::write_topology;
use super::{Begin, FrameSink, Positions, usd_identifiers};
use crate::files::in_file;
use std::fs::{File, remove_file};
use std::io::{self, BufRead, BufReader, Read, Seek, SeekFrom, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use taffeta::topology::Surface;

/// Between a body's points and its extents.
const EXTENTS: &[u8] = b"        }\n        float3[] extent.timeSamples = {\n";
/// Its lines: after the frames of either, before the extents.
const END: &[u8] = EXTENTS.split_at(10).0;
const EXTENTS_LINE: &[u8] = EXTENTS.split_at(10).1;

/// Writes one `.usda` file for all bodies.
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// # let bodies: Vec<_> = simulation.bodies().iter().map(|b| (b.name.clone(), simulation.surface(b.handle).unwrap())).collect();
/// use taffeta_io::output::{Begin, FrameSink, Usd, Positions};
///
/// let mut file = Box::new(Usd::open(&folder.path().join("scene.usda"), 0.01, &bodies, Begin::New)?);
/// let mut positions: Vec<[f32; 3]> = Vec::new();
/// for _ in 0..3 {
///     simulation.step()?;
///     simulation.positions_f32(&mut positions);
///     file.frame(simulation.report().time, &Positions::F32(&positions))?;
/// }
/// file.finish()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Usd {
    /// Length of a frame [s].
    dt: f64,
    frames: u64,
    vertices: usize,
    bodies: Vec<BodyPart>,
}

struct BodyPart {
    vertices: Range<usize>,
    points: Part,
    extents: Part,
}

impl Usd {
    /// Starts the file at `path`, or takes it up; `bodies` are names and surfaces in the order of the positions, `dt`
    /// is the length of a frame [s].
    pub fn open(path: &Path, dt: f64, bodies: &[(String, Surface)], begin: Begin) -> io::Result<Self> {
        match begin {
            Begin::Again if path.exists() => split(path).map_err(|error| in_file(path, error))?,
            // A whole file beside parts is that of the run that wrote them.
            Begin::New if path.exists() => remove_file(path).map_err(|error| in_file(path, error))?,
            _ => {}
        }
        let names: Vec<String> = bodies.iter().map(|(name, _)| name.clone()).collect();
        let mut usd = Self { dt, frames: 0, vertices: 0, bodies: Vec::new() };
        for (index, (name, (_, surface))) in usd_identifiers(&names).iter().zip(bodies).enumerate() {
            let [points, extents] = part_paths(path, index);
            let mut points = Part::open(&points, begin)?;
            if begin == Begin::New {
                if index == 0 {
                    points.write_all(usd.header().as_bytes())?;
                }
                write_topology(&mut points, name, surface)?;
                points.write_all(b"        point3f[] points.timeSamples = {\n")?;
                points.flush()?;
            }
            let vertices = usd.vertices..usd.vertices + surface.vertices.len();
            usd.vertices = vertices.end;
            usd.bodies.push(BodyPart { vertices, points, extents: Part::open(&extents, begin)? });
        }
        Ok(usd)
    }

    /// Whether all is there that an earlier run left where its mark was `mark`.
    pub fn check(path: &Path, mark: &[u64]) -> io::Result<()> {
        if path.exists() {
            return check_file(path, mark.iter().sum());
        }
        let paths = (0..).flat_map(|body| part_paths(path, body));
        paths.zip(mark).try_for_each(|(path, &length)| check_file(&path, length))
    }

    /// The header, of the same length for any number of frames.
    fn header(&self) -> String {
        let (rate, end) = (1.0 / self.dt, self.frames.saturating_sub(1));
        format!(
            "#usda 1.0\n(\n    defaultPrim = \"Scene\"\n    endTimeCode = {end:<20}\n    framesPerSecond = {rate}\n    \
             metersPerUnit = 1\n    startTimeCode = 0\n    timeCodesPerSecond = {rate}\n    upAxis = \"Y\"\n)\n\n\
             def Xform \"Scene\" (\n    kind = \"component\"\n)\n{{\n"
        )
    }

    fn parts(&mut self) -> impl Iterator<Item = &mut Part> {
        self.bodies.iter_mut().flat_map(|body| [&mut body.points, &mut body.extents])
    }

    /// Appends all parts to the first, which is the file.
    fn append(&mut self) -> io::Result<()> {
        let header = self.header();
        let mut parts = self.parts();
        let Some(whole) = parts.next() else { return Ok(()) };
        whole.patch(0, header.as_bytes())?;
        // Extents and points by turns, as the file has them.
        for (i, part) in parts.enumerate() {
            if i % 2 == 0 {
                whole.write_all(EXTENTS)?;
                whole.copy(part)?;
                whole.write_all(b"        }\n    }\n\n")?;
            } else {
                whole.copy(part)?;
            }
        }
        whole.write_all(b"}\n")
    }
}

impl FrameSink for Usd {
    fn frame(&mut self, _time: f64, positions: &Positions) -> io::Result<()> {
        let (expected, frame) = (self.vertices, self.frames);
        for body in &mut self.bodies {
            let own = positions.slice(body.vertices.clone()).filter(|_| positions.len() == expected);
            let own = own.ok_or_else(|| {
                body.points.refuse(format!("{} vertices instead of {expected}", positions.len()))
            })?;
            body.frame(frame, &own)?;
        }
        self.frames += 1;
        Ok(())
    }

    fn mark(&self) -> Vec<u64> {
        self.bodies.iter().flat_map(|body| [body.points.len(), body.extents.len()]).collect()
    }

    fn rewind(&mut self, frames: u64, mark: &[u64]) -> io::Result<()> {
        self.frames = frames;
        self.parts().zip(mark).try_for_each(|(part, &length)| part.cut(length))
    }

    fn sync(&mut self) -> io::Result<()> {
        self.parts().try_for_each(Part::sync)
    }

    /// The parts are there until the whole is: a run that ends in here can be taken up.
    fn finish(mut self: Box<Self>) -> io::Result<Vec<PathBuf>> {
        let mark = self.mark();
        if let Err(error) = self.append() {
            // The space may be wanted elsewhere; the error counts, not whether this works.
            let _ = self.rewind(self.frames, &mark);
            return Err(error);
        }
        let mut parts = self.bodies.into_iter().flat_map(|body| [body.points, body.extents]);
        let whole = parts.next().map_or(Ok(Vec::new()), |whole| Ok(vec![whole.finish()?]));
        if whole.is_ok() {
            parts.try_for_each(Part::remove)?;
        }
        whole
    }
}

impl BodyPart {
    fn frame(&mut self, frame: u64, positions: &Positions) -> io::Result<()> {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        write!(self.points, "            {frame}: [")?;
        for (i, [x, y, z]) in positions.iter_f32().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(self.points, "{comma}({x}, {y}, {z})")?;
            for (axis, value) in [x, y, z].into_iter().enumerate() {
                low[axis] = low[axis].min(value);
                high[axis] = high[axis].max(value);
            }
        }
        self.points.write_all(b"],\n")?;
        let ([a, b, c], [x, y, z]) = (low, high);
        writeln!(self.extents, "            {frame}: [({a}, {b}, {c}), ({x}, {y}, {z})],")?;
        self.points.flush()?;
        self.extents.flush()
    }
}

/// Where the points and the extents of a body are under way.
fn part_paths(path: &Path, body: usize) -> [PathBuf; 2] {
    let beside = |what: &str| {
        let mut own = path.as_os_str().to_owned();
        own.push(format!(".{body}.{what}"));
        PathBuf::from(own)
    };
    let points = if body == 0 { path.to_owned() } else { beside("points") };
    [points, beside("extents")]
}

/// Copies what `finish` appended into parts again. The file stays whole.
fn split(path: &Path) -> io::Result<()> {
    let mut lines = BufReader::new(File::open(path)?);
    let mut copy = File::open(path)?;
    let (mut line, mut at, mut start, mut body) = (Vec::new(), 0, 0, 0);
    while lines.read_until(b'\n', &mut line)? > 0 {
        let end = at + line.len() as u64;
        let [points, extents] = part_paths(path, body);
        if line.starts_with(b"    def ") {
            start = at;
        } else if line == EXTENTS_LINE {
            if body > 0 {
                copy_range(&mut copy, start..at - END.len() as u64, &points)?;
            }
            start = end;
        } else if line == b"    }\n" {
            copy_range(&mut copy, start..at - END.len() as u64, &extents)?;
            body += 1;
        }
        at = end;
        line.clear();
    }
    Ok(())
}

fn copy_range(from: &mut File, range: Range<u64>, to: &Path) -> io::Result<()> {
    let mut part = Part::open(to, Begin::New)?;
    from.seek(SeekFrom::Start(range.start))?;
    io::copy(&mut from.take(range.end.saturating_sub(range.start)), &mut part)?;
    part.sync()
}
