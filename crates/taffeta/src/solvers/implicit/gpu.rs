//! Springs that are integrated implicitly on the GPU, and how their system is solved in a sub-step.

use crate::assembly::Assembly;
use crate::backend::SolverState;
use crate::contact::colliders::gpu::Colliders;
use crate::contact::colliders::gpu::Contact;
use crate::contact::triangles::gpu::TriangleContact;
use crate::elements::KINDS;
use crate::elements::gpu::Elements;
use crate::gpu::feature::{Command, Dispatch, Feature, Features, Groups, Upload};
use crate::gpu::kernels::{Choice, Name};
use crate::gpu::layout::{Four, GROUP, Solving, Substep};
use crate::gpu::needed::Needed;
use crate::gpu::schedule::Fused;
use crate::motion::gpu::Pins;
use crate::report::FrameSums;
use crate::scene::Ice;
use crate::solvers::dual::gpu::add_statistics;
use crate::solvers::dual::gpu_layout::{ContactRecord, SolveStatistics};
use crate::solvers::implicit::gpu_layout::{
    CoarseEdge, Diagonal, IS_LEFT, LevelGroup, MOST_OPEN_AT, NodeSolve, Parents, STEP_WORDS, SUMS,
    SlotSpring, Symmetric, VECTORS, Vector, WeightedIndex, When,
};
use crate::solvers::implicit::gpu_tables::{CouplingWords, MultigridTables};
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
        "level_stages.wgsl",
        "levels.wgsl",
        "moved.wgsl",
        "newton.wgsl",
        "no_contacts.wgsl",
        "no_couplings.wgsl",
        "second_order.wgsl",
        "set_up.wgsl",
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
const STEPS_AT_START: u32 = 3 * BETWEEN_NEWTON_STEPS + 1;
/// Steps beside iterations: that which takes the changes to start from.
const MORE_STEPS: u32 = 1;
/// Where the solver finds how many Newton steps it takes: iterations from one place where a further one may begin to the next,
/// how often as many iterations as a step may need it may take, and how often one may wait for its place.
const BETWEEN_NEWTON_STEPS: u32 = 16;
const NEEDS: u32 = 3;
const WAITS: u32 = 2;

/// Steps of conjugate gradients that are written down at most, where a Newton step may need so many `iterations`.
fn steps(iterations: u32, ice: &Ice) -> u32 {
    let further = NEEDS.saturating_mul(iterations).min(ice.max_iterations).max(iterations);
    let all = if ice.newton_steps == 0 { further + WAITS * BETWEEN_NEWTON_STEPS } else { iterations };
    all.saturating_add(MORE_STEPS)
}

/// A level, or a part of one, as kernels see it.
struct Part {
    groups: Buffer<LevelGroup>,
    edges: Buffer<CoarseEdge>,
}

/// Blocks of elements, and what they are made of.
struct CouplingBuffers {
    blocks: Buffer<[u32; 4]>,
    sources: Buffer<[u32; 2]>,
}

/// Which systems bodies have, and which of them contacts join.
struct JoinedBuffers {
    systems: Buffer<u32>,
    joins: Buffer<u32>,
}

/// Springs that are integrated implicitly, on the device.
pub struct Implicit {
    /// All groups and edges of each level; those that iterations have on coarser levels; tails.
    parts: Vec<Part>,
    slots: Buffer<u32>,
    slot_springs: Buffer<SlotSpring>,
    parents: Buffer<Parents>,
    children: Buffer<WeightedIndex>,
    edge_weights: Buffer<WeightedIndex>,
    level_sizes: Buffer<[u32; 2]>,
    /// The same on the host.
    counted: Vec<[u32; 2]>,
    spring_blocks: Buffer<Four>,
    coarse_blocks: Buffer<Symmetric>,
    /// Blocks of other elements, and what they are made of.
    couplings: Option<CouplingBuffers>,
    /// Which systems contacts of surfaces join, if there are some.
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
        for groups in wide.iter().chain([tail]) {
            parts.push(part(groups, &[])?);
        }
        let couplings = |words: &CouplingWords| -> Result<_, GpuError> {
            Ok(CouplingBuffers {
                blocks: gpu.buffer_from("blocks of elements", &words.words)?,
                sources: gpu.buffer_from("sources of blocks", &words.sources)?,
            })
        };
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
            parents: gpu.buffer_from("coarser nodes", &multigrid.parents)?,
            children: gpu.buffer_from("finer nodes", &multigrid.children)?,
            edge_weights: gpu.buffer_from("finer edges", &multigrid.edge_weights)?,
            level_sizes: gpu.buffer_from("sizes of levels", &counted)?,
            spring_blocks: gpu.buffer("blocks of springs", *fine)?,
            coarse_blocks: gpu.buffer("blocks of coarser edges", *coarse)?,
            couplings: multigrid.couplings.as_ref().map(couplings).transpose()?,
            joined: in_contact.then(joined).transpose()?,
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

