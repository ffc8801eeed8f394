//! Self-collision on the GPU.

use crate::advice::Refusal;
use crate::assembly::Assembly;
use crate::contact::check_in_one_piece;
use crate::contact::colliders::gpu::Contact;
use crate::contact::colliders::gpu::contact_of;
use crate::contact::nodes::gpu_layout::{ContactMaterial, Surface};
use crate::contact::nodes::pair;
use crate::contact::nodes::self_contact::Exclusions;
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features, Upload};
use crate::gpu::kernels::{Name, Overrides};
use crate::gpu::layout::{GROUP, NONE, Substep};
use crate::gpu::schedule::Fused;
use crate::gpu::sums::sum_groups;
use crate::report::FrameSums;
use crate::step::{Op, Stage};
use crate::topology::{Csr, LANES};
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] =
    shaders!("contact/nodes", ["cells.wgsl", "pair.wgsl", "broad_phase.wgsl", "stages.wgsl"]);

/// Edge of a cell relative to the largest thickness. It is that much more so that rounding in 32 bits loses no
/// neighbour.
pub const CELL: f64 = 1.0 + 1.0 / 64.0;

/// An override of broad_phase.wgsl: whether some surfaces do not meet others.
pub const HAS_LAYERS: &str = "HAS_LAYERS";

/// Bytes of the arrays that a self-colliding body needs, and their contents.
pub fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    let body = &assembly.bodies[body];
    let Some(self_contact) = body.self_contact() else { return Vec::new() };
    let exclusions = match &self_contact.exclusions {
        Exclusions::Grid(ways) => ways.len(),
        Exclusions::Mesh(rows) => rows.offsets.len() + rows.items.len(),
    };
    // At most four buckets for each node, and three numbers.
    vec![
        (body.places() as u64 * 28, "lists of nodes that touch"),
        (exclusions as u64 * 4, "nodes that do not touch"),
    ]
}

/// Refuses self-colliding bodies in several partitions.
pub fn check_together(assembly: &Assembly, partitions: &[Range<usize>], limit: u64) -> Result<(), Refusal> {
    let collides = |index: usize| assembly.bodies[index].self_contact().is_some();
    check_in_one_piece(assembly, partitions, limit, collides)
}

/// Tables of self-collision, on the host.
#[derive(Default)]
pub struct SelfCollisionTables {
    pub surfaces: Vec<Surface>,
    /// The surface of each slice of places, and the exclusion lists.
    pub exclusions: Vec<u32>,
    /// Whether some of them do not meet others.
    pub has_layers: bool,
    /// Places of all bodies.
    places: usize,
}

impl SelfCollisionTables {
    /// The tables of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Result<Self, String> {
        let colliding =
            || bodies.iter().filter_map(|(index, body)| Some((index, body, body.self_contact()?)));
        let widest = colliding().map(|(.., self_contact)| self_contact.surface.thickness).fold(0.0, f64::max);
        if widest == 0.0 {
            return Ok(Self::default());
        }
        let exclusions = vec![NONE; bodies.slices()];
        let mut tables = Self { exclusions, places: bodies.len(), ..Self::default() };
        let meetings = bodies.assembly.meetings();
        tables.has_layers = !meetings.all_meet();
        for (number, (index, body, self_contact)) in (0..).zip(colliding()) {
            let first = bodies.local(body.first);
            let slices = first as usize / LANES..(first as usize + body.places()) / LANES;
            tables.exclusions[slices].fill(number);
            let exclusions = u32::try_from(tables.exclusions.len());
            let exclusions =
                exclusions.map_err(|_| "too many nodes that do not touch for 32 bits".to_owned())?;
            let [high, wide] = match &self_contact.exclusions {
                Exclusions::Grid(ways) => tables.add_offsets(ways),
                Exclusions::Mesh(rows) => tables.add_rows(rows),
            };
            let (surface, layers) = (self_contact.surface, meetings.of_body(index));
            tables.surfaces.push(Surface {
                first,
                count: body.nodes as u32,
                cols: body.grid_layout.map_or(0, |[_, cols]| cols as u32),
                high,
                wide,
                exclusions,
                material: ContactMaterial {
                    thickness: surface.thickness as f32,
                    friction: surface.friction as f32,
                    restitution: surface.restitution as f32,
                },
                cells_a_metre: (1.0 / (widest * CELL)) as f32,
                memberships: layers.memberships.0,
                met_layers: layers.filter.0,
            });
        }
        Ok(tables)
    }

    /// Adds a bit for each offset within the largest ones. Returns these.
    fn add_offsets(&mut self, ways: &[[i32; 2]]) -> [u32; 2] {
        let [high, wide] =
            [0, 1].map(|axis| ways.iter().map(|way| way[axis].unsigned_abs()).max().unwrap_or(0));
        let mut bits = vec![0_u32; ((2 * high + 1) * (2 * wide + 1)).div_ceil(32) as usize];
        for &[row, col] in ways {
            let bit = (row + high as i32) * (2 * wide as i32 + 1) + col + wide as i32;
            bits[bit as usize / 32] |= 1 << (bit % 32);
        }
        self.exclusions.extend(bits);
        [high, wide]
    }

    fn add_rows(&mut self, rows: &Csr) -> [u32; 2] {
        self.exclusions.extend(rows.offsets.iter().chain(&rows.items));
        [0; 2]
    }

    /// Number of buckets, a power of two; 0 if no body collides.
    pub fn buckets(&self) -> usize {
        let nodes: usize = self.surfaces.iter().map(|surface| surface.count as usize).sum();
        if nodes == 0 { 0 } else { (2 * nodes).next_power_of_two().max(64) }
    }

    /// Numbers in the linked lists, with contacts and distances.
    pub fn words(&self) -> usize {
        if self.surfaces.is_empty() { 0 } else { self.buckets() + 3 * self.places }
    }
}

