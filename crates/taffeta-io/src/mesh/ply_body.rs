//! The numbers after a PLY header, one after the other, in any of the three encodings.

use super::MeshError;
use super::ply_header::{Element, Encoding, Number};

/// Reads numbers off the body; knows where it is, for errors.
pub(super) struct Body<'a> {
    bytes: &'a [u8],
    at: usize,
    encoding: Encoding,
}

impl<'a> Body<'a> {
    pub fn new(bytes: &'a [u8], at: usize, encoding: Encoding) -> Self {
        Self { bytes, at, encoding }
    }

    /// Refuses an element whose count the rest of the file is too short for; returns the count.
    pub fn check_count(&self, element: &Element) -> Result<usize, MeshError> {
        let least: u64 = element.properties.iter().map(|p| self.least_size(p.list.unwrap_or(p.number))).sum();
        let left = (self.bytes.len() - self.at) as u64;
        // The last number of an ASCII file needs no space after it.
        match element.count.checked_mul(least) {
            Some(needed) if needed <= left + 1 => Ok(element.count as usize),
            _ => Err(self.error(format!(
                "the header says {} of `{}`, at least {least} bytes each, but only {left} bytes follow: the file \
                 is truncated or its header is wrong",
                element.count, element.name
            ))),
        }
    }

    /// Refuses a list that the rest of the file is too short for.
    pub fn list_length(&mut self, count: Number, item: Number) -> Result<usize, MeshError> {
        let length = self.number(count)?;
        let left = (self.bytes.len() - self.at) as u64 + 1;
        if length < 0.0 || length.fract() != 0.0 || !length.is_finite() {
            return Err(self.error(format!("a list of length {length}")));
        }
        if (length as u64).saturating_mul(self.least_size(item)) > left {
            return Err(self.error(format!("a list of length {length}, but only {} bytes follow", left - 1)));
        }
        Ok(length as usize)
    }

    fn least_size(&self, number: Number) -> u64 {
        match self.encoding {
            Encoding::Ascii => 2,
            _ => number.size() as u64,
        }
    }

    /// The next number. Every type but f64 itself is exact in it.
    #[inline]
    pub fn number(&mut self, number: Number) -> Result<f64, MeshError> {
        match self.encoding {
            Encoding::Ascii => self.word(),
            _ => self.binary(number),
        }
    }

    #[inline]
    fn binary(&mut self, number: Number) -> Result<f64, MeshError> {
        let size = number.size();
        let Some(found) = self.bytes.get(self.at..self.at + size) else {
            return Err(self.error("the file ends within its data"));
        };
        self.at += size;
        let mut bytes = [0_u8; 8];
        bytes[..size].copy_from_slice(found);
        if self.encoding == Encoding::Big {
            bytes[..size].reverse();
        }
        let low = u64::from_le_bytes(bytes);
        Ok(match number {
            Number::I8 => f64::from(low as i8),
            Number::U8 => f64::from(low as u8),
            Number::I16 => f64::from(low as i16),
            Number::U16 => f64::from(low as u16),
            Number::I32 => f64::from(low as i32),
            Number::U32 => f64::from(low as u32),
            Number::F32 => f64::from(f32::from_bits(low as u32)),
            Number::F64 => f64::from_bits(low),
        })
    }

    fn word(&mut self) -> Result<f64, MeshError> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        let rest = &rest[start..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += start;
        let word = &rest[..end];
        let number = std::str::from_utf8(word).ok().and_then(|word| word.parse().ok());
        let number = number.ok_or_else(|| match word {
            [] => self.error("the file ends within its data"),
            _ => self.error(format!("`{}` is not a number", String::from_utf8_lossy(word))),
        })?;
        self.at += end;
        Ok(number)
    }

    /// An error at the current line, or byte of a binary body.
    pub fn error(&self, what: impl Into<String>) -> MeshError {
        match self.encoding {
            Encoding::Ascii => {
                let line = self.bytes[..self.at].iter().filter(|&&b| b == b'\n').count() + 1;
                MeshError::at_line(line, what)
            }
            _ => MeshError::new(format!("byte {}: {}", self.at, what.into())),
        }
    }
}
