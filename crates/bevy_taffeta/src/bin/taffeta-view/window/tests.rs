//! What mouse, keys and sliders do, without a window.

use super::hands;
use crate::busy::Busy;
use crate::changes::Changes;
use crate::framing::Extent;
use crate::grab::Grab;
use crate::looks::Colouring;
use crate::looks::Looks;
use crate::play::{AsRead, Notices, Restart};
use crate::save::{Source, edited, write};
use crate::stage::{StageCamera, StagePlugin, StageRoot};
use bevy::app::PluginsState;
use bevy::camera::RenderTarget;
use bevy::input::ButtonState;
use bevy::input::keyboard::{Key, KeyboardInput};
use bevy::input::mouse::MouseButtonInput;
use bevy::prelude::*;
use bevy::time::TimeUpdateStrategy;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::scene::{
    Body, Collider, ConstraintForm, Keyframe, Mesh as Shape, Method, Scene, Select,
};
use bevy_taffeta::taffeta::{Options, Simulation};
use bevy_taffeta::taffeta_io::load_scene;
use bevy_taffeta::{FromScene, OnDivergence, Running};
use std::time::Duration;

/// A sheet of 6 × 7 nodes that hangs in two corners.
fn sheet() -> Body {
    Body::cloth("sheet", Shape::grid(6, 7, [0.6, 0.5]))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .shear(20.0, 0.02)
        .pin(Select::nodes([0, 6]))
}

fn scene() -> Scene {
    Scene::new("sheet").time(1.0 / 60.0, 1e-3).body(sheet())
}

/// A viewer of a scene without a window, whose clock goes on by a frame in each update.
fn viewer(scene: &Scene) -> App {
    let simulation = Simulation::new(scene, &Options::default()).unwrap();
    let extent = Extent::of(scene, &simulation);
    let stage = StagePlugin {
        scene: scene.clone(),
        camera: extent.camera(1.5, None, None),
        extent,
        on: RunOn { on_divergence: OnDivergence::Stop, ..default() },
        playback: default(),
        target: RenderTarget::default(),
    };
    let mut app = App::new();
    app.add_plugins((MinimalPlugins, TransformPlugin, AssetPlugin::default(), bevy::mesh::MeshPlugin));
    app.add_plugins(bevy::input::InputPlugin).init_asset::<StandardMaterial>().init_asset::<Image>();
    app.add_plugins((stage, hands))
        .insert_resource(Source { path: "sheet.toml".into(), scene: scene.clone() });
    app.insert_resource(TimeUpdateStrategy::ManualDuration(Duration::from_secs_f64(1.0 / 60.0)));
    while app.plugins_state() == PluginsState::Adding {
        bevy::tasks::tick_global_task_pools_on_main_thread();
    }
    app.finish();
    app.cleanup();
    app.update();
    app
}

fn run(app: &mut App, updates: usize) {
    (0..updates).for_each(|_| app.update());
}

fn running(app: &mut App) -> Mut<'_, Running> {
    app.world_mut().query::<&mut Running>().single_mut(app.world_mut()).expect("one world")
}

fn places(app: &mut App) -> Vec<Vec3> {
    let mut places: Vec<[f32; 3]> = Vec::new();
    running(app).simulation().positions_f32(&mut places);
    places.into_iter().map(Vec3::from).collect()
}

/// Changes a component of the one entity that has it with another.
fn change<C: Component<Mutability = bevy::ecs::component::Mutable>, With_: Component>(
    app: &mut App,
    how: impl FnOnce(&mut C),
) {
    let mut query = app.world_mut().query_filtered::<&mut C, With<With_>>();
    how(&mut query.single_mut(app.world_mut()).expect("one"));
}

fn mouse(app: &mut App, state: ButtonState) {
    let window = Entity::PLACEHOLDER;
    app.world_mut().write_message(MouseButtonInput { button: MouseButton::Left, state, window });
}

fn press(app: &mut App, key_code: KeyCode) {
    for state in [ButtonState::Pressed, ButtonState::Released] {
        app.world_mut().write_message(KeyboardInput {
            key_code,
            logical_key: Key::Unidentified(bevy::input::keyboard::NativeKey::Unidentified),
            state,
            text: None,
            repeat: false,
            window: Entity::PLACEHOLDER,
        });
    }
    app.update();
}

