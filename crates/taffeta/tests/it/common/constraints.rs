//! Springs that are solved at once: every row of the system from a list of springs, the matrix assembled in compressed
//! rows and factorised, in 64 bits.

use super::reference::{Obstacle, Reference, Spring};
use super::{V, add, dot, norm, scale, sub};
use std::collections::BTreeMap;
use taffeta::scene::{ConstraintForm, Method};

/// One constraint between two nodes.
pub struct Row {
    pub spring: usize,
    pub ends: [usize; 2],
    /// Derivative by the place of the second end; that by the first is the opposite.
    pub slope: V,
    /// What stands on the diagonal beside inverse masses.
    pub compliance: f64,
    /// What stands on the right beside velocities.
    pub wanted: f64,
}

/// How a node follows a force: its inverse mass [1/kg], and the unit normal of a surface along which it does not;
/// zero: none.
pub struct Mobility {
    pub inverse_mass: f64,
    pub normal: V,
}

impl Mobility {
    /// What a force along `b` does along `a`.
    fn along(&self, a: V, b: V) -> f64 {
        self.inverse_mass * (dot(a, b) - dot(a, self.normal) * dot(b, self.normal))
    }
}

/// A surface that holds a node: its outward normal, its own velocity and the one that takes the node onto it [m/s], and
/// whether the node sticks to it, else it slides, and the change of velocity by friction.
pub struct PredictedContact {
    pub normal: V,
    pub own: V,
    pub landing: f64,
    pub sticks: bool,
    pub friction_change: V,
    pub friction: f64,
    pub restitution: f64,
}

impl PredictedContact {
    /// The velocity of a node that would have `v` without the surface.
    pub fn held(&self, v: V) -> V {
        let along = across(if self.sticks { self.own } else { v }, self.normal);
        add(add(along, self.friction_change), scale(self.normal, self.landing))
    }
}

/// A symmetric matrix in compressed rows, all entries stored.
pub struct Csr {
    starts: Vec<usize>,
    columns: Vec<usize>,
    values: Vec<f64>,
}

impl Csr {
    /// J W Jᵀ + D.
    pub fn assemble(rows: &[Row], nodes: &[Mobility]) -> Self {
        let mut around = vec![Vec::new(); nodes.len()];
        for (index, row) in rows.iter().enumerate() {
            around[row.ends[0]].push((index, -1.0));
            around[row.ends[1]].push((index, 1.0));
        }
        let mut matrix = Self { starts: vec![0], columns: vec![], values: vec![] };
        for (index, row) in rows.iter().enumerate() {
            let mut entries = BTreeMap::from([(index, row.compliance)]);
            for (end, sign) in row.ends.into_iter().zip([-1.0, 1.0]) {
                for &(other, side) in &around[end] {
                    let share = sign * side * nodes[end].along(row.slope, rows[other].slope);
                    *entries.entry(other).or_default() += share;
                }
            }
            matrix.columns.extend(entries.keys());
            matrix.values.extend(entries.values());
            matrix.starts.push(matrix.columns.len());
        }
        matrix
    }

    fn row(&self, index: usize) -> impl Iterator<Item = (usize, f64)> {
        let range = self.starts[index]..self.starts[index + 1];
        self.columns[range.clone()].iter().copied().zip(self.values[range].iter().copied())
    }

    pub fn times(&self, x: &[f64]) -> Vec<f64> {
        (0..x.len()).map(|i| self.row(i).map(|(j, value)| value * x[j]).sum()).collect()
    }

    /// Rows of the Cholesky factor, each from its first entry up to the diagonal: no entry is outside of that envelope.
    fn factor(&self) -> Vec<(usize, Vec<f64>)> {
        let mut factor: Vec<(usize, Vec<f64>)> = Vec::new();
        for i in 0..self.starts.len() - 1 {
            let first = self.columns[self.starts[i]];
            let mut row = vec![0.0; i + 1 - first];
            self.row(i).filter(|&(j, _)| j <= i).for_each(|(j, value)| row[j - first] = value);
            let diagonal = row[i - first];
            for j in first..i {
                let (start, above) = &factor[j];
                let from = first.max(*start);
                let known = product(&row[from - first..j - first], &above[from - start..j - start]);
                row[j - first] = (row[j - first] - known) / above[j - start];
            }
            let left = diagonal - product(&row[..i - first], &row[..i - first]);
            assert!(left > 1e-13 * diagonal, "row {i} depends on those before it");
            row[i - first] = left.sqrt();
            factor.push((first, row));
        }
        factor
    }

