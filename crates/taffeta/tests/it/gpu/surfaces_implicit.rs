//! Contacts of surfaces that are part of an implicit step, on the GPU against the same on the CPU. Both take iterations of their own
//! on the way to the same velocities: places agree as far as the solver's tolerance goes, and as the contacts that follow allow.

use super::surfaces::{crossed, heap, pushed, sheet, touch};
use super::{on_gpu, small_gpu};
use crate::common::{add, build_as, farthest, near, norm, positions, run, sub, turned};
use crate::pairs::{set_velocities, velocities};
use taffeta::scene::{Body, ConstraintForm, Mass, Material, Method, Scene, Select};
use taffeta::{GpuOptions, Options, Precision, Simulation};

/// A scene whose springs are solved for by nodes, with such steps.
fn by_nodes(scene: Scene, step: f64) -> Scene {
    let mut scene = scene.time(1.0 / 60.0, step).method(Method::Ice);
    scene.solver.ice.form = ConstraintForm::Primal;
    scene.solver.ice.tolerance = 1e-6;
    scene
}

/// Runs both, and compares places after each frame; gives the most contacts of one.
fn are_near(scene: &Scene, frames: u32, apart: f64) -> (u64, [Simulation; 2]) {
    let (mut cpu, mut gpu) = (build_as(scene, Precision::F32, 1), on_gpu(scene));
    let mut most = 0;
    for frame in 1..=frames {
        run(&mut cpu, 1);
        run(&mut gpu, 1);
        let way = farthest(&positions(&cpu), &positions(&gpu));
        let [of_cpu, of_gpu] = [&cpu, &gpu].map(Simulation::report);
        println!("{} {frame}: {way:e} m, {:?} {:?}", scene.title, of_cpu.solver, of_gpu.solver);
        assert!(way < apart, "{}, frame {frame}: {way:e} m apart", scene.title);
        assert!(of_cpu.pairs.abs_diff(of_gpu.pairs) <= 10 + of_cpu.pairs / 10, "{of_cpu:?} {of_gpu:?}");
        assert_eq!(of_gpu.solver.capped, 0);
        most = most.max(of_gpu.pairs);
    }
    (most, [cpu, gpu])
}

fn fabric(name: &str, count: u32, side: f64, preset: &str) -> Body {
    touch(Body::cloth(name, sheet(count, side)).with_material(Material::preset(preset)), 0.004)
}

#[test]
fn springs_in_contact_are_solved_for_as_on_the_cpu() {
    let (most, [_, gpu]) = are_near(&by_nodes(heap(), 1.0 / 240.0), 7, 2e-4);
    assert!(most > 150 && gpu.intersections().pairs == 0, "{most}");
}

/// Fabrics one on the other, which a box that turns lifts, and one that touches nobody.
#[test]
fn fabrics_in_contact_are_solved_for_as_on_the_cpu() {
    // Turned, so that no edges lie exactly on others: rounding would decide which pairs count.
    let mut loose = fabric("loose", 11, 0.15, "jersey");
    loose.place = turned([0.1, 1.0, 0.0], 17.0, [0.0, 0.011, 0.01]);
    let mut scene = Scene::new("fabrics")
        .body(fabric("held", 9, 0.2, "cotton").pin(Select::cols(0, 0)).pin(Select::cols(8, 8)))
        .body(loose)
        .body(fabric("apart", 7, 0.1, "silk").at([1.0, 0.0, 0.0]));
    scene.colliders = vec![pushed().colliders[0].clone()];
    for newton_steps in [0, 2] {
        let mut scene = by_nodes(scene.clone(), 1.0 / 240.0);
        scene.solver.ice.max_iterations = 600;
        scene.solver.ice.newton_steps = newton_steps;
        let (most, [_, gpu]) = are_near(&scene, 3, 1e-3);
        assert!(most > 100 && gpu.intersections().pairs == 0, "{most}");
    }
}

#[test]
fn fabrics_that_start_through_each_other_come_apart() {
    let tilted = crossed().bodies[1].place.clone();
    let over = Body { place: tilted, ..fabric("over", 11, 0.25, "cotton") };
    let under = fabric("under", 9, 0.3, "denim").pin(Select::cols(0, 0)).pin(Select::cols(8, 8));
    let mut gpu = on_gpu(&by_nodes(Scene::new("crossed").body(under).body(over), 1.0 / 240.0));
    assert!(gpu.intersections().pairs > 20);
    let is_free = |simulation: &mut Simulation| {
        run(simulation, 1);
        simulation.intersections().pairs == 0
    };
    assert!((0..60).any(|_| is_free(&mut gpu)), "{} are left", gpu.intersections().pairs);
    assert!(is_free(&mut gpu) && gpu.report().max_stretch < 1.6, "{:?}", gpu.report());
}

/// Σ m v of all nodes of 1 kg each.
fn momentum(simulation: &Simulation) -> [f64; 3] {
    velocities(simulation).into_iter().fold([0.0; 3], add)
}

/// Sheets without weight that fly at each other, and one that waits.
fn impact() -> (Scene, impl Fn(&mut Simulation)) {
    let cloth = |name: &str, count, at| {
        let body = Body::cloth(name, sheet(count, 0.3)).with_mass(Mass::Node(1.0));
        touch(body.structural(2e4, 10.0).shear(1e4, 5.0), 0.01).at(at)
    };
    let mut scene = Scene::new("impact")
        .body(cloth("waits", 7, [0.0, 0.0, 3.0]))
        .body(cloth("low", 8, [0.0; 3]))
        .body(cloth("high", 9, [0.02, 0.016, 0.03]));
    scene.world.gravity = [0.0; 3];
    let throw = |simulation: &mut Simulation| {
        let v = (0..49 + 64 + 81).map(|node| match node {
            0..49 => [0.0, 0.1 * f64::from(node % 7), 0.0],
            49..113 => [0.1, 0.3, 0.0],
            _ => [0.0, -0.4, 0.1],
        });
        set_velocities(simulation, &v.collect::<Vec<_>>());
    };
    (by_nodes(scene, 1.0 / 240.0), throw)
}