/// From the camera to a point.
fn look_at(app: &mut App, point: Vec3) -> Ray3d {
    let mut camera = app.world_mut().query_filtered::<&GlobalTransform, With<StageCamera>>();
    let origin = camera.single(app.world()).expect("a camera").translation();
    let ray = Ray3d { origin, direction: Dir3::new(point - origin).expect("a way") };
    app.world_mut().resource_mut::<Grab>().ray = Some(ray);
    ray
}

#[test]
fn the_vertex_under_the_mouse_is_taken_follows_it_and_is_let_go() {
    let mut app = viewer(&scene());
    run(&mut app, 5);
    // What is seen is a frame behind.
    let mut seen = Vec::new();
    running(&mut app).places(&mut seen);
    look_at(&mut app, seen[38].lerp(seen[31], 0.1).lerp(seen[39], 0.05));
    let before = places(&mut app);
    mouse(&mut app, ButtonState::Pressed);
    app.update();
    assert_eq!(app.world().resource::<Grab>().held().map(|held| held.vertex), Some(38));
    // Up and aside, across the view.
    let to = before[38] + Vec3::new(0.06, 0.05, 0.0);
    let ray = look_at(&mut app, to);
    run(&mut app, 60);
    let now = places(&mut app);
    let off = (now[38] - ray.origin).cross(*ray.direction).length();
    assert!(off < 1e-4 && now[38].distance(before[38]) > 0.05, "{off} m off the ray");
    assert_eq!([now[0], now[6]], [before[0], before[6]]);
    mouse(&mut app, ButtonState::Released);
    run(&mut app, 20);
    assert!(places(&mut app)[38].distance(now[38]) > 0.02, "it swings back");
    assert!(!app.world().resource::<Grab>().holds());
}

#[test]
fn while_time_stands_still_what_is_held_waits_and_says_so() {
    let mut app = viewer(&scene());
    run(&mut app, 5);
    press(&mut app, KeyCode::Space);
    app.update();
    let before = places(&mut app);
    let mut seen = Vec::new();
    running(&mut app).places(&mut seen);
    look_at(&mut app, seen[38]);
    mouse(&mut app, ButtonState::Pressed);
    app.update();
    let ray = look_at(&mut app, seen[38] + Vec3::new(0.02, 0.01, 0.0));
    run(&mut app, 3);
    assert!(app.world().resource::<Grab>().waits);
    assert_eq!(places(&mut app), before);
    press(&mut app, KeyCode::Period);
    let off = (places(&mut app)[38] - ray.origin).cross(*ray.direction).length();
    assert!(off < 1e-4, "a frame brings it to the hand, {off} m off the ray");
    mouse(&mut app, ButtonState::Released);
    app.update();
    assert!(!app.world().resource::<Grab>().waits);
}

#[test]
fn a_collider_hides_what_is_behind_it() {
    let simulation = Simulation::new(&scene(), &Options::default()).unwrap();
    let camera = Extent::of(&scene(), &simulation).camera(1.5, None, None).translation;
    let mut free = viewer(&scene());
    let target = places(&mut free)[24];
    let between = target.lerp(camera, 0.5).as_dvec3().to_array();
    let mut hidden = viewer(&scene().collider(Collider::sphere(between, 0.05)));
    for (app, held) in [(&mut free, true), (&mut hidden, false)] {
        let mut cameras = app.world_mut().query_filtered::<&mut Transform, With<StageCamera>>();
        cameras.single_mut(app.world_mut()).unwrap().translation = camera;
        app.update();
        let target = places(app)[24];
        look_at(app, target);
        mouse(app, ButtonState::Pressed);
        app.update();
        assert_eq!(app.world().resource::<Grab>().holds(), held);
    }
}

#[test]
fn a_changed_value_reaches_the_simulation_which_goes_on_where_it_was() {
    let mut app = viewer(&scene());
    run(&mut app, 30);
    change::<Playback, StageRoot>(&mut app, |playback| playback.paused = true);
    app.update();
    let before = places(&mut app);
    change::<SoftMaterial, FromScene>(&mut app, |material| {
        material.springs.structural.as_mut().expect("springs").k = 77.0;
    });
    app.update();
    assert_eq!(running(&mut app).scene().bodies[0].springs.structural.unwrap().k, 77.0);
    assert_eq!(places(&mut app), before);
    press(&mut app, KeyCode::Period);
    app.update();
    assert!(places(&mut app) != before && running(&mut app).simulation().frame() > 25);
}

