//! Colliders of every shape on the GPU against the same on the CPU.

use super::constraints::{compare, drop};
use super::pairs::heap;
use super::{STEP, kept, on_gpu, small_gpu, soft, with};
use crate::common::plates::{ON_THE_UPPER, beside_the_upper, falling_short, loose};
use crate::common::state::put;
use crate::common::{V, build_as, farthest, gpu, norm, positions, run, sub, turned, weightless};
use taffeta::scene::{
    Body, Collider, ConstraintForm, Cylinder, Icosphere, Keyframe, Mass, Mesh, Method, Scene, VolumeForm,
};
use taffeta::{GpuKernels, GpuOptions, Options, Precision, Simulation, Stage};

fn ball(radius: f64, subdivisions: u32) -> Mesh {
    Mesh::Icosphere(Icosphere { radius, subdivisions })
}

/// A sheet and a ball that fall on a collider at the origin.
fn falling(title: &str, collider: Collider) -> Scene {
    let sheet = Body::cloth("sheet", Mesh::grid(21, 23, [1.2, 1.2]))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .shear(20.0, 0.02)
        .at([0.05, 0.36, 0.03]);
    let top = Body::cloth("ball", ball(0.1, 1)).with_mass(Mass::Node(0.01)).structural(50.0, 0.02);
    Scene::new(title)
        .body(sheet)
        .body(top.at([-0.1, 0.6, 0.1]))
        .collider(collider.friction(0.4).restitution(0.1))
        .time(1.0 / 60.0, STEP)
}

/// A turn about a slanted axis through the origin, and a way.
fn turning() -> Keyframe {
    Keyframe { translate: [0.05, 0.1, -0.03], ..Keyframe::rotate(0.5, [0.2, 0.9, 0.3], 100.0, [0.0; 3]) }
}

/// Runs both, frame by frame; returns how many nodes touched at most.
fn same(scene: &Scene, frames: u32) -> u64 {
    let (mut cpu, mut on_gpu) = (build_as(scene, Precision::F32, 1), on_gpu(scene));
    let mut most = 0;
    for frame in 1..=frames {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        let title = &scene.title;
        assert_eq!(farthest(&positions(&cpu), &positions(&on_gpu)), 0.0, "{title}, frame {frame}");
        assert_eq!(cpu.report().contacts, on_gpu.report().contacts, "{title}, frame {frame}");
        assert_eq!(cpu.state_hash(), on_gpu.state_hash(), "{title}, frame {frame}");
        most = most.max(cpu.report().contacts);
    }
    most
}

#[test]
fn a_ball_of_twenty_thousand_triangles_is_as_on_the_cpu() {
    assert!(same(&falling("fine ball", Collider::mesh(ball(0.3, 5)).offset(0.01)), 12) > 20);
}

#[test]
fn a_software_adapter_says_so_where_its_loops_are_too_short() {
    let node = Body::cloth("speck", Mesh::grid(2, 2, [1e-3, 1e-3])).with_mass(Mass::Node(0.01));
    let scene = Scene::new("in the middle")
        .body(node.structural(1.0, 0.0))
        .collider(Collider::mesh(ball(0.3, 5)).offset(0.01))
        .time(1.0 / 60.0, STEP);
    let ended = on_gpu(&scene).step().map(|report| report.frame);
    let why = ended.unwrap_err().to_string();
    if !gpu().info().is_software() {
        // As the CPU: each node goes a way of its own.
        let on_cpu =
            build_as(&scene, Precision::F32, 1).step().map(|report| report.frame).unwrap_err().to_string();
        assert!([&why, &on_cpu].iter().all(|why| why.contains("times its rest length")), "{why}\n{on_cpu}");
        return;
    }
    assert!(why.contains("so many of the colliders' 20480 triangles"), "{why}");
    assert!(why.contains("the CPU would tell"), "{why}");
}

/// A sheet whose middle rises and sinks, as nodes of a grid.
fn waving() -> Collider {
    let (rows, cols, side) = (8_u32, 9_u32, 1.3);
    let at = |i: u32, count: u32| side * (f64::from(i) / f64::from(count - 1) - 0.5);
    let pose = |height: f64| -> Vec<[f64; 3]> {
        let node = |row, col| {
            let (x, z) = (at(col, cols), at(row, rows));
            [x, height * (3.0 * x).cos() * (3.0 * z).cos(), z]
        };
        (0..rows).flat_map(|row| (0..cols).map(move |col| node(row, col))).collect()
    };
    let poses = [0.1, 0.3, 0.45, 0.4, 0.5].map(pose).to_vec();
    Collider::mesh(Mesh::grid(rows, cols, [side, side])).posed(0.07, poses)
}

/// Ground of furrows, in which nodes meet several triangles.
fn furrows() -> Collider {
    let height = |row: i32, col: i32| 0.1 * f64::from((row + col) % 2) + 0.02 * f64::from(row % 3);
    let rows = (0..11).map(|row| (0..9).map(|col| height(row, col)).collect()).collect();
    Collider::heightfield([1.4, 1.3], rows)
}

