//! Which triangles come near each other, as rows compare it: find.wgsl one number after the other.

use crate::contact::triangles::carry::reach_of_pushes;
use crate::contact::triangles::closest::{Closest, EdgeEdge, Pair, VertexTriangle};
use crate::contact::triangles::cones::Nearest;
use crate::contact::triangles::filter::{keeps_shape, limits, reach, reach_together};
use crate::contact::triangles::gpu_layout::{self as layout, FORCE_RECORDS, SurfaceContact};
use crate::contact::triangles::impulse::{KEEPS, grip};
use crate::contact::triangles::slide::word;
use crate::contact::triangles::solved::NEAR;
use crate::contact::triangles::surfaces::{Kind, NEIGHBOURS};
use crate::contact::triangles::tangle::{Knot, Rule};
use crate::contact::triangles::twin::Twin;
use crate::gpu::layout::NONE;
use crate::real::{Real, add, cross, dot, norm, scale, sub};

/// A pair of primitives of two leaves.
pub struct Candidate {
    /// The leaf of each node, and its lane.
    pub lanes: [(usize, usize); 4],
    /// Nodes of the first side, of those of `lanes`.
    pub first: usize,
    order: u32,
}

pub type Four3 = [[f32; 3]; 4];

impl Twin {
    /// How far from each other triangles of two leaves matter [m].
    fn reach(&self, a: usize, b: usize) -> f32 {
        let [of_a, of_b] = [a, b].map(|leaf| self.box_of(leaf));
        let allowance = self.length(layout::ALLOWANCE);
        let listed = self.work[layout::LISTED] as usize;
        if [layout::NEAR, layout::CARRIED, layout::SOLVED].contains(&listed) {
            let approach: [f32; 3] = std::array::from_fn(|axis| {
                (of_a[3][axis] - of_b[2][axis]).max(of_b[3][axis] - of_a[2][axis])
            });
            let by_pushes = match listed {
                layout::CARRIED => reach_of_pushes(self.corners.longest_push.into()) as f32,
                _ => 0.0,
            };
            let by_solver = match listed {
                layout::SOLVED => (NEAR as f32 - 1.0) * self.length(layout::THICKEST),
                _ => 0.0,
            };
            let needs = reach_together(f64::from(norm(approach))) as f32 + allowance + by_pushes + by_solver;
            return (KEEPS as f32 * self.material(a, b)[0] + needs) * layout::LOOSE_REACH as f32;
        }
        let way = |bounds: [[f32; 3]; 4]| -> f32 {
            norm(std::array::from_fn(|axis| bounds[2][axis].abs().max(bounds[3][axis].abs())))
        };
        let most = way(of_a).max(way(of_b)) + allowance;
        let digit = f32::EPSILON * self.number(layout::FARTHEST_PLACE);
        let [thickest, longest] =
            [layout::THICKEST, layout::LONGEST_EDGE].map(|word| f64::from(self.length(word)));
        reach(most.into(), thickest, longest, digit.into()) as f32 * layout::LOOSE_REACH as f32
    }

    /// Pairs of leaves that are listed for certain, and those that may be: how they are bounded is rounded one way or another.
    pub fn listed_pairs(&self) -> [Vec<[u32; 3]>; 2] {
        let mut all = [Vec::new(), Vec::new()];
        let marks = self.list(6);
        let is_marked = |leaf: usize| self.work[marks + leaf] == self.work[layout::JAM];
        for a in 0..self.leaves() {
            for b in a..self.leaves() {
                let is_asked =
                    self.work[layout::LISTED] != layout::AROUND as u32 || is_marked(a) || is_marked(b);
                if !is_asked || self.material(a, b)[0] < 0.0 {
                    continue;
                }
                let [of_a, of_b] = [a, b].map(|leaf| self.box_of(leaf));
                let gap: [f32; 3] = std::array::from_fn(|axis| {
                    (of_a[0][axis] - of_b[1][axis]).max(of_b[0][axis] - of_a[1][axis]).max(0.0)
                });
                let reach = self.reach(a, b);
                let pair = [a as u32, b as u32, self.ring(a, b)];
                for (list, share) in all.iter_mut().zip([0.9999, 1.0001]) {
                    if norm(gap) < share * reach {
                        list.push(pair);
                    }
                }
            }
        }
        all
    }

