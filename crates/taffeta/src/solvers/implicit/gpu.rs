//! Springs that are integrated implicitly on the GPU.

mod commands;

use crate::assembly::Assembly;
use crate::backend::SolverState;
use crate::elements::KINDS;
use crate::gpu::feature::{Command, Feature, Features, Upload};
use crate::gpu::kernels::{Choice, Name};
use crate::gpu::layout::{Four, Solving, Substep};
use crate::gpu::needed::Needed;
use crate::gpu::schedule::Fused;
use crate::plan;
use crate::report::FrameSums;
use crate::scene::Ice;
use crate::solvers::dual::gpu::add_statistics;
use crate::solvers::dual::gpu_layout::{ContactRecord, SolveStatistics};
use crate::solvers::implicit::gpu_layout::{
    CoarseEdge, Diagonal, IS_LEFT, LevelGroup, MOST_OPEN_AT, NodeSolve, STEP_WORDS, SUMS, SlotSpring,
    Symmetric, VECTORS, Vector, WeightedIndex,
};
use crate::solvers::implicit::gpu_sewn::{Followers, Sewn};
use crate::solvers::implicit::gpu_tables::MultigridTables;
use crate::solvers::implicit::implicit::LAST_PAIRS;
use crate::step::{Marks, Op, Stage};
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, Counts, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "solvers/implicit",
    [
        "contacts.wgsl",
        "couplings.wgsl",
        "couplings_stages.wgsl",
        "implicit.wgsl",
        "joined_systems.wgsl",
        "level_stages.wgsl",
        "levels.wgsl",
        "moved.wgsl",
        "newton.wgsl",
        "no_contacts.wgsl",
        "no_couplings.wgsl",
        "second_order.wgsl",
        "set_up.wgsl",
        "sewn.wgsl",
        "sewn_stages.wgsl",
        "stages.wgsl",
        "with_contacts.wgsl"
    ]
);

/// What kernels import, where they have no other choice: a system of springs alone.
pub const DEFAULTS: &[Shader] = &[
    ("contacts", "#import solvers/implicit/no_contacts.wgsl\n"),
    ("couplings", "#import solvers/implicit/no_couplings.wgsl\n"),
];

/// For kernels of a system of springs and other elements.
pub const COUPLED: Choice = ("couplings", "solvers/implicit/couplings.wgsl");

/// For kernels of a system that contacts of surfaces are part of.
pub const CONTACTS: Choice = ("contacts", "solvers/implicit/with_contacts.wgsl");

/// For kernels of elements where the Newton step starts.
pub const MOVED: Choice = ("memory", "solvers/implicit/moved.wgsl");

/// Iterations from one count of open systems to the next.
const BETWEEN_COUNTS: u32 = 2;
/// Most steps that are written down at the start, with a place where a further Newton step may begin at the end.
const STEPS_AT_START: u32 = 3 * BETWEEN_NEWTON_STEPS + MORE_STEPS;
/// Steps beside iterations: that which takes the changes to start from, and that which finds whether a further Newton step, which
/// begins at the last place for it, is needed.
const MORE_STEPS: u32 = 2;
/// Where the solver finds how many Newton steps it takes: iterations from one place where a further one may begin to the next,
/// how often as many iterations as a step may need it may take, and how often one may wait for its place.
const BETWEEN_NEWTON_STEPS: u32 = 16;
const NEEDS: u32 = 3;
const WAITS: u32 = 2;

/// Steps of conjugate gradients that are written down at most, where a Newton step may need so many `iterations`.
fn steps(iterations: u32, ice: &Ice) -> u32 {
    let further = NEEDS.saturating_mul(iterations);
    let all = if ice.newton_steps == 0 { further + WAITS * BETWEEN_NEWTON_STEPS } else { iterations };
    all.saturating_add(MORE_STEPS)
}

/// Steps for what had open systems at so many counts, of one iteration at least: without any there would be none to double.
fn room_for(counts: u32) -> u32 {
    let iterations = (BETWEEN_COUNTS * counts).saturating_sub(MORE_STEPS).max(1);
    iterations.next_multiple_of(BETWEEN_NEWTON_STEPS) + MORE_STEPS
}

/// Steps for twice the iterations.
fn doubled(room: u32) -> u32 {
    2 * room - MORE_STEPS
}

/// A level, or a part of one, as kernels see it.
struct Part {
    groups: Buffer<LevelGroup>,
    edges: Buffer<CoarseEdge>,
}

