//! One worker's way through a frame.

use crate::attachments::cpu::{AttachScratch, AttachWorker, SharedAttach};
use crate::contact::collider_mesh::cache::{Near, SharedNear};
use crate::contact::nodes::cpu::{PairScratch, PairWorker, SharedPairs};
use crate::cpu::backend::Setup;
use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::cpu::team::Barrier;
use crate::cpu::tile::CpuTile;
use crate::diagnostics::StateSums;
use crate::diagnostics::cpu::{chunk_volume, tile_sums};
use crate::elements::aero::aero::AirNow;
use crate::elements::hinge::hinge;
use crate::elements::load::build::LoadKind;
use crate::elements::load::load as external;
use crate::elements::spring::cpu_grid::Sweep;
use crate::plan::Substep;
use crate::real::Real;
use crate::solvers::dual::cpu::{SharedSolve, SolveScratch, SolveWorker};
use crate::solvers::implicit::cpu::{PrimalScratch, PrimalWorker, SharedPrimal};
use crate::step::Stages;
use crate::topology::LANES;
use crate::volume::cpu::SharedCorrections;
use crate::volume::volume::{Push, WEIGHTED_SUMS};
use std::ops::Range;

/// What a worker keeps from frame to frame; on cache lines of its own, so that no worker waits for another's.
#[repr(align(128))]
pub struct Scratch<T> {
    /// Forces of one tile's nodes [N].
    pub force: [Column<T>; 3],
    /// Gradients of the volume by the places of one tile's nodes [m²].
    pub gradient: [Column<T>; 3],
    /// What pushes each volume in this sub-step.
    pub pushes: Vec<Option<Push<T>>>,
    /// From where places of each volume's nodes are counted [m].
    pub origins: Vec<[T; 3]>,
    /// Forces of a grid's last rows.
    pub sweep: Sweep<T>,
    /// Factor of each load that is a torque [N/m].
    pub torques: Vec<T>,
    /// For each node of a tile, the collider that it touched last, from 1; 0: none.
    pub last_touch: Vec<u32>,
    /// Where the nodes of a tile were before they were moved to restore a volume [m].
    pub before: [Column<T>; 3],
    /// Springs that are constraints.
    pub solve: SolveScratch<T>,
    /// Springs that are solved for by nodes.
    pub primal: PrimalScratch<T>,
    /// Joints and tethers.
    pub attach: AttachScratch<T>,
    /// Inverse masses of nodes, 0 for those that colliders leave alone as they carry them [1/kg].
    pub alone: Vec<T>,
    /// Nodes that touch each other, where any do.
    pub pairs: Option<PairScratch<T>>,
    /// Time that it has waited for others about them in this frame [s].
    pub waited: f64,
}

impl<T: Real> Scratch<T> {
    /// For tiles of up to `nodes` nodes, grids of up to `cols` columns, a stretch to watch for, and some volumes.
    pub fn new(
        nodes: usize,
        (cols, watch): (usize, Option<T>),
        volumes: usize,
        pairs: Option<PairScratch<T>>,
    ) -> Self {
        Self {
            force: std::array::from_fn(|_| Column::zeros(nodes)),
            gradient: std::array::from_fn(|_| Column::zeros(if volumes > 0 { nodes } else { 0 })),
            pushes: vec![None; volumes],
            origins: vec![[T::ZERO; 3]; volumes],
            sweep: Sweep::new(cols, watch),
            torques: Vec::new(),
            last_touch: vec![0; nodes],
            before: std::array::from_fn(|_| Column::zeros(if volumes > 0 { nodes } else { 0 })),
            solve: SolveScratch::default(),
            primal: PrimalScratch::default(),
            attach: AttachScratch::default(),
            alone: Vec::new(),
            pairs,
            waited: 0.0,
        }
    }
}

/// A worker and what it may touch.
pub struct Worker<'a, T> {
    /// What does not change.
    pub setup: &'a Setup<T>,
    /// Which worker it is.
    pub index: usize,
    /// Of how many.
    pub workers: usize,
    /// Its tiles.
    pub share: Range<usize>,
    /// State before and after a sub-step, by turns.
    pub buffers: &'a [[Shared<'a, T>; 6]; 2],
    /// Which buffer holds the state now.
    pub current: usize,
    /// Forces on the corners of each hinge [N].
    pub hinge_forces: &'a Shared<'a, [[T; 3]; 4]>,
    /// Force of the air on each corner of each panel [N].
    pub panel_forces: &'a [Shared<'a, T>; 3],
    /// What volumes need between stages.
    pub corrections: &'a SharedCorrections<'a, T>,
    /// What constraints need between stages.
    pub solve: &'a SharedSolve<'a, T>,
    /// What springs that are solved for by nodes need between stages.
    pub primal: &'a SharedPrimal<'a, T>,
    /// Which joints are broken.
    pub attach: &'a SharedAttach<'a>,
    /// What nodes that touch each other need between stages.
    pub pairs: &'a SharedPairs<'a, T>,
    /// What is known of the triangles of colliders.
    pub near: &'a SharedNear<'a, T>,
    /// Where each tile's sums go.
    pub tile_sums: &'a Shared<'a, StateSums>,
    /// Where each chunk's volume goes [m³].
    pub volumes: &'a Shared<'a, f64>,
    /// Room of its own.
    pub scratch: &'a mut Scratch<T>,
    /// Where it meets the others.
    pub barrier: &'a Barrier,
}

