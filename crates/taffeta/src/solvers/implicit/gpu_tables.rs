//! Tables of springs that are solved for by nodes: levels of nodes, and what leads from one to the next.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::elements::gpu::{ElementTables, Set};
use crate::gpu::bodies::Bodies;
use crate::gpu::layout::{Four, GROUP, NONE};
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::implicit::couplings::{self, Couplings, Solved};
use crate::solvers::implicit::gpu_layout::{
    CoarseEdge, LevelGroup, Parents, SlotSpring, VECTORS, WeightedIndex, When,
};
use crate::solvers::implicit::gpu_sewn::SewnLists;
use crate::solvers::implicit::levels::Level;
use crate::solvers::implicit::slots::{NO_EDGE, Slots};
use crate::solvers::iterations as needed;
use crate::topology::LANES;
use std::ops::Range;

/// Nodes of a level of which one workgroup does all that is left.
const FEW: usize = GROUP;

/// The levels of some bodies; none where its springs are not solved for by nodes.
#[derive(Default)]
pub struct MultigridTables {
    /// Groups of all bodies, by level.
    pub groups: Vec<Vec<LevelGroup>>,
    /// Of them those of coarser levels that are in no tail, by level from the first coarser one on.
    pub wide: Vec<Vec<LevelGroup>>,
    /// Levels of few nodes, a group each.
    pub tail: Vec<LevelGroup>,
    /// Number of nodes on the finest level, and on all.
    pub finest: usize,
    pub nodes: usize,
    /// Slots of the finest level, and of all others.
    pub slot_counts: [usize; 2],
    /// Where the others begin, starts of slices, neighbours.
    pub slots: Vec<u32>,
    pub slot_springs: Vec<SlotSpring>,
    pub parents: Vec<Parents>,
    /// Starts, then children.
    pub children: Vec<WeightedIndex>,
    /// Edges of each coarser level.
    pub edges: Vec<Vec<CoarseEdge>>,
    pub edge_weights: Vec<WeightedIndex>,
    /// Blocks of other elements, where some are solved for.
    pub couplings: Option<CouplingWords>,
    /// Number of systems.
    pub solves: usize,
    /// Points that seams make.
    pub sewn: Option<SewnLists>,
    /// The same bodies once all seams are closed, where that makes a difference to their coarser levels. It has no tails: a system
    /// may have more nodes than a workgroup has lanes.
    pub sewn_levels: Option<Box<Self>>,
    /// Workgroups of the kernels that linearise elements, where a further Newton step may follow.
    linearised: Vec<u32>,
    /// Iterations of each that they need at most.
    pub iterations: u32,
}

/// Blocks of elements on all levels, as shaders see them.
#[derive(Clone, Default)]
pub struct CouplingWords {
    /// A record for each node on all levels, then slots.
    pub words: Vec<[u32; 4]>,
    /// Forces by node, and what blocks are made of.
    pub sources: Vec<[u32; 2]>,
}

/// A level, its nodes and edges counted from its own first.
struct Part {
    /// Its first place and edge among those of the scene.
    first: usize,
    first_edge: usize,
    /// Nodes of each body.
    bodies: Vec<Range<usize>>,
    places: usize,
    slots: Slots,
    /// Slots of each edge.
    of_edge: Vec<[u32; 2]>,
}

/// Workgroups of each kind of elements that are solved for.
fn linearised(elements: &ElementTables) -> Vec<u32> {
    let sets = elements.kinds.iter().map(|tables| &tables.set).filter(|set| set.is_solved_for());
    sets.map(|set| set.range.len().div_ceil(GROUP) as u32).collect()
}

/// Bytes of the arrays that a body needs to be solved for by nodes, and what they hold.
pub fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    if !assembly.solver.is_primal() {
        return Vec::new();
    }
    let springs = assembly.constraints().bodies.get(body).map_or(0, Range::len);
    let nodes = assembly.bodies[body].places() + coarser_nodes(assembly, body);
    vec![
        ((nodes * VECTORS * size_of::<Four>()) as u64, "vectors of springs"),
        // Slots of a slice are as many as its longest node has.
        ((springs * size_of::<Four>() * 5 / 2) as u64, "blocks of springs"),
        (blocks_of_elements(assembly, body, springs), "blocks of elements"),
    ]
}

