//! A segment on the device: its buffers, its kernels, and what it is told for a frame.

use crate::attachments::gpu::{Attached, Attaching};
use crate::backend::FrameInput;
use crate::build::Assembly;
use crate::contact::collider_mesh::gpu::{ColliderMeshes, Words};
use crate::contact::colliders::gpu_layout::Collider;
use crate::contact::nodes::pair;
use crate::gpu::buffers::{Fixed, Scratch, Sums, Told, fill};
use crate::gpu::kernels::{Kernels, Name, Sizes};
use crate::gpu::layout::{
    Air, Four, Load, MOVED_BY_USER, Motion, Pin, SUBSTEPS_SEEN, Solving, Substep, TORQUE, VOLUME_PARTS,
};
use crate::gpu::options::GpuKernels;
use crate::gpu::paper::Paper;
use crate::gpu::tables::Tables;
use crate::plan;
use crate::solvers::dual::gpu::Constrained;
use crate::solvers::dual::gpu_tables::Linked;
use crate::solvers::explicit::patches::{self, Patches};
use crate::solvers::implicit::gpu::Primal;
use crate::solvers::implicit::gpu_tables::Levelled;
use std::collections::HashMap;
use std::num::NonZeroU64;
use taffeta_gpu::{Bindable, Bound, Buffer, DispatchList, Gpu, GpuError, Kernel, Uniforms};

/// Position and velocity.
pub struct State {
    pub position: Buffer<Four>,
    pub velocity: Buffer<Four>,
}

/// A kernel bound to the buffers, reading either state.
struct Ready {
    bound: [Bound; 2],
    /// Whether it is told of a sub-step.
    told: bool,
}

/// What the program does in a frame, in numbers.
#[derive(Clone, Copy, Debug, Default)]
pub struct Counts {
    /// Forces.
    pub input_forces: usize,
    /// Nodes that move, the scene's among them.
    pub pins: usize,
}

/// Records of sub-steps as a dispatch sees them: its own and those after it.
struct Seen<'a>(&'a Uniforms<Substep>);

impl Bindable for Seen<'_> {
    fn buffer(&self) -> &taffeta_gpu::wgpu::Buffer {
        self.0.buffer()
    }

    fn window(&self) -> Option<NonZeroU64> {
        NonZeroU64::new((SUBSTEPS_SEEN * size_of::<Substep>()) as u64)
    }
}

/// Some whole bodies on the device.
pub struct Segment {
    gpu: Gpu,
    pub tables: Tables,
    /// The state before and after a sub-step, by turns.
    pub states: [State; 2],
    /// Which of `states` is that of now.
    pub current: usize,
    /// Where several sub-steps are taken at once.
    pub patches: Option<Patches>,
    /// What a paper's kernels work on, where they are used.
    pub paper: Option<Paper>,
    /// What constraints work on, where there are any.
    pub constrained: Option<Constrained>,
    /// What springs that are solved for by nodes work on, where there are any.
    pub primal: Option<Primal>,
    /// What joints and tethers work on, where there are any.
    pub attaching: Option<Attaching>,
    fixed: Fixed,
    scratch: Scratch,
    pub sums: Sums,
    told: Told,
    /// Colliders that are meshes.
    pub meshes: ColliderMeshes,
    mesh_data: Buffer<Words>,
    /// Kernels bound to the buffers, those of a part of a level among them, reading either state.
    bound: HashMap<(Name, usize), Ready>,
}

