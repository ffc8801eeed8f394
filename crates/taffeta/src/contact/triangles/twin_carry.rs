//! What is in the way of colliders, as rows compare it: carry.wgsl one number after the other.

use crate::contact::triangles::carry::{PUSHES, Phase, farther, go_on};
use crate::contact::triangles::closest::{EdgeEdge, VertexTriangle};
use crate::contact::triangles::filter::{limits, push_apart};
use crate::contact::triangles::gpu_layout as layout;
use crate::contact::triangles::tangle::Rule;
use crate::contact::triangles::twin::Twin;
use crate::contact::triangles::twin_find::{Four3, closest, relative};
use crate::real::{add, dot, scale, sub};

/// A component of a push by the number that kernels compare.
fn way_of(key: u32) -> f32 {
    if key & 1 == 1 { f32::from_bits(key >> 1) } else { -f32::from_bits(key >> 1) }
}

fn key_of(way: f32) -> u32 {
    way.abs().to_bits() << 1 | u32::from(way > 0.0)
}

impl Twin {
    /// What was sent to a node, by the number that kernels compare: a component of a push, or what is left of 1 when it stops.
    pub fn sent(&self, key: u32) -> f32 {
        match self.phase() {
            Phase::Stop => 1.0 - f32::from_bits(1_f32.to_bits().wrapping_sub(key)),
            _ => way_of(key),
        }
    }

    /// Where a corner of a collider is at both ends of the sub-step.
    pub fn corner_ends(&self, place: usize) -> [[f32; 3]; 2] {
        let corners = self.corners.corners.len() / 2;
        [0, corners].map(|first| {
            let [x, y, z, _] = self.corners.corners[first + place - self.nodes()];
            [x, y, z]
        })
    }

    pub fn measure_places(&mut self) {
        let places = (0..self.table(layout::ALL_PLACES)).filter(|&place| self.has_surface(place));
        let far =
            places.flat_map(|place| self.place(layout::BEFORE, place)).fold(0.0, |far, x| x.abs().max(far));
        self.work[layout::FARTHEST_PLACE] = self.work[layout::FARTHEST_PLACE].max(f32::to_bits(far));
    }

    pub fn advance_corners(&mut self) {
        let (part, parts) = (self.work[layout::CORNER_PART] - 1, self.corners.parts);
        for place in self.surface_nodes() {
            let x = self.place(if part > 0 { layout::AFTER } else { layout::BEFORE }, place);
            self.put(layout::BEFORE, place, x);
            self.put(layout::AFTER, place, x);
            self.put(layout::TARGET, place, [0.0; 3]);
            for axis in 0..3 {
                let at = self.list(axis) + place;
                self.work[at] = 0;
            }
        }
        for place in self.nodes()..self.table(layout::ALL_PLACES) {
            let [start, end] = self.corner_ends(place);
            for (array, part) in [(layout::BEFORE, part), (layout::AFTER, part + 1)] {
                let way = scale(sub(end, start), part as f32 / parts as f32);
                self.put(array, place, if part < parts { add(start, way) } else { end });
            }
        }
    }

    pub fn push_nodes(&mut self) {
        let mut pushes = vec![[0.0; 3]; self.nodes()];
        let far = self.number(layout::FARTHEST_PLACE);
        let phase = self.phase();
        let squeezed = phase == Phase::Squeeze;
        let together = (self.work[layout::PUSH_ROUND] as usize) + 1 < PUSHES;
        if phase == Phase::Restart {
            return;
        }
        for at in 0..self.work[layout::PAIRS] as usize {
            for (one, nodes, thickness) in self.touching(self.pairs[at]) {
                if self.rule(nodes, one.first) != Rule::Apart {
                    continue;
                }
                let [x, ends] =
                    [layout::BEFORE, layout::AFTER].map(|array| nodes.map(|node| self.place(array, node)));
                let moves: Four3 = std::array::from_fn(|i| sub(ends[i], x[i]));
                let x = relative(x);
                let found = closest(x, one.first);
                let size = (thickness, far);
                if phase == Phase::Stop {
                    let parts = match one.first {
                        1 => limits::<f32, VertexTriangle>(x, moves, found.apart, size, together).parts,
                        _ => limits::<f32, EdgeEdge>(x, moves, found.apart, size, together).parts,
                    };
                    if nodes.iter().all(|&node| node < self.nodes()) {
                        self.stop(nodes, parts);
                    }
                    continue;
                }
                let push = match one.first {
                    1 => push_apart::<f32, VertexTriangle>(x, moves, found.apart, size, squeezed),
                    _ => push_apart::<f32, EdgeEdge>(x, moves, found.apart, size, squeezed),
                };
                let Some(push) = push.filter(|_| moves != [[0.0; 3]; 4]) else { continue };
                let moved = |i: usize| scale(moves[i], found.weights[i]);
                let first = (0..one.first).map(moved).fold([0.0; 3], add);
                let second = (one.first..4).map(moved).fold([0.0; 3], sub);
                let first_drives = nodes[0] >= self.nodes()
                    || nodes[3] < self.nodes() && -dot(first, found.apart) > dot(second, found.apart);
                let (pushed, push) = if first_drives {
                    (one.first..4, push.map(|along| -along))
                } else {
                    (0..one.first, push)
                };
                let is_free = |node: usize| self.position[node][3] > 0.0;
                for node in pushed.clone().map(|i| nodes[i]).filter(|&node| is_free(node)) {
                    pushes[node] = farther(pushes[node], push);
                }
                if pushed.clone().all(|i| is_free(nodes[i])) {
                    let last = pushed.map(|i| nodes[i] as u32).max().unwrap_or_default();
                    self.work[layout::WAITING] = self.work[layout::WAITING].max(last + 1);
                }
            }
        }
        for (node, push) in pushes.into_iter().enumerate() {
            for (axis, push) in push.into_iter().enumerate() {
                let at = self.list(axis) + node;
                self.work[at] = self.work[at].max(key_of(push));
            }
        }
    }

    /// Notes what part of their way the nodes of a pair may make.
    fn stop(&mut self, nodes: [usize; 4], parts: [f32; 4]) {
        for (node, part) in nodes.into_iter().zip(parts) {
            let at = self.list(0) + node;
            self.work[at] = self.work[at].max(1_f32.to_bits() - part.to_bits());
        }
    }

    pub fn take_pushes(&mut self) {
        let phase = self.phase();
        for place in self.surface_nodes() {
            let sent = [0, 1, 2].map(|axis| {
                let at = self.list(axis) + place;
                std::mem::take(&mut self.work[at])
            });
            let push = sent.map(way_of);
            let way = self.place(layout::TARGET, place);
            let new = match phase {
                Phase::Restart => [0.0; 3],
                Phase::Stop => scale(way, f32::from_bits(1_f32.to_bits() - sent[0])),
                _ => go_on(way, push, self.corners.longest_push),
            };
            let moved = match phase {
                Phase::Restart => false,
                Phase::Stop => sent[0] != 0,
                _ => new != way,
            };
            self.work[layout::PUSHED] |= u32::from(moved);
            self.put(layout::TARGET, place, new);
            self.put(layout::AFTER, place, add(self.place(layout::BEFORE, place), new));
        }
    }
}
