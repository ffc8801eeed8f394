//! Nodes that are joined to other nodes or to points, and nodes that may not go far from others.

use crate::attachments::tethers;
use crate::build::Assembly;
use crate::build::body::BodyAssembly;
use crate::motion::keyframes::Track;
use crate::scene::{Body, Scene, SceneError, Seam, SeamSide};
use crate::topology::{Csr, RestShape, measure};
use std::collections::{HashMap, HashSet};

/// The second end of a row is a point, its number in the other bits.
pub const IS_POINT: u32 = 1 << 31;

/// What holds nodes together, or at points, or near others. A function of the scene alone.
#[derive(Clone, Debug, Default)]
pub struct Attachments {
    /// Joints: those of seams in the scene's order, then those of pins that break, body by body.
    pub rows: Vec<Row>,
    /// What rows have in common: one for each seam, then one for each pin that breaks.
    pub laws: Vec<Law>,
    /// Number of seams.
    pub seams: usize,
    /// Pairs of each seam that are left out, as both nodes are held for good.
    pub held: Vec<usize>,
    /// Where pins that break hold nodes.
    pub points: Vec<Point>,
    /// Tethers, ascending by node, the shortest of a node first.
    pub tethers: Vec<Tether>,
    /// Nodes with rows or tethers, ascending by solver index.
    pub nodes: Vec<u32>,
    /// Rows of each of `nodes`, ascending.
    pub rows_of: Csr,
    /// Tethers of each of `nodes`.
    pub tethers_of: Csr,
    /// Rows of each group of two or more that share free nodes, ascending.
    pub groups: Csr,
    /// Nodes that do not touch each other because a seam makes them neighbours, from both sides, ascending.
    apart: Vec<[u32; 2]>,
}

/// A joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Row {
    /// Solver indices, ascending; or one, and a point with [`IS_POINT`].
    pub ends: [u32; 2],
    /// Distance at the start [m].
    pub start: f64,
    /// Which of the laws.
    pub law: u32,
}

/// How joints hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Law {
    /// Distance once closed [m].
    pub length: f64,
    /// When closing begins and ends [s]; the same: it is closed.
    pub close: [f64; 2],
    /// Compliance [m/N]; 0: rigid.
    pub compliance: f64,
    /// Force at which it breaks [N]; infinite: never.
    pub break_force: f64,
}

/// A point that holds a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where it starts, before any motion [m].
    pub start: [f64; 3],
    /// Which of the scene's tracks it follows; `u32::MAX`: none.
    pub track: u32,
    /// Whether a collider carries it: colliders leave its node alone until it breaks.
    pub carried: bool,
}

/// A node that may not go far from another, held one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tether {
    /// Solver index.
    pub node: u32,
    /// Solver index of the held node.
    pub anchor: u32,
    /// How far [m].
    pub length: f64,
}

impl Law {
    /// Share of its closing that has gone by at time `t` [s].
    pub fn share(&self, t: f64) -> f64 {
        let [start, end] = self.close;
        if end > start { ((t - start) / (end - start)).clamp(0.0, 1.0) } else { 1.0 }
    }
}

impl Attachments {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Whether any row may break.
    pub fn breaks(&self) -> bool {
        self.laws.iter().any(|law| law.break_force < f64::INFINITY)
    }

    /// Whether a row holds a node at a point that a collider carries.
    pub fn is_carried(&self, row: &Row) -> bool {
        let end = row.ends[1];
        end & IS_POINT != 0 && self.points[(end ^ IS_POINT) as usize].carried
    }

    /// Whether they may add energy: seams that close, points that move.
    pub fn drives(&self) -> bool {
        self.laws.iter().any(|law| law.close[1] > law.close[0])
            || self.points.iter().any(|point| point.track != u32::MAX)
    }

