//! The engine against a naive reference in 64 bits: positions, energies and momenta over some fifty steps.

use crate::common::compare::{cloth, compare, join_grid, reference, scene};
use crate::common::lists::{edges, lumped, shared_edges};
use crate::common::reference::{Kind, Load, Obstacle, Rigid};
use crate::common::{V, add, build, build_as, norm, positions, run, scale, sub, surface, turned, weightless};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Cube, Force, Icosphere, Internal, Keyframe, Mass, Mesh, ScaleKey};
use taffeta::scene::{Rotation, Select, Torque};

#[test]
fn grids_of_any_shape_move_as_their_lists_of_springs_do() {
    let shapes = [
        (7, 9, [0.8, 0.9]),
        (9, 7, [0.3, 0.9]),
        (1, 11, [1.0, 0.0]),
        (11, 1, [0.0, 1.0]),
        (2, 2, [0.1, 0.1]),
        (2, 17, [1.7, 0.1]),
        (17, 3, [0.2, 1.6]),
        (4, 16, [1.5, 0.3]),
        (70, 33, [3.2, 6.9]),
    ];
    for (rows, cols, size) in shapes {
        let scene = scene(cloth(rows, cols, size).pin(Select::nodes([0])));
        let simulation = build(&scene);
        let (rows, cols) = (rows as usize, cols as usize);
        let mut reference = reference(&scene, &simulation, vec![0.05; rows * cols]);
        join_grid(&mut reference, rows, cols);
        reference.held.insert(0);
        compare(simulation, reference, 0.02);
    }
}

#[test]
fn long_and_wide_grids_have_no_seam() {
    for (rows, cols, threads) in [(5, 1100, 1), (3, 513, 3), (7, 2060, 2), (1, 2500, 2), (2, 4103, 8)] {
        let size = [0.1 * f64::from(cols - 1), 0.1 * f64::from(rows - 1)];
        let scene = scene(cloth(rows, cols, size));
        let simulation = build_as(&scene, Precision::F64, threads);
        let (rows, cols) = (rows as usize, cols as usize);
        let mut reference = reference(&scene, &simulation, vec![0.05; rows * cols]);
        join_grid(&mut reference, rows, cols);
        compare(simulation, reference, 0.02);
    }
}

#[test]
fn a_step_of_a_grid_of_four_million_nodes_has_no_seam() {
    // Larger than any strip both ways, so that strips meet; each node by itself, from its twelve neighbours.
    let (n, spacing, mass, h) = (2060_isize, 0.1, 0.05, 1e-3);
    let extent = spacing * (n - 1) as f64;
    let body = Body { pins: vec![], ..cloth(n as u32, n as u32, [extent, extent]) };
    let mut simulation = build_as(&weightless("large", h, h).body(body), Precision::F64, 3);
    simulation.disturb(0.02, 7);
    let before = positions(&simulation);
    run(&mut simulation, 1);
    let mut kinds = Vec::new();
    for (down, across, k) in
        [(0, 1, 80.0), (1, 0, 80.0), (1, 1, 50.0), (1, -1, 50.0), (0, 2, 30.0), (2, 0, 30.0)]
    {
        let rest = spacing * f64::hypot(down as f64, across as f64);
        kinds.extend([(down, across, k, rest), (-down, -across, k, rest)]);
    }
    for (node, (&x, got)) in before.iter().zip(positions(&simulation)).enumerate() {
        let (row, col) = (node as isize / n, node as isize % n);
        let mut force = [0.0; 3];
        for &(down, across, k, rest) in &kinds {
            if (0..n).contains(&(row + down)) && (0..n).contains(&(col + across)) {
                let apart = sub(before[((row + down) * n + col + across) as usize], x);
                force = add(force, scale(apart, k * (1.0 - rest / norm(apart))));
            }
        }
        let error = norm(sub(got, add(x, scale(force, h * h / mass))));
        assert!(error < 1e-12, "row {row}, column {col}: {error:e} m");
    }
}