/// An even share of `count` things for worker `index` of `workers`.
fn even(count: usize, index: usize, workers: usize) -> Range<usize> {
    count * index / workers..count * (index + 1) / workers
}

impl<'a, T: Real> Worker<'a, T> {
    /// The state at the start of the sub-step.
    fn state(&self) -> [&'a [T]; 6] {
        // SAFETY: in a sub-step all workers read this buffer and write the other; they swap after a barrier.
        self.buffers[self.current].each_ref().map(|column| unsafe { column.read() })
    }

    fn sum_torques(&mut self, substep: &Substep<T>) {
        let state = self.state();
        self.scratch.torques.clear();
        for (load, &scale) in self.setup.assembly.loads.iter().zip(&substep.scales) {
            self.scratch.torques.push(match load.kind {
                LoadKind::Force(_) => T::ZERO,
                LoadKind::Torque { axis, value, about } => {
                    let (axis, about) = (axis.map(T::from_f64), about.map(T::from_f64));
                    let place = |&node: &u32| [0, 1, 2].map(|c| state[c][node as usize]);
                    let levers = load.nodes.iter().map(|node| external::lever(place(node), axis, about));
                    external::torque_factor(T::from_f64(value) * scale, levers)
                }
            });
        }
    }

    fn bend_hinges(&mut self) {
        let (state, hinges) = (self.state(), &self.setup.hinges);
        let mine = even(hinges.corners.len(), self.index, self.workers);
        // SAFETY: shares of hinges do not overlap, and forces are read only after the barrier.
        let out = unsafe { self.hinge_forces.write(mine.clone()) };
        for (range, k, damping) in &hinges.bodies {
            for i in range.start.max(mine.start)..range.end.min(mine.end) {
                let corners = hinges.corners[i].map(|node| node as usize);
                let x = corners.map(|node| [state[0][node], state[1][node], state[2][node]]);
                let v = corners.map(|node| [state[3][node], state[4][node], state[5][node]]);
                out[i - mine.start] = hinge::forces(x, v, *k, *damping, hinges.rest[i]);
            }
        }
    }

    /// Finds the forces of its share of the panels.
    fn blow_on_panels(&mut self, air: &AirNow<T>) {
        let (setup, state) = (self.setup, self.state());
        let mine = even(setup.panels.blocks(), self.index, self.workers);
        let places = mine.start * LANES..mine.end * LANES;
        // SAFETY: shares of panels do not overlap, and forces are read only after the barrier.
        let out = self.panel_forces.each_ref().map(|column| unsafe { column.write(places.clone()) });
        setup.panels.blow(setup.level, air, state, mine, out);
    }

    /// A tile of its share.
    fn tile<'t>(&'t mut self, index: usize, substep: &'t Substep<T>) -> CpuTile<'t, T> {
        let plan = &self.setup.tiles[index];
        CpuTile {
            setup: self.setup,
            plan,
            index,
            number: index - self.share.start,
            substep,
            old: self.state(),
            next: &self.buffers[1 - self.current],
            // SAFETY: hinge forces were written before the barrier in `elements`, and next are after that of `end`.
            hinge_forces: unsafe { self.hinge_forces.read() },
            // SAFETY: as those of hinges.
            panel_forces: self.panel_forces.each_ref().map(|column| unsafe { column.read() }),
            corrections: self.corrections,
            solve: self.solve,
            primal: self.primal,
            attach: self.attach,
            volume: self.setup.volume_of_body[plan.body],
            scratch: self.scratch,
            contacts: 0,
            near: Near { meshes: &self.setup.meshes, shared: self.near },
            parted: Vec::new(),
            restored: false,
        }
    }

