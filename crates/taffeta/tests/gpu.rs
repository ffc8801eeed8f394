//! Whole scenes on the GPU against the same scenes on the CPU.

mod common;

use common::{build_as, farthest, positions, run};
use taffeta::scene::{Body, Collider, Force, Icosphere, Keyframe, Mass, Mesh, Scene, Select, Torque};
use taffeta::taffeta_gpu::{Choice, Gpu};
use taffeta::{GpuKernels, GpuOptions, Options, Precision, Simulation, Stage};

fn gpu() -> Gpu {
    Gpu::open(&Choice::from_env()).unwrap_or_else(|error| panic!("{error}"))
}

fn on_gpu(scene: &Scene) -> Simulation {
    let options = Options { gpu: Some(gpu().into()), ..Options::default() };
    Simulation::new(scene, &options).unwrap_or_else(|error| panic!("{}: {error}", scene.title))
}

fn flag() -> Scene {
    let sheet = Body::cloth("flag", Mesh::grid(20, 30, [1.5, 1.0]))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .shear(20.0, 0.02)
        .bend(5.0, 0.02)
        .pin(Select::nodes([0, 29]));
    Scene::new("flag").body(sheet).time(1.0 / 60.0, 1e-3)
}

#[test]
fn a_flag_is_the_same_on_both() {
    let scene = flag();
    let (mut a, mut b) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for _ in 0..20 {
        run(&mut a, 1);
        run(&mut b, 1);
    }
    assert_eq!(farthest(&positions(&a), &positions(&b)), 0.0);
    assert_eq!(a.state_hash(), b.state_hash());
}

#[test]
fn a_ball_on_a_slope_is_the_same_on_both() {
    let ball = Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 0.3, subdivisions: 2 }))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .hinge(1e-3, 1e-5)
        .at([0.0, 0.4, 0.0]);
    let scene = Scene::new("ball")
        .body(ball)
        .collider(Collider::plane([0.0; 3], [0.1, 1.0, 0.0]))
        .collider(Collider::sphere([0.2, 0.0, 0.0], 0.1))
        .time(1.0 / 60.0, 1e-3);
    let (mut a, mut b) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for _ in 0..20 {
        run(&mut a, 1);
        run(&mut b, 1);
    }
    assert_eq!(farthest(&positions(&a), &positions(&b)), 0.0);
}

#[test]
fn several_sub_steps_at_once_are_the_same_as_one_after_the_other() {
    let ball = Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 2 }))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .bend(20.0, 0.02)
        .at([0.0, 1.0, 0.0]);
    let sheet = flag().bodies.remove(0);
    let small = Scene::new("small")
        .body(Body { mesh: Mesh::grid(13, 17, [1.0, 1.0]), pins: Vec::new(), ..sheet.clone() })
        .body(ball)
        .collider(Collider::plane([0.0, -0.05, 0.0], [0.1, 1.0, 0.0]))
        .time(1.0 / 30.0, 5e-4);
    let wide = Body { mesh: Mesh::grid(61, 45, [2.0, 1.5]), ..sheet };
    let wide = Scene::new("wide")
        .body(wide)
        .collider(Collider::sphere([0.0, -0.4, 0.0], 0.3))
        .time(1.0 / 30.0, 1e-3);
    for (scene, kernels) in [(small, GpuKernels::Best), (wide, GpuKernels::Tiled)] {
        let options = GpuOptions { kernels, ..gpu().into() };
        let mut fused =
            Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
        let mut plain = build_as(&scene, Precision::F32, 1);
        run(&mut fused, 10);
        run(&mut plain, 10);
        assert!(plain.report().contacts > 0, "{}", scene.title);
        assert_eq!(fused.report().contacts, plain.report().contacts);
        assert_eq!(farthest(&positions(&fused), &positions(&plain)), 0.0, "{}", scene.title);
    }
}

fn push(body: &str, nodes: Vec<u32>) -> Force {
    Force {
        body: body.to_owned(),
        select: Select::nodes(nodes),
        force: None,
        torque: None,
        motion: Vec::new(),
    }
}

/// Every stage has something to do here.
fn everything() -> Scene {
    let ball = Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 2 }))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .bend(20.0, 0.02)
        .hinge(1e-3, 1e-5)
        .at([0.0, 0.3, 0.0]);
    let mut sheet = flag().bodies.remove(0).at([2.0, 0.05, 0.0]).hinge(1e-4, 1e-6);
    sheet = sheet.pin_moving(
        Select::cols(29, 29),
        vec![Keyframe::rotate(0.5, [1.0, 0.0, 0.0], 40.0, [2.0, 0.0, 0.0])],
    );
    let twist = Torque { axis: [0.0, 1.0, 0.0], value: 0.05, about: [0.0; 3] };
    let slope = Collider::plane([0.0, 0.0, 0.0], [0.05, 1.0, 0.0]).friction(0.4);
    let rising = Collider::sphere([0.1, -0.1, 0.0], 0.2).keyframe(Keyframe::translate(0.3, [0.0, 0.2, 0.0]));
    let mut scene = Scene::new("everything")
        .body(ball)
        .body(sheet)
        .force(Force { torque: Some(twist), ..push("ball", [3, 10, 40, 77].into()) })
        .force(Force { force: Some([0.0, 0.5, 0.1]), ..push("flag", [310, 311].into()) })
        .collider(slope)
        .collider(rising)
        .time(1.0 / 60.0, 1e-3);
    scene.world.drag = 1e-3;
    scene.world.wind_force = [0.0, 0.0, 1e-2];
    scene
}

#[test]
fn wherever_the_gpu_takes_over_the_scene_goes_on_as_on_the_cpu() {
    let scene = everything();
    let mut cpu = build_as(&scene, Precision::F32, 1);
    run(&mut cpu, 6);
    assert!(cpu.report().contacts > 0);
    for from in Stage::ALL {
        let options = GpuOptions { from, ..gpu().into() };
        let mut both =
            Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
        run(&mut both, 6);
        assert_eq!(farthest(&positions(&cpu), &positions(&both)), 0.0, "{}", from.name());
        assert_eq!(both.report().contacts, cpu.report().contacts, "{}", from.name());
    }
}

#[test]
fn normals_are_the_same_on_both_also_after_a_frame_and_a_move() {
    let scene = everything();
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for simulation in [&mut cpu, &mut on_gpu] {
        run(simulation, 3);
        simulation.disturb(1e-2, 7);
    }
    assert_eq!(farthest(&positions(&cpu), &positions(&on_gpu)), 0.0);
    for body in 0..2 {
        assert!(cpu.normals(body) == on_gpu.normals(body), "body {body}");
        assert!(cpu.normals(body).iter().any(|normal| normal[0] != 0.0));
    }
}
