//! NumPy's format 1.0: a header of fixed length, then [frames, vertices, 3] numbers, little endian.

use super::part::Part;
use super::{Begin, FrameSink, Positions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use taffeta::Precision;

/// Length of the header with its preamble [byte]: a multiple of 64, with room for any count.
const HEADER: usize = 128;

/// Writes `positions.npy`.
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// use taffeta_io::output::{Begin, FrameSink, Npy, Positions};
///
/// let mut file = Box::new(Npy::open(&folder.path().join("positions.npy"), 20, Precision::F32, Begin::New)?);
/// let mut positions: Vec<[f32; 3]> = Vec::new();
/// for _ in 0..3 {
///     simulation.step()?;
///     simulation.positions_f32(&mut positions);
///     file.frame(simulation.report().time, &Positions::F32(&positions))?;
/// }
/// file.finish()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Npy {
    part: Part,
    frames: u64,
    vertices: usize,
    precision: Precision,
}

impl Npy {
    /// Starts the file at `path` for frames of `vertices` vertices, or takes it up. Positions in another precision are
    /// converted.
    pub fn open(path: &Path, vertices: usize, precision: Precision, begin: Begin) -> io::Result<Self> {
        let mut part = Part::open(path, begin)?;
        if begin == Begin::New {
            part.write_all(&header(0, vertices, precision))?;
            part.flush()?;
        }
        Ok(Self { part, frames: 0, vertices, precision })
    }
}

impl FrameSink for Npy {
    fn frame(&mut self, _time: f64, positions: &Positions) -> io::Result<()> {
        if positions.len() != self.vertices {
            return Err(self.part.refuse(format!(
                "{} vertices instead of {}",
                positions.len(),
                self.vertices
            )));
        }
        positions.write(self.precision, &mut self.part)?;
        self.part.flush()?;
        self.frames += 1;
        Ok(())
    }

    fn mark(&self) -> Vec<u64> {
        vec![self.part.len()]
    }

    fn rewind(&mut self, frames: u64, mark: &[u64]) -> io::Result<()> {
        self.frames = frames;
        mark.iter().try_for_each(|&length| self.part.cut(length))
    }

    fn sync(&mut self) -> io::Result<()> {
        self.part.patch(0, &header(self.frames, self.vertices, self.precision))?;
        self.part.sync()
    }

    fn finish(mut self: Box<Self>) -> io::Result<Vec<PathBuf>> {
        self.sync()?;
        Ok(vec![self.part.finish()?])
    }
}

fn header(frames: u64, vertices: usize, precision: Precision) -> Vec<u8> {
    let kind = match precision {
        Precision::F32 => "<f4",
        Precision::F64 => "<f8",
    };
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({frames}, {vertices}, 3), }}");
    let length = HEADER - 10;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{text:<width$}\n", width = length - 1).bytes());
    bytes
}
