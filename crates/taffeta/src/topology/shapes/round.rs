//! Spheres, tori and cylinders.

use crate::scene::{Cylinder, Icosphere, Torus, UvSphere};
use crate::topology::measure::norm;
use crate::topology::shapes::from_faces;
use crate::topology::{Edges, Surface};
use std::f64::consts::{PI, TAU};

/// An icosahedron, each triangle split in four at the middles of its edges, which are moved out to the sphere.
pub(crate) fn icosphere(ball: Icosphere) -> Surface {
    let (mut nodes, mut triangles) = icosahedron();
    for _ in 0..ball.subdivisions {
        triangles = split(&mut nodes, &triangles);
    }
    let nodes = nodes.into_iter().map(|p| p.map(|x| x * ball.radius)).collect();
    Surface::of_triangles(nodes, triangles)
}

fn icosahedron() -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let golden = (1.0 + 5f64.sqrt()) / 2.0;
    let signs = [[-1.0, 1.0], [1.0, 1.0], [-1.0, -1.0], [1.0, -1.0]];
    let ring = |place: fn(f64, f64) -> [f64; 3]| signs.map(|[s, t]| unit(place(s, t * golden)));
    let nodes = [ring(|s, t| [s, t, 0.0]), ring(|s, t| [0.0, s, t]), ring(|s, t| [t, 0.0, s])].concat();
    #[rustfmt::skip]
    let triangles = vec![
        [0, 5, 1], [0, 1, 7], [0, 11, 5], [0, 7, 10], [0, 10, 11],
        [1, 5, 9], [1, 8, 7], [1, 9, 8], [2, 3, 4], [2, 6, 3],
        [2, 4, 11], [2, 10, 6], [2, 11, 10], [3, 9, 4], [3, 6, 8],
        [3, 8, 9], [4, 9, 5], [4, 5, 11], [6, 7, 8], [6, 10, 7],
    ];
    (nodes, triangles)
}

/// Splits each triangle of a closed surface on the unit sphere in four.
fn split(nodes: &mut Vec<[f64; 3]>, triangles: &[[u32; 3]]) -> Vec<[u32; 3]> {
    let edges = Edges::new(nodes.len(), triangles, &[]);
    let mut middles = vec![[0; 3]; triangles.len()];
    for (&[a, b], sides) in edges.pairs.iter().zip(&edges.triangles) {
        let middle = nodes.len() as u32;
        let [p, q] = [a, b].map(|i| nodes[i as usize]);
        nodes.push(unit([0, 1, 2].map(|i| 0.5 * (p[i] + q[i]))));
        for &t in sides {
            let opposite = triangles[t as usize].iter().position(|corner| *corner != a && *corner != b);
            middles[t as usize][opposite.unwrap_or(0)] = middle;
        }
    }
    let four = |([a, b, c], [bc, ca, ab]): (&[u32; 3], &[u32; 3])| {
        [[*a, *ab, *ca], [*ab, *b, *bc], [*ca, *bc, *c], [*ab, *bc, *ca]]
    };
    triangles.iter().zip(&middles).flat_map(four).collect()
}

fn unit(p: [f64; 3]) -> [f64; 3] {
    let length = norm(p);
    p.map(|x| x / length)
}

/// Cosine and sine of a share of the full turn; from libm, the same on all platforms.
fn turn(index: u32, count: u32) -> (f64, f64) {
    let (sin, cos) = libm::sincos(TAU * f64::from(index) / f64::from(count));
    (cos, sin)
}

/// A ring of nodes about the y axis, right-handed from +x.
fn ring(radius: f64, y: f64, count: u32) -> impl Iterator<Item = [f64; 3]> {
    (0..count).map(move |s| {
        let (cos, sin) = turn(s, count);
        [radius * cos, y, -radius * sin]
    })
}

/// Squares between two rings of nodes that start at `low` and `high`, seen from outside.
fn band(low: u32, high: u32, count: u32) -> impl Iterator<Item = Vec<u32>> {
    (0..count).map(move |s| {
        let next = (s + 1) % count;
        vec![low + s, low + next, high + next, high + s]
    })
}

/// Triangles between a ring of nodes that starts at `start` and a node above it (`up`) or below.
fn fan(start: u32, tip: u32, count: u32, up: bool) -> impl Iterator<Item = Vec<u32>> {
    (0..count).map(move |s| {
        let [here, next] = [start + s, start + (s + 1) % count];
        if up { vec![here, next, tip] } else { vec![next, here, tip] }
    })
}

/// Nodes: the pole at −y, the rings upwards, the pole at +y. Bands are squares, the polar ones triangles.
pub(crate) fn uv_sphere(ball: UvSphere) -> Surface {
    let UvSphere { radius, rings, segments } = ball;
    let middle = (1..rings).flat_map(|r| {
        let (sin, cos) = libm::sincos(PI * f64::from(r) / f64::from(rings));
        ring(radius * sin, -radius * cos, segments)
    });
    let nodes: Vec<_> = [[0.0, -radius, 0.0]].into_iter().chain(middle).chain([[0.0, radius, 0.0]]).collect();
    let top = nodes.len() as u32 - 1;
    let bands = (2..rings).flat_map(|r| band(1 + (r - 2) * segments, 1 + (r - 1) * segments, segments));
    from_faces(nodes, fan(1, 0, segments, false).chain(bands).chain(fan(top - segments, top, segments, true)))
}

/// Nodes by ring around the y axis, then around the tube, from its outside upwards.
pub(crate) fn torus(torus: Torus) -> Surface {
    let Torus { major, minor, rings, segments } = torus;
    let node = move |r: u32, s: u32| {
        let ((cos_r, sin_r), (cos_s, sin_s)) = (turn(r, rings), turn(s, segments));
        let distance = major + minor * cos_s;
        [distance * cos_r, minor * sin_s, -distance * sin_r]
    };
    let nodes = (0..rings).flat_map(|r| (0..segments).map(move |s| node(r, s))).collect();
    let squares = (0..rings).flat_map(|r| {
        let [here, next] = [r * segments, (r + 1) % rings * segments];
        (0..segments).map(move |s| {
            let up = (s + 1) % segments;
            vec![here + s, next + s, next + up, here + up]
        })
    });
    from_faces(nodes, squares)
}

/// Nodes: rings upwards, then, if capped, the middles of the lower and the upper cap.
pub(crate) fn cylinder(cylinder: Cylinder) -> Surface {
    let Cylinder { radius, height, segments, rings, capped } = cylinder;
    let y = |r: u32| (f64::from(r) / f64::from(rings) - 0.5) * height;
    let mut nodes: Vec<_> = (0..=rings).flat_map(|r| ring(radius, y(r), segments)).collect();
    let bottom = nodes.len() as u32;
    let sides = (0..rings).flat_map(|r| band(r * segments, (r + 1) * segments, segments));
    if !capped {
        return from_faces(nodes, sides);
    }
    nodes.extend([[0.0, -0.5 * height, 0.0], [0.0, 0.5 * height, 0.0]]);
    let caps = fan(0, bottom, segments, false).chain(fan(bottom - segments, bottom + 1, segments, true));
    from_faces(nodes, sides.chain(caps))
}
