//! What a simulation asks of a backend, whatever it computes on.

use crate::build::Assembly;
use crate::diagnostics::FrameSums;
#[cfg(feature = "gpu")]
use crate::gpu::{VertexTarget, View};

/// A node that is moved, or a force that is applied, by the program for one frame.
#[derive(Clone, Debug, Default)]
pub struct FrameInput {
    /// Pinned nodes that go to a place during the frame: solver index, from, to [m]; ascending.
    pub moves: Vec<(u32, [f64; 3], [f64; 3])>,
    /// Forces during the frame [N]: solver index; ascending.
    pub forces: Vec<(u32, [f64; 3])>,
}

/// What constraints know from one sub-step to the next, in the order of [`crate::solvers::constraints::Constraints`]: a function of
/// the scene alone.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SolverState {
    /// Pull of each constraint [N]; empty where the solver does not start from pulls.
    pub pulls: Vec<f64>,
    /// Whether each is active; empty where all always are.
    pub active: Vec<bool>,
    /// Whether each joint of [`crate::attachments::build::Attachments`] is there; empty where none can break.
    pub joints: Vec<bool>,
}

/// What a backend computes on.
#[derive(Clone, Debug)]
pub struct Device {
    /// `cpu` or `gpu`.
    pub backend: &'static str,
    /// In words.
    pub name: String,
}

/// A device that does not answer any more: why.
#[derive(Clone, Debug)]
pub struct Lost(pub String);

/// A backend in numbers of any type.
pub trait Backend: Send + Sync {
    /// Runs the frame that starts at time `start` [s]. It may still be under way when this returns.
    fn frame(&mut self, start: f64, input: FrameInput) -> Result<(), Lost>;
    /// Measures the state as it is.
    fn measure(&mut self) -> Result<(), Lost>;
    /// What the last frame, or measurement, has found.
    fn sums(&mut self) -> Result<FrameSums, Lost>;
    /// Brings the state to where `position` and `velocity` read it.
    fn fetch(&mut self) -> Result<(), Lost>;
    /// The scene.
    fn assembly(&self) -> &Assembly;
    /// Changes what of the scene may change while it runs: its world, and motions.
    fn alter(&mut self, how: &mut dyn FnMut(&mut Assembly));
    /// Position [m] of the node with solver index `node`.
    fn position(&self, node: usize) -> [f64; 3];
    /// Velocity [m/s] of the node with solver index `node`.
    fn velocity(&self, node: usize) -> [f64; 3];
    /// Sets position [m] and velocity [m/s] of a node.
    fn set(&mut self, node: usize, position: [f64; 3], velocity: [f64; 3]);
    /// Holds a node from now on.
    fn hold(&mut self, node: usize);
    /// Lets go of a node that was free before it was held; it keeps its velocity.
    fn let_go(&mut self, node: usize);
    /// Whether a node is free.
    fn is_free(&self, node: usize) -> bool;
    /// Appends the little-endian bytes of a node's position, or of its velocity.
    fn bytes(&self, node: usize, velocity: bool, sink: &mut Vec<u8>);
    /// What constraints remember; nothing where the scene has none.
    fn solver_state(&self) -> SolverState {
        SolverState::default()
    }
    /// Sets what constraints remember: as many numbers as [`Self::remembered`] has.
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
    /// Draws the vertices of a body that was made ready.
    #[cfg(feature = "gpu")]
    fn draw(&mut self, _body: usize, _target: &VertexTarget, _view: &View) -> Result<(), Lost> {
        Ok(())
    }
    /// Has the next frame timed by stage, if the device can do that.
    fn time_stages(&mut self) {}
    /// Time [s] that each stage took in the frame that was timed, by name; nothing if none was.
    fn stage_times(&mut self) -> Vec<(&'static str, f64)> {
        Vec::new()
    }
    /// Number of workers on the CPU.
    fn threads(&self) -> usize;
    /// What it computes on.
    fn device(&self) -> Device;
    /// What of the device, rather than of the scene, may have ended a run, in words.
    fn doubt(&self) -> Option<String> {
        None
    }
    /// Bytes of memory that state and springs take.
    fn memory(&self) -> usize;
}
