//! An open mesh has two sides and a border.

use super::depth::data;
use super::reference::{Faces, Form};
use crate::common::{V, add, build_as, positions, run, turned, weightless};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Scene, VolumeForm};

const OFFSET: f64 = 0.01;

fn nodes(name: &str, size: f64, at: V) -> Body {
    Body::cloth(name, Mesh::grid(9, 9, [size, size])).with_mass(Mass::Node(0.01)).at(at)
}

/// Of a sheet that goes up and down at up to 8 m/s, at tenths of a second [m].
fn height(i: i32) -> f64 {
    if i == 0 { 0.0 } else { f64::from(i.min(19) % 2) * 0.8 - 0.4 }
}

#[test]
fn nodes_stay_on_their_side_of_a_sheet_that_goes_up_and_down() {
    for precision in [Precision::F64, Precision::F32] {
        let mut sheet = Collider::mesh(Mesh::grid(6, 7, [3.0, 3.0])).offset(OFFSET).friction(0.1);
        for i in 1..20 {
            sheet = sheet.keyframe(Keyframe::translate(0.1 * f64::from(i), [0.0, height(i), 0.0]));
        }
        let scene = weightless("sides", 0.005, 0.005)
            .body(nodes("above", 1.0, [0.0, 0.013, 0.0]))
            .body(nodes("below", 1.0, [0.1, -0.013, 0.05]))
            .collider(sheet);
        let mut simulation = build_as(&scene, precision, 1);
        let slack = if precision == Precision::F32 { 1e-6 } else { 1e-12 };
        let mut contacts = 0;
        for frame in 0..300 {
            run(&mut simulation, 1);
            let t = simulation.report().time;
            let (i, share) = ((t / 0.1) as i32, (t / 0.1).fract());
            let level = height(i) + (height(i + 1) - height(i)) * share;
            for (node, [x, y, z]) in positions(&simulation).into_iter().enumerate() {
                let off = if node < 81 { y - level } else { level - y };
                assert!(off >= OFFSET - slack, "{precision}, frame {frame}, node {node}: {off} at {x} {z}");
            }
            contacts = contacts.max(simulation.report().contacts);
        }
        assert!(contacts >= 40, "{contacts}");
    }
}

#[test]
fn cloth_pressed_from_both_sides_stays_on_both() {
    // Weight from above on the upper side; the sheet itself goes down onto what is below, which a floor bears.
    let sheet = Collider::mesh(Mesh::grid(6, 7, [3.0, 3.0])).offset(OFFSET);
    let sheet = sheet.keyframe(Keyframe::translate(1.0, [0.0, -0.17, 0.0]));
    let floor = Collider::plane([0.0, -0.2, 0.0], [0.0, 1.0, 0.0]).offset(0.005);
    let scene = Scene::new("pressed")
        .time(0.01, 0.005)
        .body(nodes("above", 1.0, [0.0, 0.013, 0.0]))
        .body(nodes("below", 1.0, [0.1, -0.1, 0.05]))
        .collider(floor)
        .collider(sheet);
    let mut simulation = build_as(&scene, Precision::F32, 1);
    for _ in 0..150 {
        run(&mut simulation, 1);
        let level = -0.17 * simulation.report().time.min(1.0);
        for (node, [x, y, z]) in positions(&simulation).into_iter().enumerate() {
            let off = if node < 81 { y - level } else { level - y };
            assert!(off >= OFFSET - 1e-6 && y >= -0.195 - 1e-6, "node {node}: {x} {y} {z}, {off}");
        }
    }
}

#[test]
fn nodes_at_the_border_slide_off() {
    let sheet = Collider::mesh(Mesh::grid(6, 7, [1.0, 1.0])).offset(OFFSET).friction(0.0);
    let form = Form::of(&sheet);
    let mut row = nodes("row", 0.2, [0.0; 3]);
    // From 6 mm within the border to 14 mm beyond.
    row.mesh = Mesh::chain(10, 0.02);
    row.place.position = [0.504, 0.03, 0.1];
    let mut simulation =
        build_as(&Scene::new("border").time(0.002, 0.002).body(row).collider(sheet), Precision::F64, 1);
    for _ in 0..300 {
        run(&mut simulation, 1);
        for x in positions(&simulation) {
            assert!(form.distance(x) >= OFFSET - 1e-12, "{x:?}: {}", form.distance(x));
        }
    }
    for [x, y, _] in positions(&simulation) {
        assert!(if x <= 0.5 { (y - OFFSET).abs() < 1e-9 } else { y < -0.5 }, "{x} {y}");
    }
}

