//! Bodies that are drawn where they are simulated, on a software adapter where there is no other.

use crate::common::{running, set, sheet};
use crate::picture::{cloth_material, difference, rendering, rendering_with, start};
use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::scene;
use bevy_taffeta::{DeviceChoice, DrawMethod, OnDivergence, SharedGpu};

const SHARED: RunOn = RunOn {
    device: DeviceChoice::Gpu,
    draw: DrawMethod::Shared,
    threads: None,
    report_every: 120,
    on_divergence: OnDivergence::Freeze,
};
const COPIED: RunOn = RunOn { draw: DrawMethod::Copied, ..SHARED };
const ON_CPU: RunOn = RunOn { device: DeviceChoice::Cpu, ..SHARED };

/// How often memory was mapped for the program to read.
fn reads(app: &App) -> u64 {
    app.world().resource::<SharedGpu>().get().map_or(0, |gpu| gpu.reads())
}

/// Changes of meshes so far.
#[derive(Resource, Default)]
struct Changes(usize);

fn count_changes(mut events: MessageReader<AssetEvent<Mesh>>, mut changes: ResMut<Changes>) {
    changes.0 += events.read().count();
}

#[test]
fn a_hundred_thousand_vertices_never_leave_the_gpu() {
    let mut app = rendering(Vec3::new(0.0, 1.0, 2.5));
    app.init_resource::<Changes>().add_systems(Last, count_changes);
    set(&mut app, SoftWorld { time: scene::Time { max_step: None, ..default() }, ..default() });
    set(&mut app, SHARED);
    let material = cloth_material(&mut app);
    app.world_mut().spawn((
        Cloth::grid(250, 400, Vec2::new(1.6, 1.0)),
        SoftMaterial::new(Mass::Node(0.01)).structural(20.0, 0.02).shear(5.0, 0.02),
        Pins::hold(Select::nodes([0, 399])),
        material,
    ));
    start(&mut app);
    let first = crate::picture::picture(&mut app);
    assert!(running(&mut app).is_shared());
    let before = (reads(&app), app.world().resource::<Changes>().0);
    assert!(before.0 > 0 && before.1 > 0, "counters count: {before:?}");
    crate::common::run(&mut app, 24);
    assert_eq!(running(&mut app).simulation().frame(), 24);
    assert_eq!((reads(&app), app.world().resource::<Changes>().0), before);
    let last = crate::picture::picture(&mut app);
    assert!(difference(&first, &last) > 0.1, "{}", difference(&first, &last));
}

#[test]
fn what_is_shared_looks_like_what_is_copied_and_like_what_the_cpu_simulates() {
    let mut pictures = Vec::new();
    let eye = Vec3::new(0.0, 0.2, 1.5);
    for (on, pipelined) in [(SHARED, false), (COPIED, false), (ON_CPU, false), (SHARED, true)] {
        let mut app = if pipelined { rendering_with(eye, |all| all) } else { rendering(eye) };
        set(&mut app, on);
        let material = cloth_material(&mut app);
        app.world_mut().spawn((sheet(), material, Transform::from_xyz(0.0, 0.3, 0.0)));
        start(&mut app);
        crate::common::run(&mut app, 25);
        assert_eq!(running(&mut app).is_shared(), on == SHARED);
        pictures.push(crate::picture::picture(&mut app));
    }
    for other in &pictures[1..] {
        assert!(difference(&pictures[0], other) < 0.005, "{}", difference(&pictures[0], other));
    }
}

#[test]
fn the_way_to_the_screen_may_change_while_a_world_runs() {
    let mut app = rendering(Vec3::new(0.0, 0.2, 1.5));
    set(&mut app, SHARED);
    let material = cloth_material(&mut app);
    app.world_mut().spawn((sheet(), material, Transform::from_xyz(0.0, 0.3, 0.0)));
    start(&mut app);
    let mut pictures = Vec::new();
    crate::common::run(&mut app, 20);
    for on in [SHARED, COPIED, ON_CPU, SHARED] {
        set(&mut app, on);
        set(&mut app, Playback { paused: true, ..default() });
        crate::common::run(&mut app, 2);
        assert_eq!(running(&mut app).simulation().frame(), 20);
        assert_eq!(running(&mut app).is_shared(), on == SHARED);
        pictures.push(crate::picture::picture(&mut app));
    }
    for other in &pictures[1..] {
        assert!(difference(&pictures[0], other) < 0.03, "{}", difference(&pictures[0], other));
    }
}

#[test]
fn a_shared_body_that_diverges_is_told_of_with_the_next_report() {
    let mut app = rendering(Vec3::new(0.0, 0.2, 1.5));
    set(&mut app, RunOn { report_every: 16, ..SHARED });
    let material = cloth_material(&mut app);
    let stiff = SoftMaterial::new(Mass::Node(1e-4)).structural(1e5, 0.0);
    app.world_mut().spawn((sheet(), material)).insert(stiff);
    start(&mut app);
    running(&mut app).simulation_mut().disturb(1e-3, 1);
    let mut said = Vec::new();
    for _ in 0..33 {
        app.update();
        let messages = app.world().resource::<Messages<Frozen>>();
        said.extend(messages.iter_current_update_messages().map(|one| one.why.to_string()));
    }
    assert_eq!(said.len(), 1);
    assert!(said[0].starts_with("by frame 16 (frame 0 was good): "), "{}", said[0]);
    assert!(said[0].contains("sub-steps of 2.2e-5 s or less"), "{}", said[0]);
}