/// Which systems bodies have, and which of them contacts and seams join.
struct JoinedBuffers {
    systems: Buffer<u32>,
    joins: Buffer<u32>,
}

/// Springs that are integrated implicitly, on the device.
pub struct Implicit {
    /// All groups and edges of each level; those that iterations have on coarser levels; tails; the second once more once all
    /// seams are closed, where that makes a difference.
    parts: Vec<Part>,
    slots: Buffer<u32>,
    slot_springs: Buffer<SlotSpring>,
    /// At first; and once all seams are closed.
    followers: Followers,
    sewn_followers: Option<Followers>,
    edge_weights: Buffer<WeightedIndex>,
    level_sizes: Buffer<[u32; 2]>,
    /// The same on the host.
    counted: Vec<[u32; 2]>,
    spring_blocks: Buffer<Four>,
    coarse_blocks: Buffer<Symmetric>,
    /// Points that seams make.
    sewn: Option<Sewn>,
    /// Whether there are contacts of surfaces.
    in_contact: bool,
    /// Which systems those or seams join, if there are some.
    joined: Option<JoinedBuffers>,
    diagonals: Buffer<Diagonal>,
    vectors: Buffer<Four>,
    predicted_contacts: Buffer<ContactRecord>,
    node_solves: Buffer<NodeSolve>,
    product_sums: Buffer<Four>,
    counts: Counts,
    statistics: Buffer<SolveStatistics>,
    read_statistics: ReadBack<SolveStatistics>,
    /// Nodes on all levels; places among those of the scene, of which there are so many.
    nodes: usize,
    places: Range<usize>,
    scene_places: usize,
    solving: Solving,
    /// Whether changes are kept from one sub-step to the next.
    keeps_changes: bool,
    levels: usize,
    newton_steps: u32,
    is_second_order: bool,
    /// Steps that a Newton step may need, and those that are written down for one. If these do not suffice the frame is repeated.
    steps: u32,
    room: u32,
    step_words: Buffer<u32>,
    read_steps: ReadBack<u32>,
    /// What the last frame has counted of them, and the last place at which systems were open in frames.
    counted_steps: Vec<u32>,
    needed: Needed<1>,
}

impl Implicit {
    /// Takes tables to the device; `None` where nothing is solved for. `in_contact`: whether some of these bodies have contact of
    /// surfaces.
    pub fn new(
        gpu: &Gpu,
        assembly: &Assembly,
        (multigrid, in_contact): (&MultigridTables, bool),
        places: Range<usize>,
    ) -> Result<Option<Self>, GpuError> {
        if multigrid.is_empty() {
            return Ok(None);
        }
        let MultigridTables { groups, wide, tail, nodes, slot_counts: [fine, coarse], .. } = multigrid;
        let part = |groups: &[LevelGroup], edges: &[CoarseEdge]| -> Result<Part, GpuError> {
            Ok(Part {
                groups: gpu.buffer_from("groups of levels", groups)?,
                edges: gpu.buffer_from("edges of levels", edges)?,
            })
        };
        let mut parts = vec![part(&groups[0], &[])?];
        for (groups, edges) in groups[1..].iter().zip(&multigrid.edges) {
            parts.push(part(groups, edges)?);
        }
        let sewn_levels = multigrid.sewn_levels.as_deref();
        for groups in wide.iter().chain([tail]).chain(sewn_levels.iter().flat_map(|sewn| &sewn.wide)) {
            parts.push(part(groups, &[])?);
        }
        let sewn = Sewn::new(gpu, multigrid)?;
        let joined = || -> Result<_, GpuError> {
            Ok(JoinedBuffers {
                systems: gpu.buffer_from("systems of nodes", &multigrid.systems(places.len()))?,
                joins: gpu.buffer("joined systems", multigrid.solves)?,
            })
        };
        let counted = multigrid.counted();
        let ice = &assembly.solver.ice;
        Ok(Some(Self {
            parts,
            slots: gpu.buffer_from("springs by node", &multigrid.slots)?,
            slot_springs: gpu.buffer_from("springs of slots", &multigrid.slot_springs)?,
            followers: Followers::new(gpu, multigrid)?,
            sewn_followers: sewn_levels.map(|levels| Followers::new(gpu, levels)).transpose()?,
            edge_weights: gpu.buffer_from("finer edges", &multigrid.edge_weights)?,
            level_sizes: gpu.buffer_from("sizes of levels", &counted)?,
            spring_blocks: gpu.buffer("blocks of springs", *fine)?,
            coarse_blocks: gpu.buffer("blocks of coarser edges", *coarse)?,
            in_contact,
            joined: (in_contact || sewn.as_ref().is_some_and(Sewn::may_join)).then(joined).transpose()?,
            sewn,
            diagonals: gpu.buffer("diagonal blocks", *nodes)?,
            vectors: gpu.buffer("vectors of springs", VECTORS * nodes)?,
            predicted_contacts: gpu.buffer("nodes of springs", multigrid.finest)?,
            node_solves: gpu.buffer("systems of springs", multigrid.solves)?,
            product_sums: gpu.buffer("sums of springs", SUMS * groups[0].len())?,
            counts: gpu.counts("workgroups of iterations", counted.len())?,
            counted,
            statistics: gpu.buffer("what springs take", 1)?,
            read_statistics: gpu.read_back("what springs take", 1)?,
            nodes: *nodes,
            places,
            scene_places: assembly.places,
            solving: Solving::of(&assembly.solver),
            keeps_changes: ice.warm_start || !assembly.colliders().is_empty(),
            levels: groups.len(),
            newton_steps: ice.newton_steps,
            is_second_order: assembly.solver.is_second_order(),
            steps: steps(multigrid.iterations, ice),
            room: steps(multigrid.iterations, ice).min(STEPS_AT_START),
            step_words: gpu.buffer("steps that are written down", STEP_WORDS)?,
            read_steps: gpu.read_back("steps that are written down", STEP_WORDS)?,
            counted_steps: Vec::new(),
            needed: Needed::new(),
        }))
    }

