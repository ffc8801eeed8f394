//! How fast a GPU copies memory: what no sub-step can beat.

use serde::Serialize;
use std::time::Instant;
use taffeta::taffeta_gpu::{Buffer, DispatchList, Gpu, GpuError};

/// Size of each of the two buffers [byte], beyond the caches of large GPUs, and where time is short.
const BYTES: [u64; 2] = [512 << 20, 16 << 20];
/// Less is not tried [byte].
const LEAST: u64 = 4 << 20;
/// Time that a try takes, about [s], and the most copies in it.
const TRY: (f64, f64) = (0.05, 256.0);
/// Tries; the best counts.
const TRIES: usize = 5;
/// Invocations of a workgroup.
const GROUP: u32 = 256;

type Numbers = Buffer<[f32; 4]>;

/// Bytes read and written a second [GB/s].
#[derive(Clone, Copy, Serialize)]
pub struct Copied {
    /// By a kernel, four numbers an invocation.
    pub kernel_gb_per_s: f64,
    /// By the driver's own copies between buffers.
    pub buffer_gb_per_s: f64,
    /// Size of what was copied [byte].
    pub bytes: u64,
}

impl Copied {
    /// Measures both ways to copy.
    pub fn measure(gpu: &Gpu, small: bool) -> Result<Self, GpuError> {
        let (from, to) = buffers(gpu, BYTES[usize::from(small)].min(gpu.largest_binding()))?;
        let kernel = gpu.kernel("copy", &[include_str!("copy.wgsl")], "copy", &[])?;
        let bound = kernel.bind(gpu, &[("copied_from", &from), ("copied_to", &to)]);
        let groups = (from.len() as u32).div_ceil(GROUP);
        Ok(Self {
            kernel_gb_per_s: rate(gpu, from.bytes(), |list| list.dispatch(&bound, &[], groups))?,
            buffer_gb_per_s: rate(gpu, from.bytes(), |list| list.copy_buffer(&from, &to))?,
            bytes: from.bytes(),
        })
    }

    /// The better of both: what the shares of other measurements are of.
    pub fn best(&self) -> f64 {
        self.kernel_gb_per_s.max(self.buffer_gb_per_s)
    }
}

/// Two buffers, as large as there is room for.
fn buffers(gpu: &Gpu, mut bytes: u64) -> Result<(Numbers, Numbers), GpuError> {
    loop {
        let count = (bytes / 16) as usize;
        let both = || Ok((gpu.buffer("copied from", count)?, gpu.buffer("copied to", count)?));
        match both() {
            Err(GpuError::OutOfMemory { .. }) if bytes > LEAST => bytes /= 2,
            result => return result,
        }
    }
}

/// Bytes read and written a second [GB/s] where `copy` copies `bytes`.
fn rate(gpu: &Gpu, bytes: u64, copy: impl Fn(&mut DispatchList)) -> Result<f64, GpuError> {
    let copies = |count: f64| {
        let mut list = DispatchList::new();
        (0..count as usize).for_each(|_| copy(&mut list));
        list
    };
    // The first takes the memory.
    time(gpu, &copies(1.0))?;
    let count = (TRY.0 / time(gpu, &copies(1.0))?).clamp(1.0, TRY.1).floor();
    let list = copies(count);
    let mut best = f64::INFINITY;
    for _ in 0..TRIES {
        best = best.min(time(gpu, &list)?);
    }
    Ok(2.0 * count * bytes as f64 / best * 1e-9)
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
    fn both_ways_to_copy_have_a_speed() {
        let gpu = crate::gpu::open().unwrap();
        let copied = super::Copied::measure(&gpu, true).unwrap();
        let speeds = [copied.kernel_gb_per_s, copied.buffer_gb_per_s];
        assert!(speeds.iter().all(|speed| speed.is_finite() && *speed > 1e-3), "{speeds:?}");
    }
}
