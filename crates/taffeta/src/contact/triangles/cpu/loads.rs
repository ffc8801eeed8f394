//! Forces of contacts as loads of an implicit step.
//!
//! A solver that did not know of contact would have cloth under tension sink into what carries it, by millimetres in a step, and
//! impulses after it would move single nodes back: that stretches the springs between them. So the step has the forces of the
//! last one among its loads, and impulses after it are what has changed of them.

use super::{Scratch, TriangleContact, positions, read};
use crate::contact::triangles::closest::{EdgeEdge, Pair, VertexTriangle};
use crate::contact::triangles::cpu::contacts::Carried;
use crate::contact::triangles::surfaces::Kind;
use crate::cpu::tile::{Tile, within};
use crate::cpu::worker::Worker;
use crate::real::{Real, scale, sub};

/// A force on a node [N].
pub type Load<T> = (u32, [T; 3]);

impl<T: Real> TriangleContact<T> {
    /// Whether a step has the forces of the last one as loads. Those of surfaces that come apart change too fast.
    pub(super) fn has_loads(&self) -> bool {
        self.is_implicit && self.tangle.is_none()
    }

    /// Finds the forces on a worker's nodes. All workers call it.
    pub(super) fn find_loads(&self, worker: &Worker<'_, T>) {
        let workers = self.found.len();
        let (old, corners) = (positions(worker.old()), read(&self.after));
        let at = |node: u32| match node as usize {
            place if place < self.surfaces.places => old.map(|column| column[place]),
            corner => corners.map(|column| column[corner]),
        };
        let Scratch { carried, loads, .. } = self.scratch(worker);
        for to in 0..workers {
            // SAFETY: its own; others read them after the next barrier.
            unsafe { self.loads.item(worker.index * workers + to) }.clear();
        }
        for one in carried.iter() {
            let nodes = one.order.nodes(&self.surfaces);
            for (node, force) in nodes.into_iter().zip(one.on_nodes(nodes.map(at))) {
                if (node as usize) < self.surfaces.places
                    && worker.nodes.inverse_mass[node as usize] > T::ZERO
                {
                    let to = worker.index * workers + self.worker_of(node);
                    // SAFETY: as above.
                    unsafe { self.loads.item(to) }.push((node, force));
                }
            }
        }
        worker.synchronise();
        loads.clear();
        for from in 0..workers {
            // SAFETY: its own mail, sent before a barrier.
            loads.extend_from_slice(unsafe { self.loads.item(from * workers + worker.index) });
        }
        // A stable sort: the sums of a node are in the order of contacts, whoever has found them.
        loads.sort_by_key(|(node, _)| *node);
    }

    /// Adds them to the forces on a tile.
    pub(super) fn add_loads(&self, tile: &mut Tile<'_, T>) {
        // SAFETY: each worker has its own.
        let loads = &unsafe { self.scratch.of(tile.worker) }.loads;
        for (at, run) in tile.plan.runs() {
            for &(node, force) in within(loads, &run, |(node, _)| *node) {
                tile.add_force(at + node as usize - run.start, force);
            }
        }
    }
}

impl<T: Real> Carried<T> {
    /// The force on each of its nodes, which are at `x` [m].
    fn on_nodes(&self, x: [[T; 3]; 4]) -> [[T; 3]; 4] {
        let x = x.map(|one| sub(one, x[3]));
        let closest = match self.kind {
            Kind::VertexTriangle => VertexTriangle::closest(x),
            Kind::EdgeEdge => EdgeEdge::closest(x),
        };
        closest.weights.map(|weight| scale(self.force, weight))
    }
}