    /// Leaves away what a number of frames did not need: each dispatch takes time, also without workgroups.
    fn note_needed(&mut self) {
        if let Some([most]) = self.needed.note([self.counted_steps[MOST_OPEN_AT]]) {
            self.room = self.room.min(room_for(most));
        }
    }

    /// What is kept from one sub-step to the next.
    fn kept(&self) -> impl Iterator<Item = Vector> {
        let changes = self.keeps_changes.then_some(Vector::SpringChange);
        changes.into_iter().chain(self.is_second_order.then_some(Vector::Rate))
    }

    /// Where the numbers of its places are among all that are kept, of the sort `index`.
    fn own(&self, index: usize) -> Range<usize> {
        let first = index * self.scene_places;
        3 * (first + self.places.start)..3 * (first + self.places.end)
    }

    /// A vector of each place; waits for it.
    fn numbers(&self, gpu: &Gpu, which: Vector) -> Result<Vec<f64>, GpuError> {
        let vectors = self.vectors.read(gpu)?;
        let first = which as usize * self.nodes;
        let all = vectors[first..first + self.places.len()].iter();
        Ok(all.flat_map(|&[x, y, z, _]| [x, y, z].map(f64::from)).collect())
    }
}

impl Feature for Implicit {
    fn buffers(&self, part: usize) -> Vec<(&'static str, &dyn Bindable)> {
        // Parts of elements are of kinds, and their kernels see no level.
        let level = &self.parts[part.min(self.parts.len() - 1)];
        let mut all: Vec<(&'static str, &dyn Bindable)> = vec![
            ("level_groups", &level.groups),
            ("coarse_edges", &level.edges),
            ("slots", &self.slots),
            ("slot_springs", &self.slot_springs),
            ("edge_weights", &self.edge_weights),
            ("level_sizes", &self.level_sizes),
            ("spring_blocks", &self.spring_blocks),
            ("coarse_blocks", &self.coarse_blocks),
            ("diagonals", &self.diagonals),
            ("vectors", &self.vectors),
            ("predicted_contacts", &self.predicted_contacts),
            ("node_solves", &self.node_solves),
            ("product_sums", &self.product_sums),
            ("level_counts", &self.counts),
            ("statistics", &self.statistics),
            ("written_steps", &self.step_words),
        ];
        if let Some(JoinedBuffers { systems, joins }) = &self.joined {
            let both: [(&'static str, &dyn Bindable); 2] = [("systems", systems), ("joins", joins)];
            all.extend(both);
        }
        all.extend(self.sewn_followers().unwrap_or(&self.followers).buffers());
        all.extend(self.sewn.iter().flat_map(Sewn::buffers));
        all
    }

    fn kernels<'f>(&'f self, features: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let all = [Op::Predict, Op::Solve, Op::ConstraintForces];
        let mut table = vec![Fused::new(&all, self.find_changes(features)).on(Marks::SOLVED, Marks::NONE)];
        if self.is_second_order {
            // After the kernel that moves all nodes as Euler's step does.
            let place = vec![Command::run(Name::new("place_implicit_nodes"), self.parts[0].groups.len())];
            table.push(Fused { writes_state: true, ..Fused::new(&[Op::Integrate], place) });
        }
        table
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            record.solving = self.solving.stepping(substep.h, substep.scheme());
        }
        let is_closed = upload.substeps.iter().any(plan::Substep::is_sewn);
        Ok(self.sewn.as_mut().is_some_and(|sewn| sewn.close(is_closed)))
    }

