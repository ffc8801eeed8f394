//! PLY, ASCII and binary, with any properties. Further numbers at vertices become groups: the vertices above 0.5.

use super::ply_body::Body;
use super::ply_header::{Element, Property, parse_header};
use super::{MeshError, RawMesh};
use taffeta::topology::{Polygons, Uvs};

/// Vertex properties that mean something else than a group.
const NOT_GROUPS: &[&str] =
    &["x", "y", "z", "nx", "ny", "nz", "s", "t", "u", "v", "red", "green", "blue", "alpha"];

/// Reads the bytes of a PLY file.
pub(super) fn parse_ply(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let header = parse_header(bytes)?;
    let mut body = Body::new(bytes, header.body, header.encoding);
    let mut mesh = RawMesh::default();
    let mut coords = None;
    for element in &header.elements {
        let count = body.check_count(element)?;
        match element.name.as_str() {
            "vertex" => coords = read_vertices(&mut body, element, count, &mut mesh)?,
            "face" => mesh.polygons = read_faces(&mut body, element, count)?,
            "tristrips" => {
                return Err(body.error("not yet supported: triangle strips; convert to a PLY with faces"));
            }
            _ => skip(&mut body, element, count)?,
        }
    }
    check_indices(&mesh)?;
    mesh.uvs = coords.map(|coords| Uvs { coords, corners: mesh.polygons.corners.clone() });
    Ok(mesh)
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
        Some(count) => body.list_length(count, property.number)?,
        None => 1,
    };
    (0..length).try_for_each(|_| body.number(property.number).map(drop))
}

/// Reads vertices and groups into `mesh`; returns texture coordinates, if there are any.
fn read_vertices(
    body: &mut Body,
    element: &Element,
    count: usize,
    mesh: &mut RawMesh,
) -> Result<Option<Vec<[f32; 2]>>, MeshError> {
    let find = |name: &str| element.properties.iter().position(|p| p.name == name && p.list.is_none());
    let place = ["x", "y", "z"].map(find);
    let [Some(x), Some(y), Some(z)] = place else {
        return Err(MeshError::new("the vertices need the properties x, y and z"));
    };
    let uv = [["u", "v"], ["s", "t"]].map(|names| names.map(find));
    let uv = uv.into_iter().find_map(|[u, v]| Some([u?, v?]));
    let is_group = |p: &Property| p.list.is_none() && !NOT_GROUPS.contains(&p.name.as_str());
    let mut groups: Vec<(usize, Vec<u32>)> = (0..element.properties.len())
        .filter(|&i| is_group(&element.properties[i]))
        .map(|i| (i, vec![]))
        .collect();
    let mut coords = Vec::new();
    let mut values = vec![0.0; element.properties.len()];
    for vertex in 0..count {
        for (value, property) in values.iter_mut().zip(&element.properties) {
            match property.list {
                Some(_) => skip_property(body, property)?,
                None => *value = body.number(property.number)?,
            }
        }
        let place = [values[x], values[y], values[z]];
        if let Some(bad) = place.iter().find(|x| !x.is_finite()) {
            return Err(body.error(format!("vertex {vertex} has the coordinate {bad}; it must be finite")));
        }
        mesh.vertices.push(place);
        let own = uv.map(|[u, v]| [values[u] as f32, values[v] as f32]);
        if let Some(bad) = own.iter().flatten().find(|x| !x.is_finite()) {
            return Err(
                body.error(format!("vertex {vertex} has the texture coordinate {bad}; it must be finite"))
            );
        }
        coords.extend(own);
        for (property, members) in &mut groups {
            if values[*property] > 0.5 {
                members.push(vertex as u32);
            }
        }
    }
    let named = |(i, members): (usize, Vec<u32>)| (element.properties[i].name.clone(), members);
    mesh.groups = groups.into_iter().map(named).collect();
    Ok(uv.is_some().then_some(coords))
}

fn read_faces(body: &mut Body, element: &Element, count: usize) -> Result<Polygons, MeshError> {
    let is_indices =
        |p: &Property| p.list.is_some() && matches!(p.name.as_str(), "vertex_indices" | "vertex_index");
    let Some(indices) = element.properties.iter().position(is_indices) else {
        return Err(MeshError::new("the faces need a list property `vertex_indices`"));
    };
    let mut polygons = Polygons { offsets: vec![0], corners: Vec::new() };
    for face in 0..count {
        for (i, property) in element.properties.iter().enumerate() {
            let Some(length) = property.list.filter(|_| i == indices) else {
                skip_property(body, property)?;
                continue;
            };
            let length = body.list_length(length, property.number)?;
            if length < 3 {
                return Err(body.error(format!("face {face} has {length} corners; it needs at least 3")));
            }
            for _ in 0..length {
                let index = body.number(property.number)?;
                if !(0.0..f64::from(u32::MAX)).contains(&index) || index.fract() != 0.0 {
                    return Err(body.error(format!("face {face}: {index} is not the index of a vertex")));
                }
                polygons.corners.push(index as u32);
            }
        }
        let end = u32::try_from(polygons.corners.len());
        polygons.offsets.push(end.map_err(|_| body.error("more than 4294967295 corners"))?);
    }
    Ok(polygons)
}

fn check_indices(mesh: &RawMesh) -> Result<(), MeshError> {
    let count = mesh.vertices.len();
    let beyond = |face: &[u32]| face.iter().copied().find(|&v| v as usize >= count);
    let bad = mesh.polygons.iter().enumerate().find_map(|(i, face)| beyond(face).map(|v| (i, v)));
    match (bad, count) {
        (None, _) => Ok(()),
        (Some((face, _)), 0) => Err(MeshError::new(format!("face {face}: the file has no vertices"))),
        (Some((face, vertex)), _) => {
            Err(MeshError::new(format!("face {face}: vertex index {vertex}; valid: 0 to {}", count - 1)))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::parse_ply;

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
        assert!(parse_ply(list.as_bytes()).unwrap_err().to_string().starts_with("line 6: a list of length"));
    }

    #[test]
    fn bad_indices_and_coordinates_name_face_and_vertex() {
        let file = |vertex: &str, face: &str| {
            let text = format!(
                "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
                 element face 1\nproperty list uchar int vertex_indices\nend_header\n0 0 0\n1 0 0\n{vertex}\n{face}\n"
            );
            parse_ply(text.as_bytes()).unwrap_err().to_string()
        };
        assert_eq!(file("0 1 0", "3 0 1 3"), "face 0: vertex index 3; valid: 0 to 2");
        assert!(file("0 1 0", "3 0 1 -1").contains("face 0: -1 is not the index of a vertex"));
        assert!(file("0 nan 0", "3 0 1 2").contains("vertex 2 has the coordinate NaN"));
    }
}
