//! `summary.json`: a run in numbers. Scripts rely on these names.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A run in numbers.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Summary {
    /// The scene file, as it was given.
    pub scene: String,
    /// How the run ended.
    pub status: Status,
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// The device in words.
    pub device: String,
    /// `f32` or `f64`.
    pub precision: String,
    /// Worker threads of the CPU.
    pub threads: usize,
    /// Frames done; outputs have one more, the start.
    pub frames: u32,
    /// Sub-steps a frame, as the scene has them.
    pub substeps: u32,
    /// Most sub-steps of a frame: more than `substeps` where contact between triangles asked for shorter ones.
    pub substeps_max: u32,
    /// Length of a frame [s].
    pub dt: f64,
    /// Largest stable step at rest [s]; null without springs.
    pub largest_stable_step: Option<f64>,
    /// Nodes of all bodies: what is simulated.
    pub nodes: usize,
    /// Vertices of all bodies: what outputs have.
    pub vertices: usize,
    /// Springs of all kinds.
    pub springs: usize,
    /// Triangles of all bodies.
    pub triangles: usize,
    /// Median time of a frame [ms].
    pub wall_ms_per_frame: f64,
    /// Nodes times the mean number of sub-steps of a frame a second, from the median.
    pub particle_substeps_per_s: f64,
    /// Total energy [J].
    pub energy: Energy,
    /// Linear momentum at the end [kg·m/s].
    pub momentum: [f64; 3],
    /// Angular momentum about the origin at the end [kg·m²/s].
    pub angular_momentum: [f64; 3],
    /// Largest stretch l/L of any spring, and of fabric along warp or weft, in any frame; 1 without either.
    pub max_stretch: f64,
    /// Strain of fabric over all frames; null without fabric.
    pub strain: Option<Strain>,
    /// The bodies in the scene's order.
    pub bodies: Vec<BodySummary>,
    /// Nodes in contact at the end of the last frame.
    pub contacts: u64,
    /// Most nodes in contact at the end of any frame.
    pub contacts_max: u64,
    /// Contact of nodes with each other.
    pub pairs: PairSummary,
    /// Edges that pass through triangles: at the start and at the end, and in all frames with `--verify-contact` and while what
    /// starts through each other is pulled apart; null where they were not counted, as among very many triangles.
    pub intersections: Option<IntersectionSummary>,
    /// The solver of constraints.
    pub solver: SolverSummary,
    /// 64-bit hash of positions then velocities where the run ended, 16 hexadecimal digits; null where the GPU was lost,
    /// and the state with it.
    pub state_hash: Option<String>,
    /// Names of the files with the results, beside this one.
    pub files: Vec<String>,
}

/// How a run ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Status {
    /// All frames are there.
    Done,
    /// A frame failed; those before it are there.
    Diverged,
    /// A frame had surfaces that pass through each other, and the run was to stop there; the frames up to it are there.
    Intersected,
    /// The user stopped it; the frames until then are there.
    Interrupted,
    /// A file could not be written, for the disk was full or is gone, or the GPU was lost; the frames until then are
    /// there.
    Failed,
}

/// Total energy over a run [J].
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
pub struct Energy {
    /// At the start.
    pub start: f64,
    /// At the end.
    pub end: f64,
    /// The largest of all frames.
    pub max: f64,
}

/// Strain of fabric over a run.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
pub struct Strain {
    /// Least and largest engineering strain along the warp of any triangle in any frame.
    pub warp: [f64; 2],
    /// The same along the weft.
    pub weft: [f64; 2],
    /// Largest shear angle [rad].
    pub shear: f64,
}

/// Contact of nodes with each other over a run.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct PairSummary {
    /// Pairs of nodes nearer than their thickness in the last frame's last sub-step.
    #[serde(rename = "final")]
    pub end: u64,
    /// Most of them at the end of any frame.
    pub max: u64,
    /// Least distance of one by its thickness, before it was pushed apart; null without pairs.
    pub nearest: Option<f64>,
    /// Times that neighbours were searched for.
    pub searches: u64,
}

/// Edges that pass through triangles over a run.
#[derive(Clone, Copy, Debug, Default, Serialize, Deserialize, JsonSchema)]
pub struct IntersectionSummary {
    /// Pairs of an edge and a triangle at the start; null where they were counted later only.
    pub start: Option<u64>,
    /// The same in the last frame.
    #[serde(rename = "final")]
    pub end: u64,
    /// Most of them in any frame in which they were counted.
    pub max: u64,
    /// The last of these frames that has any; null where none has.
    pub last_frame: Option<u32>,
}

/// One body of a run.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct BodySummary {
    /// Its name.
    pub name: String,
    /// Its nodes.
    pub nodes: usize,
    /// Its vertices.
    pub vertices: usize,
    /// Its triangles.
    pub triangles: usize,
    /// The frame in which it diverged and was frozen (`--on-divergence freeze`): it stands as it was before; null where it moves.
    pub frozen: Option<u32>,
    /// Its volume; null where it is not closed.
    pub volume: Option<Volume>,
}

/// Volume of a closed body over a run.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
pub struct Volume {
    /// At rest [m³].
    pub rest: f64,
    /// At the end [m³].
    #[serde(rename = "final")]
    pub end: f64,
    /// How it is kept: `corrected`, `projected`, `paper-shader` or `printed`; null where nothing keeps it.
    pub form: Option<&'static str>,
    /// The volume to keep at the end [m³]; null where nothing keeps it.
    pub target: Option<f64>,
    /// Largest |V − V₀| / V₀ of all frames after the start: V₀ is the volume to keep at that time, or that at rest where
    /// nothing keeps it.
    pub max_rel_error: f64,
}

/// What the solver of constraints did; all zero for explicit springs.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, JsonSchema)]
pub struct SolverSummary {
    /// Most iterations of a sub-step.
    pub iterations: u32,
    /// Mean over frames of the most iterations of a sub-step.
    pub mean_iterations: f64,
    /// Largest residual of a sub-step, relative to the right side.
    pub residual: f64,
    /// Largest share of the springs that were constraints in a sub-step.
    pub active_fraction: f64,
    /// Mean over frames of that largest share.
    pub mean_active_fraction: f64,
    /// Sub-steps that ended with a residual beyond the tolerance.
    pub capped: u64,
}
