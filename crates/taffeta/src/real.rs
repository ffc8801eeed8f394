//! The two number types of the CPU backend: f32 is the fast path, f64 the oracle.

use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// Nodes of a slice of [`Gather`](crate::topology::Gather): one vector of 512 bits in f32.
pub const LANES: usize = 16;

/// A floating-point number that kernels are written for.
///
/// Only operations whose result is the same at every SIMD level are offered: no fused multiply-add, no
/// approximate reciprocal or root.
pub trait Real:
    Copy
    + Default
    + PartialOrd
    + Send
    + Sync
    + std::fmt::Debug
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
    + 'static
{
    /// 0.
    const ZERO: Self;
    /// 1.
    const ONE: Self;
    /// Smallest squared length that is divided by [m²]: keeps 1/l finite as l → 0.
    const TINY: Self;
    /// Distance from 1 to the next number.
    const EPSILON: Self;
    /// A length beyond all scenes [m].
    const FAR: Self;
    /// Relative error of a volume that is restored by moving nodes.
    const PROJECTED: Self;
    /// Correctly rounded square root.
    fn sqrt(self) -> Self;
    /// Angle of (x, y), from software so that every machine gives the same bits.
    fn atan2(self, x: Self) -> Self;
    /// Nearest value.
    fn from_f64(value: f64) -> Self;
    /// Exact.
    fn to_f64(self) -> f64;
    /// Nearest value in 32 bits.
    fn to_f32(self) -> f32;
    /// Little-endian bytes, handed to `sink`.
    fn bytes(self, sink: &mut Vec<u8>);

    /// The whole number next to it towards zero, as far as 32 bits reach.
    fn whole(self) -> i32;
    /// Nearest value.
    fn from_whole(value: i32) -> Self;

    /// The larger of the two; of a number and none, the number.
    fn max(self, other: Self) -> Self;
    /// Whether it is a number, and not infinite.
    fn is_finite(self) -> bool;

    /// Absolute value.
    #[inline(always)]
    fn abs(self) -> Self {
        if self < Self::ZERO { -self } else { self }
    }
}

impl Real for f32 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const TINY: Self = 1e-30;
    const EPSILON: Self = f32::EPSILON;
    const FAR: Self = 1e30;
    const PROJECTED: Self = 1e-6;
    #[inline(always)]
    fn sqrt(self) -> Self {
        f32::sqrt(self)
    }
    #[inline(always)]
    fn atan2(self, x: Self) -> Self {
        angle(self, x)
    }
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value as f32
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        f64::from(self)
    }
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self
    }
    #[inline(always)]
    fn whole(self) -> i32 {
        let inside = if self < 1e9 { self } else { 1e9 };
        let inside = if inside > -1e9 { inside } else { -1e9 };
        // SAFETY: inside of what 32 bits reach, and a number: a comparison with what is none takes the other branch.
        unsafe { inside.to_int_unchecked() }
    }
    #[inline(always)]
    fn from_whole(value: i32) -> Self {
        value as Self
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::max(self, other)
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }
    fn bytes(self, sink: &mut Vec<u8>) {
        sink.extend_from_slice(&self.to_le_bytes());
    }
}

