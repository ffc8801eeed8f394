//! One corner of an OBJ face: `v`, `v/t`, `v//n` or `v/t/n`.

use super::error::shown;

/// Most vertices and texture coordinates that a file may number; `u32::MAX` is none.
const MOST: i64 = u32::MAX as i64;

/// Indices of a corner, counted from 0.
pub(super) struct Corner {
    pub vertex: u32,
    /// `u32::MAX`: none.
    pub uv: u32,
}

impl Corner {
    /// Reads a corner where `vertices` and `uvs` have been read so far, which negative indices count back from.
    /// Whether positive ones are in range shows at the end of the file.
    pub fn parse(word: &[u8], vertices: usize, uvs: usize) -> Result<Self, String> {
        let mut parts = word.split(|&b| b == b'/');
        let vertex = index(parts.next().unwrap_or(b""), vertices, "vertex")?;
        let uv = match parts.next() {
            None | Some(b"") => u32::MAX,
            Some(part) => index(part, uvs, "texture coordinate")?,
        };
        Ok(Self { vertex, uv })
    }
}

fn index(part: &[u8], count: usize, what: &str) -> Result<u32, String> {
    let number = number(part).ok_or_else(|| format!("`{}` is not the index of a {what}", shown(part)))?;
    match number {
        0 if count == 0 => Err(format!("{what} index 0; OBJ counts from 1")),
        0 => Err(format!("{what} index 0; OBJ counts from 1, valid: 1 to {count}, or -{count} to -1")),
        1.. if number > MOST => Err(format!("{what} index {number}; a file has at most {MOST}")),
        1.. => Ok((number - 1) as u32),
        _ if count == 0 => {
            Err(format!("{what} index {number} counts back, but there is no {what} before it"))
        }
        _ => u32::try_from(count as i64 + number)
            .map_err(|_| format!("{what} index {number}; the lowest valid one is -{count}")),
    }
}

fn number(part: &[u8]) -> Option<i64> {
    let (negative, digits) = match part {
        [b'-', digits @ ..] => (true, digits),
        [b'+', digits @ ..] => (false, digits),
        digits => (false, digits),
    };
    if digits.is_empty() || digits.len() > 18 || !digits.iter().all(u8::is_ascii_digit) {
        return None;
    }
    let size = digits.iter().fold(0_i64, |number, &digit| number * 10 + i64::from(digit - b'0'));
    Some(if negative { -size } else { size })
}
