//! The kernels: which sources each is made of. A source is a whole file; nothing is ever formatted into one.

use crate::gpu::layout::PATCH_NODE_BYTES;
use crate::gpu::paper;
use crate::solvers::explicit::patches::WALK_TURNS;
use std::collections::HashMap;
use taffeta_gpu::{Gpu, GpuError, Kernel};

/// Formulas, and what every kernel is told.
const FORMULAS: &[&str] = &[
    include_str!("wgsl/vector.wgsl"),
    include_str!("wgsl/angle.wgsl"),
    include_str!("../elements/spring/spring.wgsl"),
    include_str!("../elements/load/load.wgsl"),
    include_str!("../elements/hinge/hinge.wgsl"),
    include_str!("../elements/aero/gust.wgsl"),
    include_str!("../elements/aero/aero.wgsl"),
    include_str!("../solvers/explicit/euler.wgsl"),
    include_str!("../motion/pins.wgsl"),
    include_str!("../volume/volume.wgsl"),
    include_str!("../attachments/attach.wgsl"),
    include_str!("../solvers/dual/distance.wgsl"),
    include_str!("../solvers/implicit/implicit.wgsl"),
    include_str!("../contact/colliders/shape.wgsl"),
    include_str!("wgsl/substep.wgsl"),
    include_str!("../contact/colliders/response.wgsl"),
    include_str!("../contact/colliders/press.wgsl"),
    include_str!("../contact/nodes/pair.wgsl"),
    include_str!("../contact/nodes/cells.wgsl"),
    include_str!("../solvers/explicit/node.wgsl"),
];

const NO_MESH: &str = include_str!("../contact/collider_mesh/no_mesh.wgsl");
const TOUCH: &str = include_str!("../contact/colliders/touch.wgsl");
const TOUCH_LATER: &str = include_str!("../contact/colliders/touch_later.wgsl");
const MESH: &str = concat!(
    include_str!("../contact/collider_mesh/triangle.wgsl"),
    include_str!("../contact/collider_mesh/surface.wgsl")
);

/// The scene in memory, and every kernel that works on it there.
const STAGES: &[&str] = &[
    include_str!("wgsl/state.wgsl"),
    include_str!("wgsl/reach_memory.wgsl"),
    include_str!("../solvers/explicit/stages.wgsl"),
    include_str!("../contact/colliders/touch_again.wgsl"),
    include_str!("../elements/spring/grid.wgsl"),
    include_str!("../solvers/explicit/grid_stages.wgsl"),
    include_str!("../elements/spring/mesh.wgsl"),
    include_str!("../solvers/explicit/mesh_stages.wgsl"),
    include_str!("../volume/groups.wgsl"),
    include_str!("../volume/stages.wgsl"),
    include_str!("../volume/restore_stages.wgsl"),
    include_str!("../contact/nodes/pairs.wgsl"),
    include_str!("../contact/nodes/stages.wgsl"),
    include_str!("../attachments/stages.wgsl"),
    include_str!("../solvers/dual/solve.wgsl"),
    include_str!("../solvers/dual/active_stages.wgsl"),
    include_str!("../solvers/dual/stages.wgsl"),
    include_str!("../solvers/implicit/levels.wgsl"),
    include_str!("../solvers/implicit/set_up.wgsl"),
    include_str!("../solvers/implicit/stages.wgsl"),
    include_str!("../solvers/implicit/level_stages.wgsl"),
    include_str!("../elements/load/elements.wgsl"),
    include_str!("../elements/aero/stages.wgsl"),
    include_str!("../elements/load/stages.wgsl"),
    include_str!("../motion/stages.wgsl"),
    include_str!("../diagnostics/measure.wgsl"),
    include_str!("../diagnostics/measure_grid.wgsl"),
    include_str!("../diagnostics/measure_mesh.wgsl"),
    include_str!("../diagnostics/measure_elements.wgsl"),
];

/// Kernels that meet triangles of colliders, and what of the scene they need.
const MESHES: &[&str] = &[
    include_str!("wgsl/state.wgsl"),
    include_str!("wgsl/reach_memory.wgsl"),
    include_str!("../solvers/explicit/stages.wgsl"),
    include_str!("../contact/colliders/touch_again.wgsl"),
    include_str!("../elements/spring/mesh.wgsl"),
    include_str!("../volume/groups.wgsl"),
    include_str!("../volume/restore_stages.wgsl"),
    include_str!("../contact/nodes/pairs.wgsl"),
    include_str!("../solvers/dual/solve.wgsl"),
    include_str!("../solvers/implicit/levels.wgsl"),
    include_str!("../attachments/stages.wgsl"),
    include_str!("../motion/stages.wgsl"),
    include_str!("../contact/collider_mesh/stages.wgsl"),
];

