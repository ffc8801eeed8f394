//! The engine against a system assembled in compressed rows and solved by factors, over sixty steps.

use super::{accurate, any, chain, noise, set, state, stiffen, with_acad, with_ice};
use crate::common::compare::{DT, STEP, cloth, compare, compare_for, join_grid, reference, scene};
use crate::common::lists::{edges, lumped, shared_edges};
use crate::common::reference::{Obstacle, Reference, Rigid};
use crate::common::{
    build, build_as, farthest, norm, positions, run, scale, sub, surface, turned, weightless,
};
use taffeta::scene::{
    Acad, Body, Collider, ConstraintForm, Cube, Ice, Icosphere, Internal, Keyframe, Mass, Mesh,
};
use taffeta::scene::{Method, Scene, Select, VolumeForm};
use taffeta::{Precision, Simulation};

/// Methods that a direct solver can follow: what makes constraints compliant makes the system definite.
fn methods(scene: &Scene) -> Vec<Scene> {
    let relaxed = Ice { epsilon: 0.1, warm_start: false, ..accurate() };
    let slow = Acad { threshold: 0.02, release: 0.01, target: 0.015, epsilon: 0.1, ..Acad::default() };
    vec![
        with_ice(scene.clone(), accurate()),
        with_ice(scene.clone(), relaxed),
        with_acad(scene.clone(), Acad { threshold: 0.02, ..Acad::default() }, accurate()),
        with_acad(scene.clone(), slow, Ice { warm_start: false, ..accurate() }),
    ]
}

/// A grid and its list of springs, `stiffer` times as stiff as the cloth of the other oracles.
fn grid(scene: &Scene, rows: usize, cols: usize, stiffer: f64) -> (Simulation, Reference) {
    let simulation = build(scene);
    let mut reference = reference(scene, &simulation, vec![0.05; rows * cols]);
    join_grid(&mut reference, rows, cols);
    reference.springs.iter_mut().for_each(|spring| spring.2 *= stiffer);
    (simulation, reference)
}

#[test]
fn grids_of_any_shape_move_as_their_systems_do() {
    for (rows, cols) in [(7, 9), (9, 4), (1, 21), (21, 1), (2, 2), (2, 17)] {
        let size = [0.1 * f64::from(cols - 1), 0.1 * f64::from(rows - 1)];
        for scene in methods(&scene(cloth(rows, cols, size).pin(Select::nodes([0])))) {
            let (simulation, mut reference) = grid(&scene, rows as usize, cols as usize, 1.0);
            reference.held.insert(0);
            compare(simulation, reference, 0.01);
        }
    }
}

#[test]
fn stiff_sheets_with_pins_that_turn_and_shift_move_as_their_systems_do() {
    let axis = scale([1.0, 2.0, -2.0], 1.0 / 3.0);
    let pivot = [0.2, 0.1, 0.0];
    let path = Rigid { until: 0.03, shift: [0.02, 0.01, -0.03], axis, radians: 0.3, pivot };
    let key = Keyframe { translate: path.shift, ..Keyframe::rotate(0.03, axis, 0.3_f64.to_degrees(), pivot) };
    let pinned = [0, 1, 8, 30];
    let mut body =
        cloth(7, 9, [0.8, 0.6]).pin_moving(Select::nodes(pinned), vec![key]).pin(Select::nodes([60, 62]));
    stiffen(&mut body, 1e4);
    for ice in [accurate(), Ice { epsilon: 0.01, ..accurate() }] {
        let scene = with_ice(scene(body.clone()), ice);
        let (simulation, mut reference) = grid(&scene, 7, 9, 1e4);
        reference.held.extend([0, 1, 8, 30, 60, 62]);
        reference.pins = pinned.map(|n| (n as usize, reference.x[n as usize], path)).to_vec();
        compare(simulation, reference, 5e-4);
    }
}

#[test]
fn sheets_with_hinges_and_masses_by_area_move_as_their_systems_do() {
    for scene in methods(&scene(cloth(7, 9, [0.8, 0.6]).with_mass(Mass::Area(8.0)).hinge(0.02, 1e-4))) {
        let (simulation, mut reference) = grid(&scene, 7, 9, 1.0);
        let triangles = surface(&simulation, 0).triangles;
        reference.mass = lumped(&positions(&simulation), &triangles, 8.0);
        reference.hinge(&triangles, [0.02, 1e-4]);
        compare(simulation, reference, 0.005);
    }
}

