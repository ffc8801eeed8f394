//! Bodies and colliders that come, go, move and change while their world runs.

use crate::common::{FRAME, drawn, messages, plain, positions, ready, run, running, set, sheet, with_sheet};
use bevy::ecs::system::RunSystemOnce;
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::scene::{Body, Keyframe, Material, Scene, World};
use bevy_taffeta::{
    BodyVelocity, OnDivergence, Running, SceneMaterials, collider_mesh, spawn_scene, taffeta, taffeta_io,
};
use std::path::{Path, PathBuf};

#[test]
fn a_sheet_hangs_in_its_corners_and_starts_where_its_transform_is() {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let turn = Quat::from_rotation_x(0.5);
    let at = Transform { translation: Vec3::new(1.0, 2.0, 3.0), rotation: turn, scale: Vec3::splat(2.0) };
    let entity = app.world_mut().spawn((sheet(), at)).id();
    ready(&mut app);
    let start = positions(&mut app);
    assert!(start[0].abs_diff_eq(at.transform_point(Vec3::new(-0.3, 0.0, -0.25)), 1e-6));
    run(&mut app, 30);
    let now = positions(&mut app);
    assert_eq!((now[0], now[6]), (start[0], start[6]));
    assert!(now[38].y < start[38].y - 0.3);
    // The mesh is drawn in the entity's own coordinates.
    let places = drawn(&app, entity);
    assert!(at.transform_point(places[0]).abs_diff_eq(start[0], 1e-5));
    assert!(at.transform_point(places[38]).abs_diff_eq(now[38], 1e-5));
}

#[test]
fn a_world_stands_still_goes_slowly_and_goes_by_single_frames() {
    let (mut app, _) = with_sheet();
    run(&mut app, 10);
    assert_eq!(running(&mut app).simulation().frame(), 10);
    set(&mut app, Playback { paused: true, single_frames: 3, ..default() });
    run(&mut app, 10);
    assert_eq!(running(&mut app).simulation().frame(), 13);
    set(&mut app, Playback { speed: 0.25, ..default() });
    run(&mut app, 40);
    assert_eq!(running(&mut app).simulation().frame(), 23);
    app.world_mut().resource_mut::<Time<Virtual>>().pause();
    run(&mut app, 5);
    assert_eq!(running(&mut app).simulation().frame(), 23);
}

#[test]
fn nothing_is_copied_while_time_stands_still() {
    let (mut app, _) = with_sheet();
    set(&mut app, Playback { paused: true, ..default() });
    run(&mut app, 2);
    app.world_mut().resource_mut::<Messages<AssetEvent<Mesh>>>().clear();
    run(&mut app, 3);
    assert_eq!(app.world().resource::<Messages<AssetEvent<Mesh>>>().len(), 0);
    set(&mut app, Playback::default());
    run(&mut app, 1);
    assert_eq!(app.world().resource::<Messages<AssetEvent<Mesh>>>().len(), 1);
}

#[test]
fn a_slow_program_takes_several_frames_at_once_but_no_more_than_it_may() {
    let (mut app, _) = with_sheet();
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(std::time::Duration::from_secs_f64(
        2.5 * FRAME,
    )));
    run(&mut app, 2);
    assert_eq!(running(&mut app).simulation().frame(), 5);
    set(&mut app, Playback { speed: 100.0, ..default() });
    run(&mut app, 1);
    assert_eq!(running(&mut app).simulation().frame(), 9);
}

#[test]
fn bodies_are_drawn_between_their_last_two_states() {
    let (mut app, entity) = with_sheet();
    run(&mut app, 10);
    let before = positions(&mut app);
    let clock = std::time::Duration::from_secs_f64(0.25 * FRAME);
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(clock));
    run(&mut app, 1);
    let now = positions(&mut app);
    let (drawn, between) = (drawn(&app, entity)[38], before[38].lerp(now[38], 0.25));
    assert!(before[38].distance(now[38]) > 1e-3);
    assert!(drawn.abs_diff_eq(between, 1e-6), "{drawn}, not {between}");
}