impl Segment {
    /// Takes tables to the device. With `apart`, there is room for forces between stages.
    pub fn new(
        gpu: &Gpu,
        mut tables: Tables,
        colliders: (usize, &ColliderMeshes, &[Words]),
        kernels: GpuKernels,
        apart: bool,
    ) -> Result<Self, GpuError> {
        let room = patches::room(gpu.limits());
        let (colliders, meshes, mesh_data) = colliders;
        let patches = match kernels {
            _ if meshes.any() => None,
            GpuKernels::Best => Patches::whole(&tables, room, colliders),
            GpuKernels::Tiled => Patches::rimmed(&tables, room),
            _ => None,
        };
        let position = std::mem::take(&mut tables.position);
        let velocity = std::mem::take(&mut tables.velocity);
        let state = || -> Result<State, GpuError> {
            Ok(State {
                position: gpu.buffer_from("positions", &position)?,
                velocity: gpu.buffer_from("velocities", &velocity)?,
            })
        };
        let states = [state()?, state()?];
        let fixed = Fixed::new(gpu, &tables, patches.as_ref().unwrap_or(&Patches::default()))?;
        let forces = if !tables.weights.is_empty() {
            gpu.buffer_from("forces and gradients", &tables.forces())?
        } else {
            let has_forces =
                apart || tables.has_elements() || !tables.linked.is_empty() || !tables.levelled.is_empty();
            gpu.buffer("forces", if has_forces { tables.len() } else { 0 })?
        };
        let scratch = Scratch {
            loads: gpu.buffer_from("loads", &tables.loads)?,
            force: forces,
            volume_sums: gpu.buffer("sums of volumes", VOLUME_PARTS * tables.volume_groups.len())?,
            element_forces: gpu
                .buffer("forces of hinges and panels", tables.first_panel_force() + tables.panels.len())?,
            pair_work: gpu.buffer("lists of nodes that touch", tables.pair_words())?,
        };
        let sums = Sums::new(gpu, &tables)?;
        let told = Told::new(gpu, &tables)?;
        // The papers' kernels keep what they need themselves.
        let linked = if kernels.is_of_paper() { &Linked::default() } else { &tables.linked };
        let constrained = Constrained::new(gpu, linked, position.len())?;
        tables.entries = Vec::new();
        tables.runs = Vec::new();
        tables.corners = Vec::new();
        tables.weights = Vec::new();
        let primal = Primal::new(gpu, &tables.levelled, position.len())?;
        tables.levelled = Levelled::default();
        tables.linked = Linked { numbers: tables.linked.numbers.clone(), ..Linked::default() };
        tables.apart = Vec::new();
        let attaching = Attaching::new(gpu, &tables.attached, position.len())?;
        tables.attached = Attached::default();
        tables.elements.items = Vec::new();
        Ok(Self {
            gpu: gpu.clone(),
            tables,
            states,
            current: 0,
            patches,
            paper: None,
            constrained,
            primal,
            attaching,
            fixed,
            scratch,
            sums,
            told,
            meshes: meshes.clone(),
            mesh_data: gpu.buffer_from("meshes of colliders", mesh_data)?,
            bound: HashMap::new(),
        })
    }

    /// Dispatches of a sub-step that find what springs do, where a system is solved for that.
    pub fn solver_dispatches(&self) -> usize {
        self.constrained.as_ref().map_or(0, Constrained::dispatches)
            + self.primal.as_ref().map_or(0, Primal::dispatches)
    }

    /// The state of now.
    pub fn state(&self) -> &State {
        &self.states[self.current]
    }

    /// What springs that are solved for by nodes changed of each place's velocity [m/s]; 0 where others are not.
    pub fn pulled(&self, gpu: &Gpu) -> Vec<f64> {
        let Some(primal) = &self.primal else { return vec![0.0; 3 * self.tables.places.len()] };
        primal.solver_state(gpu).unwrap_or_else(|_| vec![f64::NAN; 3 * self.tables.places.len()])
    }

    /// The program's forces within this segment.
    fn input_forces(&self, input: &FrameInput) -> Vec<Four> {
        let first = self.tables.places.start as u32;
        let inside = input.forces.iter().filter(|(node, _)| self.tables.places.contains(&(*node as usize)));
        let four = |&(node, force): &(u32, [f64; 3])| {
            let [x, y, z] = force.map(|c| c as f32);
            [x, y, z, f32::from_bits(node - first)]
        };
        inside.map(four).collect()
    }

    /// The scene's moving pins, then those that the program moves.
    fn pins(&self, input: &FrameInput) -> Vec<Pin> {
        let first = self.tables.places.start as u32;
        let inside = input.moves.iter().filter(|(node, ..)| self.tables.places.contains(&(*node as usize)));
        let moved = inside.map(|&(node, from, to)| Pin {
            start: from.map(|c| c as f32),
            node: node - first,
            goal: to.map(|c| c as f32),
            track: MOVED_BY_USER,
        });
        self.tables.pins.iter().copied().chain(moved).collect()
    }

