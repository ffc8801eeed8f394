//! What a program holds: a scene that runs. Build it, step it, read positions, move pins, apply forces.

mod frames;
mod info;
mod live;
mod seen;
mod snapshot;

pub use info::{BodyInfo, ColliderInfo};
pub use live::Pose;
pub use snapshot::Snapshot;

use crate::backend::{Backend, FrameInput, Lost};
use crate::build::Assembly;
use crate::build::body::BodyAssembly;
use crate::contact::collider_mesh::surface::MeshSurface;
use crate::diagnostics::advice::StepLimit;
use crate::diagnostics::digits::too_coarse;
use crate::diagnostics::tension::Tension;
use crate::diagnostics::wind::weakened;
use crate::diagnostics::{FrameReport, FrameSums, normals};
use crate::features;
#[cfg(feature = "gpu")]
use crate::gpu::GpuOptions;
use crate::scene::{Scene, SceneError};
#[cfg(feature = "gpu")]
use crate::step::Stage;
use crate::topology::Surface;
use crate::topology::random::SplitMix64;
use crate::volume::volume::Form;
use serde::{Deserialize, Serialize};
use std::hash::Hasher;
use std::sync::OnceLock;

/// Arithmetic of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
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
    /// Worker threads; `None`: all that the machine has, but one for every 4,096 nodes at most, for less work than
    /// that is done before the workers have met.
    pub threads: Option<usize>,
    /// Arithmetic; a GPU computes in [`Precision::F32`] alone.
    pub precision: Precision,
    /// The GPU to run on; `None`: the CPU.
    #[cfg(feature = "gpu")]
    pub gpu: Option<GpuOptions>,
}

/// A run that cannot go on.
#[derive(Clone, Debug, thiserror::Error)]
#[error("{}: body `{body}`, vertex {vertex}: {what}. {advice}", named(.first, .frame))]
pub struct Diverged {
    /// The first frame that may have failed; the one before it was good.
    pub first: u32,
    /// The frame after which that was seen. Later than `first` where several were launched before one was looked at.
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

/// Frames in words.
fn named(first: &u32, last: &u32) -> String {
    if first == last {
        format!("frame {last}")
    } else {
        format!("by frame {last} (frame {} was good)", first - 1)
    }
}

/// Why a frame could not be done.
#[derive(Clone, Debug, thiserror::Error)]
pub enum StepError {
    /// The scene cannot go on.
    #[error(transparent)]
    Diverged(#[from] Diverged),
    /// The device that computes does not answer any more.
    #[error("frame {frame}: {why}")]
    Lost {
        /// The frame that failed; the one before it was good.
        frame: u32,
        /// What the device said.
        why: String,
    },
}

/// A scene that runs.
pub struct Simulation {
    backend: Box<dyn Backend>,
    precision: Precision,
    bodies: Vec<BodyInfo>,
    colliders: Vec<ColliderInfo>,
    start: FrameReport,
    report: FrameReport,
    limit: StepLimit,
    warnings: Vec<String>,
    input: FrameInput,
    /// Nodes that were moved by the user in the last frame and stand still from now on.
    moved: Vec<u32>,
    /// Nodes that were free and are pinned by the user.
    taken: Vec<u32>,
    /// Triangles of colliders, once somebody asks how far nodes are from them.
    surfaces: OnceLock<Vec<MeshSurface<f64>>>,
    /// Frames that were launched and not collected yet, and whether more than gravity drives the scene in them.
    launched: (u32, bool),
}

impl Simulation {
    /// Checks and builds a scene.
    ///
    /// # Errors
    /// Names the place in the scene that cannot be simulated, and what would do.
    pub fn new(scene: &Scene, options: &Options) -> Result<Self, SceneError> {
        let assembly = Assembly::new(scene)?;
        let bodies: Vec<BodyInfo> =
            (0..assembly.bodies.len()).map(|body| BodyInfo::of(&assembly, body)).collect();
        let colliders =
            (0..assembly.colliders.len()).map(|i| ColliderInfo::of(scene, &assembly, i)).collect();
        let limit = StepLimit::new(&assembly);
        let of_body = |body: &BodyAssembly| {
            body.warnings.iter().map(|warning| format!("body `{}`: {warning}", body.name)).collect::<Vec<_>>()
        };
        let mut warnings: Vec<String> = assembly.bodies.iter().flat_map(of_body).collect();
        warnings.extend(assembly.attachments.warnings());
        warnings.extend(limit.warnings());
        warnings.extend(weakened(&assembly));
        if options.precision == Precision::F32 {
            warnings.extend(assembly.bodies.iter().filter_map(too_coarse));
        }
        let threads = options.threads.unwrap_or_else(|| useful_threads(&assembly)).max(1);
        let backend =
            backend(scene, assembly, threads, options).map_err(|why| SceneError::new("body", why))?;
        let mut simulation = Self {
            backend,
            precision: options.precision,
            bodies,
            colliders,
            start: FrameReport::default(),
            report: FrameReport::default(),
            limit,
            warnings,
            input: FrameInput::default(),
            moved: Vec::new(),
            taken: Vec::new(),
            surfaces: OnceLock::new(),
            launched: (0, false),
        };
        simulation.measure().map_err(|Lost(why)| SceneError::new("", why))?;
        Ok(simulation)
    }

