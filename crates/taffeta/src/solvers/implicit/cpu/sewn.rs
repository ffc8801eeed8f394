//! Points of nodes that are sewn to each other, in the system.
//!
//! All workers call these functions after a barrier. Where there are points, they end with another one, unless they say otherwise.

use crate::contact::colliders::predicted_contact::PredictedContact;
use crate::real::{Real, Symmetric, add, scale, sub};
use crate::solvers::implicit::cpu::ImplicitWorker;
use crate::solvers::implicit::cpu::columns::Columns;
use crate::solvers::implicit::implicit::jacobi;
use crate::solvers::implicit::sewn::{Matrix, matrix_times, parallel, transposed_times};

impl<T: Real> ImplicitWorker<'_, '_, T> {
    /// Whether any nodes are one point in this sub-step.
    pub fn is_sewn(&self) -> bool {
        self.sewn.is_some()
    }

    /// Does something for the nodes of each point in this worker's part; `work` is given the number of the first of them among
    /// the nodes of all points, too.
    fn each_of_all_points(&self, work: impl Fn(&[u32], usize)) {
        let Some(sewn) = self.sewn else { return };
        for point in self.worker.part(sewn.nodes.rows()) {
            work(sewn.nodes.row(point), sewn.nodes.offsets[point] as usize);
        }
    }

    /// The same for points of bodies that are not done: bodies of a point are done together.
    fn each_point(&self, work: impl Fn(&[u32], usize)) {
        self.each_of_all_points(|nodes, first| {
            if !self.is_done(self.primal.places.body_of(nodes[0])) {
                work(nodes, first);
            }
        });
    }

    /// Whether a pin holds one of a point's nodes.
    fn is_pinned(&self, nodes: &[u32]) -> bool {
        nodes.iter().any(|&node| self.worker.nodes.inverse_mass[node as usize] <= T::ZERO)
    }

    /// Has the first surface that holds a node of a point hold all of them, unless a pin does.
    pub fn hold_points(&self) {
        if !self.is_sewn() || self.colliders.is_empty() {
            return;
        }
        self.each_point(|nodes, _| {
            // SAFETY: each point is in one worker's part, and each node in one point at most.
            let predicted = |node: u32| unsafe { self.shared.predicted.item(node as usize) };
            // SAFETY: as above.
            let surface = |node: u32| unsafe { self.shared.collider.item(node as usize) };
            if self.is_pinned(nodes) {
                return;
            }
            let Some(&holder) = nodes.iter().find(|&&node| predicted(node).in_contact()) else { return };
            let held: (PredictedContact<T>, u32) = (*predicted(holder), *surface(holder));
            for &node in nodes {
                (*predicted(node), *surface(node)) = held;
            }
        });
        self.worker.synchronise();
    }

    /// Has the nodes of each point end up in the same place, where the system starts from.
    pub fn begin_points(&self) {
        if !self.is_sewn() {
            return;
        }
        let (masses, inverse_mass) = (self.masses(), &self.worker.nodes.inverse_mass);
        self.each_point(|nodes, _| {
            let is_pinned = self.is_pinned(nodes);
            let (mut sum, mut weights) = ([T::ZERO; 3], T::ZERO);
            for place in nodes.iter().map(|&node| node as usize) {
                let pin = if inverse_mass[place] <= T::ZERO { T::ONE } else { T::ZERO };
                let weight = if is_pinned { pin } else { masses[place] };
                // SAFETY: as above.
                let x = unsafe { self.shared.moved.get(place) };
                sum = add(sum, scale(x, weight));
                weights += weight;
            }
            let middle = scale(sum, T::ONE / weights);
            for place in
                nodes.iter().map(|&node| node as usize).filter(|&place| inverse_mass[place] > T::ZERO)
            {
                let [start, free] = self.base(place);
                let velocity = scale(sub(middle, start), T::ONE / self.h);
                let [x, y, z] = middle;
                let [u, v, w] = velocity;
                // SAFETY: as above.
                unsafe {
                    self.shared.total.put(place, sub(velocity, free));
                    self.shared.moved.put(place, [x, y, z, u, v, w]);
                }
            }
        });
        self.worker.synchronise();
    }

