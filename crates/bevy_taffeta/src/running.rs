//! A simulation that runs, and which entities its bodies and colliders are.

use crate::drawn::BodyMesh;
use crate::track::Track;
use bevy::prelude::*;
use taffeta::scene::Scene;
use taffeta::{BodyHandle, Simulation, View};
use taffeta_io::output::Drawn;

/// The simulation of a [`SoftWorld`](crate::SoftWorld). Remove it to start again from where bodies and colliders are.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{Running, prelude::*};
///
/// fn tell_height(worlds: Query<&Running>, cloth: Single<Entity, With<Cloth>>) {
///     for running in &worlds {
///         let mut places = Vec::new();
///         running.places(&mut places);
///         let body = running.body_of(*cloth).and_then(|body| running.drawn(body));
///         let Some(body) = body else { continue };
///         info!("frame {}: {} m", running.simulation().frame(), places[body.first_vertex].y);
///     }
/// }
///
/// fn start_again(mut commands: Commands, worlds: Query<Entity, With<Running>>) {
///     worlds.iter().for_each(|world| drop(commands.entity(world).remove::<Running>()));
/// }
/// ```
#[derive(Component)]
pub struct Running {
    pub(crate) simulation: Simulation,
    /// What it is of.
    pub(crate) scene: Scene,
    /// How often it was built.
    pub(crate) built: u64,
    pub(crate) timing: Timing,
    pub(crate) bodies: Vec<RunningBody>,
    pub(crate) colliders: Vec<RunningCollider>,
    /// Time by which it is ahead of Bevy's clock [s].
    pub(crate) ahead: f64,
    /// Share of the way between the last two states that is drawn.
    pub(crate) share: f32,
    /// Frames since the last report.
    pub(crate) unreported: u32,
    /// Frozen bodies of which a message was written, and since which frame.
    pub(crate) frozen: Vec<(u32, u32)>,
    /// Whether it cannot go on.
    pub(crate) halted: bool,
    /// Whether the device writes what is drawn.
    pub(crate) shared: bool,
    /// Where vertices were before the last frame and are now, where they are copied [m].
    pub(crate) copied: [Vec<[f32; 3]>; 2],
}

/// How long frames of a simulation take.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::Running;
///
/// fn tell_times(mut worlds: Query<&mut Running>) {
///     for mut running in &mut worlds {
///         running.time_stages(60);
///         info!("{:.2} ms a frame", 1e3 * running.timing().frame);
///         for (stage, seconds) in &running.timing().stages {
///             info!("{stage}: {:.2} ms", 1e3 * seconds);
///         }
///     }
/// }
/// ```
#[derive(Clone, Debug, Default)]
pub struct Timing {
    /// One frame, as the program waited for it [s]. Where the device is shared only frames with a report are waited for.
    pub frame: f64,
    /// Building the simulation as it is [s].
    pub build: f64,
    /// The stages of the last frame that was [timed](Running::time_stages) by name [s]; nothing where none was, or where the
    /// device cannot tell.
    pub stages: Vec<(&'static str, f64)>,
    /// One frame in so many is timed by stages; 0: none.
    pub(crate) every: u32,
}

/// A body of it.
pub struct RunningBody {
    pub entity: Entity,
    /// Its transform when it was spawned.
    pub start: GlobalTransform,
    pub mesh: BodyMesh,
    /// Number of its first vertex among those of all bodies.
    pub first_vertex: usize,
    /// How it is drawn now.
    pub view: View,
    /// The frame, and how it was drawn, that its mesh was copied for last.
    pub copied: Option<(u32, View)>,
    pub carried: Vec<Carried>,
}

impl RunningBody {
    /// For a simulation that is built again.
    pub fn again(&self) -> Self {
        let Self { entity, start, view, .. } = *self;
        let (mesh, carried) = (BodyMesh::default(), self.carried.clone());
        Self { entity, start, mesh, first_vertex: 0, view, copied: None, carried }
    }
}

/// How a body of a simulation is drawn.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{DrawnBody, Running};
///
/// /// Where the vertices of an entity's mesh are in the world [m].
/// fn vertices_of(running: &Running, entity: Entity) -> Vec<Vec3> {
///     let mut places = Vec::new();
///     running.places(&mut places);
///     let body = running.drawn_bodies().find(|body| body.entity == entity);
///     let place = |body: &DrawnBody, &vertex: &u32| places[body.first_vertex + vertex as usize];
///     body.iter().flat_map(|body| body.mesh.vertices.iter().map(|vertex| place(body, vertex))).collect()
/// }
/// ```
#[derive(Clone, Copy)]
#[non_exhaustive]
pub struct DrawnBody<'a> {
    /// The body in the simulation.
    pub handle: BodyHandle,
    /// The entity that is the body.
    pub entity: Entity,
    /// Which vertices of the body's mesh in the simulation are the vertices of the mesh that is drawn.
    pub mesh: &'a Drawn,
    /// Number of its first vertex among those of all bodies.
    pub first_vertex: usize,
}

