//! The same bits however a scene runs, what is remembered from one frame to the next, and bodies of every kind at once.

use super::{chain, newton, with};
use crate::common::alike::{self, PLAIN, SHAKEN};
use crate::common::compare::cloth;
use crate::common::state::stiffen;
use crate::common::{V, add, build, build_as, levels, norm, positions, run, sub};
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Ice, Mass, Mesh, Scene, Select, VolumeForm};

/// Bodies that move, one of them keeps its volume.
fn moving() -> Vec<Body> {
    let [sheet, ball, chain, free] = alike::moving();
    let mut all = vec![sheet, ball.keep_volume(VolumeForm::Corrected), chain, free];
    all.iter_mut().for_each(|body| stiffen(body, 300.0));
    all
}

/// Bodies of which there is little to solve: one without springs, one held as a whole, one free node, springs between
/// nodes two apart alone, which reach some or none, two nodes, a strip.
fn odd() -> Vec<Body> {
    let plain = |name: &str, mesh| Body::cloth(name, mesh).with_mass(Mass::Node(0.03));
    let apart = plain("apart", Mesh::grid(6, 7, [0.6, 0.5])).bend(500.0, 0.1);
    vec![
        plain("loose", Mesh::grid(4, 5, [0.4, 0.3])).at([0.0, 1.0, 8.0]),
        Body { name: "held".into(), ..cloth(4, 4, [0.3, 0.3]) }.pin(Select::rows(0, 3)).at([3.0, 1.0, 8.0]),
        Body { name: "one".into(), ..chain(1, 0.4, 0.03, [2e3, 0.1]) }
            .pin(Select::nodes([1]))
            .at([6.0, 1.0, 8.0]),
        apart.at([0.0, 1.0, 10.0]),
        plain("two apart", Mesh::grid(2, 2, [0.3, 0.3])).bend(5.0, 0.0).at([3.0, 1.0, 10.0]),
        Body { name: "pair".into(), ..chain(1, 0.4, 0.03, [2e3, 0.1]) }.at([6.0, 1.0, 10.0]),
        Body { name: "strip".into(), ..cloth(2, 33, [3.2, 0.1]) }
            .pin(Select::nodes([0]))
            .at([0.0, 1.0, 12.0]),
    ]
}

/// Loose and few iterations, so that what they start from shows.
fn scenes() -> [Scene; 3] {
    let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
    let of = |bodies: Vec<Body>, ice| {
        let scene = Scene::new("bits").time(0.01, 0.005).collider(floor.clone());
        with(Scene { bodies, ..scene }, ice)
    };
    let rough = Ice { max_iterations: 5, ..newton(1) };
    [
        of(moving(), rough.clone()),
        of(moving(), Ice { max_iterations: 3, warm_start: false, ..newton(2) }),
        of([moving(), odd()].concat(), newton(1)),
    ]
}

#[test]
fn any_number_of_threads_gives_the_same_bits_and_every_time() {
    SHAKEN.with_any_threads(&scenes(), |report| report.solver.iterations > 2 && report.contacts > 0);
}

#[test]
#[ignore = "run by the test of vector instructions, in processes of their own"]
fn prints_hashes() {
    SHAKEN.print_hashes(&scenes());
}

#[test]
fn any_vector_instructions_give_the_same_bits() {
    levels::assert_same("primal::bits::prints_hashes", 6);
}

#[test]
fn each_body_moves_as_if_it_were_alone_and_in_any_order() {
    PLAIN.alone_and_in_any_order(&scenes());
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    SHAKEN.restored(&scenes());
}

#[test]
fn the_last_change_of_velocities_is_remembered_and_nothing_else() {
    let both = alike::needs_no_more_than_the_state;
    let [warm, cold, _] = scenes();
    assert!(!both(&warm), "what iterations start from");
    assert!(!both(&cold), "what surfaces go by");
    assert!(both(&Scene { colliders: Vec::new(), ..cold }), "without both");
}

#[test]
fn what_has_nothing_to_solve_falls_or_stays() {
    let mut simulation =
        build(&with(Scene { bodies: odd(), ..Scene::new("odd").time(0.01, 0.005) }, newton(2)));
    let start = positions(&simulation);
    run(&mut simulation, 10);
    let x = positions(&simulation);
    // n steps of h: g h² n (n + 1)/2.
    let fall = 9.81 * 0.005 * 0.005 * 210.0;
    let mut from = 0;
    for body in simulation.bodies() {
        let falls = body.pinned == 0;
        // What hangs swings.
        let still = falls || body.pinned == body.nodes;
        for n in (from..from + body.vertices).filter(|_| still) {
            let expected = add(start[n], [0.0, if falls { -fall } else { 0.0 }, 0.0]);
            let apart = norm(sub(x[n], expected));
            assert!(apart < 1e-12, "{}: {apart:e} m", body.name);
        }
        from += body.vertices;
    }
    assert_eq!(from, x.len());
}

/// What a hand does: some frames in which a free node is taken and carried, then a node that was held is moved.
fn handled(threads: usize, stop: Option<u32>) -> (u64, Vec<V>) {
    let scene = scenes()[0].clone();
    let mut simulation = build_as(&scene, Precision::F64, threads);
    for frame in 0..8 {
        if stop == Some(frame) {
            let snapshot = simulation.snapshot();
            simulation = build_as(&scene, Precision::F64, threads);
            simulation.restore(&snapshot).unwrap();
        }
        if frame % 3 < 2 {
            let up = add([0.1, 2.0, 0.3], [0.0, 0.01 * f64::from(frame), 0.0]);
            simulation.pin_vertex(simulation.body("cloth").unwrap(), 250, up).unwrap();
        }
        if frame > 3 {
            let along = add(positions(&simulation)[504 + 642 + 150], [0.01, 0.0, 0.0]);
            simulation.pin_vertex(simulation.body("chain").unwrap(), 150, along).unwrap();
        }
        run(&mut simulation, 1);
    }
    (simulation.state_hash(), positions(&simulation))
}

#[test]
fn nodes_that_a_hand_takes_are_where_it_puts_them_and_what_hangs_on_them_follows() {
    let (hash, x) = handled(1, None);
    assert_eq!(x[250], add([0.1, 2.0, 0.3], [0.0, 0.07, 0.0]));
    for (threads, stop) in [(2, None), (3, None), (1, Some(5)), (2, Some(1))] {
        assert_eq!(handled(threads, stop).0, hash, "{threads} threads, stopped at {stop:?}");
    }
}
