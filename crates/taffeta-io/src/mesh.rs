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

use std::path::{Path, PathBuf};
use taffeta::topology::Surface;

/// How a mesh is read.
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshOptions<'a> {
    /// Close holes whose border passes each of its nodes once, by triangles between the border's nodes.
    pub fill_holes: bool,
    /// A second file with the same vertices and faces, in its shape at rest.
    pub rest: Option<&'a Path>,
    /// Folders, besides the mesh's own, that hold what it may name: the buffers of a glTF.
    pub within: &'a [PathBuf],
}

/// Format of a mesh file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// PLY, ASCII or binary.
    Ply,
}

impl MeshFormat {
    /// The format that the ending of a file's name says.
    pub fn of(path: &Path) -> Result<Self, MeshError> {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match ending.as_str() {
            "obj" => Ok(Self::Obj),
            "ply" => Ok(Self::Ply),
            "" => Err(MeshError::new("not yet supported: files without an ending; convert to OBJ or PLY")),
            other => Err(MeshError::new(format!(
                "not yet supported: {}; convert to OBJ or PLY",
                other.to_uppercase()
            ))),
        }
    }
}

/// Reads a mesh by the ending of its name. Coordinates are metres.
pub fn load_mesh(path: &Path, options: &MeshOptions) -> Result<Surface, MeshError> {
    let in_file = |error: MeshError| error.in_file(&path.display().to_string());
    let format = MeshFormat::of(path).map_err(in_file)?;
    let bytes =
        std::fs::read(path).map_err(|error| in_file(MeshError::new(format!("cannot be read: {error}"))))?;
    let raw = parse(&bytes, format).map_err(in_file)?;
    // The file's bytes are no longer needed, and may be large.
    drop(bytes);
    surface::build(raw, options).map_err(in_file)
}

/// Reads a mesh from bytes. It may name no other files.
pub fn parse_mesh(bytes: &[u8], format: MeshFormat, options: &MeshOptions) -> Result<Surface, MeshError> {
    surface::build(parse(bytes, format)?, options)
}

fn parse(bytes: &[u8], format: MeshFormat) -> Result<RawMesh, MeshError> {
    match format {
        MeshFormat::Obj => obj::parse_obj(bytes),
        MeshFormat::Ply => ply::parse_ply(bytes),
    }
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
