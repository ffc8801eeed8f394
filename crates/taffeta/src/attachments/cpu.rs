//! Joints and tethers on the CPU.
//!
//! Each node gathers its own. Both ends of a joint compute the same correction from the same numbers, and both decide
//! alike whether it breaks.

use crate::attachments::attach::{self, JointCorrection, PointState, ROUNDS};
use crate::attachments::constraints::{IS_POINT, JointConstraint};
use crate::attachments::joints::{self, GroupJoint};
use crate::attachments::tethers::MAX_TETHERS;
use crate::backend::SolverState;
use crate::contact::colliders::cpu::Colliders;
use crate::cpu::backend::Context;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::shared::{PerWorker, Shared};
use crate::cpu::tile::Tile;
use crate::cpu::worker::Worker;
use crate::motion::pins::Motion;
use crate::real::{Real, add, scale, sub};
use crate::report::FrameSums;
use crate::step::Op;
use crate::topology::Csr;
use std::ops::Range;

/// Joints and tethers.
pub struct Attachments<T> {
    /// Nodes with joints or tethers, ascending; their numbers are those of the lists below.
    nodes: Vec<u32>,
    /// Joints of each of them, ascending.
    joints_of: Csr,
    /// Tethers of each of them.
    tethers_of: Csr,
    /// Those of them in each tile.
    of_tile: Csr,
    joints: Vec<Joint<T>>,
    materials: Vec<JointMaterial<T>>,
    /// Where points start [m], and the track that they follow, if any.
    points: Vec<([T; 3], u32)>,
    /// Anchors, and how far nodes may be from them [m].
    tethers: Vec<(u32, T)>,
    /// Joints of each group that shares nodes.
    groups: Csr,
    /// Whether any joint may break.
    breaks: bool,
    /// Whether each joint is broken.
    broken: Shared<bool>,
    scratch: PerWorker<AttachScratch<T>>,
}

/// A joint in the backend's numbers.
struct Joint<T> {
    /// As of [`JointConstraint`].
    ends: [u32; 2],
    /// Their numbers among the nodes with joints; a point has that of the node.
    numbers: [u32; 2],
    /// The group that it belongs to, if any.
    group: Option<u32>,
    start: T,
    material: u32,
}

/// The material of joints: length once closed [m], compliance [m/N], force at which they break [N].
struct JointMaterial<T> {
    length: T,
    compliance: T,
    break_force: T,
}

/// The scratch memory of a worker.
#[derive(Default)]
pub struct AttachScratch<T> {
    /// Nodes that are moved, tile by tile, with their position and velocity afterwards.
    responses: Vec<(u32, [T; 6])>,
    /// Where the responses of each tile end.
    ends: Vec<usize>,
    /// Joints that break, each once.
    broken: Vec<u32>,
    /// Which groups have been solved, and the correction of each of their joints.
    solved: Vec<bool>,
    corrections: Vec<JointCorrection<T>>,
    /// Memory to solve a group: its joints, their numbers, and sums by node.
    group_joints: Vec<GroupJoint<T>>,
    members: Vec<u32>,
    sums: Vec<[T; 3]>,
}

