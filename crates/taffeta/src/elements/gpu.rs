//! Elements on the GPU: forces are found element by element; nodes gather them with their loads.

use crate::assembly::Assembly;
use crate::cpu::CpuBackend;
use crate::elements::element::{Kind, List};
use crate::elements::sets;
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features};
use crate::gpu::kernels::{Choice, Name};
use crate::gpu::layout::{Four, GROUP};
use crate::gpu::schedule::Fused;
use crate::gpu::sums::{capped, sum_groups};
use crate::plan;
use crate::report::FrameSums;
use crate::step::{Op, Stage};
use std::num::NonZeroU64;
use std::ops::Range;
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders, wgpu};

/// What shaders of all kinds import.
pub const SHADERS: &[Shader] = shaders!("elements", ["directions.wgsl", "energies.wgsl", "forces.wgsl"]);

/// The forces of a kind begin at a multiple of so many, where any device lets a buffer be bound from [256 bytes].
const ALIGNED: usize = 256 / size_of::<Four>();

/// Bytes of the array of forces of a body's elements, and what it holds.
pub fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    let of_kind = |list: &List| (list.bodies[body].len() * list.kind.forces).next_multiple_of(ALIGNED);
    let forces: usize = assembly.elements().iter().map(of_kind).sum();
    let directions: usize =
        assembly.elements().iter().map(|list| list.bodies[body].len() * directions(list)).sum();
    vec![
        ((forces * size_of::<Four>()) as u64, "forces of elements"),
        ((directions * size_of::<Four>()) as u64, "directions of elements"),
    ]
}

/// Directions of an element, of kinds that are solved for.
fn directions(list: &List) -> usize {
    let modes = list.kind.implicit.as_ref().filter(|_| list.implicit).map_or(0, |implicit| implicit.modes);
    modes * list.kind.nodes
}

/// Elements on the host.
#[derive(Default)]
pub struct ElementTables {
    /// Those of each kind of which there are some.
    pub kinds: Vec<KindTables>,
}

/// Elements of one kind on the host.
pub struct KindTables {
    /// Which.
    pub set: Set,
    /// Records, one after the other: nodes, then numbers in 32 bits.
    pub words: Vec<u32>,
}

/// Some elements of one kind.
#[derive(Clone)]
pub struct Set {
    /// Which kind.
    pub kind: &'static Kind,
    /// Which of the scene's elements of the kind.
    pub range: Range<usize>,
    /// Where their forces begin among those of all kinds.
    pub first_force: usize,
    /// Where their directions are among those of all kinds; nowhere where they are not solved for.
    pub directions: Range<usize>,
}

impl ElementTables {
    /// Those of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Self {
        let (mut kinds, mut first_force, mut first_direction) = (Vec::new(), 0, 0);
        for list in bodies.assembly.elements() {
            let of_bodies = &list.bodies[bodies.range.clone()];
            let range =
                of_bodies.first().map_or(0, |body| body.start)..of_bodies.last().map_or(0, |body| body.end);
            if range.is_empty() {
                continue;
            }
            let mut words = Vec::with_capacity(range.len() * (list.kind.nodes + list.kind.numbers()));
            for (nodes, numbers) in list.of(range.clone()) {
                words.extend(nodes.iter().map(|&node| bodies.local(node as usize)));
                words.extend(numbers.iter().map(|&number| (number as f32).to_bits()));
            }
            let directions = first_direction..first_direction + range.len() * directions(list);
            first_direction = directions.end.next_multiple_of(ALIGNED);
            let set = Set { kind: list.kind, range, first_force, directions };
            first_force = set.forces().end.next_multiple_of(ALIGNED);
            kinds.push(KindTables { set, words });
        }
        Self { kinds }
    }

    /// Number of forces of all elements, with gaps.
    pub fn forces(&self) -> usize {
        self.kinds.last().map_or(0, |last| last.set.forces().end)
    }

    /// Number of directions of all elements, with gaps.
    pub fn directions(&self) -> usize {
        self.kinds.iter().map(|one| one.set.directions.end).max().unwrap_or(0)
    }

    /// Whether any act explicitly.
    pub fn any_explicit(&self) -> bool {
        self.kinds.iter().any(|one| !one.set.is_solved_for())
    }

    /// For each corner of each element that acts explicitly, its node and where its force is among those of elements.
    pub fn corners(&self) -> impl Iterator<Item = (u32, u32)> {
        self.kinds.iter().filter(|one| !one.set.is_solved_for()).flat_map(KindTables::corners)
    }

    /// The elements of a kind.
    pub fn of(&self, kind: &str) -> Option<&KindTables> {
        self.kinds.iter().find(|tables| tables.set.kind.name == kind)
    }
}

