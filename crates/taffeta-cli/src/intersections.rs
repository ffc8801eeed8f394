//! Where a scene's surfaces pass through each other, as far as that is found within a moment.

use taffeta::scene::Scene;
use taffeta::{Intersections, Simulation};

/// Triangles up to which they are counted unasked. It takes a second for so many.
const FEW: usize = 200_000;

/// Counts them; nothing where there are no triangles, or very many.
pub fn counted(simulation: &Simulation) -> Option<Intersections> {
    let of_bodies: usize = simulation.bodies().iter().map(|body| body.triangles).sum();
    let of_colliders: usize =
        simulation.colliders().iter().filter_map(|collider| collider.surface).map(|(count, _)| count).sum();
    (of_bodies > 0 && of_bodies + of_colliders <= FEW).then(|| simulation.intersections())
}

/// Whether contact keeps all surfaces apart, and pulls apart what starts through each other.
pub fn are_kept_out(scene: &Scene, simulation: &Simulation) -> bool {
    let mut bodies = scene.bodies.iter().zip(simulation.bodies());
    bodies.all(|(body, info)| info.triangles == 0 || body.has_surface_contact())
}