impl<T: Real> Attachments<T> {
    /// The joints and tethers of a scene, if it has any.
    pub fn new(context: &Context<'_, T>) -> Option<Self> {
        let (all, tiles) = (context.assembly.attachments(), &context.nodes.tiles);
        if all.is_empty() {
            return None;
        }
        let nodes = all.nodes.clone();
        let within = |run: Range<usize>| {
            let [start, end] = [run.start, run.end].map(|at| nodes.partition_point(|&n| (n as usize) < at));
            start as u32..end as u32
        };
        let of_tile: Vec<(u32, u32)> = (0..)
            .zip(tiles)
            .flat_map(|(tile, plan)| plan.runs().map(move |(_, run)| (tile, run)))
            .flat_map(|(tile, run)| within(run).map(move |number| (tile, number)))
            .collect();
        let number = |end: u32, other: u32| {
            let node = if end & IS_POINT == 0 { end } else { other };
            nodes.binary_search(&node).unwrap_or_default() as u32
        };
        let mut group_of = vec![None; all.joints.len()];
        for group in 0..all.groups.rows() {
            all.groups.row(group).iter().for_each(|&index| group_of[index as usize] = Some(group as u32));
        }
        let joint = |(&JointConstraint { ends: [a, b], start, material }, &group): (
            &JointConstraint,
            &Option<u32>,
        )| Joint {
            ends: [a, b],
            numbers: [number(a, a), number(b, a)],
            group,
            start: T::from_f64(start),
            material,
        };
        Some(Self {
            of_tile: Csr::new(tiles.len(), of_tile.into_iter()),
            joints: all.joints.iter().zip(&group_of).map(joint).collect(),
            materials: (all.materials.iter())
                .map(|material| JointMaterial {
                    length: T::from_f64(material.length),
                    compliance: T::from_f64(material.compliance),
                    break_force: T::from_f64(material.break_force),
                })
                .collect(),
            points: all.points.iter().map(|point| (point.start.map(T::from_f64), point.track)).collect(),
            tethers: all.tethers.iter().map(|one| (one.anchor, T::from_f64(one.length))).collect(),
            groups: all.groups.clone(),
            breaks: all.breaks(),
            broken: vec![false; all.joints.len()].into(),
            scratch: PerWorker::new(context.workers(), |_| AttachScratch::default()),
            joints_of: all.joints_of.clone(),
            tethers_of: all.tethers_of.clone(),
            nodes,
        })
    }
}

impl<T: Real> Feature<T> for Attachments<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Attachments, Op::ApplyAttachments]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        // SAFETY: each worker has its own.
        let scratch = unsafe { self.scratch.of(worker.index) };
        let (closing, motions) = (worker.substep.closing(), worker.substep.motions());
        let mut attach = AttachWorker { setup: self, scratch, worker, closing, motions };
        attach.respond();
        worker.synchronise();
        attach.note_broken();
        let scratch = &attach.scratch;
        worker.mark_moved(|tile| !scratch.responses(tile - worker.tiles.start).is_empty());
        Flow::Go
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        // SAFETY: as in `run`.
        let responses = unsafe { self.scratch.of(tile.worker) }.responses(tile.number);
        tile.move_nodes(responses.iter().map(|(node, state)| (*node as usize, state)));
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        sums.broken = self.broken.get_mut().iter().map(|&broken| u64::from(broken)).sum();
    }

    /// Whether each joint is whole; empty if none can break.
    fn save(&self, state: &mut SolverState) {
        // SAFETY: no worker works between frames.
        let broken = unsafe { self.broken.read() };
        state.joints = if self.breaks { broken.iter().map(|broken| !broken).collect() } else { Vec::new() };
    }

    fn load(&mut self, state: &SolverState) {
        for (index, broken) in self.broken.get_mut().iter_mut().enumerate() {
            *broken = state.joints.get(index) == Some(&false);
        }
    }

    fn bytes(&self) -> usize {
        let lists = [&self.joints_of, &self.tethers_of, &self.of_tile, &self.groups];
        let words: usize = lists.iter().map(|list| list.offsets.len() + list.items.len()).sum();
        let joints = size_of_val(&self.joints[..]) + size_of_val(&self.tethers[..]);
        4 * (words + self.nodes.len()) + joints + size_of_val(&self.points[..])
    }
}

impl<T: Real> AttachScratch<T> {
    /// Nodes of the worker's tile number `tile` that are moved, with their position and velocity afterwards.
    pub fn responses(&self, tile: usize) -> &[(u32, [T; 6])] {
        let start = tile.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.responses[start..self.ends[tile]]
    }
}

/// A worker's part of the data.
struct AttachWorker<'w, 'a, T> {
    setup: &'w Attachments<T>,
    scratch: &'w mut AttachScratch<T>,
    worker: &'w Worker<'a, T>,
    /// How far each material has closed, and the motion of each track.
    closing: &'a [T],
    motions: &'a [Motion<T>],
}

/// The state that corrections are computed from, until the next barrier.
struct Found<'a, T> {
    state: [&'a [T]; 6],
    broken: &'a [bool],
}

