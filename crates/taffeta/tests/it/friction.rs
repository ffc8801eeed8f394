//! Coulomb friction and restitution against the numbers of a block on a slope and a ball on a floor.

use crate::common::{build, build_as, farthest, near, norm, positions, run, scale, sub, turned};
use crate::gpu::on_gpu;
use std::ops::Range;
use taffeta::scene::{
    Body, Collider, ConstraintForm, ContactForm, Keyframe, Mass, Material, Mesh, Method, Scene, Select,
    SelfCollision,
};
use taffeta::{Precision, Simulation};

const G: f64 = 9.81;

fn patch() -> Body {
    Body::cloth("patch", Mesh::grid(4, 5, [0.4, 0.3]))
        .with_mass(Mass::Node(0.03))
        .structural(100.0, 0.1)
        .shear(60.0, 0.1)
}

/// A patch that lies on a slope of 20°, down along +x.
fn incline(friction: f64) -> Scene {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let mut body = patch();
    body.place = turned([0.0, 0.0, 1.0], -20.0, [3.0 * cos, -3.0 * sin, 0.0]);
    let slope = Collider::plane([0.0; 3], [sin, cos, 0.0]).offset(0.0).friction(friction);
    Scene::new("incline").time(0.01, 0.001).body(body).collider(slope)
}

#[test]
fn a_patch_sticks_to_a_slope_of_20_degrees_with_half_the_normal_force_as_friction() {
    // tan 20° = 0.364 < 0.5.
    let mut simulation = build(&incline(0.5));
    let start = positions(&simulation);
    run(&mut simulation, 300);
    let moved = farthest(&positions(&simulation), &start);
    assert!(moved < 1e-12, "{moved:e} m in 3 s");
    assert_eq!(simulation.report().contacts, 20);
    let mut single = build_as(&incline(0.5), Precision::F32, 1);
    run(&mut single, 300);
    let moved = farthest(&positions(&single), &start);
    assert!(moved < 1e-5, "{moved:e} m in 3 s, 32 bits");
}

#[test]
fn a_patch_slides_down_a_slope_with_g_sine_less_mu_cosine() {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    for friction in [0.0, 0.2, 0.36] {
        let mut simulation = build(&incline(friction));
        let start = positions(&simulation);
        run(&mut simulation, 100);
        let a = G * (sin - friction * cos);
        // n = 1000 steps: a h² n (n + 1)/2.
        let way = a * 1e-6 * 1000.0 * 1001.0 / 2.0;
        for (from, to) in start.iter().zip(positions(&simulation)) {
            let moved = sub(to, *from);
            near("way", moved[0] * cos - moved[1] * sin, way, 1e-3 * way);
            near("way", moved[0] * cos - moved[1] * sin, way, 1e-9);
            near("off the slope", moved[0] * sin + moved[1] * cos, 0.0, 1e-12);
        }
        near("speed", norm(simulation.report().momentum) / 0.6, a, 1e-9);
    }
}

/// The mean way of a body's nodes along x and y [m].
fn mean_way(simulation: &Simulation, start: &[[f64; 3]], nodes: Range<usize>) -> [f64; 2] {
    let (all, count) = (positions(simulation), nodes.len() as f64);
    [0, 1].map(|axis| nodes.clone().map(|node| all[node][axis] - start[node][axis]).sum::<f64>() / count)
}

#[test]
fn a_pair_has_the_friction_that_the_scene_gives_it() {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    for form in [None, Some(ConstraintForm::Compliant), Some(ConstraintForm::Primal)] {
        // Both would stick by the friction of the slope.
        let mut scene = incline(0.5);
        let mut other = scene.bodies[0].clone();
        other.name = "other".into();
        other.place.position[2] += 1.0;
        scene = scene.body(other);
        scene.colliders[0].name = "slope".into();
        scene = scene.friction_between("slope", "other", 0.2);
        if let Some(form) = form {
            (scene.solver.method, scene.solver.ice.form) = (Method::Ice, form);
        }
        for (mut simulation, still) in [(build(&scene), 1e-6), (on_gpu(&scene), 1e-5)] {
            let start = positions(&simulation);
            run(&mut simulation, 50);
            let [stuck, slid] = [0, 20].map(|first| {
                let [x, y] = mean_way(&simulation, &start, first..first + 20);
                x * cos - y * sin
            });
            // After half a second.
            let way = 0.125 * G * (sin - 0.2 * cos);
            assert!(stuck.abs() < still, "{form:?}: {stuck} m");
            assert!((slid - way).abs() < 4e-3 * way, "{form:?}: {slid} m of {way} m");
        }
    }
}