    /// Lists pairs of leaves as a kernel may.
    pub fn list_leaf_pairs(&mut self) {
        let [_, all] = self.listed_pairs();
        self.work[layout::PAIRS] = all.len() as u32;
        for (at, [a, b, ring]) in all.into_iter().enumerate() {
            let reach = self.reach(a as usize, b as usize);
            self.pairs[at] = [a, b, ring, reach.to_bits()];
        }
    }

    fn ring(&self, a: usize, b: usize) -> u32 {
        let rows = self.table(layout::ROWS_AT) + a;
        let items = self.table(layout::ROW_ITEMS_AT);
        let row = self.tables[rows] as usize..self.tables[rows + 1] as usize;
        let mut found = row.map(|at| [self.tables[items + 2 * at], self.tables[items + 2 * at + 1]]);
        found.find(|[leaf, _]| *leaf == b as u32).map_or(0, |[_, ring]| ring)
    }

    /// All pairs of primitives of two leaves.
    fn candidates(&self, a: usize, b: usize) -> Vec<Candidate> {
        let byte = |word: u32, at: usize| (word >> (8 * at) & 255) as usize;
        let primitives = |leaf: usize| {
            let words = self.leaf(leaf);
            let [triangles, edges, vertices] = [0, 1, 2].map(|what| byte(words[layout::LEAF_COUNTS], what));
            let lanes = |first: usize, count: usize, size: usize| -> Vec<Vec<usize>> {
                (0..count).map(|one| (0..size).map(|at| byte(words[first + one], at)).collect()).collect()
            };
            let vertex = |one: usize| vec![byte(words[layout::LEAF_VERTICES + one / 4], one % 4)];
            [
                lanes(layout::LEAF_TRIANGLES, triangles, 3),
                lanes(layout::LEAF_EDGES, edges, 2),
                (0..vertices).map(vertex).collect(),
            ]
        };
        let [of_a, of_b] = [primitives(a), primitives(b)];
        let mut all = Vec::new();
        let mut add =
            |way: u32, (one, first): (usize, &Vec<usize>), (other, second): (usize, &Vec<usize>)| {
                let mut lanes: Vec<(usize, usize)> = Vec::new();
                lanes.extend(first.iter().map(|&lane| (a, lane)));
                lanes.extend(second.iter().map(|&lane| (b, lane)));
                if way == 1 {
                    lanes.rotate_right(1);
                }
                let lanes = [lanes[0], lanes[1], lanes[2], lanes[3]];
                let first = if way == 2 { 2 } else { 1 };
                all.push(Candidate { lanes, first, order: way << 16 | (one as u32) << 8 | other as u32 });
            };
        let numbered = |all: &[Vec<usize>]| all.iter().cloned().enumerate().collect::<Vec<_>>();
        for (way, [first, second]) in [[2, 0], [0, 2], [1, 1]].into_iter().enumerate() {
            for (one, lanes) in &numbered(&of_a[first]) {
                for (other, lanes_b) in &numbered(&of_b[second]) {
                    if a != b || way == 0 || way == 2 && other > one {
                        add(way as u32, (*one, lanes), (*other, lanes_b));
                    }
                }
            }
        }
        all
    }

    /// Whether any two nodes of a candidate's sides are in a mask of a ring.
    fn is_in_ring(&self, one: &Candidate, [.., ring, _]: [u32; 4], mask: usize) -> bool {
        let words = self.table(layout::RINGS_AT) + 16 * ring as usize + mask;
        let is_in = |i: usize, j: usize| self.tables[words + i / 2] >> (16 * (i % 2)) >> j & 1 == 1;
        let (first, second) = one.lanes.split_at(one.first);
        let (rows, others) = if one.order >> 16 == 1 { (second, first) } else { (first, second) };
        ring > 0 && rows.iter().any(|&(_, i)| others.iter().any(|&(_, j)| is_in(i, j)))
    }

