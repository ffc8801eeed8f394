//! Coarser levels of bodies whose springs are solved for by multigrid.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::solvers::constraints::Constraints;
use crate::solvers::implicit::coarsening::{Coarser, Graph, Weighted};
use crate::topology::LANES;
use std::ops::Range;

/// Nodes at which a body gets no coarser.
const FEW: usize = 24;

impl Assembly {
    /// Coarser levels of the constraints, where the form of these asks for some.
    pub fn levels(&self) -> &[Level] {
        self.extensions.list()
    }

    /// Gives them back.
    pub(crate) fn forget_levels(&mut self) {
        self.extensions.insert(Vec::<Level>::new());
    }
}

/// One level: the coarser graphs of all bodies that have one, one after the other, each from a multiple of the vector
/// width on.
#[derive(Clone, Debug, Default)]
pub struct Level {
    /// Number of places for nodes.
    pub places: usize,
    /// Nodes of each body; none of one that ends on a finer level.
    pub bodies: Vec<Range<usize>>,
    /// Ends of each edge, ascending.
    pub edges: Vec<[u32; 2]>,
    /// By place of the finer level: which nodes it follows, and how much.
    pub parents: Weighted,
    /// By edge: the edges of the finer level that it stands for, and how much of each.
    pub sources: Weighted,
}

impl Level {
    /// All levels of a scene but the finest, whose places are the solver's, whose edges the constraints. `elements`: whether
    /// each body has other elements that are solved for. `joined`: whether contacts or seams join bodies; then all of them reach the last
    /// level, some without getting any coarser.
    pub fn all(
        bodies: &[BodyAssembly],
        constraints: &Constraints,
        elements: &[bool],
        joined: bool,
    ) -> Vec<Self> {
        let mut graphs: Vec<Option<Graph>> = graphs(bodies, constraints, elements);
        let mut finer = Self {
            places: bodies.last().map_or(0, |body| body.first + body.places()),
            bodies: bodies.iter().map(|body| body.solver_range()).collect(),
            edges: constraints.ends.clone(),
            ..Self::default()
        };
        let mut levels: Vec<Self> = Vec::new();
        loop {
            let mut coarser: Vec<Option<Coarser>> = graphs
                .iter()
                .map(|graph| graph.as_ref().filter(|graph| graph.nodes() > FEW).and_then(Graph::coarser))
                .collect();
            if coarser.iter().all(Option::is_none) {
                return levels;
            }
            if joined {
                for (coarser, graph) in coarser.iter_mut().zip(&graphs) {
                    *coarser = coarser.take().or_else(|| graph.as_ref().map(Graph::same));
                }
            }
            let first_edges = first_edges(levels.last().unwrap_or(&finer), &graphs);
            let level = Self::of(levels.last().unwrap_or(&finer), &first_edges, &coarser);
            if levels.is_empty() {
                finer.edges = Vec::new();
            }
            levels.push(level);
            graphs = coarser.into_iter().map(|one| one.map(|one| one.graph)).collect();
        }
    }

    /// The level that these coarser graphs of bodies make. `first_edges`: the first edge of each body on the finer level.
    fn of(finer: &Self, first_edges: &[usize], coarser: &[Option<Coarser>]) -> Self {
        let mut level = Self::default();
        for ((body, coarser), &edge) in finer.bodies.iter().zip(coarser).zip(first_edges) {
            let from = level.places;
            let Some(Coarser { graph, parents, sources }) = coarser else {
                level.bodies.push(from..from);
                continue;
            };
            level.places += graph.nodes().next_multiple_of(LANES);
            level.bodies.push(from..from + graph.nodes());
            level.edges.extend(graph.edges.iter().map(|ends| ends.map(|node| node + from as u32)));
            (level.parents.rows()..body.start).for_each(|_| level.parents.push([]));
            for row in 0..parents.rows() {
                level
                    .parents
                    .push(parents.row(row).iter().map(|&(node, weight)| (node + from as u32, weight)));
            }
            for row in 0..sources.rows() {
                level.sources.push(sources.row(row).iter().map(|&(one, weight)| (one + edge as u32, weight)));
            }
        }
        (level.parents.rows()..finer.places).for_each(|_| level.parents.push([]));
        level
    }
}

