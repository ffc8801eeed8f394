//! A mesh in which two surfaces touch in one vertex, whose point is two nodes.

use crate::common::{V, build, near, norm, normals, positions, run, sub, weightless};
use std::sync::Arc;
use taffeta::scene::{Body, Force, Keyframe, Mass, Mesh, Select};
use taffeta::topology::{Polygons, Surface};
use taffeta::{InputError, Simulation};

/// Two triangles that touch in vertex 2: nodes 2 and 5.
fn bow_tie() -> Body {
    let vertices: Vec<V> = vec![[0.0; 3], [0.0, 1.0, 0.0], [1.0, 0.5, 0.0], [2.0, 0.0, 0.0], [2.0, 1.0, 0.0]];
    let mut polygons = Polygons::default();
    polygons.push(&[0, 2, 1]);
    polygons.push(&[2, 3, 4]);
    let mut nodes = vertices.clone();
    nodes.push(vertices[2]);
    let node_of_vertex = Some(vec![0, 1, 2, 3, 4]);
    let triangles = vec![[0, 2, 1], [5, 3, 4]];
    let surface = Surface { vertices, polygons, nodes, node_of_vertex, triangles, ..Surface::default() };
    Body::cloth("tie", Mesh::Surface(Arc::new(surface))).with_mass(Mass::Node(0.1)).structural(50.0, 0.1)
}

fn loose(body: Body) -> Simulation {
    build(&weightless("tie", 0.01, 1e-3).body(body))
}

/// Both triangles keep their sides, so that each hangs on the middle.
fn is_whole(simulation: &Simulation, middle: V) {
    let places = positions(simulation);
    for corner in [0, 1, 3, 4] {
        near("side", norm(sub(places[corner], middle)), 1.25_f64.sqrt(), 0.01);
    }
}

#[test]
fn a_pin_holds_all_nodes_of_its_vertex() {
    let mut scene = weightless("tie", 0.01, 1e-3).body(bow_tie().pin(Select::nodes([2])));
    scene.world.gravity = [0.0, -9.81, 0.0];
    scene.world.drag = 1.0;
    let mut simulation = build(&scene);
    run(&mut simulation, 100);
    let places = positions(&simulation);
    for corner in [0, 1, 3, 4] {
        // Two of 0.1 kg on two springs of 50 N/m: 0.02 m longer at most.
        near("side", norm(sub(places[corner], places[2])), 1.25_f64.sqrt(), 0.05);
    }
}

#[test]
fn keyframes_and_hands_move_all_nodes_of_a_vertex() {
    // Slowly, so that the triangles follow without a swing; one left behind would have sides of 1.16 m, not 1.12 m.
    let to = |share: f64| [1.0, 0.5, 0.3 * share];
    let path = vec![Keyframe::translate(3.0, [0.0, 0.0, 0.3])];
    let mut keyed = loose(bow_tie().pin_moving(Select::nodes([2]), path));
    let mut of_user = loose(bow_tie());
    for frame in 1..=300 {
        run(&mut keyed, 1);
        of_user.pin_vertex(of_user.body("tie").unwrap(), 2, to(f64::from(frame) / 300.0)).unwrap();
        run(&mut of_user, 1);
    }
    for simulation in [&keyed, &of_user] {
        assert!(norm(sub(positions(simulation)[2], to(1.0))) < 1e-12);
        is_whole(simulation, to(1.0));
    }
    let refused = keyed.pin_vertex(keyed.body("tie").unwrap(), 2, [0.0; 3]);
    assert!(matches!(refused, Err(InputError::FollowsKeyframes { .. })), "{refused:?}");
    assert_eq!(normals(&keyed, 0).len(), 5);
}

#[test]
fn a_force_on_a_vertex_acts_once() {
    let force = [0.0, 0.0, 1.0];
    let loads =
        Force { body: "tie".into(), select: Select::nodes([2, 3]), force: Some(force), ..Force::default() };
    let mut simulation = build(&weightless("tie", 0.01, 1e-3).body(bow_tie()).force(loads));
    run(&mut simulation, 1);
    near("momentum", simulation.report().momentum[2], 0.02, 1e-15);
    let mut of_user = loose(bow_tie());
    of_user.apply_force(of_user.body("tie").unwrap(), 2, force).unwrap();
    run(&mut of_user, 1);
    near("momentum", of_user.report().momentum[2], 0.01, 1e-15);
}

#[test]
fn a_blow_up_names_a_vertex_that_the_mesh_has() {
    let mut simulation = build(&weightless("tie", 0.1, 0.1).body(bow_tie()));
    simulation.disturb(1e-2, 1);
    for _ in 0..500 {
        if let Err(error) = simulation.step() {
            let taffeta::StepError::Diverged(error) = error else { panic!("{error}") };
            assert!(error.vertex < 5, "{error}");
            return;
        }
    }
    panic!("the step is twice the largest stable one");
}
