//! Time goes by: colliders and pins are moved, steps are taken, and what goes wrong is said.

use crate::advice::hint;
use crate::pose::Rigid;
use crate::running::Running;
use crate::track::Far;
use crate::world::{Playback, RunOn};
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use std::time::Instant;
use taffeta::{BuildError, InputError, StepError};

/// A world cannot go on: the device is lost, or a body has diverged and [`RunOn::on_divergence`] is to stop, or freezing bodies has
/// not helped. What was drawn last stays. To start again, remove [`Running`].
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::{Running, prelude::*};
///
/// fn start_again(mut commands: Commands, mut messages: MessageReader<Diverged>) {
///     for Diverged { world, body, error } in messages.read() {
///         warn!("{body:?}: {error}");
///         commands.entity(*world).remove::<Running>();
///     }
/// }
/// ```
#[derive(Message, Clone, Debug)]
pub struct Diverged {
    /// The world.
    pub world: Entity,
    /// The body that the error names.
    pub body: Option<Entity>,
    /// What was seen, the likely cause, and what to change.
    pub error: StepError,
}

/// A body has diverged, and stands still from now on while the others of its world go on. Where the world is built again, as for a
/// component that changes or a body that is spawned, it goes on from where it is, and where [`Running`] is removed, from its start.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// /// What has diverged is no longer there.
/// fn remove(mut commands: Commands, mut messages: MessageReader<Frozen>) {
///     for Frozen { body, why, .. } in messages.read() {
///         warn!("{why}");
///         commands.entity(*body).despawn();
///     }
/// }
/// ```
#[derive(Message, Clone, Debug)]
pub struct Frozen {
    /// The world.
    pub world: Entity,
    /// The body.
    pub body: Entity,
    /// What was seen of it, the likely cause, and what to change.
    pub why: taffeta::Diverged,
}

/// A world cannot be simulated as it is, or not with one of its bodies or colliders. That one alone is left out, or goes on as it was,
/// and is tried again whenever the world is built. Where the error is about none of them, as about a seam, the world is not built: if it
/// ran before, it runs on as it was. The same is not said twice in a row.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::prelude::*;
///
/// fn tell(mut messages: MessageReader<Refused>, names: Query<NameOrEntity>) {
///     for Refused { world, entity, error, .. } in messages.read() {
///         let whose = names.get(entity.unwrap_or(*world));
///         warn!("{}: {error}", whose.map_or_else(|_| "despawned".to_owned(), |name| name.to_string()));
///     }
/// }
/// # let mut app = App::new();
/// # app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), TaffetaPlugin));
/// # app.finish();
///
/// // No node has a negative mass.
/// app.world_mut().spawn((Cloth::grid(6, 7, Vec2::ONE), SoftMaterial::new(Mass::Node(-0.01))));
/// app.add_systems(Last, tell);
/// app.update();
/// assert_eq!(app.world().resource::<Messages<Refused>>().len(), 1);
/// ```
#[derive(Message, Clone, Debug)]
pub struct Refused {
    /// The world.
    pub world: Entity,
    /// The body or collider that cannot be; without one it is the world.
    pub entity: Option<Entity>,
    /// What cannot be, by its place in the scene that the entities make up, and what would do.
    pub error: BuildError,
}

/// A clock may be as much early, as a share of a frame: durations are rounded.
const EARLY: f64 = 1e-3;

/// Takes as many frames as time has gone by.
pub fn step(
    time: Res<Time>,
    mut worlds: Query<(Entity, &mut Playback, &RunOn, &mut Running)>,
    transforms: Query<&GlobalTransform>,
    mut messages: DivergenceMessages,
) {
    for (world, mut playback, on, mut running) in &mut worlds {
        if running.halted {
            continue;
        }
        let seconds = time.delta_secs_f64() * if playback.paused { 0.0 } else { playback.speed.max(0.0) };
        let (frames, left_out) = running.due(&mut playback, seconds);
        let taken = f64::from(frames) * running.simulation.dt();
        let far = Far { beyond: playback.teleport_beyond, taken: left_out.then_some(taken) };
        running.look(if playback.paused { taken } else { seconds }, &transforms, far);
        if running.jump() && running.shared && frames == 0 {
            // The state before it is that of elsewhere.
            running.share = 1.0;
        }
        let taken = running.take(frames, on);
        messages.write(world, &mut running, taken);
    }
}

/// Messages of bodies and worlds that have diverged.
#[derive(SystemParam)]
pub struct DivergenceMessages<'w> {
    diverged: MessageWriter<'w, Diverged>,
    frozen: MessageWriter<'w, Frozen>,
}

impl DivergenceMessages<'_> {
    /// Writes what has become of a world in the frames that it has taken.
    pub fn write(&mut self, world: Entity, running: &mut Running, taken: Result<(), StepError>) {
        for (body, why) in running.newly_frozen() {
            warn!("taffeta: {why}{}; it stands still from now on", hint(&why.advice));
            self.frozen.write(Frozen { world, body, why });
        }
        if let Err(error) = taken
            && !running.halted
        {
            error!("taffeta: {error}{}", hint(error.advice()));
            running.halted = true;
            let body = running.named_in(&error);
            self.diverged.write(Diverged { world, body, error });
        }
    }
}

