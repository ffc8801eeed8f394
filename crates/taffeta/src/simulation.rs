//! What a program holds: a scene that runs. Build it, step it, read positions, move pins, apply forces.

#[cfg(feature = "gpu")]
mod cost;
mod errors;
mod frames;
mod frozen;
mod handles;
mod info;
mod input;
mod intersections;
mod live;
mod options;
mod seen;
mod sleeping;
mod snapshot;
mod teleport;

#[cfg(feature = "gpu")]
pub use cost::GpuCost;
pub use errors::{BuildError, Diverged, StepError};
pub use frozen::{Frozen, OnDivergence};
pub use handles::{BodyHandle, ColliderHandle, PinHandle};
pub use info::{BodyInfo, ColliderInfo};
pub use input::InputError;
pub use intersections::Intersections;
pub use live::Pose;
pub use options::{Options, Precision};
pub use snapshot::{Changes, Snapshot};

#[cfg(feature = "gpu")]
use crate::advice::Refusal;
use crate::advice::{Advice, Warning};
use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::backend::{Backend, FrameInput, Lost};
use crate::contact::collider_mesh::surface::MeshSurface;
use crate::cpu::team::Team;
use crate::diagnostics::advice::StepLimit;
use crate::diagnostics::culprit::Culprit;
use crate::diagnostics::digits::too_coarse;
use crate::diagnostics::normals;
use crate::diagnostics::tension::Tension;
use crate::diagnostics::wind::weakened;
use crate::features;
use crate::report::{FrameReport, FrameSums, Squeezed};
use crate::scene::{LARGEST_LENGTH, Path, Scene, identity_hash};
#[cfg(feature = "gpu")]
use crate::step::Stage;
use crate::topology::Surface;
use crate::topology::random::SplitMix64;
use crate::volume::volume::Form;
use frozen::{Kept, Suspect};
use glam::DVec3;
use handles::SimulationId;
use sleeping::Sleeping;
use std::collections::BTreeSet;
use std::hash::Hasher;
use std::sync::OnceLock;

/// A scene that runs.
///
/// ```
/// use taffeta::glam::{DVec3, Vec3};
/// use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3]))
///     .with_mass(Mass::Area(0.2))
///     .structural(50.0, 0.05);
/// let scene = Scene::new("hangs").time(1.0 / 60.0, 1e-3).body(cloth.pin(Select::nodes([0])));
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// let cloth = simulation.body("cloth")?;
/// simulation.apply_force(cloth, 7, DVec3::Y)?;
/// let report = simulation.step()?;
/// assert!(report.max_stretch < 1.2);
/// let mut positions: Vec<Vec3> = Vec::new();
/// simulation.positions_f32(&mut positions);
/// assert_eq!(positions.len(), 20);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub struct Simulation {
    id: SimulationId,
    /// The scene, and its hash once a snapshot is taken or restored.
    scene: Scene,
    scene_hash: OnceLock<u64>,
    backend: Box<dyn Backend>,
    precision: Precision,
    bodies: Vec<BodyInfo>,
    colliders: Vec<ColliderInfo>,
    start: FrameReport,
    report: FrameReport,
    /// Forces on held nodes in the last frame [N].
    held: Vec<[f64; 3]>,
    limit: StepLimit,
    warnings: Vec<Warning>,
    input: FrameInput,
    /// Nodes that were moved by the user in the last frame and stand still from now on.
    moved: Vec<u32>,
    /// Nodes that were free and are pinned by the user.
    pinned: BTreeSet<u32>,
    /// Triangles of colliders, once somebody asks how far nodes are from them.
    surfaces: OnceLock<Vec<MeshSurface<f64>>>,
    /// Triangles of bodies and colliders, once somebody asks where they intersect.
    triangles: OnceLock<intersections::Triangles>,
    /// Why no frame runs before a snapshot is restored.
    halted: Option<StepError>,
    /// Frames that were submitted and not polled yet, and whether more than gravity drives the scene in them.
    submitted: (u32, bool),
    /// Bodies that diverged and stand still, and what others could go on from.
    on_divergence: OnDivergence,
    frozen: Vec<Frozen>,
    kept: Kept,
    sleeping: Sleeping,
}