#[test]
fn a_collider_that_changes_its_shape_is_drawn_in_the_pose_of_the_simulations_time() {
    let (mut app, _) = with_sheet();
    let shape = taffeta::scene::Mesh::grid(2, 3, [0.4, 0.4]);
    let flat = taffeta::topology::shapes::surface(&shape).unwrap().nodes;
    // In a quarter of a second it tilts by atan 2 about z, then it stays.
    let tilted = |slope: f64| flat.iter().map(|&[x, _, z]| [x, slope * x, z]).collect::<Vec<_>>();
    let shape =
        taffeta::scene::Collider::mesh(shape).offset(0.01).posed(0.25, vec![tilted(0.0), tilted(2.0)]);
    let at = Transform {
        translation: Vec3::new(1.0, -2.0, 0.5),
        rotation: Quat::from_rotation_y(0.6),
        scale: Vec3::splat(2.0),
    };
    let mesh = collider_mesh(&shape).unwrap();
    let mesh = app.world_mut().resource_mut::<Assets<Mesh>>().add(mesh);
    let collider = app.world_mut().spawn((SoftCollider(shape), Mesh3d(mesh), at)).id();
    for frames in [6, 6, 10] {
        run(&mut app, frames);
        let time = f64::from(running(&mut app).simulation().frame()) * FRAME;
        let expected = tilted(2.0 * (time / 0.25).min(1.0));
        for (place, node) in drawn(&app, collider).iter().zip(&expected) {
            assert!(place.abs_diff_eq(Vec3::from(node.map(|x| x as f32)), 1e-5), "{place}, not {node:?}");
        }
        let mesh = app.world().get::<Mesh3d>(collider).unwrap().0.clone();
        let mesh = app.world().resource::<Assets<Mesh>>().get(&mesh).unwrap();
        let normal = mesh.attribute(Mesh::ATTRIBUTE_NORMAL).and_then(|all| all.as_float3()).unwrap()[0];
        let across = Vec3::new(-2.0 * (time / 0.25).min(1.0) as f32, 1.0, 0.0).normalize();
        assert!(Vec3::from(normal).abs_diff_eq(across, 1e-5), "{normal:?}, not {across}");
    }
}

#[test]
fn a_collider_on_keyframes_stays_on_them_when_its_world_is_built_anew() {
    let heights = [false, true].map(|anew| {
        let (mut app, _) = with_sheet();
        let ball = SoftCollider::sphere(0.1).0.keyframe(Keyframe::translate(0.5, [0.0, 0.4, 0.0]));
        let ball = app.world_mut().spawn((SoftCollider(ball), Transform::from_xyz(0.0, -2.0, 0.0))).id();
        run(&mut app, 15);
        if anew {
            set(&mut app, SoftWorld::default());
        }
        run(&mut app, 10);
        app.world().get::<Transform>(ball).expect("a place").translation.y
    });
    assert_eq!(heights[0], heights[1]);
    assert!(heights[0] > -1.75 && heights[0] < -1.6, "{heights:?}");
}

#[test]
fn a_body_that_comes_or_goes_does_not_disturb_the_others() {
    let (mut alone, _) = with_sheet();
    let (mut app, _) = with_sheet();
    run(&mut alone, 5);
    run(&mut app, 5);
    let other = app.world_mut().spawn((sheet(), Transform::from_xyz(3.0, 0.0, 0.0))).id();
    run(&mut alone, 5);
    run(&mut app, 5);
    let (both, one) = (positions(&mut app), positions(&mut alone));
    assert_eq!((both.len(), &both[..42]), (84, &one[..]));
    assert!(both[84 - 1].y < -0.03);
    app.world_mut().despawn(other);
    run(&mut alone, 5);
    run(&mut app, 5);
    assert_eq!(positions(&mut app), positions(&mut alone));
    assert_eq!(running(&mut app).simulation().frame(), 15);
}

