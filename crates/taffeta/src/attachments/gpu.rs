//! Joints and tethers of a segment: their tables, their buffers, and what is remembered of them.

use crate::attachments::build::{Attachments, IS_POINT, Row};
use crate::build::Assembly;
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP, Joint, NONE};
use crate::gpu::recorder::Recorder;
use crate::gpu::tables::Tables;
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack};

/// Fields of a joint in `joint_work` of attach_stages.wgsl.
pub const FIELDS: usize = 5;

/// The tables of a segment.
#[derive(Default)]
pub struct Attached {
    pub joints: Vec<Joint>,
    /// As `attached` of attach_stages.wgsl; empty where the segment has neither joints nor tethers.
    pub lists: Vec<u32>,
    /// As `joint_groups` there.
    pub groups: Vec<u32>,
    /// Which of the scene's joints `joints` are.
    pub numbers: Vec<usize>,
}

/// Refuses nodes that are joined in several segments, sewn bodies that touch each other, and pins that break on colliders.
pub fn check_together(assembly: &Assembly, segments: &[Range<usize>], limit: u64) -> Result<(), String> {
    let all = &assembly.attachments;
    let body = |node: u32| assembly.bodies.partition_point(|body| body.first <= node as usize) - 1;
    if let Some(row) = all.rows.iter().find(|row| all.is_carried(row)) {
        return Err(format!(
            "body `{}` has a pin with collider and break_force, which does not run on a GPU yet; --backend cpu would do",
            assembly.bodies[body(row.ends[0])].name
        ));
    }
    let segment = |body: usize| segments.iter().position(|segment| segment.contains(&body));
    for [a, b] in all.joined().map(|ends| ends.map(body)) {
        let [first, second] = [a, b].map(|index| &assembly.bodies[index]);
        if segment(a) != segment(b) {
            return Err(format!(
                "bodies `{}` and `{}` are sewn together, and the GPU does not give a kernel enough to hold both: {limit} bytes \
                 in one piece; --backend cpu or coarser meshes would do",
                first.name, second.name
            ));
        }
        if first.touching.is_some() && second.touching.is_some() {
            return Err(format!(
                "bodies `{}` and `{}` are sewn together and have self_collision, which do not run together on a GPU yet; \
                 --backend cpu would do",
                first.name, second.name
            ));
        }
    }
    Ok(())
}

impl Tables {
    /// Adds the joints and tethers of this segment. Laws stand behind the volumes among the goals of a sub-step.
    pub(crate) fn add_attached(&mut self, assembly: &Assembly) {
        let all = &assembly.attachments;
        let here = |node: u32| self.places.contains(&(node as usize));
        let mut joints = Vec::new();
        let mut number_of = vec![NONE; all.rows.len()];
        let mut numbers = Vec::new();
        for (number, row) in all.rows.iter().enumerate().filter(|(_, row)| here(row.ends[0])) {
            number_of[number] = joints.len() as u32;
            joints.push(self.joint(assembly, row));
            numbers.push(number);
        }
        let groups = groups_here(all, &number_of, &mut joints);
        let mut lists = vec![NONE; self.len()];
        for (number, &node) in all.nodes.iter().enumerate().filter(|(_, node)| here(**node)) {
            lists[self.local(node as usize) as usize] = lists.len() as u32;
            let rows = all.rows_of.row(number);
            lists.push(rows.len() as u32);
            let second = |row: u32| u32::from(all.rows[row as usize].ends[0] != node);
            lists.extend(rows.iter().map(|&row| 2 * number_of[row as usize] + second(row)));
            let tethers = all.tethers_of.row(number);
            lists.push(tethers.len() as u32);
            lists.extend(tethers.iter().flat_map(|&tether| {
                let tether = &all.tethers[tether as usize];
                [self.local(tether.anchor as usize), (tether.length as f32).to_bits()]
            }));
        }
        if lists.len() > self.len() {
            self.attached = Attached { joints, lists, groups, numbers };
        }
    }

    fn joint(&self, assembly: &Assembly, &Row { ends: [a, b], start, law: number }: &Row) -> Joint {
        let all = &assembly.attachments;
        let law = &all.laws[number as usize];
        let point = (b & IS_POINT != 0).then(|| all.points[(b ^ IS_POINT) as usize]);
        Joint {
            point: point.map_or([0.0; 3], |point| point.start.map(|x| x as f32)),
            track: point.map_or(NONE, |point| point.track),
            a: self.local(a as usize),
            b: if point.is_some() { NONE } else { self.local(b as usize) },
            start: start as f32,
            end: law.length as f32,
            compliance: law.compliance as f32,
            // Infinity is no number to a shader.
            break_force: law.break_force.min(f64::from(f32::MAX)) as f32,
            closing: self.volume_numbers.len() as u32 + number,
            grouped: 0,
        }
    }
}

