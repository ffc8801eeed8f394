//! Cloth that starts through a collider: which way out all its nodes take that are inside.
//!
//! Each node on its own would take the shortest way, and a sheet that starts across a box would be torn over it. Nodes that hang
//! together take one way: along the sheet's normal, to the side on which all of them are out first. Contact leaves them alone
//! until they are out.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::contact::colliders::moving::MovingCollider;
use crate::contact::colliders::start::Depth;
use crate::real::{add, cross, norm, scale, sub};
use std::collections::HashSet;

/// Bodies whose nodes are led out together, by their numbers, and which of their nodes: those that are free.
struct LedOut(Vec<(usize, Vec<bool>)>);

/// A node that is inside a collider.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lift {
    /// By solver index.
    pub node: u32,
    /// Unit vector of its way out.
    pub way: [f64; 3],
}

/// Whether some nodes are corners of colliders, which come from `places` on, and others are led out of these.
pub fn are_led_apart(lifts: &[Lift], places: usize, nodes: [u32; 4]) -> bool {
    let is_led = |node: &u32| lifts.binary_search_by_key(node, |lift| lift.node).is_ok();
    nodes.iter().any(|&node| node as usize >= places) && nodes.iter().any(is_led)
}

/// A sheet has one normal if the sum of those of its triangles is at least this part of the sum of their lengths.
const EVEN: f64 = 0.5;
/// A way out that is longer than the shortest by no more than this is as good.
const AS_GOOD: f64 = 1.5;
/// Steps along a way out, at most, and the shortest one, relative to the largest depth.
const STEPS: usize = 256;
const STEP: f64 = 0.05;

impl Assembly {
    /// Has nodes of some bodies be led out of colliders together.
    pub(crate) fn lead_out(&mut self, bodies: &[usize]) {
        let carried = self.carried();
        let free = |body: &BodyAssembly| -> Vec<bool> {
            let nodes = body.free.iter().enumerate();
            nodes.map(|(local, free)| *free && !carried.contains(&(body.first + local))).collect()
        };
        let led = bodies.iter().map(|&body| (body, free(&self.bodies[body]))).collect();
        self.extensions.insert(LedOut(led));
    }

    fn led_out(&self) -> &[(usize, Vec<bool>)] {
        self.extensions.get::<LedOut>().map_or(&[], |led| &led.0)
    }

    /// The first node of each of these bodies.
    pub(super) fn first_nodes_led_out(&self) -> Vec<usize> {
        self.led_out().iter().map(|(body, _)| self.bodies[*body].first).collect()
    }

    /// Whether nodes of some bodies may be led out of colliders.
    pub fn leads_out(&self) -> bool {
        !self.led_out().is_empty() && !self.colliders().is_empty()
    }

    /// The nodes of these that are inside colliders at a time [s], each way out by node, ascending. `x` are the positions [m].
    pub fn lifts(&self, time: f64, x: &dyn Fn(usize) -> [f64; 3]) -> Vec<Lift> {
        let (mut meshes, mut all) = (0, Vec::new());
        for (index, collider) in self.extensions.list::<MovingCollider>().iter().enumerate() {
            let depth = Depth::of(collider, time, &mut meshes);
            let met = self.led_out().iter().filter(|(body, _)| self.meetings().collider(*body, index));
            for (body, is_free) in met.map(|(body, free)| (&self.bodies[*body], free)) {
                let depths: Vec<f64> = (0..body.nodes)
                    .map(
                        |local| {
                            if is_free[local] { depth.at(x(body.first + local)) } else { f64::NEG_INFINITY }
                        },
                    )
                    .collect();
                if depths.iter().any(|&depth| depth > 0.0) {
                    let at = |local: usize| x(body.first + local);
                    all.extend(Group::all(body, &depths).iter().flat_map(|group| {
                        let way = group.way_out(&at, &depths, &depth);
                        let lift =
                            move |&local: &usize| Some(Lift { node: (body.first + local) as u32, way: way? });
                        group.nodes.iter().filter_map(lift).collect::<Vec<_>>()
                    }));
                }
            }
        }
        all.sort_by_key(|lift| lift.node);
        all.dedup_by_key(|lift| lift.node);
        all
    }
}

/// Nodes of a body inside a collider that hang together, and the triangles at them.
#[derive(Default)]
struct Group {
    nodes: Vec<usize>,
    triangles: Vec<[usize; 3]>,
}

