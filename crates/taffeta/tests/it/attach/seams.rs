//! Nodes sewn to nodes.

use super::{bob, fixed, panel, two};
use crate::common::{
    V, add, build, dot, near, norm, positions, run, scale, scene_error, state, sub, turned, weightless,
};
use taffeta::Simulation;
use taffeta::scene::{Bounds, Closing, Method, Scene, Seam, SeamSide, Select};

/// The right edge of one panel and the left edge of another.
fn edges(side: u32) -> Seam {
    let edge = |name: &str, col| SeamSide::new(name, Select::cols(col, col));
    Seam::new(edge("left", side - 1), edge("right", 0))
}

/// The largest gap between the right edge of the first of two panels and the left one of the second [m].
fn gap(simulation: &Simulation, side: usize) -> f64 {
    let x = positions(simulation);
    let (left, right) = x.split_at(side * side);
    (0..side).map(|row| norm(sub(left[row * side + side - 1], right[row * side]))).fold(0.0, f64::max)
}

fn panels(apart: f64) -> Scene {
    let half = 0.25 + apart / 2.0;
    weightless("panels", 0.005, 0.001).body(panel("left", 9, [-half, 0.0, 0.0])).body(panel(
        "right",
        9,
        [half, 0.0, 0.0],
    ))
}

#[test]
fn a_seam_closes_at_its_speed_to_its_length_and_stays_under_weight() {
    for (length, method) in [(0.0, Method::Springs), (0.02, Method::Springs), (0.0, Method::Ice)] {
        let mut scene = panels(0.1).seam(edges(9).closing(0.1, 0.4, length)).method(method);
        scene.bodies[0] = scene.bodies[0].clone().pin(Select::cols(0, 0));
        let mut simulation = build(&scene);
        for (frames, at) in [(20, 0.1), (20, 0.2), (40, 0.4)] {
            run(&mut simulation, frames);
            let expected = 0.1 + (length - 0.1) * ((at - 0.1) / 0.3_f64).min(1.0);
            near("gap while it closes", gap(&simulation, 9), expected, 1e-9);
        }
        scene.world.gravity = [0.0, -9.81, 0.0];
        let mut heavy = build(&scene);
        run(&mut heavy, 400);
        near("gap under weight", gap(&heavy, 9), length, 1e-9);
        let lowest = positions(&heavy).iter().map(|x| x[1]).fold(0.0, f64::min);
        assert!(lowest < -0.25, "the second panel hangs on the first: {lowest}");
    }
}

#[test]
fn free_panels_keep_momentum_while_they_are_sewn() {
    // The line of a pull is that at the end of the sub-step: angular momentum is kept to the order of the step.
    let swung = [0.001, 0.0005].map(|step| {
        let mut scene = panels(0.2).seam(edges(9).closing(0.0, 0.3, 0.0));
        scene.time.max_step = Some(step);
        scene.bodies[1].place = turned([1.0, 0.3, 0.2], 20.0, [0.4, 0.1, 0.05]);
        let mut simulation = build(&scene);
        let mut swung: f64 = 0.0;
        for _ in 0..200 {
            run(&mut simulation, 1);
            let report = simulation.report();
            assert!(norm(report.momentum) < 1e-15, "{:?}", report.momentum);
            swung = swung.max(norm(report.angular_momentum));
        }
        assert!(gap(&simulation, 9) < 1e-9);
        swung
    });
    // Of 0.014 kg m²/s that each panel has about the other.
    assert!(swung[0] < 3e-4 && swung[1] < 0.7 * swung[0], "{swung:?}");
}

#[test]
fn an_edge_of_three_panels_keeps_momentum_and_closes_at_once() {
    // Every node of the edge in the middle has two joints.
    let side = |name: &str, col| SeamSide::new(name, Select::cols(col, col));
    let scene = panels(0.1)
        .body(panel("third", 9, [0.3, 0.1, 0.0]))
        .seam(edges(9).closing(0.0, 0.2, 0.0))
        .seam(Seam::new(side("third", 0), side("left", 8)).closing(0.0, 0.2, 0.0));
    let mut simulation = build(&scene);
    run(&mut simulation, 40);
    assert!(norm(simulation.report().momentum) < 1e-15);
    // What rounding moves as the last of the length goes.
    run(&mut simulation, 1);
    assert!(gap(&simulation, 9) < 1e-12, "{}", gap(&simulation, 9));
}

