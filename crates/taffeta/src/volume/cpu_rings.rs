//! Springs of a closed mesh and gradients of its volume in one walk around each node: both need the same neighbours.

use crate::cpu::column::Column;
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::elements::spring::cpu_gathers::level_for_gathers;
use crate::elements::spring::cpu_mesh::{GatheredSprings, gather, gather_places, lanes_of};
use crate::elements::spring::spring;
use crate::real::Real;
use crate::topology::LANES;
use std::ops::Range;

impl<T: Real> GatheredSprings<T> {
    /// Adds to `force` [N] the springs of the nodes of `slices`, and finds the gradient of the volume by each place [m²];
    /// `old` is the state from the body's first node on. Entries are in the order of rings.
    pub fn springs_and_gradients(
        &self,
        level: SimdLevel,
        slices: Range<usize>,
        old: [&[T]; 6],
        force: &mut [Column<T>; 3],
        gradient: &mut [Column<T>; 3],
    ) {
        level_for_gathers(level).run(Rings { springs: self, slices, old, force, gradient });
    }

    /// Finds the gradient of the volume by each place [m²]; `places` are from the body's first node on.
    pub fn gradients(
        &self,
        level: SimdLevel,
        slices: Range<usize>,
        places: [&[T]; 3],
        gradient: &mut [Column<T>; 3],
    ) {
        level_for_gathers(level).run(Gradients { springs: self, slices, places, gradient });
    }
}

/// A walk around sixteen nodes: Σ rₖ × rₖ₊₁ over their neighbours, where r is the vector to one.
struct Walk<T> {
    first: [[T; LANES]; 3],
    last: [[T; LANES]; 3],
    sum: [[T; LANES]; 3],
}

impl<T: Real> Walk<T> {
    #[inline(always)]
    fn new() -> Self {
        let zero = [[T::ZERO; LANES]; 3];
        Self { first: zero, last: zero, sum: zero }
    }

    /// Goes on to the next neighbours; padding, whose rest length is 0, does not count.
    #[inline(always)]
    fn go(&mut self, to: &[[T; LANES]; 3], rest_lengths: &[T; LANES]) {
        self.add(to);
        // Lane by lane within an axis: as a choice, not as branches.
        for (last, to) in self.last.iter_mut().zip(to) {
            for lane in 0..LANES {
                last[lane] = if rest_lengths[lane] != T::ZERO { to[lane] } else { last[lane] };
            }
        }
    }

    #[inline(always)]
    fn add(&mut self, to: &[[T; LANES]; 3]) {
        let (from, sum) = (&self.last, &mut self.sum);
        for lane in 0..LANES {
            sum[0][lane] += from[1][lane] * to[2][lane] - from[2][lane] * to[1][lane];
            sum[1][lane] += from[2][lane] * to[0][lane] - from[0][lane] * to[2][lane];
            sum[2][lane] += from[0][lane] * to[1][lane] - from[1][lane] * to[0][lane];
        }
    }

    /// Closes the walk; writes the gradients.
    #[inline(always)]
    fn close(mut self, gradient: [&mut [T]; 3]) {
        let first = self.first;
        self.add(&first);
        let six = T::from_f64(6.0);
        for (gradient, mut sum) in gradient.into_iter().zip(self.sum) {
            for sum in &mut sum {
                *sum = *sum / six;
            }
            gradient.copy_from_slice(&sum);
        }
    }
}

/// Kernel: springs and gradients of some slices.
struct Rings<'a, T> {
    springs: &'a GatheredSprings<T>,
    slices: Range<usize>,
    old: [&'a [T]; 6],
    force: &'a mut [Column<T>; 3],
    gradient: &'a mut [Column<T>; 3],
}

impl<T: Real> Kernel for Rings<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { springs, slices, old, force: [fx, fy, fz], gradient: [gx, gy, gz] } = self;
        let all = springs.places();
        let [x, y, z, u, v, w] = old;
        let old = [&x[..all], &y[..all], &z[..all], &u[..all], &v[..all], &w[..all]];
        let mut other = [[T::ZERO; LANES]; 6];
        for (index, slice) in slices.enumerate() {
            let own = lanes_of(&old, slice);
            let (mut sum, mut walk) = ([[T::ZERO; LANES]; 3], Walk::new());
            for (k, (neighbours, rest_lengths)) in springs.slice(slice).enumerate() {
                gather(&old, neighbours, &mut other);
                let to = add_springs(springs, &own, &other, rest_lengths, &mut sum);
                if k == 0 {
                    walk.first = to;
                }
                walk.go(&to, rest_lengths);
            }
            let here = index * LANES..(index + 1) * LANES;
            for (force, sum) in [&mut *fx, &mut *fy, &mut *fz].into_iter().zip(&sum) {
                force[here.clone()].iter_mut().zip(sum).for_each(|(force, &sum)| *force += sum);
            }
            walk.close([&mut gx[here.clone()], &mut gy[here.clone()], &mut gz[here]]);
        }
    }
}

/// Adds the springs to one neighbour of each lane; returns the vectors to them. A rest length below 0: no spring.
#[inline(always)]
fn add_springs<T: Real>(
    springs: &GatheredSprings<T>,
    own: &[[T; LANES]; 6],
    other: &[[T; LANES]; 6],
    rest_lengths: &[T; LANES],
    sum: &mut [[T; LANES]; 3],
) -> [[T; LANES]; 3] {
    let mut to = [[T::ZERO; LANES]; 3];
    for lane in 0..LANES {
        let d = [other[0][lane] - own[0][lane], other[1][lane] - own[1][lane], other[2][lane] - own[2][lane]];
        let dv =
            [other[3][lane] - own[3][lane], other[4][lane] - own[4][lane], other[5][lane] - own[5][lane]];
        let rest = rest_lengths[lane];
        let factor = spring::factor(d, dv, springs.k, springs.damping, rest);
        let factor = if rest > T::ZERO { factor } else { T::ZERO };
        for axis in 0..3 {
            sum[axis][lane] += factor * d[axis];
            to[axis][lane] = d[axis];
        }
    }
    to
}

/// Kernel: gradients of some slices.
struct Gradients<'a, T> {
    springs: &'a GatheredSprings<T>,
    slices: Range<usize>,
    places: [&'a [T]; 3],
    gradient: &'a mut [Column<T>; 3],
}

impl<T: Real> Kernel for Gradients<'_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        let Self { springs, slices, places, gradient: [gx, gy, gz] } = self;
        let all = springs.places();
        let [x, y, z] = places;
        let places = [&x[..all], &y[..all], &z[..all]];
        let mut other = [[T::ZERO; LANES]; 3];
        for (index, slice) in slices.enumerate() {
            let mut own = [[T::ZERO; LANES]; 3];
            for (own, column) in own.iter_mut().zip(places) {
                own.copy_from_slice(&column[slice * LANES..(slice + 1) * LANES]);
            }
            let mut walk = Walk::new();
            for (k, (neighbours, rest_lengths)) in springs.slice(slice).enumerate() {
                gather_places(&places, neighbours, &mut other);
                let mut to = [[T::ZERO; LANES]; 3];
                for lane in 0..LANES {
                    to[0][lane] = other[0][lane] - own[0][lane];
                    to[1][lane] = other[1][lane] - own[1][lane];
                    to[2][lane] = other[2][lane] - own[2][lane];
                }
                if k == 0 {
                    walk.first = to;
                }
                walk.go(&to, rest_lengths);
            }
            let here = index * LANES..(index + 1) * LANES;
            walk.close([&mut gx[here.clone()], &mut gy[here.clone()], &mut gz[here]]);
        }
    }
}
