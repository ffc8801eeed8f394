//! Contact of a run of nodes with all colliders, one collider after the other over the whole run.

use crate::assembly::Assembly;
use crate::backend::SolverState;
use crate::contact::collider_mesh::cache::MeshCache;
use crate::contact::colliders::lift::Lift;
use crate::contact::colliders::run::Contact;
use crate::cpu::backend::{Context, padded};
#[cfg(feature = "gpu")]
use crate::cpu::between::Between;
use crate::cpu::cells::PerWorker;
use crate::cpu::feature::Feature;
use crate::cpu::shared::Shared;
use crate::cpu::tile::{Moved, Tile};
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::real::Real;
use crate::report::FrameSums;
use crate::step::{Marks, Op};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The colliders of a scene, and which nodes are in contact with them.
pub struct Colliders<T> {
    /// The triangles of meshes near each node.
    pub cache: MeshCache<T>,
    scratch: PerWorker<ColliderScratch<T>>,
    /// Nodes that a collider carries until a joint breaks, and that joint; ascending. Colliders ignore them until
    /// then.
    carried: Vec<[u32; 2]>,
    /// Whether the joint of each of them is broken.
    released: Vec<AtomicBool>,
    /// Nodes that are led out of colliders, ascending: these ignore them until they are out. And whether there may be some:
    /// then they are looked for before each frame.
    pub lifts: Vec<Lift>,
    is_lifting: bool,
    /// For each place of a body that keeps its volume: whether it has touched a collider in this sub-step. Empty if
    /// no body does.
    in_contact: Shared<bool>,
    /// By tile: the number of nodes that have touched a collider in this sub-step.
    contacts: Vec<AtomicU64>,
}

/// The scratch memory of a worker.
struct ColliderScratch<T> {
    /// For each node of a tile, the collider that it touched last, from 1; 0: none.
    last: Vec<u32>,
    /// Inverse masses of nodes; 0 for nodes that colliders ignore [1/kg].
    inverse_mass: Vec<T>,
}

impl<T: Real> Colliders<T> {
    /// The colliders of a scene.
    pub fn new(context: &Context<'_, T>) -> Self {
        let assembly = &*context.assembly;
        let attachments = assembly.attachments();
        let rows = (0..).zip(&attachments.joints).filter(|(_, row)| attachments.is_carried(row));
        let mut carried: Vec<[u32; 2]> = rows.map(|(number, row)| [row.ends[0], number]).collect();
        carried.sort_unstable();
        let keeps_volumes = assembly.volumes().next().is_some();
        let scratch = |_| ColliderScratch { last: vec![0; context.largest_tile()], inverse_mass: Vec::new() };
        Self {
            cache: MeshCache::new(assembly, padded(assembly), context.nodes.level),
            scratch: PerWorker::new(context.workers(), scratch),
            released: carried.iter().map(|_| AtomicBool::new(false)).collect(),
            carried,
            lifts: Vec::new(),
            is_lifting: assembly.leads_out(),
            in_contact: vec![false; if keeps_volumes { assembly.places } else { 0 }].into(),
            contacts: context.nodes.tiles.iter().map(|_| AtomicU64::new(0)).collect(),
        }
    }

    /// Lets colliders act on the node of a broken joint. The worker with the joint's first end calls it.
    pub fn release(&self, joint: u32) {
        for ([_, of], released) in self.carried.iter().zip(&self.released) {
            if *of == joint {
                released.store(true, Ordering::Relaxed);
            }
        }
    }

    /// For some places of a body that keeps its volume: whether each has touched a collider in this sub-step.
    ///
    /// # Safety
    /// No other worker has a tile with one of them, and no other reference to them lives.
    #[expect(clippy::mut_from_ref, reason = "the promise above is what makes the reference unique")]
    pub unsafe fn in_contact(&self, run: &Range<usize>) -> &mut [bool] {
        // SAFETY: by the caller's promise.
        unsafe { self.in_contact.write(run.clone()) }
    }

    /// For the places of bodies that keep their volume: whether each has touched a collider. Called between frames.
    #[cfg(feature = "gpu")]
    pub fn all_in_contact(&mut self) -> &mut [bool] {
        self.in_contact.get_mut()
    }

