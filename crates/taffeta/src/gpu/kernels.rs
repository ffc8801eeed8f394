//! The kernels: which sources each is made of. A source is a whole file; nothing is ever formatted into one.

use std::collections::HashMap;
use taffeta_gpu::{Gpu, GpuError, Kernel};

/// Formulas, and what every kernel is told.
const FORMULAS: &[&str] = &[
    include_str!("../shared/vector.wgsl"),
    include_str!("../shared/angle.wgsl"),
    include_str!("../forces/spring.wgsl"),
    include_str!("../forces/external.wgsl"),
    include_str!("../forces/hinge.wgsl"),
    include_str!("../integrate/euler.wgsl"),
    include_str!("../integrate/pins.wgsl"),
    include_str!("../collision/shape.wgsl"),
    include_str!("substep.wgsl"),
    include_str!("../collision/contact.wgsl"),
    include_str!("node.wgsl"),
];

/// The scene in memory, and every kernel that works on it.
const STAGES: &[&str] = &[
    include_str!("state.wgsl"),
    include_str!("stages.wgsl"),
    include_str!("grid.wgsl"),
    include_str!("grid_stages.wgsl"),
    include_str!("mesh.wgsl"),
    include_str!("mesh_stages.wgsl"),
    include_str!("elements.wgsl"),
    include_str!("loads.wgsl"),
    include_str!("pins.wgsl"),
    include_str!("measure.wgsl"),
    include_str!("measure_grid.wgsl"),
    include_str!("measure_mesh.wgsl"),
    include_str!("measure_elements.wgsl"),
];

const LOADS_ALONE: &str = include_str!("loads_alone.wgsl");
const LOADS_GIVEN: &str = include_str!("loads_given.wgsl");

/// A kernel: its entry point, and whether loads were summed up beforehand.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Name {
    /// Entry point in the source.
    pub entry: &'static str,
    /// Whether it takes loads from the buffer in which they were summed up.
    pub loads_given: bool,
}

impl Name {
    /// The kernel with that entry point.
    pub const fn new(entry: &'static str) -> Self {
        Self { entry, loads_given: false }
    }

    /// Its sources, one behind the other.
    pub fn sources(self) -> Vec<&'static str> {
        let loads = if self.loads_given { LOADS_GIVEN } else { LOADS_ALONE };
        [FORMULAS, &[loads], STAGES].concat()
    }
}

/// Kernels that were made so far.
pub struct Kernels {
    gpu: Gpu,
    /// By name, and by kinds of springs a slice has.
    made: HashMap<(Name, u32), Kernel>,
}

impl Kernels {
    /// None yet.
    pub fn new(gpu: Gpu) -> Self {
        Self { gpu, made: HashMap::new() }
    }

    /// A kernel, made if it is not there yet.
    pub fn get(&mut self, name: Name, kinds: u32) -> Result<Kernel, GpuError> {
        if let Some(kernel) = self.made.get(&(name, kinds)) {
            return Ok(kernel.clone());
        }
        let kernel =
            self.gpu.kernel(name.entry, &name.sources(), name.entry, &[("KINDS", f64::from(kinds))])?;
        self.made.insert((name, kinds), kernel.clone());
        Ok(kernel)
    }
}
