//! Passes over the rows and nodes of a chunk.

use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::cpu::simd::Kernel;
use crate::cpu::sums::Sums;
use crate::elements::spring::spring;
use crate::real::{Real, norm, sub};
use crate::solvers::dual::cpu::Quad;
use crate::solvers::dual::distance::{Row, Softness, noise};

/// The sign of a constraint force at the first and at the second end of a row.
fn signs<T: Real>() -> [T; 2] {
    [-T::ONE, T::ONE]
}

/// Kernel: sets up the row of each constraint.
pub struct SetUpRows<'a, T> {
    /// By row: its constraint. By constraint: places of its ends, rest length [m], number of its material.
    pub which: &'a [u32],
    pub all_ends: &'a [[u32; 2]],
    pub rest: &'a [T],
    pub material: &'a [u32],
    pub softness: &'a [Softness<T>],
    pub inverse_mass: &'a [T],
    pub old: [&'a [T]; 6],
    /// If springs act as well: stiffness and damping of each material, and the target stretch of constraints.
    pub springs: Option<(&'a [[f64; 2]], T)>,
    /// By constraint: its force in the last sub-step.
    pub multiplier: &'a [T],
    pub rows: &'a mut [Quad<T>],
    pub scale: &'a mut [T],
    /// Right side.
    pub right: &'a mut [T],
    pub x: &'a mut [T],
    pub offset: &'a mut [T],
}

impl<T: Real> Kernel for SetUpRows<'_, T> {
    /// Sum of the squares of the rounding errors.
    type Output = f64;
    #[inline(always)]
    fn run(self) -> f64 {
        let mut sum = 0.0;
        for (i, &constraint) in self.which.iter().enumerate() {
            let constraint = constraint as usize;
            let [a, b] = self.all_ends[constraint].map(|end| end as usize);
            let place = |node: usize| [self.old[0][node], self.old[1][node], self.old[2][node]];
            let d = sub(place(b), place(a));
            let material = self.material[constraint] as usize;
            let (softness, mut rest) = (&self.softness[material], self.rest[constraint]);
            let mut force = T::ZERO;
            if let Some((materials, stretch)) = self.springs {
                let velocity = |node: usize| [self.old[3][node], self.old[4][node], self.old[5][node]];
                let [k, damping] = materials[material].map(T::from_f64);
                force = spring::factor(d, sub(velocity(b), velocity(a)), k, damping, rest) * norm(d);
                rest = stretch * rest;
            }
            let row = softness.row(d, self.inverse_mass[a] + self.inverse_mass[b], rest);
            let noise = noise(&row, softness.rate, place(a)).to_f64();
            sum += noise * noise;
            let by_scale = if row.scale > T::ZERO { T::ONE / row.scale } else { T::ZERO };
            let Row { direction: [x, y, z], compliance, .. } = row;
            self.rows[i] = Quad([x, y, z, compliance]);
            self.scale[i] = row.scale;
            self.right[i] = row.right;
            self.x[i] = self.multiplier[constraint] * by_scale;
            self.offset[i] = force * by_scale;
        }
        sum
    }
}

/// Kernel: the response of each node to constraint forces. The fourth number of a quad has no meaning.
pub struct GatherConstraintForces<'a, T> {
    /// By node: its entries.
    pub spans: &'a [[u32; 2]],
    pub entries: &'a [u32],
    pub row_forces: &'a [Quad<T>],
    /// By node: its place, and by place the inverse mass.
    pub places: &'a [u32],
    pub inverse_mass: &'a [T],
    /// By node: its predicted contact. Empty: no contacts.
    pub predicted: &'a [PredictedContact<T>],
    pub out: &'a mut [Quad<T>],
}

impl<T: Real> Kernel for GatherConstraintForces<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { spans, entries, row_forces, places, inverse_mass, predicted, out } = self;
        for ((out, span), &place) in out.iter_mut().zip(spans).zip(places) {
            let sum = gather(&entries[span[0] as usize..span[1] as usize], row_forces);
            let w = inverse_mass[place as usize];
            *out = Quad(sum.0.map(|number| w * number));
        }
        for (out, predicted) in out.iter_mut().zip(predicted) {
            let [x, y, z] = predicted.filtered([out.0[0], out.0[1], out.0[2]]);
            *out = Quad([x, y, z, T::ZERO]);
        }
    }
}

