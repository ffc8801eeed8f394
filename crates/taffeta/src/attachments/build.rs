//! Seams, breakable pins and tethers of a scene.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::attachments::constraints::{Attachments, IS_POINT, JointConstraint, JointMaterial, Tether};
use crate::attachments::tethers;
use crate::motion::keyframes::Track;
use crate::motion::moving::MovingPins;
use crate::scene::{Body, Scene, SceneError, Seam, SeamSide};
use crate::topology::{RestShape, measure};
use std::collections::{HashMap, HashSet};

impl Assembly {
    /// Adds seams and tethers. All bodies are there, and none of their pins has moved.
    pub(crate) fn attach(&mut self, scene: &Scene) -> Result<(), SceneError> {
        let pins = std::mem::take(self.attachments_mut());
        let (mut all, mut sewn) = (Attachments::default(), HashMap::new());
        for (index, seam) in scene.seams.iter().enumerate() {
            let material = all.materials.len() as u32;
            let path = format!("seam[{index}]");
            let pairs = self.sewn(seam).map_err(|e| e.under(&path))?;
            for &[a, b] in &pairs {
                if let Some(before) = sewn.insert([a.min(b), a.max(b)], index) {
                    return Err(SceneError::new(path, self.paired_twice([a, b], (before, index))));
                }
            }
            all.materials.push(JointMaterial {
                length: seam.length,
                close: [seam.close.start, seam.close.end],
                compliance: seam.k.map_or(0.0, |k| 1.0 / k),
                break_force: seam.break_force.unwrap_or(f64::INFINITY),
            });
            let joint =
                |[a, b]: [u32; 2]| JointConstraint { ends: [a.min(b), a.max(b)], start: 0.0, material };
            all.joints.extend(pairs.into_iter().map(joint));
        }
        all.seams = all.materials.len();
        let seams = all.seams as u32;
        all.materials.extend(pins.materials);
        all.points = pins.points;
        all.exclusions = self.seam_exclusions(&all);
        all.held = self.leave_out_held(&mut all.joints, all.seams);
        all.joints.extend(
            pins.joints
                .into_iter()
                .map(|joint| JointConstraint { material: joint.material + seams, ..joint }),
        );
        for (index, (body, built)) in scene.bodies.iter().zip(&self.bodies).enumerate() {
            let found = tethers_of(body, built).map_err(|e| e.under(&format!("body[{index}]")))?;
            all.tethers.extend(found);
        }
        all.list(|node| self.is_free(node));
        self.extensions.insert(all);
        Ok(())
    }

    /// The message for two nodes that are sewn to each other more than once.
    fn paired_twice(&self, pair: [u32; 2], (before, index): (usize, usize)) -> String {
        let [a, b] = pair.map(|node| {
            let body = self.body_of(node);
            format!("vertex {} of body `{}`", body.vertex_of_solver(node as usize - body.first), body.name)
        });
        let where_else = if before == index { "twice".to_owned() } else { format!("as seam[{before}] does") };
        format!("sews {a} to {b} {where_else}; once would do, or twice the k and break_force")
    }

    /// Removes joints of two pinned nodes, which nothing can close. Returns how many each seam had.
    fn leave_out_held(&self, joints: &mut Vec<JointConstraint>, seams: usize) -> Vec<usize> {
        let mut held = vec![0; seams];
        joints.retain(|joint| {
            let moves = joint.ends.iter().any(|&node| self.is_free(node));
            held[joint.material as usize] += usize::from(!moves);
            moves
        });
        held
    }

    /// The body of a node, given by its solver index.
    fn body_of(&self, node: u32) -> &BodyAssembly {
        &self.bodies[self.number_of_body(node)]
    }

    /// Whether no permanent pin holds a node.
    fn is_free(&self, node: u32) -> bool {
        let body = self.body_of(node);
        body.free[node as usize - body.first]
    }

