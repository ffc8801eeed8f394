//! One comparison.

use crate::parity::bench::Bench;
use crate::parity::outcome::Outcome;
use taffeta_gpu::Gpu;

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
