//! The device: opened by choice or borrowed, its limits, its health.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use crate::cache::Cache;
use crate::{AdapterInfo, Choice, GpuError, adapter};

/// A GPU that is open. Cheap to clone: the clones are one device.
///
/// ```no_run
/// use taffeta_gpu::{Choice, Gpu};
///
/// let gpu = Gpu::open(&Choice::from_env())?;
/// println!("{}: a kernel sees up to {} bytes of a buffer", gpu.info(), gpu.largest_binding());
/// let places = gpu.buffer::<[f32; 4]>("places", 1000)?;
/// assert_eq!(gpu.memory_used(), places.bytes());
/// gpu.health()?;
/// # Ok::<(), taffeta_gpu::GpuError>(())
/// ```
#[derive(Clone)]
pub struct Gpu(Arc<Inner>);

struct Inner {
    device: wgpu::Device,
    queue: wgpu::Queue,
    info: AdapterInfo,
    limits: wgpu::Limits,
    memory: Arc<AtomicU64>,
    reads: Arc<AtomicU64>,
    fault: Fault,
    cache: Mutex<Cache>,
}

/// The first thing that went wrong.
#[derive(Clone, Default)]
struct Fault(Arc<Mutex<Option<GpuError>>>);

impl Fault {
    /// Keeps `error` where it is the first, and returns the first.
    fn set(&self, error: GpuError) -> GpuError {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(error).clone()
    }

    fn get(&self) -> Option<GpuError> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "Gpu({})", self.info())
    }
}

impl Gpu {
    /// Opens the chosen adapter with all the limits that it has, and timestamps where it has them.
    ///
    /// # Errors
    /// [`GpuError::NoAdapter`], [`GpuError::NoSuchAdapter`], or [`GpuError::Failed`] where the driver
    /// does not open the device.
    pub fn open(choice: &Choice) -> Result<Gpu, GpuError> {
        let (_, adapter) = adapter::choose(choice)?;
        let descriptor = wgpu::DeviceDescriptor {
            label: Some("taffeta"),
            required_features: adapter.features() & wgpu::Features::TIMESTAMP_QUERY,
            required_limits: adapter.limits(),
            ..Default::default()
        };
        let (device, queue) = pollster::block_on(adapter.request_device(&descriptor))
            .map_err(|error| GpuError::Failed { why: error.to_string() })?;
        let gpu = Gpu::on(device, queue, adapter.get_info());
        let fault = gpu.0.fault.clone();
        gpu.0.device.on_uncaptured_error(Arc::new(move |error| drop(fault.set(told(&error)))));
        let fault = gpu.0.fault.clone();
        gpu.0.device.set_device_lost_callback(move |reason, why| drop(fault.set(lost(reason, &why))));
        Ok(gpu)
    }

    /// A device that somebody else opened. Its error handlers stay as they are, so its loss is not reported: it is seen
    /// when the next command fails, as [`GpuError::Lost`] or [`GpuError::Failed`].
    pub fn on(device: wgpu::Device, queue: wgpu::Queue, info: wgpu::AdapterInfo) -> Gpu {
        let limits = device.limits();
        let (info, memory, reads, fault) = ((&info).into(), Arc::default(), Arc::default(), Fault::default());
        let cache = Mutex::default();
        Gpu(Arc::new(Inner { device, queue, info, limits, memory, reads, fault, cache }))
    }

    /// Which adapter this is.
    pub fn info(&self) -> &AdapterInfo {
        &self.0.info
    }

    /// What the device allows.
    pub fn limits(&self) -> &wgpu::Limits {
        &self.0.limits
    }

    /// The size of the largest storage buffer that a kernel can see [bytes].
    pub fn largest_binding(&self) -> u64 {
        self.0.limits.max_storage_buffer_binding_size.min(self.0.limits.max_buffer_size)
    }

    /// Whether [`Gpu::submit_timed`] can time stages.
    pub fn has_timestamps(&self) -> bool {
        self.0.device.features().contains(wgpu::Features::TIMESTAMP_QUERY)
    }

