//! Colliders that are meshes, for rows of kernels that meet triangles.

use crate::contact::collider_mesh::surface::{Found, MeshNow, MeshSurface};
use crate::contact::collider_mesh::triangle::nearest;
use crate::gpu::layout::Four;
use crate::real::add;
use crate::scene::{Collider, Icosphere, Keyframe, Mesh, Place, Rotation};
use crate::topology::Surface;
use std::sync::Arc;

/// Height of the still sheet, its side, and the distance that it keeps [m]: powers of two.
pub const SHEET: [f32; 3] = [0.5, 0.75, 0.03125];

/// Where the middle of the upper plate is [m].
const PLATES_AT: [f64; 3] = [6.0, 2.5, 3.0];

fn place(axis: [f64; 3], degrees: f64, position: [f64; 3]) -> Place {
    Place { position, rotation: Some(Rotation { axis, degrees }), ..Place::default() }
}

/// A sheet at rest, a ball that turns, waves that are carried along, and ground of furrows.
pub fn colliders() -> Vec<Collider> {
    let turn = Keyframe {
        translate: [0.15, -0.1, 0.2],
        ..Keyframe::rotate(0.5, [0.3, -0.5, 0.4], 110.0, [0.1, 0.2, -0.1])
    };
    let ball = Mesh::Icosphere(Icosphere { radius: 0.47, subdivisions: 2 });
    let [height, side, offset] = SHEET.map(f64::from);
    let sheet = Place { position: [0.0, height, 0.0], ..Place::default() };
    let furrows = (0..6).map(|row| (0..5).map(|col| 0.13 * f64::from((row + col) % 2)).collect()).collect();
    vec![
        Collider::mesh(Mesh::grid(4, 4, [side, side]))
            .placed(sheet)
            .friction(0.3)
            .restitution(0.2)
            .offset(offset),
        Collider::mesh(ball)
            .placed(place([0.2, 0.3, 0.9], 33.0, [0.21, 0.17, -0.13]))
            .friction(0.4)
            .keyframe(turn.clone()),
        waves().placed(place([0.6, 0.1, 0.2], 75.0, [-0.4, 0.1, 0.3])).friction(0.6).keyframe(turn),
        Collider::heightfield([1.3, 1.1], furrows)
            .placed(place([0.0, 1.0, 0.0], 20.0, [0.1, -0.4, 0.1]))
            .friction(0.2),
    ]
}

/// Two level plates of 0.8 m and a tenth of a millimetre in one mesh, a metre apart, far from all else.
pub fn plates() -> Collider {
    let corner = |i: u32, y: f64| {
        [(1, 0.4, 0.0), (2, 5e-5, y), (4, 0.4, 0.0)]
            .map(|(bit, x, at)| at + if i & bit == 0 { -x } else { x })
    };
    let quads = [[0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6], [0, 4, 6, 2], [1, 3, 7, 5]];
    let triangles = quads.into_iter().flat_map(|[a, b, c, d]| [[a, b, c], [a, c, d]]);
    let of = |plate: u32| triangles.clone().map(move |corners| corners.map(|corner: u32| corner + 8 * plate));
    let nodes = [0.0, -1.0].into_iter().flat_map(|y| (0..8).map(move |i| corner(i, y))).collect();
    let surface = Surface::of_triangles(nodes, (0..2).flat_map(of).collect());
    let place = Place { position: PLATES_AT, ..Place::default() };
    Collider::mesh(Mesh::Surface(Arc::new(surface))).placed(place).offset(0.01)
}

/// A sheet that goes from pose to pose, about one in a sub-step.
fn waves() -> Collider {
    let (rows, cols) = (5_u32, 6_u32);
    let pose = |high: f64| -> Vec<[f64; 3]> {
        let node = |row, col| {
            let (x, z) = (0.21 * f64::from(col) - 0.5, 0.23 * f64::from(row) - 0.45);
            [x, high * (2.7 * x + z).cos(), z]
        };
        (0..rows).flat_map(|row| (0..cols).map(move |col| node(row, col))).collect()
    };
    Collider::mesh(Mesh::grid(rows, cols, [1.0, 1.0]))
        .posed(0.0047, [0.07, 0.13, -0.05, 0.1, 0.3, 0.2].map(pose).to_vec())
}

/// Puts some nodes on nodes, edges and faces of the still sheet, a hair beside what it keeps, and on its other side; they
/// come from there, from the other side, or from where they are. Returns the first node that is left.
pub fn put_awkward(old: &mut [Four], new: &mut [Four], from: usize) -> usize {
    let [height, side, offset] = SHEET;
    let along = [0.0, 0.5, 0.25, 0.125, -0.5].map(|fraction| fraction * side);
    let heights = [0.0, offset, offset.next_up(), offset.next_down(), 0.5 * offset, -0.5 * offset, -offset];
    let mut at = from;
    for (i, x) in along.into_iter().enumerate() {
        for (j, y) in heights.into_iter().enumerate() {
            let start = [0.25, -0.25, y][(i + j) % 3];
            new[at][..3].copy_from_slice(&[x, height + y, along[(i + 2 * j) % 5]]);
            old[at][..3].copy_from_slice(&[x, height + start, along[(i + 2 * j) % 5]]);
            at += 1;
        }
    }
    at
}

/// Puts some nodes under a corner of the upper plate, where one of its narrow sides seems the nearest by rounding, and some
/// above the lower one, to where they come through the upper one.
pub fn put_at_plates(old: &mut [Four], new: &mut [Four], from: usize) {
    let aside = |power: i32| 1e-7 * 1.4_f64.powi(power) - 0.4;
    let under = (1..13).flat_map(|i| [[aside(21), -0.25, aside(i)], [aside(i), -0.02, aside(11)]]);
    let through = (0..12).map(|i| 0.04 * f64::from(i)).map(|x| ([x, 0.25 + x, -x], [x, x - 0.98, -x]));
    for (at, (start, end)) in (from..).zip(under.map(|x| (x, x)).chain(through)) {
        let [start, end] = [start, end].map(|x| add(x, PLATES_AT).map(|c| c as f32));
        old[at][..3].copy_from_slice(&start);
        new[at][..3].copy_from_slice(&end);
    }
}

/// The triangle nearest to `x`, of all.
pub fn nearest_of(surface: &MeshSurface<f32>, now: &MeshNow<f32>, x: [f32; 3]) -> Option<Found<f32>> {
    let all = (0..).take(surface.triangles.len());
    let found = all.map(|triangle| {
        let at = nearest(x, &surface.corners(now, triangle, now.pose_fractions[1]));
        Found { triangle, at }
    });
    found.min_by(|a, b| a.at.squared.total_cmp(&b.at.squared))
}