    /// What the user should know of seams that can not close.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        let sewn = |seam: usize| self.rows.iter().filter(|row| row.law as usize == seam).count();
        let held = self.held.iter().enumerate().filter(|(_, held)| **held > 0);
        held.map(move |(seam, &held)| {
            format!(
                "seam[{seam}]: pins hold both nodes of {held} of its {} pairs, which it can not close; leave them out, or let \
                 one side go",
                held + sewn(seam)
            )
        })
    }

    /// The other node of a row, if it joins two.
    pub fn joined(&self) -> impl Iterator<Item = [u32; 2]> {
        self.rows.iter().map(|row| row.ends).filter(|ends| ends[1] & IS_POINT == 0)
    }

    /// Nodes that do not touch a node, given by its solver index, because a seam makes them neighbours; ascending.
    pub fn apart(&self, node: usize) -> impl Iterator<Item = usize> {
        let [start, end] =
            [node, node + 1].map(|at| self.apart.partition_point(|pair| (pair[0] as usize) < at));
        self.apart[start..end].iter().map(|pair| pair[1] as usize)
    }

    /// Notes a node that a pin holds until it breaks.
    pub(crate) fn hold(&mut self, node: u32, law: u32, point: Point) {
        let end = self.points.len() as u32 | IS_POINT;
        self.points.push(point);
        self.rows.push(Row { ends: [node, end], start: 0.0, law });
    }

    /// Lists rows and tethers by node, and the groups of rows.
    fn list(&mut self, is_free: impl Fn(u32) -> bool) {
        let ends = self.rows.iter().flat_map(|row| row.ends).filter(|end| end & IS_POINT == 0);
        self.nodes = ends.chain(self.tethers.iter().map(|tether| tether.node)).collect();
        self.nodes.sort_unstable();
        self.nodes.dedup();
        let number = |node: u32| self.nodes.binary_search(&node).unwrap_or_default() as u32;
        let rows: Vec<(u32, u32)> = (0..)
            .zip(&self.rows)
            .flat_map(|(row, of)| of.ends.map(|end| (end, row)))
            .filter(|(end, _)| end & IS_POINT == 0)
            .map(|(end, row)| (number(end), row))
            .collect();
        let tethers: Vec<(u32, u32)> =
            self.tethers.iter().map(|tether| number(tether.node)).zip(0..).collect();
        self.rows_of = Csr::new(self.nodes.len(), rows.into_iter());
        self.tethers_of = Csr::new(self.nodes.len(), tethers.into_iter());
        self.group(is_free);
    }

    /// Finds rows that share free nodes. What is held moves for none of its rows, so it does not join them.
    fn group(&mut self, is_free: impl Fn(u32) -> bool) {
        let mut first: Vec<u32> = (0..self.rows.len() as u32).collect();
        let root = |first: &[u32], mut row: u32| {
            while first[row as usize] != row {
                row = first[row as usize];
            }
            row
        };
        let free = (0..).zip(&self.nodes).filter(|(_, node)| is_free(**node));
        for (number, _) in free {
            for pair in self.rows_of.row(number).windows(2) {
                let [a, b] = [pair[0], pair[1]].map(|row| root(&first, row));
                first[a.max(b) as usize] = a.min(b);
            }
        }
        let roots: Vec<u32> = (0..first.len() as u32).map(|row| root(&first, row)).collect();
        let mut size = vec![0; roots.len()];
        roots.iter().for_each(|&root| size[root as usize] += 1);
        let mut number = vec![0; roots.len()];
        let mut count = 0;
        for row in 0..roots.len() {
            number[row] = count;
            count += u32::from(size[row] > 1);
        }
        let grouped = roots.iter().zip(0..).filter(|(root, _)| size[**root as usize] > 1);
        let entries: Vec<(u32, u32)> = grouped.map(|(&root, row)| (number[root as usize], row)).collect();
        self.groups = Csr::new(count as usize, entries.into_iter());
    }
}