/// Parts of the scene in the memory of workgroups, and the kernels that work on them there.
const PATCHES: &[&str] = &[
    include_str!("wgsl/state.wgsl"),
    include_str!("../solvers/explicit/reach_patch.wgsl"),
    include_str!("../elements/spring/grid.wgsl"),
    include_str!("../solvers/explicit/grid_patches.wgsl"),
    include_str!("../elements/spring/mesh.wgsl"),
    include_str!("../solvers/explicit/mesh_patches.wgsl"),
];

const LOADS_ALONE: &str = include_str!("../elements/load/alone.wgsl");
const LOADS_GIVEN: &str = include_str!("../elements/load/given.wgsl");

/// Vertex normals need no more of the scene than positions.
const NORMALS: &[&str] = &[
    include_str!("wgsl/vector.wgsl"),
    include_str!("wgsl/normal.wgsl"),
    include_str!("../diagnostics/normals.wgsl"),
];

/// Vertices of a renderer need those of two states.
const DRAWN: &[&str] = &[
    include_str!("wgsl/vector.wgsl"),
    include_str!("wgsl/normal.wgsl"),
    include_str!("../diagnostics/drawn.wgsl"),
];

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

    /// Whether it works in the memory of workgroups.
    fn is_of_patches(self) -> bool {
        matches!(self.entry, "grid_patches" | "mesh_patches")
    }

    /// Its sources, one behind the other.
    pub fn sources(self) -> Vec<&'static str> {
        match self.entry {
            "vertex_normals" => return NORMALS.to_vec(),
            "draw_vertices" => return DRAWN.to_vec(),
            _ => {}
        }
        let loads = if self.loads_given { LOADS_GIVEN } else { LOADS_ALONE };
        let contact = match self.contact {
            Contact::Solids => [NO_MESH, TOUCH],
            Contact::Later => [NO_MESH, TOUCH_LATER],
            Contact::Meshes => [MESH, TOUCH],
        };
        let stages = match self.contact {
            Contact::Meshes => MESHES,
            _ if self.is_of_patches() => PATCHES,
            _ => STAGES,
        };
        [FORMULAS, &contact, &[loads], stages, paper::sources(self.entry)].concat()
    }
}

/// The sources that kernels are made of, each put together in one way; those of the papers' kernels apart.
pub fn families() -> [Vec<&'static str>; 7] {
    let given = Name { loads_given: true, ..Name::new("") };
    let [later, meshes] = [Contact::Later, Contact::Meshes].map(|contact| Name { contact, ..Name::new("") });
    let [normals, drawn] = ["vertex_normals", "draw_vertices"].map(Name::new);
    [Name::new(""), given, Name::new("grid_patches"), normals, drawn, later, meshes].map(Name::sources)
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

/// Kernels that were made so far.
pub struct Kernels {
    gpu: Gpu,
    made: HashMap<(Name, Sizes), Kernel>,
}

impl Kernels {
    /// None yet.
    pub fn new(gpu: Gpu) -> Self {
        Self { gpu, made: HashMap::new() }
    }

    /// A kernel, made if it is not there yet.
    pub fn get(&mut self, name: Name, sizes: Sizes) -> Result<Kernel, GpuError> {
        if let Some(kernel) = self.made.get(&(name, sizes)) {
            return Ok(kernel.clone());
        }
        let kinds = ("KINDS", f64::from(sizes.kinds));
        let (room, steps) =
            (("ROOM", f64::from(sizes.room * PATCH_NODE_BYTES / 4)), ("STEPS", f64::from(sizes.steps)));
        let turns = ("TURNS", f64::from(WALK_TURNS));
        let overrides = match name.entry {
            "vertex_normals" | "draw_vertices" => &[][..],
            _ if name.is_of_patches() => &[kinds, room, steps],
            _ if name.contact == Contact::Meshes && self.gpu.info().is_software() => &[kinds, turns],
            _ => &[kinds],
        };
        let kernel = self.gpu.kernel(name.entry, &name.sources(), name.entry, overrides)?;
        self.made.insert((name, sizes), kernel.clone());
        Ok(kernel)
    }
}
