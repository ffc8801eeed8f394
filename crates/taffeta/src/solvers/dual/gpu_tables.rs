//! Tables of springs that are constraints, always or when they are too long.

use crate::assembly::Assembly;
use crate::gpu::bodies::Bodies;
use crate::gpu::layout::{GROUP, NONE, Solving};
use crate::scene::{Method, Solver};
use crate::solvers::dual::gpu_layout::{Constraint, ConstraintGroup, NodeGroup, Row, Solve};
use crate::solvers::iterations as needed;
use crate::topology::{Csr, LANES};
use std::ops::Range;

/// Bytes of the largest array that a body needs for its constraints, and its contents.
pub fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    let count = assembly.constraints().bodies.get(body).map_or(0, Range::len);
    let rows = if assembly.solver.is_primal() { 0 } else { count * size_of::<Row>() };
    vec![(rows as u64, "constraints")]
}

/// The tables of some bodies; empty if their springs are no constraints.
#[derive(Default)]
pub struct ConstraintTables {
    /// Which of the scene's constraints they are.
    pub numbers: Range<usize>,
    pub constraints: Vec<Constraint>,
    pub constraint_groups: Vec<ConstraintGroup>,
    pub node_groups: Vec<NodeGroup>,
    /// For each slice of places, where its entries begin; then the entries.
    pub incident: Vec<u32>,
    /// The system of each body.
    pub solves: Vec<Solve>,
    /// Whether constraints are adaptive.
    pub is_adaptive: bool,
    /// Most iterations.
    pub iterations: u32,
}

impl Solving {
    /// The parameters of a scene.
    pub fn of(solver: &Solver) -> Self {
        let (ice, acad) = (&solver.ice, &solver.acad);
        let is_adaptive = solver.method == Method::Acad;
        let squared = |strain: f64| {
            let stretch = (1.0 + strain) as f32;
            stretch * stretch
        };
        let (epsilon, form) = if is_adaptive { (acad.epsilon, acad.form) } else { (ice.epsilon, ice.form) };
        Self {
            activation: squared(acad.threshold),
            release: squared(acad.release),
            aim: if is_adaptive { (1.0 + acad.target) as f32 } else { 1.0 },
            epsilon: epsilon as f32,
            form: form as u32,
            tolerance_squared: (ice.tolerance * ice.tolerance) as f32,
            most_iterations: ice.max_iterations,
            is_adaptive: is_adaptive.into(),
            is_warm: ice.warm_start.into(),
            is_automatic: u32::from(ice.newton_steps == 0),
            ..Self::default()
        }
    }
}

impl ConstraintTables {
    /// The constraints of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Result<Self, String> {
        let (assembly, range) = (bodies.assembly, &bodies.range);
        let all = assembly.constraints();
        let ends = [range.start, range.end.wrapping_sub(1)].map(|body| all.bodies.get(body));
        let [Some(first), Some(last)] = ends else { return Ok(Self::default()) };
        let mut tables = Self { numbers: first.start..last.end, ..Self::default() };
        if assembly.solver.is_primal() || tables.numbers.is_empty() {
            return Ok(Self::default());
        }
        tables.is_adaptive = assembly.solver.method == Method::Acad;
        tables.add_constraints(assembly, bodies.places.start);
        let always = !tables.is_adaptive;
        for (index, body) in bodies.iter() {
            tables.add_groups(all.bodies[index].clone(), bodies.local(body.first), body.nodes, always);
        }
        tables.list_incident(bodies.len())?;
        tables.iterations = needed::iterations(assembly, range.clone());
        Ok(tables)
    }

    /// Whether there is no constraint.
    pub fn is_empty(&self) -> bool {
        self.constraints.is_empty()
    }

    fn add_constraints(&mut self, assembly: &Assembly, first_place: usize) {
        let (all, active) = (assembly.constraints(), assembly.solver.method != Method::Acad);
        let local = |node: u32| node - first_place as u32;
        self.constraints.extend(self.numbers.clone().map(|number| {
            let [k, damping] = all.materials[all.material[number] as usize].map(|c| c as f32);
            let [a, b] = all.ends[number].map(local);
            Constraint { a, b, k, damping, rest_length: all.rest[number] as f32, is_active: active.into() }
        }));
    }

    /// Cuts a body's constraints and nodes into groups.
    pub(crate) fn add_groups(
        &mut self,
        constraints: Range<usize>,
        first_node: u32,
        nodes: usize,
        always: bool,
    ) {
        let (solve, first_group) = (self.solves.len() as u32, self.constraint_groups.len() as u32);
        let (first, count) = ((constraints.start - self.numbers.start) as u32, constraints.len());
        let part = |all: usize, start: usize| GROUP.min(all - start) as u32;
        self.constraint_groups.extend((0..count).step_by(GROUP).map(|start| ConstraintGroup {
            first: first + start as u32,
            count: part(count, start),
            solve,
            first_group,
            groups: count.div_ceil(GROUP) as u32,
        }));
        self.node_groups.extend((0..nodes).step_by(GROUP).map(|start| NodeGroup {
            first: first_node + start as u32,
            count: part(nodes, start),
            solve,
            first_group,
            is_first: (start == 0).into(),
        }));
        let active_constraints = if always { count as u32 } else { 0 };
        self.solves.push(Solve { constraints: count as u32, active_constraints, ..Solve::default() });
    }

    /// Entries by node, sixteen nodes side by side.
    fn list_incident(&mut self, places: usize) -> Result<(), String> {
        let ends: Vec<[u32; 2]> =
            self.constraints.iter().map(|constraint| [constraint.a, constraint.b]).collect();
        let by_place = Csr::corners(places, &ends);
        let slices = places / LANES;
        self.incident = vec![0; slices + 1];
        for slice in 0..slices {
            let rows = (0..LANES).map(|lane| by_place.row(LANES * slice + lane));
            let longest = rows.clone().map(<[u32]>::len).max().unwrap_or(0);
            self.incident[slice] = self.incident.len() as u32;
            for i in 0..longest {
                self.incident.extend(rows.clone().map(|row| row.get(i).copied().unwrap_or(NONE)));
            }
        }
        let end = u32::try_from(self.incident.len());
        self.incident[slices] = end.map_err(|_| "too many springs for 32 bits".to_owned())?;
        Ok(())
    }
}
