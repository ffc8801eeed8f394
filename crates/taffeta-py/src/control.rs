//! What a program does to a running simulation: pins, forces, poses, and the numbers that it asks for.

use crate::errors::Failure;
use crate::running::Running;
use numpy::{PyArray2, PyArrayMethods, PyUntypedArrayMethods};
use pyo3::prelude::*;
use taffeta::{BodyHandle, InputError, Pose, Simulation};
use taffeta_io::program::pose;

/// Pins vertices at places, or where they are.
pub fn pin(
    running: &mut Running,
    body: &str,
    vertices: &[usize],
    to: Option<Vec<[f64; 3]>>,
) -> Result<(), Failure> {
    let simulation = &mut running.simulation;
    let handle = checked(simulation, body, vertices)?;
    let to = match to {
        Some(to) => to,
        None => {
            simulation.fetch()?;
            let first = crate::read::vertices(simulation, Some(body))?.start;
            let mut all: Vec<[f64; 3]> = Vec::new();
            simulation.positions_f64(&mut all);
            vertices.iter().map(|vertex| all[first + vertex]).collect()
        }
    };
    for (&vertex, place) in vertices.iter().zip(to) {
        simulation.pin_vertex(handle, vertex, place)?;
    }
    Ok(())
}

/// Frees vertices.
pub fn unpin(simulation: &mut Simulation, body: &str, vertices: &[usize]) -> Result<(), Failure> {
    let handle = checked(simulation, body, vertices)?;
    for &vertex in vertices {
        simulation.unpin_vertex(handle, vertex)?;
    }
    Ok(())
}

/// Applies a force [N] to each vertex during the next frame.
pub fn apply_forces(
    simulation: &mut Simulation,
    body: &str,
    vertices: &[usize],
    forces: &[[f64; 3]],
) -> Result<(), Failure> {
    let handle = checked(simulation, body, vertices)?;
    for (&vertex, &force) in vertices.iter().zip(forces) {
        simulation.apply_force(handle, vertex, force)?;
    }
    Ok(())
}

/// A body that has all these vertices, so that nothing is done by half.
fn checked(simulation: &Simulation, body: &str, vertices: &[usize]) -> Result<BodyHandle, Failure> {
    let handle = simulation.body(body)?;
    let count = simulation.bodies()[handle.index()].vertices;
    match vertices.iter().find(|vertex| **vertex >= count) {
        Some(&vertex) => Err(InputError::NoVertex { body: body.to_owned(), vertex, vertices: count }.into()),
        None => Ok(handle),
    }
}

/// A pose: a shift [3], or a rigid matrix [4, 4].
pub fn pose(value: &Bound<'_, PyAny>) -> Result<Pose, Failure> {
    if let Ok(shift) = value.extract::<[f64; 3]>() {
        return Ok(pose::shift(shift));
    }
    let unfit = || Failure::input("a pose is an array of numbers: a shift [3], or a rigid matrix [4, 4]");
    let numpy = value.py().import("numpy")?;
    let array = numpy.call_method1("ascontiguousarray", (value, "f8")).map_err(|_| unfit())?;
    let array = array.cast::<PyArray2<f64>>().map_err(|_| unfit())?;
    if array.shape() != [4, 4] {
        return Err(unfit());
    }
    let numbers = array.to_vec().map_err(|_| unfit())?;
    let rows: &[[f64; 4]; 4] = numbers.as_chunks().0.as_array().ok_or_else(unfit)?;
    pose::rigid(*rows).map_err(Failure::input)
}

/// A number of frames.
pub fn frames(frames: i64) -> Result<u32, Failure> {
    u32::try_from(frames)
        .map_err(|_| Failure::input(format!("frames is {frames}; 0 to {} would do", u32::MAX)))
}

/// Frames that last at least so long [s].
pub fn frames_of(seconds: f64, dt: f64) -> Result<u32, Failure> {
    // What is a whole number of frames but for roundings is one.
    let count = (seconds / dt * (1.0 - 1e-9)).ceil();
    if !(0.0..=f64::from(u32::MAX)).contains(&count) {
        let most = f64::from(u32::MAX) * dt;
        return Err(Failure::input(format!("seconds is {seconds}; 0 to {most:.3e} would do")));
    }
    Ok(count as u32)
}

/// A part of a frame.
pub fn fraction(fraction: f64) -> Result<f64, Failure> {
    let within = (0.0..=1.0).contains(&fraction);
    within
        .then_some(fraction)
        .ok_or_else(|| Failure::input(format!("fraction is {fraction}; 0 to 1 would do")))
}

/// A number that is one.
pub fn finite(name: &str, number: f64) -> Result<f64, Failure> {
    number
        .is_finite()
        .then_some(number)
        .ok_or_else(|| Failure::input(format!("{name} is {number}; a finite number would do")))
}

/// A whole number from 1 on.
pub fn at_least_one(name: &str, number: i64) -> Result<usize, Failure> {
    usize::try_from(number)
        .ok()
        .filter(|&number| number > 0)
        .ok_or_else(|| Failure::input(format!("{name} is {number}; 1 or more would do")))
}

/// A seed.
pub fn seed(seed: i64) -> Result<u64, Failure> {
    u64::try_from(seed).map_err(|_| Failure::input(format!("seed is {seed}; 0 or more would do")))
}