/// A panel that hangs in the xy plane, its first row at `y`.
fn hanging(name: &str, y: f64) -> taffeta::scene::Body {
    let body = panel(name, 9, [0.0; 3]);
    taffeta::scene::Body { place: turned([1.0, 0.0, 0.0], 90.0, [0.0, y - 0.25, 0.0]), ..body }
}

#[test]
fn seams_that_share_nodes_are_closed_under_load() {
    let row = |name: &str, row| SeamSide::new(name, Select::rows(row, row));
    let chain = [(row("a", 8), row("b", 0)), (row("b", 0), row("c", 0))];
    let ring = [chain[0].clone(), chain[1].clone(), (row("a", 8), row("c", 0))];
    let [short, long] = [1.0 / 240.0, 1.0 / 60.0];
    for (method, step) in [(Method::Springs, 0.001), (Method::Ice, short), (Method::Ice, long)] {
        for (seams, length) in [(&chain[..], 0.0), (&ring, 0.0), (&chain, 0.02)] {
            // Along lines that turn far in a step they are closed to first order.
            if length > 0.0 && step == long {
                continue;
            }
            let mut scene = Scene::new("load").time(1.0 / 60.0, step).method(method);
            scene.solver.ice.form = taffeta::scene::ConstraintForm::Primal;
            scene.world.drag = 0.002;
            // The seams hold their nodes as if they were apart by `length`: a below b, and b below c.
            scene = scene.body(hanging("a", 1.0).pin(Select::rows(0, 0)));
            scene = scene.body(hanging("b", 0.5 - length)).body(hanging("c", 0.5 - 2.0 * length));
            for (from, to) in seams {
                scene = scene.seam(Seam::new(from.clone(), to.clone()).closing(0.0, 0.1, length));
            }
            let mut simulation = build(&scene);
            run(&mut simulation, 300);
            let x = positions(&simulation);
            for (a, b) in [(72, 81), (81, 162)] {
                let far = (0..9)
                    .map(|n| norm(sub(x[a + n], x[b + n])) - length)
                    .fold(0.0, |a: f64, b| a.max(b.abs()));
                assert!(far < if length > 0.0 { 1e-6 } else { 1e-13 }, "{method:?} {step} {length}: {far}");
            }
        }
    }
}

#[test]
fn closed_seams_of_swinging_panels_win_no_energy() {
    for (side, third) in [(7, false), (7, true)] {
        let mut scene = Scene::new("swing").time(0.005, 0.0005);
        let held = panel("left", side, [-0.25, 0.0, 0.0]).pin(Select::cols(0, 0));
        scene = scene.body(held).body(panel("right", side, [0.25, 0.0, 0.0])).seam(edges(side));
        if third {
            let edge = |name: &str, col| SeamSide::new(name, Select::cols(col, col));
            let more = panel("third", side, [0.25, 0.0, 0.0]);
            scene = scene.body(more).seam(Seam::new(edge("left", side - 1), edge("third", 0)));
        }
        let mut simulation = build(&scene);
        let (start, mut before) = (simulation.report().energy(), f64::INFINITY);
        for frame in 0..600 {
            run(&mut simulation, 1);
            let energy = simulation.report().energy();
            // Symplectic Euler lets energy breathe by some thousandths of what moves.
            let room = 0.003 * simulation.report().kinetic;
            assert!(energy <= start + room && energy <= before + room, "{frame}: {before} {energy}");
            before = energy;
        }
        assert!(before < start - 0.01, "{start} {before}");
    }
}

