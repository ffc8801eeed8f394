//! Checkpoints: whole, or refused with the reason.

use taffeta::scene::{Body, Collider, ConstraintForm, Internal, Mass, Mesh, Method, Poses, Scene, Select};
use taffeta::{Options, Simulation, Snapshot};
use taffeta_io::Checkpoint;
use taffeta_io::checkpoint::{difference, identity};

fn scene() -> Scene {
    let body = Body::cloth("sheet", Mesh::grid(3, 4, [0.3, 0.2])).with_mass(Mass::Node(0.1));
    Scene::new("title").time(0.01, 0.002).method(Method::Acad).body(body.structural(40.0, 0.1))
}

fn checkpoint() -> Checkpoint<Vec<u32>> {
    let mut simulation = Simulation::new(&scene(), &Options::default()).unwrap();
    simulation.step().unwrap();
    Checkpoint { scene: identity(&scene()), snapshot: simulation.snapshot(), run: vec![3, 1, 4] }
}

fn bytes(checkpoint: &Checkpoint<Vec<u32>>) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c");
    checkpoint.write(&path).unwrap();
    assert_eq!(&Checkpoint::<Vec<u32>>::read(&path).unwrap(), checkpoint);
    assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 1, "a part is left");
    std::fs::read(&path).unwrap()
}

#[test]
fn springs_solved_for_by_nodes_go_on_bit_by_bit() {
    let mut scene = scene().method(Method::Ice);
    scene.bodies = scene.bodies.into_iter().map(|body| body.pin(Select::nodes([0]))).collect();
    scene.solver.ice.form = ConstraintForm::Primal;
    let run = |simulation: &mut Simulation| {
        simulation.advance(3).unwrap();
        (simulation.state_hash(), simulation.report().solver)
    };
    let mut whole = Simulation::new(&scene, &Options::default()).unwrap();
    run(&mut whole);
    let first = Checkpoint { scene: identity(&scene), snapshot: whole.snapshot(), run: vec![1] };
    let read = Checkpoint::<Vec<u32>>::parse(&bytes(&first)).unwrap();
    let mut goes_on = Simulation::new(&scene, &Options::default()).unwrap();
    goes_on.restore(&read.snapshot).unwrap();
    let expected = run(&mut whole);
    assert!(expected.1.iterations > 0);
    assert_eq!(run(&mut goes_on), expected);
}

#[test]
fn every_cut_and_every_flipped_bit_is_refused() {
    let whole = bytes(&checkpoint());
    for length in 0..whole.len() {
        assert!(Checkpoint::<Vec<u32>>::parse(&whole[..length]).is_err(), "{length} bytes were accepted");
    }
    for bit in 0..8 * whole.len() {
        let mut bytes = whole.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(Checkpoint::<Vec<u32>>::parse(&bytes).is_err(), "a flip of bit {bit} was accepted");
    }
    assert!(Checkpoint::<Vec<u32>>::parse(&[whole, vec![0]].concat()).is_err(), "a longer file was accepted");
}

#[test]
fn a_state_of_another_size_than_its_record_says_is_refused() {
    let mut torn = checkpoint();
    torn.snapshot.state.pop();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("c");
    torn.write(&path).unwrap();
    let error = Checkpoint::<Vec<u32>>::read(&path).unwrap_err();
    // 12 nodes of 24 bytes; 17 pulls of 4 bytes, and a bit for each of them in 3.
    assert!(error.contains("358 bytes of state for 12 nodes and 17 constraints"), "{error}");
}