impl Simulation {
    /// Checks and builds a scene.
    ///
    /// # Errors
    /// Names the place in the scene that cannot be simulated, or what it cannot run on, and what would do.
    pub fn new(scene: &Scene, options: &Options) -> Result<Self, BuildError> {
        let assembly = Assembly::new(scene)?;
        let id = SimulationId::new();
        let bodies = (0..assembly.bodies.len())
            .map(|i| BodyInfo::of(scene, &assembly, BodyHandle::new(id, i)))
            .collect();
        let colliders = (0..assembly.colliders().len())
            .map(|i| ColliderInfo::of(scene, &assembly, ColliderHandle::new(id, i)))
            .collect();
        let limit = StepLimit::new(&assembly, options.find_largest_steps);
        let of_body = |body: &BodyAssembly| {
            let said = body.warnings.iter().map(|warning| format!("body `{}`: {warning}", body.name));
            said.map(Warning::from).collect::<Vec<_>>()
        };
        let mut warnings: Vec<Warning> = assembly.bodies.iter().flat_map(of_body).collect();
        warnings.extend(assembly.attachments().warnings().map(Warning::from));
        warnings.extend(limit.warnings());
        warnings.extend(weakened(&assembly));
        if options.precision == Precision::F32 {
            warnings.extend(assembly.bodies.iter().filter_map(too_coarse).map(Warning::from));
        }
        let backend = backend(scene, assembly, options)?;
        let mut simulation = Self {
            id,
            scene: scene.clone(),
            scene_hash: OnceLock::new(),
            backend,
            precision: options.precision,
            bodies,
            colliders,
            start: FrameReport::default(),
            report: FrameReport::default(),
            held: Vec::new(),
            limit,
            warnings,
            input: FrameInput::default(),
            moved: Vec::new(),
            pinned: BTreeSet::new(),
            surfaces: OnceLock::new(),
            triangles: OnceLock::new(),
            halted: None,
            submitted: (0, false),
            on_divergence: options.on_divergence,
            frozen: Vec::new(),
            kept: Kept::default(),
            sleeping: Sleeping::default(),
        };
        simulation.sleeping = Sleeping::new(&simulation);
        simulation.measure().map_err(|Lost(why)| BuildError::Lost(why))?;
        Ok(simulation)
    }

    /// Runs one frame and reports it.
    ///
    /// # Errors
    /// A frame with a number that is not finite, or with a stretch that only a blow-up has, is not shown: the error
    /// names body, vertex, likely cause and what to change. The state stays that of the last good frame then, and every further
    /// frame has the same error until [`Self::restore`]. A GPU may be lost.
    pub fn step(&mut self) -> Result<&FrameReport, StepError> {
        self.advance(1)
    }

