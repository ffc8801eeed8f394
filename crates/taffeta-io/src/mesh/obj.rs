//! Wavefront OBJ. Continued lines, trailing comments, tabs, negative indices and numbers after a vertex are read as
//! the format means them; materials, normals, lines and points are passed over.

use super::clean::counted;
use super::error::shown;
use super::lines::next_line;
use super::obj_face::Corner;
use super::obj_groups::Groups;
use super::{MeshError, RawMesh};
use taffeta::topology::{Polygons, Uvs};

#[derive(Default)]
struct Reader {
    vertices: Vec<[f64; 3]>,
    coords: Vec<[f32; 2]>,
    polygons: Polygons,
    /// Texture index of each corner; `u32::MAX` without.
    uv_corners: Vec<u32>,
    /// Line of each face.
    lines: Vec<usize>,
    groups: Groups,
    line: usize,
}

/// Reads the bytes of an OBJ file.
pub(super) fn parse_obj(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut reader = Reader::default();
    let mut rest = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let mut line = 1;
    let mut joined = Vec::new();
    while !rest.is_empty() {
        reader.line = line;
        let mut part = next_line(&mut rest);
        line += 1;
        if part.ends_with(b"\\") && part.trim_ascii_start().first() != Some(&b'#') {
            joined.clear();
            while let Some(open) = part.strip_suffix(b"\\") {
                joined.extend_from_slice(open);
                joined.push(b' ');
                part = next_line(&mut rest);
                line += 1;
            }
            joined.extend_from_slice(part);
            reader.statement(&joined)?;
        } else {
            reader.statement(part)?;
        }
    }
    reader.finish()
}

impl Reader {
    fn statement(&mut self, line: &[u8]) -> Result<(), MeshError> {
        let mut words = line
            .split(|b| b.is_ascii_whitespace())
            .filter(|word| !word.is_empty())
            .take_while(|word| word[0] != b'#');
        match words.next() {
            Some(b"v") => {
                let place = self.numbers::<3>(words, "a vertex needs 3 coordinates")?;
                if let Some(bad) = place.iter().find(|x| !x.is_finite()) {
                    let index = self.vertices.len();
                    return Err(
                        self.error(format!("vertex {index} has the coordinate {bad}; it must be finite"))
                    );
                }
                self.vertices.push(place);
            }
            Some(b"vt") => {
                let [u] = self.numbers::<1>(words.clone().take(1), "a texture coordinate needs a number")?;
                // `v` may be left out.
                let v = words.nth(1).map_or(Ok(0.0), |word| self.number(word))?;
                let uv = [u as f32, v as f32];
                if !(uv[0].is_finite() && uv[1].is_finite()) {
                    return Err(self.error(format!("the texture coordinate {u} {v} must be finite")));
                }
                self.coords.push(uv);
            }
            Some(b"f") => self.face(words)?,
            Some(b"g") => {
                self.groups.set_groups(words, self.polygons.len()).map_err(|what| self.error(what))?;
            }
            Some(b"o") => {
                let name: Vec<_> = words.map(String::from_utf8_lossy).collect();
                self.groups.set_object(name.join(" "), self.polygons.len());
            }
            _ => {}
        }
        Ok(())
    }

    fn numbers<'a, const N: usize>(
        &self,
        mut words: impl Iterator<Item = &'a [u8]>,
        needs: &str,
    ) -> Result<[f64; N], MeshError> {
        let mut numbers = [0.0; N];
        for (found, number) in numbers.iter_mut().enumerate() {
            let word = words.next().ok_or_else(|| self.error(format!("{needs}, found {found}")))?;
            *number = self.number(word)?;
        }
        Ok(numbers)
    }

    fn number(&self, word: &[u8]) -> Result<f64, MeshError> {
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| self.error(format!("`{}` is not a number", shown(word))))
    }

    fn face<'a>(&mut self, words: impl Iterator<Item = &'a [u8]>) -> Result<(), MeshError> {
        let face = self.lines.len();
        if self.polygons.offsets.is_empty() {
            self.polygons.offsets.push(0);
        }
        let first = self.polygons.corners.len();
        for word in words {
            let corner = Corner::parse(word, self.vertices.len(), self.coords.len())
                .map_err(|what| self.error(format!("face {face}: {what}")))?;
            self.polygons.corners.push(corner.vertex);
            self.uv_corners.push(corner.uv);
        }
        let corners = self.polygons.corners.len() - first;
        if corners < 3 {
            let corners = counted(corners, "corner");
            return Err(self.error(format!("face {face} has {corners}; it needs at least 3")));
        }
        let end = u32::try_from(self.polygons.corners.len());
        self.polygons.offsets.push(end.map_err(|_| self.error("more than 4294967295 corners"))?);
        self.lines.push(self.line);
        Ok(())
    }

    fn error(&self, message: impl Into<String>) -> MeshError {
        MeshError::at_line(self.line, message)
    }

    /// Checks the indices, which may point ahead of their face, and gathers groups and texture coordinates.
    fn finish(mut self) -> Result<RawMesh, MeshError> {
        let (vertices, coords) = (self.vertices.len(), self.coords.len());
        if let Some(at) = self.polygons.corners.iter().position(|&v| v as usize >= vertices) {
            return Err(self.beyond(at, "vertex", self.polygons.corners[at], vertices));
        }
        let beyond = |&uv: &u32| uv != u32::MAX && uv as usize >= coords;
        if let Some(at) = self.uv_corners.iter().position(beyond) {
            return Err(self.beyond(at, "texture coordinate", self.uv_corners[at], coords));
        }
        let mut repairs = Vec::new();
        let without = self.uv_corners.iter().filter(|&&uv| uv == u32::MAX).count();
        let uvs = (without < self.uv_corners.len()).then(|| {
            if without > 0 {
                self.uv_corners.iter_mut().filter(|uv| **uv == u32::MAX).for_each(|uv| *uv = coords as u32);
                self.coords.push([0.0; 2]);
                let corners = counted(without, "face corner");
                repairs.push(format!("{corners} without a texture coordinate got (0, 0)"));
            }
            Uvs { coords: self.coords, corners: self.uv_corners }
        });
        let groups = self.groups.vertices(&self.polygons, vertices);
        Ok(RawMesh { vertices: self.vertices, polygons: self.polygons, uvs, groups, repairs })
    }

    fn beyond(&self, corner: usize, what: &str, index: u32, count: usize) -> MeshError {
        let face = self.polygons.offsets.partition_point(|&start| start as usize <= corner) - 1;
        let valid = match count {
            0 => format!("the file has no {what}"),
            _ => format!("valid: 1 to {count}, or -{count} to -1"),
        };
        MeshError::at_line(
            self.lines[face],
            format!("face {face}: {what} index {}; {valid}", u64::from(index) + 1),
        )
    }
}

