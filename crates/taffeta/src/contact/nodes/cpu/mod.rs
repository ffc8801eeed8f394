//! Self-collision on the CPU: broad phase, narrow phase and response.
//!
//! Neighbouring nodes form clusters, and clusters form groups.
//! - A search finds the pairs of groups that are near each other. It is repeated when other groups may have come
//!   near.
//! - Each pair of groups lists its pairs of clusters that are near each other. The list is renewed when other
//!   clusters may have come near.
//! - The narrow phase computes the distance of the nodes of two clusters, and again when bounds of their motion have
//!   used up that distance.
//!
//! So contacts do not depend on when a search or a check was made.

mod broad_phase;
mod clusters;
mod contact_list;
mod exclusion_masks;
mod narrow_phase;
mod response;
#[cfg(test)]
mod tests;

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::contact::clusters::bounds::{ClusterPair, GroupPair};
use crate::contact::clusters::margin::{Margin, extent};
use crate::contact::clusters::packed::{GROUP, Packed};
use crate::contact::clusters::tree::{Boxes, Tree};
use crate::contact::layers::Meetings;
use crate::contact::nodes::pair::{self, ContactMaterial};
use crate::cpu::backend::Context;
use crate::cpu::cells::PerWorker;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::numbers::Numbers;
use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::cpu::tile::{Fields, Tile};
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::real::Real;
use crate::report::{FrameSums, PairSums};
use crate::step::Op;
use crate::topology::LANES;
use crate::topology::boxes::{Bounds, NOWHERE, join};
use clusters::{Cluster, Pack, clusters};
use contact_list::ContactList;
use exclusion_masks::ExclusionMasks;
use std::ops::Range;
use std::sync::atomic::AtomicU32;

/// Self-collision of nodes with a thickness.
pub struct NodeContact<T> {
    setup: ContactSetup<T>,
    work: ContactWork<T>,
    scratch: PerWorker<ContactScratch<T>>,
}

/// What is constant.
struct ContactSetup<T> {
    /// Half the thickness [m] by body; 0: it does not collide.
    radius: Vec<T>,
    /// Body by place.
    body: Vec<u32>,
    /// The contact material of each body.
    surfaces: Vec<ContactMaterial<T>>,
    /// Tile by place.
    tile: Vec<u32>,
    /// The largest thickness [m].
    widest: f64,
    /// Mean diagonals of a cluster and of a group at the start [m].
    diagonals: [f64; 2],
    /// Clusters, worker by worker.
    clusters: Vec<Cluster>,
    /// Their nodes, by lane.
    nodes: Vec<[u32; LANES]>,
    /// Exclusion lists.
    exclusions: ExclusionMasks,
    /// The clusters of each worker.
    chunks: Vec<Range<usize>>,
    /// The clusters of each group.
    groups: Vec<Range<usize>>,
    /// Trees of boxes around groups, by worker.
    trees: Vec<Tree>,
    /// Which bodies meet.
    meetings: Meetings,
}

/// Results that workers share.
struct ContactWork<T> {
    /// Contacts of each place in this sub-step.
    contacts: Vec<AtomicU32>,
    /// Positions of the nodes of each cluster [m].
    packed: Shared<Packed<T>>,
    /// Motion of each cluster since the last search [m], as [`Pack`] defines it.
    moved: Shared<[f64; 4]>,
    /// Motion of the nodes of each group in this sub-step, as [`Pack`] defines it.
    balls: Shared<[f64; 4]>,
    /// Bounds of the motion of each worker's nodes in this sub-step [m]: the least along each axis, then the most.
    motion: Numbers<6>,
    /// Boxes around groups.
    boxes: Shared<Boxes<T>>,
    /// Of each worker in this sub-step: the number of pairs, counted once for each of their nodes that it has; and the least distance
    /// of a pair, relative to its thickness.
    found: Numbers<2>,
}

/// The least and the most along each axis.
fn flat([[a, b, c], [x, y, z]]: Bounds) -> [f64; 6] {
    [a, b, c, x, y, z]
}

/// What is found where there are no contacts.
const NONE_FOUND: [f64; 2] = [0.0, f64::INFINITY];

/// The scratch memory of a worker.
struct ContactScratch<T> {
    /// What is left of the last search.
    search: Margin,
    /// Pairs of groups, one of which is this worker's.
    group_pairs: Vec<GroupPair<ClusterPair>>,
    /// Empty lists, for reuse.
    spare: Vec<Vec<ClusterPair>>,
    /// Groups near one group.
    around: Vec<u32>,
    /// Boxes yet to be visited.
    stack: Vec<(usize, usize)>,
    /// Squared distances of clusters of two groups [m²].
    squared: [[T; GROUP]; GROUP],
    /// Nodes in contact.
    contact_list: ContactList,
    /// Position and velocity of each of them after contact.
    responses: Vec<[T; 6]>,
}

