//! PLY, ASCII and binary, with any properties. Further numbers at vertices become groups: the vertices above 0.5.

mod faces;
mod vertices;

use super::ply_body::Body;
use super::ply_header::{Element, Property, parse_header};
use super::{MeshError, RawMesh};
use faces::Faces;
use vertices::Vertices;

/// Reads the bytes of a PLY file.
pub(super) fn parse_ply(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let header = parse_header(bytes)?;
    let mut body = Body::new(bytes, header.body, header.encoding);
    let counts: Vec<u64> = header.elements.iter().filter(|e| e.name == "vertex").map(|e| e.count).collect();
    if counts.len() > 1 {
        return Err(MeshError::new(
            "the header has two elements `vertex`; their vertices cannot be told apart",
        ));
    }
    let mut vertices = Vertices::default();
    // Faces may come first, so what the header says counts.
    let mut faces = Faces::of_vertices(counts.first().copied().unwrap_or(0));
    for element in &header.elements {
        let count = body.check_count(element)?;
        match element.name.as_str() {
            "vertex" => vertices = Vertices::read(&mut body, element, count)?,
            "face" => faces.read_faces(&mut body, element, count)?,
            "tristrips" => faces.read_strips(&mut body, element, count)?,
            _ => skip(&mut body, element, count)?,
        }
    }
    let mut repairs = Vec::new();
    let (polygons, uvs) = faces.finish(vertices.coords, &mut repairs);
    Ok(RawMesh { vertices: vertices.places, polygons, uvs, groups: vertices.groups, repairs })
}

fn skip(body: &mut Body, element: &Element, count: usize) -> Result<(), MeshError> {
    // An element without properties has nothing to skip, however often.
    let count = if element.properties.is_empty() { 0 } else { count };
    for _ in 0..count {
        element.properties.iter().try_for_each(|property| skip_property(body, property))?;
    }
    Ok(())
}

fn skip_property(body: &mut Body, property: &Property) -> Result<(), MeshError> {
    let length = match property.list {
        Some(count) => {
            body.list_length(count, property.number, format_args!("property `{}`", property.name))?
        }
        None => 1,
    };
    (0..length).try_for_each(|_| body.number(property.number).map(drop))
}

#[cfg(test)]
mod tests {
    use super::parse_ply;
    use crate::mesh::surface_from;
    use crate::output::{Positions, write_ply};
    use taffeta::topology::{Polygons, Uvs};

    const HEADER: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty double z\nproperty uchar top\n\
        property list uchar short neighbours\nelement edge 1\nproperty list int float w\nelement face 1\n\
        property list uchar int vertex_index\nproperty uchar flag\nend_header\n";

    fn binary(little: bool) -> Vec<u8> {
        let mut bytes = Vec::new();
        let mut put = |raw: &[u8]| {
            let ordered: Vec<u8> = if little { raw.to_vec() } else { raw.iter().rev().copied().collect() };
            bytes.extend(ordered);
        };
        for (x, y, z, top) in [(0_f32, 0_f32, 0.1_f64, 1_u8), (1.0, 0.0, 0.1, 0), (0.0, 1.0, 0.1, 1)] {
            put(&x.to_le_bytes());
            put(&y.to_le_bytes());
            put(&z.to_le_bytes());
            put(&[top]);
            put(&[2]);
            put(&7_i16.to_le_bytes());
            put(&8_i16.to_le_bytes());
        }
        put(&1_i32.to_le_bytes());
        put(&0.5_f32.to_le_bytes());
        put(&[3]);
        [0_i32, 1, 2].iter().for_each(|i| put(&i.to_le_bytes()));
        put(&[9]);
        let order = if little { "little" } else { "big" };
        [format!("ply\nformat binary_{order}_endian 1.0\n{HEADER}").as_bytes(), &bytes].concat()
    }

    #[test]
    fn ascii_little_and_big_endian_read_the_same() {
        let ascii = format!(
            "ply\r\nformat ascii 1.0\n{HEADER}0 0 0.1 1 2 7 8\n1 0 0.1 0 2 7 8\n0 1 0.1 1 2 7 8\n1 0.5\n3 0 1 2 9"
        );
        for bytes in [ascii.as_bytes(), &binary(true), &binary(false)] {
            let mesh = parse_ply(bytes).unwrap();
            assert_eq!(mesh.vertices, [[0.0, 0.0, 0.1], [1.0, 0.0, 0.1], [0.0, 1.0, 0.1]]);
            assert_eq!(mesh.polygons.corners, [0, 1, 2]);
            assert_eq!(mesh.groups, [("top".to_owned(), vec![0, 2])]);
        }
    }

