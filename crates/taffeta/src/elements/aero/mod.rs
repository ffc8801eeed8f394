//! Aerodynamic forces on triangles, and gusts.

pub mod aero;
pub mod build;
pub mod cpu;
pub mod gust;
