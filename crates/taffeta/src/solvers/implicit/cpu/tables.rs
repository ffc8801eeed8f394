//! What does not change: levels, as the workers walk through them.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::real::{Real, Symmetric};
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::implicit::cpu::columns::View;
use crate::solvers::implicit::implicit::add_weighted;
use crate::solvers::implicit::levels::Level;
use crate::solvers::implicit::slots::Slots;
use crate::topology::LANES;
use std::ops::Range;

/// Nodes that a node follows at most.
const PARENTS: usize = 4;
/// Places of a chunk at most.
pub const CHUNK: usize = 128;
/// Nodes of a body on its coarsest level up to which that is nearly solved, not only smoothed.
const FEW: usize = 64;
/// Places of a level up to which one worker alone goes on from it: meeting takes longer.
const ALONE: usize = 1024;

/// Some places of one body.
#[derive(Clone, Debug)]
pub struct Chunk {
    pub body: usize,
    pub part: Range<usize>,
    /// Which of its level it is.
    pub number: usize,
}

/// By node of a slice: nodes of the coarser level that it follows; with weight 0 where there are fewer.
pub struct Parents<T> {
    pub nodes: [[u32; LANES]; PARENTS],
    pub weights: [[T; LANES]; PARENTS],
}

impl<T: Real> Parents<T> {
    /// Those of one node.
    pub fn of(&self, lane: usize) -> [(u32, T); PARENTS] {
        std::array::from_fn(|one| (self.nodes[one][lane], self.weights[one][lane]))
    }
}

/// A level.
pub struct Table<T> {
    pub slots: Slots,
    /// Number of places.
    pub places: usize,
    /// Places of each body, whole slices.
    pub bodies: Vec<Range<usize>>,
    pub chunks: Vec<Chunk>,
    /// Chunks of each body.
    pub chunks_of: Vec<Range<usize>>,
    /// By edge: slots of the finer level whose blocks it adds up.
    pub sources: Weighted,
    /// By node: nodes of the finer level that follow it.
    pub children: Weighted,
    /// By slice.
    pub parents: Vec<Parents<T>>,
    /// Whether each body has a coarser level.
    pub goes_on: Vec<bool>,
    /// Whether each body ends here with few nodes.
    pub ends: Vec<bool>,
}

impl<T: Real> Table<T> {
    /// The finest level, then coarser ones.
    pub fn all(assembly: &Assembly, levels: &[Level]) -> Vec<Self> {
        let list = assembly.constraints();
        let bodies = assembly.bodies.iter().enumerate();
        let nodes = |(index, body): (usize, &BodyAssembly)| {
            body.first..body.first + if assembly.is_solved_for(index) { body.nodes } else { 0 }
        };
        let first: Vec<Range<usize>> = bodies.map(nodes).collect();
        // Springs beside elements are among the blocks of those on coarser levels.
        let plain: Vec<bool> = (0..first.len()).map(|body| !assembly.has_solved_elements(body)).collect();
        let is_grid: Vec<bool> = assembly.bodies.iter().map(|body| body.grid_layout.is_some()).collect();
        let mut tables = vec![Self::new(assembly.places, &list.ends, &first, &is_grid)];
        // By edge of the finer level: which of the table's it is.
        let mut kept: Vec<usize> = (0..list.ends.len()).collect();
        for level in levels {
            let is_plain = |ends: &[u32; 2]| {
                let body = level.bodies.partition_point(|nodes| nodes.end <= ends[0] as usize);
                plain[body]
            };
            let of_plain: Vec<usize> =
                (0..level.edges.len()).filter(|&edge| is_plain(&level.edges[edge])).collect();
            let edges: Vec<[u32; 2]> = of_plain.iter().map(|&edge| level.edges[edge]).collect();
            let mut table = Self::new(level.places, &edges, &level.bodies, &is_grid);
            let finer = &mut tables.last_mut().expect("the finest level is there");
            finer.follow(level);
            for &edge in &of_plain {
                let slot = |source: u32| finer.slots.of_edge[kept[source as usize]];
                table
                    .sources
                    .push(level.sources.row(edge).iter().map(|&(source, weight)| (slot(source), weight)));
            }
            kept = vec![usize::MAX; level.edges.len()];
            of_plain.iter().enumerate().for_each(|(number, &edge)| kept[edge] = number);
            table.children = level.parents.transposed(level.places);
            tables.push(table);
        }
        // Only to tell sources; coarser levels look up blocks by it as well.
        tables[0].slots.of_edge = Vec::new();
        tables
    }

