//! Joints that break.

use super::{bob, fixed, panel};
use crate::common::{build, near, norm, positions, run, state};
use taffeta::scene::{Body, Keyframe, Mass, Mesh, Pin, Scene, Seam, Select};

const WEIGHT: f64 = 0.2 * 9.81;

fn hanging(break_force: f64, k: Option<f64>) -> Scene {
    let seam = Seam { break_force: Some(break_force), k, ..Seam::pairs("nail", "bob", [[0, 0]]) };
    let mut scene = Scene::new("hang")
        .body(fixed("nail", [0.0; 3]))
        .body(bob("bob", [0.0; 3], 0.2))
        .seam(seam)
        .time(0.01, 0.001);
    scene.world.drag = if k.is_some() { 20.0 } else { 0.0 };
    scene
}

#[test]
fn a_seam_holds_what_is_just_below_its_force_and_nothing_above() {
    // With so much drag a soft seam takes up the weight without swinging.
    for k in [None, Some(100.0)] {
        let mut holds = build(&hanging(1.0001 * WEIGHT, k));
        run(&mut holds, 300);
        assert_eq!(holds.report().broken, 0, "{k:?}");
        let sag = k.map_or(0.0, |k| WEIGHT / k);
        near("sag", -positions(&holds)[2][1], sag, 1e-6);
        let mut breaks = build(&hanging(0.9999 * WEIGHT, k));
        run(&mut breaks, 300);
        assert_eq!(breaks.report().broken, 1, "{k:?}");
        assert!(positions(&breaks)[2][1] < -sag - 0.01);
    }
}

#[test]
fn of_joints_in_a_chain_each_bears_what_hangs_on_it() {
    // Two bobs on a nail: the upper joint holds both, the lower one holds the second.
    let with = |break_force: [f64; 2]| {
        let seam = |from: &str, to: &str, force: f64| Seam {
            break_force: Some(force * WEIGHT),
            ..Seam::pairs(from, to, [[0, 0]])
        };
        let scene = Scene::new("chain")
            .body(fixed("nail", [0.0; 3]))
            .body(bob("first", [0.0; 3], 0.2))
            .body(bob("second", [0.0; 3], 0.2))
            .seam(seam("nail", "first", break_force[0]))
            .seam(seam("first", "second", break_force[1]));
        let mut simulation = build(&scene.time(0.01, 0.001));
        run(&mut simulation, 100);
        simulation.report().broken
    };
    assert_eq!([[2.0001, 1.0001], [1.9999, 9.0], [9.0, 0.9999]].map(with), [0, 1, 1]);
}

#[test]
fn what_is_torn_off_falls_freely() {
    let mut simulation = build(&hanging(0.5 * WEIGHT, None));
    run(&mut simulation, 50);
    let (_, v) = state::state(&simulation);
    near("speed", v[2][1], -9.81 * 0.5, 1e-9);
    assert_eq!(simulation.report().broken, 1);
}

#[test]
fn panels_that_tear_apart_keep_their_momentum() {
    let seam = |break_force| {
        let pairs: Vec<[u32; 2]> = (0..7).map(|row| [row * 7 + 6, row * 7]).collect();
        Seam { break_force, ..Seam::pairs("left", "right", pairs) }
    };
    let scene = crate::common::weightless("tear", 0.005, 0.001)
        .body(panel("left", 7, [-0.25, 0.0, 0.0]))
        .body(panel("right", 7, [0.25, 0.0, 0.0]))
        .seam(seam(Some(0.05)));
    let mut simulation = build(&scene);
    let x = positions(&simulation);
    let v: Vec<_> = (0..98).map(|node| [if node < 49 { -2.0 } else { 1.0 }, 0.0, 0.0]).collect();
    state::set(&mut simulation, &x, &v);
    let before = 0.001 * 49.0 * (1.0 - 2.0);
    for _ in 0..100 {
        run(&mut simulation, 1);
        let p = simulation.report().momentum;
        near("momentum", p[0], before, 1e-14);
        assert!(p[1].abs() < 1e-14 && p[2].abs() < 1e-14, "{p:?}");
    }
    assert_eq!(simulation.report().broken, 7);
    // Without a force at which it breaks it holds.
    let mut holds = build(&Scene { seams: vec![seam(None)], ..scene });
    state::set(&mut holds, &x, &v);
    run(&mut holds, 100);
    let x = positions(&holds);
    (0..7).for_each(|row| {
        near("gap", norm(crate::common::sub(x[row * 7 + 6], x[49 + row * 7])), 0.0, 1e-9);
    });
}