#[test]
fn a_grid_with_hinges_and_area_masses_moves_as_its_triangles_do() {
    let mut body = cloth(6, 5, [0.4, 0.5]).with_mass(Mass::Area(3.0)).hinge(0.02, 1e-4);
    body.place = turned([1.0, 2.0, 0.5], 33.0, [0.1, 2.0, 0.3]);
    let scene = scene(body.pin(Select::rows(0, 0)));
    let simulation = build(&scene);
    let triangles = surface(&simulation, 0).triangles;
    let mass = lumped(&positions(&simulation), &triangles, 3.0);
    let mut reference = reference(&scene, &simulation, mass);
    join_grid(&mut reference, 6, 5);
    reference.hinge(&triangles, [0.02, 1e-4]);
    reference.held.extend(0..5);
    compare(simulation, reference, 0.01);
}

#[test]
fn an_icosphere_moves_as_its_edges_opposite_corners_and_folds_do() {
    for (mass, whole) in [(Mass::Whole(2.0), true), (Mass::Node(0.02), false)] {
        let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 });
        let mut body = Body::cloth("ball", mesh)
            .with_mass(mass)
            .structural(60.0, 0.05)
            .bend(40.0, 0.01)
            .hinge(0.05, 2e-4);
        body.place = turned([0.3, 1.0, -0.2], 71.0, [3.0, -1.0, 0.5]);
        let scene = scene(body.pin(Select::nodes([5, 100])));
        let simulation = build(&scene);
        let (triangles, x) = (surface(&simulation, 0).triangles, positions(&simulation));
        let share = lumped(&x, &triangles, 1.0);
        let total: f64 = share.iter().sum();
        let mass = share.iter().map(|s| if whole { 2.0 * s / total } else { 0.02 }).collect();
        let mut reference = reference(&scene, &simulation, mass);
        reference.join(edges(&triangles), [60.0, 0.05]);
        reference.join(shared_edges(&triangles).into_iter().map(|[_, _, c, d]| [c, d]), [40.0, 0.01]);
        reference.hinge(&triangles, [0.05, 2e-4]);
        reference.held.extend([5, 100]);
        compare(simulation, reference, 0.01);
    }
}

#[test]
fn a_cube_with_given_struts_moves_as_its_edges_and_struts_do() {
    let mut body = Body::soft("cube", Mesh::Cube(Cube { size: 1.0, divisions: 2 }));
    body = body.with_mass(Mass::Node(0.1)).structural(90.0, 0.1);
    body.place.scale = Some(0.5);
    let struts = [[0, 25], [3, 20], [7, 18], [25, 1], [12, 13]];
    body.springs.internal =
        Some(Internal { k: 70.0, d: 0.2, pairs: Some(struts.to_vec()), ..Internal::default() });
    let scene = scene(body);
    let simulation = build(&scene);
    let triangles = surface(&simulation, 0).triangles;
    let mut reference = reference(&scene, &simulation, vec![0.1; 26]);
    reference.join(edges(&triangles), [90.0, 0.1]);
    reference.join(struts.map(|pair| pair.map(|n| n as usize)), [70.0, 0.2]);
    compare(simulation, reference, 0.02);
}

#[test]
fn point_forces_and_torques_act_as_keyed() {
    // Between its keys the scale rises from 0.5 at 10 ms to 3 at 40 ms.
    let rising = |t: f64| 0.5 + 2.5 * ((t - 0.01) / 0.03).clamp(0.0, 1.0);
    let keys = vec![ScaleKey { t: 0.01, scale: 0.5 }, ScaleKey { t: 0.04, scale: 3.0 }];
    let torque = Torque { axis: [0.0, 2.0, 0.0], value: 0.4, about: [0.1, 0.0, -0.1] };
    let load = |nodes: Vec<u32>, force, torque, motion| Force {
        body: "cloth".into(),
        select: Select::nodes(nodes),
        force,
        torque,
        motion,
    };
    let scene = scene(cloth(7, 9, [0.8, 0.6]))
        .force(load(vec![3, 11, 40], Some([0.5, -1.0, 2.0]), None, vec![]))
        .force(load((9..36).collect(), None, Some(torque), keys));
    let simulation = build(&scene);
    let mut reference = reference(&scene, &simulation, vec![0.05; 63]);
    join_grid(&mut reference, 7, 9);
    let force = Kind::Force([0.5, -1.0, 2.0]);
    reference.loads.push(Load { nodes: vec![3, 11, 40], kind: force, scale: |_| 1.0 });
    let torque = Kind::Torque(0.4, [0.0, 1.0, 0.0], [0.1, 0.0, -0.1]);
    reference.loads.push(Load { nodes: (9..36).collect(), kind: torque, scale: rising });
    compare(simulation, reference, 0.01);
}

