//! The least numbers that satisfy many linear rows, by conjugate gradients: x = Sᵀλ with (S Sᵀ + ε) λ = r.
//!
//! The numbers are a symmetric matrix X for each triangle and six moments c for each vertex inside. S is not formed: a row reads
//! l·X c at the triangles beside an edge, and the moments at its ends. All sums are in a fixed order, whatever the number of threads.

use crate::elements::bending::build::Matrix;
use crate::real::{add, dot, scale};
use crate::topology::Csr;
use rayon::prelude::*;

/// ε, where every row has the length 1.
const RIDGE: f64 = 2e-4;

/// The residual at which the iteration ends, as a part of the first one.
const TOLERANCE: f64 = 1e-2;

/// Iterations at most. Meshes take 100 to 250, whatever their size.
const ITERATIONS: usize = 400;

/// Where there is no row, side or end.
pub const NONE: u32 = u32::MAX;

/// What the rows of an edge read of the triangle at one side: l·X c, with a c for each row.
#[derive(Clone, Copy, Default)]
pub struct Side {
    /// The edge's rows.
    pub rows: u32,
    pub l: [f64; 3],
    pub c: [[f64; 3]; 3],
}

/// The three rows of an edge.
#[derive(Clone, Copy)]
pub struct Rows {
    /// Three times a triangle, and which of its edges.
    pub sides: [u32; 2],
    /// The ends that have moments.
    pub ends: [End; 2],
    /// Factor on what each row reads of the moments.
    pub weight: [f64; 3],
    /// Right side.
    pub wanted: [f64; 3],
}

/// An end of an edge.
#[derive(Clone, Copy)]
pub struct End {
    /// The vertex, among those with moments.
    pub vertex: u32,
    /// Cosine and sine of the edge's angle around it.
    pub outward: [f64; 2],
}

/// No end.
pub const NO_END: End = End { vertex: NONE, outward: [0.0; 2] };

/// Rows of edges, by what they read.
pub struct System {
    sides: Vec<[Side; 3]>,
    rows: Vec<Rows>,
    /// Twice an edge's number and which of its ends, by vertex.
    ends: Csr,
    vertices: usize,
}

/// A vertex's moments, by direction.
type Moments = [[f64; 3]; 2];

/// What a product needs on its way.
struct Work {
    moments: Vec<Moments>,
    read: Vec<Matrix>,
}

impl System {
    /// Of triangles and edges, each row scaled to the length 1.
    pub fn new(mut sides: Vec<[Side; 3]>, mut rows: Vec<Rows>, vertices: usize) -> Self {
        for one in &mut rows {
            let ends = one.ends.iter().filter(|end| end.vertex != NONE).count() as f64;
            let squared = [0, 1, 2].map(|i| {
                let of_side = |&side: &u32| {
                    let Side { l, c, .. } = sides[side as usize / 3][side as usize % 3];
                    0.5 * (dot(l, l) * dot(c[i], c[i]) + dot(l, c[i]) * dot(l, c[i]))
                };
                let beside: f64 = one.sides.iter().filter(|&&side| side != NONE).map(of_side).sum();
                beside + ends * one.weight[i] * one.weight[i]
            });
            let factor = squared.map(|squared| if squared > 0.0 { 1.0 / squared.sqrt() } else { 0.0 });
            one.weight = [0, 1, 2].map(|i| one.weight[i] * factor[i]);
            one.wanted = [0, 1, 2].map(|i| one.wanted[i] * factor[i]);
            for &side in one.sides.iter().filter(|&&side| side != NONE) {
                let c = &mut sides[side as usize / 3][side as usize % 3].c;
                *c = [0, 1, 2].map(|i| scale(c[i], factor[i]));
            }
        }
        let all =
            rows.iter().zip(0..).flat_map(|(row, at)| [(row.ends[0], 2 * at), (row.ends[1], 2 * at + 1)]);
        let ends = all.filter(|(end, _)| end.vertex != NONE).map(|(end, at)| (end.vertex, at));
        let ends = Csr::new(vertices, ends.collect::<Vec<_>>().into_iter());
        Self { sides, rows, ends, vertices }
    }

    /// X of each triangle.
    pub fn least(&self) -> Vec<Matrix> {
        let solved = self.solve();
        let mut all = vec![Matrix::default(); self.sides.len()];
        each(&mut all, |t, x| *x = self.correction(t, &solved));
        all
    }

