//! A pose as binary PLY, little endian, with the file's own faces.

use super::part::Part;
use super::uvs::uvs_of_vertices;
use super::{Begin, Positions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use taffeta::topology::{Surface, Uvs};

/// Writes a pose of one body. `normals` are unit vectors, one a vertex, or empty. Texture coordinates go to the
/// vertices (`s`, `t`) where each vertex has one, else to the corners of the faces (`texcoord`).
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// use taffeta_io::output::{Positions, write_ply};
///
/// let body = &simulation.bodies()[0];
/// let (surface, normals) = (simulation.surface(body.handle)?, simulation.normals(body.handle)?);
/// let mut positions: Vec<[f32; 3]> = Vec::new();
/// simulation.positions_f32(&mut positions);
/// write_ply(&folder.path().join("cloth.ply"), &surface, &Positions::F32(&positions), &normals)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_ply(
    path: &Path,
    surface: &Surface,
    positions: &Positions,
    normals: &[[f32; 3]],
) -> io::Result<PathBuf> {
    let mut part = Part::open(path, Begin::New)?;
    let count = surface.vertices.len();
    if positions.len() != count || !(normals.is_empty() || normals.len() == count) {
        let (places, normals) = (positions.len(), normals.len());
        return Err(part.refuse(format!("{places} positions and {normals} normals for {count} vertices")));
    }
    let vertex_uvs = surface.uvs.as_ref().and_then(|uvs| uvs_of_vertices(surface, uvs));
    let corner_uvs = surface.uvs.as_ref().filter(|_| vertex_uvs.is_none());
    part.write_all(
        header(surface, positions, !normals.is_empty(), vertex_uvs.is_some(), corner_uvs.is_some())
            .as_bytes(),
    )?;
    for vertex in 0..count {
        match positions {
            Positions::F32(all) => floats(&mut part, &all[vertex])?,
            Positions::F64(all) => {
                all[vertex].iter().try_for_each(|x| part.write_all(&x.to_le_bytes()))?;
            }
        }
        normals.get(vertex).map_or(Ok(()), |normal| floats(&mut part, normal))?;
        vertex_uvs.as_ref().map_or(Ok(()), |uvs| floats(&mut part, &uvs[vertex]))?;
    }
    write_faces(&mut part, surface, corner_uvs)?;
    for [a, b] in &surface.links {
        part.write_all(&a.to_le_bytes())?;
        part.write_all(&b.to_le_bytes())?;
    }
    part.finish()
}

fn header(
    surface: &Surface,
    positions: &Positions,
    normals: bool,
    vertex_uvs: bool,
    corner_uvs: bool,
) -> String {
    let number = match positions {
        Positions::F32(_) => "float",
        Positions::F64(_) => "double",
    };
    let mut text = format!(
        "ply\nformat binary_little_endian 1.0\nelement vertex {}\nproperty {number} x\nproperty {number} y\n\
         property {number} z\n",
        surface.vertices.len()
    );
    let lines = [
        (normals, "property float nx\nproperty float ny\nproperty float nz\n".to_owned()),
        (vertex_uvs, "property float s\nproperty float t\n".to_owned()),
        (
            !surface.polygons.is_empty(),
            format!("element face {}\nproperty list int int vertex_indices\n", surface.polygons.len()),
        ),
        (corner_uvs, "property list int float texcoord\n".to_owned()),
        (
            !surface.links.is_empty(),
            format!("element edge {}\nproperty int vertex1\nproperty int vertex2\n", surface.links.len()),
        ),
    ];
    lines.into_iter().filter(|(there, _)| *there).for_each(|(_, line)| text.push_str(&line));
    text + "end_header\n"
}

fn write_faces(part: &mut Part, surface: &Surface, corner_uvs: Option<&Uvs>) -> io::Result<()> {
    let mut first = 0;
    for polygon in surface.polygons.iter() {
        part.write_all(&(polygon.len() as u32).to_le_bytes())?;
        polygon.iter().try_for_each(|vertex| part.write_all(&vertex.to_le_bytes()))?;
        if let Some(uvs) = corner_uvs {
            part.write_all(&(2 * polygon.len() as u32).to_le_bytes())?;
            for &uv in &uvs.corners[first..first + polygon.len()] {
                floats(part, &uvs.coords[uv as usize])?;
            }
        }
        first += polygon.len();
    }
    Ok(())
}

fn floats(part: &mut Part, numbers: &[f32]) -> io::Result<()> {
    numbers.iter().try_for_each(|x| part.write_all(&x.to_le_bytes()))
}
