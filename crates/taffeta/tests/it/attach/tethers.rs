//! Nodes that may not go far from held ones.

use super::panel;
use crate::common::{
    V, add, build, build_as, dot, near, norm, positions, run, scale, sub, turned, weightless,
};
use taffeta::scene::{Body, ConstraintForm, Mesh, Method, Scene, Select};
use taffeta::{Precision, Simulation};

const SIDE: usize = 13;
const SPACING: f64 = 0.5 / 12.0;

/// A curtain of soft springs in the xy plane, its top row at y = 0.
fn curtain(pins: Select, k: f64) -> Body {
    let mut body = panel("curtain", SIDE as u32, [0.0; 3]).structural(k, 0.001).shear(k, 0.001).pin(pins);
    body.place = turned([1.0, 0.0, 0.0], 90.0, [0.0, -0.25, 0.0]);
    body
}

/// The way along edges and diagonals of a grid [m].
fn way(a: usize, b: usize) -> f64 {
    let apart = |of: fn(usize) -> usize| of(a).abs_diff(of(b)) as f64;
    let (rows, cols) = (apart(|n| n / SIDE), apart(|n| n % SIDE));
    (rows.max(cols) + (2_f64.sqrt() - 1.0) * rows.min(cols)) * SPACING
}

/// The largest distance of a free node from the nearest of some held ones, by the way.
fn farthest(x: &[V], held: &[usize]) -> f64 {
    let of = |node: usize| {
        let by_way = |a: &&usize, b: &&usize| way(node, **a).total_cmp(&way(node, **b));
        let nearest = *held.iter().min_by(by_way).expect("one is held");
        norm(sub(x[node], x[nearest])) / way(node, nearest)
    };
    (0..x.len()).filter(|node| !held.contains(node)).map(of).fold(0.0, f64::max)
}

#[test]
fn no_node_of_a_curtain_as_soft_as_1_n_m_goes_farther_than_its_way() {
    let top: Vec<usize> = (0..SIDE).collect();
    for (method, form, step) in [
        (Method::Springs, ConstraintForm::Compliant, 0.001),
        (Method::Springs, ConstraintForm::Compliant, 0.016),
        (Method::Ice, ConstraintForm::Compliant, 0.016),
        (Method::Ice, ConstraintForm::Primal, 0.016),
        (Method::Acad, ConstraintForm::Compliant, 0.004),
    ] {
        for slack in [0.0, 0.1] {
            let body = curtain(Select::rows(0, 0), 1.0);
            let mut scene = Scene::new("soft").body(body.tether(slack)).time(0.016, step).method(method);
            scene.solver.ice.form = form;
            let mut simulation = build(&scene);
            simulation.disturb(0.01, 5);
            let mut most: f64 = 0.0;
            for _ in 0..150 {
                run(&mut simulation, 1);
                most = most.max(farthest(&positions(&simulation), &top));
            }
            assert!(most < (1.0 + slack) * (1.0 + 1e-12), "{method:?} {step} {slack}: {most}");
            assert!(most > (1.0 + slack) * 0.999, "it hangs in its tethers: {most}");
            scene.bodies[0].tethers = None;
            let mut free = build(&scene);
            run(&mut free, 60);
            if method != Method::Acad {
                let far = farthest(&positions(&free), &top);
                assert!(far > 1.3, "{method:?} {step}: without tethers it stretches, {far}");
            }
        }
    }
}

#[test]
fn a_node_between_two_pins_has_a_tether_to_each() {
    let last = SIDE - 1;
    let body = curtain(Select::nodes([0, last as u32]), 2.0).tether(0.0);
    let mut simulation = build(&Scene::new("corners").body(body).time(0.016, 0.002));
    run(&mut simulation, 200);
    let x = positions(&simulation);
    for corner in [0, last] {
        let most = farthest(&x, &[corner]);
        assert!((0.999..1.0 + 1e-12).contains(&most), "{corner}: {most}");
    }
}

/// The point of some balls, by center and radius, nearest to `x` (Dykstra's algorithm of projections onto convex sets, 1983).
fn nearest_within(mut x: V, balls: &[(V, f64)]) -> V {
    let mut left = vec![[0.0; 3]; balls.len()];
    for _ in 0..20_000 {
        for (&(center, radius), left) in balls.iter().zip(&mut left) {
            let wish = add(x, *left);
            let from = sub(wish, center);
            let part = (radius / norm(from)).min(1.0);
            x = add(center, scale(from, part));
            *left = sub(wish, x);
        }
    }
    x
}

