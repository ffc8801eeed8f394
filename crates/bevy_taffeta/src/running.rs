//! A simulation that runs, and which entities its bodies and colliders are.

use crate::drawn::BodyMesh;
use crate::pose::Rigid;
use bevy::prelude::*;
use taffeta::Simulation;
use taffeta::View;

/// The simulation of a [`SoftWorld`](crate::SoftWorld). Remove it to start again from where bodies and colliders are.
#[derive(Component)]
pub struct Running {
    pub(crate) simulation: Simulation,
    pub(crate) bodies: Vec<RunningBody>,
    pub(crate) colliders: Vec<RunningCollider>,
    /// Time that has gone by and was not simulated yet [s].
    pub(crate) left: f64,
    /// Share of the way between the last two states that is drawn.
    pub(crate) share: f32,
    /// Frames since the last report.
    pub(crate) unreported: u32,
    /// Whether it cannot go on.
    pub(crate) halted: bool,
    /// Whether the device writes what is drawn.
    pub(crate) shared: bool,
    /// Where vertices were before the last frame and are now, where they are copied [m].
    pub(crate) copied: [Vec<[f32; 3]>; 2],
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

/// Pins that an entity carries.
#[derive(Clone, Copy)]
pub struct Carried {
    /// Which of the body's pins.
    pub pin: usize,
    pub by: Entity,
    /// Where the entity was when it took them.
    pub start: Rigid,
    /// Where it had brought them by the last frame.
    pub last: Rigid,
}

/// A collider of it.
pub struct RunningCollider {
    pub entity: Entity,
    /// Where the entity was when the simulation was built.
    pub start: Rigid,
    /// Where it was at the last frame.
    pub last: Rigid,
    /// Whether the scene moves it, and the entity follows.
    pub keyed: bool,
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

    /// Number of an entity's body in the simulation.
    pub fn body_of(&self, entity: Entity) -> Option<usize> {
        self.bodies.iter().position(|body| body.entity == entity)
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