#[test]
fn impacts_keep_momentum() {
    let (scene, throw) = impact();
    let mut gpu = on_gpu(&scene);
    throw(&mut gpu);
    let energy: f64 = velocities(&gpu).into_iter().map(|v| 0.5 * norm(v).powi(2)).sum();
    let before = momentum(&gpu);
    let mut most = 0;
    for _ in 0..6 {
        run(&mut gpu, 1);
        most = most.max(gpu.report().pairs);
        let lost = norm(sub(momentum(&gpu), before));
        assert!(lost < 2e-5 * norm(before), "{lost:e} of {before:?}");
    }
    let report = gpu.report();
    assert!(most > 30 && report.kinetic + report.springs < energy, "{most}: {energy} {report:?}");
}

/// Bodies that touch share a system; one that touches nobody has its own, whatever the others need.
#[test]
fn who_touches_nobody_moves_as_if_alone() {
    let (scene, throw) = impact();
    let mut apart = scene.clone();
    apart.bodies[2].place.position[1] += 2.0;
    let [mut together, mut alone] = [&scene, &apart].map(on_gpu);
    throw(&mut together);
    throw(&mut alone);
    run(&mut together, 3);
    run(&mut alone, 3);
    assert!(together.report().pairs > 10 && alone.report().pairs == 0, "{:?}", together.report());
    assert_eq!(positions(&together)[..49], positions(&alone)[..49]);
}

/// A sheet of 5 kg lies on one that is held, as on the CPU: still, and what pins carry is the weight of both.
#[test]
fn what_lies_in_a_hammock_rests_there() {
    let cloth = |name: &str, count, mass| {
        let body = Body::cloth(name, sheet(count, 0.3)).with_mass(Mass::Whole(mass));
        touch(body.structural(4e4, 20.0).shear(2e4, 10.0), 0.008)
    };
    let held = cloth("held", 9, 0.5).pin(Select::cols(0, 0)).pin(Select::cols(8, 8));
    let lies = cloth("lies", 7, 5.0).at([0.0, 0.012, 0.0]);
    let scene = by_nodes(Scene::new("hammock").body(held).body(lies), 1.0 / 120.0);
    let mut gpu = on_gpu(&scene);
    run(&mut gpu, 50);
    let report = gpu.report();
    assert!(report.kinetic < 1e-3 && report.pairs > 30 && report.max_stretch < 1.1, "{report:?}");
    let carried = report.reactions.iter().filter_map(|one| one.force).fold([0.0; 3], add);
    near("weight", carried[1], 5.5 * 9.81, 0.01 * 5.5 * 9.81);
    assert_eq!(gpu.intersections().pairs, 0);
}

#[test]
fn a_run_repeats_itself_and_goes_on_from_a_snapshot() {
    let scene = by_nodes(heap(), 1.0 / 240.0);
    let [mut whole, mut again] = [0; 2].map(|_| on_gpu(&scene));
    run(&mut whole, 6);
    let snapshot = whole.snapshot();
    assert!(snapshot.contacts > 50, "{}", snapshot.contacts);
    run(&mut whole, 2);
    again.restore(&snapshot).expect("it fits");
    run(&mut again, 2);
    assert_eq!(whole.state_hash(), again.state_hash());
    let mut cpu = build_as(&scene, Precision::F32, 1);
    cpu.restore(&snapshot).expect("it fits");
    run(&mut cpu, 2);
    let way = farthest(&positions(&whole), &positions(&cpu));
    assert!(way < 2e-4, "{way:e} m apart");
}

/// A body that is not solved for has no part in any system, wherever it stands among the others; nor have bodies on which nothing acts
/// but their own springs, in pieces of memory of their own.
#[test]
fn bodies_without_contact_or_springs_stand_beside_it() {
    let held = (0..81).collect::<Vec<_>>();
    let wall = touch(Body::cloth("wall", sheet(9, 0.3)).with_mass(Mass::Node(0.01)), 0.008);
    let falls = fabric("falls", 15, 0.2, "cotton");
    let scene = by_nodes(
        Scene::new("beside")
            .body(Body { place: turned([0.1, 1.0, 0.05], 17.0, [0.0, 0.02, 0.0]), ..falls })
            .body(wall.pin(Select::nodes(held))),
        1.0 / 120.0,
    );
    let (most, [_, gpu]) = are_near(&scene, 4, 2e-4);
    assert!(most > 30 && gpu.intersections().pairs == 0, "{most}");
    let alone = Body::cloth("alone", sheet(100, 1.0)).with_mass(Mass::Node(1e-3)).structural(50.0, 0.01);
    let scene = scene.body(alone.at([2.0, 0.0, 0.0]));
    let options = GpuOptions::from(small_gpu(3_400_000));
    let mut split = Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
    let mut whole = on_gpu(&scene);
    run(&mut split, 3);
    run(&mut whole, 3);
    assert!(split.report().pairs > 30, "{:?}", split.report());
    let way = farthest(&positions(&split), &positions(&whole));
    assert!(way < 2e-4, "{way:e} m apart");
}
