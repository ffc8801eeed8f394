//! Volumes on the GPU: bodies that keep one are cut into groups of 256 nodes, one for each workgroup.

use crate::assembly::Assembly;
use crate::contact::colliders::gpu::Contact;
use crate::contact::colliders::gpu::contact_of;
use crate::elements::load::gpu::Loads;
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP};
use crate::gpu::schedule::Fused;
use crate::motion::held_gpu::HeldForces;
use crate::plan::Substep;
use crate::report::FrameSums;
use crate::step::{Marks, Op, Stage};
use crate::topology::LANES;
use crate::volume::gpu_layout::Chunk;
use crate::volume::gpu_layout::{RESTORED, VOLUME_PARTS, VolumeGroup, WEIGHTED};
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "volume",
    [
        "groups.wgsl",
        "measure_volumes.wgsl",
        "printed.wgsl",
        "restore_stages.wgsl",
        "stages.wgsl",
        "volume.wgsl"
    ]
);

/// Triangles that one workgroup sums up.
const CHUNK: usize = 4096;

/// Bytes of the arrays that a body's volume needs, and what they hold.
pub fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    let body = &assembly.bodies[body];
    let kept = if body.volume().is_some() { body.places() } else { 0 };
    vec![
        ((kept * 2 * size_of::<Four>()) as u64, "forces and gradients"),
        ((body.closed_triangles.len() * 12) as u64, "triangles"),
    ]
}

/// Volumes on the host.
#[derive(Default)]
pub struct VolumeTables {
    pub groups: Vec<VolumeGroup>,
    /// Weight of each place of the bodies that keep a volume, one body after the other.
    pub weights: Vec<f32>,
    /// Which of the scene's volumes are theirs.
    pub numbers: Vec<usize>,
    /// Triangles of all closed bodies, whether they keep a volume or not.
    pub chunks: Vec<Chunk>,
    /// The body of each chunk.
    pub chunk_bodies: Vec<usize>,
    pub corners: Vec<u32>,
}

impl VolumeTables {
    /// The tables of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Self {
        let mut tables = Self::default();
        for (index, body) in bodies.iter() {
            let origin = bodies.local(body.first);
            let (first, count) = (tables.corners.len() / 3, body.closed_triangles.len());
            for start in (0..count).step_by(CHUNK) {
                let count = CHUNK.min(count - start) as u32;
                tables.chunks.push(Chunk { origin, first: (first + start) as u32, count });
                tables.chunk_bodies.push(index);
            }
            tables.corners.extend(body.closed_triangles.as_flattened().iter().map(|node| node + origin));
        }
        tables.cut(bodies);
        tables
    }

    /// Cuts the bodies that keep a volume into groups, in the scene's order of volumes.
    fn cut(&mut self, bodies: &Bodies<'_>) {
        let all = bodies.assembly.volumes().enumerate();
        let inside = all.filter(|(_, (body, _))| bodies.places.contains(&body.first) && body.nodes > 0);
        for (goal, (number, (body, kept))) in (0..).zip(inside) {
            let (first, first_group) = (bodies.local(body.first), self.groups.len() as u32);
            let gradients = (bodies.len() + self.weights.len()) as u32;
            let flag = |is: bool, flag: u32| if is { flag } else { 0 };
            let flags = flag(kept.weights.is_some(), WEIGHTED) | flag(kept.projects, RESTORED);
            self.groups.extend((0..body.nodes).step_by(GROUP).map(|start| VolumeGroup {
                first: first + start as u32,
                count: GROUP.min(body.nodes - start) as u32,
                gradients: gradients + start as u32,
                origin: first,
                first_group,
                groups: body.nodes.div_ceil(GROUP) as u32,
                goal,
                form: kept.form as u32,
                flags,
            }));
            let weight = |node: usize| kept.weights.as_ref().map_or(1.0, |weights| weights[node] as f32);
            self.weights.extend((0..body.nodes).map(weight));
            self.weights.resize(self.weights.len().next_multiple_of(LANES), 0.0);
            self.numbers.push(number);
        }
    }

    /// Whether nodes are moved to restore any volume.
    pub fn restores(&self) -> bool {
        self.groups.iter().any(|group| group.flags & RESTORED != 0)
    }

    /// Room for forces by place and, behind them, gradients with weights.
    pub fn forces(&self, places: usize) -> Vec<Four> {
        let gradients = self.weights.iter().map(|&weight| [0.0, 0.0, 0.0, weight]);
        std::iter::repeat_n([0.0; 4], places).chain(gradients).collect()
    }
}

/// Volumes on the device.
pub struct Volumes {
    groups: Buffer<VolumeGroup>,
    sums: Buffer<Four>,
    numbers: Vec<usize>,
    /// Whether nodes are moved to restore any volume.
    restores: bool,
    chunks: Buffer<Chunk>,
    chunk_bodies: Vec<usize>,
    corners: Buffer<u32>,
    /// By chunk [m³].
    volumes: Buffer<f32>,
    read_volumes: ReadBack<f32>,
}