    /// Sewn nodes, and each with the neighbours of the other, if both bodies collide with themselves.
    fn seam_exclusions(&self, all: &Attachments) -> Vec<[u32; 2]> {
        let body = |node: u32| self.body_of(node);
        let mut exclusions = Vec::new();
        for [a, b] in all.joined() {
            let (Some(of_a), Some(of_b)) = (&body(a).self_contact(), &body(b).self_contact()) else {
                continue;
            };
            exclusions.push([a, b]);
            for (node, other, self_contact) in [(a, b, of_b), (b, a, of_a)] {
                let home = body(other);
                self_contact.exclusions.each(home.grid_layout, other as usize - home.first, |near| {
                    exclusions.push([node, (home.first + near) as u32]);
                });
            }
        }
        exclusions.retain(|[a, b]| a != b);
        exclusions.extend(exclusions.clone().into_iter().map(|[a, b]| [b, a]));
        exclusions.sort_unstable();
        exclusions.dedup();
        exclusions
    }

    /// Sets the starting lengths of joints, when pins are where their motion starts.
    pub(crate) fn measure_seams(&mut self) {
        let Self { bodies, extensions, .. } = self;
        let attachments: &mut Attachments = extensions.get_mut();
        let place = |node: u32| {
            let body = &bodies[bodies.partition_point(|body| body.first <= node as usize) - 1];
            body.start[node as usize - body.first]
        };
        for joint in &mut attachments.joints {
            let [a, b] = joint.ends;
            if b & IS_POINT == 0 {
                joint.start = crate::real::norm(crate::real::sub(place(a), place(b)));
            }
        }
    }

    /// Moves nodes of breakable pins to where the pin's motion starts.
    pub(crate) fn start_points(&mut self) {
        let Self { bodies, extensions, .. } = self;
        let Some(attachments) = extensions.get::<Attachments>() else { return };
        let tracks = extensions.get::<MovingPins>().map_or(&[][..], |moving| &moving.tracks);
        for joint in attachments.joints.iter().filter(|joint| joint.ends[1] & IS_POINT != 0) {
            let (node, point) =
                (joint.ends[0] as usize, attachments.points[(joint.ends[1] ^ IS_POINT) as usize]);
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

/// Pairs each node with the nearest other one within reach [m].
fn nearest(
    from: &BodyAssembly,
    nodes: Vec<u32>,
    (to, others): (&BodyAssembly, Vec<u32>),
    reach: f64,
) -> Result<Vec<[u32; 2]>, SceneError> {
    let place = |body: &BodyAssembly, node: u32| body.start[node as usize - body.first];
    let targets: Vec<[f64; 3]> = others.iter().map(|&node| place(to, node)).collect();
    let near = tethers::PlacesByCell::new(&targets, reach);
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
        let message =
            "need nodes that are pinned for good, and the body has none; a pin would do, or leave them out";
        return Err(SceneError::new("tethers", message));
    }
    let mut paths = tethers::geodesic_paths(&built.surface_pieces(), &held);
    // By anchor, so that the tethers of neighbours that have the same number mostly have the same anchor.
    paths.sort_by_key(|path| (path.node, path.anchor));
    let tether = |way: tethers::GeodesicPath| Tether {
        node: (built.first + way.node as usize) as u32,
        anchor: (built.first + way.anchor as usize) as u32,
        length: way.length * (1.0 + wish.slack),
    };
    Ok(paths.into_iter().map(tether).collect())
}

impl BodyAssembly {
    /// Straight pieces of the surface at rest, by solver index within the body: edges, and lines across an edge,
    /// unfolded.
    pub(crate) fn surface_pieces(&self) -> Vec<tethers::Edge> {
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
    fn grid_pieces(&self, [joints, cols]: [usize; 2]) -> Vec<tethers::Edge> {
        let steps: [[i64; 2]; 4] = [[0, 1], [1, 0], [1, 1], [1, -1]];
        let mut pieces = Vec::with_capacity(4 * self.nodes);
        for (joint, col) in (0..joints as i64).flat_map(|joint| (0..cols as i64).map(move |col| (joint, col)))
        {
            let there = |[down, right]: [i64; 2]| {
                let (joint, col) = (joint + down, col + right);
                let inside = joint < joints as i64 && (0..cols as i64).contains(&col);
                inside.then_some((joint * cols as i64 + col) as u32)
            };
            let here = (joint * cols as i64 + col) as u32;
            let pairs = steps.into_iter().filter_map(there).map(|other| [here, other]);
            pieces.extend(pairs.map(|pair| (pair, measure::length(&self.start, pair))));
        }
        pieces
    }
}