    /// Runs one frame and reports it.
    ///
    /// # Errors
    /// A frame with a number that is not finite, or with a stretch that only a blow-up has, is not shown: the error
    /// names body, vertex, likely cause and what to change. A GPU may be lost. The simulation cannot go on then.
    pub fn step(&mut self) -> Result<&FrameReport, StepError> {
        self.advance(1)
    }

    /// Runs some frames and reports the last. On a GPU nothing waits between them.
    ///
    /// # Errors
    /// As [`Self::step`]; only the last frame is looked at, so the error says by which frame it was.
    pub fn advance(&mut self, frames: u32) -> Result<&FrameReport, StepError> {
        self.launch(frames)?;
        self.collect()
    }

    /// Runs one frame and says how long [s] each stage took: of the first worker on the CPU, or on a GPU that can tell, where
    /// stages are timed apart. The frame takes longer than others.
    ///
    /// # Errors
    /// As [`Self::step`].
    pub fn step_timed(&mut self) -> Result<Vec<(&'static str, f64)>, StepError> {
        self.backend.time_stages();
        self.step()?;
        Ok(self.backend.stage_times())
    }

    /// Brings the state to where positions are read from, if it is elsewhere. Without it the first read does so, and
    /// cannot say that it failed.
    ///
    /// # Errors
    /// A GPU may be lost.
    pub fn fetch(&mut self) -> Result<(), StepError> {
        let frame = self.frame();
        self.backend.fetch().map_err(|Lost(why)| StepError::Lost { frame, why })
    }

    fn report_of(&self, sums: FrameSums, frame: u32) -> FrameReport {
        let assembly = self.backend.assembly();
        let FrameSums { all, hinges, volumes, pairs, solver, broken } = sums;
        let gravity = assembly.world.gravity;
        let time = f64::from(frame) * assembly.time.dt;
        FrameReport {
            frame,
            time,
            kinetic: 0.5 * all.m_v2,
            gravitational: -(0..3).map(|axis| gravity[axis] * all.m_x[axis]).sum::<f64>(),
            springs: all.springs,
            hinges,
            momentum: all.momentum,
            angular_momentum: all.angular_momentum,
            max_stretch: if all.max_stretch > 0.0 { all.max_stretch } else { 1.0 },
            contacts: all.contacts,
            volumes,
            volume_targets: assembly.volume_targets(time),
            pairs: pairs.pairs,
            nearest_pair: (pairs.pairs > 0).then_some(pairs.nearest),
            pair_searches: pairs.searches,
            solver,
            broken,
        }
    }

