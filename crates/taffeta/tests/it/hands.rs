//! What a program does to a running simulation: moves pins, applies forces, reads normals.

use crate::common::{
    add, build, near, norm, normals, positions, run, scale, sub, surface, turned, weightless,
};
use taffeta::Simulation;
use taffeta::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Scene, Select};

const DT: f64 = 0.01;

fn grid(pins: Select) -> Body {
    Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3]))
        .with_mass(Mass::Node(0.1))
        .structural(50.0, 0.05)
        .shear(30.0, 0.02)
        .pin(pins)
}

fn loose(body: Body) -> Simulation {
    build(&weightless("hands", DT, 0.001).body(body))
}

#[test]
fn a_moved_pin_arrives_with_the_speed_of_its_way_and_then_stands_still() {
    // No springs: the momentum is that of the pin alone.
    let body =
        Body::cloth("cloth", Mesh::grid(2, 2, [1.0, 1.0])).with_mass(Mass::Node(0.1)).pin(Select::nodes([3]));
    let mut simulation = loose(body);
    let (start, way) = (positions(&simulation)[3], [0.02, -0.01, 0.05]);
    simulation.pin_vertex(simulation.body("cloth").unwrap(), 3, add(start, way)).unwrap();
    run(&mut simulation, 1);
    assert_eq!(positions(&simulation)[3], add(start, way));
    for (axis, p) in simulation.report().momentum.into_iter().enumerate() {
        near("momentum", p, 0.1 * way[axis] / DT, 1e-12);
    }
    for _ in 0..3 {
        run(&mut simulation, 1);
        assert_eq!(positions(&simulation)[3], add(start, way));
        assert_eq!((simulation.report().momentum, simulation.report().kinetic), ([0.0; 3], 0.0));
    }
}

#[test]
fn a_pin_moved_by_hand_drags_cloth_as_one_moved_by_keyframes() {
    let way = [0.03, 0.02, -0.01];
    let stiff = |body: Body| body.structural(50.0, 0.0).shear(30.0, 0.0);
    let moved = grid(Select::nodes([0])).pin_moving(Select::nodes([7]), vec![Keyframe::translate(DT, way)]);
    let mut keyed = loose(stiff(moved));
    let mut of_user = loose(stiff(grid(Select::nodes([0, 7]))));
    let to = add(positions(&of_user)[7], way);
    of_user.pin_vertex(of_user.body("cloth").unwrap(), 7, [9.0; 3]).unwrap();
    // The last word counts.
    of_user.pin_vertex(of_user.body("cloth").unwrap(), 7, to).unwrap();
    for frame in 0..30 {
        run(&mut keyed, 1);
        run(&mut of_user, 1);
        let apart = crate::common::farthest(&positions(&keyed), &positions(&of_user));
        assert!(apart < 1e-12, "frame {frame}: {apart:e}");
    }
}

#[test]
fn a_pin_moved_on_by_hand_frame_after_frame_keeps_its_speed_between_frames() {
    // Damping sees the pin's speed at the start of each frame's first step.
    let way = [0.3, 0.2, -0.1];
    let path = vec![Keyframe::translate(20.0 * DT, way)];
    let mut keyed = loose(grid(Select::nodes([0])).pin_moving(Select::nodes([7]), path));
    let mut of_user = loose(grid(Select::nodes([0, 7])));
    let start = positions(&of_user)[7];
    for frame in 1..=20 {
        of_user
            .pin_vertex(of_user.body("cloth").unwrap(), 7, add(start, scale(way, f64::from(frame) / 20.0)))
            .unwrap();
        run(&mut keyed, 1);
        run(&mut of_user, 1);
        let apart = crate::common::farthest(&positions(&keyed), &positions(&of_user));
        assert!(apart < 1e-12, "frame {frame}: {apart:e}");
    }
}

#[test]
fn a_free_vertex_that_is_moved_is_pinned_from_then_on() {
    let mut simulation = build(&Scene::new("").time(DT, 0.001).body(grid(Select::nodes([0]))));
    run(&mut simulation, 10);
    simulation.pin_vertex(simulation.body("cloth").unwrap(), 19, [0.3, 0.1, 0.2]).unwrap();
    run(&mut simulation, 50);
    assert_eq!(positions(&simulation)[19], [0.3, 0.1, 0.2]);
}