#[test]
fn two_bodies_have_the_friction_that_the_scene_gives_them() {
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let touching = |body: Body| {
        let form = ContactForm::Triangles;
        let wish = SelfCollision { form, thickness: 0.01, friction: 0.8, ..SelfCollision::default() };
        Body { self_collision: Some(wish), ..body }
    };
    let floor =
        Body::cloth("floor", Mesh::grid(9, 9, [3.0, 3.0])).with_mass(Mass::Node(0.03)).structural(100.0, 0.1);
    let mut scene = Scene::new("tilted")
        .time(0.01, 0.001)
        .body(touching(patch()).at([0.0, 0.01, 0.0]))
        .body(touching(floor.pin(Select::rows(0, 8))));
    scene.world.gravity = [G * sin, -G * cos, 0.0];
    for (pair, friction) in [(None, 0.8), (Some(0.2), 0.2), (Some(0.0), 0.0)] {
        let mut scene = scene.clone();
        if let Some(friction) = pair {
            scene = scene.friction_between("floor", "patch", friction);
        }
        let mut simulation = build(&scene);
        let start = positions(&simulation);
        run(&mut simulation, 50);
        let [way, fall] = mean_way(&simulation, &start, 0..20);
        let wanted = 0.125 * G * f64::max(sin - friction * cos, 0.0);
        assert!((way - wanted).abs() < 0.03 * wanted + 2e-3, "{pair:?}: {way} m of {wanted} m");
        assert!(fall.abs() < 2e-3, "{pair:?}: {fall} m");
    }
}

#[test]
fn a_fabric_without_friction_slides_down_another_in_implicit_steps() {
    // What is below is held at its borders alone, so that neither is quite flat.
    let (sin, cos) = 20_f64.to_radians().sin_cos();
    let touching = |name: &str, mesh: Mesh, preset: &str| {
        let wish = SelfCollision {
            form: ContactForm::Triangles,
            thickness: 0.003,
            friction: 0.0,
            ..SelfCollision::default()
        };
        let body = Body::cloth(name, mesh).with_material(Material::preset(preset));
        Body { self_collision: Some(wish), ..body }
    };
    let below = touching("below", Mesh::grid(8, 30, [1.0, 0.25]), "cotton").at([0.4, 0.003, 0.0]);
    let mut scene = Scene::new("tilted")
        .time(1.0 / 60.0, 1e-3)
        .method(Method::Ice)
        .body(touching("above", Mesh::grid(8, 8, [0.15, 0.15]), "linen").at([0.0, 0.006, 0.0]))
        .body(below.pin(Select::rows(0, 0)).pin(Select::rows(7, 7)))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.003));
    scene.solver.ice.form = ConstraintForm::Primal;
    scene.world.gravity = [G * sin, -G * cos, 0.0];
    let mut simulation = build_as(&scene, Precision::F32, 2);
    let start = positions(&simulation);
    run(&mut simulation, 30);
    let way = mean_way(&simulation, &start, 0..64)[0];
    // After half a second.
    let wanted = 0.125 * G * sin;
    assert!((way - wanted).abs() < 0.1 * wanted, "{way} m of {wanted} m");
    assert_eq!(simulation.intersections().pairs, 0);
}

#[test]
fn a_slope_just_below_the_angle_of_friction_holds_and_just_above_does_not() {
    let critical = 20_f64.to_radians().tan();
    for (friction, holds) in [(critical * 1.001, true), (critical * 0.999, false)] {
        let mut simulation = build(&incline(friction));
        let start = positions(&simulation);
        run(&mut simulation, 100);
        assert_eq!(farthest(&positions(&simulation), &start) < 1e-9, holds, "μ = {friction}");
    }
}

