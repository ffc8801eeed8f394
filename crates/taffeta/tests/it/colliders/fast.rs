//! Nothing passes a sheet at 50 m/s: slanted ones, grooves, rims of turning plates, and sheets that poses move.

use super::depth::data;
use super::reference::{Faces, turn};
use crate::common::{V, add, build_as, norm, positions, run, sub, turned, weightless};
use taffeta::scene::{
    Acad, Body, Collider, ConstraintForm, Cylinder, Ice, Keyframe, Mass, Mesh, Method, Scene, Solver,
};
use taffeta::{Precision, Simulation};

const STEPS: [f64; 4] = [1.0 / 60.0, 1.0 / 130.0, 1.0 / 400.0, 0.001];
const PRECISIONS: [Precision; 2] = [Precision::F32, Precision::F64];
const OFFSET: f64 = 2e-3;

/// Plates in the xz plane, 2 m wide.
fn plates() -> Vec<(&'static str, Collider)> {
    let can = Mesh::Cylinder(Cylinder { radius: 1.0, height: 1e-3, segments: 24, rings: 1, capped: true });
    vec![
        ("box", Collider::cuboid([0.0; 3], [1.0, 5e-4, 1.0])),
        ("cylinder", Collider::cylinder([0.0, -5e-4, 0.0], [0.0, 5e-4, 0.0], 1.0)),
        ("sheet", Collider::mesh(Mesh::grid(8, 11, [2.0, 2.0]))),
        ("closed mesh", Collider::mesh(can.clone())),
        ("hull", Collider::convex(can)),
    ]
}

/// Free nodes about a place, without springs.
fn nodes(at: V) -> Body {
    Body::cloth("nodes", Mesh::grid(7, 7, [0.53, 0.53])).with_mass(Mass::Node(0.01)).at(at)
}

/// Whether a place in a plate's frame is over its middle.
fn over([x, _, z]: V) -> bool {
    x * x + z * z < 0.98
}

/// Runs, and finds nodes over the plate on its upper side, or none anywhere near.
fn stay_above(what: &str, scene: &Scene, precision: Precision, time: f64, own: impl Fn(V, f64) -> V) {
    let mut simulation = build_as(scene, precision, 1);
    let mut contacts = 0;
    while simulation.report().time < time {
        run(&mut simulation, 1);
        let t = simulation.report().time;
        contacts = contacts.max(simulation.report().contacts);
        for x in positions(&simulation) {
            let place = own(x, t);
            assert!(
                place[1] > 0.0 || !over(place),
                "{what}, {precision}, {t} s: {x:?} is at {place:?} of it"
            );
        }
    }
    assert!(contacts > 20, "{what}, {precision}: {contacts} contacts");
}

#[test]
fn slanted_plates_are_not_passed() {
    for (name, plate) in plates() {
        for (axis, degrees) in [([0.0, 0.0, 1.0], 35.0), ([1.0, 0.0, 0.7], -60.0)] {
            for (h, precision) in STEPS.into_iter().flat_map(|h| PRECISIONS.map(|p| (h, p))) {
                let plate =
                    plate.clone().placed(turned(axis, degrees, [0.0; 3])).offset(OFFSET).friction(0.0);
                // 0.8 m down at 1500 m/s²: 49 m/s.
                let mut scene = weightless(name, h, h).body(nodes([0.01, 0.8, 0.02])).collider(plate);
                scene.world.gravity = [0.0, -1500.0, 0.0];
                let own = |x, _| turn(axis, -degrees, x);
                stay_above(&format!("{name} at {degrees}°, {h} s"), &scene, precision, 0.045, own);
            }
        }
    }
}

#[test]
fn turning_plates_take_along_what_is_near_their_rims() {
    let pivot = [-1.0, 0.0, 0.0];
    // 2 m from the pivot, 25 rad/s.
    let degrees = 25.0_f64.to_degrees();
    let axis = [0.0, 0.0, 1.0];
    for (name, plate) in plates() {
        for (h, precision) in STEPS.into_iter().flat_map(|h| PRECISIONS.map(|p| (h, p))) {
            let key = Keyframe::rotate(1.0, axis, degrees, pivot);
            let plate = plate.clone().offset(OFFSET).friction(0.0).keyframe(key);
            let scene = weightless(name, h, h).body(nodes([0.5, 0.6, 0.0])).collider(plate);
            let own = |x, t: f64| add(turn(axis, -degrees * t, sub(x, pivot)), pivot);
            stay_above(&format!("{name}, {h} s"), &scene, precision, 0.06, own);
        }
    }
}

