//! What a frame of a cloth costs: by the engine alone, and through Bevy, drawn where it is simulated or copied.
//!
//! `cargo run --release -p bevy_taffeta --example costs -- [ROWS] [COLS] [FRAMES]`

#[path = "../tests/it/common/mod.rs"]
mod common;
#[path = "../tests/it/picture.rs"]
mod picture;

use bevy::prelude::*;
use bevy_taffeta::prelude::*;
use bevy_taffeta::taffeta::taffeta_gpu::{Choice, Gpu};
use bevy_taffeta::taffeta::{Options, Simulation, scene};
use bevy_taffeta::{DeviceChoice, DrawMethod};
use common::set;
use std::time::Instant;

/// Frames before those that are timed.
const WARM: usize = 10;

fn main() {
    let mut numbers = std::env::args().skip(1).map(|word| word.parse::<u32>().expect("a whole number"));
    let (rows, cols) = (numbers.next().unwrap_or(250), numbers.next().unwrap_or(400));
    let frames = numbers.next().unwrap_or(50) as usize;
    let gpu = Gpu::open(&Choice::from_env()).unwrap_or_else(|error| panic!("{error}"));
    println!("{rows} × {cols} nodes, 4 sub-steps a frame, {frames} frames, on {}", gpu.info());
    for (name, gpu) in [("engine, cpu", None), ("engine, gpu", Some(gpu))] {
        report(name, bare(rows, cols, gpu, frames));
    }
    for (name, device, draw) in [
        ("Bevy, nothing simulated", DeviceChoice::Cpu, None),
        ("Bevy, cpu, copied", DeviceChoice::Cpu, Some(DrawMethod::Copied)),
        ("Bevy, gpu, copied", DeviceChoice::Gpu, Some(DrawMethod::Copied)),
        ("Bevy, gpu, shared", DeviceChoice::Gpu, Some(DrawMethod::Shared)),
    ] {
        report(name, through_bevy((rows, cols), device, draw, frames));
    }
}

fn report(name: &str, mut times: Vec<f64>) {
    times.sort_by(f64::total_cmp);
    println!(
        "{name:24} {:8.2} ms a frame (median; least {:.2})",
        1e3 * times[times.len() / 2],
        1e3 * times[0]
    );
}

fn time() -> scene::Time {
    scene::Time { max_step: Some(common::FRAME / 4.0), ..default() }
}

fn material() -> SoftMaterial {
    SoftMaterial::new(Mass::Node(0.01)).structural(50.0, 0.02).shear(20.0, 0.02).bend(5.0, 0.02)
}

/// Of the engine without anything drawn; what is in flight is waited for.
fn bare(rows: u32, cols: u32, gpu: Option<Gpu>, frames: usize) -> Vec<f64> {
    let mut cloth =
        scene::Body::cloth("", scene::Mesh::grid(rows, cols, [1.6, 1.0])).with_mass(Mass::Node(0.01));
    cloth.springs = material().springs;
    let mut scene = scene::Scene::new("costs").body(cloth.pin(Select::nodes([0, cols - 1])));
    scene.time = time();
    let options = Options { gpu: gpu.map(Into::into), ..default() };
    let mut simulation = Simulation::new(&scene, &options).unwrap_or_else(|error| panic!("{error}"));
    timed(frames, || {
        simulation.step().unwrap_or_else(|error| panic!("{error}"));
    })
}

fn through_bevy(
    (rows, cols): (u32, u32),
    device: DeviceChoice,
    draw: Option<DrawMethod>,
    frames: usize,
) -> Vec<f64> {
    let mut app = picture::rendering(Vec3::new(0.0, 1.0, 2.5));
    set(&mut app, SoftWorld { time: time(), ..default() });
    set(&mut app, RunOn { device, draw: draw.unwrap_or_default(), ..default() });
    set(&mut app, Playback { paused: draw.is_none(), ..default() });
    let red = picture::cloth_material(&mut app);
    app.world_mut().spawn((
        Cloth::grid(rows, cols, Vec2::new(1.6, 1.0)),
        material(),
        Pins::hold(Select::nodes([0, cols - 1])),
        red,
    ));
    picture::start(&mut app);
    picture::picture(&mut app);
    let device = app.world().resource::<bevy::render::renderer::RenderDevice>().clone();
    timed(frames, || {
        app.update();
        device.poll(bevy::render::render_resource::PollType::wait_indefinitely()).expect("a device");
    })
}

fn timed(frames: usize, mut frame: impl FnMut()) -> Vec<f64> {
    (0..WARM).for_each(|_| frame());
    let one = |_| {
        let start = Instant::now();
        frame();
        start.elapsed().as_secs_f64()
    };
    (0..frames).map(one).collect()
}
