//! Gusts: a velocity field that changes over space and time, by chance and yet smoothly.
//!
//! Value noise (Perlin, "An image synthesizer", 1985; Ebert et al., "Texturing and Modeling", 2003, ch. 2) in three
//! dimensions of space and one of time: a vector by chance at each point of a lattice, blended between them. Blends are
//! usually weighted by 1 − s and s, s = t²(3 − 2t); then noise is strong at lattice points and weak between them, and all
//! gusts would swell and fade in step. Here each pair of weights is divided by the root of the sum of its squares, so that
//! the mean square is the same everywhere and always.
//!
//! Only sums, products, quotients, roots and whole numbers: the same bits on every machine.

use crate::real::{Real, add, scale};
use crate::scene::Gust;
use crate::topology::random::SplitMix64;

/// What is added to a key on the way to the next lattice point along each axis: odd, so that no two in 2³² are the same.
pub const STRIDES: [u32; 3] = [0x9e37_79b1, 0x85eb_ca77, 0xc2b2_ae3d];

/// Values that a number at a lattice point can take; they are whole, and 0 is in their middle.
pub const VALUES: u32 = 1 << 10;

/// The middle of what [`lattice`] cuts out of a key.
pub const MIDDLE: f64 = (VALUES - 1) as f64 / 2.0;

/// Cells from the origin beyond which the field no longer changes.
pub const FARTHEST_CELL: f64 = 1e9;

/// From one number of [`SplitMix64`] to the next.
const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Gusts at one time.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct GustNow<T> {
    /// Lattice points a metre [1/m].
    pub cells_a_metre: T,
    /// How far the lattice has drifted beyond whole cells, 0 to 1 by axis.
    pub offset: [T; 3],
    /// Keys of the lattices before and after.
    pub keys: [u32; 2],
    /// Weights of the two [m/s].
    pub weights: [T; 2],
}

impl<T: Real> GustNow<T> {
    /// The field at time `t` [s], in air that has drifted with `velocity` [m/s] since 0 s.
    pub fn new(gust: &Gust, velocity: [f64; 3], t: f64) -> Self {
        let drift = velocity.map(|v| v * t / gust.length);
        let cells = drift.map(|cells| cells.floor() as i64 as u32);
        let shift = (0..3).fold(0_u32, |sum, axis| sum.wrapping_add(cells[axis].wrapping_mul(STRIDES[axis])));
        let age = t / gust.period;
        let key = |after: i64| {
            let number = (age.floor() as i64).wrapping_add(after) as u64;
            let mut random = SplitMix64::new(gust.seed.wrapping_add(number.wrapping_mul(STEP)));
            random.bits().wrapping_sub(shift)
        };
        let [before, after] = fade(age - age.floor());
        // Three numbers at a lattice point, each of mean square (VALUES² − 1)/12.
        let rms = ((f64::from(VALUES).powi(2) - 1.0) / 4.0 * (before * before + after * after)).sqrt();
        Self {
            cells_a_metre: T::from_f64(1.0 / gust.length),
            offset: drift.map(|cells| T::from_f64(cells - cells.floor())),
            keys: [key(0), key(1)],
            weights: [before, after].map(|weight| T::from_f64(gust.speed * weight / rms)),
        }
    }

    /// Velocity of the gusts at some places `x` [m], by axis, beside that of the air [m/s].
    #[inline(always)]
    pub fn velocities<const N: usize>(&self, x: &[[T; N]; 3]) -> [[T; N]; 3] {
        let (mut first, mut weights) = ([0_u32; N], [[[T::ZERO; N]; 2]; 3]);
        for axis in 0..3 {
            for i in 0..N {
                let (number, t) = gust_cell(x[axis][i] * self.cells_a_metre - self.offset[axis]);
                first[i] = first[i].wrapping_add(number.wrapping_mul(STRIDES[axis]));
                [weights[axis][0][i], weights[axis][1][i]] = fade(t);
            }
        }
        let mut sum = [[T::ZERO; N]; 3];
        for corner in 0..8 {
            self.add_corner([corner & 1, corner >> 1 & 1, corner >> 2], &first, &weights, &mut sum);
        }
        for i in 0..N {
            let square = |axis: usize| {
                let [a, b] = [weights[axis][0][i], weights[axis][1][i]];
                a * a + b * b
            };
            let scale = T::ONE / (square(0) * square(1) * square(2)).sqrt();
            for sum in &mut sum {
                sum[i] = sum[i] * scale;
            }
        }
        sum
    }

