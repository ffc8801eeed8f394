//! Springs of a segment that are solved for by nodes, on the device, and how their system is solved in a sub-step.

use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP};
use crate::gpu::recorder::Recorder;
use crate::solvers::dual::gpu_layout::{Met, Taken};
use crate::solvers::implicit::gpu_layout::{
    CoarseEdge, Diagonal, LevelGroup, NodeSolve, Parents, Share, SlotSpring, Symmetric, VECTORS, Vector,
};
use crate::solvers::implicit::gpu_tables::Levelled;
use taffeta_gpu::{Bindable, Buffer, Counts, DispatchList, Gpu, GpuError, ReadBack};

/// Iterations from one count of open systems to the next.
const BETWEEN_COUNTS: u32 = 2;
/// Steps beside iterations: that which takes the changes to start from.
const MORE_STEPS: u32 = 1;

/// A level, or a part of one, as kernels see it.
struct Part {
    groups: Buffer<LevelGroup>,
    edges: Buffer<CoarseEdge>,
}

/// What springs that are solved for by nodes need.
pub struct Primal {
    /// All groups and edges of each level; those that iterations have on coarser levels; tails.
    parts: Vec<Part>,
    slots: Buffer<u32>,
    slot_springs: Buffer<SlotSpring>,
    parents: Buffer<Parents>,
    children: Buffer<Share>,
    edge_shares: Buffer<Share>,
    level_sizes: Buffer<u32>,
    spring_blocks: Buffer<Four>,
    coarse_blocks: Buffer<Symmetric>,
    diagonals: Buffer<Diagonal>,
    vectors: Buffer<Four>,
    met: Buffer<Met>,
    node_solves: Buffer<NodeSolve>,
    product_sums: Buffer<Four>,
    counts: Counts,
    taken: Buffer<Taken>,
    read_taken: ReadBack<Taken>,
    /// Nodes on all levels, and places.
    nodes: usize,
    places: usize,
    levels: usize,
    newton_steps: u32,
    /// Steps that are written down for a Newton step.
    steps: u32,
}

impl Primal {
    /// Takes tables to the device; `None` where nothing is solved for.
    pub fn new(gpu: &Gpu, levelled: &Levelled, places: usize) -> Result<Option<Self>, GpuError> {
        if levelled.is_empty() {
            return Ok(None);
        }
        let Levelled { groups, wide, tail, nodes, slot_counts: [fine, coarse], .. } = levelled;
        let part = |groups: &[LevelGroup], edges: &[CoarseEdge]| -> Result<Part, GpuError> {
            Ok(Part {
                groups: gpu.buffer_from("groups of levels", groups)?,
                edges: gpu.buffer_from("edges of levels", edges)?,
            })
        };
        let mut parts = vec![part(&groups[0], &[])?];
        for (groups, edges) in groups[1..].iter().zip(&levelled.edges) {
            parts.push(part(groups, edges)?);
        }
        for groups in wide.iter().chain([tail]) {
            parts.push(part(groups, &[])?);
        }
        let cycle = [&groups[0]].into_iter().chain(wide).chain([tail]);
        let sizes: Vec<u32> = cycle.map(|groups| groups.len() as u32).collect();
        Ok(Some(Self {
            parts,
            slots: gpu.buffer_from("springs by node", &levelled.slots)?,
            slot_springs: gpu.buffer_from("springs of slots", &levelled.slot_springs)?,
            parents: gpu.buffer_from("coarser nodes", &levelled.parents)?,
            children: gpu.buffer_from("finer nodes", &levelled.children)?,
            edge_shares: gpu.buffer_from("finer edges", &levelled.edge_shares)?,
            level_sizes: gpu.buffer_from("sizes of levels", &sizes)?,
            spring_blocks: gpu.buffer("blocks of springs", *fine)?,
            coarse_blocks: gpu.buffer("blocks of coarser edges", *coarse)?,
            diagonals: gpu.buffer("diagonal blocks", *nodes)?,
            vectors: gpu.buffer("vectors of springs", VECTORS * nodes)?,
            met: gpu.buffer("nodes of springs", places)?,
            node_solves: gpu.buffer("systems of springs", levelled.solves)?,
            product_sums: gpu.buffer("sums of springs", groups[0].len())?,
            counts: gpu.counts("workgroups of iterations", sizes.len())?,
            taken: gpu.buffer("what springs take", 1)?,
            read_taken: gpu.read_back("what springs take", 1)?,
            nodes: *nodes,
            places,
            levels: groups.len(),
            newton_steps: levelled.newton_steps,
            steps: levelled.iterations.saturating_add(MORE_STEPS),
        }))
    }

    /// Its buffers by their names in the sources, those of one part among them.
    pub fn buffers(&self, part: usize) -> Vec<(&str, &dyn Bindable)> {
        vec![
            ("level_groups", &self.parts[part].groups),
            ("coarse_edges", &self.parts[part].edges),
            ("slots", &self.slots),
            ("slot_springs", &self.slot_springs),
            ("parents", &self.parents),
            ("children", &self.children),
            ("edge_shares", &self.edge_shares),
            ("level_sizes", &self.level_sizes),
            ("spring_blocks", &self.spring_blocks),
            ("coarse_blocks", &self.coarse_blocks),
            ("diagonals", &self.diagonals),
            ("vectors", &self.vectors),
            ("met", &self.met),
            ("node_solves", &self.node_solves),
            ("product_sums", &self.product_sums),
            ("level_counts", &self.counts),
            ("taken", &self.taken),
        ]
    }

    /// The part that iterations have of a coarser level.
    fn wide(&self, level: usize) -> usize {
        self.levels + level - 1
    }

