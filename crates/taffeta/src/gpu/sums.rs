//! Sums that workgroups share.

use crate::gpu::layout::GROUP;

/// Workgroups that share a sum over all nodes, springs or hinges: enough to fill a large GPU.
const SUM_GROUPS: usize = 1024;

/// Workgroups for a sum over `count` things.
pub fn sum_groups(count: usize) -> usize {
    count.div_ceil(GROUP).min(SUM_GROUPS)
}

/// A sum; the largest number where 32 bits were too few for it. Whether the state is finite is counted apart.
pub fn capped(sum: f32) -> f64 {
    f64::from(if sum.is_finite() { sum } else { f32::MAX })
}
