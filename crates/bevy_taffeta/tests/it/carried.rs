//! Cloth that entities carry, and take along where they are put elsewhere.

use crate::common::{FRAME, drawn, plain, positions, ready, run, running, set, sheet};
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::scene::Seam;

#[test]
fn colliders_and_carried_pins_follow_transforms() {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let floor = app
        .world_mut()
        .spawn((SoftCollider::ground().offset(0.01), Transform::from_xyz(0.0, -0.2, 0.0)))
        .id();
    let hand = app.world_mut().spawn(Transform::from_xyz(0.3, 0.0, 0.0)).id();
    app.world_mut().spawn(sheet()).insert(Pins::carry(Select::nodes([0, 6]), hand));
    ready(&mut app);
    run(&mut app, 30);
    let lowest = |places: &[Vec3]| places.iter().map(|x| x.y).fold(f32::INFINITY, f32::min);
    assert!((lowest(&positions(&mut app)) + 0.19).abs() < 1e-4);
    let corners = |app: &mut App| [0, 6].map(|node| positions(app)[node]);
    let [a, b] = corners(&mut app);
    for _ in 0..15 {
        app.world_mut().get_mut::<Transform>(floor).expect("it").translation.y += 0.01;
        app.world_mut().get_mut::<Transform>(hand).expect("it").rotate_y(0.1);
        app.update();
    }
    assert!(lowest(&positions(&mut app)) > -0.05 + 0.01 - 1e-4);
    let hand = Vec3::new(0.3, 0.0, 0.0);
    let turn = Quat::from_rotation_y(1.5);
    let [c, d] = corners(&mut app);
    assert!(c.abs_diff_eq(hand + turn * (a - hand), 1e-4) && d.abs_diff_eq(hand + turn * (b - hand), 1e-4));
}

#[test]
fn what_is_carried_is_drawn_where_its_carrier_is_at_any_rate_of_frames() {
    for rate in [30.0, 60.0, 100.0, 144.0] {
        let mut app = plain();
        app.add_plugins(TaffetaPlugin);
        let clock = std::time::Duration::from_secs_f64(1.0 / rate);
        app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(clock));
        let hand = app.world_mut().spawn(Transform::from_xyz(0.3, 0.0, 0.0)).id();
        let sheet = app.world_mut().spawn(sheet()).insert(Pins::carry(Select::nodes([0, 6]), hand)).id();
        ready(&mut app);
        let from = drawn(&app, sheet);
        let start = *app.world().get::<Transform>(hand).expect("it");
        let mut most = 0.0_f32;
        for frame in 1..=60 {
            let mut transform = app.world_mut().get_mut::<Transform>(hand).expect("it");
            transform.translation.z += 5.0 / rate as f32;
            transform.rotate_y(2.0 / rate as f32);
            let now = *transform;
            app.update();
            // It cannot know that the carrier starts to move.
            for node in [0, 6].into_iter().filter(|_| frame > 10) {
                let wanted =
                    now.transform_point(start.compute_affine().inverse().transform_point3(from[node]));
                most = most.max(drawn(&app, sheet)[node].distance(wanted));
            }
        }
        // As if its speed stayed the same: turning at 2 rad/s, a lever of 0.6 m is off by less than ω² r h².
        assert!(most < 1e-3, "{most} m at {rate} Hz");
    }
}

#[test]
fn cloth_goes_along_with_a_carrier_that_is_put_elsewhere() {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let hand = app.world_mut().spawn(Transform::from_xyz(0.3, 0.0, 0.0)).id();
    let ball = SoftCollider::sphere(0.1);
    let ball = app.world_mut().spawn((ball, ChildOf(hand), Transform::from_xyz(0.0, -0.3, 0.0))).id();
    let sheet = app.world_mut().spawn(sheet()).insert(Pins::carry(Select::nodes([0, 6]), hand)).id();
    ready(&mut app);
    run(&mut app, 29);
    let earlier = drawn(&app, sheet);
    run(&mut app, 1);
    let stretch = running(&mut app).simulation().report().max_stretch;
    let (before, start) = (drawn(&app, sheet), *app.world().get::<GlobalTransform>(hand).expect("it"));
    let to = Transform::from_xyz(50.0, 2.0, -7.0).with_rotation(Quat::from_rotation_y(2.0));
    *app.world_mut().get_mut::<Transform>(hand).expect("it") = to;
    run(&mut app, 1);
    let now = drawn(&app, sheet);
    for ((now, before), earlier) in now.iter().zip(&before).zip(&earlier) {
        // It swings on by a step.
        let on = 2.0 * before - earlier;
        let there = to.transform_point(start.affine().inverse().transform_point3(on));
        assert!(now.distance(there) < 0.02, "{now}, not {there}");
    }
    run(&mut app, 20);
    assert!(running(&mut app).simulation().report().max_stretch < 1.5 * stretch);
    let ball = app.world().get::<GlobalTransform>(ball).expect("it").translation();
    assert!(drawn(&app, sheet).iter().all(|x| x.distance(ball) > 0.1));
}