#[cfg(test)]
mod tests {
    use super::parse_obj;

    #[test]
    fn syntax_that_other_readers_trip_over_is_read() {
        let text = b"\xEF\xBB\xBFmtllib missing file.mtl\ng a b\r\nv\t0.0 0 0 1.0\r\nv 1e0 0 0 0.5 0.5 0.5\nv 0 +1.0E+0 0 # up\n\
            vt 0.5\nf 1//1 -1//1 \\\n2//1 # end\ng c\nf 1/1/1 2/1/1 3/1/1\nl 1 2\np 1\n";
        let mesh = parse_obj(text).unwrap();
        assert_eq!(mesh.vertices, [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]]);
        assert_eq!(mesh.polygons.corners, [0, 2, 1, 0, 1, 2]);
        let uvs = mesh.uvs.unwrap();
        assert_eq!((uvs.coords, uvs.corners), (vec![[0.5, 0.0], [0.0; 2]], vec![1, 1, 1, 0, 0, 0]));
        let names: Vec<&str> = mesh.groups.iter().map(|(name, _)| name.as_str()).collect();
        assert_eq!(names, ["a", "b", "c"]);
    }

    #[test]
    fn lines_end_in_any_way() {
        let text = "v 0 0 0\nv 1 0 0\n\nv 0 1 0\nf 1 2 \\\n3\nf 1 2 zero\n";
        for end in ["\n", "\r\n", "\r"] {
            let error = parse_obj(text.replace('\n', end).as_bytes()).unwrap_err().to_string();
            assert_eq!(error, "line 7: face 1: `zero` is not the index of a vertex");
            assert_eq!(
                parse_obj(text[..text.len() - 11].replace('\n', end).as_bytes()).unwrap().polygons.len(),
                1
            );
        }
    }

    #[test]
    fn groups_hold_until_the_next_ones() {
        let text =
            "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\ng a b a\nf 1 2 3\no a\ng b\nf 2 3 4\no c\ng\nf 1 2 4\n";
        let groups = parse_obj(text.as_bytes()).unwrap().groups;
        let members: Vec<(&str, &[u32])> = groups.iter().map(|(name, all)| (&**name, &**all)).collect();
        assert_eq!(members, [("a", &[0, 1, 2, 3][..]), ("b", &[0, 1, 2, 3]), ("c", &[0, 1, 3])]);
        let many: String = (0..33).map(|i| format!(" {i}")).collect();
        let error = parse_obj(format!("\ng{many}\n").as_bytes()).unwrap_err().to_string();
        assert_eq!(error, "line 2: more than 32 group names for one face");
    }

    #[test]
    fn errors_name_the_line_and_the_valid_range() {
        let of = |text: &str| parse_obj(text.as_bytes()).unwrap_err().to_string();
        assert_eq!(of("v 0 0\n"), "line 1: a vertex needs 3 coordinates, found 2");
        assert_eq!(of("v 0 0 0\nv 1 0 nan\n"), "line 2: vertex 1 has the coordinate NaN; it must be finite");
        assert_eq!(of("vt 0.5 inf\n"), "line 1: the texture coordinate 0.5 inf must be finite");
        assert_eq!(of("v 0 zero 0\n"), "line 1: `zero` is not a number");
        let three = "v 0 0 0\nv 1 0 0\nv 0 1 0\n";
        let zero = of(&format!("{three}f 0 1 2\n"));
        assert_eq!(zero, "line 4: face 0: vertex index 0; OBJ counts from 1, valid: 1 to 3, or -3 to -1");
        assert_eq!(
            of(&format!("{three}f 1 2 99\n")),
            "line 4: face 0: vertex index 99; valid: 1 to 3, or -3 to -1"
        );
        let back = of(&format!("{three}f 1 2 -4\n"));
        assert_eq!(back, "line 4: face 0: vertex index -4; the lowest valid one is -3");
        let far = of(&format!("{three}f 1 2 4294967299\n"));
        assert_eq!(far, "line 4: face 0: vertex index 4294967299; a file has at most 4294967295");
        assert!(
            of(&format!("{three}f 1 2 4294967295\n")).contains("vertex index 4294967295; valid: 1 to 3,")
        );
        assert_eq!(of("f 0 1 2\n"), "line 1: face 0: vertex index 0; OBJ counts from 1");
        assert_eq!(
            of("f -1 1 2\n"),
            "line 1: face 0: vertex index -1 counts back, but there is no vertex before it"
        );
        assert_eq!(of(&format!("{three}f 1 2\n")), "line 4: face 0 has 2 corners; it needs at least 3");
        assert!(of(&format!("{three}f 1/7 2/7 3/7\n")).contains("the file has no texture coordinate"));
    }
}