#[test]
fn a_vertex_that_is_unpinned_flies_on_and_falls_while_pins_of_the_scene_hold() {
    let body = Body::cloth("cloth", Mesh::grid(2, 2, [1.0, 1.0])).with_mass(Mass::Node(0.1));
    let mut simulation = build(&Scene::new("").time(DT, DT).body(body.pin(Select::nodes([3]))));
    let start = positions(&simulation);
    let way = [0.02, 0.0, -0.01];
    for vertex in [1, 3] {
        simulation.pin_vertex(simulation.body("cloth").unwrap(), vertex, add(start[vertex], way)).unwrap();
    }
    run(&mut simulation, 1);
    for vertex in [1, 3] {
        simulation.unpin_vertex(simulation.body("cloth").unwrap(), vertex).unwrap();
    }
    run(&mut simulation, 4);
    // h² g (1 + 2 + 3 + 4), and four times the way of the hand.
    let fallen = [0.1, -9.81 * DT * DT * 10.0, -0.05];
    near("flight", norm(sub(sub(positions(&simulation)[1], start[1]), fallen)), 0.0, 1e-14);
    assert_eq!(positions(&simulation)[3], add(start[3], way));
    assert!(simulation.unpin_vertex(simulation.body("cloth").unwrap(), 4).is_err());
    // One that nobody has taken is as it was.
    simulation.unpin_vertex(simulation.body("cloth").unwrap(), 0).unwrap();
    run(&mut simulation, 1);
}

#[test]
fn velocities_are_those_of_the_vertices_in_the_meshs_own_order() {
    let body = Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 1 }));
    let mut simulation = loose(body.with_mass(Mass::Node(0.2)));
    simulation.apply_force(simulation.body("ball").unwrap(), 17, [2.0, -4.0, 6.0]).unwrap();
    run(&mut simulation, 1);
    let mut velocities: Vec<[f32; 3]> = Vec::new();
    simulation.velocities_f32(&mut velocities);
    for (vertex, v) in velocities.iter().enumerate() {
        let expected = if vertex == 17 { [0.1, -0.2, 0.3] } else { [0.0; 3] };
        near("velocity", norm(sub(v.map(f64::from), expected)), 0.0, 1e-7);
    }
}

#[test]
fn gaps_are_distances_from_where_colliders_hold_nodes_back() {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 5 });
    let sheet = Mesh::grid(2, 2, [4.0, 4.0]);
    for (collider, tolerance) in [
        (Collider::sphere([0.0, -1.0, 0.0], 0.5), 1e-6),
        (Collider::mesh(ball).placed(turned([0.0, 1.0, 0.0], 0.0, [0.0, -1.0, 0.0])), 2e-3),
        (Collider::mesh(sheet).placed(turned([0.0, 1.0, 0.0], 0.0, [0.0, -0.5, 0.0])), 1e-6),
    ] {
        let sphere = collider.sphere.is_some() || tolerance > 1e-4;
        let chain = Body::cloth("chain", Mesh::chain(2, 2.0)).with_mass(Mass::Node(0.1));
        let lifted = collider.offset(0.1).keyframe(Keyframe::translate(DT, [0.0, 0.3, 0.0]));
        let mut simulation = build(&weightless("gaps", DT, DT).body(chain).collider(lifted));
        run(&mut simulation, 1);
        let mut gaps = Vec::new();
        simulation.collider_distances(0.7, &mut gaps);
        // The ball's centre is 0.7 m below the middle now, the sheet 0.2 m.
        let aside = if sphere { 1.49_f64.sqrt() - 0.6 } else { 0.1 };
        let middle = 0.1;
        for (gap, expected) in gaps.iter().zip([aside, middle, aside]) {
            near("gap", f64::from(*gap), expected, tolerance);
        }
        simulation.collider_distances(0.05, &mut gaps);
        assert_eq!(gaps, [0.05; 3]);
    }
}

