//! The mode that sets the largest step.
//!
//! A state u has a largest step of its own, at which h²κ + 2hδ comes to the room; the worst mode is the state whose step is
//! least. It is found by a locally optimal search: from u, from what it leaves unbalanced, and from the last change, the
//! combination with the largest h²κ + 2hδ at the step of u. Each round makes the step shorter, and multiplies by the matrices once.
//!
//! Source: Knyazev, "Toward the optimal preconditioned eigensolver: locally optimal block preconditioned conjugate gradient
//! method", SIAM J. Sci. Comput. 23, 2001, with a block of one, without preconditioner, and with a step that changes on the way.

use super::{System, step_within};
use crate::real::{add, dot, eigen, scale, sub};
use crate::topology::random::SplitMix64;
use std::array;

/// Element visits that a search may take; with millions of springs fewer rounds must do.
const ENOUGH: usize = 60_000_000;

/// Rounds at least and at most.
const LEAST_ROUNDS: usize = 20;
const MOST_ROUNDS: usize = 200;

/// A state is a mode where it leaves no more unbalanced than this part of what resists, in so many rounds after each other: a better
/// mode of which it has but little takes over in a few rounds.
const BALANCED: f64 = 5e-3;
const ENOUGH_BALANCED: usize = 8;

/// What is left unbalanced is rounding.
const EXACT: f64 = 1e-9;

/// What part of a direction must be new for it to count.
const NEW: f64 = 1e-10;

/// The direction in which a spring resists.
#[derive(Clone, Copy, PartialEq)]
pub enum Pull {
    /// Along itself.
    Along,
    /// Any: the bound for all states.
    AnyWay,
}

/// What is looked for.
#[derive(Clone, Copy)]
pub enum Goal {
    /// The least step at which h²κ + 2hδ comes to so much.
    Step(f64),
    /// The largest h²κ + 2hδ of a step [s].
    Rate(f64),
}

/// The worst mode by unit masses, with κ = uᵀKu and δ = uᵀDu.
pub struct Mode {
    pub kappa: f64,
    pub delta: f64,
    pub u: Vec<[f64; 3]>,
}

/// Of each node its part of a state u, of K u and of D u.
type State = Vec<[f64; 9]>;

/// By two of three states.
type Matrix = [[f64; 3]; 3];

impl System {
    /// The worst mode, from a state without any order.
    pub fn worst(&self, pull: Pull, goal: Goal) -> Mode {
        let mut random = SplitMix64::new(1);
        let any = |w: &f64| [(); 3].map(|()| if *w > 0.0 { random.unit() - 0.5 } else { 0.0 });
        let mut x = self.multiplied(self.root_inverse_mass.iter().map(any), pull);
        if scale_to_unit(&mut x) {
            self.improve(&mut x, pull, goal);
        }
        let [kappa, delta] = rates(&x);
        Mode { kappa, delta, u: x.iter().map(|&[x, y, z, ..]| [x, y, z]).collect() }
    }

    fn improve(&self, x: &mut State, pull: Pull, goal: Goal) {
        let mut last: Option<State> = None;
        let mut balanced = 0;
        for _ in 0..(ENOUGH / (1 + self.len())).clamp(LEAST_ROUNDS, MOST_ROUNDS) {
            let h = goal.step(rates(x));
            let (left, size) = unbalanced(x, h);
            balanced = if size > BALANCED { 0 } else { balanced + 1 };
            if balanced == ENOUGH_BALANCED || size.is_nan() || size <= EXACT {
                break;
            }
            let mut r = self.multiplied(left.into_iter(), pull);
            scale_to_unit(&mut r);
            let best = best_of(&products([Some(x), Some(&r), last.as_ref()], h));
            let mut change = last.take().unwrap_or_else(|| vec![[0.0; 9]; x.len()]);
            for ((x, r), change) in x.iter_mut().zip(&r).zip(&mut change) {
                for i in 0..9 {
                    change[i] = best[1] * r[i] + best[2] * change[i];
                    x[i] = best[0] * x[i] + change[i];
                }
            }
            scale_to_unit(x);
            last = scale_to_unit(&mut change).then_some(change);
        }
    }
}