    /// The solution for a right side, by factors and one correction.
    pub fn solve(&self, right: &[f64]) -> Vec<f64> {
        let factor = self.factor();
        let substitute = |right: Vec<f64>| {
            let mut x = right;
            for (i, (first, row)) in factor.iter().enumerate() {
                let (known, diagonal) = row.split_at(i - first);
                x[i] = (x[i] - product(known, &x[*first..i])) / diagonal[0];
            }
            for (i, (first, row)) in factor.iter().enumerate().rev() {
                x[i] /= row[i - first];
                (*first..i).for_each(|j| x[j] -= row[j - first] * x[i]);
            }
            x
        };
        let rest = |x: &[f64]| right.iter().zip(self.times(x)).map(|(b, ax)| b - ax).collect::<Vec<_>>();
        let mut x = substitute(right.to_vec());
        let correction = substitute(rest(&x));
        x.iter_mut().zip(correction).for_each(|(x, by)| *x += by);
        let [left, all] = [&rest(&x), right].map(|r| product(r, r).sqrt());
        assert!(left <= 1e-10 * all, "{left:e} of {all:e} is left");
        x
    }
}

/// The part of a vector across a unit vector.
fn across(v: V, normal: V) -> V {
    sub(v, scale(normal, dot(v, normal)))
}

fn product(a: &[f64], b: &[f64]) -> f64 {
    let (a, b) = (a.as_chunks::<4>(), b.as_chunks::<4>());
    let mut sums = [0.0; 4];
    for (a, b) in a.0.iter().zip(b.0) {
        (0..4).for_each(|lane| sums[lane] += a[lane] * b[lane]);
    }
    sums.iter().sum::<f64>() + a.1.iter().zip(b.1).map(|(a, b)| a * b).sum::<f64>()
}

impl Reference {
    /// Whether a spring is a constraint in this step, and not a force.
    pub fn is_constraint(&self, spring: usize) -> bool {
        match self.solver.method {
            Method::Ice => true,
            Method::Acad => self.active.contains(&spring),
            _ => false,
        }
    }

    /// Finds the springs that are constraints from now on: those that are too long, and those that were too long and
    /// still are longer than what releases them.
    pub fn activate(&mut self) {
        let acad = &self.solver.acad;
        let strain = |s: &Spring| norm(sub(self.x[s.1], self.x[s.0])) / s.4 - 1.0;
        let strains = self.springs.iter().map(strain).enumerate();
        let stays = |spring: usize, strain: f64| self.active.contains(&spring) && strain > acad.release;
        self.active =
            strains.filter(|&(i, e)| e > acad.threshold || stays(i, e)).map(|(spring, _)| spring).collect();
    }

    /// Constraints with an end that is free, sorted along the mesh.
    pub fn rows(&self, h: f64) -> Vec<Row> {
        let springs = (0..self.springs.len()).filter(|&spring| self.is_constraint(spring));
        let mut rows: Vec<Row> = springs.filter_map(|spring| self.row(spring, h)).collect();
        rows.sort_by_key(|row| row.ends[0] + row.ends[1]);
        rows
    }

    fn row(&self, spring: usize, h: f64) -> Option<Row> {
        let Spring(a, b, k, d, rest) = self.springs[spring];
        let apart = sub(self.x[b], self.x[a]);
        let (length, both) = (norm(apart), self.inverse_mass(a) + self.inverse_mass(b));
        let (form, epsilon, rest) = match self.solver.method {
            Method::Acad => {
                let acad = &self.solver.acad;
                (acad.form, acad.epsilon, (1.0 + acad.target) * rest)
            }
            _ => (self.solver.ice.form, self.solver.ice.epsilon, rest),
        };
        let (slope, compliance, wanted) = match (form, self.solver.method) {
            (ConstraintForm::Printed, _) => {
                (scale(apart, 2.0), 0.0, (length * length - rest * rest) / (h * h))
            }
            (ConstraintForm::Compliant, Method::Acad) => {
                (scale(apart, 1.0 / length), epsilon * both, (length - rest) / (h * h))
            }
            (ConstraintForm::Compliant, _) if k + d == 0.0 => return None,
            (ConstraintForm::Compliant, _) => {
                let resists = h * (h * k + d);
                (scale(apart, 1.0 / length), 1.0 / resists + epsilon * both, k * (length - rest) / resists)
            }
            (form, _) => unreachable!("the form {} has no rows", form.name()),
        };
        (both > 0.0).then_some(Row { spring, ends: [a, b], slope, compliance, wanted })
    }

    /// Velocities that forces alone would give, and those of pins [m/s].
    pub fn free_velocities(&self, f: &[V], h: f64) -> Vec<V> {
        let mut v = self.v.clone();
        for n in (0..v.len()).filter(|n| !self.held.contains(n)) {
            v[n] = add(v[n], scale(add(scale(f[n], self.inverse_mass(n)), self.gravity), h));
        }
        for &(n, start, path) in &self.pins {
            let [from, to] = [self.time, self.time + h].map(|t| path.apply(start, t));
            v[n] = scale(sub(to, from), 1.0 / h);
        }
        v
    }

