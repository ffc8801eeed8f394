//! The engine against a system by blocks, solved by factors, over some tens of steps.

use super::{accurate, chain, with};
use crate::common::compare::{DT, STEP, cloth, compare, compare_for, join_grid, reference, scene};
use crate::common::lists::{edges, lumped, shared_edges};
use crate::common::reference::{Kind, Load, Obstacle, Reference, Rigid};
use crate::common::state::stiffen;
use crate::common::{build, build_as, farthest, positions, run, scale, surface, turned};
use taffeta::scene::{
    Body, Collider, Cube, Force, Icosphere, Internal, Keyframe, Mass, Mesh, Scene, Select, Torque, VolumeForm,
};
use taffeta::{Precision, Simulation};

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
    for (rows, cols) in [(7, 9), (9, 4), (8, 8), (1, 21), (20, 1), (2, 2), (2, 17), (16, 2), (3, 5)] {
        let size = [0.1 * f64::from(cols - 1), 0.1 * f64::from(rows - 1)];
        for newton_steps in [1, 2] {
            for stiffer in [1.0, 1e3] {
                let mut body = cloth(rows, cols, size).pin(Select::nodes([0]));
                stiffen(&mut body, stiffer);
                let scene = with(scene(body), accurate(newton_steps));
                let (simulation, mut reference) = grid(&scene, rows as usize, cols as usize, stiffer);
                reference.held.insert(0);
                compare_for(simulation, reference, if stiffer > 1.0 { 1e-3 } else { 0.01 }, 10);
            }
        }
    }
}

