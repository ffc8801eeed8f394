//! A frame with a clock: what the first worker spends on each stage. Waiting for the others has a name of its own where it
//! is no part of a stage.

use crate::step::{Stage, Stages, Tile};
use std::cell::Cell;
use std::time::Instant;

/// Going over tiles, and waiting between sub-steps.
const BETWEEN: usize = Stage::ALL.len();

/// Time that stages take [s], each without those inside it.
#[derive(Default)]
pub struct Clock {
    times: [Cell<f64>; BETWEEN + 1],
}

impl Clock {
    /// Times by the names of stages, those that took none left out.
    pub fn by_name(&self) -> Vec<(&'static str, f64)> {
        let names = Stage::ALL.into_iter().map(Stage::name).chain(["between"]);
        names.zip(self.times.iter().map(Cell::get)).filter(|&(_, time)| time > 0.0).collect()
    }

    fn total(&self) -> f64 {
        self.times.iter().map(Cell::get).sum()
    }

    /// Does a job, and counts what other stages inside it do not.
    fn time<R>(&self, stage: usize, job: impl FnOnce() -> R) -> R {
        let (before, clock) = (self.total(), Instant::now());
        let result = job();
        let inside = self.total() - before;
        let time = &self.times[stage];
        time.set(time.get() + (clock.elapsed().as_secs_f64() - inside).max(0.0));
        result
    }
}

/// A worker whose stages are timed.
pub struct Timed<'a, S> {
    /// The worker.
    pub worker: &'a mut S,
    /// What it takes.
    pub clock: &'a Clock,
}

/// A tile of it.
pub struct TimedTile<'a> {
    tile: &'a mut dyn Tile,
    clock: &'a Clock,
}

/// Hands out the tiles of a stage with their clock.
macro_rules! on_tiles {
    ($self:ident, $stage:expr, $method:ident, $substep:ident, $stages:ident) => {{
        let clock = $self.clock;
        clock.time($stage, || $self.worker.$method($substep, |tile| $stages(&mut TimedTile { tile, clock })))
    }};
}

impl<S: Stages> Stages for Timed<'_, S> {
    type Substep = S::Substep;
    type Tile<'t>
        = TimedTile<'t>
    where
        Self: 't;

    fn elements(&mut self, substep: &S::Substep) {
        self.clock.time(Stage::Elements as usize, || self.worker.elements(substep));
    }
    fn particles(&mut self, substep: &S::Substep, stages: impl Fn(&mut TimedTile<'_>)) {
        on_tiles!(self, BETWEEN, particles, substep, stages);
    }
    fn constrains(&self) -> bool {
        self.worker.constrains()
    }
    fn constraints(&mut self, substep: &S::Substep, stages: impl Fn(&mut TimedTile<'_>)) {
        on_tiles!(self, Stage::Constraints as usize, constraints, substep, stages);
    }
    fn keeps_volumes(&self) -> bool {
        self.worker.keeps_volumes()
    }
    fn volumes(&mut self, substep: &S::Substep, stages: impl Fn(&mut TimedTile<'_>)) {
        on_tiles!(self, Stage::Volumes as usize, volumes, substep, stages);
    }
    fn attaches(&self) -> bool {
        self.worker.attaches()
    }
    fn attach(&mut self, substep: &S::Substep, stages: impl Fn(&mut TimedTile<'_>)) {
        on_tiles!(self, Stage::Attach as usize, attach, substep, stages);
    }
    fn collides(&self) -> bool {
        self.worker.collides()
    }
    fn pairs(&mut self, substep: &S::Substep, stages: impl Fn(&mut TimedTile<'_>)) {
        on_tiles!(self, Stage::Pairs as usize, pairs, substep, stages);
    }
    fn project(&mut self, substep: &S::Substep, stages: impl Fn(&mut TimedTile<'_>)) -> bool {
        on_tiles!(self, Stage::Project as usize, project, substep, stages)
    }
    fn end(&mut self, substep: &S::Substep) {
        self.clock.time(BETWEEN, || self.worker.end(substep));
    }
    fn diagnose(&mut self) {
        self.clock.time(Stage::Diagnose as usize, || self.worker.diagnose());
    }
}

impl TimedTile<'_> {
    fn time(&mut self, stage: Stage, job: impl FnOnce(&mut dyn Tile)) {
        self.clock.time(stage as usize, || job(self.tile));
    }
}

impl Tile for TimedTile<'_> {
    fn loads(&mut self) {
        self.time(Stage::Loads, |tile| tile.loads());
    }
    fn springs(&mut self) {
        self.time(Stage::Springs, |tile| tile.springs());
    }
    fn is_constrained(&self) -> bool {
        self.tile.is_constrained()
    }
    fn wait_for_constraints(&mut self) {
        self.time(Stage::Constraints, |tile| tile.wait_for_constraints());
    }
    fn constrain(&mut self) {
        self.time(Stage::Constraints, |tile| tile.constrain());
    }
    fn keeps_volume(&self) -> bool {
        self.tile.keeps_volume()
    }
    fn gradients(&mut self) {
        self.time(Stage::Volumes, |tile| tile.gradients());
    }
    fn keep_volume(&mut self) {
        self.time(Stage::Volumes, |tile| tile.keep_volume());
    }
    fn integrate(&mut self) {
        self.time(Stage::Integrate, |tile| tile.integrate());
    }
    fn pins(&mut self) {
        self.time(Stage::Pins, |tile| tile.pins());
    }
    fn contact(&mut self) {
        self.time(Stage::Contact, |tile| tile.contact());
    }
    fn attach(&mut self) {
        self.time(Stage::Attach, |tile| tile.attach());
    }
    fn part(&mut self) {
        self.time(Stage::Pairs, |tile| tile.part());
    }
    fn restore_volume(&mut self) {
        self.time(Stage::Project, |tile| tile.restore_volume());
    }
}
