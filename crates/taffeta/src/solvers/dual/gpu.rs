//! Constraints of a segment on the device, and how their pulls are found in a sub-step.

use crate::gpu::kernels::Name;
use crate::gpu::layout::GROUP;
use crate::gpu::order::Stages;
use crate::gpu::recorder::Recorder;
use crate::solvers::dual::gpu_layout::{Link, LinkGroup, Met, NodeGroup, Row, Solve, Taken};
use crate::solvers::dual::gpu_tables::Linked;
use crate::step::Stage;
use taffeta_gpu::{Bindable, Buffer, Counts, DispatchList, Gpu, GpuError, ReadBack};

/// Iterations from one count of open systems to the next.
const BETWEEN_COUNTS: u32 = 8;
/// Passes over a system beside iterations: with the pulls that it starts from, with what is left of the right side, and the
/// nodes' look at the last sums.
const MORE_PASSES: u32 = 3;

/// What constraints need.
pub struct Constrained {
    link_groups: Buffer<LinkGroup>,
    node_groups: Buffer<NodeGroup>,
    incident: Buffer<u32>,
    links: Buffer<Link>,
    rows: Buffer<Row>,
    row_scales: Buffer<[f32; 2]>,
    met: Buffer<Met>,
    active_links: Buffer<u32>,
    active_counts: Buffer<u32>,
    solves: Buffer<Solve>,
    row_sums: Buffer<[f32; 4]>,
    response: Buffer<[f32; 4]>,
    counts: Counts,
    taken: Buffer<Taken>,
    read_taken: ReadBack<Taken>,
    /// Groups of constraints and of nodes.
    groups: [usize; 2],
    /// Passes over the systems that are written down for a sub-step.
    passes: u32,
    is_adaptive: bool,
}

impl Constrained {
    /// Takes tables to the device; `None` where there is no constraint.
    pub fn new(gpu: &Gpu, linked: &Linked, places: usize) -> Result<Option<Self>, GpuError> {
        if linked.is_empty() {
            return Ok(None);
        }
        let (links, groups) = (linked.links.len(), linked.link_groups.len());
        let all: Vec<u32> = (0..links as u32).collect();
        Ok(Some(Self {
            link_groups: gpu.buffer_from("groups of constraints", &linked.link_groups)?,
            node_groups: gpu.buffer_from("groups of nodes", &linked.node_groups)?,
            incident: gpu.buffer_from("constraints by node", &linked.incident)?,
            links: gpu.buffer_from("constraints", &linked.links)?,
            rows: gpu.buffer("rows of constraints", links)?,
            row_scales: gpu.buffer("scales of constraints", links)?,
            met: gpu.buffer("nodes of constraints", places)?,
            active_links: gpu.buffer_from("active constraints", &all)?,
            active_counts: gpu.buffer("counts of active constraints", groups)?,
            solves: gpu.buffer_from("systems of constraints", &linked.solves)?,
            row_sums: gpu.buffer("sums of constraints", groups)?,
            response: gpu.buffer("what constraints do to nodes", places)?,
            counts: gpu.counts("workgroups of iterations", 2)?,
            taken: gpu.buffer("what constraints take", 1)?,
            read_taken: gpu.read_back("what constraints take", 1)?,
            groups: [groups, linked.node_groups.len()],
            passes: linked.iterations.saturating_add(MORE_PASSES),
            is_adaptive: linked.is_adaptive,
        }))
    }

    /// Its buffers by their names in the sources.
    pub fn buffers(&self) -> Vec<(&str, &dyn Bindable)> {
        vec![
            ("link_groups", &self.link_groups),
            ("node_groups", &self.node_groups),
            ("incident", &self.incident),
            ("links", &self.links),
            ("rows", &self.rows),
            ("row_scales", &self.row_scales),
            ("met", &self.met),
            ("active_links", &self.active_links),
            ("active_counts", &self.active_counts),
            ("solves", &self.solves),
            ("row_sums", &self.row_sums),
            ("response", &self.response),
            ("solve_counts", &self.counts),
            ("taken", &self.taken),
        ]
    }

    /// Dispatches of a sub-step that find pulls.
    pub fn dispatches(&self) -> usize {
        2 * self.passes as usize
    }

