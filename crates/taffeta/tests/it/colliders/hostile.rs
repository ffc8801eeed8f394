//! Meshes that nobody should make, as colliders.

use super::depth::data;
use super::reference::{Faces, Form};
use crate::common::{V, add, norm, positions, run, scale};
use std::f64::consts::PI;
use taffeta::scene::{Body, Collider, Cube, Icosphere, Mass, Mesh, Scene};
use taffeta::{Options, Precision, Simulation};

fn build(mesh: Mesh, precision: Precision) -> Result<Simulation, String> {
    falling(Collider::mesh(mesh), precision)
}

/// Cloth that falls onto a collider.
fn falling(collider: Collider, precision: Precision) -> Result<Simulation, String> {
    let cloth = Body::cloth("cloth", Mesh::grid(14, 14, [1.7, 1.7]))
        .at([0.013, 1.05, 0.017])
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.05)
        .shear(30.0, 0.05);
    let scene = Scene::new("hostile").time(0.01, 0.005).body(cloth).collider(collider.offset(0.02));
    let options = Options { threads: Some(1), precision, ..Options::default() };
    Simulation::new(&scene, &options).map_err(|error| error.to_string())
}

/// Cloth falls on it and keeps its distance from all triangles.
fn bears(name: &str, faces: &Faces) {
    for (precision, slack) in [(Precision::F64, 1e-12), (Precision::F32, 2e-6)] {
        let mesh = data(faces.nodes.clone(), faces.triangles.clone());
        let mut simulation = build(mesh, precision).unwrap_or_else(|error| panic!("{name}: {error}"));
        let form = Form::Sheet(faces.clone());
        let mut contacts = 0;
        for frame in 0..90 {
            run(&mut simulation, 1);
            contacts = contacts.max(simulation.report().contacts);
            for x in positions(&simulation) {
                let off = form.distance(x);
                assert!(off >= 0.02 - slack, "{name}, {precision}, frame {frame}: {x:?} is {off} m off");
            }
        }
        assert!(contacts > 0, "{name}: no contacts");
    }
}

fn moebius() -> Faces {
    let n = 24;
    let nodes = (0..2 * n).map(|i| {
        let around = PI * f64::from(i / 2) * 2.0 / f64::from(n);
        let aside = 0.3 * f64::from(i % 2 * 2 - 1);
        let (sin, cos) = around.sin_cos();
        let (half_sin, half_cos) = (around / 2.0).sin_cos();
        let out = 0.6 + aside * half_cos;
        [out * cos, aside * half_sin, out * sin]
    });
    let triangles = (0..n as u32).flat_map(|i| {
        let [a, b] = [2 * i, 2 * i + 1];
        let [c, d] = if i + 1 < n as u32 { [2 * i + 2, 2 * i + 3] } else { [1, 0] };
        [[a, b, c], [c, b, d]]
    });
    Faces { nodes: nodes.collect(), triangles: triangles.collect() }
}

/// A square in the xz plane of two triangles.
fn square() -> Faces {
    let nodes = vec![[-0.6, 0.0, -0.6], [0.6, 0.0, -0.6], [-0.6, 0.0, 0.6], [0.6, 0.0, 0.6]];
    Faces { nodes, triangles: vec![[0, 2, 1], [1, 2, 3]] }
}

fn with(mut faces: Faces, nodes: &[V], triangles: &[[u32; 3]]) -> Faces {
    faces.nodes.extend(nodes);
    faces.triangles.extend(triangles);
    faces
}

#[test]
fn surfaces_that_are_no_manifold_are_borne_on() {
    bears("Möbius strip", &moebius());
    let fins = [[0.0, 0.5, 0.0], [0.1, -0.5, 0.0], [-0.5, 0.2, 0.2]];
    bears("fins", &with(square(), &fins, &[[1, 2, 4], [1, 2, 5], [2, 1, 6]]));
    bears("twice the same", &with(square(), &[], &[[0, 2, 1], [1, 2, 0], [1, 2, 3]]));
    bears("one triangle", &Faces { triangles: vec![[0, 2, 1]], ..square() });
    // A cube whose lid is another mesh's, and two cubes with a corner in common.
    let mut open = Faces::of(&Mesh::Cube(Cube { size: 1.0, divisions: 2 }));
    open.triangles.pop();
    bears("a cube with a hole", &open);
}

