//! An implicit step whose unknowns are the nodes' velocities, solved with multigrid.

pub mod coarsening;
#[cfg(feature = "gpu")]
pub mod contacts_parity;
#[cfg(feature = "gpu")]
mod contacts_twin;
pub mod couplings;
#[cfg(feature = "gpu")]
mod couplings_coarser;
#[cfg(feature = "gpu")]
mod couplings_twin;
pub mod cpu;
#[cfg(feature = "gpu")]
mod cycle_twin;
#[cfg(feature = "gpu")]
pub mod gpu;
#[cfg(feature = "gpu")]
pub mod gpu_layout;
#[cfg(feature = "gpu")]
mod gpu_sewn;
#[cfg(feature = "gpu")]
pub mod gpu_tables;
pub mod implicit;
pub mod levels;
#[cfg(feature = "gpu")]
mod newton_twin;
#[cfg(feature = "gpu")]
pub mod parity;
#[cfg(feature = "gpu")]
mod parity_work;
pub mod scheme;
pub mod sewn;
#[cfg(feature = "gpu")]
pub mod sewn_parity;
pub mod slots;
#[cfg(feature = "gpu")]
pub mod twin;