    /// Adds a corner of the cells that start at `first`: at its start or end along each axis.
    #[inline(always)]
    fn add_corner<const N: usize>(
        &self,
        [i, j, k]: [usize; 3],
        first: &[u32; N],
        [x, y, z]: &[[[T; N]; 2]; 3],
        sum: &mut [[T; N]; 3],
    ) {
        let mut stride = 0_u32;
        for (end, along) in [i, j, k].into_iter().zip(STRIDES) {
            stride = stride.wrapping_add(end as u32 * along);
        }
        let [early, late] = [self.keys[0].wrapping_add(stride), self.keys[1].wrapping_add(stride)];
        for lane in 0..N {
            let before = lattice(early.wrapping_add(first[lane]));
            let after = lattice(late.wrapping_add(first[lane]));
            let value = add(scale(before, self.weights[0]), scale(after, self.weights[1]));
            let weight = x[i][lane] * y[j][lane] * z[k][lane];
            sum[0][lane] += value[0] * weight;
            sum[1][lane] += value[1] * weight;
            sum[2][lane] += value[2] * weight;
        }
    }
}

/// The cell that a number is in, and how far from its start [0 to 1).
#[inline(always)]
fn gust_cell<T: Real>(p: T) -> (u32, T) {
    let far = T::from_f64(FARTHEST_CELL);
    let p = if p < far { p } else { far };
    let p = if p > -far { p } else { -far };
    let near = p.whole();
    let start = T::from_whole(near);
    if start > p { ((near - 1) as u32, p - (start - T::ONE)) } else { (near as u32, p - start) }
}

/// Weights of the two ends of a cell at `t` between them; they have no slope there, so that the field has no kinks.
#[inline(always)]
fn fade<T: Real>(t: T) -> [T; 2] {
    let s = t * t * (T::from_f64(3.0) - (t + t));
    [T::ONE - s, s]
}

/// The vector at a lattice point: three numbers of ten bits, around 0.
#[inline(always)]
fn lattice<T: Real>(key: u32) -> [T; 3] {
    let bits = mixed_bits(key);
    [centred(bits >> 22), centred((bits >> 12) % VALUES), centred((bits >> 2) % VALUES)]
}

#[inline(always)]
fn centred<T: Real>(bits: u32) -> T {
    T::from_whole(bits as i32) - T::from_f64(MIDDLE)
}

