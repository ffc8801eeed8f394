//! Seams, pins that break and tethers, on the GPU against the same on the CPU.

use super::{STEP, kept, on_gpu, soft, with};
use crate::common::{build_as, farthest, gpu, positions, run, turned};
use taffeta::scene::{
    Body, Collider, ContactForm, Keyframe, Mass, Mesh, Pin, Scene, Seam, SeamSide, Select, SelfCollision,
    VolumeForm,
};
use taffeta::{GpuKernels, GpuOptions, Options, Precision, Simulation, Stage};

fn panel(name: &str, side: u32) -> Body {
    let body = Body::cloth(name, Mesh::grid(side, side, [0.5, 0.5])).with_mass(Mass::Node(0.001));
    body.structural(50.0, 0.005).shear(20.0, 0.005)
}

fn edge(name: &str, col: u32) -> SeamSide {
    SeamSide::new(name, Select::cols(col, col))
}

/// Three panels that meet in one edge, one of them softly, of which some stitches tear; pins that move and let go, pins that
/// stay, and tethers; a ball and a floor below.
fn sewn() -> Scene {
    let motion = vec![Keyframe::rotate(0.6, [0.1, 1.0, 0.0], 40.0, [0.0, 0.1, 0.0])];
    let breaking = Pin { select: Select::cols(0, 1), break_force: Some(0.25), motion, ..Pin::default() };
    let mut left = panel("left", 17).pin(Select::nodes([0, 16])).pin_breaking(Select::nodes([40]), 0.004);
    left.pins.push(breaking);
    Scene::new("sewn")
        .body(left.tether(0.02).at([-0.26, 0.0, 0.0]))
        .body(panel("right", 17).at([0.26, 0.0, 0.0]))
        .body(panel("third", 17).at([0.27, 0.05, 0.0]))
        .seam(
            Seam { break_force: Some(0.1), ..Seam::new(edge("left", 16), edge("right", 0)) }
                .closing(0.0, 0.05, 0.0),
        )
        .seam(
            Seam { k: Some(40.0), ..Seam::new(edge("third", 0), edge("left", 16)) }.closing(0.02, 0.1, 0.01),
        )
        .collider(Collider::sphere([0.0, -0.25, 0.0], 0.2))
        .collider(Collider::plane([0.0, -0.4, 0.0], [0.0, 1.0, 0.0]))
        .time(1.0 / 60.0, STEP / 2.0)
}

/// Fails unless a scene goes the same way on both, bit by bit. Returns how many joints broke.
#[track_caller]
fn same(scene: &Scene, frames: u32) -> u64 {
    let (mut cpu, mut on_gpu) = (build_as(scene, Precision::F32, 1), on_gpu(scene));
    for frame in 1..=frames {
        run(&mut cpu, 1);
        run(&mut on_gpu, 1);
        assert_eq!(farthest(&positions(&cpu), &positions(&on_gpu)), 0.0, "frame {frame}");
        assert_eq!(cpu.report().broken, on_gpu.report().broken, "frame {frame}");
        assert_eq!(cpu.state_hash(), on_gpu.state_hash(), "frame {frame}");
    }
    cpu.report().broken
}

#[test]
fn nodes_are_sewn_and_torn_as_on_the_cpu() {
    let broken = same(&sewn(), 30);
    assert!(broken > 3 && broken < 60, "{broken}");
}

#[test]
fn a_soft_curtain_hangs_in_its_tethers_as_on_the_cpu() {
    let mut body = panel("curtain", 21).structural(1.0, 0.001).shear(1.0, 0.001).pin(Select::nodes([0, 20]));
    body = body.pin_moving(Select::cols(8, 12), vec![Keyframe::translate(0.2, [0.0, 0.1, 0.1])]).tether(0.0);
    body.place = turned([1.0, 0.0, 0.2], 80.0, [0.0; 3]);
    let scene = Scene::new("curtain").body(body).collider(Collider::sphere([0.0, -0.3, 0.1], 0.15));
    assert_eq!(same(&scene.time(1.0 / 60.0, STEP), 25), 0);
}

#[test]
fn soft_bodies_and_cloth_that_touches_others_are_sewn_as_on_the_cpu() {
    let ball = with(kept(VolumeForm::Projected), soft("ball", 2, [0.0, 0.3, 0.0]));
    let touching = SelfCollision { form: ContactForm::Nodes, thickness: 0.03, ..SelfCollision::default() };
    let sheet = Body { self_collision: Some(touching.clone()), ..panel("sheet", 13) };
    let scene = Scene::new("soft")
        .body(ball)
        .body(sheet.at([0.0, -0.1, 0.0]).pin(Select::cols(0, 0)))
        .body(Body { self_collision: Some(touching), ..panel("other", 13) }.at([0.05, -0.07, 0.03]))
        .seam(Seam::pairs("ball", "sheet", [[3, 20], [7, 21], [9, 20]]))
        .seam(Seam { break_force: Some(0.01), ..Seam::pairs("ball", "other", [[5, 7]]) })
        .collider(Collider::plane([0.0, -0.3, 0.0], [0.0, 1.0, 0.0]))
        .time(1.0 / 60.0, STEP / 2.0);
    same(&scene, 12);
}

