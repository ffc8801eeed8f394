//! What names resolve to, once: bodies, colliders and pins of one simulation.

use crate::assembly::body::BodyAssembly;
use crate::simulation::{InputError, Simulation};
use glam::DVec3;
use std::sync::atomic::{AtomicU64, Ordering};

/// Tells one simulation of this process from all others.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(crate) struct SimulationId(u64);

impl SimulationId {
    pub(crate) fn new() -> Self {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        Self(NEXT.fetch_add(1, Ordering::Relaxed))
    }
}

/// A body of a [`Simulation`]. The name resolves to it once; one of another simulation is refused.
///
/// ```
/// # use taffeta::scene::{Body, Collider, Mass, Mesh, Scene, Select};
/// # use taffeta::{Options, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05).pin(Select::nodes([0])))
/// #     .collider(Collider::sphere([0.0, -1.0, 0.0], 0.2).named("ball"));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let other = Simulation::new(&scene, &Options::default())?;
/// let cloth = simulation.body("cloth")?;
/// simulation.apply_force(cloth, 3, [0.0, 0.1, 0.0])?;
/// assert!(simulation.apply_force(other.body("cloth")?, 3, [0.0, 0.1, 0.0]).is_err());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct BodyHandle {
    of: SimulationId,
    index: u32,
}

/// A collider of a [`Simulation`].
///
/// ```
/// # use taffeta::scene::{Body, Collider, Mass, Mesh, Scene, Select};
/// # use taffeta::{Options, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05).pin(Select::nodes([0])))
/// #     .collider(Collider::sphere([0.0, -1.0, 0.0], 0.2).named("ball"));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// use taffeta::Pose;
/// use taffeta::glam::{DQuat, DVec3};
///
/// let ball = simulation.collider("ball")?;
/// simulation.move_collider(ball, Pose::new(DQuat::IDENTITY, 0.01 * DVec3::Y))?;
/// simulation.step()?;
/// assert_eq!(simulation.collider_pose(ball, 1.0)?.translation, 0.01 * DVec3::Y);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ColliderHandle {
    of: SimulationId,
    index: u32,
}

/// A pin of the scene: nodes of one body of a [`Simulation`] that are held together. One with a keyframe can be moved.
///
/// ```
/// use taffeta::glam::{DQuat, DVec3};
/// use taffeta::scene::{Body, Keyframe, Mass, Mesh, Scene, Select};
/// use taffeta::{Options, Pose, Simulation};
///
/// let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3]))
///     .with_mass(Mass::Area(0.2))
///     .structural(50.0, 0.05);
/// let cloth = cloth.pin_moving(Select::rows(0, 0), vec![Keyframe::default()]);
/// let scene = Scene::new("").time(0.01, 1e-3).body(cloth);
/// let mut simulation = Simulation::new(&scene, &Options::default())?;
/// let row = simulation.pin(simulation.body("cloth")?, 0)?;
/// simulation.move_pin(row, Pose::new(DQuat::from_rotation_y(0.1), DVec3::ZERO))?;
/// simulation.step()?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct PinHandle {
    body: BodyHandle,
    index: u32,
}

impl BodyHandle {
    pub(crate) fn new(of: SimulationId, index: usize) -> Self {
        Self { of, index: index as u32 }
    }

    /// Where the body stands in [`Simulation::bodies`], and in the scene.
    pub fn index(self) -> usize {
        self.index as usize
    }
}

impl ColliderHandle {
    pub(crate) fn new(of: SimulationId, index: usize) -> Self {
        Self { of, index: index as u32 }
    }

    /// Where the collider stands in [`Simulation::colliders`], and in the scene.
    pub fn index(self) -> usize {
        self.index as usize
    }
}

impl PinHandle {
    /// The body whose nodes it holds.
    pub fn body(self) -> BodyHandle {
        self.body
    }

    /// Where the pin stands among those of its body in the scene.
    pub fn index(self) -> usize {
        self.index as usize
    }
}

