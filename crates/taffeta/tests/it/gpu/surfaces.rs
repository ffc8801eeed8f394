//! Scenes in which surfaces touch each other, on the GPU against the same on the CPU.

use super::{STEP, kept, on_gpu, soft, with};
use crate::common::{build_as, farthest, positions, run};
use crate::surfaces_pressed::pressed;
use taffeta::diagnostics::FrameReport;
use taffeta::scene::{
    Body, Collider, ContactForm, ContactZone, Icosphere, Keyframe, Mass, Mesh, Rotation, Scene, Seam,
    SeamSide, Select, SelfCollision, VolumeForm,
};
use taffeta::{Pose, Precision, Simulation};

pub fn touch(body: Body, thickness: f64) -> Body {
    let form = ContactForm::Triangles;
    let wish = SelfCollision { form, thickness, friction: 0.3, ..SelfCollision::default() };
    Body { self_collision: Some(wish), ..body }
}

fn touching(name: &str, mesh: Mesh, thickness: f64) -> Body {
    let is_grid = matches!(mesh, Mesh::Grid(_));
    let body = Body::cloth(name, mesh).with_mass(Mass::Node(0.002)).structural(20.0, 0.01);
    touch(if is_grid { body.shear(8.0, 0.005) } else { body }, thickness)
}

pub fn sheet(count: u32, side: f64) -> Mesh {
    Mesh::grid(count, count, [side, side])
}

/// With rows that keep another distance.
fn with_hem(mut body: Body) -> Body {
    let hem = ContactZone { select: Select::rows(0, 3), thickness: 0.011 };
    body.self_collision.as_mut().expect("it touches").zones = [("hem".to_owned(), hem)].into();
    body
}

/// A sheet and a ball that fall onto a sheet which is held, and a box below them.
pub fn heap() -> Scene {
    let ball = Mesh::Icosphere(Icosphere { radius: 0.05, subdivisions: 2 });
    let held = touching("held", sheet(9, 0.3), 0.01).pin(Select::cols(0, 0)).pin(Select::cols(8, 8));
    Scene::new("heap")
        .body(held)
        .body(touching("fine", sheet(13, 0.2), 0.008).at([0.01, 0.02, 0.03]))
        .body(touching("ball", ball, 0.01).at([0.0, 0.075, 0.0]))
        .collider(Collider::plane([0.0, -0.06, 0.0], [0.0, 1.0, 0.0]).friction(0.4))
        .collider(Collider::cuboid([0.05, -0.06, 0.0], [0.02, 0.03, 0.02]).friction(0.3).offset(0.004))
        .time(1.0 / 60.0, STEP)
        .friction_between("held", "fine", 0.7)
        .friction_between("ball", "collider0", 0.0)
}

/// Runs both, and returns the most contacts in a frame.
fn are_alike(cpu: &mut Simulation, gpu: &mut Simulation, frames: usize) -> u64 {
    let mut most = 0;
    for frame in 1..=frames {
        run(cpu, 1);
        run(gpu, 1);
        let (a, b) = (cpu.report(), gpu.report());
        let of = |report: &FrameReport| (report.pairs, report.nearest_pair, report.substeps);
        assert_eq!(of(a), of(b), "frame {frame}");
        assert_eq!(farthest(&positions(cpu), &positions(gpu)), 0.0, "frame {frame}");
        assert_eq!(cpu.state_hash(), gpu.state_hash(), "frame {frame}");
        most = most.max(a.pairs);
    }
    most
}

/// Goes on from the snapshot of the other backend in each, and from its own on the CPU, as far.
fn go_on_from_snapshots(scene: &Scene, cpu: &mut Simulation, gpu: &Simulation) {
    let (mut other_cpu, mut other_gpu) = both(scene);
    other_cpu.restore(&gpu.snapshot()).expect("it fits");
    other_gpu.restore(&cpu.snapshot()).expect("it fits");
    are_alike(&mut other_cpu, &mut other_gpu, 2);
    run(cpu, 2);
    assert_eq!(cpu.state_hash(), other_gpu.state_hash());
}

fn both(scene: &Scene) -> (Simulation, Simulation) {
    (build_as(scene, Precision::F32, 1), on_gpu(scene))
}

