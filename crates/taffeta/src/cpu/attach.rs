//! Joints and tethers: which node has which, what they do to it, and which are broken.
//!
//! Each node gathers its own: both ends of a joint find the same pull from the same numbers, and the same answer to the
//! question whether it breaks.

use super::shared::Shared;
use super::tiles::TilePlan;
use crate::assembly::{Assembly, IS_POINT, Row};
use crate::constraints::attach::{self, PointState, Pull, ROUNDS};
use crate::plan::Substep;
use crate::real::{Real, add, scale, sub};
use crate::topology::Csr;
use crate::topology::tethers::MOST;
use std::ops::Range;

/// What does not change.
pub struct AttachSetup<T> {
    /// Nodes with joints or tethers, ascending; their numbers are those of the lists below.
    nodes: Vec<u32>,
    /// Joints of each of them, ascending.
    rows_of: Csr,
    /// Tethers of each of them.
    tethers_of: Csr,
    /// Those of them in each tile.
    of_tile: Csr,
    joints: Vec<Joint<T>>,
    laws: Vec<Law<T>>,
    /// Where points start [m], and the track that they follow, if any.
    points: Vec<([T; 3], u32)>,
    /// Anchors, and how far nodes may be from them [m].
    tethers: Vec<(u32, T)>,
    /// Whether any joint may break.
    breaks: bool,
}

/// A joint in the backend's numbers.
struct Joint<T> {
    /// As of [`Row`].
    ends: [u32; 2],
    /// Their numbers among the nodes with joints; a point has that of the node.
    numbers: [u32; 2],
    start: T,
    law: u32,
}

/// How joints hold: length once closed [m], compliance [m/N], force at which they break [N].
struct Law<T> {
    length: T,
    compliance: T,
    break_force: T,
}

/// What is known from one sub-step to the next.
#[derive(Default)]
pub struct AttachWork {
    /// Whether each joint is broken.
    broken: Vec<bool>,
    /// Joints of each node that are not.
    joints: Vec<u32>,
}

/// The same, lent to all workers.
pub struct SharedAttach<'a> {
    broken: Shared<'a, bool>,
    joints: Shared<'a, u32>,
}

/// What a worker keeps for itself.
#[derive(Default)]
pub struct AttachScratch<T> {
    /// Nodes that are moved, tile by tile, with place and velocity after it.
    answers: Vec<(u32, [T; 6])>,
    /// Where the answers of each tile end.
    ends: Vec<usize>,
    /// Joints that break, each once.
    broken: Vec<u32>,
    /// Nodes that lose joints, and how many.
    fewer: Vec<(u32, u32)>,
}

impl<T: Real> AttachSetup<T> {
    /// The joints and tethers of a scene, if it has any.
    pub fn new(assembly: &Assembly, tiles: &[TilePlan]) -> Option<Self> {
        let all = &assembly.attachments;
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
        let joint = |&Row { ends: [a, b], start, law }: &Row| Joint {
            ends: [a, b],
            numbers: [number(a, a), number(b, a)],
            start: T::from_f64(start),
            law,
        };
        Some(Self {
            of_tile: Csr::new(tiles.len(), of_tile.into_iter()),
            joints: all.rows.iter().map(joint).collect(),
            laws: (all.laws.iter())
                .map(|law| Law {
                    length: T::from_f64(law.length),
                    compliance: T::from_f64(law.compliance),
                    break_force: T::from_f64(law.break_force),
                })
                .collect(),
            points: all.points.iter().map(|point| (point.start.map(T::from_f64), point.track)).collect(),
            tethers: all.tethers.iter().map(|one| (one.anchor, T::from_f64(one.length))).collect(),
            breaks: all.breaks(),
            rows_of: all.rows_of.clone(),
            tethers_of: all.tethers_of.clone(),
            nodes,
        })
    }

