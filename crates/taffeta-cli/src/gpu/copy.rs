//! How fast a GPU copies: the limit of what moves through its memory.

use std::time::Instant;
use taffeta::taffeta_gpu::{Buffer, DispatchList, Gpu, GpuError};

/// Size of each of the two buffers [byte], beyond the caches of large GPUs, and that below which none is tried.
const BYTES: (u64, u64) = (256 << 20, 4 << 20);
/// Time that a try takes, about [s].
const TRY: f64 = 0.03;
/// Most copies a try.
const COPIES: u32 = 256;
/// Tries; the best counts.
const TRIES: usize = 3;

/// Bytes read and written a second by copies from one large buffer to another.
pub fn bandwidth(gpu: &Gpu) -> Result<f64, GpuError> {
    let (from, to) = buffers(gpu)?;
    let copies = |count: u32| {
        let mut list = DispatchList::new();
        (0..count).for_each(|_| list.copy_buffer(&from, &to));
        list
    };
    let one = copies(1);
    // The first one takes memory and warms up.
    time(gpu, &one)?;
    let count = ((TRY / time(gpu, &one)?) as u32).clamp(1, COPIES);
    let several = copies(count);
    let mut best = f64::INFINITY;
    for _ in 0..TRIES {
        best = best.min(time(gpu, &several)?);
    }
    Ok(2.0 * f64::from(count) * from.bytes() as f64 / best)
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
        let bandwidth = super::bandwidth(&gpu).unwrap();
        assert!(bandwidth.is_finite() && bandwidth > 1e6, "{bandwidth}");
    }
}
