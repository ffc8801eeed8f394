//! Bend springs and hinges: what a fold costs, how fast it swings, where it comes to rest.

use crate::common::lists::{angle, edges, grid_pairs};
use crate::common::reference::Reference;
use crate::common::{V, add, build, farthest, near, norm, positions, run, sub, surface, weightless};
use std::sync::Arc;
use taffeta::diagnostics::FrameReport;
use taffeta::scene::{Body, Mass, Mesh, Select};
use taffeta::topology::Surface;

/// A sheet of 5 × 9 nodes, folded by `fold` [rad] at its middle column without stretch.
fn folded(body: Body, fold: f64) -> FrameReport {
    let mut simulation = build(&weightless("fold", 0.01, 0.01).body(body));
    let (sin, cos) = fold.sin_cos();
    for (vertex, x) in positions(&simulation).into_iter().enumerate() {
        let to = if x[0] > 0.0 { [x[0] * cos, x[0] * sin, x[2]] } else { x };
        simulation.pin_vertex(simulation.body("sheet").unwrap(), vertex, to).unwrap();
    }
    run(&mut simulation, 1);
    simulation.report().clone()
}

fn sheet() -> Body {
    Body::cloth("sheet", Mesh::grid(5, 9, [0.8, 0.4])).with_mass(Mass::Node(0.01)).structural(1e3, 0.0)
}

#[test]
fn a_fold_costs_bend_springs_the_fourth_power_of_its_angle() {
    // One spring a row, of 2 dx, is 2 dx cos(θ/2) long.
    let energy = |fold: f64| folded(sheet().bend(50.0, 0.0), fold).springs;
    for fold in [0.05_f64, 0.3, -1.2, 2.5] {
        let short = 0.2 * (1.0 - (fold / 2.0).cos());
        near("energy", energy(fold), 5.0 * 0.5 * 50.0 * short * short, 1e-13);
    }
    near("order", (energy(0.02) / energy(0.01)).log2(), 4.0, 1e-3);
}

#[test]
fn a_fold_costs_hinges_the_square_of_its_angle() {
    // Four edges along the fold; the other hinges stay flat.
    let energy = |fold: f64| folded(sheet().hinge(0.02, 0.0), fold);
    for fold in [0.05, 0.3, -1.2, 2.5] {
        near("energy", energy(fold).energy_of("hinges"), 4.0 * 0.5 * 0.02 * fold * fold, 1e-14);
        near("springs", energy(fold).springs, 0.0, 1e-20);
    }
    near("order", (energy(0.02).energy_of("hinges") / energy(0.01).energy_of("hinges")).log2(), 2.0, 1e-10);
}

/// Two triangles that share the edge of 0.5 m along z, folded up by `fold` [rad] at rest; corners 0.2 m away. The
/// first triangle is held.
fn leaf(fold: f64) -> Body {
    let nodes =
        vec![[0.0, 0.0, 0.0], [0.0, 0.0, 0.5], [-0.2, 0.0, 0.2], [0.2 * fold.cos(), 0.2 * fold.sin(), 0.3]];
    let triangles = vec![[0, 1, 2], [1, 0, 3]];
    let surface = Surface::of_triangles(nodes, triangles);
    let body = Body::cloth("leaf", Mesh::Surface(Arc::new(surface))).with_mass(Mass::Node(0.05));
    body.structural(500.0, 0.0).pin(Select::nodes([0, 1, 2]))
}

fn fold_of(x: &[V]) -> f64 {
    angle([x[0], x[1], x[2], x[3]]).abs()
}

#[test]
fn a_leaf_swings_with_the_frequency_of_its_hinge() {
    // ω² = k/(m r²), as the step h sees it: 2 sin(ω' h/2)/h = ω.
    for fold in [0.0, 1.0] {
        let (k, m, r, h) = (0.08, 0.05, 0.2, 1e-3);
        let mut simulation = build(&weightless("leaf", h, h).body(leaf(fold).hinge(k, 0.0)));
        let rest = positions(&simulation)[3];
        let normal = [-fold.sin(), fold.cos(), 0.0];
        let kick = normal.map(|n| 1e-3 * n);
        simulation.apply_force(simulation.body("leaf").unwrap(), 3, kick).unwrap();
        let omega = (k / m).sqrt() / r;
        let period = std::f64::consts::PI * h / (omega * h / 2.0).asin();
        let (mut before, mut crossings) = (0.0, Vec::new());
        while crossings.len() < 40 {
            run(&mut simulation, 1);
            let u = crate::common::dot(sub(positions(&simulation)[3], rest), normal);
            if before > 0.0 && u <= 0.0 {
                crossings.push(simulation.report().time - h * u / (u - before));
            }
            before = u;
        }
        let got = (crossings[39] - crossings[0]) / 39.0;
        near("period", got, period, 1e-5 * period);
    }
}

