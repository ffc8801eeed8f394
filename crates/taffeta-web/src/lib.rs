//! The wasm part of the npm package `taffeta`: it converts and calls, and computes nothing itself.
//!
//! The package is in `web/package`; docs/web.md is its guide. Objects become scenes by way of TOML, and every error becomes an
//! `Error` whose name says of which kind it is.

mod colliders;
mod document;
mod errors;
mod mesh;
mod object;
mod reads;
mod report;
mod scene;
mod simulation;

use errors::Failure;
use wasm_bindgen::prelude::wasm_bindgen;

/// Has a panic, which is a mistake of ours, end as an `Error` in JavaScript.
#[wasm_bindgen(start)]
pub fn start() {
    std::panic::set_hook(Box::new(|panic| {
        wasm_bindgen::throw_val(Failure::Internal(panic.to_string()).into());
    }));
}

/// The version of the package.
#[wasm_bindgen]
pub fn version() -> String {
    env!("CARGO_PKG_VERSION").to_owned()
}

/// The vector instructions that kernels were compiled for.
#[wasm_bindgen]
pub fn simd() -> String {
    taffeta::simd_level()
}

/// Panics, so that a test sees what becomes of a mistake of ours.
#[wasm_bindgen(js_name = panicForTest)]
pub fn panic_for_test() {
    panic!("on purpose");
}
