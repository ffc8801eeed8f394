//! Meshes from OBJ, PLY, STL, OFF and glTF files, checked, welded, triangulated and oriented.

mod borders;
mod bow_tie;
mod box_tree;
mod clean;
mod edges;
mod error;
mod extent;
mod file;
mod foreign;
mod gltf;
mod holes;
mod least_area;
mod lines;
mod nesting;
mod obj;
mod obj_face;
mod obj_groups;
mod off;
mod orient;
mod parts;
mod ply;
mod ply_body;
mod ply_header;
mod polygon;
mod rest;
mod stl;
mod stl_ascii;
mod surface;
mod triangles;
mod weld;

pub(crate) use clean::UNUSED;
pub use error::MeshError;
pub(crate) use extent::take_off;
pub use surface::surface_from;

use crate::files::Given;
use std::path::{Path, PathBuf};
use taffeta::topology::Surface;

/// How a mesh is read.
///
/// ```
/// use taffeta_io::{MeshFormat, MeshOptions, parse_mesh};
///
/// // A tetrahedron without its fourth face.
/// let open = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0 0 1\nf 1 3 2\nf 1 2 4\nf 1 4 3\n";
/// let options = MeshOptions { fill_holes: true, ..MeshOptions::default() };
/// let surface = parse_mesh(open, MeshFormat::Obj, &options)?;
/// assert_eq!(surface.triangles.len(), 4);
/// # Ok::<(), taffeta_io::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug, Default)]
pub struct MeshOptions<'a> {
    /// Close holes whose border passes each of its nodes once, by triangles between the border's nodes.
    pub fill_holes: bool,
    /// A second file with the same vertices and faces, in its shape at rest.
    pub rest: Option<&'a Path>,
    /// Folders, besides the mesh's own, that hold what it may name: the buffers of a glTF.
    pub within: &'a [PathBuf],
    /// Files to take in place of those of the disk.
    pub given: Option<&'a Given>,
}

/// Format of a mesh file.
///
/// ```
/// use taffeta_io::MeshFormat;
///
/// assert_eq!(MeshFormat::of("models/Bunny.PLY".as_ref())?, MeshFormat::Ply);
/// let error = MeshFormat::of("bunny.fbx".as_ref()).unwrap_err();
/// assert!(error.to_string().contains("convert to .obj"));
/// # Ok::<(), taffeta_io::MeshError>(())
/// ```
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum MeshFormat {
    /// Wavefront OBJ.
    Obj,
    /// PLY, ASCII or binary.
    Ply,
    /// STL, ASCII or binary.
    Stl,
    /// OFF, ASCII.
    Off,
    /// glTF 2.0, as JSON or GLB.
    Gltf,
}

impl MeshFormat {
    /// The format that the ending of a file's name says.
    pub fn of(path: &Path) -> Result<Self, MeshError> {
        let ending = path.extension().and_then(|e| e.to_str()).unwrap_or("").to_ascii_lowercase();
        match ending.as_str() {
            "obj" => Ok(Self::Obj),
            "ply" => Ok(Self::Ply),
            "stl" => Ok(Self::Stl),
            "off" => Ok(Self::Off),
            "gltf" | "glb" => Ok(Self::Gltf),
            other => {
                let found =
                    if other.is_empty() { "no ending".to_owned() } else { format!("the ending .{other}") };
                Err(MeshError::new(format!(
                    "not yet supported: a mesh with {found}; convert to .obj, .ply, .stl, .off, .gltf or .glb"
                )))
            }
        }
    }
}

/// Reads a mesh by the ending of its name. Coordinates are metres.
///
/// ```no_run
/// use taffeta_io::{MeshOptions, load_mesh};
///
/// let options = MeshOptions { fill_holes: true, ..MeshOptions::default() };
/// let surface = load_mesh("bunny.ply".as_ref(), &options)?;
/// surface.repairs.iter().for_each(|repair| println!("{repair}"));
/// # Ok::<(), taffeta_io::MeshError>(())
/// ```
pub fn load_mesh(path: &Path, options: &MeshOptions) -> Result<Surface, MeshError> {
    let raw = read_mesh(path, options)?;
    surface::build(raw, options).map_err(|error| error.in_file(&path.display().to_string()))
}

/// As [`load_mesh`], and what was taken off all places of a mesh that lay far away [m].
pub(crate) fn load_moved(path: &Path, options: &MeshOptions) -> Result<(Surface, [f64; 3]), MeshError> {
    let raw = read_mesh(path, options)?;
    surface::build_moved(raw, options).map_err(|error| error.in_file(&path.display().to_string()))
}

/// Places of the vertices of `mesh` [m] in another file with its vertices and faces, as they are there.
pub(crate) fn load_pose(
    path: &Path,
    options: &MeshOptions,
    mesh: &Surface,
) -> Result<Vec<[f64; 3]>, MeshError> {
    rest::places(read_mesh(path, options)?, ("pose", path), mesh.vertices.len(), &mesh.polygons)
}

/// What a mesh file says. Its bytes, which may be many, are gone when this returns.
fn read_mesh(path: &Path, options: &MeshOptions) -> Result<RawMesh, MeshError> {
    let read = || {
        if let Some(given) = options.given {
            let bytes =
                given.get(path).ok_or_else(|| MeshError::new("is not among the files that were given"))?;
            return parse(bytes, MeshFormat::of(path)?, path.parent(), options);
        }
        file::check_kind(path)?;
        let format = MeshFormat::of(path)?;
        parse(&file::read(path)?, format, path.parent(), options)
    };
    read().map_err(|error| error.in_file(&path.display().to_string()))
}

/// Reads a mesh from bytes. It may name no other files.
///
/// ```
/// use taffeta_io::{MeshFormat, MeshOptions, parse_mesh};
///
/// let triangle = b"v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
/// let surface = parse_mesh(triangle, MeshFormat::Obj, &MeshOptions::default())?;
/// assert_eq!(surface.triangles, [[0, 1, 2]]);
/// # Ok::<(), taffeta_io::MeshError>(())
/// ```
pub fn parse_mesh(bytes: &[u8], format: MeshFormat, options: &MeshOptions) -> Result<Surface, MeshError> {
    surface::build(parse(bytes, format, None, &MeshOptions::default())?, options)
}

/// Reads what a file says. A glTF may name buffers in `folder`, its own, and in those of the options.
fn parse(
    bytes: &[u8],
    format: MeshFormat,
    folder: Option<&Path>,
    options: &MeshOptions,
) -> Result<RawMesh, MeshError> {
    if bytes.is_empty() {
        return Err(MeshError::new("no triangles: the file is empty"));
    }
    let read = match format {
        MeshFormat::Obj => obj::parse_obj(bytes),
        MeshFormat::Ply => ply::parse_ply(bytes),
        MeshFormat::Stl => stl::parse_stl(bytes),
        MeshFormat::Off => off::parse_off(bytes),
        MeshFormat::Gltf => gltf::parse_gltf(bytes, folder, options),
    };
    match read {
        Ok(mesh) if !mesh.polygons.is_empty() => Ok(mesh),
        read => foreign::foreign(bytes, format).map_or(read, |what| Err(MeshError::new(what))),
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