#[test]
fn cloth_that_hangs_over_the_border_slides_off() {
    let sheet = Collider::mesh(Mesh::grid(6, 7, [1.0, 1.0])).offset(OFFSET).friction(0.0);
    let form = Form::of(&sheet);
    let mut cloth = nodes("cloth", 0.6, [0.4, 0.011, 0.0]).structural(100.0, 0.2).shear(50.0, 0.1);
    cloth.place = turned([0.0, 1.0, 0.0], 0.0, [0.4, 0.011, 0.013]);
    let mut simulation =
        build_as(&Scene::new("over").time(0.005, 0.001).body(cloth).collider(sheet), Precision::F32, 1);
    for _ in 0..300 {
        run(&mut simulation, 1);
        for x in positions(&simulation) {
            assert!(form.distance(x) >= OFFSET - 1e-6, "{x:?}: {}", form.distance(x));
        }
    }
    let highest = positions(&simulation).iter().map(|x| x[1]).fold(f64::NEG_INFINITY, f64::max);
    assert!(highest < -0.5, "{highest}");
}

#[test]
fn nodes_at_rest_on_a_sheet_with_little_offset_stay() {
    let slope = 25.0;
    for precision in [Precision::F64, Precision::F32] {
        let faces = Faces::of(&Mesh::grid(6, 7, [2.0, 2.0]));
        let sheet = Collider::mesh(data(faces.nodes, faces.triangles)).offset(1e-5).friction(0.9);
        let place = turned([0.3, 0.1, 1.0], slope, [0.3, 1.7, 0.2]);
        let mut body = nodes("nodes", 0.6, [0.0; 3]);
        body.place = turned([0.3, 0.1, 1.0], slope, [0.3, 1.72, 0.2]);
        let scene = Scene::new("thin").time(0.01, 0.005).body(body).collider(sheet.placed(place));
        let mut simulation = build_as(&scene, precision, 1);
        run(&mut simulation, 200);
        let lowest = positions(&simulation).iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
        assert!(lowest > 1.3, "{precision}: {lowest}");
    }
}

#[test]
fn a_ball_that_is_put_right_does_not_meet_the_sheet_where_it_was() {
    // Both fall, the sheet 30 mm below, and up to 40 mm in a sub-step; volumes are restored where the sheet has arrived.
    let ball = Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 2 });
    let ball =
        Body::soft("ball", ball).with_mass(Mass::Whole(10.0)).structural(80.0, 0.05).at([0.0, 0.2, 0.0]);
    let faces = Faces::of(&Mesh::grid(6, 7, [2.0, 2.0]));
    let h = 0.005;
    let level = |t: f64| -0.03 - 9.81 * t * (t + h) / 2.0;
    let poses = (0..21)
        .map(|i| faces.nodes.iter().map(|x| add(*x, [0.0, level(0.05 * f64::from(i)), 0.0])).collect());
    let sheet = Collider::mesh(data(faces.nodes.clone(), faces.triangles.clone()));
    let sheet = sheet.posed(0.05, poses.collect()).offset(0.005);
    let scene =
        Scene::new("falling").time(h, h).body(ball.keep_volume(VolumeForm::Projected)).collider(sheet);
    let mut simulation = build_as(&scene, Precision::F64, 1);
    simulation.disturb(1e-3, 3);
    for _ in 0..170 {
        run(&mut simulation, 1);
        let lowest = positions(&simulation).iter().map(|x| x[1]).fold(f64::INFINITY, f64::min);
        let time = simulation.report().time;
        assert_eq!(simulation.report().contacts, 0, "{time} s: {lowest} over {}", level(time));
        assert!(lowest > level(simulation.report().time) + 0.005, "{lowest}");
    }
}
