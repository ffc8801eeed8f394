//! The GPU of a run: which one, and how fast it is.

mod copy;

pub use copy::Copied;

use taffeta::taffeta_gpu::{AdapterInfo, Choice, Gpu, GpuError};

/// Opens the adapter that `TAFFETA_ADAPTER` asks for, else the best hardware, else a software adapter.
pub fn open() -> Result<Gpu, GpuError> {
    Gpu::open(&Choice::from_env())
}

/// What the user of a software adapter should know.
pub fn software_note(adapter: &AdapterInfo) -> Option<String> {
    adapter.is_software().then(|| {
        format!(
            "{} is a software adapter: its results are valid, its timings say nothing of hardware",
            adapter.name
        )
    })
}
