//! What the papers call limits and future work, each answered.

use crate::report::page::Section;
use crate::report::table::{Cell, Table};

/// Paper and place, what it says, whether that is done, and where or why not.
const ITEMS: [[&str; 4]; 20] = [
    [
        "S1 § 5",
        "a grid's size is fixed by hand, and other models need other thread groups",
        "done",
        "grids of any size, and meshes from files: `docs/meshes.md`; thread groups follow from the scene",
    ],
    [
        "S1 § 5",
        "the size of the system's matrix must be found to reduce its work",
        "done",
        "no matrix is built: constraints are applied by gathering: `docs/models/ice.md`",
    ],
    [
        "S1 § 5",
        "atomic operations are the bottleneck",
        "done",
        "no sum by atomics: nodes gather and sums are reduced in a fixed order, so results repeat bit by bit; one exchange a node is left where nodes that may touch are listed: `docs/models/determinism.md`",
    ],
    [
        "S1 § 5",
        "one GPU was tried; others may not have its 1,024 threads a workgroup",
        "partly",
        "at most 256 threads and 8 buffers, Vulkan, Metal and DirectX 12; tested on software Vulkan alone, `taffeta gpu-check` tests any other",
    ],
    [
        "S1 § 5",
        "parallel sum reduction",
        "done",
        "for volumes, energies and the solver, in fixed lanes and chunks: `docs/models/determinism.md`",
    ],
    [
        "S1 § 4",
        "Runge–Kutta is more accurate",
        "measured",
        "in the tournament above: its longest steps are 1.3 to 1.5 times those of springs, at four forces each. In plain code, against springs in vector instructions, it is faster only for a drum to 0.1 %; by forces alone, for a drum to 1 % as well",
    ],
    [
        "S1 § 4",
        "implicit Euler reduces the error in large steps",
        "done",
        "ICE by nodes, `ice.form = \"primal\"`: any step: `docs/models/primal.md`",
    ],
    [
        "S1 § 5",
        "coefficients learned from materials",
        "not yet",
        "needs gradients of the whole step; the scene format takes physical values meanwhile",
    ],
    ["S1 § 5", "more speed", "done", "the tables above"],
    [
        "S1 § 3.4",
        "collision with one sphere",
        "done",
        "planes, balls, boxes, bars, hulls, height fields and meshes, at rest or moving: `docs/models/collision.md`",
    ],
    [
        "S1 § 3",
        "no self-collision",
        "done",
        "between triangles, and of nodes, as S2 has it: `docs/models/contact.md`",
    ],
    [
        "S1 § 5",
        "use in VR and AR",
        "partly",
        "a plugin for Bevy, which draws what the GPU computed: `crates/bevy_taffeta`; not tried in a headset",
    ],
    [
        "S2",
        "a particle that skips a bin is lost: the simulation would break before",
        "done",
        "neighbours are searched again when nodes have moved far enough: `docs/models/contact.md`",
    ],
    [
        "S2",
        "frame time at other sizes and on newer GPUs",
        "partly",
        "all sizes on CPUs, to 409,600 particles; GPUs are open rows",
    ],
    [
        "S3 § VI",
        "atomic operations are the bottleneck; reduction, colouring",
        "done",
        "one reduction by bodies for all volumes; colouring is not needed where nodes gather: `docs/models/volume.md`",
    ],
    [
        "S3 § VI",
        "shape matching, to keep detail, for elastic and plastic bodies",
        "not yet",
        "springs and volume alone; a further constraint beside that of volumes is where it would go",
    ],
    ["S3 § VI", "other engines", "done", "no engine is needed: a library, a program, and a plugin for Bevy"],
    [
        "S3 § VI",
        "collision on the GPU",
        "done",
        "nodes against all colliders and each other, nothing read back within a frame; what does not fit is refused by name: `docs/gpu.md`",
    ],
    [
        "S3 § VI",
        "complex biological models",
        "partly",
        "any closed surface; scans are corrected as they are read: `docs/meshes.md`; organs were not tried",
    ],
    [
        "S3 § VI",
        "virtual cutting",
        "not yet",
        "seams and pins tear: `docs/models/attachments.md`; cutting through triangles changes the mesh, which is fixed during a run",
    ],
];

/// The table.
pub fn section() -> Section {
    let caption = "What the papers call limits of theirs or future work, and what we add to that: one sphere and no self-collision (S1), other sizes (S2). The same list is a list of what to build next.";
    let mut table =
        Table::new("limits", caption, &["paper", "limit or future work", "here", "where, or why not"]);
    for item in ITEMS {
        table.row(item.map(Cell::words).to_vec());
    }
    Section::new("Limits and future work of the papers").table(table)
}