#[test]
fn a_leaf_comes_to_rest_at_its_rest_angle() {
    for fold in [0.0, 0.7, -2.2] {
        let mut scene = weightless("leaf", 0.05, 5e-4).body(leaf(fold).hinge(0.08, 0.01));
        scene.world.drag = 0.2;
        let mut simulation = build(&scene);
        let rest = positions(&simulation);
        simulation.apply_force(simulation.body("leaf").unwrap(), 3, [-0.1, 0.5, 0.1]).unwrap();
        run(&mut simulation, 1);
        assert!((fold_of(&positions(&simulation)) - fold.abs()).abs() > 0.02, "pushed off");
        run(&mut simulation, 600);
        // Its springs and its hinge are at rest in this one place alone.
        let apart = farthest(&positions(&simulation), &rest);
        assert!(apart < 1e-8, "{apart:e} m from rest");
        assert!(simulation.report().energy_of("hinges") < 1e-18 && simulation.report().kinetic < 1e-18);
    }
}

#[test]
fn a_hinges_damping_takes_the_swing_at_its_own_rate() {
    // m r² θ'' = −k θ − d θ': a swing decays by exp(−d t/(2 m r²)).
    let (k, d, inertia, h) = (0.08, 4e-4, 0.05 * 0.04, 1e-4);
    let mut simulation = build(&weightless("leaf", 0.001, h).body(leaf(0.0).hinge(k, d)));
    simulation.apply_force(simulation.body("leaf").unwrap(), 3, [0.0, 0.01, 0.0]).unwrap();
    let mut peaks: Vec<[f64; 2]> = Vec::new();
    let mut last = [0.0; 2];
    while simulation.report().time < 5.0 {
        run(&mut simulation, 1);
        let u = positions(&simulation)[3][1];
        if last[1] > last[0] && last[1] > u {
            peaks.push([simulation.report().time, last[1]]);
        }
        last = [last[1], u];
    }
    let [first, end] = [peaks[0], peaks[peaks.len() - 1]];
    let rate = (first[1] / end[1]).ln() / (end[0] - first[0]);
    near("rate", rate, d / (2.0 * inertia), 1e-2 * d / (2.0 * inertia));
}

/// A strip held by its first two columns, under a load [N] at each node of its last, at rest.
fn cantilever(load: f64) -> (f64, FrameReport, Vec<V>) {
    let body = Body::cloth("strip", Mesh::grid(3, 12, [1.1, 0.2])).with_mass(Mass::Node(0.01));
    let body = body.structural(2e3, 0.2).shear(2e3, 0.2).hinge(0.5, 1e-3).pin(Select::cols(0, 1));
    let mut scene = weightless("cantilever", 0.1, 2e-4).body(body).force(taffeta::scene::Force {
        body: "strip".into(),
        select: Select::cols(11, 11),
        force: Some([0.0, load, 0.0]),
        ..Default::default()
    });
    scene.world.drag = 0.03;
    let mut simulation = build(&scene);
    run(&mut simulation, 400);
    assert!(simulation.report().kinetic < 1e-20, "at rest: {:e}", simulation.report().kinetic);
    let x = positions(&simulation);
    ([11, 23, 35].iter().map(|&n| x[n][1]).sum::<f64>() / 3.0, simulation.report().clone(), x)
}

#[test]
fn a_hinged_cantilever_holds_half_the_work_of_its_load_and_bends_in_proportion() {
    // Clapeyron: the energy of a linear body at rest is half of load times way.
    let load = 1e-3;
    let [(small, report, _), (twice, ..)] = [load, 2.0 * load].map(cantilever);
    let work = 3.0 * load * small;
    near("energy", report.energy_of("hinges") + report.springs, 0.5 * work, 0.01 * work);
    assert!(report.springs < 0.02 * report.energy_of("hinges"), "bent, not stretched");
    near("proportion", twice / small, 2.0, 0.02);
    assert!(small > 3e-3, "{small}");
}

#[test]
fn a_hinged_cantilever_balances_its_load() {
    let (_, _, x) = cantilever(0.1);
    let body = Body::cloth("", Mesh::grid(3, 12, [1.1, 0.2])).with_mass(Mass::Node(0.01));
    let flat = build(&weightless("", 0.1, 0.1).body(body));
    let triangles = surface(&flat, 0).triangles;
    let mut springs = Reference::new(positions(&flat), vec![0.01; 36]);
    let grid = |down, across| grid_pairs(3, 12, down, across);
    springs.join(grid(0, 1).into_iter().chain(grid(1, 0)).chain(grid(1, 1)), [2e3, 0.0]);
    springs.hinge(&triangles, [0.5, 0.0]);
    assert_eq!(springs.folds.len(), edges(&triangles).len() - (2 * 11 + 2 * 2), "one a inner edge");
    springs.x = x;
    for (node, force) in springs.forces().into_iter().enumerate().filter(|(n, _)| n % 12 > 1) {
        let load = if node % 12 == 11 { [0.0, 0.1, 0.0] } else { [0.0; 3] };
        let left = norm(add(force, load));
        assert!(left < 1e-8, "node {node}: {left:e} N");
    }
}
