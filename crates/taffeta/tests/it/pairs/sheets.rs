//! Sheets: they do not pass through each other or themselves.

use super::crossing::crossings;
use super::velocities;
use crate::common::{build, build_as, norm, positions, run, sub, surface, turned, warnings, weightless};
use taffeta::scene::{Body, Collider, Keyframe, Mass, Mesh, Scene};
use taffeta::{Precision, Simulation};

/// A square sheet of 50 g/m² at 20 mm, `nodes` along a side.
pub fn sheet(name: &str, nodes: u32, spacing: f64, thickness: f64) -> Body {
    let side = f64::from(nodes - 1) * spacing;
    Body::cloth(name, Mesh::grid(nodes, nodes, [side, side]))
        .with_mass(Mass::Node(0.0005))
        .structural(20.0, 0.01)
        .shear(10.0, 0.005)
        .bend(1.0, 0.001)
        .collide_nodes(thickness)
}

/// Two sheets dropped on a ball.
struct Crosswise {
    /// Crossings of the two, summed over frames of the fall, and at rest.
    falling: usize,
    resting: usize,
    /// The largest stretch on the way.
    stretch: f64,
    /// At rest [J].
    kinetic: f64,
    pairs: u64,
}

fn crosswise(thickness: f64) -> Crosswise {
    const NODES: u32 = 21;
    const SPACING: f64 = 0.02;
    let mut high = sheet("high", NODES, SPACING, thickness * SPACING);
    high.place = turned([0.0, 1.0, 0.0], 45.0, [0.01, 0.14, 0.0]);
    let mut scene = Scene::new("crosswise")
        .time(0.02, 0.0005)
        .body(sheet("low", NODES, SPACING, thickness * SPACING).at([0.0, 0.11, 0.0]))
        .body(high)
        .collider(Collider::sphere([0.0; 3], 0.1).friction(0.5).offset(0.005))
        .collider(Collider::plane([0.0, -0.3, 0.0], [0.0, 1.0, 0.0]));
    scene.world.drag = 0.001;
    let mut simulation = build(&scene);
    let triangles = [0, 1].map(|body| surface(&simulation, body).triangles);
    let count = |simulation: &Simulation| {
        let x = positions(simulation);
        let (low, high) = x.split_at((NODES * NODES) as usize);
        crossings([low, high], [&triangles[0], &triangles[1]])
    };
    let (mut falling, mut stretch) = (0, 0.0_f64);
    for _ in 0..25 {
        run(&mut simulation, 1);
        falling += count(&simulation);
        stretch = stretch.max(simulation.report().max_stretch);
    }
    run(&mut simulation, 75);
    let report = simulation.report();
    Crosswise { falling, resting: count(&simulation), stretch, kinetic: report.kinetic, pairs: report.pairs }
}

#[test]
fn sheets_dropped_crosswise_on_a_ball_do_not_pass_through_each_other() {
    let Crosswise { falling, resting, stretch, kinetic, pairs } = crosswise(1.0);
    assert!(stretch > 1.2 && 0.71 * stretch < 1.0, "the rule for the thickness is met: {stretch}");
    assert_eq!((falling, resting), (0, 0));
    assert!(pairs > 100 && kinetic < 1e-3, "{pairs} {kinetic}");
}

#[test]
fn sheets_that_are_too_thin_pass_through_each_other() {
    let thin = crosswise(0.3);
    assert!(thin.falling > 1000 && thin.resting > 100, "{} {}", thin.falling, thin.resting);
}