impl Volumes {
    /// Takes tables to the device.
    pub fn new(gpu: &Gpu, tables: &VolumeTables) -> Result<Self, GpuError> {
        let chunks = tables.chunks.len();
        Ok(Self {
            groups: gpu.buffer_from("groups of volumes", &tables.groups)?,
            sums: gpu.buffer("sums of volumes", VOLUME_PARTS * tables.groups.len())?,
            numbers: tables.numbers.clone(),
            restores: tables.restores(),
            chunks: gpu.buffer_from("chunks of triangles", &tables.chunks)?,
            chunk_bodies: tables.chunk_bodies.clone(),
            corners: gpu.buffer_from("triangles", &tables.corners)?,
            volumes: gpu.buffer("volumes", chunks)?,
            read_volumes: gpu.read_back("volumes", chunks)?,
        })
    }

    /// Forces, gradients and sums of the bodies that keep a volume.
    fn forces<'f>(&'f self, features: &Features, from: Stage) -> Vec<Fused<'f>> {
        let run = |entry| vec![Command::run(Name::new(entry), self.groups.len())];
        let (none, volume, waits) = (Marks::NONE, Marks::VOLUME, Marks::SOLVED);
        let given =
            from > Stage::Elements || features.get::<Loads>().is_some_and(|all| all.are_given(features));
        let explicit: (&'static str, &[Op]) = if given {
            ("volume_forces_given", &[Op::Rings, Op::Springs, Op::VolumeSums])
        } else {
            ("volume_forces", &[Op::Loads, Op::Rings, Op::Springs, Op::VolumeSums])
        };
        vec![
            Fused::new(explicit.1, run(explicit.0)).on(volume, waits).named("volumes"),
            // If springs act beside constraints. Its sums are replaced later.
            Fused::new(&[Op::Rings, Op::Springs], run("volume_forces_given")).on(volume.and(waits), none),
            Fused::new(&[Op::Gradients, Op::VolumeSums], run("volume_gradients")).on(volume, none),
            Fused::new(&[Op::VolumeSums], run("volume_gradients")).on(volume, none),
        ]
    }

    /// From multipliers to positions; and the same where the forces on held nodes are kept.
    fn particles<'f>(&'f self, features: &Features) -> Vec<Fused<'f>> {
        let [contact, _] = contact_of(features);
        let name = Name::new("volume_particles").with(contact.choices());
        let mut operations = vec![Op::Multipliers, Op::VolumeForces, Op::Integrate, Op::Contact];
        if contact == Contact::Later {
            operations.pop();
        }
        let entry = |operations: &[Op], more: Option<Command<'f>>| {
            let commands = [Command::run(name, self.groups.len())].into_iter().chain(more).collect();
            Fused::new(operations, commands).on(Marks::VOLUME, Marks::NONE)
        };
        let mut all = vec![entry(&operations, None)];
        if let Some(held) = features.get::<HeldForces>() {
            operations.insert(2, Op::HeldForces);
            all.push(entry(&operations, Some(held.command())));
        }
        all
    }

    /// A round that restores volumes. Nothing is read back, so that all rounds are recorded; on volumes that are restored
    /// they do nothing.
    fn round<'f>(&'f self, features: &Features) -> Fused<'f> {
        let [_, contact] = contact_of(features);
        let groups = if self.restores { self.groups.len() } else { 0 };
        let name = Name::new("restore_volumes").with(contact.choices());
        let commands = vec![
            // It measures what the others have written.
            Command::SwapStates,
            Command::run(Name::new("measure_kept_volumes"), groups),
            Command::SwapStates,
            Command::run(name, groups),
        ];
        let operations = [Op::MeasureVolumes, Op::RestoreVolumes, Op::Contact];
        Fused::new(&operations, commands).on(Marks::VOLUME, Marks::NONE)
    }
}

impl Feature for Volumes {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("volume_groups", &self.groups),
            ("volume_sums", &self.sums),
            ("chunks", &self.chunks),
            ("corners", &self.corners),
            ("volumes", &self.volumes),
        ]
    }

    fn kernels<'f>(&'f self, features: &'f Features, from: Stage) -> Vec<Fused<'f>> {
        let measure = vec![Command::run(Name::new("measure_volumes"), self.chunks.len())];
        let mut all = self.forces(features, from);
        all.extend(self.particles(features));
        all.push(self.round(features));
        all.push(Fused::new(&[Op::MeasureBodies], measure));
        all
    }

    fn bytes(&self, _: &Assembly) -> usize {
        self.numbers.len() * size_of::<f32>()
    }

    fn targets(&self, substep: &Substep<f32>) -> Vec<f32> {
        self.numbers.iter().map(|&volume| substep.goals()[volume]).collect()
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.volumes, &self.read_volumes);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let mut numbers = Vec::new();
        self.read_volumes.take(gpu, &mut numbers)?;
        for (&volume, &body) in numbers.iter().zip(&self.chunk_bodies) {
            *sums.volumes[body].get_or_insert(0.0) += f64::from(volume);
        }
        Ok(())
    }
}
