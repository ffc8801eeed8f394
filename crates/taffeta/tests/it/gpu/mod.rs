//! Whole scenes on the GPU against the same scenes on the CPU.

mod air;
mod attach;
mod colliders;
mod constraints;
mod drawn;
mod pairs;
mod primal;
mod surfaces;
mod surfaces_implicit;

use crate::common::{build_as, farthest, gpu, near, normals, own_gpu, positions, run};
use crate::halted::{burst, bursting};
use taffeta::scene::{
    Body, Collider, Force, Icosphere, Internal, Keyframe, Mass, Mesh, Scene, Select, Torque, UvSphere,
    Volume, VolumeForm, VolumeKey, VolumeWeights,
};
use taffeta::taffeta_gpu::{Gpu, wgpu};
use taffeta::{Advice, GpuKernels, GpuOptions, Options, Precision, Simulation, Stage, StepError};

/// A sub-step [s] as long as springs here bear: on a software device each takes as much time, whatever its length.
const STEP: f64 = 1.0 / 240.0;

pub fn on_gpu(scene: &Scene) -> Simulation {
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
    Scene::new("flag").body(sheet).time(1.0 / 60.0, STEP)
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
        .time(1.0 / 60.0, STEP);
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
        .time(1.0 / 30.0, STEP / 2.0);
    let wide = Body { mesh: Mesh::grid(61, 45, [2.0, 1.5]), ..sheet };
    let wide = Scene::new("wide")
        .body(wide)
        .collider(Collider::sphere([0.0, -0.4, 0.0], 0.3))
        .time(1.0 / 30.0, STEP);
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
        .time(1.0 / 60.0, STEP);
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
        assert!(normals(&cpu, body) == normals(&on_gpu, body), "body {body}");
        assert!(normals(&cpu, body).iter().any(|normal| normal[0] != 0.0));
    }
}

/// A device whose kernels see no more than `bytes` of a buffer.
fn small_gpu(bytes: u64) -> Gpu {
    let whole = gpu();
    let instance = wgpu::Instance::default();
    let adapters = pollster::block_on(instance.enumerate_adapters(wgpu::Backends::all()));
    let adapter = adapters.into_iter().find(|adapter| adapter.get_info().name == whole.info().name);
    let adapter = adapter.expect("the adapter that was just opened");
    let required_limits = wgpu::Limits { max_storage_buffer_binding_size: bytes, ..adapter.limits() };
    let descriptor = wgpu::DeviceDescriptor { required_limits, ..Default::default() };
    let (device, queue) = pollster::block_on(adapter.request_device(&descriptor)).expect("a device");
    Gpu::on(device, queue, adapter.get_info())
}

#[test]
fn what_one_binding_cannot_hold_is_split_by_bodies_and_goes_on_as_one_scene() {
    let scene = everything();
    let (mut cpu, options) = (build_as(&scene, Precision::F32, 1), GpuOptions::from(small_gpu(110_000)));
    let mut split = Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
    run(&mut cpu, 6);
    run(&mut split, 6);
    assert_eq!(farthest(&positions(&cpu), &positions(&split)), 0.0);
    assert_eq!(cpu.report().contacts, split.report().contacts);
    assert!(normals(&cpu, 1) == normals(&split, 1));
    assert_eq!(cpu.snapshot().state, split.snapshot().state);
}

#[test]
fn a_body_that_no_binding_holds_is_refused_with_the_numbers() {
    let options = GpuOptions::from(small_gpu(5_000));
    let error =
        Simulation::new(&flag(), &Options { gpu: Some(options), ..Options::default() }).err().unwrap();
    let words = error.to_string();
    assert!(words.contains("`flag`") && words.contains("9728 bytes") && words.contains("5000"), "{words}");
}

