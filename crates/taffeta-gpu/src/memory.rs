//! Allocation of buffers: refused before the driver is asked where they are too large, and counted.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use crate::gpu::told;
use crate::{Gpu, GpuError};

/// A buffer of the device, counted as long as it is alive.
pub(crate) struct Allocation {
    pub buffer: wgpu::Buffer,
    bytes: u64,
    used: Arc<AtomicU64>,
}

impl Drop for Allocation {
    fn drop(&mut self) {
        self.used.fetch_sub(self.bytes, Ordering::Relaxed);
    }
}

impl Gpu {
    /// A zeroed buffer of `bytes` bytes, of which there may be `limit`.
    pub(crate) fn allocate(
        &self,
        (what, label): (&'static str, &str),
        bytes: u64,
        limit: u64,
        usage: wgpu::BufferUsages,
    ) -> Result<Allocation, GpuError> {
        self.health()?;
        if bytes > limit {
            return Err(GpuError::TooLarge { what, label: label.to_owned(), bytes, limit });
        }
        let descriptor =
            wgpu::BufferDescriptor { label: Some(label), size: bytes, usage, mapped_at_creation: false };
        let (buffer, error) = self.scoped(|| self.device().create_buffer(&descriptor));
        match error {
            // A device that is lost tells only its callback.
            None => self.health()?,
            Some(wgpu::Error::OutOfMemory { .. }) => {
                return Err(GpuError::OutOfMemory { label: label.to_owned(), bytes });
            }
            Some(other) => return Err(told(&other)),
        }
        let used = self.memory().clone();
        used.fetch_add(bytes, Ordering::Relaxed);
        Ok(Allocation { buffer, bytes, used })
    }
}
