//! A flag in the wind.

use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use std::f32::consts::FRAC_PI_2;

fn main() {
    App::new().add_plugins((DefaultPlugins, flag)).run();
}

/// The plugin, and what is to be seen.
pub fn flag(app: &mut App) {
    app.add_plugins(TaffetaPlugin).add_systems(Startup, spawn);
}

fn spawn(
    mut commands: Commands,
    mut materials: ResMut<Assets<StandardMaterial>>,
    mut world: Single<&mut Environment>,
) {
    world.air = Some(Air { velocity: [5.0, 0.0, 2.0], ..default() });
    commands.spawn((
        Cloth::grid(20, 30, Vec2::new(1.5, 1.0)),
        SoftMaterial::new(Mass::Area(0.2)).structural(60.0, 0.02).shear(20.0, 0.02).bend(1.0, 0.02),
        Pins::hold(Select::cols(0, 0)),
        Transform::from_rotation(Quat::from_rotation_x(FRAC_PI_2)),
        MeshMaterial3d(materials.add(StandardMaterial {
            double_sided: true,
            cull_mode: None,
            ..Color::srgb(0.8, 0.2, 0.2).into()
        })),
    ));
    commands.spawn((Camera3d::default(), Tonemapping::AcesFitted, Transform::from_xyz(0.0, 0.0, 2.5)));
    commands.spawn((
        DirectionalLight::default(),
        Transform::from_xyz(1.0, 2.0, 3.0).looking_at(Vec3::ZERO, Vec3::Y),
    ));
}
