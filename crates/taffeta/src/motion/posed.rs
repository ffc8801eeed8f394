//! Pinned nodes that follow poses of their body's mesh, as an animation program has them.

use crate::assembly::Assembly;
use crate::motion::poses;

/// A node that is moved in a frame: its solver index, and where it starts and ends [m].
type Move = (u32, [f64; 3], [f64; 3]);

/// The nodes of a pin that follow poses.
pub struct PosedPin {
    /// Solver indices.
    pub nodes: Vec<u32>,
    /// Where those nodes are [m] in each pose.
    pub poses: Vec<Vec<[f64; 3]>>,
    /// Time between poses, and that of the first [s].
    pub interval: f64,
    pub start: f64,
}

/// Those of a scene. A node is in one of them at most.
#[derive(Default)]
pub struct PosedPins(pub Vec<PosedPin>);

impl PosedPin {
    /// Where its nodes are at a time [s].
    pub fn at(&self, t: f64) -> Vec<[f64; 3]> {
        let last = self.poses.len() as f64 - 1.0;
        poses::at(&self.poses, ((t - self.start) / self.interval).clamp(0.0, last))
    }

    /// Whether a pose is still to come at a time [s].
    pub fn goes_on_after(&self, t: f64) -> bool {
        t < self.start + (self.poses.len() as f64 - 1.0) * self.interval
    }
}

impl Assembly {
    /// Pins that follow poses.
    pub fn posed_pins(&self) -> &[PosedPin] {
        self.extensions.get::<PosedPins>().map_or(&[], |posed| &posed.0)
    }

    /// Nodes that poses move over a span of time [s], ascending.
    pub fn posed_moves(&self, span: [f64; 2]) -> Vec<Move> {
        let mut all: Vec<Move> = Vec::new();
        for pin in self.posed_pins() {
            let [from, to] = span.map(|t| pin.at(t));
            let moves = pin.nodes.iter().zip(from).zip(to).map(|((&node, from), to)| (node, from, to));
            all.extend(moves.filter(|(_, from, to)| from != to));
        }
        all.sort_unstable_by_key(|&(node, ..)| node);
        all
    }

    /// Whether a pin of a body has nodes that are still to be moved by poses after a time [s].
    pub fn is_posed_after(&self, body: usize, t: f64) -> bool {
        let nodes = self.bodies[body].solver_range();
        let of_body =
            |pin: &&PosedPin| pin.nodes.first().is_some_and(|&node| nodes.contains(&(node as usize)));
        self.posed_pins().iter().filter(of_body).any(|pin| pin.goes_on_after(t))
    }
}