/// Bits that look like chance (Wellons, "Prospecting for hash functions", 2018: `lowbias32`).
#[inline(always)]
fn mixed_bits(key: u32) -> u32 {
    let a = (key ^ key >> 16).wrapping_mul(0x7feb_352d);
    let b = (a ^ a >> 15).wrapping_mul(0x846c_a68b);
    b ^ b >> 16
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::{dot, norm, sub};

    impl<T: Real> GustNow<T> {
        /// Velocity at one place.
        fn velocity(&self, x: [T; 3]) -> [T; 3] {
            self.velocities(&x.map(|c| [c])).map(|[c]| c)
        }
    }

    const GUST: Gust = Gust { speed: 3.0, length: 0.5, period: 2.0, seed: 7 };

    fn at(gust: &Gust, t: f64, x: [f64; 3]) -> [f64; 3] {
        GustNow::new(gust, [0.0; 3], t).velocity(x)
    }

    /// Places and times all over some thousand cells, by a step that meets all parts of a cell.
    fn samples() -> impl Iterator<Item = (f64, [f64; 3])> {
        (0..40_000).map(|i| {
            let i = f64::from(i);
            (i * 1.234_567, [i * 0.317_811, i * -0.271_828, (i * 0.161_803) % 91.7 - 40.0])
        })
    }

    #[test]
    fn gusts_have_no_mean_and_the_speed_asked_for_by_axis_alike() {
        let (mut sum, mut squares) = ([0.0; 3], [0.0; 3]);
        for (t, x) in samples() {
            let v = at(&GUST, t, x);
            sum = add(sum, v);
            squares = add(squares, [v[0] * v[0], v[1] * v[1], v[2] * v[2]]);
        }
        // 40,000 samples of about independent gusts are right to 1/200.
        assert!(norm(scale(sum, 1.0 / 40_000.0)) < 0.03 * GUST.speed, "{sum:?}");
        for square in squares {
            assert!((square / 40_000.0 / (GUST.speed * GUST.speed / 3.0) - 1.0).abs() < 0.02, "{squares:?}");
        }
    }

    #[test]
    fn the_speed_is_the_same_on_lattice_points_between_them_and_at_all_times() {
        // Over seeds, at one place and time.
        for (t, x) in [(0.0, [0.0; 3]), (1.0, [0.25; 3]), (0.7, [0.5, 0.2, -0.3]), (41.0, [0.25, 0.0, 3.1])] {
            let square = |seed| {
                let v = at(&Gust { seed, ..GUST }, t, x);
                dot(v, v)
            };
            let mean = (0..20_000).map(square).sum::<f64>() / 20_000.0;
            assert!((mean / (GUST.speed * GUST.speed) - 1.0).abs() < 0.02, "{mean} at {x:?}");
        }
    }

    /// Mean scalar product of gusts some way and time apart, by their mean square.
    fn correlation(way: [f64; 3], time: f64) -> f64 {
        let product = |(t, x)| dot(at(&GUST, t, x), at(&GUST, t + time, add(x, way)));
        samples().map(product).sum::<f64>() / 40_000.0 / (GUST.speed * GUST.speed)
    }

    #[test]
    fn gusts_are_alike_nearby_and_strangers_two_lengths_or_periods_away() {
        let one = [GUST.length, 0.0, 0.0];
        assert!(correlation(scale(one, 0.1), 0.0) > 0.95);
        assert!(
            (correlation(scale(one, 0.5), 0.0) - 0.684).abs() < 0.02,
            "{}",
            correlation(scale(one, 0.5), 0.0)
        );
        assert!((correlation(one, 0.0) - 0.214).abs() < 0.02, "{}", correlation(one, 0.0));
        assert!((correlation([0.0; 3], GUST.period) - 0.214).abs() < 0.02);
        for way in [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, -1.0]] {
            assert!(correlation(scale(way, 2.0 * GUST.length), 0.0).abs() < 0.02);
        }
        assert!(correlation([0.0; 3], 2.0 * GUST.period).abs() < 0.02);
    }

    #[test]
    fn other_seeds_are_other_gusts() {
        let product = |(t, x)| dot(at(&GUST, t, x), at(&Gust { seed: 8, ..GUST }, t, x));
        assert!((samples().map(product).sum::<f64>() / 40_000.0).abs() < 0.02 * GUST.speed * GUST.speed);
    }

    #[test]
    fn the_field_has_no_jumps_and_no_kinks_across_lattice_points_and_times() {
        for (t, x) in
            [(2.0, [0.3, 0.2, 0.1]), (0.3, [0.5, 0.2, 0.1]), (0.3, [0.3, -1.0, 0.1]), (0.3, [0.3, 0.2, 0.0])]
        {
            let step = 1e-5;
            let along = |s: f64| at(&GUST, t + s, add(x, [s; 3]));
            let (before, now, after) = (along(-step), along(0.0), along(step));
            let slope = scale(sub(after, before), 0.5 / step);
            assert!(norm(sub(after, now)) < 100.0 * step, "a jump at {x:?}");
            // The slopes on both sides differ by no more than curvature makes.
            let kink = sub(scale(sub(after, now), 1.0 / step), scale(sub(now, before), 1.0 / step));
            assert!(norm(kink) < 0.02 && norm(slope) < 100.0, "{kink:?} at {x:?}");
        }
    }

    #[test]
    fn gusts_drift_with_the_air() {
        let (wind, x) = ([3.0, -2.0, 0.7], [0.13, 0.21, -0.37]);
        for t in [0.0, 0.31, 12.3, 1e4] {
            let drifting = GustNow::new(&GUST, wind, t).velocity(add(x, scale(wind, t)));
            let still = at(&GUST, t, x);
            assert!(norm(sub(drifting, still)) < 1e-7, "{t}: {drifting:?} and {still:?}");
        }
    }

    #[test]
    fn thirty_two_bits_follow_sixty_four_and_nothing_far_away_is_no_number() {
        let (fine, coarse) =
            (GustNow::<f64>::new(&GUST, [1.0; 3], 3.3), GustNow::<f32>::new(&GUST, [1.0; 3], 3.3));
        for (_, x) in samples().take(1000).map(|(t, x)| (t, x.map(|c| c % 20.0))) {
            let v = coarse.velocity(x.map(|c| c as f32)).map(f64::from);
            assert!(norm(sub(v, fine.velocity(x))) < 2e-3 * GUST.speed, "{x:?}");
        }
        for far in [1e9, -3e20, 1e38, f32::INFINITY, f32::NEG_INFINITY] {
            let v = coarse.velocity([far, -far, 1.0]);
            assert!(v.iter().all(|c| c.abs() <= 4.0 * GUST.speed as f32), "{v:?} at {far}");
        }
    }
}
