//! The order of a frame as the recorder walks through it.

use crate::step::PROJECTIONS;

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
