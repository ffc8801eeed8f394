//! Whether 32 bits can hold a mesh: its number of vertices, its size and its distance from the origin.

use super::box_tree::bounds;
use super::edges::MOST_TRIANGLES;
use super::{MeshError, RawMesh};

/// Largest extent of a mesh [m].
const LARGEST: f64 = 1e6;
/// Smallest extent of a mesh [m], below which areas and masses vanish.
const SMALLEST: f64 = 1e-12;
/// A mesh this many times its own extent away from the origin is moved there, so that 32 bits can tell its vertices
/// apart.
const FAR: f64 = 1e4;
/// Most vertices: the last number is that of a vertex without a node.
const MOST_VERTICES: u32 = u32::MAX - 1;

/// Refuses a mesh with too many vertices or triangles to number them.
pub(super) fn check_counts(raw: &RawMesh) -> Result<(), MeshError> {
    let vertices = raw.vertices.len();
    let triangles = raw.polygons.corners.len().saturating_sub(2 * raw.polygons.len());
    if vertices > MOST_VERTICES as usize || triangles > MOST_TRIANGLES as usize {
        return Err(MeshError::new(format!(
            "{vertices} vertices and {triangles} triangles; at most {MOST_VERTICES} and {MOST_TRIANGLES} can be \
             simulated"
        )));
    }
    Ok(())
}

/// Refuses a mesh too large or too small for metres, and moves one that lies far away to the origin. Returns what is taken off
/// all places [m].
pub(super) fn recentre(vertices: &mut [[f64; 3]], repairs: &mut Vec<String>) -> Result<[f64; 3], MeshError> {
    let [low, high] = bounds(vertices.iter().copied());
    let extent = (0..3).map(|axis| high[axis] - low[axis]).fold(0.0, f64::max);
    if extent > LARGEST {
        return Err(MeshError::new(format!(
            "the mesh is {extent:e} m across; at most {LARGEST:e} m can be simulated: scale its coordinates to metres"
        )));
    }
    if extent > 0.0 && extent < SMALLEST {
        return Err(MeshError::new(format!(
            "the mesh is {extent:e} m across; at least {SMALLEST:e} m can be simulated: scale its coordinates to metres"
        )));
    }
    let centre = [0, 1, 2].map(|axis| low[axis] + 0.5 * (high[axis] - low[axis]));
    let away = centre.iter().fold(0.0_f64, |away, x| away.max(x.abs()));
    if away <= FAR * extent || extent == 0.0 {
        return Ok([0.0; 3]);
    }
    take_off(vertices, centre);
    let [x, y, z] = centre;
    repairs.push(format!(
        "the mesh is {extent:.3e} m across and {away:.3e} m from the origin: moved there by ({:e}, {:e}, {:e}) m",
        0.0 - x,
        0.0 - y,
        0.0 - z
    ));
    Ok(centre)
}

/// Takes a shift off places [m].
pub(crate) fn take_off(places: &mut [[f64; 3]], shift: [f64; 3]) {
    places.iter_mut().for_each(|place| *place = [0, 1, 2].map(|axis| place[axis] - shift[axis]));
}
