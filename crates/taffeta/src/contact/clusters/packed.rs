//! The positions of a cluster's nodes, and how far they move.

use crate::real::{Real, dot, sub};
use crate::topology::LANES;

/// Number of clusters in a group. They are consecutive, and belong to one worker.
pub const GROUP: usize = LANES;

/// Positions of the nodes of a cluster [m], by axis. Lanes without a node hold a NaN.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub struct Packed<T>(pub [[T; LANES]; 3]);

/// The least and the greatest of sixteen numbers; by halves, for vectors.
#[inline(always)]
pub fn range<T: Real>(x: &[T; LANES]) -> [T; 2] {
    let (mut least, mut most) = (*x, *x);
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            least[lane] = if least[lane + half] < least[lane] { least[lane + half] } else { least[lane] };
            most[lane] = if most[lane + half] > most[lane] { most[lane + half] } else { most[lane] };
        }
        half /= 2;
    }
    [least[0], most[0]]
}

/// Motion of the first `len` lanes, and the greatest distance from it [m]. A NaN is infinitely far away.
#[inline(always)]
pub fn motion<T: Real>(now: &[[T; LANES]; 3], then: &[[T; LANES]; 3], len: usize) -> [f64; 4] {
    let mut way = [[T::ZERO; LANES]; 3];
    for axis in 0..3 {
        for lane in 0..LANES {
            way[axis][lane] = now[axis][lane] - then[axis][lane];
        }
        for lane in len..LANES {
            way[axis][lane] = way[axis][0];
        }
    }
    let mut by = [T::ZERO; 3];
    for axis in 0..3 {
        // The middle of their box: all are about as near to it as can be.
        let [low, high] = range(&way[axis]);
        by[axis] = (low + high) * T::from_f64(0.5);
    }
    let mut far = [T::ZERO; LANES];
    let mut lost = false;
    for lane in 0..LANES {
        let off = sub([way[0][lane], way[1][lane], way[2][lane]], by);
        far[lane] = dot(off, off);
        let is_known = far[lane] < T::FAR;
        lost |= !is_known;
    }
    let by = by.map(T::to_f64);
    if lost {
        return [0.0, 0.0, 0.0, f64::INFINITY];
    }
    let mut half = LANES / 2;
    while half > 0 {
        for lane in 0..half {
            far[lane] = if far[lane] > far[lane + half] { far[lane] } else { far[lane + half] };
        }
        half /= 2;
    }
    // With a margin for rounding.
    let radius = far[0].sqrt().to_f64() * 1.0001 + (by[0].abs() + by[1].abs() + by[2].abs()) * 1e-6;
    [by[0], by[1], by[2], radius]
}

/// A ball around balls, centred between some bounds.
#[inline(always)]
pub fn about(balls: &[[f64; 4]], least: [f64; 3], most: [f64; 3]) -> [f64; 4] {
    let [x, y, z] = [0, 1, 2].map(|axis| (least[axis] + most[axis]) * 0.5);
    let mut radius = 0.0;
    for ball in balls {
        let off = sub([ball[0], ball[1], ball[2]], [x, y, z]);
        let far = dot(off, off).sqrt() + ball[3];
        // A NaN remains.
        radius = if far <= radius { radius } else { far };
    }
    if radius < f64::INFINITY { [x, y, z, radius] } else { [0.0, 0.0, 0.0, f64::INFINITY] }
}
