//! Distances from triangles, side by side in vector lanes.

use crate::contact::collider_mesh::surface::{MeshNow, MeshSurface};
use crate::contact::collider_mesh::triangle::{Nearest, nearest};
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::real::Real;

/// Number of triangles that are compared together.
pub const LANES: usize = 8;

/// Kernel: squared distances of a position from triangles [m²].
struct Distances<'a, T> {
    x: [T; 3],
    /// By corner and axis.
    corners: &'a [[[T; LANES]; 3]; 3],
}

impl<T: Real> Kernel for Distances<'_, T> {
    type Output = [T; LANES];
    #[inline(always)]
    fn run(self) -> [T; LANES] {
        let Self { x, corners: [a, b, c] } = self;
        let mut squared = [T::ZERO; LANES];
        for i in 0..LANES {
            let at = |corner: &[[T; LANES]; 3]| [corner[0][i], corner[1][i], corner[2][i]];
            squared[i] = nearest(x, &[at(a), at(b), at(c)]).squared;
        }
        squared
    }
}

/// The nearest of the triangles that were compared.
pub struct Closest<T> {
    pub triangle: u32,
    /// Squared distance of it, and a lower bound of that of all others [m²].
    pub squared: T,
    pub others: T,
}

/// Triangles relative to a position.
pub struct View<'a, T> {
    pub level: SimdLevel,
    pub surface: &'a MeshSurface<T>,
    pub now: &'a MeshNow<T>,
    pub x: [T; 3],
}

impl<T: Real> View<'_, T> {
    /// The nearest point of a triangle.
    pub fn nearest(&self, triangle: u32) -> Nearest<T> {
        nearest(self.x, &self.surface.corners(self.now, triangle, self.now.pose_fractions[1]))
    }

    /// Squared distances of triangles [m²], [`LANES`] at most; further lanes have no meaning.
    pub fn squared(&self, triangles: impl Iterator<Item = u32>) -> [T; LANES] {
        let mut corners = [[[T::ZERO; LANES]; 3]; 3];
        for (lane, triangle) in triangles.enumerate() {
            let [a, b, c] = self.surface.corners(self.now, triangle, self.now.pose_fractions[1]);
            for axis in 0..3 {
                corners[0][axis][lane] = a[axis];
                corners[1][axis][lane] = b[axis];
                corners[2][axis][lane] = c[axis];
            }
        }
        self.level.run(Distances { x: self.x, corners: &corners })
    }
}

impl<T: Real> Closest<T> {
    /// Starts with one triangle.
    pub fn new(triangle: u32, squared: T) -> Self {
        Self { triangle, squared, others: T::FAR }
    }

    /// Compares another; of those at the same distance, the first is the nearest.
    pub fn consider(&mut self, triangle: u32, squared: T) {
        if triangle == self.triangle {
            return;
        }
        let first = triangle < self.triangle;
        if squared < self.squared || (squared == self.squared && first) {
            (self.triangle, self.squared, self.others) = (triangle, squared, self.squared);
        } else {
            self.leave(squared);
        }
    }

    /// Compares all that may be nearer.
    pub fn look_around(&mut self, view: &View<'_, T>) {
        let tree = view.surface.tree(view.now);
        let left_out = tree.visit_around(view.x, self.squared, |triangles| {
            for (triangle, squared) in triangles.clone().zip(view.squared(triangles)) {
                self.consider(triangle, squared);
            }
            self.squared
        });
        self.leave(left_out);
    }

    /// All that were skipped are no nearer than this [m²].
    pub fn leave(&mut self, squared: T) {
        self.others = if squared < self.others { squared } else { self.others };
    }
}
