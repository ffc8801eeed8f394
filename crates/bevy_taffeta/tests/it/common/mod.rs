//! Apps without a window.
#![allow(dead_code, reason = "each test file uses a part")]

use bevy::app::PluginsState;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_taffeta::prelude::*;
use bevy_taffeta::{DefaultWorld, Running};
use std::time::Duration;

/// Seconds from one frame of an app to the next: those of the default world.
pub const FRAME: f64 = 1.0 / 60.0;

/// An app without a renderer: bodies run on the CPU.
pub fn plain() -> App {
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), bevy::mesh::MeshPlugin));
    app.init_asset::<StandardMaterial>();
    clocked(app)
}

/// An app whose clock goes on by a frame in each update.
pub fn clocked(mut app: App) -> App {
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(FRAME)));
    app
}

/// Ready to be updated.
pub fn ready(app: &mut App) {
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    // The first update has no time before it.
    app.update();
}

pub fn run(app: &mut App, updates: usize) {
    (0..updates).for_each(|_| app.update());
}

/// The one world that runs.
pub fn running(app: &mut App) -> Mut<'_, Running> {
    let mut query = app.world_mut().query::<&mut Running>();
    query.single_mut(app.world_mut()).expect("one world")
}

pub fn positions(app: &mut App) -> Vec<Vec3> {
    let mut places: Vec<[f32; 3]> = Vec::new();
    running(app).simulation().positions_f32(&mut places);
    places.into_iter().map(Vec3::from).collect()
}

/// Sets a component of the default world.
pub fn set<C: Component>(app: &mut App, component: C) {
    let mut query = app.world_mut().query_filtered::<Entity, With<DefaultWorld>>();
    let world = query.single(app.world()).expect("the default world");
    app.world_mut().entity_mut(world).insert(component);
}

/// A sheet of 6 × 7 nodes that hangs in two corners.
pub fn sheet() -> impl Bundle {
    (
        Cloth::grid(6, 7, Vec2::new(0.6, 0.5)),
        SoftMaterial::new(Mass::Node(0.01)).structural(50.0, 0.02).shear(20.0, 0.02),
        Pins::hold(Select::nodes([0, 6])),
    )
}

/// An app with a sheet, and that.
pub fn with_sheet() -> (App, Entity) {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let sheet = app.world_mut().spawn(sheet()).id();
    ready(&mut app);
    (app, sheet)
}

pub fn messages<M: Message>(app: &App) -> Vec<&M> {
    app.world().resource::<Messages<M>>().iter_current_update_messages().collect()
}

/// Places of a body's mesh.
pub fn drawn(app: &App, body: Entity) -> Vec<Vec3> {
    let mesh = app.world().get::<Mesh3d>(body).expect("a mesh").0.clone();
    let mesh = app.world().resource::<Assets<Mesh>>().get(&mesh).expect("an asset");
    let places = mesh.attribute(Mesh::ATTRIBUTE_POSITION).and_then(|places| places.as_float3());
    places.expect("places").iter().map(|place| Vec3::from(*place)).collect()
}
