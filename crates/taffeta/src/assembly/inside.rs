//! Nodes that start inside colliders.

use super::Assembly;
use crate::collision::mesh::MeshSurface;
use crate::collision::moving::ColliderNow;
use crate::collision::shape::ShapeNow;
use crate::real::Real;
use crate::scene::Scene;
use std::collections::HashSet;

/// Deeper than this a node is inside [m]: less is rounding.
const ROUNDING: f64 = 1e-9;

/// A collider at the start.
struct Start {
    now: ColliderNow<f64>,
    /// Its triangles, if it has some.
    surface: Option<MeshSurface<f64>>,
    offset: f64,
}

impl Assembly {
    /// Warns of free nodes that start inside colliders: they are put on the surface at once, whatever that stretches. What a
    /// collider carries is left alone.
    pub(super) fn note_starts_inside(&mut self, scene: &Scene) {
        let mut meshes = 0;
        let attached = &self.attachments;
        let rows = attached.rows.iter().filter(|row| attached.is_carried(row));
        let carried: HashSet<usize> = rows.map(|row| row.ends[0] as usize).collect();
        for (index, (collider, described)) in self.colliders.iter().zip(&scene.colliders).enumerate() {
            let surface = collider.mesh().map(|mesh| mesh.surface());
            let start = Start { now: collider.at(-1.0, 1.0, &mut meshes), surface, offset: described.offset };
            for body in &mut self.bodies {
                let depth = |local: usize| {
                    let meets = body.free[local] && !carried.contains(&(body.first + local));
                    if meets { start.depth(body.start[local]) } else { 0.0 }
                };
                let deep = (0..body.nodes).map(|local| (local, depth(local)));
                let inside: Vec<(usize, f64)> = deep.filter(|&(_, depth)| depth > ROUNDING).collect();
                let Some(worst) = inside.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else { continue };
                let nodes = if inside.len() == 1 { "node starts" } else { "nodes start" };
                let words = format!(
                    "{} {nodes} inside collider `{}`, worst of all vertex {}, {:.3e} m deep; what starts inside is put on the \
                     surface at once, and springs that are stretched by it throw the body: another place would do",
                    inside.len(),
                    scene.collider_name(index),
                    body.vertex_of_solver(worst.0),
                    worst.1
                );
                body.warnings.push(words);
            }
        }
    }
}

impl Start {
    /// How deep a place is behind the surface itself [m]; nothing is behind a sheet.
    fn depth(&self, x: [f64; 3]) -> f64 {
        let depth = match (&self.now.shape, &self.surface) {
            (ShapeNow::Mesh(mesh), Some(surface)) => {
                let place = mesh.local(x);
                let is_within = surface.solid && !surface.tree(mesh).is_outside(place);
                let depth = if is_within { surface.depth(mesh, place, f64::FAR) } else { None };
                depth.map(|depth| depth - mesh.offset)
            }
            _ => self.now.depth_and_normal(x).map(|(depth, _)| depth - self.offset),
        };
        depth.unwrap_or(0.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, Collider, Icosphere, Mass, Mesh};

    /// What a level sheet of 3 × 3 nodes and 1 m is told on a collider.
    fn told(y: f64, collider: Collider) -> String {
        let sheet = Body::cloth("sheet", Mesh::grid(3, 3, [1.0, 1.0])).with_mass(Mass::Node(0.1));
        let scene =
            Scene::new("inside").body(sheet.structural(1.0, 0.0).at([0.0, y, 0.0])).collider(collider);
        Assembly::new(&scene).unwrap().bodies[0].warnings.join("\n")
    }

    #[test]
    fn nodes_that_start_inside_are_counted_and_the_deepest_is_named() {
        let icosphere = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 3 });
        let shapes = [
            Collider::sphere([0.0; 3], 0.5),
            Collider::mesh(icosphere.clone()).named("ball"),
            Collider::convex(icosphere),
        ];
        for collider in shapes {
            let name = if collider.name.is_empty() { "collider0" } else { "ball" };
            let words = told(0.3, collider.clone().offset(0.01));
            let start = format!("1 node starts inside collider `{name}`, worst of all vertex 4, ");
            let depth = words.strip_prefix(&start).and_then(|rest| rest.split(' ').next()).unwrap();
            assert!((depth.parse::<f64>().unwrap() - 0.2).abs() < 5e-3, "{words}");
            assert_eq!(told(0.505, collider.offset(0.01)), "");
        }
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.01);
        assert_eq!(told(0.0, floor.clone()), "");
        assert!(told(-0.25, floor).starts_with("9 nodes start inside collider `collider0`, worst"));
    }

    #[test]
    fn nothing_is_inside_a_sheet_and_held_nodes_may_be_anywhere() {
        assert_eq!(told(0.0, Collider::mesh(Mesh::grid(2, 2, [2.0, 2.0])).offset(0.1)), "");
        let held = Body::cloth("sheet", Mesh::grid(2, 2, [0.1, 0.1]))
            .with_mass(Mass::Node(0.1))
            .structural(1.0, 0.0)
            .pin(crate::scene::Select::nodes([0, 1, 2, 3]));
        let scene = Scene::new("held").body(held).collider(Collider::sphere([0.0; 3], 0.5));
        assert!(Assembly::new(&scene).unwrap().bodies[0].warnings.is_empty());
    }
}
