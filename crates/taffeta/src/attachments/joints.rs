//! Groups of joints that share nodes. They are solved together, so that no joint opens what another one closes.
//!
//! With the gaps d of all joints, their gradients J, the inverse masses W, and the compliances D divided by the
//! square of the sub-step, their shifts f solve (J W Jᵀ + D) f = −d. A joint of length 0 has three rows, any other
//! one row along the line between its ends. Joints that still close pull only: three nodes whose seams close at different times
//! would be to form a triangle that there is not, such as one with sides of 0, 1 and 2 cm, and rows that all but contradict each
//! other would throw them far. Pinned nodes may make rows contradict each other, too. So the system is solved
//! by conjugate residuals (Stiefel, "Relaxationsmethoden bester Strategie zur Lösung linearer Gleichungssysteme",
//! Comment. Math. Helv. 29, 1955), which minimise the residual, and converge in as many iterations as there are rows.

use crate::attachments::attach::JointCorrection;
use crate::real::{Real, add, dot, scale, sub};

/// A joint of a group.
#[derive(Clone, Copy, Debug)]
pub struct GroupJoint<T> {
    /// Numbers of its nodes; a point, or a pinned node, has none.
    nodes: [Option<usize>; 2],
    /// Inverse masses of them [1/kg].
    inverse_mass: [T; 2],
    /// Unit vector along which its ends move, or zero if they move in all directions.
    along: [T; 3],
    /// Compliance divided by the square of the sub-step [1/kg].
    softness: T,
    /// Change of position of its first end times mass [kg·m].
    shift: [T; 3],
    /// The residual r [m] and the search direction p [kg·m], and their products with the matrix, A r and A p.
    residual: [T; 3],
    direction: [T; 3],
    a_residual: [T; 3],
    a_direction: [T; 3],
}

/// A field of the joints.
type Field<T> = fn(&mut GroupJoint<T>) -> &mut [T; 3];

/// Most iterations of a group.
pub const ROUNDS: usize = 64;

impl<T: Real> GroupJoint<T> {
    /// A joint of two nodes that are `d` [m] apart, first less second, and should be `length` [m], on its way to `end`. `None`
    /// if both ends are pinned, if it has no direction, or if its ends are nearer already while it closes.
    pub fn new(
        nodes: [usize; 2],
        inverse_mass: [T; 2],
        d: [T; 3],
        [length, end]: [T; 2],
        softness: T,
    ) -> Option<Self> {
        let distance = dot(d, d).sqrt();
        let any = length <= T::ZERO;
        let has_line = distance > T::ZERO && (distance >= length || length == end);
        if inverse_mass[0] + inverse_mass[1] <= T::ZERO || !(any || has_line) {
            return None;
        }
        let line = [d[0] / distance, d[1] / distance, d[2] / distance];
        let zero = [T::ZERO; 3];
        let node = |end: usize| (inverse_mass[end] > T::ZERO).then_some(nodes[end]);
        Some(Self {
            nodes: [node(0), node(1)],
            inverse_mass,
            along: if any { zero } else { line },
            softness,
            shift: zero,
            residual: if any { scale(d, -T::ONE) } else { scale(line, length - distance) },
            direction: zero,
            a_residual: zero,
            a_direction: zero,
        })
    }

    /// Its correction.
    pub fn correction(&self) -> JointCorrection<T> {
        JointCorrection { shift: self.shift, size: dot(self.shift, self.shift).sqrt() }
    }
}

/// Solves for the shifts of the joints of a group. `sums` has room for one vector for each node.
pub fn solve<T: Real>(joints: &mut [GroupJoint<T>], sums: &mut [[T; 3]]) {
    apply_matrix(joints, sums, |joint| &mut joint.residual, |joint| &mut joint.a_residual);
    for joint in &mut *joints {
        (joint.direction, joint.a_direction) = (joint.residual, joint.a_residual);
    }
    let mut slope = inner(joints, |joint| (joint.residual, joint.a_residual));
    let enough = slope * (T::EPSILON * T::EPSILON);
    for _ in 0..ROUNDS {
        let squared = inner(joints, |joint| (joint.a_direction, joint.a_direction));
        if slope <= enough || squared <= T::ZERO {
            break;
        }
        let alpha = slope / squared;
        for joint in &mut *joints {
            joint.shift = add(joint.shift, scale(joint.direction, alpha));
            joint.residual = sub(joint.residual, scale(joint.a_direction, alpha));
        }
        apply_matrix(joints, sums, |joint| &mut joint.residual, |joint| &mut joint.a_residual);
        let next = inner(joints, |joint| (joint.residual, joint.a_residual));
        let beta = next / slope;
        slope = next;
        for joint in &mut *joints {
            joint.direction = add(joint.residual, scale(joint.direction, beta));
            joint.a_direction = add(joint.a_residual, scale(joint.a_direction, beta));
        }
    }
}

/// Σ a·b, in the order of the joints.
fn inner<T: Real>(joints: &[GroupJoint<T>], of: impl Fn(&GroupJoint<T>) -> ([T; 3], [T; 3])) -> T {
    joints.iter().map(of).fold(T::ZERO, |sum, (a, b)| sum + dot(a, b))
}

