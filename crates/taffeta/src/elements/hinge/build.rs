//! The hinges of a body: one at each edge that two triangles share.

use crate::assembly::body::BodyAssembly;
use crate::elements::element::Described;
use crate::elements::hinge::hinge::{Rest, rest};
use crate::scene::Scene;
use crate::topology::{Edges, RestShape, Surface};

/// The hinges of a body, if they would do anything.
pub fn hinges(body: &BodyAssembly, scene: &Scene, index: usize) -> Described {
    let mut all = Described::default();
    let Some(hinge) = scene.bodies[index].springs.hinge.filter(|hinge| hinge.k > 0.0 || hinge.d > 0.0) else {
        return all;
    };
    let mut add = |nodes: [u32; 4], Rest { angle, steepness }: Rest<f64>| {
        all.push(&nodes, &[angle, steepness, hinge.k, hinge.d]);
    };
    let at_start = |nodes: [u32; 4]| rest(nodes.map(|node| body.start[node as usize]));
    if let (Some(surface), Some(edges)) = (&body.surface, &body.edges) {
        let shape = RestShape::of(surface, body.placement.factor);
        let hinges = in_solver_order(body, edges, surface);
        if shape.is_given() {
            hinges.zip(shape.hinges(edges)).for_each(|(nodes, places)| add(nodes, rest(places)));
        } else {
            hinges.for_each(|nodes| add(nodes, at_start(nodes)));
        }
    } else {
        let surface = body.user_surface();
        let edges = Edges::new(surface.nodes.len(), &surface.triangles, &surface.links);
        in_solver_order(body, &edges, &surface).for_each(|nodes| add(nodes, at_start(nodes)));
    }
    all
}

/// The corners `[a, b, left, right]` of each hinge.
fn in_solver_order(body: &BodyAssembly, edges: &Edges, surface: &Surface) -> impl Iterator<Item = [u32; 4]> {
    let hinges = edges.hinges(&surface.triangles).into_iter();
    hinges.map(|corners| corners.map(|node| body.solver_local(node as usize) as u32))
}