#[test]
fn surfaces_touch_each_other_as_on_the_cpu() {
    let mut scene = heap();
    scene.bodies[1] = with_hem(scene.bodies[1].clone());
    let (mut cpu, mut gpu) = both(&scene);
    // More than there is room for at the start, so frames are repeated.
    let most = are_alike(&mut cpu, &mut gpu, 13);
    assert!(most > 400 && cpu.report().contacts > 10, "{most} {}", cpu.report().contacts);
    gpu.disturb(1e-3, 1);
    let still = gpu.report();
    assert_eq!((still.pairs, still.nearest_pair), (0, None));
}

/// What flies fast goes in several rounds of the filter, which hold back some nodes, so that sub-steps become shorter.
#[test]
fn cloth_that_is_thrown_is_held_back_as_on_the_cpu() {
    let thrown = touching("thrown", sheet(9, 0.12), 0.006).at([0.0, 0.1, 0.0]).moving([0.3, -14.0, 0.2]);
    let held = touching("held", sheet(11, 0.25), 0.006).pin(Select::rows(0, 0)).pin(Select::rows(10, 10));
    let scene = Scene::new("thrown")
        .body(held)
        .body(thrown)
        .collider(Collider::cuboid([0.02, -0.05, 0.01], [0.01, 0.03, 0.01]).offset(0.004))
        .time(STEP, STEP / 2.0);
    let (mut cpu, mut gpu) = both(&scene);
    let most = are_alike(&mut cpu, &mut gpu, 8);
    assert!(most > 30 && cpu.report().substeps > 2, "{most} {}", cpu.report().substeps);
    go_on_from_snapshots(&scene, &mut cpu, &gpu);
}

/// Pushes of colliders that move come to no end, so that nodes stop and are reported.
#[test]
fn layers_without_room_are_pressed_as_on_the_cpu() {
    let springs = |body: Body| body.with_mass(Mass::Node(0.002)).structural(20.0, 0.01).shear(8.0, 0.005);
    let scene = pressed(2, 0.001, 0.01, springs).time(STEP / 2.0, STEP / 8.0);
    let (mut cpu, mut gpu) = both(&scene);
    let mut squeezed = 0;
    for _ in 0..5 {
        are_alike(&mut cpu, &mut gpu, 1);
        assert_eq!(cpu.report().squeezed, gpu.report().squeezed);
        squeezed += u32::from(cpu.report().squeezed.is_some());
    }
    assert!(squeezed > 0);
}

#[test]
fn contact_goes_on_from_a_snapshot_on_the_other_backend() {
    let (mut cpu, mut gpu) = both(&heap());
    run(&mut cpu, 7);
    run(&mut gpu, 7);
    let [of_cpu, of_gpu] = [&cpu, &gpu].map(Simulation::snapshot);
    assert!(of_cpu.contacts > 100, "{}", of_cpu.contacts);
    assert_eq!(of_cpu.contacts, of_gpu.contacts);
    go_on_from_snapshots(&heap(), &mut cpu, &gpu);
}

#[test]
fn meshes_volumes_and_seams_stand_beside_contact_as_on_the_cpu() {
    let ball = |radius| Mesh::Icosphere(Icosphere { radius, subdivisions: 1 });
    let pillow = touch(with(kept(VolumeForm::Projected), soft("pillow", 1, [0.0, 0.43, 0.0])), 0.03);
    let mut scene = Scene::new("beside")
        .body(pillow)
        .body(touching("left", sheet(7, 0.3), 0.02).at([-0.16, 0.66, 0.0]))
        .body(touching("right", sheet(7, 0.3), 0.02).at([0.16, 0.66, 0.0]))
        .collider(Collider::mesh(ball(0.2)).friction(0.4).offset(0.01))
        .time(1.0 / 60.0, STEP);
    let edge = |name: &str, col: u32| SeamSide::new(name, Select::cols(col, col));
    scene = scene.seam(Seam::new(edge("left", 6), edge("right", 0)));
    let (mut cpu, mut gpu) = both(&scene);
    let most = are_alike(&mut cpu, &mut gpu, 10);
    assert!(most > 5 && cpu.report().contacts > 0, "{most} {}", cpu.report().contacts);
}