#[test]
fn where_building_takes_long_only_the_last_value_of_a_slider_is_taken_up() {
    for (at_once, builds) in [(0.0, 1), (f64::INFINITY, 3)] {
        let mut app = viewer(&scene());
        app.world_mut().resource_mut::<Changes>().at_once = at_once;
        let before = running(&mut app).built();
        for (k, edits) in [(60.0, true), (70.0, true), (80.0, false)] {
            app.world_mut().resource_mut::<Busy>().edits = edits;
            let mut bodies = app.world_mut().query::<(Entity, &mut SoftMaterial)>();
            let (body, mut material) = bodies.single_mut(app.world_mut()).expect("a body");
            material.bypass_change_detection().springs.structural.as_mut().expect("springs").k = k;
            app.world_mut().resource_mut::<Changes>().waiting.insert(body);
            app.update();
        }
        run(&mut app, 3);
        assert_eq!(running(&mut app).built() - before, builds);
        assert_eq!(running(&mut app).scene().bodies[0].springs.structural.unwrap().k, 80.0);
    }
}

#[test]
fn a_method_that_is_chosen_while_it_runs_goes_on_from_the_same_places() {
    use ConstraintForm::{Compliant, Primal};
    let mut app = viewer(&scene());
    run(&mut app, 30);
    let all = [
        (Method::Ice, Compliant),
        (Method::Ice, Primal),
        (Method::Acad, Compliant),
        (Method::Springs, Compliant),
    ];
    for (method, form) in all {
        change::<Playback, StageRoot>(&mut app, |playback| playback.paused = true);
        app.update();
        let before = places(&mut app);
        change::<SoftWorld, StageRoot>(&mut app, |world| {
            (world.solver.method, world.solver.ice.form) = (method, form);
        });
        app.update();
        assert_eq!(places(&mut app), before, "{method:?} {form:?}");
        change::<Playback, StageRoot>(&mut app, |playback| playback.paused = false);
        run(&mut app, 10);
        assert!(!running(&mut app).is_halted() && places(&mut app) != before);
        assert!(running(&mut app).simulation().report().max_stretch < 2.0, "{method:?} {form:?}");
    }
}

#[test]
fn what_the_engine_refuses_is_told_in_its_words_while_the_last_good_state_goes_on() {
    let mut app = viewer(&scene());
    let set = |app: &mut App, k: f64| {
        change::<SoftMaterial, FromScene>(app, |material| {
            material.springs.structural.as_mut().expect("springs").k = k;
        });
        run(app, 2);
    };
    set(&mut app, -1.0);
    let frame = running(&mut app).simulation().frame();
    let told = app.world().resource::<Notices>().refused.clone().expect("refused");
    assert!(told.contains("springs.structural.k") && told.contains("-1"), "{told}");
    run(&mut app, 5);
    assert_eq!(running(&mut app).simulation().frame(), frame + 5);
    set(&mut app, 60.0);
    assert_eq!(app.world().resource::<Notices>().refused, None);
}

#[test]
fn from_the_start_again_all_happens_as_it_did() {
    let lifted = Keyframe::translate(0.5, [0.0, 0.4, 0.0]);
    let scene = scene().collider(Collider::sphere([0.0, -0.4, 0.0], 0.2).keyframe(lifted));
    let mut app = viewer(&scene);
    run(&mut app, 60);
    let first = (running(&mut app).simulation().frame(), running(&mut app).simulation().state_hash());
    change::<SoftWorld, StageRoot>(&mut app, |world| world.time.frames = 7);
    run(&mut app, 3);
    app.world_mut().write_message(Restart);
    while running(&mut app).simulation().frame() != first.0 {
        app.update();
    }
    assert_eq!(running(&mut app).simulation().state_hash(), first.1);
}

#[test]
fn a_diverged_scene_stands_still_and_starts_again_with_the_values_of_the_file() {
    let mut app = viewer(&scene());
    change::<SoftMaterial, FromScene>(&mut app, |material| {
        material.springs.structural.as_mut().expect("springs").k = 1e7;
    });
    run(&mut app, 30);
    let told = app.world().resource::<Notices>().diverged.clone().expect("diverged");
    assert!(told.contains("sheet") && running(&mut app).is_halted(), "{told}");
    app.world_mut().write_message(AsRead);
    run(&mut app, 30);
    assert_eq!(app.world().resource::<Notices>().diverged, None);
    assert!(running(&mut app).simulation().frame() > 20 && !running(&mut app).is_halted());
}

