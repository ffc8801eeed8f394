//! Typed buffers that kernels read and write, and uniform records with the parameters of a dispatch.

use std::marker::PhantomData;
use std::num::NonZeroU64;

use bytemuck::Pod;
use wgpu::BufferUsages;

use crate::memory::Allocation;
use crate::{DispatchList, Gpu, GpuError};

/// Uploads go through staging memory of this size [bytes], whatever the size of the data.
const PIECE: usize = 32 << 20;

/// What a kernel can be bound to by name.
///
/// ```no_run
/// # use taffeta_gpu::{Bindable, Buffer, Choice, DispatchList, Gpu, wgpu};
/// /// The elements of a buffer from number 64 on: 256 bytes, a multiple of every device's alignment.
/// struct Rest<'a>(&'a Buffer<f32>);
///
/// impl Bindable for Rest<'_> {
///     fn buffer(&self) -> &wgpu::Buffer {
///         self.0.raw()
///     }
///     fn offset(&self) -> u64 {
///         256
///     }
/// }
/// # let source = "
/// #     @group(2) @binding(0) var<storage, read_write> values: array<f32>;
/// #     @compute @workgroup_size(64) fn twice(@builtin(global_invocation_id) id: vec3u) {
/// #         if id.x < arrayLength(&values) { values[id.x] *= 2.0; }
/// #     }";
/// # let gpu = Gpu::open(&Choice::from_env())?;
/// # let kernel = gpu.kernel("twice", &[source], "twice", &[])?;
///
/// let values = gpu.buffer_from("values", &[1.0_f32; 100])?;
/// let twice = kernel.bind(&gpu, &[("values", &Rest(&values))]);
/// let mut list = DispatchList::new();
/// list.dispatch(&twice, &[], 1);
/// gpu.submit(&list)?;
/// assert_eq!(values.read(&gpu)?[63..65], [1.0, 2.0]);
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
pub trait Bindable: Send + Sync {
    /// The buffer.
    fn buffer(&self) -> &wgpu::Buffer;

    /// From where on a kernel sees it [bytes]: a multiple of the device's alignment.
    fn offset(&self) -> u64 {
        0
    }

    /// How much of it a kernel sees [bytes]; all of it from there on where this is `None`.
    fn window(&self) -> Option<NonZeroU64> {
        None
    }
}

/// `len` elements of `T` on the GPU, in storage that kernels read and write.
///
/// ```no_run
/// use taffeta_gpu::{Choice, Gpu};
///
/// let gpu = Gpu::open(&Choice::from_env())?;
/// let heights = gpu.buffer::<f32>("heights", 4)?;
/// heights.write(&gpu, 1, &[0.5, 0.75]);
/// assert_eq!(heights.read(&gpu)?, [0.0, 0.5, 0.75, 0.0]);
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
pub struct Buffer<T> {
    memory: Allocation,
    len: usize,
    elements: PhantomData<fn() -> T>,
}

/// Records of `T` in uniform memory, of which a dispatch is told one by its offset.
///
/// ```no_run
/// use taffeta_gpu::{Choice, DispatchList, Gpu};
///
/// let source = "
///     @group(0) @binding(0) var<uniform> step: vec4f;
///     @group(2) @binding(0) var<storage, read_write> height: array<f32>;
///     @compute @workgroup_size(1) fn rise() { height[0] += step.x; }";
/// let gpu = Gpu::open(&Choice::from_env())?;
/// let steps = gpu.uniforms::<[f32; 4]>("steps", 2)?;
/// steps.write(&gpu, &[[0.25, 0.0, 0.0, 0.0], [2.0, 0.0, 0.0, 0.0]]);
/// let height = gpu.buffer::<f32>("height", 1)?;
/// let rise = gpu.kernel("rise", &[source], "rise", &[])?;
/// let rise = rise.bind(&gpu, &[("step", &steps), ("height", &height)]);
/// let mut list = DispatchList::new();
/// list.dispatch(&rise, &[steps.offset(0)], 1);
/// list.dispatch(&rise, &[steps.offset(1)], 1);
/// gpu.submit(&list)?;
/// assert_eq!(height.read(&gpu)?, [2.25]);
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
pub struct Uniforms<T> {
    memory: Allocation,
    len: usize,
    stride: usize,
    records: PhantomData<fn() -> T>,
}

