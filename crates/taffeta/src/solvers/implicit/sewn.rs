//! Nodes that closed seams make one point: in the system they change their velocity alike.
//!
//! With the matrix S that gives each node the velocity of its point, the system A of all nodes becomes Sᵀ A S. Its vectors
//! stay vectors of nodes: those of velocities are the same at all nodes of a point, and of a residual only the sum over a
//! point counts. The preconditioner V of all nodes becomes Sᵀ W V W S, where W shares the residual of a point among its
//! nodes, and adds up what each of them would do by the same weights, which sum up to 1: symmetric as V is.
//!
//! Source: Mandel, "Balancing domain decomposition", Communications in Numerical Methods in Engineering 9, 1993, without its
//! coarse problem: weights by stiffness.

use crate::assembly::Assembly;
use crate::attachments::constraints::{IS_POINT, JointConstraint, JointMaterial};
use crate::plan::Substep;
use crate::real::{Real, Symmetric, dot, times};
use crate::scene::Seam;
use crate::solvers::implicit::coarsening::Weighted;
use crate::solvers::implicit::implicit::inverse;
use crate::solvers::implicit::levels::Level;
use crate::topology::Csr;
use crate::topology::sets::Sets;

/// The points that seams make of nodes, once all of them are closed. Points beside seams that still close, and so act after the
/// system, would have these draw at ever larger parts of a garment.
#[derive(Clone, Debug)]
pub struct SewnPoints {
    /// The nodes of each, by solver index, ascending.
    pub nodes: Csr,
    /// Bodies that they join, two by two.
    pub links: Vec<[u32; 2]>,
}

/// Nodes so near to each other at the start [m] are sewn from then on.
const TOUCHES: f64 = 1e-6;

/// When the last seam that makes points is closed [s].
struct ClosedAt(f64);

/// Whether the nodes of points are sewn to each other in a sub-step.
struct IsSewn(bool);

impl JointMaterial {
    /// Whether it makes one point of the nodes that it joins, once it is closed.
    fn makes_points(&self) -> bool {
        self.is_tight() && self.break_force == f64::INFINITY
    }
}

impl Assembly {
    /// The joints that make points of nodes that are solved for, and when each of them is closed [s].
    fn sewing(&self) -> impl Iterator<Item = (&JointConstraint, f64)> {
        let all = self.attachments();
        let is_solved = |node: u32| self.is_solved_for(self.number_of_body(node));
        all.joints.iter().filter_map(move |joint| {
            let material = &all.materials[joint.material as usize];
            let [start, end] = material.close;
            let makes = joint.ends[1] & IS_POINT == 0 && material.makes_points();
            let at = if joint.start <= TOUCHES { 0.0 } else { end.max(start) };
            (makes && joint.ends.into_iter().all(is_solved)).then_some((joint, at))
        })
    }

    /// Notes when seams will have made points, if any do.
    pub(crate) fn note_sewing(&mut self) {
        if self.solver.is_primal()
            && let Some(at) = self.sewing().map(|one| one.1).reduce(f64::max)
        {
            self.extensions.insert(ClosedAt(at));
        }
    }

    /// When all seams that make points are closed [s].
    pub fn sewn_at(&self) -> Option<f64> {
        self.extensions.get().map(|&ClosedAt(at)| at)
    }

    /// The points that seams make.
    pub fn sewn_points(&self) -> Option<SewnPoints> {
        self.sewn_at()?;
        let mut sets = Sets::new(self.places);
        self.sewing().for_each(|(joint, _)| sets.join(joint.ends[0], joint.ends[1]));
        let nodes = points_of(&sets.all());
        let bodies = |pair: &[u32]| [pair[0], pair[1]].map(|node| self.number_of_body(node) as u32);
        let links = (0..nodes.rows()).flat_map(|point| nodes.row(point).windows(2).map(bodies));
        let mut links: Vec<[u32; 2]> = links.filter(|[a, b]| a != b).collect();
        links.sort_unstable();
        links.dedup();
        Some(SewnPoints { nodes, links })
    }

