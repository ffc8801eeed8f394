//! Scenes whose springs are constraints, on the GPU against the same on the CPU. Both take steps of their own on the way to
//! the same pulls, so that places agree as far as the solver's tolerance goes.

use super::pairs::heap;
use super::{everything, on_gpu, small_gpu, volumes};
use crate::common::{build_as, farthest, gpu, positions, run};
use taffeta::scene::{Body, Collider, ConstraintForm, Keyframe, Mass, Mesh, Method, Scene, Select};
use taffeta::{GpuOptions, Options, Precision, Simulation, Stage};

/// A sheet falls on a ball at steps of 16 ms.
pub fn drop(method: Method) -> Scene {
    let sheet = Body::cloth("sheet", Mesh::grid(34, 34, [2.0, 2.0]))
        .with_mass(Mass::Node(0.15))
        .structural(200.0, 0.1)
        .shear(200.0, 0.1)
        .bend(200.0, 0.1)
        .at([0.0, 0.55, 0.0]);
    let ball = Collider::sphere([0.0; 3], 0.5).offset(0.01).friction(0.3);
    precise(Scene::new("drop").body(sheet).collider(ball).time(0.016, 0.016).method(method))
}

/// The same with so small a tolerance that backends agree.
pub fn precise(mut scene: Scene) -> Scene {
    scene.solver.ice.tolerance = 1e-6;
    scene
}

/// Runs both, and compares places after each frame.
pub fn compare(scene: &Scene, frames: u32, apart: f64) -> [Simulation; 2] {
    let (mut cpu, mut on_gpu) = (build_as(scene, Precision::F32, 1), on_gpu(scene));
    for frame in 1..=frames {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        let way = farthest(&positions(&cpu), &positions(&on_gpu));
        println!(
            "{} {frame}: {way:e} m, {:?} {:?}",
            scene.title,
            cpu.report().solver,
            on_gpu.report().solver
        );
        assert!(way < apart, "{}, frame {frame}: {way:e} m apart", scene.title);
    }
    [cpu, on_gpu]
}

/// A sheet that hangs by two corners, one of which moves, and sways in the wind.
pub fn hung(method: Method) -> Scene {
    let lift = vec![Keyframe::translate(0.4, [0.2, 0.3, -0.1])];
    let sheet = Body::cloth("sheet", Mesh::grid(34, 34, [2.0, 2.0]))
        .with_mass(Mass::Node(0.01))
        .structural(400.0, 0.02)
        .shear(300.0, 0.02)
        .bend(100.0, 0.02)
        .pin(Select::nodes([0]))
        .pin_moving(Select::nodes([33]), lift);
    let mut scene = precise(Scene::new("hung").body(sheet).time(0.016, 0.008).method(method));
    scene.world.wind_force = [0.01, 0.0, 0.02];
    scene
}

#[test]
fn a_sheet_that_hangs_on_moving_pins_is_that_of_the_cpu() {
    for (method, apart) in [(Method::Ice, 2e-6), (Method::Acad, 1e-4)] {
        let [cpu, gpu] = compare(&hung(method), 6, apart).map(|simulation| simulation.report().solver);
        assert!(gpu.iterations > 3 && gpu.iterations.abs_diff(cpu.iterations) < 10, "{cpu:?} {gpu:?}");
        assert_eq!((gpu.active_fraction as f32, gpu.capped), (cpu.active_fraction as f32, 0));
    }
}

#[test]
fn a_sheet_of_constraints_falls_as_on_the_cpu() {
    let [cpu, gpu] = compare(&drop(Method::Ice), 14, 1e-5).map(|simulation| simulation.report().solver);
    assert!(gpu.iterations > 3 && gpu.iterations.abs_diff(cpu.iterations) < 10, "{cpu:?} {gpu:?}");
    assert_eq!((gpu.active_fraction, gpu.capped), (1.0, 0));
}

#[test]
fn springs_that_are_too_long_become_constraints_as_on_the_cpu() {
    let [cpu, gpu] = compare(&drop(Method::Acad), 13, 3e-4).map(|simulation| simulation.report().solver);
    assert!(gpu.active_fraction > 0.01 && gpu.active_fraction < 1.0, "{gpu:?}");
    assert_eq!(gpu.active_fraction as f32, cpu.active_fraction as f32);
}

#[test]
fn bodies_of_all_sorts_have_systems_of_their_own() {
    // A spring that is a hair too long on one side alone ends what can be compared.
    for (method, frames) in [(Method::Ice, 6), (Method::Acad, 2)] {
        let mut scene = precise(everything().method(method));
        scene.solver.acad.threshold = 0.005;
        compare(&scene, frames, 1e-5);
    }
}

