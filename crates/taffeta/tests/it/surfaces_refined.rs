//! Contact between triangles in steps that are too long for what happens: shorter ones take their place as long as it does.

use crate::common::{build_as, positions, turned};
use crate::surfaces::{fabric, implicit, touching};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Cuboid, Keyframe, Mass, Material, Mesh, Pin, Scene, Select};

/// Two boxes push a cloth on the floor together, and let it go.
fn pinched() -> Scene {
    let pushing = |side: f64| {
        let key = |t: f64, way: f64| Keyframe::translate(t, [-side * way, 0.0, 0.0]);
        let collider = Collider::cuboid([side * 0.18, 0.052, 0.0], [0.05, 0.05, 0.2]);
        let keys = [key(0.1, 0.0), key(0.6, 0.12), key(0.8, 0.12), key(0.9, 0.0)];
        keys.into_iter().fold(collider.offset(0.003).friction(0.6), Collider::keyframe)
    };
    let scene = Scene::new("pinched")
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction(0.2))
        .collider(pushing(-1.0))
        .collider(pushing(1.0))
        .body(fabric("cloth", [12, 15], [0.0, 0.01, 0.0]).with_material(Material::preset("cotton")));
    implicit(scene, 1.0 / 60.0)
}

#[test]
fn long_steps_become_shorter_while_cloth_is_pinched() {
    let mut simulation = build_as(&pinched(), Precision::F32, 2);
    let mut frames = Vec::new();
    for _ in 0..62 {
        let report = simulation.step().unwrap();
        frames.push((report.substeps, report.max_stretch));
        assert_eq!(simulation.intersections().pairs, 0, "frame {}", simulation.frame());
    }
    // Nobody touches anything else before the boxes come, and they are gone at the end.
    assert!(frames[..9].iter().all(|&(substeps, _)| substeps == 1), "{frames:?}");
    assert!(frames[20..50].iter().any(|&(substeps, _)| substeps == 16), "{frames:?}");
    assert!(frames[61].0 < 16, "{frames:?}");
    let most = frames.iter().fold(0.0, |most: f64, &(_, stretch)| most.max(stretch));
    assert!(most < 1.6, "cotton was stretched to {most} times its length");
}

/// A square of cotton of so many nodes and so long [m].
fn cotton(nodes: u32, size: f64) -> Body {
    let mesh = Mesh::grid(nodes, nodes, [size; 2]);
    touching(Body::cloth("cotton", mesh).with_material(Material::preset("cotton")), 0.3)
}

#[test]
fn a_corner_is_dragged_through_the_folds_of_its_own_cloth() {
    let mut curtain = cotton(24, 0.48).pin(Select::rows(0, 0));
    curtain.place = turned([1.0, 0.0, 0.0], 90.0, [0.0, 0.24, 0.0]);
    let way = [0.21, 0.27, 0.06];
    let motion = vec![Keyframe::translate(1.0, way)];
    curtain.pins.push(Pin { select: Select::nodes([552]), motion, ..Pin::default() });
    let mut scene = implicit(Scene::new("dragged").body(curtain), 1.0 / 240.0);
    scene.world.drag = 2e-4;
    let mut simulation = build_as(&scene, Precision::F32, 2);
    let start = positions(&simulation)[552];
    let mut substeps = 0;
    for frame in 1..=40_u32 {
        substeps += simulation.step().unwrap().substeps;
        assert_eq!(simulation.intersections().pairs, 0, "frame {frame}");
        let part = f64::from(frame) / 60.0;
        let corner = positions(&simulation)[552];
        let lag = (0..3).map(|axis| start[axis] + part * way[axis] - corner[axis]);
        let lag = lag.map(|along| along * along).sum::<f64>().sqrt();
        // Folds are in its way for half a second; edges are 21 mm long.
        let most = if frame > 34 { 1e-4 } else { 0.04 };
        assert!(lag < most, "frame {frame}: the corner is {lag} m behind its pin");
    }
    // Who is stopped by a layer slides along it. While such nodes stayed where they were, frames were refined to 1,304 sub-steps.
    assert!(substeps < 900, "{substeps}");
}

#[test]
fn stiff_cloth_in_long_steps_lies_on_a_corner_without_being_stretched() {
    let sheet = cotton(16, 0.36).at([0.007, 0.02, 0.011]);
    let corner = Collider {
        cuboid: Some(Cuboid { center: [0.0; 3], half: [0.12; 3] }),
        offset: 0.004,
        friction: 0.3,
        place: turned([1.0, 0.0, -0.8], 52.0, [0.0, -0.22, 0.0]),
        ..Collider::default()
    };
    let mut simulation =
        build_as(&implicit(Scene::new("corner").collider(corner).body(sheet), 1.0 / 60.0), Precision::F32, 2);
    let (mut most, mut substeps) = (0.0_f64, 0);
    for frame in 1..=90 {
        let report = simulation.step().unwrap();
        most = most.max(report.max_stretch);
        substeps += report.substeps;
        assert_eq!(simulation.intersections().pairs, 0, "frame {frame}");
    }
    // The system knows of contacts also where h² k is many times the mass: what it leaves to impulses stretches cotton by half.
    assert!(most < 1.2 && substeps < 360, "{most} {substeps}");
}

