//! The contacts of a worker in a sub-step, and what is exchanged with other workers about their nodes.

use crate::contact::triangles::impulse::Contact;
use crate::contact::triangles::order::Order;
use crate::contact::triangles::surfaces::Kind;
use crate::cpu::cells::{Cells, PerWorker};
use crate::real::{Real, add, scale, sub};

/// The force of a contact, which the next sub-step starts from.
#[derive(Clone, Copy, Debug)]
pub struct Carried<T> {
    pub order: Order,
    pub kind: Kind,
    /// Both primitives by their numbers.
    pub key: [u32; 2],
    /// On the first side [N].
    pub force: [T; 3],
    /// The impulse that the solver of an implicit sub-step has given it [N·s], if it is part of the system.
    pub solved: Option<[T; 3]>,
}

/// A contact, with its nodes.
pub struct Active<T> {
    pub carried: Carried<T>,
    pub nodes: [u32; 4],
    pub weights: [T; 4],
    pub contact: Contact<T>,
    /// Impulse on the first side, beside that of the solver [N·s].
    pub impulse: [T; 3],
}

impl<T: Real> Active<T> {
    /// Velocity of the first side relative to the second [m/s].
    pub fn velocity(&self, v: impl Fn(u32) -> [T; 3]) -> [T; 3] {
        let anchor = v(self.nodes[3]);
        let of = |node: usize| scale(sub(v(self.nodes[node]), anchor), self.weights[node]);
        add(add(of(0), of(1)), of(2))
    }
}

/// A node's part in a contact.
#[derive(Clone, Copy, Debug)]
pub struct Part<T> {
    /// The node by place; then its number among its worker's nodes in contact.
    pub node: u32,
    /// The contact among those of the worker that has found it.
    contact: u32,
    /// Its weight there.
    weight: T,
}

/// What workers tell each other about contacts: which nodes take part, and what acts on them. Between the sending and the reading is
/// a barrier.
pub struct Mail<T> {
    workers: usize,
    /// From each worker to each.
    parts: Cells<Vec<Part<T>>>,
    /// For each worker's contacts: what removes old overlaps [kg·m], and the impulse [N·s].
    pushes: PerWorker<Vec<[T; 3]>>,
    impulses: PerWorker<Vec<[T; 3]>>,
}

impl<T: Real> Mail<T> {
    /// For so many workers.
    pub fn new(workers: usize) -> Self {
        let vectors = || PerWorker::new(workers, |_| Vec::new());
        Self {
            workers,
            parts: Cells::new(workers * workers, |_| Vec::new()),
            pushes: vectors(),
            impulses: vectors(),
        }
    }

    /// Sends the nodes of a worker's contacts, those of the first `places`, each to the worker that has it.
    pub fn send_parts(
        &self,
        from: usize,
        contacts: &[Active<T>],
        places: u32,
        worker: impl Fn(u32) -> usize,
    ) {
        let mut parts: Vec<_> = (0..self.workers).map(|to| self.parts.of(from * self.workers + to)).collect();
        parts.iter_mut().for_each(|parts| parts.clear());
        for (number, contact) in (0..).zip(contacts) {
            for (&node, &weight) in contact.nodes.iter().zip(&contact.weights) {
                if weight != T::ZERO && node < places {
                    let to = if self.workers > 1 { worker(node) } else { 0 };
                    parts[to].push(Part { node, contact: number, weight });
                }
            }
        }
    }

    /// Calls `job` with each part that was sent to a worker, in an order that does not depend on the number of workers.
    pub fn each_part(&self, to: usize, mut job: impl FnMut(&mut Part<T>)) {
        for from in 0..self.workers {
            self.parts.of(from * self.workers + to).iter_mut().for_each(&mut job);
        }
    }

    /// Sends a vector for each contact of a worker: what removes old overlaps, or its impulse.
    pub fn send(&self, what: What, from: usize, vectors: impl Iterator<Item = [T; 3]>) {
        let mut own = self.vectors(what).of(from);
        own.clear();
        own.extend(vectors);
    }

    /// Calls `add` with the number of a node of a worker and the vector of a contact times the node's weight there, for each
    /// part, in the order of [`Self::each_part`].
    pub fn sum(&self, what: What, to: usize, mut add: impl FnMut(usize, [T; 3])) {
        for from in 0..self.workers {
            let parts = self.parts.read(from * self.workers + to);
            if parts.is_empty() {
                // Most workers have contacts with few others, and need not contend for their vectors.
                continue;
            }
            let vectors = self.vectors(what).read(from);
            for part in parts.iter() {
                add(part.node as usize, scale(vectors[part.contact as usize], part.weight));
            }
        }
    }

    fn vectors(&self, what: What) -> &PerWorker<Vec<[T; 3]>> {
        match what {
            What::Pushes => &self.pushes,
            What::Impulses => &self.impulses,
        }
    }
}

/// Which vectors are sent.
#[derive(Clone, Copy, Debug)]
pub enum What {
    Pushes,
    Impulses,
}
