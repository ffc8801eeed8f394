//! Which vector instructions gather fastest, found by a short trial.

use crate::cpu::column::Column;
use crate::cpu::simd::SimdLevel;
use crate::elements::spring::cpu_mesh::GatheredSprings;
use crate::real::Real;
use crate::topology::{Gather, LANES};
use std::sync::OnceLock;
use std::time::{Duration, Instant};

/// Nodes of the trial, and springs at each: as many as a tile has.
const NODES: usize = 512;
const SPRINGS: usize = 6;

/// Turns of each level, some microseconds each. The least time counts, as what else the machine does only adds to it.
const TURNS: usize = 30;

/// The level to use for kernels that gather, where `level` is what the machine has.
///
/// A kernel for AVX-512 has vector gathers, one for AVX2 loads number by number. On some processors the former take two
/// thirds of the time, on others they are the slower ones, and no list of processors says so. The results are the same.
pub fn level_for_gathers(level: SimdLevel) -> SimdLevel {
    static FASTER: OnceLock<SimdLevel> = OnceLock::new();
    if level < SimdLevel::Avx512 { level } else { *FASTER.get_or_init(|| faster(level)) }
}

/// The faster one of AVX2 and the `level` above it, in 32 bits, for springs: it stands for other kernels, and for 64 bits.
fn faster(level: SimdLevel) -> SimdLevel {
    let springs = springs::<f32>(NODES);
    let columns: [Column<f32>; 6] = std::array::from_fn(|axis| {
        let mut column = Column::zeros(NODES);
        for (node, number) in column.iter_mut().enumerate() {
            *number = ((node * (2 * axis + 3)) % 61) as f32;
        }
        column
    });
    let old = columns.each_ref().map(|column| &**column);
    let mut force = std::array::from_fn(|_| Column::zeros(NODES));
    let mut least = [(SimdLevel::Avx2, Duration::MAX), (level, Duration::MAX)];
    for _ in 0..TURNS {
        for (level, least) in &mut least {
            let start = Instant::now();
            springs.springs(*level, 0..NODES / LANES, old, &mut force, None);
            *least = start.elapsed().min(*least);
        }
    }
    // Read, so that the work is not left out.
    std::hint::black_box(&force);
    // Twice the vector width helps other parts of such kernels, so it needs no lead.
    let [(_, narrow), (_, wide)] = least;
    if narrow < wide * 9 / 10 { SimdLevel::Avx2 } else { level }
}

/// Springs between nodes that are near each other by number, as those of a mesh in its solver's order.
fn springs<T: Real>(nodes: usize) -> GatheredSprings<T> {
    let slices = nodes / LANES;
    let neighbour = (0..slices * SPRINGS * LANES).map(|entry| {
        let (slice, spring, lane) = (entry / (SPRINGS * LANES), entry / LANES % SPRINGS, entry % LANES);
        ((slice * LANES + lane + [1, 3, 17, nodes - 1, nodes - 5, nodes - 23][spring]) % nodes) as u32
    });
    let gather = Gather {
        slice_starts: (0..=slices).map(|slice| (slice * SPRINGS * LANES) as u32).collect(),
        neighbour: neighbour.collect(),
        rest: vec![1.0; slices * SPRINGS * LANES],
    };
    GatheredSprings::new((1.0, 0.1), gather, nodes)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elements::spring::spring;

    /// Few nodes, and so many that what they read is fetched ahead.
    fn are_as_one_by_one<T: Real>() {
        for nodes in [NODES, 1 << 16] {
            let springs = springs::<T>(nodes);
            let columns: [Column<T>; 6] = std::array::from_fn(|axis| {
                let mut column = Column::zeros(nodes);
                let number = |node: usize| T::from_f64(((node * (2 * axis + 3)) % 61) as f64 / 7.0);
                column.iter_mut().enumerate().for_each(|(node, x)| *x = number(node));
                column
            });
            let old = columns.each_ref().map(|column| &**column);
            // The last slices: prefetching must not go beyond the table.
            let (last, own) = (nodes / LANES - 2..nodes / LANES, nodes - 2 * LANES);
            let alone: Vec<[T; 3]> = (own..nodes)
                .map(|node| {
                    let mut sum = [T::ZERO; 3];
                    for (neighbours, _) in springs.slice(node / LANES) {
                        let other = neighbours[node % LANES] as usize;
                        let [d, dv] =
                            [0, 3].map(|from| [0, 1, 2].map(|i| old[from + i][other] - old[from + i][node]));
                        let factor = spring::factor(d, dv, springs.k, springs.damping, T::ONE);
                        sum = [0, 1, 2].map(|axis| sum[axis] + factor * d[axis]);
                    }
                    sum
                })
                .collect();
            let mut force = std::array::from_fn(|_| Column::zeros(2 * LANES));
            springs.springs(SimdLevel::Base, last, old, &mut force, None);
            let found = |at: usize| [0, 1, 2].map(|axis| force[axis][at].to_f64().to_bits());
            for (at, sum) in alone.iter().enumerate() {
                assert_eq!(found(at), sum.map(|x| x.to_f64().to_bits()), "{nodes} {at}");
            }
        }
    }

    #[test]
    fn springs_of_sixteen_nodes_are_those_one_by_one() {
        are_as_one_by_one::<f32>();
        are_as_one_by_one::<f64>();
    }
}
