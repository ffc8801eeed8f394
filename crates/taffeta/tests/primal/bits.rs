//! The same bits however a scene runs, what is remembered from one frame to the next, and bodies of every kind at once.

use super::common::compare::cloth;
use super::common::state::stiffen;
use super::common::{V, add, build, build_as, levels, norm, positions, run, sub, turned};
use super::{chain, newton, with};
use taffeta::scene::{
    Body, Collider, Ice, Icosphere, Internal, Keyframe, Mass, Mesh, Scene, Select, VolumeForm,
};
use taffeta::{Precision, Simulation};

/// A sheet that a moving pin pulls, a soft ball with struts that lands, a chain, and a sheet that nothing holds.
fn moving() -> Vec<Body> {
    let pull = vec![Keyframe::translate(0.05, [0.05, 0.1, -0.02])];
    let mut sheet = cloth(24, 21, [2.0, 2.3]).pin_moving(Select::nodes([0, 20]), pull);
    sheet.place = turned([1.0, 0.2, 0.0], 70.0, [0.0, 2.0, 0.0]);
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
    let mut ball =
        Body::soft("ball", mesh).with_mass(Mass::Node(0.02)).structural(90.0, 0.05).bend(30.0, 0.01);
    ball.springs.internal = Some(Internal { count: 200, k: 60.0, d: 0.05, ..Internal::default() });
    let free = Body { name: "free".into(), ..cloth(5, 130, [12.9, 0.4]) }.hinge(1e-3, 1e-5);
    let mut all = vec![
        sheet,
        ball.keep_volume(VolumeForm::Corrected).at([5.0, 0.49, 0.0]),
        chain(300, 30.0, 0.02, [90.0, 0.05]).at([0.0, 1.0, 4.0]).pin(Select::nodes([150])),
        free.at([0.0, 1.0, 6.0]),
    ];
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

fn start(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = build_as(scene, precision, threads);
    simulation.disturb(0.002, 11);
    simulation
}

fn ran(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let mut simulation = start(scene, precision, threads);
    run(&mut simulation, 4);
    simulation
}

#[test]
fn any_number_of_threads_gives_the_same_bits_and_every_time() {
    for scene in scenes() {
        for precision in [Precision::F32, Precision::F64] {
            let one = ran(&scene, precision, 1);
            let solver = &one.report().solver;
            assert!(solver.iterations > 2 && one.report().contacts > 0, "{solver:?}");
            for threads in [1, 2, 3, 8] {
                let many = ran(&scene, precision, threads);
                assert_eq!(one.state_hash(), many.state_hash(), "{:?}, {precision}, {threads}", scene.solver);
                assert_eq!(one.report(), many.report(), "{:?}, {precision}, {threads}", scene.solver);
            }
        }
    }
}

#[test]
#[ignore = "run by the test of vector instructions, in processes of their own"]
fn prints_hashes() {
    for scene in scenes() {
        for precision in [Precision::F32, Precision::F64] {
            println!("hash|{:?} {precision} {:016x}", scene.solver, ran(&scene, precision, 2).state_hash());
        }
    }
}

#[test]
fn any_vector_instructions_give_the_same_bits() {
    levels::assert_same("bits::prints_hashes", 6);
}

#[test]
fn each_body_moves_as_if_it_were_alone_and_in_any_order() {
    for scene in scenes() {
        let places = |bodies: &[Body], threads| {
            let mut simulation =
                build_as(&Scene { bodies: bodies.to_vec(), ..scene.clone() }, Precision::F32, threads);
            run(&mut simulation, 4);
            positions(&simulation)
        };
        let alone: Vec<_> = scene.bodies.iter().map(|body| places(std::slice::from_ref(body), 1)).collect();
        assert!(alone.concat() == places(&scene.bodies, 2), "{:?}", scene.solver);
        let turned: Vec<_> = scene.bodies.iter().rev().cloned().collect();
        let back: Vec<_> = alone.iter().rev().flatten().copied().collect();
        assert!(back == places(&turned, 2), "{:?}", scene.solver);
    }
}

#[test]
fn a_restored_simulation_goes_on_bit_by_bit() {
    for scene in scenes() {
        for precision in [Precision::F32, Precision::F64] {
            let mut whole = start(&scene, precision, 1);
            run(&mut whole, 2);
            let snapshot = whole.snapshot();
            run(&mut whole, 2);
            for threads in [1, 2] {
                let mut again = build_as(&scene, precision, threads);
                // It may have been elsewhere before.
                run(&mut again, threads as u32 - 1);
                again.restore(&snapshot).unwrap();
                assert_eq!(again.snapshot(), snapshot, "what is restored is what was taken");
                run(&mut again, 2);
                assert_eq!(again.state_hash(), whole.state_hash(), "{:?}, {precision}", scene.solver);
                assert_eq!(again.report(), whole.report(), "{:?}, {precision}", scene.solver);
            }
        }
    }
}

/// Goes on from places and velocities alone: what else is remembered is that of a simulation just built.
fn from_state_alone(scene: &Scene, of: &Simulation) -> Simulation {
    let mut again = build_as(scene, of.precision(), 1);
    let mut snapshot = again.snapshot();
    let taken = of.snapshot();
    (snapshot.state, snapshot.start, snapshot.report) = (taken.state, taken.start, taken.report);
    again.restore(&snapshot).unwrap();
    again
}

#[test]
fn the_last_change_of_velocities_is_remembered_and_nothing_else() {
    let both = |scene: &Scene| {
        let mut whole = start(scene, Precision::F64, 1);
        run(&mut whole, 2);
        let mut again = from_state_alone(scene, &whole);
        for simulation in [&mut whole, &mut again] {
            run(simulation, 2);
        }
        whole.state_hash() == again.state_hash()
    };
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
            simulation.move_pin("cloth", 250, up).unwrap();
        }
        if frame > 3 {
            let along = add(positions(&simulation)[504 + 642 + 150], [0.01, 0.0, 0.0]);
            simulation.move_pin("chain", 150, along).unwrap();
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
