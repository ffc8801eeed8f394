//! Whether a surface given as data is one.

use crate::real::area;
use crate::scene::{Polygons, Surface};

/// Most nodes of a mesh, and half the most triangles: three corners each must be countable in 32 bits.
pub(crate) const MESH_NODES: u64 = 1 << 29;

/// Checks that every index of a surface has something to point at, places are finite and triangles have an area.
pub(crate) fn check_surface(surface: &Surface) -> Result<(), String> {
    let [vertices, nodes] = [surface.vertices.len(), surface.nodes.len()];
    if nodes == 0 || surface.triangles.is_empty() && surface.links.is_empty() {
        return Err("has no triangles and no links; one or more would do".into());
    }
    if nodes.max(vertices).max(surface.triangles.len() / 2) as u64 > MESH_NODES {
        return Err(format!("has {nodes} nodes, {vertices} vertices; {MESH_NODES} are the limit"));
    }
    finite("vertex", &surface.vertices)?;
    finite("node", &surface.nodes)?;
    in_range("link", &surface.links, nodes)?;
    in_range("triangle", &surface.triangles, nodes)?;
    let areas = surface.triangles.iter().map(|t| area(t.map(|node| surface.nodes[node as usize])));
    if let Some((t, area)) = areas.enumerate().find(|(_, area)| !area.is_normal()) {
        return Err(format!("triangle {t} has an area of {area} m²; three corners apart would do"));
    }
    check_rest(surface)?;
    check_vertices(surface)?;
    check_faces(&surface.polygons, vertices)
}

/// Refuses a shape at rest that is not one of these triangles, or has some without an area.
fn check_rest(surface: &Surface) -> Result<(), String> {
    let (Some(rest), count) = (&surface.rest, surface.triangles.len()) else { return Ok(()) };
    if rest.len() != count {
        let have = rest.len();
        return Err(format!("has {count} triangles, but rest places for {have}; three for each would do"));
    }
    for (t, corners) in rest.iter().enumerate() {
        if corners.iter().flatten().any(|x| !x.is_finite()) {
            return Err(format!("triangle {t} is at {corners:?} at rest, finite numbers would do"));
        }
        let area = area(*corners);
        if !area.is_normal() {
            return Err(format!(
                "triangle {t} has an area of {area} m² at rest; three corners apart would do"
            ));
        }
    }
    Ok(())
}

fn finite(what: &str, points: &[[f64; 3]]) -> Result<(), String> {
    match points.iter().position(|p| p.iter().any(|x| !x.is_finite())) {
        Some(i) => Err(format!("{what} {i} is at {:?}, finite numbers would do", points[i])),
        None => Ok(()),
    }
}

/// Refuses elements with a node that does not exist, or twice the same.
fn in_range<const N: usize>(what: &str, elements: &[[u32; N]], nodes: usize) -> Result<(), String> {
    for (i, element) in elements.iter().enumerate() {
        if let Some(node) = element.iter().find(|node| **node as usize >= nodes) {
            return Err(format!("{what} {i} has node {node}, 0 to {} would do", nodes - 1));
        }
        if (1..N).any(|k| element[..k].contains(&element[k])) {
            return Err(format!("{what} {i} has a node twice: {element:?}; different ones would do"));
        }
    }
    Ok(())
}

/// Refuses vertices without a node of their own, or with one that does not exist, and groups of such vertices.
fn check_vertices(surface: &Surface) -> Result<(), String> {
    let [vertices, nodes] = [surface.vertices.len(), surface.nodes.len()];
    let listed = surface.node_of_vertex.as_ref();
    let have = listed.map_or(nodes, Vec::len);
    if have != vertices {
        return Err(format!("has {vertices} vertices, but nodes for {have}; one for each would do"));
    }
    let strays = listed.and_then(|list| list.iter().position(|n| *n != u32::MAX && *n as usize >= nodes));
    if let Some(vertex) = strays {
        return Err(format!("vertex {vertex} has a node beyond the last, 0 to {} would do", nodes - 1));
    }
    for (name, members) in &surface.groups {
        if let Some(vertex) = members.iter().find(|v| **v as usize >= vertices) {
            return Err(format!("group `{name}` has vertex {vertex}, 0 to {} would do", vertices - 1));
        }
    }
    Ok(())
}

fn check_faces(polygons: &Polygons, vertices: usize) -> Result<(), String> {
    let ends =
        [polygons.offsets.first(), polygons.offsets.last()].map(|end| end.map_or(0, |end| *end as usize));
    if ends != [0, polygons.corners.len()] || !polygons.offsets.is_sorted() {
        return Err("face offsets do not ascend from 0 to the number of corners".into());
    }
    match polygons.corners.iter().find(|v| **v as usize >= vertices) {
        Some(vertex) => {
            Err(format!("a face has vertex {vertex}, 0 to {} would do", vertices.saturating_sub(1)))
        }
        None => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_surface_given_as_data_is_not_trusted() {
        let nodes = [[0.0, 0.0], [1.0, 0.0], [0.0, 1.0], [1.0, 1.0]].map(|[x, z]| [x, 0.0, z]).to_vec();
        let mut good = Surface::of_triangles(nodes, vec![[0, 1, 2], [2, 1, 3]]);
        good.polygons = Polygons::default();
        good.polygons.push(&[0, 1, 3, 2]);
        assert!(check_surface(&good).is_ok());
        let broken = |change: &dyn Fn(&mut Surface), words: &str| {
            let mut surface = good.clone();
            change(&mut surface);
            let message = check_surface(&surface).unwrap_err();
            assert!(message.contains(words), "{message}");
        };
        broken(&|s| s.triangles[1][2] = 4, "triangle 1 has node 4, 0 to 3");
        broken(&|s| s.triangles[0] = [0, 1, 1], "a node twice");
        broken(&|s| s.nodes[3] = s.nodes[1], "triangle 1 has an area of 0 m²");
        broken(&|s| s.nodes[2][1] = f64::INFINITY, "node 2 is at");
        broken(&|s| s.node_of_vertex = Some(vec![0, 1, 9, u32::MAX]), "vertex 2");
        broken(&|s| s.node_of_vertex = Some(vec![0]), "nodes for 1");
        broken(&|s| s.groups.push(("hem".into(), vec![4])), "group `hem` has vertex 4");
        broken(&|s| s.polygons.corners[0] = 7, "vertex 7");
        broken(&|s| s.polygons.offsets[1] = 9, "offsets");
        broken(&|s| s.triangles.clear(), "no triangles");
        let corners = [[0.0; 3], [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]];
        let rest = |s: &mut Surface, second| s.rest = Some(vec![corners, second]);
        broken(&|s| s.rest = Some(vec![[[0.0; 3]; 3]]), "rest places for 1; three for each");
        broken(&move |s| rest(s, [[0.0; 3], [f64::NAN; 3], [1.0; 3]]), "triangle 1 is at");
        broken(&move |s| rest(s, [[0.0; 3], [1.0; 3], [2.0; 3]]), "triangle 1 has an area of 0 m² at rest");
    }
}
