//! The backend on the CPU: memory and scheduling. Formulas are in the stages' own folders.

pub mod attendance;
pub mod backend;
pub mod balance;
#[cfg(feature = "gpu")]
pub mod between;
pub mod cells;
pub mod clock;
pub mod column;
pub mod feature;
pub mod lanes;
pub mod numbers;
pub mod places;
pub mod resting;
#[cfg(feature = "gpu")]
pub mod separate;
pub mod shared;
pub mod simd;
pub mod states;
pub mod sums;
pub mod team;
pub mod tile;
pub mod tiles;
pub mod worker;

#[cfg(test)]
mod order_tests;

pub use backend::CpuBackend;
pub use simd::SimdLevel;