#[test]
fn sheets_that_poses_move_take_nodes_along() {
    let faces = Faces::of(&Mesh::grid(8, 11, [2.0, 2.0]));
    for interval in [0.0173, 0.04, 0.2] {
        for (h, precision) in STEPS.into_iter().flat_map(|h| PRECISIONS.map(|p| (h, p))) {
            // 50 m/s upward, while the middle lags behind and catches up.
            let lag = |x: &V, i: i32| if i % 2 == 1 { 0.1 * (1.0 - x[0] * x[0]) } else { 0.0 };
            let height = |x: &V, i: i32| 50.0 * interval * f64::from(i) - lag(x, i);
            let at = |i: i32| faces.nodes.iter().map(|x| add(*x, [0.0, height(x, i), 0.0])).collect();
            let poses: Vec<Vec<V>> = (0..16).map(at).collect();
            let sheet = Collider::mesh(data(faces.nodes.clone(), faces.triangles.clone()));
            let sheet = sheet.posed(interval, poses).offset(OFFSET).friction(0.0);
            let scene = weightless("poses", h, h).body(nodes([0.01, 0.7, 0.02])).collider(sheet);
            let own = |x: V, t: f64| sub(x, [0.0, 50.0 * t - 0.11, 0.0]);
            stay_above(&format!("poses of {interval} s, {h} s"), &scene, precision, 0.15, own);
        }
    }
}

#[test]
fn poses_that_come_faster_than_sub_steps_take_nodes_along() {
    let faces = Faces::of(&Mesh::grid(8, 11, [2.0, 2.0]));
    let h = 1.0 / 60.0;
    // The last three take a whole number of sub-steps, one to rounding, and less than one.
    let films =
        [(77.0, 40), (240.0, 120), (333.3, 160), (1000.0, 500), (120.0, 61), (119.999999, 61), (1000.0, 17)];
    for (rate, count) in films {
        for (speed, precision) in [1.0, 7.0, 50.0].into_iter().flat_map(|v| PRECISIONS.map(|p| (v, p))) {
            let at = |i: i32| {
                faces.nodes.iter().map(|x| add(*x, [0.0, speed / rate * f64::from(i), 0.0])).collect()
            };
            let poses: Vec<Vec<V>> = (0..count).map(at).collect();
            let end = f64::from(count - 1) / rate;
            let sheet = Collider::mesh(data(faces.nodes.clone(), faces.triangles.clone()));
            let sheet = sheet.posed(1.0 / rate, poses).offset(OFFSET).friction(0.0);
            let scene =
                weightless("dense", h, h).body(nodes([0.01, 0.1 * speed * end, 0.02])).collider(sheet);
            let mut simulation = build_as(&scene, precision, 1);
            let what = format!("{count} poses, {rate} a second, {speed} m/s, {precision}");
            let mut contacts = 0;
            while simulation.report().time < end + h {
                run(&mut simulation, 1);
                contacts = contacts.max(simulation.report().contacts);
                for share in [0.3, 0.7, 1.0] {
                    let t = simulation.report().time + (share - 1.0) * h;
                    let level = speed * t.min(end);
                    let own = collider_nodes(&simulation, share);
                    assert!(own.iter().all(|x| (x[1] - level).abs() < 1e-6), "{what}, {t} s: {:?}", own[0]);
                }
                let level = speed * simulation.report().time.min(end);
                for x in positions(&simulation) {
                    assert!(x[1] > level, "{what}, {} s: {x:?}", simulation.report().time);
                }
            }
            assert_eq!(contacts, 49, "{what}");
        }
    }
}

/// Nodes of the first collider, which changes its shape.
fn collider_nodes(simulation: &Simulation, share: f64) -> Vec<V> {
    simulation.collider_nodes(simulation.colliders()[0].handle, share).unwrap().unwrap()
}

#[test]
fn of_dense_poses_sub_steps_that_are_a_whole_number_of_them_see_what_the_file_has() {
    let faces = Faces::of(&Mesh::grid(3, 3, [1.0, 1.0]));
    let turned = |i: i32| faces.nodes.iter().map(|&x| turn([0.0, 0.0, 1.0], 3.0 * f64::from(i), x)).collect();
    let poses: Vec<Vec<V>> = (0..103).map(turned).collect();
    let sheet = Collider::mesh(data(faces.nodes.clone(), faces.triangles.clone()));
    let scene = weightless("whole", 0.02, 0.02)
        .body(nodes([9.0, 9.0, 9.0]))
        .collider(sheet.posed(0.005, poses.clone()).offset(OFFSET));
    let mut simulation = build_as(&scene, Precision::F64, 1);
    for frame in 1..30_usize {
        run(&mut simulation, 1);
        let own = collider_nodes(&simulation, 1.0);
        for (x, given) in own.iter().zip(&poses[(4 * frame).min(102)]) {
            assert!(norm(sub(*x, *given)) < 1e-12, "frame {frame}: {x:?}, not {given:?}");
        }
    }
}