/// The sum of the constraint forces at a node, with their signs.
#[inline(always)]
pub fn gather<T: Real>(entries: &[u32], row_forces: &[Quad<T>]) -> Quad<T> {
    let signs = signs::<T>();
    let mut sum = [T::ZERO; 4];
    for &entry in entries {
        let (force, sign) = (&row_forces[entry as usize / 2], signs[entry as usize % 2]);
        for (sum, force) in sum.iter_mut().zip(force.0) {
            *sum += sign * force;
        }
    }
    Quad(sum)
}

/// Kernel: multiplies a vector by the matrix. `response` is the part at the nodes.
pub struct Apply<'a, T> {
    pub rows: &'a [Quad<T>],
    pub ends: &'a [[u32; 2]],
    pub response: &'a [Quad<T>],
    pub vector: &'a [T],
    pub out: &'a mut [T],
}

impl<T: Real> Kernel for Apply<'_, T> {
    /// Vector times itself, vector times result.
    type Output = [f64; 2];
    #[inline(always)]
    fn run(self) -> [f64; 2] {
        let Self { rows, ends, response, vector, out } = self;
        for (((out, row), [a, b]), &vector) in out.iter_mut().zip(rows).zip(ends).zip(vector) {
            let (a, b) = (&response[*a as usize].0, &response[*b as usize].0);
            let mut part = [T::ZERO; 4];
            for axis in 0..4 {
                part[axis] = (b[axis] - a[axis]) * row.0[axis];
            }
            *out = part[0] + part[1] + part[2] + row.0[3] * vector;
        }
        // In a pass of their own, by whole groups of lanes, sums stay in registers.
        [Sums::of(vector, vector), Sums::of(vector, out)]
    }
}

/// Kernel: adds a multiple of a vector to another.
pub struct Combine<'a, T> {
    pub to: &'a mut [T],
    pub factor: T,
    pub other: &'a [T],
}

impl<T: Real> Kernel for Combine<'_, T> {
    /// The result times itself.
    type Output = f64;
    #[inline(always)]
    fn run(self) -> f64 {
        for (to, &other) in self.to.iter_mut().zip(self.other) {
            *to += self.factor * other;
        }
        Sums::of(self.to, self.to)
    }
}

/// Kernel: scales a vector.
pub struct Multiply<'a, T> {
    pub vector: &'a mut [T],
    pub factor: T,
}

impl<T: Real> Kernel for Multiply<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for number in self.vector {
            *number = self.factor * *number;
        }
    }
}

/// Kernel: the product of two vectors.
pub struct Product<'a, T> {
    pub a: &'a [T],
    pub b: &'a [T],
}

impl<T: Real> Kernel for Product<'_, T> {
    type Output = f64;
    #[inline(always)]
    fn run(self) -> f64 {
        Sums::of(self.a, self.b)
    }
}

/// Kernel: the force of a vector along each row's direction.
pub struct Along<'a, T> {
    pub rows: &'a [Quad<T>],
    pub vector: &'a [T],
    pub row_forces: &'a mut [Quad<T>],
}

impl<T: Real> Kernel for Along<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        for ((row_forces, row), &length) in self.row_forces.iter_mut().zip(self.rows).zip(self.vector) {
            *row_forces = Quad(row.0.map(|number| number * length));
        }
    }
}

/// Kernel: a step of conjugate gradients.
pub struct Advance<'a, T> {
    pub alpha: T,
    pub beta: T,
    pub x: &'a mut [T],
    pub r: &'a mut [T],
    pub p: &'a mut [T],
    pub s: &'a mut [T],
    pub w: &'a [T],
}

impl<T: Real> Kernel for Advance<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { alpha, beta, x, r, p, s, w } = self;
        advance(alpha, beta, x, r, p, s, w);
    }
}

#[inline(always)]
fn advance<T: Real>(alpha: T, beta: T, x: &mut [T], r: &mut [T], p: &mut [T], s: &mut [T], w: &[T]) {
    let n = x.len();
    let (r, p, s, w) = (&mut r[..n], &mut p[..n], &mut s[..n], &w[..n]);
    for i in 0..n {
        p[i] = r[i] + beta * p[i];
        s[i] = w[i] + beta * s[i];
        x[i] += alpha * p[i];
        r[i] -= alpha * s[i];
    }
}
