//! Single passes of a sub-step on a given state, to compare another backend with.

use crate::backend::{Backend, FrameInput};
use crate::cpu::backend::CpuBackend;
use crate::cpu::between::Between;
use crate::cpu::feature::Feature;
use crate::cpu::tile::Tile;
use crate::plan::Substep;
use crate::real::Real;
use crate::step::{self, Line, Op};
use crate::topology::LANES;
use std::ops::Range;

impl<T: Real> CpuBackend<T> {
    /// A feature by its type, if the scene has it.
    pub fn feature<F: Feature<T>>(&mut self) -> Option<&mut F> {
        self.features.get_mut()
    }

    /// Sets a place in the state after the sub-step, as position [m], then velocity [m/s].
    pub fn set_after(&mut self, place: usize, state: [T; 6]) {
        let after = &mut self.states[self.turn.next()];
        after.iter_mut().zip(state).for_each(|(column, number)| column.get_mut()[place] = number);
    }

    /// A place in the state after the sub-step.
    pub fn after(&self, place: usize) -> [T; 6] {
        std::array::from_fn(|axis| self.column_of(true, axis)[place])
    }

    /// Positions [m] and velocities [m/s] by axis and place, of the present state, or of that after the sub-step.
    pub fn fields(&self, next: bool) -> [&[T]; 6] {
        std::array::from_fn(|axis| self.column_of(next, axis))
    }

    /// Inverse mass [1/kg] and mass [kg] by place.
    pub fn masses(&self) -> (&[T], &[T]) {
        (&self.nodes.inverse_mass, &self.nodes.mass)
    }

    /// Begins a sub-step and computes the forces of its elements. Then runs each wanted operation on tiles once, from
    /// the present state to the one after, which does not become the present one. Forces start as in `between`.
    pub fn run_separately(
        &mut self,
        substep: &Substep<T>,
        input: &FrameInput,
        between: &mut Between<T>,
        wanted: impl Fn(Op) -> bool + Sync,
    ) {
        self.input = input.clone();
        assert_eq!(self.threads(), 1, "passes apart are for one worker");
        between.last_collider = vec![0; between.force.len()];
        let list: Vec<_> = step::substep(&self.parts).iter().flat_map(Line::passes).copied().collect();
        let mut operations: Vec<Op> = list.iter().map(|pass| pass.op).filter(|&op| wanted(op)).collect();
        let mut seen = [false; Op::COUNT];
        operations.retain(|&op| !std::mem::replace(&mut seen[op as usize], true));
        let kept = std::sync::Mutex::new(between);
        self.work(substep, |worker| {
            let mut between = kept.lock().expect("one worker");
            worker.features.iter().for_each(|feature| feature.begin(worker));
            for feature in worker.features.of(Op::Elements) {
                feature.run(Op::Elements, worker);
            }
            worker.each_tile(|tile| {
                load(tile, &between);
                for &op in &operations {
                    let marks = tile.marks.get();
                    if list.iter().any(|pass| pass.op == op && pass.on.chooses(marks)) {
                        tile.features.of(op).for_each(|feature| feature.tile(op, tile));
                    }
                }
                store(tile, &mut between);
            });
        });
    }

    /// Runs some passes of a sub-step.
    pub fn passes(&mut self, substep: &Substep<T>, lines: &[Line]) {
        assert_eq!(self.threads(), 1, "passes apart are for one worker");
        let program = crate::cpu::worker::Program::new(lines, &[]);
        self.work(substep, |worker| worker.passes(&program));
    }

    /// Ends a sub-step whose state was computed elsewhere.
    pub fn end(&mut self, state: impl Fn(usize, usize) -> T) {
        self.turn.pass();
        for (axis, column) in self.states[self.turn.now].iter_mut().enumerate() {
            let places = &mut column.get_mut()[..self.assembly.places];
            places.iter_mut().enumerate().for_each(|(place, number)| *number = state(axis, place));
        }
    }
}

/// A tile's runs of places, with the lanes past a mesh's last node.
fn runs<T>(tile: &Tile<'_, T>) -> Vec<(usize, Range<usize>)> {
    let is_grid = !tile.plan.cols.is_empty();
    let whole = |end: usize| if is_grid { end } else { end.next_multiple_of(LANES) };
    tile.plan.runs().map(|(at, run)| (at, run.start..whole(run.end))).collect()
}

fn load<T: Real>(tile: &mut Tile<'_, T>, between: &Between<T>) {
    tile.features.iter().for_each(|feature| feature.begin_apart(tile));
    for (at, run) in runs(tile) {
        for (i, place) in run.enumerate() {
            let force = between.force[place];
            tile.scratch.force.iter_mut().zip(force).for_each(|(column, number)| column[at + i] = number);
        }
    }
}

fn store<T: Real>(tile: &Tile<'_, T>, between: &mut Between<T>) {
    for (at, run) in runs(tile) {
        for (i, place) in run.enumerate() {
            between.force[place] = tile.scratch.force.each_ref().map(|column| column[at + i]);
        }
    }
    tile.features.iter().for_each(|feature| feature.end_apart(tile, between));
}
