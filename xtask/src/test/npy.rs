//! The positions that a run has written, as far as they are compared.

use std::path::Path;

/// `positions.npy`: [frames, vertices, 3], of which the last frame is kept.
#[derive(Debug, PartialEq)]
pub struct Poses {
    pub frames: usize,
    pub vertices: usize,
    /// [m]
    pub last: Vec<[f64; 3]>,
}

impl Poses {
    /// Reads a file as taffeta writes it: little-endian numbers of 4 or 8 bytes.
    pub fn read(file: &Path) -> Result<Self, String> {
        let bytes = std::fs::read(file).map_err(|error| format!("{}: {error}", file.display()))?;
        parse(&bytes).ok_or_else(|| format!("{}: is not a npy file of places", file.display()))
    }
}

fn parse(bytes: &[u8]) -> Option<Poses> {
    let rest = bytes.strip_prefix(b"\x93NUMPY\x01\x00")?;
    let (length, rest) = rest.split_first_chunk()?;
    let (header, data) = rest.split_at_checked(usize::from(u16::from_le_bytes(*length)))?;
    let header = std::str::from_utf8(header).ok()?;
    let [frames, vertices, 3] = shape(header)?[..] else { return None };
    let size = if header.contains("'<f4'") { 4 } else { 8 };
    let start = frames.checked_sub(1)?.checked_mul(vertices)?.checked_mul(3 * size)?;
    let last: Vec<f64> = data.get(start..)?.chunks_exact(size).map(number).collect();
    let last = last.as_chunks().0.to_vec();
    (last.len() == vertices).then_some(Poses { frames, vertices, last })
}

fn shape(header: &str) -> Option<Vec<usize>> {
    let inside = header.split_once("'shape': (")?.1.split_once(')')?.0;
    inside.split(',').map(|count| count.trim().parse().ok()).collect()
}

fn number(bytes: &[u8]) -> f64 {
    match bytes.try_into() {
        Ok(four) => f64::from(f32::from_le_bytes(four)),
        Err(_) => bytes.try_into().map_or(f64::NAN, f64::from_le_bytes),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn npy(kind: &str, shape: &str, data: &[u8]) -> Vec<u8> {
        let header = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': {shape}, }}\n");
        let length = (header.len() as u16).to_le_bytes();
        [b"\x93NUMPY\x01\x00", &length[..], header.as_bytes(), data].concat()
    }

    #[test]
    fn the_last_pose_is_read_in_either_precision() {
        let numbers: Vec<f32> = (0..12).map(|i| i as f32).collect();
        let single: Vec<u8> = numbers.iter().flat_map(|x| x.to_le_bytes()).collect();
        let double: Vec<u8> = numbers.iter().flat_map(|x| f64::from(*x).to_le_bytes()).collect();
        let last = vec![[6.0, 7.0, 8.0], [9.0, 10.0, 11.0]];
        let wanted = Some(Poses { frames: 2, vertices: 2, last });
        assert_eq!(parse(&npy("<f4", "(2, 2, 3)", &single)), wanted);
        assert_eq!(parse(&npy("<f8", "(2, 2, 3)", &double)), wanted);
        assert_eq!(parse(&npy("<f4", "(2, 2, 3)", &single[4..])), None);
        assert_eq!(parse(&npy("<f4", "(0, 2, 3)", &[])), None);
        assert_eq!(parse(b"PK"), None);
    }
}