#[test]
fn keys_pause_go_on_by_a_frame_and_start_again() {
    let mut app = viewer(&scene());
    run(&mut app, 5);
    press(&mut app, KeyCode::Space);
    app.update();
    let frame = running(&mut app).simulation().frame();
    run(&mut app, 5);
    assert_eq!(running(&mut app).simulation().frame(), frame);
    press(&mut app, KeyCode::KeyN);
    run(&mut app, 3);
    assert_eq!(running(&mut app).simulation().frame(), frame + 1);
    press(&mut app, KeyCode::KeyR);
    run(&mut app, 2);
    assert_eq!(running(&mut app).simulation().frame(), 0);
}

#[test]
fn colours_are_given_to_every_vertex_and_taken_away_again() {
    let mut app = viewer(&scene().collider(Collider::sphere([0.0, -0.3, 0.0], 0.2)));
    run(&mut app, 20);
    for colouring in [Colouring::Strain, Colouring::Velocity, Colouring::Contact, Colouring::Plain] {
        app.world_mut().resource_mut::<Looks>().colouring = colouring;
        run(&mut app, 2);
        let body = running(&mut app).drawn_bodies().next().unwrap().entity;
        let handle = app.world().get::<Mesh3d>(body).unwrap().0.clone();
        let mesh = app.world().resource::<Assets<Mesh>>().get(&handle).unwrap();
        let colours = mesh.attribute(Mesh::ATTRIBUTE_COLOR).map_or(0, |colours| colours.len());
        assert_eq!(colours, if colouring == Colouring::Plain { 0 } else { 42 }, "{colouring:?}");
    }
}

#[test]
fn springs_are_drawn_between_the_vertices_that_they_join() {
    let mut app = viewer(&scene());
    app.world_mut().resource_mut::<Looks>().lines = [true, true, true, false, false];
    run(&mut app, 10);
    let places = places(&mut app);
    let mut wires = app.world_mut().query_filtered::<&Mesh3d, Without<Name>>();
    let handles: Vec<_> = wires.iter(app.world()).map(|mesh| mesh.0.clone()).collect();
    let meshes = app.world().resource::<Assets<Mesh>>();
    let mut lengths = Vec::new();
    for mesh in handles.iter().filter_map(|handle| meshes.get(handle)) {
        if mesh.primitive_topology() == bevy::mesh::PrimitiveTopology::LineList {
            lengths.push(mesh.indices().unwrap().len() / 2);
            assert_eq!(mesh.count_vertices(), places.len());
        }
    }
    lengths.sort_unstable();
    // Structural 6·6 + 5·7, shear 2·5·6, edges of triangles 71 and a diagonal in each cell.
    assert_eq!(lengths, [60, 71, 101]);
}

#[test]
fn a_scene_is_saved_with_its_values_as_they_are_and_read_again() {
    let path = std::path::Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes/press_bunny.toml");
    let source = Source::read(&path, &[]).unwrap();
    let material = SoftMaterial::of(&source.scene.bodies[0]).unwrap().structural(123.0, 0.5);
    let mut world = SoftWorld { time: source.scene.time.clone(), ..default() };
    world.solver.method = Method::Ice;
    let mut environment = Environment(source.scene.world.clone());
    environment.gravity = [0.0, -1.62, 0.0];
    let scene = edited(
        &source.scene,
        (&world, &environment),
        [(&FromScene(0), &material)].into_iter(),
        [].into_iter(),
    );
    let folder = std::env::temp_dir().join(format!("taffeta-view-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let to = folder.join("saved.toml");
    let outcome = write(&scene, &to);
    let text = std::fs::read_to_string(&to).unwrap();
    let again = load_scene(&to, &[]);
    std::fs::remove_dir_all(&folder).unwrap();
    assert!(outcome.is_ok(), "{outcome:?}");
    let again = again.unwrap().scene;
    assert_eq!(again.bodies[0].springs.structural.unwrap().k, 123.0);
    assert_eq!((again.solver.method, again.world.gravity), (Method::Ice, [0.0, -1.62, 0.0]));
    // The mesh is named, not written out.
    assert!(text.contains("file = \"") && text.len() < 10_000, "{text}");
}
