//! What the host reads: copies of buffers in memory that it can map, without waiting for them.

use std::marker::PhantomData;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use bytemuck::Pod;

use crate::buffer::bytes_of;
use crate::memory::Allocation;
use crate::{Gpu, GpuError};

/// `len` elements of `T` on their way to the host.
///
/// Recorded with [`DispatchList::copy`](crate::DispatchList::copy), submitted, then
/// [`start`](ReadBack::start)ed and [`take`](ReadBack::take)n. Between start and take nothing may be
/// copied to it.
///
/// ```no_run
/// use taffeta_gpu::{Choice, DispatchList, Gpu};
///
/// let gpu = Gpu::open(&Choice::from_env())?;
/// let values = gpu.buffer_from("values", &[1.0_f32, 2.0])?;
/// let staging = gpu.read_back("values", values.len())?;
/// let mut list = DispatchList::new();
/// list.copy(&values, &staging);
/// gpu.submit(&list)?;
/// staging.start();
/// while !staging.ready(&gpu) {
///     // Something else may be done here.
/// }
/// let mut read = Vec::new();
/// staging.take(&gpu, &mut read)?;
/// assert_eq!(read, [1.0, 2.0]);
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
pub struct ReadBack<T> {
    memory: Allocation,
    len: usize,
    state: Arc<Mutex<State>>,
    /// Counts mappings of all of the device's.
    reads: Arc<AtomicU64>,
    elements: PhantomData<fn() -> T>,
}

#[derive(Clone, Copy, PartialEq)]
enum State {
    Idle,
    Pending,
    Mapped,
    Failed,
}

impl Gpu {
    /// Room for `count` elements on their way to the host.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`], [`GpuError::OutOfMemory`], or what [`Gpu::health`] says.
    pub fn read_back<T: Pod>(&self, label: &str, count: usize) -> Result<ReadBack<T>, GpuError> {
        let usage = wgpu::BufferUsages::MAP_READ | wgpu::BufferUsages::COPY_DST;
        let limit = self.limits().max_buffer_size;
        let memory = self.allocate(("read-back", label), bytes_of::<T>(count), limit, usage)?;
        let state = Arc::new(Mutex::new(State::Idle));
        let reads = self.read_count().clone();
        Ok(ReadBack { memory, len: count, state, reads, elements: PhantomData })
    }
}

impl<T> ReadBack<T> {
    /// The number of elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    pub(crate) fn raw(&self) -> &wgpu::Buffer {
        &self.memory.buffer
    }

    fn state(&self) -> State {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn set(&self, state: State) {
        *self.state.lock().unwrap_or_else(PoisonError::into_inner) = state;
    }

    /// Asks for the elements after a submission that copies to it. Nothing happens where they were
    /// already asked for.
    pub fn start(&self) {
        if self.state() != State::Idle {
            return;
        }
        self.set(State::Pending);
        self.reads.fetch_add(1, Ordering::Relaxed);
        let state = self.state.clone();
        self.memory.buffer.map_async(wgpu::MapMode::Read, .., move |result| {
            let reached = if result.is_ok() { State::Mapped } else { State::Failed };
            *state.lock().unwrap_or_else(PoisonError::into_inner) = reached;
        });
    }

    /// Whether [`take`](ReadBack::take) would not wait. Does not wait itself.
    pub fn ready(&self, gpu: &Gpu) -> bool {
        if self.state() == State::Pending {
            gpu.poll(wgpu::PollType::Poll);
        }
        matches!(self.state(), State::Mapped | State::Failed)
    }
}

impl<T: Pod> ReadBack<T> {
    /// Waits for the elements, and puts them in place of what `sink` holds.
    ///
    /// # Errors
    /// What [`Gpu::health`] says, and [`GpuError::Lost`] where the copy never arrived. `sink` is then
    /// as it was.
    pub fn take(&self, gpu: &Gpu, sink: &mut Vec<T>) -> Result<(), GpuError> {
        self.start();
        while self.state() == State::Pending && gpu.health().is_ok() {
            gpu.poll(wgpu::PollType::wait_indefinitely());
        }
        // Memory of a lost device cannot be looked at, even where it was mapped before.
        gpu.health()?;
        if self.state() == State::Failed {
            return Err(gpu.fell("a read-back never arrived"));
        }
        sink.clear();
        let bytes = self.memory.buffer.get_mapped_range(..);
        sink.extend_from_slice(&bytemuck::cast_slice(&bytes)[..self.len]);
        drop(bytes);
        self.memory.buffer.unmap();
        self.set(State::Idle);
        Ok(())
    }
}