    #[test]
    fn every_truncation_is_refused() {
        let whole = binary(true);
        for length in 0..whole.len() {
            assert!(parse_ply(&whole[..length]).is_err(), "{length} bytes were accepted");
        }
    }

    #[test]
    fn a_count_that_the_file_is_too_short_for_is_refused_at_once() {
        let text = "ply\nformat binary_little_endian 1.0\nelement vertex 4000000000\nproperty float x\n\
            property float y\nproperty float z\nelement face 4000000000\nproperty list uchar int vertex_indices\n\
            end_header\n0123456789ab";
        let error = parse_ply(text.as_bytes()).unwrap_err().to_string();
        assert!(error.contains("4000000000 of `vertex`") && error.contains("only 12 bytes"), "{error}");
        let nothing = "ply\nformat ascii 1.0\nelement mark 18446744073709551615\nend_header\n";
        assert!(parse_ply(nothing.as_bytes()).unwrap().vertices.is_empty());
        let list = "ply\nformat ascii 1.0\nelement face 1\nproperty list uint int vertex_index\nend_header\n4e9 0 1 2";
        assert!(
            parse_ply(list.as_bytes())
                .unwrap_err()
                .to_string()
                .starts_with("line 6: face 0: a list of length")
        );
    }

    const TRIANGLE: &str = "element vertex 3\nproperty float x\nproperty float y\nproperty float z\nelement face 1\n\
        property list uchar int vertex_indices\nend_header\n";

    #[test]
    fn bad_indices_and_coordinates_name_face_and_vertex() {
        let file = |vertex: &str, face: &str| {
            let text = format!("ply\nformat ascii 1.0\n{TRIANGLE}0 0 0\n1 0 0\n{vertex}\n{face}\n");
            parse_ply(text.as_bytes()).unwrap_err().to_string()
        };
        assert_eq!(file("0 1 0", "3 0 1 3"), "line 13: face 0: vertex index 3; valid: 0 to 2");
        assert_eq!(file("0 1 0", "3 0 1 -1"), "line 13: face 0: vertex index -1; valid: 0 to 2");
        assert_eq!(file("0 1 0", "3 0 1 1.5"), "line 13: face 0: vertex index 1.5; valid: 0 to 2");
        let negative = "line 13: face 0: a list of length -3; it must be a whole number, not negative";
        assert_eq!(file("0 1 0", "-3 0 1 2"), negative);
        assert_eq!(file("0 1 0", "1 0"), "line 13: face 0 has 1 corner; it needs at least 3");
        assert!(file("0 nan 0", "3 0 1 2").starts_with("line 12: vertex 2 has the coordinate NaN"));
        assert!(file("0 1 0", "3 0 1 zero").starts_with("line 13: `zero` is not a number"));
        let mut bytes = binary(true);
        let index = bytes.len() - 5;
        bytes[index] = 200;
        let error = parse_ply(&bytes).unwrap_err().to_string();
        assert_eq!(error, format!("byte {index}: face 0: vertex index 200; valid: 0 to 2"));
    }

    #[test]
    fn any_ends_of_lines_and_faces_before_vertices_are_read() {
        let text = "ply \nobj_info made by hand\nformat ascii 1.0\ncomment\n\nelement\tface 1\nproperty list uint8 int32 \
            vertex_index\nelement vertex 3\nproperty float64 x\nproperty float32 y\nproperty int z\nend_header\n3 0\t1  2\n\
            0 0 +1\n00001.00000000000000000000000000000000000000000000000 0 1\n0 1E0 1\n";
        for end in ["\n", "\r\n", "\r"] {
            let mesh = parse_ply(text.replace('\n', end).as_bytes()).unwrap();
            assert_eq!(mesh.vertices, [[0.0, 0.0, 1.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]]);
            assert_eq!(mesh.polygons.corners, [0, 1, 2]);
            let bad = text.replace("0 1E0", "0 one").replace('\n', end);
            let error = parse_ply(bad.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with("line 16: `one`"), "{error}");
            let bad = text.replace("0 0 +1", "first 0 +1").replace('\n', end);
            let error = parse_ply(bad.as_bytes()).unwrap_err().to_string();
            assert!(error.starts_with("line 14: `first`"), "{error}");
        }
        // The first byte of a binary body is no part of the header, even where it could end a line.
        let header = format!("ply\rformat binary_little_endian 1.0\r{}", TRIANGLE.replace('\n', "\r"));
        let mut bytes = header.into_bytes();
        (0..9).for_each(|i: u8| bytes.extend(f32::from_bits(u32::from(10 + i)).to_le_bytes()));
        bytes.extend([3, 0, 0, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0]);
        assert_eq!(parse_ply(&bytes).unwrap().vertices[0][0], f64::from(f32::from_bits(10)));
    }