    fn new(places: usize, edges: &[[u32; 2]], nodes: &[Range<usize>], is_grid: &[bool]) -> Self {
        let kinds: Vec<(Range<usize>, bool)> = nodes.iter().cloned().zip(is_grid.iter().copied()).collect();
        let slots = Slots::new(places, edges, &kinds);
        let within = |one: &u32| (*one as usize) < places;
        assert!(slots.neighbour.iter().all(within), "neighbours are places of their level");
        let bodies: Vec<Range<usize>> =
            nodes.iter().map(|nodes| nodes.start..nodes.end.next_multiple_of(LANES)).collect();
        let (mut chunks, mut chunks_of) = (Vec::new(), Vec::new());
        for (body, all) in bodies.iter().enumerate() {
            let from = chunks.len();
            for start in all.clone().step_by(CHUNK) {
                let part = start..all.end.min(start + CHUNK);
                chunks.push(Chunk { body, part, number: chunks.len() });
            }
            chunks_of.push(from..chunks.len());
        }
        Self {
            chunks,
            chunks_of,
            goes_on: vec![false; bodies.len()],
            ends: nodes.iter().map(|nodes| (1..=FEW).contains(&nodes.len())).collect(),
            slots,
            places,
            bodies,
            sources: Weighted::default(),
            children: Weighted::default(),
            parents: Vec::new(),
        }
    }

    /// Notes the next coarser level.
    fn follow(&mut self, coarser: &Level) {
        // What is not there is one of its own body, too, if that goes on: 0 times what has blown up elsewhere is no number. Nodes of such a
        // body all have a parent, and its padding follows that of its last node.
        let mut own = 0;
        let mut slice = |first: usize| {
            let mut all = Parents { nodes: [[0; LANES]; PARENTS], weights: [[T::ZERO; LANES]; PARENTS] };
            for lane in 0..LANES {
                let row = coarser.parents.row(first + lane);
                own = row.first().map_or(own, |parent| parent.0);
                for at in 0..PARENTS {
                    let (node, weight) = row.get(at).copied().unwrap_or((own, 0.0));
                    (all.nodes[at][lane], all.weights[at][lane]) = (node, T::from_f64(f64::from(weight)));
                }
            }
            all
        };
        self.parents = (0..self.places).step_by(LANES).map(&mut slice).collect();
        for (body, nodes) in coarser.bodies.iter().enumerate() {
            self.goes_on[body] = !nodes.is_empty();
            self.ends[body] &= nodes.is_empty();
        }
    }

    /// Number of slots.
    pub fn count(&self) -> usize {
        self.slots.neighbour.len()
    }

    /// Whether one worker alone does what is left from here on.
    pub fn is_small(&self) -> bool {
        self.places <= ALONE
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let weighted = |one: &Weighted| 4 * one.offsets.len() + 8 * one.items.len();
        8 * self.count()
            + 4 * self.slots.of_edge.len()
            + weighted(&self.sources)
            + weighted(&self.children)
            + self.parents.len() * size_of::<Parents<T>>()
    }
}

/// What a node's children give it of their diagonals, beside edges and couplings.
#[inline(always)]
pub fn own_of_children<T: Real>(children: &Weighted, finer: &View<'_, T>, place: usize) -> Symmetric<T> {
    let mut own = [T::ZERO; 6];
    for &(child, weight) in children.row(place) {
        own = add_weighted(own, T::from_f64(f64::from(weight)), finer.at(child as usize));
    }
    own
}
