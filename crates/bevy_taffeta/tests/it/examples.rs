//! The examples, without a window, held to physics.

#[path = "../../examples/balloon.rs"]
#[allow(dead_code, reason = "it has a main of its own")]
mod balloon;
#[path = "../../examples/balls.rs"]
#[allow(dead_code, reason = "it has a main of its own")]
mod balls;
#[path = "../../examples/cape.rs"]
#[allow(dead_code, reason = "it has a main of its own")]
mod cape;
#[path = "../../examples/flag.rs"]
#[allow(dead_code, reason = "it has a main of its own")]
mod flag;

use crate::common::{plain, positions, ready, run, running};
use bevy::prelude::*;
use bevy_taffeta::prelude::*;

fn example(plugin: fn(&mut App)) -> App {
    let mut app = plain();
    app.add_plugins(plugin);
    ready(&mut app);
    app
}

#[test]
fn the_flag_hangs_at_its_pole_and_flies_with_the_wind() {
    let mut app = example(flag::flag);
    let start = positions(&mut app);
    run(&mut app, 90);
    let now = positions(&mut app);
    assert!((0..20).all(|row| now[30 * row] == start[30 * row]));
    // The wind has a part towards +z, and nothing else has: the free edge is carried that way.
    let drift: f32 = (0..20).map(|row| now[30 * row + 29].z - start[30 * row + 29].z).sum::<f32>() / 20.0;
    assert!(drift > 0.1, "{drift}");
    assert!(running(&mut app).simulation().report().max_stretch < 1.5);
}

#[test]
fn the_balls_keep_their_distance_and_their_volume_and_stay_above_the_ground() {
    let mut app = example(balls::balls);
    let mut nearest = f64::INFINITY;
    for _ in 0..90 {
        run(&mut app, 1);
        let running = running(&mut app);
        nearest = nearest.min(running.simulation().report().nearest_pair.unwrap_or(f64::INFINITY));
    }
    // Surfaces are parted in every sub-step, and pressed together again by the balls above.
    assert!(nearest > 0.8 && nearest < 1.05, "nearest: {nearest} of the thickness");
    let places = positions(&mut app);
    assert_eq!(places.len(), 13 * 162);
    let lowest = places.iter().map(|x| x.y).fold(f32::INFINITY, f32::min);
    assert!((lowest - 0.01).abs() < 1e-4, "the ground's offset is 0.01 m: {lowest}");
    let running = running(&mut app);
    let simulation = running.simulation();
    assert_eq!(simulation.intersections().pairs, 0);
    for (body, volume) in simulation.bodies().iter().zip(&simulation.report().volumes) {
        let share = volume.unwrap_or(0.0) / body.rest_volume.unwrap_or(1.0);
        assert!((share - 1.0).abs() < 0.01, "{}: {share}", body.name);
    }
}

#[test]
fn the_cape_hangs_on_the_shoulders_and_is_pushed_by_legs_and_back() {
    let mut app = example(cape::cape);
    let shoulders = |app: &mut App| {
        let mut query = app.world_mut().query_filtered::<&GlobalTransform, With<cape::Walks>>();
        let torso = query.single(app.world()).expect("a character").affine().inverse();
        positions(app)[..15].iter().map(|x| torso.transform_point3(*x)).collect::<Vec<_>>()
    };
    let start = shoulders(&mut app);
    let (mut touched, mut contacts) = (f32::INFINITY, 0);
    for _ in 0..60 {
        app.update();
        for (a, b) in start.iter().zip(shoulders(&mut app)) {
            assert!(a.abs_diff_eq(b, 1e-4), "{a} {b}");
        }
        contacts = contacts.max(running(&mut app).simulation().report().contacts);
        let nearest = clearance(&mut app);
        assert!(nearest > -1e-3, "{nearest} m inside");
        touched = touched.min(nearest);
    }
    assert!(contacts > 20 && touched.abs() < 1e-3, "{contacts} contacts, {touched} m away");
}

/// How far the cape's free nodes are at least from where the capsules hold them back [m].
fn clearance(app: &mut App) -> f32 {
    let places = positions(app);
    let mut query = app.world_mut().query::<(&SoftCollider, &GlobalTransform)>();
    let mut nearest = f32::INFINITY;
    for (collider, transform) in query.iter(app.world()) {
        let bar = collider.0.capsule.expect("a capsule");
        let [a, b] = [bar.a, bar.b].map(|x| transform.transform_point(Vec3::from(x.map(|x| x as f32))));
        let reach = (bar.radius + collider.0.offset) as f32;
        for x in &places[15..] {
            let share = ((*x - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0);
            nearest = nearest.min(x.distance(a.lerp(b, share)) - reach);
        }
    }
    nearest
}

#[test]
fn the_balloon_grows_until_its_rubber_holds_the_pressure() {
    let mut app = example(balloon::balloon);
    run(&mut app, 240);
    let running = running(&mut app);
    let simulation = running.simulation();
    let surface = simulation.surface(simulation.bodies()[0].handle).expect("its own body");
    let mut squares = 0.0;
    let at = |node: u32| surface.nodes[node as usize];
    for triangle in &surface.triangles {
        for (a, b) in [(0, 1), (1, 2), (2, 0)] {
            let (a, b) = (at(triangle[a]), at(triangle[b]));
            // Every edge is one of two triangles.
            squares += 0.5 * (0..3).map(|i| (a[i] - b[i]).powi(2)).sum::<f64>();
        }
    }
    let volume = simulation.bodies()[0].rest_volume.expect("a closed body");
    // All lengths grow by a factor s: p dV/ds = dE/ds, 3 p V s² = k Σ L² (s − 1).
    let stiffness = balloon::RUBBER * squares / (3.0 * balloon::PRESSURE * volume);
    let s = (stiffness - (stiffness * (stiffness - 4.0)).sqrt()) / 2.0;
    let found = simulation.report().volumes[0].expect("a closed body") / volume;
    assert!(s > 1.1, "the pressure is to be felt: {s}");
    assert!((found / s.powi(3) - 1.0).abs() < 0.02, "{found} times its volume, not {}", s.powi(3));
}