/// Two sheets that meet in a line along z, at ±`slope`.
fn groove(slope: f64) -> Mesh {
    let nodes = (0..15).map(|i| {
        let x = f64::from(i % 3 - 1);
        [x, slope * x.abs(), f64::from(i / 3 - 2)]
    });
    let triangles = (0..8).flat_map(|i: u32| {
        let [a, b] = [i / 2 * 3 + i % 2, i / 2 * 3 + i % 2 + 1];
        [[a, a + 3, b], [b, a + 3, b + 3]]
    });
    data(nodes.collect(), triangles.collect())
}

#[test]
fn nodes_do_not_leave_a_groove_by_its_bottom() {
    for slope in [0.3, 1.0, 2.0, 4.0] {
        for (h, precision) in STEPS.into_iter().flat_map(|h| PRECISIONS.map(|p| (h, p))) {
            for friction in [0.0, 0.5] {
                let sheet = Collider::mesh(groove(slope)).offset(OFFSET).friction(friction);
                let mut scene =
                    weightless("groove", h, h).body(nodes([0.01, slope + 0.3, 0.02])).collider(sheet);
                scene.world.gravity = [0.0, -1500.0, 0.0];
                let mut simulation = build_as(&scene, precision, 1);
                for _ in 0..(0.1 / h) as u32 {
                    run(&mut simulation, 1);
                    for [x, y, z] in positions(&simulation) {
                        let up = y - slope * x.abs();
                        assert!(
                            up > 0.0 || y > slope,
                            "slope {slope}, {h} s, μ {friction}, {precision}: {x} {y} {z} is {up} over it"
                        );
                    }
                }
            }
        }
    }
}

#[test]
fn springs_that_are_solved_for_do_not_pull_cloth_through() {
    let form = |form| Ice { form, ..Ice::default() };
    let solvers = [
        Solver { method: Method::Ice, ice: form(ConstraintForm::Compliant), ..Solver::default() },
        Solver { method: Method::Ice, ice: form(ConstraintForm::Primal), ..Solver::default() },
        Solver { method: Method::Acad, acad: Acad::default(), ..Solver::default() },
    ];
    for (solver, (name, plate)) in
        solvers.iter().flat_map(|solver| plates().into_iter().map(move |p| (solver, p)))
    {
        for precision in PRECISIONS {
            let cloth = nodes([0.01, 0.9, 0.02]).structural(500.0, 0.05).shear(300.0, 0.05);
            let plate = plate.clone().offset(OFFSET).friction(0.2);
            let mut scene = weightless(name, 0.005, 0.005).body(cloth).collider(plate);
            scene.world.gravity = [0.0, -1500.0, 0.0];
            scene.solver = solver.clone();
            let what = format!("{name}, {:?} {:?}", solver.method, solver.ice.form);
            stay_above(&what, &scene, precision, 0.1, |x, _| x);
        }
    }
}

/// A funnel of 9 triangles with its tip at the origin, 2 m wide.
fn funnel(slope: f64) -> Mesh {
    let rim = (0..9).map(|i| {
        let (sin, cos) = (f64::from(i) * std::f64::consts::TAU / 9.0).sin_cos();
        [cos, slope, sin]
    });
    data(rim.chain([[0.0; 3]]).collect(), (0..9).map(|i| [9, (i + 1) % 9, i]).collect())
}

#[test]
fn nodes_do_not_leave_a_funnel_by_its_tip() {
    let mut leaks = 0;
    for slope in [0.5, 1.0, 3.0] {
        for (h, precision) in STEPS.into_iter().flat_map(|h| PRECISIONS.map(|p| (h, p))) {
            for friction in [0.0, 0.5] {
                let sheet = Collider::mesh(funnel(slope)).offset(OFFSET).friction(friction);
                let mut scene =
                    weightless("funnel", h, h).body(nodes([0.01, slope + 0.3, 0.02])).collider(sheet);
                scene.world.gravity = [0.0, -1500.0, 0.0];
                let mut simulation = build_as(&scene, precision, 1);
                let mut out = Vec::new();
                for _ in 0..(0.1 / h) as u32 {
                    run(&mut simulation, 1);
                    out.extend(positions(&simulation).into_iter().filter(|x| x[1] < 0.0));
                }
                println!(
                    "funnel {slope}, {h} s, μ {friction}, {precision}: {} below, {:?}",
                    out.len(),
                    out.first()
                );
                leaks += out.len();
            }
        }
    }
    assert_eq!(leaks, 0);
}
