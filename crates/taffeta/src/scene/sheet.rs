//! Flat sheets and discs whose triangles have an edge of a given length.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// A flat sheet in the xz plane, centred, with straight borders; it looks to +y. Texture coordinates are metres: u along x,
/// v along z, so that the warp of a fabric runs along x. Groups of nodes: `left` (−x), `right` (+x), `back` (−z), `front` (+z).
///
/// A whole number of edges fits each side, the nearest one to what `edge` says. With [`Pattern::Equilateral`] rows run along x,
/// a height of √¾ edges apart, each half an edge against the last, with half triangles at their ends.
///
/// ```
/// use taffeta::scene::{Body, Material, Mesh, Scene, Select};
/// use taffeta::{Options, Simulation};
///
/// // A curtain of cotton, triangles of 5 cm, that hangs by one side.
/// let top = Select { group: Some("back".into()), ..Select::default() };
/// let curtain = Body::cloth("curtain", Mesh::sheet([1.0, 2.0], 0.05)).with_material(Material::preset("cotton"));
/// let scene = Scene::new("").time(1e-3, 1e-4).body(curtain.pin(top));
/// assert_eq!(Simulation::new(&scene, &Options::default())?.bodies()[0].pinned, 21);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sheet {
    /// Extent along x and z [m].
    pub size: [f64; 2],
    /// Length of a triangle's edge [m], about.
    #[serde(default = "default_edge")]
    pub edge: f64,
    /// How triangles are laid.
    #[serde(default)]
    pub pattern: Pattern,
}

/// A flat disc in the xz plane, centred, with a smooth round border; it looks to +y. Texture coordinates are as those of a
/// [`Sheet`].
///
/// Inside it is an even pattern. The border is a ring of equal edges, a whole number of them, and the nodes within three edges
/// of it are moved until their triangles are well shaped.
///
/// ```
/// use taffeta::scene::{Disc, Mesh, Pattern};
///
/// // The specimen of a drape test: 30 cm across.
/// let specimen = Disc { radius: 0.15, edge: 0.01, pattern: Pattern::Equilateral };
/// assert_eq!(Mesh::Disc(specimen).nodes(), 851);
/// ```
#[derive(Clone, Copy, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Disc {
    /// Radius [m].
    pub radius: f64,
    /// Length of a triangle's edge [m], about; at most half the radius.
    #[serde(default = "default_edge")]
    pub edge: f64,
    /// How triangles are laid inside.
    #[serde(default)]
    pub pattern: Pattern,
}

/// How the triangles of a flat mesh are laid.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Pattern {
    /// Triangles with three equal sides.
    #[default]
    Equilateral,
    /// Squares, all cut along the same diagonal, as those of a grid.
    Grid,
}

fn default_edge() -> f64 {
    0.01
}

impl Pattern {
    /// Distance of rows by edge.
    pub(crate) fn height(self) -> f64 {
        match self {
            Self::Equilateral => 0.75_f64.sqrt(),
            Self::Grid => 1.0,
        }
    }
}

impl Sheet {
    /// Edges along x, rows of triangles along z: the nearest whole numbers, at least one.
    pub(crate) fn counts(&self) -> [u64; 2] {
        let whole = |length: f64, each: f64| ((length / each).round() as u64).max(1);
        [whole(self.size[0], self.edge), whole(self.size[1], self.edge * self.pattern.height())]
    }

    /// Number of nodes.
    pub(crate) fn nodes(&self) -> u64 {
        let [along, rows] = self.counts();
        let shifted = match self.pattern {
            Pattern::Equilateral => rows / 2 + rows % 2,
            Pattern::Grid => 0,
        };
        rows.saturating_add(1).saturating_mul(along.saturating_add(1)).saturating_add(shifted)
    }
}

/// Rows of a disc at either side of its middle that are counted one by one. A disc with more has too many nodes.
const COUNTED_ROWS: f64 = 1e5;

impl Disc {
    /// Radius in edges within which the pattern is laid.
    pub(crate) fn core(&self) -> f64 {
        self.radius / self.edge - 0.5
    }

    /// Rows of the pattern at either side of the middle one.
    pub(crate) fn rows(&self) -> i64 {
        (self.core() / self.pattern.height()) as i64
    }

    /// Number of nodes in a row of the pattern, which lie symmetrically about its middle, an edge apart.
    pub(crate) fn in_row(&self, row: i64) -> u64 {
        let (radius, row) = (self.core(), row as f64);
        let half = |z: f64| (radius * radius - z * z).max(0.0).sqrt();
        match self.pattern {
            Pattern::Equilateral if row % 2.0 != 0.0 => 2 * (half(row * self.pattern.height()) + 0.5) as u64,
            Pattern::Equilateral => 2 * half(row * self.pattern.height()) as u64 + 1,
            // Nodes of whole squares: the middle row has those of the rows beside it, the last ones need a square, too.
            Pattern::Grid => match half(row.abs().max(1.0)) as u64 {
                0 => 0,
                half => 2 * half + 1,
            },
        }
    }

    /// Number of nodes on the border.
    pub(crate) fn rim(&self) -> u64 {
        (std::f64::consts::TAU * self.radius / self.edge).round() as u64
    }

    /// Number of nodes.
    pub(crate) fn nodes(&self) -> u64 {
        let core = self.core();
        if core > COUNTED_ROWS {
            return (std::f64::consts::PI * core * core / self.pattern.height()) as u64;
        }
        let rows = self.rows();
        (-rows..=rows).map(|row| self.in_row(row)).sum::<u64>() + self.rim()
    }
}
