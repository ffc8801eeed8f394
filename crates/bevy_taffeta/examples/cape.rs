//! A cape on an animated character, whose capsules push it.

use bevy::core_pipeline::tonemapping::Tonemapping;
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use std::f32::consts::FRAC_PI_2;

fn main() {
    App::new().add_plugins((DefaultPlugins, cape)).run();
}

/// The plugin, and what is to be seen.
pub fn cape(app: &mut App) {
    app.add_plugins(TaffetaPlugin).add_systems(Startup, spawn).add_systems(Update, walk);
}

/// Distance of the cape from the character's skin [m].
pub const OFFSET: f64 = 0.01;

/// A part of the character that swings about its upper end, by so much and with this sign.
#[derive(Component)]
pub struct Swings(f32);

/// The character.
#[derive(Component)]
pub struct Walks;

fn spawn(
    mut commands: Commands,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let skin = materials.add(Color::srgb(0.7, 0.6, 0.5));
    let mut part = |down: f32, radius: f32| {
        let mesh =
            Capsule3d::new(radius, down).mesh().build().translated_by(Vec3::new(0.0, -down / 2.0, 0.0));
        let collider = SoftCollider::capsule(Vec3::ZERO, Vec3::new(0.0, -down, 0.0), radius).offset(OFFSET);
        (collider, Mesh3d(meshes.add(mesh)), MeshMaterial3d(skin.clone()))
    };
    let torso = part(0.4, 0.15);
    let [left, right] = [part(0.7, 0.09), part(0.7, 0.09)];
    let character = commands
        .spawn((Walks, torso, Transform::from_xyz(0.0, 1.4, 0.0)))
        .with_child((left, Swings(0.5), Transform::from_xyz(-0.11, -0.45, 0.0)))
        .with_child((right, Swings(-0.5), Transform::from_xyz(0.11, -0.45, 0.0)))
        .id();
    commands.spawn((
        Cloth::grid(25, 15, Vec2::new(0.56, 1.0)),
        SoftMaterial::new(Mass::Node(0.002)).structural(30.0, 0.01).shear(10.0, 0.01).bend(0.5, 0.005),
        Pins::carry(Select::rows(0, 0), character),
        Transform::from_xyz(0.0, 0.95, -0.2).with_rotation(Quat::from_rotation_x(FRAC_PI_2)),
        MeshMaterial3d(materials.add(StandardMaterial {
            base_color: Color::srgb(0.5, 0.1, 0.3),
            double_sided: true,
            cull_mode: None,
            ..default()
        })),
    ));
    let view = Transform::from_xyz(-1.6, 1.4, -2.2).looking_at(Vec3::new(0.0, 0.9, 0.0), Vec3::Y);
    commands.spawn((Camera3d::default(), Tonemapping::AcesFitted, view));
    let sun = Transform::from_xyz(-2.0, 3.0, -2.0).looking_at(Vec3::ZERO, Vec3::Y);
    commands.spawn((DirectionalLight { shadow_maps_enabled: true, ..default() }, sun));
}

fn walk(
    time: Res<Time>,
    mut character: Single<&mut Transform, (With<Walks>, Without<Swings>)>,
    mut legs: Query<(&Swings, &mut Transform)>,
) {
    let phase = 5.0 * time.elapsed_secs();
    character.translation =
        Vec3::new(0.0, 1.4 + 0.02 * (2.0 * phase).sin(), -0.1 * (1.0 - (0.4 * phase).cos()));
    character.rotation = Quat::from_rotation_y(0.2 * phase.sin());
    for (swings, mut leg) in &mut legs {
        leg.rotation = Quat::from_rotation_x(swings.0 * phase.sin());
    }
}