    /// Finds what springs change of velocities, where all other forces are known, and adds it.
    fn find_changes<'f>(&'f self, features: &'f Features) -> Vec<Command<'f>> {
        let nodes = self.parts[0].groups.len();
        let run = |entry, groups| Command::run(self.name(entry), groups);
        let mut all = vec![run("free_nodes", nodes)];
        all.extend(features.get::<Pins>().map(Pins::command));
        if features.get::<Colliders>().is_some_and(Colliders::has_meshes) {
            let name = Name::new("predict_mesh_contacts_implicit").with(Contact::Meshes.choices());
            all.push(Command::run(name, nodes));
        }
        all.push(run("predict_contacts_implicit", nodes));
        if let Some(contacts) = self.contacts(features) {
            all.extend(self.find_contacts(contacts));
        }
        if self.is_automatic() {
            all.push(run("sum_motion", nodes));
        }
        for newton in 0..self.newton_steps.max(1) {
            if newton > 0 {
                all.push(run("next_newton_step", nodes));
            }
            self.linearise(features, &mut all);
            self.coarsen(&mut all);
            self.iterate(features, &mut all);
        }
        if let Some(contacts) = self.contacts(features) {
            all.extend([run("multiply_change", nodes), contacts.each_for_solver("apply_contacts")]);
            all.extend(contacts.keep_solved());
        }
        all.extend([
            run("record_implicit_statistics", 1),
            run("spring_impulses", nodes),
            run("add_implicit_forces", nodes),
        ]);
        all
    }