    /// Runs `stages` on the tiles of its share whose volume is `chosen`; adds up contacts.
    fn on_volumes(
        &mut self,
        substep: &Substep<T>,
        chosen: impl Fn(&Self, usize) -> bool,
        stages: impl Fn(&mut CpuTile<'_, T>),
    ) {
        for index in self.share.clone() {
            let volume = self.setup.volume_of_body[self.setup.tiles[index].body];
            if !volume.is_some_and(|volume| chosen(self, volume)) {
                continue;
            }
            let mut tile = self.tile(index, substep);
            stages(&mut tile);
            let contacts = tile.contacts;
            self.sums_of(index).contacts += contacts;
        }
    }

    /// Solves for springs that are constraints; returns whether any tile waits for that.
    fn solve_springs(&mut self, substep: &Substep<T>) -> bool {
        let (setup, old, next) = (self.setup, self.state(), &self.buffers[1 - self.current]);
        if let Some(primal) = &setup.primal {
            PrimalWorker {
                setup,
                primal,
                shared: self.primal,
                scratch: &mut self.scratch.primal,
                index: self.index,
                workers: self.workers,
                alone: self.workers == 1,
                barrier: self.barrier,
                old,
                next,
                h: substep.h,
                colliders: primal.colliders(substep),
                near: Near { meshes: &setup.meshes, shared: self.near },
            }
            .solve();
            return true;
        }
        let Some(solve) = &setup.solve else { return false };
        // SAFETY: noted before the barrier that was just passed, and anew after the next.
        if solve.adaptive && !unsafe { self.solve.waits() }.contains(&true) {
            return false;
        }
        SolveWorker {
            setup,
            solve,
            shared: self.solve,
            scratch: &mut self.scratch.solve,
            share: self.share.clone(),
            index: self.index,
            workers: self.workers,
            barrier: self.barrier,
            old,
            next,
            h: substep.h,
            colliders: solve.colliders(substep),
            near: Near { meshes: &setup.meshes, shared: self.near },
        }
        .solve();
        true
    }

    /// Where the sums of a tile of its share go.
    fn sums_of(&mut self, index: usize) -> &mut StateSums {
        // SAFETY: one place a tile, in one worker's share, read after the frame.
        let one = unsafe { self.tile_sums.write(index..index + 1) };
        &mut one[0]
    }

    /// The worker's part in what all do about nodes that touch each other.
    fn pair_worker(&mut self) -> Option<PairWorker<'_, T>> {
        Some(PairWorker {
            pairs: self.setup.pairs.as_ref()?,
            shared: self.pairs,
            scratch: self.scratch.pairs.as_mut()?,
            first_tile: self.share.start,
            index: self.index,
            next: &self.buffers[1 - self.current],
            inverse_mass: &self.setup.inverse_mass,
            level: self.setup.level,
        })
    }

    /// Solves for the volumes that are `chosen`, once all have written their sums.
    fn solve(
        &mut self,
        chosen: impl Fn(usize) -> bool,
        solve: impl Fn(usize, &[[T; WEIGHTED_SUMS]]) -> Option<Push<T>>,
    ) {
        self.barrier.wait();
        // SAFETY: sums are written before a barrier and read after it.
        let sums = unsafe { self.corrections.sums.read() };
        for volume in (0..self.setup.volumes.len()).filter(|volume| chosen(*volume)) {
            self.scratch.pushes[volume] = solve(volume, sums);
        }
    }

    /// Notes from where places are counted in a state.
    fn note_origins(&mut self, state: [&[T]; 3]) {
        for (origin, volume) in self.scratch.origins.iter_mut().zip(&self.setup.volumes) {
            *origin = state.map(|column| column[volume.first]);
        }
    }
}

