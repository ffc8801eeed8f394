//! Springs as constraints on positions.

use crate::common::{V, build, build_as, near, norm, positions, run, scale, sub, turned, weightless};
use std::collections::HashMap;
use std::sync::Arc;
use taffeta::scene::{
    Body, Bounds, Collider, Icosphere, Keyframe, Mass, Mesh, Method, Pattern, Scene, Seam, SeamSide, Select,
    Sheet, Sleep, Surface, Volume,
};
use taffeta::{Options, Precision, Simulation};

const G: f64 = 9.81;

/// A square metre of n × n nodes that starts at 45° and swings from two corners, with so many sub-steps of a sixtieth of a second.
fn sheet(n: u32, substeps: u32, method: Method) -> Scene {
    let body = Body::cloth("sheet", Mesh::grid(n, n, [1.0, 1.0])).with_mass(Mass::Whole(0.2));
    let mut body = body.structural(2500.0, 0.01).shear(600.0, 0.01).bend(1.0, 0.001);
    body.place = turned([1.0, 0.0, 0.0], 45.0, [0.0; 3]);
    let frame = 1.0 / 60.0;
    Scene::new("sheet")
        .time(frame, frame / f64::from(substeps))
        .method(method)
        .body(body.pin(Select::nodes([0, n - 1])))
}

/// By how much the longest edge along rows and columns is too long, and the mean height [m].
fn stretch_and_height(simulation: &Simulation, n: usize) -> (f64, f64) {
    let places = positions(simulation);
    let rest = 1.0 / (n - 1) as f64;
    let edge = |a: usize, b: usize| norm(sub(places[a], places[b])) / rest - 1.0;
    let mut most = 0.0_f64;
    for at in 0..n * n {
        most = if at % n + 1 < n { most.max(edge(at, at + 1)) } else { most };
        most = if at + n < n * n { most.max(edge(at, at + n)) } else { most };
    }
    (most, places.iter().map(|place| place[1]).sum::<f64>() / (n * n) as f64)
}

#[test]
fn few_substeps_keep_a_sheet_near_its_length_and_more_bring_it_to_how_stiff_springs_move() {
    let (n, frames) = (30, 60);
    let mut reference = build_as(&sheet(n, 220, Method::Springs), Precision::F32, 1);
    let heights: Vec<f64> = (0..frames)
        .map(|_| {
            run(&mut reference, 1);
            stretch_and_height(&reference, n as usize).1
        })
        .collect();
    // At most so long in motion, and so far from the reference's mean height [m].
    for (substeps, longest, off) in [(2, 0.09, 0.03), (4, 0.045, 0.015), (12, 0.02, 0.01)] {
        let mut simulation = build_as(&sheet(n, substeps, Method::Xpbd), Precision::F32, 1);
        let (mut most, mut farthest) = (0.0_f64, 0.0_f64);
        for height in &heights {
            run(&mut simulation, 1);
            let (stretch, own) = stretch_and_height(&simulation, n as usize);
            (most, farthest) = (most.max(stretch), farthest.max((own - height).abs()));
        }
        assert!(most < longest, "{substeps} sub-steps: {most}");
        assert!(farthest < off, "{substeps} sub-steps: {farthest} m");
    }
}

#[test]
fn meshes_hang_on_levels_as_grids_do() {
    // The same sheet of triangles that are nearly equilateral, on its two upper corners.
    let hung = |levels| {
        let sheet = Mesh::Sheet(Sheet { size: [1.0, 1.0], edge: 1.0 / 30.0, pattern: Pattern::default() });
        let mut body = Body::cloth("sheet", sheet).with_mass(Mass::Whole(0.2));
        body = body.structural(10_000.0, 0.0).bend(1.0, 0.0);
        body.place = turned([1.0, 0.0, 0.0], 45.0, [0.0; 3]);
        let corner = |x| Select {
            inside: Some(Bounds { min: [x - 0.02, 0.34, -0.37], max: [x + 0.02, 0.37, -0.34] }),
            ..Select::default()
        };
        let body = body.pin(corner(-0.5)).pin(corner(0.5));
        let mut scene = Scene::new("sheet").time(1.0 / 60.0, 1.0 / 480.0).method(Method::Xpbd).body(body);
        scene.solver.xpbd.levels = levels;
        let mut simulation = build_as(&scene, Precision::F32, 1);
        let mut most = 0.0_f64;
        for _ in 0..60 {
            run(&mut simulation, 1);
            most = most.max(simulation.report().max_stretch);
        }
        most
    };
    let (with, without) = (hung(None), hung(Some(0)));
    assert!(with < 1.09, "{with}");
    assert!(without > 1.3, "{without}");
}

