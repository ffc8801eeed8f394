//! The dual solver on the GPU.

use crate::assembly::Assembly;
use crate::backend::SolverState;
use crate::contact::colliders::gpu::Colliders;
use crate::contact::colliders::gpu::Contact;
use crate::gpu::feature::{Command, Dispatch, Feature, Features, Groups, Upload};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Solving, Substep};
use crate::gpu::schedule::Fused;
use crate::motion::gpu::Pins;
use crate::report::{FrameSums, SolverReport};
use crate::scene::Method;
use crate::solvers::dual::gpu_layout::{
    Constraint, ConstraintGroup, ContactRecord, NodeGroup, Row, Solve, SolveStatistics,
};
use crate::solvers::dual::gpu_tables::ConstraintTables;
use crate::step::{Marks, Op, Stage};
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, Counts, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "solvers/dual",
    [
        "active_stages.wgsl",
        "deepest_contact.wgsl",
        "distance.wgsl",
        "printed.wgsl",
        "solve.wgsl",
        "stages.wgsl"
    ]
);

/// Iterations from one count of unconverged systems to the next.
const BETWEEN_COUNTS: u32 = 8;
/// Passes over a system beside iterations: one with the warm start, one with the residual, and the last check of
/// sums.
const MORE_PASSES: u32 = 3;

/// Constraints on the device.
pub struct Dual {
    constraint_groups: Buffer<ConstraintGroup>,
    node_groups: Buffer<NodeGroup>,
    incident: Buffer<u32>,
    constraints: Buffer<Constraint>,
    rows: Buffer<Row>,
    row_scales: Buffer<[f32; 2]>,
    predicted_contacts: Buffer<ContactRecord>,
    active_constraints: Buffer<u32>,
    active_counts: Buffer<u32>,
    solves: Buffer<Solve>,
    row_sums: Buffer<[f32; 4]>,
    response: Buffer<[f32; 4]>,
    counts: Counts,
    statistics: Buffer<SolveStatistics>,
    read_statistics: ReadBack<SolveStatistics>,
    /// Groups of constraints and of nodes.
    groups: [usize; 2],
    /// Passes over the systems that are recorded for a sub-step.
    passes: u32,
    is_adaptive: bool,
    /// Which of the scene's constraints they are.
    numbers: Range<usize>,
    solving: Solving,
    /// Whether constraint forces are kept from one sub-step to the next.
    keeps_multipliers: bool,
}

impl Dual {
    /// Uploads tables; `None` if there is no constraint.
    pub fn new(
        gpu: &Gpu,
        assembly: &Assembly,
        tables: &ConstraintTables,
        places: usize,
    ) -> Result<Option<Self>, GpuError> {
        if tables.is_empty() {
            return Ok(None);
        }
        let (constraints, groups) = (tables.constraints.len(), tables.constraint_groups.len());
        let all: Vec<u32> = (0..constraints as u32).collect();
        let solver = &assembly.solver;
        let surfaces = solver.method == Method::Ice && !assembly.colliders().is_empty();
        Ok(Some(Self {
            constraint_groups: gpu.buffer_from("groups of constraints", &tables.constraint_groups)?,
            node_groups: gpu.buffer_from("groups of nodes", &tables.node_groups)?,
            incident: gpu.buffer_from("constraints by node", &tables.incident)?,
            constraints: gpu.buffer_from("constraints", &tables.constraints)?,
            rows: gpu.buffer("rows of constraints", constraints)?,
            row_scales: gpu.buffer("scales of constraints", constraints)?,
            predicted_contacts: gpu.buffer("nodes of constraints", places)?,
            active_constraints: gpu.buffer_from("active constraints", &all)?,
            active_counts: gpu.buffer("counts of active constraints", groups)?,
            solves: gpu.buffer_from("systems of constraints", &tables.solves)?,
            row_sums: gpu.buffer("sums of constraints", groups)?,
            response: gpu.buffer("what constraints do to nodes", places)?,
            counts: gpu.counts("workgroups of iterations", 2)?,
            statistics: gpu.buffer("what constraints take", 1)?,
            read_statistics: gpu.read_back("what constraints take", 1)?,
            groups: [groups, tables.node_groups.len()],
            passes: tables.iterations.saturating_add(MORE_PASSES),
            is_adaptive: tables.is_adaptive,
            numbers: tables.numbers.clone(),
            solving: Solving::of(solver),
            keeps_multipliers: solver.ice.warm_start || surfaces,
        }))
    }

    /// Constraint forces [N], and which constraints are active. Waits for them.
    fn state(&self, gpu: &Gpu) -> Result<(Vec<f64>, Vec<bool>), GpuError> {
        let (rows, scales, constraints) =
            (self.rows.read(gpu)?, self.row_scales.read(gpu)?, self.constraints.read(gpu)?);
        let pulls = rows.iter().zip(&scales).map(|(row, [scale, _])| f64::from(row.x * scale));
        Ok((pulls.collect(), constraints.iter().map(|constraint| constraint.is_active != 0).collect()))
    }

