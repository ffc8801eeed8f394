//! The native part of the Python package `taffeta`: it converts and calls, and computes nothing itself.
//!
//! The package is in `python/taffeta`; docs/python.md is its guide. Arrays become numpy's, dicts become scenes by way of TOML, and
//! every error becomes an exception of `taffeta._errors`. While frames run, Python's other threads do.

mod arrays;
mod control;
mod document;
mod errors;
mod info;
mod mesh;
mod options;
mod read;
mod report;
mod running;
mod scene;
mod simulation;
mod worlds;

/// `taffeta._native`.
#[pyo3::pymodule]
mod _native {
    use pyo3::prelude::*;

    #[pymodule_export]
    use crate::info::{Body, Collider, info, materials};
    #[pymodule_export]
    use crate::scene::{check, check_mesh, format_toml, format_value, parse_toml, read_text};
    #[pymodule_export]
    use crate::simulation::Simulation;
    #[pymodule_export]
    use crate::worlds::Worlds;

    #[pymodule_init]
    fn init(module: &Bound<'_, PyModule>) -> PyResult<()> {
        module.add("__version__", env!("CARGO_PKG_VERSION"))
    }
}
