//! Scenes whose springs are solved for by nodes, on the GPU against the same on the CPU. Both take steps of their own on the
//! way to the same velocities, so that places agree as far as the solver's tolerance goes.

use super::constraints::{compare, drop, hung, precise};
use super::pairs::heap;
use super::{everything, on_gpu, small_gpu, volumes};
use crate::common::{build_as, farthest, gpu, positions, run};
use taffeta::scene::{Body, ConstraintForm, Icosphere, Mass, Mesh, Method, Scene, Select};
use taffeta::{GpuOptions, Options, Precision, Simulation, Stage};

/// A scene whose springs are solved for by nodes.
fn by_nodes(mut scene: Scene) -> Scene {
    scene.solver.method = Method::Ice;
    scene.solver.ice.form = ConstraintForm::Primal;
    precise(scene)
}

/// The same at second order in time.
fn second(scene: Scene) -> Scene {
    let mut scene = by_nodes(scene);
    scene.solver.ice.order = 2;
    scene
}

#[test]
fn at_second_order_sheets_fall_and_hang_as_on_the_cpu() {
    for scene in [second(drop(Method::Ice)), second(hung(Method::Ice)), second(everything_but_volumes())] {
        let [cpu, gpu] = compare(&scene, 6, 1e-5).map(|simulation| simulation.report().solver);
        assert!(gpu.iterations > 3 && gpu.iterations.abs_diff(cpu.iterations) < 10, "{cpu:?} {gpu:?}");
    }
}

fn everything_but_volumes() -> Scene {
    let mut scene = everything();
    scene.bodies.iter_mut().for_each(|body| body.volume = None);
    scene
}

#[test]
fn accelerations_are_part_of_what_is_restored() {
    let scene = second(hung(Method::Ice));
    let (mut whole, mut first, mut again, mut cpu) =
        (on_gpu(&scene), on_gpu(&scene), on_gpu(&scene), build_as(&scene, Precision::F32, 1));
    run(&mut whole, 5);
    run(&mut first, 3);
    let snapshot = first.snapshot();
    again.restore(&snapshot).unwrap();
    assert_eq!(again.snapshot(), snapshot);
    run(&mut again, 2);
    assert_eq!(whole.state_hash(), again.state_hash());
    cpu.restore(&snapshot).unwrap();
    run(&mut cpu, 2);
    let way = farthest(&positions(&whole), &positions(&cpu));
    assert!(way < 1e-4, "{way:e} m apart");
}

#[test]
fn a_sheet_falls_as_on_the_cpu() {
    let scene = by_nodes(drop(Method::Ice));
    let [cpu, gpu] = compare(&scene, 14, 1e-5).map(|simulation| simulation.report().solver);
    assert!(gpu.iterations > 3 && gpu.iterations.abs_diff(cpu.iterations) < 10, "{cpu:?} {gpu:?}");
    assert_eq!((gpu.active_fraction, gpu.capped), (1.0, 0));
}

#[test]
fn a_sheet_that_hangs_on_moving_pins_is_that_of_the_cpu() {
    let scene = by_nodes(hung(Method::Ice));
    let [cpu, gpu] = compare(&scene, 6, 2e-6).map(|simulation| simulation.report().solver);
    assert!(gpu.iterations > 3 && gpu.iterations.abs_diff(cpu.iterations) < 10, "{cpu:?} {gpu:?}");
}

/// One body has springs and hinges, one hinges alone, one springs alone.
#[test]
fn hinges_are_solved_for_as_on_the_cpu() {
    let ball = |name: &str, at: f64| {
        let mesh = Mesh::Icosphere(Icosphere { radius: 0.3, subdivisions: 3 });
        Body::cloth(name, mesh).with_mass(Mass::Whole(0.3)).pin(Select::nodes([0, 7])).at([at, 0.0, 0.0])
    };
    let scene = Scene::new("hinges")
        .time(1.0 / 60.0, 1.0 / 120.0)
        .body(ball("both", 0.0).structural(2e3, 0.1).hinge(0.05, 1e-4))
        .body(ball("bent", 1.0).hinge(0.5, 1e-3))
        .body(ball("plain", 2.0).structural(2e3, 0.1));
    let [cpu, gpu] = compare(&by_nodes(scene), 3, 1e-5).map(|simulation| simulation.report().clone());
    assert!(cpu.energy_of("hinges") > 1e-6 && gpu.solver.iterations > 3, "{cpu:?}");
    let apart = (gpu.energy_of("hinges") - cpu.energy_of("hinges")).abs();
    assert!(apart < 1e-3 * cpu.energy_of("hinges"), "{apart:e} J apart");
}

