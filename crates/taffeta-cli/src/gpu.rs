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
    adapter
        .is_software()
        .then(|| format!("{} is a software adapter: it proves results, never speed", adapter.name))
}

/// Keeps Vulkan's device selection from complaining on a machine without a desktop: it looks for one in the folder that
/// this variable names. There is nothing at this path, and nobody else can put something there.
///
/// To be called first of all: no other thread may be running.
#[cfg(target_os = "linux")]
pub fn expect_no_desktop() {
    let name = "XDG_RUNTIME_DIR";
    if std::env::var_os(name).is_none_or(|value| value.is_empty()) {
        // SAFETY: the only thread of the process does this before it starts others.
        unsafe { std::env::set_var(name, "/nonexistent") };
    }
}

/// Nothing complains elsewhere.
#[cfg(not(target_os = "linux"))]
pub fn expect_no_desktop() {}
