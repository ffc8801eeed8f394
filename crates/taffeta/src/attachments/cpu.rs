//! Joints and tethers on the CPU.
//!
//! Each node gathers its own. Both ends of a joint compute the same correction from the same numbers, and both decide
//! alike whether it breaks.

use crate::attachments::attach::{self, JointCorrection, PointState};
use crate::attachments::constraints::{IS_POINT, JointConstraint};
use crate::attachments::cpu_tethers::{Anchor, HoldBack, Tethered, Tethers, hold_back};
use crate::attachments::joints::{self, GroupJoint};
use crate::backend::SolverState;
use crate::contact::colliders::cpu::Colliders;
use crate::cpu::backend::Context;
use crate::cpu::cells::PerWorker;
use crate::cpu::feature::{Feature, Flow};
use crate::cpu::tile::Tile;
use crate::cpu::worker::Worker;
use crate::motion::pins::Motion;
use crate::real::{Real, add, scale, sub};
use crate::report::FrameSums;
use crate::step::Op;
use crate::topology::{Csr, LANES};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, Ordering};

/// Joints and tethers.
pub struct Attachments<T> {
    /// Nodes with joints or tethers, ascending; their numbers are those of the lists below.
    nodes: Vec<u32>,
    /// Joints of each of them, ascending.
    joints_of: Csr,
    /// Tethers of each of them.
    tethers_of: Csr,
    /// Those of them in each tile that have joints.
    of_tile: Csr,
    /// Tethers of those that have none.
    alone: Tethers<T>,
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
    broken: Vec<AtomicBool>,
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

/// A node that is moved, with its position and velocity afterwards.
type Response<T> = (u32, [T; 6]);

/// The scratch memory of a worker.
#[derive(Default)]
pub struct AttachScratch<T> {
    /// Nodes with joints that are moved, tile by tile, with their position and velocity afterwards.
    responses: Vec<Response<T>>,
    /// Where the responses of each tile end.
    ends: Vec<usize>,
    /// The anchors of a node.
    anchors: Vec<Anchor<T>>,
    /// The state of all anchors of nodes without joints.
    anchor_state: [Vec<T>; 6],
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
        let (with_joints, others): (Vec<_>, Vec<_>) = (0..)
            .zip(tiles)
            .flat_map(|(tile, plan)| plan.runs().map(move |(_, run)| (tile, run)))
            .flat_map(|(tile, run)| within(run).map(move |number| (tile, number)))
            .partition(|(_, number)| !all.joints_of.row(*number as usize).is_empty());
        let others = Csr::new(tiles.len(), others.into_iter());
        let tethers: Vec<(u32, T)> =
            all.tethers.iter().map(|one| (one.anchor, attach::radius(one.length))).collect();
        let tethered = |&number: &u32| -> Tethered<'_, T> {
            // Tethers are sorted by node.
            let of = match all.tethers_of.row(number as usize) {
                [first, .., last] => &tethers[*first as usize..=*last as usize],
                [only] => std::slice::from_ref(&tethers[*only as usize]),
                [] => &[],
            };
            (all.nodes[number as usize], of)
        };
        let by_tile = tiles.iter().enumerate().map(|(tile, plan)| {
            (plan.runs().map(|(_, run)| run).collect(), others.row(tile).iter().map(tethered).collect())
        });
        let alone = Tethers::new(by_tile);
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
            of_tile: Csr::new(tiles.len(), with_joints.into_iter()),
            alone,
            joints: all.joints.iter().zip(&group_of).map(joint).collect(),
            materials: (all.materials.iter())
                .map(|material| JointMaterial {
                    length: T::from_f64(material.length),
                    compliance: T::from_f64(material.compliance),
                    break_force: T::from_f64(material.break_force),
                })
                .collect(),
            points: all.points.iter().map(|point| (point.start.map(T::from_f64), point.track)).collect(),
            tethers,
            groups: all.groups.clone(),
            breaks: all.breaks(),
            broken: all.joints.iter().map(|_| AtomicBool::new(false)).collect(),
            scratch: PerWorker::new(context.workers(), |_| AttachScratch::default()),
            joints_of: all.joints_of.clone(),
            tethers_of: all.tethers_of.clone(),
            nodes,
        })
    }

    fn is_broken(&self, joint: usize) -> bool {
        self.broken[joint].load(Ordering::Relaxed)
    }

    /// Moves the nodes of a tile that have tethers and no joints. None of them is an anchor or has a joint, so nobody has read them.
    fn hold_alone(&self, tile: &mut Tile<'_, T>, anchors: &[Vec<T>; 6]) {
        let (nodes, h) = (tile.nodes, tile.substep.h);
        let mut left = self.alone.of_tile(tile.index);
        for (_, run) in tile.plan.runs() {
            let (groups, others) = left.split_at(left.partition_point(|group| group.first < run.end));
            left = others;
            if groups.is_empty() {
                continue;
            }
            let (mut after, mass) = (tile.after(&run), &nodes.inverse_mass[run.clone()]);
            let anchors = anchors.each_ref().map(|column| &column[..]);
            let (tethers, start, moved) = (&self.alone, run.start, tile.moved_nodes());
            let hold_back = |state, inverse_mass| {
                nodes.level.run(HoldBack { tethers, groups, start, state, inverse_mass, anchors, h, moved });
            };
            if run.len() >= LANES {
                hold_back(after, mass);
                continue;
            }
            let (mut few, mut few_masses) = ([[T::ZERO; LANES]; 6], [T::ZERO; LANES]);
            few_masses[..run.len()].copy_from_slice(mass);
            for (few, after) in few.iter_mut().zip(&after) {
                few[..run.len()].copy_from_slice(after);
            }
            hold_back(few.each_mut().map(|column| &mut column[..]), &few_masses);
            for (few, after) in few.iter().zip(&mut after) {
                after.copy_from_slice(&few[..run.len()]);
            }
        }
    }
}