#[test]
fn newton_steps_are_those_of_the_cpu() {
    let mut scene = by_nodes(drop(Method::Ice));
    scene.solver.ice.newton_steps = 3;
    compare(&scene, 12, 2e-5);
}

/// A flag that starts flat needs many of them, a sheet beside it one.
#[test]
fn newton_steps_are_as_many_as_a_body_needs_as_on_the_cpu() {
    let flag = Body::cloth("flag", Mesh::grid(20, 30, [1.5, 1.0])).with_mass(Mass::Node(5e-4));
    let calm = Body::cloth("calm", Mesh::grid(12, 10, [0.5, 0.5])).with_mass(Mass::Node(0.01));
    let scene = Scene::new("flags")
        .time(1.0 / 60.0, 1.0 / 60.0)
        .body(flag.structural(1e5, 0.1).shear(1e5, 0.1).bend(1e5, 0.1).pin(Select::nodes([0, 570])))
        .body(calm.structural(1e3, 0.1).shear(1e3, 0.1).pin(Select::rows(0, 0)).at([3.0, 0.0, 0.0]));
    let one = |mut scene: Scene| {
        scene.solver.ice.newton_steps = 1;
        scene
    };
    let [cpu, gpu] = compare(&by_nodes(scene.clone()), 3, 1e-4);
    let mut once = build_as(&one(by_nodes(scene)), Precision::F32, 1);
    run(&mut once, 3);
    let way = farthest(&positions(&gpu)[..600], &positions(&once)[..600]);
    assert!(way > 2e-3, "one step goes elsewhere: {way:e} m");
    let [cpu, gpu, once] = [cpu, gpu, once].map(|simulation| simulation.report().solver.iterations);
    assert!(cpu.abs_diff(gpu) < 10 && gpu > 3 * once / 2, "{cpu} {gpu} {once}");
}

#[test]
fn bodies_of_all_sorts_have_systems_of_their_own() {
    compare(&by_nodes(everything()), 6, 1e-5);
}

#[test]
fn volumes_are_kept_beside_springs_by_nodes() {
    compare(&by_nodes(volumes()), 5, 1e-5);
}

#[test]
fn nodes_touch_each_other_beside_springs_by_nodes() {
    let [cpu, gpu] = compare(&by_nodes(heap()), 4, 1e-5).map(|simulation| simulation.report().clone());
    assert!(gpu.pairs > 30, "{}", gpu.pairs);
    assert_eq!((cpu.pairs, cpu.contacts), (gpu.pairs, gpu.contacts));
}

/// Levels that more than a workgroup shares, sums over more groups than a workgroup has lanes.
#[test]
fn a_large_sheet_is_one_system() {
    let sheet = Body::cloth("sheet", Mesh::grid(280, 240, [2.4, 2.0]))
        .with_mass(Mass::Node(1e-3))
        .structural(400.0, 0.01)
        .shear(200.0, 0.01)
        .bend(100.0, 0.01)
        .pin(Select::rows(0, 0));
    let scene = by_nodes(Scene::new("large").body(sheet).time(4e-3, 2e-3));
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 2), on_gpu(&scene));
    for simulation in [&mut cpu, &mut on_gpu] {
        simulation.disturb(1e-3, 7);
        run(simulation, 1);
    }
    let way = farthest(&positions(&cpu), &positions(&on_gpu));
    let (a, b) = (cpu.report().solver, on_gpu.report().solver);
    assert!(way < 2e-6 && b.iterations > 3 && b.capped == 0, "{way:e} m, {a:?} {b:?}");
}

#[test]
fn the_programs_hand_acts_beside_springs_by_nodes() {
    let scene = by_nodes(hung(Method::Ice));
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for simulation in [&mut cpu, &mut on_gpu] {
        run(simulation, 2);
        simulation.pin_vertex(simulation.body("sheet").unwrap(), 0, [-1.1, 0.1, -0.9]).unwrap();
        simulation.pin_vertex(simulation.body("sheet").unwrap(), 700, [0.1, 0.2, 0.2]).unwrap();
        simulation.apply_force(simulation.body("sheet").unwrap(), 1155, [1.0, 2.0, -0.5]).unwrap();
        run(simulation, 3);
    }
    let way = farthest(&positions(&cpu), &positions(&on_gpu));
    assert!(way < 1e-5, "{way:e} m apart");
    assert_eq!(positions(&on_gpu)[700].map(|c| c as f32), [0.1, 0.2, 0.2]);
}

