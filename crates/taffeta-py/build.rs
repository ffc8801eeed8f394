//! A module for Python leaves Python's own symbols open; macOS must be told.

fn main() {
    pyo3_build_config::add_extension_module_link_args();
}
