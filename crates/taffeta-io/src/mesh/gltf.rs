//! glTF 2.0, as JSON or GLB: the triangles of its default scene in their places. Materials, normals, colours, cameras
//! and animations are passed over. Vertices are in the order of the scene graph, primitive by primitive; primitives of
//! one mesh that share an accessor of positions share vertices, nodes with the same mesh get copies.
//!
//! Texture coordinates are turned over, v' = 1 − v: glTF counts v from the top, OBJ, USD and this crate from the
//! bottom. Groups: the names of nodes and meshes, and attributes `_NAME` of one number, the vertices above 0.5.

mod accessor;
mod buffers;
mod builder;
mod container;
mod document;
mod scene;

use super::{MeshError, MeshOptions, RawMesh};
use accessor::Data;
use buffers::Loader;
use builder::Builder;
use std::path::Path;

/// Reads the bytes of a glTF or GLB. Buffers may lie in `folder`, where the file is, and in the folders of the options;
/// without `folder` it must bring them along.
pub(super) fn parse_gltf(
    bytes: &[u8],
    folder: Option<&Path>,
    options: &MeshOptions,
) -> Result<RawMesh, MeshError> {
    let (document, binary) = container::open(bytes)?;
    let loader = Loader { folder, within: options.within, given: options.given, binary };
    let buffers = loader.load(&document.buffers).map_err(MeshError::new)?;
    let data = Data { document: &document, buffers };
    let mut builder = Builder::new(&data);
    for placement in scene::placements(&document).map_err(MeshError::new)? {
        builder.add(&placement).map_err(MeshError::new)?;
    }
    Ok(builder.finish())
}
