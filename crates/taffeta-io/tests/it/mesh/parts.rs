//! Parts of a surface: which way out is, and what touches.

use super::{cubes, load, obj, volume_and_closed};
use taffeta::scene::{Body, Mass, Mesh, Scene};
use taffeta::topology::Surface;
use taffeta::{Options, Simulation};

fn load_cubes(list: &[([f64; 3], f64, bool)]) -> Surface {
    let (vertices, faces) = cubes(list);
    load(&obj(&vertices, &faces)).unwrap()
}

fn volume(surface: &Surface) -> f64 {
    volume_and_closed(surface).0
}

#[test]
fn each_closed_part_is_turned_outward_for_itself() {
    let far = [3.0, 0.5, 0.0];
    let one = load_cubes(&[([0.0; 3], 1.0, true), (far, 2.0, false)]);
    assert!((volume(&one) - 9.0).abs() < 1e-12);
    assert_eq!(one.repairs, ["reoriented 12 triangles: 1 closed part was inside out"]);
    let both = load_cubes(&[([0.0; 3], 1.0, true), (far, 2.0, true)]);
    assert!((volume(&both) - 9.0).abs() < 1e-12);
    assert_eq!(both.repairs, ["reoriented 24 triangles: 2 closed parts were inside out"]);
}

#[test]
fn what_is_inside_keeps_its_sense_relative_to_the_outermost() {
    // A cavity of 0.8³ in a cube, a cube of 0.5³ in the cavity, and one of 0.2³ in that, which is part of the solid.
    let (cavity, core) = (0.8_f64.powi(3), 0.5_f64.powi(3));
    for inside_out in [false, true] {
        let list = [
            ([0.0; 3], 0.5, inside_out),
            ([0.1, 0.0, 0.0], 0.2, inside_out),
            ([0.0; 3], 1.0, inside_out),
            ([0.0; 3], 0.8, !inside_out),
        ];
        let surface = load_cubes(&list);
        let expected = 1.0 - cavity + core + 0.2_f64.powi(3);
        assert!((volume(&surface) - expected).abs() < 1e-12, "{inside_out}: {}", volume(&surface));
        let said = ["reoriented 48 triangles: 1 closed part was inside out, with 3 inside it"];
        assert_eq!(surface.repairs, &said[..usize::from(inside_out)]);
    }
}

#[test]
fn parts_that_touch_are_not_inside_each_other() {
    // On the side of the other, within its box and on none of its nodes or edges.
    let on_top = load_cubes(&[([0.0; 3], 2.0, false), ([1.25, 0.125, 0.25], 0.5, true)]);
    assert!((volume(&on_top) - 8.125).abs() < 1e-12, "{}", volume(&on_top));
    // A cavity that touches a side from within is one still.
    let cavity = load_cubes(&[([0.0; 3], 2.0, true), ([0.75, 0.125, 0.25], 0.5, false)]);
    assert!((volume(&cavity) - 7.875).abs() < 1e-12, "{}", volume(&cavity));
    // An octahedron whose corners are all on the sides of a cube.
    let (mut vertices, mut faces) = cubes(&[([0.0; 3], 2.0, true)]);
    vertices.extend([0, 1, 2].map(|axis| [0, 1, 2].map(|i| f64::from(u8::from(i == axis)))));
    vertices.extend([0, 1, 2].map(|axis| [0, 1, 2].map(|i| -f64::from(u8::from(i == axis)))));
    for (x, y, z) in [(8, 9, 10), (8, 10, 12), (8, 12, 13), (8, 13, 9)] {
        faces.extend([[x, y, z], [11, z, y]]);
    }
    let inscribed = load(&obj(&vertices, &faces)).unwrap();
    assert!((volume(&inscribed) - (8.0 - 4.0 / 3.0)).abs() < 1e-12, "{}", volume(&inscribed));
}

#[test]
fn overlapping_parts_are_both_outermost() {
    let surface = load_cubes(&[([0.0; 3], 2.0, true), ([0.9, 0.1, 0.2], 1.0, true)]);
    assert!((volume(&surface) - 9.0).abs() < 1e-12, "{}", volume(&surface));
}

#[test]
fn cubes_that_share_an_edge_are_two_solids() {
    let surface = load_cubes(&[([0.0; 3], 1.0, false), ([1.0, 1.0, 0.0], 1.0, true)]);
    assert!((volume(&surface) - 2.0).abs() < 1e-12);
    assert_eq!(surface.nodes.len(), 14);
    let [welded, crowded, turned] = &surface.repairs[..] else { panic!("{:?}", surface.repairs) };
    assert!(welded.starts_with("welded 16 vertices into 14"));
    assert_eq!(crowded, "not a manifold: 1 edge with more than two triangles, between vertices 6 and 7");
    assert_eq!(turned, "reoriented 12 triangles: 1 closed part was inside out");
}

#[test]
fn what_is_closed_only_by_others_keeps_its_winding() {
    // Cubes with a common side, which is there once: three triangles meet at each of its edges.
    let (vertices, mut faces) = cubes(&[([0.0; 3], 1.0, false), ([1.0, 0.0, 0.0], 1.0, true)]);
    faces.retain(|face| face[0] < 8 || face.iter().any(|&vertex| vertex >= 12));
    let surface = load(&obj(&vertices, &faces)).unwrap();
    assert_eq!((surface.nodes.len(), surface.triangles.len()), (12, 22));
    let [welded, crowded] = &surface.repairs[..] else { panic!("{:?}", surface.repairs) };
    assert!(welded.starts_with("welded 16 vertices into 12"));
    assert!(crowded.starts_with("not a manifold: 4 edges"), "{crowded}");
    assert!(crowded.ends_with("4 and 5, 4 and 6, 5 and 7, …"), "{crowded}");
}