    /// Hands over what the sub-steps of a frame are told. Returns how many forces by the program and how many pins there
    /// are.
    pub fn tell(
        &mut self,
        assembly: &Assembly,
        substeps: &[plan::Substep<f32>],
        input: &FrameInput,
    ) -> Result<Counts, GpuError> {
        let (forces, pins) = (self.input_forces(input), self.pins(input));
        let still = !assembly.colliders_move();
        let with_colliders = if still { &substeps[..substeps.len().min(1)] } else { substeps };
        let colliders: Vec<Collider> = with_colliders
            .iter()
            .flat_map(|substep| &substep.colliders)
            .map(|now| self.meshes.told(now))
            .collect();
        let motions: Vec<Motion> =
            substeps.iter().flat_map(|substep| substep.motions.iter().map(Motion::from)).collect();
        let numbers = &self.tables.load_numbers;
        let scales: Vec<f32> =
            substeps.iter().flat_map(|s| numbers.iter().map(|&load| s.scales[load])).collect();
        let kept = &self.tables.volume_numbers;
        let of_substep = |s: &plan::Substep<f32>| {
            kept.iter().map(|&volume| s.goals[volume]).chain(s.closing.clone()).collect::<Vec<_>>()
        };
        let goals: Vec<f32> = substeps.iter().flat_map(of_substep).collect();
        let world = &assembly.world;
        let record = |(index, s): (usize, &plan::Substep<f32>)| Substep {
            gravity: world.gravity.map(|c| c as f32),
            h: s.h,
            wind: world.wind_force.map(|c| c as f32),
            drag: world.drag as f32,
            first_collider: if still { 0 } else { (index * s.colliders.len()) as u32 },
            colliders: s.colliders.len() as u32,
            first_motion: (index * s.motions.len()) as u32,
            first_scale: (index * numbers.len()) as u32,
            frame_fraction: s.frame_fraction.0,
            frame_rate: s.frame_fraction.1,
            input_forces: forces.len() as u32,
            pins: pins.len() as u32,
            solving: Solving::of(&assembly.solver),
            left: (substeps.len() - index) as u32,
            first_goal: (index * (kept.len() + s.closing.len())) as u32,
            most_apart: pair::most_apart(f64::from(s.h)) as f32,
            gap: 0,
            air: Air::of(s.air.as_ref(), self.tables.first_panel_force() as u32),
            padding: [0; 16],
        };
        let records: Vec<Substep> = substeps.iter().enumerate().map(record).collect();
        let counts = Counts { input_forces: forces.len(), pins: pins.len() };
        self.write(&records, &colliders, &motions, [&scales, &goals], &pins, &forces)?;
        Ok(counts)
    }

    fn write(
        &mut self,
        substeps: &[Substep],
        colliders: &[Collider],
        motions: &[Motion],
        [scales, goals]: [&[f32]; 2],
        pins: &[Pin],
        forces: &[Four],
    ) -> Result<(), GpuError> {
        let (gpu, told) = (&self.gpu, &mut self.told);
        let mut new = false;
        if told.substeps.len() < substeps.len() + SUBSTEPS_SEEN - 1 {
            told.substeps = gpu.uniforms("sub-steps", substeps.len() + SUBSTEPS_SEEN - 1)?;
            new = true;
        }
        told.substeps.write(gpu, substeps);
        new |= fill(gpu, "colliders", &mut told.colliders, colliders)?;
        new |= fill(gpu, "motions", &mut told.motions, motions)?;
        new |= fill(gpu, "scales of loads", &mut told.scales, scales)?;
        new |= fill(gpu, "volumes to keep", &mut told.goals, goals)?;
        new |= fill(gpu, "pins", &mut told.pins, pins)?;
        new |= fill(gpu, "forces by the user", &mut told.input_forces, forces)?;
        if !forces.is_empty() && self.scratch.force.len() < self.tables.len() {
            self.scratch.force = gpu.buffer("forces", self.tables.len())?;
            new = true;
        }
        if new {
            self.bound.clear();
        }
        gpu.health()
    }

    /// Puts forces by place, forces on hinges' corners, then on panels, and factors of torques where later stages look for
    /// them.
    pub fn put_forces(&self, force: &[[f32; 3]], elements: &[[f32; 3]], torques: &[f32], scales: &[f32]) {
        let fours =
            |forces: &[[f32; 3]]| forces.iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect::<Vec<Four>>();
        self.scratch.force.write(&self.gpu, 0, &fours(&force[self.tables.places.clone()]));
        self.scratch.element_forces.write(&self.gpu, 0, &fours(elements));
        let factor = |(load, &number): (&Load, &usize)| {
            let torque = torques.get(number).copied().unwrap_or(0.0);
            Load { factor: if load.kind == TORQUE { torque } else { scales[number] }, ..*load }
        };
        let loads: Vec<Load> = self.tables.loads.iter().zip(&self.tables.load_numbers).map(factor).collect();
        self.scratch.loads.write(&self.gpu, 0, &loads);
    }