/// Bytes of the blocks of a body's elements on all levels, or of what they are made of beside so many springs, about.
fn blocks_of_elements(assembly: &Assembly, body: usize, springs: usize) -> u64 {
    let mut pairs: Vec<[u32; 2]> = Vec::new();
    for list in assembly.elements().iter().filter(|list| list.implicit) {
        for (nodes, _) in list.of(list.bodies[body].clone()) {
            let others = |&a: &u32| nodes.iter().filter(move |&&b| a < b).map(move |&b| [a, b]);
            pairs.extend(nodes.iter().flat_map(others));
        }
    }
    pairs.sort_unstable();
    pairs.dedup();
    if pairs.is_empty() {
        return 0;
    }
    // Two slots each. Coarser levels have a third as many nodes in all, with somewhat longer rows. A block goes to those between
    // all that its two nodes follow.
    let blocks = 2 * pairs.len() * ROWS * size_of::<[u32; 4]>() * 3 / 2;
    let sources = 2 * (pairs.len() + springs) * 7 * size_of::<[u32; 2]>();
    blocks.max(sources) as u64
}

/// Nodes that a body has on all its coarser levels.
fn coarser_nodes(assembly: &Assembly, body: usize) -> usize {
    assembly.levels().iter().map(|level| level.bodies[body].len().next_multiple_of(LANES)).sum()
}

impl Part {
    /// Some bodies of a level that has these edges.
    fn new(bodies: &[Range<usize>], edges: &[[u32; 2]]) -> Self {
        let first = bodies.first().map_or(0, |body| body.start);
        let end = bodies.last().map_or(first, |body| body.end.next_multiple_of(LANES));
        // Those of a body follow those of the bodies before it.
        let before = |place: usize| edges.partition_point(|ends| (ends[0] as usize) < place);
        let of_bodies = before(first)..before(end);
        let bodies: Vec<Range<usize>> =
            bodies.iter().map(|body| body.start - first..body.end - first).collect();
        let local: Vec<[u32; 2]> =
            edges[of_bodies.clone()].iter().map(|ends| ends.map(|node| node - first as u32)).collect();
        let kinds: Vec<(Range<usize>, bool)> = bodies.iter().map(|body| (body.clone(), false)).collect();
        let slots = Slots::new(end - first, &local, &kinds);
        let mut of_edge: Vec<[u32; 2]> = slots.of_edge.iter().map(|&slot| [slot; 2]).collect();
        for (slot, &edge) in (0..).zip(&slots.edge).filter(|(_, edge)| **edge != NO_EDGE) {
            let [at_first, at_second] = &mut of_edge[edge as usize];
            if *at_first != slot {
                *at_second = slot;
            }
        }
        Self { first, first_edge: of_bodies.start, bodies, places: end - first, slots, of_edge }
    }

    /// Number of slots.
    fn count(&self) -> usize {
        self.slots.neighbour.len()
    }
}

impl MultigridTables {
    /// Whether there is nothing to solve for.
    pub fn is_empty(&self) -> bool {
        self.solves == 0
    }

    /// By place, of which there are so many, which of the systems its body has; NONE without.
    pub fn systems(&self, places: usize) -> Vec<u32> {
        let mut all = vec![NONE; places];
        for group in self.groups.first().into_iter().flatten() {
            all[group.first as usize..(group.first + group.count) as usize].fill(group.solve);
        }
        all
    }

    /// What is counted on the device: workgroups, and when they run. First those of iterations, by level, tails last.
    pub fn counted(&self) -> Vec<[u32; 2]> {
        let cycle = [&self.groups[0]].into_iter().chain(&self.wide).chain([&self.tail]);
        let mut all: Vec<[u32; 2]> =
            cycle.map(|groups| [groups.len() as u32, When::Iterated as u32]).collect();
        let finest = self.groups[0].len() as u32;
        let levels = self.groups.iter().map(|groups| groups.len() as u32);
        let edges = self.edges.iter().map(|edges| edges.len().div_ceil(GROUP) as u32);
        let linearised = [finest].into_iter().chain(self.linearised.iter().copied());
        let points = || [self.point_groups()].into_iter();
        let sewn = self.sewn_levels.iter().flat_map(|sewn| &sewn.wide).map(|groups| groups.len() as u32);
        let further = linearised
            .chain(levels)
            .chain(edges)
            .chain(points())
            .map(|one| [one, When::Begun as u32])
            .chain(sewn.chain(points()).map(|one| [one, When::Iterated as u32]));
        for one in further.filter(|one| one[0] > 0) {
            // Those of the same size share their count.
            if !all.contains(&one) {
                all.push(one);
            }
        }
        all
    }