/// Sheets one above the other, below which a box comes up and a spike turns.
pub fn pushed() -> Scene {
    let layer = |name: &str, y: f64| touching(name, sheet(9, 0.3), 0.006).at([0.0, y, 0.0]);
    let up = Keyframe {
        translate: [0.01, 0.06, 0.0],
        ..Keyframe::rotate(0.1, [0.2, 1.0, 0.1], 20.0, [0.0, -0.05, 0.0])
    };
    let turns = Keyframe::rotate(0.1, [0.0, 0.0, 1.0], 60.0, [0.1, 0.0, 0.1]);
    let spike = Mesh::Icosphere(Icosphere { radius: 0.02, subdivisions: 0 });
    let mut spike = Collider::mesh(spike).offset(0.003).keyframe(turns);
    spike.place.position = [0.05, -0.03, 0.1];
    Scene::new("pushed")
        .body(layer("held", 0.0).pin(Select::cols(0, 0)).pin(Select::cols(8, 8)))
        .body(layer("middle", 0.008))
        .body(layer("top", 0.016))
        .collider(
            Collider::cuboid([0.0, -0.05, 0.0], [0.04, 0.035, 0.05]).offset(0.004).friction(0.5).keyframe(up),
        )
        .collider(spike)
        .time(1.0 / 60.0, STEP)
}

/// After thirty frames no more rounds are written down than they needed; a frame that needs more is repeated.
#[test]
fn no_bits_depend_on_how_many_rounds_are_written_down() {
    let low = touching("low", sheet(6, 0.2), 0.006).pin(Select::cols(0, 0)).pin(Select::cols(5, 5));
    let high = touching("high", sheet(5, 0.15), 0.006);
    let mut scene = Scene::new("falls late").body(low).body(high.at([0.007, 0.35, 0.011]));
    scene = scene.time(1.0 / 120.0, 1.0 / 240.0);
    let (mut cpu, mut gpu) = both(&scene);
    // It falls for a quarter of a second, and lands when little is written down.
    run(&mut cpu, 31);
    run(&mut gpu, 31);
    assert_eq!(cpu.report().pairs, 0);
    assert!(are_alike(&mut cpu, &mut gpu, 8) > 20);
}

/// What is in the way of a collider goes along with it, in several parts of its motion, and pushes what is above.
#[test]
fn colliders_that_move_carry_cloth_as_on_the_cpu() {
    let (mut cpu, mut gpu) = both(&pushed());
    assert!(are_alike(&mut cpu, &mut gpu, 7) > 300);
    assert_eq!(cpu.intersections().pairs, 0);
    // Where it has come to rest, and in a snapshot of that.
    go_on_from_snapshots(&pushed(), &mut cpu, &gpu);
}

#[test]
fn a_collider_that_a_program_moves_carries_cloth_as_on_the_cpu() {
    let scene = Scene::new("lifted")
        .body(touching("held", sheet(9, 0.3), 0.006).pin(Select::cols(0, 0)).pin(Select::cols(8, 8)))
        .body(touching("top", sheet(9, 0.3), 0.006).at([0.0, 0.008, 0.0]))
        .collider(Collider::cuboid([0.0, -0.05, 0.0], [0.05, 0.04, 0.05]).offset(0.004).named("lift"))
        .time(1.0 / 60.0, STEP);
    let lift = |simulation: &mut Simulation, by: f64| {
        let lift = simulation.collider("lift").expect("its name");
        simulation
            .move_collider(lift, Pose { translate: [0.0, by, 0.0], ..Pose::default() })
            .expect("finite");
    };
    let (mut cpu, mut gpu) = both(&scene);
    are_alike(&mut cpu, &mut gpu, 1);
    for frame in 1..4 {
        lift(&mut cpu, 0.03 * f64::from(frame));
        lift(&mut gpu, 0.03 * f64::from(frame));
        are_alike(&mut cpu, &mut gpu, 1);
    }
    assert!(are_alike(&mut cpu, &mut gpu, 1) > 20);
}

/// Sheets that cross each other and a box that turns.
pub fn crossed() -> Scene {
    let sloping = Rotation { axis: [0.0, 0.0, 1.0], degrees: 14.0 };
    let mut over = touching("over", sheet(11, 0.25), 0.006).at([0.01, 0.004, 0.0]);
    over.place.rotation = Some(sloping);
    let turns = Keyframe::rotate(0.5, [0.0, 1.0, 0.0], 20.0, [0.0; 3]);
    Scene::new("crossed")
        .body(touching("under", sheet(9, 0.3), 0.008).pin(Select::cols(0, 0)).pin(Select::cols(8, 8)))
        .body(over)
        .body(touching("apart", sheet(5, 0.1), 0.006).at([0.0, 0.1, 0.0]))
        .collider(Collider::cuboid([0.0, -0.06, 0.0], [0.03, 0.02, 0.03]).offset(0.003).keyframe(turns))
        .time(1.0 / 60.0, STEP)
}