impl Simulation {
    /// The body of that name.
    ///
    /// # Errors
    /// Where there is none; the error names those there are.
    pub fn body(&self, name: &str) -> Result<BodyHandle, InputError> {
        let found = self.bodies.iter().find(|body| body.name == name);
        found.map(|body| body.handle).ok_or_else(|| InputError::NoBody {
            name: name.to_owned(),
            known: self.bodies.iter().map(|body| body.name.clone()).collect(),
        })
    }

    /// The collider of that name, the first where several have it.
    ///
    /// # Errors
    /// Where there is none; the error names those there are.
    pub fn collider(&self, name: &str) -> Result<ColliderHandle, InputError> {
        let found = self.colliders.iter().find(|collider| collider.name == name);
        found.map(|collider| collider.handle).ok_or_else(|| InputError::NoCollider {
            name: name.to_owned(),
            known: self.colliders.iter().map(|collider| collider.name.clone()).collect(),
        })
    }

    /// A pin of a body, by its place among the body's pins in the scene.
    ///
    /// # Errors
    /// Where the body has fewer pins, or is one of another simulation.
    pub fn pin(&self, body: BodyHandle, index: usize) -> Result<PinHandle, InputError> {
        let info = &self.bodies[self.index_of(body)?];
        if index >= info.pins {
            return Err(InputError::NoPin { body: info.name.clone(), pin: index, pins: info.pins });
        }
        Ok(PinHandle { body, index: index as u32 })
    }

    /// The force with which a pin holds its nodes in the last sub-step of the last frame [N], as
    /// [`PinReaction`](crate::diagnostics::PinReaction) has it. `None` at the start, and for pins that break.
    ///
    /// # Errors
    /// Where the pin is one of another simulation.
    pub fn reaction(&self, pin: PinHandle) -> Result<Option<DVec3>, InputError> {
        let body = self.index_of(pin.body())?;
        Ok(self.report.reaction(body, pin.index()).map(DVec3::from))
    }

    /// Vertices that a pin holds, and the force on each in the last sub-step of the last frame [N]: what
    /// [`Self::reaction`] is the sum of. Empty before a frame has run, and for pins that break.
    ///
    /// # Errors
    /// Where the pin is one of another simulation.
    pub fn vertex_reactions(&self, pin: PinHandle) -> Result<Vec<(usize, DVec3)>, InputError> {
        let (body, assembly) = (self.index_of(pin.body())?, self.backend.assembly());
        let forces = assembly.node_reactions((self.report.time, self.report.substeps), &self.held);
        let found = &assembly.bodies[body];
        let all = assembly.held_by(body, pin.index()).filter_map(|(node, index)| {
            Some((found.vertex_of_solver(node - found.first), DVec3::from(*forces.get(index)?)))
        });
        Ok(all.collect())
    }

    /// The index of a body of this simulation.
    pub(crate) fn index_of(&self, body: BodyHandle) -> Result<usize, InputError> {
        if body.of == self.id { Ok(body.index()) } else { Err(InputError::ForeignHandle) }
    }

    /// The index of a collider of this simulation.
    pub(crate) fn index_of_collider(&self, collider: ColliderHandle) -> Result<usize, InputError> {
        if collider.of == self.id { Ok(collider.index()) } else { Err(InputError::ForeignHandle) }
    }

    /// A body of this simulation, and the node of its vertex.
    pub(crate) fn node_of(
        &self,
        body: BodyHandle,
        vertex: usize,
    ) -> Result<(&BodyAssembly, usize), InputError> {
        let found = &self.backend.assembly().bodies[self.index_of(body)?];
        let (body, vertices) = (|| found.name.clone(), found.vertices());
        if vertex >= vertices {
            return Err(InputError::NoVertex { body: body(), vertex, vertices });
        }
        let node =
            found.node_of_vertex(vertex).ok_or_else(|| InputError::NotSimulated { body: body(), vertex })?;
        Ok((found, node))
    }
}
