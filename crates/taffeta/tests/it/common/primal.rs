//! Implicit springs and hinges by nodes: Newton's steps of backward Euler, every block of the system from lists of springs
//! and hinges, the system factorised, in 64 bits.

use super::constraints::PredictedContact;
use super::lists::{angle, angle_gradient};
use super::reference::{Fold, Reference, Spring};
use super::{V, add, dot, norm, scale, sub};

/// A symmetric matrix of three rows.
pub type M3 = [V; 3];

pub const ZERO: M3 = [[0.0; 3]; 3];

/// s times the unit matrix.
pub fn unit(s: f64) -> M3 {
    [[s, 0.0, 0.0], [0.0, s, 0.0], [0.0, 0.0, s]]
}

pub fn plus(a: M3, b: M3) -> M3 {
    std::array::from_fn(|i| add(a[i], b[i]))
}

pub fn times(a: M3, u: V) -> V {
    std::array::from_fn(|i| dot(a[i], u))
}

/// a b.
fn chained(a: M3, b: M3) -> M3 {
    std::array::from_fn(|i| std::array::from_fn(|j| (0..3).map(|k| a[i][k] * b[k][j]).sum()))
}

fn transposed(a: M3) -> M3 {
    std::array::from_fn(|i| std::array::from_fn(|j| a[j][i]))
}

/// n nᵀ.
pub fn along(n: V) -> M3 {
    n.map(|s| scale(n, s))
}

/// A spring between two nodes that are `apart` [m]: n, l, and the geometric stiffness |T|/l [N/m], at most k.
fn geometry(apart: V, &Spring(_, _, k, _, rest): &Spring) -> (V, f64, f64) {
    let length = norm(apart);
    (scale(apart, 1.0 / length), length, (k * (length - rest).abs() / length).min(k))
}

/// Impulse on the first end by the velocity of the second one against it: (h² k + h d) n nᵀ + h² g (1 − n nᵀ) [kg].
pub fn block(apart: V, spring: &Spring, h: f64) -> M3 {
    let (n, _, g) = geometry(apart, spring);
    let stiff = h * h * spring.2 + h * spring.3;
    plus(unit(h * h * g), along(n).map(|row| scale(row, stiff - h * h * g)))
}

/// Force on the first end [N]; its rate is what the second one does against it [m/s].
pub fn pull(apart: V, rate: V, spring: &Spring) -> V {
    let (n, length, _) = geometry(apart, spring);
    scale(n, spring.2 * (length - spring.4) + spring.3 * dot(n, rate))
}

/// A symmetric definite matrix of blocks: for each row those from its first one that is not zero up to the diagonal.
pub struct Blocks(Vec<Vec<M3>>);

impl Blocks {
    /// The matrix with these blocks on its diagonal.
    pub fn diagonal(of: impl IntoIterator<Item = M3>) -> Self {
        Self(of.into_iter().map(|block| vec![block]).collect())
    }

    /// Adds to the block of a node and another one: (B u)_i += b u_j, and (B u)_j += bᵀ u_i.
    fn insert(&mut self, i: usize, j: usize, b: M3) {
        let (row, column, b) = if i < j { (j, i, transposed(b)) } else { (i, j, b) };
        let back = row - column;
        let entries = &mut self.0[row];
        while entries.len() <= back {
            entries.insert(0, ZERO);
        }
        let place = entries.len() - 1 - back;
        entries[place] = plus(entries[place], b);
    }

    /// Adds what an edge resists: ±b (u_j − u_i).
    pub fn edge(&mut self, i: usize, j: usize, b: M3) {
        self.insert(i, i, b);
        self.insert(j, j, b);
        self.insert(i, j, b.map(|row| scale(row, -1.0)));
    }

    /// Adds what a mode resists: c g gᵀ, where g has a direction for each of some nodes.
    fn mode<const N: usize>(&mut self, nodes: [usize; N], g: [V; N], c: f64) {
        for i in 0..N {
            for j in 0..=i {
                self.insert(nodes[i], nodes[j], g[i].map(|s| scale(g[j], c * s)));
            }
        }
    }

    pub fn apply(&self, u: &[V]) -> Vec<V> {
        let mut out = vec![[0.0; 3]; u.len()];
        for (i, row) in self.0.iter().enumerate() {
            let first = i + 1 - row.len();
            for (j, &b) in (first..).zip(row) {
                out[i] = add(out[i], times(b, u[j]));
                if i != j {
                    out[j] = add(out[j], times(transposed(b), u[i]));
                }
            }
        }
        out
    }

