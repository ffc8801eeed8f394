//! Rows of joints and tethers.

use crate::attachments::attach::{self, JointCorrection};
use crate::attachments::gpu::FIELDS;
use crate::attachments::gpu_layout::Joint;
use crate::attachments::joints::{self, GroupJoint};
use crate::backend::{Backend, SolverState};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP, NONE};
use crate::motion::pins::Motion;
use crate::parity::bench::{Bench, Given, Written};
use crate::parity::fixture::{Chance, Fixture, SUBSTEP, words};
use crate::parity::row::{Row, Tolerance};
use crate::parity::scene::scene;
use crate::real::sub;
use crate::scene::{Keyframe, Pin, Scene, Seam, SeamSide, Select};
use crate::solvers::explicit::parity::kernel_of;
use crate::step::{self, Line, Op, Parts};

const FOUND: &str = "sums of products, a root and quotients; hardware rounds them otherwise";
const SOLVED: &str = "some rounds of conjugate residuals, of which hardware may need one more";
const MOVED: &str = "as above; contact multiplies what hardware rounds otherwise";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    row("solve_joints", Tolerance::new(0.0, 64.0, FOUND), solve),
    row("solve_joint_groups", Tolerance::new(0.0, 65_536.0, SOLVED), group),
    row("apply_attachments", Tolerance::new(0.0, 256.0, MOVED), attach),
];

