//! A scene on stage: what both a window and a film show.

use crate::args::Args;
use crate::framing::{Extent, FIELD};
use crate::{say, scenery};
use bevy::camera::{PerspectiveProjection, RenderTarget};
use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::light::{CascadeShadowConfig, CascadeShadowConfigBuilder, DirectionalLightShadowMap};
use bevy::prelude::*;
use bevy::render::RenderPlugin;
use bevy::render::settings::WgpuSettings;
use bevy_taffeta::taffeta::scene::Scene;
use bevy_taffeta::taffeta::taffeta_gpu::{Choice, Gpu};
use bevy_taffeta::taffeta::{Options, Simulation};
use bevy_taffeta::taffeta_io::program::{Failure, advised, not_built};
use bevy_taffeta::taffeta_io::{Loaded, load_scene};
use bevy_taffeta::{OnDivergence, Playback, RunOn, TaffetaPlugin, spawn_scene};
use std::f32::consts::TAU;

/// A scene that was read and found right.
pub struct Opened {
    /// The scene.
    pub loaded: Loaded,
    /// How large it is.
    pub extent: Extent,
}

/// Reads the scene, and says what there is to say of it.
pub fn open(args: &Args) -> Result<Opened, Failure> {
    let loaded = load_scene(&args.scene, &args.sets)?;
    let threads = args.threads.map(usize::from);
    let simulation = Simulation::new(&loaded.scene, &Options { threads, ..default() })
        .map_err(|error| not_built(&loaded.source, &error))?;
    say(if loaded.scene.title.is_empty() { "untitled scene" } else { &loaded.scene.title });
    loaded.notes.iter().for_each(|note| say(&format!("note: {note}")));
    for warning in simulation.warnings() {
        say(&format!("warning: {}", advised(warning, &warning.advice)));
    }
    let extent = Extent::of(&loaded.scene, &simulation);
    Ok(Opened { loaded, extent })
}

/// When pipelines are made.
#[derive(Clone, Copy, PartialEq, Eq)]
pub enum Pipelines {
    /// While frames are drawn without what lacks one: a window answers at once.
    Meanwhile,
    /// Before the frame that needs them is drawn: where nobody looks, frames that lack something are work for nothing.
    First,
}

/// Bevy's renderer on the adapter that `TAFFETA_ADAPTER` asks for, else on the best.
pub fn renderer(pipelines: Pipelines) -> Result<RenderPlugin, Failure> {
    // Bevy would panic where there is none.
    let gpu = Gpu::open(&Choice::from_env()).map_err(|error| Failure::Input(error.to_string()))?;
    let settings = WgpuSettings { adapter_name: Some(gpu.info().name.clone()), ..default() };
    let synchronous_pipeline_compilation = pipelines == Pipelines::First;
    Ok(RenderPlugin { render_creation: settings.into(), synchronous_pipeline_compilation, ..default() })
}

/// The scene, light and a camera that sees it. The plugin of the engine comes with it.
pub struct StagePlugin {
    /// The scene.
    pub scene: Scene,
    /// How large it is.
    pub extent: Extent,
    /// What it is computed on.
    pub on: RunOn,
    /// When it runs.
    pub playback: Playback,
    /// Where the camera is.
    pub camera: Transform,
    /// What it draws to.
    pub target: RenderTarget,
}

impl StagePlugin {
    /// The stage as the command line has it, drawn to `target`.
    pub fn new(args: &Args, opened: &Opened, target: RenderTarget) -> Self {
        let [width, height] = args.size.map(|side| side as f32);
        let on = RunOn {
            device: args.backend.device(),
            threads: args.threads.map(usize::from),
            // As the command line does.
            on_divergence: OnDivergence::Stop,
            ..default()
        };
        Self {
            scene: opened.loaded.scene.clone(),
            extent: opened.extent.clone(),
            on,
            playback: Playback::default(),
            camera: opened.extent.camera(width / height, args.eye, args.at),
            target,
        }
    }
}

/// The world of the scene: its bodies and colliders are below it.
#[derive(Component)]
pub struct StageRoot;

/// The camera.
#[derive(Component)]
pub struct StageCamera;

/// A light that casts shadows.
#[derive(Component)]
struct Sun;

/// The scene that is on stage.
#[derive(Resource)]
pub struct OnStage {
    /// As it was read.
    pub scene: Scene,
    on: RunOn,
    playback: Playback,
    camera: Transform,
    target: RenderTarget,
}

