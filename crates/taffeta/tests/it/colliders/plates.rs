//! Nothing passes a thin plate at 50 m/s, whoever moves.

use super::depth::pushed;
use crate::common::plates::{HEIGHTS, ON_THE_UPPER, beside_the_upper, falling_short, thin_plates};
use crate::common::state::put;
use crate::common::{V, build_as, norm, positions, run, sub, weightless};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Cylinder, Icosphere, Keyframe, Mass, Mesh, Place, Rotation, Scene};

/// Plates of a millimetre or none, 2 m wide, in the xz plane.
fn plates() -> Vec<(&'static str, Collider)> {
    let can = Mesh::Cylinder(Cylinder { radius: 1.0, height: 1e-3, segments: 24, rings: 1, capped: true });
    let waves = (0..9).map(|row| (0..9).map(|col| 1e-3 * f64::from((row + col) % 2)).collect()).collect();
    vec![
        ("box", Collider::cuboid([0.0; 3], [1.0, 5e-4, 1.0])),
        ("cylinder", Collider::cylinder([0.0, -5e-4, 0.0], [0.0, 5e-4, 0.0], 1.0)),
        ("sheet", Collider::mesh(Mesh::grid(8, 11, [2.0, 2.0]))),
        ("closed mesh", Collider::mesh(can.clone())),
        ("hull", Collider::convex(can)),
        ("height field", Collider::heightfield([2.0, 2.0], waves)),
    ]
}

/// Free nodes over the middle of a plate, without springs.
fn nodes(y: f64) -> Body {
    Body::cloth("nodes", Mesh::grid(5, 5, [0.37, 0.37])).with_mass(Mass::Node(0.01)).at([0.013, y, 0.017])
}

fn heights(scene: &Scene, precision: Precision, frames: usize) -> Vec<V> {
    let mut simulation = build_as(scene, precision, 1);
    for _ in 0..frames {
        simulation.step().unwrap();
    }
    let mut places = Vec::new();
    simulation.positions_f64(&mut places);
    places
}

/// Nodes that fall 0.8 m in a first frame and 1.7 m in the second, in which they meet the plate: at 100 m/s.
fn thrown(plate: Collider, up: bool) -> Scene {
    let side = if up { -1.0 } else { 1.0 };
    let mut scene =
        weightless("thrown", 1.0 / 60.0, 1.0 / 60.0).body(nodes(2.0 * side)).collider(plate.offset(2e-3));
    scene.world.gravity = [0.0, -3000.0 * side, 0.0];
    scene
}

#[test]
fn nodes_at_100_metres_a_second_stay_on_their_side() {
    for (name, plate) in plates() {
        for up in [false, true] {
            for precision in [Precision::F32, Precision::F64] {
                // The ground has no lower side to hit.
                if up && name == "height field" {
                    continue;
                }
                let scene = thrown(plate.clone(), up);
                for [x, y, z] in heights(&scene, precision, 2) {
                    assert!(if up { y < 0.0 } else { y > 0.0 }, "{name}, up: {up}: {x} {y} {z}");
                }
            }
        }
    }
}

#[test]
fn a_plate_at_50_metres_a_second_takes_nodes_along() {
    for (name, plate) in plates() {
        let turn = Rotation { axis: [0.0, 1.0, 0.0], degrees: 40.0 };
        let place = Place { rotation: Some(turn), ..Place::default() };
        let moved = plate.placed(place).offset(2e-3).friction(0.0);
        let scene = weightless("swept", 1.0 / 60.0, 1.0 / 60.0)
            .body(nodes(1.0))
            .collider(moved.keyframe(Keyframe::translate(0.1, [0.0, 5.0, 0.0])));
        for [x, y, z] in heights(&scene, Precision::F32, 2) {
            assert!(y > 5.0 / 3.0, "{name}: {x} {y} {z}");
        }
    }
}