impl Assembly {
    /// Adds seams and tethers, when all bodies are there and none of their pins has moved.
    pub(crate) fn attach(&mut self, scene: &Scene) -> Result<(), SceneError> {
        let pins = std::mem::take(&mut self.attachments);
        let (mut all, mut sewn) = (Attachments::default(), HashMap::new());
        for (index, seam) in scene.seams.iter().enumerate() {
            let law = all.laws.len() as u32;
            let path = format!("seam[{index}]");
            let pairs = self.sewn(seam).map_err(|e| e.under(&path))?;
            for &[a, b] in &pairs {
                if let Some(before) = sewn.insert([a.min(b), a.max(b)], index) {
                    return Err(SceneError::new(path, self.sewn_twice([a, b], (before, index))));
                }
            }
            all.laws.push(Law {
                length: seam.length,
                close: [seam.close.start, seam.close.end],
                compliance: seam.k.map_or(0.0, |k| 1.0 / k),
                break_force: seam.break_force.unwrap_or(f64::INFINITY),
            });
            let row = |[a, b]: [u32; 2]| Row { ends: [a.min(b), a.max(b)], start: 0.0, law };
            all.rows.extend(pairs.into_iter().map(row));
        }
        all.seams = all.laws.len();
        let seams = all.seams as u32;
        all.laws.extend(pins.laws);
        all.points = pins.points;
        all.apart = self.sewn_apart(&all);
        all.held = self.leave_out_held(&mut all.rows, all.seams);
        all.rows.extend(pins.rows.into_iter().map(|row| Row { law: row.law + seams, ..row }));
        for (index, (body, built)) in scene.bodies.iter().zip(&self.bodies).enumerate() {
            let found = tethers_of(body, built).map_err(|e| e.under(&format!("body[{index}]")))?;
            all.tethers.extend(found);
        }
        all.list(|node| self.is_free(node));
        self.attachments = all;
        Ok(())
    }

    /// Says that two nodes are sewn to each other more than once.
    fn sewn_twice(&self, pair: [u32; 2], (before, index): (usize, usize)) -> String {
        let [a, b] = pair.map(|node| {
            let body = self.body_of(node);
            format!("vertex {} of body `{}`", body.vertex_of_solver(node as usize - body.first), body.name)
        });
        let where_else = if before == index { "twice".to_owned() } else { format!("as seam[{before}] does") };
        format!("sews {a} to {b} {where_else}; once would do, or twice the k and break_force")
    }

    /// Takes out rows of nodes that are both held for good, which nothing can join; how many each seam had.
    fn leave_out_held(&self, rows: &mut Vec<Row>, seams: usize) -> Vec<usize> {
        let mut held = vec![0; seams];
        rows.retain(|row| {
            let moves = row.ends.iter().any(|&node| self.is_free(node));
            held[row.law as usize] += usize::from(!moves);
            moves
        });
        held
    }

    /// The body of a node, given by its solver index.
    fn body_of(&self, node: u32) -> &BodyAssembly {
        &self.bodies[self.bodies.partition_point(|body| body.first <= node as usize) - 1]
    }

    /// Whether no pin holds a node for good.
    fn is_free(&self, node: u32) -> bool {
        let body = self.body_of(node);
        body.free[node as usize - body.first]
    }

    /// Sewn nodes, and each with the neighbours of the other, where both touch others.
    fn sewn_apart(&self, all: &Attachments) -> Vec<[u32; 2]> {
        let body = |node: u32| self.body_of(node);
        let mut apart = Vec::new();
        for [a, b] in all.joined() {
            let (Some(of_a), Some(of_b)) = (&body(a).touching, &body(b).touching) else { continue };
            apart.push([a, b]);
            for (node, other, touching) in [(a, b, of_b), (b, a, of_a)] {
                let home = body(other);
                touching.apart.each(home, other as usize - home.first, |near| {
                    apart.push([node, (home.first + near) as u32]);
                });
            }
        }
        apart.retain(|[a, b]| a != b);
        apart.extend(apart.clone().into_iter().map(|[a, b]| [b, a]));
        apart.sort_unstable();
        apart.dedup();
        apart
    }

    /// Notes how far apart the ends of rows are, when pins are where their motion starts.
    pub(crate) fn measure_seams(&mut self) {
        let bodies = &self.bodies;
        let place = |node: u32| {
            let body = &bodies[bodies.partition_point(|body| body.first <= node as usize) - 1];
            body.start[node as usize - body.first]
        };
        for row in &mut self.attachments.rows {
            let [a, b] = row.ends;
            if b & IS_POINT == 0 {
                row.start = crate::real::norm(crate::real::sub(place(a), place(b)));
            }
        }
    }

    /// Brings nodes that a pin holds until it breaks to where its motion starts.
    pub(crate) fn start_points(&mut self) {
        let Self { attachments, bodies, tracks, .. } = self;
        for row in attachments.rows.iter().filter(|row| row.ends[1] & IS_POINT != 0) {
            let (node, point) = (row.ends[0] as usize, attachments.points[(row.ends[1] ^ IS_POINT) as usize]);
            let Some(track) = tracks.get(point.track as usize) else { continue };
            let body = bodies.partition_point(|body| body.first <= node) - 1;
            let body = &mut bodies[body];
            body.start[node - body.first] = Track::pose(track, 0.0).apply(point.start);
        }
    }