    fn start_frame(&mut self, gpu: &Gpu) {
        self.statistics.write(gpu, 0, &[SolveStatistics::default()]);
        self.step_words.write(gpu, 0, &[0; STEP_WORDS]);
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.statistics, &self.read_statistics);
        list.copy(&self.step_words, &self.read_steps);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        add_statistics(&self.read_statistics, gpu, &mut sums.solver)
    }

    fn dispatches(&self) -> usize {
        let of_contacts = if self.in_contact { 3 } else { 0 };
        let of_seams = if self.sewn.is_some() { 4 + 2 * LAST_PAIRS } else { 0 };
        let of_step = 6 + of_contacts + of_seams + 4 * self.wide().len();
        let of_elements =
            if self.followers.has_elements() { 1 + 2 * KINDS.len() + 2 * self.levels } else { 0 };
        let set_up = 6 + 2 * of_contacts + 3 * self.levels + of_elements;
        let further = if self.is_automatic() { self.room / BETWEEN_NEWTON_STEPS } else { 0 };
        let of_iterations = self.room as usize * of_step + further as usize * set_up;
        self.newton_steps.max(1) as usize * (of_iterations + set_up)
    }

    fn write_all(&mut self) {
        self.room = self.steps;
    }

    fn may_repeat(&self) -> bool {
        self.steps > STEPS_AT_START
    }

    fn lasting(&self) -> Vec<&dyn Bindable> {
        vec![&self.vectors]
    }

    fn is_short(&mut self, gpu: &Gpu) -> Result<bool, GpuError> {
        if !self.may_repeat() {
            return Ok(false);
        }
        self.read_steps.take(gpu, &mut self.counted_steps)?;
        let is_short = self.counted_steps[IS_LEFT] > 0 && self.room < self.steps;
        // Where no sub-step was run no system was open.
        if !is_short && self.counted_steps[MOST_OPEN_AT] > 0 {
            self.note_needed();
        }
        Ok(is_short)
    }

    /// Velocity changes are by the length of the step.
    fn rescale(&mut self, gpu: &Gpu, by: f32) -> Result<(), GpuError> {
        if self.keeps_changes {
            let first = Vector::SpringChange as usize * self.nodes;
            let vectors = self.vectors.read(gpu)?;
            let changes = vectors[first..first + self.places.len()].iter();
            let scaled: Vec<Four> = changes.map(|change| change.map(|number| by * number)).collect();
            self.vectors.write(gpu, first, &scaled);
        }
        Ok(())
    }

    fn grow(&mut self, _: &Gpu) -> Result<(), GpuError> {
        if self.counted_steps.get(IS_LEFT).is_some_and(|&left| left > 0) {
            self.room = doubled(self.room).min(self.steps);
        }
        Ok(())
    }

    fn save(&self, gpu: &Gpu, state: &mut SolverState) {
        // Elsewhere springs change nothing.
        state.warm_start.resize(3 * self.scene_places * self.kept().count(), 0.0);
        for (index, kept) in self.kept().enumerate() {
            let own = self.own(index);
            let numbers = self.numbers(gpu, kept).unwrap_or_else(|_| vec![f64::NAN; own.len()]);
            state.warm_start[own].copy_from_slice(&numbers);
        }
    }

    fn load(&mut self, gpu: &Gpu, state: &SolverState) -> bool {
        for (index, kept) in self.kept().enumerate() {
            let own = state.warm_start.get(self.own(index)).unwrap_or_default();
            let fours: Vec<Four> = (own.as_chunks::<3>().0.iter())
                .map(|&[x, y, z]| [x as f32, y as f32, z as f32, 0.0])
                .collect();
            self.vectors.write(gpu, kept as usize * self.nodes, &fours);
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn room_is_for_what_was_needed_and_grows_from_any_size() {
        for counts in 0..200 {
            let room = room_for(counts);
            assert!(room >= BETWEEN_COUNTS * counts && doubled(room) > room, "{counts} counts: {room} steps");
        }
    }
}
