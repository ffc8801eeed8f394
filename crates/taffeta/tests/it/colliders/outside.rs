//! No node is inside of a collider after any sub-step, whatever its shape and however it moves.

use super::depth::{data, shapes};
use super::reference::{Faces, Form, turn};
use crate::common::{V, add, build_as, positions, run, scale, sub};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Scene, Torus};

const STEP: f64 = 0.008;

fn sheet(height: f64) -> Body {
    Body::cloth("sheet", Mesh::grid(15, 15, [2.1, 2.1]))
        .at([0.113, height, -0.117])
        .with_mass(Mass::Node(0.02))
        .structural(100.0, 0.1)
        .shear(100.0, 0.1)
        .bend(20.0, 0.05)
}

/// What moves a collider, and where a place of the scene is in the collider's frame at a time.
type Motion = (&'static str, Option<Keyframe>, fn(V, f64) -> V);

const LEAN: V = [0.3, 0.2, 1.0];

fn share(t: f64) -> f64 {
    (t / 0.5).min(1.0)
}

fn motions() -> [Motion; 3] {
    const WAY: V = [0.5, 0.9, -0.3];
    [
        ("at rest", None, |x, _| x),
        ("shifted", Some(Keyframe::translate(0.5, WAY)), |x, t| sub(x, scale(WAY, share(t)))),
        ("turned", Some(Keyframe::rotate(0.5, LEAN, 200.0, [0.1, 0.0, 0.0])), |x, t| {
            add(turn(LEAN, -200.0 * share(t), sub(x, [0.1, 0.0, 0.0])), [0.1, 0.0, 0.0])
        }),
    ]
}

/// Runs, and returns the deepest that any node has been inside [m], and the most contacts.
fn deepest(scene: &Scene, precision: Precision, frames: u32, off: impl Fn(V, f64) -> f64) -> (f64, u64) {
    let mut simulation = build_as(scene, precision, 1);
    let (mut deepest, mut contacts) = (f64::NEG_INFINITY, 0);
    for _ in 0..frames {
        run(&mut simulation, 1);
        let time = simulation.report().time;
        let inside = positions(&simulation).into_iter().map(|x| -off(x, time));
        deepest = inside.fold(deepest, f64::max);
        contacts = contacts.max(simulation.report().contacts);
    }
    (deepest, contacts)
}

fn slack(precision: Precision) -> f64 {
    if precision == Precision::F32 { 2e-6 } else { 1e-12 }
}

fn stays_out(precision: Precision, frames: u32) {
    for (name, collider) in shapes() {
        let form = Form::of(&collider);
        for (how, key, own) in motions() {
            let mut moved = collider.clone().offset(0.02).friction(0.3);
            moved.motion.extend(key);
            let scene = Scene::new(name).time(STEP, STEP).body(sheet(1.15)).collider(moved);
            let (inside, contacts) =
                deepest(&scene, precision, frames, |x, t| form.distance(own(x, t)) - 0.02);
            println!("{name} {how} {precision}: {inside:e} m, {contacts} contacts");
            assert!(inside <= slack(precision), "{name} {how} {precision}: {inside:e} m inside");
            assert!(contacts > 5, "{name} {how}: {contacts}");
        }
    }
}

#[test]
fn no_node_is_inside_of_any_shape_in_64_bits() {
    stays_out(Precision::F64, 90);
}

#[test]
fn no_node_is_inside_of_any_shape_in_32_bits() {
    stays_out(Precision::F32, 60);
}

/// A mesh between poses.
fn between(poses: &[Vec<V>], interval: f64, triangles: &[[u32; 3]], t: f64) -> Faces {
    let time = (t / interval).clamp(0.0, poses.len() as f64 - 1.0);
    let pose = (time as usize).min(poses.len() - 2);
    let share = time - pose as f64;
    let mix = |(a, b): (&V, &V)| add(scale(*a, 1.0 - share), scale(*b, share));
    Faces {
        nodes: poses[pose].iter().zip(&poses[pose + 1]).map(mix).collect(),
        triangles: triangles.to_vec(),
    }
}

/// A mesh that goes through poses of `bend` under a sheet; a sub-step is no whole part of the time between them.
fn changes_shape(name: &str, mesh: &Mesh, bend: impl Fn(V, f64) -> V, precision: Precision) {
    let faces = Faces::of(mesh);
    let poses: Vec<Vec<V>> =
        (0..9).map(|i| faces.nodes.iter().map(|x| bend(*x, f64::from(i))).collect()).collect();
    let collider = Collider::mesh(data(poses[0].clone(), faces.triangles.clone())).offset(0.02);
    let collider = collider.posed(0.05, poses.clone()).friction(0.2);
    let scene = Scene::new(name).time(STEP, STEP).body(sheet(1.05)).collider(collider);
    let (inside, contacts) = deepest(&scene, precision, 75, |x, t| {
        let faces = between(&poses, 0.05, &faces.triangles, t);
        let form = if name == "sheet" { Form::Sheet(faces) } else { Form::Solid(faces) };
        form.distance(x) - 0.02
    });
    println!("{name} {precision}: {inside:e} m, {contacts} contacts");
    assert!(
        inside <= slack(precision) && contacts > 5,
        "{name} {precision}: {inside:e} m, {contacts} contacts"
    );
}

#[test]
fn no_node_is_inside_of_a_mesh_that_changes_its_shape() {
    for precision in [Precision::F64, Precision::F32] {
        let ball = Mesh::Icosphere(Icosphere { radius: 0.8, subdivisions: 2 });
        let breathe = |x: V, t: f64| scale(x, 1.0 + 0.25 * (t * 1.3).sin());
        changes_shape("breathing ball", &ball, breathe, precision);
        let torus = Mesh::Torus(Torus { major: 0.7, minor: 0.25, rings: 16, segments: 8 });
        let twist = |x: V, t: f64| turn([1.0, 0.0, 0.3], 15.0 * t * x[0], add(x, [0.0, 0.05 * t, 0.0]));
        changes_shape("twisting torus", &torus, twist, precision);
        let wave =
            |[x, y, z]: V, t: f64| [x, y + 0.9 + 0.2 * (3.0 * x + 1.7 * t).sin() * (t / 3.0).min(1.0), z];
        changes_shape("sheet", &Mesh::grid(13, 13, [2.6, 2.6]), wave, precision);
    }
}
