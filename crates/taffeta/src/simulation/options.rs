//! How to run a scene, apart from what it is.

#[cfg(feature = "gpu")]
use crate::gpu::GpuOptions;
use serde::{Deserialize, Serialize};

/// Arithmetic of a run.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Precision {
    /// 32 bits: the fast path.
    #[default]
    F32,
    /// 64 bits: the oracle.
    F64,
}

/// How to run a scene, apart from what it is. More may come: write `..Options::default()`.
///
/// ```
/// use taffeta::{Options, Precision};
///
/// let reference = Options { precision: Precision::F64, threads: Some(1), ..Options::default() };
/// # let _ = reference;
/// ```
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Worker threads; `None`: all that the machine has, but one for every 4,096 nodes at most, for less work than
    /// that is done before the workers have met.
    pub threads: Option<usize>,
    /// Arithmetic; a GPU computes in [`Precision::F32`] alone.
    pub precision: Precision,
    /// The GPU to run on; `None`: the CPU.
    #[cfg(feature = "gpu")]
    pub gpu: Option<GpuOptions>,
}