const fn row(
    name: &'static str,
    tolerance: Tolerance,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> Row {
    Row { name, entry: name, tolerance, check }
}

/// The scene of the other rows, sewn: seams within a body, between bodies, to held nodes, of several joints a node, rigid and
/// soft, that break and do not; pins that break, still and moving; tethers.
fn sewn(apart: bool) -> Scene {
    let mut all = scene(0.0087, apart);
    // Joints move nodes far here, and what is behind a half-space is inside it whichever way it came.
    all.colliders.retain(|collider| collider.plane.is_some());
    all.frictions.clear();
    let side = |name: &str, nodes: std::ops::Range<u32>| {
        SeamSide::new(name, Select::nodes(nodes.collect::<Vec<_>>()))
    };
    let seam = |from, to, k, break_force, length| Seam {
        k,
        break_force,
        ..Seam::new(from, to).closing(0.002, 0.021, length)
    };
    all = all
        .seam(seam(side("sheet", 0..60), side("ball", 100..160), None, Some(900.0), 0.13))
        .seam(seam(side("ball", 120..200), side("sheet", 200..280), Some(310.0), Some(70.0), 0.0))
        .seam(seam(side("sheet", 300..340), side("sheet", 500..540), Some(2.7), None, 0.21))
        .seam(seam(side("chain", 0..38), side("blob", 20..58), None, None, 0.0))
        // Closed by now, and longer than its ends are apart.
        .seam(seam(side("sheet", 60..80), side("ball", 150..170), None, None, 9.0).closing(0.0, 0.005, 9.0));
    let motion = vec![Keyframe::rotate(0.3, [0.3, 0.8, -0.2], 50.0, [0.1, 0.2, -0.3])];
    let breaking = |nodes: std::ops::Range<u32>, motion, force| Pin {
        select: Select::nodes(nodes.collect::<Vec<_>>()),
        motion,
        break_force: Some(force),
        ..Pin::default()
    };
    all.bodies[1].pins.push(breaking(180..230, motion, 800.0));
    all.bodies[5].pins.push(breaking(30..50, Vec::new(), 1700.0));
    all.bodies[0] = all.bodies[0].clone().tether(0.03);
    all.bodies[1] = all.bodies[1].clone().tether(0.4);
    all
}

/// A state, and which joints are broken before the sub-step.
pub struct Work {
    pub fixture: Fixture,
    pub broken: Vec<u32>,
}

impl Work {
    pub fn new(seed: u64, exact: bool) -> Result<Self, String> {
        let mut fixture = Fixture::of(&sewn(!exact), seed, exact)?;
        let mut chance = Chance::new(seed + 77);
        let broken: Vec<u32> =
            fixture.tables.attachments.joints.iter().map(|_| u32::from(chance.number() > 0.6)).collect();
        let at_one_place: Vec<Joint> =
            fixture.tables.attachments.joints.iter().step_by(29).copied().collect();
        for joint in at_one_place.iter().filter(|joint| exact && joint.b != NONE) {
            let place = fixture.new.position[joint.a as usize];
            fixture.new.position[joint.b as usize][..3].copy_from_slice(&place[..3]);
        }
        Ok(Self { fixture, broken })
    }

    /// How far apart the ends of a joint are, their inverse masses, its length and its softness.
    fn gap(&self, joint: &Joint) -> ([f32; 3], [f32; 2], f32, f32) {
        let (substep, state) = (self.fixture.substep(), &self.fixture.new.position);
        let end = |node: u32| {
            let [x, y, z, w] = state[node as usize];
            ([x, y, z], w)
        };
        let (x, w) = end(joint.a);
        let motion: Option<&Motion<f32>> = substep.motions().get(joint.track as usize);
        let point = motion.map_or(joint.point, |motion| motion.apply(joint.point).0);
        let (y, v) = if joint.b == NONE { (point, 0.0) } else { end(joint.b) };
        let fraction = substep.closing()[joint.closing as usize - self.fixture.tables.volumes.numbers.len()];
        let length = attach::length(joint.start, joint.end, fraction);
        (sub(x, y), [w, v], length, attach::softness(joint.compliance, substep.h))
    }

    /// What each joint does by the formulas.
    fn shifts(&self) -> Vec<JointCorrection<f32>> {
        let tables = &self.fixture.tables.attachments;
        let alone = |joint: &Joint| {
            let (d, [v, w], length, softness) = self.gap(joint);
            attach::solve_joint(d, length, v + w, softness)
        };
        let mut corrections: Vec<JointCorrection<f32>> = tables.joints.iter().map(alone).collect();
        let mut sums = vec![[f32::NAN; 3]; self.fixture.tables.len()];
        for bounds in tables.groups[1..tables.groups[0] as usize + 2].windows(2) {
            let rows = &tables.groups[bounds[0] as usize..bounds[1] as usize];
            let joint = |&row: &u32| {
                let joint = &tables.joints[row as usize];
                let (d, masses, length, softness) = self.gap(joint);
                let whole = self.broken[row as usize] == 0;
                let ends = [joint.a, joint.b].map(|node| node as usize);
                whole.then(|| GroupJoint::new(ends, masses, d, [length, joint.end], softness)).flatten()
            };
            let all: Vec<Option<GroupJoint<f32>>> = rows.iter().map(joint).collect();
            let mut joints: Vec<GroupJoint<f32>> = all.iter().copied().flatten().collect();
            joints::solve(&mut joints, &mut sums);
            let mut joints = joints.iter();
            for (&row, linked) in rows.iter().zip(&all) {
                let joint = linked.and_then(|_| joints.next());
                corrections[row as usize] = joint.map_or(JointCorrection::default(), GroupJoint::correction);
            }
        }
        corrections
    }

    /// As `joint_corrections` and `joint_broken` have it afterwards.
    fn corrections(&self) -> (Vec<Four>, Vec<u32>) {
        let h = self.fixture.substep().h;
        let joints = self.fixture.tables.attachments.joints.iter().zip(&self.broken);
        joints
            .zip(self.shifts())
            .map(|((joint, &broken), correction)| {
                let [x, y, z] = correction.shift;
                let breaks = broken != 0 || attach::breaks(&correction, h, joint.break_force);
                if breaks { ([0.0; 4], 1) } else { ([x, y, z, 1.0], 0) }
            })
            .unzip()
    }

    /// The same after a kernel that does those in groups, or the others; the rest is as it was, `joint_corrections` at `before`.
    fn corrections_of(&self, grouped: bool, before: f32) -> (Vec<Four>, Vec<u32>) {
        let (mut corrections, mut broken) = self.corrections();
        for (row, joint) in self.fixture.tables.attachments.joints.iter().enumerate() {
            if (joint.grouped != 0) != grouped {
                (corrections[row], broken[row]) = ([before; 4], self.broken[row]);
            }
        }
        (corrections, broken)
    }

    fn run(
        &self,
        bench: &mut Bench<'_>,
        entry: &'static str,
        corrections: Vec<u32>,
        groups: usize,
        compare: impl FnOnce(&mut Written<'_>),
    ) -> Result<(), String> {
        let fixture = &self.fixture;
        let kernel = kernel_of(bench, Name::new(entry), fixture)?;
        let mut arrays = fixture.arrays();
        arrays.insert("old_position", words(&fixture.new.position));
        arrays.insert("old_velocity", words(&fixture.new.velocity));
        arrays.insert("joints", words(&fixture.tables.attachments.joints));
        arrays.insert("attachment_lists", fixture.tables.attachments.lists.clone());
        arrays.insert("joint_broken", self.broken.clone());
        let tables = &fixture.tables.attachments;
        arrays.insert("joint_groups", tables.groups.clone());
        let work = 4 * (FIELDS * tables.joints.len() + fixture.tables.len());
        arrays.insert("joint_work", vec![f32::NAN.to_bits(); work]);
        arrays.insert("joint_corrections", corrections);
        bench.run(&kernel, &Given { arrays: &arrays, records: &fixture.records(), groups }, compare)
    }
}

fn both(bench: &Bench<'_>) -> Result<[Work; 2], String> {
    Ok([Work::new(31, bench.exact)?, Work::new(32, bench.exact)?])
}

fn same(written: &mut Written<'_>, name: &str, wanted: &[u32]) {
    let halves = |words: &[u32]| -> Vec<f32> {
        words.iter().flat_map(|word| [(word >> 16) as f32, (word & 0xffff) as f32]).collect()
    };
    let found: Vec<u32> = written.take(name);
    written.outcome().copied(name, &halves(wanted), &halves(&found));
}

fn solve(bench: &mut Bench<'_>) -> Result<(), String> {
    solve_with(bench, "solve_joints", false, |work| work.fixture.tables.attachments.joints.len())
}

fn group(bench: &mut Bench<'_>) -> Result<(), String> {
    solve_with(bench, "solve_joint_groups", true, |work| work.fixture.tables.attachments.groups[0] as usize)
}

fn solve_with(
    bench: &mut Bench<'_>,
    entry: &'static str,
    grouped: bool,
    count: impl Fn(&Work) -> usize,
) -> Result<(), String> {
    for work in both(bench)? {
        const BEFORE: f32 = 7.5;
        let (corrections, broken) = work.corrections_of(grouped, BEFORE);
        let before = vec![BEFORE.to_bits(); 4 * corrections.len()];
        work.run(bench, entry, before, count(&work).div_ceil(GROUP), |written| {
            written.fours("joint_corrections", &corrections);
            same(written, "joint_broken", &broken);
            // What it was solved with is looked at by what comes of it.
            let _: Vec<f32> = written.take("joint_work");
        })?;
    }
    Ok(())
}

/// Joints and tethers on the CPU, and colliders again or not.
fn attach_once(contact: bool) -> Vec<Line> {
    let parts = Parts { attachments: true, ..Parts::default() };
    let all = [Op::Attachments, Op::ApplyAttachments, Op::Contact];
    step::part_of(&parts, &all[..if contact { 3 } else { 2 }])
}

/// The state that the CPU comes to.
fn on_cpu(work: &mut Work, contact: bool) -> Vec<[f32; 6]> {
    let Work { fixture, broken, .. } = work;
    let joints = broken.iter().map(|&broken| broken == 0).collect();
    fixture.cpu.set_solver_state(&SolverState { joints, ..SolverState::default() });
    let Fixture { cpu, substeps, new, .. } = fixture;
    for (place, (x, v)) in new.position.iter().zip(&new.velocity).enumerate() {
        cpu.set_after(place, [x[0], x[1], x[2], v[0], v[1], v[2]]);
    }
    cpu.passes(&substeps[SUBSTEP], &attach_once(contact));
    (0..new.position.len()).map(|place| cpu.after(place)).collect()
}

/// The same with inverse masses, and masses that say who has touched a collider: colliders have moved it.
fn attached(work: &mut Work) -> [Vec<Four>; 2] {
    let (without, with) = (on_cpu(work, false), on_cpu(work, true));
    let [mut position, mut velocity] =
        [&work.fixture.new.position, &work.fixture.new.velocity].map(Vec::clone);
    for (place, (after, before)) in with.iter().zip(&without).enumerate() {
        position[place][..3].copy_from_slice(&after[..3]);
        velocity[place][..3].copy_from_slice(&after[3..]);
        if after != before {
            velocity[place][3] = -velocity[place][3].abs();
        }
    }
    [position, velocity]
}

fn attach(bench: &mut Bench<'_>) -> Result<(), String> {
    for mut work in both(bench)? {
        let [position, velocity] = attached(&mut work);
        // What a broken one has is not looked at.
        let given = |[x, y, z, w]: Four| if w == 0.0 { [7.0, -5.0, 3.0, 0.0] } else { [x, y, z, w] };
        let corrections = words(&work.corrections().0.into_iter().map(given).collect::<Vec<Four>>());
        let groups = work.fixture.place_groups();
        work.run(bench, "apply_attachments", corrections.clone(), groups, |written| {
            written.fours("new_position", &position);
            written.fours("new_velocity", &velocity);
            same(written, "joint_corrections", &corrections);
        })?;
    }
    Ok(())
}
