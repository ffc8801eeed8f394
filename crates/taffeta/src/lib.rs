//! The engine: a scene in, positions out. No window, no clock, no file system.

pub mod diagnostics;
pub mod scene;
mod simulation;
pub mod topology;

pub use simulation::{BodyInfo, Diverged, Options, Precision, Simulation};
