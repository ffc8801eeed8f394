//! OFF (Geomview's Object File Format), ASCII: one vertex and one face a line. Normals, colours and texture coordinates
//! are passed over.

use super::error::shown;
use super::lines::next_line;
use super::{MeshError, RawMesh};
use taffeta::topology::Polygons;

/// Reads the bytes of an OFF file.
pub(super) fn parse_off(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut lines = Lines { rest: bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), line: 0, end: 0 };
    let (vertices, faces) = header(&mut lines)?;
    let mut mesh = RawMesh { vertices: Vec::with_capacity(vertices), ..RawMesh::default() };
    for vertex in 0..vertices {
        mesh.vertices.push(read_vertex(&mut lines, vertex)?);
    }
    mesh.polygons.offsets.push(0);
    for face in 0..faces {
        read_face(&mut lines, face, vertices, &mut mesh.polygons)?;
    }
    Ok(mesh)
}

/// Reads the word that names the kind, which may be left out, and the counts of vertices and faces.
fn header(lines: &mut Lines) -> Result<(usize, usize), MeshError> {
    let Some(mut line) = lines.next() else { return Err(MeshError::new("no triangles: the file is empty")) };
    // Some writers leave out the line's end after the word: `OFF490 518 0`.
    let glued = line.strip_prefix(b"OFF").is_some_and(|rest| rest.first().is_some_and(u8::is_ascii_digit));
    let kind = if glued { Some(&line[..3]) } else { word(line).filter(|word| word.ends_with(b"OFF")) };
    if let Some(kind) = kind {
        check_kind(kind).map_err(|what| lines.error(what))?;
        line = line[kind.len()..].trim_ascii_start();
        if word(line).is_some_and(|word| word.eq_ignore_ascii_case(b"BINARY")) {
            return Err(lines.error("not yet supported: binary OFF; convert to ASCII OFF or to PLY"));
        }
        if line.is_empty() {
            line = lines.next().ok_or_else(|| lines.error("the counts of vertices and faces are missing"))?;
        }
    }
    let mut words = words(line);
    let mut count = |what: &str| {
        let word = words.next().unwrap_or(b"");
        number::<u64>(word).ok_or_else(|| {
            let word = shown(word);
            lines.error(format!("`{word}` is not a number of {what}; expected `OFF` and the numbers of vertices, faces and edges"))
        })
    };
    let (vertices, faces) = (count("vertices")?, count("faces")?);
    check_counts(vertices, faces, lines.rest.len()).map_err(|what| lines.error(what))?;
    Ok((vertices as usize, faces as usize))
}

/// Refuses vertices that are not places in space.
fn check_kind(kind: &[u8]) -> Result<(), String> {
    let mut rest = &kind[..kind.len() - 3];
    for part in [&b"ST"[..], b"C", b"N"] {
        rest = rest.strip_prefix(part).unwrap_or(rest);
    }
    let kind = shown(kind);
    match rest {
        b"" => Ok(()),
        b"4" | b"n" | b"4n" => {
            Err(format!("not yet supported: {kind}, whose vertices are not in 3 dimensions"))
        }
        _ => Err(format!("`{kind}` is not a kind of OFF; expected OFF with ST, C or N before it")),
    }
}

/// Refuses counts that the rest of the file, of `left` bytes, is too short for.
fn check_counts(vertices: u64, faces: u64, left: usize) -> Result<(), String> {
    // `0 0 0` and `1 0`, with line ends; the last one may be missing.
    let least = 6 * u128::from(vertices) + 4 * u128::from(faces);
    if least <= left as u128 + 1 {
        return Ok(());
    }
    Err(format!(
        "the header says {vertices} vertices and {faces} faces, at least {least} bytes, but only {left} bytes follow: \
         the file is truncated or its header is wrong"
    ))
}

fn read_vertex(lines: &mut Lines, vertex: usize) -> Result<[f64; 3], MeshError> {
    let line = lines.next().ok_or_else(|| lines.error(format!("the file ends before vertex {vertex}")))?;
    let mut words = words(line);
    let mut place = [0.0_f64; 3];
    for (found, x) in place.iter_mut().enumerate() {
        let Some(word) = words.next() else {
            return Err(lines.error(format!("vertex {vertex} needs 3 coordinates, found {found}")));
        };
        *x = number(word).ok_or_else(|| lines.not_a_number(&format!("vertex {vertex}"), word))?;
        if !x.is_finite() {
            return Err(lines.error(format!("vertex {vertex} has the coordinate {x}; it must be finite")));
        }
    }
    Ok(place)
}

fn read_face(
    lines: &mut Lines,
    face: usize,
    vertices: usize,
    polygons: &mut Polygons,
) -> Result<(), MeshError> {
    let line = lines.next().ok_or_else(|| lines.error(format!("the file ends before face {face}")))?;
    let mut words = words(line);
    let word = words.next().unwrap_or(b"");
    let corners = number::<u64>(word).ok_or_else(|| lines.not_a_number(&format!("face {face}"), word))?;
    if corners < 3 {
        let corners = if corners == 1 { "1 corner".to_owned() } else { format!("{corners} corners") };
        return Err(lines.error(format!("face {face} has {corners}; it needs at least 3")));
    }
    for found in 0..corners {
        let Some(word) = words.next() else {
            return Err(lines.error(format!("face {face} says {corners} corners; its line has {found}")));
        };
        let index: i64 = number(word).ok_or_else(|| lines.not_a_number(&format!("face {face}"), word))?;
        let valid = u32::try_from(index).ok().filter(|&index| (index as usize) < vertices);
        polygons.corners.push(valid.ok_or_else(|| match vertices {
            0 => lines.error(format!("face {face}: the file has no vertices")),
            _ => lines.error(format!("face {face}: vertex index {index}; valid: 0 to {}", vertices - 1)),
        })?);
    }
    let end = u32::try_from(polygons.corners.len());
    polygons.offsets.push(end.map_err(|_| lines.error("more than 4294967295 corners"))?);
    Ok(())
}

