//! Numbers out of buffers. Every offset, stride and count is checked against the buffer before anything is read.

use super::document::{Accessor, Document, Sparse};
use std::borrow::Cow;

/// A document and the data of its buffers.
pub(super) struct Data<'a> {
    pub document: &'a Document,
    pub buffers: Vec<Cow<'a, [u8]>>,
}

/// A number's type, by its number in OpenGL.
#[derive(Clone, Copy)]
enum Component {
    I8,
    U8,
    I16,
    U16,
    U32,
    F32,
}

impl Component {
    fn of(number: u32) -> Result<Self, String> {
        Ok(match number {
            5120 => Self::I8,
            5121 => Self::U8,
            5122 => Self::I16,
            5123 => Self::U16,
            5125 => Self::U32,
            5126 => Self::F32,
            _ => return Err(format!("componentType {number} is not a type of numbers")),
        })
    }

    fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::U32 | Self::F32 => 4,
        }
    }

    /// The number at the start of `bytes`; every type is exact in f64.
    fn read(self, bytes: &[u8]) -> f64 {
        match self {
            Self::I8 => f64::from(bytes[0] as i8),
            Self::U8 => f64::from(bytes[0]),
            Self::I16 => f64::from(i16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U16 => f64::from(u16::from_le_bytes([bytes[0], bytes[1]])),
            Self::U32 => f64::from(u32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
            Self::F32 => f64::from(f32::from_le_bytes([bytes[0], bytes[1], bytes[2], bytes[3]])),
        }
    }

    /// What normalised integers are divided by (glTF 2.0, 3.6.2.2).
    fn one(self) -> Option<f64> {
        match self {
            Self::I8 => Some(i8::MAX.into()),
            Self::U8 => Some(u8::MAX.into()),
            Self::I16 => Some(i16::MAX.into()),
            Self::U16 => Some(u16::MAX.into()),
            Self::U32 => Some(u32::MAX.into()),
            Self::F32 => None,
        }
    }

    /// The largest index; GPUs take it for a restart.
    fn restart(self) -> Option<u32> {
        match self {
            Self::U8 => Some(u8::MAX.into()),
            Self::U16 => Some(u16::MAX.into()),
            Self::U32 => Some(u32::MAX),
            _ => None,
        }
    }
}

/// Elements of one size in a buffer, all of them inside.
struct Elements<'a> {
    bytes: &'a [u8],
    stride: usize,
    size: usize,
    count: usize,
}

impl<'a> Elements<'a> {
    fn each(self) -> impl Iterator<Item = &'a [u8]> {
        let Self { bytes, stride, size, count } = self;
        (0..count).map(move |i| &bytes[i * stride..i * stride + size])
    }
}