#[test]
fn the_last_body_takes_the_simulation_with_it_and_a_new_one_starts_at_once() {
    let (mut app, entity) = with_sheet();
    run(&mut app, 5);
    app.world_mut().despawn(entity);
    run(&mut app, 2);
    assert_eq!(app.world_mut().query::<&Running>().iter(app.world()).count(), 0);
    app.world_mut().spawn(sheet());
    run(&mut app, 2);
    assert_eq!(running(&mut app).simulation().frame(), 2);
}

#[test]
fn a_world_starts_again_where_running_is_removed() {
    let (mut app, _) = with_sheet();
    let start = positions(&mut app);
    run(&mut app, 5);
    let mut query = app.world_mut().query_filtered::<Entity, With<Running>>();
    let world = query.single(app.world()).expect("a world");
    app.world_mut().entity_mut(world).remove::<Running>();
    set(&mut app, Playback { paused: true, ..default() });
    run(&mut app, 1);
    assert_eq!(positions(&mut app), start);
}

#[test]
fn parameters_may_change_while_a_world_runs() {
    let (mut app, entity) = with_sheet();
    run(&mut app, 60);
    let soft = running(&mut app).simulation().report().max_stretch;
    let mut material = app.world_mut().get_mut::<SoftMaterial>(entity).expect("it");
    *material = material.clone().structural(200.0, 0.02);
    run(&mut app, 60);
    assert_eq!(running(&mut app).simulation().frame(), 120);
    assert!(running(&mut app).simulation().report().max_stretch - 1.0 < 0.5 * (soft - 1.0));
    set(&mut app, Environment(World { gravity: [0.0, 9.81, 0.0], ..World::default() }));
    let frames = (0..60).take_while(|_| {
        app.update();
        positions(&mut app)[38].y < 0.1
    });
    let frames = frames.count() as u32;
    assert!(frames < 60, "it falls upwards");
    // Air comes to a world that was built without: it is built again, and goes on.
    set(&mut app, Environment(World { air: Some(default()), ..World::default() }));
    run(&mut app, 1);
    assert_eq!(running(&mut app).simulation().frame(), 122 + frames);
}

/// Too stiff for its steps.
fn tin() -> (impl Bundle, SoftMaterial) {
    ((sheet(), Name::new("tin")), SoftMaterial::new(Mass::Node(1e-4)).structural(1e5, 0.0))
}

#[test]
fn a_body_that_diverges_is_named_and_stands_still_while_the_others_go_on() {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let good = app.world_mut().spawn((sheet(), Transform::from_xyz(5.0, 0.0, 0.0))).id();
    let (sheet, stiff) = tin();
    let tin = app.world_mut().spawn(sheet).insert(stiff).id();
    ready(&mut app);
    running(&mut app).simulation_mut().disturb(1e-3, 1);
    let frozen = (0..60).find_map(|_| {
        app.update();
        let frozen = messages::<Frozen>(&app);
        let [Frozen { body, why, .. }] = frozen[..] else { return None };
        assert!(why.to_string().contains("sub-steps of 2.2e-5 s or less"), "{why}");
        Some(*body)
    });
    assert_eq!(frozen, Some(tin));
    let (before, frame) = (positions(&mut app), running(&mut app).simulation().frame());
    run(&mut app, 5);
    let after = positions(&mut app);
    assert!(messages::<Frozen>(&app).is_empty() && messages::<Diverged>(&app).is_empty());
    assert_eq!(running(&mut app).simulation().frame(), frame + 5);
    let half = before.len() / 2;
    assert!(after[..half] != before[..half] && after[half..] == before[half..]);
    // With other springs it goes on from where it is.
    let held = app.world().get::<SoftMaterial>(good).expect("it").clone();
    app.world_mut().entity_mut(tin).insert(held);
    run(&mut app, 5);
    assert_eq!(running(&mut app).simulation().frame(), frame + 10);
    assert!(positions(&mut app)[half..] != after[half..]);
}