    /// Workgroups of kernels that have an invocation for each point that seams make.
    pub fn point_groups(&self) -> u32 {
        self.sewn.as_ref().map_or(0, |lists| (lists.starts.len() - 1).div_ceil(GROUP) as u32)
    }

    /// The levels of some bodies, and what seams make of them.
    pub fn new(bodies: &Bodies<'_>, elements: &ElementTables) -> Result<Self, String> {
        let assembly = bodies.assembly;
        let mut multigrid = Self::of_levels(bodies, elements, assembly.levels(), true)?;
        if multigrid.is_empty() {
            return Ok(multigrid);
        }
        let Some(points) = assembly.sewn_points() else { return Ok(multigrid) };
        multigrid.sewn = SewnLists::new(bodies, &points);
        if multigrid.couplings.is_some()
            && multigrid.sewn.is_some()
            && let Some(levels) = assembly.sewn_levels(&points)
        {
            multigrid.sewn_levels = Some(Box::new(Self::of_levels(bodies, elements, &levels, false)?));
        }
        Ok(multigrid)
    }

    /// The levels of some bodies; those of few nodes are tails, if asked for.
    fn of_levels(
        bodies: &Bodies<'_>,
        elements: &ElementTables,
        levels: &[Level],
        has_tails: bool,
    ) -> Result<Self, String> {
        let (assembly, bodies) = (bodies.assembly, bodies.range.clone());
        let all = assembly.constraints();
        if !assembly.solver.is_primal() {
            return Ok(Self::default());
        }
        let acts = |body: usize| assembly.is_solved_for(body);
        let coupled = bodies.clone().any(|body| assembly.has_solved_elements(body));
        let solves = bodies.clone().filter(|&body| acts(body)).count();
        if solves == 0 {
            return Ok(Self::default());
        }
        let nodes = |body: usize| {
            let BodyAssembly { first, nodes, .. } = &assembly.bodies[body];
            *first..first + if acts(body) { *nodes } else { 0 }
        };
        let places: Vec<Range<usize>> = bodies.clone().map(nodes).collect();
        let coarser = levels.iter().map(|level| {
            // Blocks of springs go over to those of elements on coarser levels.
            Part::new(&level.bodies[bodies.clone()], if coupled { &[] } else { &level.edges })
        });
        let parts: Vec<Part> = std::iter::once(Part::new(&places, &all.ends))
            .chain(coarser.take_while(|part| part.places > 0))
            .collect();
        let mut multigrid = Self {
            solves,
            linearised: linearised(elements),
            iterations: needed::descents(assembly, bodies.clone()),
            ..Self::default()
        };
        multigrid.list_springs(assembly, &parts[0]);
        if coupled {
            multigrid.edges = vec![Vec::new(); parts.len() - 1];
        } else {
            multigrid.list_edges(&parts, levels);
        }
        multigrid.lay_out(&parts)?;
        multigrid.follow(&parts, levels);
        multigrid.cut(&parts, has_tails);
        if let Some(couplings) = couplings::Tables::new(assembly, levels, &bodies, &parts[0].slots) {
            let places: Vec<usize> = parts.iter().map(|part| part.places).collect();
            let mut words = CouplingWords::new(&couplings, &places, elements)?;
            let with_elements = |body: &usize| assembly.has_solved_elements(*body);
            for body in bodies.clone().filter(with_elements) {
                words.mark(&parts, body - bodies.start);
            }
            multigrid.couplings = Some(words);
        }
        Ok(multigrid)
    }

    /// What each slot of the finest level is.
    fn list_springs(&mut self, assembly: &Assembly, finest: &Part) {
        let all = assembly.constraints();
        let spring = |&edge: &u32| {
            if edge == NO_EDGE {
                return SlotSpring::default();
            }
            let number = finest.first_edge + edge as usize;
            let [k, damping] = all.materials[all.material[number] as usize].map(|c| c as f32);
            SlotSpring { k, damping, rest_length: all.rest[number] as f32 }
        };
        self.slot_springs = finest.slots.edge.iter().map(spring).collect();
    }