impl Set {
    /// Whether they are solved for.
    pub fn is_solved_for(&self) -> bool {
        !self.directions.is_empty()
    }

    /// Where their forces are among those of all kinds.
    pub fn forces(&self) -> Range<usize> {
        self.first_force..self.first_force + self.kind.forces * self.range.len()
    }

    /// What the CPU has found of their forces [N].
    pub fn found_on_cpu(&self, cpu: &mut CpuBackend<f32>) -> Vec<Four> {
        let Some(elements) = cpu.feature::<sets::Elements<f32>>() else { return Vec::new() };
        let (each, found) = (self.kind.forces, elements.forces(self.kind.name));
        let own = &found[each * self.range.start..each * self.range.end];
        own.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect()
    }
}

impl KindTables {
    /// Nodes and numbers of each element.
    pub fn elements(&self) -> impl Iterator<Item = (&[u32], &[u32])> {
        let kind = self.set.kind;
        self.words.chunks_exact(kind.nodes + kind.numbers()).map(|words| words.split_at(kind.nodes))
    }

    fn corners(&self) -> impl Iterator<Item = (u32, u32)> {
        let Set { kind, first_force, .. } = self.set;
        self.elements().enumerate().flat_map(move |(index, (nodes, _))| {
            let first = first_force + kind.forces * index;
            let force = move |corner: usize| if kind.forces > 1 { first + corner } else { first };
            nodes.iter().enumerate().map(move |(at, &node)| (node, force(at) as u32))
        })
    }
}

/// A part of a buffer, as a kernel sees it.
struct Window {
    buffer: wgpu::Buffer,
    offset: u64,
    bytes: u64,
}

impl Window {
    fn new(all: &Buffer<Four>, seen: &Range<usize>) -> Self {
        let bytes = |count: usize| (count * size_of::<Four>()) as u64;
        Self { buffer: all.raw().clone(), offset: bytes(seen.start), bytes: bytes(seen.len()) }
    }
}

impl Bindable for Window {
    fn buffer(&self) -> &wgpu::Buffer {
        &self.buffer
    }

    fn offset(&self) -> u64 {
        self.offset
    }

    fn window(&self) -> Option<NonZeroU64> {
        NonZeroU64::new(self.bytes)
    }
}

/// Elements of one kind on the device.
struct OnDevice {
    set: Set,
    records: Buffer<u32>,
    /// Force on each corner of each element, or on all corners of each [N].
    forces: Window,
    /// Directions of modes over the step, where they are solved for.
    directions: Option<Window>,
    /// By workgroup [J], where they have some.
    energies: Option<(Buffer<f32>, ReadBack<f32>)>,
}

/// Elements on the device.
pub struct Elements {
    kinds: Vec<OnDevice>,
    /// Forces and directions of all kinds, one behind the other.
    forces: Buffer<Four>,
    directions: Option<Buffer<Four>>,
}

