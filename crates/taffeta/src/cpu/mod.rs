//! The backend on the CPU: memory and scheduling. Formulas are in the stages' own folders.

#[cfg(feature = "gpu")]
pub mod apart;
pub mod backend;
pub mod balance;
pub mod clock;
pub mod column;
pub mod feature;
pub mod shared;
pub mod simd;
pub mod sums;
pub mod team;
pub mod tile;
pub mod tiles;
pub mod worker;

#[cfg(test)]
mod order_tests;

#[cfg(all(test, feature = "gpu"))]
pub use crate::contact::colliders::cpu::{GRAIN, GROOVES, ROUNDS};
pub use backend::CpuBackend;
pub use simd::SimdLevel;
