//! Two nodes.

use super::{cloud, set_velocities, touch, velocities};
use crate::common::{V, add, build_as, cross, near, norm, positions, run, scale, sub, weightless};
use taffeta::scene::{Body, Scene, SelfCollision};
use taffeta::{Precision, Simulation};

const STEP: f64 = 0.001;
const THICKNESS: f64 = 0.1;

/// Two nodes of two bodies as they are a step before they touch, and a step later.
struct Meeting {
    mass: [f64; 2],
    held: [bool; 2],
    x: [V; 2],
    v: [V; 2],
    how: [SelfCollision; 2],
}

/// After the impact.
struct After {
    x: [V; 2],
    v: [V; 2],
    pairs: u64,
}

impl Meeting {
    /// Head-on along x, at 3 m/s and −2 m/s.
    fn head_on(mass: [f64; 2], friction: f64, restitution: f64) -> Self {
        Self {
            mass,
            held: [false; 2],
            x: [[-0.051, 0.0, 0.0], [0.051, 0.0, 0.0]],
            v: [[3.0, 0.0, 0.0], [-2.0, 0.0, 0.0]],
            how: [(); 2].map(|()| touch(THICKNESS, friction, restitution)),
        }
    }

    fn scene(&self) -> Scene {
        let body = |i: usize| -> Body {
            let body = cloud(["first", "second"][i], &[self.x[i]], self.mass[i], self.how[i].clone());
            if self.held[i] { body.pin(taffeta::scene::Select::nodes([0])) } else { body }
        };
        weightless("two", STEP, STEP).body(body(0)).body(body(1))
    }

    fn start(&self, precision: Precision) -> Simulation {
        let mut simulation = build_as(&self.scene(), precision, 1);
        let v = |i: usize| if self.held[i] { [0.0; 3] } else { self.v[i] };
        set_velocities(&mut simulation, &[v(0), [0.0; 3], v(1)]);
        simulation
    }

    fn after(&self, frames: u32) -> After {
        let mut simulation = self.start(Precision::F64);
        run(&mut simulation, frames);
        let (x, v) = (positions(&simulation), velocities(&simulation));
        After { x: [x[0], x[2]], v: [v[0], v[2]], pairs: simulation.report().pairs }
    }
}

#[track_caller]
fn same(what: &str, got: V, expected: V) {
    (0..3).for_each(|axis| near(what, got[axis], expected[axis], 1e-12));
}

#[test]
fn equal_masses_that_meet_elastically_exchange_their_velocities() {
    let after = Meeting::head_on([0.2; 2], 0.0, 1.0).after(1);
    assert_eq!(after.pairs, 1);
    same("first", after.v[0], [-2.0, 0.0, 0.0]);
    same("second", after.v[1], [3.0, 0.0, 0.0]);
    // They part by themselves: nothing pushes them.
    same("place", after.x[0], [-0.048, 0.0, 0.0]);
    assert_eq!(Meeting::head_on([0.2; 2], 0.0, 1.0).after(2).pairs, 0);
}

#[test]
fn unequal_masses_part_as_momentum_and_restitution_say() {
    for (mass, e) in [([0.1, 0.3], 1.0), ([5.0, 0.02], 0.5), ([0.4, 0.4], 0.25)] {
        let after = Meeting::head_on(mass, 0.7, e).after(1);
        let common = (3.0 * mass[0] - 2.0 * mass[1]) / (mass[0] + mass[1]);
        let share = |i: usize| mass[1 - i] / (mass[0] + mass[1]);
        same("first", after.v[0], [common - 5.0 * e * share(0), 0.0, 0.0]);
        same("second", after.v[1], [common + 5.0 * e * share(1), 0.0, 0.0]);
    }
}

#[test]
fn nodes_that_do_not_bounce_go_on_together_at_their_thickness() {
    let meeting = Meeting::head_on([0.1, 0.3], 0.0, 0.0);
    for frames in [1, 2, 100] {
        let After { x, v, .. } = meeting.after(frames);
        same("common velocity", v[0], [-0.75, 0.0, 0.0]);
        same("common velocity", v[1], [-0.75, 0.0, 0.0]);
        near("distance", norm(sub(x[0], x[1])), THICKNESS, 1e-12);
    }
}