impl Real for f64 {
    const ZERO: Self = 0.0;
    const ONE: Self = 1.0;
    const TINY: Self = 1e-200;
    const EPSILON: Self = f64::EPSILON;
    const FAR: Self = 1e200;
    const PROJECTED: Self = 1e-10;
    #[inline(always)]
    fn sqrt(self) -> Self {
        f64::sqrt(self)
    }
    fn atan2(self, x: Self) -> Self {
        libm::atan2(self, x)
    }
    #[inline(always)]
    fn from_f64(value: f64) -> Self {
        value
    }
    #[inline(always)]
    fn to_f64(self) -> f64 {
        self
    }
    #[inline(always)]
    fn to_f32(self) -> f32 {
        self as f32
    }
    #[inline(always)]
    fn whole(self) -> i32 {
        let inside = if self < 1e9 { self } else { 1e9 };
        let inside = if inside > -1e9 { inside } else { -1e9 };
        // SAFETY: inside of what 32 bits reach, and a number: a comparison with what is none takes the other branch.
        unsafe { inside.to_int_unchecked() }
    }
    #[inline(always)]
    fn from_whole(value: i32) -> Self {
        value as Self
    }
    #[inline(always)]
    fn max(self, other: Self) -> Self {
        Self::max(self, other)
    }
    #[inline(always)]
    fn is_finite(self) -> bool {
        Self::is_finite(self)
    }
    fn bytes(self, sink: &mut Vec<u8>) {
        sink.extend_from_slice(&self.to_le_bytes());
    }
}

/// Angle of (x, y) in 32 bits, within 3 units in the last place, by operations that are exactly rounded everywhere:
/// the twin of `gpu/wgsl/angle.wgsl`.
///
/// With t in [0, tan π/8] after two reductions, atan t = t + t³ P(t²), P of degree 3 with the least largest relative
/// error (2·10⁻⁸; exchange method, Remez 1934).
#[inline(always)]
fn angle(y: f32, x: f32) -> f32 {
    use std::f32::consts::{FRAC_PI_2, FRAC_PI_4, PI};
    const TAN_EIGHTH: f32 = 0.414_213_57;
    let (across, up) = (Real::abs(x), Real::abs(y));
    let (small, large) = if up > across { (across, up) } else { (up, across) };
    let steep = small > TAN_EIGHTH * large;
    let (num, den) = if steep { (small - large, small + large) } else { (small, large) };
    let t = num / if den == 0.0 { 1.0 } else { den };
    let z = t * t;
    let series = ((0.080_537_125 * z - 0.138_776_75) * z + 0.199_777_1) * z - 0.333_329_5;
    let angle = t + t * z * series;
    let angle = if steep { angle + FRAC_PI_4 } else { angle };
    let angle = if up > across { FRAC_PI_2 - angle } else { angle };
    let angle = if x < 0.0 { PI - angle } else { angle };
    if y < 0.0 { -angle } else { angle }
}

/// Length of (x, y), which are neither huge nor tiny, by operations that are exactly rounded everywhere: what systems have differs in
/// the last bit. The root is corrected by what is left of its square, as Borges does (An improved algorithm for hypot(a, b), 2019).
pub fn hypot(x: f64, y: f64) -> f64 {
    let (x, y) = (x.abs(), y.abs());
    let (long, short) = if x < y { (y, x) } else { (x, y) };
    if short <= long * (0.25 * f64::EPSILON) {
        return long + short;
    }
    let root = (long * long + short * short).sqrt();
    let (a, b) = if root <= 2.0 * short {
        let over = root - short;
        (long * (2.0 * over - long), (over - 2.0 * (long - short)) * over)
    } else {
        let over = root - long;
        (2.0 * over * (long - 2.0 * short), (4.0 * over - short) * short + over * over)
    };
    root - (a + b) / (2.0 * root)
}

/// The difference of two angles, by the shorter way round.
#[inline(always)]
pub fn wrap<T: Real>(angle: T) -> T {
    let (pi, turn) = (T::from_f64(std::f64::consts::PI), T::from_f64(std::f64::consts::TAU));
    let less = if angle > pi { angle - turn } else { angle };
    if angle < -pi { angle + turn } else { less }
}

/// Scalar product.
#[inline(always)]
pub fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Difference a − b.
#[inline(always)]
pub fn sub<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

/// Sum.
#[inline(always)]
pub fn add<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