/// (J W Jᵀ + D) times a field.
fn apply_matrix<T: Real>(joints: &mut [GroupJoint<T>], sums: &mut [[T; 3]], from: Field<T>, to: Field<T>) {
    for node in joints.iter().flat_map(|joint| joint.nodes).flatten() {
        sums[node] = [T::ZERO; 3];
    }
    for joint in &mut *joints {
        let (given, [a, b]) = (*from(joint), joint.nodes);
        a.into_iter().for_each(|a| sums[a] = add(sums[a], given));
        b.into_iter().for_each(|b| sums[b] = sub(sums[b], given));
    }
    for joint in &mut *joints {
        let moved = |end: usize| {
            joint.nodes[end].map_or([T::ZERO; 3], |node| scale(sums[node], joint.inverse_mass[end]))
        };
        let both = sub(moved(0), moved(1));
        let line = joint.along;
        let kept = if dot(line, line) > T::ZERO { scale(line, dot(line, both)) } else { both };
        *to(joint) = add(kept, scale(*from(joint), joint.softness));
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::real::norm;

    /// Positions of nodes with inverse masses `w` after joints between pairs, all of one length and softness.
    fn joined(x: &[[f64; 3]], w: &[f64], pairs: &[[usize; 2]], length: f64, softness: f64) -> Vec<[f64; 3]> {
        let joint = |&[a, b]: &[usize; 2]| {
            GroupJoint::new([a, b], [w[a], w[b]], sub(x[a], x[b]), [length; 2], softness)
        };
        let mut joints: Vec<GroupJoint<f64>> = pairs.iter().filter_map(joint).collect();
        solve(&mut joints, &mut vec![[f64::NAN; 3]; x.len()]);
        let mut after = x.to_vec();
        for (joint, [a, b]) in joints.iter().zip(pairs) {
            after[*a] = add(after[*a], scale(joint.correction().shift, w[*a]));
            after[*b] = sub(after[*b], scale(joint.correction().shift, w[*b]));
        }
        after
    }

    const X: [[f64; 3]; 4] = [[0.0; 3], [0.1, 0.02, 0.0], [0.05, -0.1, 0.3], [-0.2, 0.1, 0.1]];

    #[test]
    fn what_is_joined_meets_in_its_centre_of_mass() {
        let w = [1.0, 1000.0, 0.5, 20.0];
        let mass = w.iter().map(|w| 1.0 / w).sum::<f64>();
        let centre = X.iter().zip(w).fold([0.0; 3], |sum, (&x, w)| add(sum, scale(x, 1.0 / (w * mass))));
        let chain: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 3]];
        let ring: &[[usize; 2]] = &[[0, 1], [1, 2], [2, 3], [3, 0], [0, 2], [0, 2]];
        for pairs in [chain, ring, &[[0, 1], [0, 2], [0, 3]]] {
            for x in joined(&X, &w, pairs, 0.0, 0.0) {
                assert!(norm(sub(x, centre)) < 1e-12, "{x:?} {centre:?}");
            }
        }
    }

    #[test]
    fn what_two_held_nodes_draw_at_comes_between_them_and_a_chain_to_what_is_held() {
        let between = joined(&X, &[0.0, 3.0, 0.0, 2.0], &[[0, 1], [1, 2]], 0.0, 0.0)[1];
        assert!(norm(sub(between, scale(X[2], 0.5))) < 1e-15, "{between:?}");
        let held = joined(&X, &[0.0, 3.0, 0.2, 2.0], &[[0, 1], [1, 2], [2, 3]], 0.0, 0.0);
        assert!(held.iter().all(|&x| norm(x) < 1e-15), "{held:?}");
    }

    #[test]
    fn joints_of_a_length_keep_to_their_lines() {
        let x = [[0.0; 3], [0.3, 0.0, 0.0], [0.3, 0.25, 0.0]];
        let after = joined(&x, &[1.0, 2.0, 3.0], &[[0, 1], [1, 2]], 0.2, 0.0);
        // To first order: they move each other's ends sideways.
        let [a, b] = [sub(after[0], after[1]), sub(after[1], after[2])];
        assert!((a[0].abs() - 0.2).abs() < 1e-15 && (b[1].abs() - 0.2).abs() < 1e-15, "{after:?}");
    }

    #[test]
    fn joints_that_still_close_pull_only() {
        let joint = |length, end| GroupJoint::new([0, 1], [1.0; 2], [0.3, 0.0, 0.0], [length, end], 0.0);
        assert!(joint(0.4, 0.1).is_none());
        assert!(joint(0.2, 0.1).is_some() && joint(0.4, 0.4).is_some());
    }

    #[test]
    fn soft_joints_share_a_load() {
        // Two springs in series: each opens by the difference of its ends.
        let x = [[0.0; 3], [0.0; 3], [0.0, -0.1, 0.0]];
        let after = joined(&x, &[0.0, 1e9, 1.0], &[[0, 1], [1, 2]], 0.0, 2.0);
        assert!(
            (after[2][1] + 0.1 * 4.0 / 5.0).abs() < 1e-9 && (after[1][1] + 0.04).abs() < 1e-9,
            "{after:?}"
        );
    }
}