impl Data<'_> {
    /// Elements of N numbers of any type, as f64; normalised where the accessor says so.
    pub fn numbers<const N: usize>(&self, index: usize) -> Result<Vec<[f64; N]>, String> {
        let accessor = self.accessor(index)?;
        self.read_numbers(accessor).map_err(|what| format!("accessor {index}: {what}"))
    }

    /// Indices of vertices below `vertices`.
    pub fn indices(&self, index: usize, vertices: usize) -> Result<Vec<u32>, String> {
        let accessor = self.accessor(index)?;
        self.read_indices(accessor, vertices).map_err(|what| format!("accessor {index}: {what}"))
    }

    pub fn accessor(&self, index: usize) -> Result<&Accessor, String> {
        let accessors = &self.document.accessors;
        accessors.get(index).ok_or_else(|| format!("accessor {index}; there are {}", accessors.len()))
    }

    fn read_numbers<const N: usize>(&self, accessor: &Accessor) -> Result<Vec<[f64; N]>, String> {
        let component = Component::of(accessor.component_type)?;
        expect_kind(accessor, ["", "SCALAR", "VEC2", "VEC3", "VEC4"][N])?;
        // Of a two's complement, the lowest number goes below −1.
        let number = |bytes: &[u8]| match component.one().filter(|_| accessor.normalized) {
            Some(one) => (component.read(bytes) / one).max(-1.0),
            None => component.read(bytes),
        };
        let element =
            |bytes: &[u8]| -> [f64; N] { std::array::from_fn(|i| number(&bytes[i * component.size()..])) };
        let size = N * component.size();
        let mut values: Vec<[f64; N]> = match accessor.buffer_view {
            Some(view) => {
                self.elements(view, accessor.byte_offset, accessor.count, size)?.each().map(element).collect()
            }
            None => vec![[0.0; N]; self.zeros(accessor)?],
        };
        let Some(sparse) = &accessor.sparse else { return Ok(values) };
        let count = values.len();
        if sparse.count > count as u64 {
            return Err(format!("{} sparse elements of {count}", sparse.count));
        }
        let (indices, new) = self.substitutes(sparse, size)?;
        for (index, new) in indices.zip(new) {
            let value = values.get_mut(index as usize);
            *value.ok_or_else(|| format!("sparse index {index}; there are {count} elements"))? = element(new);
        }
        Ok(values)
    }

    /// Indices and new elements, of `size` bytes, of a sparse accessor.
    fn substitutes(
        &self,
        sparse: &Sparse,
        size: usize,
    ) -> Result<(impl Iterator<Item = u32>, impl Iterator<Item = &[u8]>), String> {
        let (indices, new) = (&sparse.indices, &sparse.values);
        let component = Component::of(indices.component_type)?;
        if component.restart().is_none() {
            return Err("sparse indices must be unsigned integers".to_owned());
        }
        let indices =
            self.elements(indices.buffer_view, indices.byte_offset, sparse.count, component.size())?;
        let new = self.elements(new.buffer_view, new.byte_offset, sparse.count, size)?;
        Ok((indices.each().map(move |bytes| component.read(bytes) as u32), new.each()))
    }

    /// How many zeros an accessor without a view starts from; not more than the data has bytes.
    fn zeros(&self, accessor: &Accessor) -> Result<usize, String> {
        if accessor.sparse.is_none() {
            return Err("it names no bufferView".to_owned());
        }
        let bytes: usize = self.buffers.iter().map(|buffer| buffer.len()).sum();
        match usize::try_from(accessor.count) {
            Ok(count) if count <= bytes => Ok(count),
            _ => Err(format!("{} elements, but the buffers have only {bytes} bytes", accessor.count)),
        }
    }

    fn read_indices(&self, accessor: &Accessor, vertices: usize) -> Result<Vec<u32>, String> {
        let component = Component::of(accessor.component_type)?;
        expect_kind(accessor, "SCALAR")?;
        let Some(restart) = component.restart().filter(|_| !accessor.normalized) else {
            return Err("indices must be unsigned integers, not normalised".to_owned());
        };
        let indices = self.read_numbers::<1>(accessor)?;
        let check = |(at, [index]): (usize, [f64; 1])| {
            let index = index as u32;
            if (index as usize) < vertices && index != restart {
                return Ok(index);
            }
            let hint = if index == restart { " (restarts are not part of glTF)" } else { "" };
            let valid = match vertices {
                0 => "there are no vertices".to_owned(),
                _ => format!("valid: 0 to {}", (vertices - 1).min(restart as usize - 1)),
            };
            Err(format!("index {at} is vertex {index}{hint}; {valid}"))
        };
        indices.into_iter().enumerate().map(check).collect()
    }

    /// `count` elements of `size` bytes in a view, from its byte `offset` on.
    fn elements(&self, view: usize, offset: u64, count: u64, size: usize) -> Result<Elements<'_>, String> {
        let views = &self.document.buffer_views;
        let found = views.get(view).ok_or_else(|| format!("bufferView {view}; there are {}", views.len()))?;
        let buffer = self.buffers.get(found.buffer).ok_or_else(|| {
            format!("bufferView {view} is in buffer {}; there are {}", found.buffer, self.buffers.len())
        })?;
        let end = found.byte_offset.checked_add(found.byte_length);
        let bytes = end.and_then(|end| buffer.get(found.byte_offset.try_into().ok()?..end.try_into().ok()?));
        let bytes = bytes.ok_or_else(|| {
            format!(
                "bufferView {view} has {} bytes from byte {} on, but buffer {} has only {}",
                found.byte_length,
                found.byte_offset,
                found.buffer,
                buffer.len()
            )
        })?;
        let stride = found.byte_stride.filter(|&stride| stride > 0).unwrap_or(size as u64);
        if stride < size as u64 {
            return Err(format!(
                "bufferView {view} has a byteStride of {stride}, but an element {size} bytes"
            ));
        }
        // The last element needs no padding after it.
        let needed = match count {
            0 => 0,
            _ => u128::from(offset) + u128::from(count - 1) * u128::from(stride) + size as u128,
        };
        if needed > bytes.len() as u128 {
            let length = bytes.len();
            return Err(format!(
                "{count} elements need {needed} bytes of bufferView {view}, which has {length}"
            ));
        }
        // Every element lies inside, so each of these numbers is at most the length of a slice.
        let bytes = &bytes[(offset as usize).min(bytes.len())..];
        Ok(Elements { bytes, stride: stride as usize, size, count: count as usize })
    }
}

fn expect_kind(accessor: &Accessor, kind: &str) -> Result<(), String> {
    match accessor.kind == kind {
        true => Ok(()),
        false => Err(format!("its type is {}; it must be {kind}", accessor.kind)),
    }
}