    /// The edges of all coarser levels, and of what they are made.
    fn list_edges(&mut self, parts: &[Part], levels: &[Level]) {
        // Those of the finest level are counted by themselves, those of others from the first of all others.
        let (mut base_finer, mut base) = (0, 0);
        for (pair, level) in parts.windows(2).zip(levels) {
            let (finer, here) = (&pair[0], &pair[1]);
            let slot = |source: u32| base_finer + finer.of_edge[source as usize - finer.first_edge][0];
            let mut edges = Vec::with_capacity(here.of_edge.len());
            for (number, slots) in (here.first_edge..).zip(&here.of_edge) {
                let (first, row) = (self.edge_weights.len() as u32, level.sources.row(number));
                self.edge_weights
                    .extend(row.iter().map(|&(source, weight)| WeightedIndex { at: slot(source), weight }));
                edges.push(CoarseEdge {
                    slots: slots.map(|slot| base + slot),
                    first,
                    count: row.len() as u32,
                });
            }
            self.edges.push(edges);
            (base_finer, base) = (base, base + here.count() as u32);
        }
    }

    /// Slots of all levels in one array.
    fn lay_out(&mut self, parts: &[Part]) -> Result<(), String> {
        (self.finest, self.nodes) = (parts[0].places, parts.iter().map(|part| part.places).sum());
        self.slot_counts = [parts[0].count(), parts[1..].iter().map(Part::count).sum()];
        let header = self.nodes / LANES + 2;
        if u32::try_from(header + self.slot_counts.iter().sum::<usize>()).is_err() {
            return Err("too many springs for 32 bits".to_owned());
        }
        self.slots = vec![(header + self.slot_counts[0]) as u32];
        let (mut node, mut slot, mut neighbours) = (0, header, Vec::new());
        for part in parts {
            let starts = &part.slots.starts[..part.places / LANES];
            self.slots.extend(starts.iter().map(|&groups| (slot + LANES * groups as usize) as u32));
            neighbours.extend(part.slots.neighbour.iter().map(|&other| node as u32 + other));
            (node, slot) = (node + part.places, slot + part.count());
        }
        self.slots.push(slot as u32);
        self.slots.extend(neighbours);
        Ok(())
    }

    /// Parents of all nodes, and the other way round.
    fn follow(&mut self, parts: &[Part], levels: &[Level]) {
        let (mut rows, mut node) = (Weighted::default(), 0);
        for (pair, level) in parts.windows(2).zip(levels) {
            let (finer, here) = (&pair[0], &pair[1]);
            node += finer.places;
            for place in finer.first..finer.first + finer.places {
                let parent =
                    |&(parent, weight): &(u32, f32)| ((node + parent as usize - here.first) as u32, weight);
                rows.push(level.parents.row(place).iter().map(parent));
            }
        }
        (rows.rows()..self.nodes).for_each(|_| rows.push([]));
        let parents = |node: usize| {
            // What is not there is the node itself, times 0.
            let mut all = Parents { nodes: [node as u32; 4], weights: [0.0; 4] };
            for (i, &(parent, weight)) in rows.row(node).iter().enumerate().take(4) {
                (all.nodes[i], all.weights[i]) = (parent, weight);
            }
            all
        };
        self.parents = (0..self.nodes).map(parents).collect();
        let children = rows.transposed(self.nodes);
        let header = self.nodes as u32 + 1;
        let starts = children.offsets.iter().map(|&start| WeightedIndex { at: header + start, weight: 0.0 });
        let items = children.items.iter().map(|&(at, weight)| WeightedIndex { at, weight });
        self.children = starts.chain(items).collect();
    }

    /// Cuts the bodies' nodes into groups.
    fn cut(&mut self, parts: &[Part], has_tails: bool) {
        let bodies = parts[0].bodies.iter().enumerate().filter(|(_, nodes)| !nodes.is_empty());
        let solving: Vec<usize> = bodies.map(|(body, _)| body).collect();
        self.groups = vec![Vec::new(); parts.len()];
        self.wide = vec![Vec::new(); parts.len() - 1];
        for (solve, &body) in (0..).zip(&solving) {
            let (mut node, mut tail) = (0, Vec::new());
            for (level, part) in parts.iter().enumerate() {
                let nodes = &part.bodies[body];
                add_groups(&mut self.groups[level], solve, node + nodes.start, nodes.len());
                if level > 0 && (nodes.len() > FEW || !has_tails) {
                    add_groups(&mut self.wide[level - 1], solve, node + nodes.start, nodes.len());
                } else if level > 0 && !nodes.is_empty() {
                    tail.push((node + nodes.start, nodes.len()));
                }
                node += part.places;
            }
            let first_group = self.tail.len() as u32;
            self.tail.extend(tail.iter().map(|&(first, count)| LevelGroup {
                first: first as u32,
                count: count as u32,
                solve,
                first_group,
                groups: tail.len() as u32,
            }));
        }
    }
}

