//! Scenes in which nodes touch each other, on the GPU against the same on the CPU.

use super::{STEP, kept, on_gpu, small_gpu, soft, with};
use crate::common::{build_as, farthest, gpu, positions, run};
use std::sync::Arc;
use taffeta::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Scene, Select, VolumeForm};
use taffeta::topology::Surface;
use taffeta::{GpuKernels, GpuOptions, Options, Precision, Simulation, Stage};

fn cloth(name: &str, mesh: Mesh) -> Body {
    let is_grid = matches!(mesh, Mesh::Grid(_));
    let body = Body::cloth(name, mesh).with_mass(Mass::Node(0.002)).structural(20.0, 0.01);
    if is_grid { body.shear(8.0, 0.005) } else { body }
}

/// A sheet that is held, onto which another and a ball fall; a shell that touches none; on a floor the ends of a sheet
/// that a moving row of pins folds onto itself.
pub fn heap() -> Scene {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.05, subdivisions: 2 });
    let sheet = |side| Mesh::grid(17, 19, [side, 0.36]);
    let fold = vec![Keyframe::rotate(0.12, [0.0, 0.0, 1.0], 170.0, [0.6, 0.0, 0.0])];
    let folded = cloth("folded", Mesh::grid(25, 25, [0.5, 0.5])).at([0.6, 0.012, 0.0]).collide_nodes(0.018);
    let mut low =
        cloth("low", sheet(0.36)).collide_nodes(0.02).pin(Select::cols(0, 0)).pin(Select::cols(18, 18));
    low.self_collision.as_mut().unwrap().friction = 0.5;
    Scene::new("heap")
        .body(low.at([0.0, 0.1, 0.0]))
        .body(cloth("shell", ball.clone()).at([2.0, 0.1, 0.0]))
        .body(cloth("high", sheet(0.3)).collide_nodes(0.017).at([0.01, 0.118, 0.02]))
        .body(cloth("ball", ball).collide_nodes(0.022).at([0.0, 0.19, 0.0]))
        .body(folded.pin_moving(Select::cols(24, 24), fold))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction(0.4).offset(0.0))
        .time(1.0 / 60.0, STEP)
}

#[test]
fn nodes_touch_each_other_as_on_the_cpu() {
    let scene = heap();
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    let mut most = 0;
    for frame in 1..=14 {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        assert_eq!(farthest(&positions(&cpu), &positions(&on_gpu)), 0.0, "frame {frame}");
        let (a, b) = (cpu.report(), on_gpu.report());
        assert_eq!((a.pairs, a.nearest_pair), (b.pairs, b.nearest_pair), "frame {frame}");
        assert_eq!(cpu.state_hash(), on_gpu.state_hash(), "frame {frame}");
        assert_eq!(b.pair_searches, 4, "every sub-step searches");
        most = most.max(a.pairs);
    }
    assert!(most > 300 && cpu.report().contacts > 10, "{most}");
    on_gpu.disturb(1e-3, 1);
    let still = on_gpu.report();
    assert_eq!((still.pairs, still.nearest_pair, still.pair_searches), (0, None, 0));
}

#[test]
fn bodies_that_keep_their_volume_touch_each_other_as_on_the_cpu() {
    let touching = |form, subdivisions, place| {
        with(kept(form), soft(&format!("{form:?} {subdivisions}"), subdivisions, place)).collide_nodes(0.11)
    };
    let sheet = cloth("sheet", Mesh::grid(13, 13, [0.8, 0.8])).collide_nodes(0.06).at([0.0, 0.52, 0.0]);
    let scene = Scene::new("soft")
        .body(touching(VolumeForm::Projected, 2, [0.0, 0.2, 0.0]))
        .body(touching(VolumeForm::Corrected, 2, [0.46, 0.25, 0.1]))
        .body(touching(VolumeForm::Projected, 1, [0.2, 0.66, 0.05]))
        .body(sheet)
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).friction(0.4).offset(0.0))
        .time(1.0 / 60.0, STEP);
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    let mut most = 0;
    for frame in 1..=10 {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        assert_eq!(cpu.report().pairs, on_gpu.report().pairs, "frame {frame}");
        assert_eq!(cpu.state_hash(), on_gpu.state_hash(), "frame {frame}");
        most = most.max(cpu.report().pairs);
    }
    assert!(most > 20, "{most}");
}

