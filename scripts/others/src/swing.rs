//! A sheet that swings from two corners, for `peers.py`: the engines run, and their positions go to a file.

use rapier_cloth_core::{Cloth, ClothMaterial, GridBuilder, Solver, SolverSettings, Vec3};
use rapier3d::prelude::*;
use std::io::Write;

const USAGE: &str = "others swing rapier3d N FRAMES STEPS ITERATIONS HERTZ FILE, or \
    others swing rapier-cloth-core N FRAMES STEPS ITERATIONS COMPLIANCE FILE";
/// Of the sheet [m, kg].
const SIZE: f32 = 1.0;
const MASS: f32 = 0.2;
/// Of a frame [s], and downwards [m/s²].
const FRAME: f32 = 1.0 / 60.0;
const GRAVITY: f32 = 9.81;

/// Simulates a frame, and appends the positions.
type Frame = Box<dyn FnMut(&mut Vec<[f32; 3]>) -> Result<(), String>>;

/// From the words after `swing`. The file holds x, y and z of all nodes row by row [m], as 32 bits, for the start and each frame.
pub fn run(words: &[String]) -> Result<(), String> {
    let [engine, n, frames, steps, iterations, material, path] = words else {
        return Err(USAGE.to_owned());
    };
    let whole =
        |word: &String| word.parse::<usize>().map_err(|_| format!("{word} is no whole number: {USAGE}"));
    let (n, frames, steps, iterations) = (whole(n)?, whole(frames)?, whole(steps)?, whole(iterations)?);
    let material = material.parse::<f32>().map_err(|_| format!("{material} is no number: {USAGE}"))?;
    let mut frame = match engine.as_str() {
        "rapier3d" => rapier(n, steps, iterations, material),
        "rapier-cloth-core" => xpbd(n, steps, iterations, material)?,
        _ => return Err(format!("{engine} is not known: {USAGE}")),
    };
    let mut out = start(n);
    for _ in 0..frames {
        frame(&mut out)?;
    }
    let bytes: Vec<u8> = out.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    std::fs::File::create(path)
        .and_then(|mut file| file.write_all(&bytes))
        .map_err(|error| format!("{path}: {error}"))
}

/// From node to node along a row and from row to row: the sheet hangs down from its first row at 45 degrees.
fn cell(n: usize) -> (f32, f32) {
    let cell = SIZE / (n - 1) as f32;
    (cell, cell * 0.5_f32.sqrt())
}

fn start(n: usize) -> Vec<[f32; 3]> {
    let (across, down) = cell(n);
    let node = |i: usize| ((i % n) as f32, (i / n) as f32);
    (0..n * n).map(node).map(|(col, row)| [col * across - SIZE / 2.0, -row * down, row * down]).collect()
}

fn pins(n: usize) -> [u32; 2] {
    [0, n as u32 - 1]
}

/// Springs of `hertz` each, with the mass at their ends.
fn rapier(n: usize, steps: usize, iterations: usize, hertz: f32) -> Frame {
    let mut world = PhysicsWorld::new();
    world.gravity = Vector::Y * -GRAVITY;
    world.integration_parameters.dt = FRAME;
    world.integration_parameters.num_solver_iterations = steps;
    world.integration_parameters.num_internal_pgs_iterations = iterations;
    let (across, down) = cell(n);
    let (row, col) = (Vector::new(0.0, -down, down), Vector::X * across);
    let cloth = SoftBodyBuilder::cloth(Vector::X * (-SIZE / 2.0), row, col, n, n)
        .particle_mass(MASS / (n * n) as f32)
        .pinned_particles(pins(n))
        .no_surface_collider()
        .softness(SpringCoefficients::new(hertz, 0.0))
        .can_sleep(false);
    let cloth = world.insert_soft_body(cloth);
    Box::new(move |out| {
        world.step();
        out.extend(world.soft_bodies[cloth].particle_positions().map(|at| at.to_array()));
        Ok(())
    })
}

/// Edges of `compliance` [m/N], and next to no resistance to bending.
fn xpbd(n: usize, steps: usize, iterations: usize, compliance: f32) -> Result<Frame, String> {
    let half = 0.5_f32.sqrt();
    let mesh = GridBuilder::new(n, n)
        .size(SIZE, SIZE)
        .origin(Vec3::new(-SIZE / 2.0, 0.0, 0.0))
        .axes(Vec3::X, Vec3::new(0.0, -half, half))
        .build()
        .map_err(|error| error.to_string())?;
    let material = ClothMaterial {
        surface_density: MASS / (SIZE * SIZE),
        stretch_compliance: compliance,
        bend_compliance: 1e3,
        damping: 0.0,
        ..ClothMaterial::default()
    };
    let mut cloth = Cloth::new(mesh, material).map_err(|error| error.to_string())?;
    for (pin, x) in pins(n).into_iter().zip([-SIZE / 2.0, SIZE / 2.0]) {
        cloth.pin(pin, Vec3::new(x, 0.0, 0.0)).map_err(|error| error.to_string())?;
    }
    let mut solver = Solver::new();
    let settings = SolverSettings { iterations, ..SolverSettings::default() };
    Ok(Box::new(move |out| {
        for _ in 0..steps {
            solver
                .step(&mut cloth, FRAME / steps as f32, Vec3::NEG_Y * GRAVITY, &settings)
                .map_err(|error| error.to_string())?;
        }
        out.extend(cloth.positions().iter().map(|at| at.to_array()));
        Ok(())
    }))
}
