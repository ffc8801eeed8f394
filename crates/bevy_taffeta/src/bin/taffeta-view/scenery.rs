//! What scenes are drawn with, and the floor that is drawn of a plane.

use bevy::asset::RenderAssetUsages;
use bevy::light::NotShadowCaster;
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_taffeta::taffeta::scene::{Kind, Plane, Scene, Shape};
use bevy_taffeta::{SceneMaterials, SoftCollider};

use crate::framing::Extent;

/// Behind everything.
pub const BACKGROUND: Color = Color::srgb(0.89, 0.91, 0.94);
/// Colours of bodies, by turns.
const BODIES: [Color; 4] = [
    Color::srgb(0.78, 0.23, 0.21),
    Color::srgb(0.17, 0.52, 0.70),
    Color::srgb(0.90, 0.66, 0.22),
    Color::srgb(0.30, 0.60, 0.44),
];
const COLLIDER: Color = Color::srgb(0.72, 0.72, 0.74);
/// The two shades of a floor.
const SQUARES: [Color; 2] = [Color::srgb(0.86, 0.87, 0.89), Color::srgb(0.79, 0.80, 0.83)];
/// Share of light that a plate lets through, which presses from above.
const PLATE: Color = Color::srgba(0.45, 0.52, 0.60, 0.2);
/// Radius up to which a floor is drawn in full, and at which it has faded away; that of a plate; by the scene's.
const FULL: f32 = 2.0;
const GONE: f32 = 7.0;
const PLATE_RADIUS: f32 = 1.1;
/// How far below its surface a plane is drawn, by the scene's radius.
const SUNK: f32 = 0.003;
/// A floor's squares are about this share of the scene's radius.
const SQUARE: f32 = 0.25;

/// What bodies and colliders of a scene are drawn with: both sides of all. Where the first body is soft, the second colour
/// is first.
pub fn materials(scene: &Scene, materials: &mut Assets<StandardMaterial>) -> SceneMaterials {
    let mut colours = BODIES;
    if scene.bodies.first().is_some_and(|body| body.kind == Kind::Soft) {
        colours.rotate_left(1);
    }
    let mut of = |base_color: Color, roughness| {
        materials.add(StandardMaterial {
            base_color,
            perceptual_roughness: roughness,
            reflectance: 0.3,
            double_sided: true,
            cull_mode: None,
            ..default()
        })
    };
    SceneMaterials {
        bodies: colours.map(|colour| of(colour, 0.75)).to_vec(),
        collider: Some(of(COLLIDER, 0.6)),
    }
}

/// Draws planes as floors that fade away, those that look down as plates.
pub fn lay_floors(
    mut commands: Commands,
    colliders: Query<(Entity, &SoftCollider), Added<SoftCollider>>,
    extent: Res<Extent>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    for (entity, collider) in &colliders {
        let Some(Shape::Plane(plane)) = collider.0.shape() else { continue };
        let Some(place) = beneath(&extent, plane) else { continue };
        let is_plate = place.rotation.mul_vec3(Vec3::Y).y < -0.5;
        let (mesh, material) = if is_plate { plate(&extent) } else { floor(&extent) };
        commands.entity(entity).insert((
            Mesh3d(meshes.add(mesh.transformed_by(place))),
            MeshMaterial3d(materials.add(material)),
            NotShadowCaster,
        ));
    }
}

/// The place on a plane next to the scene's middle.
fn beneath(extent: &Extent, plane: Plane) -> Option<Transform> {
    let [normal, point] = [plane.normal, plane.point].map(|v| Vec3::from(v.map(|x| x as f32)));
    let normal = normal.try_normalize()?;
    // What lies on it without an offset is seen, and not cut by it.
    let depth = normal.dot(extent.middle - point) + SUNK * extent.radius;
    let translation = extent.middle - normal * depth;
    Some(Transform { translation, rotation: Quat::from_rotation_arc(Vec3::Y, normal), scale: Vec3::ONE })
}

/// A square of a plate that can be seen through.
fn plate(extent: &Extent) -> (Mesh, StandardMaterial) {
    let side = 2.0 * PLATE_RADIUS * extent.radius;
    let material = StandardMaterial {
        base_color: PLATE,
        alpha_mode: AlphaMode::Blend,
        perceptual_roughness: 0.3,
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    (Plane3d::new(Vec3::Y, Vec2::splat(0.5 * side)).mesh().build(), material)
}

/// A chequered floor, which fades away and is not seen from below.
fn floor(extent: &Extent) -> (Mesh, StandardMaterial) {
    let side = rounded(SQUARE * extent.radius);
    let count = (GONE * extent.radius / side).ceil() as i32;
    let shades = SQUARES.map(|colour| colour.to_linear().to_vec3());
    let (mut places, mut colours, mut indices) = (Vec::new(), Vec::new(), Vec::new());
    for (row, col) in (-count..count).flat_map(|row| (-count..count).map(move |col| (row, col))) {
        let first = places.len() as u32;
        let shade = shades[(row + col).rem_euclid(2) as usize];
        for (z, x) in [(row, col), (row + 1, col), (row + 1, col + 1), (row, col + 1)] {
            let place = Vec3::new(x as f32, 0.0, z as f32) * side;
            let faded = (place.length() / extent.radius - FULL) / (GONE - FULL);
            let left = 1.0 - faded.clamp(0.0, 1.0);
            places.push(place);
            colours.push(shade.extend(left * left * (3.0 - 2.0 * left)).to_array());
        }
        indices.extend([0, 1, 2, 0, 2, 3].map(|corner| first + corner));
    }
    let normals = vec![[0.0, 1.0, 0.0]; places.len()];
    let mesh = Mesh::new(
        PrimitiveTopology::TriangleList,
        RenderAssetUsages::RENDER_WORLD | RenderAssetUsages::MAIN_WORLD,
    )
    .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, places)
    .with_inserted_attribute(Mesh::ATTRIBUTE_NORMAL, normals)
    .with_inserted_attribute(Mesh::ATTRIBUTE_COLOR, colours)
    .with_inserted_indices(Indices::U32(indices));
    let material = StandardMaterial {
        alpha_mode: AlphaMode::Blend,
        perceptual_roughness: 0.9,
        reflectance: 0.1,
        ..default()
    };
    (mesh, material)
}

/// One, two or five times a power of ten, next to a length.
fn rounded(length: f32) -> f32 {
    let power = 10.0_f32.powf(length.log10().floor());
    let steps = [1.0, 2.0, 5.0, 10.0].map(|step| step * power);
    let distance = |step: &f32| (step / length).ln().abs();
    steps.into_iter().min_by(|a, b| distance(a).total_cmp(&distance(b))).unwrap_or(power)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_have_round_sides() {
        for (length, side) in [(0.9, 1.0), (0.23, 0.2), (34.0, 50.0), (0.0011, 0.001)] {
            assert!((rounded(length) / side - 1.0).abs() < 1e-5, "{length}: {}", rounded(length));
        }
    }
}
