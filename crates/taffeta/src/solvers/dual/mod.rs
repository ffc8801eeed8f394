//! The dual solver: springs are constraints, and their forces are the unknowns (ICE, ACAD).

pub mod cpu;
pub mod distance;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
#[cfg(feature = "gpu")]
pub mod gpu_tables;
#[cfg(feature = "gpu")]
pub mod parity;
#[cfg(feature = "paper-forms")]
pub mod printed;
#[cfg(feature = "gpu")]
pub mod twin;