    /// The same where nodes move as their `yields` let them, and what is left of each is its own mass.
    fn filtered(&self, yields: &[M3], mass: &[f64]) -> Vec<Vec<f64>> {
        let mut rows = Vec::new();
        for (i, row) in self.0.iter().enumerate() {
            let first = i + 1 - row.len();
            let mut blocks: Vec<M3> =
                (first..).zip(row).map(|(j, &b)| chained(chained(yields[i], b), yields[j])).collect();
            let held = plus(unit(mass[i]), yields[i].map(|row| scale(row, -mass[i])));
            let last = blocks.len() - 1;
            blocks[last] = plus(blocks[last], held);
            for axis in 0..3 {
                let all = blocks.iter().flat_map(|b| b[axis]);
                rows.push(all.take(3 * (i - first) + axis + 1).collect());
            }
        }
        rows
    }

    /// The solution where nodes move as their `yields` let them, by Cholesky's factors and one correction.
    pub fn solve(&self, right: &[V], yields: &[M3], mass: &[f64]) -> Vec<V> {
        let right: Vec<V> = right.iter().zip(yields).map(|(&b, &y)| times(y, b)).collect();
        let factor = factors(self.filtered(yields, mass));
        let left = |x: &[V]| -> Vec<V> {
            let rest = right.iter().zip(self.apply(x));
            rest.zip(yields).map(|((&b, ax), &y)| times(y, sub(b, ax))).collect()
        };
        let x = substitute(&factor, &right);
        let x: Vec<V> = x.iter().zip(substitute(&factor, &left(&x))).map(|(&x, by)| add(x, by)).collect();
        let size = |r: &[V]| r.iter().map(|&r| dot(r, r)).sum::<f64>().sqrt();
        let (rest, all) = (size(&left(&x)), size(&right));
        assert!(rest <= 1e-10 * all, "{rest:e} of {all:e} is left");
        x
    }
}

/// Rows of Cholesky's factor, as long as those of the matrix: each from its first entry up to the diagonal.
fn factors(mut rows: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
    for i in 0..rows.len() {
        let (done, rest) = rows.split_at_mut(i);
        let row = &mut rest[0];
        let first = i + 1 - row.len();
        for j in first..i {
            let start = j + 1 - done[j].len();
            let from = first.max(start);
            let known = product(&row[from - first..j - first], &done[j][from - start..j - start]);
            row[j - first] = (row[j - first] - known) / done[j][j - start];
        }
        let (before, diagonal) = row.split_at_mut(i - first);
        let left = diagonal[0] - product(before, before);
        assert!(left > 1e-14 * diagonal[0], "row {i} depends on those before it");
        diagonal[0] = left.sqrt();
    }
    rows
}

/// Forwards and backwards through the factors.
fn substitute(factor: &[Vec<f64>], right: &[V]) -> Vec<V> {
    let mut x = right.as_flattened().to_vec();
    for (i, row) in factor.iter().enumerate() {
        let (known, diagonal) = row.split_at(row.len() - 1);
        x[i] = (x[i] - product(known, &x[i - known.len()..i])) / diagonal[0];
    }
    for (i, row) in factor.iter().enumerate().rev() {
        x[i] /= row[row.len() - 1];
        let first = i + 1 - row.len();
        (first..i).for_each(|j| x[j] -= row[j - first] * x[i]);
    }
    x.as_chunks().0.to_vec()
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}

/// How nodes move in a sub-step.
pub struct Motion {
    /// Velocities [m/s], and what springs would change of them on nodes that surfaces hold as well.
    pub v: Vec<V>,
    pub changes: Vec<V>,
}

/// The system of one Newton step: masses and blocks, and the impulses of springs and hinges [kg·m/s].
pub struct System {
    pub matrix: Blocks,
    pub impulses: Vec<V>,
}

impl System {
    /// What is left to do for springs and inertia where nodes have velocities `u`, and would have `free` without springs.
    pub fn right(&self, u: &[V], free: &[V], mass: &[f64]) -> Vec<V> {
        let lag = |n: usize| scale(sub(free[n], u[n]), mass[n]);
        (0..u.len()).map(|n| add(self.impulses[n], lag(n))).collect()
    }
}

impl Reference {
    /// Linearised where velocities `u` take nodes in `h` [s].
    pub fn linearised(&self, u: &[V], h: f64) -> System {
        let x: Vec<V> = self.x.iter().zip(u).map(|(&x, &u)| add(x, scale(u, h))).collect();
        self.linearised_at(&x, u, h, &self.mass)
    }

    /// Linearised at places `x` that change by `h` times velocities `u`, of nodes with a `mass` each.
    pub fn linearised_at(&self, x: &[V], u: &[V], h: f64, mass: &[f64]) -> System {
        let mut matrix = Blocks::diagonal(mass.iter().map(|&m| unit(m)));
        let mut impulses = vec![[0.0; 3]; u.len()];
        for spring in self.springs.iter().filter(|spring| spring.2 + spring.3 > 0.0) {
            let (a, b) = (spring.0, spring.1);
            let apart = sub(x[b], x[a]);
            matrix.edge(a, b, block(apart, spring, h));
            let impulse = scale(pull(apart, sub(u[b], u[a]), spring), h);
            (impulses[a], impulses[b]) = (add(impulses[a], impulse), sub(impulses[b], impulse));
        }
        for &Fold(nodes, k, d, rest) in &self.folds {
            let at = nodes.map(|n| x[n]);
            let g = angle_gradient(at);
            let rate: f64 = (0..4).map(|c| dot(g[c], u[nodes[c]])).sum();
            let moment = k * (angle(at) - rest) + d * rate;
            matrix.mode(nodes, g, h * h * k + h * d);
            for c in 0..4 {
                impulses[nodes[c]] = sub(impulses[nodes[c]], scale(g[c], h * moment));
            }
        }
        System { matrix, impulses }
    }

