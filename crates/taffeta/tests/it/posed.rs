//! Pins that follow poses of their body's mesh.

use crate::common::{build_as, farthest, positions, turned};
use crate::gpu::on_gpu;
use taffeta::glam::{DAffine3, DQuat, DVec3};
use taffeta::scene::{Body, ConstraintForm, Ice, Keyframe, Mass, Mesh, Method, Scene, Select, Sleep};
use taffeta::topology::shapes;
use taffeta::{BuildError, InputError, Options, Pose, Precision, Simulation};

const DT: f64 = 0.01;
/// Time between poses, which is no multiple of that of a frame [s].
const INTERVAL: f64 = 0.025;
const ALONG: [f64; 3] = [0.01, 0.02, -0.005];
const SIZE: [f64; 2] = [0.5, 0.4];

fn sheet() -> Body {
    let cloth = Body::cloth("cape", Mesh::grid(12, 9, SIZE)).with_mass(Mass::Node(0.005));
    let cloth = Body { place: turned([1.0, 0.0, 0.0], 70.0, [0.3, 1.0, 0.0]), ..cloth };
    cloth.structural(60.0, 0.02).shear(20.0, 0.02)
}

/// Where that puts what is in the mesh.
fn placed(x: [f64; 3]) -> DVec3 {
    let turn = DQuat::from_rotation_x(70_f64.to_radians());
    DAffine3::from_rotation_translation(turn, DVec3::new(0.3, 1.0, 0.0)).transform_point3(x.into())
}

fn scene(body: Body) -> Scene {
    let mut scene = Scene::new("posed").body(body).method(Method::Ice).time(DT, 0.005);
    scene.solver.ice = Ice { form: ConstraintForm::Primal, ..Ice::default() };
    scene
}

/// Poses of the whole mesh, before it is placed: shifted by [`ALONG`] from pose to pose.
fn poses(count: usize) -> Vec<Vec<[f64; 3]>> {
    let nodes = shapes::grid_surface(12, 9, SIZE).nodes;
    let shifted = |pose: usize, x: &[f64; 3]| [0, 1, 2].map(|axis| x[axis] + pose as f64 * ALONG[axis]);
    (0..count).map(|pose| nodes.iter().map(|x| shifted(pose, x)).collect()).collect()
}

fn posed(count: usize) -> Body {
    sheet().pin_posed(Select::rows(0, 0), INTERVAL, poses(count))
}

fn on_cpu(scene: &Scene) -> Simulation {
    build_as(scene, Precision::F32, 2)
}

/// The largest distance of a pinned node from where poses have it at a time [s] [m].
fn off(simulation: &Simulation, poses: &[Vec<[f64; 3]>], time: f64) -> f64 {
    let at = (time / INTERVAL).min(poses.len() as f64 - 1.0);
    let (before, after) = (&poses[at as usize], &poses[(at as usize + 1).min(poses.len() - 1)]);
    let now = positions(simulation);
    let of = |node: usize| {
        let [from, to] = [before, after].map(|pose| DVec3::from(pose[node]));
        DVec3::from(now[node]).distance(placed(from.lerp(to, at.fract()).into()))
    };
    (0..9).map(of).fold(0.0, f64::max)
}

#[test]
fn nodes_go_through_the_poses_and_stay_in_the_last() {
    for build in [on_cpu, on_gpu] {
        let mut simulation = build(&scene(posed(5)));
        for frame in 0..14 {
            let off = off(&simulation, &poses(5), f64::from(frame) * DT);
            assert!(off < 1e-6, "frame {frame}: {off} m");
            simulation.step().unwrap();
        }
    }
}

#[test]
fn cloth_moves_as_with_keyframes_of_the_same_motion() {
    // Poses as far apart as frames: then both are the same straight lines.
    let nodes = poses(31);
    let by_poses = sheet().pin_posed(Select::rows(0, 0), DT, nodes);
    let whole = placed(ALONG.map(|c| 30.0 * c)) - placed([0.0; 3]);
    let key = Keyframe::translate(0.3, whole.to_array());
    let by_keys = sheet().pin_moving(Select::rows(0, 0), vec![Keyframe::translate(0.0, [0.0; 3]), key]);
    for precision in [Precision::F32, Precision::F64] {
        let [mut a, mut b] =
            [by_poses.clone(), by_keys.clone()].map(|body| build_as(&scene(body), precision, 1));
        a.advance(40).unwrap();
        b.advance(40).unwrap();
        let apart = farthest(&positions(&a), &positions(&b));
        assert!(apart < 1e-4, "{precision:?}: {apart} m");
    }
}

