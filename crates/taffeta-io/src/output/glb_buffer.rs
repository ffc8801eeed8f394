//! The binary half of a GLB file: arrays of 4-byte numbers, and the JSON that says where they are.

use serde_json::{Value, json};

/// glTF's numbers for what an array is for.
const VERTICES: u32 = 34962;
const INDICES: u32 = 34963;
/// glTF's numbers for types of numbers.
const U32: u32 = 5125;
const F32: u32 = 5126;

/// Arrays one after the other. All their numbers have 4 bytes, so that all start at multiples of 4.
#[derive(Default)]
pub(super) struct GlbBuffer {
    /// The arrays, little endian.
    pub bytes: Vec<u8>,
    /// Their `bufferViews`.
    pub views: Vec<Value>,
    /// Their `accessors`.
    pub accessors: Vec<Value>,
}

impl GlbBuffer {
    /// Adds an array over vertices and returns the index of its accessor. `N` is 1 to 3.
    pub fn vertices<const N: usize>(&mut self, numbers: impl Iterator<Item = [f32; N]>) -> usize {
        let bytes = numbers.flat_map(|numbers| numbers.map(f32::to_le_bytes).concat());
        self.add(bytes, VERTICES, F32, ["SCALAR", "VEC2", "VEC3"][N - 1], 4 * N)
    }

    /// Adds positions, for which glTF wants the extent too.
    pub fn positions(&mut self, places: &[[f32; 3]]) -> usize {
        let (mut low, mut high) = ([f32::INFINITY; 3], [f32::NEG_INFINITY; 3]);
        for place in places {
            low = [0, 1, 2].map(|axis| low[axis].min(place[axis]));
            high = [0, 1, 2].map(|axis| high[axis].max(place[axis]));
        }
        let index = self.vertices(places.iter().copied());
        // In 64 bits, so that the text has all digits.
        self.accessors[index]["min"] = json!(low.map(f64::from));
        self.accessors[index]["max"] = json!(high.map(f64::from));
        index
    }

    /// Adds indices of vertices and returns the index of their accessor.
    pub fn indices(&mut self, indices: impl Iterator<Item = u32>) -> usize {
        self.add(indices.flat_map(u32::to_le_bytes), INDICES, U32, "SCALAR", 4)
    }

    fn add(
        &mut self,
        bytes: impl Iterator<Item = u8>,
        target: u32,
        number: u32,
        kind: &str,
        size: usize,
    ) -> usize {
        let start = self.bytes.len();
        self.bytes.extend(bytes);
        let length = self.bytes.len() - start;
        let view = self.views.len();
        self.views.push(json!({ "buffer": 0, "byteOffset": start, "byteLength": length, "target": target }));
        self.accessors.push(
            json!({ "bufferView": view, "componentType": number, "count": length / size, "type": kind }),
        );
        view
    }
}