    fn node(&self, (leaf, lane): (usize, usize)) -> usize {
        self.leaf(leaf)[lane] as usize
    }

    /// Pairs of primitives of two leaves that can touch, with their nodes and their thickness.
    pub fn touching(&self, pair: [u32; 4]) -> Vec<(Candidate, [usize; 4], f32)> {
        let [a, b] = [pair[0] as usize, pair[1] as usize];
        let all = self.candidates(a, b).into_iter();
        let any_collider =
            [a, b].iter().any(|&leaf| self.leaf(leaf)[0] as usize >= self.table(layout::NODE_PLACES));
        let give_way = |one: &Candidate| !any_collider || self.gives_way(one);
        let may = |one: &Candidate| !self.is_in_ring(one, pair, 0) && give_way(one);
        all.filter(may)
            .map(|one| {
                let nodes = one.lanes.map(|lane| self.node(lane));
                let [thickness, _] = self.material(a, b);
                let start = nodes.map(|node| self.start(node));
                let most = norm(closest(relative(start), one.first).apart) * NEIGHBOURS as f32;
                let is_near = self.is_in_ring(&one, pair, 8);
                (one, nodes, if is_near && most < thickness { most } else { thickness })
            })
            .collect()
    }

    /// The force of a contact in the last sub-step [N], and the impulse that the solver has given it in this one [N·s].
    fn last_force(&self, order: [u32; 3]) -> ([f32; 3], Option<[f32; 3]>) {
        let count = self.work[layout::FORCES] as usize;
        let mut all = self.forces.chunks_exact(FORCE_RECORDS).take(count);
        let found = all.find(|records| records[0][..3] == order);
        let vector = |[x, y, z, _]: [u32; 4]| [x, y, z].map(f32::from_bits);
        let solved = |records: &[[u32; 4]]| (records[0][3] != 0).then_some(vector(records[2]));
        found.map_or(([0.0; 3], None), |records| (vector(records[1]), solved(records)))
    }

    pub fn find_surface_contacts(&mut self) {
        let for_solver = self.work[layout::LISTED] == layout::SOLVED as u32;
        let leads = for_solver || self.tables[layout::IS_SOLVED] == 0;
        let within = if for_solver { NEAR as f32 } else { 1.0 };
        let most = within.max(KEEPS as f32);
        for at in 0..self.work[layout::PAIRS] as usize {
            let pair = self.pairs[at];
            for (one, nodes, thickness) in self.touching(pair) {
                let [x, ends] = [layout::BEFORE, layout::AFTER]
                    .map(|array| relative(nodes.map(|node| self.place(array, node))));
                let Closest { weights, apart } = closest(x, one.first);
                let order = [pair[0], pair[1], one.order];
                match self.rule(nodes, one.first) {
                    Rule::Apart if self.gives_way(&one) => {}
                    Rule::Apart | Rule::Ignored => continue,
                    Rule::Through { above } => {
                        if leads && norm(apart) < most * thickness {
                            self.lead_back(nodes, weights, thickness, above, order);
                        }
                        continue;
                    }
                }
                let distance = norm(apart);
                let by = 1.0 / if distance > f32::TINY { distance } else { 1.0 };
                let then = add(
                    add(scale(ends[0], weights[0]), scale(ends[1], weights[1])),
                    scale(ends[2], weights[2]),
                );
                let along = dot(then, scale(apart, by));
                let (force, solved) = self.last_force(order);
                let is_new = force == [0.0; 3] && solved.is_none();
                let keeps = if is_new { within } else { most };
                let kind = kind_of(one.first);
                let places = nodes.map(|node| node as u32);
                let nearest = Nearest { kind, nodes: places, weights, apart, carries: !is_new };
                if along < keeps * thickness && distance > 0.0 && self.is_in_cones(&nearest) {
                    let friction = self.material(pair[0] as usize, pair[1] as usize)[1];
                    let normal = apart.map(|x| x / distance);
                    self.add_contact(SurfaceContact {
                        nodes: places,
                        weights,
                        normal,
                        gap: distance - thickness,
                        impulse: scale(force, if solved.is_some() { 0.0 } else { self.h }),
                        solved: solved.unwrap_or_default(),
                        grip: solved.map_or(0.0, |solved| grip(solved, normal, friction)),
                        force,
                        thickness,
                        order,
                        friction,
                        ..SurfaceContact::default()
                    });
                }
            }
        }
    }

