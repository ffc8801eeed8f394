//! Contact of surfaces on the GPU.
//!
//! Lists are filled by counting up, and sorted where their order matters. How many workgroups look at them is counted on the device
//! ([`count.wgsl`](SHADERS)), so that a frame needs no read-back in between. A list that is too short says so at the end of the
//! frame, and the frame is repeated with more room.

use crate::advice::Refusal;
use crate::assembly::Assembly;
use crate::backend::{ContactForce, SolverState};
use crate::contact::check_in_one_piece;
use crate::contact::colliders::gpu::contact_of;
use crate::contact::colliders::lift::Lift;
use crate::contact::triangles::carry::PUSHES;
use crate::contact::triangles::filter::JAMS;
use crate::contact::triangles::gpu_layout::{
    self as layout, FORCE_RECORDS, LEVELS, SolvedContact, SurfaceContact,
};
use crate::contact::triangles::gpu_tables::{CornersMoved, Room, SurfaceTables};
use crate::contact::triangles::order::{Candidate, Order, Way};
use crate::contact::triangles::surfaces::{Kind, corners_at};
use crate::contact::triangles::tangle::Tangle;
use crate::gpu::feature::{Command, Dispatch, Feature, Features, Groups, Seen, Upload};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP, NONE, Substep};
use crate::gpu::needed::Needed;
use crate::gpu::partition::fill;
use crate::gpu::schedule::Fused;
use crate::report::FrameSums;
use crate::step::{FILTERS, IMPULSES, Op, Stage};
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, Counts, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "contact/triangles",
    [
        "add.wgsl",
        "carry.wgsl",
        "closest.wgsl",
        "cones.wgsl",
        "count.wgsl",
        "filter.wgsl",
        "find.wgsl",
        "hold.wgsl",
        "impulse.wgsl",
        "leaf_pairs.wgsl",
        "list.wgsl",
        "most.wgsl",
        "pull.wgsl",
        "rounds.wgsl",
        "slide.wgsl",
        "solved.wgsl",
        "surfaces.wgsl",
        "tangle.wgsl"
    ]
);

/// Numbers of parts of commands: levels of boxes, and what is counted.
const PARTS: usize = if LEVELS > layout::COUNT_SOLVED { LEVELS } else { layout::COUNT_SOLVED + 1 };

/// Bits of `SHORT`.
const SHORT_OF_PAIRS: u32 = 1;
const SHORT_OF_CONTACTS: u32 = 2;
const SHORT_OF_ROUNDS: u32 = 4;
const SHORT_OF_JAMS: u32 = 8;
const SHORT_OF_PUSHES: u32 = 16;
const SHORT_OF_IMPULSES: u32 = 32;

/// How often nodes that are held back may hold back others; the last time all planes stand still.
const MOST_JAMS: usize = JAMS as usize + 1;

/// Bytes of the arrays that a body with a surface needs, and their contents.
pub fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    let body = &assembly.bodies[body];
    let bytes = (layout::PLACE_ARRAYS * size_of::<Four>() * body.places()) as u64;
    body.surface_contact().map_or(Vec::new(), |_| vec![(bytes, "places of surfaces")])
}

/// Refuses surfaces in several partitions.
pub fn check_together(assembly: &Assembly, partitions: &[Range<usize>], limit: u64) -> Result<(), Refusal> {
    let has_surface = |index: usize| assembly.bodies[index].surface_contact().is_some();
    check_in_one_piece(assembly, partitions, limit, has_surface)
}

/// Contact of surfaces on the device.
pub struct TriangleContact {
    tables: SurfaceTables,
    room: Room,
    words: Buffer<u32>,
    /// For each level of boxes, and each thing that is counted, its number.
    parts: Vec<Buffer<u32>>,
    places: Buffer<Four>,
    /// Corners of colliders in all sub-steps that are handed over, where some move.
    corners: Buffer<Four>,
    boxes: Buffer<Four>,
    /// Where surfaces pass through each other.
    knots: Buffer<u32>,
    tangle: Option<Tangle>,
    /// Whether they may; then it is looked for after each frame, until none does. Whether it must be looked for before the next
    /// frame, too: nodes have been put elsewhere. How many edges pierce triangles, if it was looked for after the last frame.
    is_tangled: bool,
    is_stale: bool,
    intersections: Option<u64>,
    /// Nodes that are led out of colliders.
    lifts: Vec<Lift>,
    /// Where corners of colliders are [m].
    corners_now: Vec<[f32; 3]>,
    lists: Lists,
    counts: Counts,
    read: ReadBack<u32>,
    /// What the last frame has counted.
    counted: Vec<u32>,
    /// What frames need of what is written down: rounds of impulses and of the filter, jams, pushes.
    needed: Needed<4>,
    /// Sub-steps of the frame: each searches.
    substeps: u64,
}

