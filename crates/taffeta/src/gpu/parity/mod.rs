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
pub(crate) mod scene;

use crate::features::shaders;
use crate::gpu::kernels::Name;
use bench::Bench;
pub use outcome::{Difference, Outcome};
use taffeta_gpu::Gpu;
use taffeta_gpu::wgpu::naga;

/// A kernel and its twin.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Its name: the kernel's entry point, and a word more where there are variants.
    pub name: &'static str,
    /// The kernel's entry point.
    pub entry: &'static str,
    /// How far the twins may be apart.
    pub tolerance: Tolerance,
    pub(crate) check: fn(&mut Bench<'_>) -> Result<(), String>,
}

/// Differences that are allowed, in units in the last place of the largest number of an output.
#[derive(Clone, Copy, Debug)]
pub struct Tolerance {
    /// On adapters that run kernels on the CPU.
    pub software: f64,
    /// On others: they may fuse a product and a sum, and take a quotient or root with an error of 2.5 units. Some
    /// times what products and roots that are off by a unit were seen to make.
    pub hardware: f64,
    /// Why so much.
    pub why: &'static str,
}

impl Tolerance {
    pub(crate) const fn new(software: f64, hardware: f64, why: &'static str) -> Self {
        Self { software, hardware, why }
    }

    /// That of an adapter.
    pub fn on(&self, gpu: &Gpu) -> f64 {
        if gpu.info().is_software() { self.software } else { self.hardware }
    }
}

impl Row {
    /// Runs both twins. The error says what kept the kernel from running.
    pub fn run(&self, gpu: &Gpu) -> Result<Outcome, String> {
        self.run_edited(gpu, gpu.info().is_software(), &|source| source)
    }

    /// As [`Self::run`], with sources that went through `edit`: to see that a fault in them is found, and that other
    /// roundings are not taken for one. States are `exact` where kernels round as the CPU does.
    pub fn run_edited(
        &self,
        gpu: &Gpu,
        exact: bool,
        edit: &dyn Fn(String) -> String,
    ) -> Result<Outcome, String> {
        let mut bench = Bench { gpu, entry: self.entry, exact, edit, outcome: Outcome::default() };
        (self.check)(&mut bench)?;
        Ok(bench.outcome)
    }
}

/// The entry points that naga finds in the shaders.
pub fn entry_points() -> Result<Vec<String>, String> {
    let mut found = Vec::new();
    let shaders = shaders();
    for file in shaders.with_kernels() {
        let source = Name::new("").source_of(file, &shaders)?;
        let module = naga::front::wgsl::parse_str(&source).map_err(|error| error.emit_to_string(&source))?;
        found.extend(module.entry_points.into_iter().map(|point| point.name));
    }
    found.sort();
    Ok(found)
}