#[test]
fn a_joint_of_two_bobs_stops_what_parts_them_and_goes_on_with_their_momentum() {
    for mass in [[1.0, 1.0], [0.2, 3.0]] {
        let seam = Seam::pairs("a", "b", [[0, 0]]).closing(0.0, 1.0, 0.3);
        let scene = weightless("bobs", 0.01, 0.01)
            .body(bob("a", [0.0; 3], mass[0]))
            .body(bob("b", [0.0, 0.3, 0.0], mass[1]))
            .seam(seam);
        let mut simulation = build(&scene);
        let x = positions(&simulation);
        let v = [[0.0, -1.0, 0.0], [0.0; 3], [0.0, 2.0, 0.0], [0.0; 3]];
        state::set(&mut simulation, &x, &v);
        run(&mut simulation, 1);
        let (x, after) = state::state(&simulation);
        let common = (2.0 * mass[1] - mass[0]) / (mass[0] + mass[1]);
        near("first", after[0][1], common, 1e-12);
        near("second", after[2][1], common, 1e-12);
        near("distance", norm(sub(x[0], x[2])), 0.3, 1e-12);
    }
}

#[test]
fn a_weight_on_a_soft_seam_hangs_by_m_g_over_k() {
    for (k, step) in [(20.0, 0.001), (500.0, 0.01)] {
        let seam = Seam { k: Some(k), ..Seam::pairs("nail", "bob", [[0, 0]]) };
        let mut scene =
            Scene::new("hang").body(fixed("nail", [0.0; 3])).body(bob("bob", [0.0; 3], 0.2)).seam(seam);
        scene = scene.time(0.01, step);
        scene.world.drag = 1.0;
        let mut simulation = build(&scene);
        run(&mut simulation, 2000);
        near("sag", -positions(&simulation)[2][1], 0.2 * 9.81 / k, 1e-9);
    }
}

#[test]
fn nodes_are_sewn_in_the_order_in_which_they_are_listed() {
    let side = |name: &str, nodes: [u32; 2]| SeamSide::new(name, Select::nodes(nodes));
    let scene = |b: [u32; 2]| {
        let seam = Seam::new(side("a", [0, 1]), side("b", b)).closing(0.0, 0.1, 0.0);
        weightless("order", 0.01, 0.001)
            .body(two("a", [0.0; 3], 1.0).pin(Select::nodes([0, 1])))
            .body(two("b", [0.0, 0.2, 0.0], 1.0))
            .seam(seam)
    };
    for (order, first) in [([0, 1], 0.0), ([1, 0], 1.0)] {
        let mut simulation = build(&scene(order));
        run(&mut simulation, 100);
        near("first node of the second body", positions(&simulation)[2][0], first, 1e-9);
    }
}

#[test]
fn what_is_within_reach_is_sewn_and_a_body_to_itself() {
    // A strip folded about its middle: each node to the one above it. Half of them are beyond the reach.
    let near_side = SeamSide::new("left", Select::cols(8, 8));
    let seam = |reach| Seam { reach: Some(reach), ..Seam::new(near_side.clone(), SeamSide::body("right")) };
    let mut simulation = build(&panels(0.1).seam(seam(0.11).clone()));
    run(&mut simulation, 150);
    assert!(gap(&simulation, 9) < 1e-9);
    let half = Bounds { min: [-9.0, -9.0, -0.01], max: [9.0; 3] };
    let select = Select { inside: Some(half), ..Select::cols(8, 8) };
    let some = Seam { from: SeamSide::new("left", select), ..seam(0.11) };
    let mut simulation = build(&panels(0.1).seam(some));
    run(&mut simulation, 150);
    let x = positions(&simulation);
    let sewn = (0..9).filter(|row| norm(sub(x[row * 9 + 8], x[81 + row * 9])) < 1e-9).count();
    assert_eq!(sewn, 5);
    // Of one body, neighbours are none, be they across a square: what is left is a fold.
    let body =
        |reach| Seam { reach: Some(reach), ..Seam::new(SeamSide::body("left"), SeamSide::body("left")) };
    let spacing = 0.5 / 8.0;
    let flat = |seam| Simulation::new(&panels(0.1).seam(seam), &taffeta::Options::default());
    let refused = scene_error(flat(body(1.5 * spacing)));
    assert!(refused.message.contains("is so near to one of `left` that is not its neighbour"), "{refused}");
    assert_eq!(flat(body(2.1 * spacing)).map(|built| built.seam_pair_counts()[0] > 40), Ok(true));
    // A tube: the left edge of a panel to its right one.
    let edge = |col| SeamSide::new("left", Select::cols(col, col));
    let seam = Seam { close: Closing { start: 0.0, end: 0.8 }, ..Seam::new(edge(0), edge(8)) };
    let mut scene = weightless("tube", 0.005, 0.001).body(panel("left", 9, [0.0; 3])).seam(seam);
    scene.world.drag = 0.002;
    let mut simulation = build(&scene);
    simulation.disturb(1e-4, 3);
    run(&mut simulation, 400);
    let x = positions(&simulation);
    for row in 0..9 {
        near("seam of the tube", norm(sub(x[row * 9], x[row * 9 + 8])), 0.0, 1e-9);
    }
}