/// It is counted in every frame, also after a snapshot, and where a program puts vertices elsewhere.
#[test]
fn surfaces_that_start_through_each_other_come_apart_as_on_the_cpu() {
    let (mut cpu, mut gpu) = both(&crossed());
    let counts = |cpu: &Simulation, gpu: &Simulation| {
        let [of_cpu, of_gpu] = [cpu, gpu].map(|one| one.report().intersections);
        assert_eq!(of_cpu, of_gpu);
        of_cpu
    };
    assert!(counts(&cpu, &gpu).is_some_and(|count| count > 20), "{:?}", cpu.report().intersections);
    are_alike(&mut cpu, &mut gpu, 4);
    assert!(counts(&cpu, &gpu).is_some_and(|count| count > 0), "{:?}", cpu.report().intersections);
    assert!(gpu.snapshot().is_tangled);
    go_on_from_snapshots(&crossed(), &mut cpu, &gpu);
    run(&mut gpu, 2);
    while counts(&cpu, &gpu).is_some() && cpu.frame() < 40 {
        are_alike(&mut cpu, &mut gpu, 1);
    }
    assert_eq!((counts(&cpu, &gpu), cpu.intersections().pairs), (None, 0), "frame {}", cpu.frame());
    cpu.disturb(0.006, 1);
    gpu.disturb(0.006, 1);
    are_alike(&mut cpu, &mut gpu, 1);
    assert!(counts(&cpu, &gpu).is_some_and(|count| count > 0), "{:?}", cpu.report().intersections);
}

/// A sheet across a ball and a box, another one above them, and a plane below.
fn across() -> Scene {
    let spike = Mesh::Icosphere(Icosphere { radius: 0.03, subdivisions: 1 });
    let mut spike = Collider::mesh(spike).offset(0.003);
    spike.place.position = [-0.08, 0.0, 0.06];
    Scene::new("across")
        .body(touching("across", sheet(10, 0.3), 0.006))
        .body(touching("above", sheet(6, 0.2), 0.006).at([0.0, 0.05, 0.0]))
        .collider(Collider::cuboid([0.06, 0.004, 0.02], [0.04, 0.03, 0.04]).offset(0.004).friction(0.3))
        .collider(Collider::sphere([-0.05, -0.005, -0.08], 0.04).offset(0.004))
        .collider(spike)
        .collider(Collider::plane([0.0, -0.06, 0.0], [0.0, 1.0, 0.0]))
        .time(1.0 / 60.0, STEP)
}

/// Nodes inside colliders leave them together, which leave them alone; so do those that a program puts there.
#[test]
fn cloth_that_starts_across_colliders_leaves_them_as_on_the_cpu() {
    let (mut cpu, mut gpu) = both(&across());
    assert!(cpu.intersections().pairs > 20);
    are_alike(&mut cpu, &mut gpu, 3);
    assert!(gpu.snapshot().is_tangled);
    go_on_from_snapshots(&across(), &mut cpu, &gpu);
    run(&mut gpu, 2);
    while cpu.report().intersections.is_some() && cpu.frame() < 40 {
        are_alike(&mut cpu, &mut gpu, 1);
    }
    assert_eq!((cpu.intersections().pairs, gpu.snapshot().is_tangled), (0, false), "frame {}", cpu.frame());
    cpu.disturb(0.03, 1);
    gpu.disturb(0.03, 1);
    are_alike(&mut cpu, &mut gpu, 2);
}

/// One body touches by triangles, another one by nodes: both lie on a ball.
#[test]
fn both_forms_of_contact_stand_beside_each_other_as_on_the_cpu() {
    let folded = Body { self_collision: None, ..touching("folded", sheet(25, 0.5), 0.01) };
    let scene = Scene::new("forms")
        .body(touching("triangles", sheet(9, 0.25), 0.008).at([0.0, 0.11, 0.0]))
        .body(folded.clone().collide_nodes(0.018).at([0.0, 0.13, 0.1]))
        .body(Body { name: "upper".into(), ..folded.collide_nodes(0.018) }.at([0.0, 0.142, 0.1]))
        .collider(Collider::sphere([0.0; 3], 0.1).offset(0.004).friction(0.3))
        .time(1.0 / 60.0, STEP);
    let (mut cpu, mut gpu) = both(&scene);
    for frame in 1..=8 {
        run(&mut cpu, 1);
        run(&mut gpu, 1);
        assert_eq!(farthest(&positions(&cpu), &positions(&gpu)), 0.0, "frame {frame}");
    }
    assert!(cpu.report().contacts > 20 && cpu.report().pairs > 0, "{:?}", cpu.report());
}