    /// Coarser levels of which iterations have a part.
    fn wide_levels(&self) -> usize {
        let part = |level: &usize| !self.parts[self.wide(*level)].groups.is_empty();
        (1..self.levels).filter(part).count()
    }

    /// The part of all tails.
    fn tail(&self) -> usize {
        self.parts.len() - 1
    }

    /// Dispatches of a sub-step.
    pub fn dispatches(&self) -> usize {
        let of_step = 6 + 4 * self.wide_levels();
        (self.newton_steps as usize) * (self.steps as usize * of_step + 3 * self.levels)
    }

    /// Forgets what the frame before has taken.
    pub fn start_frame(&self, gpu: &Gpu) {
        self.taken.write(gpu, 0, &[Taken::default()]);
    }

    /// What springs changed of each place's velocity [m/s]; waits for it.
    pub fn solver_state(&self, gpu: &Gpu) -> Result<Vec<f64>, GpuError> {
        let vectors = self.vectors.read(gpu)?;
        let first = Vector::Pulled as usize * self.nodes;
        let pulled = vectors[first..first + self.places].iter();
        Ok(pulled.flat_map(|&[x, y, z, _]| [x, y, z].map(f64::from)).collect())
    }

    /// Takes it back; three numbers a place.
    pub fn set_solver_state(&self, gpu: &Gpu, pulled: &[f64]) {
        let fours: Vec<Four> = pulled
            .as_chunks::<3>()
            .0
            .iter()
            .map(|&[x, y, z]| [x as f32, y as f32, z as f32, 0.0])
            .take(self.places)
            .collect();
        self.vectors.write(gpu, Vector::Pulled as usize * self.nodes, &fours);
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
    /// Finds what springs change of velocities, where all other forces are known, and adds it.
    pub(crate) fn find_changes(&mut self, substep: usize) {
        let Some(primal) = &self.segment.primal else { return };
        let (nodes, newton_steps) = (primal.parts[0].groups.len(), primal.newton_steps);
        self.list.stage("constraints");
        self.dispatch("free_nodes", substep, nodes);
        self.dispatch("pins_all", substep, self.counts.pins.div_ceil(GROUP));
        if self.meets_meshes() {
            self.dispatch_on_meshes("meet_meshes_by_nodes", substep, nodes);
        }
        self.dispatch("meet_nodes", substep, nodes);
        for newton in 0..newton_steps {
            if newton > 0 {
                self.dispatch("step_on", substep, nodes);
            }
            self.set_up_levels(substep);
            self.dispatch("start_nodes", substep, nodes);
            self.descend(substep);
        }
        self.dispatch("note_descents", substep, 1);
        self.dispatch("spring_impulses", substep, nodes);
        self.dispatch("push_nodes", substep, nodes);
    }

    /// Blocks and diagonals of all levels.
    fn set_up_levels(&mut self, substep: usize) {
        let Some(primal) = &self.segment.primal else { return };
        let sizes = |part: &Part| (part.groups.len(), part.edges.len().div_ceil(GROUP));
        let sizes: Vec<(usize, usize)> = primal.parts[..primal.levels].iter().map(sizes).collect();
        for (level, (groups, edges)) in sizes.into_iter().enumerate() {
            if level == 0 {
                self.dispatch("set_up_nodes", substep, groups);
                continue;
            }
            let entry = if level == 1 { "coarsen_springs" } else { "coarsen_edges" };
            self.dispatch_part((entry, level), substep, edges);
            self.dispatch_part(("coarsen_nodes", level), substep, groups);
        }
    }

    /// Conjugate gradients.
    fn descend(&mut self, substep: usize) {
        let Some(primal) = &self.segment.primal else { return };
        let (steps, wide, tail) = (primal.steps, primal.wide_levels(), primal.tail());
        let has_tail = !primal.parts[tail].groups.is_empty();
        let level = |level: usize| (primal.wide(level), level);
        let levels: Vec<(usize, usize)> = (1..=wide).map(level).collect();
        let tail = (tail, primal.levels);
        for step in 0..steps {
            if step % BETWEEN_COUNTS == 0 {
                self.dispatch("count_descents", substep, 1);
            }
            self.counted("step_nodes", substep, (0, 0));
            if step + 1 == steps {
                // Nothing asks for what it leaves.
                break;
            }
            self.counted("left_of_nodes", substep, (0, 0));
            for &level in &levels {
                self.counted("restrict_level", substep, level);
                self.counted("left_of_level", substep, level);
            }
            if has_tail {
                self.counted("cycle_tail", substep, tail);
            }
            for &level in levels.iter().rev() {
                self.counted("follow_level", substep, level);
                self.counted("smooth_level", substep, level);
            }
            self.counted("follow_level", substep, (0, 0));
            self.counted("smooth_nodes", substep, (0, 0));
            self.counted("apply_nodes", substep, (0, 0));
        }
    }

    /// A kernel on a part of a level.
    fn dispatch_part(&mut self, (entry, part): (&'static str, usize), substep: usize, groups: usize) {
        if groups > 0 && self.fault.is_ok() {
            let bound = self.segment.bound(self.kernels, (Name::new(entry), part), substep);
            self.fault = bound.map(|(bound, offsets)| self.list.dispatch(&bound, &offsets, groups as u32));
        }
    }

    /// A kernel on a part of a level, in as many workgroups as were counted for it.
    fn counted(&mut self, entry: &'static str, substep: usize, (part, which): (usize, usize)) {
        if self.fault.is_ok() {
            let bound = self.segment.bound(self.kernels, (Name::new(entry), part), substep);
            self.fault = bound.map(|(bound, offsets)| {
                if let Some(primal) = &self.segment.primal {
                    self.list.dispatch_counted(&bound, &offsets, &primal.counts, which);
                }
            });
        }
    }
}
