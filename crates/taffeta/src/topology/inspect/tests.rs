use crate::scene::{Cube, Cylinder, Mesh, Torus};
use crate::topology::inspect::*;
use crate::topology::shapes::{self, grid_surface};

fn of(nodes: &[[f64; 3]], triangles: &[[u32; 3]]) -> Inspection {
    let surface = Surface { nodes: nodes.to_vec(), triangles: triangles.to_vec(), ..Surface::default() };
    Inspection::new(&surface)
}

fn shape(mesh: &Mesh) -> Surface {
    shapes::surface(mesh).unwrap()
}

/// `a` and `b` as one surface; node `i` of `b` is node `with[i]` of `a` where there is one.
fn together(a: &Surface, b: &Surface, with: impl Fn(u32) -> Option<u32>) -> Surface {
    let mut both = a.clone();
    let shift = a.nodes.len() as u32;
    both.nodes.extend(&b.nodes);
    both.triangles.extend(b.triangles.iter().map(|t| t.map(|n| with(n).unwrap_or(n + shift))));
    both
}

#[test]
fn a_torus_has_a_handle_and_a_tube_two_borders() {
    let torus =
        Inspection::new(&shape(&Mesh::Torus(Torus { major: 1.0, minor: 0.3, rings: 9, segments: 7 })));
    assert_eq!((torus.euler, torus.genus, torus.holes, torus.parts.len()), (0, Some(1), 0, 1));
    assert!(torus.orientable && torus.parts[0].closed);
    let tube = Cylinder { radius: 1.0, height: 2.0, segments: 12, rings: 3, capped: false };
    let tube = Inspection::new(&shape(&Mesh::Cylinder(tube)));
    assert_eq!((tube.euler, tube.genus, tube.holes, tube.volume), (0, Some(0), 2, None));
}

#[test]
fn sizes_are_those_of_a_cube() {
    let cube = Inspection::new(&shape(&Mesh::Cube(Cube { size: 2.0, divisions: 4 })));
    assert!((cube.volume.unwrap() - 8.0).abs() < 1e-12 && (cube.area - 24.0).abs() < 1e-12);
    assert_eq!(cube.bounds, [[-1.0; 3], [1.0; 3]]);
    assert_eq!((cube.shortest.0, cube.longest.0), (0.5, 0.5_f64.hypot(0.5)));
    assert!((cube.thinnest.0 - 2.0).abs() < 1e-12, "half a square is twice as long as high");
    assert_eq!((cube.euler, cube.genus), (2, Some(0)));
}

#[test]
fn a_cavity_is_a_part_of_negative_volume() {
    let outer = shape(&Mesh::Cube(Cube { size: 2.0, divisions: 1 }));
    let mut inner = shape(&Mesh::Cube(Cube { size: 1.0, divisions: 1 }));
    inner.triangles.iter_mut().for_each(|t| t.swap(1, 2));
    let found = Inspection::new(&together(&outer, &inner, |_| None));
    assert!((found.volume.unwrap() - 7.0).abs() < 1e-12);
    assert!((found.parts[1].volume.unwrap() + 1.0).abs() < 1e-12);
    assert_eq!((found.parts.len(), found.joined_parts, found.genus, found.euler), (2, 2, Some(0), 4));
    assert_eq!(found.parts[1].first, 12);
}

#[test]
fn cubes_that_touch_at_a_corner_are_two_parts_joined_by_a_bow_tie() {
    let cube = shape(&Mesh::Cube(Cube { size: 1.0, divisions: 1 }));
    let mut other = cube.clone();
    other.nodes.iter_mut().for_each(|p| *p = p.map(|x| x + 1.0));
    let at = |p: [f64; 3], of: &Surface| of.nodes.iter().position(|q| *q == p).unwrap() as u32;
    let (high, low) = (at([0.5; 3], &cube), at([0.5; 3], &other));
    let found = Inspection::new(&together(&cube, &other, |n| (n == low).then_some(high)));
    assert_eq!((found.parts.len(), found.joined_parts), (2, 1));
    assert_eq!(found.bow_ties, [high]);
    assert_eq!((found.genus, found.euler), (Some(0), 3), "cut open at the node each part is a sphere");
    assert!(found.volume.is_some());
}

#[test]
fn holes_that_touch_at_a_node_are_two() {
    // Two squares of a sheet are missing that have one corner in common.
    let sheet = grid_surface(5, 5, [1.0, 1.0]);
    let missing = [[6, 7, 11, 12], [12, 13, 17, 18]];
    let kept = |t: &[u32; 3]| !missing.iter().any(|square| t.iter().all(|n| square.contains(n)));
    let triangles: Vec<[u32; 3]> = sheet.triangles.iter().copied().filter(kept).collect();
    let found = of(&sheet.nodes, &triangles);
    assert_eq!((found.holes, found.edges.boundary_edges()), (3, 24), "and the outer border");
    assert_eq!((found.bow_ties.clone(), found.genus), (vec![12], Some(0)));
    assert_eq!((found.parts.len(), found.open_borders), (1, 0));
}

#[test]
fn a_strip_with_a_twist_is_not_orientable_and_has_one_border() {
    // Five squares around; the last is joined to the first upside down.
    let strip: Vec<[u32; 3]> = (0..5)
        .flat_map(|i| {
            let [a, b] = [2 * i, 2 * i + 1];
            let [c, d] = if i < 4 { [a + 2, b + 2] } else { [1, 0] };
            [[a, c, b], [b, c, d]]
        })
        .collect();
    let nodes: Vec<[f64; 3]> = (0..10).map(|i| [f64::from(i), f64::from(i * i), f64::from(i % 2)]).collect();
    let found = of(&nodes, &strip);
    assert!(!found.orientable && found.genus.is_none());
    assert_eq!((found.holes, found.edges.boundary_edges(), found.edges.flipped), (1, 10, 1));
    let sides = Sides::new(10, &strip[..8], &Edges::new(10, &strip[..8], &[]));
    assert!(is_orientable(&strip[..8], &Edges::new(10, &strip[..8], &[]), &sides), "cut open it is a band");
}

#[test]
fn a_fin_on_a_cube_is_one_part_without_genus() {
    let cube = shape(&Mesh::Cube(Cube { size: 1.0, divisions: 1 }));
    let [a, b, _] = cube.triangles[0];
    let mut nodes = cube.nodes.clone();
    nodes.push([3.0, 3.0, 3.0]);
    let fin = [cube.triangles.clone(), vec![[a, b, nodes.len() as u32 - 1]]].concat();
    let found = of(&nodes, &fin);
    assert_eq!((found.parts.len(), found.genus, found.edges.non_manifold_edges()), (1, None, 1));
    assert_eq!((found.holes, found.open_borders, found.edges.boundary_edges()), (0, 1, 2));
    assert!(found.orientable && !found.parts[0].closed && found.volume.is_none());
}