fn from(scene: &Scene, from: Stage) -> Result<Simulation, String> {
    let options = GpuOptions { from, ..gpu().into() };
    let options = Options { gpu: Some(options), ..Options::default() };
    Simulation::new(scene, &options).map_err(|error| error.to_string())
}

#[test]
fn any_stage_up_to_that_of_joints_can_be_the_first_on_the_gpu() {
    let mut cpu = build_as(&sewn(), Precision::F32, 1);
    run(&mut cpu, 2);
    for stage in [Stage::Springs, Stage::Contact, Stage::Attach] {
        let mut mixed = from(&sewn(), stage).expect("it starts");
        run(&mut mixed, 2);
        assert_eq!(mixed.state_hash(), cpu.state_hash(), "{stage:?}");
    }
    let refused = from(&sewn(), Stage::Pairs).err().expect("it is too late");
    assert!(refused.contains("at stage `attach` at the latest, not at `pairs`"), "{refused}");
}

#[test]
fn what_is_broken_goes_from_one_to_the_other() {
    let scene = sewn();
    let mut whole = build_as(&scene, Precision::F32, 1);
    run(&mut whole, 14);
    let snapshot = whole.snapshot();
    assert!(snapshot.report.broken > 0 && snapshot.joints > 60);
    let mut taken_up = on_gpu(&scene);
    taken_up.restore(&snapshot).expect("it fits");
    assert_eq!(taken_up.snapshot(), snapshot);
    run(&mut whole, 6);
    run(&mut taken_up, 6);
    assert_eq!(
        (taken_up.state_hash(), taken_up.report().broken),
        (whole.state_hash(), whole.report().broken)
    );
    let mut back = build_as(&scene, Precision::F32, 1);
    back.restore(&taken_up.snapshot()).expect("it fits");
    run(&mut whole, 3);
    run(&mut back, 3);
    assert_eq!(back.state_hash(), whole.state_hash());
}

#[test]
fn what_a_gpu_does_not_do_is_refused_with_words() {
    let touching = |name: &str| panel(name, 5).collide_nodes(0.01);
    let scene = Scene::new("").body(touching("a")).body(touching("b")).seam(Seam::pairs("a", "b", [[0, 0]]));
    let refused = from(&scene, Stage::Elements).err().expect("it is refused");
    assert!(refused.contains("bodies `a` and `b` are sewn together and have self_collision"), "{refused}");
    let mut carried = panel("sheet", 5);
    let collider = Some("collider0".to_owned());
    carried.pins.push(Pin { select: Select::cols(0, 0), break_force: Some(1.0), collider, ..Pin::default() });
    let scene = Scene::new("").body(carried).collider(Collider::sphere([0.0; 3], 0.1));
    let refused = from(&scene, Stage::Elements).err().expect("it is refused");
    assert!(refused.contains("body `sheet` has a pin with collider and break_force"), "{refused}");
    let options = GpuOptions { kernels: GpuKernels::Tiled, ..gpu().into() };
    let options = Options { gpu: Some(options), ..Options::default() };
    assert!(Simulation::new(&sewn(), &options).is_err());
}

#[test]
fn fabrics_are_sewn_in_their_systems_as_on_the_cpu() {
    // A seam on a table of which one edge is raised; Newton steps by themselves, one, and two of second order.
    for (newton_steps, order) in [(0, 1), (1, 1), (2, 2)] {
        let [sewn, _] = crate::primal::sewn::raised(0.0);
        let mut scene = sewn.method(taffeta::scene::Method::Ice);
        scene.bodies[1].place.position[2] += 0.001;
        scene.solver.ice.form = taffeta::scene::ConstraintForm::Primal;
        (scene.solver.ice.newton_steps, scene.solver.ice.order) = (newton_steps, order);
        scene.solver.ice.tolerance = 1e-5;
        let (mut cpu, mut gpu) = (build_as(&scene, Precision::F32, 1), on_gpu(&scene));
        let (mut most, mut iterations) = (0.0_f64, [0; 2]);
        // The seam is closed when the third frame starts.
        run(&mut cpu, 1);
        run(&mut gpu, 1);
        let snapshot = gpu.snapshot();
        for _ in 2..=20 {
            run(&mut cpu, 1);
            run(&mut gpu, 1);
            let apart = farthest(&positions(&cpu), &positions(&gpu));
            most = most.max(apart);
            for (sum, one) in iterations.iter_mut().zip([&cpu, &gpu]) {
                *sum += one.report().solver.iterations;
            }
        }
        assert!(most < 2e-4, "{newton_steps}: {most} m");
        assert!(10 * iterations[1] < 11 * iterations[0], "{newton_steps}: {iterations:?} iterations");
        let end = gpu.state_hash();
        if order == 2 {
            gpu.restore(&snapshot).unwrap();
            run(&mut gpu, 19);
            assert_eq!(gpu.state_hash(), end, "restored from before the seam was closed");
        }
    }
}
