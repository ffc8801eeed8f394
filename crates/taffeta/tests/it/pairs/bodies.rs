//! Several bodies.

use super::crossing::crossings;
use super::{cloud, set_velocities, touch, velocities};
use crate::common::{V, build, build_as, near, norm, positions, run, scale, sub, surface, weightless};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Icosphere, Mass, Mesh, Scene, SelfCollision, VolumeForm};

/// Two nodes of two bodies at `x`, moving at `v`, a millisecond later.
fn met(how: &[Option<SelfCollision>; 2], x: [V; 2], v: [V; 2], precision: Precision) -> ([V; 2], u64) {
    let mut bodies = [0, 1].map(|i| cloud(["first", "second"][i], &[x[i]], 0.1, touch(0.1, 0.0, 0.0)));
    (0..2).for_each(|i| bodies[i].self_collision.clone_from(&how[i]));
    let [first, second] = bodies;
    let mut simulation = build_as(&weightless("two", 0.001, 0.001).body(first).body(second), precision, 1);
    set_velocities(&mut simulation, &[v[0], [0.0; 3], v[1]]);
    run(&mut simulation, 1);
    let v = velocities(&simulation);
    ([v[0], v[2]], simulation.report().pairs)
}

#[test]
fn surfaces_meet_at_their_mean_thickness_with_mean_friction_and_the_larger_restitution() {
    let how = [Some(touch(0.06, 0.2, 0.5)), Some(touch(0.14, 0.45, 0.25))];
    let at = |x: f64| [[0.0; 3], [x, 0.0, 0.0]];
    let v = [[2.0, 3.0, 0.0], [0.0; 3]];
    let (_, none) = met(&how, at(0.1021), v, Precision::F64);
    let ([a, b], one) = met(&how, at(0.1019), v, Precision::F64);
    assert_eq!((none, one), (0, 1));
    // Along the line between them, which has turned a little by then.
    let line = scale([0.002 - 0.1019, 0.003, 0.0], 1.0 / norm([0.0999, 0.003, 0.0]));
    let along = |v: V| v[0] * line[0] + v[1] * line[1];
    let [before, after] = [sub(v[0], v[1]), sub(a, b)];
    near("restitution", along(after), -0.5 * along(before), 1e-12);
    let slip = |v: V| norm(sub(v, scale(line, along(v))));
    // √(0.2 · 0.45) = 0.3.
    near("friction", slip(before) - slip(after), 0.3 * 1.5 * -along(before), 1e-12);
}

#[test]
fn bodies_without_contact_pass_through() {
    let v = [[2.0, 0.0, 0.0], [-2.0, 0.0, 0.0]];
    let x = [[0.0; 3], [0.05, 0.0, 0.0]];
    for how in [[Some(touch(0.1, 0.0, 0.0)), None], [None, Some(touch(0.1, 0.0, 0.0))], [None, None]] {
        assert_eq!(met(&how, x, v, Precision::F64), (v, 0));
    }
}

#[test]
fn far_from_the_origin_and_from_each_other_all_is_the_same() {
    let how = [(); 2].map(|()| Some(touch(0.1, 0.3, 0.5)));
    let v = [[2.0, 1.0, 0.0], [-2.0, 0.0, 0.5]];
    let at = |place: V| [place, [place[0] + 0.1, place[1], place[2]]];
    for (precision, most) in [(Precision::F64, 1e-9), (Precision::F32, 1e-2)] {
        let (here, _) = met(&how, at([0.0; 3]), v, precision);
        for place in [[1000.0, 0.0, 0.0], [-1000.0, 1000.0, -1000.0]] {
            let (there, pairs) = met(&how, at(place), v, precision);
            assert_eq!(pairs, 1);
            for i in 0..2 {
                assert!(norm(sub(here[i], there[i])) < most, "{precision}: {here:?} {there:?}");
            }
        }
        let (apart, pairs) = met(&how, [[0.0; 3], [1e4, 0.0, 0.0]], v, precision);
        assert_eq!((apart, pairs), (v, 0));
    }
}

#[test]
fn soft_bodies_pile_up_and_keep_their_volume() {
    let ball = |name: &str, at: V| {
        Body::soft(name, Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: 3 }))
            .with_mass(Mass::Whole(0.3))
            .structural(60.0, 0.05)
            .keep_volume(VolumeForm::Corrected)
            .collide_nodes(0.015)
            .at(at)
    };
    let wall = |x: f64, z: f64| Collider::plane([-0.15 * x, 0.0, -0.15 * z], [x, 0.0, z]).offset(0.0);
    let scene = Scene::new("pile")
        .time(0.01, 0.0005)
        .body(ball("a", [0.0, 0.11, 0.0]))
        .body(ball("b", [0.05, 0.34, 0.02]))
        .body(ball("c", [-0.04, 0.57, -0.03]))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction(0.5));
    let sides = [wall(1.0, 0.0), wall(-1.0, 0.0), wall(0.0, 1.0), wall(0.0, -1.0)];
    let mut simulation = build(&sides.into_iter().fold(scene, Scene::collider));
    let rest = simulation.report().volumes[0].unwrap();
    let triangles = surface(&simulation, 0).triangles;
    let (mut worst, mut touched) = (0.0_f64, 0);
    for frame in 1..=150 {
        run(&mut simulation, 1);
        let report = simulation.report();
        let errors = report.volumes.iter().flatten().map(|v| (v / rest - 1.0).abs());
        worst = errors.fold(worst, f64::max);
        touched += report.pairs;
        if frame % 10 == 0 {
            let x = positions(&simulation);
            let balls: Vec<&[V]> = x.chunks(x.len() / 3).collect();
            for (a, b) in [(0, 1), (0, 2), (1, 2)] {
                let through = crossings([balls[a], balls[b]], [&triangles, &triangles]);
                assert_eq!(through, 0, "frame {frame}: balls {a} and {b}");
            }
        }
    }
    assert!(touched > 5000, "{touched}");
    assert!(worst < 0.005, "{worst:e}");
}
