//! Holes that are filled where that is asked for.

use super::{CUBE_FACES, assert_unit_cube, cube, cubes, obj, volume_and_closed};
use std::fs;
use taffeta::topology::Surface;
use taffeta_io::{MeshFormat, MeshOptions, load_mesh, parse_mesh};

fn filled(text: &str) -> Surface {
    let options = MeshOptions { fill_holes: true, ..MeshOptions::default() };
    parse_mesh(text.as_bytes(), MeshFormat::Obj, &options).unwrap()
}

/// The cube without the faces that `leave` says.
fn holed(turn: impl Fn(usize) -> bool, leave: impl Fn(usize) -> bool) -> String {
    let keep = |(line, text): (usize, &str)| (line < 8 || !leave(line - 8)).then(|| format!("{text}\n"));
    cube(turn).lines().enumerate().filter_map(keep).collect()
}

#[test]
fn a_hole_is_filled_whichever_way_the_surface_turns() {
    let turns: [fn(usize) -> bool; 4] = [|_| false, |_| true, |i| i % 3 == 0, |i| i > 4];
    for turn in turns {
        // The two triangles with x = 0.5, then with them one more, and two holes of a triangle each.
        for (leave, said) in [
            (&[6, 11][..], "filled 1 hole with 2 triangles (a border of 4 edges)"),
            (&[5, 6, 11], "filled 1 hole with 3 triangles (a border of 5 edges)"),
            (&[0, 11], "filled 2 holes with 2 triangles (borders of 3, 3 edges)"),
        ] {
            let surface = filled(&holed(turn, |i| leave.contains(&i)));
            let (volume, closed) = volume_and_closed(&surface);
            assert!(closed && volume > 0.8, "{leave:?}: volume {volume}, closed: {closed}");
            assert_eq!((surface.vertices.len(), surface.polygons.len()), (8, 12 - leave.len()));
            assert_eq!(surface.repairs[0], said);
        }
        assert_unit_cube(&filled(&holed(turn, |i| i == 6)));
    }
    let open = parse_mesh(holed(|_| false, |i| i == 6).as_bytes(), MeshFormat::Obj, &MeshOptions::default());
    assert_eq!(open.unwrap().triangles.len(), 11);
}

#[test]
fn only_the_files_own_triangles_count_as_reoriented() {
    let surface = filled(&holed(|_| true, |i| i == 6));
    let said = [
        "filled 1 hole with 1 triangle (a border of 3 edges)",
        "reoriented 11 triangles: the surface was inside out",
    ];
    assert_eq!(surface.repairs, said);
}

#[test]
fn holes_that_touch_in_a_point_are_filled_one_by_one() {
    // Two triangles without a common edge, but with a common node.
    let pair = (0..12)
        .flat_map(|i| (i + 1..12).map(move |j| [i, j]))
        .find(|[i, j]| CUBE_FACES[*i].iter().filter(|node| CUBE_FACES[*j].contains(node)).count() == 1);
    let pair = pair.unwrap();
    let surface = filled(&holed(|_| false, |i| pair.contains(&i)));
    assert_unit_cube(&surface);
    assert_eq!(surface.repairs, ["filled 2 holes with 2 triangles (borders of 3, 3 edges)"]);
}

#[test]
fn both_ends_of_a_tube_are_filled() {
    let (rings, segments) = (3_u32, 12_u32);
    let at = |ring: u32, segment: u32| ring * segments + segment % segments;
    let vertices: Vec<[f64; 3]> = (0..rings * segments)
        .map(|i| {
            let angle = f64::from(i % segments) * std::f64::consts::TAU / f64::from(segments);
            [angle.cos(), f64::from(i / segments), angle.sin()]
        })
        .collect();
    let mut faces = Vec::new();
    for (ring, segment) in (0..rings - 1).flat_map(|r| (0..segments).map(move |s| (r, s))) {
        let [a, b] = [at(ring, segment), at(ring, segment + 1)];
        let [c, d] = [at(ring + 1, segment), at(ring + 1, segment + 1)];
        faces.extend([[a, b, c], [b, d, c]]);
    }
    let surface = filled(&obj(&vertices, &faces));
    let (volume, closed) = volume_and_closed(&surface);
    // Two metres of a regular polygon with 12 corners: ½ n sin(2π/n) m².
    assert!(closed && (volume - 6.0).abs() < 1e-12, "volume {volume}, closed: {closed}");
    assert_eq!(surface.repairs[0], "filled 2 holes with 20 triangles (borders of 12, 12 edges)");
}

#[test]
fn no_edge_is_used_again() {
    // A square of two triangles across its shorter diagonal: its border is filled across the longer one.
    let square = [[0.0; 3], [1.0, 0.0, 0.0], [0.8, 0.8, 0.1], [0.0, 1.0, 0.0]];
    let pillow = filled(&obj(&square, &[[0, 1, 2], [0, 2, 3]]));
    assert!(volume_and_closed(&pillow).1);
    assert_eq!(pillow.triangles.len(), 4);
    // A lone triangle has no other side.
    let lone = filled(&obj(&square[..3], &[[0, 1, 2]]));
    assert_eq!(lone.triangles.len(), 1);
    assert!(lone.repairs[0].starts_with("left 1 hole open: "), "{:?}", lone.repairs);
}

#[test]
fn borders_that_run_into_a_crowded_edge_or_a_twist_are_left() {
    let (mut vertices, mut faces) = cubes(&[([0.0; 3], 1.0, false)]);
    vertices.push([2.0; 3]);
    faces.push([1, 3, 8]);
    let fin = filled(&obj(&vertices, &faces));
    assert_eq!(fin.triangles.len(), 13);
    assert!(fin.repairs[1].starts_with("left 2 open edges as found: "), "{:?}", fin.repairs);
    // A strip of five triangles, its ends joined with a twist: nodes 0 to 4, each three in a row a triangle.
    let place = |i: u32| [f64::from(i * i), f64::from(i * i * i), f64::from(i)];
    let strip: Vec<[u32; 3]> = (0..5).map(|i| [i, (i + 1) % 5, (i + 2) % 5]).collect();
    let twisted = filled(&obj(&[0, 1, 2, 3, 4].map(place), &strip));
    assert_eq!(twisted.triangles.len(), 5);
    let [twist, left] = &twisted.repairs[..] else { panic!("{:?}", twisted.repairs) };
    assert!(twist.starts_with("not orientable: 1 part"));
    assert!(left.starts_with("left 5 open edges as found: "), "{left}");
}

#[test]
fn a_filled_hole_has_places_at_rest() {
    let folder = tempfile::tempdir().unwrap();
    let (mesh, rest) = (folder.path().join("mesh.obj"), folder.path().join("rest.obj"));
    let text = holed(|_| true, |i| i == 6);
    fs::write(&mesh, &text).unwrap();
    fs::write(&rest, text.replace("0.5", "1.5")).unwrap();
    let options = MeshOptions { fill_holes: true, rest: Some(&rest), ..MeshOptions::default() };
    let surface = load_mesh(&mesh, &options).unwrap();
    assert_unit_cube(&surface);
    let of_nodes = |t: &[u32; 3]| t.map(|node| surface.nodes[node as usize].map(|x| 3.0 * x));
    assert_eq!(surface.rest.unwrap(), surface.triangles.iter().map(of_nodes).collect::<Vec<_>>());
}
