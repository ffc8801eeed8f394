//! Single stages of a sub-step on a state of the caller's choice, to compare another backend with.

use crate::backend::{Backend, FrameInput};
use crate::build::body::BodyAssembly;
use crate::contact::collider_mesh::cache::Near;
use crate::cpu::backend::{CpuBackend, Fields};
use crate::cpu::shared::Shared;
use crate::cpu::tile::CpuTile;
use crate::cpu::worker::Worker;
use crate::diagnostics::StateSums;
use crate::plan::Substep;
use crate::real::Real;
use crate::step::Stages;
use crate::topology::LANES;
use crate::volume::volume::WEIGHTED_SUMS;
use std::ops::Range;
use std::sync::PoisonError;

/// What stages hand to each other beside the state, by place. Lanes past a mesh's last node are places too.
#[derive(Clone, Debug, Default)]
pub struct Between<T> {
    /// Force on each place [N]; those of no tile stay.
    pub force: Vec<[T; 3]>,
    /// The collider that each place touched last, from 1; 0: none.
    pub touched: Vec<u32>,
    /// Factor of each load that is a torque [N/m].
    pub torques: Vec<T>,
    /// Forces on the corners of each hinge [N].
    pub hinge_forces: Vec<[[T; 3]; 4]>,
    /// Force of the air on each corner of each panel [N].
    pub panel_forces: Vec<[T; 3]>,
}

impl<T: Real> CpuBackend<T> {
    /// Sets a place in the state after the sub-step, as position [m], then velocity [m/s].
    pub fn set_after(&mut self, place: usize, state: [T; 6]) {
        let after = &mut self.fields[1 - self.current];
        after.iter_mut().zip(state).for_each(|(column, number)| column[place] = number);
    }

    /// A place in the state after the sub-step.
    pub fn after(&self, place: usize) -> [T; 6] {
        self.fields[1 - self.current].each_ref().map(|column| column[place])
    }

    /// Sums over the bodies that `chosen` says, as last measured.
    pub fn sums_of(&self, chosen: impl Fn(&BodyAssembly) -> bool) -> StateSums {
        let mut all = StateSums::default();
        let bodies = &self.setup.assembly.bodies;
        let tiles = self.setup.tiles.iter().zip(&self.tile_sums);
        tiles.filter(|(tile, _)| chosen(&bodies[tile.body])).for_each(|(_, sums)| all.add(sums));
        all
    }

