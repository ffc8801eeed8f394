//! The triangles around each node of a closed surface, as the way around it through its neighbours.

use crate::assembly::body::{BodyAssembly, BodySprings};
use crate::assembly::springs::SpringKind;
use crate::assembly::springs::SpringList;
use crate::topology::{Csr, Gather, LANES};

/// In [`Gather::rest`]: a neighbour on the way around a node, without a spring to it. Padding has 0.
pub const NO_SPRING: f64 = -1.0;

impl BodyAssembly {
    /// The springs of a mesh by node, each kind with its stiffness [N/m] and damping [kg/s]. Where the body keeps its volume
    /// the first are those along edges, as [`rings`] has them, whether there are springs or not.
    pub fn gathered(&self) -> Result<Vec<(f64, f64, Gather)>, String> {
        let BodySprings::Mesh(lists) = &self.springs else { return Ok(Vec::new()) };
        let mut gathered = Vec::new();
        let mut others = &lists[..];
        if self.volume().is_some() {
            let along = lists.first().filter(|list| list.kind == SpringKind::Structural);
            let ring = rings(self.nodes, &self.closed_triangles, along)?;
            gathered.push((along.map_or(0.0, |list| list.k), along.map_or(0.0, |list| list.d), ring));
            others = &lists[usize::from(along.is_some())..];
        }
        for list in others {
            gathered.push((list.k, list.d, Gather::new(self.nodes, &list.pairs, &list.rest)?));
        }
        Ok(gathered)
    }
}

/// The ring of each node, and the springs along its edges: entries as in [`Gather`], but in the order of the ring,
/// counter-clockwise from outside, so that (a, rₖ, rₖ₊₁) and (a, r_last, r₀) are the triangles at a.
///
/// A node where several fans meet has them one after the other, each closed by its first neighbour and all by the
/// first of the first: what the ways between fans add is taken away on the way back. `triangles` are closed; `springs` are
/// along their edges.
pub fn rings(nodes: usize, triangles: &[[u32; 3]], springs: Option<&SpringList>) -> Result<Gather, String> {
    let corners = Csr::corners(nodes, triangles);
    let by_node = springs.map(|list| (list, Csr::corners(nodes, &list.pairs)));
    let length = |a: u32, b: u32| {
        let Some((list, by_node)) = &by_node else { return NO_SPRING };
        let to_b = |end: &&u32| list.pairs[**end as usize / 2][1 - **end as usize % 2] == b;
        by_node.row(a as usize).iter().find(to_b).map_or(NO_SPRING, |end| list.rest[*end as usize / 2])
    };
    let row = |node: usize| {
        let fans = fans(corners.row(node), triangles);
        let mut row: Vec<(u32, f64)> = Vec::new();
        for fan in &fans {
            row.extend(fan.iter().map(|&other| (other, length(node as u32, other))));
            if fans.len() > 1 {
                row.push((fan[0], NO_SPRING));
            }
        }
        row
    };
    let mut gather = Gather { slice_starts: vec![0], ..Gather::default() };
    for slice in 0..nodes.div_ceil(LANES) {
        let rows: Vec<_> = (slice * LANES..nodes.min((slice + 1) * LANES)).map(row).collect();
        gather.add_slice(slice, &rows, nodes)?;
    }
    Ok(gather)
}

/// The ways around a node: `corners` are 3·triangle + corner.
fn fans(corners: &[u32], triangles: &[[u32; 3]]) -> Vec<Vec<u32>> {
    let mut next: Vec<(u32, u32)> = corners
        .iter()
        .map(|&corner| {
            let (triangle, at) = (triangles[corner as usize / 3], corner as usize % 3);
            (triangle[(at + 1) % 3], triangle[(at + 2) % 3])
        })
        .collect();
    let mut fans = Vec::new();
    while let Some((first, mut end)) = (!next.is_empty()).then(|| next.swap_remove(0)) {
        let mut fan = vec![first];
        while end != first {
            // A closed surface goes on at every edge.
            let Some(at) = next.iter().position(|&(from, _)| from == end) else { break };
            fan.push(end);
            end = next.swap_remove(at).1;
        }
        fans.push(fan);
    }
    fans
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Icosphere, Mesh};
    use crate::topology::shapes::surface;

    /// The neighbours of a node in their order.
    fn row(gather: &Gather, node: usize) -> Vec<(u32, f64)> {
        let slice = node / LANES;
        let [start, end] = [0, 1].map(|i| gather.slice_starts[slice + i] as usize);
        let entries = (start + node % LANES..end).step_by(LANES);
        entries.map(|i| (gather.neighbour[i], gather.rest[i])).filter(|&(_, rest)| rest != 0.0).collect()
    }

    #[test]
    fn every_triangle_is_between_two_neighbours_of_each_of_its_corners() {
        let ball = surface(&Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 2 })).unwrap();
        let gather = rings(ball.nodes.len(), &ball.triangles, None).unwrap();
        let mut found = Vec::new();
        for node in 0..ball.nodes.len() {
            let ring = row(&gather, node);
            let around = |k: usize| (node as u32, ring[k].0, ring[(k + 1) % ring.len()].0);
            found.extend((0..ring.len()).map(around));
        }
        let turns = |&[a, b, c]: &[u32; 3]| [(a, b, c), (b, c, a), (c, a, b)];
        let mut given: Vec<_> = ball.triangles.iter().flat_map(turns).collect();
        found.sort_unstable();
        given.sort_unstable();
        assert_eq!(found, given);
    }

    #[test]
    fn two_fans_at_a_node_are_walked_one_after_the_other_and_back() {
        // Two tetrahedra that share node 0.
        let solid = |[a, b, c, d]: [u32; 4]| [[a, c, b], [a, b, d], [b, c, d], [c, a, d]];
        let triangles = [solid([0, 1, 2, 3]), solid([0, 4, 5, 6])].concat();
        let gather = rings(7, &triangles, None).unwrap();
        let ring: Vec<u32> = row(&gather, 0).into_iter().map(|(other, _)| other).collect();
        assert_eq!(ring.len(), 8);
        assert_eq!((ring[0], ring[4]), (ring[3], ring[7]));
        assert_eq!(row(&gather, 5).len(), 3);
    }
}