    /// Bytes that it takes.
    pub fn bytes(&self) -> usize {
        let lists = [&self.rows_of, &self.tethers_of, &self.of_tile];
        let words: usize = lists.iter().map(|list| list.offsets.len() + list.items.len()).sum();
        let joints = size_of_val(&self.joints[..]) + size_of_val(&self.tethers[..]);
        4 * (words + self.nodes.len()) + joints + size_of_val(&self.points[..])
    }
}

impl AttachWork {
    /// At the start nothing is broken.
    pub fn new<T>(setup: Option<&AttachSetup<T>>) -> Self {
        let mut work = Self::default();
        if let Some(setup) = setup {
            work.remember(setup, &[]);
        }
        work
    }

    /// Whether each joint is there; empty where none can break.
    pub fn remembered<T>(&self, setup: &AttachSetup<T>) -> Vec<bool> {
        if setup.breaks { self.broken.iter().map(|broken| !broken).collect() } else { Vec::new() }
    }

    /// Takes back what [`Self::remembered`] gave.
    pub fn remember<T>(&mut self, setup: &AttachSetup<T>, there: &[bool]) {
        self.broken = (0..setup.joints.len()).map(|row| there.get(row) == Some(&false)).collect();
        let left = |number: usize| {
            let rows = setup.rows_of.row(number).iter();
            rows.filter(|&&row| !self.broken[row as usize]).count() as u32
        };
        self.joints = (0..setup.nodes.len()).map(left).collect();
    }

    /// Number of broken joints.
    pub fn broken(&self) -> u64 {
        self.broken.iter().map(|&broken| u64::from(broken)).sum()
    }

    /// Lends it.
    pub fn share(&mut self) -> SharedAttach<'_> {
        SharedAttach { broken: Shared::new(&mut self.broken), joints: Shared::new(&mut self.joints) }
    }
}

impl<T: Real> AttachScratch<T> {
    /// Nodes of its tile number `tile` that are moved, with their place and velocity after it.
    pub fn answers(&self, tile: usize) -> &[(u32, [T; 6])] {
        let start = tile.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.answers[start..self.ends[tile]]
    }
}

/// A worker's part in what all do about joints and tethers.
pub struct AttachWorker<'a, T> {
    pub setup: &'a AttachSetup<T>,
    pub shared: &'a SharedAttach<'a>,
    pub scratch: &'a mut AttachScratch<T>,
    /// Its tiles.
    pub share: Range<usize>,
    /// State after the sub-step.
    pub next: &'a [Shared<'a, T>; 6],
    /// Inverse masses [1/kg].
    pub inverse_mass: &'a [T],
    pub substep: &'a Substep<T>,
}

/// What its nodes are found from, until the next barrier.
struct Found<'a, T> {
    state: [&'a [T]; 6],
    broken: &'a [bool],
    joints: &'a [u32],
}

impl<T: Real> Found<'_, T> {
    fn node(&self, node: u32) -> PointState<T> {
        let at = |axes: [usize; 3]| axes.map(|axis| self.state[axis][node as usize]);
        (at([0, 1, 2]), at([3, 4, 5]))
    }
}

impl<'a, T: Real> AttachWorker<'a, T> {
    /// Finds what becomes of its nodes.
    pub fn answer(&mut self) {
        // SAFETY: all have written their nodes, and what is broken, before a barrier, and change them after another.
        let found = unsafe {
            let state = self.next.each_ref().map(|column| column.read());
            Found { state, broken: self.shared.broken.read(), joints: self.shared.joints.read() }
        };
        let AttachScratch { answers, ends, broken, fewer } = &mut *self.scratch;
        answers.clear();
        ends.clear();
        broken.clear();
        fewer.clear();
        for tile in self.share.clone() {
            for &number in self.setup.of_tile.row(tile) {
                let before = found.node(self.setup.nodes[number as usize]);
                let joined = self.joined(number, &found);
                let after = self.held_near(number, joined, &found);
                if after != before {
                    let ([x, y, z], [u, v, w]) = after;
                    self.scratch.answers.push((self.setup.nodes[number as usize], [x, y, z, u, v, w]));
                }
            }
            self.scratch.ends.push(self.scratch.answers.len());
        }
    }