/// Two square metres of n × n nodes, 2 cm apart but at their common border.
fn pillow(n: u32) -> Surface {
    let border = |i: u32, j: u32| i == 0 || j == 0 || i == n - 1 || j == n - 1;
    let (mut number, mut nodes, mut triangles) = (HashMap::new(), Vec::new(), Vec::new());
    for side in [1.0, -1.0] {
        let mut node = |i: u32, j: u32| {
            let up = if border(i, j) { 0.0 } else { side };
            *number.entry((i, j, up as i32)).or_insert_with(|| {
                nodes.push([f64::from(i) / f64::from(n - 1), 0.01 * up, f64::from(j) / f64::from(n - 1)]);
                nodes.len() as u32 - 1
            })
        };
        for (i, j) in (0..n - 1).flat_map(|i| (0..n - 1).map(move |j| (i, j))) {
            let [a, b, c, d] = [(i, j), (i, j + 1), (i + 1, j + 1), (i + 1, j)].map(|(i, j)| node(i, j));
            // No triangle is in both layers.
            let is_corner = [0, n - 2].contains(&i) && [0, n - 2].contains(&j);
            let cut = if is_corner { i == j } else { (i + j) % 2 == 1 };
            let two = if cut { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
            triangles.extend(two.map(|[a, b, c]| if side > 0.0 { [a, b, c] } else { [c, b, a] }));
        }
    }
    Surface::of_triangles(nodes, triangles)
}

#[test]
fn limits_let_a_flat_pillow_fill() {
    let full = |method: Method, substeps: f64| {
        let mut scene = weightless("pillow", 1.0 / 60.0, 1.0 / 60.0 / substeps).method(method);
        let mut body = Body::soft("pillow", Mesh::Surface(Arc::new(pillow(25)))).with_mass(Mass::Whole(0.5));
        body.volume = Some(Volume { pressure: Some(200.0), ..Volume::default() });
        scene.world.drag = 0.004;
        let mut simulation = build_as(&scene.body(body.structural(1000.0, 0.02)), Precision::F32, 1);
        run(&mut simulation, 200);
        simulation.report().volumes[0].expect("it is closed")
    };
    let (springs, positions) = (full(Method::Springs, 70.0), full(Method::Xpbd, 16.0));
    assert!(positions > 0.87 * springs, "{positions} m³, and {springs} m³ by explicit springs");
}

#[test]
fn damping_gives_no_energy() {
    // The last is some two hundred times m/h: all of it at once would resist limits until the sheet blows up.
    for d in [0.01, 1.0, 10.0] {
        let mut scene = sheet(20, 4, Method::Xpbd);
        scene.bodies[0] = scene.bodies[0].clone().shear(100.0, d).bend(1.0, d);
        let mut simulation = build_as(&scene, Precision::F32, 1);
        let start = simulation.report().gravitational;
        for _ in 0..240 {
            run(&mut simulation, 1);
            let now = simulation.report().kinetic + simulation.report().gravitational;
            assert!(now < start + 0.01, "d = {d}: {now} J after {start} J");
        }
    }
}

#[test]
fn springs_alone_bear_a_load_at_their_own_stretch() {
    // Five masses on soft springs; without levels they are what stretches.
    let (links, m, k) = (5, 0.02, 40.0);
    let chain = Body::cloth("chain", Mesh::chain(links, 0.5)).with_mass(Mass::Node(m)).structural(k, 0.05);
    let mut scene =
        Scene::new("chain").time(0.02, 0.0005).method(Method::Xpbd).body(chain.pin(Select::nodes([0])));
    scene.solver.xpbd.levels = Some(0);
    scene.world.drag = 0.02;
    let mut simulation = build(&scene);
    run(&mut simulation, 500);
    let places = positions(&simulation);
    for link in 0..links as usize {
        let hanging = f64::from(links) - link as f64;
        let length = norm(sub(places[link + 1], places[link]));
        // Within a spring's length its pull is k(l − L) to the square of the stretch.
        let stretch = length / 0.1 - 1.0;
        let pull = k * (length - 0.1) * (1.0 + stretch / 2.0);
        near("pull", pull / (hanging * m * G), 1.0, 0.02 + stretch * stretch);
    }
}

#[test]
fn levels_let_soft_cloth_be_as_long_as_they_are_asked_to() {
    let longest = |limit: f64| {
        let mut scene = sheet(17, 8, Method::Xpbd);
        let body = Body::cloth("sheet", Mesh::grid(17, 17, [1.0, 1.0])).with_mass(Mass::Whole(0.2));
        scene.bodies[0] = body.structural(3.0, 0.001).shear(1.0, 0.001).pin(Select::rows(0, 0));
        scene.solver.xpbd.stretch_limit = limit;
        scene.world.drag = 0.002;
        let mut simulation = build(&scene);
        run(&mut simulation, 180);
        let places = positions(&simulation);
        norm(sub(places[8], places[8 + 16 * 17]))
    };
    // Springs alone would let it be 1.3 times as long and more.
    let (tight, loose) = (longest(0.0), longest(0.2));
    assert!(tight > 0.99 && tight < 1.04, "{tight}");
    assert!(loose > tight + 0.08 && loose < 1.24, "{loose} after {tight}");
}

/// Bodies that spin and fly, stretched at first.
fn thrown(body: Body, levels: Option<u32>, step: f64) -> Simulation {
    let mut scene = weightless("thrown", 0.01, step).method(Method::Xpbd).body(body.at([0.5, 1.0, -2.0]));
    scene.solver.xpbd.levels = levels;
    let mut simulation = build_as(&scene, Precision::F64, 2);
    simulation.disturb(0.01, 3);
    let body = simulation.bodies()[0].handle;
    for (vertex, force) in [(0, [3.0, 1.0, -2.0]), (9, [0.0, -4.0, 1.0])] {
        simulation.apply_force(body, vertex, force).unwrap();
    }
    run(&mut simulation, 1);
    simulation
}

fn bodies() -> [Body; 3] {
    let sheet = Body::cloth("sheet", Mesh::grid(22, 15, [1.0, 0.8])).with_mass(Mass::Area(2.0));
    let ball = Mesh::Icosphere(Icosphere { radius: 0.4, subdivisions: 3 });
    let ball = Body::cloth("ball", ball).with_mass(Mass::Node(0.02));
    let chain = Body::cloth("chain", Mesh::chain(60, 2.0)).with_mass(Mass::Node(0.05));
    [sheet.shear(120.0, 0.1), ball, chain].map(|body| body.structural(200.0, 0.2).bend(80.0, 0.1))
}

#[test]
fn nothing_gives_momentum_to_what_flies_free() {
    for body in bodies() {
        let mut simulation = thrown(body, None, 0.002);
        let start = simulation.report().clone();
        run(&mut simulation, 100);
        let now = simulation.report();
        let drift = norm(sub(now.momentum, start.momentum)) / norm(start.momentum);
        assert!(drift < 1e-9, "{}: {drift}", simulation.bodies()[0].name);
    }
}

#[test]
fn springs_alone_keep_angular_momentum_to_first_order_in_the_step() {
    let drift = |substeps: f64| {
        let [sheet, ..] = bodies();
        let mut simulation = thrown(sheet, Some(0), 0.01 / substeps);
        let start = simulation.report().clone();
        run(&mut simulation, 10);
        let now = simulation.report();
        norm(sub(now.angular_momentum, start.angular_momentum)) / norm(start.angular_momentum)
    };
    let [coarse, fine] = [8.0, 64.0].map(drift);
    assert!(coarse < 0.01 && fine < 0.3 * coarse, "{fine} after {coarse}");
}

#[test]
fn energy_is_only_lost() {
    let mut simulation = build(&sheet(20, 4, Method::Xpbd));
    let all = |simulation: &Simulation| {
        let report = simulation.report();
        // Springs may hold what limits have not taken yet; what moves and falls may not gain.
        report.kinetic + report.gravitational
    };
    let start = all(&simulation);
    let mut least = start;
    for _ in 0..240 {
        run(&mut simulation, 1);
        let now = all(&simulation);
        assert!(now < least + 0.02 * (start - least).max(0.05), "{now} J after {least} J");
        least = least.min(now);
    }
}

#[test]
fn cloth_lies_on_what_carries_it() {
    let body = Body::cloth("cloth", Mesh::grid(30, 30, [1.0, 1.0])).with_mass(Mass::Area(0.2));
    let body = body.structural(1000.0, 0.01).shear(200.0, 0.01).bend(1.0, 0.0).at([0.0, 0.6, 0.0]);
    let ball = Collider::sphere([0.0; 3], 0.3).friction(0.5);
    let scene =
        Scene::new("drape").time(1.0 / 60.0, 1.0 / 960.0).method(Method::Xpbd).body(body).collider(ball);
    let mut simulation = build_as(&scene, Precision::F32, 1);
    run(&mut simulation, 150);
    let inside = positions(&simulation).into_iter().map(|place: V| 0.3 - norm(place)).fold(0.0, f64::max);
    assert!(inside < 1e-6, "{inside} m inside the ball");
    let (stretch, height) = stretch_and_height(&simulation, 30);
    assert!(stretch < 0.09, "{stretch}");
    // It hangs over the ball and has not slid off.
    assert!(height > -0.1 && height < 0.25, "{height} m");
}

#[test]
fn pins_that_come_and_go_are_seen_by_all_levels() {
    let mut simulation = build(&sheet(25, 4, Method::Xpbd));
    let body = simulation.body("sheet").unwrap();
    run(&mut simulation, 30);
    // Held in its middle from now on, it hangs from there, too.
    let middle = 12 * 25 + 13;
    let at = positions(&simulation)[middle];
    simulation.pin_vertex(body, middle, at).unwrap();
    simulation.unpin_vertex(body, 0).unwrap();
    run(&mut simulation, 60);
    let places = positions(&simulation);
    assert!(norm(sub(places[middle], at)) < 1e-9);
    let (stretch, _) = stretch_and_height(&simulation, 25);
    // One node in the middle bears half of it.
    assert!(stretch < 0.12, "{stretch}");
}

#[test]
fn a_restored_run_goes_on_with_the_same_bits() {
    let scene = sheet(25, 3, Method::Xpbd);
    let mut first = build_as(&scene, Precision::F32, 2);
    run(&mut first, 20);
    let snapshot = first.snapshot();
    run(&mut first, 10);
    let mut second = build_as(&scene, Precision::F32, 1);
    second.restore(&snapshot).unwrap();
    run(&mut second, 10);
    assert_eq!(first.state_hash(), second.state_hash());
}

#[test]
fn no_step_is_too_long_and_what_is_impossible_is_refused() {
    let mut coarse = sheet(12, 1, Method::Xpbd);
    coarse.time.dt = 0.1;
    coarse.time.max_step = None;
    let mut simulation = build(&coarse);
    assert!(simulation.warnings().is_empty());
    run(&mut simulation, 50);
    let places = positions(&simulation);
    assert!(places.iter().all(|&place| norm(scale(place, 1.0)) < 3.0));
    for (change, words) in [
        (
            Box::new(|scene: &mut Scene| scene.solver.xpbd.sweeps = 0) as Box<dyn Fn(&mut Scene)>,
            "1 to 1000 would do",
        ),
        (Box::new(|scene: &mut Scene| scene.solver.xpbd.stretch_limit = -0.1), "0 or more would do"),
        (Box::new(|scene: &mut Scene| scene.solver.xpbd.stretch_limit = f64::NAN), "stretch_limit"),
    ] {
        let mut scene = sheet(12, 1, Method::Xpbd);
        change(&mut scene);
        let error = Simulation::new(&scene, &Options::default()).err().expect("refused").to_string();
        assert!(error.contains("solver.xpbd") && error.contains(words), "{error}");
    }
}

#[test]
fn pins_that_move_take_cloth_along() {
    // Its two corners go 1 m aside within a second, and stay.
    let mut scene = sheet(25, 4, Method::Xpbd);
    let body = scene.bodies.remove(0);
    let aside = vec![Keyframe::translate(0.0, [0.0; 3]), Keyframe::translate(1.0, [1.0, 0.0, 0.0])];
    let mut body = Body { pins: Vec::new(), ..body }.pin_moving(Select::nodes([0, 24]), aside);
    body.name = "sheet".to_owned();
    scene.world.drag = 1e-3;
    let mut simulation = build(&scene.body(body));
    let start = positions(&simulation);
    let mut most = 0.0_f64;
    for _ in 0..60 {
        run(&mut simulation, 1);
        most = most.max(stretch_and_height(&simulation, 25).0);
    }
    run(&mut simulation, 240);
    let places = positions(&simulation);
    for corner in [0, 24] {
        assert!(
            norm(sub(places[corner], [start[corner][0] + 1.0, start[corner][1], start[corner][2]])) < 1e-9
        );
    }
    let mean = |places: &[V]| places.iter().map(|place| place[0]).sum::<f64>() / places.len() as f64;
    assert!((mean(&places) - mean(&start) - 1.0).abs() < 0.02, "{}", mean(&places));
    // The corners set out at once with 1 m/s, and the sheet swings down meanwhile.
    assert!(most < 0.15, "{most}");
    let (rest, _) = stretch_and_height(&simulation, 25);
    assert!(rest < 0.02, "{rest}");
}

#[test]
fn seams_hold_sheets_together_and_keep_their_momentum() {
    let half = |name: &str, at: V| {
        let body = Body::cloth(name, Mesh::grid(12, 12, [0.5, 0.5])).with_mass(Mass::Whole(0.05));
        let body = body.structural(2000.0, 0.01).shear(400.0, 0.01).bend(1.0, 0.001).at(at);
        Body { velocity: [0.0, 0.0, if at[0] > 0.0 { 1.0 } else { -0.5 }], ..body }
    };
    let side =
        |body: &str, column| SeamSide { body: body.into(), select: Some(Select::cols(column, column)) };
    let mut scene = weightless("sewn", 1.0 / 60.0, 1.0 / 480.0).method(Method::Xpbd);
    scene = scene.body(half("left", [-0.25, 0.0, 0.0])).body(half("right", [0.25, 0.0, 0.0]));
    let mut simulation = build(&scene.seam(Seam::new(side("left", 11), side("right", 0))));
    let before = simulation.report().momentum;
    run(&mut simulation, 60);
    let places = positions(&simulation);
    let open =
        (0..12).map(|row| norm(sub(places[12 * row + 11], places[144 + 12 * row]))).fold(0.0, f64::max);
    assert!(open < 1e-9, "the seam is open by {open} m");
    let after = simulation.report().momentum;
    assert!(norm(sub(after, before)) < 1e-9 * norm(before), "{before:?} {after:?}");
    // One half pulls the other along: both drift at the mean speed.
    let mean = |nodes: std::ops::Range<usize>| nodes.map(|node| places[node][2]).sum::<f64>() / 144.0;
    assert!((mean(0..144) - mean(144..288)).abs() < 0.5, "{} {}", mean(0..144), mean(144..288));
}

#[test]
fn cloth_at_rest_falls_asleep_and_wakes_when_it_is_pushed() {
    let body = Body::cloth("cloth", Mesh::grid(12, 12, [0.4, 0.4])).with_mass(Mass::Area(0.2));
    let body = body.structural(1000.0, 0.01).shear(200.0, 0.01).bend(1.0, 0.001).at([0.0, 0.05, 0.0]);
    let mut scene = Scene::new("floor").time(1.0 / 60.0, 1.0 / 240.0).method(Method::Xpbd).body(body);
    scene.world.drag = 1e-3;
    scene.sleep = Some(Sleep { speed: 5e-3, after: 0.2 });
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction(0.6);
    let mut simulation = build(&scene.collider(floor));
    let cloth = simulation.body("cloth").unwrap();
    while !simulation.is_asleep(cloth).unwrap() {
        assert!(simulation.step().unwrap().time < 10.0, "it does not fall asleep");
    }
    let (still, hash) = (positions(&simulation), simulation.state_hash());
    run(&mut simulation, 10);
    assert_eq!(simulation.state_hash(), hash);
    simulation.apply_force(cloth, 143, [0.0, 0.5, 0.0]).unwrap();
    run(&mut simulation, 1);
    assert!(!simulation.is_asleep(cloth).unwrap());
    assert!(positions(&simulation)[143][1] > still[143][1]);
}

#[test]
fn a_soft_body_keeps_its_volume_on_a_floor() {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 3 });
    let mut body = Body::soft("ball", ball).with_mass(Mass::Whole(0.5)).structural(500.0, 0.0);
    body.volume = Some(Volume::default());
    let scene = Scene::new("ball").time(1.0 / 60.0, 1.0 / 480.0).method(Method::Xpbd);
    let scene = scene.body(body.at([0.0, 0.3, 0.0])).collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]));
    let mut simulation = build(&scene);
    let whole = simulation.report().volumes[0].unwrap();
    for _ in 0..120 {
        run(&mut simulation, 1);
        let share = simulation.report().volumes[0].unwrap() / whole;
        assert!((share - 1.0).abs() < 0.03, "{share} of its volume");
    }
    let lowest = positions(&simulation).iter().map(|place| place[1]).fold(1.0, f64::min);
    // Where surfaces are kept apart, and nowhere else.
    assert!((0.01 - 1e-9..0.011).contains(&lowest), "{lowest} m");
}
