//! Every kernel beside its twin on the CPU: one state, both run, every output compared.
//!
//! The tests go through these rows on a software adapter, and the program does on its users' machines.

pub(crate) mod bench;
#[cfg(test)]
pub(crate) mod coverage;
pub(crate) mod drawn;
pub(crate) mod fixture;
pub(crate) mod formulas;
mod outcome;
pub(crate) mod row;
mod rows;
pub(crate) mod scene;

pub use outcome::{Difference, Outcome};
pub use row::{Row, Tolerance};
pub use rows::{entry_points, rows};
