//! What 32 bits must count, over the whole scene.

use crate::real::LANES;
use crate::scene::validate::path::{Checked, Path};
use crate::scene::{Body, Mesh, Scene};

/// Most nodes of all bodies, each body's rounded up to whole vectors: an index is a signed 32-bit number.
const NODES: u64 = i32::MAX as u64;
/// Most nodes of one mesh that bodies collide with.
pub(crate) const MOST_NODES: u64 = 1 << 26;
/// Most hinges of all bodies: four corners each.
const HINGES: u64 = 1 << 30;
/// Most struts of a body: both ends, and what pads them.
const STRUTS: u64 = 1 << 28;

/// Refuses a scene with more of anything than can be numbered.
pub(crate) fn check(scene: &Scene) -> Checked {
    let (mut nodes, mut hinges) = (0_u64, 0_u64);
    for (index, body) in scene.bodies.iter().enumerate() {
        let path = Path::item("body", index);
        nodes = nodes.saturating_add(body.mesh.nodes().next_multiple_of(LANES as u64));
        path.key("mesh").demand(nodes <= NODES, || {
            format!("brings the scene to {nodes} nodes, {NODES} are the limit; coarser meshes would do")
        })?;
        hinges = hinges.saturating_add(hinges_of(body));
        path.key("springs").key("hinge").demand(hinges <= HINGES, || {
            format!(
                "brings the scene to about {hinges} hinges, {HINGES} are the limit; a coarser mesh or bend springs \
                 would do"
            )
        })?;
        let struts = body.springs.internal.as_ref().map_or(0, |wish| u64::from(wish.count));
        path.key("springs")
            .key("internal")
            .demand(struts <= STRUTS, || format!("has a count of {struts}, {STRUTS} struts are the limit"))?;
    }
    Ok(())
}

/// Number of hinges, to within a border: half as many again as triangles.
fn hinges_of(body: &Body) -> u64 {
    if body.springs.hinge.is_none() {
        return 0;
    }
    match &body.mesh {
        Mesh::Surface(surface) => surface.triangles.len() as u64 * 3 / 2,
        mesh => mesh.nodes().saturating_mul(3),
    }
}