#[test]
fn a_sheet_between_closing_walls_keeps_its_folds_apart() {
    const NODES: usize = 40;
    const THICKNESS: f64 = 0.006;
    let wall = |side: f64| {
        Collider::plane([0.16 * side, 0.0, 0.0], [-side, 0.0, 0.0])
            .offset(0.0)
            .friction(0.0)
            .keyframe(Keyframe::translate(2.0, [-0.11 * side, 0.0, 0.0]))
    };
    // Weightless: on a floor it could only fold upwards.
    let mut scene = weightless("walls", 0.02, 0.0005).body(sheet("cloth", NODES as u32, 0.008, THICKNESS));
    scene.world.drag = 0.002;
    let scene = scene.collider(wall(-1.0)).collider(wall(1.0));
    let mut simulation = build(&scene);
    simulation.disturb(1e-4, 3);
    run(&mut simulation, 130);
    let x = positions(&simulation);
    let neighbours = |a: usize, b: usize| {
        let (down, across) = ((a / NODES).abs_diff(b / NODES), (a % NODES).abs_diff(b % NODES));
        (down <= 1 && across <= 1) || down + across == 2 && down * across == 0
    };
    let mut least = f64::MAX;
    for a in 0..x.len() {
        for b in (a + 1..x.len()).filter(|&b| !neighbours(a, b)) {
            least = least.min(norm(sub(x[a], x[b])));
        }
    }
    let report = simulation.report();
    assert!(report.pairs > 0);
    assert!(least > 0.9 * THICKNESS, "{}", least / THICKNESS);
}

#[test]
fn no_node_ends_inside_of_a_collider() {
    for precision in [Precision::F64, Precision::F32] {
        let mut scene = Scene::new("heap").time(0.01, 0.001);
        for layer in 0..4 {
            let mut body = sheet(&layer.to_string(), 15, 0.02, 0.02);
            body.place =
                turned([0.0, 1.0, 0.0], 20.0 * f64::from(layer), [0.0, 0.11 + 0.025 * f64::from(layer), 0.0]);
            scene = scene.body(body);
        }
        let scene = scene
            .collider(Collider::sphere([0.0; 3], 0.1).offset(0.0))
            .collider(Collider::plane([0.0, -0.05, 0.0], [0.0, 1.0, 0.0]).offset(0.0));
        let mut simulation = build_as(&scene, precision, 1);
        let mut pairs = 0;
        for frame in 0..80 {
            run(&mut simulation, 1);
            pairs += simulation.report().pairs;
            for x in positions(&simulation) {
                assert!(norm(x) > 0.1 - 1e-7 && x[1] > -0.05 - 1e-7, "{precision}, frame {frame}: {x:?}");
            }
        }
        assert!(pairs > 10_000, "{pairs}");
    }
}

#[test]
fn sheets_that_start_in_contact_part_gently_and_say_so() {
    const THICKNESS: f64 = 0.016;
    for gap in [0.0, 0.2 * THICKNESS, 0.9 * THICKNESS] {
        let scene = weightless("twins", 0.002, 0.001)
            .body(sheet("low", 12, 0.02, THICKNESS))
            .body(sheet("high", 12, 0.02, THICKNESS).at([0.0, gap, 0.0]));
        for precision in [Precision::F64, Precision::F32] {
            let mut simulation = build_as(&scene, precision, 1);
            let told =
                warnings(&simulation).iter().find(|words| words.contains("144 pairs of nodes")).cloned();
            let told = told.unwrap_or_else(|| panic!("{:?}", simulation.warnings()));
            assert!(told.contains("body `low`") && told.contains("of `high`"), "{told}");
            let mut fastest = 0.0;
            for _ in 0..100 {
                run(&mut simulation, 1);
                fastest = velocities(&simulation).into_iter().map(norm).fold(fastest, f64::max);
            }
            let x = positions(&simulation);
            let (low, high) = x.split_at(144);
            let least = low.iter().zip(high).map(|(&a, &b)| norm(sub(a, b))).fold(f64::MAX, f64::min);
            assert!(least > 0.99 * THICKNESS, "{gap}, {precision}: {least}");
            // Each gets half of 0.016 m in 0.02 s.
            assert!(fastest < 0.41, "{gap}, {precision}: {fastest} m/s");
        }
    }
}