    fn solve(&self) -> Vec<[f64; 3]> {
        let mut residual: Vec<[f64; 3]> = self.rows.iter().map(|row| row.wanted).collect();
        let mut solved = vec![[0.0; 3]; residual.len()];
        let mut direction = residual.clone();
        let mut product = solved.clone();
        let mut work = Work {
            moments: vec![Moments::default(); self.vertices],
            read: vec![Matrix::default(); self.sides.len()],
        };
        let mut squared = sum(&residual, &residual);
        let enough = TOLERANCE * TOLERANCE * squared;
        for _ in 0..ITERATIONS {
            self.product(&direction, &mut work, &mut product);
            let along = sum(&direction, &product);
            if !(squared > enough && along > 0.0) {
                break;
            }
            let step = squared / along;
            each(&mut solved, |i, to| *to = add(*to, scale(direction[i], step)));
            each(&mut residual, |i, to| *to = add(*to, scale(product[i], -step)));
            let next = sum(&residual, &residual);
            each(&mut direction, |i, to| *to = add(residual[i], scale(*to, next / squared)));
            squared = next;
        }
        solved
    }

    /// Sᵀ at a triangle.
    fn correction(&self, triangle: usize, of: &[[f64; 3]]) -> Matrix {
        let mut all = Matrix::default();
        for side in self.sides[triangle].iter().filter(|side| side.rows != NONE) {
            let y = combined(&side.c, of[side.rows as usize]);
            for i in 0..3 {
                for j in 0..3 {
                    all[i][j] += 0.5 * (side.l[i] * y[j] + side.l[j] * y[i]);
                }
            }
        }
        all
    }

    /// Sᵀ at a vertex.
    fn moments(&self, vertex: usize, of: &[[f64; 3]]) -> Moments {
        let mut all = Moments::default();
        for &at in self.ends.row(vertex) {
            let row = &self.rows[at as usize / 2];
            let [u, v] = row.ends[at as usize % 2].outward;
            let p = of[at as usize / 2];
            let turned = combined(&frame([u, v]), [0, 1, 2].map(|i| row.weight[i] * p[i]));
            all = [add(all[0], scale(turned, u)), add(all[1], scale(turned, v))];
        }
        all
    }

    /// (S Sᵀ + ε) times `of`.
    fn product(&self, of: &[[f64; 3]], work: &mut Work, to: &mut [[f64; 3]]) {
        each(&mut work.read, |t, read| {
            let x = self.correction(t, of);
            *read = self.sides[t].map(|side| {
                let y = x.map(|row| dot(row, side.l));
                side.c.map(|c| dot(c, y))
            });
        });
        each(&mut work.moments, |vertex, moments| *moments = self.moments(vertex, of));
        let work = &*work;
        each(to, |at, to| {
            let row = &self.rows[at];
            *to = scale(of[at], RIDGE);
            for &side in row.sides.iter().filter(|&&side| side != NONE) {
                *to = add(*to, work.read[side as usize / 3][side as usize % 3]);
            }
            for end in row.ends.iter().filter(|end| end.vertex != NONE) {
                let [c, d] = work.moments[end.vertex as usize];
                let along = add(scale(c, end.outward[0]), scale(d, end.outward[1]));
                let turned = frame(end.outward).map(|row| dot(row, along));
                (0..3).for_each(|i| to[i] += row.weight[i] * turned[i]);
            }
        });
    }
}

/// Curvatures nn, tt, √2 nt of an edge that runs along (u, v), from 11, 22, √2 12; n is to the right of it.
fn frame([u, v]: [f64; 2]) -> Matrix {
    let (uu, vv, uv) = (u * u, v * v, std::f64::consts::SQRT_2 * u * v);
    [[vv, uu, -uv], [uu, vv, uv], [uv, -uv, vv - uu]]
}

fn combined(rows: &Matrix, by: [f64; 3]) -> [f64; 3] {
    add(add(scale(rows[0], by[0]), scale(rows[1], by[1])), scale(rows[2], by[2]))
}

fn sum(a: &[[f64; 3]], b: &[[f64; 3]]) -> f64 {
    a.iter().zip(b).map(|(&a, &b)| dot(a, b)).sum()
}

/// Entries that one thread takes at least: fewer are done sooner by one.
const FEW: usize = 2048;

/// Sets each entry, by several threads where there are many.
pub fn each<T: Send>(all: &mut [T], set: impl Fn(usize, &mut T) + Sync) {
    if all.len() < 2 * FEW {
        all.iter_mut().enumerate().for_each(|(i, to)| set(i, to));
    } else {
        all.par_iter_mut().with_min_len(FEW).enumerate().for_each(|(i, to)| set(i, to));
    }
}
