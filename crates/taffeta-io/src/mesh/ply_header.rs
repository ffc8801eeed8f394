//! The header of a PLY file: its encoding, its elements and their properties.

use super::MeshError;
use super::error::shown;

/// How the body is written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Little,
    Big,
}

/// A number's type.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Number {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

#[derive(Debug)]
pub(super) struct Property {
    pub name: String,
    /// Type of the count, if this is a list.
    pub list: Option<Number>,
    pub number: Number,
}

#[derive(Debug)]
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

#[derive(Debug)]
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// Byte at which the body starts.
    pub body: usize,
}

impl Number {
    fn parse(word: &str) -> Option<Self> {
        Some(match word {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Size in a binary body [byte].
    pub fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// Reads the header at the start of `bytes`.
pub(super) fn parse_header(bytes: &[u8]) -> Result<Header, MeshError> {
    let start = if bytes.starts_with(b"\xEF\xBB\xBF") { 3 } else { 0 };
    if bytes.len() == start {
        return Err(MeshError::new("an empty file: it has no triangles"));
    }
    let mut header = Header { encoding: Encoding::Ascii, elements: Vec::new(), body: start };
    let mut encoding = None;
    let line_end = line_end(&bytes[start..]);
    for line in 1.. {
        let rest = &bytes[header.body..];
        if rest.is_empty() {
            return Err(MeshError::at_line(line, "the header has no `end_header`"));
        }
        let end = rest.iter().position(|&b| b == line_end).unwrap_or(rest.len());
        header.body += (end + 1).min(rest.len());
        let text = String::from_utf8_lossy(&rest[..end]);
        let words: Vec<&str> = text.split_ascii_whitespace().collect();
        let refuse = |what: String| Err(MeshError::at_line(line, what));
        match words.as_slice() {
            ["ply"] if line == 1 => {}
            _ if line == 1 => return refuse("not a PLY file: the first line must be `ply`".to_owned()),
            [] | ["comment" | "obj_info", ..] => {}
            ["format", word, _version] => match parse_encoding(word) {
                Some(found) => encoding = Some(found),
                None => return refuse(format!("unknown format `{}`", shown(word.as_bytes()))),
            },
            ["element", name, count] => match count.parse() {
                Ok(count) => {
                    header.elements.push(Element { name: (*name).into(), count, properties: Vec::new() });
                }
                Err(_) => {
                    return refuse(format!("`{}` is not a number of elements", shown(count.as_bytes())));
                }
            },
            ["property", words @ ..] => match (header.elements.last_mut(), parse_property(words)) {
                (Some(element), Some(property)) => element.properties.push(property),
                (None, _) => return refuse("a property before any element".to_owned()),
                (_, None) => return refuse(format!("cannot read `{}`", shown(text.trim().as_bytes()))),
            },
            ["end_header"] => break,
            _ => return refuse(format!("cannot read `{}` in the header", shown(text.trim().as_bytes()))),
        }
    }
    header.encoding = encoding.ok_or_else(|| MeshError::new("the header has no `format` line"))?;
    Ok(header)
}

/// The byte at which the header's lines end, as the first one does. It must not be guessed again: the byte after the
/// header may be any.
fn line_end(text: &[u8]) -> u8 {
    match text.iter().position(|b| matches!(b, b'\n' | b'\r')) {
        Some(end) if text[end] == b'\r' && text.get(end + 1) != Some(&b'\n') => b'\r',
        _ => b'\n',
    }
}

fn parse_encoding(word: &str) -> Option<Encoding> {
    match word {
        "ascii" => Some(Encoding::Ascii),
        "binary_little_endian" => Some(Encoding::Little),
        "binary_big_endian" => Some(Encoding::Big),
        _ => None,
    }
}

fn parse_property(words: &[&str]) -> Option<Property> {
    match words {
        ["list", count, number, name] => Some(Property {
            name: (*name).into(),
            list: Some(Number::parse(count)?),
            number: Number::parse(number)?,
        }),
        [number, name] => Some(Property { name: (*name).into(), list: None, number: Number::parse(number)? }),
        _ => None,
    }
}