#[test]
fn the_same_bits_come_out_twice_and_in_one_go() {
    let scene = by_nodes(drop(Method::Ice));
    let [mut one, mut again, mut at_once] = [0; 3].map(|_| on_gpu(&scene));
    run(&mut one, 10);
    run(&mut again, 10);
    at_once.advance(10).unwrap();
    assert_eq!(one.state_hash(), again.state_hash());
    assert_eq!((one.state_hash(), one.report()), (at_once.state_hash(), at_once.report()));
}

#[test]
fn a_restored_simulation_goes_on_with_the_changes_that_it_had() {
    let scene = by_nodes(hung(Method::Ice));
    let (mut whole, mut first, mut again, mut cpu) =
        (on_gpu(&scene), on_gpu(&scene), on_gpu(&scene), build_as(&scene, Precision::F32, 1));
    run(&mut whole, 5);
    run(&mut first, 3);
    let snapshot = first.snapshot();
    again.restore(&snapshot).unwrap();
    assert_eq!(again.snapshot(), snapshot);
    run(&mut again, 2);
    assert_eq!(whole.state_hash(), again.state_hash());
    // The other backend takes it up too.
    cpu.restore(&snapshot).unwrap();
    run(&mut cpu, 2);
    let way = farthest(&positions(&whole), &positions(&cpu));
    assert!(way < 1e-4, "{way:e} m apart");
}

/// After thirty frames no more iterations are written down than they needed; a frame that needs more is repeated.
#[test]
fn no_bits_depend_on_how_many_iterations_are_written_down() {
    let mut scene = by_nodes(hung(Method::Ice));
    scene.bodies[0].mesh = Mesh::grid(16, 16, [2.0, 2.0]);
    scene.bodies[0].pins.clear();
    let mut scene = scene.body(Body { name: "pinned".to_owned(), ..hung(Method::Ice).bodies.remove(0) });
    scene.bodies[1].mesh = Mesh::grid(34, 34, [2.0, 2.0]);
    let (mut whole, mut again) = (on_gpu(&scene), on_gpu(&scene));
    run(&mut whole, 31);
    // It starts with what any scene starts with.
    again.restore(&whole.snapshot()).unwrap();
    // Frames in which nothing is solved for ask for nothing.
    (0..31).for_each(|_| whole.disturb(0.0, 1));
    for simulation in [&mut whole, &mut again] {
        simulation.disturb(0.3, 3);
        run(simulation, 1);
        assert!(simulation.report().solver.iterations > 48, "{:?}", simulation.report().solver);
    }
    assert_eq!(whole.state_hash(), again.state_hash());
}

/// Where the first stages are the CPU's no frame is repeated: all iterations are written down.
#[test]
fn a_gpu_takes_over_before_springs_are_solved_for() {
    let scene = by_nodes(hung(Method::Ice));
    let mut whole = on_gpu(&scene);
    whole.disturb(0.05, 3);
    run(&mut whole, 1);
    assert!(whole.report().solver.iterations > 48, "{:?}", whole.report().solver);
    let options = GpuOptions { from: Stage::Springs, ..gpu().into() };
    let mut later = Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
    later.disturb(0.05, 3);
    run(&mut later, 1);
    assert_eq!(whole.state_hash(), later.state_hash());
}

#[test]
fn iterations_that_are_not_enough_are_counted() {
    let mut scene = by_nodes(drop(Method::Ice).time(0.016, 0.004));
    scene.solver.ice.max_iterations = 2;
    let mut simulation = on_gpu(&scene);
    run(&mut simulation, 10);
    let solver = simulation.report().solver;
    assert_eq!((solver.iterations, solver.capped), (2, 4));
    assert!(solver.residual > 1e-6, "{solver:?}");
}

#[test]
fn scenes_are_split_by_bodies() {
    let scene = by_nodes(everything());
    let mut whole = on_gpu(&scene);
    let options = GpuOptions::from(small_gpu(800_000));
    let mut split = Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
    run(&mut whole, 2);
    run(&mut split, 2);
    assert_eq!(whole.state_hash(), split.state_hash());
}
