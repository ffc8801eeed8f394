//! Colliders as triangles.

use crate::contact::colliders::moving::MovingCollider;

/// Triangles of a box, whose corner number k lies towards +x, +y, +z where bits 0, 1, 2 of k are set.
const BOX: [[u32; 3]; 12] = [
    [0, 2, 1],
    [1, 2, 3],
    [4, 5, 6],
    [5, 7, 6],
    [0, 1, 4],
    [1, 5, 4],
    [2, 6, 3],
    [3, 6, 7],
    [0, 4, 2],
    [2, 4, 6],
    [1, 3, 5],
    [3, 7, 5],
];

impl MovingCollider {
    /// Its triangles; `None` where it has none.
    pub fn faces(&self) -> Option<&[[u32; 3]]> {
        match self.mesh() {
            Some(mesh) => Some(&mesh.triangles),
            None => self.box_corners().map(|_| &BOX[..]),
        }
    }

    /// The corners of its triangles [m] at time `t` [s].
    pub fn corners(&self, t: f64) -> Vec<[f64; 3]> {
        let corners = match self.mesh() {
            Some(mesh) => mesh.nodes(t),
            None => self.box_corners().map_or_else(Vec::new, Vec::from),
        };
        let pose = self.track().pose(t);
        corners.into_iter().map(|x| pose.apply(x)).collect()
    }
}
