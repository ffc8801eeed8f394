//! The answer for a mesh, as `--json` prints it. Scripts rely on these names.

use schemars::JsonSchema;
use serde::Serialize;

/// A mesh in numbers, and whether it can be simulated. Vertices are those of the file, counted from 0.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct MeshReport {
    /// The file, as it was given.
    pub mesh: String,
    /// Vertices of the file.
    pub vertices: usize,
    /// Faces of the file, of any number of corners.
    pub faces: usize,
    /// What is simulated: vertices at one place share a node.
    pub nodes: usize,
    /// Triangles that the faces were cut into.
    pub triangles: usize,
    /// Edges of the triangles.
    pub edges: usize,
    /// Whether each edge has two triangles that agree on their sides.
    pub closed: bool,
    /// Whether the triangles can be turned so that all neighbours agree on their sides.
    pub orientable: bool,
    /// Components: triangles that hang together by edges.
    pub components: usize,
    /// The same, if components that touch at a point count as one.
    pub joined_components: usize,
    /// The largest components, at most 20, by triangles.
    pub largest_components: Vec<ComponentReport>,
    /// Nodes − edges + triangles.
    pub euler_characteristic: i64,
    /// Number of handles; null with non-manifold edges or if not orientable.
    pub genus: Option<u64>,
    /// Closed loops of boundary edges; the outer border of a sheet is one.
    pub holes: usize,
    /// Borders that are no loops, for they end at non-manifold edges.
    pub open_borders: usize,
    /// Edges with one triangle.
    pub boundary_edges: Named<[u32; 2]>,
    /// Edges with more than two triangles.
    pub non_manifold_edges: Named<[u32; 2]>,
    /// Edges with more than two faces in the file, before faces were dropped; counted only if some are left.
    pub non_manifold_edges_in_file: usize,
    /// Edges whose two triangles disagree on their sides.
    pub flipped_edges: Named<[u32; 2]>,
    /// Vertices at which parts of the surface only touch; each part has a node of its own there.
    pub bow_ties: Named<u32>,
    /// Triangles that meet where they should not.
    pub self_intersections: IntersectionReport,
    /// Extent along x, y and z [m].
    pub extent: [f64; 3],
    /// Area [m²].
    pub area: f64,
    /// Volume inside [m³]; null if not closed.
    pub volume: Option<f64>,
    /// The shortest edge.
    pub shortest_edge: EdgeReport,
    /// The longest edge.
    pub longest_edge: EdgeReport,
    /// The thinnest triangle.
    pub thinnest_triangle: TriangleReport,
    /// How stiff the mesh is against bending, by the stiffness of a fabric laid on it: least and largest of all directions, without
    /// its border; 1 and 1 if it is regular. Null above 200,000 nodes and if no triangle is inside.
    pub bending_factors: Option<[f64; 2]>,
    /// Memory that building the body takes [byte], roughly.
    pub memory_bytes: u64,
    /// What was repaired on reading, in words.
    pub repairs: Vec<String>,
    /// What does not forbid a simulation, but may spoil it, in words.
    pub warnings: Vec<String>,
    /// What the unit of the coordinates may be, if hardly metres.
    pub unit: Option<UnitHint>,
    /// Whether it can be a soft body.
    pub body: Verdict,
    /// Whether it can be a shell: cloth.
    pub shell: Verdict,
    /// A scene with this mesh, in TOML, to be saved beside it; null if it was refused.
    pub scene: Option<String>,
}

/// A count, and the first few.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Named<T> {
    /// How many there are.
    pub count: usize,
    /// The first of them, by vertices.
    pub first: Vec<T>,
}

/// Triangles that hang together by edges.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct ComponentReport {
    /// Number of triangles.
    pub triangles: usize,
    /// A vertex of it.
    pub vertex: u32,
    /// Whether each edge has two triangles that agree on their sides.
    pub closed: bool,
    /// Volume inside [m³], negative for a cavity; null if not closed.
    pub volume: Option<f64>,
    /// Number of handles; null with non-manifold edges or if not orientable.
    pub genus: Option<u64>,
}

/// Triangles that meet where they should not.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct IntersectionReport {
    /// Pairs without a common corner that have a point in common; one that touches counts.
    pub crossing: u64,
    /// Pairs with a common corner or edge that have a point in common beyond it.
    pub folded: u64,
    /// False if the count ended early, for there are too many: these numbers are then the least there are.
    pub complete: bool,
    /// The first pairs, each triangle by its vertices.
    pub first: Vec<[[u32; 3]; 2]>,
}

/// An edge.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
pub struct EdgeReport {
    /// Length [m].
    pub length: f64,
    /// Its ends.
    pub vertices: [u32; 2],
}

/// A triangle.
#[derive(Clone, Copy, Debug, Serialize, JsonSchema)]
pub struct TriangleReport {
    /// Longest edge over the height upon it; 1.15 if all edges are equal.
    pub aspect: f64,
    /// Its corners.
    pub vertices: [u32; 3],
}

/// What the unit of the coordinates may be.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct UnitHint {
    /// In words.
    pub hint: String,
    /// The `place.scale` that makes metres of it; null where that is open.
    pub scale: Option<f64>,
}

/// Whether a mesh is accepted as something.
#[derive(Clone, Debug, Serialize, JsonSchema)]
pub struct Verdict {
    /// Whether it is.
    pub accepted: bool,
    /// Why not.
    pub reason: Option<String>,
    /// What would do.
    pub remedy: Option<String>,
}
