//! Forces on single nodes: wind, drag, point loads, torques.

pub mod build;
pub mod cpu;
pub mod load;