#[test]
fn a_sheet_that_goes_from_pose_to_pose_at_50_metres_a_second_takes_nodes_along() {
    let (rows, cols) = (8_u32, 11_u32);
    let at = |i: u32, count: u32| 2.0 * (f64::from(i) / f64::from(count - 1) - 0.5);
    let pose = |y: f64| -> Vec<V> {
        (0..rows * cols).map(|node| [at(node % cols, cols), y, at(node / cols, rows)]).collect()
    };
    let sheet = Collider::mesh(Mesh::grid(rows, cols, [2.0, 2.0])).posed(0.1, vec![pose(0.0), pose(5.0)]);
    for y in [0.5, 1.0, 1.3] {
        let scene = weightless("swept", 1.0 / 60.0, 1.0 / 60.0)
            .body(nodes(y))
            .collider(sheet.clone().offset(2e-3).friction(0.0));
        for [x, y, z] in heights(&scene, Precision::F32, 2) {
            assert!(y > 5.0 / 3.0, "{x} {y} {z}");
        }
    }
}

#[test]
fn cloth_that_lies_on_a_thin_plate_without_an_offset_stays_on_it() {
    let can = Mesh::Cylinder(Cylinder { radius: 0.5, height: 1e-4, segments: 24, rings: 1, capped: true });
    let mut ground = Collider::heightfield([0.8, 0.8], vec![vec![5e-5; 2]; 2]);
    ground.heightfield.iter_mut().for_each(|field| field.depth = 1e-4);
    let sheet = Body::cloth("sheet", Mesh::grid(14, 14, [0.6, 0.6]))
        .with_mass(Mass::Area(0.2))
        .structural(100.0, 0.02)
        .shear(50.0, 0.02)
        .at([0.0, 0.05, 0.0]);
    for (name, plate) in
        [("ground", ground), ("mesh", Collider::mesh(can.clone())), ("hull", Collider::convex(can))]
    {
        for precision in [Precision::F32, Precision::F64] {
            let scene = Scene::new("thin").time(1.0 / 60.0, 7e-4).body(sheet.clone()).collider(plate.clone());
            for [x, y, z] in heights(&scene, precision, 40) {
                assert!(y > 4e-5, "{name}, {precision}: {x} {y} {z}");
            }
        }
    }
}

#[test]
fn an_offset_much_larger_than_the_mesh_is_kept() {
    let speck = Mesh::Icosphere(Icosphere { radius: 0.02, subdivisions: 1 });
    let scene = weightless("speck", 1.0 / 60.0, 1.0 / 60.0)
        .body(nodes(0.3))
        .collider(Collider::mesh(speck).offset(0.45));
    for [x, y, z] in heights(&scene, Precision::F64, 1) {
        let off = (x * x + y * y + z * z).sqrt();
        assert!(off > 0.46, "{x} {y} {z}: {off}");
    }
}

#[test]
fn thin_plates_leave_nodes_alone_that_are_off_them() {
    let places = beside_the_upper();
    for precision in [Precision::F32, Precision::F64] {
        let after = pushed(thin_plates(&HEIGHTS), &places, precision);
        for (before, after) in places.iter().zip(after) {
            assert!(norm(sub(after, *before)) < 1e-6, "{precision:?}: {before:?} went to {after:?}");
        }
    }
}

#[test]
fn a_way_through_a_plate_that_ends_short_of_another_is_stopped_by_the_first() {
    let (scene, places) = falling_short();
    for precision in [Precision::F32, Precision::F64] {
        let mut simulation = build_as(&scene, precision, 1);
        put(&mut simulation, &places);
        run(&mut simulation, 1);
        for ([_, start, _], [x, y, z]) in places.iter().zip(positions(&simulation)) {
            assert!((y - ON_THE_UPPER).abs() < 1e-6, "{precision:?}: from {start} to {x} {y} {z}");
        }
    }
}

#[test]
fn cloth_that_slides_off_a_thin_plate_wins_no_energy() {
    let sheet = Body::cloth("sheet", Mesh::grid(14, 14, [1.0, 1.0]))
        .with_mass(Mass::Node(0.005))
        .at([0.0, 0.25, 0.0]);
    let sheet = sheet.structural(50.0, 0.02).shear(50.0, 0.02).bend(5.0, 0.02);
    let scene = Scene::new("plate").time(1.0 / 60.0, 5e-4).body(sheet).collider(thin_plates(&[0.0]));
    let mut simulation = build_as(&scene, Precision::F32, 1);
    let mut before = simulation.report().energy();
    for frame in 0..60 {
        let energy = simulation.step().unwrap().energy();
        assert!(energy < before + 1e-3, "frame {frame}: {before} J became {energy} J");
        before = energy;
    }
}