    /// Sets them. Forces or activity may be empty.
    fn set_state(&self, gpu: &Gpu, pulls: &[f64], active: &[bool]) -> Result<(), GpuError> {
        let rows: Vec<Row> = pulls.iter().map(|&pull| Row { x: pull as f32, ..Row::default() }).collect();
        self.rows.write(gpu, 0, &rows);
        self.row_scales.write(gpu, 0, &vec![[1.0, 0.0]; rows.len()]);
        if !active.is_empty() {
            let mut constraints = self.constraints.read(gpu)?;
            constraints
                .iter_mut()
                .zip(active)
                .for_each(|(constraint, &is_active)| constraint.is_active = is_active.into());
            self.constraints.write(gpu, 0, &constraints);
        }
        gpu.health()
    }

    /// A kernel on systems that have not converged.
    fn counted(&self, entry: &'static str, which: usize) -> Command<'_> {
        let groups = Groups::Counted(&self.counts, which);
        Command::Dispatch(Dispatch { name: Name::new(entry), part: 0, groups })
    }

    /// Solves for constraint forces, after all other forces, and adds them.
    fn solve_constraints<'f>(&'f self, features: &Features) -> Vec<Command<'f>> {
        let [constraints, nodes] = self.groups;
        let run = |entry, groups| Command::run(Name::new(entry), groups);
        let mut all = Vec::new();
        if self.is_adaptive {
            all.extend([run("mark_active", constraints), run("list_active", constraints)]);
        }
        all.push(run("free_velocities", nodes));
        all.extend(features.get::<Pins>().map(Pins::command));
        all.push(run("set_up_rows", constraints));
        if features.get::<Colliders>().is_some_and(Colliders::has_meshes) {
            all.push(Command::run(Name::new("predict_mesh_contacts").with(Contact::Meshes.choices()), nodes));
        }
        all.extend([run("predict_contacts", nodes), run("start_rows", constraints)]);
        for pass in 0..self.passes {
            if pass % BETWEEN_COUNTS == 0 {
                all.push(run("count_systems", 1));
            }
            all.extend([self.counted("solve_nodes", 0), self.counted("solve_rows", 1)]);
        }
        all.extend([run("record_statistics", 1), run("apply_constraint_forces", nodes)]);
        all
    }
}

impl Feature for Dual {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("constraint_groups", &self.constraint_groups),
            ("node_groups", &self.node_groups),
            ("incident", &self.incident),
            ("constraints", &self.constraints),
            ("rows", &self.rows),
            ("row_scales", &self.row_scales),
            ("predicted_contacts", &self.predicted_contacts),
            ("active_constraints", &self.active_constraints),
            ("active_counts", &self.active_counts),
            ("solves", &self.solves),
            ("row_sums", &self.row_sums),
            ("response", &self.response),
            ("solve_counts", &self.counts),
            ("statistics", &self.statistics),
        ]
    }

    fn kernels<'f>(&'f self, features: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let all = [Op::Predict, Op::Solve, Op::ConstraintForces];
        vec![Fused::new(&all, self.solve_constraints(features)).on(Marks::SOLVED, Marks::NONE)]
    }

    fn upload(&mut self, _: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        records.iter_mut().for_each(|record| record.solving = self.solving);
        Ok(false)
    }

    fn start_frame(&mut self, gpu: &Gpu) {
        self.statistics.write(gpu, 0, &[SolveStatistics::default()]);
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.statistics, &self.read_statistics);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        add_statistics(&self.read_statistics, gpu, &mut sums.solver)
    }

    fn dispatches(&self) -> usize {
        2 * self.passes as usize
    }

    fn lasting(&self) -> Vec<&dyn Bindable> {
        vec![&self.constraints, &self.rows, &self.row_scales]
    }

    fn save(&self, gpu: &Gpu, state: &mut SolverState) {
        let count = self.constraints.len();
        let unknown = |_| (vec![f64::NAN; count], vec![false; count]);
        let (pulls, active) = self.state(gpu).unwrap_or_else(unknown);
        state.warm_start.extend(if self.keeps_multipliers { pulls } else { Vec::new() });
        state.active.extend(if self.is_adaptive { active } else { Vec::new() });
    }

    fn load(&mut self, gpu: &Gpu, state: &SolverState) -> bool {
        let pulls = state.warm_start.get(self.numbers.clone()).unwrap_or_default();
        let active = state.active.get(self.numbers.clone()).unwrap_or_default();
        // If the device is lost, the next frame that is submitted reports it.
        let _ = self.set_state(gpu, pulls, active);
        false
    }
}

/// Adds the statistics of a partition's solves in a frame; waits for them. With several partitions, sub-steps and
/// fractions are those of the worst one.
pub fn add_statistics(
    read: &ReadBack<SolveStatistics>,
    gpu: &Gpu,
    report: &mut SolverReport,
) -> Result<(), GpuError> {
    let mut all = Vec::new();
    read.take(gpu, &mut all)?;
    let statistics = all.first().copied().unwrap_or_default();
    report.iterations = report.iterations.max(statistics.iterations);
    report.residual = report.residual.max(f64::from(statistics.residual).sqrt());
    report.active_fraction = report.active_fraction.max(f64::from(statistics.active_fraction));
    report.capped = report.capped.max(statistics.capped);
    Ok(())
}
