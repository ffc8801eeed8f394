//! One body by solver index.

use crate::advice::Advice;
use crate::assembly::springs;
use crate::assembly::springs::SpringList;
use crate::extensions::Extensions;
use crate::scene::{Body, Grid, Kind, Mesh, SceneError, Select};
use crate::topology::{
    Edges, LANES, Placement, RestShape, Selectable, Surface, mass, measure, no_inside, order, select, shapes,
};
use std::ops::Range;

/// A body, ready to run. Nodes have three numberings: the user's (`node`), the solver's within the body, and the
/// solver's in the scene (`first` more).
pub struct BodyAssembly {
    /// Its name.
    pub name: String,
    /// Solver index of its first node.
    pub first: usize,
    /// Number of nodes.
    pub nodes: usize,
    /// Rows, columns and extent of a grid, whose surface follows from them.
    pub grid: Option<Grid>,
    /// Rows and columns in solver order, of a grid: the user's, or exchanged.
    pub grid_layout: Option<[usize; 2]>,
    /// The surface of a mesh body, as given, before placement.
    pub surface: Option<Surface>,
    /// Where it was put.
    pub placement: Placement,
    /// The solver's number of each node, within the body; `None`: the same.
    pub solver_of_node: Option<Vec<u32>>,
    /// Places at the start [m], in solver order.
    pub start: Vec<[f64; 3]>,
    /// Velocities at the start [m/s], in solver order; none where it starts at rest.
    pub start_velocity: Vec<[f64; 3]>,
    /// Mass of each node [kg], in solver order.
    pub mass: Vec<f64>,
    /// Whether each node is free, in solver order.
    pub free: Vec<bool>,
    /// Its springs.
    pub springs: BodySprings,
    /// Triangles in solver order within the body, of a closed body; else none.
    pub closed_triangles: Vec<[u32; 3]>,
    /// Volume at rest [m³], of a closed body.
    pub rest_volume: Option<f64>,
    /// What the user should know about its start, in words.
    pub warnings: Vec<String>,
    /// What features have made of its description.
    pub extensions: Extensions,
    pub(crate) edges: Option<Edges>,
    /// As [`select::split_nodes`] gives them.
    pub(crate) split: Vec<[u32; 2]>,
}

/// Springs of a body.
pub enum BodySprings {
    /// By direction of the grid.
    Grid(GridDirections),
    /// By lists of node pairs, in solver order within the body.
    Mesh(Vec<SpringList>),
}

/// Stiffness [N/m], damping [kg/s], rest length [m] of a grid's springs: along columns by one and two, along rows by
/// one and two, both diagonals.
pub type GridDirections = [Option<[f64; 3]>; 6];

impl BodyAssembly {
    /// Number of places that it takes among the solver's nodes.
    pub fn places(&self) -> usize {
        self.nodes.next_multiple_of(LANES)
    }

    /// The solver's number, within the body, of the user's node.
    pub fn solver_local(&self, node: usize) -> usize {
        self.solver_of_node.as_ref().map_or(node, |map| map[node] as usize)
    }

    /// The solver's number, in the scene, of the user's node.
    pub fn solver_index(&self, node: usize) -> usize {
        self.first + self.solver_local(node)
    }

    /// Number of the file's vertices.
    pub fn vertices(&self) -> usize {
        self.surface.as_ref().map_or(self.nodes, |surface| surface.vertices.len())
    }

    /// The node of a vertex; `None` if no face uses it.
    pub fn node_of_vertex(&self, vertex: usize) -> Option<usize> {
        let map = self.surface.as_ref().and_then(|surface| surface.node_of_vertex.as_ref());
        map.map_or(Some(vertex), |map| (map[vertex] != u32::MAX).then_some(map[vertex] as usize))
    }

    /// A vertex's node, and the others that its point was split into.
    pub fn nodes_at(&self, node: usize) -> impl Iterator<Item = usize> {
        let split = self.split.iter().filter(move |[_, owner]| *owner as usize == node);
        std::iter::once(node).chain(split.map(|[node, _]| *node as usize))
    }

    /// Solver indices of its nodes.
    pub fn solver_range(&self) -> Range<usize> {
        self.first..self.first + self.nodes
    }

    /// The first vertex of the node with the solver's number `local`.
    pub fn vertex_of_solver(&self, local: usize) -> usize {
        let node = match &self.solver_of_node {
            Some(map) => map.iter().position(|&to| to as usize == local).unwrap_or(local),
            None => local,
        };
        self.surface.as_ref().map_or(node, |surface| surface.first_vertex_of(node as u32))
    }