#[test]
fn volumes_are_kept_beside_constraints() {
    for (method, frames) in [(Method::Ice, 5), (Method::Acad, 2)] {
        let mut scene = precise(volumes().method(method));
        scene.solver.acad.threshold = 0.005;
        compare(&scene, frames, 1e-5);
    }
}

#[test]
fn nodes_touch_each_other_beside_constraints() {
    let scene = precise(heap().method(Method::Ice));
    let [cpu, gpu] = compare(&scene, 4, 1e-5).map(|simulation| simulation.report().clone());
    assert!(gpu.pairs > 30, "{}", gpu.pairs);
    assert_eq!((cpu.pairs, cpu.contacts), (gpu.pairs, gpu.contacts));
}

/// Sums over more groups than a workgroup has lanes.
#[test]
fn a_large_sheet_is_one_system() {
    let sheet = Body::cloth("sheet", Mesh::grid(220, 210, [2.0, 2.0]))
        .with_mass(Mass::Node(1e-3))
        .structural(40.0, 0.01)
        .shear(20.0, 0.01)
        .bend(10.0, 0.01)
        .pin(Select::rows(0, 0));
    let scene = precise(Scene::new("large").body(sheet).time(4e-3, 2e-3).method(Method::Ice));
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
fn the_programs_hand_acts_beside_constraints() {
    let scene = hung(Method::Ice);
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
fn printed_forms_run_as_on_the_cpu() {
    for method in [Method::Ice, Method::Acad] {
        let mut scene = drop(method);
        scene.solver.ice.form = ConstraintForm::Printed;
        scene.solver.acad.form = ConstraintForm::Printed;
        scene.solver.ice.max_iterations = 6;
        compare(&scene, 3, 1e-3);
    }
}

#[test]
fn the_same_bits_come_out_twice_and_in_one_go() {
    for method in [Method::Ice, Method::Acad] {
        let scene = drop(method);
        let [mut one, mut again, mut at_once] = [0; 3].map(|_| on_gpu(&scene));
        run(&mut one, 10);
        run(&mut again, 10);
        at_once.advance(10).unwrap();
        assert_eq!(one.state_hash(), again.state_hash());
        assert_eq!((one.state_hash(), one.report()), (at_once.state_hash(), at_once.report()));
    }
}

#[test]
fn a_restored_simulation_goes_on_with_the_pulls_that_it_had() {
    for method in [Method::Ice, Method::Acad] {
        let scene = hung(method);
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
}

#[test]
fn iterations_that_are_not_enough_are_counted() {
    let mut scene = drop(Method::Ice).time(0.016, 0.004);
    scene.solver.ice.max_iterations = 2;
    let mut simulation = on_gpu(&scene);
    run(&mut simulation, 10);
    let solver = simulation.report().solver;
    assert_eq!((solver.iterations, solver.capped), (2, 4));
    assert!(solver.residual > 1e-6, "{solver:?}");
}

#[test]
fn scenes_are_split_by_bodies() {
    for method in [Method::Ice, Method::Acad] {
        let mut scene = precise(everything().method(method));
        scene.solver.acad.threshold = 0.005;
        let mut whole = on_gpu(&scene);
        let options = GpuOptions::from(small_gpu(110_000));
        let mut split =
            Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
        run(&mut whole, 2);
        run(&mut split, 2);
        assert_eq!(whole.state_hash(), split.state_hash());
    }
}

fn start(scene: &Scene, from: Stage) -> Result<Simulation, String> {
    let options = GpuOptions { from, ..gpu().into() };
    let options = Options { gpu: Some(options), ..Options::default() };
    Simulation::new(scene, &options).map_err(|error| error.to_string())
}

#[test]
fn a_gpu_takes_over_before_pulls_are_found() {
    let mut scene = precise(everything().method(Method::Acad));
    scene.solver.acad.threshold = 0.005;
    let mut whole = on_gpu(&scene);
    run(&mut whole, 1);
    for from in Stage::ALL {
        match start(&scene, from) {
            Ok(mut both) => {
                assert!(from <= Stage::Constraints);
                run(&mut both, 1);
                let way = farthest(&positions(&whole), &positions(&both));
                assert!(way < 1e-5, "{}: {way:e} m apart", from.name());
            }
            Err(words) => {
                assert!(from > Stage::Constraints);
                assert!(words.contains("the method is \"acad\"") && words.contains(from.name()), "{words}");
            }
        }
    }
}

#[test]
fn a_timed_frame_names_the_stage_of_constraints() {
    let mut timed = on_gpu(&drop(Method::Ice));
    let times = timed.step_timed().unwrap();
    let names: Vec<&str> = times.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["loads", "constraints", "integrate", "contact", "diagnose"]);
}