    #[test]
    fn strips_are_triangles_that_turn_alternately() {
        let of = |list: &str| {
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 6\nproperty float x\nproperty float y\nproperty float z\n\
                 element tristrips 1\nproperty list int int vertex_indices\nend_header\n{}{list}\n",
                "0 0 0\n".repeat(6)
            );
            parse_ply(text.as_bytes()).map(|mesh| mesh.polygons).map_err(|error| error.to_string())
        };
        let strips = of("9 0 1 2 3 -1 3 4 5 0").unwrap();
        assert_eq!(strips.corners, [0, 1, 2, 2, 1, 3, 3, 4, 5, 5, 4, 0]);
        assert_eq!(strips.offsets, [0, 3, 6, 9, 12]);
        // 2 2 and 3 3 carry the strip over without a triangle; the sixth one is turned.
        assert_eq!(of("8 0 1 2 2 3 3 4 5").unwrap().corners, [0, 1, 2, 4, 3, 5]);
        assert_eq!(of("3 0 1 6").unwrap_err(), "line 16: triangle strip 0: vertex index 6; valid: 0 to 5");
    }

    #[test]
    fn colours_of_more_than_half_are_groups() {
        let text = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
            property uchar red\nproperty ushort green\nproperty float blue\nproperty uchar alpha\nproperty uchar pin\n\
            element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0 127 32767 0.5 255 0\n\
            1 0 0 128 32768 0.6 255 1\n0 1 0 255 65535 1 255 255\n3 0 1 2\n";
        let groups = parse_ply(text.as_bytes()).unwrap().groups;
        let members: Vec<(&str, &[u32])> = groups.iter().map(|(name, all)| (&**name, &**all)).collect();
        let above: &[u32] = &[1, 2];
        let (red, green, blue) = (("red", above), ("green", above), ("blue", above));
        assert_eq!(members, [red, green, blue, ("alpha", &[0, 1, 2]), ("pin", above)]);
    }

    #[test]
    fn texture_coordinates_of_corners_are_read_as_they_are_written() {
        let uvs = |n: usize| (0..n).map(|i| [i as f32, 0.25 * i as f32]).collect::<Vec<_>>();
        let polygons = Polygons { offsets: vec![0, 3, 7], corners: vec![0, 1, 2, 0, 2, 3, 4] };
        let places = vec![[0.0; 3], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.5, 0.0]];
        let written = Uvs { coords: uvs(7), corners: (0..7).collect() };
        let surface = surface_from(places.clone(), polygons, Some(written.clone()), vec![]).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mesh.ply");
        let file = write_ply(&path, &surface, &Positions::F64(&places), &[]).unwrap();
        let mesh = parse_ply(&std::fs::read(file).unwrap()).unwrap();
        assert_eq!((mesh.vertices, mesh.uvs), (places, Some(written)));
    }

    #[test]
    fn faces_may_lack_texture_coordinates_but_not_have_some_of_them() {
        let of = |first: &str, second: &str| {
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 element face 2\nproperty list uchar float texcoord\nproperty list uchar int vertex_indices\n\
                 end_header\n0 0 0\n1 0 0\n0 1 0\n{first} 3 0 1 2\n{second} 3 0 2 1\n"
            );
            parse_ply(text.as_bytes()).map_err(|error| error.to_string())
        };
        let mesh = of("0", "6 0 1 0.5 1 0 0.5").unwrap();
        let coords = mesh.uvs.unwrap().coords;
        assert_eq!(coords, [[0.0, 0.0], [0.0, 0.0], [0.0, 0.0], [0.0, 1.0], [0.5, 1.0], [0.0, 0.5]]);
        assert_eq!(mesh.repairs, ["3 face corners without a texture coordinate got (0, 0)"]);
        assert_eq!(of("0", "0").unwrap().uvs, None);
        let error = of("0", "4 0 1 0.5 1").unwrap_err();
        assert_eq!(error, "line 15: face 1 has 3 corners and 4 texture coordinates; it needs 2 each");
        assert!(of("6 0 0 0 0 0 inf", "0").unwrap_err().contains("face 0 has the texture coordinate inf"));
    }
}
