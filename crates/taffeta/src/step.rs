//! One frame, top to bottom: the only place that knows the order of the stages.
//!
//! A backend lends workers that know how to run a stage on their part of the scene; this file says when. The
//! particle stages run one after the other on each tile (some hundred neighbouring nodes), so that what a stage has
//! just written is still at hand for the next; where a stage needs what all others have written, all workers meet.

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
    /// Forces of springs that are constraints.
    Constraints,
    /// Forces that keep volumes.
    Volumes,
    /// New velocity, new position.
    Integrate,
    /// Moving pins.
    Pins,
    /// Colliders.
    Contact,
    /// Seams, pins that break and tethers, and colliders again.
    Attach,
    /// Nodes that touch each other, and colliders again.
    Pairs,
    /// Nodes moved to restore volumes, and colliders again.
    Project,
    /// Sums over the state.
    Diagnose,
}

impl Stage {
    /// All of them, in order.
    pub const ALL: [Self; 12] = [
        Self::Elements,
        Self::Loads,
        Self::Springs,
        Self::Constraints,
        Self::Volumes,
        Self::Integrate,
        Self::Pins,
        Self::Contact,
        Self::Attach,
        Self::Pairs,
        Self::Project,
        Self::Diagnose,
    ];

    /// Its name.
    pub fn name(self) -> &'static str {
        match self {
            Self::Elements => "elements",
            Self::Loads => "loads",
            Self::Springs => "springs",
            Self::Constraints => "constraints",
            Self::Volumes => "volumes",
            Self::Integrate => "integrate",
            Self::Pins => "pins",
            Self::Contact => "contact",
            Self::Attach => "attach",
            Self::Pairs => "pairs",
            Self::Project => "project",
            Self::Diagnose => "diagnose",
        }
    }
}

/// Most times that a sub-step moves nodes to restore volumes.
pub const PROJECTIONS: usize = 5;

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
    /// Whether springs are constraints, or may become some.
    fn constrains(&self) -> bool;
    /// Finds the pulls of constraints, when all have found forces; then runs `stages` on tiles that wait for them.
    fn constraints(&mut self, substep: &Self::Substep, stages: impl Fn(&mut Self::Tile<'_>));
    /// Whether any body keeps its volume.
    fn keeps_volumes(&self) -> bool;
    /// Finds the multiplier of each volume, when all have found gradients; then runs `stages` on tiles that keep one.
    fn volumes(&mut self, substep: &Self::Substep, stages: impl Fn(&mut Self::Tile<'_>));
    /// Whether nodes are joined to others or to points, or held near others.
    fn attaches(&self) -> bool;
    /// Finds what that does to nodes, when all have moved; then runs `stages` on tiles of those that it moves.
    fn attach(&mut self, substep: &Self::Substep, stages: impl Fn(&mut Self::Tile<'_>));
    /// Whether nodes touch each other.
    fn collides(&self) -> bool;
    /// Finds the nodes that touch each other and what that does to them, when all have moved; then runs `stages` on their
    /// tiles.
    fn pairs(&mut self, substep: &Self::Substep, stages: impl Fn(&mut Self::Tile<'_>));
    /// Measures again the volumes that are restored by moving nodes, when all have moved; then runs `stages` on tiles of
    /// those that are off. Returns whether none is.
    fn project(&mut self, substep: &Self::Substep, stages: impl Fn(&mut Self::Tile<'_>)) -> bool;
    /// Ends the sub-step, when all have done their part.
    fn end(&mut self, substep: &Self::Substep);
    /// Energies, momenta, stretch and volumes at the end of the frame.
    fn diagnose(&mut self);
}

/// The particle stages, in the order in which they run.
pub trait Tile {
    /// Force from wind, drag, point loads, torques and hinges.
    fn loads(&mut self);
    /// Adds the force of the springs that are no constraints.
    fn springs(&mut self);
    /// Whether constraints act on its nodes.
    fn is_constrained(&self) -> bool;
    /// Keeps forces for later, and the velocity that they alone would give.
    fn wait_for_constraints(&mut self);
    /// Takes them up again, and adds the force of constraints.
    fn constrain(&mut self);
    /// Whether its nodes are those of a body that keeps its volume.
    fn keeps_volume(&self) -> bool;
    /// Gradients of the volume, and what the multiplier needs of them and of the force.
    fn gradients(&mut self);
    /// Adds the force that keeps the volume.
    fn keep_volume(&mut self);
    /// New velocity, then new position.
    fn integrate(&mut self);
    /// Puts moving pins where their keyframes say.
    fn pins(&mut self);
    /// Keeps nodes out of colliders.
    fn contact(&mut self);
    /// Gives nodes that are joined or tethered their new velocities and places.
    fn attach(&mut self);
    /// Gives nodes that touch each other their new velocities and places.
    fn part(&mut self);
    /// Moves nodes that touch nothing so that the volume is restored.
    fn restore_volume(&mut self);
}

/// Runs one frame.
pub fn frame<S: Stages>(worker: &mut S, substeps: &[S::Substep]) {
    for substep in substeps {
        worker.elements(substep);
        worker.particles(substep, |tile| {
            tile.loads();
            tile.springs();
            // Pulls need all other forces: there the way parts.
            if tile.is_constrained() { tile.wait_for_constraints() } else { forces_known(tile) }
        });
        if worker.constrains() {
            worker.constraints(substep, |tile| {
                tile.constrain();
                forces_known(tile);
            });
        }
        if worker.keeps_volumes() {
            worker.volumes(substep, |tile| {
                tile.keep_volume();
                go_on(tile);
            });
        }
        if worker.attaches() {
            worker.attach(substep, |tile| {
                tile.attach();
                tile.contact();
            });
        }
        if worker.collides() {
            worker.pairs(substep, |tile| {
                tile.part();
                tile.contact();
            });
        }
        if worker.keeps_volumes() {
            // Contact has changed volumes; what touches nothing gives them back, and may touch something then.
            for _ in 0..PROJECTIONS {
                let kept = worker.project(substep, |tile| {
                    tile.restore_volume();
                    tile.contact();
                });
                if kept {
                    break;
                }
            }
        }
        worker.end(substep);
    }
    worker.diagnose();
}

/// On from forces. A multiplier needs all of them on its body: there the way parts again.
fn forces_known(tile: &mut impl Tile) {
    if tile.keeps_volume() { tile.gradients() } else { go_on(tile) }
}

/// From forces to places.
fn go_on(tile: &mut impl Tile) {
    tile.integrate();
    tile.pins();
    tile.contact();
}