    /// Adds a dispatch of `groups` workgroups that reads the state of now.
    pub fn dispatch(
        &mut self,
        kernels: &mut Kernels,
        list: &mut DispatchList,
        name: Name,
        substep: usize,
        groups: u32,
    ) -> Result<(), GpuError> {
        let (bound, offsets) = self.bound(kernels, (name, 0), substep)?;
        list.dispatch(&bound, &offsets, groups);
        Ok(())
    }

    /// A kernel that reads the state of now, on a part of a level where it has some, and the offset by which it is told of a
    /// sub-step, if it is.
    pub fn bound(
        &mut self,
        kernels: &mut Kernels,
        name: (Name, usize),
        substep: usize,
    ) -> Result<(Bound, Vec<u32>), GpuError> {
        if !self.bound.contains_key(&name) {
            let kernel = kernels.get(name.0, self.sizes())?;
            let bound = [0, 1].map(|from| self.bind(&kernel, from, name.1));
            self.gpu.health()?;
            let told = kernel.bindings().iter().any(|binding| binding.name == "substeps");
            self.bound.insert(name, Ready { bound, told });
        }
        let ready = &self.bound[&name];
        let offset = ready.told.then(|| self.told.substeps.offset(substep));
        Ok((ready.bound[self.current].clone(), offset.into_iter().collect()))
    }

    fn sizes(&self) -> Sizes {
        Sizes {
            kinds: self.tables.kinds.max(1) as u32,
            room: patches::room(self.gpu.limits()),
            steps: self.patches.as_ref().map_or(1, |patches| patches.steps),
        }
    }

    /// Binds a kernel to all buffers by their names in the sources, with the state read from `from` and a part of a level.
    fn bind(&self, kernel: &Kernel, from: usize, part: usize) -> Bound {
        let (fixed, scratch, sums, told) = (&self.fixed, &self.scratch, &self.sums, &self.told);
        let [old, new] = [&self.states[from], &self.states[1 - from]];
        let seen = Seen(&told.substeps);
        let buffers: [(&str, &dyn Bindable); 41] = [
            ("substeps", &seen),
            ("colliders", &told.colliders),
            ("motions", &told.motions),
            ("scales", &told.scales),
            ("pins", &told.pins),
            ("input_forces", &told.input_forces),
            ("goals", &told.goals),
            ("grids", &fixed.grids),
            ("tiles", &fixed.tiles),
            ("patches", &fixed.patches),
            ("smalls", &fixed.smalls),
            ("runs", &fixed.runs),
            ("entries", &fixed.entries),
            ("hinges", &fixed.hinges),
            ("panels", &fixed.panels),
            ("load_nodes", &fixed.load_nodes),
            ("node_starts", &fixed.node_starts),
            ("node_elements", &fixed.node_elements),
            ("chunks", &fixed.chunks),
            ("corners", &fixed.corners),
            ("volume_groups", &fixed.volume_groups),
            ("surfaces", &fixed.surfaces),
            ("apart", &fixed.apart),
            ("mesh_data", &self.mesh_data),
            ("old_position", &old.position),
            ("old_velocity", &old.velocity),
            ("new_position", &new.position),
            ("new_velocity", &new.velocity),
            ("loads", &scratch.loads),
            ("force", &scratch.force),
            ("load", &scratch.force),
            ("element_forces", &scratch.element_forces),
            ("volume_sums", &scratch.volume_sums),
            ("linked", &scratch.pair_work),
            ("pair_work", &scratch.pair_work),
            ("node_sums", &sums.nodes),
            ("grid_spring_sums", &sums.grid_springs),
            ("mesh_spring_sums", &sums.mesh_springs),
            ("hinge_sums", &sums.hinges),
            ("volumes", &sums.volumes),
            ("pair_sums", &sums.pairs),
        ];
        let of_paper = self.paper.as_ref().map_or_else(Vec::new, Paper::buffers);
        let of_solver = self.constrained.as_ref().map_or_else(Vec::new, Constrained::buffers);
        let of_primal = self.primal.as_ref().map_or_else(Vec::new, |primal| primal.buffers(part));
        let of_attached = self.attaching.as_ref().map_or_else(Vec::new, Attaching::buffers);
        kernel.bind(&self.gpu, &[&buffers[..], &of_paper, &of_solver, &of_primal, &of_attached].concat())
    }
}