#[test]
fn a_timed_frame_is_a_frame_like_others_and_every_stage_at_work_took_time() {
    let (mut timed, mut plain) = (on_gpu(&everything()), on_gpu(&everything()));
    let times = timed.step_timed().unwrap();
    run(&mut plain, 1);
    assert_eq!(timed.state_hash(), plain.state_hash());
    let names: Vec<&str> = times.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["elements", "loads", "particles", "pins", "diagnose"]);
    assert!(times.iter().all(|(_, seconds)| *seconds > 0.0), "{times:?}");
    run(&mut timed, 1);
}

#[test]
fn tiles_of_meshes_are_refused() {
    let options = GpuOptions { kernels: GpuKernels::Tiled, ..gpu().into() };
    let error = Simulation::new(&everything(), &Options { gpu: Some(options), ..Options::default() }).err();
    assert!(error.unwrap().to_string().contains("scenes of grids alone"));
}

/// Many moving colliders: a frame is handed over in pieces whose number of sub-steps is no multiple of anything.
#[test]
fn a_frame_in_odd_pieces_is_the_same_as_in_one() {
    let mut scene = flag().time(0.2, 1e-3);
    scene.bodies[0].mesh = Mesh::grid(5, 7, [1.5, 1.0]);
    scene.bodies[0].pins.clear();
    for i in 0..1300 {
        let place = [0.01 * f64::from(i) - 3.0, -0.3, 0.0];
        let rising = Keyframe::translate(0.2, [0.0, 0.05, 0.0]);
        scene = scene.collider(Collider::sphere(place, 0.1).keyframe(rising));
    }
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 2), on_gpu(&scene));
    run(&mut cpu, 1);
    run(&mut on_gpu, 1);
    assert!(cpu.report().contacts > 0);
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
}

#[test]
fn sums_beyond_32_bits_are_no_divergence() {
    let heavy = Body::cloth("heavy", Mesh::grid(4, 5, [1.0, 1.0])).with_mass(Mass::Node(1e12));
    let mut scene = Scene::new("heavy").body(heavy).time(0.01, 0.01);
    scene.world.gravity = [0.0, -1e15, 0.0];
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    run(&mut cpu, 3);
    run(&mut on_gpu, 3);
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
    assert!(on_gpu.report().is_finite());
}

#[test]
fn a_device_that_is_lost_ends_the_run_and_the_last_snapshot_goes_on() {
    let device = own_gpu();
    let on = |gpu: &Gpu| {
        let options = Options { gpu: Some(gpu.clone().into()), ..Options::default() };
        Simulation::new(&everything(), &options).unwrap()
    };
    let mut simulation = on(&device);
    run(&mut simulation, 2);
    let snapshot = simulation.snapshot();
    device.lose();
    let error = simulation.step().unwrap_err();
    assert!(matches!(error, StepError::Lost { frame: 3, .. }), "{error}");
    assert!(simulation.fetch().is_err() && simulation.step().is_err());
    let (mut again, mut unbroken) = (on(&gpu()), on(&gpu()));
    again.restore(&snapshot).unwrap();
    run(&mut again, 2);
    run(&mut unbroken, 4);
    assert_eq!(again.state_hash(), unbroken.state_hash());
}

#[test]
fn the_programs_hand_does_the_same_on_both() {
    let scene = flag();
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for simulation in [&mut cpu, &mut on_gpu] {
        run(simulation, 2);
        simulation.pin_vertex(simulation.body("flag").unwrap(), 0, [-0.7, 0.1, -0.4]).unwrap();
        simulation.pin_vertex(simulation.body("flag").unwrap(), 300, [0.0, -0.2, 0.1]).unwrap();
        simulation.apply_force(simulation.body("flag").unwrap(), 599, [1.0, 2.0, -0.5]).unwrap();
        simulation.apply_force(simulation.body("flag").unwrap(), 599, [0.5, 0.0, 0.0]).unwrap();
        run(simulation, 3);
    }
    assert_eq!(farthest(&positions(&cpu), &positions(&on_gpu)), 0.0);
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
    assert_eq!(positions(&on_gpu)[300].map(|c| c as f32), [0.0, -0.2, 0.1]);
    for simulation in [&mut cpu, &mut on_gpu] {
        simulation.unpin_vertex(simulation.body("flag").unwrap(), 300).unwrap();
        run(simulation, 3);
    }
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
    assert_ne!(positions(&on_gpu)[300].map(|c| c as f32), [0.0, -0.2, 0.1]);
}