impl<T: Real> ContactSetup<T> {
    /// The setup of a scene whose tiles are cut into chunks; `None` if no body collides with itself.
    pub fn new(assembly: &Assembly, tiles: &[TilePlan], chunks: &[Range<usize>]) -> Option<Self> {
        Self::with(assembly, tiles, chunks, None)
    }

    /// The same for other chunks, of a scene that may have started.
    pub fn again(&self, assembly: &Assembly, tiles: &[TilePlan], chunks: &[Range<usize>]) -> Option<Self> {
        Self::with(assembly, tiles, chunks, Some(self.diagonals))
    }

    fn with(
        assembly: &Assembly,
        tiles: &[TilePlan],
        chunks: &[Range<usize>],
        diagonals: Option<[f64; 2]>,
    ) -> Option<Self> {
        let (mut all, mut groups) = (Vec::new(), Vec::new());
        let (mut owned, mut trees): (Vec<Range<usize>>, Vec<Tree>) = (Vec::new(), Vec::new());
        for chunk in chunks {
            let (first, first_group) = (all.len(), groups.len());
            all.extend(clusters(assembly, &tiles[chunk.clone()]));
            owned.push(first..all.len());
            let ends = (first..all.len()).step_by(GROUP);
            groups.extend(ends.map(|start| start..all.len().min(start + GROUP)));
            let boxes = trees.last().map_or(0, |last| last.boxes.end);
            trees.push(Tree::new(first_group..groups.len(), boxes));
        }
        if all.is_empty() {
            return None;
        }
        let mut tile = vec![0; assembly.places];
        for (number, plan) in tiles.iter().enumerate() {
            plan.runs().for_each(|(_, run)| tile[run].fill(number as u32));
        }
        let mut body = vec![0; assembly.places];
        let mut nodes = vec![[0; LANES]; all.len()];
        for (cluster, nodes) in all.iter().zip(&mut nodes) {
            for (lane, node) in cluster.nodes().enumerate() {
                (nodes[lane], body[node]) = (node as u32, cluster.body);
            }
        }
        let diagonals = diagonals.unwrap_or_else(|| {
            let of_groups = groups.iter().map(|group| diagonal(assembly, &all[group.clone()])).sum::<f64>();
            let of_clusters = all.chunks(1).map(|cluster| diagonal(assembly, cluster)).sum::<f64>();
            [of_clusters / all.len() as f64, of_groups / groups.len() as f64]
        });
        let surfaces = surfaces::<T>(assembly);
        Some(Self {
            radius: surfaces.iter().map(|surface| surface.thickness * T::from_f64(0.5)).collect(),
            body,
            widest: surfaces.iter().map(|surface| surface.thickness.to_f64()).fold(0.0, f64::max),
            diagonals,
            exclusions: ExclusionMasks::new(assembly, &all),
            surfaces,
            tile,
            clusters: all,
            nodes,
            chunks: owned,
            groups,
            trees,
            meetings: assembly.meetings().clone(),
        })
    }

    /// Bytes that it takes.
    fn bytes(&self) -> usize {
        let clusters = size_of_val(&self.clusters[..]) + size_of_val(&self.nodes[..]);
        8 * self.body.len() + clusters + self.exclusions.bytes()
    }

    fn material(&self, a: usize, b: usize) -> ContactMaterial<T> {
        let [a, b] = [a, b].map(|place| &self.surfaces[self.body[place] as usize]);
        pair::combine_materials(a, b)
    }

    /// Whether the bodies of two clusters meet.
    fn do_meet(&self, clusters: [usize; 2]) -> bool {
        let [a, b] = clusters.map(|cluster| self.clusters[cluster].body as usize);
        self.meetings.bodies(a, b)
    }

    /// Whether some clusters of two groups meet.
    fn do_groups_meet(&self, groups: [u32; 2]) -> bool {
        let [a, b] = groups.map(|group| self.groups[group as usize].clone());
        self.meetings.all_meet() || a.into_iter().any(|a| b.clone().any(|b| self.do_meet([a, b])))
    }

    /// Distance at which nodes of two clusters are in contact [m].
    fn reach(&self, clusters: [u32; 2]) -> T {
        let [a, b] = clusters.map(|cluster| self.radius[self.clusters[cluster as usize].body as usize]);
        a + b
    }

