//! One frame, top to bottom: the only place that knows the order of the stages.
//!
//! A backend lends workers that know how to run a stage on their part of the scene; this file says when. The
//! particle stages run one after the other on each tile (some hundred neighbouring nodes), so that what a stage has
//! just written is still at hand for the next; between `elements` and `particles`, and after them, all workers meet.

/// The stages of a sub-step in their order, and what is measured after the last one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// Forces of elements that several nodes share.
    #[default]
    Elements,
    /// Wind, drag, point loads, torques, hinges' forces by node.
    Loads,
    /// Forces of springs.
    Springs,
    /// New velocity, new position.
    Integrate,
    /// Moving pins.
    Pins,
    /// Colliders.
    Contact,
    /// Sums over the state.
    Diagnose,
}

impl Stage {
    /// All of them, in order.
    pub const ALL: [Self; 7] = [
        Self::Elements,
        Self::Loads,
        Self::Springs,
        Self::Integrate,
        Self::Pins,
        Self::Contact,
        Self::Diagnose,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elements => "elements",
            Self::Loads => "loads",
            Self::Springs => "springs",
            Self::Integrate => "integrate",
            Self::Pins => "pins",
            Self::Contact => "contact",
            Self::Diagnose => "diagnose",
        }
    }
}

/// What a backend's worker can do.
pub trait Stages {
    /// What a sub-step is told: its length, and poses, scales and colliders at its end.
    type Substep;
    /// Neighbouring nodes that pass through the particle stages together.
    type Tile<'a>: Tile
    where
        Self: 'a;

    /// Forces of elements that several nodes share (hinges), and sums that loads need (torques).
    fn elements(&mut self, substep: &Self::Substep);
    /// Runs `stages` on every tile of the worker's part.
    fn particles(&mut self, substep: &Self::Substep, stages: impl Fn(&mut Self::Tile<'_>));
    /// Energies, momenta, stretch and volumes at the end of the frame.
    fn diagnose(&mut self);
}

/// The particle stages, in the order in which they run.
pub trait Tile {
    /// Force from wind, drag, point loads, torques and hinges.
    fn loads(&mut self);
    /// Adds the force of the springs.
    fn springs(&mut self);
    /// New velocity, then new position.
    fn integrate(&mut self);
    /// Puts moving pins where their keyframes say.
    fn pins(&mut self);
    /// Keeps nodes out of colliders.
    fn contact(&mut self);
}

/// Runs one frame.
pub fn frame<S: Stages>(worker: &mut S, substeps: &[S::Substep]) {
    for substep in substeps {
        worker.elements(substep);
        worker.particles(substep, |tile| {
            tile.loads();
            tile.springs();
            // Constraints that correct forces (implicit constraint enforcement, volume) come between here and
            // `integrate`: they need all forces, so they split the particle stages in two passes.
            tile.integrate();
            tile.pins();
            tile.contact();
        });
    }
    worker.diagnose();
}
