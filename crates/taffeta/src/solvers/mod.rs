//! Solvers: from forces to the next state.

pub mod constraints;
pub mod dual;
pub mod explicit;
pub mod implicit;
#[cfg(feature = "gpu")]
pub mod iterations;
pub mod waiting;
pub mod xpbd;
