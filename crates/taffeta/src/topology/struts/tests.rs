use crate::scene::{Cube, Icosphere, Mesh, Torus};
use crate::topology::shapes::surface;
use crate::topology::struts::*;

fn find(surface: &Surface, count: u32, seed: u64) -> Result<Vec<[u32; 2]>, String> {
    let edges = Edges::new(surface.nodes.len(), &surface.triangles, &[]);
    struts(&surface.nodes, &surface.triangles, &edges, count, seed)
}

/// Whether all of a strut is inside by `inside`, at 63 points along it.
fn stays(surface: &Surface, [a, b]: [u32; 2], inside: impl Fn([f64; 3]) -> bool) -> bool {
    let [p, q] = [a, b].map(|i| surface.nodes[i as usize]);
    (1..64).all(|i| inside([0, 1, 2].map(|k| p[k] + (q[k] - p[k]) * f64::from(i) / 64.0)))
}

#[test]
fn struts_of_a_torus_never_cross_its_hole() {
    let torus = surface(&Mesh::Torus(Torus { major: 1.0, minor: 0.4, rings: 24, segments: 12 })).unwrap();
    let found = find(&torus, 1500, 3).unwrap();
    assert_eq!(found.len(), 1500);
    let inside = |p: [f64; 3]| (p[0].hypot(p[2]) - 1.0).hypot(p[1]) < 0.4;
    assert!(found.iter().all(|pair| stays(&torus, *pair, inside)));
    assert!(found.is_sorted() && found.windows(2).all(|w| w[0] != w[1]));
    let edges = Edges::new(288, &torus.triangles, &[]).pairs;
    assert!(found.iter().all(|pair| pair[0] < pair[1] && !edges.contains(pair)));
}

#[test]
fn the_same_seed_gives_the_same_struts_and_another_seed_others() {
    let ball = surface(&Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 })).unwrap();
    let first = find(&ball, 400, 7).unwrap();
    assert_eq!(first, find(&ball, 400, 7).unwrap());
    assert_ne!(first, find(&ball, 400, 8).unwrap());
}

#[test]
fn a_cube_of_one_division_has_only_its_space_diagonals() {
    let cube = surface(&Mesh::Cube(Cube { size: 1.0, divisions: 1 })).unwrap();
    let found = find(&cube, 4, 1).unwrap();
    assert_eq!(found, [[0, 7], [1, 6], [2, 5], [3, 4]]);
    let refused = find(&cube, 5, 1).unwrap_err();
    assert_eq!(refused, "5 struts are asked for, 4 were found inside; that many would do");
}

#[test]
fn the_cube_of_the_paper_gets_its_625_struts_and_none_lies_in_a_face() {
    let cube = surface(&Mesh::Cube(Cube { size: 2.0, divisions: 8 })).unwrap();
    let found = find(&cube, 625, 1).unwrap();
    assert_eq!(found.len(), 625);
    assert!(found.iter().all(|pair| stays(&cube, *pair, |p| p.iter().all(|x| x.abs() < 1.0))));
}

#[test]
fn more_struts_than_a_large_mesh_can_hold_are_refused_by_a_sample() {
    // 9,602 nodes make 46 million pairs; a sixth of them lie in one face and are no struts.
    let cube = surface(&Mesh::Cube(Cube { size: 1.0, divisions: 40 })).unwrap();
    let refused = find(&cube, 46_000_000, 1).unwrap_err();
    let words = refused.strip_prefix("46000000 struts are asked for, and no more than about ").unwrap();
    let about: f64 = words.split(' ').next().unwrap().parse().unwrap();
    assert!(about > 38e6 && about < 42e6, "{about}");
    assert!(find(&cube, 1000, 1).is_ok());
}

/// An L: three unit cubes, whose inner edge 3–9 makes the cone at its ends neither convex nor flat.
#[test]
fn a_reflex_edge_lets_struts_go_inward_only() {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    let level = |z: f64| outline.map(|[x, y]| [x, y, z]);
    let nodes = [level(0.0), level(1.0)].concat();
    let caps = [[0, 1, 3], [1, 2, 3], [0, 3, 5], [3, 4, 5]];
    let top = caps.map(|t| t.map(|i| i + 6));
    let bottom = caps.map(|[a, b, c]| [a, c, b]);
    let sides = (0..6u32).flat_map(|i| {
        let j = (i + 1) % 6;
        [[i, j, j + 6], [i, j + 6, i + 6]]
    });
    let triangles: Vec<_> = bottom.into_iter().chain(top).chain(sides).collect();
    let l = Surface { nodes, triangles, ..Surface::default() };
    let found = find(&l, 10, 1).unwrap();
    let most = find(&l, 60, 1).unwrap_err();
    assert_eq!(most, "60 struts are asked for, 10 were found inside; that many would do");
    let inside = |p: [f64; 3]| {
        p.iter().all(|x| *x > 0.0) && p[2] < 1.0 && (p[0] < 1.0 && p[1] < 2.0 || p[1] < 1.0 && p[0] < 2.0)
    };
    assert!(found.iter().all(|pair| stays(&l, *pair, inside)), "{found:?}");
}

#[test]
fn an_open_surface_is_refused() {
    let sheet = crate::topology::shapes::grid_surface(3, 3, [1.0; 2]);
    assert!(find(&sheet, 1, 1).unwrap_err().contains("has 8 open edges, 0 edges of more"));
}

#[test]
fn struts_from_a_file_are_checked_and_become_nodes() {
    let mut sheet = crate::topology::shapes::grid_surface(2, 2, [1.0; 2]);
    assert_eq!(given_struts(&[[3, 0], [1, 2]], &sheet).unwrap(), [[0, 3], [1, 2]]);
    let refused = |pairs: &[[u32; 2]], words: &str| {
        let (_, message) = given_struts(pairs, &sheet).unwrap_err();
        assert!(message.contains(words), "{message}");
    };
    refused(&[[0, 1], [4, 0]], "strut 1 has vertex 4, 0 to 3");
    refused(&[[2, 2]], "no length");
    refused(&[[0, 1], [1, 0]], "strut 1 is given twice");
    sheet.node_of_vertex = Some(vec![3, 2, 1, u32::MAX]);
    assert_eq!(given_struts(&[[0, 2]], &sheet).unwrap(), [[1, 3]]);
    assert!(given_struts(&[[0, 3]], &sheet).unwrap_err().1.contains("no face uses"));
    assert_eq!(given_struts(&[[0, 2], [0, 9]], &sheet).unwrap_err().0, 1);
}