    /// Contacts of surfaces, if they are part of the system.
    fn contacts<'f>(&self, features: &'f Features) -> Option<&'f TriangleContact> {
        features.get::<TriangleContact>().filter(|_| self.joined.is_some())
    }

    /// Finds the contacts that may come about in the sub-step, and which systems they join.
    fn find_contacts<'f>(&self, contacts: &'f TriangleContact) -> Vec<Command<'f>> {
        let systems = self.node_solves.len().div_ceil(GROUP);
        let mut all = contacts.find_for_solver();
        all.extend([
            Command::run(Name::new("part_systems"), systems),
            contacts.each_for_solver("take_contacts"),
            Command::run(Name::new("name_systems"), systems),
        ]);
        all
    }

    /// Whether the solver finds how many Newton steps it takes.
    fn is_automatic(&self) -> bool {
        self.newton_steps == 0
    }

    /// A further Newton step, where one is needed and none is under way.
    fn go_on<'f>(&'f self, features: &'f Features, all: &mut Vec<Command<'f>>) {
        let nodes = self.parts[0].groups.len();
        let mut judged = Vec::new();
        if self.joined.is_some() {
            judged.push(Command::run(Name::new("multiply_change"), nodes));
        }
        judged.extend(
            ["spring_impulses", "next_newton_step"].map(|entry| Command::run(self.name(entry), nodes)),
        );
        self.linearise(features, &mut judged);
        judged.extend(["measure_left", "judge_systems"].map(|entry| Command::run(self.name(entry), nodes)));
        let mut begun = Vec::new();
        self.coarsen(&mut begun);
        all.push(Command::run(Name::new("count_next_step"), 1));
        all.extend(judged.into_iter().map(|command| self.when(When::Judged, command)));
        all.push(Command::run(Name::new("count_unmet"), 1));
        all.extend(begun.into_iter().map(|command| self.when(When::Begun, command)));
    }

    /// A command in as many workgroups as are counted for it; of no workgroups it stays as it is. So do those of contacts, which are
    /// counted by themselves: they find out by the state of a system whether its next step begins.
    fn when<'f>(&'f self, when: When, command: Command<'f>) -> Command<'f> {
        match command {
            Command::Dispatch(Dispatch { name, part, groups: Groups::Linear(groups) }) if groups > 0 => {
                let counted = self.counted.iter().position(|&one| one == [groups as u32, when as u32]);
                let index = counted.expect("MultigridTables::counted lists what a further step runs");
                Command::Dispatch(Dispatch { name, part, groups: Groups::Counted(&self.counts, index) })
            }
            other => other,
        }
    }

    /// A kernel that may import what a system is made of.
    fn name(&self, entry: &'static str) -> Name {
        let mut name = Name::new(entry);
        if self.couplings.is_some() {
            name = name.with(&[COUPLED]);
        }
        if self.joined.is_some() { name.with(&[CONTACTS]) } else { name }
    }

    /// Forces, blocks and diagonals of the finest level.
    fn linearise<'f>(&'f self, features: &'f Features, all: &mut Vec<Command<'f>>) {
        let nodes = self.parts[0].groups.len();
        if self.couplings.is_some() {
            all.extend(features.get::<Elements>().into_iter().flat_map(|all| all.linearise(&[MOVED])));
            all.push(Command::run(Name::new("set_up_couplings"), nodes));
        }
        all.push(Command::run(self.name("set_up_nodes"), nodes));
        if let Some(contacts) = self.contacts(features) {
            all.push(contacts.each_for_solver("linearise_contacts"));
            all.push(Command::run(Name::new("add_contacts"), nodes));
        }
    }

    /// Blocks and diagonals of coarser levels, and what iterations start from.
    fn coarsen<'f>(&'f self, all: &mut Vec<Command<'f>>) {
        for (level, part) in self.parts[..self.levels].iter().enumerate().skip(1) {
            let (groups, edges) = (part.groups.len(), part.edges.len().div_ceil(GROUP));
            if self.couplings.is_some() {
                all.push(Command::run_part(Name::new("coarsen_couplings"), level, groups));
                continue;
            }
            let entry = if level == 1 { "coarsen_springs" } else { "coarsen_edges" };
            all.push(Command::run_part(Name::new(entry), level, edges));
            all.push(Command::run_part(Name::new("coarsen_nodes"), level, groups));
        }
        if self.couplings.is_some() {
            let levels = || self.parts[..self.levels].iter().enumerate();
            let of_all = |entry| {
                levels()
                    .map(move |(level, part)| Command::run_part(Name::new(entry), level, part.groups.len()))
            };
            all.extend(of_all("bound_couplings").chain(of_all("scale_inverses")));
        }
        let nodes = self.parts[0].groups.len();
        if self.joined.is_some() {
            all.push(Command::run(Name::new("multiply_cycled"), nodes));
        }
        all.push(Command::run(self.name("start_nodes"), nodes));
    }

    /// Conjugate gradients, in the steps that are written down.
    fn iterate<'f>(&'f self, features: &'f Features, all: &mut Vec<Command<'f>>) {
        let has_tail = !self.parts[self.tail()].groups.is_empty();
        let levels: Vec<(usize, usize)> =
            (1..=self.wide_levels()).map(|level| (self.wide(level), level)).collect();
        for step in 0..self.room {
            if self.is_automatic() && step > 0 && step % BETWEEN_NEWTON_STEPS == 0 {
                self.go_on(features, all);
            }
            if step % BETWEEN_COUNTS == 0 {
                all.push(Command::run(Name::new("count_open_systems"), 1));
            }
            all.push(self.counted("step_nodes", (0, 0)));
            if step + 1 == self.room {
                // Nothing asks for what it leaves.
                break;
            }
            all.extend(self.multiplied("multiply_cycle", "residual_of_nodes"));
            for &level in &levels {
                all.extend([self.counted("restrict_level", level), self.counted("residual_of_level", level)]);
            }
            if has_tail {
                all.push(self.counted("cycle_tail", (self.tail(), self.levels)));
            }
            for &level in levels.iter().rev() {
                all.extend([self.counted("prolong_level", level), self.counted("smooth_level", level)]);
            }
            all.push(self.counted("prolong_level", (0, 0)));
            all.extend(self.multiplied("multiply_cycle", "smooth_nodes"));
            all.extend(self.multiplied("multiply_cycled", "apply_nodes"));
        }
        all.push(Command::run(Name::new("count_left"), 1));
    }

    /// Leaves away what a number of frames did not need: each dispatch takes time, also without workgroups.
    fn note_needed(&mut self) {
        if let Some([most]) = self.needed.note([self.counted_steps[MOST_OPEN_AT]]) {
            let needed = (BETWEEN_COUNTS * most).next_multiple_of(BETWEEN_NEWTON_STEPS) + MORE_STEPS;
            self.room = self.room.min(needed);
        }
    }

    /// A kernel that needs a product with contacts, if there are some, and then that product before it.
    fn multiplied(&self, product: &'static str, entry: &'static str) -> impl Iterator<Item = Command<'_>> {
        let product = self.joined.is_some().then_some(product);
        product.into_iter().chain([entry]).map(|entry| self.counted(entry, (0, 0)))
    }

    /// A kernel on a part of a level, in as many workgroups as were counted for it.
    fn counted(&self, entry: &'static str, (part, which): (usize, usize)) -> Command<'_> {
        let groups = Groups::Counted(&self.counts, which);
        Command::Dispatch(Dispatch { name: self.name(entry), part, groups })
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
            ("parents", &self.parents),
            ("children", &self.children),
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
        if let Some(CouplingBuffers { blocks, sources }) = &self.couplings {
            let both: [(&'static str, &dyn Bindable); 2] =
                [("couplings", blocks), ("coupling_sources", sources)];
            all.extend(both);
        }
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
        Ok(false)
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
        let of_contacts = if self.joined.is_some() { 3 } else { 0 };
        let of_step = 6 + of_contacts + 4 * self.wide_levels();
        let of_elements = if self.couplings.is_some() { 1 + 2 * KINDS.len() + 2 * self.levels } else { 0 };
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

    fn grow(&mut self, _: &Gpu) -> Result<(), GpuError> {
        if self.counted_steps.get(IS_LEFT).is_some_and(|&left| left > 0) {
            self.room = (2 * self.room - MORE_STEPS).min(self.steps);
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