fn words(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty())
}

fn word(line: &[u8]) -> Option<&[u8]> {
    words(line).next()
}

fn number<T: std::str::FromStr>(word: &[u8]) -> Option<T> {
    std::str::from_utf8(word).ok()?.parse().ok()
}

/// Lines that say something: without comments, blank ones left out.
struct Lines<'a> {
    rest: &'a [u8],
    /// Of the line last returned, from 1.
    line: usize,
    /// Lines taken off so far.
    end: usize,
}

impl<'a> Lines<'a> {
    fn next(&mut self) -> Option<&'a [u8]> {
        while !self.rest.is_empty() {
            let line = next_line(&mut self.rest);
            self.end += 1;
            let comment = line.iter().position(|&b| b == b'#').unwrap_or(line.len());
            let line = line[..comment].trim_ascii();
            if !line.is_empty() {
                self.line = self.end;
                return Some(line);
            }
        }
        None
    }

    fn not_a_number(&self, whose: &str, word: &[u8]) -> MeshError {
        self.error(format!("{whose}: `{}` is not a number", shown(word)))
    }

    fn error(&self, message: impl Into<String>) -> MeshError {
        MeshError::at_line(self.line, message)
    }
}

#[cfg(test)]
mod tests {
    use super::parse_off;

    #[test]
    fn kinds_comments_and_colours_are_read() {
        let body = "\n# a comment\n0 0 0 9 9 9 # first\n\n1 0 0 9\n1 1e0 0 9 9\r\n0 1 .5\n3 0 1 2 255 0 0\n4 0 1 2 3\n";
        for head in [
            "OFF\n4 2 0",
            "OFF 4 2 0",
            "OFF # x\n\n4 2",
            "4 2 0",
            "STCNOFF\n4 2 0",
            "COFF 4 2 5",
            "NOFF\r\n4 2 0\r",
        ] {
            for end in ["\n", "\r\n", "\r"] {
                let text = (head.to_owned() + body).replace('\r', "").replace('\n', end);
                let mesh = parse_off(text.as_bytes()).expect(head);
                assert_eq!(
                    mesh.vertices,
                    [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.5]]
                );
                assert_eq!(
                    (mesh.polygons.offsets, mesh.polygons.corners),
                    (vec![0, 3, 7], vec![0, 1, 2, 0, 1, 2, 3])
                );
            }
        }
    }

    #[test]
    fn errors_name_face_vertex_and_line() {
        let of = |text: &str| parse_off(text.as_bytes()).unwrap_err().to_string();
        let file =
            |vertex: &str, face: &str| of(&format!("OFF\n3 1 0\n0 0 0\n1 0 0\n{vertex}\n# faces\n{face}\n"));
        assert_eq!(file("0 1 0", "3 0 1 3"), "line 7: face 0: vertex index 3; valid: 0 to 2");
        assert_eq!(file("0 1 0", "3 0 -1 2"), "line 7: face 0: vertex index -1; valid: 0 to 2");
        assert_eq!(file("0 1 0", "1 0"), "line 7: face 0 has 1 corner; it needs at least 3");
        assert_eq!(file("0 1 0", "4 0 1 2"), "line 7: face 0 says 4 corners; its line has 3");
        assert_eq!(file("0 1 0", "3 0 1 2.5"), "line 7: face 0: `2.5` is not a number");
        assert_eq!(file("0 nan 0", "3 0 1 2"), "line 5: vertex 2 has the coordinate NaN; it must be finite");
        assert_eq!(file("0 1", "3 0 1 2"), "line 5: vertex 2 needs 3 coordinates, found 2");
        assert_eq!(of("OFF\n2 1 0\n0 0 0\n1 0 0  # and no more"), "line 4: the file ends before face 0");
        assert_eq!(of("OFF\n0 1 0\n3 0 1 2"), "line 3: face 0: the file has no vertices");
    }

    #[test]
    fn what_is_not_read_is_named() {
        let of = |text: &str| parse_off(text.as_bytes()).unwrap_err().to_string();
        assert!(of("4OFF\n1 0 0\n0 0 0 0").contains("not yet supported: 4OFF"));
        assert!(of("CnOFF\n5\n1 0 0\n").contains("not yet supported: CnOFF"));
        assert!(of("OFF BINARY\n\0\0").contains("line 1: not yet supported: binary OFF"));
        assert!(of("BOFF\n1 0 0\n0 0 0").contains("`BOFF` is not a kind of OFF"));
        assert!(of("solid x\nfacet").contains("`solid` is not a number of vertices"));
        let huge = of("OFF\n4000000000 18446744073709551615 0\n0 0 0\n");
        assert!(
            huge.starts_with("line 2: the header says 4000000000 vertices") && huge.contains("only 6 bytes"),
            "{huge}"
        );
    }
}