    /// Whether the sides of a pair stand in each other's normal cones.
    fn is_in_cones(&self, nearest: &Nearest<f32>) -> bool {
        let fan = |place: u32| {
            let [from, to] =
                [0, 1].map(|end| self.tables[self.table(layout::FANS_AT) + place as usize + end]);
            let items = &self.tables[self.table(layout::FAN_ITEMS_AT)..];
            items[from as usize..to as usize].chunks_exact(2).map(|two| [two[0], two[1]])
        };
        nearest.is_in_cones(fan, |place| self.place(layout::BEFORE, place as usize))
    }

    /// What becomes of a pair whose surfaces may pass through each other.
    pub fn rule(&self, nodes: [usize; 4], first: usize) -> Rule {
        let two = |node: usize, word: usize| {
            [0, 1].map(|trace| self.knots[layout::KNOT_WORDS * node + word + trace])
        };
        let knot = |node: usize| Knot {
            of: two(node, layout::KNOT_OF),
            next: two(node, layout::KNOT_NEXT),
            astray: two(node, layout::KNOT_ASTRAY),
            above: two(node, layout::KNOT_ABOVE),
            loose: two(node, layout::KNOT_LOOSE),
        };
        let is_led = |node: &usize| self.knots[layout::KNOT_WORDS * node + layout::KNOT_LED] != 0;
        if nodes.iter().any(is_led) && nodes.iter().any(|node| *node >= self.nodes()) {
            return Rule::Ignored;
        }
        Rule::of(kind_of(first), nodes.map(knot))
    }

    fn lead_back(
        &mut self,
        nodes: [usize; 4],
        weights: [f32; 4],
        thickness: f32,
        above: bool,
        order: [u32; 3],
    ) {
        let [v, a, b, c] = nodes.map(|node| self.place(layout::BEFORE, node));
        let normal = cross(sub(b, a), sub(c, a));
        if norm(normal) > f32::TINY {
            let normal = scale(normal, if above { 1.0 } else { -1.0 } / norm(normal));
            let gap = dot(normal, sub(v, a)) - thickness;
            self.add_lead(nodes, weights, normal, [gap, thickness], order);
        }
    }

    fn add_lead(
        &mut self,
        nodes: [usize; 4],
        weights: [f32; 4],
        normal: [f32; 3],
        [gap, thickness]: [f32; 2],
        order: [u32; 3],
    ) {
        self.add_contact(SurfaceContact {
            nodes: nodes.map(|node| node as u32),
            weights,
            normal,
            gap,
            thickness,
            order,
            leads: 1,
            ..SurfaceContact::default()
        });
    }

    pub fn add_pulls(&mut self) {
        for pull in 0..self.table(layout::PULL_COUNT) {
            let first = layout::KNOT_WORDS * self.table(layout::ALL_PLACES) + layout::PULL_WORDS * pull;
            let nodes = [0, 1, 2, 3].map(|at| self.knots[first + at] as usize);
            let number = |at: usize| f32::from_bits(self.knots[first + at]);
            let is_led = self.knots[first + layout::PULL_LED] != 0;
            let solves = self.work[layout::LISTED] == layout::SOLVED as u32;
            if !is_led && self.tables[layout::IS_SOLVED] != 0 && !solves {
                continue;
            }
            let weights = [0, 1, 2, 3].map(|at| number(layout::PULL_WEIGHTS + at));
            let normal = [0, 1, 2].map(|at| number(layout::PULL_DIRECTION + at));
            let x = relative(nodes.map(|node| self.place(layout::BEFORE, node)));
            let apart = (0..3).fold([0.0; 3], |sum, i| add(sum, scale(x[i], weights[i])));
            let gap = if is_led { 0.0 } else { dot(normal, apart) } - number(layout::PULL_THICKNESS);
            self.add_lead(
                nodes,
                weights,
                normal,
                [gap, number(layout::PULL_SIZE)],
                [NONE, NONE, pull as u32],
            );
        }
    }