/// Multiple.
#[inline(always)]
pub fn scale<T: Real>(a: [T; 3], s: T) -> [T; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// Vector product.
#[inline(always)]
pub fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// A symmetric matrix: xx, yy, zz, xy, xz, yz.
pub type Symmetric<T> = [T; 6];

/// A matrix times a vector.
#[inline(always)]
pub fn times<T: Real>(m: &Symmetric<T>, v: [T; 3]) -> [T; 3] {
    [
        m[0] * v[0] + m[3] * v[1] + m[4] * v[2],
        m[3] * v[0] + m[1] * v[1] + m[5] * v[2],
        m[4] * v[0] + m[5] * v[1] + m[2] * v[2],
    ]
}

/// Eigenvalues of a symmetric matrix, and the unit vector of each, by Jacobi's rotations.
pub fn eigen(mut x: [[f64; 3]; 3]) -> ([f64; 3], [[f64; 3]; 3]) {
    let mut vectors = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    for (p, q) in [(0, 1), (0, 2), (1, 2)].repeat(8) {
        if x[p][q] == 0.0 {
            continue;
        }
        let ratio = (x[q][q] - x[p][p]) / (2.0 * x[p][q]);
        let tangent = ratio.signum() / (ratio.abs() + (ratio * ratio + 1.0).sqrt());
        let cosine = 1.0 / (tangent * tangent + 1.0).sqrt();
        let turn = |[a, b]: [f64; 2]| [cosine * a - cosine * tangent * b, cosine * tangent * a + cosine * b];
        for row in &mut x {
            [row[p], row[q]] = turn([row[p], row[q]]);
        }
        for k in 0..3 {
            [x[p][k], x[q][k]] = turn([x[p][k], x[q][k]]);
            [vectors[p][k], vectors[q][k]] = turn([vectors[p][k], vectors[q][k]]);
        }
    }
    ([0, 1, 2].map(|k| x[k][k]), vectors)
}

/// Area between three corners [m²].
pub fn area<T: Real>([a, b, c]: [[T; 3]; 3]) -> T {
    T::from_f64(0.5) * norm(cross(sub(b, a), sub(c, a)))
}

/// Length.
#[inline(always)]
pub fn norm<T: Real>(a: [T; 3]) -> T {
    dot(a, a).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lengths_have_the_bits_that_they_always_had() {
        assert_eq!(
            [hypot(3.0, 4.0), hypot(-5.0, 0.0), hypot(0.0, 0.0), hypot(1e-20, 1.0)],
            [5.0, 5.0, 0.0, 1.0]
        );
        // Where the root of the sum of squares is another number.
        let bits = [(0.4, 0.1), (0.5, 0.2), (1.1, 0.4)].map(|(x, y): (f64, f64)| {
            assert_eq!(hypot(x, y), hypot(y, -x));
            hypot(x, y).to_bits()
        });
        assert_eq!(bits, [0x3fda_634b_d77f_e1a5, 0x3fe1_3b86_ea20_ae5c, 0x3ff2_ba3e_bdc9_a7e7]);
    }

    #[test]
    fn angles_in_32_bits_are_within_three_units_of_the_last_place() {
        let sizes = [1e-20_f32, 1e-6, 0.1, 0.414_213, 0.414_214, 0.7, 1.0, 1.3, 2.414_2, 2.414_3, 50.0, 1e12];
        for (i, &a) in sizes.iter().enumerate() {
            for &b in &sizes[i..] {
                for (y, x) in [(a, b), (-a, b), (a, -b), (-a, -b), (b, a), (-b, a), (b, -a), (-b, -a)] {
                    let exact = f64::from(y).atan2(f64::from(x));
                    let unit = f64::from((exact as f32).abs()) * f64::from(f32::EPSILON);
                    assert!((f64::from(angle(y, x)) - exact).abs() <= 3.0 * unit, "{y} {x}");
                }
            }
        }
        assert_eq!(
            [angle(0.0, 0.0), angle(0.0, 1.0), angle(1.0, 0.0)],
            [0.0, 0.0, std::f32::consts::FRAC_PI_2]
        );
        assert!(angle(f32::NAN, 1.0).is_nan() && angle(1.0, f32::NAN).is_nan());
    }
}