#[test]
fn a_conveyor_drags_cloth_with_mu_g_until_it_moves_along() {
    // 1 m/s is reached after 1/(0.5 g) = 0.204 s.
    let belt = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(0.5);
    let belt = belt.keyframe(Keyframe::translate(2.0, [2.0, 0.0, 0.0]));
    let mut simulation = build(&Scene::new("belt").time(0.01, 0.001).body(patch()).collider(belt));
    let start = positions(&simulation);
    let mean = |all: &[[f64; 3]]| all.iter().map(|x| x[0]).sum::<f64>() / 20.0;
    run(&mut simulation, 10);
    near("speed", simulation.report().momentum[0] / 0.6, 0.5 * G * 0.1, 1e-9);
    near("way", mean(&positions(&simulation)), 0.5 * G * 1e-6 * 100.0 * 101.0 / 2.0, 1e-9);
    run(&mut simulation, 40);
    near("speed", simulation.report().momentum[0] / 0.6, 1.0, 1e-9);
    // The belt is ahead by the slip, v²/(2 μ g), to a step's way.
    near("lag", 0.5 - mean(&positions(&simulation)), 1.0 / (2.0 * 0.5 * G), 1e-3);
    let before = positions(&simulation);
    run(&mut simulation, 100);
    let after = positions(&simulation);
    let carried: Vec<_> = before.iter().map(|x| [x[0] + 1.0, x[1], x[2]]).collect();
    assert!(farthest(&carried, &after) < 1e-9, "cloth that sticks goes where the belt goes");
    assert!(farthest(&start, &after) > 1.3);
    // The belt stops after 2 s, and the cloth slides on by v²/(2 μ g).
    run(&mut simulation, 80);
    let stop = mean(&positions(&simulation));
    run(&mut simulation, 50);
    near("standstill", mean(&positions(&simulation)), stop, 1e-12);
    near("in all", stop, 2.0, 2e-3);
}

#[test]
fn cloth_sticks_to_a_turntable_and_turns_with_it() {
    // 90° in a second at up to 0.25 m: centripetal 0.62 m/s² < μ g.
    let table = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(0.9);
    let table = table.keyframe(Keyframe::rotate(1.0, [0.0, 1.0, 0.0], 90.0, [0.0; 3]));
    let mut simulation = build(&Scene::new("table").time(0.01, 0.0005).body(patch()).collider(table));
    let start = positions(&simulation);
    run(&mut simulation, 100);
    let turned: Vec<_> = start.iter().map(|x| [x[2], x[1], -x[0]]).collect();
    let apart = farthest(&turned, &positions(&simulation));
    // It starts from rest, slips until it has ω r = 0.4 m/s, and lags by v²/(2 μ g) = 9 mm at most.
    assert!(apart < 0.009, "{apart} m");
}

#[test]
fn a_bounce_rises_to_the_square_of_the_restitution() {
    for restitution in [0.0, 0.5, 0.8, 1.0] {
        let floor =
            Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(0.0).restitution(restitution);
        let body =
            Body::cloth("patch", Mesh::grid(2, 2, [0.1, 0.1])).with_mass(Mass::Node(0.1)).at([0.0, 1.0, 0.0]);
        let mut simulation = build(&Scene::new("bounce").time(0.001, 1e-4).body(body).collider(floor));
        // 0.4515 s down, up by e v/g later at the top.
        let down = (2.0 / G).sqrt();
        let (from, to) = (down * 1.01, down * (1.0 + 2.0 * restitution));
        let mut highest = 0.0_f64;
        while simulation.report().time < to {
            run(&mut simulation, 1);
            if simulation.report().time > from {
                highest = highest.max(positions(&simulation)[0][1]);
            }
        }
        let rise = restitution * restitution;
        near("height", highest, rise, 2e-3 * rise + 1e-9 + if restitution > 0.0 { 0.0 } else { 1e-6 });
    }
}

#[test]
fn a_throw_along_the_floor_stops_after_its_speed_squared_over_two_mu_g() {
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(0.3);
    let mut simulation = build(&Scene::new("throw").time(0.01, 1e-3).body(patch()).collider(floor));
    let start = positions(&simulation);
    // 2 m/s within a frame, against friction of 0.3 g in it.
    let push = 0.03 * (2.0 / 0.01 + 0.3 * G);
    for vertex in 0..20 {
        simulation
            .apply_force(simulation.body("patch").unwrap(), vertex, scale([0.6, 0.0, 0.8], push))
            .unwrap();
    }
    run(&mut simulation, 1);
    near("speed", norm(simulation.report().momentum) / 0.6, 2.0, 1e-9);
    run(&mut simulation, 150);
    let way = norm(sub(positions(&simulation)[7], start[7]));
    // The push itself goes 1 cm.
    near("way", way, 0.01 + 4.0 / (2.0 * 0.3 * G), 3e-3);
    near("standstill", simulation.report().kinetic, 0.0, 1e-20);
}
