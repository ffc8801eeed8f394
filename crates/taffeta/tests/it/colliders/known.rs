//! What is known of triangles makes runs faster, and nothing else.

use super::depth::data;
use super::reference::Faces;
use crate::common::{V, add, build_as, run, scale};
use taffeta::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Scene, Torus, VolumeForm};
use taffeta::{Precision, Simulation, Snapshot};

/// Cloth that touches itself and a soft ball, on a sheet, a ring that turns, and a ball that breathes.
fn scene() -> Scene {
    let cloth = Body::cloth("cloth", Mesh::grid(26, 30, [1.6, 1.4]))
        .at([0.0, 0.35, 0.0])
        .with_mass(Mass::Node(0.005))
        .structural(60.0, 0.05)
        .shear(40.0, 0.03)
        .collide_nodes(0.03);
    let ball = Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 3 });
    let ball =
        Body::soft("ball", ball).with_mass(Mass::Whole(0.5)).structural(80.0, 0.05).at([0.1, 0.6, 0.1]);
    let ring = Mesh::Torus(Torus { major: 0.4, minor: 0.1, rings: 24, segments: 12 });
    let breathing = Faces::of(&Mesh::Icosphere(Icosphere { radius: 0.25, subdivisions: 2 }));
    let at = |i: u32| {
        let grown = |x: &V| add(scale(*x, 1.0 + 0.1 * f64::from(i % 3)), [0.5, 0.0, 0.3]);
        breathing.nodes.iter().map(grown).collect()
    };
    let poses = (0..12).map(at).collect();
    Scene::new("known")
        .time(0.01, 0.002)
        .body(cloth)
        .body(ball.keep_volume(VolumeForm::Projected).collide_nodes(0.03))
        .collider(Collider::mesh(Mesh::grid(9, 9, [3.0, 3.0])))
        .collider(Collider::mesh(ring).keyframe(Keyframe::rotate(
            0.5,
            [0.2, 1.0, 0.1],
            90.0,
            [0.1, 0.0, 0.0],
        )))
        .collider(Collider::mesh(data(breathing.nodes.clone(), breathing.triangles)).posed(0.033, poses))
}

fn start(precision: Precision, threads: usize) -> Simulation {
    let mut simulation = build_as(&scene(), precision, threads);
    simulation.disturb(0.001, 3);
    simulation
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for precision in [Precision::F32, Precision::F64] {
        let ran = |threads| {
            let mut simulation = start(precision, threads);
            run(&mut simulation, 22);
            (simulation.state_hash(), simulation.report().contacts)
        };
        let one = ran(1);
        assert!(one.1 > 50, "{} contacts", one.1);
        for threads in [2, 3, 8] {
            assert_eq!(ran(threads), one, "{precision}, {threads}");
        }
    }
}

/// Hashes of frames after a snapshot is taken up.
fn goes_on(simulation: &mut Simulation, from: &Snapshot, frames: u32) -> Vec<u64> {
    simulation.restore(from).unwrap();
    let mut hashes = vec![simulation.state_hash()];
    for _ in 0..frames {
        run(simulation, 1);
        hashes.push(simulation.state_hash());
    }
    hashes
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit_and_time_may_go_back() {
    for precision in [Precision::F32, Precision::F64] {
        let mut whole = start(precision, 2);
        run(&mut whole, 8);
        let early = whole.snapshot();
        run(&mut whole, 12);
        let late = whole.snapshot();
        run(&mut whole, 8);
        for stop in [&early, &late] {
            let fresh = goes_on(&mut start(precision, 1), stop, 10);
            assert_eq!(goes_on(&mut whole, stop, 10), fresh, "{precision}: what is known matters");
        }
    }
}

/// The same state, with all nodes of the bodies elsewhere.
fn elsewhere(snapshot: &Snapshot, way: V) -> Snapshot {
    let mut moved = snapshot.clone();
    let places = 24 * snapshot.nodes as usize;
    for (bytes, axis) in
        moved.state[..places].as_chunks_mut::<8>().0.iter_mut().zip([0, 1, 2].into_iter().cycle())
    {
        *bytes = (f64::from_le_bytes(*bytes) + way[axis]).to_le_bytes();
    }
    moved
}

#[test]
fn bodies_put_elsewhere_by_hand_meet_what_is_there() {
    let mut whole = start(Precision::F64, 2);
    run(&mut whole, 20);
    for way in [[0.7, 0.3, -0.4], [0.0, 5.0, 0.0], [0.2, -0.6, 0.0], [-0.01, 0.0, 0.01]] {
        let moved = elsewhere(&whole.snapshot(), way);
        let fresh = goes_on(&mut start(Precision::F64, 1), &moved, 6);
        assert_eq!(goes_on(&mut whole, &moved, 6), fresh, "{way:?}");
    }
}