/// Where the edges of each body start among those of a level.
fn first_edges(level: &Level, graphs: &[Option<Graph>]) -> Vec<usize> {
    let mut next = 0;
    let mut starts = Vec::new();
    for graph in graphs {
        starts.push(next);
        next += graph.as_ref().map_or(0, |graph| graph.edges.len());
    }
    debug_assert_eq!(next, level.edges.len(), "every edge is one of a body");
    starts
}

/// The finest graph of each body that is solved for.
fn graphs(bodies: &[BodyAssembly], list: &Constraints, elements: &[bool]) -> Vec<Option<Graph>> {
    let one = |((body, rows), &has_elements): ((&BodyAssembly, &Range<usize>), &bool)| {
        let first = body.first as u32;
        (has_elements || !rows.is_empty()).then(|| Graph {
            places: body.start.clone(),
            edges: list.ends[rows.clone()].iter().map(|ends| ends.map(|node| node - first)).collect(),
            near: list.material[rows.clone()].iter().map(|&one| list.near[one as usize]).collect(),
            links: if has_elements { links(body) } else { Vec::new() },
            grid: body.grid_layout,
        })
    };
    bodies.iter().zip(&list.bodies).zip(elements).map(one).collect()
}

/// The edges of a body's triangles, in solver order within the body.
fn links(body: &BodyAssembly) -> Vec<[u32; 2]> {
    let pairs = body.edges.iter().flat_map(|edges| &edges.pairs);
    pairs.map(|pair| pair.map(|node| body.solver_local(node as usize) as u32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Assembly;
    use crate::scene::{Body, ConstraintForm, Icosphere, Mass, Mesh, Method, Scene};

    #[test]
    fn bodies_follow_each_other_on_every_level() {
        let heavy = |body: Body| body.with_mass(Mass::Node(0.1)).structural(9.0, 0.0).bend(1.0, 0.0);
        let ball = Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 3 });
        let mut scene = Scene::new("")
            .method(Method::Ice)
            .body(heavy(Body::cloth("grid", Mesh::grid(20, 30, [1.0, 1.5]))))
            .body(Body::cloth("bare", Mesh::grid(9, 9, [1.0, 1.0])).with_mass(Mass::Node(0.1)))
            .body(heavy(Body::soft("ball", ball)));
        scene.solver.ice.form = ConstraintForm::Primal;
        let assembly = Assembly::new(&scene).unwrap();
        let levels = assembly.levels();
        assert_eq!(levels[0].bodies[0], 0..11 * 16);
        assert!(levels.iter().all(|level| level.bodies[1].is_empty()));
        assert!(levels[0].bodies[2].len() < 642 / 3);
        let (mut places, mut edges) = (assembly.places, assembly.constraints().len());
        let mut bodies: Vec<Range<usize>> = assembly.bodies.iter().map(|body| body.solver_range()).collect();
        for level in levels {
            assert_eq!(level.parents.rows(), places);
            assert_eq!(level.sources.rows(), level.edges.len());
            assert!(level.sources.items.iter().all(|one| (one.0 as usize) < edges));
            for (finer, coarser) in bodies.iter().zip(&level.bodies) {
                let within = |one: &(u32, f32)| coarser.contains(&(one.0 as usize));
                assert!(finer.clone().all(|place| level.parents.row(place).iter().all(within)));
            }
            assert!(level.bodies.iter().all(|body| body.start % LANES == 0 && body.end <= level.places));
            (places, edges, bodies) = (level.places, level.edges.len(), level.bodies.clone());
        }
        assert!(bodies.iter().all(|body| body.len() <= FEW));
    }
}