#[test]
fn sheets_on_a_ball_that_turns_and_a_slope_that_rises_move_as_their_systems_do() {
    let axis = scale([1.0, 2.0, -2.0], 1.0 / 3.0);
    let (shift, pivot) = ([0.02, 0.01, -0.03], [0.3, -0.2, 0.1]);
    let swing = Rigid { until: 0.03, shift, axis, radians: 0.5, pivot };
    let rise = Rigid { shift: [0.0, 0.01, 0.0], radians: 0.05, ..swing };
    let key = |path: Rigid| Keyframe {
        translate: path.shift,
        ..Keyframe::rotate(path.until, axis, path.radians.to_degrees(), pivot)
    };
    let (at, foot, normal) = ([0.0, -0.099, 0.0], [0.35, -0.01, 0.0], scale([-3.0, 4.0, 0.0], 0.2));
    let ball = Collider::sphere(at, 0.09).offset(0.01).restitution(0.3);
    let slope = Collider::plane(foot, normal).offset(0.0);
    let obstacle = |at, ball, friction, restitution, motion| Obstacle {
        at,
        ball,
        normal,
        friction,
        restitution,
        motion,
    };
    // Where a node lands on a surface, a rounding decides whether contact acts in this step or in the next.
    for (stiffer, rub, allowed) in
        [(1.0, 0.0, 1e-6), (1.0, 1.0, 2e-5), (200.0, 0.0, 1e-6), (200.0, 1.0, 2e-5)]
    {
        let mut body = cloth(7, 9, [0.8, 0.6]);
        stiffen(&mut body, stiffer);
        let scene = scene(body).collider(ball.clone().friction(0.4 * rub).keyframe(key(swing)));
        let scene = scene.collider(slope.clone().friction(0.2 * rub).keyframe(key(rise)));
        for scene in methods(&scene).into_iter().take(if stiffer > 1.0 { 2 } else { 4 }) {
            let (mut simulation, mut reference) = grid(&scene, 7, 9, stiffer);
            reference.obstacles = vec![
                obstacle(at, Some(0.1), 0.4 * rub, 0.3, swing),
                obstacle(foot, None, 0.2 * rub, 0.0, rise),
            ];
            simulation.disturb(0.004, 7);
            reference.x = positions(&simulation);
            let mut touched = 0;
            for frame in 1..=20 {
                run(&mut simulation, 1);
                [STEP, STEP, DT - 2.0 * STEP].into_iter().for_each(|h| reference.step(h));
                let apart = farthest(&positions(&simulation), &reference.x);
                assert!(apart < allowed, "frame {frame}: {apart:e} m apart, {:?}", scene.solver);
                touched += reference.touched;
            }
            assert!(touched > 5, "{touched}");
        }
    }
}

#[test]
fn a_ball_and_a_cube_with_struts_move_as_their_systems_do() {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 1 });
    let mut ball = Body::soft("ball", mesh).structural(6000.0, 0.5).bend(400.0, 0.1);
    ball.place = turned([0.3, 1.0, -0.2], 71.0, [3.0, -1.0, 0.5]);
    let cube = Body::soft("cube", Mesh::Cube(Cube { size: 0.5, divisions: 2 })).structural(6000.0, 0.5);
    let struts = [[0, 25], [3, 20], [7, 18], [25, 1], [12, 13]];
    for (mut body, bent) in [(ball, true), (cube, false)] {
        body.springs.internal =
            Some(Internal { k: 7000.0, d: 0.2, pairs: Some(struts.to_vec()), ..Internal::default() });
        let body = body.with_mass(Mass::Node(0.1)).pin(Select::nodes([5, 19]));
        for scene in methods(&scene(body)) {
            let simulation = build(&scene);
            let triangles = surface(&simulation, 0).triangles;
            let nodes = positions(&simulation).len();
            let mut reference = reference(&scene, &simulation, vec![0.1; nodes]);
            reference.join(edges(&triangles), [6000.0, 0.5]);
            if bent {
                let opposite = shared_edges(&triangles).into_iter().map(|[_, _, c, d]| [c, d]);
                reference.join(opposite, [400.0, 0.1]);
            }
            reference.join(struts.map(|pair| pair.map(|n| n as usize)), [7000.0, 0.2]);
            reference.held.extend([5, 19]);
            compare_for(simulation, reference, 0.01, 10);
        }
    }
}

#[test]
fn a_ball_that_keeps_its_volume_moves_as_its_system_and_its_volume_have_it() {
    // Pulls are found without the force that keeps the volume; that one is found with the pulls.
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 1 });
    let ball = Body::soft("ball", mesh).with_mass(Mass::Node(0.1)).structural(6000.0, 0.5);
    let ball = ball.bend(400.0, 0.1).pin(Select::nodes([5])).keep_volume(VolumeForm::Corrected);
    for scene in methods(&scene(ball)) {
        let simulation = build(&scene);
        let triangles = surface(&simulation, 0).triangles;
        let mut reference = reference(&scene, &simulation, vec![0.1; 42]);
        reference.join(edges(&triangles), [6000.0, 0.5]);
        let opposite = shared_edges(&triangles).into_iter().map(|[_, _, c, d]| [c, d]);
        reference.join(opposite, [400.0, 0.1]);
        reference.held.insert(5);
        reference.keep_volume(triangles, false);
        compare_for(simulation, reference, 0.01, 10);
    }
}

