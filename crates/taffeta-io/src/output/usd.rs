//! USD in its text form: a mesh or curve for each body, with points and extents for each frame.
//!
//! A frame adds to all bodies, but the file has one body after the other: each body's points stream into a part of
//! their own, and `finish` puts the parts together.

use super::part::Part;
use super::usd_mesh::write_topology;
use super::{FrameSink, Positions, usd_identifiers};
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};
use taffeta::topology::Surface;

/// Writes one `.usda` file for all bodies.
pub struct Usd {
    path: PathBuf,
    /// Length of a frame [s].
    dt: f64,
    frames: u64,
    vertices: usize,
    bodies: Vec<BodyPart>,
}

struct BodyPart {
    part: Part,
    vertices: Range<usize>,
    extents: Vec<[[f32; 3]; 2]>,
}

impl Usd {
    /// Starts the file at `path`; `bodies` are names and surfaces in the order of the positions, `dt` is the length
    /// of a frame [s].
    pub fn create(path: &Path, dt: f64, bodies: &[(String, Surface)]) -> io::Result<Self> {
        let names: Vec<String> = bodies.iter().map(|(name, _)| name.clone()).collect();
        let mut usd = Self { path: path.to_owned(), dt, frames: 0, vertices: 0, bodies: Vec::new() };
        for (index, (name, (_, surface))) in usd_identifiers(&names).iter().zip(bodies).enumerate() {
            let mut own = path.as_os_str().to_owned();
            own.push(format!(".{index}"));
            let mut part = Part::create(Path::new(&own))?;
            write_topology(&mut part, name, surface)?;
            part.write_all(b"        point3f[] points.timeSamples = {\n")?;
            let vertices = usd.vertices..usd.vertices + surface.vertices.len();
            usd.vertices = vertices.end;
            usd.bodies.push(BodyPart { part, vertices, extents: Vec::new() });
        }
        Ok(usd)
    }

    fn header(&self) -> String {
        let (rate, end) = (1.0 / self.dt, self.frames.saturating_sub(1));
        format!(
            "#usda 1.0\n(\n    defaultPrim = \"Scene\"\n    endTimeCode = {end}\n    framesPerSecond = {rate}\n    \
             metersPerUnit = 1\n    startTimeCode = 0\n    timeCodesPerSecond = {rate}\n    upAxis = \"Y\"\n)\n\n\
             def Xform \"Scene\" (\n    kind = \"component\"\n)\n{{\n"
        )
    }
}

impl FrameSink for Usd {
    fn frame(&mut self, _time: f64, positions: &Positions) -> io::Result<()> {
        let (expected, frame) = (self.vertices, self.frames);
        for body in &mut self.bodies {
            let own = positions.slice(body.vertices.clone()).filter(|_| positions.len() == expected);
            let own = own.ok_or_else(|| {
                body.part.refuse(format!("{} vertices instead of {expected}", positions.len()))
            })?;
            body.frame(frame, &own)?;
        }
        self.frames += 1;
        Ok(())
    }

    fn finish(self: Box<Self>) -> io::Result<PathBuf> {
        let mut whole = Part::create(&self.path)?;
        whole.write_all(self.header().as_bytes())?;
        for body in self.bodies {
            whole.take(body.close()?)?;
        }
        whole.write_all(b"}\n")?;
        whole.finish()
    }
}

impl BodyPart {
    fn frame(&mut self, frame: u64, positions: &Positions) -> io::Result<()> {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        write!(self.part, "            {frame}: [")?;
        for (i, [x, y, z]) in positions.iter_f32().enumerate() {
            let comma = if i == 0 { "" } else { ", " };
            write!(self.part, "{comma}({x}, {y}, {z})")?;
            for (axis, value) in [x, y, z].into_iter().enumerate() {
                low[axis] = low[axis].min(value);
                high[axis] = high[axis].max(value);
            }
        }
        self.extents.push([low, high]);
        self.part.write_all(b"],\n")
    }

    fn close(mut self) -> io::Result<Part> {
        self.part.write_all(b"        }\n        float3[] extent.timeSamples = {\n")?;
        for (frame, [[a, b, c], [x, y, z]]) in self.extents.iter().enumerate() {
            writeln!(self.part, "            {frame}: [({a}, {b}, {c}), ({x}, {y}, {z})],")?;
        }
        self.part.write_all(b"        }\n    }\n\n")?;
        Ok(self.part)
    }
}