impl<T: Real> Feature<T> for Attachments<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Attachments, Op::ApplyAttachments]
    }

    fn run(&self, _: Op, worker: &mut Worker<'_, T>) -> Flow {
        let scratch = &mut *self.scratch.of(worker.index);
        let (closing, motions) = (worker.substep.closing(), worker.substep.motions());
        let mut attach = AttachWorker { setup: self, scratch, worker, closing, motions };
        attach.respond();
        worker.synchronise();
        attach.note_broken();
        let scratch = &attach.scratch;
        worker.mark_moved(|tile| {
            let has_tethers = !self.alone.of_tile(tile).is_empty();
            has_tethers || !scratch.of_tile(tile - worker.tiles.start).is_empty()
        });
        Flow::Go
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        let scratch = self.scratch.read(tile.worker);
        let responses = scratch.of_tile(tile.number);
        tile.move_nodes(responses.iter().map(|&(node, state)| (node as usize, state)));
        self.hold_alone(tile, &scratch.anchor_state);
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        sums.broken = self.broken.iter_mut().map(|broken| u64::from(*broken.get_mut())).sum();
    }

    /// Whether each joint is whole; empty if none can break.
    fn save(&self, state: &mut SolverState) {
        let is_whole = |joint: usize| !self.is_broken(joint);
        state.joints = if self.breaks { (0..self.joints.len()).map(is_whole).collect() } else { Vec::new() };
    }

    fn load(&mut self, state: &SolverState) {
        for (index, broken) in self.broken.iter_mut().enumerate() {
            *broken.get_mut() = state.joints.get(index) == Some(&false);
        }
    }

    fn bytes(&self) -> usize {
        let lists = [&self.joints_of, &self.tethers_of, &self.of_tile, &self.groups];
        let words: usize = lists.iter().map(|list| list.offsets.len() + list.items.len()).sum();
        let joints = size_of_val(&self.joints[..]) + size_of_val(&self.tethers[..]);
        4 * (words + self.nodes.len()) + joints + self.alone.bytes() + size_of_val(&self.points[..])
    }
}

impl<T: Real> AttachScratch<T> {
    /// Nodes with joints of the worker's tile number `tile` that are moved, with their position and velocity afterwards.
    pub fn of_tile(&self, tile: usize) -> &[Response<T>] {
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
        // SAFETY: all have written their nodes before a barrier, and change them after another.
        let found = Found { state: self.worker.next().each_ref().map(|column| unsafe { column.read() }) };
        let AttachScratch { responses, ends, anchor_state, broken, solved, corrections, sums, .. } =
            &mut *self.scratch;
        for (anchors, column) in anchor_state.iter_mut().zip(found.state) {
            anchors.clear();
            anchors.extend(self.setup.alone.nodes.iter().map(|&node| column[node as usize]));
        }
        responses.clear();
        ends.clear();
        broken.clear();
        solved.clear();
        solved.resize(self.setup.groups.rows(), false);
        if !solved.is_empty() {
            corrections.resize(self.setup.joints.len(), JointCorrection::default());
            sums.resize(self.setup.nodes.len(), [T::ZERO; 3]);
        }
        let nodes = self.worker.nodes;
        for tile in self.worker.tiles.clone() {
            if !self.worker.resting.has(nodes.tiles[tile].body) {
                for &number in self.setup.of_tile.row(tile) {
                    self.move_joined(number, &found);
                }
            }
            self.scratch.ends.push(self.scratch.responses.len());
        }
    }

    /// A node with joints, and perhaps tethers.
    fn move_joined(&mut self, number: u32, found: &Found<'_, T>) {
        let node = self.setup.nodes[number as usize];
        let (before, mut after) = (found.node(node), self.joined(number, found));
        let tethers = self.setup.tethers_of.row(number as usize);
        if !tethers.is_empty() && self.worker.nodes.inverse_mass[node as usize] > T::ZERO {
            let anchor = |&tether: &u32| {
                let (anchor, length) = self.setup.tethers[tether as usize];
                (found.node(anchor), length)
            };
            self.scratch.anchors.clear();
            self.scratch.anchors.extend(tethers.iter().map(anchor));
            after = hold_back(after, &self.scratch.anchors, self.worker.substep.h);
        }
        if after != before {
            let ([x, y, z], [u, v, w]) = after;
            self.scratch.responses.push((node, [x, y, z, u, v, w]));
        }
    }

    /// A node after its joints.
    fn joined(&mut self, number: u32, found: &Found<'_, T>) -> PointState<T> {
        let (setup, h) = (self.setup, self.worker.substep.h);
        let node = setup.nodes[number as usize];
        let mut sum = [T::ZERO; 3];
        let indices = setup.joints_of.row(number as usize);
        for &index in indices.iter().filter(|&&index| !setup.is_broken(index as usize)) {
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
        for &index in indices.filter(|&&index| !self.setup.is_broken(index as usize)) {
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

    /// Marks broken joints, after all workers have found theirs.
    fn note_broken(&mut self) {
        let colliders = self.worker.features.get::<Colliders<T>>();
        for &index in &self.scratch.broken {
            // Only the worker of the first end notes this; all read it before the last barrier, and again after the sub-step's last.
            self.setup.broken[index as usize].store(true, Ordering::Relaxed);
            if let Some(colliders) = colliders {
                colliders.release(index);
            }
        }
    }
}
