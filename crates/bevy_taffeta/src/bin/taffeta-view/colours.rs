//! Bodies in the colours of a quantity: strain, velocity, distance from colliders.

use crate::framing::Extent;
use crate::listed::{Listed, Springs};
use crate::looks::{Colouring, Looks};
use crate::stage::StageRoot;
use bevy::asset::AssetEventSystems;
use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy_taffeta::Running;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::springs::SpringKind;

/// The colour map "viridis" (Smith and van der Walt, 2015) at even steps, in sRGB.
const VIRIDIS: [[u8; 3]; 9] = [
    [68, 1, 84],
    [71, 44, 122],
    [59, 81, 139],
    [44, 113, 142],
    [33, 144, 141],
    [39, 173, 129],
    [92, 200, 99],
    [170, 220, 50],
    [253, 231, 37],
];

/// The colour of a share from 0 to 1, in sRGB.
pub fn viridis(share: f32) -> [f32; 3] {
    let at = share.clamp(0.0, 1.0) * (VIRIDIS.len() - 1) as f32;
    let below = (at as usize).min(VIRIDIS.len() - 2);
    let [from, to] = [VIRIDIS[below], VIRIDIS[below + 1]].map(|rgb| rgb.map(|c| f32::from(c) / 255.0));
    std::array::from_fn(|i| from[i] + (at - below as f32) * (to[i] - from[i]))
}

/// What is shown of a quantity now.
#[derive(Resource, Default)]
pub struct Range {
    /// The value of the last colour; that of the first is 0.
    pub top: f32,
}

/// Share of a range by which it shrinks in a frame, if it has become too large.
const SHRINK: f32 = 0.03;

impl Range {
    /// Makes room for values up to `largest`, but no less than `least`.
    fn follow(&mut self, largest: f32, least: f32) {
        let wanted = largest.max(least);
        let shrunk = self.top * (1.0 - SHRINK);
        self.top = if wanted.is_finite() { wanted.max(shrunk) } else { self.top.max(least) };
    }
}

/// What bodies are drawn with where their colours say nothing.
#[derive(Component)]
struct PlainMaterial(Handle<StandardMaterial>);

/// White, so that vertices give the colour.
#[derive(Resource)]
struct White(Handle<StandardMaterial>);

/// Colours of vertices.
pub fn colours(app: &mut App) {
    app.init_resource::<Range>()
        .init_resource::<Listed>()
        .add_systems(Startup, make_white)
        .add_systems(Update, choose_materials)
        .add_systems(PostUpdate, paint.after(TaffetaSystems::Draw).before(AssetEventSystems));
}

fn make_white(mut commands: Commands, mut materials: ResMut<Assets<StandardMaterial>>) {
    let white = StandardMaterial {
        perceptual_roughness: 1.0,
        reflectance: 0.1,
        double_sided: true,
        cull_mode: None,
        ..default()
    };
    commands.insert_resource(White(materials.add(white)));
}

type Bodies<'w, 's> = Query<
    'w,
    's,
    (Entity, &'static mut MeshMaterial3d<StandardMaterial>, Option<&'static PlainMaterial>),
    With<SoftMaterial>,
>;

/// White bodies while colours say something.
fn choose_materials(mut commands: Commands, looks: Res<Looks>, white: Res<White>, mut bodies: Bodies) {
    let painted = looks.colouring != Colouring::Plain;
    for (body, mut material, plain) in &mut bodies {
        match (painted, plain) {
            (true, None) => {
                commands.entity(body).insert(PlainMaterial(material.0.clone()));
                material.0 = white.0.clone();
            }
            (false, Some(plain)) => {
                material.0 = plain.0.clone();
                commands.entity(body).remove::<PlainMaterial>();
            }
            _ => {}
        }
    }
}

/// The meshes of bodies.
#[derive(SystemParam)]
struct Painted<'w, 's> {
    bodies: Query<'w, 's, &'static Mesh3d>,
    meshes: ResMut<'w, Assets<Mesh>>,
}

