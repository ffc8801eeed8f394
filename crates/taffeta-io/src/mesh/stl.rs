//! STL, binary and ASCII. Corners are the vertices, three a facet and in the file's order; normals are passed over.

use super::clean::counted;
use super::stl_ascii::parse_ascii;
use super::{MeshError, RawMesh};
use taffeta::topology::Polygons;

/// Bytes of a binary file before its first facet: 80 that say nothing, and the number of facets.
const HEADER: usize = 84;
/// Bytes of a facet: a normal, three corners and an attribute.
const FACET: usize = 50;

/// Reads the bytes of an STL file. The length says which kind it is: binary files may start with `solid` as well.
pub(super) fn parse_stl(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let count = bytes.get(80..HEADER).map(|b| u32::from_le_bytes([b[0], b[1], b[2], b[3]]));
    let length = count.map(|count| HEADER as u64 + FACET as u64 * u64::from(count));
    if length == Some(bytes.len() as u64) {
        return parse_binary(&bytes[HEADER..]);
    }
    if looks_ascii(bytes) {
        return parse_ascii(bytes);
    }
    let found = counted(bytes.len(), "byte");
    Err(MeshError::new(match (count, length) {
        (Some(count), Some(length)) => format!(
            "file size is {found}, not 84 + 50·count = {length} for its {}: {}",
            counted(count as usize, "facet"),
            if length > bytes.len() as u64 {
                "the file is truncated or not an STL"
            } else {
                "the count is too small, or bytes follow that are no facets"
            }
        ),
        _ => {
            format!("file size is {found}: too short for a binary STL, and an ASCII one starts with `solid`")
        }
    }))
}

/// Whether the file starts with `solid`, and goes on as text does.
fn looks_ascii(bytes: &[u8]) -> bool {
    let text = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes).trim_ascii_start();
    let start = &text[..text.len().min(1024)];
    start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid"))
        && start.get(5).is_none_or(u8::is_ascii_whitespace)
        && start.iter().all(|b| !b.is_ascii_control() || b.is_ascii_whitespace())
}

fn parse_binary(facets: &[u8]) -> Result<RawMesh, MeshError> {
    let polygons = soup(facets.len() / FACET)?;
    let mut vertices = Vec::with_capacity(polygons.corners.len());
    for (facet, bytes) in facets.chunks_exact(FACET).enumerate() {
        for (vertex, corner) in bytes[12..48].chunks_exact(12).enumerate() {
            let axis = |at: usize| {
                f64::from(f32::from_le_bytes([corner[at], corner[at + 1], corner[at + 2], corner[at + 3]]))
            };
            let place = [axis(0), axis(4), axis(8)];
            if let Some(what) = not_finite(facet, vertex, &place) {
                return Err(MeshError::new(format!("byte {}: {what}", HEADER + FACET * facet)));
            }
            vertices.push(place);
        }
    }
    Ok(RawMesh { vertices, polygons, ..RawMesh::default() })
}

/// `count` triangles, each with corners of its own.
pub(super) fn soup(count: usize) -> Result<Polygons, MeshError> {
    let corners = count.checked_mul(3).and_then(|corners| u32::try_from(corners).ok());
    let corners = corners.ok_or_else(|| MeshError::new("more than 4294967295 corners"))?;
    Ok(Polygons { offsets: (0..=corners).step_by(3).collect(), corners: (0..corners).collect() })
}

/// Complains about a coordinate that is not a number or infinite.
pub(super) fn not_finite(facet: usize, vertex: usize, place: &[f64; 3]) -> Option<String> {
    let bad = place.iter().find(|x| !x.is_finite())?;
    Some(format!("facet {facet}, vertex {vertex} has the coordinate {bad}; it must be finite"))
}

#[cfg(test)]
mod tests {
    use super::parse_stl;

    fn binary(count: u32, facets: usize) -> Vec<u8> {
        let mut bytes = b"solid says this binary file".to_vec();
        bytes.resize(80, b' ');
        bytes.extend(count.to_le_bytes());
        for facet in 0..facets {
            [9.0, 9.0, 9.0, facet as f32, 0.0, 0.1, 1.0, 0.0, 0.1, 0.0, 1.0, 0.1_f32]
                .iter()
                .for_each(|x| bytes.extend(x.to_le_bytes()));
            bytes.extend([7, 7]);
        }
        bytes
    }

    #[test]
    fn corners_are_vertices_and_normals_nothing() {
        let mesh = parse_stl(&binary(2, 2)).unwrap();
        let z = f64::from(0.1_f32);
        let facet = |x| [[x, 0.0, z], [1.0, 0.0, z], [0.0, 1.0, z]];
        assert_eq!(mesh.vertices, [facet(0.0), facet(1.0)].concat());
        assert_eq!((mesh.polygons.offsets, mesh.polygons.corners), (vec![0, 3, 6], vec![0, 1, 2, 3, 4, 5]));
        assert_eq!(parse_stl(&binary(0, 0)).unwrap().polygons.len(), 0);
    }

    #[test]
    fn a_length_that_does_not_follow_from_the_count_is_refused() {
        let of = |bytes: &[u8]| parse_stl(bytes).unwrap_err().to_string();
        assert_eq!(
            of(&binary(3, 2)),
            "file size is 184 bytes, not 84 + 50·count = 234 for its 3 facets: the file is truncated or not an STL"
        );
        assert!(of(&binary(u32::MAX, 1)).contains("not 84 + 50·count = 214748364834"));
        assert!(
            of(&binary(1, 2)).contains(
                "= 134 for its 1 facet: the count is too small, or bytes follow that are no facets"
            )
        );
        assert!(of(b"").starts_with("file size is 0 bytes: too short"));
        let whole = binary(2, 2);
        for end in 0..whole.len() {
            // A part of the header may look like an ASCII file without facets.
            let empty = parse_stl(&whole[..end]).is_ok_and(|mesh| mesh.polygons.is_empty());
            assert!((empty && end <= 80) || parse_stl(&whole[..end]).is_err(), "{end} bytes were accepted");
        }
    }

    #[test]
    fn coordinates_that_are_not_finite_name_facet_and_vertex() {
        let mut bytes = binary(2, 2);
        bytes[84 + 50 + 12 + 12..][..4].copy_from_slice(&f32::NAN.to_le_bytes());
        let error = parse_stl(&bytes).unwrap_err().to_string();
        assert_eq!(error, "byte 134: facet 1, vertex 1 has the coordinate NaN; it must be finite");
    }
}
