//! The kernels: which file each is in, which files stand for what it imports by a name, and the numbers that are fixed when it
//! is made. A source is made of whole files; nothing is ever formatted into one.

use std::collections::BTreeMap;
use taffeta_gpu::{Gpu, GpuError, Kernel, Shader, Shaders, shaders};

/// The state, sub-steps, and products of vectors: what the files of features import.
pub const SHADERS: &[Shader] = shaders!(
    "gpu",
    [
        "wgsl/angle.wgsl",
        "wgsl/force.wgsl",
        "wgsl/goals.wgsl",
        "wgsl/index.wgsl",
        "wgsl/normal.wgsl",
        "wgsl/reach_memory.wgsl",
        "wgsl/state.wgsl",
        "wgsl/substep.wgsl",
        "wgsl/vector.wgsl"
    ]
);

/// Files that stand for what shaders import by a name, where a kernel has no other.
pub const DEFAULTS: &[Shader] = &[("memory", "#import gpu/wgsl/reach_memory.wgsl\n")];

/// A file that stands for what a kernel imports by a name.
pub type Choice = (&'static str, &'static str);

/// A kernel: its entry point, and what it is put together with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Name {
    /// Entry point in the source.
    pub entry: &'static str,
    /// The files that stand for what it imports by a name, where it is not what the features' shaders have there.
    choices: [Option<Choice>; 2],
}

impl Name {
    /// The kernel with that entry point.
    pub const fn new(entry: &'static str) -> Self {
        Self { entry, choices: [None; 2] }
    }

    /// The same with other files; each name that is imported has one at most.
    pub fn with(mut self, choices: &[Choice]) -> Self {
        for &choice in choices {
            let free = self.choices.iter_mut().find(|one| one.is_none());
            *free.expect("no kernel has more choices than there is room for") = Some(choice);
        }
        self
    }

    /// Whether it has such a file.
    pub fn has(self, choice: Choice) -> bool {
        self.choices.contains(&Some(choice))
    }

    /// Its source. The error says what is not among the `shaders`.
    pub fn source(self, shaders: &Shaders) -> Result<String, String> {
        let file = shaders.file_of(self.entry);
        let file = file.ok_or_else(|| format!("no shader has the entry point `{}`", self.entry))?;
        self.source_of(file, shaders)
    }

    /// The source of all kernels of a file.
    pub fn source_of(self, file: &str, shaders: &Shaders) -> Result<String, String> {
        shaders.source(file, &self.choices.into_iter().flatten().collect::<Vec<_>>())
    }
}

/// Numbers that are fixed when a kernel is made, by their names in the shaders.
pub type Overrides = BTreeMap<&'static str, f64>;

/// The kernels of a device, which keeps those that it has compiled.
#[derive(Clone)]
pub struct Kernels {
    gpu: Gpu,
    shaders: Shaders,
}

impl Kernels {
    /// Those that are put together from these files.
    pub fn new(gpu: Gpu, shaders: Shaders) -> Self {
        Self { gpu, shaders }
    }

    /// A kernel.
    pub fn get(&self, name: Name, overrides: &Overrides) -> Result<Kernel, GpuError> {
        let failed = |why| GpuError::Shader { label: name.entry.to_owned(), why };
        let source = name.source(&self.shaders).map_err(failed)?;
        let overrides: Vec<_> = overrides.iter().map(|(&name, &value)| (name, value)).collect();
        self.gpu.kernel(name.entry, &[&source], name.entry, &overrides)
    }
}
