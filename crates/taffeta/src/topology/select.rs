//! The nodes that a selection means.

use crate::scene::{Bounds, Select};
use crate::topology::{Edges, Surface};
use std::collections::HashMap;

/// What a selection chooses from: a body at its start.
///
/// ```
/// use taffeta::scene::Select;
/// use taffeta::topology::{Selectable, select::select};
///
/// let (nodes, grid) = ([].as_slice(), Some([4, 5]));
/// let sheet =
///     Selectable { nodes, vertices: 20, node_of_vertex: None, split: &[], groups: &[], grid, edges: None };
/// assert_eq!(select(&Select::rows(0, 0), &sheet), Ok(vec![0, 1, 2, 3, 4]));
/// let corner = Select { cols: Some([4, 4]), ..Select::rows(3, 3) };
/// assert_eq!(select(&corner, &sheet), Ok(vec![19]));
/// ```
#[derive(Clone, Copy, Debug)]
pub struct Selectable<'a> {
    /// Places of the nodes in the scene [m]; for a selection without a box, none will do.
    pub nodes: &'a [[f64; 3]],
    /// Number of vertices in the user's order.
    pub vertices: usize,
    /// The node of each vertex, as in [`Surface`].
    pub node_of_vertex: Option<&'a [u32]>,
    /// Nodes of vertices that have several, as [`split_nodes`] gives them.
    pub split: &'a [[u32; 2]],
    /// Named sets of vertices.
    pub groups: &'a [(String, Vec<u32>)],
    /// Rows and columns, of a grid.
    pub grid: Option<[u32; 2]>,
    /// Edges, of a mesh; grids need none.
    pub edges: Option<&'a Edges>,
}

