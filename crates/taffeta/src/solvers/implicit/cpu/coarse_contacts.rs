//! Contacts between surfaces that both move, on coarser levels: Pᵀ C P of what they add to the matrix.
//!
//! A contact takes back C Σ w v of the velocities of its nodes. Where nodes follow coarser ones by P, its weights there are Pᵀ w:
//! it stays a contact, of some more nodes, and so it does from level to level. Blocks between the coarse nodes add up over
//! contacts, so that thousands of them between the same few nodes cost no more than one.

use crate::contact::triangles::cpu::solved::NO_BODY;
use crate::contact::triangles::solved::SolvedContact;
use crate::cpu::cells::PerWorker;
use crate::cpu::shared::Shared;
use crate::real::{Real, Symmetric};
use crate::solvers::implicit::cpu::ImplicitWorker;
use crate::solvers::implicit::cpu::columns::{Columns, View};
use crate::solvers::implicit::cpu::kernels::{COARSE, Lanes, add_edges};
use crate::solvers::implicit::cpu::tables::Table;
use crate::solvers::implicit::implicit::add_weighted;
use crate::topology::LANES;
use std::array::from_fn;
use std::ops::Range;

/// Contacts on a coarser level.
pub struct CoarseContacts<T> {
    /// By worker: what the contacts that it has found weigh nodes by.
    weights: PerWorker<Weights<T>>,
    /// By worker: contacts of the nodes of its share, and their blocks with other nodes.
    rows: PerWorker<Rows<T>>,
    groups: Shared<Vec<Group<T>>>,
    /// By slice of nodes: whose groups its blocks are.
    slices: Shared<Slice>,
    /// By node: Σ |w| C, which Jacobi's iteration has on the diagonal.
    shares: Columns<T>,
}

/// Nodes of contacts, and their weights.
#[derive(Clone, Debug, Default)]
struct Weights<T> {
    /// By contact: where its nodes end.
    ends: Vec<u32>,
    items: Vec<(u32, T)>,
}

/// The contacts of each node of a share.
#[derive(Clone, Debug, Default)]
struct Rows<T> {
    /// By node: where its contacts end.
    ends: Vec<u32>,
    items: Vec<Part<T>>,
}

/// One node of a contact.
#[derive(Clone, Copy, Debug)]
struct Part<T> {
    worker: u32,
    contact: u32,
    weight: T,
}

/// A block for each node of a slice, with another node.
#[derive(Clone, Copy, Debug)]
struct Group<T> {
    others: [u32; LANES],
    blocks: [[T; LANES]; COARSE],
}

/// Which of whose groups are those of a slice of nodes.
#[derive(Clone, Copy, Debug, Default)]
struct Slice {
    worker: u32,
    groups: [u32; 2],
}

/// The blocks of contacts on a level, to multiply by.
#[derive(Clone, Copy)]
pub struct CoarseBlocks<'a, T> {
    groups: &'a [Vec<Group<T>>],
    slices: &'a [Slice],
}

/// Blocks of one node with others, and Σ |w| C.
#[derive(Default)]
struct Row<T> {
    blocks: Vec<(u32, Symmetric<T>)>,
    share: Symmetric<T>,
}

/// By place of a level: which of a row's blocks may be the one with it.
struct Found(Vec<u32>);

impl<T: Real> CoarseContacts<T> {
    /// Those of a level, for so many workers.
    pub fn new(table: &Table<T>, workers: usize) -> Self {
        let mut all = Self {
            weights: PerWorker::new(0, |_| Weights::default()),
            rows: PerWorker::new(0, |_| Rows::default()),
            groups: Shared::default(),
            slices: vec![Slice::default(); table.places.div_ceil(LANES)].into(),
            shares: Columns::new(6, table.places),
        };
        all.share(workers);
        all
    }

