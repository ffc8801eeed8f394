//! The same scene gives the same bits for any number of threads, with any vector instructions, every time.

use crate::common::{build_as, levels, positions, run, turned};
use std::collections::BTreeMap;
use taffeta::Precision;
use taffeta::scene::{
    Body, Collider, ConstraintForm, Cube, Force, Icosphere, Internal, Keyframe, Mass, Mesh, Method, Scene,
    Select, Torque, VolumeForm,
};

fn cloth(name: &str, mesh: Mesh) -> Body {
    Body::cloth(name, mesh).with_mass(Mass::Node(0.02)).structural(90.0, 0.05).bend(30.0, 0.02)
}

/// A grid of several strips and tiles, with hinges, held at one edge.
fn wide() -> Scene {
    let body = cloth("wide", Mesh::grid(9, 2300, [230.0, 0.8])).shear(50.0, 0.02).hinge(2e-3, 1e-5);
    let mut scene = Scene::new("wide").body(body.pin(Select::rows(0, 0)));
    scene.world.drag = 0.01;
    scene
}

/// Many tiles of a mesh, with hinges, and a torque on most nodes.
fn twisted() -> Scene {
    let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 4 });
    let body = cloth("ball", mesh).hinge(1e-3, 1e-5).pin(Select::nodes([3]));
    let torque = Torque { axis: [0.3, 1.0, 0.0], value: 5.0, about: [0.0; 3] };
    Scene::new("twisted").body(body).force(Force {
        body: "ball".into(),
        select: Select::nodes((100..2500).collect::<Vec<u32>>()),
        torque: Some(torque),
        ..Force::default()
    })
}

/// Cloth, a soft cube and a chain on a ball that turns and a floor.
fn contact() -> Scene {
    let mut sheet = cloth("sheet", Mesh::grid(60, 67, [2.0, 1.8])).shear(50.0, 0.02);
    sheet.place = turned([0.2, 1.0, 0.1], 30.0, [0.0, 0.6, 0.0]);
    let mut cube = Body::soft("cube", Mesh::Cube(Cube { size: 0.4, divisions: 8 })).at([0.1, 1.0, 0.0]);
    cube.springs.internal = Some(Internal { count: 200, k: 60.0, d: 0.05, ..Internal::default() });
    let ball = Collider::sphere([0.0; 3], 0.5).keyframe(Keyframe::rotate(
        1.0,
        [1.0, 0.0, 1.0],
        90.0,
        [0.1, 0.0, 0.0],
    ));
    Scene::new("contact")
        .body(sheet)
        .body(cube.with_mass(Mass::Whole(4.0)).structural(60.0, 0.05))
        .body(cloth("chain", Mesh::chain(701, 7.0)).at([0.0, 0.4, 0.9]))
        .collider(ball)
        .collider(Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0]).restitution(0.3))
}

fn hash(scene: &Scene, precision: Precision, threads: usize) -> (u64, String) {
    let mut simulation = build_as(&scene.clone().time(0.01, 0.003), precision, threads);
    simulation.disturb(0.002, 11);
    run(&mut simulation, 6);
    (simulation.state_hash(), simulation.device())
}

/// The same cloth, a sheet and a ball that all workers share, with springs as constraints on positions.
fn by_positions() -> Scene {
    let mut scene = contact().method(Method::Xpbd);
    scene.title = "positions".into();
    let ball = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 6 });
    // So large that their first level is shared as well.
    let large = cloth("large", Mesh::grid(140, 145, [1.5, 1.5])).shear(50.0, 0.02);
    let large = large.pin(Select::nodes([3, 150]));
    scene
        .body(large.at([0.0, 2.0, 0.0]))
        .body(cloth("ball", ball).at([0.0, 4.0, 0.0]).pin(Select::nodes([7])))
}

fn scenes() -> [Scene; 4] {
    [wide(), twisted(), contact(), by_positions()]
}