#[test]
fn a_force_for_a_frame_changes_momentum_by_force_times_time() {
    let mut simulation = loose(grid(Select::nodes([0])));
    let mut free = loose(Body { pins: vec![], ..grid(Select::nodes([0])) });
    let forces = [(3, [1.0, -2.0, 0.5]), (18, [0.0, 4.0, 1.0]), (3, [2.0, 0.0, 0.0]), (7, [-1.0, 0.0, 0.0])];
    for (vertex, force) in forces {
        free.apply_force(free.body("cloth").unwrap(), vertex, force).unwrap();
    }
    for _ in 0..5 {
        run(&mut free, 1);
        for (p, expected) in free.report().momentum.into_iter().zip([2.0, 2.0, 1.5]) {
            near("momentum", p, expected * DT, 1e-15);
        }
    }
    simulation.apply_force(simulation.body("cloth").unwrap(), 0, [5.0, 5.0, 5.0]).unwrap();
    run(&mut simulation, 1);
    near("kinetic energy with a push on a held node", simulation.report().kinetic, 0.0, 1e-25);
}

#[test]
fn vertices_keep_the_meshs_own_order_whatever_order_the_solver_has() {
    let body = Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 2 }));
    let mut simulation = loose(body.with_mass(Mass::Node(0.2)));
    let start = positions(&simulation);
    assert_eq!(start, surface(&simulation, 0).nodes);
    for vertex in [0, 17, 161] {
        simulation.apply_force(simulation.body("ball").unwrap(), vertex, scale(start[vertex], 2.0)).unwrap();
    }
    run(&mut simulation, 1);
    for (vertex, (from, to)) in start.iter().zip(positions(&simulation)).enumerate() {
        // F h²/m (1 + … + 10) = 10 · 1e-6 · 55 m outwards.
        let out = if [0, 17, 161].contains(&vertex) { 5.5e-4 } else { 0.0 };
        near("way", norm(to) - norm(*from), out, 1e-12);
    }
    for (normal, x) in normals(&simulation, 0).iter().zip(&start) {
        let off = norm(sub(normal.map(f64::from), *x));
        assert!(off < 0.03, "a sphere's normal points away from its centre: {off}");
    }
}

#[test]
fn a_frame_that_is_timed_is_the_same_and_its_stages_take_no_longer_than_all_of_it() {
    let scene = Scene::new("").time(DT, 0.001).body(grid(Select::nodes([0])).collide_nodes(0.02));
    for threads in [1, 2] {
        let [mut timed, mut other] =
            [0; 2].map(|_| crate::common::build_as(&scene, taffeta::Precision::F32, threads));
        let clock = std::time::Instant::now();
        let times = timed.step_timed().unwrap();
        let whole = clock.elapsed().as_secs_f64();
        run(&mut other, 1);
        assert_eq!(timed.state_hash(), other.state_hash());
        // Of two threads the first may have no nodes.
        let stages = ["loads", "springs", "integrate", "pairs", "between"];
        for stage in stages.into_iter().filter(|_| threads == 1) {
            assert!(times.iter().any(|(name, time)| *name == stage && *time > 0.0), "{stage}: {times:?}");
        }
        assert!(times.iter().map(|(_, time)| time).sum::<f64>() <= whole);
        // The next frame is not timed.
        run(&mut timed, 1);
    }
}

#[test]
fn what_is_not_there_is_refused_by_name() {
    let mut simulation = loose(grid(Select::nodes([0])));
    let error = simulation.body("sheet").unwrap_err().to_string();
    assert!(error.contains("`sheet`") && error.contains("cloth"), "{error}");
    let error =
        simulation.apply_force(simulation.body("cloth").unwrap(), 20, [0.0; 3]).unwrap_err().to_string();
    assert!(error.contains("0 to 19") && error.contains("20"), "{error}");
    run(&mut simulation, 1);
}

#[test]
fn a_disturbance_is_the_same_for_the_same_seed_and_spares_pins() {
    let disturbed = |seed| {
        let mut simulation = loose(grid(Select::nodes([4, 9])));
        simulation.disturb(0.01, seed);
        positions(&simulation)
    };
    let (start, [a, b, c]) = (positions(&loose(grid(Select::nodes([4, 9])))), [1, 1, 2].map(disturbed));
    assert_eq!(a, b);
    assert!(a[4] == start[4] && a[9] == start[9]);
    let moved = crate::common::farthest(&a, &start);
    assert!(moved > 0.005 && moved < 0.01 * 3_f64.sqrt() && crate::common::farthest(&a, &c) > 0.005);
}