impl<T: Real> Found<'_, T> {
    fn node(&self, node: u32) -> PointState<T> {
        let at = |axes: [usize; 3]| axes.map(|axis| self.state[axis][node as usize]);
        (at([0, 1, 2]), at([3, 4, 5]))
    }
}

impl<T: Real> AttachWorker<'_, '_, T> {
    /// Computes the corrections of its nodes.
    pub fn respond(&mut self) {
        // SAFETY: all have written their nodes, and what is broken, before a barrier, and change them after another.
        let found = unsafe {
            let state = self.worker.next().each_ref().map(|column| column.read());
            Found { state, broken: self.setup.broken.read() }
        };
        let AttachScratch { responses, ends, broken, solved, corrections, sums, .. } = &mut *self.scratch;
        responses.clear();
        ends.clear();
        broken.clear();
        solved.clear();
        solved.resize(self.setup.groups.rows(), false);
        if !solved.is_empty() {
            corrections.resize(self.setup.joints.len(), JointCorrection::default());
            sums.resize(self.setup.nodes.len(), [T::ZERO; 3]);
        }
        for tile in self.worker.tiles.clone() {
            for &number in self.setup.of_tile.row(tile) {
                if self.is_slack(number, &found) {
                    continue;
                }
                let before = found.node(self.setup.nodes[number as usize]);
                let joined = self.joined(number, &found);
                let after = self.apply_tethers(number, joined, &found);
                if after != before {
                    let ([x, y, z], [u, v, w]) = after;
                    self.scratch.responses.push((self.setup.nodes[number as usize], [x, y, z, u, v, w]));
                }
            }
            self.scratch.ends.push(self.scratch.responses.len());
        }
    }

    /// Whether a node has no joints, and no tether holds it back: most of the time that is so of most nodes.
    #[inline(always)]
    fn is_slack(&self, number: u32, found: &Found<'_, T>) -> bool {
        let (setup, number) = (self.setup, number as usize);
        let at = |node: u32| [0, 1, 2].map(|axis| found.state[axis][node as usize]);
        let x = at(setup.nodes[number]);
        setup.joints_of.row(number).is_empty()
            && setup.tethers_of.row(number).iter().all(|&tether| {
                let (anchor, length) = setup.tethers[tether as usize];
                attach::is_within(x, at(anchor), length)
            })
    }

    /// A node after its joints.
    fn joined(&mut self, number: u32, found: &Found<'_, T>) -> PointState<T> {
        let (setup, h) = (self.setup, self.worker.substep.h);
        let node = setup.nodes[number as usize];
        let mut sum = [T::ZERO; 3];
        let indices = setup.joints_of.row(number as usize);
        for &index in indices.iter().filter(|&&index| !found.broken[index as usize]) {
            let joint = &setup.joints[index as usize];
            let correction = match joint.group {
                Some(group) => {
                    self.solve(group as usize, found);
                    self.scratch.corrections[index as usize]
                }
                None => self.solve_alone(joint, found),
            };
            let first = joint.ends[0] == node;
            if attach::breaks(&correction, h, setup.materials[joint.material as usize].break_force) {
                self.scratch.broken.extend(first.then_some(index));
            } else {
                sum = add(sum, scale(correction.shift, if first { T::ONE } else { -T::ONE }));
            }
        }
        let w = self.worker.nodes.inverse_mass[node as usize];
        let (x, v) = found.node(node);
        (add(x, scale(sum, w)), add(v, scale(sum, w / h)))
    }

    fn solve_alone(&self, joint: &Joint<T>, found: &Found<'_, T>) -> JointCorrection<T> {
        let (d, [v, w], length, softness) = self.gap(joint, found);
        attach::solve_joint(d, length, v + w, softness)
    }