    /// The surface that a node gets deepest into with the pulls of the last step, if it comes there without them, or
    /// lies there. `free` and `v` are without and with them. Normals are those at the place of now.
    pub fn predict_contact(&self, node: usize, [free, v]: [V; 2], h: f64) -> Option<PredictedContact> {
        let (x, then) = (self.x[node], self.time + h);
        let inside = |o: &Obstacle| o.depth(add(x, scale(v, h)), then).0;
        let comes = |o: &Obstacle| {
            let (depth, normal) = o.depth(x, then);
            -depth <= (-h * dot(free, normal)).max(0.0) + h * h * norm(self.gravity)
        };
        let implicit = self.solver.method == Method::Ice && !self.held.contains(&node);
        let all = self.obstacles.iter().filter(|o| implicit && inside(o) > 0.0 && comes(o));
        let obstacle = all.max_by(|a, b| inside(a).total_cmp(&inside(b)))?;
        let ((depth, normal), own) = (obstacle.depth(x, then), obstacle.velocity(x, self.time, h));
        let (landing, friction) = ((depth / h).min(dot(own, normal)), obstacle.friction);
        let (slip, most) = (across(sub(v, own), normal), friction * (landing - dot(v, normal)).max(0.0));
        let sticks = norm(slip) <= 0.95 * most && most > 0.0;
        let friction_change = scale(slip, if sticks || most == 0.0 { 0.0 } else { -most / norm(slip) });
        Some(PredictedContact {
            normal,
            own,
            landing,
            sticks,
            friction_change,
            friction,
            restitution: obstacle.restitution,
        })
    }

    /// Velocity of a node after pulls, of which a surface bears what they press, and rubs: until the node stops, and less what
    /// contact rubs later.
    pub fn velocity_after(free: V, pulled: V, predicted: &PredictedContact) -> V {
        let [before, after] = [free, pulled].map(|v| dot(v, predicted.normal));
        let least = before.min(predicted.landing);
        let kept = if predicted.restitution > 0.0 {
            after.clamp(least, predicted.landing)
        } else {
            predicted.landing - (predicted.landing - least) / 16.0
        };
        if predicted.sticks {
            return add(across(predicted.own, predicted.normal), scale(predicted.normal, kept));
        }
        let held = add(pulled, scale(predicted.normal, kept - after));
        let most = norm(predicted.friction_change);
        if most == 0.0 {
            return held;
        }
        let forward = scale(predicted.friction_change, -1.0 / most);
        let stopped = dot(sub(held, predicted.own), forward).clamp(0.0, most);
        let later = (predicted.friction * (predicted.landing - kept)).min(stopped);
        sub(held, scale(forward, stopped - later))
    }

    /// Velocities after pulls [m/s].
    fn pulled(&self, free: &[V], rows: &[Row], pulls: &[f64], h: f64) -> Vec<V> {
        let mut v = free.to_vec();
        for (row, &pull) in rows.iter().zip(pulls) {
            for (end, sign) in row.ends.into_iter().zip([1.0, -1.0]) {
                v[end] = add(v[end], scale(row.slope, sign * h * pull * self.inverse_mass(end)));
            }
        }
        v
    }

    /// Adds the pulls of constraints to forces: (J W Jᵀ + D) λ = c + J v*/h. A node that a surface holds is taken to
    /// land on it, and to be moved along it alone, or not at all.
    pub fn constrain(&mut self, f: &mut [V], h: f64) {
        if self.solver.is_second_order() {
            return self.constrain_at_second_order(f, h);
        }
        if self.solver.method == Method::Ice && self.solver.ice.form == ConstraintForm::Primal {
            return self.constrain_by_nodes(f, h);
        }
        let (rows, free) = (self.rows(h), self.free_velocities(f, h));
        self.multipliers.resize(self.springs.len(), 0.0);
        let before: Vec<f64> =
            rows.iter().map(|row| self.multipliers[row.spring] / norm(row.slope)).collect();
        let guess = self.pulled(&free, &rows, &before, h);
        let predicted: Vec<Option<PredictedContact>> =
            (0..free.len()).map(|n| self.predict_contact(n, [free[n], guess[n]], h)).collect();
        let (mut v, mut nodes) = (free.clone(), Vec::new());
        for (n, predicted) in predicted.iter().enumerate() {
            let mut mobility = Mobility { inverse_mass: self.inverse_mass(n), normal: [0.0; 3] };
            if let Some(predicted) = predicted {
                mobility.normal = predicted.normal;
                mobility.inverse_mass *= if predicted.sticks { 0.0 } else { 1.0 };
                v[n] = predicted.held(v[n]);
            }
            nodes.push(mobility);
        }
        let rate = |row: &Row| dot(row.slope, sub(v[row.ends[1]], v[row.ends[0]]));
        let right: Vec<f64> = rows.iter().map(|row| row.wanted + rate(row) / h).collect();
        let pulls = Csr::assemble(&rows, &nodes).solve(&right);
        for (n, mut after) in self.pulled(&free, &rows, &pulls, h).into_iter().enumerate() {
            if let Some(predicted) = &predicted[n] {
                after = Self::velocity_after(free[n], after, predicted);
            }
            if !self.held.contains(&n) {
                f[n] = add(f[n], scale(sub(after, free[n]), self.mass[n] / h));
            }
        }
        self.multipliers.fill(0.0);
        for (row, pull) in rows.iter().zip(pulls) {
            self.multipliers[row.spring] = pull * norm(row.slope);
        }
    }
}
