//! Joints and tethers of a scene.

use crate::assembly::Assembly;
use crate::plan::Substep;
use crate::real::Real;
use crate::topology::Csr;
use crate::topology::sets::Sets;

/// Marks the second end of a joint as a point, whose number is in the other bits.
pub const IS_POINT: u32 = 1 << 31;

/// Joints and tethers. They are a function of the scene alone.
#[derive(Clone, Debug, Default)]
pub struct Attachments {
    /// Joints: those of seams in the scene's order, then those of pins that break, body by body.
    pub joints: Vec<JointConstraint>,
    /// Materials of joints: one for each seam, then one for each breakable pin.
    pub materials: Vec<JointMaterial>,
    /// Number of seams.
    pub seams: usize,
    /// Pairs of each seam that are left out because both nodes are pinned for good.
    pub held: Vec<usize>,
    /// The points of breakable pins.
    pub points: Vec<Point>,
    /// Tethers, ascending by node, then by anchor.
    pub tethers: Vec<Tether>,
    /// Nodes with joints or tethers, ascending by solver index.
    pub nodes: Vec<u32>,
    /// Joints of each of `nodes`, ascending.
    pub joints_of: Csr,
    /// Tethers of each of `nodes`.
    pub tethers_of: Csr,
    /// Joints of each group of two or more that share free nodes, ascending.
    pub groups: Csr,
    /// Nodes that do not collide because a seam makes them neighbours, in both orders, ascending.
    pub(crate) exclusions: Vec<[u32; 2]>,
}

impl Assembly {
    /// Nodes that are joined to others or to points, or held near others.
    pub fn attachments(&self) -> &Attachments {
        self.extensions.get().expect("a scene is assembled with attachments, or with a list of none")
    }

    /// For each place the least of those that stand for the same point: nodes that rigid seams bring to one place.
    pub(crate) fn points(&self) -> Vec<u32> {
        let (all, mut sets) = (self.attachments(), Sets::new(self.places));
        for joint in all.joints.iter().filter(|joint| joint.ends[1] & IS_POINT == 0) {
            if all.materials[joint.material as usize].is_tight() {
                sets.join(joint.ends[0], joint.ends[1]);
            }
        }
        sets.all()
    }

    pub(crate) fn attachments_mut(&mut self) -> &mut Attachments {
        self.extensions.get_mut()
    }
}

/// Fraction of its closing of each material at the end of a sub-step.
pub struct Closing<T>(pub Vec<T>);

/// How far seams have closed in a sub-step.
pub fn parameters<T: Real>(assembly: &Assembly, [t, h]: [f64; 2], substep: &mut Substep<T>) {
    let materials = assembly.attachments().materials.iter();
    if materials.len() == 0 {
        return;
    }
    let fractions = materials.map(|material| T::from_f64(material.closed_fraction(t + h)));
    substep.extensions.insert(Closing(fractions.collect()));
}

impl<T: Real> Substep<T> {
    /// Fraction of its closing of each material of [`Assembly::attachments`] at its end.
    pub fn closing(&self) -> &[T] {
        self.extensions.get::<Closing<T>>().map_or(&[], |closing| &closing.0)
    }
}

/// A joint.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointConstraint {
    /// Solver indices, ascending; or one, and a point with [`IS_POINT`].
    pub ends: [u32; 2],
    /// Distance at the start [m].
    pub start: f64,
    /// Number of its material.
    pub material: u32,
}

/// The material of joints.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointMaterial {
    /// Distance once closed [m].
    pub length: f64,
    /// When closing begins and ends [s]. If both are the same, it is closed.
    pub close: [f64; 2],
    /// Compliance [m/N]; 0: rigid.
    pub compliance: f64,
    /// Force at which it breaks [N]; infinite: never.
    pub break_force: f64,
}

/// The point of a breakable pin.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Point {
    /// Where it starts, before any motion [m].
    pub start: [f64; 3],
    /// Which of the scene's tracks it follows; `u32::MAX`: none.
    pub track: u32,
    /// Whether a collider carries it. Colliders ignore its node until it breaks.
    pub carried: bool,
}

/// A tether: a node, and the pinned node that it must stay near.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Tether {
    /// Solver index.
    pub node: u32,
    /// Solver index of the pinned node.
    pub anchor: u32,
    /// Largest distance [m].
    pub length: f64,
}

impl JointMaterial {
    /// Whether it brings its nodes to one place.
    pub fn is_tight(&self) -> bool {
        self.length == 0.0 && self.compliance == 0.0
    }

    /// Fraction of its closing at time `t` [s].
    pub fn closed_fraction(&self, t: f64) -> f64 {
        let [start, end] = self.close;
        if end > start { ((t - start) / (end - start)).clamp(0.0, 1.0) } else { 1.0 }
    }
}

