//! Cloth and soft bodies for Bevy, simulated by taffeta. On a GPU they are simulated on Bevy's own device, and what is drawn
//! is written there by a compute shader: the mesh never leaves it.
//!
//! ```no_run
//! use bevy::prelude::*;
//! use bevy_taffeta::prelude::*;
//!
//! fn main() {
//!     App::new().add_plugins((DefaultPlugins, TaffetaPlugin)).add_systems(Startup, flag).run();
//! }
//!
//! fn flag(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
//!     commands.spawn((
//!         Cloth::grid(20, 30, Vec2::new(1.5, 1.0)),
//!         SoftMaterial::new(Mass::Node(0.01)).structural(50.0, 0.02).shear(20.0, 0.02).bend(5.0, 0.02),
//!         Pins::hold(Select::nodes([0, 29])),
//!         MeshMaterial3d(materials.add(StandardMaterial { double_sided: true, cull_mode: None, ..default() })),
//!     ));
//!     commands.spawn((SoftCollider::sphere(0.3), Transform::from_xyz(0.0, -0.5, 0.0)));
//! }
//! ```
//!
//! Bodies and colliders under an entity with a [`SoftWorld`] are one simulation and can touch each other; all others belong
//! to the one that the plugin spawns ([`DefaultWorld`]). A world has its own gravity and air ([`Environment`]), pause and
//! speed ([`Playback`]) and device ([`RunOn`]). Bodies start where their transform is and move in the world from then on;
//! colliders, and pins that are carried by an entity, follow its transform.
//!
//! A component that changes is taken up while the world runs: gravity and wind at once, all else by building the simulation
//! again and going on from where bodies are. An entity that is despawned, or spawned, leaves or joins it likewise. Removing
//! [`Running`] starts a world again.
//!
//! A world takes steps of [`SoftWorld::time`], whatever Bevy's frames last. The last one ends at Bevy's clock or up to a step later, and
//! bodies are drawn between the last two, as they are at the clock. Entities that carry pins or are colliders are followed to where
//! they will be at the end of the step if they go on as they went: what they carry is drawn where they are, not behind them.
//! `Time<Virtual>` pauses and slows all worlds together. What goes wrong is said by the messages [`Frozen`], [`Diverged`]
//! and [`Refused`], in the engine's words; what they advise is data, and the log names the component to change.

mod advice;
mod body;
mod build;
mod collider;
mod copied;
mod device;
mod drawn;
mod mesh;
mod pose;
mod refused;
mod running;
mod scene;
mod shared;
mod step;
mod teleport;
mod track;
mod world;

pub use body::{BodyPlace, BodyVelocity, Cloth, Pinned, Pins, SoftBody, SoftMaterial};
pub use collider::{SoftCollider, collider_mesh};
pub use device::SharedGpu;
pub use mesh::FromMesh3d;
pub use running::{DrawnBody, Running, Timing};
pub use scene::{
    FromScene, SceneLoadError, SceneLoader, SceneMaterials, SoftScene, SoftSceneRoot, spawn_scene,
};
pub use step::{Diverged, Frozen, Refused};
pub use taffeta;
pub use taffeta::OnDivergence;
pub use taffeta_io;
pub use teleport::TeleportCloth;
pub use world::{DefaultWorld, DeviceChoice, DrawMethod, Environment, Playback, RunOn, SoftWorld};

use bevy::asset::AssetEventSystems;
use bevy::prelude::*;

/// What most programs need.
pub mod prelude {
    pub use crate::{
        Cloth, Diverged, Environment, FromMesh3d, Frozen, Pins, Playback, Refused, RunOn, SoftBody,
        SoftCollider, SoftMaterial, SoftScene, SoftSceneRoot, SoftWorld, TaffetaPlugin, TaffetaSystems,
        TeleportCloth,
    };
    pub use taffeta::scene::{Air, LayerMask, Layers, Mass, Select, Volume, VolumeForm};
}

/// Cloth and soft bodies. Needs Bevy's assets, meshes and transforms; without its renderer bodies run on the CPU.
///
/// ```
/// use bevy::mesh::MeshPlugin;
/// use bevy::prelude::*;
/// use bevy::time::TimeUpdateStrategy;
/// use bevy_taffeta::{Running, prelude::*};
/// use std::time::Duration;
///
/// // Without a window, on the CPU: half a second, in thirty frames after the first update.
/// let mut app = App::new();
/// app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), MeshPlugin, TaffetaPlugin))
///     .insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)));
/// let hung = (Cloth::grid(6, 7, Vec2::new(0.6, 0.5)), Pins::hold(Select::nodes([0, 6])));
/// app.world_mut().spawn(hung);
/// app.finish();
/// (0..=30).for_each(|_| app.update());
///
/// let running = app.world_mut().query::<&Running>().single(app.world())?;
/// assert_eq!(running.simulation().frame(), 30);
/// let mut places = Vec::new();
/// running.places(&mut places);
/// assert!(places[41].y < -0.3);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct TaffetaPlugin;

/// What the plugin does in each frame, in this order: scenes are spawned in [`PreUpdate`], all else follows the
/// propagation of transforms in [`PostUpdate`].
///
/// ```no_run
/// use bevy::prelude::*;
/// use bevy_taffeta::taffeta::glam::DVec3;
/// use bevy_taffeta::{Running, prelude::*};
///
/// /// Lifts the first vertex of all cloth by a newton.
/// fn lift(mut worlds: Query<&mut Running>, cloth: Query<Entity, With<Cloth>>) {
///     for mut running in &mut worlds {
///         for entity in &cloth {
///             let Some(body) = running.body_of(entity) else { continue };
///             if let Err(error) = running.simulation_mut().apply_force(body, 0, DVec3::Y) {
///                 warn!("{error}");
///             }
///         }
///     }
/// }
///
/// let between = lift.after(TaffetaSystems::Build).before(TaffetaSystems::Step);
/// App::new().add_plugins((DefaultPlugins, TaffetaPlugin)).add_systems(PostUpdate, between).run();
/// ```
#[derive(SystemSet, Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum TaffetaSystems {
    /// Scenes that were loaded become entities.
    Spawn,
    /// What was spawned, changed or despawned is taken up.
    Build,
    /// Colliders and pins are moved, and steps taken. Before it, forces may be applied by [`Running::simulation_mut`].
    Step,
    /// Bodies are drawn as they are now; on a shared device that happens when Bevy extracts what it renders.
    Draw,
}

impl Plugin for TaffetaPlugin {
    fn build(&self, app: &mut App) {
        use TaffetaSystems::{Build, Draw, Spawn, Step};
        app.init_asset::<SoftScene>()
            .add_message::<Diverged>()
            .add_message::<Frozen>()
            .add_message::<Refused>()
            .configure_sets(
                PostUpdate,
                // A mesh that is given to the renderer must be told of before it takes it.
                (Build, Step, Draw).chain().after(TransformSystems::Propagate).before(AssetEventSystems),
            )
            .add_systems(PreUpdate, scene::spawn_loaded.in_set(Spawn))
            .add_systems(PostUpdate, (mesh::make_bodies, build::build).chain().in_set(Build))
            .add_systems(PostUpdate, (step::step, step::show_colliders).chain().in_set(Step))
            .add_systems(PostUpdate, (drawn::aim, copied::draw, collider::show_shapes).chain().in_set(Draw));
        app.register_asset_loader(SceneLoader::of(app));
        app.world_mut().spawn((Name::new("soft world"), DefaultWorld, SoftWorld::default()));
    }

    fn finish(&self, app: &mut App) {
        shared::share_device(app);
    }
}
