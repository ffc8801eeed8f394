//! The backend on the CPU: memory and scheduling. Formulas are in the stages' own folders.

mod air;
mod attach;
mod backend;
mod balance;
mod column;
mod contact;
mod diagnose;
mod grid;
mod mesh;
mod near;
mod pairs;
mod primal;
mod rings;
mod shared;
mod simd;
mod solve;
mod sums;
mod team;
mod tile;
mod tiles;
mod timed;
mod volume;
mod volume_tile;
mod worker;

pub use backend::CpuBackend;
#[cfg(feature = "gpu")]
pub use backend::{Between, KeptParts};
#[cfg(all(test, feature = "gpu"))]
pub use contact::{GRAIN, GROOVES, ROUNDS};
pub use simd::SimdLevel;