    /// Number of triangles.
    pub fn triangles(&self) -> usize {
        match (&self.grid, &self.surface) {
            (Some(grid), _) => 2 * (grid.rows as usize - 1) * (grid.cols as usize - 1),
            (None, Some(surface)) => surface.triangles.len(),
            (None, None) => 0,
        }
    }

    /// The surface as the user knows it; a grid's is made here.
    pub fn user_surface(&self) -> Surface {
        match (&self.surface, &self.grid) {
            (Some(surface), _) => surface.clone(),
            (None, Some(grid)) => shapes::grid_surface(grid.rows, grid.cols, grid.size),
            (None, None) => Surface::default(),
        }
    }

    /// The user's nodes that a selection means, ascending.
    pub fn select(&self, choice: &Select) -> Result<Vec<u32>, SceneError> {
        // Only a box asks for places, and a body may have many pins.
        let asked = if choice.inside.is_some() { self.nodes } else { 0 };
        let nodes: Vec<[f64; 3]> = (0..asked).map(|node| self.start[self.solver_local(node)]).collect();
        let from = Selectable {
            nodes: &nodes,
            vertices: self.vertices(),
            node_of_vertex: self.surface.as_ref().and_then(|s| s.node_of_vertex.as_deref()),
            split: &self.split,
            groups: self.surface.as_ref().map_or(&[], |s| &s.groups),
            grid: self.grid.map(|grid| [grid.rows, grid.cols]),
            edges: self.edges.as_ref(),
        };
        select::select(choice, &from).map_err(|(field, message)| SceneError::new(field, message))
    }

    /// By triangle of its surface: the number of the zone that it is of, from 1; 0: none. Where zones overlap, the last
    /// counts. `path` is where they are described, by name.
    pub fn zones<'z>(
        &self,
        path: &str,
        surface: &Surface,
        zones: impl Iterator<Item = (&'z String, &'z Select)>,
    ) -> Result<Vec<usize>, SceneError> {
        let mut all = vec![0; surface.triangles.len()];
        for ((name, select), number) in zones.zip(1..) {
            let path = format!("{path}.{name}");
            let mut inside = vec![false; self.nodes];
            let nodes = self.select(select).map_err(|error| error.under(&path))?;
            nodes.iter().for_each(|&node| inside[node as usize] = true);
            let mut any = false;
            for (one, triangle) in all.iter_mut().zip(&surface.triangles) {
                if triangle.iter().all(|&node| inside[node as usize]) {
                    (*one, any) = (number, true);
                }
            }
            if !any {
                let message =
                    format!("means {} nodes and no whole triangle; all three corners count", nodes.len());
                return Err(SceneError::new("select", message).under(&path));
            }
        }
        Ok(all)
    }

    /// The nodes of a selection that a load acts on: one for each vertex, also where a vertex has several.
    pub fn select_loaded(&self, choice: &Select) -> Result<Vec<u32>, SceneError> {
        let mut nodes = self.select(choice)?;
        for node in &mut nodes {
            if let Ok(i) = self.split.binary_search_by_key(node, |[split, _]| *split) {
                *node = self.split[i][1];
            }
        }
        nodes.sort_unstable();
        nodes.dedup();
        Ok(nodes)
    }

    /// Number of springs by kind.
    pub fn spring_counts(&self) -> Vec<(&'static str, usize)> {
        match (&self.springs, &self.grid) {
            (BodySprings::Grid(along), Some(grid)) => {
                let counts = springs::grid_counts(grid.rows, grid.cols);
                [("structural", counts.structural, 0), ("shear", counts.shear, 4), ("bend", counts.bend, 1)]
                    .into_iter()
                    .filter(|&(_, _, direction)| along[direction].is_some())
                    .map(|(name, count, _)| (name, count as usize))
                    .collect()
            }
            (BodySprings::Mesh(lists), _) => {
                lists.iter().map(|list| (list.kind.name(), list.pairs.len())).collect()
            }
            (BodySprings::Grid(_), None) => Vec::new(),
        }
    }
}

