//! Hinges on the CPU.

use crate::build::Assembly;
use crate::cpu::shared::Shared;
use crate::cpu::simd::SimdLevel;
use crate::cpu::worker::Worker;
use crate::elements::cpu::ElementSet;
use crate::elements::hinge::hinge::{self, Rest};
use crate::real::Real;
use crate::topology::{Csr, LANES};
use std::ops::Range;

/// Hinges by solver index.
pub struct Hinges<T> {
    /// Corners `[a, b, left, right]`.
    corners: Vec<[u32; 4]>,
    /// Each at rest.
    rest: Vec<Rest<T>>,
    /// Hinges, stiffness [N·m/rad] and damping [N·m·s/rad] of each body that has some.
    bodies: Vec<(Range<usize>, T, T)>,
    /// For each place: 4·hinge + corner.
    by_node: Csr,
    /// Forces on the corners of each [N].
    forces: Shared<[[T; 3]; 4]>,
}

impl<T: Real> Hinges<T> {
    /// Those of a scene, if it has any.
    pub fn new(assembly: &Assembly) -> Option<Self> {
        let (mut corners, mut rest, mut bodies) = (Vec::new(), Vec::new(), Vec::new());
        for body in assembly.bodies.iter().filter(|body| !body.hinges.is_empty()) {
            let (from, first) = (corners.len(), body.first as u32);
            corners.extend(body.hinges.iter().map(|corners| corners.map(|node| node + first)));
            rest.extend(
                body.hinge_rest.iter().map(|rest| Rest {
                    angle: T::from_f64(rest.angle),
                    steepness: T::from_f64(rest.steepness),
                }),
            );
            bodies.push((from..corners.len(), T::from_f64(body.hinge.k), T::from_f64(body.hinge.d)));
        }
        (!corners.is_empty()).then(|| Self {
            by_node: Csr::corners(assembly.places, &corners),
            forces: vec![[[T::ZERO; 3]; 4]; corners.len()].into(),
            corners,
            rest,
            bodies,
        })
    }

    /// Forces on the corners of each [N], as last found.
    #[cfg(feature = "gpu")]
    pub fn forces(&self) -> &[[[T; 3]; 4]] {
        // SAFETY: asked for between frames, when no worker works.
        unsafe { self.forces.read() }
    }
}

impl<T: Real> ElementSet<T> for Hinges<T> {
    fn find(&self, worker: &Worker<'_, T>) {
        let (state, mine) = (worker.old(), worker.part(self.corners.len()));
        // SAFETY: parts of workers do not overlap, and forces are read only after the barrier.
        let out = unsafe { self.forces.write(mine.clone()) };
        for (range, k, damping) in &self.bodies {
            for i in range.start.max(mine.start)..range.end.min(mine.end) {
                let corners = self.corners[i].map(|node| node as usize);
                let x = corners.map(|node| [state[0][node], state[1][node], state[2][node]]);
                let v = corners.map(|node| [state[3][node], state[4][node], state[5][node]]);
                out[i - mine.start] = hinge::forces(x, v, *k, *damping, self.rest[i]);
            }
        }
    }

    fn gather(&self, _: SimdLevel, nodes: Range<usize>, sum: &mut [[T; LANES]; 3]) {
        // SAFETY: found before a barrier, and found anew after the sub-step's last.
        let forces = unsafe { self.forces.read() };
        for (lane, node) in nodes.enumerate() {
            for &corner in self.by_node.row(node) {
                let force = forces[corner as usize / 4][corner as usize % 4];
                for axis in 0..3 {
                    sum[axis][lane] += force[axis];
                }
            }
        }
    }

    fn energy(&self, state: [&[T]; 6]) -> f64 {
        let mut sum = 0.0;
        for (range, k, _) in &self.bodies {
            for i in range.clone() {
                let corners = self.corners[i].map(|n| [0, 1, 2].map(|c| state[c][n as usize]));
                sum += hinge::energy(corners, *k, self.rest[i].angle).to_f64();
            }
        }
        sum
    }

    fn bytes(&self) -> usize {
        self.corners.len() * (size_of::<[[T; 3]; 4]>() + 36)
    }
}