/// Scenes with whatever threads share.
fn shared() -> Vec<Scene> {
    let soft = |form: ConstraintForm, method: Method| {
        let body = cloth("sheet", Mesh::grid(40, 41, [2.0, 2.0])).shear(50.0, 0.02).pin(Select::rows(0, 0));
        let beside = cloth("beside", Mesh::grid(30, 30, [1.0, 1.0])).shear(50.0, 0.02).at([0.0, -0.6, 0.0]);
        let floor = Collider::sphere([0.0, -1.2, 0.0], 0.5);
        let mut scene = Scene::new(format!("{form:?} {method:?}")).body(body).body(beside).collider(floor);
        scene.solver.ice.form = form;
        scene.method(method)
    };
    let mut nodes = contact();
    nodes.title = "nodes".into();
    nodes.bodies[0] = nodes.bodies[0].clone().collide_nodes(0.02);
    nodes.bodies[2] = nodes.bodies[2].clone().collide_nodes(0.02);
    let ball = Mesh::Icosphere(Icosphere { radius: 0.3, subdivisions: 4 });
    let ball =
        Body::soft("ball", ball).with_mass(Mass::Node(0.02)).structural(90.0, 0.05).at([0.0, 0.5, 0.0]);
    let full = Scene::new("volume")
        .body(ball.keep_volume(VolumeForm::Projected))
        .collider(Collider::plane([0.0; 3], [0.0, 1.0, 0.0]));
    let mut all = vec![nodes, full];
    all.extend(scenes());
    all.push(soft(ConstraintForm::Primal, Method::Ice));
    all.push(soft(ConstraintForm::Compliant, Method::Ice));
    all.push(soft(ConstraintForm::Compliant, Method::Acad));
    all
}

#[test]
fn the_number_of_threads_may_change_between_frames() {
    for scene in shared() {
        let hash = |counts: &[usize]| {
            let mut simulation = build_as(&scene.clone().time(0.01, 0.003), Precision::F32, 3);
            simulation.disturb(0.002, 11);
            for frame in 0..12 {
                simulation.limit_threads(counts[frame % counts.len()]);
                run(&mut simulation, 1);
            }
            simulation.state_hash()
        };
        assert_eq!(hash(&[1, 3, 3, 2, 2]), hash(&[1]), "{}", scene.title);
    }
}

#[test]
fn any_number_of_threads_gives_the_same_bits_and_every_time() {
    for scene in scenes() {
        for precision in [Precision::F32, Precision::F64] {
            let (one, _) = hash(&scene, precision, 1);
            for threads in [1, 2, 3, 8] {
                let (many, device) = hash(&scene, precision, threads);
                assert_eq!(one, many, "{}, {precision:?}, {device}", scene.title);
                assert!(device.contains(&format!("{threads} thread")), "{device}");
            }
        }
    }
}

#[test]
fn bodies_that_do_not_touch_move_as_if_each_were_alone() {
    let all = contact();
    let places = |bodies: &[Body]| {
        let scene = Scene { bodies: bodies.to_vec(), ..all.clone() };
        let mut simulation = build_as(&scene.time(0.01, 0.003), Precision::F32, 2);
        run(&mut simulation, 15);
        positions(&simulation)
    };
    let alone: Vec<_> = all.bodies.iter().flat_map(|body| places(std::slice::from_ref(body))).collect();
    assert!(alone == places(&all.bodies));
}

#[test]
fn scenes_and_precisions_differ_so_that_the_hash_says_something() {
    let hashes: Vec<u64> = scenes()
        .iter()
        .flat_map(|scene| [Precision::F32, Precision::F64].map(|precision| hash(scene, precision, 2).0))
        .collect();
    assert!((0..6).all(|i| (0..i).all(|j| hashes[i] != hashes[j])), "{hashes:?}");
}

#[test]
#[ignore = "run by the test of vector instructions, in processes of their own"]
fn prints_hashes() {
    for scene in scenes() {
        for precision in [Precision::F32, Precision::F64] {
            let (hash, device) = hash(&scene, precision, 2);
            println!("hash|{}|{precision:?}|{hash:016x}|{device}", scene.title);
        }
    }
}

/// Hashes by scene and precision of a process told to use `level`, and the levels it says it used.
fn hashes_with(level: &str) -> (BTreeMap<String, String>, Vec<String>) {
    let lines = levels::printed_with(level, "determinism::prints_hashes");
    let fields: Vec<Vec<&str>> = lines.iter().map(|line| line.split('|').collect()).collect();
    let hashes = fields.iter().map(|f| (format!("{} {}", f[0], f[1]), f[2].to_owned())).collect();
    (hashes, fields.iter().map(|f| f[3].to_owned()).collect())
}

#[test]
fn any_vector_instructions_give_the_same_bits() {
    let (plain, devices) = hashes_with("sse2");
    assert_eq!(plain.len(), 8, "{plain:?}");
    if cfg!(target_arch = "x86_64") {
        assert!(devices.iter().all(|device| device.ends_with("sse2")), "{devices:?}");
    }
    for level in levels::OTHERS {
        let (hashes, devices) = hashes_with(level);
        assert_eq!(plain, hashes, "{level}: {devices:?}");
    }
}