impl Attachments {
    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.nodes.is_empty()
    }

    /// Whether any joint may break.
    pub fn breaks(&self) -> bool {
        self.materials.iter().any(|material| material.break_force < f64::INFINITY)
    }

    /// Whether a joint holds a node at a point that a collider carries.
    pub fn is_carried(&self, joint: &JointConstraint) -> bool {
        let end = joint.ends[1];
        end & IS_POINT != 0 && self.points[(end ^ IS_POINT) as usize].carried
    }

    /// Calls `sink` with each node of joints that change over a span of time [s]: those that close, and those to points of which
    /// `follows` says that they move.
    pub fn each_changing(&self, span: [f64; 2], follows: impl Fn(&Point) -> bool, mut sink: impl FnMut(u32)) {
        let closes = |material: &JointMaterial| {
            let [before, after] = span.map(|t| material.closed_fraction(t));
            before != after
        };
        let closing: Vec<bool> = self.materials.iter().map(closes).collect();
        let moving: Vec<bool> = self.points.iter().map(follows).collect();
        if !closing.contains(&true) && !moving.contains(&true) {
            return;
        }
        for JointConstraint { ends: [a, b], material, .. } in &self.joints {
            let is_point = b & IS_POINT != 0;
            if closing[*material as usize] || is_point && moving[(b ^ IS_POINT) as usize] {
                sink(*a);
                if !is_point {
                    sink(*b);
                }
            }
        }
    }

    /// Whether they may add energy: by seams that close, or points that move.
    pub fn drives(&self) -> bool {
        self.materials.iter().any(|material| material.close[1] > material.close[0])
            || self.points.iter().any(|point| point.track != u32::MAX)
    }

    /// Warnings of seams that cannot close.
    pub fn warnings(&self) -> impl Iterator<Item = String> {
        let sewn = |seam: usize| self.joints.iter().filter(|joint| joint.material as usize == seam).count();
        let held = self.held.iter().enumerate().filter(|(_, held)| **held > 0);
        held.map(move |(seam, &held)| {
            format!(
                "seam[{seam}]: pins hold both nodes of {held} of its {} pairs, which the seam cannot close; \
                 leave them out, or unpin one side",
                held + sewn(seam)
            )
        })
    }

    /// The ends of joints between two nodes.
    pub fn joined(&self) -> impl Iterator<Item = [u32; 2]> {
        self.joints.iter().map(|joint| joint.ends).filter(|ends| ends[1] & IS_POINT == 0)
    }

    /// Nodes that a node, given by its solver index, does not collide with because a seam makes them neighbours;
    /// ascending.
    pub fn exclusions(&self, node: usize) -> impl Iterator<Item = usize> {
        let [start, end] =
            [node, node + 1].map(|at| self.exclusions.partition_point(|pair| (pair[0] as usize) < at));
        self.exclusions[start..end].iter().map(|pair| pair[1] as usize)
    }

    /// Adds the joint of a node that a pin holds until it breaks.
    pub(crate) fn hold(&mut self, node: u32, material: u32, point: Point) {
        let end = self.points.len() as u32 | IS_POINT;
        self.points.push(point);
        self.joints.push(JointConstraint { ends: [node, end], start: 0.0, material });
    }

    /// Lists joints and tethers by node, and the groups of joints.
    pub(crate) fn list(&mut self, is_free: impl Fn(u32) -> bool) {
        let ends = self.joints.iter().flat_map(|joint| joint.ends).filter(|end| end & IS_POINT == 0);
        self.nodes = ends.chain(self.tethers.iter().map(|tether| tether.node)).collect();
        self.nodes.sort_unstable();
        self.nodes.dedup();
        let number = |node: u32| self.nodes.binary_search(&node).unwrap_or_default() as u32;
        let joints: Vec<(u32, u32)> = (0..)
            .zip(&self.joints)
            .flat_map(|(joint, of)| of.ends.map(|end| (end, joint)))
            .filter(|(end, _)| end & IS_POINT == 0)
            .map(|(end, joint)| (number(end), joint))
            .collect();
        let tethers: Vec<(u32, u32)> =
            self.tethers.iter().map(|tether| number(tether.node)).zip(0..).collect();
        self.joints_of = Csr::new(self.nodes.len(), joints.into_iter());
        self.tethers_of = Csr::new(self.nodes.len(), tethers.into_iter());
        self.group(is_free);
    }

    /// Groups joints that share free nodes. A pinned node moves for none of its joints, so it does not connect them.
    fn group(&mut self, is_free: impl Fn(u32) -> bool) {
        let mut sets = Sets::new(self.joints.len());
        let free = (0..).zip(&self.nodes).filter(|(_, node)| is_free(**node));
        for (number, _) in free {
            for pair in self.joints_of.row(number).windows(2) {
                sets.join(pair[0], pair[1]);
            }
        }
        let roots = sets.all();
        let mut size = vec![0; roots.len()];
        roots.iter().for_each(|&root| size[root as usize] += 1);
        let mut number = vec![0; roots.len()];
        let mut count = 0;
        for joint in 0..roots.len() {
            number[joint] = count;
            count += u32::from(size[joint] > 1);
        }
        let grouped = roots.iter().zip(0..).filter(|(root, _)| size[**root as usize] > 1);
        let entries: Vec<(u32, u32)> = grouped.map(|(&root, joint)| (number[root as usize], joint)).collect();
        self.groups = Csr::new(count as usize, entries.into_iter());
    }
}
