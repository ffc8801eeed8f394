//! The constraint solver of 2021 as printed, and the same with other ways to multiply by its matrix.

mod pattern;
#[cfg(test)]
mod tests;

use crate::kernels::parts::{GROUP, Product, go_on_in_place, with_loads};
use crate::kernels::spring_centric::{Spring, SpringLists};
use crate::kernels::volume::KeptVolumes;
use taffeta::diagnostics::SolverReport;
use taffeta::extension::{Bodies, Command, Dispatch, Groups, Name};
use taffeta::taffeta_gpu::bytemuck::{Pod, Zeroable};
use taffeta::taffeta_gpu::{Bindable, Buffer, Gpu, GpuError};
use taffeta::topology::Csr;

/// Most springs of which SpMM() is run: it starts their square of threads.
pub const MOST_PRINTED: usize = 7_000;
/// Rows and columns of a workgroup of SpMM().
const SIDE: usize = 32;
/// Invocations of the workgroups that are ours.
const OUR_GROUP: usize = 256;
/// Sums over all constraints, as in `solve.wgsl`.
const SUMS: usize = 4;

/// `PrintedTriplet` of system.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
pub struct Triplet {
    pub row: f32,
    pub column: f32,
    pub value: f32,
}

/// Every spring a constraint, and the system that they make.
pub struct Constraints {
    pub lists: SpringLists,
    product: Product,
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
    fn new(gpu: &Gpu, product: Product, pairs: &[[u32; 2]], nodes: usize) -> Result<Self, GpuError> {
        let by_node = Csr::corners(nodes, pairs);
        let (mut entries, mut rows, mut ends) = (0, Csr::default(), Csr::default());
        match product {
            Product::Printed => entries = pattern::entries(pairs, &by_node),
            Product::Csr => rows = pattern::csr(pairs, &by_node),
            Product::Ell => rows.items = pattern::ell(pairs, &by_node),
            Product::MatrixFree => ends = by_node,
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
    /// The springs of some bodies.
    pub fn new(gpu: &Gpu, product: Product, bodies: &Bodies<'_>) -> Result<Self, GpuError> {
        let springs = springs(bodies);
        let volumes = KeptVolumes::new(gpu, bodies, false)?;
        let lists = SpringLists::of_springs(gpu, &springs, &[], volumes, bodies.len())?;
        let (m, nodes) = (springs.len(), bodies.len());
        let pairs: Vec<[u32; 2]> = springs.iter().map(|&Spring { a, b, .. }| [a, b]).collect();
        let (starts, columns) = jacobian(&pairs);
        let list = |label, list: &[u32]| gpu.buffer_from(label, list);
        let vector = |label| gpu.buffer(label, m);
        Ok(Self {
            lists,
            product,
            nodes,
            iterations: bodies.assembly.solver.ice.max_iterations,
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

    /// A sub-step by constraints alone: the eleven kernels of table 1, then UpdateNodes() of 2023, for which S1 has no name.
    pub fn commands<'f>(&self, loads_given: bool) -> Vec<Command<'f>> {
        let mut all = self.build(loads_given);
        all.extend([Command::Label("solve"), self.over(self.summing("initial_step"))]);
        for _ in 0..self.iterations {
            all.push(Command::Label("product"));
            all.extend(self.multiply());
            all.extend([
                Command::Label("solve"),
                self.over(self.summing("compute_alpha")),
                self.over(("update_lambda", GROUP)),
                self.over(self.summing("compute_beta")),
                self.over(("update_p", GROUP)),
            ]);
        }
        all.extend([Command::Label("force"), self.over(("compute_force", GROUP))]);
        all.extend(go_on_in_place());
        let update = with_loads("spring_centric_update", loads_given);
        all.push(Command::run(update, self.nodes.div_ceil(GROUP)));
        all
    }

    /// ConstructingSys.
    fn build<'f>(&self, loads_given: bool) -> Vec<Command<'f>> {
        let vect = with_loads("compute_vect", loads_given);
        let mut all = vec![
            self.over(("compute_phi", GROUP)),
            Command::run(vect, self.nodes.div_ceil(GROUP)),
            self.over(("compute_rhs", GROUP)),
        ];
        match self.product {
            Product::Printed => {
                let groups = Groups::Plane([self.lists.count().div_ceil(SIDE) as u32; 2], None);
                all.push(Command::Dispatch(Dispatch { name: Name::new("spmm"), part: 0, groups }));
            }
            Product::Csr => all.push(self.over(("fill_csr", OUR_GROUP))),
            Product::Ell => all.push(self.over(("fill_ell", OUR_GROUP))),
            Product::MatrixFree => {}
        }
        all
    }

    /// A p.
    fn multiply<'f>(&self) -> Vec<Command<'f>> {
        match self.product {
            Product::Printed => {
                vec![Command::run(Name::new("spmv"), self.matrix.system.len().div_ceil(GROUP))]
            }
            Product::Csr => vec![self.over(("spmv_csr", OUR_GROUP))],
            Product::Ell => vec![self.over(("spmv_ell", OUR_GROUP))],
            Product::MatrixFree => vec![
                Command::run(Name::new("gather_printed_nodes"), self.nodes.div_ceil(OUR_GROUP)),
                self.over(("apply_printed_rows", OUR_GROUP)),
            ],
        }
    }

    /// A kernel that adds up, as printed or by workgroups first.
    fn summing(&self, entry: &'static str) -> (&'static str, usize) {
        match (self.product, entry) {
            (Product::Printed, _) => (entry, GROUP),
            (_, "initial_step") => ("initial_step_by_groups", OUR_GROUP),
            (_, "compute_alpha") => ("compute_alpha_by_groups", OUR_GROUP),
            _ => ("compute_beta_by_groups", OUR_GROUP),
        }
    }

    /// A kernel, with a thread for each spring, in workgroups of some size.
    fn over<'f>(&self, (entry, group): (&'static str, usize)) -> Command<'f> {
        Command::run(Name::new(entry), self.lists.count().div_ceil(group))
    }
}

/// The springs of some bodies, with ends counted from the first of their places.
fn springs(bodies: &Bodies<'_>) -> Vec<Spring> {
    let all = bodies.assembly.constraints();
    let spring = |i: usize| {
        let [a, b] = all.ends[i].map(|node| bodies.local(node as usize));
        Spring { a, b, rest_length: all.rest[i] as f32, kind: 0 }
    };
    bodies.range.clone().flat_map(|body| all.bodies[body].clone()).map(spring).collect()
}

/// J in CSR: where rows begin, and the columns of its values. Each row has three values a node.
fn jacobian(pairs: &[[u32; 2]]) -> (Vec<u32>, Vec<u32>) {
    let starts = (0..=pairs.len() as u32).map(|row| 6 * row).collect();
    let columns = pairs.as_flattened().iter().flat_map(|node| [0, 1, 2].map(|axis| 3 * node + axis));
    (starts, columns.collect())
}
