//! Passes over the bands of a chunk of nodes, sixteen rows at a time.

use crate::cpu::simd::Kernel;
use crate::real::{Real, sub};
use crate::solvers::dual::distance::{Softness, noise};
use crate::topology::LANES;
use std::ops::Range;

pub type Lanes<T> = [T; LANES];

/// A band of a body's rows: `step` is from the first node of a row to its second. `first` and `second` are where the row
/// is of which node 0 is that end, in columns with room for the nodes before.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Band {
    pub step: usize,
    pub first: usize,
    pub second: usize,
    pub material: usize,
}

/// Sixteen numbers of a column.
#[inline(always)]
fn lanes<T>(column: &[T], at: usize) -> &Lanes<T> {
    let lanes = column[at..at + LANES].as_array();
    lanes.expect("as many as were asked for")
}

/// Sixteen numbers of a column, whose last one stands in for those after it.
#[inline(always)]
fn fetch<T: Real>(column: &[T], at: usize, found: &mut Lanes<T>) {
    if let Some(inside) = column.get(at..at + LANES) {
        found.copy_from_slice(inside);
    } else {
        let last = column.len() - 1;
        for (lane, found) in found.iter_mut().enumerate() {
            *found = column[(at + lane).min(last)];
        }
    }
}

/// Splits a column of whole vectors.
#[inline(always)]
fn blocks<T>(column: &[T], nodes: usize) -> &[Lanes<T>] {
    column[..nodes].as_chunks().0
}

/// The same to write.
#[inline(always)]
fn blocks_mut<T>(column: &mut [T], nodes: usize) -> &mut [Lanes<T>] {
    column[..nodes].as_chunks_mut().0
}

/// The sum of lanes, the upper half added to the lower repeatedly. Kernels return lanes: if they added these up
/// themselves, the compiler would not keep them in vectors.
pub fn total<T: Real>(lanes: &Lanes<T>) -> f64 {
    let mut sums = lanes.map(T::to_f64);
    for half in [8, 4, 2, 1] {
        for lane in 0..half {
            sums[lane] += sums[lane + half];
        }
    }
    sums[0]
}

/// Kernel: sets up the rows of a band at a chunk of nodes.
pub struct SetUpBand<'a, T> {
    /// Solver index of the first node.
    pub first: usize,
    /// From a node to the other end of its row.
    pub step: usize,
    pub softness: &'a Softness<T>,
    pub position: [&'a [T]; 3],
    pub inverse_mass: &'a [T],
    /// By row: rest length [m], less than 0 where there is none; force in the last sub-step.
    pub rest: &'a [T],
    pub multiplier: &'a [T],
    pub direction: [&'a mut [T]; 3],
    pub compliance: &'a mut [T],
    pub scale: &'a mut [T],
    pub right: &'a mut [T],
    pub x: &'a mut [T],
    pub vector: &'a mut [T],
}

impl<T: Real> Kernel for SetUpBand<'_, T> {
    /// Sums of the squares of the rounding errors.
    type Output = Lanes<f64>;
    #[inline(always)]
    fn run(self) -> Lanes<f64> {
        let (nodes, mut sums) = (self.rest.len(), [0.0; LANES]);
        let ([px, py, pz], w) = (self.position, self.inverse_mass);
        let [dx, dy, dz] = self.direction;
        let (rest, multiplier) = (blocks(self.rest, nodes), blocks(self.multiplier, nodes));
        let (dx, dy, dz) = (blocks_mut(dx, nodes), blocks_mut(dy, nodes), blocks_mut(dz, nodes));
        let (compliance, scale) = (blocks_mut(self.compliance, nodes), blocks_mut(self.scale, nodes));
        let (right, x) = (blocks_mut(self.right, nodes), blocks_mut(self.x, nodes));
        let vector = blocks_mut(self.vector, nodes);
        for i in 0..rest.len() {
            let at = self.first + i * LANES;
            let [mut ax, mut ay, mut az, mut aw] = [[T::ZERO; LANES]; 4];
            let [mut bx, mut by, mut bz, mut bw] = [[T::ZERO; LANES]; 4];
            for (column, a, b) in [
                (px, &mut ax, &mut bx),
                (py, &mut ay, &mut by),
                (pz, &mut az, &mut bz),
                (w, &mut aw, &mut bw),
            ] {
                a.copy_from_slice(&column[at..at + LANES]);
                fetch(column, at + self.step, b);
            }
            let ([mut ux, mut uy, mut uz, mut d, mut c], mut size, mut x0, mut rounding) =
                ([[T::ZERO; LANES]; 5], [T::ZERO; LANES], [T::ZERO; LANES], [0.0; LANES]);
            for lane in 0..LANES {
                let start = [ax[lane], ay[lane], az[lane]];
                let between = sub([bx[lane], by[lane], bz[lane]], start);
                let row = self.softness.row(between, aw[lane] + bw[lane], rest[i][lane]);
                let noise = noise(&row, self.softness.rate, start).to_f64();
                let by_scale = if row.scale > T::ZERO { T::ONE / row.scale } else { T::ZERO };
                let is_there = rest[i][lane] >= T::ZERO;
                let x = multiplier[i][lane] * by_scale;
                ux[lane] = if is_there { row.direction[0] } else { T::ZERO };
                uy[lane] = if is_there { row.direction[1] } else { T::ZERO };
                uz[lane] = if is_there { row.direction[2] } else { T::ZERO };
                d[lane] = if is_there { row.compliance } else { T::ZERO };
                c[lane] = if is_there { row.right } else { T::ZERO };
                size[lane] = if is_there { row.scale } else { T::ZERO };
                x0[lane] = if is_there { x } else { T::ZERO };
                rounding[lane] = if is_there { noise * noise } else { 0.0 };
            }
            for lane in 0..LANES {
                sums[lane] += rounding[lane];
            }
            (dx[i], dy[i], dz[i], compliance[i]) = (ux, uy, uz, d);
            (scale[i], right[i], x[i], vector[i]) = (size, c, x0, x0);
        }
        sums
    }
}