/// Marks the slot of a spring among sources.
pub const SPRING: u32 = 1 << 31;
/// Words from one row of a block to the next, and rows of a block.
pub const ROW: usize = LANES;
const ROWS: usize = 3;

impl CouplingWords {
    /// Those of levels with so many places each.
    fn new(tables: &couplings::Tables, places: &[usize], elements: &ElementTables) -> Result<Self, String> {
        let slots = tables.finest.len() + tables.coarser.iter().map(Couplings::len).sum::<usize>();
        let header: usize = places.iter().sum();
        if header + ROWS * slots >= SPRING as usize {
            return Err("too many blocks of elements for 32 bits".to_owned());
        }
        let mut all = Self::default();
        all.words.resize(header + ROWS * slots, [0; 4]);
        let sets: Vec<&Set> =
            elements.kinds.iter().map(|one| &one.set).filter(|set| set.is_solved_for()).collect();
        let kind = |first: fn(&Solved) -> usize, index: u32| {
            tables.solved.partition_point(|one| first(one) <= index as usize) - 1
        };
        let force = |index: u32| {
            let kind = kind(|one| one.first_force, index);
            index + (sets[kind].first_force - tables.solved[kind].first_force) as u32
        };
        let direction = |index: u32| {
            let kind = kind(|one| one.first_direction, index);
            index + (sets[kind].directions.start - tables.solved[kind].first_direction) as u32
        };
        for node in 0..places[0] {
            let start = all.sources.len() as u32;
            all.sources.extend(tables.forces.row(node).iter().map(|&index| [force(index), 0]));
            [all.words[node][2], all.words[node][3]] = [start, all.sources.len() as u32];
        }
        let (mut node, mut first) = (0, header);
        all.add_level((node, first), &tables.finest, |[a, b]| [direction(a), direction(b)]);
        let mut finer = (first, tables.finest.len());
        first += ROWS * tables.finest.len();
        for (level, (count, couplings)) in places.iter().zip(&tables.coarser).enumerate() {
            node += count;
            all.add_level((node, first), couplings, |(slot, weight)| {
                let source = match (slot as usize).checked_sub(finer.1) {
                    Some(spring) if level == 0 => SPRING | spring as u32,
                    _ => address(finer.0, slot as usize),
                };
                [source, weight.to_bits()]
            });
            finer = (first, couplings.len());
            first += ROWS * couplings.len();
        }
        Ok(all)
    }

    /// Marks the nodes of a body that has elements on all coarser levels.
    fn mark(&mut self, parts: &[Part], body: usize) {
        let mut first = parts[0].places;
        for part in &parts[1..] {
            for node in part.bodies[body].clone() {
                self.words[first + node][3] = 1;
            }
            first += part.places;
        }
    }

    /// Adds a level whose nodes and slots begin there.
    fn add_level<S: Copy>(
        &mut self,
        (node, first): (usize, usize),
        couplings: &Couplings<S>,
        source: impl Fn(S) -> [u32; 2],
    ) {
        for local in 0..(couplings.starts.len() - 1) * LANES {
            let slots: Vec<(usize, usize)> = couplings.row(local).collect();
            let has_sum = !couplings.groups(local / LANES).is_empty();
            let start = if has_sum { address(first, couplings.sum_of(local)) } else { 0 };
            [self.words[node + local][0], self.words[node + local][1]] = [start, slots.len() as u32];
            for (slot, other) in slots {
                let at = address(first, slot) as usize;
                let from = self.sources.len() as u32;
                self.sources.extend(couplings.sources(slot).iter().map(|&one| source(one)));
                self.words[at][3] = (node + other) as u32;
                self.words[at + ROW][3] = from;
                self.words[at + 2 * ROW][3] = self.sources.len() as u32;
            }
        }
    }
}

/// Where the first row of a slot's block is, of a level whose slots begin there.
fn address(first: usize, slot: usize) -> u32 {
    (first + slot / LANES * ROWS * ROW + slot % LANES) as u32
}

