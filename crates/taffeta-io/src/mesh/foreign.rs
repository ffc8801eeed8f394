//! Files that are something else than their name says, told by the bytes they begin with.

use super::MeshFormat;

const UTF_16: &str = "is a text in UTF-16; save it as UTF-8";

/// Beginnings of files that are no meshes to be read.
const OTHERS: &[(&[u8], &str)] = &[
    (b"\xFF\xFE", UTF_16),
    (b"\xFE\xFF", UTF_16),
    (b"\x1F\x8B", "is compressed with gzip; unpack it first"),
    (b"\x28\xB5\x2F\xFD", "is compressed with Zstandard; unpack it first"),
    (b"\xFD7zXZ", "is compressed with xz; unpack it first"),
    (b"PK\x03\x04", "is a ZIP archive; unpack it first"),
    (b"\x89PNG", "is a picture (PNG), not a mesh"),
    (b"Kaydara FBX", "is an FBX file; convert it"),
];

/// Beginnings of meshes, and the endings that their names should have.
const MESHES: &[(&[u8], MeshFormat, &str)] = &[
    (b"ply\n", MeshFormat::Ply, ".ply"),
    (b"ply\r", MeshFormat::Ply, ".ply"),
    (b"glTF", MeshFormat::Gltf, ".glb"),
    (b"OFF", MeshFormat::Off, ".off"),
    (b"solid ", MeshFormat::Stl, ".stl"),
];

/// What a file is that could not be read as `format`, or has no faces there, and what would do; `None` if it may be one.
pub(super) fn foreign(bytes: &[u8], format: MeshFormat) -> Option<String> {
    if let Some((_, what)) = OTHERS.iter().find(|(start, _)| bytes.starts_with(start)) {
        return Some((*what).to_owned());
    }
    let (_, _, ending) = MESHES.iter().find(|(start, of, _)| *of != format && bytes.starts_with(start))?;
    Some(format!("begins as a {ending} file does; if it is one, give its name that ending"))
}
