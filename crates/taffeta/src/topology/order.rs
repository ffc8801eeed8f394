//! Order in memory: nodes that are near in space are near in memory, so that a gather finds its neighbours in
//! the cache.

use crate::topology::measure::bounds;

/// Bits of an axis; three of them fill a 63-bit key.
const BITS: u32 = 21;

/// Order of nodes along a Hilbert curve through their bounding cube at rest: entry `new` is the old index. Nodes
/// in one cell keep their order.
///
/// ```
/// use taffeta::topology::order::locality_order;
///
/// // Corners of a cube: each is next to the one before it.
/// let corners: Vec<[f64; 3]> = (0..8).map(|i| [i & 1, i >> 1 & 1, i >> 2].map(f64::from)).collect();
/// let order = locality_order(&corners);
/// let step = |a: u32, b: u32| (0..3).map(|i| (corners[a as usize][i] - corners[b as usize][i]).abs()).sum::<f64>();
/// assert!(order.windows(2).all(|two| step(two[0], two[1]) == 1.0));
/// ```
pub fn locality_order(nodes: &[[f64; 3]]) -> Vec<u32> {
    let [lo, hi] = bounds(nodes);
    let extent = (0..3).map(|i| hi[i] - lo[i]).fold(0.0, f64::max);
    let last = f64::from((1u32 << BITS) - 1);
    let scale = if extent > 0.0 { last / extent } else { 0.0 };
    let mut keyed: Vec<(u64, u32)> = nodes
        .iter()
        .zip(0..)
        .map(|(p, index)| (hilbert([0, 1, 2].map(|i| ((p[i] - lo[i]) * scale) as u32)), index))
        .collect();
    keyed.sort_unstable();
    keyed.into_iter().map(|(_, index)| index).collect()
}

/// Place along the Hilbert curve of a cell, by Skilling, "Programming the Hilbert curve", AIP Conf. Proc. 707
/// (2004), `AxestoTranspose`; the transposed bits are then interleaved, first axis first.
fn hilbert(mut x: [u32; 3]) -> u64 {
    let mut q = 1 << (BITS - 1);
    while q > 1 {
        let low = q - 1;
        for i in 0..3 {
            if x[i] & q != 0 {
                x[0] ^= low;
            } else {
                let swap = (x[0] ^ x[i]) & low;
                x[0] ^= swap;
                x[i] ^= swap;
            }
        }
        q >>= 1;
    }
    x[1] ^= x[0];
    x[2] ^= x[1];
    let mut flip = 0;
    for bit in (1..BITS).rev() {
        if x[2] >> bit & 1 == 1 {
            flip ^= (1 << bit) - 1;
        }
    }
    let x = x.map(|v| v ^ flip);
    (0..BITS).rev().fold(0, |key, bit| x.iter().fold(key, |key, v| key << 1 | u64::from(v >> bit & 1)))
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The 8³ cells of a cube, so scaled that each is a cell of the coarsest three levels.
    fn cells() -> Vec<[f64; 3]> {
        (0..512).map(|i| [i / 64, i / 8 % 8, i % 8].map(f64::from)).collect()
    }

    #[test]
    fn the_curve_visits_every_cell_once_and_steps_to_a_face_neighbour() {
        let nodes = cells();
        let order = locality_order(&nodes);
        let mut sorted = order.clone();
        sorted.sort_unstable();
        assert_eq!(sorted, (0..512).collect::<Vec<u32>>());
        for step in order.windows(2) {
            let [a, b] = [nodes[step[0] as usize], nodes[step[1] as usize]];
            let distance: f64 = (0..3).map(|i| (a[i] - b[i]).abs()).sum();
            assert_eq!(distance, 1.0, "{a:?} to {b:?}");
        }
    }

    #[test]
    fn nodes_in_one_place_keep_their_order() {
        assert_eq!(locality_order(&[[1.0, 2.0, 3.0]; 5]), [0, 1, 2, 3, 4]);
        assert!(locality_order(&[]).is_empty());
    }
}