#[test]
fn the_printed_forms_of_chains_move_as_their_systems_do() {
    // Nothing but neighbours: with more constraints than directions the printed system is singular.
    let body = chain(12, 1.2, 0.05, [80.0, 0.05]).pin(Select::nodes([0]));
    let printed = ConstraintForm::Printed;
    let acad = Acad { threshold: 0.02, release: 0.01, target: 0.01, form: printed, ..Acad::default() };
    for scene in [
        with_ice(scene(body.clone()), Ice { form: printed, ..accurate() }),
        with_acad(scene(body.clone()), acad, accurate()),
    ] {
        let simulation = build(&scene);
        let mut reference = reference(&scene, &simulation, vec![0.05; 13]);
        reference.join((0..12).map(|n| [n, n + 1]), [80.0, 0.05]);
        reference.held.insert(0);
        compare(simulation, reference, 0.005);
    }
}

#[test]
fn one_step_of_a_sheet_takes_away_what_factors_say_to_a_millionth() {
    // Judged by velocities: forces are what matters of multipliers. All three kinds, 1,946 constraints, a step of 16 ms.
    let (h, stiffer) = (0.016, 1e3);
    let mut body = cloth(19, 19, [1.8, 1.8]).pin(Select::rows(0, 0));
    stiffen(&mut body, stiffer);
    let scene = with_ice(Scene::new("one step").time(h, h).body(body), Ice { tolerance: 1e-9, ..accurate() });
    let (mut simulation, mut reference) = grid(&scene, 19, 19, stiffer);
    reference.held.extend(0..19);
    let mut random = noise(3);
    for n in 19..361 {
        reference.v[n] = any(&mut random);
        reference.x[n] = crate::common::add(reference.x[n], scale(any(&mut random), 0.01));
    }
    set(&mut simulation, &reference.x, &reference.v);
    let free = reference.free_velocities(&reference.forces(), h);
    run(&mut simulation, 1);
    reference.step(h);
    let size = |a: &[[f64; 3]], b: &[[f64; 3]]| {
        a.iter().zip(b).map(|(&a, &b)| norm(sub(a, b)).powi(2)).sum::<f64>().sqrt()
    };
    let (error, all) = (size(&state(&simulation).1, &reference.v), size(&free, &reference.v));
    assert!(all > 1.0 && error < 1e-6 * all, "{:e}", error / all);
}

#[test]
fn constraints_between_held_nodes_are_left_out() {
    // All nodes of a sheet but one are held: what is left are the constraints of that one.
    let held: Vec<u32> = (0..25).filter(|&n| n != 12).collect();
    let body = cloth(5, 5, [0.4, 0.4]).pin(Select::nodes(held.clone()));
    for scene in methods(&scene(body)) {
        let (simulation, mut reference) = grid(&scene, 5, 5, 1.0);
        reference.held.extend(held.iter().map(|&n| n as usize));
        assert_eq!(reference.rows(STEP.min(DT)).len(), if reference.is_constraint(0) { 12 } else { 0 });
        compare(simulation, reference, 0.02);
    }
    // Where all are held nothing is left, and nothing fails.
    let mut still = build(&with_ice(
        weightless("held", DT, STEP).body(cloth(3, 3, [0.2, 0.2]).pin(Select::rows(0, 2))),
        accurate(),
    ));
    run(&mut still, 3);
    assert_eq!(still.report().kinetic, 0.0);
}

#[test]
fn in_32_bits_sheets_move_as_in_64_bits_to_a_tenth_of_a_millimetre() {
    let mut body = cloth(19, 14, [1.3, 1.8]).pin(Select::nodes([0, 13]));
    stiffen(&mut body, 50.0);
    for scene in methods(&scene(body)) {
        let scene = with(scene, |ice| ice.tolerance = 1e-5);
        // A spring that is at the threshold but for a rounding is a constraint in one of them alone.
        let frames = if scene.solver.method == Method::Acad { 10 } else { 100 };
        let places = |precision| {
            let mut simulation = build_as(&scene, precision, 2);
            run(&mut simulation, frames);
            positions(&simulation)
        };
        let apart = farthest(&places(Precision::F32), &places(Precision::F64));
        assert!(apart < 1e-4, "{:?}: {apart:e} m", scene.solver);
    }
}

fn with(mut scene: Scene, change: impl Fn(&mut Ice)) -> Scene {
    change(&mut scene.solver.ice);
    scene
}