impl Goal {
    /// The step [s] at which a state with these rates is looked at.
    fn step(self, [kappa, delta]: [f64; 2]) -> f64 {
        match self {
            Self::Step(room) => step_within(room, [kappa, delta]),
            Self::Rate(h) => h,
        }
    }
}

/// κ and δ.
pub fn rates(x: &State) -> [f64; 2] {
    x.iter().fold([0.0; 2], |[kappa, delta], [x, y, z, u, v, w, a, b, c]| {
        [kappa + (x * u + y * v + z * w), delta + (x * a + y * b + z * c)]
    })
}

/// (h²K + 2hD) u of a node.
fn resisted(&[_, _, _, u, v, w, a, b, c]: &[f64; 9], h: f64) -> [f64; 3] {
    add(scale([u, v, w], h * h), scale([a, b, c], 2.0 * h))
}

/// What is not balanced by inertia at a step, and how large it is as a part of what resists.
fn unbalanced(x: &State, h: f64) -> (Vec<[f64; 3]>, f64) {
    let at = |node: &[f64; 9]| [node[0], node[1], node[2]];
    let value: f64 = x.iter().map(|node| dot(at(node), resisted(node, h))).sum();
    let left: Vec<[f64; 3]> = x.iter().map(|node| sub(resisted(node, h), scale(at(node), value))).collect();
    let size = left.iter().map(|&one| dot(one, one)).sum::<f64>().sqrt();
    (left, size / value)
}

/// Scales a state to length 1, if it has any.
fn scale_to_unit(x: &mut State) -> bool {
    let length = x.iter().map(|&[x, y, z, ..]| dot([x, y, z], [x, y, z])).sum::<f64>().sqrt();
    if length > 0.0 {
        x.iter_mut().flatten().for_each(|number| *number *= 1.0 / length);
    }
    length > 0.0
}

/// Of some states their products with each other, and with (h²K + 2hD) between.
fn products(states: [Option<&State>; 3], h: f64) -> [Matrix; 2] {
    let mut all = [Matrix::default(); 2];
    for (i, a) in states.iter().enumerate() {
        for (j, b) in states.iter().enumerate().take(i + 1) {
            if let (Some(a), Some(b)) = (a, b) {
                let [inner, resists] = inner_products(a, b, h);
                (all[0][i][j], all[0][j][i]) = (inner, inner);
                (all[1][i][j], all[1][j][i]) = (resists, resists);
            }
        }
    }
    all
}

/// a·b and a·(h²K + 2hD) b.
fn inner_products(a: &State, b: &State, h: f64) -> [f64; 2] {
    let mut sums = [[0.0; 3]; 3];
    for (a, b) in a.iter().zip(b) {
        for axis in 0..3 {
            for (part, sum) in sums.iter_mut().enumerate() {
                sum[axis] += a[axis] * b[3 * part + axis];
            }
        }
    }
    let [inner, by_k, by_d] = sums.map(|[x, y, z]| x + y + z);
    [inner, h * h * by_k + 2.0 * h * by_d]
}

/// What to take of each state for the largest h²κ + 2hδ.
fn best_of([inner, resisted]: &[Matrix; 2]) -> [f64; 3] {
    // Combinations of length 1 that are orthogonal, or nothing.
    let mut bases = Matrix::default();
    for i in 0..3 {
        let mut basis: [f64; 3] = array::from_fn(|k| if k == i { 1.0 } else { 0.0 });
        for before in &bases[..i] {
            basis = sub(basis, scale(*before, form(inner, *before, basis)));
        }
        let squared = form(inner, basis, basis);
        if squared > NEW * inner[i][i] {
            bases[i] = scale(basis, 1.0 / squared.sqrt());
        }
    }
    let projected = bases.map(|a| bases.map(|b| form(resisted, a, b)));
    let (values, vectors) = eigen(projected);
    let best = (0..3).fold(0, |best, i| if values[i] > values[best] { i } else { best });
    (0..3).fold([0.0; 3], |sum, i| add(sum, scale(bases[i], vectors[best][i])))
}

/// a·M b.
fn form(m: &Matrix, a: [f64; 3], b: [f64; 3]) -> f64 {
    dot(a, m.map(|row| dot(row, b)))
}