impl Group {
    /// Those of a body, whose nodes are so deep [m].
    fn all(body: &BodyAssembly, depths: &[f64]) -> Vec<Self> {
        let triangles: Vec<[usize; 3]> = (body.user_surface().triangles.iter())
            .map(|triangle| triangle.map(|node| body.solver_local(node as usize)))
            .filter(|triangle| triangle.iter().any(|&node| depths[node] > 0.0))
            .collect();
        let mut at = vec![Vec::new(); depths.len()];
        for (number, triangle) in triangles.iter().enumerate() {
            triangle.iter().for_each(|&node| at[node].push(number));
        }
        let (mut seen, mut all) = (vec![false; depths.len()], Vec::new());
        for first in 0..depths.len() {
            let (mut open, mut group, mut of_group) = (vec![first], Self::default(), HashSet::new());
            while let Some(node) = open.pop() {
                if depths[node] <= 0.0 || std::mem::replace(&mut seen[node], true) {
                    continue;
                }
                group.nodes.push(node);
                for &triangle in &at[node] {
                    if of_group.insert(triangle) {
                        group.triangles.push(triangles[triangle]);
                        open.extend(triangles[triangle]);
                    }
                }
            }
            if !group.triangles.is_empty() {
                all.push(group);
            }
        }
        all
    }

    /// The way out for all of them; `None` if each has a better one of its own, or they have no common normal.
    fn way_out(&self, x: &dyn Fn(usize) -> [f64; 3], depths: &[f64], depth: &Depth) -> Option<[f64; 3]> {
        let (mut sum, mut area) = ([0.0; 3], 0.0);
        for triangle in &self.triangles {
            let [a, b, c] = triangle.map(x);
            let normal = cross(sub(b, a), sub(c, a));
            sum = add(sum, normal);
            area += norm(normal);
        }
        if norm(sum) < EVEN * area || area <= 0.0 {
            return None;
        }
        let normal = scale(sum, 1.0 / norm(sum));
        let step = STEP * self.nodes.iter().map(|&node| depths[node]).fold(0.0, f64::max);
        let farthest = |way: [f64; 3]| {
            self.nodes.iter().map(|&node| depth.along(x(node), way, step)).fold(0.0, f64::max)
        };
        let ways = [normal, scale(normal, -1.0)];
        let [one, other] = ways.map(farthest);
        let way = if one <= other { ways[0] } else { ways[1] };
        let is_better = |&node: &usize| depth.along(x(node), way, step) > AS_GOOD * depths[node] + 2.0 * step;
        (one.min(other).is_finite() && self.nodes.iter().any(is_better)).then_some(way)
    }
}

impl Depth {
    /// How far it is to the surface along a unit vector [m], found to a step [m]; infinite if it is not reached.
    fn along(&self, x: [f64; 3], way: [f64; 3], step: f64) -> f64 {
        let mut gone = 0.0;
        for _ in 0..STEPS {
            // The surface is at least as far as it is deep.
            match self.at(add(x, scale(way, gone))) {
                depth if depth > 0.0 => gone += depth.max(step),
                _ => return gone,
            }
        }
        f64::INFINITY
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Body, Collider, Mass, Mesh, Scene};

    /// The ways out of a level sheet of 9 × 9 nodes and 1 m, `y` [m] above the middle of a collider.
    fn ways(y: f64, collider: Collider) -> Vec<[f64; 3]> {
        let sheet = Body::cloth("sheet", Mesh::grid(9, 9, [1.0, 1.0])).with_mass(Mass::Node(0.1));
        let scene = Scene::new("").body(sheet.structural(1.0, 0.0).at([0.0, y, 0.0])).collider(collider);
        let mut assembly = Assembly::new(&scene).unwrap();
        assembly.lead_out(&[0]);
        let start = assembly.bodies[0].start.clone();
        assembly.lifts(0.0, &|node| start[node]).into_iter().map(|lift| lift.way).collect()
    }

    #[test]
    fn a_sheet_across_a_ball_leaves_it_on_the_nearer_side() {
        let ball = || Collider::sphere([0.0; 3], 0.3);
        let up = ways(0.05, ball());
        assert!(up.len() > 10 && up.iter().all(|way| way[1] > 0.999), "{up:?}");
        let down = ways(-0.05, ball());
        assert!(down.len() == up.len() && down.iter().all(|way| way[1] < -0.999), "{down:?}");
    }

    #[test]
    fn where_all_are_out_the_shortest_way_together_nothing_is_led() {
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]);
        assert_eq!(ways(-0.1, floor.clone()), Vec::<[f64; 3]>::new());
        assert_eq!(ways(0.1, floor), Vec::<[f64; 3]>::new());
    }
}