#[test]
fn a_failed_write_leaves_the_earlier_checkpoint() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("none/c");
    let error = checkpoint().write(&path).unwrap_err().to_string();
    assert!(error.contains("none/c: "), "{error}");
    let path = folder.path().join("c");
    checkpoint().write(&path).unwrap();
    assert_eq!(Checkpoint::<Vec<u32>>::read(&path).unwrap(), checkpoint());
    // A folder cannot be replaced by a file, and nothing of the attempt stays.
    let path = folder.path().join("d");
    std::fs::create_dir(&path).unwrap();
    assert!(checkpoint().write(&path).is_err());
    let mut left: Vec<_> =
        std::fs::read_dir(folder.path()).unwrap().map(|one| one.unwrap().file_name()).collect();
    left.sort();
    assert_eq!(left, ["c", "d"]);
}

#[test]
fn a_scene_is_told_from_another_by_the_first_value_that_differs() {
    let was = identity(&scene());
    let said = |change: &dyn Fn(&mut Scene)| {
        let mut now = scene();
        change(&mut now);
        difference(&was, &identity(&now))
    };
    assert_eq!(said(&|_| {}), None);
    assert_eq!(said(&|s| (s.title, s.time.frames) = ("other".into(), 7)), None, "a run may go on for longer");
    assert_eq!(said(&|s| s.time.dt = 0.02).unwrap(), "`time.dt` was 0.01 and is 0.02");
    let stiffer = said(&|s| s.bodies[0].springs.structural.as_mut().unwrap().k = 41.0).unwrap();
    assert_eq!(stiffer, "`body[0].springs.structural.k` was 40.0 and is 41.0");
    assert_eq!(said(&|s| s.bodies.clear()).unwrap(), "`body[0]` was given and is not given");
}

#[test]
fn a_mesh_that_moved_by_a_bit_is_another_scene() {
    let surface = |x: f64| {
        let mut polygons = taffeta::topology::Polygons::default();
        polygons.push(&[0, 1, 2]);
        let places = vec![[x, 0.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]];
        taffeta_io::surface_from(places, polygons, None, vec![]).unwrap()
    };
    let differs = |path: &str, of: &dyn Fn(f64) -> Scene| {
        let of = |x: f64| identity(&of(x));
        assert_eq!(difference(&of(0.0), &of(0.0)), None);
        let said = difference(&of(0.0), &of(f64::EPSILON)).unwrap();
        assert!(said.starts_with(&format!("`{path}` was \"")) && said.contains(" with hash "), "{said}");
    };
    let mesh = |x: f64| Mesh::Surface(std::sync::Arc::new(surface(x)));
    let body = |mesh: Mesh| Body::cloth("b", mesh).with_mass(Mass::Node(0.1));
    let sheet = || Scene::new("mesh").body(body(Mesh::grid(3, 3, [1.0, 1.0])));
    differs("body[0].mesh.file", &|x| Scene::new("mesh").body(body(mesh(x))));
    differs("collider[0].mesh.file", &|x| sheet().collider(Collider::mesh(mesh(x))));
    differs("collider[0].convex.file", &|x| sheet().collider(Collider::convex(mesh(x))));
    differs("collider[0].poses.file", &|x| {
        let nodes = vec![std::sync::Arc::new(surface(x).nodes)];
        let poses = Poses { nodes, ..Poses::default() };
        sheet().collider(Collider { poses: Some(poses), ..Collider::mesh(mesh(0.0)) })
    });
    differs("body[0].springs.internal.file", &|x| {
        let internal = Internal { pairs: Some(vec![[0, 1 + u32::from(x > 0.0)]]), ..Internal::default() };
        let mut ball = body(Mesh::grid(3, 3, [1.0, 1.0]));
        ball.springs.internal = Some(internal);
        Scene::new("mesh").body(ball)
    });
}

#[test]
fn reports_keep_every_bit() {
    let mut exact = checkpoint();
    exact.snapshot.report.kinetic = 0.1 + 0.2;
    exact.snapshot.report.volumes = vec![None, Some(f64::MIN_POSITIVE), Some(1.0 / 3.0)];
    let Snapshot { report, .. } = Checkpoint::<Vec<u32>>::parse(&bytes(&exact)).unwrap().snapshot;
    assert_eq!(report, exact.snapshot.report);
}