/// A collider of every shape that is no ball and no half-space.
fn shapes() -> Vec<(&'static str, Collider)> {
    let can = Mesh::Cylinder(Cylinder { radius: 0.25, height: 0.3, segments: 16, rings: 2, capped: true });
    let slanted = turned([0.3, 0.1, 0.7], 25.0, [0.02, 0.05, -0.01]);
    vec![
        ("box", Collider::cuboid([0.0; 3], [0.3, 0.15, 0.2]).keyframe(turning())),
        ("still box", Collider::cuboid([0.0; 3], [0.3, 0.15, 0.2]).placed(slanted.clone())),
        ("capsule", Collider::capsule([-0.3, 0.1, 0.0], [0.3, 0.0, 0.1], 0.12).keyframe(turning())),
        ("cylinder", Collider::cylinder([-0.2, 0.1, 0.0], [0.25, 0.05, 0.1], 0.15).keyframe(turning())),
        ("ball of triangles", Collider::mesh(ball(0.3, 2)).keyframe(turning())),
        ("can", Collider::mesh(can.clone()).placed(slanted.clone())),
        ("hull", Collider::convex(can).keyframe(turning())),
        ("sheet", Collider::mesh(Mesh::grid(5, 7, [0.9, 0.8])).placed(slanted)),
        ("furrows", furrows()),
        ("waves", waving()),
        ("carried waves", waving().keyframe(turning())),
    ]
}

#[test]
fn a_sheet_falls_on_every_shape_as_on_the_cpu() {
    for (title, collider) in shapes() {
        let most = same(&falling(title, collider), 14);
        assert!(most > 20, "{title}: {most} contacts at most");
    }
}

#[test]
fn nodes_between_colliders_of_several_shapes_go_where_they_go_on_the_cpu() {
    let mut scene = falling("several", Collider::mesh(ball(0.2, 1)).keyframe(turning()));
    scene = scene
        .collider(Collider::plane([0.0, 0.05, 0.0], [0.05, 1.0, 0.02]).friction(0.3))
        .collider(Collider::cuboid([0.25, 0.1, 0.1], [0.1, 0.12, 0.2]))
        .collider(Collider::mesh(Mesh::grid(4, 5, [0.7, 0.7])).placed(turned(
            [1.0, 0.0, 0.3],
            30.0,
            [0.1, 0.15, 0.2],
        )));
    assert!(same(&scene, 14) > 50);
}

#[test]
fn bodies_that_keep_their_volume_lie_on_meshes_as_on_the_cpu() {
    let scene = Scene::new("volumes on meshes")
        .body(with(kept(VolumeForm::Projected), soft("projected", 2, [0.0, 0.5, 0.0])))
        .body(with(kept(VolumeForm::Corrected), soft("corrected", 2, [0.45, 0.4, 0.1])))
        .body(super::flag().bodies.remove(0).at([0.0, 0.8, 0.0]))
        .collider(furrows().friction(0.4))
        .collider(Collider::mesh(ball(0.2, 1)).keyframe(turning()))
        .time(1.0 / 60.0, STEP);
    assert!(same(&scene, 16) > 20);
}

#[test]
fn nodes_that_touch_each_other_are_kept_out_of_meshes_too() {
    let mut scene = heap();
    scene.colliders = vec![
        Collider::mesh(Mesh::grid(3, 3, [4.0, 4.0])).friction(0.4).offset(0.001),
        Collider::mesh(ball(0.07, 1)).keyframe(turning()),
        Collider::cuboid([0.6, 0.0, 0.1], [0.1, 0.03, 0.05]),
    ];
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for frame in 1..=12 {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        assert_eq!(cpu.state_hash(), on_gpu.state_hash(), "frame {frame}");
    }
    assert!(cpu.report().contacts > 10 && cpu.report().pairs > 100);
}

#[test]
fn a_gpu_takes_over_scenes_with_meshes_at_every_stage() {
    let scene = falling("taken over", waving());
    let mut cpu = build_as(&scene, Precision::F32, 1);
    run(&mut cpu, 14);
    assert!(cpu.report().contacts > 10);
    for from in Stage::ALL {
        let options = GpuOptions { from, ..gpu().into() };
        let mut both =
            Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
        run(&mut both, 14);
        assert_eq!(farthest(&positions(&cpu), &positions(&both)), 0.0, "{}", from.name());
        assert_eq!(both.report().contacts, cpu.report().contacts, "{}", from.name());
    }
}

#[test]
fn surfaces_of_triangles_hold_nodes_of_implicit_springs_as_on_the_cpu() {
    for form in [ConstraintForm::Compliant, ConstraintForm::Primal] {
        let mut scene = drop(Method::Ice);
        scene.solver.ice.form = form;
        scene.colliders = vec![
            Collider::mesh(ball(0.5, 2)).offset(0.01).friction(0.3),
            Collider::cuboid([0.5, 0.2, 0.3], [0.2, 0.1, 0.2]).offset(0.01),
        ];
        // Later the last digits say which way a node slips off an edge.
        let [cpu, gpu] = compare(&scene, 12, 1e-5);
        assert!(cpu.report().contacts > 10);
        assert!(cpu.report().contacts.abs_diff(gpu.report().contacts) < 5);
    }
}

