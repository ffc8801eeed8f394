//! When time goes by: pause, single frames, slow motion, from the start again.

use crate::busy::Busy;
use crate::stage::{OnStage, StageRoot};
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta_io::program::advised;
use bevy_taffeta::{FromScene, Running};

/// Starts the scene again, with its values as they are.
#[derive(Message)]
pub struct Restart;

/// Puts all values back to those of the file, and starts again.
#[derive(Message)]
pub struct AsRead;

/// What the engine has to say.
#[derive(Resource, Default)]
pub struct Notices {
    /// Why the values cannot be simulated; what ran before runs on.
    pub refused: Option<String>,
    /// Why the simulation stands still.
    pub diverged: Option<String>,
    /// What became of the last thing that the user wanted.
    pub done: Option<Result<String, String>>,
}

/// Playing, by keys.
pub fn play(app: &mut App) {
    app.init_resource::<Notices>()
        .add_message::<Restart>()
        .add_message::<AsRead>()
        .add_systems(Update, (keys, put_back, restart).chain())
        .add_systems(PostUpdate, listen.after(TaffetaSystems::Step));
}

fn keys(
    keys: Res<ButtonInput<KeyCode>>,
    busy: Res<Busy>,
    mut worlds: Query<&mut Playback, With<StageRoot>>,
    mut restart: MessageWriter<Restart>,
) {
    if busy.keys {
        return;
    }
    for mut playback in &mut worlds {
        if keys.just_pressed(KeyCode::Space) {
            playback.paused = !playback.paused;
        }
        if keys.any_just_pressed([KeyCode::Period, KeyCode::KeyN]) {
            step(&mut playback);
        }
    }
    if keys.just_pressed(KeyCode::KeyR) {
        restart.write(Restart);
    }
}

/// Goes on by one frame and stands still.
pub fn step(playback: &mut Playback) {
    playback.single_frames = if playback.paused { playback.single_frames + 1 } else { 1 };
    playback.paused = true;
}

/// The values of the file again.
fn put_back(
    mut asked: MessageReader<AsRead>,
    mut restart: MessageWriter<Restart>,
    stage: Res<OnStage>,
    mut worlds: Query<(&mut SoftWorld, &mut Environment), With<StageRoot>>,
    mut materials: Query<(&FromScene, &mut SoftMaterial)>,
    mut colliders: Query<(&FromScene, &mut SoftCollider)>,
) {
    if asked.read().count() == 0 {
        return;
    }
    let scene = &stage.scene;
    for (mut world, mut environment) in &mut worlds {
        (world.time, world.solver) = (scene.time.clone(), scene.solver.clone());
        environment.0 = scene.world.clone();
    }
    for (from, mut material) in &mut materials {
        if let Some(read) = scene.bodies.get(from.0).and_then(SoftMaterial::of) {
            *material = read;
        }
    }
    for (from, mut collider) in &mut colliders {
        if let Some(read) = scene.colliders.get(from.0) {
            collider.0 = read.clone();
        }
    }
    restart.write(Restart);
}

/// From the start again: colliders that the scene moves go back too.
fn restart(
    mut commands: Commands,
    mut asked: MessageReader<Restart>,
    mut notices: ResMut<Notices>,
    worlds: Query<Entity, With<StageRoot>>,
    mut colliders: Query<&mut Transform, (With<SoftCollider>, With<FromScene>)>,
) {
    if asked.read().count() == 0 {
        return;
    }
    notices.diverged = None;
    for world in &worlds {
        commands.entity(world).remove::<Running>();
    }
    for mut transform in &mut colliders {
        *transform = Transform::IDENTITY;
    }
}

/// Takes up what the engine says. What could be built is not refused any more.
fn listen(
    mut notices: ResMut<Notices>,
    mut refused: MessageReader<Refused>,
    mut diverged: MessageReader<Diverged>,
    running: Query<&Running, With<StageRoot>>,
    mut built: Local<u64>,
) {
    let now = running.iter().map(Running::built).sum();
    if now != *built {
        *built = now;
        (notices.refused, notices.diverged) = (None, None);
    }
    if let Some(message) = refused.read().last() {
        notices.refused = Some(advised(&message.error, message.error.advice()));
    }
    if let Some(message) = diverged.read().last() {
        notices.diverged = Some(advised(&message.error, message.error.advice()));
    }
}