#[test]
fn colliders_act_again_on_nodes_that_touch_others() {
    let mut scene = heap();
    scene.colliders[0] = Collider::sphere([0.0, 0.0, 0.0], 0.09).friction(0.3);
    scene = scene.collider(Collider::plane([0.0, -0.003, 0.0], [0.1, 1.0, 0.02]).friction(0.4));
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    for frame in 1..=14 {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        assert_eq!(farthest(&positions(&cpu), &positions(&on_gpu)), 0.0, "frame {frame}");
    }
    assert!(cpu.report().pairs > 100 && cpu.report().contacts > 10);
}

/// A thousand nodes at hardly more than one place: triangles that each are a body's part of its own.
#[test]
fn a_heap_in_one_cell_is_slow_and_not_wrong() {
    let triangles: Vec<[u32; 3]> = (0..340).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    // Places all over a cube, by steps that no edge of it is a multiple of.
    let place = |i: u32| [0.618, 0.414, 0.732].map(|step| 0.006 * (f64::from(i) * step).fract());
    let nodes: Vec<[f64; 3]> = (0..1020).map(place).collect();
    let surface = Surface::of_triangles(nodes, triangles);
    let scene = Scene::new("heap in a cell")
        .body(cloth("heap", Mesh::Surface(Arc::new(surface))).collide_nodes(0.02))
        .time(1e-3, 1e-3);
    let (mut cpu, mut on_gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
    run(&mut cpu, 1);
    run(&mut on_gpu, 1);
    assert_eq!(cpu.report().pairs, 1020 * 1017 / 2);
    assert_eq!(on_gpu.report().pairs, cpu.report().pairs);
    assert_eq!(cpu.state_hash(), on_gpu.state_hash());
}

fn from(scene: &Scene, from: Stage) -> Result<Simulation, String> {
    let options = GpuOptions { from, ..gpu().into() };
    let options = Options { gpu: Some(options), ..Options::default() };
    Simulation::new(scene, &options).map_err(|error| error.to_string())
}

#[test]
fn a_gpu_takes_over_nodes_that_touch_before_they_are_found() {
    let scene = heap();
    let mut cpu = build_as(&scene, Precision::F32, 1);
    run(&mut cpu, 3);
    assert!(cpu.report().pairs > 20, "{}", cpu.report().pairs);
    for stage in Stage::ALL {
        if stage <= Stage::Pairs {
            let mut both = from(&scene, stage).unwrap();
            run(&mut both, 3);
            assert_eq!(cpu.state_hash(), both.state_hash(), "{}", stage.name());
            let (a, b) = (cpu.report(), both.report());
            assert_eq!((a.pairs, a.nearest_pair, 4), (b.pairs, b.nearest_pair, b.pair_searches));
        } else {
            let words = from(&scene, stage).err().unwrap();
            assert!(words.contains("`low` has self_collision") && words.contains(stage.name()), "{words}");
        }
    }
}

#[test]
fn bodies_that_touch_each_other_are_not_split() {
    let options = Options { gpu: Some(GpuOptions::from(small_gpu(20_000))), ..Options::default() };
    let words = Simulation::new(&heap(), &options).err().unwrap().to_string();
    assert!(words.contains("`low` and `high`") && words.contains("20000 bytes"), "{words}");
    // What touches none may be elsewhere.
    let mut scene = heap();
    for body in &mut scene.bodies {
        if body.name == "ball" || body.name == "folded" {
            body.self_collision = None;
        }
    }
    let options = Options { gpu: Some(GpuOptions::from(small_gpu(30_000))), ..Options::default() };
    let mut split = Simulation::new(&scene, &options).unwrap();
    let mut cpu = build_as(&scene, Precision::F32, 1);
    run(&mut cpu, 5);
    run(&mut split, 5);
    assert!(cpu.report().pairs > 0);
    assert_eq!(cpu.report().pairs, split.report().pairs);
    assert_eq!(cpu.state_hash(), split.state_hash());
}

#[test]
fn sheets_that_touch_are_not_cut_into_tiles() {
    let scene = Scene::new("sheet")
        .body(cloth("sheet", Mesh::grid(9, 9, [0.3, 0.3])).collide_nodes(0.03))
        .time(0.01, 1e-3);
    let options = GpuOptions { kernels: GpuKernels::Tiled, ..gpu().into() };
    let error = Simulation::new(&scene, &Options { gpu: Some(options), ..Options::default() }).err();
    assert!(error.unwrap().to_string().contains("without self_collision"));
}

#[test]
fn a_timed_frame_names_the_stage_of_pairs() {
    let times = on_gpu(&heap()).step_timed().unwrap();
    let names: Vec<&str> = times.iter().map(|(name, _)| *name).collect();
    assert_eq!(names, ["particles", "pins", "pairs", "diagnose"]);
}
