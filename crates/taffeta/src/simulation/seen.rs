//! Quantities of vertices that a program may display: velocities, and distances from colliders.

use crate::assembly::body::BodyAssembly;
use crate::contact::collider_mesh::surface::MeshSurface;
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::shape::ShapeNow;
use crate::simulation::Simulation;

impl Simulation {
    /// Velocities of all vertices [m/s], bodies one after the other, in the meshes' own order; none has what no face uses.
    /// `out` is cleared first.
    pub fn velocities_f32<V: From<[f32; 3]>>(&self, out: &mut Vec<V>) {
        out.clear();
        let velocity = |node: usize| self.backend.velocity(node).map(|c| c as f32);
        self.each_vertex(|node| out.push(node.map_or([0.0; 3], velocity).into()));
    }

    /// Distances of all vertices from colliders [m] at the end of the last frame, less the colliders' offsets: 0 in
    /// contact, below 0 inside, `reach` if nothing is nearer. Vertices come as in [`Self::positions_f32`]. `out` is
    /// cleared first.
    pub fn collider_distances(&self, reach: f64, out: &mut Vec<f32>) {
        out.clear();
        let assembly = self.backend.assembly();
        let surfaces = self.surfaces.get_or_init(|| {
            assembly.colliders().iter().filter_map(|one| one.mesh()).map(|mesh| mesh.surface()).collect()
        });
        let (now, dt, mut meshes) = (f64::from(self.frame()) * self.dt(), self.dt(), 0);
        let at_end =
            |one: &crate::contact::colliders::moving::MovingCollider| one.at(now - dt, dt, &mut meshes);
        let colliders: Vec<ColliderNow<f64>> = assembly.colliders().iter().map(at_end).collect();
        let distance = |x: [f64; 3]| {
            let distances = colliders.iter().map(|collider| distance_of(collider, surfaces, x, reach));
            distances.fold(reach, f64::min) as f32
        };
        self.each_vertex(|node| {
            out.push(node.map_or(reach as f32, |node| distance(self.backend.position(node))))
        });
    }

    /// Calls `sink` with the node of each vertex, by solver index; `None` for one that no face uses.
    fn each_vertex(&self, mut sink: impl FnMut(Option<usize>)) {
        for body in &self.backend.assembly().bodies {
            let node = |body: &BodyAssembly, vertex| Some(body.solver_index(body.node_of_vertex(vertex)?));
            (0..body.vertices()).for_each(|vertex| sink(node(body, vertex)));
        }
    }
}

/// Distance of a position from a collider with its offset [m].
fn distance_of(collider: &ColliderNow<f64>, surfaces: &[MeshSurface<f64>], x: [f64; 3], reach: f64) -> f64 {
    match &collider.shape {
        ShapeNow::Mesh(mesh) => {
            let within = reach + mesh.offset;
            let depth = surfaces[mesh.index as usize].depth(mesh, mesh.local(x), within * within);
            depth.map_or(reach, |depth| -depth)
        }
        _ => collider.depth_and_normal(x).map_or(reach, |(depth, _)| -depth),
    }
}