#[test]
fn frames_in_one_go_are_the_same_as_one_by_one_and_the_sums_are_those_of_the_cpu() {
    let scene = everything();
    let (mut cpu, mut one, mut all) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene), on_gpu(&scene));
    run(&mut cpu, 7);
    run(&mut one, 7);
    all.advance(7).unwrap();
    assert_eq!(one.state_hash(), all.state_hash());
    assert_eq!(one.report(), all.report());
    let (a, b) = (cpu.report(), all.report());
    let close = |what: &str, x: f64, y: f64, size: f64| near(what, x, y, 2e-6 * size);
    close("kinetic", a.kinetic, b.kinetic, a.kinetic);
    close("gravitational", a.gravitational, b.gravitational, 10.0);
    close("springs", a.springs, b.springs, a.springs);
    close("hinges", a.energy_of("hinges"), b.energy_of("hinges"), a.energy_of("hinges"));
    close("stretch", a.max_stretch, b.max_stretch, a.max_stretch);
    for axis in 0..3 {
        close("momentum", a.momentum[axis], b.momentum[axis], 10.0);
        close("angular momentum", a.angular_momentum[axis], b.angular_momentum[axis], 10.0);
    }
    assert_eq!((a.contacts, a.volumes.len()), (b.contacts, b.volumes.len()));
    close("volume", a.volumes[0].unwrap(), b.volumes[0].unwrap(), a.volumes[0].unwrap());
    assert_eq!(b.volumes[1], None);
}

#[test]
fn a_blow_up_on_the_gpu_is_reported_and_not_shown() {
    let mut scene = flag();
    let sheet = scene.bodies.remove(0).structural(1e6, 0.0);
    let mut scene = scene.body(sheet);
    scene.time.max_step = Some(5e-3);
    let mut simulation = on_gpu(&scene);
    simulation.disturb(1e-3, 1);
    let error = (0..300).find_map(|_| simulation.step().err());
    let Some(StepError::Diverged(error)) = error else { panic!("{error:?}") };
    assert_eq!(error.body, "flag");
    assert!(matches!(error.advice[..], [Advice::LongestStep(_), ..]), "{error:?}");
}

#[test]
fn positions_after_a_blow_up_on_the_gpu_are_those_of_the_last_good_frame() {
    for frames in [1, 3] {
        let mut simulation = on_gpu(&bursting());
        let (hash, before, error) = burst(&mut simulation, frames);
        assert!(matches!(error, StepError::Diverged(_)), "{error}");
        assert_eq!((simulation.state_hash(), positions(&simulation)), (hash, before));
        assert_eq!(simulation.step().unwrap_err().to_string(), error.to_string());
        // What is freed, or pinned, while the frame that fails is under way stays so.
        let mut again = on_gpu(&bursting());
        let (stiff, soft) = (again.body("stiff").unwrap(), again.body("soft").unwrap());
        again.pin_vertex(stiff, 7, [0.1, 0.0, 0.2]).unwrap();
        again.disturb(1e-6, 1);
        let fails = |simulation: &mut Simulation| {
            let was = simulation.snapshot();
            simulation.submit(frames).unwrap();
            simulation.unpin_vertex(stiff, 7).unwrap();
            simulation.pin_vertex(soft, 9, [0.0, 0.1, 0.0]).unwrap();
            let failed = simulation.poll().is_err();
            if !failed {
                simulation.restore(&was).unwrap();
                simulation.submit(frames).unwrap();
                simulation.poll().unwrap();
            }
            failed
        };
        assert!((0..100).any(|_| fails(&mut again)), "it held");
        assert!(positions(&again).iter().flatten().all(|x| x.is_finite()));
        let mut fresh = on_gpu(&bursting());
        again.restore(&fresh.snapshot()).unwrap();
        run(&mut again, 2);
        run(&mut fresh, 2);
        assert_eq!(again.state_hash(), fresh.state_hash());
    }
}

