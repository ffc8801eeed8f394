//! Some whole bodies on the device: their state, their features, and how a frame of them is recorded.

use crate::backend::SolverState;
use crate::gpu::feature::{Command, Dispatch, Features, Groups, Seen, Upload};
use crate::gpu::kernels::{Kernels, Name, Overrides};
use crate::gpu::layout::{Four, SUBSTEPS_SEEN, Substep};
use crate::gpu::schedule::{Fused, schedule};
use crate::step::{self, Line, Marks, Op, Parts, Stage};
use std::collections::HashMap;
use std::num::NonZeroU64;
use std::ops::Range;
use taffeta_gpu::bytemuck::Pod;
use taffeta_gpu::bytemuck::Zeroable;
use taffeta_gpu::{Bindable, Bound, Buffer, DispatchList, Gpu, GpuError, Kernel, Uniforms};

/// Position and velocity.
pub struct State {
    /// Position [m], and the inverse mass [1/kg].
    pub position: Buffer<Four>,
    /// Velocity [m/s], and the mass [kg].
    pub velocity: Buffer<Four>,
}

impl State {
    /// Room for the state of so many places.
    pub fn new(gpu: &Gpu, label: &str, places: usize) -> Result<Self, GpuError> {
        Ok(Self { position: gpu.buffer(label, places)?, velocity: gpu.buffer(label, places)? })
    }

    /// Copies it to another of the same size.
    pub fn copy(&self, to: &Self, list: &mut DispatchList) {
        list.copy_buffer(&self.position, &to.position);
        list.copy_buffer(&self.velocity, &to.velocity);
    }
}

/// A kernel bound to the buffers, reading either state.
struct Ready {
    bound: [Bound; 2],
    /// Whether it sees the parameters of a sub-step.
    reads_substeps: bool,
}

/// Records of sub-steps as a dispatch sees them: its own and those after it.
struct Window<'a>(&'a Uniforms<Substep>);

impl Bindable for Window<'_> {
    fn buffer(&self) -> &taffeta_gpu::wgpu::Buffer {
        self.0.buffer()
    }

    fn window(&self) -> Option<NonZeroU64> {
        NonZeroU64::new((SUBSTEPS_SEEN * size_of::<Substep>()) as u64)
    }
}

/// What a partition starts from.
#[derive(Default)]
pub struct Start {
    /// Its places among those of the scene.
    pub places: Range<usize>,
    /// Position [m] and inverse mass [1/kg], velocity [m/s] and mass [kg], by place.
    pub position: Vec<Four>,
    pub velocity: Vec<Four>,
    /// Forces by place, and what lies behind them; nothing where kernels keep them for themselves.
    pub forces: Vec<Four>,
    /// What the bodies have.
    pub parts: Parts,
    /// Their classes: what is always known of them.
    pub classes: Vec<Marks>,
}

/// Some whole bodies on the device.
pub struct Partition {
    gpu: Gpu,
    /// Its places among those of the scene.
    pub places: Range<usize>,
    /// Its features.
    pub features: Features,
    /// The state before and after a sub-step, by turns, and which of them is that of now.
    pub states: [State; 2],
    pub current: usize,
    /// Forces by place [N] where they wait between kernels.
    force: Buffer<Four>,
    classes: Vec<Marks>,
    /// Passes of a sub-step, and of one that keeps the forces on held nodes, where there are any.
    lines: Vec<Line>,
    keeping: Option<Vec<Line>>,
    overrides: Overrides,
    substeps: Uniforms<Substep>,
    targets: Buffer<f32>,
    /// Kernels bound to the buffers, those of a part of some among them, reading either state.
    bound: HashMap<(Name, usize), Ready>,
}

/// Writes data into a buffer, or makes a larger one; whether it is a new one.
pub fn fill<T: Pod>(gpu: &Gpu, label: &str, buffer: &mut Buffer<T>, data: &[T]) -> Result<bool, GpuError> {
    let new = data.len() > buffer.len();
    if new {
        *buffer = gpu.buffer(label, data.len())?;
    }
    buffer.write(gpu, 0, data);
    Ok(new)
}

/// What the kernels of all features carry out.
fn table(features: &Features, from: Stage) -> Vec<Fused<'_>> {
    features.iter().flat_map(|feature| feature.kernels(features, from)).collect()
}

/// The name by which the time of an entry is told: that of the entry among others that carries out the same operation.
fn label_among(others: &[&Fused<'_>], entry: &Fused<'_>) -> &'static str {
    let op = if entry.operations[0] == Op::HeldForces { Op::Integrate } else { entry.operations[0] };
    others.iter().find(|other| other.operations.contains(&op)).map_or(entry.label, |other| other.label)
}