/// Numbers of workgroups along x, y and z, which a kernel writes and
/// [`DispatchList::dispatch_counted`] reads.
///
/// ```no_run
/// use taffeta_gpu::{Choice, DispatchList, Gpu};
///
/// let source = "
///     @group(2) @binding(0) var<storage, read_write> counts: array<u32>;
///     @group(2) @binding(1) var<storage, read_write> sum: atomic<u32>;
///     @compute @workgroup_size(1) fn count() { counts[0] = 5; counts[1] = 1; counts[2] = 1; }
///     @compute @workgroup_size(1) fn work() { atomicAdd(&sum, 1u); }";
/// let gpu = Gpu::open(&Choice::from_env())?;
/// let (counts, sum) = (gpu.counts("counts", 1)?, gpu.buffer::<u32>("sum", 1)?);
/// let count = gpu.kernel("count", &[source], "count", &[])?.bind(&gpu, &[("counts", &counts)]);
/// let work = gpu.kernel("work", &[source], "work", &[])?.bind(&gpu, &[("sum", &sum)]);
/// let mut list = DispatchList::new();
/// list.dispatch(&count, &[], 1);
/// list.dispatch_counted(&work, &[], &counts, 0);
/// gpu.submit(&list)?;
/// assert_eq!(sum.read(&gpu)?, [5]);
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
pub struct Counts(Buffer<[u32; 3]>);

impl Gpu {
    /// Room for `count` zeroed numbers of workgroups, which kernels see as three words each.
    ///
    /// # Errors
    /// Those of [`Gpu::buffer`].
    pub fn counts(&self, label: &str, count: usize) -> Result<Counts, GpuError> {
        Ok(Counts(self.storage(label, count, BufferUsages::INDIRECT)?))
    }

    /// `count` zeroed elements. Where `count` is 0 there is memory for one, because a kernel cannot
    /// be bound to nothing.
    ///
    /// # Errors
    /// [`GpuError::TooLarge`] before memory is asked for, [`GpuError::OutOfMemory`], or what
    /// [`Gpu::health`] says.
    pub fn buffer<T: Pod>(&self, label: &str, count: usize) -> Result<Buffer<T>, GpuError> {
        self.storage(label, count, BufferUsages::empty())
    }

    fn storage<T: Pod>(&self, label: &str, count: usize, more: BufferUsages) -> Result<Buffer<T>, GpuError> {
        let usage = BufferUsages::STORAGE | BufferUsages::COPY_SRC | BufferUsages::COPY_DST | more;
        let memory = self.allocate(("buffer", label), bytes_of::<T>(count), self.largest_binding(), usage)?;
        Ok(Buffer { memory, len: count, elements: PhantomData })
    }

    /// A buffer that holds `data`, uploaded in pieces without a second copy of the whole.
    ///
    /// # Errors
    /// Those of [`Gpu::buffer`].
    pub fn buffer_from<T: Pod>(&self, label: &str, data: &[T]) -> Result<Buffer<T>, GpuError> {
        let buffer = self.buffer(label, data.len())?;
        buffer.write(self, 0, data);
        self.health()?;
        Ok(buffer)
    }

    /// `count` zeroed records, each where a dispatch's offset can point at it.
    ///
    /// # Errors
    /// Those of [`Gpu::buffer`].
    pub fn uniforms<T: Pod>(&self, label: &str, count: usize) -> Result<Uniforms<T>, GpuError> {
        let stride =
            size_of::<T>().next_multiple_of(self.limits().min_uniform_buffer_offset_alignment as usize);
        let (record, most) = (size_of::<T>() as u64, self.limits().max_uniform_buffer_binding_size);
        if record > most {
            return Err(GpuError::TooLarge {
                what: "uniform record",
                label: label.into(),
                bytes: record,
                limit: most,
            });
        }
        let bytes = (stride as u64).saturating_mul(count.max(1) as u64);
        // Offsets are numbers of 32 bits.
        let limit = self.limits().max_buffer_size.min(u32::MAX.into());
        let usage = BufferUsages::UNIFORM | BufferUsages::COPY_DST;
        let memory = self.allocate(("uniform buffer", label), bytes, limit, usage)?;
        Ok(Uniforms { memory, len: count, stride, records: PhantomData })
    }
}

