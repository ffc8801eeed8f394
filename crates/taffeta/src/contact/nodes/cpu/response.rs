//! The contact response of nodes.

use crate::contact::nodes::cpu::ContactWorker;
use crate::contact::nodes::pair;
use crate::real::{Real, sub};
use std::sync::atomic::Ordering;

impl<T: Real> ContactWorker<'_, T> {
    /// Computes the contact response of each of its nodes, after a sub-step of `h` [s].
    pub fn respond(&mut self, h: T) {
        let limits = (h, T::from_f64(pair::max_separation(h.to_f64())));
        let contacts = |place: usize| self.shared.contacts[place].load(Ordering::Relaxed);
        let state = self.state();
        let mut responses = std::mem::take(&mut self.scratch.responses);
        responses.clear();
        for (number, &node) in self.scratch.contact_list.owners().iter().enumerate() {
            let node = node as usize;
            let mut sum = [T::ZERO; 6];
            for &other in self.scratch.contact_list.others(number) {
                let other = other as usize;
                let (a, b) = (node.min(other), node.max(other));
                let [xa, xb] = [a, b].map(|at| [0, 1, 2].map(|axis| state[axis][at]));
                let [va, vb] = [a, b].map(|at| [3, 4, 5].map(|axis| state[axis][at]));
                let mobility =
                    pair::mobility([self.inverse_mass[a], self.inverse_mass[b]], [contacts(a), contacts(b)]);
                let done =
                    pair::exchange(sub(xa, xb), sub(va, vb), mobility, &self.setup.material(a, b), limits);
                let sign = if node == a { T::ONE } else { -T::ONE };
                for axis in 0..3 {
                    sum[axis] += done.shift[axis] * sign;
                    sum[3 + axis] += done.impulse[axis] * sign;
                }
            }
            let w = self.inverse_mass[node];
            responses.push(std::array::from_fn(|axis| state[axis][node] + sum[axis] * w));
        }
        self.scratch.responses = responses;
    }
}