fn soft(name: &str, subdivisions: u32, place: [f64; 3]) -> Body {
    Body::soft(name, Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions }))
        .with_mass(Mass::Volume(30.0))
        .structural(40.0, 0.02)
        .at(place)
}

fn kept(form: VolumeForm) -> Volume {
    Volume { form, ..Volume::default() }
}

fn with(volume: Volume, body: Body) -> Body {
    Body { volume: Some(volume), ..body }
}

/// Bodies that keep their volumes in every way, beside a cloth on a grid and one on a mesh: of one group and of several,
/// with springs of several kinds and with none along edges, with nodes that are held and moved, on a floor, on a slope and
/// between moving plates.
fn volumes() -> Scene {
    let weights = VolumeWeights { center: [4.0, 0.25, 0.3], radius: 0.3 };
    let weighted = Volume { weights: Some(weights), ..kept(VolumeForm::Projected) };
    let key = |t, target| VolumeKey { t, target: Some(target), pressure: None };
    let growing = Volume { motion: vec![key(0.0, 1.0), key(0.1, 1.3)], ..kept(VolumeForm::Projected) };
    let blown = Volume { pressure: Some(30.0), ..Volume::default() };
    let lift = vec![Keyframe::translate(0.2, [0.05, 0.1, 0.02])];
    let held = soft("held", 2, [8.0, 0.25, 0.0])
        .pin(Select::nodes([3, 40]))
        .pin_moving(Select::nodes([0, 1, 7]), lift);
    let mut struts = soft("struts", 1, [3.0, 0.22, 0.0]);
    struts.springs.internal = Some(Internal { count: 60, k: 30.0, d: 0.01, ..Internal::default() });
    let mut loose = soft("loose", 1, [7.0, 0.3, 0.0]);
    loose.springs.structural = None;
    let mesh = Body::cloth("mesh", Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 1 }))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .at([2.0, 0.21, 4.0]);
    let press = Collider::sphere([1.0, 0.76, 0.0], 0.3)
        .friction(0.3)
        .keyframe(Keyframe::translate(0.2, [0.0, -0.15, 0.0]));
    let mut scene = Scene::new("volumes")
        .body(with(kept(VolumeForm::Corrected), soft("corrected", 3, [0.0, 0.21, 0.0])))
        .body(flag().bodies.remove(0).at([0.0, 0.8, 4.0]))
        .body(with(kept(VolumeForm::Projected), soft("projected", 3, [1.0, 0.25, 0.0])))
        .body(with(kept(VolumeForm::PaperShader), soft("paper", 2, [2.0, 0.21, 0.0])))
        .body(with(kept(VolumeForm::Corrected), struts))
        .body(with(weighted, soft("weighted", 3, [4.0, 0.22, 0.0])))
        .body(with(blown, soft("blown", 2, [5.0, 0.22, 0.0])))
        .body(mesh)
        .body(with(growing, soft("grows", 2, [6.0, 0.22, 0.0])))
        .body(with(kept(VolumeForm::Corrected), loose))
        .body(with(kept(VolumeForm::Projected), held))
        .collider(Collider::plane([0.0; 3], [0.05, 1.0, 0.0]).friction(0.4))
        .collider(press)
        .time(1.0 / 60.0, STEP / 2.0);
    scene.world.drag = 1e-3;
    scene.world.wind_force = [0.0, 0.0, 1e-3];
    scene
}

#[test]
fn bodies_keep_their_volumes_in_every_way_as_on_the_cpu() {
    let scene = volumes();
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for frame in 1..=12 {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        let (a, b) = (positions(&cpu), positions(&on_gpu));
        assert_eq!(farthest(&a, &b), 0.0, "frame {frame}");
        assert_eq!(cpu.state_hash(), on_gpu.state_hash(), "frame {frame}");
        assert_eq!(cpu.report().contacts, on_gpu.report().contacts, "frame {frame}");
    }
    assert!(cpu.report().contacts > 100);
}