    /// Finds the weights of the nodes of each point. Each worker alone needs those that it finds: there is no barrier at the end.
    pub fn weigh_points(&self) {
        self.each_point(|nodes, first| {
            // SAFETY: found before a barrier.
            let inverse = |node: u32| unsafe { self.shared.levels[0].inverse.get(node as usize) };
            let mut those_before: Symmetric<T> = inverse(nodes[0]);
            for (at, &node) in nodes.iter().enumerate().skip(1) {
                let (weight, together) = parallel(&those_before, &inverse(node));
                // SAFETY: each point is in one worker's part.
                unsafe { *self.shared.weights.item(first + at) = weight };
                those_before = together;
            }
        });
    }

    /// Distributes the residual of each point among its nodes, and takes the first step of the cycle there.
    pub fn distribute_residuals(&self) {
        if !self.is_sewn() {
            return;
        }
        let here = &self.shared.levels[0];
        self.each_point(|nodes, first| {
            // SAFETY: written before a barrier; each point is in one worker's part, and each node in one point at most.
            let residual = |node: u32| -> [T; 3] { unsafe { here.r.get(node as usize) } };
            let mut left = nodes.iter().fold([T::ZERO; 3], |sum, &node| add(sum, residual(node)));
            for (at, &node) in nodes.iter().enumerate().rev() {
                let others =
                    if at > 0 { transposed_times(self.weight(first + at), left) } else { [T::ZERO; 3] };
                let own = sub(left, others);
                // SAFETY: as above.
                unsafe {
                    here.r.put(node as usize, own);
                    here.z.put(node as usize, jacobi(&here.inverse.get(node as usize), own));
                }
                left = others;
            }
        });
        self.worker.synchronise();
    }

    /// Averages a vector over the nodes of each point.
    pub fn average_points(&self, vector: &Columns<T>) {
        if !self.is_sewn() {
            return;
        }
        self.each_point(|nodes, first| {
            // SAFETY: as above.
            let of = |node: u32| -> [T; 3] { unsafe { vector.get(node as usize) } };
            let mut all = of(nodes[0]);
            for (at, &node) in nodes.iter().enumerate().skip(1) {
                let own = of(node);
                all = add(own, matrix_times(self.weight(first + at), sub(all, own)));
            }
            for &node in nodes {
                // SAFETY: as above.
                unsafe { vector.put(node as usize, all) };
            }
        });
        self.worker.synchronise();
    }

    /// Has the nodes of a point that something holds press on it together: a pin bears what the nodes that are sewn to its own
    /// lack, a surface as much by each node as it has of the mass.
    pub fn pool_impulses(&self) {
        if !self.is_sewn() {
            return;
        }
        let nodes_mass = &self.worker.nodes.mass;
        self.each_of_all_points(|nodes, _| {
            // SAFETY: written before a barrier; each point is in one worker's part, and each node in one point at most.
            let impulse = |place: usize| -> [T; 3] { unsafe { self.shared.impulse.get(place) } };
            // SAFETY: as above.
            let put = |place: usize, impulse: [T; 3]| unsafe { self.shared.impulse.put(place, impulse) };
            let places = || nodes.iter().map(|&node| node as usize);
            let is_free = |place: &usize| self.worker.nodes.inverse_mass[*place] > T::ZERO;
            if let Some(pin) = places().find(|place| !is_free(place)) {
                let lacks = |place: usize| {
                    // SAFETY: as above.
                    let total: [T; 3] = unsafe { self.shared.total.get(place) };
                    sub(impulse(place), scale(total, self.masses()[place]))
                };
                let all = places().filter(is_free).fold(impulse(pin), |sum, place| add(sum, lacks(place)));
                put(pin, all);
            } else if self.hold(0).predicted.get(nodes[0] as usize).is_some_and(PredictedContact::in_contact)
            {
                let sum = places().fold([T::ZERO; 3], |sum, place| add(sum, impulse(place)));
                let mass = places().fold(T::ZERO, |sum, place| sum + nodes_mass[place]);
                places().for_each(|place| put(place, scale(sum, nodes_mass[place] / mass)));
            }
        });
        self.worker.synchronise();
    }

    /// The weight of the nodes before one, by its number among those of all points.
    fn weight(&self, at: usize) -> &Matrix<T> {
        // SAFETY: found by this worker.
        unsafe { &self.shared.weights.read()[at] }
    }
}