/// Kernel: the forces of a vector at the nodes of a chunk.
pub struct GatherBands<'a, T> {
    /// Where rows are with node 0 as their second and first end, in the order in which forces are added.
    pub seconds: &'a [usize],
    pub firsts: &'a [usize],
    pub direction: [&'a [T]; 3],
    pub vector: &'a [T],
    pub nodes: Range<usize>,
    /// By node of the chunk: what forces are multiplied by, and the directions of contacts. Empty: nothing.
    pub inverse_mass: &'a [T],
    pub contact: Option<[&'a [T]; 4]>,
    pub out: [&'a mut [T]; 3],
}

impl<T: Real> Kernel for GatherBands<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { seconds, firsts, direction: [dx, dy, dz], vector, nodes, inverse_mass, .. } = self;
        let (count, all) = (nodes.len(), vector.len());
        let (dx, dy, dz) = (&dx[..all], &dy[..all], &dz[..all]);
        let [x, y, z] = self.out;
        let (x, y, z) = (blocks_mut(x, count), blocks_mut(y, count), blocks_mut(z, count));
        let inverse_mass = blocks(inverse_mass, if inverse_mass.is_empty() { 0 } else { count });
        for i in 0..x.len() {
            let (node, [mut sx, mut sy, mut sz]) = (nodes.start + i * LANES, [[T::ZERO; LANES]; 3]);
            for &start in seconds {
                let at = start + node;
                let (length, dx, dy, dz) = (lanes(vector, at), lanes(dx, at), lanes(dy, at), lanes(dz, at));
                for lane in 0..LANES {
                    sx[lane] += dx[lane] * length[lane];
                    sy[lane] += dy[lane] * length[lane];
                    sz[lane] += dz[lane] * length[lane];
                }
            }
            for &start in firsts {
                let at = start + node;
                let (length, dx, dy, dz) = (lanes(vector, at), lanes(dx, at), lanes(dy, at), lanes(dz, at));
                for lane in 0..LANES {
                    sx[lane] -= dx[lane] * length[lane];
                    sy[lane] -= dy[lane] * length[lane];
                    sz[lane] -= dz[lane] * length[lane];
                }
            }
            if let Some(w) = inverse_mass.get(i) {
                for lane in 0..LANES {
                    sx[lane] = w[lane] * sx[lane];
                    sy[lane] = w[lane] * sy[lane];
                    sz[lane] = w[lane] * sz[lane];
                }
            }
            if let Some([nx, ny, nz, slides]) = self.contact {
                let at = i * LANES;
                let (nx, ny, nz, slides) = (lanes(nx, at), lanes(ny, at), lanes(nz, at), lanes(slides, at));
                for lane in 0..LANES {
                    let along = sx[lane] * nx[lane] + sy[lane] * ny[lane] + sz[lane] * nz[lane];
                    sx[lane] = (sx[lane] - nx[lane] * along) * slides[lane];
                    sy[lane] = (sy[lane] - ny[lane] * along) * slides[lane];
                    sz[lane] = (sz[lane] - nz[lane] * along) * slides[lane];
                }
            }
            (x[i], y[i], z[i]) = (sx, sy, sz);
        }
    }
}

