//! Thin plates in one mesh, and nodes that are not to touch them, or one of them alone.

use super::{V, norm, weightless};
use std::sync::Arc;
use taffeta::scene::{Body, Collider, Mass, Mesh, Scene};
use taffeta::topology::Surface;

/// Two of them [m].
pub const HEIGHTS: [f64; 2] = [0.0, -1.0];
/// Where a node lies on the upper one [m].
pub const ON_THE_UPPER: f64 = 0.01005;

/// Level plates of 0.8 m and a tenth of a millimetre, in 12 triangles each, at these heights [m].
pub fn thin_plates(heights: &[f64]) -> Collider {
    let corner = |i: u32, y: f64| {
        [(1, 0.4, 0.0), (2, 5e-5, y), (4, 0.4, 0.0)]
            .map(|(bit, x, at)| at + if i & bit == 0 { -x } else { x })
    };
    let quads = [[0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let of = |plate: u32| triangles.clone().map(move |corners| corners.map(|corner: u32| corner + 8 * plate));
    let nodes = heights.iter().flat_map(|&y| (0..8).map(move |i| corner(i, y))).collect();
    let triangles = (0..heights.len() as u32).flat_map(of).collect();
    Collider::mesh(Mesh::Surface(Arc::new(Surface::of_triangles(nodes, triangles)))).offset(0.01)
}

/// Places off the upper plate: around two corners and along two edges, above, below and beside.
pub fn beside_the_upper() -> Vec<V> {
    let aside = |n: i32| f64::from((n - 30).signum()) * 1e-7 * 1.4_f64.powi((n - 30).abs());
    let mut places = Vec::new();
    for (y, (i, j)) in [-0.3, -0.2158796, -0.02, 0.0, 0.02, 0.2]
        .into_iter()
        .flat_map(|y| (0..61).flat_map(move |i| (0..61).map(move |j| (y, (i, j)))))
    {
        places.push([0.4 + aside(i), y, 0.4 + aside(j)]);
        places.push([-0.4 + aside(i), y, -0.4 + aside(j)]);
        places.push([0.4 + aside(i), y, -0.4 + 0.0133 * f64::from(j)]);
        places.push([-0.4 + 0.0133 * f64::from(i), y, -0.4 + aside(j)]);
    }
    places.retain(|[x, y, z]| {
        norm([(x.abs() - 0.4).max(0.0), (y.abs() - 5e-5).max(0.0), (z.abs() - 0.4).max(0.0)]) > 0.0101
    });
    places
}

/// Free nodes at two plates, without springs.
pub fn loose(nodes: usize) -> Scene {
    let body = Body::cloth("nodes", Mesh::chain(nodes as u32 - 1, 1.0)).with_mass(Mass::Node(1.0));
    weightless("plates", 0.01, 0.01).body(body).collider(thin_plates(&HEIGHTS))
}

/// Nodes that fall 1.25 m in one sub-step, through the upper plate and to 45 cm to 5 mm above the lower one, into its upper half,
/// its lower half and through it; and where from.
pub fn falling_short() -> (Scene, Vec<V>) {
    let across = |i: i32| 0.013 + 0.037 * f64::from(i);
    let starts = [0.2, 0.24997, 0.25003, 0.255, 0.27, 0.3, 0.4, 0.5, 0.6, 0.7];
    let places: Vec<V> = starts
        .into_iter()
        .flat_map(|y| (-9..9).flat_map(move |i| (-9..9).map(move |j| [across(i), y, across(j)])))
        .collect();
    let mut scene = loose(places.len());
    scene.world.gravity = [0.0, -12_500.0, 0.0];
    (scene, places)
}