impl Elements {
    /// Takes tables to the device.
    pub fn new(gpu: &Gpu, tables: &ElementTables) -> Result<Self, GpuError> {
        let forces: Buffer<Four> = gpu.buffer("forces of elements", tables.forces())?;
        let count = tables.directions();
        let directions: Option<Buffer<Four>> =
            (count > 0).then(|| gpu.buffer("directions of elements", count)).transpose()?;
        let on_device = |tables: &KindTables| {
            let kind = tables.set.kind;
            let sums = sum_groups(tables.set.range.len());
            let energies = || {
                let label = "energies of elements";
                Ok((gpu.buffer(label, sums)?, gpu.read_back(label, sums)?))
            };
            Ok(OnDevice {
                records: gpu.buffer_from(kind.name, &tables.words)?,
                forces: Window::new(&forces, &tables.set.forces()),
                directions: directions
                    .as_ref()
                    .filter(|_| tables.set.is_solved_for())
                    .map(|all| Window::new(all, &tables.set.directions)),
                energies: kind.kernels.energies.map(|_| energies()).transpose()?,
                set: tables.set.clone(),
            })
        };
        let kinds = tables.kinds.iter().map(on_device).collect::<Result<_, GpuError>>()?;
        Ok(Self { kinds, forces, directions })
    }

    /// What finds forces and directions of elements that are solved for, by kernels that are put together with `choices`.
    pub fn linearise(&self, choices: &[Choice]) -> Vec<Command<'_>> {
        let of_kind = |(part, one): (usize, &OnDevice)| {
            let directions = one.set.kind.implicit.as_ref().filter(|_| one.set.is_solved_for())?.directions;
            let groups = one.set.range.len().div_ceil(GROUP);
            let run = |entry| Command::run_part(Name::new(entry).with(choices), part, groups);
            Some([run(one.set.kind.kernels.forces.entry), run(directions.entry)])
        };
        (1..).zip(&self.kinds).filter_map(of_kind).flatten().collect()
    }

    /// Whether any act explicitly.
    pub fn any_explicit(&self) -> bool {
        self.kinds.iter().any(|one| !one.set.is_solved_for())
    }
}

impl Feature for Elements {
    /// Kernels of a kind see its own forces and energies: its part is one more than its number. Others see all forces.
    fn buffers(&self, part: usize) -> Vec<(&'static str, &dyn Bindable)> {
        let mut all: Vec<(&'static str, &dyn Bindable)> =
            self.kinds.iter().map(|one| (one.set.kind.name, &one.records as &dyn Bindable)).collect();
        match part.checked_sub(1).and_then(|kind| self.kinds.get(kind)) {
            Some(one) => {
                all.push(("element_forces", &one.forces));
                all.extend(one.directions.iter().map(|some| ("element_directions", some as &dyn Bindable)));
                all.extend(one.energies.iter().map(|(sums, _)| ("element_energies", sums as &dyn Bindable)));
            }
            None => {
                all.push(("element_forces", &self.forces));
                all.extend(self.directions.iter().map(|some| ("element_directions", some as &dyn Bindable)));
            }
        }
        all
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let kinds = || (1..).zip(&self.kinds);
        let explicit = || kinds().filter(|(_, one)| !one.set.is_solved_for());
        let force = |(part, one): (usize, &OnDevice)| {
            Command::run_part(
                Name::new(one.set.kind.kernels.forces.entry),
                part,
                one.set.range.len().div_ceil(GROUP),
            )
        };
        let energy = |(part, one): (usize, &OnDevice)| {
            let (sums, _) = one.energies.as_ref()?;
            Some(Command::run_part(Name::new(one.set.kind.kernels.energies?.entry), part, sums.len()))
        };
        vec![
            Fused::new(&[Op::Elements], explicit().map(force).collect()),
            Fused::new(&[Op::MeasureTiles], kinds().filter_map(energy).collect()),
        ]
    }

    fn adopt_state(&self, gpu: &Gpu, cpu: &mut CpuBackend<f32>, _: &plan::Substep<f32>) {
        for one in self.kinds.iter().filter(|one| !one.set.is_solved_for()) {
            self.forces.write(gpu, one.set.first_force, &one.set.found_on_cpu(cpu));
        }
    }

    fn copy(&self, list: &mut DispatchList) {
        for (sums, read) in self.kinds.iter().filter_map(|one| one.energies.as_ref()) {
            list.copy(sums, read);
        }
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let mut numbers = Vec::new();
        for one in &self.kinds {
            if let Some((_, read)) = &one.energies {
                read.take(gpu, &mut numbers)?;
                sums.add_energy(one.set.kind.name, numbers.iter().map(|&energy| capped(energy)).sum());
            }
        }
        Ok(())
    }
}