#[test]
fn a_printed_form_diverges_bit_by_bit_as_on_the_cpu() {
    let scene = Scene::new("printed")
        .body(with(kept(VolumeForm::Printed), soft("printed", 2, [0.0, 0.3, 0.0])))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]))
        .time(1.0 / 60.0, STEP);
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    run(&mut cpu, 1);
    run(&mut on_gpu, 1);
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
    let volume = |simulation: &Simulation| simulation.report().volumes[0].unwrap();
    assert!(volume(&cpu) != volume(&build_as(&scene, Precision::F32, 1)));
}

/// More groups than a workgroup has lanes; in two pieces, so that the last lanes have fewer.
#[test]
fn a_body_of_many_groups_is_summed_up_as_on_the_cpu() {
    let ball = Mesh::UvSphere(UvSphere { radius: 0.5, segments: 300, rings: 230 });
    let ball =
        Body::soft("ball", ball).with_mass(Mass::Volume(300.0)).structural(5.0, 0.001).at([0.0, 0.5, 0.0]);
    let scene = Scene::new("large")
        .body(with(kept(VolumeForm::Projected), ball))
        .collider(Collider::plane([0.0, 0.001, 0.0], [0.0, 1.0, 0.0]))
        .time(2e-4, 1e-4);
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 2), on_gpu(&scene));
    run(&mut cpu, 1);
    run(&mut on_gpu, 1);
    assert!(positions(&cpu).len() > 256 * 256);
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
}

#[test]
fn a_gpu_takes_over_bodies_that_keep_their_volume_before_they_are_summed_up() {
    let scene = volumes();
    let start = |from| {
        let options = GpuOptions { from, ..gpu().into() };
        Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() })
    };
    let mut cpu = build_as(&scene, Precision::F32, 1);
    run(&mut cpu, 1);
    for from in Stage::ALL {
        if from <= Stage::Volumes {
            let mut both = start(from).unwrap();
            run(&mut both, 1);
            assert_eq!(cpu.state_hash(), both.state_hash(), "{}", from.name());
        } else {
            let words = start(from).err().unwrap().to_string();
            assert!(words.contains("`corrected` keeps its volume") && words.contains(from.name()), "{words}");
        }
    }
}

#[test]
fn forces_by_hand_and_loads_act_on_bodies_that_keep_their_volume() {
    let twist = Torque { axis: [0.0, 1.0, 0.0], value: 0.05, about: [1.0, 0.0, 0.0] };
    let mut scene =
        volumes().force(Force { torque: Some(twist), ..push("projected", [3, 10, 40, 77].into()) });
    scene.bodies[0] = scene.bodies[0].clone().hinge(1e-3, 1e-5);
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for simulation in [&mut cpu, &mut on_gpu] {
        simulation.disturb(1e-3, 5);
        simulation.apply_force(simulation.body("weighted").unwrap(), 7, [0.5, 0.0, 0.1]).unwrap();
        simulation.pin_vertex(simulation.body("grows").unwrap(), 4, [6.0, 0.45, 0.0]).unwrap();
        run(simulation, 3);
    }
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
    assert_eq!(cpu.report().contacts, on_gpu.report().contacts);
}

#[test]
fn scenes_with_volumes_are_split_by_bodies_too() {
    let scene = volumes();
    let (mut cpu, options) = (build_as(&scene, Precision::F32, 1), GpuOptions::from(small_gpu(90_000)));
    let mut split = Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
    run(&mut cpu, 3);
    run(&mut split, 3);
    assert_eq!(cpu.state_hash(), split.state_hash());
}

#[test]
fn a_timed_frame_names_the_stages_of_volumes() {
    let mut timed = on_gpu(&volumes());
    let times = timed.step_timed().unwrap();
    let names: Vec<&str> = times.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["particles", "volumes", "pins", "project", "diagnose"]);
}