#[test]
fn tethers_move_a_node_to_the_nearest_place_that_they_allow() {
    // A board of 3 × 3 nodes that nothing but tethers holds together, in its first step.
    let spacing = 0.25;
    let way = |a: usize, b: usize| {
        let [rows, cols] = [(a / 3).abs_diff(b / 3), (a % 3).abs_diff(b % 3)];
        (rows.max(cols) as f64 + (2_f64.sqrt() - 1.0) * rows.min(cols) as f64) * spacing
    };
    let mut of_both = 0;
    for gravity in [[30.0, -60.0, 14.0], [-45.0, -8.0, -31.0], [4.0, 6.0, 70.0]] {
        for pins in [vec![0], vec![0, 2], vec![2, 7], vec![0, 5, 6], vec![0, 2, 6, 8]] {
            let pinned: Vec<u32> = pins.iter().map(|&pin| pin as u32).collect();
            let mut body = panel("board", 3, [0.0; 3]).pin(Select::nodes(pinned)).tether(0.02);
            body.springs = taffeta::scene::Springs::default();
            let mut scene = Scene::new("board").body(body.structural(1e-9, 0.0)).time(0.1, 0.1);
            scene.world.gravity = gravity;
            let mut simulation = build(&scene);
            let start = positions(&simulation);
            run(&mut simulation, 1);
            for (node, &x) in
                positions(&simulation).iter().enumerate().filter(|(node, _)| !pins.contains(node))
            {
                let balls: Vec<(V, f64)> =
                    pins.iter().map(|&pin| (start[pin], 1.02 * way(node, pin))).collect();
                let free = add(start[node], scale(gravity, 0.01));
                let (nearest, far) = (nearest_within(free, &balls), norm(sub(x, free)));
                let off = norm(sub(x, nearest));
                // More than two move it one after the other: to a place that they allow, not quite to the nearest.
                let most = if pins.len() > 2 { 0.5 * norm(sub(nearest, free)) } else { 1e-9 };
                assert!(
                    off <= most,
                    "node {node} of {pins:?} under {gravity:?}, moved by {far} m, is {off} m from it"
                );
                let out = |&(center, radius): &(V, f64)| norm(sub(x, center)) - radius;
                let farthest = balls.iter().map(out).fold(0.0, f64::max);
                assert!(
                    farthest < if pins.len() > 2 { 0.01 } else { 1e-13 },
                    "node {node} of {pins:?}: {farthest} m out"
                );
                let on = |(center, radius): &&(V, f64)| (norm(sub(x, *center)) - radius).abs() < 1e-12;
                of_both += usize::from(balls.iter().filter(on).count() > 1);
            }
        }
    }
    assert!(of_both > 10, "{of_both} nodes lie where spheres meet");
}

#[test]
fn tethers_out_of_which_nothing_hangs_change_no_bit() {
    let ran = |slack: Option<f64>, precision| {
        let body = curtain(Select::rows(0, 0), 300.0);
        let mut body = slack.into_iter().fold(body, Body::tether);
        body.tethers = slack.map(|slack| taffeta::scene::Tethers { slack });
        let scene = Scene::new("stiff").body(body).time(0.005, 0.0005);
        let scene = scene.collider(taffeta::scene::Collider::sphere([0.0, -0.3, 0.05], 0.1));
        let mut simulation = build_as(&scene, precision, 1);
        run(&mut simulation, 100);
        (simulation.state_hash(), simulation.report().clone())
    };
    for precision in [Precision::F32, Precision::F64] {
        assert_eq!(ran(None, precision), ran(Some(1.0), precision));
        assert_ne!(ran(None, precision), ran(Some(0.0), precision));
    }
}

fn hung(mesh: Mesh) -> Simulation {
    let scene = Scene::new("mesh").body(panel_of(mesh)).time(0.008, 0.001);
    let mut scene = scene;
    scene.world.drag = 0.005;
    let mut simulation = build(&scene);
    run(&mut simulation, 800);
    simulation
}

fn panel_of(mesh: Mesh) -> Body {
    let body = Body { mesh, ..panel("cloth", 5, [0.0; 3]) };
    let body = Body { springs: taffeta::scene::Springs::default(), ..body };
    body.structural(1.0, 0.01).pin(Select::nodes([0])).tether(0.0)
}

#[test]
fn a_chain_hangs_as_long_as_it_is_made() {
    let x = positions(&hung(Mesh::chain(10, 0.7)));
    for (node, x) in x.iter().enumerate() {
        let distance = norm(sub(*x, [-0.35, 0.0, 0.0]));
        assert!(distance < 0.07 * node as f64 * (1.0 + 1e-12) + 1e-15, "{node}: {distance}");
    }
    assert!(x[10][1] < -0.69);
}

#[test]
fn ways_along_a_closed_mesh_lead_around_it() {
    // The far pole of a ball of radius r is π r away along the surface, 2 r through it.
    let radius = 0.2;
    let ball = Mesh::Icosphere(taffeta::scene::Icosphere { radius, subdivisions: 3 });
    let top = positions(&build(&weightless("start", 0.01, 0.01).body(panel_of(ball.clone()))))[0];
    let simulation = hung(ball);
    let x = positions(&simulation);
    let most = x.iter().map(|&x| norm(sub(x, top))).fold(0.0, f64::max);
    let around = std::f64::consts::PI * radius;
    assert!((0.95 * around..1.06 * around).contains(&most), "{most} {around}");
}