    /// Runs some frames and reports the last. On a GPU nothing waits between them, except where a frame may be repeated: with contact
    /// between triangles, and in implicit steps of many iterations.
    ///
    /// # Errors
    /// As [`Self::step`]; only the last frame is looked at, so the error says by which frame it was.
    pub fn advance(&mut self, frames: u32) -> Result<&FrameReport, StepError> {
        self.submit(frames)?;
        self.poll()
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
        let FrameSums {
            parts,
            all,
            elements,
            strain,
            volumes,
            pairs,
            intersections,
            blown_up: _,
            squeezed,
            solver,
            broken,
            held,
        } = sums;
        let strain = strain.map(|extremes| extremes.strain());
        let of_fabric = strain.map_or(0.0, |strain| 1.0 + strain.warp[1].max(strain.weft[1]));
        let max_stretch = all.max_stretch.max(of_fabric);
        let gravity = assembly.world.gravity;
        let time = f64::from(frame) * assembly.time.dt;
        let substeps = parts * assembly.time.substeps();
        FrameReport {
            frame,
            time,
            substeps,
            kinetic: 0.5 * all.m_v2,
            gravitational: -(0..3).map(|axis| gravity[axis] * all.m_x[axis]).sum::<f64>(),
            springs: all.springs,
            elements,
            momentum: all.momentum,
            angular_momentum: all.angular_momentum,
            max_stretch: if max_stretch > 0.0 { max_stretch } else { 1.0 },
            strain,
            contacts: all.contacts,
            volumes,
            volume_targets: assembly.volume_targets(time),
            pairs: pairs.pairs,
            nearest_pair: (pairs.pairs > 0).then_some(pairs.nearest),
            pair_searches: pairs.searches,
            intersections,
            squeezed: squeezed.map(|node| self.squeezed(node as usize, time)),
            solver,
            broken,
            reactions: assembly.reactions((time, substeps), &held),
            asleep: self.sleeping.count,
        }
    }

    /// A node that had no room, in words of the scene.
    fn squeezed(&self, node: usize, time: f64) -> Squeezed {
        let assembly = self.backend.assembly();
        let index = assembly.bodies.iter().rposition(|body| body.first <= node).unwrap_or_default();
        let body = &assembly.bodies[index];
        Squeezed {
            body: index,
            vertex: body.vertex_of_solver(node - body.first),
            colliders: self.nearest_colliders(node, time, 2),
        }
    }

    /// What failed in frames `first` to `frame`: the first of the suspects is named.
    fn diverged(&self, [first, frame]: [u32; 2], what: String, suspects: &[Suspect]) -> Diverged {
        let diverges =
            |body: &BodyAssembly| body.volume().is_some_and(|kept| Form::DIVERGING.contains(&kept.form));
        let cause = match self.backend.assembly().bodies.iter().find(|body| diverges(body)) {
            Some(body) => Warning::new(
                format!(
                    "Likely cause: the volume of body `{}` is kept as printed, where every step makes its error 4/3 times as \
                     large; the corrected form would do",
                    body.name
                ),
                [Advice::CorrectedVolume],
            ),
            None => self.limit.after(),
        };
        let Warning { message: mut cause, mut advice } = cause;
        if let Some(hint) = self.backend.failure_hint() {
            cause = format!("{cause}. {hint}");
            advice.extend(hint.advice);
        }
        let bodies = &self.backend.assembly().bodies;
        let named = suspects.first().map(|one| (bodies[one.body].name.clone(), one.vertex));
        let (body, vertex) = named.unwrap_or_default();
        Diverged { first, frame, body, vertex, what, cause, advice }
    }

    /// Report of the last frame; before the first step, of the start.
    pub fn report(&self) -> &FrameReport {
        &self.report
    }