/// Adds the groups of a body's nodes.
fn add_groups(groups: &mut Vec<LevelGroup>, solve: u32, first: usize, nodes: usize) {
    let first_group = groups.len() as u32;
    groups.extend((0..nodes).step_by(GROUP).map(|start| LevelGroup {
        first: (first + start) as u32,
        count: GROUP.min(nodes - start) as u32,
        solve,
        first_group,
        groups: nodes.div_ceil(GROUP) as u32,
    }));
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, ConstraintForm, Icosphere, Mass, Mesh, Method, Scene};

    fn assembly() -> Assembly {
        let heavy = |body: Body| body.with_mass(Mass::Node(0.1)).structural(9.0, 0.0).bend(1.0, 0.0);
        let ball = || Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 3 });
        let mut scene = Scene::new("")
            .method(Method::Ice)
            .body(heavy(Body::cloth("first", Mesh::grid(20, 30, [1.0, 1.5]))))
            .body(Body::cloth("bare", Mesh::grid(9, 9, [1.0, 1.0])).with_mass(Mass::Node(0.1)))
            .body(heavy(Body::soft("ball", ball())))
            .body(heavy(Body::cloth("last", Mesh::grid(40, 50, [1.0, 1.0]))));
        scene.solver.ice.form = ConstraintForm::Primal;
        Assembly::new(&scene).unwrap()
    }

    fn of(assembly: &Assembly, bodies: Range<usize>) -> MultigridTables {
        let bodies = Bodies::new(assembly, bodies);
        MultigridTables::new(&bodies, &ElementTables::new(&bodies)).unwrap()
    }

    /// Slots of a node, and the nodes at their other ends.
    fn slots_of(multigrid: &MultigridTables, node: usize) -> Vec<(usize, usize)> {
        let slots = &multigrid.slots;
        let range = slots[1 + node / LANES] as usize + node % LANES..slots[2 + node / LANES] as usize;
        range.step_by(LANES).map(|at| (at, slots[at] as usize)).filter(|&(_, other)| other != node).collect()
    }

    #[test]
    fn slots_lead_both_ways_on_all_levels_and_edges_know_theirs() {
        let assembly = assembly();
        for bodies in [0..4, 1..3, 2..4] {
            let multigrid = of(&assembly, bodies);
            let leads = |from: usize, to: usize| slots_of(&multigrid, from).iter().any(|slot| slot.1 == to);
            let mut owner = vec![usize::MAX; multigrid.slots.len()];
            for node in 0..multigrid.nodes {
                for (at, other) in slots_of(&multigrid, node) {
                    assert!(leads(other, node), "{node} to {other}");
                    owner[at] = node;
                }
            }
            for edge in multigrid.edges.iter().flatten() {
                let [a, b] = edge.slots.map(|slot| (slot + multigrid.slots[0]) as usize);
                assert_eq!([owner[a], owner[b]], [multigrid.slots[b] as usize, multigrid.slots[a] as usize]);
            }
        }
    }

    #[test]
    fn children_are_those_that_follow_a_node() {
        let multigrid = of(&assembly(), 0..4);
        let mut all = 0;
        for node in 0..multigrid.nodes {
            let range = multigrid.children[node].at as usize..multigrid.children[node + 1].at as usize;
            for child in &multigrid.children[range] {
                let Parents { nodes, weights } = multigrid.parents[child.at as usize];
                assert!(nodes.iter().zip(weights).any(|one| one == (&(node as u32), child.weight)));
                all += 1;
            }
        }
        let followed = multigrid.parents.iter().flat_map(|one| one.weights).filter(|weight| *weight > 0.0);
        assert_eq!(followed.count(), all);
    }

    #[test]
    fn every_node_of_a_level_is_in_one_group_and_levels_of_few_nodes_are_tails() {
        let multigrid = of(&assembly(), 0..4);
        assert_eq!(
            (multigrid.solves, multigrid.wide[0].iter().map(|group| group.count).sum::<u32>()),
            (3, 21 * 26)
        );
        let count = |groups: &[LevelGroup]| groups.iter().map(|group| group.count).sum::<u32>();
        let coarser: u32 = multigrid.groups[1..].iter().map(|groups| count(groups)).sum();
        let wide: u32 = multigrid.wide.iter().map(|groups| count(groups)).sum();
        assert_eq!(coarser, wide + count(&multigrid.tail));
        assert!(multigrid.tail.iter().all(|group| group.count as usize <= FEW));
    }
}
