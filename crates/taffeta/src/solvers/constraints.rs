//! Springs as a list, for methods that make constraints of them.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings};
use crate::assembly::springs::SpringKind;
use crate::elements::spring::stencil::GRID_STEPS;
use crate::scene::Method;
use std::ops::Range;

/// The springs of a scene, one by one: bodies one after the other, in each by first end, second end, kind.
#[derive(Default)]
pub struct Constraints {
    /// Solver indices of the two ends, ascending.
    pub ends: Vec<[u32; 2]>,
    /// Length at rest [m].
    pub rest: Vec<f64>,
    /// Which of the materials.
    pub material: Vec<u32>,
    /// Stiffness [N/m] and damping [kg/s].
    pub materials: Vec<[f64; 2]>,
    /// By material: whether the ends of its springs are neighbours.
    pub near: Vec<bool>,
    /// Those of each body.
    pub bodies: Vec<Range<usize>>,
}

impl Assembly {
    /// Springs as a list, where the method makes constraints of them.
    pub fn constraints(&self) -> &Constraints {
        self.extensions.get().expect("a scene is assembled with constraints, or with a list of none")
    }

    /// The same, for a backend to keep.
    pub(crate) fn take_constraints(&mut self) -> Constraints {
        std::mem::take(self.extensions.get_mut())
    }

    /// Whether anything of a body is solved for: springs or other elements.
    pub fn is_solved_for(&self, body: usize) -> bool {
        let springs = self.constraints().bodies.get(body).is_some_and(|all| !all.is_empty());
        springs || self.has_solved_elements(body)
    }
}

impl Constraints {
    /// Those of some bodies whose method needs them, else none.
    pub(crate) fn new(bodies: &[BodyAssembly], method: Method) -> Self {
        let mut all = Self::default();
        if matches!(method, Method::Springs | Method::Xpbd) {
            return all;
        }
        for body in bodies {
            let from = all.ends.len();
            match (&body.springs, body.grid_layout) {
                (BodySprings::Grid(along), Some(layout)) => all.add_grid(body.first, along, layout),
                (BodySprings::Mesh(_), _) => all.add_mesh(body),
                (BodySprings::Grid(_), None) => {}
            }
            all.bodies.push(from..all.ends.len());
        }
        all
    }

    /// Number of all.
    pub fn len(&self) -> usize {
        self.ends.len()
    }

    /// Whether there is none.
    pub fn is_empty(&self) -> bool {
        self.ends.is_empty()
    }

    /// The number of a material that does something.
    fn add_material(&mut self, [k, d]: [f64; 2], near: bool) -> Option<u32> {
        let acts = k > 0.0 || d > 0.0;
        acts.then(|| {
            self.materials.push([k, d]);
            self.near.push(near);
            self.materials.len() as u32 - 1
        })
    }

    fn add_grid(
        &mut self,
        first: usize,
        along: &crate::assembly::body::GridDirections,
        [rows, cols]: [usize; 2],
    ) {
        let along = along.map(|direction| {
            direction.and_then(|[k, d, length]| Some((self.add_material([k, d], true)?, length)))
        });
        // Each node owns six; by their other ends.
        let order = [0, 1, 5, 2, 4, 3];
        for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
            for direction in order {
                let (down, across) = GRID_STEPS[direction];
                let there = (row + down, col.checked_add_signed(across).filter(|&col| col < cols));
                if let (Some((material, length)), (to, Some(col_there))) = (along[direction], there)
                    && to < rows
                {
                    let [a, b] = [row * cols + col, to * cols + col_there].map(|node| (first + node) as u32);
                    self.push([a, b], length, material);
                }
            }
        }
    }

    fn add_mesh(&mut self, body: &BodyAssembly) {
        let BodySprings::Mesh(lists) = &body.springs else { return };
        let mut springs = Vec::new();
        for list in lists {
            let Some(material) = self.add_material([list.k, list.d], list.kind == SpringKind::Structural)
            else {
                continue;
            };
            let ends = list.pairs.iter().map(|pair| pair.map(|node| node + body.first as u32));
            springs
                .extend(ends.zip(&list.rest).map(|([a, b], &rest)| ([a.min(b), a.max(b)], material, rest)));
        }
        springs.sort_by_key(|&(ends, material, _)| (ends, material));
        for (ends, material, rest) in springs {
            self.push(ends, rest, material);
        }
    }

    fn push(&mut self, ends: [u32; 2], rest: f64, material: u32) {
        self.ends.push(ends);
        self.rest.push(rest);
        self.material.push(material);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::assembly::Assembly;
    use crate::scene::{Body, Icosphere, Mass, Mesh, Scene};

    #[test]
    fn every_spring_is_listed_once_by_its_ends() {
        let heavy = |body: Body| body.with_mass(Mass::Node(0.1));
        let grid = heavy(Body::cloth("grid", Mesh::grid(5, 7, [0.6, 0.8])));
        let ball = Mesh::Icosphere(Icosphere { radius: 1.0, subdivisions: 2 });
        let scene = Scene::new("")
            .method(Method::Ice)
            .body(grid.structural(9.0, 0.0).shear(8.0, 0.1).bend(0.0, 0.0))
            .body(heavy(Body::soft("ball", ball)).structural(7.0, 0.0).bend(6.0, 0.0));
        let assembly = Assembly::new(&scene).unwrap();
        let all = assembly.constraints();
        // Structural 5·6 + 7·4, shear 2·4·6, bend none; edges of the ball 3·162 − 6, each with a bend spring.
        assert_eq!(all.bodies, [0..106, 106..106 + 2 * 480]);
        assert!(all.ends.iter().all(|[a, b]| a < b) && all.ends.is_sorted());
        let first = assembly.bodies[1].first as u32;
        assert!(all.ends[106..].iter().all(|[a, _]| *a >= first));
        assert_eq!(all.materials, [[9.0, 0.0], [9.0, 0.0], [8.0, 0.1], [8.0, 0.1], [7.0, 0.0], [6.0, 0.0]]);
        let start = |node: u32| {
            let body = &assembly.bodies[usize::from(node >= first)];
            body.start[node as usize - body.first]
        };
        for (&[a, b], &rest) in all.ends.iter().zip(&all.rest) {
            let d = crate::real::sub(start(b), start(a));
            assert!((crate::real::norm(d) - rest).abs() < 1e-12);
        }
    }
}