#[test]
fn a_world_that_diverges_says_so_in_the_engines_words_and_is_not_drawn_any_more() {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let (sheet, stiff) = tin();
    let entity = app.world_mut().spawn(sheet).insert(stiff).id();
    set(&mut app, RunOn { on_divergence: OnDivergence::Stop, ..default() });
    ready(&mut app);
    running(&mut app).simulation_mut().disturb(1e-3, 1);
    for _ in 0..60 {
        app.update();
        if let [diverged] = messages::<Diverged>(&app)[..] {
            let said = diverged.error.to_string();
            assert!(said.contains("body `tin`") && said.contains("sub-steps of 2.2e-5 s or less"), "{said}");
            assert_eq!(diverged.body, Some(entity));
            assert!(running(&mut app).is_halted());
            assert!(drawn(&app, entity).iter().all(|place| place.is_finite()));
            // With other springs it starts again.
            app.world_mut().entity_mut(entity).insert(SoftMaterial::default());
            run(&mut app, 3);
            assert_eq!(running(&mut app).simulation().frame(), 3);
            return;
        }
    }
    panic!("it held");
}

#[test]
fn worlds_are_apart() {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let weightless = Environment(World { gravity: [0.0; 3], ..World::default() });
    let world = app.world_mut().spawn((SoftWorld::default(), weightless)).id();
    let [heavy, light] = [None, Some(world)].map(|parent| {
        let sheet = app.world_mut().spawn(sheet()).id();
        if let Some(parent) = parent {
            app.world_mut().entity_mut(sheet).insert(ChildOf(parent));
        }
        sheet
    });
    ready(&mut app);
    run(&mut app, 10);
    let lowest = |app: &mut App, body: Entity| {
        let mut query = app.world_mut().query::<&Running>();
        let running = query.iter(app.world()).find(|one| one.body_of(body).is_some()).expect("its world");
        let mut places: Vec<[f32; 3]> = Vec::new();
        running.simulation().positions_f32(&mut places);
        places.iter().map(|x| x[1]).fold(0.0, f32::min)
    };
    assert!(lowest(&mut app, heavy) < -0.05);
    assert_eq!(lowest(&mut app, light), 0.0);
}

#[test]
fn a_collider_with_keyframes_takes_its_entity_along() {
    let (mut app, _) = with_sheet();
    let lifted = Keyframe::translate(0.5, [0.0, 1.0, 0.0]);
    let below = taffeta::scene::Collider::sphere([0.0, -5.0, 0.0], 0.1).keyframe(lifted);
    let ball = app.world_mut().spawn(SoftCollider(below)).id();
    run(&mut app, 60);
    assert!(app.world().get::<Transform>(ball).expect("it").translation.abs_diff_eq(Vec3::Y, 1e-6));
}

#[test]
fn a_scene_file_runs_as_the_engine_runs_it() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let scene = taffeta_io::load_scene(&folder.join("flag.toml"), &[]).expect("a scene").scene;
    let mut simulation = taffeta::Simulation::new(&scene, &default()).expect("a simulation");
    let mut app = App::new();
    let assets = AssetPlugin { file_path: folder.display().to_string(), ..default() };
    app.add_plugins((MinimalPlugins, TransformPlugin, assets, bevy::mesh::MeshPlugin, TaffetaPlugin));
    app.init_asset::<StandardMaterial>();
    let mut app = crate::common::clocked(app);
    let handle = app.world().resource::<AssetServer>().load::<SoftScene>("flag.toml");
    let root = app.world_mut().spawn((SoftSceneRoot(handle), SceneMaterials::default())).id();
    app.insert_resource(bevy::time::TimeUpdateStrategy::ManualDuration(std::time::Duration::from_secs_f64(
        scene.time.dt,
    )));
    ready(&mut app);
    for _ in 0..10_000 {
        app.update();
        if app.world().get::<Running>(root).is_some() {
            break;
        }
        std::thread::yield_now();
    }
    run(&mut app, 5);
    let ours = app.world().get::<Running>(root).expect("it was loaded").simulation();
    simulation.advance(ours.frame()).expect("it holds");
    assert!(ours.frame() >= 5);
    assert_eq!(ours.state_hash(), simulation.state_hash());
    let mut drawn = app.world_mut().query::<(&Cloth, &Mesh3d, &MeshMaterial3d<StandardMaterial>)>();
    assert_eq!(drawn.iter(app.world()).count(), 1);
}

