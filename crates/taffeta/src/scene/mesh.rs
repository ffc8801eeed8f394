use crate::scene::{Disc, Pattern, Sheet, Surface};
use glam::DVec2;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::sync::Arc;

/// Where a body's shape comes from.
///
/// ```
/// use taffeta::scene::{Icosphere, Mesh};
///
/// // What is at hand, with its number of nodes.
/// assert_eq!(Mesh::grid(20, 30, [1.0, 1.5]).nodes(), 600);
/// assert_eq!(Mesh::chain(10, 1.0).nodes(), 11);
/// assert_eq!(Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 }).nodes(), 642);
/// ```
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Mesh {
    /// A rectangle of rows × columns in the xz plane.
    Grid(Grid),
    /// A flat rectangle of triangles in the xz plane, with texture coordinates.
    Sheet(Sheet),
    /// A flat disc of triangles in the xz plane, with texture coordinates.
    Disc(Disc),
    /// A mesh file: OBJ, PLY, STL, OFF or glTF. The engine reads no files: `taffeta_io::load_scene` does, and puts a `Surface` here.
    File(String),
    /// A sphere from a subdivided icosahedron.
    Icosphere(Icosphere),
    /// A sphere of rings and segments.
    UvSphere(UvSphere),
    /// A torus about the y axis.
    Torus(Torus),
    /// A cube of squares, each two triangles.
    Cube(Cube),
    /// A capped cylinder about the y axis.
    Cylinder(Cylinder),
    /// Nodes in a row along x, joined by links.
    Chain(Chain),
    /// A surface given as data.
    #[serde(skip)]
    Surface(Arc<Surface>),
}

/// Nodes in the xz plane, centred; row 0 at −z, column 0 at −x, node = row·cols + column.
///
/// ```
/// use taffeta::scene::{Grid, Mesh};
///
/// assert!(matches!(Mesh::grid(20, 30, [1.0, 1.5]), Mesh::Grid(Grid { rows: 20, cols: 30, .. })));
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Grid {
    /// Nodes along z.
    pub rows: u32,
    /// Nodes along x.
    pub cols: u32,
    /// Extent along x (columns) and z (rows) [m].
    pub size: [f64; 2],
}

/// A subdivided icosahedron.
///
/// ```
/// use taffeta::scene::{Icosphere, Mesh};
///
/// // Each subdivision has four times the triangles; nodes: 10·4ⁿ + 2.
/// assert_eq!(Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 4 }).nodes(), 2562);
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Icosphere {
    /// Radius [m].
    pub radius: f64,
    /// How often each triangle is split in four, 0 to 9.
    pub subdivisions: u32,
}

/// A sphere of rings (pole to pole) and segments (around).
///
/// ```
/// use taffeta::scene::{Mesh, UvSphere};
///
/// // Two poles, and 7 circles of 16 nodes between 8 rings.
/// assert_eq!(Mesh::UvSphere(UvSphere { radius: 0.2, rings: 8, segments: 16 }).nodes(), 114);
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UvSphere {
    /// Radius [m].
    pub radius: f64,
    /// Bands from pole to pole, at least 2.
    pub rings: u32,
    /// Sectors around the y axis, at least 3.
    pub segments: u32,
}

/// A torus about the y axis.
///
/// ```
/// use taffeta::scene::{Mesh, Torus};
///
/// // A swim ring of 60 cm, 20 cm thick.
/// let ring = Mesh::Torus(Torus { major: 0.2, minor: 0.1, rings: 48, segments: 24 });
/// assert_eq!(ring.nodes(), 48 * 24);
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Torus {
    /// Distance from the centre to the middle of the tube [m].
    pub major: f64,
    /// Radius of the tube [m].
    pub minor: f64,
    /// Sectors around the y axis, at least 3.
    pub rings: u32,
    /// Sectors around the tube, at least 3.
    pub segments: u32,
}

