//! The contacts of a worker in a sub-step, and what is exchanged with other workers about their nodes.

use crate::contact::triangles::cpu::lanes::{See, Seen, gather};
use crate::contact::triangles::cpu::pairs::List;
use crate::contact::triangles::impulse::{Contact, KEEPS};
use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::real::{Real, add, scale, sub};
use crate::topology::LANES;

/// A contact, with its nodes.
pub struct Active<T> {
    /// The list, and the pair in it.
    pub list: usize,
    pub pair: usize,
    pub nodes: [u32; 4],
    pub weights: [T; 4],
    pub contact: Contact<T>,
    /// Impulse on the first side [N·s].
    pub impulse: [T; 3],
}

impl<T: Real> Active<T> {
    /// Velocity of the first side relative to the second [m/s].
    pub fn velocity(&self, v: impl Fn(u32) -> [T; 3]) -> [T; 3] {
        let anchor = v(self.nodes[3]);
        let of = |node: usize| scale(sub(v(self.nodes[node]), anchor), self.weights[node]);
        add(of(0), add(of(1), of(2)))
    }
}

/// The columns that pairs are seen in.
#[derive(Clone, Copy)]
pub struct Columns<'a, T> {
    pub before: [&'a [T]; 3],
    pub after: [&'a [T]; 3],
    pub level: SimdLevel,
    /// The sub-step [s].
    pub h: T,
    /// How far nodes have moved since the search, and how much nearer they may come in this sub-step [m].
    pub travelled: f64,
    pub stride: f64,
}

impl<T: Real> List<T> {
    /// Looks at all pairs that are awake, and adds the contacts among them.
    pub fn find(&mut self, number: usize, columns: &Columns<'_, T>, found: &mut Vec<Active<T>>) {
        self.wake(columns.travelled + columns.stride);
        let mut awake = std::mem::take(&mut self.awake);
        for sixteen in awake.chunks_mut(LANES) {
            let nodes = gather(sixteen.iter().map(|(pair, _)| &self.nodes[*pair as usize]));
            let Columns { before, after, .. } = *columns;
            let seen = columns.level.run(See { kind: self.kind, nodes: &nodes, before, after });
            for (lane, (pair, distance)) in sixteen.iter_mut().enumerate() {
                *distance = seen.distance[lane];
                let pair = *pair as usize;
                let thickness = self.materials[pair][0];
                let slack = *distance - T::from_f64(KEEPS) * thickness;
                self.wakes[pair] = columns.travelled + slack.to_f64() * (1.0 - 1e-5);
                let carries = self.forces[pair] != [T::ZERO; 3];
                let keeps = if carries { T::from_f64(KEEPS) } else { T::ONE };
                if seen.then[lane] < keeps * thickness && *distance > T::ZERO {
                    found.push(self.active(number, (lane, pair), &seen, columns.h));
                } else {
                    self.forces[pair] = [T::ZERO; 3];
                }
            }
        }
        self.awake = awake;
    }

    fn active(&self, list: usize, (lane, pair): (usize, usize), seen: &Seen<T>, h: T) -> Active<T> {
        let ([thickness, friction], distance) = (self.materials[pair], seen.distance[lane]);
        Active {
            list,
            pair,
            nodes: self.nodes[pair],
            weights: seen.weights.map(|lanes| lanes[lane]),
            contact: Contact {
                normal: seen.apart.map(|lanes| lanes[lane] / distance),
                gap: distance - thickness,
                thickness,
                friction,
                advance: T::ZERO,
                mobility: T::ZERO,
            },
            impulse: scale(self.forces[pair], h),
        }
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

/// What workers tell each other about contacts: which nodes take part, and what acts on them.
pub struct Mail<T> {
    workers: usize,
    /// For each kind of pairs, and from each worker to each.
    parts: Shared<Vec<Part<T>>>,
    /// For each worker's contacts: what removes old overlaps [kg·m], and the impulse [N·s].
    pushes: Shared<Vec<[T; 3]>>,
    impulses: Shared<Vec<[T; 3]>>,
}

impl<T: Real> Mail<T> {
    /// For so many workers.
    pub fn new(workers: usize) -> Self {
        let vectors = || vec![Vec::new(); workers].into();
        Self {
            workers,
            parts: vec![Vec::new(); 2 * workers * workers].into(),
            pushes: vectors(),
            impulses: vectors(),
        }
    }

    /// Sends the nodes of contacts, those of the first `places`, each to the worker that has it.
    ///
    /// # Safety
    /// `from` is the worker that calls, and nobody reads its mail before the next barrier.
    pub unsafe fn send_parts(
        &self,
        from: usize,
        contacts: &[Active<T>],
        places: u32,
        worker: impl Fn(u32) -> usize,
    ) {
        let index = |kind: usize, to: usize| (kind * self.workers + from) * self.workers + to;
        for (kind, to) in (0..2).flat_map(|kind| (0..self.workers).map(move |to| (kind, to))) {
            // SAFETY: the caller's promise.
            unsafe { self.parts.item(index(kind, to)) }.clear();
        }
        for (number, contact) in (0..).zip(contacts) {
            for (&node, &weight) in contact.nodes.iter().zip(&contact.weights) {
                if weight != T::ZERO && node < places {
                    let to = if self.workers > 1 { worker(node) } else { 0 };
                    // SAFETY: as above.
                    let parts = unsafe { self.parts.item(index(contact.list, to)) };
                    parts.push(Part { node, contact: number, weight });
                }
            }
        }
    }

    /// Calls `job` with each part that was sent to a worker, in an order that does not depend on the number of workers.
    ///
    /// # Safety
    /// `to` is the worker that calls, after a barrier that follows the sending.
    pub unsafe fn each_part(&self, to: usize, mut job: impl FnMut(&mut Part<T>)) {
        for sent in 0..2 * self.workers {
            // SAFETY: the caller's promise.
            unsafe { self.parts.item(sent * self.workers + to) }.iter_mut().for_each(&mut job);
        }
    }

    /// Sends a vector for each contact: what removes old overlaps, or its impulse.
    ///
    /// # Safety
    /// As of [`Self::send_parts`].
    pub unsafe fn send(&self, what: What, from: usize, vectors: impl Iterator<Item = [T; 3]>) {
        // SAFETY: the caller's promise.
        let own = unsafe { self.vectors(what).item(from) };
        own.clear();
        own.extend(vectors);
    }

    /// Calls `add` with the number of a node of a worker and the vector of a contact times the node's weight there, for each
    /// part, in the order of [`Self::each_part`].
    ///
    /// # Safety
    /// As of [`Self::each_part`]; nobody sends vectors before the next barrier.
    pub unsafe fn sum(&self, what: What, to: usize, mut add: impl FnMut(usize, [T; 3])) {
        // SAFETY: the caller's promise.
        let (parts, vectors) = unsafe { (self.parts.read(), self.vectors(what).read()) };
        for kind in 0..2 {
            for (from, vectors) in vectors.iter().enumerate() {
                for part in &parts[(kind * self.workers + from) * self.workers + to] {
                    add(part.node as usize, scale(vectors[part.contact as usize], part.weight));
                }
            }
        }
    }

    fn vectors(&self, what: What) -> &Shared<Vec<[T; 3]>> {
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
