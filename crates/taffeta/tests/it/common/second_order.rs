//! Steps of second order in time: Bossak's accelerations, each node's own, as its formulas have them.

use super::constraints::PredictedContact;
use super::primal::{M3, ZERO, along, plus, times, unit};
use super::reference::Reference;
use super::{V, add, dot, scale, sub};

/// How accelerations and places follow from velocities in a step.
struct Newmark {
    h: f64,
    mu: f64,
    beta: f64,
    gamma: f64,
    /// Whether accelerations before are not known: then by implicit Euler.
    is_first: bool,
}

/// What a node goes on with, and what holds it.
#[derive(Clone, Copy)]
struct Node {
    x: V,
    v: V,
    a: V,
    /// By forces that are not solved for [m/s²], and by friction at once [m/s].
    outer: V,
    rubbed: V,
    is_held: bool,
}

impl Newmark {
    fn new(h: f64, is_first: bool) -> Self {
        let left = 0.5;
        let mu = if is_first { 0.0 } else { (1.0 - left) / (1.0 + left) };
        Self { h, mu, beta: 0.25 * (1.0 + mu) * (1.0 + mu), gamma: 0.5 + mu, is_first }
    }

    /// Change of place by velocity [s], and of acceleration [1/s].
    fn slopes(&self) -> [f64; 2] {
        if self.is_first {
            [self.h, 1.0 / self.h]
        } else {
            [self.h * self.beta / self.gamma, 1.0 / (self.h * self.gamma)]
        }
    }

    fn rate(&self, node: &Node, u: V) -> V {
        let gained = sub(sub(u, node.rubbed), node.v);
        if self.is_first {
            return scale(gained, 1.0 / self.h);
        }
        scale(sub(gained, scale(node.a, self.h * (1.0 - self.gamma))), 1.0 / (self.h * self.gamma))
    }

    fn place(&self, node: &Node, u: V) -> V {
        if self.is_first || node.is_held {
            return add(node.x, scale(u, self.h));
        }
        // What rubs changes the velocity at the start.
        let unrubbed = Node { rubbed: [0.0; 3], ..*node };
        let mean = add(scale(node.a, 0.5 - self.beta), scale(self.rate(&unrubbed, u), self.beta));
        add(node.x, add(scale(node.v, self.h), scale(mean, self.h * self.h)))
    }
}

impl Reference {
    /// Adds to forces what makes of Euler's step one of second order, springs included; keeps accelerations, and where nodes
    /// without velocity would come to.
    pub fn constrain_at_second_order(&mut self, f: &mut [V], h: f64) {
        let newmark = Newmark::new(h, self.time == 0.0);
        let free = self.free_velocities(f, h);
        let count = free.len();
        self.changes.resize(count, [0.0; 3]);
        self.rates.resize(count, [0.0; 3]);
        let predicted: Vec<Option<PredictedContact>> = (0..count)
            .map(|n| self.predict_contact(n, [free[n], add(free[n], self.changes[n])], h))
            .collect();
        let yields: Vec<M3> = (0..count)
            .map(|n| match &predicted[n] {
                _ if self.held.contains(&n) => ZERO,
                Some(predicted) if predicted.sticks => ZERO,
                Some(predicted) => plus(unit(1.0), along(predicted.normal).map(|row| scale(row, -1.0))),
                None => unit(1.0),
            })
            .collect();
        let nodes: Vec<Node> = (0..count)
            .map(|n| {
                let held = predicted[n].as_ref().map_or(free[n], |one| one.held(free[n]));
                Node {
                    x: self.x[n],
                    v: add(held, times(yields[n], sub(self.v[n], held))),
                    a: times(yields[n], self.rates[n]),
                    outer: scale(sub(free[n], self.v[n]), 1.0 / h),
                    rubbed: predicted[n].as_ref().map_or([0.0; 3], |one| one.friction_change),
                    is_held: self.held.contains(&n),
                }
            })
            .collect();
        let (u, pushed) = self.solved(&newmark, &nodes, &yields);
        for n in (0..count).filter(|&n| !nodes[n].is_held) {
            let by_all = sub(u[n], free[n]);
            let change = match &predicted[n] {
                None => by_all,
                Some(one) if one.sticks => pushed[n],
                Some(one) => {
                    let slid = sub(by_all, one.friction_change);
                    add(slid, scale(one.normal, dot(sub(pushed[n], slid), one.normal)))
                }
            };
            let pulled = add(free[n], change);
            let after =
                predicted[n].as_ref().map_or(pulled, |one| Self::velocity_after(free[n], pulled, one));
            f[n] = add(f[n], scale(sub(after, free[n]), self.mass[n] / h));
            self.changes[n] = change;
        }
        self.rates = (0..count).map(|n| times(yields[n], newmark.rate(&nodes[n], u[n]))).collect();
        let rest = nodes.iter().map(|node| newmark.place(node, [0.0; 3])).collect();
        self.arrive = Some((rest, newmark.slopes()[0]));
    }

    /// Velocities after the step, and what springs would change of them in the whole of it, by Newton's steps.
    fn solved(&self, newmark: &Newmark, nodes: &[Node], yields: &[M3]) -> (Vec<V>, Vec<V>) {
        let [reach, rate] = newmark.slopes();
        let heavy: Vec<f64> = self.mass.iter().map(|m| m * (1.0 + newmark.mu) * reach * rate).collect();
        let mut u: Vec<V> = nodes.iter().map(|node| node.v).collect();
        let mut pushed = vec![[0.0; 3]; u.len()];
        for _ in 0..self.solver.ice.newton_steps {
            let x: Vec<V> = nodes.iter().zip(&u).map(|(node, &u)| newmark.place(node, u)).collect();
            let system = self.linearised_at(&x, &u, reach, &heavy);
            let right: Vec<V> = (0..u.len())
                .map(|n| {
                    let (node, m) = (&nodes[n], self.mass[n] * reach);
                    let inertia = scale(newmark.rate(node, u[n]), 1.0 + newmark.mu);
                    let inertia = sub(inertia, add(scale(node.a, newmark.mu), node.outer));
                    sub(system.impulses[n], scale(inertia, m))
                })
                .collect();
            let change = system.matrix.solve(&right, yields, &heavy);
            for (n, resisted) in system.matrix.apply(&change).into_iter().enumerate() {
                let push = sub(system.impulses[n], sub(resisted, scale(change[n], heavy[n])));
                pushed[n] = scale(push, self.inverse_mass(n) * newmark.h / reach);
                u[n] = add(u[n], change[n]);
            }
        }
        (u, pushed)
    }
}
