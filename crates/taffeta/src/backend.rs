//! The interface of a backend.

use crate::advice::Warning;
use crate::assembly::Assembly;
use crate::plan::refinement::Refinement;
use crate::report::FrameSums;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

/// The user's input for one frame: moved pins and forces.
#[derive(Clone, Debug, Default)]
pub struct FrameInput {
    /// Pinned nodes that move during the frame: solver index, from, to [m]; ascending.
    pub moves: Vec<(u32, [f64; 3], [f64; 3])>,
    /// Forces during the frame [N]: solver index; ascending.
    pub forces: Vec<(u32, [f64; 3])>,
}

/// State that solvers keep from one sub-step to the next, in the order of
/// [`crate::solvers::constraints::Constraints`]. Its layout is a function of the scene alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolverState {
    /// Warm start of the solver: constraint forces [N], or velocity changes by node; empty if the solver starts from
    /// zero.
    pub warm_start: Vec<f64>,
    /// Whether each constraint is active; empty if all of them always are.
    pub active: Vec<bool>,
    /// Whether each joint of [`crate::attachments::constraints::Attachments`] is whole; empty if none can break.
    pub joints: Vec<bool>,
    /// Forces of contacts between surfaces, those of vertices with triangles first, each kind ascending by pair.
    pub contacts: Vec<ContactForce>,
    /// Whether surfaces may pass through each other, and are to be untangled.
    pub is_tangled: bool,
    /// How finely sub-steps are cut.
    pub refinement: Refinement,
}

/// The force of a contact between surfaces.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ContactForce {
    /// 0: a vertex and a triangle; 1: two edges.
    pub kind: u8,
    /// Their numbers.
    pub pair: [u32; 2],
    /// On the first [N].
    pub force: [f64; 3],
}

/// The device of a backend.
#[derive(Clone, Debug)]
pub struct Device {
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// A description.
    pub name: String,
}

/// A renderer's buffer for the vertices of a body.
///
/// ```no_run
/// use taffeta::taffeta_gpu::wgpu;
/// use taffeta::{Simulation, StepError, VertexTarget, View};
///
/// /// Vertices of a place and a normal, eight numbers each with texture coordinates.
/// fn draw(simulation: &mut Simulation, buffer: wgpu::Buffer) -> Result<(), StepError> {
///     let body = simulation.bodies()[0].handle;
///     let nodes: Vec<u32> = (0..simulation.bodies()[0].nodes as u32).collect();
///     simulation.make_drawn(body, &nodes)?;
///     let target = VertexTarget { buffer, first: 0, stride: 32, normal: 12 };
///     let world = View {
///         alpha: 1.0,
///         places: [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]],
///         normals: [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
///     };
///     simulation.draw(body, &target, &world)
/// }
/// ```
#[cfg(feature = "gpu")]
#[derive(Clone, Debug)]
pub struct VertexTarget {
    /// A buffer of the device that simulates, which kernels may write to as storage.
    pub buffer: taffeta_gpu::wgpu::Buffer,
    /// Where the first vertex begins, and its place with it [byte].
    pub first: u64,
    /// From a vertex to the next [byte].
    pub stride: u64,
    /// From a vertex's place to its normal [byte].
    pub normal: u64,
}

#[cfg(feature = "gpu")]
impl VertexTarget {
    /// Refuses a buffer that cannot hold the vertices, in words.
    pub(crate) fn check(&self, vertices: usize) -> Result<(), String> {
        let Self { buffer, first, stride, normal } = self;
        if !buffer.usage().contains(taffeta_gpu::wgpu::BufferUsages::STORAGE) {
            return Err("kernels may not write to the buffer: it needs the usage STORAGE".to_owned());
        }
        if [first, stride, normal].iter().any(|bytes| **bytes % 4 != 0) {
            return Err(format!(
                "first = {first}, stride = {stride} and normal = {normal} must be multiples of 4 bytes"
            ));
        }
        // A position and a normal have twelve bytes each.
        if *normal < 12 || normal.saturating_add(12) > *stride {
            return Err(format!(
                "a normal {normal} bytes after the position does not fit a stride of {stride} bytes: 12 to stride - 12 \
                 would do"
            ));
        }
        let end = first.saturating_add(self.bytes(vertices));
        if end > buffer.size() {
            return Err(format!(
                "{vertices} vertices end at byte {end} of a buffer of {} bytes",
                buffer.size()
            ));
        }
        Ok(())
    }