impl<T: Pod> Buffer<T> {
    /// Puts `data` in place of the elements from `first` on, before all that is submitted later.
    ///
    /// # Panics
    /// Where `data` reaches past the end: a mistake of the caller.
    pub fn write(&self, gpu: &Gpu, first: usize, data: &[T]) {
        let end = first.checked_add(data.len());
        assert!(end.is_some_and(|end| end <= self.len), "a write past the end of a buffer of {}", self.len);
        let mut at = (first * size_of::<T>()) as u64;
        let mut pieces = bytemuck::cast_slice(data).chunks(PIECE).peekable();
        while let Some(piece) = pieces.next() {
            gpu.watched(|| gpu.queue().write_buffer(&self.memory.buffer, at, piece));
            at += piece.len() as u64;
            if pieces.peek().is_some() {
                // Frees the staging memory of this piece before the next takes some.
                gpu.watched(|| gpu.queue().submit([]));
                gpu.poll(wgpu::PollType::wait_indefinitely());
            }
        }
    }

    /// Waits for all that was submitted, and returns the elements.
    ///
    /// # Errors
    /// [`GpuError::OutOfMemory`] or what [`Gpu::health`] says.
    pub fn read(&self, gpu: &Gpu) -> Result<Vec<T>, GpuError> {
        let staging = gpu.read_back("read", self.len)?;
        let mut list = DispatchList::new();
        list.copy(self, &staging);
        gpu.submit(&list)?;
        let mut elements = Vec::new();
        staging.take(gpu, &mut elements)?;
        Ok(elements)
    }
}

impl<T> Buffer<T> {
    /// The number of elements.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The memory that it takes [bytes].
    pub fn bytes(&self) -> u64 {
        self.memory.buffer.size()
    }

    /// The buffer behind it.
    pub fn raw(&self) -> &wgpu::Buffer {
        &self.memory.buffer
    }
}

impl Counts {
    pub(crate) fn len(&self) -> usize {
        self.0.len()
    }

    pub(crate) fn raw(&self) -> &wgpu::Buffer {
        self.0.raw()
    }
}

impl Bindable for Counts {
    fn buffer(&self) -> &wgpu::Buffer {
        self.0.buffer()
    }
}

impl<T: Pod> Uniforms<T> {
    /// Puts `data` in place of the first records, before all that is submitted later.
    ///
    /// # Panics
    /// Where `data` has more records than there are: a mistake of the caller.
    pub fn write(&self, gpu: &Gpu, data: &[T]) {
        assert!(data.len() <= self.len, "{} records for a buffer of {}", data.len(), self.len);
        let mut padded = vec![0; data.len() * self.stride];
        for (slot, record) in padded.chunks_exact_mut(self.stride).zip(data) {
            slot[..size_of::<T>()].copy_from_slice(bytemuck::bytes_of(record));
        }
        if !padded.is_empty() {
            gpu.watched(|| gpu.queue().write_buffer(&self.memory.buffer, 0, &padded));
        }
    }
}

impl<T> Uniforms<T> {
    /// The number of records.
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no records.
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// The offset that tells a dispatch record `index` [bytes].
    ///
    /// # Panics
    /// Where there is no such record: a mistake of the caller.
    pub fn offset(&self, index: usize) -> u32 {
        assert!(index < self.len, "record {index} of {}", self.len);
        (index * self.stride) as u32
    }
}

impl<T> Bindable for Buffer<T> {
    fn buffer(&self) -> &wgpu::Buffer {
        &self.memory.buffer
    }
}

impl<T> Bindable for Uniforms<T> {
    fn buffer(&self) -> &wgpu::Buffer {
        &self.memory.buffer
    }

    fn window(&self) -> Option<NonZeroU64> {
        NonZeroU64::new(size_of::<T>() as u64)
    }
}

/// The size of `count` elements, of one at least [bytes].
pub(crate) fn bytes_of<T>(count: usize) -> u64 {
    const { assert!(size_of::<T>() > 0 && size_of::<T>().is_multiple_of(4), "GPUs copy whole words of 4 bytes") }
    (size_of::<T>() as u64).saturating_mul(count.max(1) as u64)
}
