//! The first stages of a sub-step alone, and what they have found: where the CPU hands over to a GPU, to find out in
//! which stage the two differ.

use super::worker::Worker;
use crate::plan::Substep;
use crate::real::Real;
use crate::step::{Listed, Stage, Stages, Tile};
use std::sync::{Mutex, PoisonError};

/// What the first stages of a sub-step have found.
pub struct Begun<T> {
    /// Factor of each load that is a torque [N/m].
    pub torques: Vec<T>,
    /// Forces on the corners of each hinge [N].
    pub hinge_forces: Vec<[[T; 3]; 4]>,
    /// Force on each place by axis [N].
    pub force: [Vec<T>; 3],
    /// Whether the node at each place has touched a collider.
    pub touched: Vec<bool>,
}

impl<T: Real> Begun<T> {
    /// Nothing yet, for some places.
    pub fn new(places: usize) -> Self {
        Self {
            torques: Vec::new(),
            hinge_forces: Vec::new(),
            force: [0; 3].map(|_| vec![T::ZERO; places]),
            touched: vec![false; places],
        }
    }
}

/// A worker that does no more than the stages before `until`.
pub struct Begin<'a, 'w, 's, T> {
    pub worker: &'a mut Worker<'w, T>,
    pub until: Stage,
    pub begun: &'a Mutex<Begun<T>>,
    /// The only sub-step.
    pub substep: &'s Substep<T>,
}

impl<T: Real> Stages for Begin<'_, '_, '_, T> {
    type Substep = ();
    type Tile<'t>
        = Listed
    where
        Self: 't;

    fn elements(&mut self, (): &()) {
        if self.until > Stage::Elements {
            self.worker.elements(self.substep);
            let mut begun = self.begun.lock().unwrap_or_else(PoisonError::into_inner);
            begun.torques.clone_from(&self.worker.scratch.torques);
        }
    }

    fn particles(&mut self, (): &(), stages: impl Fn(&mut Listed)) {
        let mut listed = Listed::default();
        stages(&mut listed);
        let (begun, until) = (self.begun, self.until);
        self.worker.tiles(self.substep, |tile| {
            for stage in listed.stages().filter(|stage| *stage < until) {
                match stage {
                    Stage::Loads => tile.loads(),
                    Stage::Springs => tile.springs(),
                    Stage::Integrate => tile.integrate(),
                    Stage::Pins => tile.pins(),
                    Stage::Contact => tile.contact(),
                    Stage::Elements | Stage::Diagnose => {}
                }
            }
            let mut begun = begun.lock().unwrap_or_else(PoisonError::into_inner);
            let collided = until > Stage::Contact && !tile.substep.colliders.is_empty();
            for (at, run) in tile.plan.runs() {
                for axis in 0..3 {
                    let found = &tile.scratch.force[axis][at..at + run.len()];
                    begun.force[axis][run.clone()].copy_from_slice(found);
                }
                for (i, place) in run.enumerate() {
                    begun.touched[place] = collided && tile.scratch.last_touch[at + i] > 0;
                }
            }
        });
    }

    fn diagnose(&mut self) {}
}