#[test]
fn a_bob_on_a_rigid_rod_swings_with_the_period_of_a_pendulum() {
    let length = 0.5;
    let angle: f64 = 0.05;
    let at = [length * angle.sin(), -length * angle.cos(), 0.0];
    let seam = Seam::pairs("nail", "bob", [[0, 0]]).closing(0.0, 0.1, length);
    let scene = Scene::new("pendulum").body(fixed("nail", [0.0; 3])).body(bob("bob", at, 0.1)).seam(seam);
    let mut simulation = build(&scene.time(0.001, 0.0001));
    let period = std::f64::consts::TAU * (length / 9.81_f64).sqrt() * (1.0 + angle * angle / 16.0);
    let mut crossings = Vec::new();
    let mut before: V = at;
    for frame in 1..=3000 {
        run(&mut simulation, 1);
        let x = positions(&simulation)[2];
        near("rod", dot(x, x).sqrt(), length, 1e-12);
        if before[0] > 0.0 && x[0] <= 0.0 {
            crossings.push(0.001 * (f64::from(frame) - x[0] / (x[0] - before[0])));
        }
        before = x;
    }
    near("period", crossings[1] - crossings[0], period, 0.001 * period);
    assert!(norm(add(before, scale(at, -1.0))) < 2.0 * norm(at));
}

#[test]
fn seams_that_meet_and_close_at_different_times_throw_nothing() {
    // An armpit: as front and back come together, the sleeve is to be at different distances from them.
    let mut scene = Scene::new("armpit").time(1.0 / 60.0, 0.001);
    for (name, z) in [("front", 0.05), ("back", -0.05)] {
        scene = scene.body(panel(name, 9, [0.0, 0.0, z]).pin(Select::nodes([0, 8])));
    }
    scene = scene.body(panel("sleeve", 9, [0.55, 0.0, 0.0]));
    let side = |name: &str| SeamSide::new(name, Select { rows: Some([3, 8]), ..Select::cols(8, 8) });
    scene = scene
        .seam(Seam::new(side("front"), side("back")).closing(0.0, 0.3, 0.0))
        .seam(Seam::pairs("front", "sleeve", [[35, 36], [26, 37]]).closing(0.0, 0.6, 0.0))
        .seam(Seam::pairs("back", "sleeve", [[35, 36]]).closing(0.2, 0.8, 0.0));
    let mut simulation = build(&scene);
    let mut fastest: f64 = 0.0;
    for _ in 0..90 {
        run(&mut simulation, 1);
        fastest = fastest.max(state::state(&simulation).1.into_iter().map(norm).fold(0.0, f64::max));
    }
    assert!(fastest < 20.0, "{fastest} m/s");
    let x = positions(&simulation);
    near("closed", norm(sub(x[35], x[81 + 35])), 0.0, 1e-9);
    near("closed", norm(sub(x[35], x[162 + 36])), 0.0, 1e-9);
}