/// A sheet whose corners a hand carries, after half a second.
fn with_hand() -> (App, [Entity; 2]) {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let hand = app.world_mut().spawn(Transform::default()).id();
    let sheet = app.world_mut().spawn(sheet()).insert(Pins::carry(Select::nodes([0, 6]), hand)).id();
    ready(&mut app);
    run(&mut app, 30);
    (app, [hand, sheet])
}

fn put(app: &mut App, hand: Entity, at: Vec3) {
    app.world_mut().get_mut::<Transform>(hand).expect("it").translation = at;
}

/// Where the sheet of [`with_hand`] is so many frames later, if the hand stays.
fn undisturbed(frames: usize) -> Vec<Vec3> {
    let (mut app, [_, body]) = with_hand();
    run(&mut app, frames);
    drawn(&app, body)
}

/// Whether a sheet is where another one is that was put elsewhere.
fn assert_there(now: &[Vec3], expected: &[Vec3], shift: Vec3) {
    for (now, expected) in now.iter().zip(expected) {
        assert!(now.distance(*expected + shift) < 1e-3, "{now}, not {}", *expected + shift);
    }
}

#[test]
fn cloth_is_put_elsewhere_on_demand_with_its_carrier_or_comes_back_to_it() {
    let expected = undisturbed(20);
    for hand_goes in [true, false] {
        let (mut app, [hand, body]) = with_hand();
        let by = Transform::from_xyz(0.0, 30.0, 0.0);
        app.world_mut().commands().queue(TeleportCloth { body, by });
        if hand_goes {
            put(&mut app, hand, by.translation);
        }
        run(&mut app, 20);
        assert_there(&drawn(&app, body), &expected, if hand_goes { by.translation } else { Vec3::ZERO });
    }
}

#[test]
fn a_carrier_that_moves_far_while_its_world_stands_still_takes_its_cloth_along() {
    let (mut app, [hand, body]) = with_hand();
    let before = drawn(&app, body)[38];
    set(&mut app, Playback { paused: true, ..default() });
    for step in 1..=20 {
        put(&mut app, hand, Vec3::X * 0.5 * step as f32);
        run(&mut app, 1);
    }
    assert_eq!(drawn(&app, body)[38], before);
    set(&mut app, Playback::default());
    run(&mut app, 20);
    assert_there(&drawn(&app, body), &undisturbed(20), Vec3::X * 10.0);
}

#[test]
fn what_is_sewn_to_cloth_goes_along_and_what_is_held_elsewhere_too_is_pulled() {
    let pairs: Vec<[u32; 2]> = (0..7).map(|column| [35 + column, column]).collect();
    for held in [false, true] {
        let mut app = plain();
        app.add_plugins(TaffetaPlugin);
        let hand = app.world_mut().spawn(Transform::default()).id();
        let carried = Pins::carry(Select::nodes([0, 6]), hand);
        app.world_mut().spawn(sheet()).insert((Name::new("upper"), carried));
        let pins = if held { Pins::hold(Select::nodes([38])) } else { Pins::default() };
        let lower = app.world_mut().spawn(sheet()).insert((Name::new("lower"), pins)).id();
        app.world_mut().entity_mut(lower).insert(Transform::from_xyz(0.0, 0.0, 0.5));
        let mut world = app.world_mut().query::<&mut SoftWorld>().single_mut(app.world_mut()).expect("one");
        world.seams = vec![Seam::pairs("upper", "lower", pairs.clone())];
        ready(&mut app);
        run(&mut app, 5);
        let before = drawn(&app, lower)[20];
        put(&mut app, hand, Vec3::X * 20.0);
        run(&mut app, 1);
        let moved = drawn(&app, lower)[20].distance(before);
        assert_eq!(moved > 19.0, !held, "{moved} m");
    }
}

/// The largest stretch of a sheet in half a second after its hand has gone half a second at 5 m/s, and a frame of so many seconds.
fn stretch_after(seconds: f32) -> f64 {
    let (mut app, [hand, body]) = with_hand();
    let mut at = 0.0;
    let mut go = |app: &mut App, seconds: f32| {
        at += 5.0 * seconds;
        put(app, hand, Vec3::X * at);
        let clock = std::time::Duration::from_secs_f32(seconds);
        app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(clock));
        run(app, 1);
        let is_there = (drawn(app, body)[0].x - (at - 0.3)).abs() < 0.05;
        (is_there, running(app).simulation().report().max_stretch)
    };
    for _ in 0..30 {
        go(&mut app, FRAME as f32);
    }
    go(&mut app, seconds);
    let all: Vec<(bool, f64)> = (0..30).map(|_| go(&mut app, FRAME as f32)).collect();
    assert!(all.iter().all(|(is_there, _)| *is_there), "{all:?}");
    all.into_iter().map(|(_, stretch)| stretch).fold(0.0, f64::max)
}

/// Bevy's clock leaves out what is more than a quarter of a second, and the world what is more than four frames.
#[test]
fn a_carrier_takes_its_cloth_through_a_frame_of_a_second() {
    let [usual, late] = [FRAME as f32, 1.0].map(stretch_after);
    assert!(late < 1.1 * usual, "{late}, {usual} without it");
}
