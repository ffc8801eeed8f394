//! The numbers after a PLY header, one after the other, in any of the three encodings.

use super::MeshError;
use super::clean::counted;
use super::error::shown;
use super::lines::line_ends;
use super::ply_header::{Element, Encoding, Number};
use std::fmt;

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

    /// Reads the length of a list in `place`; refuses one that the rest of the file is too short for.
    pub fn list_length(
        &mut self,
        count: Number,
        item: Number,
        place: fmt::Arguments,
    ) -> Result<usize, MeshError> {
        let length = self.number(count)?;
        let left = (self.bytes.len() - self.at) as u64 + 1;
        if length < 0.0 || length.fract() != 0.0 || !length.is_finite() {
            let what = format!("{place}: a list of length {length}; it must be a whole number, not negative");
            return Err(self.error_behind(count, what));
        }
        if (length as u64).saturating_mul(self.least_size(item)) > left {
            let what = format!(
                "{place}: a list of length {length}, but only {} left",
                counted(left as usize - 1, "byte")
            );
            return Err(self.error_behind(count, what));
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
        Ok(match number {
            Number::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Number::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Number::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Number::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Number::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Number::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Number::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Number::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    /// The next bytes of a binary body, the lowest first.
    #[inline]
    fn take<const N: usize>(&mut self) -> Result<[u8; N], MeshError> {
        let Some(&(mut bytes)) = self.bytes.get(self.at..).and_then(|rest| rest.first_chunk()) else {
            return Err(self.error("the file ends within its data"));
        };
        self.at += N;
        if self.encoding == Encoding::Big {
            bytes.reverse();
        }
        Ok(bytes)
    }

    fn word(&mut self) -> Result<f64, MeshError> {
        let rest = &self.bytes[self.at..];
        let start = rest.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(rest.len());
        let rest = &rest[start..];
        let end = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.at += start;
        let word = &rest[..end];
        let number = match digits(word) {
            Some(number) => Some(number),
            None => std::str::from_utf8(word).ok().and_then(|word| word.parse().ok()),
        };
        let number = number.ok_or_else(|| match word {
            [] => self.error("the file ends within its data"),
            _ => self.error(format!("`{}` is not a number", shown(word))),
        })?;
        self.at += end;
        Ok(number)
    }

    /// An error at the current line, or byte of a binary body.
    pub fn error(&self, what: impl Into<String>) -> MeshError {
        self.error_at(self.at, what)
    }

    /// An error at the number that has been read last.
    pub fn error_behind(&self, number: Number, what: impl Into<String>) -> MeshError {
        match self.encoding {
            Encoding::Ascii => self.error(what),
            _ => self.error_at(self.at - number.size(), what),
        }
    }

    fn error_at(&self, at: usize, what: impl Into<String>) -> MeshError {
        match self.encoding {
            Encoding::Ascii => MeshError::at_line(line_ends(&self.bytes[..at]) + 1, what),
            _ => MeshError::new(format!("byte {at}: {}", what.into())),
        }
    }
}

/// A number of few digits and nothing else, as most indices are.
fn digits(word: &[u8]) -> Option<f64> {
    if word.is_empty() || word.len() > 9 || !word.iter().all(u8::is_ascii_digit) {
        return None;
    }
    Some(f64::from(word.iter().fold(0_u32, |number, &digit| 10 * number + u32::from(digit - b'0'))))
}
