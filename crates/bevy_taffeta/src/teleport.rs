//! What is put elsewhere at once.

use crate::pose::Rigid;
use crate::running::Running;
use bevy::ecs::system::Command;
use bevy::prelude::*;
use taffeta::InputError;

/// A command: carries a body along in the world at once, as `by`, a motion in the world without scale, has it. What carries its
/// pins is to be put there, too. Where that is impossible, as [`Running::teleport`] has it, a warning says why.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// fn back_to_the_top(mut commands: Commands, balls: Query<Entity, With<SoftBody>>) {
///     for body in &balls {
///         commands.queue(TeleportCloth { body, by: Transform::from_xyz(0.0, 5.0, 0.0) });
///     }
/// }
/// ```
#[derive(Clone, Copy, Debug)]
pub struct TeleportCloth {
    /// The body.
    pub body: Entity,
    /// The motion.
    pub by: Transform,
}

impl Command for TeleportCloth {
    type Out = ();

    fn apply(self, world: &mut World) {
        let mut all = world.query::<&mut Running>();
        let running = all.iter_mut(world).find(|running| running.body_of(self.body).is_some());
        let Some(mut running) = running else {
            warn!("taffeta: TeleportCloth: {} is no body of a world that runs", self.body);
            return;
        };
        running.teleport(self.body, self.by).unwrap_or_else(|error| warn!("taffeta: TeleportCloth: {error}"));
    }
}

impl Running {
    /// Carries a body along in the world at once, as `by`, a motion in the world without scale, has it: its velocities and its pins
    /// with it. What carries those is to be put there, too; where that jumps farther than
    /// [`Playback::teleport_beyond`](crate::Playback::teleport_beyond), this happens by itself.
    ///
    /// # Errors
    /// Where the entity is no body of this world, or as [`taffeta::Simulation::teleport_body`] has them.
    pub fn teleport(&mut self, body: Entity, by: Transform) -> Result<(), InputError> {
        let Some(index) = self.bodies.iter().position(|one| one.entity == body) else {
            let known = self.simulation.bodies().iter().map(|body| body.name.clone()).collect();
            return Err(InputError::NoBody { name: body.to_string(), known });
        };
        let motion = Rigid::of(&by.into());
        self.carry_along(index, &motion)?;
        self.bodies[index].carried.iter_mut().for_each(|one| one.track.expect(&motion));
        self.share = 1.0;
        Ok(())
    }

    /// Puts what follows entities that were put elsewhere there. Returns whether there was something.
    pub(crate) fn jump(&mut self) -> bool {
        let refused = |error: InputError| warn_once!("taffeta: {error}");
        let mut jumped = false;
        for (index, one) in self.colliders.iter_mut().enumerate() {
            let Some(motion) = one.track.take_jump() else { continue };
            let collider = self.simulation.colliders()[index].handle;
            let to = one.track.carried(&motion).pose();
            match self.simulation.teleport_collider(collider, to) {
                Ok(()) => {
                    one.track.carry(&motion);
                    jumped = true;
                }
                Err(error) => refused(error),
            }
        }
        for index in 0..self.bodies.len() {
            let carried = self.bodies[index].carried.iter_mut();
            let jumps: Vec<Rigid> = carried.filter_map(|one| one.track.take_jump()).collect();
            // Where carriers were put to places of their own, the pins of the others follow from there.
            if let Some(motion) = jumps.first() {
                match self.carry_along(index, motion) {
                    Ok(()) => jumped = true,
                    Err(error) => refused(error),
                }
            }
        }
        jumped
    }

    /// Carries a body along in the world, what is drawn of it, and what follows the carriers of its pins.
    fn carry_along(&mut self, index: usize, motion: &Rigid) -> Result<(), InputError> {
        let body = self.simulation.bodies()[index].handle;
        self.simulation.teleport_body(body, motion.pose())?;
        let first = self.bodies[index].first_vertex;
        let vertices = first..first + self.simulation.bodies()[index].vertices;
        for place in self.copied.iter_mut().filter_map(|all| all.get_mut(vertices.clone())).flatten() {
            *place = (motion.turn * Vec3::from(*place).as_dvec3() + motion.shift).as_vec3().to_array();
        }
        self.bodies[index].copied = None;
        self.bodies[index].carried.iter_mut().for_each(|one| one.track.carry(motion));
        Ok(())
    }
}