/// Lists that grow.
struct Lists {
    pairs: Buffer<[u32; 4]>,
    contacts: Buffer<SurfaceContact>,
    solved: Buffer<SolvedContact>,
    forces: Buffer<[u32; 4]>,
    work: Buffer<u32>,
}

impl Lists {
    /// With the forces of the last sub-step.
    fn new(
        gpu: &Gpu,
        tables: &SurfaceTables,
        room: Room,
        forces: &[(Order, [f32; 3])],
    ) -> Result<Self, GpuError> {
        let lists = Self {
            pairs: gpu.buffer("pairs of leaves", room.pairs)?,
            contacts: gpu.buffer("contacts of surfaces", room.contacts)?,
            solved: gpu.buffer("contacts in systems", if tables.is_solved { room.contacts } else { 1 })?,
            forces: gpu.buffer("forces of contacts", FORCE_RECORDS * room.contacts)?,
            work: gpu.buffer("lists of contacts", tables.work(room))?,
        };
        lists.put_forces(gpu, tables, room, forces);
        Ok(lists)
    }

    /// Puts the forces of the last sub-step where the next one looks for them.
    fn put_forces(&self, gpu: &Gpu, tables: &SurfaceTables, room: Room, forces: &[(Order, [f32; 3])]) {
        let buckets = tables.buckets();
        let mut first = vec![NONE; 2 * buckets];
        let (mut next, mut words) = (Vec::new(), Vec::new());
        for (number, (order, force)) in (0..).zip(forces) {
            let order = order_words(order);
            let bucket = bucket_of(order, buckets);
            next.push(std::mem::replace(&mut first[bucket], number));
            let [x, y, z] = force.map(f32::to_bits);
            words.extend([[order[0], order[1], order[2], 0], [x, y, z, 0], [0; 4]]);
        }
        let [next_at, first_at] = tables.force_lists(room);
        self.forces.write(gpu, 0, &words);
        self.work.write(gpu, next_at, &next);
        self.work.write(gpu, first_at, &first);
        let mut counted = [0; layout::LISTS];
        counted[layout::FORCES] = forces.len() as u32;
        self.work.write(gpu, 0, &counted);
    }
}

/// As kernels have it: both leaves, and what it is in them.
fn order_words(order: &Order) -> [u32; 3] {
    let Candidate { way, one, other } = order.pair;
    [order.leaves[0], order.leaves[1], (way as u32) << 16 | u32::from(one) << 8 | u32::from(other)]
}

pub fn order_of([a, b, pair]: [u32; 3]) -> Order {
    let way = match pair >> 16 {
        0 => Way::VertexTriangle,
        1 => Way::TriangleVertex,
        _ => Way::EdgeEdge,
    };
    Order::new([a, b], Candidate { way, one: (pair >> 8) as u8, other: pair as u8 })
}

/// `bucket_of` of surfaces.wgsl.
pub fn bucket_of([a, b, pair]: [u32; 3], buckets: usize) -> usize {
    let mixed = a.wrapping_mul(0x9e37_79b1) ^ b.wrapping_mul(0x85eb_ca6b) ^ pair.wrapping_mul(0xc2b2_ae35);
    (mixed ^ mixed >> 15) as usize & (buckets - 1)
}

