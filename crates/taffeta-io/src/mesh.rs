//! Meshes from OBJ and PLY files, checked, welded, triangulated and oriented.

mod clean;
mod error;
mod obj;
mod obj_face;
mod obj_groups;
mod orient;
mod ply;
mod ply_body;
mod ply_header;
mod polygon;
mod surface;

pub use error::MeshError;
pub use surface::surface_from;

use std::path::Path;
use taffeta::topology::Surface;

/// Reads a mesh by the ending of its name: `.obj` or `.ply`. Coordinates are metres.
pub fn load_mesh(path: &Path) -> Result<Surface, MeshError> {
    let in_file = |error: MeshError| error.in_file(&path.display().to_string());
    let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
    let parse = match ending.as_str() {
        "obj" => obj::parse_obj,
        "ply" => ply::parse_ply,
        _ => {
            let kind =
                if ending.is_empty() { "files without an ending".to_owned() } else { ending.to_uppercase() };
            return Err(in_file(MeshError::new(format!("not yet supported: {kind}; convert to OBJ or PLY"))));
        }
    };
    let bytes =
        std::fs::read(path).map_err(|error| in_file(MeshError::new(format!("cannot be read: {error}"))))?;
    let raw = parse(&bytes).map_err(in_file)?;
    // The file's bytes are no longer needed, and may be large.
    drop(bytes);
    surface::build(raw).map_err(in_file)
}

/// What a mesh file says, before it is checked as a surface.
#[derive(Debug, Default)]
struct RawMesh {
    vertices: Vec<[f64; 3]>,
    polygons: taffeta::topology::Polygons,
    uvs: Option<taffeta::topology::Uvs>,
    groups: Vec<(String, Vec<u32>)>,
    repairs: Vec<String>,
}
