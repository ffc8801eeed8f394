//! What a device has compiled: sources that were read, and the kernels that were asked for last.

use std::collections::{HashMap, VecDeque};
use std::sync::Arc;

use crate::Kernel;
use crate::reflect::Parsed;

/// Kernels that are kept though nobody holds them. To keep all that `taffeta gpu-check` makes took 8 GB on a software driver.
const KEPT: usize = 96;

/// A source that was read, for a device.
pub(crate) struct Module {
    pub parsed: Parsed,
    pub module: wgpu::ShaderModule,
}

/// What a kernel is made of.
#[derive(PartialEq)]
pub(crate) struct Key {
    source: String,
    label: String,
    entry: String,
    overrides: Vec<(String, u64)>,
}

impl Key {
    pub fn new(label: &str, source: String, entry: &str, overrides: &[(&str, f64)]) -> Self {
        let overrides = overrides.iter().map(|(name, value)| ((*name).to_owned(), value.to_bits()));
        Self { source, label: label.to_owned(), entry: entry.to_owned(), overrides: overrides.collect() }
    }

    pub fn source(&self) -> &str {
        &self.source
    }
}

/// What a device has compiled.
#[derive(Default)]
pub(crate) struct Cache {
    modules: HashMap<String, Arc<Module>>,
    /// The one that was asked for last stands last.
    kernels: VecDeque<(Key, Kernel)>,
}

impl Cache {
    pub fn module(&self, source: &str) -> Option<Arc<Module>> {
        self.modules.get(source).cloned()
    }

    /// Keeps a source that was read, unless somebody else was faster.
    pub fn keep_module(&mut self, source: &str, module: Module) -> Arc<Module> {
        self.modules.entry(source.to_owned()).or_insert_with(|| Arc::new(module)).clone()
    }

    pub fn kernel(&mut self, key: &Key) -> Option<Kernel> {
        let at = self.kernels.iter().position(|(one, _)| one == key)?;
        let found = self.kernels.remove(at)?;
        let kernel = found.1.clone();
        self.kernels.push_back(found);
        Some(kernel)
    }

    pub fn keep_kernel(&mut self, key: Key, kernel: Kernel) {
        if self.kernels.len() == KEPT {
            self.kernels.pop_front();
        }
        self.kernels.push_back((key, kernel));
    }
}
