//! A pile of soft balls.

use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy_taffeta::prelude::*;

fn main() {
    App::new().add_plugins((DefaultPlugins, balls)).run();
}

/// Distance that balls keep from each other [m].
pub const THICKNESS: f64 = 0.03;

/// The plugin, and what is to be seen.
pub fn balls(app: &mut App) {
    app.add_plugins(TaffetaPlugin).add_systems(Startup, spawn);
}

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let rubber = SoftMaterial::new(Mass::Node(0.002))
        .structural(40.0, 0.02)
        .keep_volume(VolumeForm::Corrected)
        .collide(THICKNESS);
    // Two layers, the upper one in the hollows of the lower.
    for (layer, side) in [(0, 3), (1, 2)] {
        for number in 0..side * side {
            let (x, z) = ((number % side) as f32, (number / side) as f32);
            let middle = (side - 1) as f32 / 2.0;
            let at = Vec3::new(0.34 * (x - middle), 0.2 + 0.32 * layer as f32, 0.34 * (z - middle));
            commands.spawn((
                SoftBody::ball(0.15, 2),
                rubber.clone(),
                Transform::from_translation(at),
                MeshMaterial3d(materials.add(Color::hsl(40.0 * number as f32, 0.6, 0.5))),
            ));
        }
    }
    commands.spawn((
        SoftCollider::ground().friction(0.6),
        Mesh3d(meshes.add(Plane3d::default().mesh().size(4.0, 4.0))),
        MeshMaterial3d(materials.add(Color::srgb(0.5, 0.5, 0.5))),
    ));
    let view = Transform::from_xyz(0.8, 1.0, 1.6).looking_at(Vec3::new(0.0, 0.25, 0.0), Vec3::Y);
    commands.spawn((Camera3d::default(), Tonemapping::AcesFitted, view));
    let sun = Transform::from_xyz(1.0, 3.0, 2.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((DirectionalLight { shadow_maps_enabled: true, ..default() }, sun));
}
