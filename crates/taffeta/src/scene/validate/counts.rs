//! What 32 bits must count, over the whole scene.

use crate::real::LANES;
use crate::scene::validate::path::{Checked, Path};
use crate::scene::{Body, Mesh, Scene};
use std::collections::BTreeMap;

/// Most nodes of all bodies, each body's rounded up to whole vectors: an index is a signed 32-bit number.
const NODES: u64 = i32::MAX as u64;
/// Most nodes of one mesh that bodies collide with.
pub(crate) const MOST_NODES: u64 = 1 << 26;
/// Most elements of one kind of all bodies: four corners each.
const ELEMENTS: u64 = 1 << 30;
/// Most struts of a body: both ends, and what pads them.
const STRUTS: u64 = 1 << 28;

/// Refuses a scene with more of anything than can be numbered.
pub(crate) fn check(scene: &Scene) -> Checked {
    let mut nodes = 0_u64;
    let mut elements = BTreeMap::new();
    for (index, body) in scene.bodies.iter().enumerate() {
        let path = Path::item("body", index);
        nodes = nodes.saturating_add(body.mesh.nodes().next_multiple_of(LANES as u64));
        path.key("mesh").demand(nodes <= NODES, || {
            format!("brings the scene to {nodes} nodes, {NODES} are the limit; coarser meshes would do")
        })?;
        for kind in body.elements() {
            let all: &mut u64 = elements.entry(kind.key).or_default();
            *all = all.saturating_add(edges_of(body));
            path.key(kind.key).demand(*all <= ELEMENTS, || {
                format!(
                    "brings the scene to about {all} elements of this kind, {ELEMENTS} are the limit; a coarser mesh \
                     would do"
                )
            })?;
        }
        let struts = body.springs.internal.as_ref().map_or(0, |wish| u64::from(wish.count));
        path.key("springs")
            .key("internal")
            .demand(struts <= STRUTS, || format!("has a count of {struts}, {STRUTS} struts are the limit"))?;
    }
    Ok(())
}

/// Number of edges, to within a border: half as many again as triangles. No kind has more elements.
fn edges_of(body: &Body) -> u64 {
    match &body.mesh {
        Mesh::Surface(surface) => surface.triangles.len() as u64 * 3 / 2,
        mesh => mesh.nodes().saturating_mul(3),
    }
}
