//! A balloon that is blown up.

use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::scene::VolumeKey;

fn main() {
    App::new().add_plugins((DefaultPlugins, balloon)).run();
}

/// Stiffness of the rubber's edges [N/m], and the pressure in it after [`BLOWN`] seconds [Pa].
pub const RUBBER: f64 = 60.0;
/// See [`RUBBER`].
pub const PRESSURE: f64 = 120.0;
/// See [`RUBBER`].
pub const BLOWN: f64 = 1.0;

/// The plugin, and what is to be seen.
pub fn balloon(app: &mut App) {
    app.add_plugins(TaffetaPlugin).add_systems(Startup, spawn);
}

fn spawn(
    mut commands: Commands,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut world: Single<&mut Environment>,
) {
    world.gravity = [0.0; 3];
    world.drag = 0.02;
    let motion = vec![VolumeKey { t: BLOWN, pressure: Some(PRESSURE), ..default() }];
    commands.spawn((
        SoftBody::ball(0.15, 3),
        SoftMaterial::new(Mass::Node(0.001)).structural(RUBBER, 0.02).volume(Volume {
            pressure: Some(0.0),
            motion,
            ..default()
        }),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.8, 0.3, 0.5),
            perceptual_roughness: 0.2,
            ..default()
        })),
    ));
    commands.spawn((Camera3d::default(), Tonemapping::AcesFitted, Transform::from_xyz(0.0, 0.0, 1.2)));
    let sun = Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((DirectionalLight::default(), sun));
}