/// Pins that an entity carries.
#[derive(Clone, Copy)]
pub struct Carried {
    /// Which of the body's pins.
    pub pin: usize,
    pub by: Entity,
    pub track: Track,
}

/// A collider of it.
pub struct RunningCollider {
    pub entity: Entity,
    pub track: Track,
    /// Whether the scene moves it, and the entity follows.
    pub keyed: bool,
    /// The frame, and the share of it, that its mesh was brought to last, where poses change its shape.
    pub shown: Option<(u32, f32)>,
}

impl Running {
    /// The simulation.
    pub fn simulation(&self) -> &Simulation {
        &self.simulation
    }

    /// The simulation, to apply forces or to move pins by vertex. Both need the state on the host, which on a GPU is read
    /// back for it.
    pub fn simulation_mut(&mut self) -> &mut Simulation {
        &mut self.simulation
    }

    /// The body that an entity is.
    pub fn body_of(&self, entity: Entity) -> Option<BodyHandle> {
        self.drawn_bodies().find(|body| body.entity == entity).map(|body| body.handle)
    }

    /// How a body is drawn; `None` for one of another simulation, as of this world before it was built again.
    pub fn drawn(&self, body: BodyHandle) -> Option<DrawnBody<'_>> {
        self.drawn_bodies().nth(body.index()).filter(|drawn| drawn.handle == body)
    }

    /// How all bodies are drawn, in the order of [`Simulation::bodies`].
    pub fn drawn_bodies(&self) -> impl Iterator<Item = DrawnBody<'_>> {
        self.simulation.bodies().iter().zip(&self.bodies).map(|(info, body)| DrawnBody {
            handle: info.handle,
            entity: body.entity,
            mesh: &body.mesh.drawn,
            first_vertex: body.first_vertex,
        })
    }

    /// The scene that the entities made up when it was built.
    pub fn scene(&self) -> &Scene {
        &self.scene
    }

    /// How often it was built: once, and again for every change that needs it.
    pub fn built(&self) -> u64 {
        self.built
    }

    /// Where the vertices of all bodies are drawn in the world [m]. Where the device is shared it is where they are after the
    /// last frame, and is read back.
    pub fn places(&self, out: &mut Vec<Vec3>) {
        out.clear();
        let [before, now] = &self.copied;
        if self.shared {
            self.simulation.positions_f32(out);
        } else {
            let between = |(a, b): (&[f32; 3], &[f32; 3])| Vec3::from(*a).lerp(Vec3::from(*b), self.share);
            out.extend(before.iter().zip(now).map(between));
        }
    }

    /// How long frames take.
    pub fn timing(&self) -> &Timing {
        &self.timing
    }

    /// Times the stages of one frame in so many; 0 ends it. Such a frame takes longer, and is waited for.
    pub fn time_stages(&mut self, every: u32) {
        self.timing.every = every;
    }

    /// Whether it cannot go on: it has diverged, or the device is lost.
    pub fn is_halted(&self) -> bool {
        self.halted
    }

    /// Whether bodies are drawn on the device on which they are simulated, without a copy.
    pub fn is_shared(&self) -> bool {
        self.shared
    }
}
