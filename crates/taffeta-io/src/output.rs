//! Results: caches of positions (npy, PC2, USD, VTU), a table of frames, and final poses (PLY, OBJ, GLB).
//!
//! Every writer streams into `NAME.part`; `finish` writes the true number of frames into the header, syncs the file
//! to the disk and gives it its name. A file without `.part` is whole.

mod drawn;
mod frames;
mod glb;
mod glb_buffer;
mod names;
mod npy;
mod obj;
pub(crate) mod part;
mod pc2;
mod ply;
mod triangles;
mod usd;
mod usd_mesh;
mod uvs;
mod vtu;
mod vtu_mesh;

pub use part::check_file;

pub use drawn::Drawn;
pub use frames::FrameTable;
pub use glb::{GlbBody, write_glb};
pub use names::{file_stems, usd_identifiers};
pub use npy::Npy;
pub use obj::write_obj;
pub use pc2::Pc2;
pub use ply::write_ply;
pub use triangles::triangles_of;
pub use usd::Usd;
pub use vtu::Vtu;

use std::io::{self, Write};
use std::ops::Range;
use std::path::PathBuf;
use taffeta::Precision;

/// Whether files are started, or taken up again.
///
/// ```
/// # use taffeta::Precision;
/// # let folder = tempfile::tempdir()?;
/// use taffeta_io::output::{Begin, FrameSink, Npy, Positions};
///
/// # let path = &folder.path().join("positions.npy");
/// let mut file = Npy::open(path, 1, Precision::F32, Begin::New)?;
/// file.frame(0.0, &Positions::F32(&[[0.0, 1.0, 0.0]]))?;
/// let mark = file.mark();
/// drop(file); // The run ends here, without `finish`.
/// let mut file = Box::new(Npy::open(path, 1, Precision::F32, Begin::Again)?);
/// file.rewind(1, &mark)?;
/// file.frame(0.1, &Positions::F32(&[[0.0, 0.95, 0.0]]))?;
/// assert_eq!(std::fs::metadata(&file.finish()?[0])?.len(), 128 + 2 * 12);
/// # Ok::<(), std::io::Error>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Begin {
    /// Empty, whatever was there before.
    New,
    /// As an earlier run left them, finished or not; [`FrameSink::rewind`] says where to go on.
    Again,
}

/// Something that frames are written to.
///
/// A frame is on its way to the disk when [`frame`](Self::frame) returns, so that a full disk shows at the frame
/// that it cuts off, and all sinks can be rewound to the frame before.
///
/// ```
/// use std::{io, path::PathBuf};
/// use taffeta_io::output::{FrameSink, Positions};
///
/// /// Remembers the lowest height in each frame [m], and writes nothing.
/// #[derive(Default)]
/// struct Lowest(Vec<f32>);
///
/// impl FrameSink for Lowest {
///     fn frame(&mut self, _time: f64, positions: &Positions) -> io::Result<()> {
///         let Positions::F32(all) = positions else { return Err(io::ErrorKind::Unsupported.into()) };
///         self.0.push(all.iter().map(|place| place[1]).fold(f32::INFINITY, f32::min));
///         Ok(())
///     }
///     fn mark(&self) -> Vec<u64> {
///         Vec::new()
///     }
///     fn rewind(&mut self, frames: u64, _mark: &[u64]) -> io::Result<()> {
///         self.0.truncate(frames as usize);
///         Ok(())
///     }
///     fn sync(&mut self) -> io::Result<()> {
///         Ok(())
///     }
///     fn finish(self: Box<Self>) -> io::Result<Vec<PathBuf>> {
///         Ok(Vec::new())
///     }
/// }
///
/// let mut lowest = Lowest::default();
/// lowest.frame(0.0, &Positions::F32(&[[0.0, 1.5, 0.0], [0.1, 0.25, 0.0]]))?;
/// assert_eq!(lowest.0, [0.25]);
/// # Ok::<(), io::Error>(())
/// ```
pub trait FrameSink {
    /// Adds a frame at `time` [s] with the positions of all vertices of all bodies.
    fn frame(&mut self, time: f64, positions: &Positions) -> io::Result<()>;

    /// Lengths of the files under way [byte]: where the frames so far end. A run that goes on needs them.
    fn mark(&self) -> Vec<u64>;

    /// Goes back to the end of `frames` frames, where [`mark`](Self::mark) was `mark`.
    fn rewind(&mut self, frames: u64, mark: &[u64]) -> io::Result<()>;

    /// Puts all frames so far on the disk, with their true number in the header.
    fn sync(&mut self) -> io::Result<()>;

    /// Completes the files and gives them their names, which are returned.
    fn finish(self: Box<Self>) -> io::Result<Vec<PathBuf>>;
}

/// Positions [m] of all vertices of all bodies, one body after the other.
///
/// ```
/// use taffeta_io::output::Positions;
///
/// let places = [[0.0, 1.0, 0.0], [0.1, 1.0, 0.0], [0.0, 2.0, 0.0]];
/// let all = Positions::F32(&places);
/// // The second body begins at vertex 2.
/// assert_eq!(all.slice(2..3).map(|body| body.len()), Some(1));
/// assert!(all.slice(2..4).is_none());
/// ```
#[derive(Clone, Copy, Debug)]
pub enum Positions<'a> {
    /// In 32 bits.
    F32(&'a [[f32; 3]]),
    /// In 64 bits.
    F64(&'a [[f64; 3]]),
}

impl<'a> Positions<'a> {
    /// Number of vertices.
    pub fn len(&self) -> usize {
        match self {
            Self::F32(all) => all.len(),
            Self::F64(all) => all.len(),
        }
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The vertices of `range`, where there are that many.
    pub fn slice(&self, range: Range<usize>) -> Option<Positions<'a>> {
        match self {
            Self::F32(all) => all.get(range).map(Positions::F32),
            Self::F64(all) => all.get(range).map(Positions::F64),
        }
    }

    /// Writes the numbers in `precision`, little endian; converts them where they are in another.
    fn write(&self, precision: Precision, out: &mut impl Write) -> io::Result<()> {
        match (self, precision) {
            (Self::F32(all), Precision::F32) => {
                all.as_flattened().iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
            }
            (Self::F32(all), Precision::F64) => {
                let mut wide = all.as_flattened().iter().map(|&x| f64::from(x));
                wide.try_for_each(|x| out.write_all(&x.to_le_bytes()))
            }
            (Self::F64(all), Precision::F64) => {
                all.as_flattened().iter().try_for_each(|x| out.write_all(&x.to_le_bytes()))
            }
            (Self::F64(_), Precision::F32) => {
                self.iter_f32().flatten().try_for_each(|x| out.write_all(&x.to_le_bytes()))
            }
        }
    }

    /// One after the other, rounded to 32 bits.
    fn iter_f32(&self) -> impl Iterator<Item = [f32; 3]> + use<'a> {
        let all = *self;
        (0..all.len()).map(move |i| match all {
            Self::F32(all) => all[i],
            Self::F64(all) => all[i].map(|x| x as f32),
        })
    }
}