#[test]
fn a_body_of_a_scene_keeps_its_fabric_and_its_velocity() {
    let cotton = Body::cloth("sheet", taffeta::scene::Mesh::grid(5, 6, [0.5, 0.4]));
    let cotton = cotton.with_material(Material::preset("cotton"));
    let thrown = Body { velocity: [1.0, 2.0, 0.0], angular_velocity: [0.0, 3.0, 1.0], ..cotton };
    let scene = Scene::new("thrown").time(FRAME, 1e-4).body(thrown);
    let mut simulation = taffeta::Simulation::new(&scene, &default()).expect("a simulation");
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let root = app.world_mut().spawn_empty().id();
    let spawn = move |mut commands: Commands, mut meshes: ResMut<Assets<Mesh>>| {
        spawn_scene(&mut commands, root, &scene, &SceneMaterials::default(), &mut meshes);
    };
    app.world_mut().run_system_once(spawn).expect("it runs");
    ready(&mut app);
    run(&mut app, 5);
    let running = app.world().get::<Running>(root).expect("it runs");
    let ours = running.simulation();
    assert!(ours.frame() >= 5);
    simulation.advance(ours.frame()).expect("it holds");
    assert_eq!(ours.state_hash(), simulation.state_hash());
    assert_eq!(running.scene().bodies[0].area_density, None);
}

#[test]
fn a_body_is_thrown_as_its_transform_is_turned() {
    let mut app = plain();
    app.add_plugins(TaffetaPlugin);
    let velocity = BodyVelocity { linear: [1.0, 0.0, 0.0], angular: [0.0, 2.0, 0.0] };
    let turned = Transform::from_rotation(Quat::from_rotation_z(std::f32::consts::FRAC_PI_2));
    app.world_mut().spawn((sheet(), turned, velocity));
    ready(&mut app);
    run(&mut app, 1);
    let body = running(&mut app).scene().bodies[0].clone();
    let near = |a: [f64; 3], b: [f64; 3]| a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-6);
    assert!(near(body.velocity, [0.0, 1.0, 0.0]), "{:?}", body.velocity);
    assert!(near(body.angular_velocity, [-2.0, 0.0, 0.0]), "{:?}", body.angular_velocity);
}

#[test]
fn every_body_and_collider_of_every_scene_is_an_entity_that_can_be_seen() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let files = |folder: &Path| -> Vec<PathBuf> {
        let files = std::fs::read_dir(folder).expect("scenes").map(|file| file.expect("a file").path());
        files.filter(|file| file.extension().is_some_and(|extension| extension == "toml")).collect()
    };
    let mut count = 0;
    for file in files(&folder).into_iter().chain(files(&folder.join("contact"))) {
        let scene = taffeta_io::load_scene(&file, &[]).expect("a scene").scene;
        let mut app = plain();
        let root = app.world_mut().spawn_empty().id();
        let (bodies, colliders) = (scene.bodies.len(), scene.colliders.len());
        let spawn =
            move |mut commands: Commands,
                  mut all: (ResMut<Assets<Mesh>>, ResMut<Assets<StandardMaterial>>)| {
                let materials = SceneMaterials::default().filled(&mut all.1);
                spawn_scene(&mut commands, root, &scene, &materials, &mut all.0);
            };
        app.world_mut().run_system_once(spawn).expect("it runs");
        let mut seen = app.world_mut().query::<(&SoftCollider, &Mesh3d, &MeshMaterial3d<StandardMaterial>)>();
        assert_eq!(seen.iter(app.world()).count(), colliders, "{}", file.display());
        let mut seen = app.world_mut().query::<(&Pins, &SoftMaterial, &MeshMaterial3d<StandardMaterial>)>();
        assert_eq!(seen.iter(app.world()).count(), bodies, "{}", file.display());
        count += 1;
    }
    assert!(count > 20, "{count} scenes");
}
