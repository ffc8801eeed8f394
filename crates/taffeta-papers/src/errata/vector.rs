//! Vectors of three numbers, and the sheets and balls of the experiments.

use taffeta::scene::{Icosphere, Mesh};
use taffeta::topology::{Surface, shapes};

pub type Vector = [f64; 3];

pub fn add(a: Vector, b: Vector) -> Vector {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

pub fn sub(a: Vector, b: Vector) -> Vector {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

pub fn scale(s: f64, a: Vector) -> Vector {
    [s * a[0], s * a[1], s * a[2]]
}

pub fn dot(a: Vector, b: Vector) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: Vector, b: Vector) -> Vector {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn norm(a: Vector) -> f64 {
    dot(a, a).sqrt()
}

/// As a shader has it: of nothing, not a number.
pub fn normalize(a: Vector) -> Vector {
    scale(1.0 / norm(a), a)
}

pub fn sum(vectors: impl IntoIterator<Item = Vector>) -> Vector {
    vectors.into_iter().fold([0.0; 3], add)
}

/// Steps (rows, columns) to the neighbours that own a spring with a node: structural, shear, bend.
pub const STEPS: [[isize; 2]; 6] = [[0, 1], [1, 0], [1, 1], [1, -1], [0, 2], [2, 0]];

/// The springs of a sheet of so many rows and columns along these steps; node = row · columns + column.
pub fn sheet_springs(rows: usize, columns: usize, steps: &[[isize; 2]]) -> Vec<[usize; 2]> {
    let node = |[row, column]: [isize; 2]| {
        let [row, column] = [usize::try_from(row).ok()?, usize::try_from(column).ok()?];
        (row < rows && column < columns).then_some(row * columns + column)
    };
    let mut pairs = Vec::new();
    for &[down, across] in steps {
        for from in 0..rows * columns {
            let to = node([(from / columns) as isize + down, (from % columns) as isize + across]);
            pairs.extend(to.map(|to| [from, to]));
        }
    }
    pairs
}

/// A ball around the origin.
pub fn ball(radius: f64, subdivisions: u32) -> Surface {
    let mesh = Mesh::Icosphere(Icosphere { radius, subdivisions });
    shapes::surface(&mesh).expect("the sizes of the experiments are allowed")
}

/// Numbers by chance between −1 and 1, the same every time (SplitMix64).
pub struct Chance(pub u64);

impl Chance {
    pub fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^= z >> 31;
        (z >> 11) as f64 / (1u64 << 52) as f64 - 1.0
    }
}
