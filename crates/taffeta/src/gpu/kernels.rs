//! The kernels: which file each is in, which files stand for what it imports by a name, and the numbers that are fixed when it
//! is made. A source is made of whole files; nothing is ever formatted into one.

use crate::contact::collider_mesh::tree::WALK_TURNS;
use crate::solvers::explicit::gpu_layout::PATCH_NODE_BYTES;
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

/// What a kernel does about colliders.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Contact {
    /// It keeps nodes out of them; none is a mesh.
    Solids,
    /// Nothing: some are meshes, and contact is a kernel of its own.
    Later,
    /// It keeps nodes out of meshes, too.
    Meshes,
}

/// A kernel: its entry point, and what it is put together with.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Name {
    /// Entry point in the source.
    pub entry: &'static str,
    /// Whether it takes loads from the buffer in which they were summed up.
    pub loads_given: bool,
    /// Colliders.
    pub contact: Contact,
}

impl Name {
    /// The kernel with that entry point.
    pub const fn new(entry: &'static str) -> Self {
        Self { entry, loads_given: false, contact: Contact::Solids }
    }

    /// The files that stand for what the kernel imports by a name.
    fn choices(self) -> [(&'static str, &'static str); 4] {
        let (touch, meshes) = match self.contact {
            Contact::Solids => ("contact/colliders/touch.wgsl", "contact/collider_mesh/no_mesh.wgsl"),
            Contact::Later => ("contact/colliders/touch_later.wgsl", "contact/collider_mesh/no_mesh.wgsl"),
            Contact::Meshes => ("contact/colliders/touch.wgsl", "contact/collider_mesh/surface.wgsl"),
        };
        let loads = if self.loads_given { "elements/load/given.wgsl" } else { "elements/load/alone.wgsl" };
        [("touch", touch), ("meshes", meshes), ("loads", loads), ("memory", "gpu/wgsl/reach_memory.wgsl")]
    }

    /// Its source. The error says what is not among the `shaders`.
    pub fn source(self, shaders: &Shaders) -> Result<String, String> {
        let file = shaders.file_of(self.entry);
        let file = file.ok_or_else(|| format!("no shader has the entry point `{}`", self.entry))?;
        self.source_of(file, shaders)
    }

    /// The source of all kernels of a file.
    pub fn source_of(self, file: &str, shaders: &Shaders) -> Result<String, String> {
        shaders.source(file, &self.choices())
    }
}

/// Numbers that are fixed when a kernel is made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Sizes {
    /// Kinds of springs that a slice has.
    pub kinds: u32,
    /// Nodes that a patch has room for.
    pub room: u32,
    /// Sub-steps that are taken at once on patches.
    pub steps: u32,
}

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
    pub fn get(&self, name: Name, sizes: Sizes) -> Result<Kernel, GpuError> {
        let failed = |why| GpuError::Shader { label: name.entry.to_owned(), why };
        let source = name.source(&self.shaders).map_err(failed)?;
        let overrides = [
            ("KINDS", f64::from(sizes.kinds)),
            ("ROOM", f64::from(sizes.room * PATCH_NODE_BYTES / 4)),
            ("STEPS", f64::from(sizes.steps)),
            ("TURNS", f64::from(if self.gpu.info().is_software() { WALK_TURNS } else { u32::MAX })),
        ];
        self.gpu.kernel(name.entry, &[&source], name.entry, &overrides)
    }
}