#[test]
fn triangles_without_area_are_refused_and_poses_may_bring_them() {
    let needle = [[0.0, 0.0, 0.0], [0.2, 0.0, 0.0], [0.4, 0.0, 0.0]];
    for faces in [
        with(square(), &needle, &[[4, 5, 6]]),
        with(square(), &[[0.1, 0.0, 0.1]; 3], &[[4, 5, 6]]),
        with(square(), &[], &[[1, 1, 2]]),
    ] {
        let message = build(data(faces.nodes, faces.triangles), Precision::F32).err().unwrap_or_default();
        assert!(message.starts_with("collider[0].mesh: triangle 2 "), "{message}");
    }
    // A ball that collapses to a disk, a line, a point, and comes back.
    let ball = Faces::of(&Mesh::Icosphere(Icosphere { radius: 0.9, subdivisions: 2 }));
    let flat = |scales: V| ball.nodes.iter().map(|x| [0, 1, 2].map(|i| x[i] * scales[i])).collect();
    let poses = [[1.0; 3], [1.0, 0.0, 1.0], [1.0, 0.0, 0.0], [0.0; 3], [1.0; 3]].map(flat).to_vec();
    for precision in [Precision::F64, Precision::F32] {
        let mesh = data(ball.nodes.clone(), ball.triangles.clone());
        let mut simulation = falling(Collider::mesh(mesh).posed(0.1, poses.clone()), precision).unwrap();
        run(&mut simulation, 60);
        for x in positions(&simulation) {
            assert!(norm(x) > 0.85, "{precision}: {x:?}");
        }
    }
}

#[test]
fn large_and_small_triangles_may_meet() {
    // A square of a micrometre in the middle of one of a metre and more, which is cut towards it.
    let small = 1e-5;
    let inner: Vec<V> = square().nodes.iter().map(|x| scale(*x, small)).collect();
    let nodes: Vec<V> = square().nodes.into_iter().chain(inner).collect();
    let ring = [[0, 4, 5], [0, 5, 1], [1, 5, 7], [1, 7, 3], [3, 7, 6], [3, 6, 2], [2, 6, 4], [2, 4, 0]];
    let mut triangles = ring.to_vec();
    triangles.extend([[4, 6, 5], [5, 6, 7]]);
    bears("1e5", &Faces { nodes, triangles });
}

#[test]
fn a_fan_of_many_triangles_has_a_tip() {
    let n = 150;
    let rim = (0..n).map(|i| {
        let (sin, cos) = (2.0 * PI * f64::from(i) / f64::from(n)).sin_cos();
        [0.7 * cos, 0.0, 0.7 * sin]
    });
    let nodes: Vec<V> = rim.chain([[0.0, 0.9, 0.0], [0.0, -0.9, 0.0]]).collect();
    let n = n as u32;
    let cone = (0..n).map(|i| [n, (i + 1) % n, i]);
    bears("cone", &Faces { nodes: nodes.clone(), triangles: cone.clone().collect() });
    let both = cone.chain((0..n).map(|i| [n + 1, i, (i + 1) % n])).collect();
    bears("two cones", &Faces { nodes, triangles: both });
}

#[test]
fn two_solids_in_one_mesh_are_both_solid() {
    let ball = Faces::of(&Mesh::Icosphere(Icosphere { radius: 0.4, subdivisions: 2 }));
    let other: Vec<V> = ball.nodes.iter().map(|x| add(*x, [0.9, 0.0, 0.2])).collect();
    let first = ball.nodes.len() as u32;
    let more: Vec<[u32; 3]> = ball.triangles.iter().map(|t| t.map(|i| i + first)).collect();
    bears("two balls", &with(ball, &other, &more));
}

#[test]
fn what_is_no_surface_is_refused() {
    let refused = |nodes: Vec<V>, triangles: Vec<[u32; 3]>| {
        build(data(nodes, triangles), Precision::F32).err().unwrap_or_default()
    };
    let faces = square();
    let mut nodes = faces.nodes.clone();
    nodes[2][1] = f64::NAN;
    for (what, message) in [
        ("NaN", refused(nodes.clone(), faces.triangles.clone())),
        ("no triangles", refused(faces.nodes.clone(), Vec::new())),
        ("nothing", refused(Vec::new(), Vec::new())),
        ("beyond", refused(faces.nodes.clone(), vec![[0, 2, 9]])),
    ] {
        println!("{what}: {message}");
        assert!(message.starts_with("collider[0].mesh"), "{what}: {message}");
    }
    nodes[2][1] = 1e300;
    let huge = refused(nodes, faces.triangles);
    println!("{huge}");
    assert!(!huge.is_empty());
}