    /// From the first vertex to the end of the last one's normal [byte].
    pub(crate) fn bytes(&self, vertices: usize) -> u64 {
        match vertices as u64 {
            0 => 0,
            some => self.stride.saturating_mul(some - 1).saturating_add(self.normal + 12),
        }
    }
}

/// The state of a body that is drawn, and its coordinates. [`VertexTarget`] has an example.
#[cfg(feature = "gpu")]
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Interpolation between the state before the last frame, 0, and the state after it, 1.
    pub alpha: f32,
    /// Rows of the map of places into the renderer's coordinates; the last number of each is the shift [m].
    pub places: [[f32; 4]; 3],
    /// Rows of the map of normals, whose lengths do not matter.
    pub normals: [[f32; 3]; 3],
}

/// Frames in which the nodes of a body were held before all that is kept of it stays as it is: with two there are two sub-steps.
pub const SETTLING: u32 = 2;

/// How a body moves.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BodyMotion {
    /// Least and largest coordinates of its nodes [m]; infinite and the wrong way round without any.
    pub bounds: [[f64; 3]; 2],
    /// Speed of the fastest node [m/s].
    pub speed: f64,
}

impl BodyMotion {
    /// Of no nodes.
    pub const NONE: Self = Self { bounds: [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]], speed: 0.0 };

    /// Of nodes with these positions [m] and velocities [m/s].
    pub fn of(nodes: impl Iterator<Item = [[f64; 3]; 2]>) -> Self {
        let Self { mut bounds, speed: mut squared } = Self::NONE;
        for [x, v] in nodes {
            for axis in 0..3 {
                bounds[0][axis] = bounds[0][axis].min(x[axis]);
                bounds[1][axis] = bounds[1][axis].max(x[axis]);
            }
            let square = v[0] * v[0] + v[1] * v[1] + v[2] * v[2];
            // What is no number stays so.
            squared = if square <= squared || squared.is_nan() { squared } else { square };
        }
        Self { bounds, speed: squared.sqrt() }
    }

    /// Its bounds, larger by a margin on each side [m].
    pub fn grown(&self, margin: f64) -> [[f64; 3]; 2] {
        let [low, high] = self.bounds;
        [low.map(|x| x - margin), high.map(|x| x + margin)]
    }

    /// Centre and radius of a ball around it [m].
    pub fn ball(&self) -> ([f64; 3], f64) {
        let [low, high] = self.bounds;
        let half: [f64; 3] = std::array::from_fn(|axis| 0.5 * (high[axis] - low[axis]));
        (std::array::from_fn(|axis| low[axis] + half[axis]), half.iter().map(|h| h * h).sum::<f64>().sqrt())
    }
}

/// Why a device is lost.
#[derive(Clone, Debug)]
pub struct Lost(pub String);