    /// The distance vector of a joint, the inverse masses of its ends, its present length, and its softness.
    fn gap(&self, joint: &Joint<T>, found: &Found<'_, T>) -> ([T; 3], [T; 2], T, T) {
        let (material, h) = (&self.setup.materials[joint.material as usize], self.worker.substep.h);
        let [a, b] = joint.ends;
        let (x, w) = if b & IS_POINT == 0 {
            (found.node(b).0, self.worker.nodes.inverse_mass[b as usize])
        } else {
            (self.point(b ^ IS_POINT), T::ZERO)
        };
        let length = attach::length(joint.start, material.length, self.closing[joint.material as usize]);
        let d = sub(found.node(a).0, x);
        (d, [self.worker.nodes.inverse_mass[a as usize], w], length, attach::softness(material.compliance, h))
    }

    /// Solves a group, unless this worker has solved it in this sub-step. All workers with one of its nodes find the
    /// same.
    fn solve(&mut self, group: usize, found: &Found<'_, T>) {
        if std::mem::replace(&mut self.scratch.solved[group], true) {
            return;
        }
        self.scratch.group_joints.clear();
        self.scratch.members.clear();
        let indices = self.setup.groups.row(group).iter();
        for &index in indices.filter(|&&index| !found.broken[index as usize]) {
            let joint = &self.setup.joints[index as usize];
            let (d, masses, length, softness) = self.gap(joint, found);
            self.scratch.corrections[index as usize] = JointCorrection::default();
            let numbers = joint.numbers.map(|number| number as usize);
            let lengths = [length, self.setup.materials[joint.material as usize].length];
            if let Some(joint) = GroupJoint::new(numbers, masses, d, lengths, softness) {
                self.scratch.group_joints.push(joint);
                self.scratch.members.push(index);
            }
        }
        let AttachScratch { group_joints, members, sums, corrections, .. } = &mut *self.scratch;
        joints::solve(group_joints, sums);
        for (joint, &index) in group_joints.iter().zip(&*members) {
            corrections[index as usize] = joint.correction();
        }
    }

    /// The position of a point at the end of the sub-step.
    fn point(&self, point: u32) -> [T; 3] {
        let (start, track) = self.setup.points[point as usize];
        self.motions.get(track as usize).map_or(start, |motion| motion.apply(start).0)
    }

    /// A node after its tethers. Their anchors are pinned, and stay where they are.
    fn apply_tethers(&self, number: u32, from: PointState<T>, found: &Found<'_, T>) -> PointState<T> {
        let tethers = self.setup.tethers_of.row(number as usize);
        if self.worker.nodes.inverse_mass[self.setup.nodes[number as usize] as usize] <= T::ZERO {
            return from;
        }
        let (mut x, mut shift, mut taut) = (from.0, [T::ZERO; 3], [false; MAX_TETHERS]);
        for _ in 0..ROUNDS {
            let mut moved = false;
            for (taut, &tether) in taut.iter_mut().zip(tethers) {
                let (anchor, length) = self.setup.tethers[tether as usize];
                if let Some((back, way)) = attach::project_to_sphere(x, found.node(anchor).0, length) {
                    (x, shift, moved, *taut) = (back, add(shift, way), true, true);
                }
            }
            if !moved || tethers.len() == 1 {
                break;
            }
        }
        let taut = || tethers.iter().zip(taut).filter(|(_, taut)| *taut);
        let anchors = || taut().map(|(&tether, _)| found.node(self.setup.tethers[tether as usize].0));
        let count = T::from_f64(anchors().count() as f64);
        if count <= T::ZERO {
            return from;
        }
        let with = anchors().fold([T::ZERO; 3], |sum, (_, v)| add(sum, v)).map(|sum| sum / count);
        let v = attach::without_lost_motion(from.1, shift, with, self.worker.substep.h);
        (x, anchors().fold(v, |v, (at, with)| attach::without_stretching(v, sub(x, at), with)))
    }

    /// Marks broken joints, after all workers have found theirs.
    fn note_broken(&mut self) {
        let colliders = self.worker.features.get::<Colliders<T>>();
        for &index in &self.scratch.broken {
            // SAFETY: only the worker of the first end notes this; all read it before the last barrier, and again after
            // the sub-step's last.
            unsafe {
                *self.setup.broken.item(index as usize) = true;
                if let Some(colliders) = colliders {
                    colliders.set_released(index, true);
                }
            }
        }
    }
}