/// A cube of `divisions`² squares a face.
///
/// ```
/// use taffeta::scene::{Cube, Mesh};
///
/// assert_eq!(Mesh::Cube(Cube { size: 1.0, divisions: 8 }).nodes(), 386);
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cube {
    /// Edge [m].
    pub size: f64,
    /// Squares along an edge.
    pub divisions: u32,
}

/// A capped cylinder about the y axis.
///
/// ```
/// use taffeta::scene::{Cylinder, Mesh};
///
/// // A sleeve: an open tube of 5 circles with 24 nodes each.
/// let sleeve = Mesh::Cylinder(Cylinder { radius: 0.06, height: 0.5, segments: 24, rings: 4, capped: false });
/// assert_eq!(sleeve.nodes(), 5 * 24);
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Cylinder {
    /// Radius [m].
    pub radius: f64,
    /// Height [m].
    pub height: f64,
    /// Sectors around, at least 3.
    #[serde(default = "default_segments")]
    pub segments: u32,
    /// Bands along the height, at least 1.
    #[serde(default = "default_rings")]
    pub rings: u32,
    /// Whether the ends are closed.
    #[serde(default = "default_capped")]
    pub capped: bool,
}

fn default_segments() -> u32 {
    32
}
fn default_rings() -> u32 {
    8
}
fn default_capped() -> bool {
    true
}

/// `links` + 1 nodes along x, centred, node 0 at −x.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Select};
///
/// // A rope of 2 m and 0.1 kg that hangs from its first node.
/// let rope = Body::cloth("rope", Mesh::chain(40, 2.0)).with_mass(Mass::Node(0.1 / 41.0)).structural(2e3, 0.1);
/// let rope = rope.pin(Select::nodes([0]));
/// assert_eq!(rope.mesh.nodes(), 41);
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Chain {
    /// Number of links; nodes are one more.
    pub links: u32,
    /// Length of the whole chain [m].
    pub length: f64,
}

impl Mesh {
    /// A grid of `rows` × `cols` nodes, `size` = extent along x and z [m].
    pub fn grid(rows: u32, cols: u32, size: impl Into<DVec2>) -> Self {
        Self::Grid(Grid { rows, cols, size: size.into().to_array() })
    }

    /// A flat sheet of triangles with equal sides, `size` = extent along x and z [m], `edge` = length of their edges [m], about.
    pub fn sheet(size: impl Into<DVec2>, edge: f64) -> Self {
        Self::Sheet(Sheet { size: size.into().to_array(), edge, pattern: Pattern::Equilateral })
    }

    /// A chain of `links` links, `length` [m] in all.
    pub fn chain(links: u32, length: f64) -> Self {
        Self::Chain(Chain { links, length })
    }

    /// Whether it is a file, or what was in one.
    pub(crate) fn is_from_file(&self) -> bool {
        matches!(self, Self::File(_) | Self::Surface(_))
    }

    /// Number of nodes, for shapes given by numbers or data; 0 for a file that is not loaded.
    pub fn nodes(&self) -> u64 {
        let product = |a: u32, b: u32| u64::from(a) * u64::from(b);
        match self {
            Self::Grid(grid) => product(grid.rows, grid.cols),
            Self::Sheet(sheet) => sheet.nodes(),
            Self::Disc(disc) => disc.nodes(),
            Self::File(_) => 0,
            Self::Icosphere(ball) => {
                10_u64.saturating_mul(4_u64.saturating_pow(ball.subdivisions)).saturating_add(2)
            }
            Self::UvSphere(ball) => product(ball.rings.saturating_sub(1), ball.segments) + 2,
            Self::Torus(torus) => product(torus.rings, torus.segments),
            Self::Cube(cube) => product(cube.divisions, cube.divisions).saturating_mul(6) + 2,
            Self::Cylinder(cylinder) => {
                let caps = if cylinder.capped { 2 } else { 0 };
                product(cylinder.segments, cylinder.rings) + u64::from(cylinder.segments) + caps
            }
            Self::Chain(chain) => u64::from(chain.links) + 1,
            Self::Surface(surface) => surface.nodes.len() as u64,
        }
    }
}