pub(crate) fn at<T>(result: Result<T, (&'static str, String)>) -> Result<T, SceneError> {
    result.map_err(|(field, message)| SceneError::new(field, message))
}

pub(crate) fn mesh_body(body: &Body, mesh: &Mesh) -> Result<BodyAssembly, SceneError> {
    let in_mesh = |message: String| SceneError::new("mesh", message);
    let surface = shapes::surface(mesh).map_err(in_mesh)?;
    let edges = Edges::new(surface.nodes.len(), &surface.triangles, &surface.links);
    let placement = at(Placement::new(&body.place, &surface.nodes))?;
    let mut placed = surface.nodes.clone();
    placement.apply_all(&mut placed);
    let closed = !surface.triangles.is_empty() && edges.is_closed();
    if body.kind == Kind::Soft
        && let Some(error) = not_closed(body, &surface, &edges)
    {
        return Err(error);
    }
    let rest = RestShape::of(&surface, placement.factor);
    let volume = if closed { Some(rest_volume(&rest, &placed, &surface)?) } else { None };
    let mass = mesh_mass(body, &surface, &placed, &rest, volume)?;
    let lists = springs::mesh_springs(&body.springs, &surface, &edges, &rest)?;
    let far = if rest.is_given() { springs::start_warning(&lists, &placed) } else { None };
    let order = order::locality_order(&surface.nodes);
    let mut solver_of_node = vec![0; order.len()];
    for (new, &old) in order.iter().enumerate() {
        solver_of_node[old as usize] = new as u32;
    }
    Ok(BodyAssembly {
        name: String::new(),
        first: 0,
        nodes: surface.nodes.len(),
        grid: None,
        grid_layout: None,
        placement,
        start_velocity: Vec::new(),
        start: order.iter().map(|&old| placed[old as usize]).collect(),
        free: vec![true; mass.len()],
        mass: order.iter().map(|&old| mass[old as usize]).collect(),
        springs: BodySprings::Mesh(lists.into_iter().map(|list| renumber(list, &solver_of_node)).collect()),
        closed_triangles: if closed {
            surface.triangles.iter().map(|t| t.map(|n| solver_of_node[n as usize])).collect()
        } else {
            Vec::new()
        },
        rest_volume: volume,
        extensions: Extensions::default(),
        warnings: far.into_iter().collect(),
        solver_of_node: Some(solver_of_node),
        split: select::split_nodes(&surface),
        surface: Some(surface),
        edges: Some(edges),
    })
}

/// Volume of a closed body at rest [m³]; that of the start where the shape at rest encloses none.
fn rest_volume(rest: &RestShape, placed: &[[f64; 3]], surface: &Surface) -> Result<f64, SceneError> {
    let given = if rest.is_given() { rest.volume() } else { None };
    match given {
        Some(volume) if volume < 0.0 => Err(SceneError::new(
            "rest_shape",
            format!("encloses {volume} m³: it is the mirror image of the mesh; the same way round would do"),
        )),
        Some(volume) if volume > 0.0 => Ok(volume),
        _ => Ok(measure::volume(placed, &surface.triangles)),
    }
}

/// Mass of each node [kg], by areas at rest.
fn mesh_mass(
    body: &Body,
    surface: &Surface,
    placed: &[[f64; 3]],
    rest: &RestShape,
    volume: Option<f64>,
) -> Result<Vec<f64>, SceneError> {
    let refuse = |message: String| SceneError::new("", message);
    let areas = if rest.is_given() {
        rest.areas()
    } else {
        surface.triangles.iter().map(|t| measure::area(placed, *t)).collect()
    };
    let lengths: Vec<f64> = surface.links.iter().map(|link| measure::length(placed, *link)).collect();
    let shares = mass::Shares {
        nodes: placed.len(),
        triangles: (&surface.triangles, &areas),
        links: (&surface.links, &lengths),
        volume: volume.unwrap_or(0.0),
    };
    let mass = body.mass_given().ok_or_else(|| refuse("has no mass".into()))?;
    mass::lump(mass, body.kind, &shares).map_err(refuse)
}

fn renumber(mut list: SpringList, solver_of_node: &[u32]) -> SpringList {
    for pair in &mut list.pairs {
        *pair = pair.map(|node| solver_of_node[node as usize]);
    }
    list
}

/// Why a mesh cannot be a soft body, and what would do.
fn not_closed(body: &Body, surface: &Surface, edges: &Edges) -> Option<SceneError> {
    let why = no_inside(surface, edges)?;
    let fillable = why.fillable && !body.fill_holes;
    let remedy = if fillable { "holes of a mesh from a file can be filled" } else { "mend it" };
    let error = SceneError::new("mesh", format!("{why}; {remedy}, or make the body a cloth"));
    Some(if fillable { error.advise(Advice::FillHoles) } else { error }.advise(Advice::Cloth))
}