/// A turn by 40° about a slanted axis and a shift, in 30 ms, and the same as a keyframe.
fn swing(pivot: V) -> (Rigid, Keyframe) {
    let axis = scale([1.0, 2.0, -2.0], 1.0 / 3.0);
    let shift = [0.02, 0.01, -0.03];
    let rigid = Rigid { until: 0.03, shift, axis, radians: 40_f64.to_radians(), pivot };
    let rotate = Some(Rotation { axis: [1.0, 2.0, -2.0], degrees: 40.0 });
    (rigid, Keyframe { t: 0.03, translate: shift, rotate, pivot, ..Keyframe::default() })
}

#[test]
fn pins_that_turn_and_shift_carry_the_cloth_with_them() {
    let (path, key) = swing([0.2, 0.1, 0.0]);
    let pinned = [0, 4, 8, 30];
    let still = Select::nodes([60, 62]);
    let scene = scene(cloth(7, 9, [0.8, 0.6]).pin_moving(Select::nodes(pinned), vec![key]).pin(still));
    let simulation = build(&scene);
    let mut reference = reference(&scene, &simulation, vec![0.05; 63]);
    join_grid(&mut reference, 7, 9);
    reference.held.extend([0, 4, 8, 30, 60, 62]);
    reference.pins = pinned.map(|n| (n as usize, reference.x[n as usize], path)).to_vec();
    compare(simulation, reference, 0.01);
}

#[test]
fn spheres_and_planes_that_move_push_and_rub_as_coulomb_has_it() {
    let (path, key) = swing([0.3, -0.2, 0.1]);
    let ball = Collider::sphere([0.0, -0.095, 0.0], 0.1).offset(0.01).friction(0.4).restitution(0.3);
    // The slope rises and tilts by 4° in 50 ms.
    let lift = [0.0, 0.01, 0.0];
    let axis = [0.0, 0.0, 1.0];
    let rise = Rigid { until: 0.05, shift: lift, axis, radians: 4_f64.to_radians(), pivot: [0.4, 0.0, 0.0] };
    let tilt = Keyframe { translate: lift, ..Keyframe::rotate(0.05, axis, 4.0, rise.pivot) };
    let slope = Collider::plane([0.35, -0.02, 0.0], [-1.0, 2.0, 0.0]).offset(0.005).friction(0.2);
    let scene =
        scene(cloth(7, 9, [0.8, 0.6])).collider(ball.keyframe(key.clone())).collider(slope.keyframe(tilt));
    let simulation = build(&scene);
    let mut reference = reference(&scene, &simulation, vec![0.05; 63]);
    join_grid(&mut reference, 7, 9);
    let normal = scale([-1.0, 2.0, 0.0], 1.0 / 5_f64.sqrt());
    let at = [0.0, -0.095, 0.0];
    reference.obstacles = vec![Obstacle {
        at,
        ball: Some(0.11),
        normal: [0.0; 3],
        friction: 0.4,
        restitution: 0.3,
        motion: path,
    }];
    let foot = add([0.35, -0.02, 0.0], scale(normal, 0.005));
    reference.obstacles.push(Obstacle {
        at: foot,
        ball: None,
        normal,
        friction: 0.2,
        restitution: 0.0,
        motion: rise,
    });
    compare(simulation, reference, 0.005);
}