/// Kernel: multiplies a vector by the matrix. `response` is the part at the nodes.
pub struct ApplyBands<'a, T> {
    pub bands: &'a [Band],
    pub direction: [&'a [T]; 3],
    pub vector: &'a [T],
    pub response: [&'a [T]; 3],
    pub nodes: Range<usize>,
    /// By row of the chunk.
    pub compliance: &'a [T],
    pub out: &'a mut [T],
}

impl<T: Real> Kernel for ApplyBands<'_, T> {
    /// Vector times itself, vector times result.
    type Output = [Lanes<T>; 2];
    #[inline(always)]
    fn run(self) -> [Lanes<T>; 2] {
        let Self { bands, direction: [dx, dy, dz], vector, response: [x, y, z], nodes, .. } = self;
        let (count, node) = (nodes.len(), nodes.start);
        let a = [blocks(&x[node..], count), blocks(&y[node..], count), blocks(&z[node..], count)];
        let (compliances, outs) = (self.compliance.chunks_exact(count), self.out.chunks_exact_mut(count));
        let (mut squares, mut products) = ([T::ZERO; LANES], [T::ZERO; LANES]);
        for ((band, compliance), out) in bands.iter().zip(compliances).zip(outs) {
            let (at, there) = (band.first + node, node + band.step);
            let d = [blocks(&dx[at..], count), blocks(&dy[at..], count), blocks(&dz[at..], count)];
            let b = [blocks(&x[there..], count), blocks(&y[there..], count), blocks(&z[there..], count)];
            let (vector, compliance) = (blocks(&vector[at..], count), blocks(compliance, count));
            for (i, out) in blocks_mut(out, count).iter_mut().enumerate() {
                let (ax, ay, az, vector) = (&a[0][i], &a[1][i], &a[2][i], &vector[i]);
                let (bx, by, bz, compliance) = (&b[0][i], &b[1][i], &b[2][i], &compliance[i]);
                let (dx, dy, dz) = (&d[0][i], &d[1][i], &d[2][i]);
                let mut found = [T::ZERO; LANES];
                for lane in 0..LANES {
                    let x = (bx[lane] - ax[lane]) * dx[lane];
                    let y = (by[lane] - ay[lane]) * dy[lane];
                    let z = (bz[lane] - az[lane]) * dz[lane];
                    found[lane] = x + y + z + compliance[lane] * vector[lane];
                }
                for lane in 0..LANES {
                    squares[lane] += vector[lane] * vector[lane];
                    products[lane] += vector[lane] * found[lane];
                }
                *out = found;
            }
        }
        [squares, products]
    }
}

/// Kernel: a vector plus a multiple of another.
pub struct CombineBands<'a, T> {
    pub to: &'a mut [T],
    pub factor: T,
    pub other: &'a [T],
}

impl<T: Real> Kernel for CombineBands<'_, T> {
    /// The result times itself.
    type Output = Lanes<T>;
    #[inline(always)]
    fn run(self) -> Lanes<T> {
        let (count, mut squares) = (self.other.len(), [T::ZERO; LANES]);
        for (to, other) in blocks_mut(self.to, count).iter_mut().zip(blocks(self.other, count)) {
            for lane in 0..LANES {
                to[lane] += self.factor * other[lane];
                squares[lane] += to[lane] * to[lane];
            }
        }
        squares
    }
}