impl TriangleContact {
    /// Takes tables to the device; `None` where there are no surfaces.
    pub fn new(gpu: &Gpu, tables: &SurfaceTables) -> Result<Option<Self>, GpuError> {
        if tables.is_empty() {
            return Ok(None);
        }
        let (mut tables, room) = (tables.clone(), tables.room());
        tables.put_room(room);
        let part = |number: u32| gpu.buffer_from("part of a command", &[number]);
        Ok(Some(Self {
            words: gpu.buffer_from("surfaces", &tables.words)?,
            parts: (0..PARTS as u32).map(part).collect::<Result<_, _>>()?,
            places: gpu.buffer_from("places of surfaces", &tables.start())?,
            corners: gpu.buffer("corners of colliders", 1)?,
            boxes: gpu.buffer("boxes of surfaces", 4 * tables.boxes())?,
            knots: gpu.buffer("surfaces that pass through each other", 1)?,
            tangle: None,
            is_tangled: tables.start_tangled,
            // Colliders look who is led out of them.
            is_stale: tables.leads_out,
            intersections: None,
            lifts: Vec::new(),
            corners_now: tables.corners[..tables.corners.len() - 1].to_vec(),
            lists: Lists::new(gpu, &tables, room, &[])?,
            counts: gpu.counts("workgroups of contact", layout::ON_BOXES + LEVELS)?,
            read: gpu.read_back("counted of surfaces", layout::LISTS)?,
            counted: Vec::new(),
            needed: Needed::new(),
            substeps: 0,
            tables,
            room,
        }))
    }

    /// A kernel with an invocation for each of some.
    fn each(&self, entry: &'static str, count: usize) -> Command<'_> {
        Command::run(Name::new(entry), count.div_ceil(GROUP))
    }

    fn count(&self, what: usize) -> Command<'_> {
        Command::run_part(Name::new("count_surfaces"), what, 1)
    }