    /// A node after its joints.
    fn joined(&mut self, number: u32, found: &Found<'_, T>) -> PointState<T> {
        let (setup, h) = (self.setup, self.substep.h);
        let node = setup.nodes[number as usize];
        let (mut sum, mut lost) = ([T::ZERO; 3], 0);
        let rows = setup.rows_of.row(number as usize);
        for &row in rows.iter().filter(|&&row| !found.broken[row as usize]) {
            let joint = &setup.joints[row as usize];
            let pull = self.pull(joint, found);
            let first = joint.ends[0] == node;
            if pull.size / (h * h) > setup.laws[joint.law as usize].break_force {
                lost += 1;
                self.scratch.broken.extend(first.then_some(row));
            } else {
                sum = add(sum, scale(pull.shift, if first { T::ONE } else { -T::ONE }));
            }
        }
        self.scratch.fewer.extend((lost > 0).then_some((number, lost)));
        let w = self.inverse_mass[node as usize];
        let (x, v) = found.node(node);
        (add(x, scale(sum, w)), add(v, scale(sum, w / h)))
    }

    fn pull(&self, joint: &Joint<T>, found: &Found<'_, T>) -> Pull<T> {
        let (law, h) = (&self.setup.laws[joint.law as usize], self.substep.h);
        let [a, b] = joint.ends;
        let joints = joint.numbers.map(|number| found.joints[number as usize]);
        let (x, w) = if b & IS_POINT == 0 {
            (found.node(b).0, self.inverse_mass[b as usize])
        } else {
            (self.point(b ^ IS_POINT), T::ZERO)
        };
        let give = attach::give([self.inverse_mass[a as usize], w], joints);
        let length = attach::length(joint.start, law.length, self.substep.closing[joint.law as usize]);
        attach::pull(sub(found.node(a).0, x), length, give, law.compliance / (h * h))
    }

    /// Where a point is at the end of the sub-step.
    fn point(&self, point: u32) -> [T; 3] {
        let (start, track) = self.setup.points[point as usize];
        self.substep.motions.get(track as usize).map_or(start, |motion| motion.apply(start).0)
    }

    /// A node after its tethers. What they lead to is held, and stays where it is.
    fn held_near(&self, number: u32, from: PointState<T>, found: &Found<'_, T>) -> PointState<T> {
        let tethers = self.setup.tethers_of.row(number as usize);
        if self.inverse_mass[self.setup.nodes[number as usize] as usize] <= T::ZERO {
            return from;
        }
        let (mut x, mut shift, mut taut) = (from.0, [T::ZERO; 3], [false; MOST]);
        for _ in 0..ROUNDS {
            let mut moved = false;
            for (taut, &tether) in taut.iter_mut().zip(tethers) {
                let (anchor, length) = self.setup.tethers[tether as usize];
                if let Some((back, way)) = attach::put_back(x, found.node(anchor).0, length) {
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
        let v = attach::undone(from.1, shift, with, self.substep.h);
        (x, anchors().fold(v, |v, (at, with)| attach::taut(v, sub(x, at), with)))
    }

    /// Notes what has broken, when all have found that.
    pub fn note_broken(&mut self) {
        let AttachScratch { broken, fewer, .. } = &*self.scratch;
        for &row in broken {
            // SAFETY: only the worker of the first end notes this; all read it before the last barrier, and again after
            // the sub-step's last.
            unsafe { *self.shared.broken.item(row as usize) = true };
        }
        for &(number, lost) in fewer {
            // SAFETY: the node is in one worker's share; read as above.
            unsafe { *self.shared.joints.item(number as usize) -= lost };
        }
    }
}
