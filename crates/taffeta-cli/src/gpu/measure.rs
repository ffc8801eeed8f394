//! What a GPU can do at most.

use crate::run::GpuCost;
use std::time::Instant;
use taffeta::taffeta_gpu::{Buffer, DispatchList, Gpu, GpuError};

/// Size of each of the two buffers [byte], beyond the caches of large GPUs, and that below which none is tried.
const BYTES: (u64, u64) = (256 << 20, 4 << 20);
/// Time that a try takes, about [s].
const TRY: f64 = 0.03;
/// Most copies a try.
const COPIES: f64 = 256.0;
/// Tries; the best counts.
const TRIES: usize = 3;
/// Dispatches by which the time of one is measured.
const DISPATCHES: u32 = 1000;
/// Bytes that a sub-step reads and writes for each node: position and velocity, four numbers each, in and out.
pub const NODE_BYTES: f64 = 64.0;
/// A kernel that does next to nothing; dispatches of it wait for each other, as sub-steps do.
const LITTLE: &str = "
    @group(2) @binding(0) var<storage, read_write> values: array<u32>;
    @compute @workgroup_size(64) fn little(@builtin(global_invocation_id) id: vec3u) { values[id.x] += 1u; }";

/// Bytes read and written a second by copies from one large buffer to another.
pub fn copy_bandwidth(gpu: &Gpu) -> Result<f64, GpuError> {
    let (from, to) = buffers(gpu)?;
    let copies = |count: f64| {
        let mut list = DispatchList::new();
        (0..count as usize).for_each(|_| list.copy_buffer(&from, &to));
        list
    };
    // The first one takes memory and warms up.
    time(gpu, &copies(1.0))?;
    let count = (TRY / time(gpu, &copies(1.0))?).clamp(1.0, COPIES).floor();
    let list = copies(count);
    let mut best = f64::INFINITY;
    for _ in 0..TRIES {
        best = best.min(time(gpu, &list)?);
    }
    Ok(2.0 * count * from.bytes() as f64 / best)
}

/// Two buffers, as large as there is room for.
fn buffers(gpu: &Gpu) -> Result<(Buffer<u32>, Buffer<u32>), GpuError> {
    let mut bytes = BYTES.0.min(gpu.largest_binding());
    loop {
        let count = (bytes / 4) as usize;
        let both = || Ok((gpu.buffer("copy from", count)?, gpu.buffer("copy to", count)?));
        match both() {
            Err(GpuError::OutOfMemory { .. }) if bytes > BYTES.1 => bytes /= 2,
            result => return result,
        }
    }
}

/// What a sub-step costs, at the speed at which memory is copied.
pub fn cost(gpu: &Gpu) -> Result<GpuCost, GpuError> {
    let values: Buffer<u32> = gpu.buffer("little", 64)?;
    let little = gpu.kernel("little", &[LITTLE], "little", &[])?.bind(gpu, &[("values", &values)]);
    let mut list = DispatchList::new();
    (0..DISPATCHES).for_each(|_| list.dispatch(&little, &[], 1));
    time(gpu, &list)?;
    let seconds_per_substep = time(gpu, &list)? / f64::from(DISPATCHES);
    Ok(GpuCost { seconds_per_substep, seconds_per_node: NODE_BYTES / copy_bandwidth(gpu)? })
}

/// Time until a list is done [s].
fn time(gpu: &Gpu, list: &DispatchList) -> Result<f64, GpuError> {
    let start = Instant::now();
    gpu.submit(list)?;
    gpu.wait()?;
    Ok(start.elapsed().as_secs_f64())
}

#[cfg(test)]
mod tests {
    #[test]
    fn a_gpu_s_speed_is_positive_and_finite() {
        let gpu = crate::gpu::open().unwrap();
        let bandwidth = super::copy_bandwidth(&gpu).unwrap();
        assert!(bandwidth.is_finite() && bandwidth > 1e6, "{bandwidth}");
        let cost = super::cost(&gpu).unwrap();
        assert!(cost.seconds_per_substep > 0.0 && cost.seconds_per_substep < 1.0, "{cost:?}");
        assert!(cost.seconds_per_node > 0.0 && cost.seconds_per_node < 1e-3, "{cost:?}");
    }
}
