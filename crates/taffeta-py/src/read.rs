//! Positions, velocities, normals and faces.

use crate::arrays::Rows;
use crate::errors::Failure;
use crate::running::Running;
use std::ops::Range;
use taffeta::{InputError, Simulation};
use taffeta_io::output::triangles_of;

/// What has three numbers a vertex.
#[derive(Clone, Copy)]
pub enum Quantity {
    Positions,
    Velocities,
    Normals,
}

/// Puts a quantity into the rows that are kept for it; says which of them are those of the body, or all.
pub fn rows(running: &mut Running, quantity: Quantity, body: Option<&str>) -> Result<Range<usize>, Failure> {
    let Running { simulation, rows, .. } = running;
    let chosen = vertices(simulation, body)?;
    simulation.fetch()?;
    match (quantity, rows) {
        (Quantity::Positions, Rows::F32(all)) => simulation.positions_f32(all),
        (Quantity::Positions, Rows::F64(all)) => simulation.positions_f64(all),
        (Quantity::Velocities, Rows::F32(all)) => simulation.velocities_f32(all),
        (Quantity::Velocities, Rows::F64(all)) => simulation.velocities_f64(all),
        (Quantity::Normals, Rows::F32(all)) => {
            all.clear();
            for body in simulation.bodies() {
                all.extend(simulation.normals::<[f32; 3]>(body.handle)?);
            }
        }
        (Quantity::Normals, Rows::F64(all)) => {
            all.clear();
            for body in simulation.bodies() {
                all.extend(simulation.normals_f64::<[f64; 3]>(body.handle)?);
            }
        }
    }
    Ok(chosen)
}

/// The vertices of a body, or all, among those of all bodies one after the other.
pub fn vertices(simulation: &Simulation, body: Option<&str>) -> Result<Range<usize>, InputError> {
    let counts = simulation.bodies().iter().map(|body| body.vertices);
    let Some(name) = body else { return Ok(0..counts.sum()) };
    let index = simulation.body(name)?.index();
    let first: usize = counts.take(index).sum();
    Ok(first..first + simulation.bodies()[index].vertices)
}

/// Triangles by vertices: those of a body, counted from its first one, or those of all.
pub fn faces(simulation: &Simulation, body: Option<&str>) -> Result<Vec<[u32; 3]>, Failure> {
    if let Some(name) = body {
        return Ok(triangles_of(&simulation.surface(simulation.body(name)?)?));
    }
    let (mut all, mut first) = (Vec::new(), 0);
    for body in simulation.bodies() {
        let triangles = triangles_of(&simulation.surface(body.handle)?);
        all.extend(triangles.iter().map(|triangle| triangle.map(|vertex| vertex + first)));
        first += body.vertices as u32;
    }
    Ok(all)
}
