//! The constraint solver of 2021 as printed, and the same with other ways to multiply by its matrix.

mod pattern;
#[cfg(test)]
mod tests;

use crate::build::Assembly;
use crate::diagnostics::SolverReport;
use crate::gpu::kernels::Name;
use crate::gpu::paper::GROUP;
use crate::gpu::paper::spring_centric::{Spring, SpringLists};
use crate::gpu::paper::volume::KeptVolumes;
use crate::gpu::recorder::Recorder;
use crate::gpu::tables::Tables;
use crate::topology::Csr;
use bytemuck::{Pod, Zeroable};
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, Gpu, GpuError};

/// Most springs of which SpMM() is run: it starts their square of threads.
pub const MOST_PRINTED: usize = 7_000;
/// Rows and columns of a workgroup of SpMM().
const SIDE: usize = 32;
/// Invocations of the workgroups that are ours.
const OUR_GROUP: usize = 256;
/// Sums over all constraints, as in `solve.wgsl`.
const SUMS: usize = 4;

const SOURCES: &[&str] = &[
    include_str!("../spring_centric.wgsl"),
    include_str!("../volume.wgsl"),
    include_str!("system.wgsl"),
    include_str!("solve.wgsl"),
    include_str!("products.wgsl"),
];

/// How the matrix J M⁻¹ Jᵀ of the constraint solver of 2021 is multiplied by a vector.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ConstraintProduct {
    /// As printed: in COO, made by a thread for each two springs, a thread for each entry.
    Printed,
    /// In CSR, a thread for each row.
    Csr,
    /// In ELLPACK, a thread for each row.
    Ell,
    /// Without the matrix: a thread for each node, then one for each spring.
    MatrixFree,
}

/// `PrintedTriplet` of system.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Triplet {
    pub row: f32,
    pub column: f32,
    pub value: f32,
}

/// The sources of an entry point, if it is one of these.
pub fn sources(entry: &str) -> &'static [&'static str] {
    let found = SOURCES[2..].iter().any(|source| source.contains(&format!("fn {entry}(")));
    if found { SOURCES } else { &[] }
}

/// Every spring a constraint, and the system that they make.
pub struct Constraints {
    pub lists: SpringLists,
    product: ConstraintProduct,
    nodes: usize,
    /// Of conjugate gradients, in each step.
    iterations: u32,
    /// Where rows of J begin, and columns of its values; the same for columns and rows of its transpose.
    jacobian: [Buffer<u32>; 4],
    matrix: Matrix,
    /// Of J.
    values: Buffer<f32>,
    vect: Buffer<f32>,
    /// Φ, right side, λ, r, p, A p.
    vectors: [Buffer<f32>; 6],
    sums: Buffer<f32>,
}

/// What a product by J M⁻¹ Jᵀ needs; the rest is empty.
struct Matrix {
    system: Buffer<Triplet>,
    counter: Buffer<u32>,
    /// CSR or ELLPACK: where rows begin, columns, values.
    rows: (Buffer<u32>, Buffer<u32>, Buffer<f32>),
    /// Without the matrix: where rows of nodes begin, ends of constraints at them, M⁻¹ Jᵀ p.
    ends: (Buffer<u32>, Buffer<u32>, Buffer<f32>),
}

impl Matrix {
    fn new(
        gpu: &Gpu,
        product: ConstraintProduct,
        pairs: &[[u32; 2]],
        nodes: usize,
    ) -> Result<Self, GpuError> {
        let by_node = Csr::corners(nodes, pairs);
        let (mut entries, mut rows, mut ends) = (0, Csr::default(), Csr::default());
        match product {
            ConstraintProduct::Printed => entries = pattern::entries(pairs, &by_node),
            ConstraintProduct::Csr => rows = pattern::csr(pairs, &by_node),
            ConstraintProduct::Ell => rows.items = pattern::ell(pairs, &by_node),
            ConstraintProduct::MatrixFree => ends = by_node,
        }
        let node_numbers = if ends.items.is_empty() { 0 } else { 3 * nodes };
        Ok(Self {
            system: gpu.buffer("system in COO", entries)?,
            counter: gpu.buffer("number of entries", 1)?,
            rows: (
                gpu.buffer_from("rows of the system", &rows.offsets)?,
                gpu.buffer_from("columns of the system", &rows.items)?,
                gpu.buffer("values of the system", rows.items.len())?,
            ),
            ends: (
                gpu.buffer_from("rows of nodes", &ends.offsets)?,
                gpu.buffer_from("constraints at nodes", &ends.items)?,
                gpu.buffer("products of nodes", node_numbers)?,
            ),
        })
    }
}