    /// Solver indices of the pairs that a seam sews.
    fn sewn(&self, seam: &Seam) -> Result<Vec<[u32; 2]>, SceneError> {
        let sides = [("from", &seam.from), ("to", &seam.to)];
        let [from, to] = sides.map(|(key, side)| (key, side, self.body_named(&side.body)));
        let pairs = match (&seam.pairs, seam.reach) {
            (Some(pairs), _) => listed(pairs, [from.2, to.2])?,
            (None, Some(reach)) => {
                let [a, b] = [from, to].map(|(key, side, body)| chosen(key, side, body));
                nearest(from.2, a?, (to.2, b?), reach)?
            }
            (None, None) => {
                let [a, b] = [from, to].map(|(key, side, body)| chosen(key, side, body));
                let (a, b) = (a?, b?);
                if a.len() != b.len() {
                    let counts = format!("selects {} nodes, and from.select {}", b.len(), a.len());
                    let message = format!("{counts}; as many on both sides, pairs or reach would do");
                    return Err(SceneError::new("to.select", message));
                }
                a.into_iter().zip(b).map(|(a, b)| [a, b]).collect()
            }
        };
        match pairs.iter().find(|[a, b]| a == b) {
            None => Ok(pairs),
            Some([node, _]) => {
                let vertex = from.2.vertex_of_solver(*node as usize - from.2.first);
                let message =
                    format!("sews vertex {vertex} of body `{}` to itself; another one would do", from.2.name);
                Err(SceneError::new("", message))
            }
        }
    }

    /// A body by its name, which has been checked.
    fn body_named(&self, name: &str) -> &BodyAssembly {
        self.bodies.iter().find(|body| body.name == name).unwrap_or(&self.bodies[0])
    }
}

/// Pairs of vertices.
fn listed(pairs: &[[u32; 2]], bodies: [&BodyAssembly; 2]) -> Result<Vec<[u32; 2]>, SceneError> {
    let node = |index: usize, side: usize| {
        let (body, vertex) = (bodies[side], pairs[index][side] as usize);
        let refuse = |what: String| SceneError::new(format!("pairs[{index}][{side}]"), what);
        if vertex >= body.vertices() {
            let last = body.vertices() - 1;
            return Err(refuse(format!("is {vertex}, and body `{}` has vertices 0 to {last}", body.name)));
        }
        let node = body.node_of_vertex(vertex);
        let unused = || refuse(format!("is {vertex}, which no face uses; vertices of faces would do"));
        node.map(|node| body.solver_index(node) as u32).ok_or_else(unused)
    };
    (0..pairs.len()).map(|index| Ok([node(index, 0)?, node(index, 1)?])).collect()
}

/// Solver indices of the nodes of a side: as they are listed, or ascending by the user's. Without a selection: all.
fn chosen(key: &str, side: &SeamSide, body: &BodyAssembly) -> Result<Vec<u32>, SceneError> {
    let all = || Ok((0..body.nodes as u32).collect());
    let nodes = side.select.as_ref().map_or_else(all, |select| body.select_loaded(select));
    let nodes = nodes.map_err(|e| e.under(key))?;
    let in_order = |list: &Vec<u32>| -> Option<Vec<u32>> {
        list.iter().map(|&vertex| body.node_of_vertex(vertex as usize).map(|node| node as u32)).collect()
    };
    let listed = side.select.as_ref().and_then(|select| select.nodes.as_ref()).and_then(in_order);
    // Where other keys choose among those listed, their order is kept.
    let nodes = match listed {
        Some(listed) => listed.into_iter().filter(|node| nodes.binary_search(node).is_ok()).collect(),
        None => nodes,
    };
    Ok(nodes.into_iter().map(|node| body.solver_index(node as usize) as u32).collect())
}