    /// Lower bound of how far nodes of two clusters are from contact, if they are no closer than a distance [m]; with
    /// a margin for rounding.
    fn gap(&self, clusters: [u32; 2], distance: T) -> f64 {
        distance.to_f64() * (1.0 - 1e-5) - self.reach(clusters).to_f64()
    }
}

/// The contact material of each body. A body that does not collide has no thickness.
fn surfaces<T: Real>(assembly: &Assembly) -> Vec<ContactMaterial<T>> {
    let of_body = |body: &BodyAssembly| {
        let surface = body.self_contact().map(|self_contact| self_contact.surface);
        let numbers = surface.map_or([0.0; 3], |s| [s.thickness, s.friction, s.restitution]);
        let [thickness, friction, restitution] = numbers.map(T::from_f64);
        ContactMaterial { thickness, friction, restitution }
    };
    assembly.bodies.iter().map(of_body).collect()
}

/// Diagonal of the box around clusters at the start [m]. If they are of several bodies, that of the first body.
fn diagonal(assembly: &Assembly, clusters: &[Cluster]) -> f64 {
    let body = &assembly.bodies[clusters[0].body as usize];
    let nodes = clusters.iter().filter(|one| one.body == clusters[0].body).flat_map(Cluster::nodes);
    extent(nodes.map(|node| [body.start[node - body.first]; 2]).fold(NOWHERE, join))
}

impl<T: Real> ContactWork<T> {
    /// Memory for the pairs of a scene.
    fn new(setup: &ContactSetup<T>, workers: usize) -> Self {
        let (places, clusters) = (setup.body.len(), setup.clusters.len());
        let boxes = setup.trees.last().map_or(0, |last| last.boxes.end);
        Self {
            contacts: std::iter::repeat_with(|| AtomicU32::new(0)).take(places).collect(),
            packed: vec![Packed([[T::ZERO; LANES]; 3]); clusters].into(),
            moved: vec![[0.0; 4]; clusters].into(),
            balls: vec![[0.0; 4]; setup.groups.len()].into(),
            motion: Numbers::all(workers, flat(NOWHERE)),
            boxes: vec![Boxes::empty(); boxes].into(),
            found: Numbers::all(workers, NONE_FOUND),
        }
    }

    /// The contacts of all workers in the last sub-step.
    fn found(&self) -> [f64; 2] {
        let add = |[ends, nearest]: [f64; 2], [more, other]: [f64; 2]| [ends + more, nearest.min(other)];
        self.found.iter().fold(NONE_FOUND, add)
    }

    /// Bytes that it takes.
    fn bytes(&self) -> usize {
        4 * self.contacts.len() + self.packed.bytes() + self.moved.bytes() + self.boxes.bytes()
    }
}

impl<T: Real> NodeContact<T> {
    /// Self-collision of a scene; `None` if no body has it.
    pub fn new(context: &Context<'_, T>) -> Option<Self> {
        let setup = ContactSetup::new(context.assembly, &context.nodes.tiles, context.chunks)?;
        Some(Self::with(setup, context.assembly.places, context.chunks))
    }

    fn with(setup: ContactSetup<T>, places: usize, chunks: &[Range<usize>]) -> Self {
        let scratch = |worker: usize| ContactScratch::new(places, chunks[worker].len());
        let work = ContactWork::new(&setup, chunks.len());
        Self { scratch: PerWorker::new(chunks.len(), scratch), setup, work }
    }

    /// A worker's part of the data.
    fn part<'w>(
        &'w self,
        worker: &'w Worker<'_, T>,
        scratch: &'w mut ContactScratch<T>,
    ) -> ContactWorker<'w, T> {
        ContactWorker {
            setup: &self.setup,
            shared: &self.work,
            scratch,
            first_tile: worker.tiles.start,
            index: worker.index,
            next: worker.next(),
            inverse_mass: &worker.nodes.inverse_mass,
            level: worker.nodes.level,
        }
    }
}