impl Constraints {
    /// The springs of some bodies of a scene.
    pub fn new(
        gpu: &Gpu,
        product: ConstraintProduct,
        assembly: &Assembly,
        bodies: Range<usize>,
        tables: &Tables,
    ) -> Result<Self, GpuError> {
        let springs = springs(assembly, bodies, tables);
        let volumes = KeptVolumes::new(gpu, &[], tables)?;
        let lists = SpringLists::of_springs(gpu, &springs, &[], volumes, tables)?;
        let (m, nodes) = (springs.len(), tables.len());
        let pairs: Vec<[u32; 2]> = springs.iter().map(|&Spring { a, b, .. }| [a, b]).collect();
        let (starts, columns) = jacobian(&pairs);
        let list = |label, list: &[u32]| gpu.buffer_from(label, list);
        let vector = |label| gpu.buffer(label, m);
        Ok(Self {
            lists,
            product,
            nodes,
            iterations: assembly.solver.ice.max_iterations,
            jacobian: [
                list("IA", &starts)?,
                list("JA", &columns)?,
                list("JB", &starts)?,
                list("IB", &columns)?,
            ],
            matrix: Matrix::new(gpu, product, &pairs, nodes)?,
            values: gpu.buffer("A", 6 * m)?,
            vect: gpu.buffer("Vect", 3 * nodes)?,
            vectors: [
                vector("Phi")?,
                vector("Rhs")?,
                vector("Lambda")?,
                vector("r")?,
                vector("p")?,
                vector("Result")?,
            ],
            sums: gpu.buffer("sums of constraints", SUMS)?,
        })
    }

    /// Its buffers by their names in the sources.
    pub fn buffers(&self) -> Vec<(&'static str, &dyn Bindable)> {
        let [ia, ja, jb, ib] = &self.jacobian;
        let [phi, rhs, lambda, residual, direction, product] = &self.vectors;
        let Matrix { system, counter, rows, ends } = &self.matrix;
        let own: [(&'static str, &dyn Bindable); 22] = [
            ("printed_ia", ia),
            ("printed_ja", ja),
            ("printed_jb", jb),
            ("printed_ib", ib),
            ("printed_sys", system),
            ("printed_nnz", counter),
            ("printed_sys_starts", &rows.0),
            ("printed_sys_columns", &rows.1),
            ("printed_sys_values", &rows.2),
            ("printed_end_starts", &ends.0),
            ("printed_ends_at", &ends.1),
            ("printed_node_product", &ends.2),
            ("printed_j", &self.values),
            ("printed_vect", &self.vect),
            ("printed_phi", phi),
            ("printed_rhs", rhs),
            ("printed_lambda", lambda),
            ("printed_residual", residual),
            ("printed_p", direction),
            ("printed_product", product),
            ("printed_product_bits", product),
            ("printed_sums", &self.sums),
        ];
        self.lists.buffers().into_iter().chain(own).collect()
    }

    /// Adds what the last sub-step has found.
    pub fn report(&self, gpu: &Gpu, report: &mut SolverReport) -> Result<(), GpuError> {
        let sums = self.sums.read(gpu)?;
        let [.., left, right] = sums[..] else { return Ok(()) };
        let residual = if right > 0.0 { f64::from(left / right).sqrt() } else { 0.0 };
        report.iterations = report.iterations.max(self.iterations);
        report.residual = report.residual.max(residual);
        report.active_fraction = 1.0;
        Ok(())
    }

    /// What the recorder needs to know of it.
    pub fn shape(&self) -> Shape {
        Shape {
            product: self.product,
            springs: self.lists.counts()[0],
            nodes: self.nodes,
            entries: self.matrix.system.len(),
            iterations: self.iterations,
        }
    }
}

/// The springs of some bodies, with ends counted from the first place of `tables`.
fn springs(assembly: &Assembly, bodies: Range<usize>, tables: &Tables) -> Vec<Spring> {
    let all = &assembly.constraints;
    let first = tables.places.start as u32;
    let spring = |i: usize| {
        let [a, b] = all.ends[i].map(|node| node - first);
        Spring { a, b, rest_length: all.rest[i] as f32, kind: 0 }
    };
    bodies.flat_map(|body| all.bodies[body].clone()).map(spring).collect()
}

/// J in CSR: where rows begin, and the columns of its values. Each row has three values a node.
fn jacobian(pairs: &[[u32; 2]]) -> (Vec<u32>, Vec<u32>) {
    let starts = (0..=pairs.len() as u32).map(|row| 6 * row).collect();
    let columns = pairs.as_flattened().iter().flat_map(|node| [0, 1, 2].map(|axis| 3 * node + axis));
    (starts, columns.collect())
}

/// What a system is dispatched by.
#[derive(Clone, Copy, Debug)]
pub struct Shape {
    product: ConstraintProduct,
    springs: usize,
    nodes: usize,
    /// Of the matrix in COO.
    entries: usize,
    iterations: u32,
}

impl Recorder<'_> {
    /// A sub-step by constraints alone: the eleven kernels of table 1, then UpdateNodes() of 2023, for which S1 has no name.
    pub fn constraints(&mut self, shape: Shape, substep: usize, loads_given: bool) {
        self.list.stage("system");
        self.build(shape, substep, loads_given);
        self.list.stage("solve");
        self.over(self.summing(shape, "initial_step"), substep, shape.springs);
        for _ in 0..shape.iterations {
            self.list.stage("product");
            self.multiply(shape, substep);
            self.list.stage("solve");
            self.over(self.summing(shape, "compute_alpha"), substep, shape.springs);
            self.over(("update_lambda", GROUP), substep, shape.springs);
            self.over(self.summing(shape, "compute_beta"), substep, shape.springs);
            self.over(("update_p", GROUP), substep, shape.springs);
        }
        self.list.stage("force");
        self.over(("compute_force", GROUP), substep, shape.springs);
        self.go_on_in_place();
        let update = Name { loads_given, ..Name::new("spring_centric_update") };
        self.dispatch_kernel(update, substep, shape.nodes.div_ceil(GROUP));
    }

