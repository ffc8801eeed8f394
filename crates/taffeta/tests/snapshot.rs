//! A simulation that is restored from a snapshot goes on as if it had never stopped.

mod common;

use common::{add, build_as, positions, run};
use taffeta::scene::{Body, Collider, Icosphere, Kind, Mass, Mesh, Scene, Select};
use taffeta::{Precision, Simulation};

/// Cloth with a moving pin and one for the hand, beside a soft ball with hinges that falls onto a plane.
fn scene() -> Scene {
    let cloth = Body::cloth("cloth", Mesh::grid(9, 11, [0.4, 0.3]))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.05)
        .shear(30.0, 0.02)
        .bend(5.0, 0.0)
        .pin(Select::nodes([0]))
        .pin_moving(Select::nodes([10]), vec![taffeta::scene::Keyframe::translate(0.2, [0.1, 0.0, 0.05])]);
    let ball = Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: 2 });
    let mut ball = Body::cloth("ball", ball).with_mass(Mass::Whole(0.5)).structural(200.0, 0.1);
    ball.kind = Kind::Soft;
    ball.springs.hinge = Some(taffeta::scene::Hinge { k: 0.01, d: 1e-5 });
    let mut scene = Scene::new("stopped").time(0.01, 0.001).body(cloth).body(ball);
    scene.colliders.push(Collider::plane([0.0, -0.12, 0.0], [0.0, 1.0, 0.0]));
    scene
}

/// Frame by frame the same pulls of the hand.
fn pull(simulation: &mut Simulation, frames: std::ops::Range<u32>) {
    for frame in frames {
        let to = add([0.1, 0.02, 0.1], [0.0, 0.001 * f64::from(frame), 0.0]);
        if frame % 5 < 3 {
            simulation.move_pin("cloth", 50, to).unwrap();
        }
        simulation.apply_force("ball", 3, [0.1, 0.0, f64::from(frame % 3)]).unwrap();
        run(simulation, 1);
    }
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    for precision in [Precision::F32, Precision::F64] {
        // The last frame before a stop moves the pin, or lets it stand.
        for stop in [8, 9, 11] {
            let mut whole = build_as(&scene(), precision, 1);
            pull(&mut whole, 0..stop);
            let snapshot = whole.snapshot();
            pull(&mut whole, stop..20);
            for threads in [1, 3] {
                let mut again = build_as(&scene(), precision, threads);
                again.restore(&snapshot).unwrap();
                assert_eq!(again.snapshot(), snapshot, "what is restored is what was taken");
                pull(&mut again, stop..20);
                assert_eq!(again.state_hash(), whole.state_hash(), "{precision}, stopped at {stop}");
                assert_eq!(again.report(), whole.report());
            }
        }
    }
}

#[test]
fn a_snapshot_in_64_bits_is_rounded_to_32() {
    let mut fine = build_as(&scene(), Precision::F64, 1);
    pull(&mut fine, 0..10);
    let mut coarse = build_as(&scene(), Precision::F32, 1);
    coarse.restore(&fine.snapshot()).unwrap();
    let rounded: Vec<_> = positions(&fine).into_iter().map(|p| p.map(|x| f64::from(x as f32))).collect();
    assert_eq!(positions(&coarse), rounded);
    assert_eq!(coarse.frame(), 10);
}

#[test]
fn a_snapshot_of_something_else_is_refused_and_changes_nothing() {
    let mut simulation = build_as(&scene(), Precision::F32, 1);
    let before = simulation.state_hash();
    let good = simulation.snapshot();
    let mut refused = |change: &dyn Fn(&mut taffeta::Snapshot), words: &str| {
        let mut snapshot = good.clone();
        change(&mut snapshot);
        let error = simulation.restore(&snapshot).unwrap_err();
        assert!(error.contains(words), "{error}");
        assert_eq!(simulation.state_hash(), before);
    };
    refused(&|s| s.nodes = 7, "it holds 7 nodes, the scene has 261");
    refused(&|s| s.state.truncate(100), "has 100 bytes");
    refused(&|s| s.held.push(261), "node 261");
    refused(&|s| s.held.clear(), "node 0 is free in it and held here");
    let nan = f32::NAN.to_le_bytes();
    refused(&|s| s.state[12 * 5..12 * 5 + 4].copy_from_slice(&nan), "node 5 has a number that is not finite");
}