    /// Coarser levels once all seams are closed, where that makes a difference: nodes of a point follow the same coarser nodes, so
    /// that coarser levels have the bodies sewn to each other. Only levels of elements can, whose blocks are products of
    /// matrices.
    pub fn sewn_levels(&self, SewnPoints { nodes, .. }: &SewnPoints) -> Option<Vec<Level>> {
        let mut follows: Vec<u32> = (0..self.places as u32).collect();
        for point in (0..nodes.rows()).map(|point| nodes.row(point)) {
            if point.iter().all(|&node| self.has_solved_elements(self.number_of_body(node))) {
                point.iter().for_each(|&node| follows[node as usize] = point[0]);
            }
        }
        if (0..).zip(&follows).all(|(node, &follows)| node == follows) {
            return None;
        }
        let mut levels = self.levels().to_vec();
        let first = levels.first_mut()?;
        let mut parents = Weighted::default();
        follows.iter().for_each(|&node| parents.push(first.parents.row(node as usize).iter().copied()));
        first.parents = parents;
        Some(levels)
    }
}

/// Whether seams may join coarser levels of bodies, of which it is known whether elements of theirs are solved for.
pub fn sews_levels(seams: &[Seam], has_elements: impl Fn(&str) -> bool) -> bool {
    seams.iter().any(|seam| seam.makes_points() && seam.bodies().into_iter().all(&has_elements))
}

/// The sets of more than one node, by their least one.
fn points_of(least: &[u32]) -> Csr {
    let mut number = vec![u32::MAX; least.len()];
    let mut count = 0;
    for (node, &least) in least.iter().enumerate() {
        if node != least as usize && number[least as usize] == u32::MAX {
            number[least as usize] = count;
            count += 1;
        }
    }
    let entries = (0..).zip(least).map(|(node, &least)| (number[least as usize], node));
    let entries: Vec<(u32, u32)> = entries.filter(|&(point, _)| point != u32::MAX).collect();
    Csr::new(count as usize, entries.into_iter())
}

/// Whether all seams are closed when the frame of a sub-step starts. Within a frame that stays the same: a GPU has its kernels recorded
/// by frames.
pub fn parameters<T: Real>(assembly: &Assembly, substep: &mut Substep<T>) {
    if let Some(at) = assembly.sewn_at() {
        substep.extensions.insert(IsSewn(at <= substep.frame_start));
    }
}

impl<T: Real> Substep<T> {
    /// Whether the nodes of [`Assembly::sewn_points`] are sewn to each other.
    pub fn is_sewn(&self) -> bool {
        self.extensions.get().is_some_and(|&IsSewn(is_sewn)| is_sewn)
    }
}

/// A matrix by rows.
pub type Matrix<T> = [[T; 3]; 3];

/// Of two inverses of blocks the weight of the first, W = B (A + B)⁻¹, and the inverse of the blocks' sum, W A.
pub fn parallel<T: Real>(a: &Symmetric<T>, b: &Symmetric<T>) -> (Matrix<T>, Symmetric<T>) {
    if a[0] + a[1] + a[2] <= T::ZERO {
        // What nothing moves takes all; of two such the first.
        let row = |row: usize| std::array::from_fn(|axis| if axis == row { T::ONE } else { T::ZERO });
        return (std::array::from_fn(row), [T::ZERO; 6]);
    }
    let sum = inverse(&std::array::from_fn(|i| a[i] + b[i]));
    let weight = product(b, &sum);
    // A row of W times A, as A is symmetric.
    let rows = weight.map(|row| times(a, row));
    let half = |x: T, y: T| (x + y) * T::from_f64(0.5);
    let mixed = [half(rows[0][1], rows[1][0]), half(rows[0][2], rows[2][0]), half(rows[1][2], rows[2][1])];
    (weight, [rows[0][0], rows[1][1], rows[2][2], mixed[0], mixed[1], mixed[2]])
}

/// Two symmetric matrices times each other.
fn product<T: Real>(a: &Symmetric<T>, b: &Symmetric<T>) -> Matrix<T> {
    let row = |x: T, y: T, z: T| times(b, [x, y, z]);
    [row(a[0], a[3], a[4]), row(a[3], a[1], a[5]), row(a[4], a[5], a[2])]
}

/// A matrix times a vector.
pub fn matrix_times<T: Real>(m: &Matrix<T>, v: [T; 3]) -> [T; 3] {
    m.map(|row| dot(row, v))
}