impl Running {
    /// Sees where the entities are that colliders and pins follow, `seconds` of its time after it was asked last. What is despawned
    /// stands where it was.
    fn look(&mut self, seconds: f64, transforms: &Query<&GlobalTransform>, far: Far) {
        let colliders = self.colliders.iter_mut().filter(|one| !one.keyed);
        let colliders = colliders.map(|one| (one.entity, &mut one.track));
        let carried = self.bodies.iter_mut().flat_map(|body| &mut body.carried);
        for (entity, track) in colliders.chain(carried.map(|one| (one.by, &mut one.track))) {
            if let Ok(transform) = transforms.get(entity) {
                track.see(Rigid::of(transform), seconds, far);
            }
        }
    }

    /// The number of frames that are due after `seconds` more, and whether there are too many, so that time is left out. The last one
    /// ends at Bevy's clock or later, so that nothing is drawn that is older than the clock.
    fn due(&mut self, playback: &mut Playback, seconds: f64) -> (u32, bool) {
        if playback.paused {
            let frames = playback.single_frames.min(playback.most_frames.max(1));
            if frames > 0 {
                playback.single_frames -= frames;
                // A single frame is to be seen whole.
                (self.ahead, self.share) = (0.0, 1.0);
            }
            return (frames, false);
        }
        let dt = self.simulation.dt();
        self.ahead -= seconds;
        let due = (-self.ahead / dt - EARLY).ceil().max(0.0);
        let frames = due.min(f64::from(playback.most_frames));
        self.ahead = if frames < due { 0.0 } else { self.ahead + due * dt };
        self.share = (1.0 - self.ahead / dt).clamp(0.0, 1.0) as f32;
        (frames as u32, frames < due)
    }

    /// Takes some frames, through which colliders and pins go evenly to where their entities will be at the end.
    fn take(&mut self, frames: u32, on: &RunOn) -> Result<(), StepError> {
        for frame in 0..frames {
            self.follow(1.0 / f64::from(frames - frame));
            self.one_frame(on)?;
            if !self.shared && frame + 2 >= frames {
                self.simulation.fetch()?;
                self.copied.swap(0, 1);
                self.simulation.positions_f32(&mut self.copied[1]);
            }
        }
        Ok(())
    }

    /// Takes a frame, and asks what became of it where that is due.
    fn one_frame(&mut self, on: &RunOn) -> Result<(), StepError> {
        let clock = Instant::now();
        let is_timed = self.timing.every > 0 && self.simulation.frame().is_multiple_of(self.timing.every);
        if is_timed {
            self.timing.stages = self.simulation.step_timed()?;
            self.unreported = 0;
            return Ok(());
        }
        self.simulation.submit(1)?;
        self.unreported += 1;
        if !self.shared || self.unreported >= on.report_every {
            self.simulation.poll()?;
            self.timing.frame = clock.elapsed().as_secs_f64() / f64::from(self.unreported);
            self.unreported = 0;
        }
        Ok(())
    }

    /// Sends colliders and pins a share of the way that is left to their entities.
    fn follow(&mut self, share: f64) {
        let (ahead, simulation) = (self.ahead, &mut self.simulation);
        let refused = |error: InputError| warn_once!("taffeta: {error}");
        for (index, one) in self.colliders.iter_mut().enumerate().filter(|(_, one)| !one.keyed) {
            if let Some(way) = one.track.follow(share, ahead) {
                let collider = simulation.colliders()[index].handle;
                simulation.move_collider(collider, way.pose()).unwrap_or_else(refused);
            }
        }
        for (index, running) in self.bodies.iter_mut().enumerate() {
            let body = simulation.bodies()[index].handle;
            for one in &mut running.carried {
                if let Some(way) = one.track.follow(share, ahead) {
                    let pin = simulation.pin(body, one.pin);
                    pin.and_then(|pin| simulation.move_pin(pin, way.pose())).unwrap_or_else(refused);
                }
            }
        }
    }

    /// Bodies that have been frozen since it was last asked.
    fn newly_frozen(&mut self) -> Vec<(Entity, taffeta::Diverged)> {
        let all = self.simulation.frozen();
        let since = |one: &taffeta::Frozen| (one.body, one.why.first);
        let new = all.iter().filter(|one| !self.frozen.contains(&since(one)));
        let new = new.map(|one| (self.bodies[one.body as usize].entity, one.why.clone())).collect();
        self.frozen = all.iter().map(since).collect();
        new
    }

    /// The body that an error names.
    fn named_in(&self, error: &StepError) -> Option<Entity> {
        let StepError::Diverged(diverged) = error else { return None };
        let index = self.simulation.bodies().iter().position(|body| body.name == diverged.body)?;
        Some(self.bodies[index].entity)
    }
}

/// Brings the entities of colliders that the scene moves to where these are drawn now.
pub fn show_colliders(
    worlds: Query<&Running>,
    mut transforms: Query<(&mut Transform, &mut GlobalTransform, Option<&ChildOf>)>,
) {
    for running in &worlds {
        for (index, one) in running.colliders.iter().enumerate().filter(|(_, one)| one.keyed) {
            let collider = running.simulation.colliders()[index].handle;
            let pose = running.simulation.collider_pose(collider, f64::from(running.share));
            let Ok(pose) = pose.map(Rigid::of_motion) else { continue };
            let parent = transforms.get(one.entity).ok().and_then(|(.., parent)| parent.map(ChildOf::parent));
            let parent = parent.and_then(|parent| transforms.get(parent).ok().map(|(_, global, _)| *global));
            let Ok((mut local, mut global, _)) = transforms.get_mut(one.entity) else { continue };
            let moved = pose.after(&one.track.start).transform(global.to_scale_rotation_translation().0);
            let now = GlobalTransform::from(moved);
            if *global != now {
                *global = now;
                *local = parent.map_or(moved, |parent| now.reparented_to(&parent));
            }
        }
    }
}