/// Self-collision on the device.
pub struct NodeContact {
    surfaces: Buffer<Surface>,
    exclusions: Buffer<u32>,
    work: Buffer<u32>,
    /// By workgroup: contacts, and the least distance as a fraction of the thickness.
    sums: Buffer<[u32; 2]>,
    read_sums: ReadBack<[u32; 2]>,
    buckets: usize,
    has_layers: bool,
    /// Workgroups, with one invocation for each place.
    groups: usize,
    /// Searches in this frame: one in each sub-step.
    searches: u64,
}

impl NodeContact {
    /// Uploads tables; `None` if no body collides with itself.
    pub fn new(gpu: &Gpu, tables: &SelfCollisionTables) -> Result<Option<Self>, GpuError> {
        if tables.surfaces.is_empty() {
            return Ok(None);
        }
        let sums = sum_groups(tables.places);
        Ok(Some(Self {
            surfaces: gpu.buffer_from("surfaces", &tables.surfaces)?,
            exclusions: gpu.buffer_from("nodes that do not touch", &tables.exclusions)?,
            work: gpu.buffer("lists of nodes that touch", tables.words())?,
            sums: gpu.buffer("sums over pairs", sums)?,
            read_sums: gpu.read_back("sums over pairs", sums)?,
            buckets: tables.buckets(),
            has_layers: tables.has_layers,
            groups: tables.places.div_ceil(GROUP),
            searches: 0,
        }))
    }

    /// Finds contacts, and applies their response. It reads the state after the sub-step, and writes over the state
    /// before it.
    fn resolve_self_contacts<'f>(&'f self, features: &Features) -> Vec<Command<'f>> {
        let run = |entry, groups| Command::run(Name::new(entry), groups);
        let [contact, _] = contact_of(features);
        let mut all = vec![
            Command::SwapStates,
            run("clear_cells", self.buckets.div_ceil(GROUP)),
            run("fill_cells", self.groups),
            run("find_self_contacts", self.groups),
            Command::run(Name::new("resolve_self_contacts").with(contact.choices()), self.groups),
        ];
        if contact == Contact::Later {
            let name = Name::new("contact_after_self_collision").with(Contact::Meshes.choices());
            all.push(Command::run(name, self.groups));
        }
        all
    }
}

impl Feature for NodeContact {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("surfaces", &self.surfaces),
            ("exclusions", &self.exclusions),
            // As atomic numbers, and as plain ones.
            ("cell_links", &self.work),
            ("contact_work", &self.work),
            ("contact_sums", &self.sums),
        ]
    }

    fn overrides(&self, _: &Gpu, overrides: &mut Overrides) {
        overrides.insert(HAS_LAYERS, f64::from(u32::from(self.has_layers)));
    }

    fn kernels<'f>(&'f self, features: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let sums = vec![Command::run(Name::new("measure_self_contacts"), self.sums.len())];
        let all = [Op::SelfContact, Op::ApplySelfContact, Op::Contact];
        vec![Fused::new(&all, self.resolve_self_contacts(features)), Fused::new(&[Op::MeasureTiles], sums)]
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            record.max_separation = pair::max_separation(f64::from(substep.h)) as f32;
        }
        self.searches += upload.substeps.len() as u64;
        Ok(false)
    }

    fn start_frame(&mut self, _: &Gpu) {
        self.searches = 0;
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.sums, &self.read_sums);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let mut contacts = Vec::new();
        self.read_sums.take(gpu, &mut contacts)?;
        if self.searches == 0 {
            // The sums are those of another frame.
            return Ok(());
        }
        sums.pairs.searches = self.searches;
        // Each pair is counted at both nodes.
        sums.pairs.pairs += contacts.iter().map(|&[count, _]| u64::from(count)).sum::<u64>() / 2;
        let nearest = contacts.iter().map(|&[_, fraction]| f64::from(f32::from_bits(fraction)).sqrt());
        sums.pairs.nearest = nearest.fold(sums.pairs.nearest, f64::min);
        Ok(())
    }
}