#[test]
fn a_pin_that_comes_later_takes_the_nodes_that_both_name() {
    let key = vec![Keyframe::translate(0.0, [0.0; 3]), Keyframe::translate(0.1, [0.0, 0.0, 0.3])];
    let ends = Select { cols: Some([0, 2]), ..Select::rows(0, 0) };
    let keyed_last = posed(5).pin_moving(ends.clone(), key.clone());
    let posed_last = sheet().pin_moving(ends, key).pin_posed(Select::rows(0, 0), INTERVAL, poses(5));
    let [keyed, posed] = [keyed_last, posed_last].map(|body| {
        let mut simulation = on_cpu(&scene(body));
        simulation.advance(10).unwrap();
        positions(&simulation)
    });
    let by_keys = placed(poses(1)[0][1]) + DVec3::new(0.0, 0.0, 0.3);
    let by_poses = |node: usize| placed(poses(5)[4][node]);
    assert!(DVec3::from(keyed[1]).distance(by_keys) < 1e-6, "{:?}", keyed[1]);
    for (all, node) in [(&keyed, 5), (&posed, 1), (&posed, 5)] {
        assert!(DVec3::from(all[node]).distance(by_poses(node)) < 1e-6, "{node}: {:?}", all[node]);
    }
}

#[test]
fn a_snapshot_goes_on_bit_by_bit_in_the_midst_of_poses() {
    let mut simulation = on_cpu(&scene(posed(9)));
    simulation.advance(7).unwrap();
    let snapshot = simulation.snapshot();
    simulation.advance(20).unwrap();
    let mut again = on_cpu(&scene(posed(9)));
    again.restore(&snapshot).unwrap();
    again.advance(20).unwrap();
    assert_eq!(again.state_hash(), simulation.state_hash());
    // Its poses are part of a scene.
    let mut other = on_cpu(&scene(posed(8)));
    assert!(other.restore(&snapshot).is_err());
}

#[test]
fn what_moves_by_poses_is_awake_and_sleeps_when_they_are_over() {
    let last = |body: Body| {
        let mut scene = scene(body);
        scene.sleep = Some(Sleep { speed: 5.0, after: 0.05 });
        let mut simulation = on_cpu(&scene);
        let asleep = |frame: u32| (frame, simulation.step().unwrap().asleep);
        (1..400).map(asleep).find(|&(_, asleep)| asleep > 0).map(|(frame, _)| frame)
    };
    // With so high a speed whatever stands at its pins sleeps at once.
    let (still, moved) = (last(posed(1)).unwrap(), last(posed(41)).unwrap());
    assert!(still < 60, "{still}");
    assert!(moved > 100, "poses last for 100 frames, and it slept in frame {moved}");
}

#[test]
fn what_cannot_be_is_refused() {
    let refused = |body: Body| match Simulation::new(&scene(body), &Options::default()) {
        Err(BuildError::Scene(error)) => error.to_string(),
        other => panic!("{:?}", other.err()),
    };
    let mut short = poses(2);
    short[1].pop();
    let mut wild = poses(2);
    wild[1][3][0] = f64::NAN;
    let mut both = posed(2);
    both.pins[0].motion = vec![Keyframe::translate(1.0, [0.0; 3])];
    let by = |poses| sheet().pin_posed(Select::rows(0, 0), INTERVAL, poses);
    for (body, path, words) in [
        (by(Vec::new()), "body[0].pin[0].poses", "has none"),
        (by(short), "body[0].pin[0].poses", "pose 1 has 107 nodes, the mesh 108"),
        (by(wild), "body[0].pin[0].poses", "node 3 of pose 1"),
        (both, "body[0].pin[0].poses", "cannot be beside motion"),
        (sheet().pin_posed(Select::rows(0, 0), 0.0, poses(2)), "body[0].pin[0].poses.interval", "is 0"),
    ] {
        let error = refused(body);
        assert!(error.contains(path) && error.contains(words), "{error}");
    }
}

#[test]
fn a_program_moves_nodes_only_where_poses_do_not() {
    let mut simulation = on_cpu(&scene(posed(5)));
    let cape = simulation.bodies()[0].handle;
    let by_poses = |error| matches!(error, Err(InputError::FollowsKeyframes { .. }));
    assert!(by_poses(simulation.pin_vertex(cape, 3, DVec3::ZERO)));
    assert!(by_poses(simulation.teleport_body(cape, Pose::default())));
    simulation.pin_vertex(cape, 60, DVec3::new(0.3, 0.9, 0.0)).unwrap();
    // After the last pose nothing brings them back.
    simulation.advance(11).unwrap();
    let shift = DVec3::new(0.0, 2.0, 0.0);
    simulation.teleport_body(cape, Pose::new(DQuat::IDENTITY, shift)).unwrap();
    simulation.advance(3).unwrap();
    let now = positions(&simulation);
    assert!(DVec3::from(now[4]).distance(placed(poses(5)[4][4]) + shift) < 1e-5, "{:?}", now[4]);
}