    /// Keeps a run of nodes out of colliders. `at` is where the run begins in the worker's scratch memory. `is_moved`: the nodes were
    /// moved once more, and their motion starts where that memory has it.
    fn collide(
        &self,
        tile: &Tile<'_, T>,
        ColliderScratch { last, inverse_mass: alone }: &mut ColliderScratch<T>,
        (at, run): (usize, Range<usize>),
        is_moved: bool,
    ) -> u64 {
        let mut state = tile.after(&run);
        let all = at..at + run.len();
        let start = if is_moved {
            tile.scratch.before.each_ref().map(|column| &column[all.clone()])
        } else {
            [0, 1, 2].map(|axis| &tile.old[axis][run.clone()])
        };
        let mut inverse_mass = &tile.nodes.inverse_mass[run.clone()];
        let first = self.carried.partition_point(|&[node, _]| (node as usize) < run.start);
        let end = self.carried.partition_point(|&[node, _]| (node as usize) < run.end);
        let lifts = self.lifts.partition_point(|lift| (lift.node as usize) < run.start)
            ..self.lifts.partition_point(|lift| (lift.node as usize) < run.end);
        if first < end || !lifts.is_empty() {
            alone.clear();
            alone.extend_from_slice(inverse_mass);
            for index in first..end {
                if !self.released[index].load(Ordering::Relaxed) {
                    alone[self.carried[index][0] as usize - run.start] = T::ZERO;
                }
            }
            for lift in &self.lifts[lifts] {
                alone[lift.node as usize - run.start] = T::ZERO;
            }
            inverse_mass = alone;
        }
        let contacts = Contact {
            level: tile.nodes.level,
            colliders: tile.substep.met_colliders().at(run.start),
            cache: &self.cache,
            run: run.clone(),
            inverse_mass,
            start,
            carried: !is_moved,
            state: &mut state,
            last: &mut last[all.clone()],
            h: tile.substep.h,
        }
        .act();
        if tile.marks.has(Marks::VOLUME) { self.note_contacts(&run, &last[all]) } else { contacts }
    }

    /// Marks nodes that have touched a collider. Returns how many were not marked before.
    fn note_contacts(&self, run: &Range<usize>, last: &[u32]) -> u64 {
        // SAFETY: the tile is this worker's.
        let in_contact = unsafe { self.in_contact(run) };
        let mut new = 0;
        for (in_contact, &last) in in_contact.iter_mut().zip(last) {
            new += u64::from(last > 0 && !*in_contact);
            *in_contact |= last > 0;
        }
        new
    }
}

impl<T: Real> Feature<T> for Colliders<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Contact]
    }

    fn begin(&self, worker: &mut Worker<'_, T>) {
        self.contacts[worker.tiles.clone()].iter().for_each(|contacts| contacts.store(0, Ordering::Relaxed));
        if self.in_contact.len() > 0 {
            for (_, run) in worker.nodes.tiles[worker.tiles.clone()].iter().flat_map(TilePlan::runs) {
                // SAFETY: the tiles are this worker's.
                unsafe { self.in_contact(&run) }.fill(false);
            }
        }
    }

    #[cfg(feature = "gpu")]
    fn begin_apart(&self, tile: &Tile<'_, T>) {
        self.scratch.of(tile.worker).last.fill(0);
    }

    #[cfg(feature = "gpu")]
    fn end_apart(&self, tile: &Tile<'_, T>, between: &mut Between<T>) {
        let last = &self.scratch.read(tile.worker).last;
        for (at, run) in tile.plan.runs() {
            between.last_collider[run.clone()].copy_from_slice(&last[at..at + run.len()]);
        }
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        if !tile.has_contact() {
            return;
        }
        let scratch = &mut self.scratch.of(tile.worker);
        if let Moved::Some(moved) = &tile.moved {
            for run in moved.chunk_by(|(node, _), (next, _)| node + 1 == *next) {
                for (at, (_, from)) in run.iter().enumerate() {
                    for (column, &from) in tile.scratch.before.iter_mut().zip(from) {
                        column[at] = from;
                    }
                }
                self.collide(tile, scratch, (0, run[0].0..run[0].0 + run.len()), true);
            }
            return;
        }
        let is_moved = matches!(tile.moved, Moved::Any);
        let runs = tile.plan.runs();
        let contacts: u64 = runs.map(|run| self.collide(tile, scratch, run, is_moved)).sum();
        // The tile is this worker's.
        let before = self.contacts[tile.index].load(Ordering::Relaxed);
        self.contacts[tile.index].store(before + contacts, Ordering::Relaxed);
    }

    fn prepare(&mut self, assembly: &Assembly, start: f64, state: [&[T]; 6]) {
        if self.is_lifting {
            let x = |node: usize| [0, 1, 2].map(|axis| state[axis][node].to_f64());
            self.lifts = assembly.lifts(start, &x);
            self.is_lifting = !self.lifts.is_empty();
        }
    }

    fn relocate(&mut self) {
        self.is_lifting = true;
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        sums.all.contacts = self.contacts.iter_mut().map(|contacts| *contacts.get_mut()).sum();
    }

    fn forget(&mut self, node: usize) {
        self.cache.forget(node);
    }

    fn save(&self, state: &mut SolverState) {
        state.is_tangled |= self.is_lifting;
    }

    fn load(&mut self, state: &SolverState) {
        self.is_lifting = state.is_tangled;
        self.lifts.clear();
        for (&[_, joint], released) in self.carried.iter().zip(&mut self.released) {
            *released.get_mut() = state.joints.get(joint as usize) == Some(&false);
        }
    }
}