    /// The vertex to name: the first that is not finite, else the fastest.
    fn diverged(&self, [first, frame]: [u32; 2], what: String) -> Diverged {
        let mut worst = (-1.0, 0, 0);
        for (index, body) in self.backend.assembly().bodies.iter().enumerate() {
            for local in 0..body.nodes {
                let v = self.backend.velocity(body.first + local);
                let speed =
                    v.iter().chain(&self.backend.position(body.first + local)).map(|c| c * c).sum::<f64>();
                let speed = if speed.is_finite() { v.iter().map(|c| c * c).sum() } else { f64::INFINITY };
                if speed > worst.0 {
                    worst = (speed, index, local);
                }
            }
        }
        let body = &self.backend.assembly().bodies[worst.1];
        let printed =
            |body: &BodyAssembly| body.volume.as_ref().is_some_and(|kept| kept.form == Form::Printed);
        let advice = match self.backend.assembly().bodies.iter().find(|body| printed(body)) {
            Some(body) => format!(
                "Likely cause: the volume of body `{}` is kept as printed, where every step makes its error 4/3 times as \
                 large; volume.form = \"corrected\" would do",
                body.name
            ),
            None => self.limit.after(),
        };
        let advice =
            [Some(advice), self.backend.doubt()].into_iter().flatten().collect::<Vec<_>>().join(". ");
        let (body, vertex) = (body.name.clone(), body.vertex_of_solver(worst.2));
        Diverged { first, frame, body, vertex, what, advice }
    }

    /// Report of the last frame; before the first step, of the start.
    pub fn report(&self) -> &FrameReport {
        &self.report
    }

    /// Number of frames done, those among them that were launched and may still be under way.
    pub fn frame(&self) -> u32 {
        self.report.frame + self.launched.0
    }

    /// The bodies in the scene's order.
    pub fn bodies(&self) -> &[BodyInfo] {
        &self.bodies
    }

    /// The colliders in the scene's order, as they were when it was built.
    pub fn colliders(&self) -> &[ColliderInfo] {
        &self.colliders
    }

    /// Number of pairs of nodes that each seam sews, in the scene's order.
    pub fn sewn(&self) -> Vec<usize> {
        let attached = &self.backend.assembly().attachments;
        let mut pairs = vec![0; attached.seams];
        let laws = attached.rows.iter().map(|row| row.law as usize);
        laws.filter(|&law| law < attached.seams).for_each(|law| pairs[law] += 1);
        pairs
    }

    /// Largest stable step at rest [s] of what is explicit, found by power iteration; infinite without springs. Where all
    /// springs are implicit it is that of hinges and drag.
    pub fn largest_stable_step(&self) -> f64 {
        self.limit.at_rest
    }

    /// Largest step [s] that is stable however springs are folded; at most [`Self::largest_stable_step`].
    pub fn largest_stable_step_folded(&self) -> f64 {
        self.limit.folded
    }

    /// The same in any flow of air [s]; `None` where air does not act on the body that sets the largest steps.
    pub fn largest_stable_step_in_air(&self) -> Option<f64> {
        self.limit.in_air
    }

    /// Where implicit springs are pulled hardest by what hangs in them, as far as that can be told beforehand; `None` for
    /// explicit springs, for those solved for by nodes, and where nothing hangs from a pin.
    pub fn hanging(&self) -> Option<&Tension> {
        self.limit.hanging.as_ref()
    }

    /// Moves a pinned vertex to a place [m] during the next frame, in a straight line; it stays there. A free vertex
    /// is pinned from now on, until [`Self::let_go`].
    ///
    /// # Errors
    /// Where there is no such body or vertex, the vertex follows keyframes of the scene, or `to` is not finite.
    pub fn move_pin(&mut self, body: &str, vertex: usize, to: [f64; 3]) -> Result<(), SceneError> {
        let (found, node) = self.node_of(body, vertex)?;
        finite(to, "a place")?;
        let nodes: Vec<usize> = found.nodes_at(node).map(|node| found.solver_index(node)).collect();
        let moving = &self.backend.assembly().moving_pins;
        let keyed = |node: &usize| moving.binary_search_by_key(&(*node as u32), |pin| pin.node).is_ok();
        if nodes.iter().any(keyed) {
            let message = format!(
                "vertex {vertex} of body `{body}` follows keyframes; a pin without them can be moved"
            );
            return Err(SceneError::new("body", message));
        }
        for node in nodes {
            if self.backend.is_free(node) {
                self.backend.hold(node);
                self.taken.push(node as u32);
            }
            let from = self.backend.position(node);
            let moves = &mut self.input.moves;
            moves.retain(|&(other, ..)| other as usize != node);
            let place = moves.partition_point(|&(other, ..)| (other as usize) < node);
            moves.insert(place, (node as u32, from, to));
        }
        Ok(())
    }