impl<T: Real> Feature<T> for NodeContact<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::SelfContact, Op::ApplySelfContact]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        let scratch = &mut *self.scratch.of(worker.index);
        self.part(worker, scratch).update_motion_bounds();
        worker.synchronise_uneven();
        let mut pairs = self.part(worker, scratch);
        if pairs.is_stale() {
            pairs.search(|| worker.synchronise());
        }
        pairs.find_contacts();
        worker.synchronise_uneven();
        let mut pairs = self.part(worker, scratch);
        let any = pairs.any();
        if any {
            pairs.respond(worker.substep.h);
            worker.synchronise_uneven();
        }
        let touches = |tile: usize| scratch.responses(tile - worker.tiles.start).len() > 0;
        worker.mark_moved(|tile| any && touches(tile));
        Flow::Go
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        let scratch = self.scratch.read(tile.worker);
        tile.move_nodes(scratch.responses(tile.number).map(|(node, state)| (node, *state)));
    }

    fn measure(&mut self, _: [&[T]; 6], substeps: usize, sums: &mut FrameSums) {
        let [ends, nearest] = if substeps > 0 { self.work.found() } else { NONE_FOUND };
        // All workers have searched equally often.
        let searches =
            self.scratch.iter_mut().map(|scratch| std::mem::take(&mut scratch.search.searches)).max();
        sums.pairs = PairSums { pairs: ends as u64 / 2, nearest, searches: searches.unwrap_or(0) };
    }

    fn has_uneven_work(&self) -> bool {
        true
    }

    fn redistribute(&mut self, assembly: &Assembly, tiles: &[TilePlan], chunks: &[Range<usize>]) {
        if let Some(setup) = self.setup.again(assembly, tiles, chunks) {
            *self = Self::with(setup, assembly.places, chunks);
        }
    }

    fn bytes(&self) -> usize {
        self.setup.bytes() + self.work.bytes()
    }
}

impl<T: Real> ContactScratch<T> {
    /// For a worker with so many tiles.
    pub fn new(places: usize, tiles: usize) -> Self {
        Self {
            search: Margin::default(),
            group_pairs: Vec::new(),
            spare: Vec::new(),
            around: Vec::new(),
            stack: Vec::new(),
            squared: [[T::ZERO; GROUP]; GROUP],
            contact_list: ContactList::new(places, tiles),
            responses: Vec::new(),
        }
    }

    /// Nodes in contact of the worker's tile number `tile`, with position and velocity after contact.
    pub fn responses(&self, tile: usize) -> impl ExactSizeIterator<Item = (usize, &[T; 6])> {
        let range = self.contact_list.of_tile(tile);
        let nodes = self.contact_list.owners()[range.clone()].iter().map(|&node| node as usize);
        nodes.zip(&self.responses[range])
    }
}

/// A worker's part of the data.
struct ContactWorker<'a, T> {
    setup: &'a ContactSetup<T>,
    shared: &'a ContactWork<T>,
    scratch: &'a mut ContactScratch<T>,
    /// Its first tile, and which worker it is.
    first_tile: usize,
    index: usize,
    /// State after the sub-step.
    next: &'a Fields<T>,
    /// Inverse masses [1/kg].
    inverse_mass: &'a [T],
    /// Instructions in use.
    level: SimdLevel,
}

impl<'a, T: Real> ContactWorker<'a, T> {
    /// State after the sub-step, of all nodes.
    fn state(&self) -> [&'a [T]; 6] {
        // SAFETY: all have written their nodes before a barrier, and change them again after another.
        self.next.each_ref().map(|column| unsafe { column.read() })
    }

    /// Its tree.
    fn tree(&self) -> &'a Tree {
        &self.setup.trees[self.index]
    }

    /// Positions of all nodes, and motion of their clusters.
    fn clusters(&self) -> (&'a [Packed<T>], &'a [[f64; 4]]) {
        // SAFETY: they are written before the barrier after `update_motion_bounds`, or that in a search, and again after the
        // sub-step's last.
        unsafe { (self.shared.packed.read(), self.shared.moved.read()) }
    }

    /// Its clusters.
    fn own(&self) -> Range<usize> {
        self.setup.chunks[self.index].clone()
    }

    /// Packs the positions of its nodes, and updates the bounds of their motion.
    pub fn update_motion_bounds(&mut self) {
        let (own, groups) = (self.own(), self.tree().groups.clone());
        // SAFETY: these are this worker's own; others read them after the next barrier, until the sub-step's last.
        let (packed, moved, balls) = unsafe {
            let balls = self.shared.balls.write(groups);
            (self.shared.packed.write(own.clone()), self.shared.moved.write(own.clone()), balls)
        };
        let clusters = &self.setup.clusters[own];
        let bounds = self.level.run(Pack { clusters, state: self.next, packed, moved, balls });
        self.shared.motion.set(self.index, flat(bounds));
    }

    /// Whether groups that are not paired may have come near each other since the last search. Called once in a
    /// sub-step, after all workers have updated their bounds.
    pub fn is_stale(&mut self) -> bool {
        let motion = self.shared.motion.iter().map(|[a, b, c, x, y, z]| [[a, b, c], [x, y, z]]);
        let search = &mut self.scratch.search;
        search.add(motion.fold(NOWHERE, join));
        !search.covers(0.0)
    }

    /// Whether any nodes are in contact.
    pub fn any(&self) -> bool {
        self.shared.found.iter().any(|[ends, _]| ends > 0.0)
    }
}