#[test]
fn a_tether_follows_its_pin() {
    let body = curtain(Select::rows(0, 0), 1.0).tether(0.0);
    let keys = vec![taffeta::scene::Keyframe::translate(0.5, [0.0, 1.0, 0.0])];
    let mut body = body;
    body.pins[0].motion = keys;
    let mut simulation = build(&Scene::new("lift").body(body).time(0.016, 0.002));
    let top: Vec<usize> = (0..SIDE).collect();
    for _ in 0..60 {
        run(&mut simulation, 1);
        near("reach", farthest(&positions(&simulation), &top).max(1.0), 1.0, 1e-9);
    }
}

/// Runs frames of one sub-step of `dt` [s]. Fails where nodes of `mass` [kg] have more kinetic energy than the way that they
/// have gone tells: only what moves them is a speed. Returns the most that they had [J].
#[track_caller]
fn as_fast_as_it_moves(simulation: &mut Simulation, frames: u32, mass: f64, dt: f64) -> f64 {
    let (mut most, mut before): (f64, _) = (0.0, positions(simulation));
    for frame in 0..frames {
        run(simulation, 1);
        let (after, kinetic) = (positions(simulation), simulation.report().kinetic);
        let way: f64 = before.iter().zip(&after).map(|(&a, &b)| dot(sub(b, a), sub(b, a))).sum();
        let of_way = 0.5 * mass * way / (dt * dt);
        assert!(kinetic < (1.0 + 1e-9) * of_way + 1e-15, "{frame}: {kinetic} {of_way}");
        (most, before) = (most.max(kinetic), after);
    }
    most
}

/// Ways of solving, and their steps [s].
const WAYS: [(Method, f64); 3] =
    [(Method::Springs, 0.001), (Method::Springs, 0.00025), (Method::Ice, 1.0 / 60.0)];

fn drawn(body: Body, (method, step): (Method, f64)) -> Simulation {
    let mut scene = Scene::new("drawn").body(body).time(step, step).method(method);
    scene.solver.ice.form = ConstraintForm::Primal;
    scene.world.drag = 0.0005;
    build(&scene)
}

#[test]
fn cloth_that_hangs_still_in_four_tethers_has_no_speed() {
    for way in WAYS {
        let last = (SIDE * SIDE) as u32 - 1;
        let corners = Select::nodes([0, SIDE as u32 - 1, last + 1 - SIDE as u32, last]);
        let body = panel("sheet", SIDE as u32, [0.0; 3]).pin(corners).tether(0.0);
        let mut simulation = drawn(body, way);
        as_fast_as_it_moves(&mut simulation, (6.0 / way.1) as u32, 0.001, way.1);
        let most = as_fast_as_it_moves(&mut simulation, 60, 0.001, way.1);
        // Explicit springs leave them trembling with less than gravity gives in a sub-step.
        let fallen = 0.5 * 0.001 * f64::from(last) * (9.81 * way.1).powi(2);
        assert!(most < if way.0 == Method::Springs { fallen } else { 1e-18 }, "{way:?}: {most} {fallen}");
    }
}

#[test]
fn what_two_pins_have_drawn_apart_stores_no_speed() {
    for way in WAYS {
        for apart in [0.005, 0.05] {
            let [tethered, free] = [true, false].map(|tethered| {
                let mut body = curtain(Select::nodes([0]), 100.0);
                let keys = |at: f64| taffeta::scene::Keyframe::translate(at, [apart * 0.5, 0.0, 0.0]);
                let home = taffeta::scene::Keyframe::translate(2.2, [0.0; 3]);
                body = body.pin_moving(Select::nodes([SIDE as u32 - 1]), vec![keys(0.5), keys(2.0), home]);
                let mut simulation = drawn(if tethered { body.tether(0.0) } else { body }, way);
                let frames = |time: f64| (time / way.1).round() as u32;
                run(&mut simulation, frames(0.5) + 2);
                as_fast_as_it_moves(&mut simulation, frames(1.0), 0.001, way.1);
                let held = as_fast_as_it_moves(&mut simulation, frames(0.5) - 2, 0.001, way.1);
                run(&mut simulation, frames(0.2) + 1);
                let back = as_fast_as_it_moves(&mut simulation, frames(1.0), 0.001, way.1);
                [held, back]
            });
            let less = (0..2).all(|when| tethered[when] < free[when]);
            assert!(less, "{apart} m, {way:?}: held apart and let go {tethered:?}, without tethers {free:?}");
        }
    }
}
