//! What is run, and what each run leaves.

pub mod behaviour;
pub mod job;
pub mod programs;
pub mod scenes;
pub mod strip;
pub mod turns;
