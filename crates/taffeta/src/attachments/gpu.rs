//! Joints and tethers on the GPU.

use crate::advice::{Advice, Refusal};
use crate::assembly::Assembly;
use crate::attachments::attach;
use crate::attachments::constraints::{self, IS_POINT, JointConstraint};
use crate::attachments::gpu_layout::Joint;
use crate::backend::SolverState;
use crate::contact::colliders::gpu::contact_of;
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP, NONE};
use crate::gpu::schedule::Fused;
use crate::plan::Substep;
use crate::report::FrameSums;
use crate::step::{Op, Stage};
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!("attachments", ["attach.wgsl", "stages.wgsl"]);

/// Fields of a joint in `joint_work` of stages.wgsl.
pub const FIELDS: usize = 5;

/// Tables of joints and tethers, on the host.
#[derive(Default)]
pub struct AttachmentTables {
    pub joints: Vec<Joint>,
    /// As `attachment_lists` of stages.wgsl; empty if there are neither joints nor tethers.
    pub lists: Vec<u32>,
    /// As `joint_groups` there.
    pub groups: Vec<u32>,
    /// Which of the scene's joints `joints` are.
    pub numbers: Vec<usize>,
}

/// Refuses joints between partitions, sewn bodies with self-collision, and breakable pins on colliders.
pub fn check_together(assembly: &Assembly, partitions: &[Range<usize>], limit: u64) -> Result<(), Refusal> {
    let all = assembly.attachments();
    let body = |node: u32| assembly.number_of_body(node);
    if let Some(joint) = all.joints.iter().find(|joint| all.is_carried(joint)) {
        let message = format!(
            "body `{}` has a pin with collider and break_force, which does not run on a GPU yet; the CPU would do",
            assembly.bodies[body(joint.ends[0])].name
        );
        return Err(Refusal::new(message, [Advice::Cpu]));
    }
    let partition = |body: usize| partitions.iter().position(|bodies| bodies.contains(&body));
    for [a, b] in all.joined().map(|ends| ends.map(body)) {
        let [first, second] = [a, b].map(|index| &assembly.bodies[index]);
        if partition(a) != partition(b) {
            let message = format!(
                "bodies `{}` and `{}` are sewn together, and the GPU does not give a kernel enough to hold both: {limit} bytes \
                 in one piece; the CPU or coarser meshes would do",
                first.name, second.name
            );
            return Err(Refusal::new(message, [Advice::Cpu]));
        }
        if first.self_contact().is_some() && second.self_contact().is_some() {
            let message = format!(
                "bodies `{}` and `{}` are sewn together and have self_collision, which do not run together on a GPU yet; \
                 the CPU would do",
                first.name, second.name
            );
            return Err(Refusal::new(message, [Advice::Cpu]));
        }
    }
    Ok(())
}

impl AttachmentTables {
    /// The tables of some bodies. So many of these keep a volume: among the targets of a sub-step, the lengths of
    /// joints follow the volumes.
    pub fn new(bodies: &Bodies<'_>, volumes: usize) -> Self {
        let all = bodies.assembly.attachments();
        let (mut joints, mut numbers) = (Vec::new(), Vec::new());
        let mut number_of = vec![NONE; all.joints.len()];
        for (number, joint) in all.joints.iter().enumerate().filter(|(_, joint)| bodies.has(joint.ends[0])) {
            number_of[number] = joints.len() as u32;
            joints.push(joint_record(bodies, joint, volumes));
            numbers.push(number);
        }
        let groups = groups_here(all, &number_of, &mut joints);
        let lists = lists(bodies, &number_of);
        // The lists follow the starts by place.
        if lists.len() > bodies.len() { Self { joints, lists, groups, numbers } } else { Self::default() }
    }
}

fn joint_record(
    bodies: &Bodies<'_>,
    &JointConstraint { ends: [a, b], start, material: number }: &JointConstraint,
    volumes: usize,
) -> Joint {
    let all = bodies.assembly.attachments();
    let material = &all.materials[number as usize];
    let point = (b & IS_POINT != 0).then(|| all.points[(b ^ IS_POINT) as usize]);
    Joint {
        point: point.map_or([0.0; 3], |point| point.start.map(|x| x as f32)),
        track: point.map_or(NONE, |point| point.track),
        a: bodies.local(a as usize),
        b: if point.is_some() { NONE } else { bodies.local(b as usize) },
        start: start as f32,
        end: material.length as f32,
        compliance: material.compliance as f32,
        // WGSL has no infinity.
        break_force: material.break_force.min(f64::from(f32::MAX)) as f32,
        closing: volumes as u32 + number,
        grouped: 0,
    }
}

/// The start of each place's list. A list has the joints of a node, then its tethers.
fn lists(bodies: &Bodies<'_>, number_of: &[u32]) -> Vec<u32> {
    let all = bodies.assembly.attachments();
    let mut lists = vec![NONE; bodies.len()];
    for (number, &node) in all.nodes.iter().enumerate().filter(|(_, node)| bodies.has(**node)) {
        lists[bodies.local(node as usize) as usize] = lists.len() as u32;
        let own = all.joints_of.row(number);
        lists.push(own.len() as u32);
        let second = |joint: u32| u32::from(all.joints[joint as usize].ends[0] != node);
        lists.extend(own.iter().map(|&joint| 2 * number_of[joint as usize] + second(joint)));
        let tethers = all.tethers_of.row(number);
        lists.push(tethers.len() as u32);
        lists.extend(tethers.iter().flat_map(|&tether| {
            let tether = &all.tethers[tether as usize];
            [bodies.local(tether.anchor as usize), attach::radius::<f32>(tether.length).to_bits()]
        }));
    }
    lists
}