    /// Has so many workers from the next sub-step on.
    pub fn share(&mut self, workers: usize) {
        self.weights = PerWorker::new(workers, |_| Weights::default());
        self.rows = PerWorker::new(workers, |_| Rows::default());
        self.groups = vec![Vec::new(); workers].into();
    }

    /// Bytes that it takes, but for its lists.
    pub fn bytes(&self) -> usize {
        self.slices.bytes() + self.shares.bytes()
    }

    /// What contacts add to a product.
    ///
    /// # Safety
    /// As of [`Shared::read`].
    pub unsafe fn blocks(&self) -> CoarseBlocks<'_, T> {
        // SAFETY: promised by the caller.
        unsafe { CoarseBlocks { groups: self.groups.read(), slices: self.slices.read() } }
    }

    /// What contacts add to the diagonals that Jacobi's iteration divides by.
    ///
    /// # Safety
    /// As of [`Shared::read`].
    pub unsafe fn shares(&self) -> View<'_, T> {
        // SAFETY: promised by the caller.
        unsafe { self.shares.read() }
    }
}

impl<T: Real> CoarseBlocks<'_, T> {
    /// Adds the product of a slice's blocks with a vector.
    #[inline(always)]
    pub fn add_product(&self, slice: usize, vector: &View<'_, T>, own: &Lanes<T>, sum: &mut Lanes<T>) {
        let Slice { worker, groups: [from, to] } = self.slices[slice];
        for group in &self.groups[worker as usize][from as usize..to as usize] {
            add_edges::<T, COARSE>(own, &vector.gather(&group.others), group.blocks.as_flattened(), sum);
        }
    }
}

impl<T: Real> Weights<T> {
    fn of(&self, contact: usize) -> &[(u32, T)] {
        let start = if contact == 0 { 0 } else { self.ends[contact - 1] };
        &self.items[start as usize..self.ends[contact] as usize]
    }

    /// Adds a contact by nodes of the finer level.
    fn push(&mut self, finer: &Table<T>, nodes: impl Iterator<Item = (u32, T)>) {
        let start = self.items.len();
        for (node, weight) in nodes {
            let parents = finer.parents[node as usize / LANES].of(node as usize % LANES);
            for (parent, share) in parents.into_iter().filter(|(_, share)| *share != T::ZERO) {
                let by = weight * share;
                match self.items[start..].iter_mut().find(|one| one.0 == parent) {
                    Some(one) => one.1 += by,
                    None => self.items.push((parent, by)),
                }
            }
        }
        self.ends.push(self.items.len() as u32);
    }

    fn clear(&mut self) {
        self.ends.clear();
        self.items.clear();
    }
}

impl<T: Real> Rows<T> {
    fn of(&self, row: usize) -> &[Part<T>] {
        let start = if row == 0 { 0 } else { self.ends[row - 1] };
        &self.items[start as usize..self.ends[row] as usize]
    }

    /// Those of some places, in the order of contacts, whoever has found them.
    fn list(&mut self, places: &Range<usize>, all: &[&Weights<T>]) {
        let row = |place: u32| (place as usize).checked_sub(places.start).filter(|&row| row < places.len());
        self.ends.clear();
        self.ends.resize(places.len() + 1, 0);
        for row in all.iter().flat_map(|one| &one.items).filter_map(|one| row(one.0)) {
            self.ends[row + 1] += 1;
        }
        for row in 0..places.len() {
            self.ends[row + 1] += self.ends[row];
        }
        let none = Part { worker: 0, contact: 0, weight: T::ZERO };
        self.items.clear();
        self.items.resize(self.ends[places.len()] as usize, none);
        for (worker, weights) in (0..).zip(all) {
            for contact in 0..weights.ends.len() {
                for &(place, weight) in weights.of(contact) {
                    if let Some(row) = row(place) {
                        // Where a row starts becomes where it ends.
                        let at = &mut self.ends[row];
                        self.items[*at as usize] = Part { worker, contact: contact as u32, weight };
                        *at += 1;
                    }
                }
            }
        }
        self.ends.pop();
    }
}