    /// A kernel in as many workgroups as are counted.
    fn counted(&self, name: Name, on: usize) -> Command<'_> {
        self.counted_part(name, 0, on)
    }

    fn counted_part(&self, name: Name, part: usize, on: usize) -> Command<'_> {
        Command::Dispatch(Dispatch { name, part, groups: Groups::Counted(&self.counts, on) })
    }

    /// Lists pairs of leaves, and finds contacts, where `take` has put what there is.
    fn find(&self, take: &'static str) -> Vec<Command<'_>> {
        let leaves = self.tables.leaves();
        let all = self.tables.all_places().max(leaves).max(self.tables.buckets());
        let mut commands = vec![self.each(take, all), self.each("bound_leaves", leaves)];
        for (level, [_, count]) in self.tables.levels.iter().enumerate().skip(1) {
            commands.push(Command::run_part(Name::new("bound_level"), level, count.div_ceil(GROUP)));
        }
        let counted = |entry, on| self.counted(Name::new(entry), on);
        commands.extend([
            Command::run(Name::new("list_leaf_pairs"), leaves.div_ceil(layout::LEAF_GROUP)),
            self.count(layout::COUNT_PAIRS),
            counted("find_surface_contacts", layout::ON_PAIRS),
        ]);
        if self.tables.pulls() > 0 {
            commands.push(self.each("add_pulls", self.tables.pulls()));
        }
        commands.extend([
            self.count(layout::COUNT_CONTACTS),
            counted("place_parts", layout::ON_TOUCHED),
            counted("fill_parts", layout::ON_CONTACTS),
            counted("sort_parts", layout::ON_CONTACTS),
        ]);
        commands
    }

    /// Finds the contacts that may come about while a system is solved for.
    pub fn find_for_solver(&self) -> Vec<Command<'_>> {
        self.find("take_start")
    }

    /// A kernel with an invocation for each of them.
    pub fn each_for_solver(&self, entry: &'static str) -> Command<'_> {
        self.counted(Name::new(entry), layout::ON_CONTACTS)
    }

    /// Keeps what a solver has found, for the rounds after it.
    pub fn keep_solved(&self) -> Vec<Command<'_>> {
        vec![self.each_for_solver("keep_solved"), self.count(layout::COUNT_SOLVED)]
    }

    /// A round of impulses.
    fn round(&self, features: &Features) -> Vec<Command<'_>> {
        let [_, contact] = contact_of(features);
        let apply = Name::new("apply_impulses").with(contact.choices());
        vec![
            self.counted(Name::new("correct_impulses"), layout::ON_ROUND_CONTACTS),
            self.counted(apply, layout::ON_ROUND_TOUCHED),
            self.count(layout::COUNT_ROUND),
        ]
    }

    /// Boxes around all leaves, and then a list of pairs of leaves, if they are counted.
    fn list(&self) -> Vec<Command<'_>> {
        let mut commands = vec![self.counted(Name::new("bound_leaves"), layout::ON_BOXES)];
        for level in 1..self.tables.levels.len() {
            commands.push(self.counted_part(Name::new("bound_level"), level, layout::ON_BOXES + level));
        }
        commands.push(self.counted(Name::new("list_leaf_pairs"), layout::ON_LIST));
        commands
    }

    /// Colliders that move carry what is in their way, in all parts that are written down.
    fn carry(&self) -> Vec<Command<'_>> {
        if self.room.parts == 0 {
            return Vec::new();
        }
        let counted = |entry, on| self.counted(Name::new(entry), on);
        let part = || [self.count(layout::COUNT_PART), counted("advance_corners", layout::ON_CORNERS)];
        let mut commands = vec![self.each("measure_places", self.tables.all_places())];
        for _ in 0..self.room.parts {
            commands.extend(part());
            commands.extend(self.list());
            commands.push(self.count(layout::COUNT_CARRIED));
            for _ in 0..self.room.pushes {
                commands.extend([
                    counted("push_nodes", layout::ON_PUSH),
                    counted("take_pushes", layout::ON_TAKE),
                    self.count(layout::COUNT_PUSHES),
                ]);
            }
        }
        commands.extend(part());
        commands
    }

    /// All rounds of the filter that are written down.
    fn filter(&self) -> Vec<Command<'_>> {
        let counted = |entry, on| self.counted(Name::new(entry), on);
        let mut commands = vec![counted("note_forces", layout::ON_CONTACTS)];
        commands.extend(self.carry());
        for round in 0..self.room.rounds {
            commands.push(match round {
                0 => self.each("measure_ways", self.tables.all_places()),
                _ => counted("measure_ways", layout::ON_MEASURE),
            });
            commands.extend([self.count(layout::COUNT_WAYS), counted("go_part", layout::ON_PART)]);
            commands.extend(self.list());
            let limit = || [self.count(layout::COUNT_PAIRS), counted("limit_ways", layout::ON_PAIRS)];
            commands.extend(limit());
            let mark = || [counted("mark_held", layout::ON_MARK), self.count(layout::COUNT_HELD)];
            for _ in 0..self.room.jams {
                commands.extend(mark());
                commands.push(counted("list_leaf_pairs", layout::ON_LIST));
                commands.extend(limit());
            }
            if self.room.jams < MOST_JAMS {
                // Whether that was enough.
                commands.extend(mark());
            }
            commands.extend([counted("hold_back", layout::ON_HOLD), self.count(layout::COUNT_FILTER_ROUND)]);
        }
        commands
    }

    /// Makes lists of this length, with the forces of the last sub-step.
    fn give_room(&mut self, gpu: &Gpu, room: Room, forces: &[(Order, [f32; 3])]) -> Result<(), GpuError> {
        self.lists = Lists::new(gpu, &self.tables, room, forces)?;
        self.write_down(gpu, room);
        Ok(())
    }

    /// Writes down so many rounds, where lists are as long as before.
    fn write_down(&mut self, gpu: &Gpu, room: Room) {
        self.room = room;
        self.tables.put_room(room);
        self.words.write(gpu, 0, &self.tables.words[..layout::HEADER]);
    }

    /// Notes what a frame needed of what is written down, and leaves away what a number of them did not: each dispatch takes time,
    /// also without workgroups.
    fn note_needed(&mut self, gpu: &Gpu) {
        let words = [layout::MOST_IMPULSES, layout::MOST_ROUNDS, layout::MOST_JAMS, layout::MOST_PUSHES];
        let Some(most) = self.needed.note(words.map(|word| self.counted[word])) else { return };
        let [impulses, rounds, jams, pushes] = most.map(|needed| (needed as usize).max(1));
        let old = self.room;
        let room = Room {
            impulses: old.impulses.min(impulses),
            rounds: old.rounds.min(rounds),
            jams: old.jams.min(jams),
            pushes: old.pushes.min(pushes),
            ..old
        };
        if room != old {
            self.write_down(gpu, room);
        }
    }

    /// The forces of the last sub-step, in the order of contacts; waits for them. If the device is lost, the next frame that is
    /// submitted reports it.
    fn forces(&self, gpu: &Gpu) -> Vec<(Order, [f32; 3])> {
        let counted = self.lists.work.read(gpu).unwrap_or_default();
        let count = counted.get(layout::FORCES).map_or(0, |&count| count as usize);
        let words = self.lists.forces.read(gpu).unwrap_or_default();
        let force = |records: &[[u32; 4]]| {
            let [[a, b, pair, _], [x, y, z, _]] = [records[0], records[1]];
            (order_of([a, b, pair]), [x, y, z].map(f32::from_bits))
        };
        let mut all: Vec<_> = words.chunks_exact(FORCE_RECORDS).take(count).map(force).collect();
        all.sort_unstable_by_key(|(order, _)| *order);
        all
    }
}