    /// Forgets what the frame before has taken.
    pub fn start_frame(&self, gpu: &Gpu) {
        self.taken.write(gpu, 0, &[Taken::default()]);
    }

    /// Number of constraints.
    pub fn len(&self) -> usize {
        self.links.len()
    }

    /// Pulls [N], and which constraints are active; waits for them.
    pub fn solver_state(&self, gpu: &Gpu) -> Result<(Vec<f64>, Vec<bool>), GpuError> {
        let (rows, scales, links) = (self.rows.read(gpu)?, self.row_scales.read(gpu)?, self.links.read(gpu)?);
        let pulls = rows.iter().zip(&scales).map(|(row, [scale, _])| f64::from(row.x * scale));
        Ok((pulls.collect(), links.iter().map(|link| link.is_active != 0).collect()))
    }

    /// Takes back what was remembered; of constraints, pulls or activity may be left out.
    pub fn set_solver_state(&self, gpu: &Gpu, pulls: &[f64], active: &[bool]) -> Result<(), GpuError> {
        let rows: Vec<Row> = pulls.iter().map(|&pull| Row { x: pull as f32, ..Row::default() }).collect();
        self.rows.write(gpu, 0, &rows);
        self.row_scales.write(gpu, 0, &vec![[1.0, 0.0]; rows.len()]);
        if !active.is_empty() {
            let mut links = self.links.read(gpu)?;
            links.iter_mut().zip(active).for_each(|(link, &is_active)| link.is_active = is_active.into());
            self.links.write(gpu, 0, &links);
        }
        gpu.health()
    }

    /// Has what was taken copied to where the host reads it.
    pub fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.taken, &self.read_taken);
    }

    /// What the frame has taken; waits for it.
    pub fn taken(&self, gpu: &Gpu) -> Result<Taken, GpuError> {
        let mut all = Vec::new();
        self.read_taken.take(gpu, &mut all)?;
        Ok(all.first().copied().unwrap_or_default())
    }
}

impl Recorder<'_> {
    /// All forces but those of constraints. Where springs act as well, kernels of their own have those of bodies that keep
    /// their volume.
    pub(crate) fn forces_before_constraints(&mut self, substep: usize) {
        if self.from <= Stage::Loads {
            self.alone(Stage::Loads, substep);
        }
        let is_adaptive = self.segment.constrained.as_ref().is_some_and(|all| all.is_adaptive);
        if is_adaptive && self.from <= Stage::Springs {
            self.alone(Stage::Springs, substep);
            let kept = if self.keeps_volumes() { self.segment.tables.volume_groups.len() } else { 0 };
            self.dispatch("volume_forces_given", substep, kept);
        }
    }

    /// Finds the pulls of constraints, where all other forces are known, and adds them.
    pub(crate) fn find_pulls(&mut self, substep: usize) {
        let Some(Constrained { groups: [links, nodes], passes, is_adaptive, .. }) = self.segment.constrained
        else {
            return;
        };
        self.list.stage("constraints");
        if is_adaptive {
            self.dispatch("mark_active", substep, links);
            self.dispatch("list_active", substep, links);
        }
        self.dispatch("free_velocities", substep, nodes);
        self.dispatch("pins_all", substep, self.counts.pins.div_ceil(GROUP));
        self.dispatch("set_up_rows", substep, links);
        if self.meets_meshes() {
            self.dispatch_on_meshes("meet_meshes", substep, nodes);
        }
        self.dispatch("meet_surfaces", substep, nodes);
        self.dispatch("start_rows", substep, links);
        for pass in 0..passes {
            if pass % BETWEEN_COUNTS == 0 {
                self.dispatch("count_solves", substep, 1);
            }
            self.dispatch_counted("solve_nodes", substep, 0);
            self.dispatch_counted("solve_rows", substep, 1);
        }
        self.dispatch("note_solves", substep, 1);
        self.dispatch("pull_nodes", substep, nodes);
    }

    fn dispatch_counted(&mut self, entry: &'static str, substep: usize, which: usize) {
        if self.fault.is_ok() {
            let bound = self.segment.bound(self.kernels, (Name::new(entry), 0), substep);
            self.fault = bound.map(|(bound, offsets)| {
                if let Some(constrained) = &self.segment.constrained {
                    self.list.dispatch_counted(&bound, &offsets, &constrained.counts, which);
                }
            });
        }
    }
}