/// Gives the vertices of all bodies their colours.
fn paint(
    looks: Res<Looks>,
    extent: Res<Extent>,
    mut range: ResMut<Range>,
    mut listed: ResMut<Listed>,
    worlds: Query<&Running, With<StageRoot>>,
    Painted { bodies, mut meshes }: Painted,
    mut painted: Local<Option<(u32, u64, Colouring)>>,
) {
    let Ok(running) = worlds.single() else { return };
    let now = (running.simulation().frame(), running.built(), looks.colouring);
    if *painted == Some(now) || running.is_shared() {
        return;
    }
    let before = painted.replace(now);
    if looks.colouring == Colouring::Plain && before.is_none_or(|before| before.2 == Colouring::Plain) {
        return;
    }
    if before.is_none_or(|before| before.2 != looks.colouring) {
        range.top = 0.0;
    }
    let values = values(looks.colouring, running, &mut listed, &extent);
    range.follow(values.iter().copied().fold(0.0, f32::max), least(looks.colouring, &extent));
    for body in running.drawn_bodies() {
        let mesh = bodies.get(body.entity).ok().and_then(|mesh| meshes.get_mut(&mesh.0));
        let Some(mut mesh) = mesh else { continue };
        if looks.colouring == Colouring::Plain {
            mesh.remove_attribute(Mesh::ATTRIBUTE_COLOR);
            continue;
        }
        let first = body.first_vertex;
        let colour = |&vertex: &u32| colour(looks.colouring, values[first + vertex as usize] / range.top);
        let colours: Vec<[f32; 4]> = body.mesh.vertices.iter().map(colour).collect();
        mesh.insert_attribute(Mesh::ATTRIBUTE_COLOR, colours);
    }
}

/// The colour of a share of the range, as meshes have it. What touches is brightest.
fn colour(colouring: Colouring, share: f32) -> [f32; 4] {
    let [r, g, b] = viridis(shade(colouring, share));
    Color::srgb(r, g, b).to_linear().to_f32_array()
}

/// Where in the map a share of the range is.
pub fn shade(colouring: Colouring, share: f32) -> f32 {
    if colouring == Colouring::Contact { 1.0 - share } else { share }
}

/// The smallest range that is shown: less is noise.
fn least(colouring: Colouring, extent: &Extent) -> f32 {
    match colouring {
        Colouring::Plain => 1.0,
        Colouring::Strain => 0.01,
        Colouring::Velocity => 0.05,
        Colouring::Contact => reach(extent),
    }
}

/// Gaps are told up to this [m].
fn reach(extent: &Extent) -> f32 {
    0.05 * extent.radius
}

/// The quantity at each vertex of all bodies.
fn values(colouring: Colouring, running: &Running, listed: &mut Listed, extent: &Extent) -> Vec<f32> {
    match colouring {
        Colouring::Plain => Vec::new(),
        Colouring::Strain => strains(running, listed.of(running)),
        Colouring::Velocity => {
            let mut velocities: Vec<Vec3> = Vec::new();
            running.simulation().velocities_f32(&mut velocities);
            velocities.into_iter().map(Vec3::length).collect()
        }
        Colouring::Contact => {
            let mut gaps = Vec::new();
            running.simulation().collider_distances(f64::from(reach(extent)), &mut gaps);
            gaps
        }
    }
}

/// l/L − 1 of the longest structural or shear spring at each vertex, 0 where none is too long.
pub fn strains(running: &Running, springs: &[Vec<Springs>]) -> Vec<f32> {
    let mut places: Vec<Vec3> = Vec::new();
    running.simulation().positions_f32(&mut places);
    let mut strains = vec![0.0; places.len()];
    for (body, lists) in running.drawn_bodies().zip(springs) {
        let first = body.first_vertex;
        let along =
            lists.iter().filter(|list| matches!(list.kind, SpringKind::Structural | SpringKind::Shear));
        for (ends, rest) in along.flat_map(|list| list.ends.iter().zip(&list.rest)) {
            let [a, b] = ends.map(|vertex| first + vertex as usize);
            let strain = places[a].distance(places[b]) / rest - 1.0;
            for vertex in [a, b] {
                strains[vertex] = strain.max(strains[vertex]);
            }
        }
    }
    strains
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_map_grows_lighter_all_the_way_and_ends_where_it_should() {
        let light = |share: f32| {
            let [r, g, b] = viridis(share).map(|c| c.powf(2.2));
            0.21 * r + 0.72 * g + 0.07 * b
        };
        let shades: Vec<f32> = (0..=100).map(|i| light(i as f32 / 100.0)).collect();
        assert!(shades.is_sorted(), "{shades:?}");
        assert_eq!(viridis(7.0), [253.0, 231.0, 37.0].map(|c| c / 255.0));
    }

    #[test]
    fn a_range_grows_at_once_and_shrinks_slowly_to_what_is_least() {
        let mut range = Range::default();
        range.follow(2.0, 0.5);
        assert_eq!(range.top, 2.0);
        range.follow(1.0, 0.5);
        assert!(range.top > 1.9 && range.top < 2.0);
        (0..200).for_each(|_| range.follow(0.0, 0.5));
        assert_eq!(range.top, 0.5);
    }
}