impl Partition {
    /// Takes it to the device.
    pub fn new(gpu: &Gpu, start: Start, features: Features) -> Result<Self, GpuError> {
        let state = || -> Result<State, GpuError> {
            Ok(State {
                position: gpu.buffer_from("positions", &start.position)?,
                velocity: gpu.buffer_from("velocities", &start.velocity)?,
            })
        };
        let mut overrides = Overrides::new();
        features.iter().for_each(|feature| feature.overrides(gpu, &mut overrides));
        Ok(Self {
            states: [state()?, state()?],
            current: 0,
            force: gpu.buffer_from("forces", &start.forces)?,
            lines: step::substep(&Parts { held: false, ..start.parts }),
            keeping: start.parts.held.then(|| step::substep(&start.parts)),
            classes: start.classes,
            overrides,
            substeps: gpu.uniforms("sub-steps", SUBSTEPS_SEEN)?,
            targets: gpu.buffer("targets", 1)?,
            bound: HashMap::new(),
            gpu: gpu.clone(),
            places: start.places,
            features,
        })
    }

    /// The state of now.
    pub fn state(&self) -> &State {
        &self.states[self.current]
    }

    /// Takes the parameters of sub-steps to the device.
    pub fn upload(&mut self, upload: &Upload<'_>) -> Result<(), GpuError> {
        let (gpu, substeps) = (&self.gpu, upload.substeps);
        let alike = self.alike(substeps.len(), upload.last);
        let mut records = vec![Substep::zeroed(); substeps.len()];
        let mut new = false;
        let mut targets = Vec::new();
        for (index, (record, substep)) in records.iter_mut().zip(substeps).enumerate() {
            record.gravity = substep.gravity.map(|c| c as f32);
            record.h = substep.h;
            record.left = alike.saturating_sub(index).max(1) as u32;
            record.first_goal = targets.len() as u32;
            targets.extend(self.features.iter().flat_map(|feature| feature.targets(substep)));
        }
        new |= fill(gpu, "targets", &mut self.targets, &targets)?;
        for feature in self.features.iter_mut() {
            new |= feature.upload(upload, &mut records)?;
        }
        if self.substeps.len() < records.len() + SUBSTEPS_SEEN - 1 {
            self.substeps = gpu.uniforms("sub-steps", records.len() + SUBSTEPS_SEEN - 1)?;
            new = true;
        }
        self.substeps.write(gpu, &records);
        if self.force.len() < self.places.len() && !upload.input.forces.is_empty() {
            self.force = gpu.buffer("forces", self.places.len())?;
            new = true;
        }
        if new {
            self.bound.clear();
        }
        gpu.health()
    }

    /// Records sub-steps, and with the `last` of a frame what is measured after it.
    pub fn record(
        &mut self,
        kernels: &Kernels,
        list: &mut DispatchList,
        substeps: usize,
        (from, last): (Stage, bool),
    ) -> Result<(), GpuError> {
        let features = std::mem::take(&mut self.features);
        let tables = [table(&features, from), table(&features, from.max(Stage::Loads))];
        let result = self.record_with(&features, &tables, kernels, list, substeps, (from, last));
        drop(tables);
        self.features = features;
        result
    }