/// A matrix, turned over, times a vector.
pub fn transposed_times<T: Real>(m: &Matrix<T>, v: [T; 3]) -> [T; 3] {
    [0, 1, 2].map(|axis| m[0][axis] * v[0] + m[1][axis] * v[1] + m[2][axis] * v[2])
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, ConstraintForm, Mass, Mesh, Method, Scene, Seam, SeamSide, Select};
    use crate::solvers::implicit::implicit::block;

    fn close(a: &[f64], b: &[f64]) {
        assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 1e-12), "{a:?} {b:?}");
    }

    #[test]
    fn blocks_weight_what_acts_on_both_as_their_sum_yields() {
        let [a, b] = [block([1.0, -2.0, 0.5], 0.7), block([0.3, 0.1, 2.0], 0.2)];
        let (weight, together) = parallel(&inverse(&a), &inverse(&b));
        let sum: Symmetric<f64> = std::array::from_fn(|i| a[i] + b[i]);
        close(&together, &inverse(&sum));
        // What one has of a force moves it as much as what the other has moves that.
        let r = [0.3, -0.4, 0.9];
        let first = transposed_times(&weight, r);
        let second = [0, 1, 2].map(|axis| r[axis] - first[axis]);
        let moved = times(&inverse(&sum), r);
        close(&times(&inverse(&a), first), &moved);
        close(&times(&inverse(&b), second), &moved);
    }

    #[test]
    fn what_nothing_moves_takes_all() {
        let free = block([1.0, -2.0, 0.5], 0.7);
        for (inverses, all) in [([[0.0; 6], free], 1.0), ([free, [0.0; 6]], 0.0), ([[0.0; 6]; 2], 1.0)] {
            let (weight, together) = parallel(&inverses[0], &inverses[1]);
            assert_eq!(weight, [[all, 0.0, 0.0], [0.0, all, 0.0], [0.0, 0.0, all]]);
            assert_eq!(together, [0.0; 6]);
        }
    }

    fn assembly(seams: impl IntoIterator<Item = Seam>) -> Assembly {
        Assembly::new(&seams.into_iter().fold(scene(), Scene::seam)).unwrap()
    }

    fn scene() -> Scene {
        let mut scene = Scene::new("").method(Method::Ice);
        scene.solver.ice.form = ConstraintForm::Primal;
        for name in ["a", "b", "c", "bare"] {
            let body = Body::cloth(name, Mesh::grid(4, 4, [1.0, 1.0])).with_mass(Mass::Node(0.1));
            scene = scene.body(if name == "bare" { body } else { body.structural(9.0, 0.0) });
        }
        scene
    }

    fn row(from: &str, to: &str) -> Seam {
        let side = |name: &str| SeamSide::new(name, Select::rows(0, 0));
        Seam::new(side(from), side(to))
    }

    #[test]
    fn closed_seams_make_points_of_what_is_solved_for() {
        let soft = Seam { k: Some(1.0), ..row("a", "c") };
        let tears = Seam { break_force: Some(1.0), ..row("b", "c").closing(0.0, 0.2, 0.0) };
        let long = row("a", "c").closing(0.0, 0.2, 0.1);
        for seam in [soft, tears, long, row("c", "bare")] {
            assert!(assembly([seam]).sewn_points().is_none());
        }
        let seams = [row("a", "b").closing(0.0, 0.3, 0.0), row("b", "c").closing(0.1, 0.2, 0.0)];
        let assembly = assembly(seams.into_iter().chain([row("c", "bare").closing(0.0, 0.9, 0.0)]));
        let SewnPoints { nodes, links } = assembly.sewn_points().unwrap();
        let firsts: Vec<u32> = assembly.bodies.iter().map(|body| body.first as u32).collect();
        assert_eq!((nodes.rows(), nodes.row(1)), (4, &[firsts[0] + 1, firsts[1] + 1, firsts[2] + 1][..]));
        assert_eq!(links, [[0, 1], [1, 2]]);
    }

    #[test]
    fn points_begin_when_the_last_seam_is_closed_and_at_once_where_nodes_touch() {
        // All bodies of this scene are in one place.
        let at = |seams: &[Seam], lift: f64| {
            let mut scene = scene();
            scene.bodies[2].place.position = [0.0, lift, 0.0];
            Assembly::new(&seams.iter().cloned().fold(scene, Scene::seam)).unwrap().sewn_at()
        };
        let seams = [row("a", "b").closing(0.0, 0.3, 0.0), row("b", "c").closing(0.1, 0.2, 0.0)];
        assert_eq!(at(&seams, 0.0), Some(0.0));
        assert_eq!(at(&seams, 0.5), Some(0.2));
        assert_eq!(at(&[], 0.5), None);
    }
}