#[test]
fn what_is_broken_is_remembered() {
    let scene = hanging(0.5 * WEIGHT, None);
    let mut first = build(&scene);
    run(&mut first, 3);
    let snapshot = first.snapshot();
    assert_eq!((snapshot.joints, snapshot.constraints.as_slice()), (1, &[0_u8][..]));
    let mut again = build(&scene);
    again.restore(&snapshot).unwrap();
    run(&mut first, 20);
    run(&mut again, 20);
    assert_eq!((again.state_hash(), again.report()), (first.state_hash(), first.report()));
    assert_eq!(again.report().broken, 1);
    let whole = build(&hanging(2.0 * WEIGHT, None)).snapshot();
    assert_eq!(whole.constraints, [1]);
    // A seam that cannot break remembers nothing.
    let seam = Seam { break_force: None, ..scene.seams[0].clone() };
    let plain = build(&Scene { seams: vec![seam], ..scene.clone() });
    assert_eq!((plain.snapshot().joints, plain.snapshot().constraints.len()), (0, 0));
    let mut damaged = build(&scene).snapshot();
    (damaged.joints, damaged.constraints) = (0, Vec::new());
    assert_eq!(
        build(&scene).restore(&damaged).unwrap_err().to_string(),
        "it holds 0 joints, the scene has 1"
    );
}

/// A chain of 0.1 kg a node that hangs from its first one, without springs but for its links.
fn chain(pin: Pin) -> Body {
    let mut body =
        Body::cloth("chain", Mesh::chain(4, 0.4)).with_mass(Mass::Node(0.1)).structural(2000.0, 2.0);
    body.pins = vec![pin];
    body
}

#[test]
fn a_pin_lets_go_when_holding_takes_more_than_its_force() {
    let with = |break_force: f64| {
        let pin = Pin { select: Select::nodes([0, 4]), break_force: Some(break_force), ..Pin::default() };
        let mut scene = Scene::new("pin").body(chain(pin)).time(0.005, 0.0005);
        scene.world.drag = 0.05;
        let mut simulation = build(&scene);
        run(&mut simulation, 1500);
        (simulation.report().broken, positions(&simulation))
    };
    // At first each holds half: 0.25 kg, swinging; then one holds all of 0.5 kg.
    let (broken, x) = with(100.0);
    assert_eq!(broken, 0);
    near("held", norm(crate::common::sub(x[0], [-0.2, 0.0, 0.0])), 0.0, 1e-12);
    near("held", norm(crate::common::sub(x[4], [0.2, 0.0, 0.0])), 0.0, 1e-12);
    let (broken, x) = with(1.0);
    assert_eq!(broken, 2);
    assert!(x.iter().all(|x| x[1] < -1.0), "{x:?}");
}

#[test]
fn a_pin_that_does_not_break_moves_as_one_that_cannot() {
    let motion = vec![
        Keyframe::translate(0.5, [0.3, 0.1, 0.0]),
        Keyframe::rotate(1.0, [0.0, 1.0, 0.2], 90.0, [0.1, 0.0, 0.0]),
    ];
    let at = |break_force: Option<f64>| {
        let pin =
            Pin { select: Select::nodes([0, 1]), motion: motion.clone(), break_force, ..Pin::default() };
        let mut simulation = build(&Scene::new("move").body(chain(pin)).time(0.005, 0.0005));
        run(&mut simulation, 150);
        state::state(&simulation)
    };
    let ((held, speeds), (joined, others)) = (at(None), at(Some(1e6)));
    for node in 0..5 {
        near("place", norm(crate::common::sub(held[node], joined[node])), 0.0, 1e-9);
        near("speed", norm(crate::common::sub(speeds[node], others[node])), 0.0, 1e-6);
    }
}

#[test]
fn another_pin_holds_for_good_what_a_pin_that_breaks_holds_too() {
    let breaking = Pin { select: Select::nodes([0, 1]), break_force: Some(1e-3), ..Pin::default() };
    let scene = Scene::new("both").body(chain(breaking).pin(Select::nodes([0]))).time(0.005, 0.0005);
    let mut simulation = build(&scene);
    run(&mut simulation, 100);
    assert_eq!(simulation.report().broken, 1);
    assert_eq!(positions(&simulation)[0], [-0.2, 0.0, 0.0]);
}
