//! What can go wrong on a GPU, in words that say what would do.

/// Why the GPU did not do what was asked.
///
/// ```no_run
/// use taffeta_gpu::{Choice, Gpu, GpuError};
///
/// let gpu = match Gpu::open(&Choice::Best) {
///     Err(GpuError::NoAdapter { .. }) => Gpu::open(&Choice::BestOrSoftware)?,
///     other => other?,
/// };
/// let error = gpu.buffer::<f32>("too much", usize::MAX / 8).err();
/// assert!(matches!(error, Some(GpuError::TooLarge { limit, .. }) if limit == gpu.largest_binding()));
/// # Ok::<(), GpuError>(())
/// ```
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum GpuError {
    /// There is no adapter at all, or none of the kind that was asked for.
    #[error("no GPU was found{hint}")]
    NoAdapter {
        /// What was found instead, or what to install, as the end of the sentence.
        hint: String,
    },
    /// The name or number that was asked for fits no adapter.
    #[error("TAFFETA_ADAPTER=`{wanted}` fits no adapter; there {there}")]
    NoSuchAdapter {
        /// What was asked for.
        wanted: String,
        /// The adapters there are, numbered, as the end of the sentence `there …`.
        there: String,
    },
    /// A buffer is larger than what a kernel can see of one, or than the device allows.
    #[error("{what} `{label}` would take {bytes} bytes, and this GPU allows {limit}")]
    TooLarge {
        /// The sort of buffer.
        what: &'static str,
        /// The buffer's label.
        label: String,
        /// Its size [bytes].
        bytes: u64,
        /// The largest size that would do [bytes].
        limit: u64,
    },
    /// The GPU has no memory left for a buffer.
    #[error("the GPU has no memory left for `{label}` of {bytes} bytes")]
    OutOfMemory {
        /// The buffer's label, or what was done.
        label: String,
        /// Its size [bytes].
        bytes: u64,
    },
    /// A dispatch has more workgroups than two dimensions hold.
    #[error("kernel `{label}` was given {groups} workgroups, and this GPU allows {limit}")]
    TooManyGroups {
        /// The kernel's label.
        label: String,
        /// The number of workgroups asked for.
        groups: u32,
        /// The largest number that would do.
        limit: u64,
    },
    /// The device is gone: it was reset, removed or given up.
    #[error("the GPU was lost: {why}")]
    Lost {
        /// What the driver said.
        why: String,
    },
    /// A kernel's source is wrong or cannot be compiled.
    #[error("kernel `{label}`: {why}")]
    Shader {
        /// The kernel's label.
        label: String,
        /// What the compiler said, with the lines it speaks of.
        why: String,
    },
    /// The device refused a command.
    #[error("the GPU refused a command: {why}")]
    Failed {
        /// What the driver said.
        why: String,
    },
    /// The device cannot time what it does.
    #[error("this GPU has no timestamps, so its stages cannot be timed")]
    NoTimestamps,
}