/// A backend of any precision.
pub trait Backend: Send + Sync {
    /// Runs the frame that starts at time `start` [s]. It may still be running when this returns.
    fn frame(&mut self, start: f64, input: FrameInput) -> Result<(), Lost>;
    /// Has frames end early once `stop` is true, where the backend can.
    fn stop_on(&mut self, _stop: Option<Arc<AtomicBool>>) {}
    /// Whether the last frame ended early.
    fn was_stopped(&self) -> bool {
        false
    }
    /// The state of now is one that [`Self::return_to_good`] may go back to.
    fn mark_good(&mut self);
    /// Goes back to the positions and velocities that were good last. What solvers remember stays as it is.
    fn return_to_good(&mut self) -> Result<(), Lost>;
    /// Measures the state as it is.
    fn measure(&mut self) -> Result<(), Lost>;
    /// The sums of the last frame, or measurement.
    fn sums(&mut self) -> Result<FrameSums, Lost>;
    /// Makes `position` and `velocity` return the present state.
    fn fetch(&mut self) -> Result<(), Lost>;
    /// The scene.
    fn assembly(&self) -> &Assembly;
    /// Changes the parts of the scene that may change while it runs: its world, and motions.
    fn alter(&mut self, how: &mut dyn FnMut(&mut Assembly));
    /// Position [m] of the node with solver index `node`.
    fn position(&self, node: usize) -> [f64; 3];
    /// Velocity [m/s] of the node with solver index `node`.
    fn velocity(&self, node: usize) -> [f64; 3];
    /// Sets position [m] and velocity [m/s] of a node.
    fn set(&mut self, node: usize, position: [f64; 3], velocity: [f64; 3]);
    /// Pins a node from now on.
    fn pin(&mut self, node: usize);
    /// From now on all nodes of these bodies are held, and none is moved: nothing of them has to be computed until it is said otherwise.
    /// No result depends on it.
    fn let_rest(&mut self, _bodies: &[bool]) {}
    /// Where a body is and how fast it moves, after [`Self::fetch`].
    fn motion(&self, body: usize) -> BodyMotion {
        let nodes = self.assembly().bodies[body].solver_range();
        BodyMotion::of(nodes.map(|node| [self.position(node), self.velocity(node)]))
    }
    /// Frees a node that was free before it was pinned; it keeps its velocity.
    fn unpin(&mut self, node: usize);
    /// Whether a node is free.
    fn is_free(&self, node: usize) -> bool;
    /// Appends the little-endian bytes of a node's position, or of its velocity.
    fn bytes(&self, node: usize, velocity: bool, sink: &mut Vec<u8>);
    /// The state of solvers; empty if the scene has none.
    fn solver_state(&self) -> SolverState {
        SolverState::default()
    }
    /// Sets the state of solvers. It must have as many numbers as [`Self::solver_state`] returns.
    fn set_solver_state(&mut self, _from: &SolverState) {}
    /// Unit normals of a body's nodes in user order, if the backend computes them itself.
    fn normals(&self, _body: usize) -> Option<Vec<[f32; 3]>> {
        None
    }
    /// Has vertices at the nodes `nodes` of a body made ready to be drawn, `u32::MAX` where one has none; false where the
    /// backend has no device that could draw.
    #[cfg(feature = "gpu")]
    fn make_drawn(&mut self, _body: usize, _nodes: &[u32]) -> Result<bool, Lost> {
        Ok(false)
    }
    /// Number of vertices of a body that were made ready.
    #[cfg(feature = "gpu")]
    fn drawn_vertices(&self, _body: usize) -> usize {
        0
    }
    /// Draws the vertices of a body that was made ready.
    #[cfg(feature = "gpu")]
    fn draw(&mut self, _body: usize, _target: &VertexTarget, _view: &View) -> Result<(), Lost> {
        Ok(())
    }
    /// Times the next frame by stage, if the device supports that.
    fn time_stages(&mut self) {}
    /// Time [s] of each stage in the timed frame, by name; empty if none was timed.
    fn stage_times(&mut self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
    /// Number of threads on the CPU.
    fn threads(&self) -> usize;
    /// Has at most so many of them work from now on.
    fn limit_threads(&mut self, _most: usize) {}
    /// The device.
    fn device(&self) -> Device;
    /// A hint that the device, rather than the scene, may have made a run fail.
    fn failure_hint(&self) -> Option<Warning> {
        None
    }
    /// Bytes of memory that state and springs take.
    fn memory(&self) -> usize;
}