    /// Number of frames done, those among them that were submitted and may still be running.
    pub fn frame(&self) -> u32 {
        self.report.frame + self.submitted.0
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
    pub fn seam_pair_counts(&self) -> Vec<usize> {
        let attachments = self.backend.assembly().attachments();
        let mut pairs = vec![0; attachments.seams];
        let materials = attachments.joints.iter().map(|row| row.material as usize);
        materials.filter(|&material| material < attachments.seams).for_each(|material| pairs[material] += 1);
        pairs
    }

    /// Largest stable step at rest [s] of what is explicit; infinite without springs. Where all springs are implicit it is that of
    /// other elements and drag, in the primal form of drag alone. With [`Options::find_largest_steps`], or where the scene's step is near
    /// to it, within a hundredth; else a stable step that is at least as long as the scene's.
    pub fn largest_stable_step(&self) -> f64 {
        self.limit.at_rest
    }

    /// Largest step [s] that is stable however springs are folded; at most [`Self::largest_stable_step`], and found as that is.
    pub fn largest_stable_step_folded(&self) -> f64 {
        self.limit.folded
    }

    /// The same in any flow of air [s]; `None` where air does not act on the body that sets the largest steps.
    pub fn largest_stable_step_in_air(&self) -> Option<f64> {
        self.limit.in_air
    }

    /// What sets [`Self::largest_stable_step_folded`], or that in air; `None` where nothing does, and where neither
    /// [`Options::find_largest_steps`] nor the scene's step asks for it.
    pub fn largest_step_culprit(&self) -> Option<&Culprit> {
        self.limit.culprit.as_ref()
    }

    /// Where implicit springs are pulled hardest by what hangs in them, as far as that can be told beforehand; `None` for
    /// explicit springs, for those solved for by nodes, and where nothing hangs from a pin.
    pub fn max_tension(&self) -> Option<&Tension> {
        self.limit.max_tension.as_ref()
    }

    /// Applies a force [N] to a vertex during the next frame. Several forces on one vertex add up. On a [frozen](Self::frozen) body it has
    /// no effect.
    ///
    /// # Errors
    /// Where the body has no such vertex or is one of another simulation, or `force` has a number beyond 10¹⁵ N.
    pub fn apply_force(
        &mut self,
        body: BodyHandle,
        vertex: usize,
        force: impl Into<DVec3>,
    ) -> Result<(), InputError> {
        let (found, node) = self.node_of(body, vertex)?;
        let (node, force) = (found.solver_index(node), force.into().to_array());
        Path::of("force").finite(&force)?;
        if self.is_frozen(body.index()) {
            return Ok(());
        }
        let forces = &mut self.input.forces;
        forces.insert(forces.partition_point(|&(other, _)| (other as usize) <= node), (node as u32, force));
        Ok(())
    }

    /// Moves every free node by up to `amplitude` [m] along each axis, at random but the same for the same `seed`. An amplitude that is
    /// no number moves none, and one beyond 10⁶ m moves them so far.
    pub fn disturb(&mut self, amplitude: f64, seed: u64) {
        // Frames under way are looked at first: what has blown up is no start. It says so in the next step.
        let _ = self.poll();
        self.rouse_all();
        let amplitude =
            if amplitude.is_nan() { 0.0 } else { amplitude.clamp(-LARGEST_LENGTH, LARGEST_LENGTH) };
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
        self.sleeping.count = self.sleeping.rest.asleep.len() as u32;
        self.backend.measure()?;
        let sums = self.backend.sums()?;
        self.held.clone_from(&sums.held);
        // What touched colliders did so in a frame before.
        self.report = FrameReport { contacts: 0, ..self.report_of(sums, self.frame()) };
        self.submitted = (0, false);
        self.sleeping.idle = 0;
        self.start = self.report.clone();
        self.mark_good();
        Ok(())
    }

    fn scene_hash(&self) -> u64 {
        *self.scene_hash.get_or_init(|| identity_hash(&self.scene))
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

    /// Positions of all vertices [m], bodies one after the other, in the meshes' own order: `[f32; 3]`, [`glam::Vec3`] or what
    /// else is made of them. `out` is cleared first.
    pub fn positions_f32<V: From<[f32; 3]>>(&self, out: &mut Vec<V>) {
        out.clear();
        self.vertex_positions(|x| out.push(x.map(|c| c as f32).into()));
    }

    /// As [`Self::positions_f32`], in 64 bits.
    pub fn positions_f64<V: From<[f64; 3]>>(&self, out: &mut Vec<V>) {
        out.clear();
        self.vertex_positions(|x| out.push(x.into()));
    }

    /// Unit normals of a body's vertices, area-weighted.
    ///
    /// # Errors
    /// Where the body is one of another simulation.
    pub fn normals<V: From<[f32; 3]>>(&self, body: BodyHandle) -> Result<Vec<V>, InputError> {
        let body = self.index_of(body)?;
        let of_nodes = self.backend.normals(body).unwrap_or_else(|| self.node_normals(body));
        let body = &self.backend.assembly().bodies[body];
        let of_vertex = |vertex| body.node_of_vertex(vertex).map_or([0.0, 1.0, 0.0], |node| of_nodes[node]);
        Ok((0..body.vertices()).map(|vertex| of_vertex(vertex).into()).collect())
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
    /// # Errors
    /// Where the body is one of another simulation.
    pub fn surface(&self, body: BodyHandle) -> Result<Surface, InputError> {
        Ok(self.backend.assembly().bodies[self.index_of(body)?].user_surface())
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

    /// Worker threads. Fewer of them work while other programs need the cores.
    pub fn threads(&self) -> usize {
        self.backend.threads()
    }

    /// Has at most `most` threads work from now on: at least one, and never more than at the start. No result depends on it. On a
    /// GPU it does nothing.
    ///
    /// ```
    /// # use taffeta::{Options, Simulation, scene::{Body, Mass, Mesh, Scene}};
    /// # let cloth = Body::cloth("cloth", Mesh::grid(4, 4, [1.0, 1.0])).with_mass(Mass::Node(0.1)).structural(9.0, 0.1);
    /// # let mut simulation = Simulation::new(&Scene::new("").body(cloth), &Options::default()).unwrap();
    /// // While a level loads, the game needs its cores itself.
    /// simulation.limit_threads(1);
    /// simulation.step().unwrap();
    /// simulation.limit_threads(simulation.threads());
    /// ```
    pub fn limit_threads(&mut self, most: usize) {
        self.backend.limit_threads(most);
    }

    /// The device in words: `cpu, 2 threads, avx512`.
    pub fn device(&self) -> String {
        self.backend.device().name
    }

    /// `cpu` or `gpu`.
    pub fn backend(&self) -> &'static str {
        self.backend.device().backend
    }

    /// Bytes of memory that state, springs and lists of contacts take now.
    pub fn memory(&self) -> usize {
        self.backend.memory()
    }

    /// What the user should know before running: a step that is too long.
    pub fn warnings(&self) -> &[Warning] {
        &self.warnings
    }
}

#[cfg_attr(not(feature = "gpu"), expect(unused_variables, reason = "only a boundary builds a scene twice"))]
fn backend(scene: &Scene, assembly: Assembly, options: &Options) -> Result<Box<dyn Backend>, BuildError> {
    #[cfg(feature = "gpu")]
    if let Some(gpu) = &options.gpu {
        return match (options.precision, gpu.from) {
            (Precision::F64, _) => {
                let message = "a GPU computes in 32 bits; those or the CPU would do";
                Err(Refusal::new(message, [Advice::SinglePrecision, Advice::Cpu]).into())
            }
            (Precision::F32, Stage::Elements) => Ok(Box::new(features::on_gpu(gpu, assembly)?)),
            (Precision::F32, _) => {
                Ok(Box::new(features::at_boundary(gpu, [assembly, Assembly::new(scene)?])?))
            }
        };
    }
    let threads = options.threads.unwrap_or_else(|| useful_threads(&assembly)).max(1);
    let team = match &options.pool {
        Some(pool) => Team::of(pool.clone(), threads),
        None => Team::new(threads),
    };
    Ok(match options.precision {
        Precision::F32 => Box::new(features::on_cpu::<f32>(assembly, team)?),
        Precision::F64 => Box::new(features::on_cpu::<f64>(assembly, team)?),
    })
}

/// Threads of this machine that gain something for a scene. An element costs as much as some nodes with their springs, a
/// constraint with the iterations about it, or a triangle with its contacts, as much as some more.
fn useful_threads(assembly: &Assembly) -> usize {
    let all = std::thread::available_parallelism().map_or(1, std::num::NonZero::get);
    let elements: usize = assembly.elements().iter().map(|list| list.kind.cost * list.len()).sum();
    let surfaces = assembly.surfaces().map_or(0, |surfaces| 8 * surfaces.triangles.len());
    all.min((assembly.places + elements + surfaces + 4 * assembly.constraints().len()) / 4096)
}