    /// Applies a force [N] to a vertex during the next frame. Several forces on one vertex add up.
    ///
    /// # Errors
    /// Where there is no such body or vertex, or `force` is not finite.
    pub fn apply_force(&mut self, body: &str, vertex: usize, force: [f64; 3]) -> Result<(), SceneError> {
        let (found, node) = self.node_of(body, vertex)?;
        let node = found.solver_index(node);
        finite(force, "a force")?;
        let forces = &mut self.input.forces;
        forces.insert(forces.partition_point(|&(other, _)| (other as usize) <= node), (node as u32, force));
        Ok(())
    }

    /// Moves every free node by up to `amplitude` [m] along each axis, at random but the same for the same `seed`.
    pub fn disturb(&mut self, amplitude: f64, seed: u64) {
        let mut random = SplitMix64::new(seed);
        for node in self.user_order() {
            let shift: [f64; 3] = std::array::from_fn(|_| amplitude * (2.0 * random.unit() - 1.0));
            if self.backend.is_free(node) {
                let x = self.backend.position(node);
                let v = self.backend.velocity(node);
                self.backend.set(node, std::array::from_fn(|axis| x[axis] + shift[axis]), v);
            }
        }
        // A device that is lost says so in the next step.
        let _ = self.measure();
    }

    /// Takes the state as it is for the start.
    fn measure(&mut self) -> Result<(), Lost> {
        self.backend.measure()?;
        let sums = self.backend.sums()?;
        self.report = self.report_of(sums, self.frame());
        self.launched = (0, false);
        self.start = self.report.clone();
        Ok(())
    }

    /// The body of that name, and the node of its vertex.
    fn node_of(&self, body: &str, vertex: usize) -> Result<(&BodyAssembly, usize), SceneError> {
        let bodies = &self.backend.assembly().bodies;
        let names = || bodies.iter().map(|b| b.name.as_str()).collect::<Vec<_>>().join(", ");
        let found = bodies.iter().find(|b| b.name == body).ok_or_else(|| {
            SceneError::new("body", format!("there is no body `{body}`; there are: {}", names()))
        })?;
        let count = found.vertices();
        if vertex >= count {
            let message = format!("body `{body}` has vertices 0 to {}, not {vertex}", count - 1);
            return Err(SceneError::new("body", message));
        }
        let node = found.node_of_vertex(vertex).ok_or_else(|| {
            SceneError::new(
                "body",
                format!("vertex {vertex} of body `{body}` is in no face and not simulated"),
            )
        })?;
        Ok((found, node))
    }

    /// Solver indices of all nodes in user order.
    fn user_order(&self) -> Vec<usize> {
        let bodies = &self.backend.assembly().bodies;
        bodies.iter().flat_map(|body| (0..body.nodes).map(|node| body.solver_index(node))).collect()
    }

    fn vertex_positions(&self, mut sink: impl FnMut([f64; 3])) {
        for body in &self.backend.assembly().bodies {
            for vertex in 0..body.vertices() {
                sink(match (body.node_of_vertex(vertex), &body.surface) {
                    (None, Some(surface)) => body.placement.apply(surface.vertices[vertex]),
                    (node, _) => self.backend.position(body.solver_index(node.unwrap_or(vertex))),
                });
            }
        }
    }

    /// Positions of all vertices [m], bodies one after the other, in the meshes' own order. `out` is cleared first.
    pub fn positions_f32(&self, out: &mut Vec<[f32; 3]>) {
        out.clear();
        self.vertex_positions(|x| out.push(x.map(|c| c as f32)));
    }

    /// As [`Self::positions_f32`], in 64 bits.
    pub fn positions_f64(&self, out: &mut Vec<[f64; 3]>) {
        out.clear();
        self.vertex_positions(|x| out.push(x));
    }

    /// Unit normals of a body's vertices, area-weighted.
    ///
    /// # Panics
    /// Where there is no body with this index.
    pub fn normals(&self, body: usize) -> Vec<[f32; 3]> {
        let of_nodes = self.backend.normals(body).unwrap_or_else(|| self.node_normals(body));
        let body = &self.backend.assembly().bodies[body];
        let of_vertex = |vertex| body.node_of_vertex(vertex).map_or([0.0, 1.0, 0.0], |node| of_nodes[node]);
        (0..body.vertices()).map(of_vertex).collect()
    }