#[test]
fn friction_takes_no_more_than_coulomb_says_and_its_way_back() {
    // Approach 5 m/s, reduced mass 0.1 kg: the impulse between them is 0.5 (1 + e) N·s.
    for (friction, e, slip) in [(0.1, 0.0, 4.0), (0.3, 0.5, 4.0), (0.9, 0.0, 4.0), (0.2, 1.0, 0.7)] {
        let mut meeting = Meeting::head_on([0.2; 2], friction, e);
        meeting.v[0][1] = 0.75 * slip;
        meeting.v[1][1] = -0.25 * slip;
        let after = meeting.after(1);
        let normal = {
            let moved = |i: usize| add(meeting.x[i], scale(meeting.v[i], STEP));
            let way = sub(moved(0), moved(1));
            scale(way, 1.0 / norm(way))
        };
        let part = |v: [V; 2]| {
            let relative = sub(v[0], v[1]);
            let speed: f64 = (0..3).map(|axis| relative[axis] * normal[axis]).sum();
            (speed, norm(sub(relative, scale(normal, speed))))
        };
        let ((approach, slipped), (gone, left)) = (part(meeting.v), part(after.v));
        near("restitution", gone, -e * approach, 1e-12);
        near("friction", slipped - left, slipped.min(friction * (1.0 + e) * -approach), 1e-12);
        same("momentum", add(after.v[0], after.v[1]), add(meeting.v[0], meeting.v[1]));
        // Where it sticks, they are as far along each other as they were.
        let along = |x: [V; 2]| norm(cross(sub(x[0], x[1]), normal));
        if left < 1e-9 && e == 0.0 {
            near("way back", along(after.x), along(meeting.x), 1e-12);
        }
    }
}

#[test]
fn a_held_node_is_a_wall() {
    for e in [0.0, 0.5, 1.0] {
        for held in [0, 1] {
            let mut meeting = Meeting::head_on([0.2, 0.7], 0.0, e);
            meeting.held[held] = true;
            meeting.x[1 - held] = scale(meeting.x[1 - held], 0.1005 / 0.051 - 1.0);
            let after = meeting.after(1);
            assert_eq!(after.pairs, 1);
            same("free", after.v[1 - held], scale(meeting.v[1 - held], -e));
            same("held", after.v[held], [0.0; 3]);
            assert_eq!(after.x[held], meeting.x[held]);
        }
    }
}

#[test]
fn two_held_nodes_stay() {
    let mut meeting = Meeting::head_on([0.2; 2], 0.5, 0.5);
    meeting.held = [true; 2];
    meeting.x = [[0.0; 3], [0.01, 0.0, 0.0]];
    let after = meeting.after(3);
    assert_eq!((after.x, after.v, after.pairs), (meeting.x, [[0.0; 3]; 2], 1));
}

#[test]
fn a_held_node_stops_all_that_fall_on_it_as_it_would_stop_one() {
    // Six nodes come from all sides at once.
    let sides: Vec<V> = (0..6)
        .map(|i| std::array::from_fn(|axis| if axis == i / 2 { [0.1005, -0.1005][i % 2] } else { 0.0 }))
        .collect();
    let held = cloud("wall", &[[0.0; 3]], 1.0, touch(THICKNESS, 0.2, 0.0));
    let scene = weightless("star", STEP, STEP)
        .body(held.pin(taffeta::scene::Select::nodes([0])))
        .body(cloud("free", &sides, 0.01, touch(THICKNESS, 0.2, 0.0)));
    let mut simulation = build_as(&scene, Precision::F64, 1);
    let v: Vec<V> = [[0.0; 3]; 2].into_iter().chain(sides.iter().map(|&x| scale(x, -20.0))).collect();
    set_velocities(&mut simulation, &v);
    run(&mut simulation, 1);
    assert_eq!(simulation.report().pairs, 6);
    for v in velocities(&simulation) {
        same("velocity", v, [0.0; 3]);
    }
}

#[test]
fn nodes_at_one_place_part_and_keep_their_momentum() {
    for e in [0.0, 0.5, 1.0] {
        let mut meeting = Meeting::head_on([0.1, 0.3], 0.5, e);
        (meeting.x, meeting.v) = ([[0.3, 0.2, 0.1]; 2], [[0.0; 3]; 2]);
        for precision in [Precision::F64, Precision::F32] {
            let mut simulation = meeting.start(precision);
            run(&mut simulation, 400);
            let (x, p) = (positions(&simulation), simulation.report().momentum);
            let way = sub(x[0], x[2]);
            assert!(way[1] > 0.98 * THICKNESS && way[0] == 0.0 && way[2] == 0.0, "{e} {precision}: {way:?}");
            assert!(norm(p) < 1e-7, "{p:?}");
        }
    }
}
