//! What is wrong with a collider is told before anything runs.

use super::depth::data;
use super::reference::Faces;
use crate::common::{build_as, run};
use std::sync::Arc;
use taffeta::scene::{
    Bar, Body, Collider, Cube, Cuboid, Cylinder, Heightfield, Keyframe, Mass, Mesh, Place, Poses, Scene,
    Sphere,
};
use taffeta::topology::shapes::surface;
use taffeta::{Options, Precision, Simulation};

/// The message about the second of two colliders.
fn refused(collider: Collider) -> String {
    let body = Body::cloth("cloth", Mesh::grid(3, 3, [1.0, 1.0])).with_mass(Mass::Node(0.01));
    let scene = Scene::new("refused").body(body).collider(Collider::sphere([0.0; 3], 1.0)).collider(collider);
    let message = match Simulation::new(&scene, &Options::default()) {
        Ok(_) => String::new(),
        Err(error) => error.to_string(),
    };
    println!("{message}");
    message
}

#[track_caller]
fn says(collider: Collider, path: &str, what: &str) {
    let message = refused(collider);
    assert!(message.starts_with(path) && message.contains(what), "{path} … {what}: got “{message}”");
}

fn grid() -> Mesh {
    Mesh::grid(3, 3, [1.0, 1.0])
}

#[test]
fn a_collider_has_exactly_one_shape() {
    says(Collider::default(), "collider[1]", "has no shape");
    let both = Collider { sphere: Some(Sphere { center: [0.0; 3], radius: 1.0 }), ..Collider::mesh(grid()) };
    says(both, "collider[1]", "more than one shape");
}

#[test]
fn sizes_are_above_zero() {
    for bad in [-1.0, 0.0, f64::NAN, f64::INFINITY] {
        says(Collider::sphere([0.0; 3], bad), "collider[1].sphere.radius", "");
        says(Collider::cuboid([0.0; 3], [1.0, bad, 1.0]), "collider[1].box.half", "");
        says(Collider::capsule([0.0; 3], [1.0; 3], bad), "collider[1].capsule.radius", "");
        says(Collider::cylinder([0.0; 3], [1.0; 3], bad), "collider[1].cylinder.radius", "");
        says(Collider::heightfield([1.0, bad], vec![vec![0.0; 3]; 3]), "collider[1].heightfield.size", "");
        let cylinder = Cylinder { radius: bad, height: 1.0, segments: 8, rings: 1, capped: true };
        says(Collider::mesh(Mesh::Cylinder(cylinder)), "collider[1].mesh", "radius");
        says(Collider::convex(Mesh::Cylinder(cylinder)), "collider[1].convex", "radius");
        let grid = Collider::mesh(grid());
        says(
            grid.clone().placed(Place { scale: Some(bad), ..Place::default() }),
            "collider[1].place.scale",
            "",
        );
        if bad != 0.0 {
            says(grid.clone().offset(bad), "collider[1].offset", "");
            says(grid.friction(bad), "collider[1].friction", "");
        }
    }
    let ends = [1.0, f64::NAN, 0.0];
    says(Collider::capsule(ends, [0.0; 3], 1.0), "collider[1].capsule.a", "");
    says(Collider::cylinder([0.0; 3], ends, 1.0), "collider[1].cylinder.b", "");
    says(Collider::cylinder([1.0; 3], [1.0; 3], 1.0), "collider[1].cylinder.b", "apart");
    let cuboid = Cuboid { center: ends, half: [1.0; 3] };
    says(Collider { cuboid: Some(cuboid), ..Collider::default() }, "collider[1].box.center", "");
    says(Collider::mesh(grid()).restitution(1.5), "collider[1].restitution", "");
    let point = Bar { a: [0.3; 3], b: [0.3; 3], radius: 0.1 };
    assert_eq!(refused(Collider { capsule: Some(point), ..Collider::default() }), "");
}

