//! The multigrid cycle through the GPU's arrays, in the order in which the GPU takes sums.

use crate::real::{add, sub};
use crate::solvers::implicit::gpu_layout::{LevelGroup, Vector};
use crate::solvers::implicit::implicit::{LAST_PAIRS, add_weighted};
use crate::solvers::implicit::twin::Twin;

impl Twin<'_> {
    fn left_of(&self, which: Vector, node: usize) -> [f32; 3] {
        let residual = self.get(Vector::Residual, node);
        if node < self.fixture.tables.len() {
            sub(residual, self.system_times(self.mass(node), which, node))
        } else {
            sub(residual, self.level_times(which, node))
        }
    }

    /// Does something for each node, of which it gives all before it takes any.
    pub(super) fn all(&mut self, nodes: &[usize], which: Vector, of: impl Fn(&Self, usize) -> [f32; 3]) {
        let found: Vec<[f32; 3]> = nodes.iter().map(|&node| of(self, node)).collect();
        nodes.iter().zip(found).for_each(|(&node, v)| self.put(which, node, v));
    }

    /// What the first step leaves.
    pub fn leave(&mut self, groups: &[LevelGroup]) {
        let nodes = self.open(groups);
        self.all(&nodes, Vector::Cycled, |twin, node| {
            let residual = twin.left_of(Vector::Cycle, node);
            twin.filtered(node, residual)
        });
    }

    /// A vector as far as a node yields.
    pub(super) fn filtered(&self, node: usize, v: [f32; 3]) -> [f32; 3] {
        if node < self.fixture.tables.len() { self.predicted(node).filtered(v) } else { v }
    }

    pub fn restrict(&mut self, groups: &[LevelGroup]) {
        let nodes = self.open(groups);
        self.restrict_to(&nodes);
    }

    fn restrict_to(&mut self, nodes: &[usize]) {
        self.all(nodes, Vector::Residual, |twin, node| {
            let follow = |sum, (child, weight)| add_weighted(sum, weight, twin.get(Vector::Cycled, child));
            twin.children(node).into_iter().fold([0.0; 3], follow)
        });
        self.all(nodes, Vector::Cycle, |twin, node| twin.jacobi(node, twin.get(Vector::Residual, node)));
    }

    pub fn follow(&mut self, groups: &[LevelGroup]) {
        let nodes = self.open(groups);
        self.follow_to(&nodes);
    }

    fn follow_to(&mut self, nodes: &[usize]) {
        self.all(nodes, Vector::Cycle, |twin, node| {
            let parents = twin.fixture.tables.multigrid.parents[node];
            let follow = |sum, i: usize| {
                add_weighted(sum, parents.weights[i], twin.get(Vector::Cycled, parents.nodes[i] as usize))
            };
            let correction = (0..4).fold([0.0; 3], follow);
            add(twin.get(Vector::Cycle, node), twin.filtered(node, correction))
        });
    }

    pub fn smooth(&mut self, groups: &[LevelGroup]) {
        let nodes = self.open(groups);
        self.smooth_to(&nodes, [Vector::Cycle, Vector::Cycled]);
    }

    pub fn smooth_back(&mut self, groups: &[LevelGroup]) {
        let nodes = self.open(groups);
        self.smooth_to(&nodes, [Vector::Cycled, Vector::Cycle]);
    }

    fn smooth_to(&mut self, nodes: &[usize], [from, to]: [Vector; 2]) {
        self.all(nodes, to, |twin, node| {
            add(twin.get(from, node), twin.jacobi(node, twin.left_of(from, node)))
        });
    }

    pub fn tail(&mut self) {
        let tail = self.fixture.tables.multigrid.tail.clone();
        for (index, first) in (0..).zip(&tail).filter(|(index, group)| group.first_group == *index) {
            let all = &tail[index as usize..][..first.groups as usize];
            let levels: Vec<Vec<usize>> = all.iter().map(|g| self.open(std::slice::from_ref(g))).collect();
            for (level, nodes) in levels.iter().enumerate() {
                self.restrict_to(nodes);
                if level + 1 < levels.len() {
                    self.all(nodes, Vector::Cycled, |twin, node| twin.left_of(Vector::Cycle, node));
                }
            }
            let Some((coarsest, others)) = levels.split_last() else { continue };
            for sweep in 0..2 * LAST_PAIRS - 1 {
                let turns = [Vector::Cycle, Vector::Cycled];
                self.smooth_to(coarsest, if sweep % 2 == 0 { turns } else { [turns[1], turns[0]] });
            }
            for nodes in others.iter().rev() {
                self.follow_to(nodes);
                self.smooth_to(nodes, [Vector::Cycle, Vector::Cycled]);
            }
        }
    }
}