    /// Whether all is well so far. What went wrong once stays: results after it mean nothing.
    ///
    /// # Errors
    /// The first of: [`GpuError::Lost`], and [`GpuError::Failed`] for a command that the device
    /// refused or had no memory for. What a call that makes something returned as its own error
    /// ([`GpuError::TooLarge`], [`GpuError::OutOfMemory`], [`GpuError::Shader`]) is not among them.
    pub fn health(&self) -> Result<(), GpuError> {
        self.0.fault.get().map_or(Ok(()), Err)
    }

    /// Destroys the device, as a driver's reset would: for tests of what follows.
    pub fn lose(&self) {
        self.0.device.destroy();
        self.fell("it was given up");
    }

    /// The device behind it.
    pub fn device(&self) -> &wgpu::Device {
        &self.0.device
    }

    /// The queue behind it.
    pub fn queue(&self) -> &wgpu::Queue {
        &self.0.queue
    }

    /// The size of the buffers alive that were made here [bytes].
    pub fn memory_used(&self) -> u64 {
        self.0.memory.load(Ordering::Relaxed)
    }

    /// How many times memory was mapped for the host to read, so far.
    pub fn reads(&self) -> u64 {
        self.0.reads.load(Ordering::Relaxed)
    }

    pub(crate) fn read_count(&self) -> &Arc<AtomicU64> {
        &self.0.reads
    }

    /// Waits until all that was submitted is done.
    ///
    /// # Errors
    /// What [`Gpu::health`] says then.
    pub fn wait(&self) -> Result<(), GpuError> {
        self.health()?;
        while !self.poll(wgpu::PollType::wait_indefinitely()) {
            self.health()?;
        }
        self.health()
    }

    /// Lets callbacks run. False where what it waits for took too long, and may yet come.
    pub(crate) fn poll(&self, how: wgpu::PollType) -> bool {
        // wgpu panics where a driver reports its loss while it is polled. A driver that is reset is
        // no broken invariant of ours; no lock is held and nothing is left half done by then.
        match catch_unwind(AssertUnwindSafe(|| self.0.device.poll(how))) {
            Ok(Ok(_)) => return true,
            Ok(Err(wgpu::PollError::Timeout)) => return false,
            Ok(Err(error)) => drop(self.0.fault.set(GpuError::Failed { why: error.to_string() })),
            Err(_) => drop(self.fell("the driver gave it up")),
        }
        true
    }

    /// Keeps for [`Gpu::health`] that the device is lost, and returns what is known of it.
    pub(crate) fn fell(&self, why: &str) -> GpuError {
        self.0.fault.set(GpuError::Lost { why: why.to_owned() })
    }

    /// What was compiled here. Hold it no longer than to look something up: compiling takes long.
    pub(crate) fn cache(&self) -> MutexGuard<'_, Cache> {
        self.0.cache.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn memory(&self) -> &Arc<AtomicU64> {
        &self.0.memory
    }

    /// Runs `work` and returns what went wrong in it.
    pub(crate) fn scoped<R>(&self, work: impl FnOnce() -> R) -> (R, Option<wgpu::Error>) {
        use wgpu::ErrorFilter::{Internal, OutOfMemory, Validation};
        let device = &self.0.device;
        let scopes = [OutOfMemory, Internal, Validation].map(|filter| device.push_error_scope(filter));
        let result = work();
        // Scopes are a stack: the last is popped first.
        let errors = scopes.into_iter().rev().map(|scope| pollster::block_on(scope.pop()));
        (result, errors.fold(None, Option::or))
    }

    /// Runs `work` and keeps what went wrong in it for [`Gpu::health`].
    pub(crate) fn watched<R>(&self, work: impl FnOnce() -> R) -> R {
        let (result, error) = self.scoped(work);
        if let Some(error) = error {
            self.0.fault.set(told(&error));
        }
        result
    }
}

/// What wgpu says of a command.
pub(crate) fn told(error: &wgpu::Error) -> GpuError {
    let why = match error {
        wgpu::Error::OutOfMemory { .. } => "it has no memory left for it".to_owned(),
        other => other.to_string(),
    };
    GpuError::Failed { why }
}

fn lost(reason: wgpu::DeviceLostReason, why: &str) -> GpuError {
    let why = if why.is_empty() { format!("{reason:?}").to_lowercase() } else { why.to_owned() };
    GpuError::Lost { why }
}
