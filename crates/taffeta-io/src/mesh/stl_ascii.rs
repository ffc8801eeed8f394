//! ASCII STL: words in any case, names with spaces, several solids in one file. The names become groups.

use super::error::shown;
use super::lines::{is_end, line_ends};
use super::stl::{not_finite, soup};
use super::{MeshError, RawMesh};
use std::collections::HashMap;

/// Reads a text that starts with `solid`.
pub(super) fn parse_ascii(bytes: &[u8]) -> Result<RawMesh, MeshError> {
    let mut words = Words { rest: bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes), line: 1 };
    let mut vertices = Vec::new();
    let mut solids = Solids::default();
    let mut open = false;
    while let Some((word, line)) = words.next() {
        match word.to_ascii_lowercase().as_slice() {
            b"solid" => {
                solids.start(words.rest_of_line(), vertices.len());
                open = true;
            }
            b"endsolid" => {
                words.rest_of_line();
                open = false;
            }
            b"facet" => facet(&mut words, line, &mut vertices)?,
            _ => return Err(unexpected(word, line, "`facet`, `endsolid` or `solid`")),
        }
    }
    let repairs = if open { vec!["the file ends without `endsolid`".to_owned()] } else { Vec::new() };
    let polygons = soup(vertices.len() / 3)?;
    Ok(RawMesh { groups: solids.groups(vertices.len()), vertices, polygons, uvs: None, repairs })
}

/// Reads what follows the word `facet`, up to `endfacet`.
fn facet(words: &mut Words, start: usize, vertices: &mut Vec<[f64; 3]>) -> Result<(), MeshError> {
    let first = vertices.len();
    let facet = first / 3;
    loop {
        let Some((word, line)) = words.next() else {
            return Err(MeshError::at_line(start, format!("facet {facet}: the file ends within it")));
        };
        match word.to_ascii_lowercase().as_slice() {
            // Some programs write normals that are not numbers; the winding says more.
            b"normal" => words.skip(3),
            b"outer" | b"loop" | b"endloop" => {}
            b"vertex" => {
                let place = [words.number(facet)?, words.number(facet)?, words.number(facet)?];
                if let Some(what) = not_finite(facet, vertices.len() - first, &place) {
                    return Err(MeshError::at_line(line, what));
                }
                vertices.push(place);
            }
            b"endfacet" => break,
            _ => return Err(unexpected(word, line, "`vertex` or `endfacet`")),
        }
    }
    match vertices.len() - first {
        3 => Ok(()),
        1 => Err(MeshError::at_line(start, format!("facet {facet} has 1 vertex; it needs 3"))),
        found => Err(MeshError::at_line(start, format!("facet {facet} has {found} vertices; it needs 3"))),
    }
}

fn unexpected(word: &[u8], line: usize, expected: &str) -> MeshError {
    MeshError::at_line(line, format!("`{}` where {expected} is expected", shown(word)))
}

/// Reads word by word; knows the line.
struct Words<'a> {
    rest: &'a [u8],
    line: usize,
}

impl<'a> Words<'a> {
    /// The next word and its line.
    fn next(&mut self) -> Option<(&'a [u8], usize)> {
        let start = self.rest.iter().position(|b| !b.is_ascii_whitespace())?;
        self.line += line_ends(&self.rest[..start]);
        let word = &self.rest[start..];
        let end = word.iter().position(u8::is_ascii_whitespace).unwrap_or(word.len());
        self.rest = &word[end..];
        Some((&word[..end], self.line))
    }

    fn skip(&mut self, count: usize) {
        for _ in 0..count {
            self.next();
        }
    }

    fn rest_of_line(&mut self) -> &'a [u8] {
        let end = self.rest.iter().position(is_end).unwrap_or(self.rest.len());
        let (line, rest) = self.rest.split_at(end);
        self.rest = rest;
        line.trim_ascii()
    }

    fn number(&mut self, facet: usize) -> Result<f64, MeshError> {
        let Some((word, line)) = self.next() else {
            return Err(MeshError::at_line(self.line, format!("facet {facet}: the file ends within it")));
        };
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        number.ok_or_else(|| {
            let word = shown(word);
            MeshError::at_line(line, format!("facet {facet}: `{word}` is not a number"))
        })
    }
}

