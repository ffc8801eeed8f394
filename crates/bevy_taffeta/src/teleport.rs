//! What is put elsewhere at once.

use crate::pose::Rigid;
use crate::running::Running;
use crate::track::Track;
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
    /// Carries a body along in the world at once, as `by`, a motion in the world without scale, has it: its velocities and its pins,
    /// and bodies that are sewn to it. What carries those is to be put there, too; where that jumps farther than
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
        let sewn = self.sewn().into_iter().find(|sewn| sewn.contains(&index)).unwrap_or_default();
        let bodies: Vec<(usize, Rigid)> = sewn.into_iter().map(|index| (index, motion)).collect();
        self.put(&bodies, &[])?;
        for (index, _) in bodies {
            self.bodies[index].carried.iter_mut().for_each(|one| one.track.expect(&motion));
        }
        self.share = 1.0;
        Ok(())
    }

    /// Puts what follows entities that were put elsewhere there. Returns whether there was something.
    pub(crate) fn jump(&mut self) -> bool {
        let carried = self.bodies.iter().flat_map(|body| &body.carried).map(|one| &one.track);
        if !self.colliders.iter().map(|one| &one.track).chain(carried).any(Track::has_jumped) {
            return false;
        }
        let colliders = self.colliders.iter_mut().enumerate();
        let colliders: Vec<(usize, Rigid)> =
            colliders.filter_map(|(index, one)| Some((index, one.track.take_jump()?))).collect();
        let mut bodies: Vec<(usize, Rigid)> = Vec::new();
        for sewn in self.sewn() {
            let pins: usize = sewn.iter().map(|&index| self.scene.bodies[index].pins.len()).sum();
            let mut jumps = Vec::new();
            for &index in &sewn {
                let carried = self.bodies[index].carried.iter_mut();
                jumps.extend(carried.filter_map(|one| one.track.take_jump()));
            }
            // What is also held by something that has stayed is pulled.
            if jumps.len() == pins
                && let Some(&motion) = jumps.first()
            {
                bodies.extend(sewn.into_iter().map(|index| (index, motion)));
            }
        }
        if bodies.is_empty() && colliders.is_empty() {
            return false;
        }
        if self.put(&bodies, &colliders).is_err() {
            // One of them cannot be, as a pin of it follows keyframes: it goes there as it can, and the others at once.
            let each = bodies.iter().map(|one| (std::slice::from_ref(one), &[][..]));
            let each = each.chain(colliders.iter().map(|one| (&[][..], std::slice::from_ref(one))));
            for (body, collider) in each {
                self.put(body, collider).unwrap_or_else(|error| warn_once!("taffeta: {error}"));
            }
        }
        true
    }

    /// Carries bodies along, what is drawn of them, and what follows the carriers of their pins; and colliders.
    fn put(&mut self, bodies: &[(usize, Rigid)], colliders: &[(usize, Rigid)]) -> Result<(), InputError> {
        let simulation = &self.simulation;
        let of_body = |(index, motion): &(usize, Rigid)| (simulation.bodies()[*index].handle, motion.pose());
        let of_collider = |(index, motion): &(usize, Rigid)| {
            let to = self.colliders[*index].track.carried(motion);
            (simulation.colliders()[*index].handle, to.pose())
        };
        let handles: Vec<_> = bodies.iter().map(of_body).collect();
        let of_colliders: Vec<_> = colliders.iter().map(of_collider).collect();
        self.simulation.teleport(&handles, &of_colliders)?;
        for (index, motion) in colliders {
            self.colliders[*index].track.carry(motion);
        }
        for (index, motion) in bodies {
            self.bodies[*index].carried.iter_mut().for_each(|one| one.track.carry(motion));
            let is_frozen = self.simulation.frozen().iter().any(|one| one.body as usize == *index);
            if !is_frozen {
                self.carry_drawn(*index, motion);
            }
        }
        Ok(())
    }

    fn carry_drawn(&mut self, index: usize, motion: &Rigid) {
        let first = self.bodies[index].first_vertex;
        let vertices = first..first + self.simulation.bodies()[index].vertices;
        for place in self.copied.iter_mut().filter_map(|all| all.get_mut(vertices.clone())).flatten() {
            *place = (motion.turn * Vec3::from(*place).as_dvec3() + motion.shift).as_vec3().to_array();
        }
        self.bodies[index].copied = None;
    }

    /// Bodies that seams join, by index: each body is in one of the sets.
    fn sewn(&self) -> Vec<Vec<usize>> {
        let mut set_of: Vec<usize> = (0..self.bodies.len()).collect();
        for seam in &self.scene.seams {
            let ends = [&seam.from.body, &seam.to.body];
            let index = |name: &String| self.scene.bodies.iter().position(|body| body.name == *name);
            if let [Some(a), Some(b)] = ends.map(index) {
                let (kept, gone) = (set_of[a], set_of[b]);
                set_of.iter_mut().filter(|set| **set == gone).for_each(|set| *set = kept);
            }
        }
        let members = |set| set_of.iter().enumerate().filter(move |(_, of)| **of == set);
        let sets = (0..self.bodies.len()).map(|set| members(set).map(|(index, _)| index).collect());
        sets.filter(|members: &Vec<usize>| !members.is_empty()).collect()
    }
}