    fn add_contact(&mut self, one: SurfaceContact) {
        let nearest = (1.0 + one.gap / one.thickness).max(0.0);
        self.work[layout::NEAREST] = self.work[layout::NEAREST].min(nearest.to_bits());
        let number = self.work[layout::CONTACTS] as usize;
        self.work[layout::CONTACTS] += 1;
        self.contacts[number] = one;
        for (&node, &weight) in one.nodes.iter().zip(&one.weights) {
            if weight != 0.0 && (node as usize) < self.nodes() {
                let at = self.list(0) + node as usize;
                self.work[at] += 1;
                if self.work[at] == 1 {
                    let touched = self.list(5) + self.work[layout::TOUCHED] as usize;
                    self.work[touched] = node;
                    self.work[layout::TOUCHED] += 1;
                }
            }
        }
    }

    pub fn limit_ways(&mut self) {
        let (kind, far) = (self.work[layout::LISTED] as usize, self.number(layout::FARTHEST_PLACE));
        for at in 0..self.work[layout::PAIRS] as usize {
            for (one, nodes, thickness) in self.touching(self.pairs[at]) {
                let is_held = |&node: &usize| {
                    node < self.nodes() && self.work[self.list(4) + node] == self.work[layout::JAM]
                };
                let is_asked = kind != layout::AROUND || nodes.iter().any(is_held);
                if !is_asked || self.rule(nodes, one.first) != Rule::Apart {
                    continue;
                }
                let [x, ends] =
                    [layout::BEFORE, layout::AFTER].map(|array| nodes.map(|node| self.place(array, node)));
                let moves: Four3 = std::array::from_fn(|i| sub(ends[i], x[i]));
                let x = relative(x);
                let (apart, together) = (closest(x, one.first).apart, kind == layout::NEAR);
                if together && self.are_pinned_as_one(nodes) {
                    continue;
                }
                let found = match one.first {
                    1 => limits::<f32, VertexTriangle>(x, moves, apart, (thickness, far), together),
                    _ => limits::<f32, EdgeEdge>(x, moves, apart, (thickness, far), together),
                };
                for (i, (node, part)) in nodes.into_iter().zip(found.parts).enumerate() {
                    let at = self.list(3) + node;
                    if node < self.nodes() && part < 1.0 {
                        let away = if i < one.first { apart } else { apart.map(|along| -along) };
                        self.work[at] = self.work[at].min(word(part, away));
                    }
                }
            }
        }
    }

    /// Whether any node of a pair is free.
    fn gives_way(&self, one: &Candidate) -> bool {
        !one.lanes.iter().all(|&(leaf, lane)| self.leaf(leaf)[layout::LEAF_HELD] >> lane & 1 == 1)
    }

    /// Where a node was at the start of the scene [m].
    fn start(&self, node: usize) -> [f32; 3] {
        let at = self.table(layout::START_AT) + 3 * node;
        std::array::from_fn(|axis| f32::from_bits(self.tables[at + axis]))
    }

    /// Whether all nodes of a pair are pinned, and have kept their distances of the start.
    fn are_pinned_as_one(&self, nodes: [usize; 4]) -> bool {
        let is_one = |array: usize| {
            keeps_shape(nodes.map(|node| self.start(node)), nodes.map(|node| self.place(array, node)))
        };
        nodes.iter().all(|&node| node < self.nodes() && self.position[node][3] <= 0.0)
            && is_one(layout::BEFORE)
            && is_one(layout::AFTER)
    }
}

fn kind_of(first: usize) -> Kind {
    if first == 1 { Kind::VertexTriangle } else { Kind::EdgeEdge }
}

/// Positions relative to the last.
pub fn relative(x: Four3) -> Four3 {
    x.map(|one| sub(one, x[3]))
}

pub fn closest(x: Four3, first: usize) -> Closest<f32> {
    if first == 1 { VertexTriangle::closest(x) } else { EdgeEdge::closest(x) }
}
