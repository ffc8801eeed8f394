//! Quantities of vertices that a program may display: velocities, normals, and distances from colliders.

use crate::assembly::body::BodyAssembly;
use crate::contact::collider_mesh::surface::MeshSurface;
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::shape::ShapeNow;
use crate::diagnostics::normals::normals;
use crate::real::Real;
use crate::simulation::{BodyHandle, InputError, Precision, Simulation};

impl Simulation {
    /// Velocities of all vertices [m/s], bodies one after the other, in the meshes' own order; none has what no face uses.
    /// `out` is cleared first.
    pub fn velocities_f32<V: From<[f32; 3]>>(&self, out: &mut Vec<V>) {
        out.clear();
        let velocity = |node: usize| self.backend.velocity(node).map(|c| c as f32);
        self.each_vertex(|node| out.push(node.map_or([0.0; 3], velocity).into()));
    }

    /// As [`Self::velocities_f32`], in 64 bits.
    pub fn velocities_f64<V: From<[f64; 3]>>(&self, out: &mut Vec<V>) {
        out.clear();
        let velocity = |node: usize| self.backend.velocity(node);
        self.each_vertex(|node| out.push(node.map_or([0.0; 3], velocity).into()));
    }

    /// Unit normals of a body's vertices, area-weighted, in 64 bits; where the run has 32, with their digits.
    ///
    /// # Errors
    /// Where the body is one of another simulation.
    pub fn normals_f64<V: From<[f64; 3]>>(&self, body: BodyHandle) -> Result<Vec<V>, InputError> {
        if self.precision == Precision::F32 {
            let normals = self.normals::<[f32; 3]>(body)?;
            return Ok(normals.into_iter().map(|normal| normal.map(f64::from).into()).collect());
        }
        let body = &self.backend.assembly().bodies[self.index_of(body)?];
        let places: Vec<[f64; 3]> =
            (0..body.nodes).map(|node| self.backend.position(body.solver_index(node))).collect();
        let of_nodes = normals(&places, &body.user_surface().triangles);
        let of_vertex = |vertex| body.node_of_vertex(vertex).map_or([0.0, 1.0, 0.0], |node| of_nodes[node]);
        Ok((0..body.vertices()).map(|vertex| of_vertex(vertex).into()).collect())
    }

    /// Distances of all vertices from the colliders that they meet [m] at the end of the last frame, less the colliders' offsets:
    /// 0 in contact, below 0 inside, `reach` if nothing is nearer. Vertices come as in [`Self::positions_f32`]. `out` is
    /// cleared first.
    pub fn collider_distances(&self, reach: f64, out: &mut Vec<f32>) {
        out.clear();
        let (colliders, surfaces) = self.colliders_at(f64::from(self.frame()) * self.dt());
        let assembly = self.backend.assembly();
        for (index, body) in assembly.bodies.iter().enumerate() {
            let met = |&(collider, _): &(usize, _)| assembly.meetings().collider(index, collider);
            let met: Vec<&ColliderNow<f64>> =
                colliders.iter().enumerate().filter(met).map(|(_, collider)| collider).collect();
            let distance = |node: usize| {
                let x = self.backend.position(body.solver_index(node));
                let distances = met.iter().map(|collider| distance_of(collider, surfaces, x, reach));
                distances.fold(reach, f64::min) as f32
            };
            let of_vertex = |vertex| body.node_of_vertex(vertex).map_or(reach as f32, distance);
            out.extend((0..body.vertices()).map(of_vertex));
        }
    }

    /// The colliders that are nearest to a node at a time [s], of those that it meets, nearest first: at most `count`, by their
    /// number in the scene.
    pub(super) fn nearest_colliders(&self, node: usize, time: f64, count: usize) -> Vec<usize> {
        self.nearest_to(self.backend.position(node), node, time, count)
    }

    /// The same if the node were elsewhere [m].
    fn nearest_to(&self, place: [f64; 3], node: usize, time: f64, count: usize) -> Vec<usize> {
        let (colliders, surfaces) = self.colliders_at(time);
        let distance = |collider| distance_of(collider, surfaces, place, f64::FAR);
        let distances: Vec<f64> = colliders.iter().map(distance).collect();
        let assembly = self.backend.assembly();
        let body = assembly.number_of_body(node as u32);
        let met = |&collider: &usize| assembly.meetings().collider(body, collider);
        let mut nearest: Vec<usize> = (0..distances.len()).filter(met).collect();
        nearest.sort_by(|&a, &b| distances[a].total_cmp(&distances[b]));
        nearest.truncate(count);
        nearest
    }

    /// The colliders as they are at a time [s], and the triangles of those that are meshes.
    fn colliders_at(&self, time: f64) -> (Vec<ColliderNow<f64>>, &[MeshSurface<f64>]) {
        self.colliders_after([time - self.dt(), time])
    }

    /// The colliders at the end of a span of time [s], having moved since its start, and the triangles of those that are meshes.
    pub(super) fn colliders_after(
        &self,
        [from, to]: [f64; 2],
    ) -> (Vec<ColliderNow<f64>>, &[MeshSurface<f64>]) {
        let all = self.backend.assembly().colliders();
        let surfaces = self
            .surfaces
            .get_or_init(|| all.iter().filter_map(|one| one.mesh()).map(|mesh| mesh.surface()).collect());
        let mut meshes = 0;
        (all.iter().map(|one| one.at(from, to - from, &mut meshes)).collect(), surfaces)
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
pub(super) fn distance_of(
    collider: &ColliderNow<f64>,
    surfaces: &[MeshSurface<f64>],
    x: [f64; 3],
    reach: f64,
) -> f64 {
    match &collider.shape {
        ShapeNow::Mesh(mesh) => {
            let within = reach + mesh.offset;
            let depth = surfaces[mesh.index as usize].depth(mesh, mesh.local(x), within * within);
            depth.map_or(reach, |depth| -depth)
        }
        _ => collider.depth_and_normal(x).map_or(reach, |(depth, _)| -depth),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Options;
    use crate::scene::{Body, Collider, Icosphere, Keyframe, Mass, Mesh, Place, Scene};

    #[test]
    fn in_64_bits_velocities_and_normals_have_their_digits() {
        let turned = Place {
            rotation: Some(crate::scene::Rotation { axis: [1.0, 0.0, 0.0], degrees: 30.0 }),
            ..Place::default()
        };
        let sheet = Body::cloth("sheet", Mesh::grid(3, 3, [0.1, 0.1])).with_mass(Mass::Node(0.1));
        let sheet = Body { place: turned, velocity: [0.1, 0.0, 0.0], ..sheet.structural(1.0, 0.0) };
        let scene = Scene::new("turned").body(sheet);
        let simulation =
            Simulation::new(&scene, &Options { precision: Precision::F64, ..Options::default() }).unwrap();
        let mut velocities: Vec<[f64; 3]> = Vec::new();
        simulation.velocities_f64(&mut velocities);
        assert_eq!(velocities, [[0.1, 0.0, 0.0]; 9]);
        let normals: Vec<[f64; 3]> = simulation.normals_f64(simulation.bodies()[0].handle).unwrap();
        for [x, y, z] in normals {
            assert!(x.abs() < 1e-14 && (y - 0.75_f64.sqrt()).abs() < 1e-14 && (z - 0.5).abs() < 1e-14);
        }
    }

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
        let simulation = Simulation::new(&scene, &Options::default()).unwrap();
        assert_eq!(simulation.nearest_to([0.0; 3], 0, 0.0, 2), [1, 0]);
        assert_eq!(simulation.nearest_to([0.0; 3], 0, 1.0, 3), [2, 1, 0]);
    }
}
