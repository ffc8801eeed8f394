//! How far a fabric is strained: by triangle, and the extremes of all triangles at the end of a frame.
//!
//! The columns of F are the warp and weft of the rest shape as they are now. Their lengths are the stretches along warp and weft,
//! √(2 E₁₁ + 1) and √(2 E₂₂ + 1), and the angle between them is a right angle less the shear angle. Extremes are those of squares,
//! so that each is found exactly whatever the order.

use crate::cpu::backend::Context;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::numbers::Numbers;
use crate::cpu::worker::Worker;
use crate::elements::element::List;
use crate::elements::membrane::{NAME, membrane::columns};
use crate::real::{Real, dot};
use crate::report::{FrameSums, StrainSums};
use crate::step::Op;
use std::ops::Range;

/// Triangles of a chunk at most.
const CHUNK: usize = 4096;

/// What a workgroup begins with: less than any number is.
pub const NONE: [f32; 5] = [0.0, -f32::MAX, 0.0, -f32::MAX, 0.0];

/// Squared stretch along the warp, its negative, the same along the weft, and the squared sine of the shear angle, of a triangle
/// with corners at `x` [m] whose Dm⁻¹ is `inverse` [1/m].
pub fn strain<T: Real>(x: [[T; 3]; 3], inverse: [T; 4]) -> [T; 5] {
    let [warp, weft] = columns(x, inverse);
    let (c11, c22, c12) = (dot(warp, warp), dot(weft, weft), dot(warp, weft));
    let product = c11 * c22;
    let shear = if product > T::ZERO { c12 * c12 / product } else { T::ZERO };
    [c11, -c11, c22, -c22, shear]
}

/// The strain of all fabric on the CPU.
pub struct Strains<T> {
    /// Corners by solver index, and Dm⁻¹ [1/m].
    triangles: Vec<([u32; 3], [T; 4])>,
    /// Extremes by chunk.
    most: Numbers<5>,
}

impl<T: Real> Strains<T> {
    /// Those of a scene, if it has fabric.
    pub fn new(context: &Context<'_, T>) -> Option<Self> {
        let list = context.assembly.elements().iter().find(|list| list.kind.name == NAME)?;
        let triangles = Self::triangles(list);
        let chunks = triangles.len().div_ceil(CHUNK);
        (chunks > 0).then(|| Self { triangles, most: Numbers::all(chunks, NONE.map(f64::from)) })
    }

    fn triangles(list: &List) -> Vec<([u32; 3], [T; 4])> {
        let triangle = |(nodes, numbers): (&[u32], &[f64])| {
            ([0, 1, 2].map(|i| nodes[i]), [0, 1, 2, 3].map(|i| T::from_f64(numbers[i])))
        };
        list.of(0..list.len()).map(triangle).collect()
    }

    /// The extremes of some triangles.
    fn most(&self, state: [&[T]; 6], range: Range<usize>) -> [T; 5] {
        let mut most = NONE.map(|one| T::from_f64(one.into()));
        for (corners, inverse) in &self.triangles[range] {
            let x = corners.map(|node| [0, 1, 2].map(|axis| state[axis][node as usize]));
            for (most, one) in most.iter_mut().zip(strain(x, *inverse)) {
                *most = if one > *most { one } else { *most };
            }
        }
        most
    }
}

impl<T: Real> Feature<T> for Strains<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::MeasureBodies]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        let state = worker.old();
        for chunk in worker.part(self.most.len()) {
            let range = chunk * CHUNK..self.triangles.len().min((chunk + 1) * CHUNK);
            self.most.set(chunk, self.most(state, range).map(T::to_f64));
        }
        Flow::Go
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        self.most.iter().for_each(|most| StrainSums(most).add_to(&mut sums.strain));
    }

    fn bytes(&self) -> usize {
        self.triangles.len() * size_of::<([u32; 3], [T; 4])>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle whose warp runs along x and whose weft along y, moved by a matrix.
    fn strain_of(matrix: [[f64; 2]; 2]) -> [f64; 5] {
        let place = |[x, y]: [f64; 2]| {
            [matrix[0][0] * x + matrix[0][1] * y, matrix[1][0] * x + matrix[1][1] * y, 0.3]
        };
        strain([[0.0, 0.0], [2.0, 0.0], [0.0, 4.0]].map(place), [0.5, 0.0, 0.0, 0.25])
    }

    #[test]
    fn stretch_and_shear_are_read_from_a_triangle() {
        assert_eq!(strain_of([[1.0, 0.0], [0.0, 1.0]]), [1.0, -1.0, 1.0, -1.0, 0.0]);
        assert_eq!(strain_of([[1.5, 0.0], [0.0, 0.5]]), [2.25, -2.25, 0.25, -0.25, 0.0]);
        // Sheared by 30°: sin² = ¼.
        let [c11, _, c22, _, shear] = strain_of([[1.0, 0.5], [0.0, 0.75_f64.sqrt()]]);
        assert!((c11 - 1.0).abs() < 1e-15 && (c22 - 1.0).abs() < 1e-15 && (shear - 0.25).abs() < 1e-15);
        // A triangle without width has no angle.
        assert_eq!(strain_of([[1.0, 0.0], [0.0, 0.0]]), [1.0, -1.0, 0.0, -0.0, 0.0]);
    }
}
