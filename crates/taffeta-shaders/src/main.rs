//! Compiles every kernel with a Vulkan driver, and prints what its compiler says of them as JSON.
//!
//! `taffeta-shaders` uses the driver that the environment chooses. `taffeta-shaders navi21 gfx1100` uses Mesa's driver for AMD, which
//! compiles for any GPU where none is, and runs nothing. `cargo xtask shaders` makes a table of it.

mod compiler;
mod families;
mod kernels;

use compiler::Compiler;
use kernels::Spirv;
use serde::Serialize;
use std::collections::BTreeMap;
use std::process::ExitCode;

/// Statistics that say nothing of what a kernel costs.
const HASHES: [&str; 2] = ["Hash", "Driver pipeline hash"];

#[derive(Serialize)]
struct Found {
    /// The device's name, and the driver's version.
    device: String,
    driver: String,
    kernels: Vec<Compiled>,
}

/// A kernel and what the compiler says of it.
#[derive(Serialize)]
struct Compiled {
    entry: String,
    /// Files that stand for what it imports by a name, where they are not the usual ones.
    with: String,
    /// By the compiler's own names.
    statistics: BTreeMap<String, f64>,
}

/// What the program ends with where it has no driver to ask.
const NO_DRIVER: u8 = 2;

/// Why nothing was found.
enum Failure {
    NoDriver(String),
    Other(String),
}

fn main() -> ExitCode {
    let names: Vec<String> = std::env::args().skip(1).collect();
    let result = if names.is_empty() {
        found().map(|found| serde_json::to_string(&found).expect("names and numbers"))
    } else {
        families::all(&names)
    };
    match result {
        Ok(text) => {
            println!("{text}");
            ExitCode::SUCCESS
        }
        Err(Failure::NoDriver(message)) => {
            eprintln!("taffeta-shaders: {message}");
            ExitCode::from(NO_DRIVER)
        }
        Err(Failure::Other(message)) => {
            eprintln!("taffeta-shaders: {message}");
            ExitCode::FAILURE
        }
    }
}

fn found() -> Result<Found, Failure> {
    let compiler = Compiler::new().map_err(Failure::NoDriver)?;
    let mut kernels: Vec<Compiled> = Vec::new();
    for Spirv { entry, with, words, buffers } in kernels::all().map_err(Failure::Other)? {
        let mut statistics = compiler
            .statistics(&entry, &words, &buffers)
            .map_err(|error| Failure::Other(format!("`{entry}` cannot be compiled: {error}")))?;
        statistics.retain(|name, _| !HASHES.contains(&name.as_str()));
        let compiled = Compiled { entry, with, statistics };
        let is_it = |one: &Compiled| one.entry == compiled.entry && one.statistics == compiled.statistics;
        // Choices that make no difference to this one.
        if !kernels.iter().any(is_it) {
            kernels.push(compiled);
        }
    }
    Ok(Found { device: compiler.device_name(), driver: compiler.driver(), kernels })
}