/// Plates of a millimetre or none, 2 m wide, in the xz plane.
fn plates() -> Vec<(&'static str, Collider)> {
    let can = Mesh::Cylinder(Cylinder { radius: 1.0, height: 1e-3, segments: 24, rings: 1, capped: true });
    vec![
        ("box", Collider::cuboid([0.0; 3], [1.0, 5e-4, 1.0])),
        ("cylinder", Collider::cylinder([0.0, -5e-4, 0.0], [0.0, 5e-4, 0.0], 1.0)),
        ("sheet", Collider::mesh(Mesh::grid(8, 11, [2.0, 2.0]))),
        ("closed mesh", Collider::mesh(can.clone())),
        ("hull", Collider::convex(can)),
    ]
}

#[test]
fn nothing_passes_a_thin_plate_at_50_metres_a_second() {
    let nodes = |y| {
        Body::cloth("nodes", Mesh::grid(5, 5, [0.37, 0.37])).with_mass(Mass::Node(0.01)).at([0.013, y, 0.017])
    };
    for (name, plate) in plates() {
        let lift = Keyframe::translate(0.1, [0.0, 5.0, 0.0]);
        let swept = weightless(name, 1.0 / 60.0, 1.0 / 60.0)
            .body(nodes(1.0))
            .collider(plate.clone().offset(2e-3).friction(0.0).keyframe(lift));
        let mut thrown =
            weightless(name, 1.0 / 60.0, 1.0 / 60.0).body(nodes(2.0)).collider(plate.offset(2e-3));
        thrown.world.gravity = [0.0, -3000.0, 0.0];
        for (scene, least) in [(swept, 5.0 / 3.0), (thrown, 0.0)] {
            assert!(same(&scene, 2) > 0, "{name}");
            let mut simulation = on_gpu(&scene);
            run(&mut simulation, 2);
            for [x, y, z] in positions(&simulation) {
                assert!(y > least, "{name}: {x} {y} {z}");
            }
        }
    }
}

/// Where nodes go that are put at places: the same on both.
fn put_on_both(scene: &Scene, places: &[V], frames: u32) -> Vec<V> {
    let (mut cpu, mut on_gpu) = (build_as(scene, Precision::F32, 1), on_gpu(scene));
    for simulation in [&mut cpu, &mut on_gpu] {
        put(simulation, places);
        run(simulation, frames);
    }
    assert_eq!(farthest(&positions(&cpu), &positions(&on_gpu)), 0.0);
    positions(&on_gpu)
}

#[test]
fn thin_plates_leave_nodes_alone_that_are_off_them() {
    let places = beside_the_upper();
    for (before, after) in places.iter().zip(put_on_both(&loose(places.len()), &places, 1)) {
        assert!(norm(sub(after, *before)) < 1e-6, "{before:?} went to {after:?}");
    }
}

#[test]
fn a_way_through_a_plate_that_ends_short_of_another_is_stopped_by_the_first() {
    let (scene, places) = falling_short();
    for ([_, start, _], [x, y, z]) in places.iter().zip(put_on_both(&scene, &places, 1)) {
        assert!((y - ON_THE_UPPER).abs() < 1e-6, "from {start} to {x} {y} {z}");
    }
}

#[test]
fn scenes_with_meshes_are_split_by_bodies_too() {
    let scene = falling("split", Collider::mesh(ball(0.3, 1)).keyframe(turning()));
    let (mut cpu, options) = (build_as(&scene, Precision::F32, 1), GpuOptions::from(small_gpu(40_000)));
    let mut split = Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).unwrap();
    run(&mut cpu, 9);
    run(&mut split, 9);
    assert!(cpu.report().contacts > 10);
    assert_eq!(cpu.state_hash(), split.state_hash());
}

#[test]
fn what_a_device_cannot_do_with_meshes_is_refused() {
    let built = |scene: &Scene, options: GpuOptions| {
        let options = Options { gpu: Some(options), ..Options::default() };
        Simulation::new(scene, &options).err().map(|error| error.to_string())
    };
    let refused = |collider: Collider, options: GpuOptions| {
        built(&falling("refused", collider), options).expect("a refusal")
    };
    let words = refused(Collider::mesh(ball(0.3, 2)), small_gpu(9_000).into());
    assert!(words.contains("meshes among the colliders take") && words.contains("9000"), "{words}");
    let tiled = GpuOptions { kernels: GpuKernels::Tiled, ..gpu().into() };
    assert!(refused(Collider::mesh(ball(0.3, 1)), tiled).contains("without meshes as colliders"));
    if gpu().info().is_software() {
        let crowd = |colliders: usize| {
            let mut scene = falling("crowd", Collider::mesh(ball(0.3, 1)));
            let far = |_| Collider::sphere([0.0, -9.0, 0.0], 0.1);
            scene.colliders.extend((1..colliders).map(far));
            built(&scene, gpu().into())
        };
        assert_eq!(crowd(441), None);
        assert!(crowd(442).unwrap().contains("the scene has 442 colliders"));
    }
}