#[test]
fn chains_move_as_their_systems_do() {
    for (links, held) in [(1, vec![0]), (2, vec![1]), (40, vec![0, 40]), (33, vec![])] {
        for [k, d] in [[90.0, 0.0], [2e4, 3.0]] {
            let body = chain(links, 0.1 * f64::from(links), 0.05, [k, d]);
            let body = if held.is_empty() { body } else { body.pin(Select::nodes(held.clone())) };
            let scene = with(scene(body), accurate(3));
            let simulation = build(&scene);
            let n = links as usize;
            let mut reference = reference(&scene, &simulation, vec![0.05; n + 1]);
            reference.join((0..n).map(|n| [n, n + 1]), [k, d]);
            reference.held.extend(held.iter().map(|&n| n as usize));
            compare_for(simulation, reference, 0.004, 10);
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
    for newton_steps in [1, 2, 3] {
        let scene = with(scene(body.clone()), accurate(newton_steps));
        let (simulation, mut reference) = grid(&scene, 7, 9, 1e4);
        reference.held.extend([0, 1, 8, 30, 60, 62]);
        reference.pins = pinned.map(|n| (n as usize, reference.x[n as usize], path)).to_vec();
        compare(simulation, reference, 5e-4);
    }
}

#[test]
fn sheets_with_hinges_loads_and_masses_by_area_move_as_their_systems_do() {
    let torque = Torque { axis: [0.0, 1.0, 0.0], value: 0.4, about: [0.1, 0.0, -0.1] };
    let load = |nodes: Vec<u32>, force, torque| Force {
        body: "cloth".into(),
        select: Select::nodes(nodes),
        force,
        torque,
        motion: vec![],
    };
    for newton_steps in [1, 3] {
        let body = cloth(7, 9, [0.8, 0.6]).with_mass(Mass::Area(8.0)).hinge(0.02, 1e-4);
        let scene = with(scene(body), accurate(newton_steps))
            .force(load(vec![3, 11, 40], Some([0.5, -1.0, 2.0]), None))
            .force(load((9..36).collect(), None, Some(torque.clone())));
        let (simulation, mut reference) = grid(&scene, 7, 9, 1.0);
        let triangles = surface(&simulation, 0).triangles;
        reference.mass = lumped(&positions(&simulation), &triangles, 8.0);
        reference.hinge(&triangles, [0.02, 1e-4]);
        let force = Kind::Force([0.5, -1.0, 2.0]);
        reference.loads.push(Load { nodes: vec![3, 11, 40], kind: force, scale: |_| 1.0 });
        let turn = Kind::Torque(torque.value, torque.axis, torque.about);
        reference.loads.push(Load { nodes: (9..36).collect(), kind: turn, scale: |_| 1.0 });
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
    for (stiffer, rub, newton_steps, allowed) in
        [(1.0, 0.0, 1, 1e-6), (1.0, 1.0, 2, 2e-5), (200.0, 0.0, 2, 1e-6), (200.0, 1.0, 1, 2e-5)]
    {
        let mut body = cloth(7, 9, [0.8, 0.6]);
        stiffen(&mut body, stiffer);
        let scene = scene(body).collider(ball.clone().friction(0.4 * rub).keyframe(key(swing)));
        let scene = scene.collider(slope.clone().friction(0.2 * rub).keyframe(key(rise)));
        let scene = with(scene, accurate(newton_steps));
        let (mut simulation, mut reference) = grid(&scene, 7, 9, stiffer);
        reference.obstacles =
            vec![obstacle(at, Some(0.1), 0.4 * rub, 0.3, swing), obstacle(foot, None, 0.2 * rub, 0.0, rise)];
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

/// A ball and a cube with struts, their lists of springs, and some nodes held.
fn soft_bodies(settings: impl Fn(Body) -> Scene) -> Vec<(Simulation, Reference)> {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 });
    let mut ball = Body::soft("ball", mesh).structural(6000.0, 0.5).bend(400.0, 0.1);
    ball.place = turned([0.3, 1.0, -0.2], 71.0, [3.0, -1.0, 0.5]);
    let cube = Body::soft("cube", Mesh::Cube(Cube { size: 0.5, divisions: 2 })).structural(6000.0, 0.5);
    let struts = [[0, 25], [3, 20], [7, 18], [25, 1], [12, 13]];
    let all = [(ball, true), (cube, false)].map(|(mut body, bent)| {
        body.springs.internal =
            Some(Internal { k: 7000.0, d: 0.2, pairs: Some(struts.to_vec()), ..Internal::default() });
        let scene = settings(body.with_mass(Mass::Node(0.1)).pin(Select::nodes([5, 19])));
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
        (simulation, reference)
    });
    all.into()
}

#[test]
fn a_ball_and_a_cube_with_struts_move_as_their_systems_do() {
    for newton_steps in [1, 2] {
        for (simulation, reference) in soft_bodies(|body| with(scene(body), accurate(newton_steps))) {
            compare_for(simulation, reference, 0.01, 10);
        }
    }
}

#[test]
fn a_ball_that_keeps_its_volume_moves_as_its_system_and_its_volume_have_it() {
    // Springs are solved for without the force that keeps the volume; that one is found with what they do.
    for newton_steps in [1, 2] {
        let settings =
            |body: Body| with(scene(body.keep_volume(VolumeForm::Corrected)), accurate(newton_steps));
        for (simulation, mut reference) in soft_bodies(settings) {
            reference.keep_volume(surface(&simulation, 0).triangles, false);
            compare_for(simulation, reference, 0.01, 10);
        }
    }
}

#[test]
fn in_32_bits_sheets_move_as_in_64_bits_to_a_tenth_of_a_millimetre() {
    let mut body = cloth(19, 14, [1.3, 1.8]).pin(Select::nodes([0, 13]));
    stiffen(&mut body, 50.0);
    for newton_steps in [1, 2] {
        let mut ice = accurate(newton_steps);
        ice.tolerance = 1e-5;
        let scene = with(scene(body.clone()), ice);
        let places = |precision| {
            let mut simulation = build_as(&scene, precision, 1);
            run(&mut simulation, 100);
            positions(&simulation)
        };
        let apart = farthest(&places(Precision::F32), &places(Precision::F64));
        assert!(apart < 1e-4, "{newton_steps}: {apart:e} m");
    }
}
