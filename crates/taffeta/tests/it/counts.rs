//! Numbers of nodes and springs, masses and volumes that the papers and geometry give.

use crate::common::{build, build_as, near, weightless};
use taffeta::scene::{Body, Cube, Cylinder, Icosphere, Internal, Mass, Mesh, Torus, UvSphere};
use taffeta::{BodyInfo, Precision};

fn info(body: Body) -> BodyInfo {
    build(&weightless("counts", 0.01, 0.01).body(body)).bodies()[0].clone()
}

fn springs(body: Body) -> Vec<(&'static str, usize)> {
    info(body).springs
}

fn hinges(body: &BodyInfo) -> usize {
    body.elements.iter().find(|(kind, _)| *kind == "hinges").unwrap().1
}

fn grid(rows: u32, cols: u32) -> Body {
    let size = [f64::from(cols) - 1.0, f64::from(rows) - 1.0];
    Body::cloth("grid", Mesh::grid(rows, cols, size)).with_mass(Mass::Node(0.1)).structural(1.0, 0.0)
}

#[test]
fn grids_have_the_numbers_of_springs_of_the_papers() {
    let all = |body: Body| springs(body).iter().map(|(_, count)| count).sum::<usize>();
    let full = |n| grid(n, n).shear(1.0, 0.0).bend(1.0, 0.0);
    assert_eq!(all(full(32)), 5826);
    assert_eq!(all(full(34)), 6598);
    assert_eq!(all(grid(38, 38).shear(1.0, 0.0)), 5550);
    assert_eq!(all(grid(32, 32).shear(1.0, 0.0)), 3906);
    let (r, c) = (7, 12);
    let expected = [
        ("structural", r * (c - 1) + c * (r - 1)),
        ("shear", 2 * (r - 1) * (c - 1)),
        ("bend", r * (c - 2) + c * (r - 2)),
    ];
    assert_eq!(springs(grid(7, 12).shear(1.0, 0.0).bend(1.0, 0.0)), expected);
    let line = grid(1, 6).shear(1.0, 0.0).bend(1.0, 0.0);
    assert_eq!(springs(line), [("structural", 5), ("shear", 0), ("bend", 4)]);
}

#[test]
fn the_cube_of_the_paper_has_386_nodes_and_1777_springs() {
    let mut cube =
        Body::soft("cube", Mesh::Cube(Cube { size: 1.0, divisions: 8 })).with_mass(Mass::Node(0.01));
    cube.springs.internal = Some(Internal { count: 625, k: 1.0, ..Internal::default() });
    let cube = info(cube.structural(1.0, 0.0));
    assert_eq!((cube.vertices, cube.nodes, cube.triangles), (386, 386, 768));
    assert_eq!(cube.springs, [("structural", 1152), ("internal", 625)]);
    near("volume", cube.rest_volume.unwrap(), 1.0, 1e-14);
}

#[test]
fn a_closed_surface_has_as_many_bend_springs_and_hinges_as_edges_and_an_open_one_less_its_rim() {
    let ball =
        |body: Body| body.with_mass(Mass::Node(0.1)).structural(1.0, 0.0).bend(1.0, 0.0).hinge(1.0, 0.0);
    let closed = info(ball(Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 3 }))));
    assert_eq!((closed.nodes, closed.triangles, hinges(&closed)), (642, 1280, 1920));
    assert_eq!(closed.springs, [("structural", 1920), ("bend", 1920)]);
    let tube = Cylinder { radius: 1.0, height: 1.0, segments: 12, rings: 3, capped: false };
    let open = info(ball(Body::cloth("tube", Mesh::Cylinder(tube))));
    // 4 rings of 12, 3 bands of 12 uprights and 12 diagonals; two rims of 12.
    assert_eq!((open.springs[0], hinges(&open)), (("structural", 120), 96));
    assert_eq!(open.rest_volume, None);
    assert_eq!(hinges(&info(grid(5, 7).hinge(1.0, 0.0))), 5 * 6 + 7 * 4 + 6 * 4 - 2 * (4 + 6));
}

#[test]
fn volumes_at_the_start_are_those_of_the_polyhedra() {
    let ball = |subdivisions| Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions });
    let ring = Mesh::Torus(Torus { major: 1.0, minor: 0.25, rings: 96, segments: 24 });
    let octahedron = Mesh::UvSphere(UvSphere { radius: 1.0, rings: 2, segments: 4 });
    let prism = Mesh::Cylinder(Cylinder { radius: 1.0, height: 2.0, segments: 4, rings: 3, capped: true });
    let known = [
        (ball(2), 4.047045, 5e-7),
        (ball(3), 4.152741, 5e-7),
        (ball(4), 4.179739, 5e-7),
        (ring, 1.218785, 5e-7),
        (octahedron, 4.0 / 3.0, 1e-14),
        (prism, 4.0, 1e-14),
    ];
    for (mesh, volume, tolerance) in known {
        let body = Body::soft("", mesh).with_mass(Mass::Node(0.1));
        // A hundred metres away, and half as large.
        let mut small = body.clone().at([100.0, -50.0, 70.0]);
        small.place.scale = Some(0.5);
        let scene = weightless("volumes", 0.01, 0.01).body(body).body(grid(3, 3)).body(small);
        let simulation = build(&scene);
        let [Some(whole), None, Some(eighth)] = simulation.report().volumes[..] else {
            panic!("volumes of solids alone")
        };
        near("volume", whole, volume, tolerance);
        near("an eighth", eighth, volume / 8.0, tolerance);
        let single = build_as(&scene, Precision::F32, 1);
        near("in 32 bits", single.report().volumes[0].unwrap(), volume, 1e-6 * volume);
    }
}

#[test]
fn masses_add_up_to_what_was_asked() {
    let cube = |mass| Body::soft("", Mesh::Cube(Cube { size: 0.5, divisions: 4 })).with_mass(mass);
    for (body, mass) in [
        (cube(Mass::Whole(2.0)), 2.0),
        (cube(Mass::Area(2.0)), 3.0),
        (cube(Mass::Volume(1000.0)), 125.0),
        (cube(Mass::Node(0.1)), 9.8),
        (grid(5, 9).with_mass(Mass::Area(0.25)), 8.0),
        (Body::cloth("", Mesh::chain(4, 2.0)).with_mass(Mass::Whole(4.0)), 4.0),
    ] {
        near("mass", info(body).mass, mass, 1e-13 * mass);
    }
}