/// Each node with the nearest other one within reach [m].
fn nearest(
    from: &BodyAssembly,
    nodes: Vec<u32>,
    (to, others): (&BodyAssembly, Vec<u32>),
    reach: f64,
) -> Result<Vec<[u32; 2]>, SceneError> {
    let place = |body: &BodyAssembly, node: u32| body.start[node as usize - body.first];
    let targets: Vec<[f64; 3]> = others.iter().map(|&node| place(to, node)).collect();
    let near = tethers::Near::new(&targets, reach);
    // Within a body every node is near its neighbours.
    let joined: HashSet<[u32; 2]> = if from.first == to.first {
        let all = from.surface_pieces().into_iter();
        all.map(|([a, b], _)| [a.min(b), a.max(b)].map(|node| node + from.first as u32)).collect()
    } else {
        HashSet::new()
    };
    let (mut pairs, mut seen) = (Vec::new(), HashSet::new());
    for node in nodes {
        let found = near.nearest(place(from, node), |other| {
            let other = others[other];
            other != node && !joined.contains(&[node.min(other), node.max(other)])
        });
        let pair = found.map(|other| [node, others[other]]);
        // Two nodes of one body that are each other's nearest are one pair.
        pairs.extend(pair.filter(|&[a, b]| seen.insert([a.min(b), a.max(b)])));
    }
    if pairs.is_empty() {
        let message = format!(
            "is {reach} m, and no node of `{}` is so near to one of `{}`{}; more would do",
            from.name,
            to.name,
            if joined.is_empty() { "" } else { " that is not its neighbour" }
        );
        return Err(SceneError::new("reach", message));
    }
    Ok(pairs)
}

/// Tethers of a body that has some.
fn tethers_of(body: &Body, built: &BodyAssembly) -> Result<Vec<Tether>, SceneError> {
    let Some(wish) = &body.tethers else { return Ok(Vec::new()) };
    let held: Vec<bool> = built.free.iter().map(|free| !free).collect();
    if !held.contains(&true) {
        let message = "lead to nodes that are held for good, and the body has none; [[body.pin]] would do, or leave them out";
        return Err(SceneError::new("tethers", message));
    }
    let ways = tethers::ways(&built.surface_pieces(), &held);
    let tether = |way: tethers::Way| Tether {
        node: (built.first + way.node as usize) as u32,
        anchor: (built.first + way.anchor as usize) as u32,
        length: way.length * (1.0 + wish.slack),
    };
    Ok(ways.into_iter().map(tether).collect())
}

impl BodyAssembly {
    /// Straight pieces of the surface at rest, by solver index within the body: edges, and what leads across one, laid flat.
    fn surface_pieces(&self) -> Vec<tethers::Piece> {
        match (self.grid_layout, &self.surface, &self.edges) {
            (Some(layout), ..) => self.grid_pieces(layout),
            (None, Some(surface), Some(edges)) => {
                let lengths = RestShape::of(surface, self.placement.factor).edge_lengths(edges);
                let length = |a: u32, b: u32| {
                    edges.pairs.binary_search(&[a.min(b), a.max(b)]).ok().map(|edge| lengths[edge])
                };
                let across = |[a, b, left, right]: [u32; 4]| {
                    let (to_left, to_right) =
                        ([length(a, left)?, length(b, left)?], [length(a, right)?, length(b, right)?]);
                    Some(([left, right], tethers::across(length(a, b)?, to_left, to_right)?))
                };
                let along = edges.pairs.iter().copied().zip(lengths.iter().copied());
                let all = along.chain(edges.hinges(&surface.triangles).into_iter().filter_map(across));
                all.map(|(pair, length)| (pair.map(|node| self.solver_local(node as usize) as u32), length))
                    .collect()
            }
            _ => Vec::new(),
        }
    }

    /// Of a grid, which is at rest as it starts.
    fn grid_pieces(&self, [rows, cols]: [usize; 2]) -> Vec<tethers::Piece> {
        let steps: [[i64; 2]; 4] = [[0, 1], [1, 0], [1, 1], [1, -1]];
        let mut pieces = Vec::with_capacity(4 * self.nodes);
        for (row, col) in (0..rows as i64).flat_map(|row| (0..cols as i64).map(move |col| (row, col))) {
            let there = |[down, right]: [i64; 2]| {
                let (row, col) = (row + down, col + right);
                let inside = row < rows as i64 && (0..cols as i64).contains(&col);
                inside.then_some((row * cols as i64 + col) as u32)
            };
            let here = (row * cols as i64 + col) as u32;
            let pairs = steps.into_iter().filter_map(there).map(|other| [here, other]);
            pieces.extend(pairs.map(|pair| (pair, measure::length(&self.start, pair))));
        }
        pieces
    }
}