    /// Runs the elements of a sub-step, then `stages` on each tile, from the state of now to the one after, which does
    /// not become that of now. Forces start as `between` has them.
    pub fn apart(
        &mut self,
        substep: &Substep<T>,
        input: &FrameInput,
        between: &mut Between<T>,
        stages: impl Fn(&mut CpuTile<'_, T>),
    ) {
        self.setup.input = input.clone();
        assert_eq!(self.threads(), 1, "stages apart are for one worker");
        self.work(|worker| worker.elements(substep));
        let [a, b]: &mut [Fields<T>; 2] = &mut self.fields;
        let (old, next) = if self.current == 0 { (a, b) } else { (b, a) };
        let old = old.each_ref().map(|column| &column[..]);
        let next = next.each_mut().map(|column| Shared::new(column));
        let corrections = self.corrections.share();
        let solve = self.solve.share();
        let primal = self.primal.share();
        let attach = self.attach.share();
        let near = self.near.share();
        let scratch = self.scratch[0].get_mut().unwrap_or_else(PoisonError::into_inner);
        scratch.sweep.restart();
        for (origin, volume) in scratch.origins.iter_mut().zip(&self.setup.volumes) {
            *origin = [0, 1, 2].map(|axis| old[axis][volume.first]);
        }
        between.touched = vec![0; between.force.len()];
        for (number, plan) in self.setup.tiles.iter().enumerate() {
            let hinge_forces = &self.hinge_forces;
            let panel_forces = self.panel_forces.each_ref().map(|column| &column[..]);
            let (setup, next) = (&self.setup, &next);
            let (corrections, solve, primal, attach) = (&corrections, &solve, &primal, &attach);
            let mut tile = CpuTile {
                setup,
                plan,
                index: number,
                number,
                substep,
                old,
                next,
                hinge_forces,
                panel_forces,
                corrections,
                solve,
                primal,
                attach,
                volume: setup.volume_of_body[plan.body],
                scratch,
                contacts: 0,
                near: Near { meshes: &setup.meshes, shared: &near },
                parted: Vec::new(),
                restored: false,
            };
            load(&mut tile, between);
            stages(&mut tile);
            store(&tile, between);
        }
        between.torques.clone_from(&scratch.torques);
        between.hinge_forces.clone_from(&self.hinge_forces);
        let panel = |number: usize| self.panel_forces.each_ref().map(|column| column[number]);
        between.panel_forces = (0..self.panel_forces[0].len()).map(panel).collect();
    }

    /// Positions [m] and velocities [m/s] by axis and place: those of now, or those that a sub-step has begun to write.
    pub fn fields(&self, next: bool) -> &Fields<T> {
        &self.fields[if next { 1 - self.current } else { self.current }]
    }

    /// Inverse mass [1/kg] and mass [kg] by place.
    pub fn masses(&self) -> (&[T], &[T]) {
        (&self.setup.inverse_mass, &self.setup.mass)
    }

    /// Ends a sub-step whose state was found elsewhere.
    pub fn end(&mut self, state: impl Fn(usize, usize) -> T) {
        self.current = 1 - self.current;
        for axis in 0..6 {
            for place in 0..self.setup.assembly.places {
                self.fields[self.current][axis][place] = state(axis, place);
            }
        }
    }
}

/// What the stages of volumes hand to each other, by place.
#[derive(Clone, Debug, Default)]
pub struct KeptParts<T> {
    /// Force [N] without that of the constraint.
    pub force: Vec<[T; 3]>,
    /// Gradient of the volume [m²].
    pub gradient: Vec<[T; 3]>,
    /// Whether a place has touched a collider.
    pub touched: Vec<bool>,
    /// Sums of each group.
    pub sums: Vec<[T; WEIGHTED_SUMS]>,
}

impl<T: Real> CpuBackend<T> {
    /// Lends the only worker, in a sub-step from the state of now to the one after, which does not become that of now.
    pub fn lend_worker(&mut self, job: impl Fn(&mut Worker<'_, T>) + Sync) {
        assert_eq!(self.threads(), 1, "stages apart are for one worker");
        self.work(job);
    }

    /// Places of bodies that keep their volume: among those of all such bodies, and among all.
    fn kept_places(&self) -> impl Iterator<Item = (usize, usize)> + use<T> {
        let of_body: Vec<_> =
            self.setup.volumes.iter().map(|body| (body.places.clone(), body.first)).collect();
        of_body
            .into_iter()
            .flat_map(|(places, first)| places.clone().map(move |i| (i, first + i - places.start)))
    }

    /// Says which places have touched a collider.
    pub fn set_touched(&mut self, touched: impl Fn(usize) -> bool) {
        self.kept_places().for_each(|(among, place)| self.corrections.touched[among] = touched(place));
    }

    /// What the stages of volumes have left: of the state before, or once it is there, of that after.
    pub fn kept_parts(&self, after: bool) -> KeptParts<T> {
        let (places, found) = (self.setup.assembly.places, &self.corrections);
        let mut kept = KeptParts {
            force: vec![[T::ZERO; 3]; places],
            gradient: vec![[T::ZERO; 3]; places],
            touched: vec![false; places],
            sums: found.sums.clone(),
        };
        for (among, place) in self.kept_places() {
            let waiting = self.after(place);
            if after {
                kept.gradient[place] = found.gradient.each_ref().map(|column| column[among]);
            } else {
                kept.gradient[place] = [0, 1, 2].map(|axis| waiting[axis]);
                kept.force[place] = [3, 4, 5].map(|axis| waiting[axis]);
            }
            kept.touched[place] = found.touched[among];
        }
        kept
    }
}

/// A tile's runs of places, with the lanes past a mesh's last node.
fn runs<T>(tile: &CpuTile<'_, T>) -> Vec<(usize, Range<usize>)> {
    let is_grid = !tile.plan.cols.is_empty();
    let whole = |end: usize| if is_grid { end } else { end.next_multiple_of(LANES) };
    tile.plan.runs().map(|(at, run)| (at, run.start..whole(run.end))).collect()
}

fn load<T: Real>(tile: &mut CpuTile<'_, T>, between: &Between<T>) {
    tile.scratch.last_touch.fill(0);
    for (at, run) in runs(tile) {
        for (i, place) in run.enumerate() {
            let force = between.force[place];
            tile.scratch.force.iter_mut().zip(force).for_each(|(column, number)| column[at + i] = number);
        }
    }
}

fn store<T: Real>(tile: &CpuTile<'_, T>, between: &mut Between<T>) {
    for (at, run) in runs(tile) {
        for (i, place) in run.enumerate() {
            between.force[place] = tile.scratch.force.each_ref().map(|column| column[at + i]);
        }
    }
    for (at, run) in tile.plan.runs() {
        between.touched[run.clone()].copy_from_slice(&tile.scratch.last_touch[at..at + run.len()]);
    }
}