impl<T: Real> Row<T> {
    /// Those of a place, by its contacts.
    fn couple(
        &mut self,
        place: usize,
        parts: &[Part<T>],
        contacts: &[&[SolvedContact<T>]],
        weights: &[&Weights<T>],
        found: &mut Found,
    ) {
        self.blocks.clear();
        self.share = [T::ZERO; 6];
        for part in parts {
            let (worker, number) = (part.worker as usize, part.contact as usize);
            let one = &contacts[worker][number];
            if one.along <= T::ZERO {
                continue;
            }
            let block = one.block();
            self.share = add_weighted(self.share, part.weight.abs(), block);
            for &(other, weight) in weights[worker].of(number).iter().filter(|one| one.0 as usize != place) {
                self.add(found, other, -part.weight * weight, block);
            }
        }
    }

    fn add(&mut self, found: &mut Found, other: u32, by: T, block: Symmetric<T>) {
        let at = &mut found.0[other as usize];
        match self.blocks.get_mut(*at as usize) {
            Some((place, sum)) if *place == other => *sum = add_weighted(*sum, by, block),
            _ => {
                *at = self.blocks.len() as u32;
                self.blocks.push((other, add_weighted([T::ZERO; 6], by, block)));
            }
        }
    }
}

impl<T: Real> Group<T> {
    /// One block of each node of a slice; of nodes that have fewer, one with themselves that is nothing.
    fn of(first: usize, rows: &[Row<T>; LANES], rank: usize) -> Self {
        let of_lane = |lane: usize| {
            rows[lane].blocks.get(rank).copied().unwrap_or(((first + lane) as u32, [T::ZERO; 6]))
        };
        let lanes: [(u32, Symmetric<T>); LANES] = from_fn(of_lane);
        Self { others: lanes.map(|one| one.0), blocks: from_fn(|one| from_fn(|lane| lanes[lane].1[one])) }
    }
}

impl<T: Real> ImplicitWorker<'_, '_, T> {
    /// Finds what the contacts of a worker weigh nodes of coarser levels by. Others read it after a barrier.
    pub fn weigh_contacts(&self, contacts: &[SolvedContact<T>]) {
        let places = self.multigrid.tables[0].places;
        for (level, coarse) in self.primal.coarse_contacts.iter().enumerate() {
            let index = self.worker.index;
            let mut weights = coarse.weights.of(index);
            let finer =
                level.checked_sub(1).map(|finer| self.primal.coarse_contacts[finer].weights.read(index));
            weights.clear();
            for (number, one) in contacts.iter().enumerate() {
                let is_there = one.body != NO_BODY && one.stiffness > T::ZERO && !one.is_held;
                let corners = one
                    .nodes
                    .into_iter()
                    .zip(one.weights)
                    .filter(|&(node, weight)| is_there && weight != T::ZERO && (node as usize) < places);
                let table = &self.multigrid.tables[level];
                match &finer {
                    None => weights.push(table, corners),
                    Some(finer) => weights.push(table, finer.of(number).iter().copied()),
                }
            }
        }
    }

    /// Lists the contacts of the nodes of its share on coarser levels.
    pub fn list_contacts(&self) {
        for (level, coarse) in (1..).zip(&self.primal.coarse_contacts) {
            let weights: Vec<_> = coarse.weights.iter().collect();
            let weights: Vec<_> = weights.iter().map(|one| &**one).collect();
            coarse.rows.of(self.worker.index).list(&self.share_of(level), &weights);
        }
    }