impl Plugin for StagePlugin {
    fn build(&self, app: &mut App) {
        app.add_plugins(TaffetaPlugin)
            .insert_resource(ClearColor(scenery::BACKGROUND))
            .insert_resource(DirectionalLightShadowMap { size: SHADOW })
            .insert_resource(GlobalAmbientLight { brightness: AMBIENT, color: SKY, ..default() })
            .insert_resource(self.extent.clone())
            .insert_resource(OnStage {
                scene: self.scene.clone(),
                on: self.on,
                playback: self.playback,
                camera: self.camera,
                target: self.target.clone(),
            })
            .add_systems(Startup, (set_up, light))
            .add_systems(PreUpdate, scenery::lay_floors)
            .add_systems(Update, fit_shadows);
    }
}

/// Spawns the scene, and a camera that sees it.
fn set_up(
    mut commands: Commands,
    stage: Res<OnStage>,
    extent: Res<Extent>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let root = commands.spawn((Name::new("scene"), StageRoot)).id();
    let drawn = scenery::materials(&stage.scene, &mut materials);
    spawn_scene(&mut commands, root, &stage.scene, &drawn, &mut meshes);
    commands.entity(root).insert((stage.on, stage.playback));
    let far = stage.camera.translation.distance(extent.middle) + 20.0 * extent.radius;
    commands.spawn((
        StageCamera,
        Camera3d::default(),
        stage.target.clone(),
        Tonemapping::None,
        Msaa::Sample4,
        Projection::Perspective(PerspectiveProjection {
            fov: FIELD,
            near: 0.01 * extent.radius,
            far,
            ..default()
        }),
        stage.camera,
    ));
}

/// Side of a shadow map [pixel].
const SHADOW: usize = 2048;
/// Light from everywhere [cd/m²].
const AMBIENT: f32 = 480.0;
const SKY: Color = Color::srgb(0.93, 0.96, 1.0);
/// Light of the sun, and of what lightens its shadows [lux].
const SUN: f32 = 3000.0;
const FILL: f32 = 500.0;
/// The sun is so many lights in a ring of this angle [rad]: shadows get softer away from what casts them.
const SUNS: u8 = 4;
const SUN_RADIUS: f32 = 0.018;
/// How far from the scene's middle shadows are drawn, by its radius.
const SHADOWED: f32 = 1.6;

/// A sun over the shoulder of the camera, and a weak light from the other side.
fn light(mut commands: Commands, stage: Res<OnStage>) {
    let forward = stage.camera.forward().as_vec3();
    let back = -Vec3::new(forward.x, 0.0, forward.z).normalize_or(Vec3::NEG_Z);
    let right = Vec3::Y.cross(back);
    let from = |side: f32, up: f32, behind: f32| {
        Transform::from_translation(side * right + up * Vec3::Y + behind * back)
            .looking_at(Vec3::ZERO, Vec3::Y)
    };
    let sun = DirectionalLight {
        illuminance: SUN / f32::from(SUNS),
        color: Color::srgb(1.0, 0.97, 0.93),
        shadow_maps_enabled: true,
        ..default()
    };
    let middle = from(-0.6, 0.8, 0.7);
    for number in 0..SUNS {
        let angle = TAU * (f32::from(number) + 0.25) / f32::from(SUNS);
        let aside = SUN_RADIUS * Vec2::from_angle(angle);
        let turn = Quat::from_rotation_y(aside.x) * Quat::from_rotation_x(aside.y);
        commands.spawn((Sun, sun, Transform::from_rotation(middle.rotation * turn)));
    }
    let fill = DirectionalLight { illuminance: FILL, color: SKY, ..default() };
    commands.spawn((fill, from(0.9, 0.35, 0.6)));
}

/// Spends the shadow maps on the scene, from wherever it is seen.
fn fit_shadows(
    camera: Single<&Transform, With<StageCamera>>,
    mut suns: Query<&mut CascadeShadowConfig, With<Sun>>,
    extent: Res<Extent>,
) {
    let (distance, reach) = (camera.translation.distance(extent.middle), SHADOWED * extent.radius);
    for mut sun in &mut suns {
        *sun = CascadeShadowConfigBuilder {
            num_cascades: 1,
            minimum_distance: (distance - reach).max(0.01 * extent.radius),
            maximum_distance: distance + reach,
            ..default()
        }
        .build();
    }
}