#[test]
fn lengths_and_places_are_within_a_thousand_kilometres() {
    let at = |path: &str, collider| says(collider, &format!("collider[1].{path}"), "000 m would do");
    at("sphere.radius", Collider::sphere([0.0; 3], 1e9));
    at("sphere.center", Collider::sphere([0.0, 2e6, 0.0], 1.0));
    at("offset", Collider::sphere([0.0; 3], 1.0).offset(1e9));
    at("motion[0].translate", Collider::mesh(grid()).keyframe(Keyframe::translate(1.0, [1e14, 0.0, 0.0])));
    at("plane.point", Collider::plane([0.0, -1e7, 0.0], [0.0, 1.0, 0.0]));
    at("box.half[1]", Collider::cuboid([0.0; 3], [1.0, 1e7, 1.0]));
    at("cylinder.b", Collider::cylinder([0.0; 3], [1e7, 0.0, 0.0], 1.0));
    at("capsule.radius", Collider::capsule([0.0; 3], [1.0, 0.0, 0.0], 1e7));
    at("heightfield.heights", Collider::heightfield([1.0; 2], vec![vec![0.0, 1e9], vec![0.0, 1.0]]));
    let large = Place { scale: Some(1e7), ..Place::default() };
    at("place.scale", Collider::sphere([0.0; 3], 1.0).placed(large));
    let block = Collider::heightfield([1.0; 2], vec![vec![-8e5, 8e5], vec![0.0, 1.0]]);
    says(block, "collider[1]: has an extent of 1.600001e6 m", "1000000 m would do");
}

#[test]
fn bars_with_ends_at_one_place_to_rounding_have_numbers() {
    let bar = |length| Collider::cylinder([0.0; 3], [length, 0.0, 0.0], 0.6);
    says(bar(1e-300), "collider[1].cylinder.b", "apart");
    says(bar(1e-20), "collider[1].cylinder.b", "is 1e-20 m from a; 1e-15 m or more would do");
    let ball = |length| (Collider::capsule([0.0; 3], [length, 0.0, 0.0], 0.6), 5);
    let shapes = [1e-300, 1e-160, 1e-20, 1e-15, 1e-10].map(ball).into_iter();
    for (collider, touched) in shapes.chain([1e-15, 1e-10].map(|length| (bar(length), 3))) {
        for precision in [Precision::F32, Precision::F64] {
            let body = Body::cloth("cloth", grid()).with_mass(Mass::Node(0.01));
            let scene = Scene::new("short").body(body).collider(collider.clone());
            let mut simulation = build_as(&scene, precision, 1);
            run(&mut simulation, 1);
            assert_eq!(simulation.report().contacts, touched, "{collider:?}, {precision}");
        }
    }
}

#[test]
fn vertices_of_no_face_belong_to_a_hull() {
    let mut cube = surface(&Mesh::Cube(Cube { size: 1.0, divisions: 1 })).unwrap();
    cube.vertices.push([0.0, 4.0, 0.0]);
    let nodes = (0..cube.nodes.len() as u32).chain([u32::MAX]).collect();
    cube.node_of_vertex = Some(nodes);
    let hull = Collider::convex(Mesh::Surface(Arc::new(cube))).offset(0.0);
    let body =
        Body::cloth("cloth", Mesh::grid(3, 3, [0.01, 0.01])).with_mass(Mass::Node(0.01)).at([0.0, 3.0, 0.0]);
    let mut simulation = build_as(&Scene::new("hull").body(body).collider(hull), Precision::F64, 1);
    run(&mut simulation, 1);
    assert_eq!(simulation.report().contacts, 9);
}