    /// ConstructingSys.
    fn build(&mut self, shape: Shape, substep: usize, loads_given: bool) {
        self.over(("compute_phi", GROUP), substep, shape.springs);
        let vect = Name { loads_given, ..Name::new("compute_vect") };
        self.dispatch_kernel(vect, substep, shape.nodes.div_ceil(GROUP));
        self.over(("compute_rhs", GROUP), substep, shape.springs);
        match shape.product {
            ConstraintProduct::Printed => {
                let groups = [shape.springs.div_ceil(SIDE) as u32; 2];
                self.over_plane(Name::new("spmm"), groups, substep);
            }
            ConstraintProduct::Csr => self.over(("fill_csr", OUR_GROUP), substep, shape.springs),
            ConstraintProduct::Ell => self.over(("fill_ell", OUR_GROUP), substep, shape.springs),
            ConstraintProduct::MatrixFree => {}
        }
    }

    /// A p.
    fn multiply(&mut self, shape: Shape, substep: usize) {
        match shape.product {
            ConstraintProduct::Printed => self.over(("spmv", GROUP), substep, shape.entries),
            ConstraintProduct::Csr => self.over(("spmv_csr", OUR_GROUP), substep, shape.springs),
            ConstraintProduct::Ell => self.over(("spmv_ell", OUR_GROUP), substep, shape.springs),
            ConstraintProduct::MatrixFree => {
                self.over(("gather_printed_nodes", OUR_GROUP), substep, shape.nodes);
                self.over(("apply_printed_rows", OUR_GROUP), substep, shape.springs);
            }
        }
    }

    /// A kernel that adds up, as printed or by workgroups first.
    fn summing(&self, shape: Shape, entry: &'static str) -> (&'static str, usize) {
        match (shape.product, entry) {
            (ConstraintProduct::Printed, _) => (entry, GROUP),
            (_, "initial_step") => ("initial_step_by_groups", OUR_GROUP),
            (_, "compute_alpha") => ("compute_alpha_by_groups", OUR_GROUP),
            _ => ("compute_beta_by_groups", OUR_GROUP),
        }
    }

    /// A kernel, with a thread for each of `count`, in workgroups of some size.
    fn over(&mut self, (entry, group): (&'static str, usize), substep: usize, count: usize) {
        self.dispatch_kernel(Name::new(entry), substep, count.div_ceil(group));
    }
}
