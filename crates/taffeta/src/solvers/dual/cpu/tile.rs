//! What constraints ask of a tile, and what they give it.

use crate::contact::colliders::press::Press;
use crate::cpu::tile::CpuTile;
use crate::cpu::tiles::TiledSprings;
use crate::real::{Real, scale, sub};
use crate::solvers::dual::cpu::kernels::gather;

impl<T: Real> CpuTile<'_, T> {
    /// Whether every spring of the tile's body is a constraint.
    pub(crate) fn is_implicit(&self) -> bool {
        let (solve, primal) = (self.setup.solve.as_ref(), self.setup.primal.as_ref());
        solve.is_some_and(|solve| !solve.adaptive && !solve.list.bodies[self.plan.body].is_empty())
            || primal.is_some_and(|primal| primal.acts_on(self.plan.body))
    }

    /// Notes whether the tile's nodes wait for constraints: because springs are too long, or were in the last sub-step.
    pub(crate) fn note_waiting(&mut self, beyond: bool) {
        if self.setup.solve.as_ref().is_none_or(|solve| !solve.adaptive) {
            return;
        }
        let tile = self.index;
        // SAFETY: each tile is in one worker's share; others read after a barrier.
        unsafe {
            let before = self.solve.tile_nodes.item(tile)[0] > 0;
            *self.solve.waits.item(tile) = beyond || before;
        }
    }

    /// Whether the tile's nodes wait for constraints.
    pub(crate) fn waits(&self) -> bool {
        // SAFETY: as above.
        let noted = || unsafe { *self.solve.waits.item(self.index) };
        let adaptive = self.setup.solve.as_ref().is_some_and(|solve| solve.adaptive);
        if adaptive { noted() } else { self.is_implicit() }
    }

    /// Takes up the force that waits, and adds that of constraints.
    pub(crate) fn add_constraints(&mut self) {
        for (at, run) in self.plan.runs() {
            let [_, _, _, force @ ..] = self.after(&run);
            for (to, from) in self.scratch.force.iter_mut().zip(force) {
                to[at..at + run.len()].copy_from_slice(from);
            }
        }
        let adaptive = self.setup.solve.as_ref().is_some_and(|solve| solve.adaptive);
        for (at, run) in self.plan.runs() {
            if self.setup.primal.is_some() {
                self.add_changes(at, &run);
                continue;
            }
            if !adaptive {
                run.clone().for_each(|place| self.add_pulls((at + place - run.start, place), place));
                continue;
            }
            // A tile may wait for constraints of which none has become active, here or anywhere.
            let Some(nodes) = self.scratch.solve.layout.nodes_of_tile.get(self.number).cloned() else {
                return;
            };
            // SAFETY: listed before a barrier; the nodes of a tile ascend.
            let places = &unsafe { self.solve.places.read() }[nodes.clone()];
            let within = |place: usize| places.partition_point(|&one| (one as usize) < place);
            let (from, to) = (within(run.start), within(run.end));
            for (&place, node) in places[from..to].iter().zip(nodes.start + from..) {
                let place = place as usize;
                self.add_pulls((at + place - run.start, place), node);
            }
        }
    }

    /// Adds the pulls at a node of the system to the `at`-th force of the tile.
    fn add_pulls(&mut self, (at, place): (usize, usize), node: usize) {
        // SAFETY: listed, and found, before a barrier.
        let (span, entries, pulled) =
            unsafe { (self.solve.spans.read()[node], self.solve.entries.read(), self.solve.pulled.read()) };
        let [x, y, z, _] = gather(&entries[span[0] as usize..span[1] as usize], pulled).0;
        let mut force = [-x, -y, -z];
        let solve = self.setup.solve.as_ref();
        if solve.is_some_and(|solve| !solve.colliders(self.substep).is_empty()) {
            force = self.pressed(place, node, force);
        }
        for (column, force) in self.scratch.force.iter_mut().zip(force) {
            column[at] += force;
        }
    }

    /// The force of pulls on a node with what a surface does about it.
    fn pressed(&self, place: usize, node: usize, force: [T; 3]) -> [T; 3] {
        // SAFETY: found before a barrier.
        let (press, surface) = unsafe { (self.solve.press.read()[node], self.solve.surface.read()[node]) };
        if press.normal == [T::ZERO; 3] {
            return force;
        }
        let kick = self.substep.h * self.setup.inverse_mass[place];
        scale(self.borne(place, (&press, surface), scale(force, kick)), T::ONE / kick)
    }

    /// A change of a node's velocity with what the surface that holds it does about it.
    pub(crate) fn borne(&self, place: usize, (press, surface): (&Press<T>, u32), change: [T; 3]) -> [T; 3] {
        // SAFETY: waits where the state after will be, for this tile alone.
        let free = [0, 1, 2].map(|axis| unsafe { *self.next[axis].item(place) });
        sub(press.after(free, change, &self.substep.colliders[surface as usize].touching), free)
    }

    /// Gradients of the volume in the state before, which springs did not come by.
    pub(crate) fn find_gradients(&mut self) {
        let first = self.setup.assembly.bodies[self.plan.body].first;
        if let (Some(_), TiledSprings::Mesh(sets)) = (self.volume, &self.setup.springs[self.plan.body])
            && let Some(rings) = sets.first()
        {
            let places = [0, 1, 2].map(|axis| &self.old[axis][first..]);
            rings.gradients(self.setup.level, self.plan.units.clone(), places, &mut self.scratch.gradient);
        }
    }
}
