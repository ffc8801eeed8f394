//! A pose as Wavefront OBJ, with the file's own faces and texture coordinates.

use super::part::Part;
use super::{Begin, Positions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use taffeta::topology::Surface;

/// Writes a pose of one body. `normals` are unit vectors, one a vertex, or empty.
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene};
/// # use taffeta::{Options, Precision, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05));
/// # let mut simulation = Simulation::new(&scene, &Options::default())?;
/// # let folder = tempfile::tempdir()?;
/// use taffeta_io::output::{Positions, write_obj};
///
/// let body = &simulation.bodies()[0];
/// let (surface, normals) = (simulation.surface(body.handle)?, simulation.normals(body.handle)?);
/// let mut positions: Vec<[f32; 3]> = Vec::new();
/// simulation.positions_f32(&mut positions);
/// write_obj(&folder.path().join("cloth.obj"), &surface, &Positions::F32(&positions), &normals)?;
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
pub fn write_obj(
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
    match positions {
        Positions::F32(all) => all.iter().try_for_each(|[x, y, z]| writeln!(part, "v {x} {y} {z}"))?,
        Positions::F64(all) => all.iter().try_for_each(|[x, y, z]| writeln!(part, "v {x} {y} {z}"))?,
    }
    if let Some(uvs) = &surface.uvs {
        uvs.coords.iter().try_for_each(|[u, v]| writeln!(part, "vt {u} {v}"))?;
    }
    normals.iter().try_for_each(|[x, y, z]| writeln!(part, "vn {x} {y} {z}"))?;
    write_faces(&mut part, surface, !normals.is_empty())?;
    surface.links.iter().try_for_each(|[a, b]| writeln!(part, "l {} {}", a + 1, b + 1))?;
    part.finish()
}

fn write_faces(part: &mut Part, surface: &Surface, normals: bool) -> io::Result<()> {
    let mut corner = 0;
    for polygon in surface.polygons.iter() {
        write!(part, "f")?;
        for vertex in polygon.iter().map(|vertex| vertex + 1) {
            let uv = surface.uvs.as_ref().map(|uvs| uvs.corners[corner] + 1);
            match (uv, normals) {
                (None, false) => write!(part, " {vertex}")?,
                (Some(uv), false) => write!(part, " {vertex}/{uv}")?,
                (None, true) => write!(part, " {vertex}//{vertex}")?,
                (Some(uv), true) => write!(part, " {vertex}/{uv}/{vertex}")?,
            }
            corner += 1;
        }
        writeln!(part)?;
    }
    Ok(())
}
