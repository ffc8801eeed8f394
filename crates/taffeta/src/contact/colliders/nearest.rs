//! Which colliders are near a place.

use crate::assembly::Assembly;
use crate::contact::colliders::moving::MovingCollider;
use crate::contact::colliders::start::Depth;
use crate::real::Real;

impl Assembly {
    /// The colliders that are nearest to a place [m] at a time [s], nearest first: at most `count`, by their number in the scene.
    pub(crate) fn nearest_colliders(&self, place: [f64; 3], time: f64, count: usize) -> Vec<usize> {
        let mut meshes = 0;
        let depth = |collider| Depth::of(collider, time, &mut meshes).within(f64::FAR).at(place);
        let depths: Vec<f64> = self.extensions.list::<MovingCollider>().iter().map(depth).collect();
        let mut nearest: Vec<usize> = (0..depths.len()).collect();
        nearest.sort_by(|&a, &b| depths[b].total_cmp(&depths[a]));
        nearest.truncate(count);
        nearest
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Place, Scene};

    #[test]
    fn the_nearest_colliders_come_first_whatever_their_shape_and_wherever_they_go() {
        let ball = Collider::mesh(Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 }))
            .placed(Place { position: [0.0, 3.0, 0.0], ..Place::default() });
        let moves =
            Collider::sphere([0.0, -9.0, 0.0], 0.5).keyframe(Keyframe::translate(1.0, [0.0, 7.0, 0.0]));
        let sheet = Body::cloth("sheet", Mesh::grid(3, 3, [0.1, 0.1])).with_mass(Mass::Node(0.1));
        let scene = Scene::new("near")
            .body(sheet.structural(1.0, 0.0))
            .collider(Collider::sphere([0.0, 5.0, 0.0], 0.5))
            .collider(ball)
            .collider(moves);
        let assembly = Assembly::new(&scene).unwrap();
        assert_eq!(assembly.nearest_colliders([0.0; 3], 0.0, 2), [1, 0]);
        assert_eq!(assembly.nearest_colliders([0.0; 3], 1.0, 3), [2, 1, 0]);
    }
}
