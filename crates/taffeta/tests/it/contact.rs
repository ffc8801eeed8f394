//! Nodes stay out of spheres and floors, whatever these do.

use crate::common::{V, build_as, norm, positions, run, sub};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Keyframe, Mass, Mesh, Scene};

/// A sheet of 24 × 24 nodes over the origin.
fn sheet(height: f64, size: f64) -> Body {
    Body::cloth("sheet", Mesh::grid(24, 24, [size, size]))
        .at([0.013, height, -0.017])
        .with_mass(Mass::Node(0.02))
        .structural(150.0, 0.1)
        .shear(150.0, 0.1)
        .bend(50.0, 0.05)
}

/// A scene with one step a frame, so that every step is looked at.
fn scene(body: Body, colliders: Vec<Collider>) -> Scene {
    let mut scene = Scene::new("contact").time(0.004, 0.004).body(body);
    scene.colliders = colliders;
    scene
}

/// Runs frame by frame; `center` is where a ball of radius 0.5 is at a time. Returns the most contacts seen.
fn keeps_out(scene: &Scene, frames: u32, center: fn(f64) -> V, floor: f64) -> u64 {
    let mut most = 0;
    // Four ulps of coordinates up to 1 m.
    for (precision, slack) in
        [(Precision::F32, 4.0 * f64::from(f32::EPSILON)), (Precision::F64, 4.0 * f64::EPSILON)]
    {
        let mut simulation = build_as(scene, precision, 2);
        for frame in 1..=frames {
            run(&mut simulation, 1);
            let o = center(simulation.report().time);
            for (node, x) in positions(&simulation).into_iter().enumerate() {
                let distance = norm(sub(x, o));
                assert!(distance >= 0.5 - slack, "frame {frame}, node {node}: {:e} m inside", 0.5 - distance);
                assert!(x[1] >= floor, "frame {frame}, node {node}: {:e} m below the floor", floor - x[1]);
            }
            most = most.max(simulation.report().contacts);
        }
    }
    most
}

fn ball() -> Collider {
    Collider::sphere([0.0; 3], 0.5).offset(0.0)
}

fn floor() -> Collider {
    Collider::plane([0.0, -0.5, 0.0], [0.0, 3.0, 0.0]).offset(0.0)
}

const NO_FLOOR: f64 = f64::NEG_INFINITY;

#[test]
fn no_node_enters_a_sphere_at_rest() {
    for friction in [0.0, 0.4] {
        let most =
            keeps_out(&scene(sheet(0.6, 1.5), vec![ball().friction(friction)]), 250, |_| [0.0; 3], NO_FLOOR);
        assert!(most > 100, "{most} contacts");
    }
}

#[test]
fn no_node_enters_a_sphere_that_moves_through_the_cloth() {
    let moving = ball().keyframe(Keyframe::translate(0.5, [0.5, 1.0, -0.25]));
    let center = |t: f64| [0.5, 1.0, -0.25].map(|c| c * (t / 0.5).min(1.0));
    assert!(keeps_out(&scene(sheet(0.7, 1.5), vec![moving]), 200, center, NO_FLOOR) > 100);
}

#[test]
fn no_node_enters_a_sphere_that_turns_about_a_pivot_beside_it() {
    // Half a metre from the pivot's axis, 180° in half a second.
    let moving = ball().keyframe(Keyframe::rotate(0.5, [0.0, 0.0, 1.0], -180.0, [0.5, 0.0, 0.0]));
    let center = |t: f64| {
        let (sin, cos) = (std::f64::consts::PI * (1.0 - (t / 0.5).min(1.0))).sin_cos();
        [0.5 + 0.5 * cos, 0.5 * sin, 0.0]
    };
    assert!(keeps_out(&scene(sheet(0.52, 1.5), vec![moving]), 200, center, NO_FLOOR) > 50);
}

#[test]
fn no_node_falls_below_a_floor() {
    for restitution in [0.0, 0.7] {
        let mut body = sheet(0.3, 1.5);
        body.place = crate::common::turned([1.0, 0.3, 0.2], 70.0, [0.0, 0.5, 0.0]);
        let scene = scene(body, vec![floor().restitution(restitution)]);
        assert!(keeps_out(&scene, 400, |_| [9.0; 3], -0.5) > 24);
    }
}

#[test]
fn cloth_over_a_sphere_on_the_floor_enters_neither() {
    for colliders in [vec![ball(), floor()], vec![floor(), ball()]] {
        let most = keeps_out(&scene(sheet(0.6, 2.6), colliders), 500, |_| [0.0; 3], -0.5);
        assert!(most > 150, "{most} contacts");
    }
}

/// Cloth on the floor at a height, blown against the ball.
fn blown(floor: f64, colliders: Vec<Collider>) {
    let mut scene = scene(sheet(0.0, 1.5), colliders);
    scene.bodies[0].place.position = [1.3, floor + 0.01, 0.0];
    scene.world.wind_force = [-0.2, 0.05, 0.0];
    assert!(keeps_out(&scene, 400, |_| [0.0; 3], floor) > 30);
}

#[test]
fn cloth_blown_into_the_wedge_below_a_sphere_enters_neither() {
    for colliders in [vec![ball(), floor()], vec![floor(), ball()]] {
        blown(-0.5, colliders);
    }
}

#[test]
fn cloth_blown_into_the_wedge_beside_a_sunk_sphere_enters_neither() {
    blown(-0.45, vec![ball(), Collider::plane([0.0, -0.45, 0.0], [0.0, 1.0, 0.0]).offset(0.0)]);
}

#[test]
fn the_offset_is_kept_between_surface_and_nodes() {
    let scene =
        scene(sheet(0.6, 1.5), vec![Collider::sphere([0.0; 3], 0.45).offset(0.05), floor().offset(0.1)]);
    assert!(keeps_out(&scene, 250, |_| [0.0; 3], -0.4 - 1e-7) > 100);
}