/// The groups of joints of a segment, of which `number_of` has the numbers. Notes which joints are in one.
fn groups_here(all: &Attachments, number_of: &[u32], joints: &mut [Joint]) -> Vec<u32> {
    let rows = |group: usize| all.groups.row(group).iter().map(|&row| number_of[row as usize]);
    let here: Vec<usize> =
        (0..all.groups.rows()).filter(|&group| rows(group).all(|row| row != NONE)).collect();
    let mut groups = vec![here.len() as u32];
    let mut end = here.len() as u32 + 2;
    groups.push(end);
    for &group in &here {
        end += rows(group).count() as u32;
        groups.push(end);
    }
    for row in here.into_iter().flat_map(rows) {
        groups.push(row);
        joints[row as usize].grouped = 1;
    }
    groups
}

/// Joints and tethers on the device.
pub struct Attaching {
    joints: Buffer<Joint>,
    lists: Buffer<u32>,
    broken: Buffer<u32>,
    groups: Buffer<u32>,
    work: Buffer<Four>,
    pulls: Buffer<Four>,
    read_broken: ReadBack<u32>,
    /// How many groups there are.
    grouped: usize,
    numbers: Vec<usize>,
}

impl Attaching {
    /// Takes tables to the device, if there are any.
    pub fn new(gpu: &Gpu, attached: &Attached, places: usize) -> Result<Option<Self>, GpuError> {
        if attached.lists.is_empty() {
            return Ok(None);
        }
        let count = attached.joints.len();
        Ok(Some(Self {
            joints: gpu.buffer_from("joints", &attached.joints)?,
            lists: gpu.buffer_from("joints and tethers by node", &attached.lists)?,
            broken: gpu.buffer_from("broken joints", &vec![0; count])?,
            groups: gpu.buffer_from("groups of joints", &attached.groups)?,
            work: gpu.buffer(
                "groups of joints at work",
                if attached.groups[0] > 0 { FIELDS * count + places } else { 0 },
            )?,
            pulls: gpu.buffer("pulls of joints", count)?,
            read_broken: gpu.read_back("broken joints", count)?,
            grouped: attached.groups[0] as usize,
            numbers: attached.numbers.clone(),
        }))
    }

    /// Its buffers by their names in the sources.
    pub fn buffers(&self) -> Vec<(&str, &dyn Bindable)> {
        vec![
            ("joints", &self.joints),
            ("attached", &self.lists),
            ("joint_broken", &self.broken),
            ("joint_groups", &self.groups),
            ("joint_work", &self.work),
            ("pulls", &self.pulls),
        ]
    }

    /// Has what is broken copied to where the host reads it.
    pub fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.broken, &self.read_broken);
    }

    /// Number of broken joints at the end of the frame; waits for it.
    pub fn broken(&self, gpu: &Gpu) -> Result<u64, GpuError> {
        let mut all = Vec::new();
        self.read_broken.take(gpu, &mut all)?;
        Ok(all.iter().map(|&broken| u64::from(broken)).sum())
    }

    /// Notes among those of the scene which joints are there; waits for it.
    pub fn solver_state(&self, gpu: &Gpu, there: &mut [bool]) {
        // A device that is lost says so when the next frame is handed over.
        let broken = self.broken.read(gpu).unwrap_or_default();
        self.numbers.iter().zip(broken).for_each(|(&number, broken)| there[number] = broken == 0);
    }

    /// Takes back what was remembered of the scene's joints.
    pub fn set_solver_state(&self, gpu: &Gpu, there: &[bool]) {
        let broken = |&number: &usize| u32::from(there.get(number) == Some(&false));
        self.broken.write(gpu, 0, &self.numbers.iter().map(broken).collect::<Vec<_>>());
    }
}

impl Recorder<'_> {
    /// Joints and tethers, and colliders again.
    pub(crate) fn attach_all(&mut self, substep: usize) {
        let Some(attaching) = &self.segment.attaching else { return };
        let [joints, groups] = [attaching.joints.len(), attaching.grouped].map(|all| all.div_ceil(GROUP));
        self.list.stage("attach");
        self.segment.current = 1 - self.segment.current;
        let places = self.segment.tables.place_groups();
        self.dispatch("pull_joints", substep, joints);
        self.dispatch("pull_groups", substep, groups);
        let name = Name { contact: self.whole_contact(), ..Name::new("attach_nodes") };
        self.dispatch_kernel(name, substep, places);
    }
}
