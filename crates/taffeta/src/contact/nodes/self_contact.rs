//! How a body's nodes touch each other, and which do not.

use crate::contact::nodes::pair::ContactMaterial;
use crate::topology::Csr;

/// Contact of a body's nodes with each other, and with those of others.
#[derive(Clone, Debug)]
pub struct SelfContact {
    /// Thickness [m], friction, restitution.
    pub surface: ContactMaterial<f64>,
    /// Nodes of the same body that do not touch.
    pub exclusions: Exclusions,
    /// The longest edge [m].
    pub(crate) longest: f64,
}

/// Nodes that are too near along the surface to touch: those that share a spring, and those nearer than the way around a
/// fold whose layers touch, which is π/2 times the thickness.
#[derive(Clone, Debug)]
pub enum Exclusions {
    /// Of a grid: rows and columns from one to the other.
    Grid(Vec<[i32; 2]>),
    /// Of a mesh, by node, in solver order within the body.
    Mesh(Csr),
}

/// Thickness by the distance of neighbouring nodes below which a node of one sheet fits between those of another: half the
/// diagonal of a square.
pub(crate) const GAP: f64 = 0.71;

impl SelfContact {
    /// Length by rest length of its longest edge from which on nodes of another layer slip between its own.
    pub fn slips_from(&self) -> f64 {
        self.surface.thickness / (GAP * self.longest)
    }
}

impl Exclusions {
    /// Hands over the nodes that do not touch the node `local` of its body, of a grid of these rows and columns.
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