/// The solids' names, and from which vertex on each holds.
#[derive(Default)]
struct Solids {
    names: Vec<String>,
    by_name: HashMap<String, usize>,
    starts: Vec<(usize, Option<usize>)>,
}

impl Solids {
    fn start(&mut self, name: &[u8], vertex: usize) {
        let name = String::from_utf8_lossy(name).into_owned();
        let index = (!name.is_empty()).then(|| {
            *self.by_name.entry(name).or_insert_with_key(|name| {
                self.names.push(name.clone());
                self.names.len() - 1
            })
        });
        self.starts.push((vertex, index));
    }

    fn groups(self, vertices: usize) -> Vec<(String, Vec<u32>)> {
        let mut groups: Vec<_> = self.names.into_iter().map(|name| (name, Vec::new())).collect();
        for (i, &(start, index)) in self.starts.iter().enumerate() {
            let end = self.starts.get(i + 1).map_or(vertices, |&(next, _)| next);
            if let Some(index) = index {
                groups[index].1.extend(start as u32..end as u32);
            }
        }
        groups
    }
}

#[cfg(test)]
mod tests {
    use super::parse_ascii;

    const FACET: &str = "facet normal 0 0 1\n outer loop\n vertex 0 0 0\n vertex 1.5e0 0 0\n vertex 0 0.1 0\n endloop\nendfacet\n";

    #[test]
    fn any_case_line_end_and_several_solids_are_read() {
        let text = format!(
            "\u{feff} Solid the left one\n{FACET}endsolid\nsolid\n{0}endsolid x\nSOLID b\n{0}ENDSOLID b\nsolid the left one\n{FACET}",
            FACET.to_uppercase()
        );
        for text in [
            text.clone(),
            text.replace('\n', "\r\n"),
            text.replace('\n', "\r"),
            text.replace("0 0 1", "nan nan nan"),
        ] {
            let mesh = parse_ascii(text.as_bytes()).unwrap();
            assert_eq!(mesh.vertices, [[[0.0; 3], [1.5, 0.0, 0.0], [0.0, 0.1, 0.0]]; 4].concat());
            assert_eq!(mesh.polygons.corners, (0..12).collect::<Vec<_>>());
            let groups = [("the left one", vec![0, 1, 2, 9, 10, 11]), ("b", vec![6, 7, 8])];
            assert_eq!(mesh.groups, groups.map(|(name, vertices)| (name.to_owned(), vertices)));
            assert_eq!(mesh.repairs, ["the file ends without `endsolid`"]);
        }
    }

    #[test]
    fn errors_name_facet_and_line() {
        let of = |text: String| parse_ascii(text.as_bytes()).unwrap_err().to_string();
        let two = format!("solid\n{FACET}{FACET}");
        let second = two.len() - FACET.len();
        let with = |from: &str, to: &str| of(two[..second].to_owned() + &FACET.replace(from, to));
        assert_eq!(with(" vertex 0 0 0\n", ""), "line 9: facet 1 has 2 vertices; it needs 3");
        assert_eq!(with("endloop", "vertex 0 0 0"), "line 9: facet 1 has 4 vertices; it needs 3");
        let nan = with("0.1", "NaN");
        assert_eq!(nan, "line 13: facet 1, vertex 2 has the coordinate NaN; it must be finite");
        assert_eq!(with("1.5e0", "1,5"), "line 12: facet 1: `1,5` is not a number");
        assert_eq!(with("endfacet", ""), "line 9: facet 1: the file ends within it");
        let old = |text: String| of(text.replace('\n', "\r"));
        assert_eq!(
            old(format!("solid\n{FACET}\ninner")),
            "line 10: `inner` where `facet`, `endsolid` or `solid` is expected"
        );
        assert_eq!(with("outer", "inner"), "line 10: `inner` where `vertex` or `endfacet` is expected");
        assert_eq!(
            of("solid\nnothing".into()),
            "line 2: `nothing` where `facet`, `endsolid` or `solid` is expected"
        );
    }
}
