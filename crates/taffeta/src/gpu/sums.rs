//! Adds up in 64 bits what the workgroups have summed.

use crate::diagnostics::{FrameSums, SolverReport};
use crate::gpu::layout::NODE_SUMS;
use crate::gpu::segment::Segment;
use crate::solvers::dual::gpu_layout::Taken;
use taffeta_gpu::{Gpu, GpuError};

/// A sum; the largest number where 32 bits were too few for it. Whether the state is finite is counted apart.
fn capped(sum: f32) -> f64 {
    f64::from(if sum.is_finite() { sum } else { f32::MAX })
}

/// Adds what a segment has measured; waits for it.
pub fn add(gpu: &Gpu, segment: &Segment, sums: &mut FrameSums) -> Result<(), GpuError> {
    let (read, all) = (&segment.sums, &mut sums.all);
    let mut numbers = Vec::new();
    read.read_nodes.take(gpu, &mut numbers)?;
    for row in numbers.chunks_exact(NODE_SUMS) {
        let row: [f64; NODE_SUMS] = std::array::from_fn(|i| capped(row[i]));
        all.m_v2 += if row[11] > 0.0 { f64::NAN } else { row[0] };
        for axis in 0..3 {
            all.m_x[axis] += row[1 + axis];
            all.momentum[axis] += row[4 + axis];
            all.angular_momentum[axis] += row[7 + axis];
        }
        all.contacts += row[10] as u64;
    }
    let mut pairs = Vec::new();
    for springs in [&read.read_grid_springs, &read.read_mesh_springs] {
        springs.take(gpu, &mut pairs)?;
        for [energy, stretch] in pairs.iter().map(|pair| pair.map(capped)) {
            all.springs += energy;
            all.max_stretch = if stretch > all.max_stretch { stretch } else { all.max_stretch };
        }
    }
    read.read_hinges.take(gpu, &mut numbers)?;
    sums.hinges += numbers.iter().map(|&energy| capped(energy)).sum::<f64>();
    read.read_volumes.take(gpu, &mut numbers)?;
    for (&volume, &body) in numbers.iter().zip(&segment.tables.chunk_bodies) {
        *sums.volumes[body].get_or_insert(0.0) += f64::from(volume);
    }
    let mut contacts = Vec::new();
    read.read_pairs.take(gpu, &mut contacts)?;
    // Both nodes of a pair count it.
    sums.pairs.pairs += contacts.iter().map(|&[count, _]| u64::from(count)).sum::<u64>() / 2;
    let nearest = contacts.iter().map(|&[_, share]| f64::from(f32::from_bits(share)).sqrt());
    sums.pairs.nearest = nearest.fold(sums.pairs.nearest, f64::min);
    if let Some(constrained) = &segment.constrained {
        add_taken(&constrained.taken(gpu)?, &mut sums.solver);
    }
    if let Some(attaching) = &segment.attaching {
        sums.broken += attaching.broken(gpu)?;
    }
    if let Some(primal) = &segment.primal {
        add_taken(&primal.taken(gpu)?, &mut sums.solver);
    }
    Ok(())
}

/// What another segment's solver has taken. Where there are several, sub-steps are counted and shares compared by segment.
fn add_taken(taken: &Taken, report: &mut SolverReport) {
    report.iterations = report.iterations.max(taken.iterations);
    report.residual = report.residual.max(f64::from(taken.residual).sqrt());
    report.active_fraction = report.active_fraction.max(f64::from(taken.active_share));
    report.capped = report.capped.max(taken.capped);
}
