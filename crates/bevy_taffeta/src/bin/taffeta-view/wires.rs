//! Springs and edges as lines.

use crate::listed::Listed;
use crate::looks::{Lines, Looks};
use crate::stage::{StageCamera, StageRoot};
use bevy::asset::{AssetEventSystems, RenderAssetUsages};
use bevy::camera::visibility::NoFrustumCulling;
use bevy::light::{NotShadowCaster, NotShadowReceiver};
use bevy::mesh::{Indices, PrimitiveTopology};
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::BodyHandle;
use bevy_taffeta::{DrawnBody, Running};

/// Lines are drawn at this share of their distance from the camera, so that the surface that they lie on does not hide them.
const NEARER: f32 = 0.997;

/// Lines of a body.
#[derive(Component)]
struct Wire {
    body: BodyHandle,
    lines: Lines,
    /// Which of the simulations that were built they are of.
    built: u64,
}

/// Lines of springs and edges.
pub fn wires(app: &mut App) {
    app.add_systems(Update, spawn)
        .add_systems(PostUpdate, follow.after(TaffetaSystems::Draw).before(AssetEventSystems));
}

/// Has the lines that are wanted, and no others.
fn spawn(
    mut commands: Commands,
    looks: Res<Looks>,
    mut listed: ResMut<Listed>,
    worlds: Query<&Running, With<StageRoot>>,
    wires: Query<(Entity, &Wire)>,
    mut meshes: ResMut<Assets<Mesh>>,
    mut materials: ResMut<Assets<StandardMaterial>>,
) {
    let Ok(running) = worlds.single() else { return };
    let shown = |lines: Lines| Lines::ALL.iter().zip(looks.lines).any(|(one, on)| *one == lines && on);
    let mut there = Vec::new();
    for (entity, wire) in &wires {
        if shown(wire.lines) && wire.built == running.built() {
            there.push((wire.body, wire.lines));
        } else {
            commands.entity(entity).despawn();
        }
    }
    for lines in Lines::ALL.into_iter().filter(|lines| shown(*lines)) {
        let [r, g, b] = lines.colour();
        for drawn in running.drawn_bodies() {
            let body = drawn.handle;
            if there.contains(&(body, lines)) {
                continue;
            }
            let ends = ends(lines, running, &drawn, &mut listed);
            if ends.is_empty() {
                continue;
            }
            let strong = if lines == Lines::Edges { 0.35 } else { 0.8 };
            let material = StandardMaterial {
                base_color: Color::srgb_u8(r, g, b).with_alpha(strong),
                alpha_mode: AlphaMode::Blend,
                unlit: true,
                ..default()
            };
            commands.spawn((
                Wire { body, lines, built: running.built() },
                Mesh3d(meshes.add(mesh(ends))),
                MeshMaterial3d(materials.add(material)),
                (NoFrustumCulling, NotShadowCaster, NotShadowReceiver),
            ));
        }
    }
}

/// Vertices at the ends of lines.
fn ends(lines: Lines, running: &Running, body: &DrawnBody, listed: &mut Listed) -> Vec<u32> {
    match lines {
        Lines::Springs(kind) => {
            let of_kind = listed.of(running)[body.handle.index()].iter().filter(|list| list.kind == kind);
            of_kind.flat_map(|list| list.ends.as_flattened()).copied().collect()
        }
        Lines::Edges => {
            let drawn = body.mesh;
            let around = drawn.triangles.iter().flat_map(|[a, b, c]| [[*a, *b], [*b, *c], [*c, *a]]);
            let all = around.chain(drawn.links.iter().copied());
            let mut all: Vec<[u32; 2]> =
                all.map(|pair| pair.map(|corner| drawn.vertices[corner as usize])).collect();
            all.iter_mut().for_each(|pair| pair.sort_unstable());
            all.sort_unstable();
            all.dedup();
            all.into_flattened()
        }
    }
}

fn mesh(ends: Vec<u32>) -> Mesh {
    let usages = RenderAssetUsages::RENDER_WORLD | RenderAssetUsages::MAIN_WORLD;
    Mesh::new(PrimitiveTopology::LineList, usages)
        .with_inserted_attribute(Mesh::ATTRIBUTE_POSITION, Vec::<[f32; 3]>::new())
        .with_inserted_indices(Indices::U32(ends))
}

/// Brings lines to where bodies are drawn.
fn follow(
    worlds: Query<&Running, With<StageRoot>>,
    camera: Query<&GlobalTransform, (With<StageCamera>, Without<Wire>)>,
    mut wires: Query<(&Wire, &Mesh3d, &mut Transform, &mut GlobalTransform)>,
    mut meshes: ResMut<Assets<Mesh>>,
) {
    let (Ok(running), Ok(camera)) = (worlds.single(), camera.single()) else { return };
    if wires.is_empty() {
        return;
    }
    let mut places = Vec::new();
    running.places(&mut places);
    let eye = camera.translation();
    for (wire, handle, mut transform, mut global) in &mut wires {
        let (true, Some(mut mesh)) = (wire.built == running.built(), meshes.get_mut(&handle.0)) else {
            continue;
        };
        let Some(DrawnBody { first_vertex: first, .. }) = running.drawn(wire.body) else { continue };
        let count = running.simulation().bodies()[wire.body.index()].vertices;
        let own: Vec<[f32; 3]> = places[first..first + count].iter().map(Vec3::to_array).collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_POSITION, own);
        *transform = Transform { translation: (1.0 - NEARER) * eye, scale: Vec3::splat(NEARER), ..default() };
        *global = (*transform).into();
    }
}