    /// Solves for the velocities at the end of a step of `h` [s]. `free` are those without springs [m/s]; `yields` projects
    /// onto the directions in which nodes yield, in others they have velocities `held`.
    pub fn backward(&self, free: &[V], held: &[V], yields: &[M3], h: f64) -> Motion {
        let mut u = self.before(held, yields);
        let mut changes = vec![[0.0; 3]; u.len()];
        for _ in 0..self.solver.ice.newton_steps {
            let system = self.linearised(&u, h);
            let change = system.matrix.solve(&system.right(&u, free, &self.mass), yields, &self.mass);
            for (n, resisted) in system.matrix.apply(&change).into_iter().enumerate() {
                // What springs push, less what the matrix has beside masses.
                let pushed = sub(system.impulses[n], sub(resisted, scale(change[n], self.mass[n])));
                changes[n] = scale(pushed, self.inverse_mass(n));
                u[n] = add(u[n], change[n]);
            }
        }
        Motion { v: u, changes }
    }

    /// From where the first Newton step starts: velocities before, and where nodes do not yield, those that they have.
    fn before(&self, held: &[V], yields: &[M3]) -> Vec<V> {
        let start = |n: usize| add(held[n], times(yields[n], sub(self.v[n], held[n])));
        (0..held.len()).map(start).collect()
    }

    /// Adds to forces what springs do in a step of backward Euler. A node that a surface holds is taken to land on it, and
    /// to be moved along it alone, or not at all.
    pub fn constrain_by_nodes(&mut self, f: &mut [V], h: f64) {
        let free = self.free_velocities(f, h);
        self.changes.resize(free.len(), [0.0; 3]);
        let predicted = |n: usize| self.predict_contact(n, [free[n], add(free[n], self.changes[n])], h);
        let predicted: Vec<Option<PredictedContact>> = (0..free.len()).map(predicted).collect();
        let held = |n: usize| predicted[n].as_ref().map_or(free[n], |predicted| predicted.held(free[n]));
        let yields = |n: usize| match &predicted[n] {
            _ if self.held.contains(&n) => ZERO,
            Some(predicted) if predicted.sticks => ZERO,
            Some(predicted) => plus(unit(1.0), along(predicted.normal).map(|row| scale(row, -1.0))),
            None => unit(1.0),
        };
        let held: Vec<V> = (0..free.len()).map(held).collect();
        let yields: Vec<M3> = (0..free.len()).map(yields).collect();
        let friction_change = |n: usize| {
            predicted[n].as_ref().map_or(free[n], |predicted| add(free[n], predicted.friction_change))
        };
        let friction_change: Vec<V> = (0..free.len()).map(friction_change).collect();
        let changes = self.backward(&friction_change, &held, &yields, h).changes;
        for (n, &change) in changes.iter().enumerate().filter(|(n, _)| !self.held.contains(n)) {
            let pulled = add(free[n], change);
            let after = predicted[n]
                .as_ref()
                .map_or(pulled, |predicted| Self::velocity_after(free[n], pulled, predicted));
            f[n] = add(f[n], scale(sub(after, free[n]), self.mass[n] / h));
        }
        self.changes = changes;
    }

    /// The error that is left of the first Newton step's system where velocities have become `v`, in the norm of the
    /// system, √(eᵀ A e): relative to the larger of that before and √(Σ m |v* − v|²).
    pub fn error(&self, free: &[V], v: &[V], h: f64) -> f64 {
        let yields: Vec<M3> =
            (0..v.len()).map(|n| if self.held.contains(&n) { ZERO } else { unit(1.0) }).collect();
        let u = self.before(free, &yields);
        let system = self.linearised(&u, h);
        let change: Vec<V> = v.iter().zip(&u).map(|(&v, &u)| sub(v, u)).collect();
        let exact = system.matrix.solve(&system.right(&u, free, &self.mass), &yields, &self.mass);
        let size = |e: &[V]| -> f64 { e.iter().zip(system.matrix.apply(e)).map(|(&e, ae)| dot(e, ae)).sum() };
        let off: Vec<V> = exact.iter().zip(&change).map(|(&a, &b)| sub(a, b)).collect();
        let outer: f64 =
            (0..u.len()).map(|n| self.mass[n] * dot(sub(free[n], u[n]), sub(free[n], u[n]))).sum();
        (size(&off) / outer.max(size(&exact))).sqrt()
    }
}