impl<T: Real> Stages for Worker<'_, T> {
    type Substep = Substep<T>;
    type Tile<'t>
        = CpuTile<'t, T>
    where
        Self: 't;

    fn elements(&mut self, substep: &Substep<T>) {
        self.sum_torques(substep);
        let (bends, blows) = (!self.setup.hinges.corners.is_empty(), self.setup.panels.blocks() > 0);
        if bends {
            self.bend_hinges();
        }
        if let Some(air) = substep.air.as_ref().filter(|_| blows) {
            self.blow_on_panels(air);
        }
        if bends || blows {
            self.barrier.wait();
        }
    }

    fn particles(&mut self, substep: &Substep<T>, stages: impl Fn(&mut CpuTile<'_, T>)) {
        self.scratch.sweep.restart();
        let [x, y, z, ..] = self.state();
        self.note_origins([x, y, z]);
        for index in self.share.clone() {
            let mut tile = self.tile(index, substep);
            stages(&mut tile);
            let contacts = tile.contacts;
            self.sums_of(index).contacts = contacts;
        }
    }

    fn constrains(&self) -> bool {
        self.setup.solve.is_some() || self.setup.primal.is_some()
    }

    fn constraints(&mut self, substep: &Substep<T>, stages: impl Fn(&mut CpuTile<'_, T>)) {
        self.barrier.wait();
        if !self.solve_springs(substep) {
            return;
        }
        for index in self.share.clone() {
            let mut tile = self.tile(index, substep);
            if tile.waits() {
                stages(&mut tile);
                let contacts = tile.contacts;
                self.sums_of(index).contacts += contacts;
            }
        }
    }

    fn keeps_volumes(&self) -> bool {
        !self.setup.volumes.is_empty()
    }

    fn volumes(&mut self, substep: &Substep<T>, stages: impl Fn(&mut CpuTile<'_, T>)) {
        let setup = self.setup;
        // Bodies and their tiles are in one order.
        let mut of_tiles =
            setup.tiles[self.share.clone()].iter().filter_map(|tile| setup.volume_of_body[tile.body]);
        let (first, last) = (of_tiles.next(), of_tiles.next_back());
        let mine = first.map_or(0..0, |first| first..last.unwrap_or(first) + 1);
        self.solve(
            |volume| mine.contains(&volume),
            |volume, sums| Some(setup.volumes[volume].push(sums, substep.goals[volume], substep.h)),
        );
        self.on_volumes(substep, |_, _| true, stages);
    }

    fn attaches(&self) -> bool {
        self.setup.attach.is_some()
    }

    fn attach(&mut self, substep: &Substep<T>, stages: impl Fn(&mut CpuTile<'_, T>)) {
        let Some(setup) = &self.setup.attach else { return };
        self.barrier.wait();
        let mut attach = AttachWorker {
            setup,
            shared: self.attach,
            scratch: &mut self.scratch.attach,
            share: self.share.clone(),
            next: &self.buffers[1 - self.current],
            inverse_mass: &self.setup.inverse_mass,
            substep,
        };
        attach.answer();
        self.barrier.wait();
        attach.note_broken();
        for index in self.share.clone() {
            if !self.scratch.attach.answers(index - self.share.start).is_empty() {
                stages(&mut self.tile(index, substep));
            }
        }
    }

    fn collides(&self) -> bool {
        self.setup.pairs.is_some()
    }

    fn pairs(&mut self, substep: &Substep<T>, stages: impl Fn(&mut CpuTile<'_, T>)) {
        let barrier = self.barrier;
        let Some(mut pairs) = self.pair_worker() else { return };
        pairs.note_moves();
        let mut waited = barrier.wait_timed();
        if pairs.is_stale() {
            pairs.search(|| barrier.wait());
        }
        pairs.find_near();
        waited += barrier.wait_timed();
        let any = pairs.any();
        if any {
            pairs.answer(substep.h);
            waited += barrier.wait_timed();
        }
        self.scratch.waited += waited;
        for index in self.share.clone().filter(|_| any) {
            let touches = |pairs: &PairScratch<T>| pairs.answers(index - self.share.start).len() > 0;
            if self.scratch.pairs.as_ref().is_some_and(touches) {
                stages(&mut self.tile(index, substep));
            }
        }
    }

    fn project(&mut self, substep: &Substep<T>, stages: impl Fn(&mut CpuTile<'_, T>)) -> bool {
        let setup = self.setup;
        let projects = |volume: usize| setup.volumes[volume].projects;
        if !(0..setup.volumes.len()).any(projects) {
            return true;
        }
        self.barrier.wait();
        // SAFETY: all have moved their nodes before the barrier, and move them again after the next.
        let next = [0, 1, 2].map(|axis| unsafe { self.buffers[1 - self.current][axis].read() });
        self.note_origins(next);
        self.on_volumes(substep, |_, volume| projects(volume), |tile| tile.measure_volume());
        self.solve(projects, |volume, sums| setup.volumes[volume].projection(sums, substep.goals[volume]));
        let off = |worker: &Self, volume: usize| projects(volume) && worker.scratch.pushes[volume].is_some();
        let done = !(0..setup.volumes.len()).any(|volume| off(self, volume));
        self.on_volumes(substep, off, stages);
        done
    }

    fn end(&mut self, _: &Substep<T>) {
        self.barrier.wait();
        self.current = 1 - self.current;
    }

    fn diagnose(&mut self) {
        let state = self.state();
        for index in self.share.clone() {
            // SAFETY: one place a tile, read after the frame.
            let sums = &mut unsafe { self.tile_sums.write(index..index + 1) }[0];
            *sums = StateSums {
                contacts: sums.contacts,
                ..tile_sums(self.setup, &self.setup.tiles[index], state)
            };
        }
        for index in even(self.setup.volume_chunks.len(), self.index, self.workers) {
            // SAFETY: one place a chunk, in one worker's share, read after the frame.
            let volume = &mut unsafe { self.volumes.write(index..index + 1) }[0];
            *volume = chunk_volume(self.setup, index, state);
        }
    }
}