impl Feature for TriangleContact {
    fn buffers(&self, part: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("surface_tables", &self.words),
            ("surface_part", &self.parts[part.min(PARTS - 1)]),
            ("surface_places", &self.places),
            ("surface_corners", &self.corners),
            ("surface_knots", &self.knots),
            ("surface_boxes", &self.boxes),
            ("surface_pairs", &self.lists.pairs),
            ("surface_contacts", &self.lists.contacts),
            ("solved_contacts", &self.lists.solved),
            ("surface_forces", &self.lists.forces),
            ("surface_work", &self.lists.work),
            ("surface_counts", &self.counts),
        ]
    }

    fn kernels<'f>(&'f self, features: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let keep = vec![self.each("keep_places", self.tables.places())];
        let round = [Op::SurfaceImpulses, Op::ApplySurfaceImpulses, Op::Contact].repeat(IMPULSES);
        let rounds = (0..self.room.impulses).flat_map(|_| self.round(features)).collect();
        let filter = [Op::SurfaceFilter, Op::ApplySurfaceFilter].repeat(FILTERS);
        vec![
            Fused::new(&[Op::Elements], keep),
            Fused::new(&[Op::SurfaceContacts], self.find("take_places")),
            Fused::new(&round, rounds),
            Fused::new(&filter, self.filter()),
        ]
    }

    fn bytes(&self, assembly: &Assembly) -> usize {
        if assembly.colliders_move() { 2 * self.tables.corners.len() * size_of::<Four>() } else { 0 }
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        self.substeps += upload.substeps.len() as u64;
        let mut all: Vec<Four> = Vec::new();
        self.room.parts = 0;
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            let CornersMoved { parts, longest_push, corners } = self.tables.corners_moved(substep);
            (record.corner_parts, record.longest_push) = (parts, longest_push);
            record.longest_step = substep.longest;
            record.first_corner = if corners.is_empty() { NONE } else { all.len() as u32 };
            self.room.parts = self.room.parts.max(parts as usize);
            all.extend(corners);
        }
        if let Some(last) = all.len().checked_sub(self.tables.corners.len()) {
            let corners = all[last..].iter().take(self.corners_now.len());
            self.corners_now = corners.map(|&[x, y, z, _]| [x, y, z]).collect();
        }
        fill(upload.gpu, "corners of colliders", &mut self.corners, &all)
    }

    fn start_frame(&mut self, gpu: &Gpu) {
        self.substeps = 0;
        self.intersections = None;
        self.lists.work.write(gpu, layout::SHORT, &[0; layout::SQUEEZED + 1 - layout::SHORT]);
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.lists.work, &self.read);
    }

    fn measure(&self, _: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let counted = |word: usize| self.counted.get(word).copied().unwrap_or(0);
        if self.intersections.is_some() {
            sums.intersections = self.intersections;
        }
        if self.substeps == 0 {
            // The sums are those of another frame.
            return Ok(());
        }
        sums.pairs.searches += self.substeps;
        sums.squeezed = counted(layout::SQUEEZED).checked_sub(1).map(|node| node + self.tables.first as u32);
        sums.pairs.pairs += u64::from(counted(layout::CONTACTS));
        if counted(layout::CONTACTS) > 0 {
            let nearest = f64::from(f32::from_bits(counted(layout::NEAREST)));
            sums.pairs.nearest = sums.pairs.nearest.min(nearest);
        }
        Ok(())
    }

    fn relocate(&mut self) {
        (self.is_tangled, self.is_stale) = (true, true);
    }

    fn looks(&self, before: bool) -> bool {
        if before { self.is_stale || !self.lifts.is_empty() } else { self.is_tangled }
    }

    fn see(&mut self, seen: &mut Seen<'_>) -> Result<bool, GpuError> {
        let mut is_asked = seen.time.is_none();
        if let Some(time) = seen.time {
            is_asked = std::mem::take(&mut self.is_stale);
            self.corners_now = corners_at(seen.assembly, time).map(|x| x.map(|x| x as f32)).collect();
            // Colliders have looked for them.
            self.lifts = seen.found.list::<Lift>().to_vec();
        }
        let Some(surfaces) = seen.assembly.surfaces() else { return Ok(false) };
        if is_asked {
            let nodes = seen.position.iter().map(|&[x, y, z, _]| [x, y, z]);
            let all: Vec<_> =
                nodes.chain(self.corners_now.iter().copied()).map(|x| x.map(f64::from)).collect();
            self.tangle = if self.is_tangled { Tangle::of(surfaces, &all) } else { None };
            self.is_tangled = self.tangle.is_some();
        }
        if seen.time.is_none() {
            self.intersections = Some(self.tangle.as_ref().map_or(0, |tangle| tangle.pairs));
        }
        let knots = self.tables.put_tangle(self.tangle.as_ref(), &self.lifts, surfaces);
        self.words.write(seen.gpu, 0, &self.tables.words[..layout::HEADER]);
        fill(seen.gpu, "surfaces that pass through each other", &mut self.knots, &knots)
    }

    fn dispatches(&self) -> usize {
        self.find("take_places").len() + self.filter().len() + 3 * self.room.impulses
    }

    fn may_repeat(&self) -> bool {
        true
    }

    fn lasting(&self) -> Vec<&dyn Bindable> {
        vec![&self.lists.forces, &self.lists.work]
    }

    fn is_short(&mut self, gpu: &Gpu) -> Result<bool, GpuError> {
        self.read.take(gpu, &mut self.counted)?;
        let is_short = self.counted.get(layout::SHORT).is_some_and(|&short| short > 0);
        if !is_short && self.substeps > 0 {
            self.note_needed(gpu);
        }
        Ok(is_short)
    }

    fn taken(&self) -> f64 {
        let squared = self.counted.get(layout::MOST_WAY_TAKEN).map_or(0.0, |&bits| f32::from_bits(bits));
        f64::from(squared).sqrt() / self.tables.mean_edge
    }

    fn grow(&mut self, gpu: &Gpu) -> Result<(), GpuError> {
        let [short, pairs, contacts] =
            [layout::SHORT, layout::MOST_PAIRS, layout::MOST_CONTACTS].map(|word| self.counted[word]);
        let wider = |room: usize, wanted: u32| room.max(wanted as usize) + (wanted / 2) as usize;
        let old = self.room;
        let grown = |flag: u32, old: usize, new: usize| if short & flag != 0 { new } else { old };
        let room = Room {
            pairs: grown(SHORT_OF_PAIRS, old.pairs, wider(old.pairs, pairs)),
            contacts: grown(SHORT_OF_CONTACTS, old.contacts, wider(old.contacts, contacts)),
            impulses: grown(SHORT_OF_IMPULSES, old.impulses, (2 * old.impulses).min(IMPULSES)),
            rounds: grown(SHORT_OF_ROUNDS, old.rounds, (4 * old.rounds).min(FILTERS)),
            jams: grown(SHORT_OF_JAMS, old.jams, (4 * old.jams).min(MOST_JAMS)),
            parts: old.parts,
            pushes: grown(SHORT_OF_PUSHES, old.pushes, (4 * old.pushes).min(PUSHES)),
        };
        if (room.pairs, room.contacts) == (old.pairs, old.contacts) {
            self.write_down(gpu, room);
            return Ok(());
        }
        let forces = self.forces(gpu);
        self.give_room(gpu, room, &forces)
    }

    fn save(&self, gpu: &Gpu, state: &mut SolverState) {
        state.is_tangled |= self.is_tangled;
        state.contacts.extend(self.forces(gpu).into_iter().map(|(order, force)| {
            let firsts = order.leaves.map(|leaf| self.tables.firsts[leaf as usize]);
            let (kind, pair) = (order.pair.way.kind() as u8, order.pair.key(firsts));
            ContactForce { kind, pair, force: force.map(f64::from) }
        }));
    }

    fn load(&mut self, gpu: &Gpu, state: &SolverState) -> bool {
        (self.is_tangled, self.is_stale) = (state.is_tangled, true);
        self.lifts.clear();
        let force = |one: &ContactForce| {
            let kind = Kind::ALL[usize::from(one.kind).min(1)];
            (Order::of_key(&self.tables.firsts, kind, one.pair), one.force.map(|force| force as f32))
        };
        let all: Vec<_> = state.contacts.iter().map(force).collect();
        let room = Room { contacts: self.room.contacts.max(all.len()), ..self.room };
        // If there is no memory for them, the next frame that is submitted says so.
        self.give_room(gpu, room, &all).is_ok()
    }
}