#[test]
fn pinned_cloth_is_not_driven_through_pinned_cloth() {
    let all = || Select::nodes((0..36).collect::<Vec<u32>>());
    let mut driven = fabric("driven", [6, 6], [0.0; 3]);
    driven.place = turned([1.0, 0.0, 0.3], 50.0, [0.01, 0.06, 0.0]);
    let motion = vec![Keyframe::translate(0.3, [0.0, -0.12, 0.0]), Keyframe::translate(0.6, [0.0; 3])];
    driven.pins.push(Pin { select: all(), motion, ..Pin::default() });
    let scene = Scene::new("").body(fabric("table", [6, 6], [0.0; 3]).pin(all())).body(driven);
    let mut simulation = build_as(&implicit(scene, 1.0 / 240.0), Precision::F32, 2);
    let start = positions(&simulation);
    let mut lowest = f64::INFINITY;
    for frame in 1..=38 {
        simulation.step().unwrap();
        assert_eq!(simulation.intersections().pairs, 0, "frame {frame}");
        lowest = positions(&simulation)[36..].iter().fold(lowest, |lowest, x| lowest.min(x[1]));
    }
    // Its lower edge hangs beside the table's border or lies on it; its pins bring it back.
    assert!(lowest > -0.1, "{lowest}");
    for (x, start) in positions(&simulation).iter().zip(&start) {
        assert!((0..3).all(|axis| (x[axis] - start[axis]).abs() < 1e-6), "{x:?} {start:?}");
    }
}

#[test]
fn cloth_that_a_plough_slides_along_stays_above_the_floor() {
    let all = Select::nodes((0..144).collect::<Vec<u32>>());
    let mut plough = fabric("plough", [12, 12], [0.0; 3]);
    plough.place = turned([0.0, 0.0, 1.0], 40.0, [-0.2, 0.0752, 0.004]);
    plough.pins.push(Pin {
        select: all,
        motion: vec![Keyframe::translate(0.2, [0.3, -0.004, 0.0])],
        ..Pin::default()
    });
    let scene = Scene::new("")
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.002).friction(0.3))
        .body(fabric("cloth", [12, 12], [0.0, 0.0021, 0.0]))
        .body(plough);
    let mut simulation = build_as(&implicit(scene, 1.0 / 240.0), Precision::F32, 2);
    let (mut lowest, mut pushed) = (f64::INFINITY, 0.0_f64);
    for frame in 1..=18 {
        simulation.step().unwrap();
        assert_eq!(simulation.intersections().pairs, 0, "frame {frame}");
        for x in &positions(&simulation)[..144] {
            (lowest, pushed) = (lowest.min(x[1]), pushed.max(x[0] - 0.11));
        }
    }
    // Whether it wrinkles before the plough is a matter of roundings.
    assert!(lowest > 0.002 - 1e-6 && pushed > 0.1, "{lowest} {pushed}");
}

#[test]
fn pinned_parts_that_turn_together_follow_their_pins() {
    // Two layers that nearly touch, of long triangles, turn by 0.2 rad in each sub-step.
    let all = || Select::nodes((0..8).collect::<Vec<u32>>());
    let layer = |name: &str, height: f64| {
        let mut body = touching(Body::cloth(name, Mesh::grid(2, 4, [0.2, 0.01])), 0.3).at([0.1, height, 0.0]);
        body = body.structural(1.0, 0.0).with_mass(Mass::Node(1e-4));
        body.pins.push(Pin {
            select: all(),
            motion: vec![Keyframe::rotate(0.5, [0.0, 0.0, 1.0], 1375.0, [0.0; 3])],
            ..Pin::default()
        });
        body
    };
    let scene = Scene::new("").body(layer("one", 0.0)).body(layer("other", 2e-4));
    let mut simulation = build_as(&implicit(scene, 1.0 / 240.0), Precision::F32, 2);
    let start = positions(&simulation);
    for frame in 1..=20 {
        simulation.step().unwrap();
        let (sin, cos) = (1375.0 / 0.5 * f64::from(frame) / 60.0).to_radians().sin_cos();
        for (x, start) in positions(&simulation).iter().zip(&start) {
            let wanted = [start[0] * cos - start[1] * sin, start[0] * sin + start[1] * cos, start[2]];
            let off = (0..3).map(|axis| (x[axis] - wanted[axis]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-6, "frame {frame}: {x:?} in place of {wanted:?}");
        }
    }
}