/// The groups of joints in this partition, by the numbers in `number_of`. Marks the joints that are in one.
fn groups_here(all: &constraints::Attachments, number_of: &[u32], joints: &mut [Joint]) -> Vec<u32> {
    let members = |group: usize| all.groups.row(group).iter().map(|&joint| number_of[joint as usize]);
    let here: Vec<usize> =
        (0..all.groups.rows()).filter(|&group| members(group).all(|joint| joint != NONE)).collect();
    let mut groups = vec![here.len() as u32];
    let mut end = here.len() as u32 + 2;
    groups.push(end);
    for &group in &here {
        end += members(group).count() as u32;
        groups.push(end);
    }
    for joint in here.into_iter().flat_map(members) {
        groups.push(joint);
        joints[joint as usize].grouped = 1;
    }
    groups
}

/// Joints and tethers on the device.
pub struct Attachments {
    joints: Buffer<Joint>,
    lists: Buffer<u32>,
    broken: Buffer<u32>,
    groups: Buffer<u32>,
    work: Buffer<Four>,
    corrections: Buffer<Four>,
    read_broken: ReadBack<u32>,
    /// How many groups there are.
    grouped: usize,
    numbers: Vec<usize>,
    /// Number of joints of the scene; 0 if none can break.
    scene_joints: usize,
    /// Workgroups, with one invocation for each place.
    place_groups: usize,
}

impl Attachments {
    /// Uploads tables; `None` if they are empty.
    pub fn new(
        gpu: &Gpu,
        assembly: &Assembly,
        tables: &AttachmentTables,
        places: usize,
    ) -> Result<Option<Self>, GpuError> {
        if tables.lists.is_empty() {
            return Ok(None);
        }
        let (count, all) = (tables.joints.len(), assembly.attachments());
        let work = if tables.groups[0] > 0 { FIELDS * count + places } else { 0 };
        Ok(Some(Self {
            joints: gpu.buffer_from("joints", &tables.joints)?,
            lists: gpu.buffer_from("joints and tethers by node", &tables.lists)?,
            broken: gpu.buffer_from("broken joints", &vec![0; count])?,
            groups: gpu.buffer_from("groups of joints", &tables.groups)?,
            work: gpu.buffer("groups of joints at work", work)?,
            corrections: gpu.buffer("corrections of joints", count)?,
            read_broken: gpu.read_back("broken joints", count)?,
            grouped: tables.groups[0] as usize,
            numbers: tables.numbers.clone(),
            scene_joints: if all.breaks() { all.joints.len() } else { 0 },
            place_groups: places.div_ceil(GROUP),
        }))
    }
}

impl Feature for Attachments {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("joints", &self.joints),
            ("attachment_lists", &self.lists),
            ("joint_broken", &self.broken),
            ("joint_groups", &self.groups),
            ("joint_work", &self.work),
            ("joint_corrections", &self.corrections),
        ]
    }

    /// Reads the state after the sub-step, and writes over the state before it.
    fn kernels<'f>(&'f self, features: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let [joints, groups] = [self.joints.len(), self.grouped].map(|all| all.div_ceil(GROUP));
        let [_, contact] = contact_of(features);
        let commands = vec![
            Command::SwapStates,
            Command::run(Name::new("solve_joints"), joints),
            Command::run(Name::new("solve_joint_groups"), groups),
            Command::run(Name::new("apply_attachments").with(contact.choices()), self.place_groups),
        ];
        vec![Fused::new(&[Op::Attachments, Op::ApplyAttachments, Op::Contact], commands)]
    }

    fn bytes(&self, assembly: &Assembly) -> usize {
        assembly.attachments().materials.len() * size_of::<f32>()
    }

    fn targets(&self, substep: &Substep<f32>) -> Vec<f32> {
        substep.closing().to_vec()
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.broken, &self.read_broken);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let mut all = Vec::new();
        self.read_broken.take(gpu, &mut all)?;
        sums.broken += all.iter().map(|&broken| u64::from(broken)).sum::<u64>();
        Ok(())
    }

    fn lasting(&self) -> Vec<&dyn Bindable> {
        vec![&self.broken]
    }

    fn save(&self, gpu: &Gpu, state: &mut SolverState) {
        if self.scene_joints == 0 {
            return;
        }
        state.joints.resize(self.scene_joints, true);
        // If the device is lost, the next frame that is submitted reports it.
        let broken = self.broken.read(gpu).unwrap_or_default();
        self.numbers.iter().zip(broken).for_each(|(&number, broken)| state.joints[number] = broken == 0);
    }

    fn load(&mut self, gpu: &Gpu, state: &SolverState) -> bool {
        let broken = |&number: &usize| u32::from(state.joints.get(number) == Some(&false));
        self.broken.write(gpu, 0, &self.numbers.iter().map(broken).collect::<Vec<_>>());
        false
    }
}