/// Where in the scene, as keys from the pin or force, and what is wrong.
type Refusal = (&'static str, String);

/// The nodes that meet every key of a selection, ascending. The error is (field, message), the field as keys from
/// the pin or force: `select.rows`.
///
/// ```
/// use taffeta::scene::Select;
/// use taffeta::topology::{Edges, Selectable, select::select, shapes::grid_surface};
///
/// let sheet = grid_surface(3, 3, [0.2, 0.2]);
/// let edges = Edges::new(9, &sheet.triangles, &[]);
/// let (nodes, edges, groups) = (&sheet.nodes[..], Some(&edges), &sheet.groups[..]);
/// let body = Selectable { nodes, vertices: 9, node_of_vertex: None, split: &[], groups, grid: None, edges };
/// let border = Select { boundary: Some(true), ..Select::default() };
/// assert_eq!(select(&border, &body), Ok(vec![0, 1, 2, 3, 5, 6, 7, 8]));
/// let (field, message) = select(&Select::nodes([9]), &body).unwrap_err();
/// assert_eq!(format!("{field} {message}"), "select.nodes has 9, 0 to 8 would do");
/// ```
pub fn select(select: &Select, body: &Selectable) -> Result<Vec<u32>, Refusal> {
    let keys = [
        select.nodes.as_ref().map(|list| body.listed(list)),
        select.group.as_ref().map(|name| body.group(name)),
        body.on_grid(select),
        select.boundary.map(|wanted| body.boundary(wanted)),
        select.inside.as_ref().map(|bounds| body.inside(bounds)),
    ];
    let mut chosen: Option<Vec<u32>> = None;
    for key in keys.into_iter().flatten() {
        let key = key?;
        chosen = Some(match chosen {
            None => key,
            Some(so_far) => so_far.into_iter().filter(|node| key.binary_search(node).is_ok()).collect(),
        });
    }
    match chosen {
        None => Err(("select", "has no key; nodes, rows, cols, box, boundary or group would do".into())),
        Some(nodes) if nodes.is_empty() => {
            Err(("select", "selects no node; a node must meet all keys".into()))
        }
        Some(nodes) => Ok(nodes),
    }
}

/// Nodes that no vertex has because its point was split where surfaces touch: each with the node at the same place
/// that the vertex has, ascending.
///
/// ```
/// use taffeta::topology::{Surface, select::split_nodes};
///
/// // The file has one vertex where two triangles touch at their tips: nodes 0 and 3.
/// let [left, right] = [[[-0.1, 0.0, 0.0], [-0.1, 0.1, 0.0]], [[0.1, 0.0, 0.0], [0.1, 0.1, 0.0]]];
/// let nodes = [&[[0.0; 3]], &left[..], &[[0.0; 3]], &right[..]].concat();
/// let node_of_vertex = Some(vec![0, 1, 2, 4, 5]);
/// let surface = Surface { nodes, node_of_vertex, ..Surface::default() };
/// assert_eq!(split_nodes(&surface), [[3, 0]]);
/// ```
pub fn split_nodes(surface: &Surface) -> Vec<[u32; 2]> {
    let Some(list) = &surface.node_of_vertex else { return Vec::new() };
    let mut used = vec![false; surface.nodes.len()];
    list.iter().filter(|node| **node != u32::MAX).for_each(|node| used[*node as usize] = true);
    let spare: Vec<u32> = (0..used.len() as u32).filter(|node| !used[*node as usize]).collect();
    if spare.is_empty() {
        return Vec::new();
    }
    let place = |node: u32| surface.nodes[node as usize].map(f64::to_bits);
    let mut owners: HashMap<[u64; 3], Option<u32>> = spare.iter().map(|node| (place(*node), None)).collect();
    for node in list.iter().filter(|node| **node != u32::MAX) {
        owners.entry(place(*node)).and_modify(|owner| *owner = owner.or(Some(*node)));
    }
    spare.into_iter().filter_map(|node| Some([node, (*owners.get(&place(node))?)?])).collect()
}

impl Selectable<'_> {
    /// Nodes of vertices, ascending: all of those that have several.
    fn with_split(&self, nodes: Vec<u32>) -> Vec<u32> {
        let mut nodes = sorted(nodes);
        let also = self.split.iter().filter(|[_, owner]| nodes.binary_search(owner).is_ok());
        let also: Vec<u32> = also.map(|[node, _]| *node).collect();
        nodes.extend(also);
        sorted(nodes)
    }

    /// The node of a vertex, if a face uses it.
    fn node(&self, vertex: u32) -> Option<u32> {
        let node = self.node_of_vertex.map_or(vertex, |list| list[vertex as usize]);
        (node != u32::MAX).then_some(node)
    }

    fn listed(&self, list: &[u32]) -> Result<Vec<u32>, Refusal> {
        let nodes = list.iter().map(|&vertex| {
            if vertex as usize >= self.vertices {
                let last = self.vertices.saturating_sub(1);
                return Err(("select.nodes", format!("has {vertex}, 0 to {last} would do")));
            }
            let unused =
                || ("select.nodes", format!("has {vertex}, which no face uses; vertices of faces would do"));
            self.node(vertex).ok_or_else(unused)
        });
        Ok(self.with_split(nodes.collect::<Result<_, _>>()?))
    }

    fn group(&self, name: &str) -> Result<Vec<u32>, Refusal> {
        if let Some((_, members)) = self.groups.iter().find(|(group, _)| group == name) {
            return Ok(self.with_split(members.iter().filter_map(|vertex| self.node(*vertex)).collect()));
        }
        let names: Vec<String> = self.groups.iter().map(|(group, _)| format!("`{group}`")).collect();
        let have =
            if names.is_empty() { "it has no groups".into() } else { format!("it has {}", names.join(", ")) };
        Err(("select.group", format!("the mesh has no group `{name}`; {have}")))
    }

    /// Nodes in the rows and columns asked for, if either is.
    fn on_grid(&self, select: &Select) -> Option<Result<Vec<u32>, Refusal>> {
        let field = if select.rows.is_some() { "select.rows" } else { "select.cols" };
        if select.rows.is_none() && select.cols.is_none() {
            return None;
        }
        let Some([rows, cols]) = self.grid else {
            return Some(Err((
                field,
                "only grids have rows and columns; nodes, box or group would do".into(),
            )));
        };
        let ranges = range("select.rows", select.rows, rows)
            .and_then(|rows| Ok((rows, range("select.cols", select.cols, cols)?)));
        Some(ranges.map(|([top, bottom], [left, right])| {
            (top..=bottom).flat_map(|r| (left..=right).map(move |c| r * cols + c)).collect()
        }))
    }

    fn boundary(&self, wanted: bool) -> Result<Vec<u32>, Refusal> {
        if !wanted {
            return Err(("select.boundary", "is false; true would do, or leave it out".into()));
        }
        let nodes = match (self.grid, self.edges) {
            (Some([rows, cols]), _) => {
                let on_edge = |i: u32, count: u32| i == 0 || i + 1 == count;
                let open = |node: &u32| on_edge(node / cols, rows) || on_edge(node % cols, cols);
                (0..rows * cols).filter(open).collect()
            }
            (None, Some(edges)) => edges.boundary_nodes(),
            (None, None) => Vec::new(),
        };
        let closed = || ("select.boundary", "the body has no open edge; nodes, box or group would do".into());
        if nodes.is_empty() { Err(closed()) } else { Ok(nodes) }
    }

    fn inside(&self, bounds: &Bounds) -> Result<Vec<u32>, Refusal> {
        let Bounds { min, max } = bounds;
        if (0..3).any(|i| min[i] > max[i]) {
            return Err(("select.box", format!("min {min:?} is above max {max:?}; below or equal would do")));
        }
        let within = |p: &[f64; 3]| (0..3).all(|i| (min[i]..=max[i]).contains(&p[i]));
        let found: Vec<u32> =
            self.nodes.iter().zip(0..).filter(|(p, _)| within(p)).map(|(_, node)| node).collect();
        if found.is_empty() {
            let [low, high] = crate::topology::measure::bounds(self.nodes);
            let message = format!("holds no node; the body starts between {low:?} and {high:?}");
            return Err(("select.box", message));
        }
        Ok(found)
    }
}

/// First and last of `count`, both included; without a wish all of them.
fn range(field: &'static str, wish: Option<[u32; 2]>, count: u32) -> Result<[u32; 2], Refusal> {
    let [first, last] = wish.unwrap_or([0, count - 1]);
    if first > last || last >= count {
        let message = format!("is {first} to {last}, ascending within 0 to {} would do", count - 1);
        return Err((field, message));
    }
    Ok([first, last])
}

fn sorted(mut nodes: Vec<u32>) -> Vec<u32> {
    nodes.sort_unstable();
    nodes.dedup();
    nodes
}

#[cfg(test)]
mod tests;
