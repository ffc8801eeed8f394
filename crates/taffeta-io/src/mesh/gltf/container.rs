//! Tells GLB from JSON, splits a GLB into its chunks, and reads the document.

use super::document::Document;
use crate::mesh::MeshError;

/// Marks of a GLB and its chunks.
const GLB: &[u8] = b"glTF";
const JSON: &[u8] = b"JSON";
const BIN: &[u8] = b"BIN\0";

/// Required extensions that leave triangles where they are, or that are read: by the start of their names.
const HARMLESS: &[&str] = &[
    "KHR_mesh_quantization",
    "KHR_materials_",
    "KHR_texture_",
    "KHR_lights_",
    "KHR_animation_pointer",
    "KHR_xmp",
    "EXT_texture_",
    "EXT_lights_",
    "MSFT_texture_dds",
];

/// Required extensions that change triangles, and what would do.
const CHANGES_SHAPE: &[(&str, &str)] = &[
    ("KHR_draco_mesh_compression", "export without compression"),
    ("EXT_meshopt_compression", "export without compression"),
    ("KHR_meshopt_compression", "export without compression"),
    ("EXT_mesh_gpu_instancing", "export without instancing"),
];

/// The document, and the binary part of a GLB.
pub(super) fn open(bytes: &[u8]) -> Result<(Document, Option<&[u8]>), MeshError> {
    let (json, binary) = match bytes.starts_with(GLB) {
        true => split(bytes).map_err(MeshError::new)?,
        false => (bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), None),
    };
    let document: Document = serde_json::from_slice(json)
        .map_err(|error| MeshError::new(format!("cannot be read as glTF 2.0: {error}")))?;
    if !document.asset.version.starts_with("2.") {
        let version = &document.asset.version;
        return Err(MeshError::new(format!("not supported: glTF {version}; convert to glTF 2.0")));
    }
    document.extensions_required.iter().try_for_each(|name| check_extension(name))?;
    Ok((document, binary))
}

fn check_extension(name: &str) -> Result<(), MeshError> {
    if HARMLESS.iter().any(|start| name.starts_with(start)) {
        return Ok(());
    }
    let known = CHANGES_SHAPE.iter().find(|(known, _)| *known == name);
    let advice = known.map_or("export without it", |(_, advice)| advice);
    Err(MeshError::new(format!("not yet supported: the required extension {name}; {advice}")))
}

/// The JSON of a GLB and its binary chunk.
fn split(bytes: &[u8]) -> Result<(&[u8], Option<&[u8]>), String> {
    let word = |at| bytes.get(at..at + 4).map(|b: &[u8]| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let (Some(version), Some(length)) = (word(4), word(8)) else {
        return Err(format!("the file ends at byte {}, within its GLB header", bytes.len()));
    };
    if version != 2 {
        return Err(format!("not supported: GLB version {version}; convert to glTF 2.0"));
    }
    let whole = bytes.get(..length as usize).ok_or_else(|| {
        format!("the header says {length} bytes, but the file has {}: it is truncated", bytes.len())
    })?;
    let mut rest =
        whole.get(12..).ok_or_else(|| format!("the header says {length} bytes, too few for a GLB"))?;
    let (kind, json) = chunk(&mut rest, bytes.len())?;
    if kind != JSON {
        return Err("the first chunk of a GLB must be JSON".to_owned());
    }
    if rest.is_empty() {
        return Ok((json, None));
    }
    let (kind, binary) = chunk(&mut rest, bytes.len())?;
    Ok((json, (kind == BIN).then_some(binary)))
}

/// Takes a chunk off `rest`: its kind and its data. The file is `file` bytes long.
fn chunk<'a>(rest: &mut &'a [u8], file: usize) -> Result<(&'a [u8], &'a [u8]), String> {
    let at = file - rest.len();
    let Some((head, data)) = rest.split_at_checked(8) else {
        return Err(format!("byte {at}: the file ends within the header of a chunk"));
    };
    let length = u32::from_le_bytes([head[0], head[1], head[2], head[3]]) as usize;
    let Some((data, after)) = data.split_at_checked(length) else {
        return Err(format!("byte {at}: a chunk of {length} bytes, but only {} follow", data.len()));
    };
    *rest = after;
    Ok((&head[4..8], data))
}