    fn node_normals(&self, body: usize) -> Vec<[f32; 3]> {
        let body = &self.backend.assembly().bodies[body];
        let places = (0..body.nodes).map(|node| self.backend.position(body.solver_index(node)));
        let triangles = body.user_surface().triangles;
        match self.precision {
            Precision::F32 => {
                normals::normals(&places.map(|x| x.map(|c| c as f32)).collect::<Vec<_>>(), &triangles)
            }
            Precision::F64 => {
                let normals = normals::normals(&places.collect::<Vec<_>>(), &triangles);
                normals.into_iter().map(|n| n.map(|c| c as f32)).collect()
            }
        }
    }

    /// A body's vertices, faces and texture coordinates, as outputs need them.
    ///
    /// # Panics
    /// Where there is no body with this index.
    pub fn surface(&self, body: usize) -> Surface {
        self.backend.assembly().bodies[body].user_surface()
    }

    /// 64-bit hash (XXH64, seed 0) of little-endian positions then velocities of all nodes, in user order.
    pub fn state_hash(&self) -> u64 {
        let mut hasher = twox_hash::XxHash64::with_seed(0);
        self.state(&self.user_order(), |bytes| hasher.write(bytes));
        hasher.finish()
    }

    /// Little-endian positions then velocities of the nodes with solver indices `order`, piece by piece.
    fn state(&self, order: &[usize], mut sink: impl FnMut(&[u8])) {
        let mut bytes = Vec::new();
        for velocity in [false, true] {
            for nodes in order.chunks(4096) {
                bytes.clear();
                for &node in nodes {
                    self.backend.bytes(node, velocity, &mut bytes);
                }
                sink(&bytes);
            }
        }
    }

    /// Precision of the run.
    pub fn precision(&self) -> Precision {
        self.precision
    }

    /// Worker threads in use.
    pub fn threads(&self) -> usize {
        self.backend.threads()
    }

    /// The device in words: `cpu, 2 threads, avx512`.
    pub fn device(&self) -> String {
        self.backend.device().name
    }

    /// `cpu` or `gpu`.
    pub fn backend(&self) -> &'static str {
        self.backend.device().backend
    }

    /// Bytes of memory that state and springs take while running.
    pub fn memory(&self) -> usize {
        self.backend.memory()
    }

    /// What the user should know before running: a step that is too long.
    pub fn warnings(&self) -> &[String] {
        &self.warnings
    }
}

#[cfg_attr(not(feature = "gpu"), expect(unused_variables, reason = "only a boundary builds a scene twice"))]
fn backend(
    scene: &Scene,
    assembly: Assembly,
    threads: usize,
    options: &Options,
) -> Result<Box<dyn Backend>, String> {
    #[cfg(feature = "gpu")]
    if let Some(gpu) = &options.gpu {
        return match (options.precision, gpu.from) {
            (Precision::F64, _) => {
                Err("a GPU computes in 32 bits; --precision f32 or the CPU would do".to_owned())
            }
            (Precision::F32, Stage::Elements) => Ok(Box::new(features::on_gpu(gpu, assembly)?)),
            (Precision::F32, _) => {
                let again = Assembly::new(scene).map_err(|error| error.to_string())?;
                Ok(Box::new(features::at_boundary(gpu, [assembly, again])?))
            }
        };
    }
    Ok(match options.precision {
        Precision::F32 => Box::new(features::on_cpu::<f32>(assembly, threads)?),
        Precision::F64 => Box::new(features::on_cpu::<f64>(assembly, threads)?),
    })
}

fn finite(value: [f64; 3], what: &str) -> Result<(), SceneError> {
    if value.iter().all(|c| c.is_finite()) {
        return Ok(());
    }
    Err(SceneError::new("body", format!("{value:?} is not {what}: three finite numbers would do")))
}

/// Threads of this machine that gain something for a scene. A hinge costs as much as some nodes with their springs, a
/// constraint with the iterations about it as much as some more.
fn useful_threads(assembly: &Assembly) -> usize {
    let all = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let hinges: usize = assembly.bodies.iter().map(|body| body.hinges.len()).sum();
    all.min((assembly.places + 8 * hinges + 4 * assembly.constraints.len()) / 4096)
}