#[test]
fn meshes_are_surfaces() {
    says(Collider::mesh(Mesh::chain(3, 1.0)), "collider[1].mesh", "chain");
    says(Collider::convex(Mesh::chain(3, 1.0)), "collider[1].convex", "chain");
    says(Collider::convex(grid()), "collider[1].convex", "four that are not in a plane");
    says(Collider::mesh(Mesh::File("dress.obj".into())), "collider[1].mesh", "dress.obj");
    says(Collider::mesh(data(vec![[0.0; 3]; 3], Vec::new())), "collider[1].mesh", "triangles");
    says(Collider::mesh(grid()).offset(0.0), "collider[1].offset", "two sides; more would do");
    let fit = Place { fit: Some(1.0), ..Place::default() };
    says(Collider::cuboid([0.0; 3], [1.0; 3]).placed(fit), "collider[1].place.fit", "scale would do");
}

#[test]
fn poses_fit_their_mesh() {
    let nodes = Faces::of(&grid()).nodes;
    let posed = |poses| Collider::mesh(grid()).posed(0.1, poses);
    says(
        posed(vec![nodes.clone(), nodes[..8].to_vec()]),
        "collider[1].poses",
        "pose 1 has 8 nodes, the mesh 9",
    );
    says(posed(Vec::new()), "collider[1].poses", "");
    let mut lost = nodes.clone();
    lost[4][2] = f64::NAN;
    says(posed(vec![nodes.clone(), lost]), "collider[1].poses", "node 4 of pose 1");
    let mut far = nodes.clone();
    far[4][2] = 1e30;
    says(
        posed(vec![nodes.clone(), far]),
        "collider[1].poses",
        "node 4 of pose 1 is at [0.0, 0.0, 1e30] m; within ±1000000 m",
    );
    let cube = Faces::of(&Mesh::Cube(Cube { size: 1.0, divisions: 1 }));
    let scaled = |s: f64| cube.nodes.iter().map(|x| [s * x[0], x[1], x[2]]).collect::<Vec<_>>();
    let solid = |s: f64| {
        let mesh = Collider::mesh(data(cube.nodes.clone(), cube.triangles.clone()));
        mesh.posed(0.1, vec![scaled(1.0), scaled(s)])
    };
    says(solid(-1.0), "collider[1].poses", "pose 1 turns the mesh inside out");
    assert_eq!(refused(solid(0.0)), "");
    for interval in [0.0, -1.0, f64::NAN] {
        let poses = vec![nodes.clone(); 2];
        says(Collider::mesh(grid()).posed(interval, poses), "collider[1].poses.interval", "");
    }
    says(Collider::sphere([0.0; 3], 1.0).posed(0.1, vec![nodes.clone()]), "collider[1].poses", "");
    let both = Poses { file: Some("a.pc2".into()), files: vec!["b.obj".into()], ..Poses::default() };
    says(Collider { poses: Some(both), ..Collider::mesh(grid()) }, "collider[1].poses", "file and files");
}

#[test]
fn heights_make_a_rectangle() {
    let field = |heights| Collider::heightfield([1.0, 1.0], heights);
    says(
        field(vec![vec![0.0; 3], vec![0.0; 2]]),
        "collider[1].heightfield",
        "row 1 has 2 heights, the first one 3",
    );
    says(field(vec![vec![0.0; 3]]), "collider[1].heightfield", "1 × 3");
    says(field(vec![vec![0.0]; 4]), "collider[1].heightfield", "4 × 1");
    says(field(vec![vec![0.0, 1.0], vec![f64::NAN, 0.0]]), "collider[1].heightfield.heights", "NaN");
    says(field(Vec::new()), "collider[1].heightfield", "0 × 0");
    let deep = Heightfield { depth: -1.0, heights: vec![vec![0.0; 2]; 2], size: [1.0; 2] };
    says(Collider { heightfield: Some(deep), ..Collider::default() }, "collider[1].heightfield.depth", "");
}

#[test]
fn keyframes_ascend() {
    let back = Collider::mesh(grid())
        .keyframe(Keyframe::translate(1.0, [0.0; 3]))
        .keyframe(Keyframe::translate(0.5, [1.0; 3]));
    says(back, "collider[1].motion", "");
}