    /// The entries of the table that carry out the passes of a sub-step, in their order.
    fn order<'t, 'f>(
        &self,
        lines: &[Line],
        table: &'t [Fused<'f>],
        from: Stage,
    ) -> Result<Vec<&'t Fused<'f>>, GpuError> {
        let order = schedule(lines, &self.classes, table, from).map_err(|why| GpuError::Failed { why })?;
        let entries = order.into_iter().map(|index| &table[index]);
        Ok(entries.filter(|entry| entry.does_something()).collect())
    }

    /// How many of the first of some sub-steps are alike: the last one of a frame keeps forces where any are kept.
    fn alike(&self, substeps: usize, last: bool) -> usize {
        substeps.saturating_sub(usize::from(last && self.keeping.is_some()))
    }

    fn record_with(
        &mut self,
        features: &Features,
        [table, apart]: &[Vec<Fused<'_>>; 2],
        kernels: &Kernels,
        list: &mut DispatchList,
        substeps: usize,
        (from, last): (Stage, bool),
    ) -> Result<(), GpuError> {
        let failed = |why| GpuError::Failed { why };
        let order = self.order(&self.lines, table, from)?;
        if order.len() > 1 && order.iter().any(|entry| entry.steps > 1) {
            return Err(failed(
                "a kernel that takes several sub-steps at once stands beside others".to_owned(),
            ));
        }
        let (mut substep, alike) = (0, self.alike(substeps, last));
        while substep < alike {
            for entry in &order {
                self.run((entry, entry.label), features, kernels, list, substep)?;
            }
            self.current = 1 - self.current;
            substep += if let [only] = order[..] { only.steps as usize } else { 1 };
        }
        if substeps > alike {
            let lines = self.keeping.as_deref().unwrap_or_default();
            for entry in self.order(lines, apart, from)? {
                self.run((entry, label_among(&order, entry)), features, kernels, list, alike)?;
            }
            self.current = 1 - self.current;
        }
        if last {
            let order =
                schedule(&step::frame_end(), &self.classes, table, Stage::default()).map_err(failed)?;
            for index in order {
                self.run((&table[index], table[index].label), features, kernels, list, 0)?;
            }
            features.iter().for_each(|feature| feature.copy(list));
        }
        Ok(())
    }

    fn run(
        &mut self,
        (entry, label): (&Fused<'_>, &'static str),
        features: &Features,
        kernels: &Kernels,
        list: &mut DispatchList,
        substep: usize,
    ) -> Result<(), GpuError> {
        list.stage(label);
        for command in &entry.commands {
            match command {
                Command::SwapStates => self.current = 1 - self.current,
                Command::Label(label) => list.stage(label),
                Command::Dispatch(dispatch) => self.dispatch(dispatch, features, kernels, list, substep)?,
            }
        }
        Ok(())
    }

    fn dispatch(
        &mut self,
        dispatch: &Dispatch<'_>,
        features: &Features,
        kernels: &Kernels,
        list: &mut DispatchList,
        substep: usize,
    ) -> Result<(), GpuError> {
        if matches!(dispatch.groups, Groups::Linear(0)) {
            return Ok(());
        }
        let (bound, mut offsets) = self.bound(features, kernels, (dispatch.name, dispatch.part), substep)?;
        match dispatch.groups {
            Groups::Linear(groups) => list.dispatch(&bound, &offsets, groups as u32),
            Groups::Plane(groups, offset) => {
                offsets.extend(offset);
                list.dispatch_plane(&bound, &offsets, groups);
            }
            Groups::Counted(counts, index) => list.dispatch_counted(&bound, &offsets, counts, index),
        }
        Ok(())
    }

    /// A kernel that reads the state of now, on a part of a feature's buffers, and the offset of its sub-step's parameters, if
    /// it sees them.
    fn bound(
        &mut self,
        features: &Features,
        kernels: &Kernels,
        name: (Name, usize),
        substep: usize,
    ) -> Result<(Bound, Vec<u32>), GpuError> {
        if !self.bound.contains_key(&name) {
            let kernel = kernels.get(name.0, &self.overrides)?;
            let bound = [0, 1].map(|from| self.bind(features, &kernel, from, name.1));
            self.gpu.health()?;
            let reads_substeps = kernel.bindings().iter().any(|binding| binding.name == "substeps");
            self.bound.insert(name, Ready { bound, reads_substeps });
        }
        let ready = &self.bound[&name];
        let offset = ready.reads_substeps.then(|| self.substeps.offset(substep));
        Ok((ready.bound[self.current].clone(), offset.into_iter().collect()))
    }

    /// Binds a kernel to all buffers by their names in the shaders, with the state read from `from`.
    fn bind(&self, features: &Features, kernel: &Kernel, from: usize, part: usize) -> Bound {
        let [old, new] = [&self.states[from], &self.states[1 - from]];
        let seen = Window(&self.substeps);
        let own: [(&str, &dyn Bindable); 8] = [
            ("substeps", &seen),
            ("goals", &self.targets),
            ("old_position", &old.position),
            ("old_velocity", &old.velocity),
            ("new_position", &new.position),
            ("new_velocity", &new.velocity),
            ("force", &self.force),
            ("load", &self.force),
        ];
        let others = features.iter().flat_map(|feature| feature.buffers(part));
        kernel.bind(&self.gpu, &own.into_iter().chain(others).collect::<Vec<_>>())
    }

    /// Gives its features the room that a frame did not have.
    pub fn grow(&mut self) -> Result<(), GpuError> {
        self.bound.clear();
        let mut features = self.features.iter_mut();
        features.try_for_each(|feature| feature.grow(&self.gpu))
    }

    /// Whether any of its features is to see where nodes are before the next frame, or after the last.
    pub fn looks(&self, before: bool) -> bool {
        self.features.iter().any(|feature| feature.looks(before))
    }

    /// Shows its features where nodes are.
    pub fn see(&mut self, seen: &mut Seen<'_>) -> Result<(), GpuError> {
        let mut new = false;
        let before = seen.time.is_some();
        for feature in self.features.iter_mut().filter(|feature| feature.looks(before)) {
            new |= feature.see(seen)?;
        }
        if new {
            self.bound.clear();
        }
        Ok(())
    }

    /// Has its features take back what they know from one sub-step to the next.
    pub fn load(&mut self, state: &SolverState) {
        let mut new = false;
        for feature in self.features.iter_mut() {
            new |= feature.load(&self.gpu, state);
        }
        if new {
            self.bound.clear();
        }
    }

    /// Puts forces by place where later kernels look for them.
    pub fn put_forces(&self, force: &[[f32; 3]]) {
        let fours: Vec<Four> = force[self.places.clone()].iter().map(|&[x, y, z]| [x, y, z, 0.0]).collect();
        self.force.write(&self.gpu, 0, &fours);
    }
}
