//! A module for Python leaves Python's own symbols open; macOS needs a flag for that.

fn main() {
    // Files of Python are no part of it.
    println!("cargo:rerun-if-changed=build.rs");
    pyo3_build_config::add_extension_module_link_args();
}