    /// What contacts add to the diagonals of a coarser level.
    pub fn shares_of_contacts(&self, level: usize) -> Option<View<'_, T>> {
        // SAFETY: found before a barrier, and again after another.
        self.contacts_in_system().map(|_| unsafe { self.primal.coarse_contacts[level - 1].shares() })
    }

    /// The places of its share of a level.
    fn share_of(&self, level: usize) -> Range<usize> {
        let chunks = &self.multigrid.tables[level].chunks;
        let own = &chunks[self.worker.part(chunks.len())];
        match (own.first(), own.last()) {
            (Some(first), Some(last)) => first.part.start..last.part.end,
            _ => 0..0,
        }
    }

    /// Finds the blocks of contacts between the nodes of its share of coarser levels and others, and what they add to diagonals.
    pub fn couple_contacts(&self) {
        let Some(contacts) = self.contacts_in_system() else { return };
        let contacts = contacts.solved_contacts();
        let contacts: Vec<_> = contacts.iter().map(|one| &one[..]).collect();
        for (level, coarse) in (1..).zip(&self.primal.coarse_contacts) {
            let places = self.share_of(level);
            let weights: Vec<_> = coarse.weights.iter().collect();
            let weights: Vec<_> = weights.iter().map(|one| &**one).collect();
            let rows = coarse.rows.read(self.worker.index);
            // SAFETY: its own groups, slices and places.
            let (groups, slices, shares) = unsafe {
                let slices = coarse.slices.write(places.start / LANES..places.end / LANES);
                (coarse.groups.item(self.worker.index), slices, coarse.shares.write::<6>(&places))
            };
            groups.clear();
            let mut of_slice: [Row<T>; LANES] = from_fn(|_| Row::default());
            let mut found = Found(vec![0; self.multigrid.tables[level].places]);
            for (first, slice) in places.clone().step_by(LANES).zip(slices) {
                for (lane, row) in of_slice.iter_mut().enumerate() {
                    let at = first - places.start + lane;
                    row.couple(first + lane, rows.of(at), &contacts, &weights, &mut found);
                    (0..6).for_each(|one| shares[one][at] = row.share[one]);
                }
                let start = groups.len() as u32;
                let most = of_slice.iter().map(|row| row.blocks.len()).max().unwrap_or(0);
                groups.extend((0..most).map(|rank| Group::of(first, &of_slice, rank)));
                *slice = Slice { worker: self.worker.index as u32, groups: [start, groups.len() as u32] };
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Assembly;
    use crate::real::{dot, norm, scale, sub, times};
    use crate::scene::{Body, ConstraintForm, Mass, Mesh, Method, Scene};
    use crate::topology::random::SplitMix64;

    /// Levels of a sheet that gets coarser twice, and of a small one that does so once.
    fn tables() -> Vec<Table<f64>> {
        let sheet = |name: &str, n: u32| {
            let body = Body::cloth(name, Mesh::grid(n, n, [1.0, 1.0])).with_mass(Mass::Node(0.1));
            body.structural(9.0, 0.0).collide(0.01)
        };
        let mut scene = Scene::new("").method(Method::Ice).body(sheet("a", 16)).body(sheet("b", 6));
        scene.solver.ice.form = ConstraintForm::Primal;
        let assembly = Assembly::new(&scene).unwrap();
        Table::all(&assembly, assembly.levels())
    }

    /// Contacts of any nodes of both sheets, some of nodes of one alone.
    fn contacts(tables: &[Table<f64>]) -> Vec<SolvedContact<f64>> {
        let mut random = SplitMix64::new(5);
        let mut any = |count: usize| (random.unit() * count as f64) as u32;
        (0..40)
            .map(|number| {
                let other = tables[0].bodies[usize::from(number % 3 > 0)].start as u32;
                let nodes = [any(256), any(256), any(256), other + any(36)];
                let across = [1.0, f64::from(any(9)), -f64::from(any(5))];
                let normal = scale(across, 1.0 / norm(across));
                let weights = [-0.5, -0.25, -0.25, 1.0];
                let along = 1.0 + f64::from(any(3));
                SolvedContact { nodes, weights, normal, along, across: 0.3, ..SolvedContact::default() }
            })
            .collect()
    }

    fn weights_of(table: &Table<f64>, finer: &[Vec<(u32, f64)>]) -> Weights<f64> {
        let mut weights = Weights::default();
        finer.iter().for_each(|nodes| weights.push(table, nodes.iter().copied()));
        weights
    }

    #[test]
    fn blocks_between_coarse_nodes_are_contacts_of_the_finer_ones_that_follow_them() {
        let tables = tables();
        assert_eq!(tables.len(), 4, "the small sheet is there on all levels");
        let contacts = contacts(&tables);
        let mut nodes: Vec<Vec<(u32, f64)>> =
            contacts.iter().map(|one| one.nodes.into_iter().zip(one.weights).collect()).collect();
        let mut random = SplitMix64::new(7);
        for level in 1..tables.len() {
            let weights = weights_of(&tables[level - 1], &nodes);
            nodes = (0..contacts.len()).map(|number| weights.of(number).to_vec()).collect();
            let (places, all) = (tables[level].places, [&contacts[..]]);
            let mut coarse: Vec<[f64; 3]> =
                (0..places).map(|_| [0; 3].map(|_| random.unit() - 0.5)).collect();
            let mut rows = Rows::default();
            rows.list(&(0..places), &[&weights]);
            let of_row = |place: usize| {
                let mut row = Row::default();
                let mut found = Found(vec![0; places]);
                row.couple(place, rows.of(place), &all, &[&weights], &mut found);
                row
            };
            let energy = |coarse: &[[f64; 3]]| -> f64 {
                let of_place = |place: usize| {
                    let own = coarse[place];
                    let with = |&(other, block): &(u32, Symmetric<f64>)| {
                        dot(own, times(&block, sub(own, coarse[other as usize])))
                    };
                    of_row(place).blocks.iter().map(with).sum::<f64>()
                };
                (0..places).map(of_place).sum()
            };
            let found = energy(&coarse);
            // As nodes of the finest level move then.
            let mut fine = coarse.clone();
            for table in tables[..level].iter().rev() {
                let of = |place: usize| {
                    let parents = table.parents[place / LANES].of(place % LANES);
                    let add = |sum, (one, weight)| add_weighted(sum, weight, fine[one as usize]);
                    parents.into_iter().fold([0.0; 3], add)
                };
                fine = (0..table.places).map(of).collect();
            }
            let expected: f64 = contacts
                .iter()
                .map(|one| {
                    let velocity = one.relative(|node| fine[node as usize]);
                    dot(velocity, one.times(velocity))
                })
                .sum();
            assert!((found - expected).abs() < 1e-9 * expected, "level {level}: {found} {expected}");
            // A motion of all alike is none of the contacts'.
            coarse.fill([0.3, -0.2, 0.7]);
            assert_eq!(energy(&coarse), 0.0);
        }
    }

    #[test]
    fn the_contacts_of_a_node_are_the_same_whoever_has_found_them() {
        let tables = tables();
        let contacts = contacts(&tables);
        let nodes: Vec<Vec<(u32, f64)>> =
            contacts.iter().map(|one| one.nodes.into_iter().zip(one.weights).collect()).collect();
        let places = tables[1].places;
        let blocks = |cut: usize, share: Range<usize>| {
            let all = [&contacts[..cut], &contacts[cut..]];
            let weights = [&nodes[..cut], &nodes[cut..]].map(|nodes| weights_of(&tables[0], nodes));
            let weights = weights.each_ref();
            let mut rows = Rows::default();
            rows.list(&share, &weights);
            let of_row = |place: usize| {
                let mut row = Row::default();
                row.couple(place, rows.of(place - share.start), &all, &weights, &mut Found(vec![0; places]));
                (row.blocks, row.share)
            };
            share.clone().map(of_row).collect::<Vec<_>>()
        };
        let whole = blocks(contacts.len(), 0..places);
        assert!(whole.iter().any(|row| row.0.len() > 3));
        for cut in [0, 13, 29] {
            let halves = [blocks(cut, 0..LANES), blocks(cut, LANES..places)].concat();
            assert_eq!(halves, whole);
        }
    }
}