#[test]
fn a_node_where_parts_touch_in_a_point_is_split() {
    let (vertices, faces) = cubes(&[([0.0; 3], 1.0, false), ([1.0; 3], 1.0, false)]);
    let welded = load(&obj(&vertices, &faces)).unwrap();
    let said = "split 1 node where parts of the surface touched in a point only";
    assert_eq!(welded.repairs, ["welded 16 vertices into 15: they lay at the same places", said]);
    assert_eq!(volume_and_closed(&welded), (2.0, true));
    assert_eq!(welded.nodes.len(), 16);
    let nodes = welded.node_of_vertex.unwrap();
    assert_eq!((nodes[7], nodes[8]), (7, 15), "vertex 8 goes with its own cube");
    // With one vertex for both cubes, it goes with the first.
    let faces: Vec<[u32; 3]> = faces.iter().map(|f| f.map(|v| if v < 8 { v } else { v - 1 })).collect();
    let vertices: Vec<[f64; 3]> = [&vertices[..8], &vertices[9..]].concat();
    let faces: Vec<[u32; 3]> = faces.iter().rev().copied().collect();
    let shared = load(&obj(&vertices, &faces)).unwrap();
    assert_eq!(shared.repairs, [said]);
    assert_eq!((shared.vertices.len(), shared.nodes.len()), (15, 16));
    let nodes = shared.node_of_vertex.as_ref().unwrap();
    assert_eq!(nodes[..], (0..15).collect::<Vec<u32>>());
    let at = |node: u32| shared.triangles.iter().filter(move |t| t.contains(&node)).flatten();
    assert!(at(7).all(|&node| node >= 7), "vertex 7 goes with the far cube, which comes first");
    assert!(at(15).all(|&node| node < 7 || node == 15));
    let cloth = Body::cloth("cubes", Mesh::Surface(std::sync::Arc::new(shared))).with_mass(Mass::Node(1.0));
    assert!(Simulation::new(&Scene::new("two cubes").body(cloth), &Options::default()).is_ok());
}

#[test]
fn fans_that_share_an_edge_stay_together() {
    // A cube with a fin: the edge of the fin has three triangles, and its ends are one node each.
    let (mut vertices, mut faces) = cubes(&[([0.0; 3], 1.0, false)]);
    vertices.push([2.0; 3]);
    faces.push([1, 3, 8]);
    assert_eq!(load(&obj(&vertices, &faces)).unwrap().nodes.len(), 9);
    // Three sheets that touch in a point: three nodes, and each vertex there with its own sheet.
    let corner = |i: f64| [[0.0; 3], [1.0, i, 0.0], [1.0, i, 1.0]];
    let sheets = [0.0, 1.0, 2.0].map(corner).concat();
    let surface = load(&obj(&sheets, &[[0, 1, 2], [4, 5, 3], [8, 6, 7]])).unwrap();
    assert_eq!((surface.nodes.len(), surface.repairs.len()), (9, 2));
    let nodes = surface.node_of_vertex.unwrap();
    let of_triangles: Vec<[u32; 3]> =
        [[0, 1, 2], [4, 5, 3], [8, 6, 7]].iter().map(|t| t.map(|v: usize| nodes[v])).collect();
    assert_eq!(surface.triangles, of_triangles);
}

#[test]
fn a_thousand_parts_within_parts_are_told_apart() {
    // Cubes in cubes in a row, every other pair inside out, all inside one cube that is inside out as well.
    let mut list = Vec::new();
    for i in 0..1000 {
        let centre = [f64::from(i) * 1.5, 0.1, 0.2];
        list.extend([(centre, 1.0, i % 2 == 0), (centre, 0.5, i % 2 != 0)]);
    }
    let row = load_cubes(&list);
    assert!((volume(&row) - 1000.0 * 0.875).abs() < 1e-6, "{}", volume(&row));
    assert_eq!(
        row.repairs,
        ["reoriented 12000 triangles: 500 closed parts were inside out, with 500 inside them"]
    );
    list.push(([750.0, 0.0, 0.0], 2000.0, true));
    let held = load_cubes(&list);
    assert!((volume(&held) - 8e9).abs() < 1e-3, "{}", volume(&held));
    assert_eq!(
        held.repairs,
        ["reoriented 24012 triangles: 1 closed part was inside out, with 2000 inside it"]
    );
}

/// Two panels of 3 × 3 vertices, sewn all around. At two corners a triangle of either has all three corners on the
/// seam, so that both have the same nodes; they are two pieces of cloth.
#[test]
fn panels_sewn_together_keep_both_their_corners() {
    let panel = |height: f64| -> String {
        let inner = |x: u32, y: u32| if (x, y) == (1, 1) { height } else { 0.0 };
        (0..9).map(|i| format!("v {} {} {}\n", i / 3, i % 3, inner(i / 3, i % 3))).collect()
    };
    let faces = [[1, 4, 2], [2, 4, 5], [2, 5, 3], [3, 5, 6], [4, 7, 5], [5, 7, 8], [5, 8, 6], [6, 8, 9]];
    let front: String = faces.iter().map(|[a, b, c]| format!("f {a} {b} {c}\n")).collect();
    let back: String = faces.iter().map(|[a, b, c]| format!("f {} {} {}\n", a + 9, c + 9, b + 9)).collect();
    let pillow = load(&(panel(0.3) + &panel(-0.3) + &front + &back)).unwrap();
    assert_eq!((pillow.nodes.len(), pillow.triangles.len()), (10, 16));
    // One panel with both its sides is one panel.
    let sheet = load(&(panel(0.3) + &panel(0.3) + &front + &back)).unwrap();
    assert_eq!((sheet.nodes.len(), sheet.triangles.len()), (9, 8));
}
