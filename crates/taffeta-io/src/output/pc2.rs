//! PC2, the point cache of 3ds Max that Blender and Maya read: a header of 32 bytes, then 32-bit floats, frame by
//! frame, little endian.

use super::part::Part;
use super::{Begin, FrameSink, Positions};
use std::io::{self, Write};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Byte at which the number of frames is written.
const COUNT_AT: u64 = 28;

/// Writes the points of one body.
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// use taffeta_io::output::{Begin, FrameSink, Pc2, Positions};
///
/// let mut file = Box::new(Pc2::open(&folder.path().join("cloth.pc2"), 0..20, Begin::New)?);
/// let mut positions: Vec<[f32; 3]> = Vec::new();
/// for _ in 0..3 {
///     simulation.step()?;
///     simulation.positions_f32(&mut positions);
///     file.frame(simulation.report().time, &Positions::F32(&positions))?;
/// }
/// file.finish()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Pc2 {
    part: Part,
    frames: i32,
    vertices: Range<usize>,
}

impl Pc2 {
    /// Starts the file at `path` for one body, which has `vertices` among those of all bodies, or takes it up.
    pub fn open(path: &Path, vertices: Range<usize>, begin: Begin) -> io::Result<Self> {
        let mut part = Part::open(path, begin)?;
        let points = i32::try_from(vertices.len())
            .map_err(|_| part.refuse(format!("{} vertices are too many for PC2", vertices.len())))?;
        if begin == Begin::New {
            part.write_all(&header(points))?;
            part.flush()?;
        }
        Ok(Self { part, frames: 0, vertices })
    }
}

/// The header of a file without frames.
fn header(points: i32) -> Vec<u8> {
    let mut bytes = b"POINTCACHE2\0".to_vec();
    bytes.extend(1_i32.to_le_bytes());
    bytes.extend(points.to_le_bytes());
    // Start frame and frames a sample.
    bytes.extend(0_f32.to_le_bytes());
    bytes.extend(1_f32.to_le_bytes());
    bytes.extend(0_i32.to_le_bytes());
    bytes
}

impl FrameSink for Pc2 {
    fn frame(&mut self, _time: f64, positions: &Positions) -> io::Result<()> {
        let own = positions.slice(self.vertices.clone()).ok_or_else(|| {
            self.part.refuse(format!("vertices {:?} of {}", self.vertices, positions.len()))
        })?;
        for x in own.iter_f32().flatten() {
            self.part.write_all(&x.to_le_bytes())?;
        }
        self.part.flush()?;
        self.frames = self
            .frames
            .checked_add(1)
            .ok_or_else(|| self.part.refuse("too many frames for PC2".to_owned()))?;
        Ok(())
    }

    fn mark(&self) -> Vec<u64> {
        vec![self.part.len()]
    }

    fn rewind(&mut self, frames: u64, mark: &[u64]) -> io::Result<()> {
        self.frames = i32::try_from(frames).unwrap_or(i32::MAX);
        mark.iter().try_for_each(|&length| self.part.cut(length))
    }

    fn sync(&mut self) -> io::Result<()> {
        let frames = self.frames;
        self.part.patch(COUNT_AT, &frames.to_le_bytes())?;
        self.part.sync()
    }

    fn finish(mut self: Box<Self>) -> io::Result<Vec<PathBuf>> {
        self.sync()?;
        Ok(vec![self.part.finish()?])
    }
}
