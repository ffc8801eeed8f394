//! Nodes that a collider carries.

use super::panel;
use crate::common::{
    V, add, build, build_as, cross, dot, near, norm, positions, run, scale, scene_error, state, sub, warnings,
};
use taffeta::scene::{Body, Collider, Keyframe, Pin, Scene, Select};
use taffeta::{Options, Precision, Simulation};

const AXIS: V = [0.2, 0.9, -0.3];
const PIVOT: V = [0.1, 0.0, 0.2];

fn drum() -> Collider {
    let turn = |t, degrees, translate| Keyframe { translate, ..Keyframe::rotate(t, AXIS, degrees, PIVOT) };
    let mut drum = Collider::sphere([0.0, -0.5, 0.0], 0.3);
    drum.name = "drum".to_owned();
    drum.motion = vec![turn(0.5, 90.0, [0.1, 0.2, 0.0]), turn(1.5, 450.0, [0.1, -0.1, 0.3])];
    drum
}

/// x turned by an angle about the axis (Rodrigues).
fn turned(x: V, degrees: f64) -> V {
    let axis = scale(AXIS, 1.0 / norm(AXIS));
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let along = scale(axis, dot(axis, x) * (1.0 - cosine));
    add(add(scale(x, cosine), scale(cross(axis, x), sine)), along)
}

/// Where the drum has carried a point by time `t`.
fn carried(x: V, t: f64) -> V {
    let mix = |a: f64, b: f64, s: f64| a + s * (b - a);
    let (degrees, shift) = if t < 0.5 {
        (mix(0.0, 90.0, 2.0 * t), scale([0.1, 0.2, 0.0], 2.0 * t))
    } else {
        let s = (t - 0.5).min(1.0);
        (mix(90.0, 450.0, s), [0.1, mix(0.2, -0.1, s), mix(0.0, 0.3, s)])
    };
    add(add(turned(sub(x, PIVOT), degrees), PIVOT), shift)
}

fn scene(pin: impl Fn(Body) -> Body) -> Scene {
    Scene::new("drum").body(pin(panel("sheet", 9, [0.0; 3]))).collider(drum()).time(0.01, 0.001)
}

#[test]
fn nodes_go_the_way_of_the_points_of_a_turning_collider() {
    let breaking = |body: Body| {
        let pin = Pin {
            select: Select::cols(0, 2),
            collider: Some("drum".into()),
            break_force: Some(1e9),
            ..Pin::default()
        };
        Body { pins: vec![pin], ..body }
    };
    let plain = |body: Body| body.pin_to(Select::cols(0, 2), "drum");
    for (scene, tolerance) in [(scene(plain), 1e-12), (scene(breaking), 1e-9)] {
        let mut simulation = build(&scene);
        let start = positions(&simulation);
        for frame in 1..=180 {
            run(&mut simulation, 1);
            let t = 0.01 * f64::from(frame);
            let (x, v) = state::state(&simulation);
            for node in (0..81).filter(|node| node % 9 < 3) {
                let expected = carried(start[node], t);
                near("place", norm(sub(x[node], expected)), 0.0, tolerance);
                // The velocity is that of the way in the last sub-step.
                let before = carried(start[node], t - 0.001);
                near("speed", norm(sub(v[node], scale(sub(expected, before), 1000.0))), 0.0, 1e-6);
            }
        }
        assert_eq!(simulation.report().broken, 0);
    }
}

#[test]
fn what_a_collider_carries_it_leaves_alone_until_the_pin_breaks() {
    // A row 5 mm deep in an arm with an offset of 10 mm; the seven nodes of the row bear 0.49 N.
    let arm =
        Collider { name: "arm".to_owned(), ..Collider::capsule([-0.5, 0.0, 0.0], [0.5, 0.0, 0.0], 0.05) };
    let with = |break_force: f64| {
        let mut sheet = panel("sheet", 7, [0.0, 0.045, 0.25]);
        sheet.pins.push(Pin {
            select: Select::rows(0, 0),
            collider: Some("arm".into()),
            break_force: Some(break_force),
            ..Pin::default()
        });
        let mut scene = Scene::new("arm").body(sheet).collider(arm.clone()).time(1.0 / 60.0, 0.001);
        scene.world.drag = 0.005;
        let mut simulation = build(&scene);
        assert!(!warnings(&simulation).join(" ").contains("inside collider"), "{:?}", simulation.warnings());
        let start = positions(&simulation);
        run(&mut simulation, 240);
        (simulation.report().broken, start, positions(&simulation))
    };
    let (broken, start, x) = with(0.5);
    assert_eq!(broken, 0);
    (0..7).for_each(|node| near("held", norm(sub(x[node], start[node])), 0.0, 1e-12));
    let (broken, _, x) = with(0.05);
    assert_eq!(broken, 7);
    // What has broken is kept out of the arm, and slides off it.
    assert!(x.iter().all(|x| x[1].hypot(x[2]) > 0.06 - 1e-9 || x[0].abs() > 0.5), "{x:?}");
}

#[test]
fn a_pin_on_a_collider_is_one_with_its_keyframes() {
    let by_name = scene(|body| body.pin_to(Select::cols(0, 0), "drum"));
    let by_keys = scene(|body| body.pin_moving(Select::cols(0, 0), drum().motion));
    let [a, b] = [by_name, by_keys].map(|scene| {
        let mut simulation = build_as(&scene, Precision::F32, 1);
        run(&mut simulation, 60);
        simulation.state_hash()
    });
    assert_eq!(a, b);
}

#[test]
fn a_collider_without_a_name_is_called_by_its_number_and_one_at_rest_holds() {
    let mut still = scene(|body| body.pin_to(Select::cols(0, 0), "collider1"));
    still.colliders.push(Collider::plane([0.0, -2.0, 0.0], [0.0, 1.0, 0.0]));
    let mut simulation = build(&still);
    let start = positions(&simulation);
    run(&mut simulation, 30);
    assert_eq!(positions(&simulation)[9], start[9]);
}

#[test]
fn colliders_are_named_once_and_pins_name_one_that_is_there() {
    let refused = |scene: &Scene, path: &str, words: &str| {
        let error = scene_error(Simulation::new(scene, &Options::default()));
        assert_eq!(error.path, path, "{error}");
        assert!(error.message.contains(words), "{error}");
    };
    let nowhere = scene(|body| body.pin_to(Select::cols(0, 0), "drun"));
    refused(&nowhere, "body[0].pin[0].collider", "there is no collider `drun`; `drum` would do");
    let alone = Scene { colliders: Vec::new(), ..nowhere };
    refused(&alone, "body[0].pin[0].collider", "the scene has no colliders; one of that name would do");
    let mut both = scene(|body| body.pin_to(Select::cols(0, 0), "drum"));
    both.bodies[0].pins[0].motion = drum().motion;
    refused(&both, "body[0].pin[0].collider", "is `drum`, and the pin has a motion too");
    let twice = scene(|body| body).collider(drum());
    refused(&twice, "collider[1].name", "is `drum`, as is that of collider[0]");
}
