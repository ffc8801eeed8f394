//! Springs as a list for people and pictures, whatever the method.

use crate::assembly::body::mesh_body;
use crate::assembly::body::{BodyAssembly, BodySprings, GridDirections};
use crate::assembly::grid;
use crate::assembly::springs::{SpringKind, SpringList};
use crate::elements::spring::stencil::GRID_STEPS;
use crate::scene::{Mesh, Scene, SceneError};

/// What a grid's springs in each direction are for.
const KINDS: [SpringKind; 6] = [
    SpringKind::Structural,
    SpringKind::Bend,
    SpringKind::Structural,
    SpringKind::Bend,
    SpringKind::Shear,
    SpringKind::Shear,
];

/// The springs of a scene's body as a simulation has them, with their ends by the user's nodes, a < b. Those of a grid come by
/// direction.
///
/// # Errors
/// Where there is no such body, or the scene cannot be simulated.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene};
/// use taffeta::springs_of;
///
/// let cloth = Body::cloth("cloth", Mesh::grid(3, 3, [0.2, 0.2])).with_mass(Mass::Area(0.2)).structural(50.0, 0.05);
/// let scene = Scene::new("").body(cloth);
/// // Six along z, six along x.
/// let lists = springs_of(&scene, 0)?;
/// let lines: Vec<[u32; 2]> = lists.iter().flat_map(|list| &list.pairs).copied().collect();
/// assert_eq!(lines.len(), 12);
/// assert!(lines.contains(&[0, 1]) && lines.contains(&[0, 3]));
/// assert!(springs_of(&scene, 1).is_err());
/// # Ok::<(), taffeta::scene::SceneError>(())
/// ```
pub fn springs_of(scene: &Scene, body: usize) -> Result<Vec<SpringList>, SceneError> {
    scene.validate()?;
    let described = scene.bodies.get(body).ok_or_else(|| {
        SceneError::new("body", format!("has {} elements, and none at {body}", scene.bodies.len()))
    })?;
    let built = match &described.mesh {
        Mesh::Grid(grid) => grid::build(described, *grid),
        mesh => mesh_body(described, mesh),
    };
    let built = built.map_err(|error| error.under(&format!("body[{body}]")))?;
    let lists = match (&built.springs, built.grid_layout) {
        (BodySprings::Grid(along), Some(layout)) => of_grid(along, layout),
        (BodySprings::Mesh(lists), _) => lists.clone(),
        (BodySprings::Grid(_), None) => Vec::new(),
    };
    Ok(by_node(&built, lists))
}

/// By the solver's nodes.
fn of_grid(along: &GridDirections, [rows, cols]: [usize; 2]) -> Vec<SpringList> {
    let mut lists = Vec::new();
    for (direction, &(down, across)) in GRID_STEPS.iter().enumerate() {
        let Some([k, d, length]) = along[direction] else { continue };
        let mut pairs = Vec::new();
        for (row, col) in (0..rows.saturating_sub(down)).flat_map(|row| (0..cols).map(move |col| (row, col)))
        {
            if let Some(there) = col.checked_add_signed(across).filter(|&there| there < cols) {
                pairs.push([row * cols + col, (row + down) * cols + there].map(|node| node as u32));
            }
        }
        lists.push(SpringList { kind: KINDS[direction], rest: vec![length; pairs.len()], pairs, k, d });
    }
    lists
}

/// From the solver's nodes to the user's.
fn by_node(built: &BodyAssembly, mut lists: Vec<SpringList>) -> Vec<SpringList> {
    let Some(solver_of_node) = &built.solver_of_node else { return lists };
    let mut node_of_solver = vec![0; solver_of_node.len()];
    for (node, &local) in (0..).zip(solver_of_node) {
        node_of_solver[local as usize] = node;
    }
    for pair in lists.iter_mut().flat_map(|list| &mut list.pairs) {
        *pair = pair.map(|local| node_of_solver[local as usize]);
        pair.sort_unstable();
    }
    lists
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::{norm, sub};
    use crate::scene::{Body, Icosphere, Mass};
    use crate::topology::shapes;

    #[test]
    fn springs_join_the_users_nodes_at_their_lengths_at_rest() {
        let heavy = |body: Body| body.with_mass(Mass::Node(0.1)).structural(9.0, 0.0).bend(7.0, 0.1);
        let ball = Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 2 });
        let scene = Scene::new("")
            .body(heavy(Body::cloth("grid", Mesh::grid(5, 7, [0.6, 0.8]))).shear(8.0, 0.0))
            // Long rows: the solver has rows and columns exchanged.
            .body(heavy(Body::cloth("wide", Mesh::grid(3, 2100, [21.0, 0.03]))))
            .body(heavy(Body::soft("ball", ball)));
        let counts = [[58, 48, 46], [3 * 2099 + 2 * 2100, 0, 3 * 2098 + 2100], [480, 0, 480]];
        let kinds = [SpringKind::Structural, SpringKind::Shear, SpringKind::Bend];
        for (index, counts) in counts.into_iter().enumerate() {
            let lists = springs_of(&scene, index).unwrap();
            for (kind, count) in kinds.into_iter().zip(counts) {
                let of_kind = lists.iter().filter(|list| list.kind == kind);
                assert_eq!(of_kind.map(|list| list.pairs.len()).sum::<usize>(), count, "{index} {kind:?}");
            }
            let nodes = shapes::surface(&scene.bodies[index].mesh).unwrap().nodes;
            for list in &lists {
                for (&[a, b], &rest) in list.pairs.iter().zip(&list.rest) {
                    let length = norm(sub(nodes[b as usize], nodes[a as usize]));
                    assert!(a < b && (length - rest).abs() < 1e-12, "{index} {:?} {a} {b}", list.kind);
                }
            }
        }
        assert!(springs_of(&scene, 3).is_err());
    }
}
