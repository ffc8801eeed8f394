//! Self-collision of a body: its material and its exclusion lists.

use crate::assembly::body::BodyAssembly;
use crate::contact::nodes::pair::ContactMaterial;
use crate::topology::Csr;

/// Self-collision of a body, and its collision with other bodies that have it.
#[derive(Clone, Debug)]
pub struct SelfContact {
    /// Thickness [m], friction, restitution.
    pub surface: ContactMaterial<f64>,
    /// Nodes of the same body that do not collide.
    pub exclusions: Exclusions,
    /// The longest edge [m].
    pub(crate) longest: f64,
}

/// Exclusion lists: pairs of nodes that are too close along the surface to collide. They share a spring, or they are
/// closer than the length of a fold whose layers are in contact, which is π/2 times the thickness.
#[derive(Clone, Debug)]
pub enum Exclusions {
    /// For a grid: offsets in rows and columns.
    Grid(Vec<[i32; 2]>),
    /// For a mesh: by node, in solver order within the body.
    Mesh(Csr),
}

/// Thickness relative to the distance of neighbouring nodes below which a node of one sheet fits between those of
/// another: half the diagonal of a square.
pub(crate) const GAP: f64 = 0.71;

impl BodyAssembly {
    /// Contact of its nodes with each other, and with those of other bodies that have this.
    pub fn self_contact(&self) -> Option<&SelfContact> {
        self.extensions.get()
    }
}

impl SelfContact {
    /// Stretch of its longest edge from which nodes of another layer can pass between its own.
    pub fn slips_from(&self) -> f64 {
        self.surface.thickness / (GAP * self.longest)
    }
}

impl Exclusions {
    /// Calls `take` with each node on the exclusion list of the node `local`, on a grid of these rows and columns.
    pub fn each(&self, layout: Option<[usize; 2]>, local: usize, mut take: impl FnMut(usize)) {
        match (self, layout) {
            (Self::Mesh(rows), _) => rows.row(local).iter().for_each(|&node| take(node as usize)),
            (Self::Grid(ways), Some([rows, cols])) => {
                let (row, col) = ((local / cols) as i64, (local % cols) as i64);
                for way in ways {
                    let (row, col) = (row + i64::from(way[0]), col + i64::from(way[1]));
                    if (0..rows as i64).contains(&row) && (0..cols as i64).contains(&col) {
                        take(row as usize * cols + col as usize);
                    }
                }
            }
            (Self::Grid(_), None) => {}
        }
    }
}
