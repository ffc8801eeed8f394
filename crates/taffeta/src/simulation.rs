//! What a program holds: a scene that runs. Build it, step it, read positions, move pins, apply forces.

use crate::diagnostics::FrameReport;
use crate::scene::{Scene, SceneError};
use crate::topology::Surface;

/// Arithmetic of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Precision {
    /// 32 bits: the fast path.
    #[default]
    F32,
    /// 64 bits: the oracle.
    F64,
}

/// How to run a scene, apart from what it is.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Worker threads; `None`: all that the machine has.
    pub threads: Option<usize>,
    /// Arithmetic.
    pub precision: Precision,
}

/// One body of a running scene, for people and outputs.
#[derive(Clone, Debug)]
pub struct BodyInfo {
    /// Its name.
    pub name: String,
    /// Number of vertices: what outputs have.
    pub vertices: usize,
    /// Number of nodes: what is simulated.
    pub nodes: usize,
    /// Number of triangles.
    pub triangles: usize,
    /// Springs by kind, with their number: `("structural", 1984)`.
    pub springs: Vec<(&'static str, usize)>,
    /// Volume at rest [m³], of a closed body.
    pub rest_volume: Option<f64>,
    /// What was mended in its mesh, in words.
    pub repairs: Vec<String>,
}

/// A run that cannot go on.
#[derive(Clone, Debug, thiserror::Error)]
#[error("frame {frame}: body `{body}`, vertex {vertex}: {what}. {advice}")]
pub struct Diverged {
    /// The frame that failed; the one before it was good.
    pub frame: u32,
    /// Name of the body.
    pub body: String,
    /// Vertex in the mesh's own order.
    pub vertex: usize,
    /// What was seen.
    pub what: String,
    /// Likely cause, and what to change.
    pub advice: String,
}

/// A scene that runs.
pub struct Simulation {}

impl Simulation {
    /// Checks and builds a scene.
    pub fn new(_scene: &Scene, _options: &Options) -> Result<Self, SceneError> {
        todo!()
    }
    /// Runs one frame and reports it.
    pub fn step(&mut self) -> Result<&FrameReport, Diverged> {
        todo!()
    }
    /// Report of the last frame; before the first step, of the start.
    pub fn report(&self) -> &FrameReport {
        todo!()
    }
    /// Number of frames done.
    pub fn frame(&self) -> u32 {
        todo!()
    }
    /// The bodies in the scene's order.
    pub fn bodies(&self) -> &[BodyInfo] {
        todo!()
    }
    /// Largest stable step at rest [s]; infinite without springs. Found by power iteration.
    pub fn largest_stable_step(&self) -> f64 {
        todo!()
    }
    /// Positions of all vertices [m], bodies one after the other, in the meshes' own order. `out` is cleared first.
    pub fn positions_f32(&self, _out: &mut Vec<[f32; 3]>) {
        todo!()
    }
    /// As [`Self::positions_f32`], in 64 bits.
    pub fn positions_f64(&self, _out: &mut Vec<[f64; 3]>) {
        todo!()
    }
    /// Unit normals of a body's vertices, area-weighted.
    pub fn normals(&self, _body: usize) -> Vec<[f32; 3]> {
        todo!()
    }
    /// A body's vertices, faces and texture coordinates, as outputs need them.
    pub fn surface(&self, _body: usize) -> Surface {
        todo!()
    }
    /// 64-bit hash of little-endian positions then velocities, in user order.
    pub fn state_hash(&self) -> u64 {
        todo!()
    }
    /// Precision of the run.
    pub fn precision(&self) -> Precision {
        todo!()
    }
    /// Worker threads in use.
    pub fn threads(&self) -> usize {
        todo!()
    }
    /// The device in words: `cpu, 2 threads, avx512`.
    pub fn device(&self) -> String {
        todo!()
    }
    /// Advice from building the scene, for the user: a step that is too long, nodes that nothing holds.
    pub fn warnings(&self) -> &[String] {
        todo!()
    }
}
