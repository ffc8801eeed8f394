//! Memory of the GPU backend, and one frame of it.

use crate::advice::Warning;
use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::backend::{Backend, Device, FrameInput, Lost, SolverState, VertexTarget, View};
use crate::cpu::CpuBackend;
use crate::cpu::between::Between;
use crate::extensions::Extensions;
use crate::gpu::backup::Backup;
use crate::gpu::drawn::Drawn;
use crate::gpu::feature::{Seen, Upload};
use crate::gpu::kernels::Kernels;
use crate::gpu::layout::Four;
use crate::gpu::mirror::{Landing, Mirror};
use crate::gpu::normals::AllNormals;
use crate::gpu::options::GpuOptions;
use crate::gpu::partition::{Partition, State};
use crate::plan::refinement::{InVain, Refinement};
use crate::plan::{self, Parameters};
use crate::report::FrameSums;
use crate::step::Stage;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Mutex, OnceLock, PoisonError};
use taffeta_gpu::{Buffer, DispatchList, Gpu, GpuError, add_time};

/// Most sub-steps that are handed over at once, and most bytes that they are told beside their records.
const AT_ONCE: (usize, usize) = (1024, 16 << 20);

/// Most dispatches of sub-steps with many that are handed over at once: the device is at work on them while more are written down.
const MOST_DISPATCHES: usize = 1 << 10;

/// The GPU backend.
pub struct GpuBackend {
    /// Adds what features tell a sub-step.
    parameters: Parameters<f32>,
    gpu: Gpu,
    from: Stage,
    assembly: Assembly,
    kernels: Kernels,
    partitions: Vec<Partition>,
    /// Where the state lands, once it has been asked for.
    landings: Vec<Landing>,
    /// Whether the state of now has been sent to `landings`.
    sent: bool,
    mirror: OnceLock<Mirror>,
    /// Places that were changed in the mirror.
    changed: Range<usize>,
    free: Vec<bool>,
    /// Inverse masses [1/kg] of nodes that were free before they were pinned.
    when_free: HashMap<usize, f32>,
    /// Times of the stages in the frame that is timed.
    times: Option<Vec<(&'static str, f64)>>,
    /// Of the bodies whose normals were asked for.
    normals: Mutex<AllNormals>,
    /// Vertices that a renderer draws, by body.
    drawn: HashMap<usize, Drawn>,
    /// What may have ended a run, other than the scene.
    failure_hint: Option<Warning>,
    /// Positions of each partition before the last frame, where something of it is drawn.
    before: Vec<Option<Buffer<Four>>>,
    /// The last good state of each partition, and whether it is that of now: then it is copied when a frame starts.
    good: Vec<State>,
    is_good: bool,
    /// What the frame starts from in each partition, where it may be repeated.
    backups: Vec<Backup>,
    /// How finely sub-steps are cut, and into how many parts those of the last frame were; 0 after a measurement.
    refinement: Refinement,
    parts: u32,
    /// How much of a node's way contact has taken at most since the last good frame, where only a scene that blows up comes to it; 0 else.
    blown_up: f64,
}

impl From<GpuError> for Lost {
    fn from(error: GpuError) -> Self {
        Self(error.to_string())
    }
}

impl GpuBackend {
    /// A scene whose bodies are on the device already. The error says what the driver refuses.
    pub fn new(
        options: &GpuOptions,
        mut assembly: Assembly,
        partitions: Vec<Partition>,
        kernels: Kernels,
        failure_hint: Option<Warning>,
        parameters: Parameters<f32>,
    ) -> Result<Self, String> {
        let gpu = options.gpu.clone();
        let words = |error: GpuError| error.to_string();
        let mut free = vec![false; assembly.places];
        for body in &assembly.bodies {
            free[body.solver_range()].copy_from_slice(&body.free);
        }
        assembly.release();
        let normals = Mutex::new(AllNormals::new(kernels.clone()));
        let before = partitions.iter().map(|_| None).collect();
        let good = partitions.iter().map(|one| State::new(&gpu, "good", one.places.len()));
        let good = good.collect::<Result<_, _>>().map_err(words)?;
        let backups = partitions.iter().map(|_| Backup::default()).collect();
        let mut backend = Self {
            gpu,
            from: options.from,
            parameters,
            assembly,
            kernels,
            partitions,
            failure_hint,
            landings: Vec::new(),
            sent: false,
            mirror: OnceLock::new(),
            changed: 0..0,
            free,
            when_free: HashMap::new(),
            times: None,
            normals,
            drawn: HashMap::new(),
            before,
            good,
            is_good: true,
            backups,
            refinement: Refinement::default(),
            parts: 0,
            blown_up: 0.0,
        };
        if options.from != Stage::default() {
            let features = backend.partitions.iter_mut().flat_map(|partition| partition.features.iter_mut());
            features.for_each(|feature| feature.write_all());
        }
        // What the driver refuses is known before the first frame.
        for start in backend.assembly.sewn_at().into_iter().chain([0.0]) {
            let substeps = plan::frame(&backend.assembly, start, (1, InVain::NEVER), parameters);
            let few = &substeps[..substeps.len().min(backend.at_once())];
            backend.record(&mut DispatchList::new(), few, &FrameInput::default(), true).map_err(words)?;
            backend.partitions.iter_mut().for_each(|partition| partition.current = 0);
        }
        Ok(backend)
    }

    /// Sub-steps that are handed over at once.
    fn at_once(&self) -> usize {
        let bytes = |one: &Partition| one.features.iter().map(|feature| feature.bytes(&self.assembly)).sum();
        let dispatches =
            |one: &Partition| one.features.iter().map(|feature| feature.dispatches()).sum::<usize>();
        let bytes: usize = self.partitions.iter().map(bytes).max().unwrap_or(0);
        let dispatches: usize = self.partitions.iter().map(dispatches).sum();
        (AT_ONCE.1 / bytes.max(1)).min(MOST_DISPATCHES / dispatches.max(1)).clamp(1, AT_ONCE.0)
    }

    /// Writes down what the sub-steps do.
    fn record(
        &mut self,
        list: &mut DispatchList,
        substeps: &[plan::Substep<f32>],
        input: &FrameInput,
        last: bool,
    ) -> Result<(), GpuError> {
        for partition in &mut self.partitions {
            let places = partition.places.clone();
            let (gpu, assembly) = (&self.gpu, &self.assembly);
            partition.upload(&Upload { gpu, assembly, substeps, input, places, last })?;
            partition.record(&self.kernels, list, substeps.len(), (self.from, last))?;
        }
        Ok(())
    }

    /// Keeps the positions of now for what is drawn after what comes next, and before a frame the state if it is the last good one.
    fn keep_state(&mut self, is_frame: bool) -> DispatchList {
        let mut list = DispatchList::new();
        for (partition, before) in self.partitions.iter().zip(&self.before) {
            if let Some(before) = before {
                list.copy_buffer(&partition.state().position, before);
            }
        }
        if is_frame && std::mem::take(&mut self.is_good) {
            for (partition, good) in self.partitions.iter().zip(&self.good) {
                partition.state().copy(good, &mut list);
            }
        }
        list
    }

    /// The number of the partition that a body is in; none has a body without nodes.
    fn partition_of(&self, body: &BodyAssembly) -> Option<usize> {
        self.partitions.iter().position(|partition| partition.places.contains(&body.first))
    }

    fn new_drawn(&mut self, body: usize, nodes: &[u32]) -> Result<bool, GpuError> {
        let found = &self.assembly.bodies[body];
        let Some(index) = self.partition_of(found) else { return Ok(false) };
        let partition = &self.partitions[index];
        let drawn = Drawn::new(&self.gpu, &self.kernels, partition, found, nodes)?;
        self.drawn.insert(body, drawn);
        if self.before[index].is_none() {
            self.put_back();
            self.changed = 0..0;
            self.before[index] =
                Some(self.gpu.buffer("positions before", self.partitions[index].places.len())?);
            let list = self.keep_state(false);
            self.gpu.submit(&list)?;
        }
        Ok(true)
    }

    /// Runs the frame that starts at a time [s], or measures.
    fn run(&mut self, start: Option<f64>, input: &FrameInput) -> Result<(), GpuError> {
        self.run_to_its_end(start, input)?;
        self.see(None)
    }

    /// Shows features that look where nodes are: at a time [s] before a frame, or after one.
    fn see(&mut self, time: Option<f64>) -> Result<(), GpuError> {
        if !self.partitions.iter().any(|partition| partition.looks(time.is_some())) {
            return Ok(());
        }
        let position = self.mirror().position.clone();
        let found = Extensions::default();
        let mut seen = Seen { gpu: &self.gpu, assembly: &self.assembly, time, position: &position, found };
        self.partitions.iter_mut().try_for_each(|partition| partition.see(&mut seen))
    }

    fn run_to_its_end(&mut self, start: Option<f64>, input: &FrameInput) -> Result<(), GpuError> {
        if start.is_some() {
            self.see(start)?;
        }
        self.put_back();
        self.changed = 0..0;
        let wanted = self.mirror.take().is_some();
        let may_repeat = |one: &Partition| one.features.iter().any(|feature| feature.may_repeat());
        if !self.partitions.iter().any(may_repeat) {
            return self.run_once(start, input, wanted);
        }
        for (backup, partition) in self.backups.iter_mut().zip(&self.partitions) {
            backup.keep(&self.gpu, partition)?;
        }
        let most = self.assembly.time.most_parts();
        loop {
            let (times, before) = (self.times.clone(), self.refinement.parts);
            let in_vain = InVain::of(&self.assembly, before, !input.moves.is_empty());
            self.run_once(start, input, wanted)?;
            let mut is_short = false;
            let mut taken = 0.0_f64;
            for feature in self.partitions.iter_mut().flat_map(|partition| partition.features.iter_mut()) {
                is_short |= feature.is_short(&self.gpu)?;
                taken = taken.max(feature.taken());
            }
            let is_repeated = is_short || start.is_some() && self.refinement.note(taken, most);
            if is_repeated {
                self.times = times;
                for (partition, backup) in self.partitions.iter_mut().zip(&self.backups) {
                    backup.restore(&self.gpu, partition)?;
                }
            }
            if self.refinement.parts != before {
                self.rescale(before as f32 / self.refinement.parts as f32)?;
            }
            if !is_repeated {
                let blown_up = start.is_some() && taken > in_vain.taken();
                self.blown_up = self.blown_up.max(if blown_up { taken } else { 0.0 });
                return Ok(());
            }
            for (partition, backup) in self.partitions.iter_mut().zip(&mut self.backups) {
                if is_short {
                    partition.grow()?;
                }
                // Buffers, or what is in them, may be others now.
                backup.keep(&self.gpu, partition)?;
            }
        }
    }

    /// Sub-steps are `by` times as long from now on.
    fn rescale(&mut self, by: f32) -> Result<(), GpuError> {
        let mut features = self.partitions.iter_mut().flat_map(|partition| partition.features.iter_mut());
        features.try_for_each(|feature| feature.rescale(&self.gpu, by))
    }

    fn run_once(&mut self, start: Option<f64>, input: &FrameInput, wanted: bool) -> Result<(), GpuError> {
        self.parts = start.map_or(0, |_| self.refinement.parts);
        let substeps = start.map_or(Vec::new(), |start| {
            plan::frame(&self.assembly, start, (self.refinement.parts, InVain::NEVER), self.parameters)
        });
        self.start_frame();
        let mut done = 0;
        let mut before = self.keep_state(start.is_some());
        loop {
            let end = substeps.len().min(done + self.at_once());
            let last = end == substeps.len();
            let mut list = std::mem::take(&mut before);
            self.record(&mut list, &substeps[done..end], input, last)?;
            if last && wanted {
                self.send(&mut list)?;
            }
            match &mut self.times {
                Some(times) => {
                    let part = self.gpu.submit_timed(&list)?;
                    part.into_iter().for_each(|(stage, seconds)| add_time(times, stage, seconds));
                }
                None => self.gpu.submit(&list)?,
            }
            if last {
                self.sent = wanted;
                return Ok(());
            }
            done = end;
        }
    }

    /// What is counted over a frame starts again.
    pub fn start_frame(&mut self) {
        for feature in self.partitions.iter_mut().flat_map(|partition| partition.features.iter_mut()) {
            feature.start_frame(&self.gpu);
        }
    }

    /// Does the stages of a sub-step that are the GPU's, and measures.
    pub fn finish(&mut self, substep: &plan::Substep<f32>, input: &FrameInput) -> Result<(), Lost> {
        let mut list = DispatchList::new();
        self.record(&mut list, std::slice::from_ref(substep), input, true)?;
        Ok(self.gpu.submit(&list)?)
    }

    /// Position and velocity of all places as they are now.
    pub fn places(&mut self) -> Result<(Vec<Four>, Vec<Four>), Lost> {
        self.sent = false;
        let mirror = self.fetched()?;
        Ok((mirror.position, mirror.velocity))
    }

    /// Puts positions and velocities of all places in the state of now, or in that after it.
    pub fn put_state(&self, next: bool, [position, velocity]: &[Vec<Four>; 2]) {
        for partition in &self.partitions {
            let state = &partition.states[if next { 1 - partition.current } else { partition.current }];
            state.position.write(&self.gpu, 0, &position[partition.places.clone()]);
            state.velocity.write(&self.gpu, 0, &velocity[partition.places.clone()]);
        }
    }

    /// Takes over forces and what else the CPU has found in a sub-step.
    pub fn adopt_state(
        &self,
        between: &Between<f32>,
        cpu: &mut CpuBackend<f32>,
        substep: &plan::Substep<f32>,
    ) {
        for partition in &self.partitions {
            partition.put_forces(&between.force);
            partition.features.iter().for_each(|feature| feature.adopt_state(&self.gpu, cpu, substep));
        }
    }

    /// What went wrong so far.
    pub fn health(&self) -> Result<(), GpuError> {
        self.gpu.health()
    }

    /// Puts back what was changed on the host.
    fn put_back(&self) {
        if let Some(mirror) = self.mirror.get().filter(|_| !self.changed.is_empty()) {
            mirror.put(&self.gpu, &self.partitions, &self.changed);
        }
    }

    /// Has the state of now sent to the host with `list`.
    fn send(&mut self, list: &mut DispatchList) -> Result<(), GpuError> {
        if self.landings.is_empty() {
            self.landings = self.new_landings()?;
        }
        self.landings
            .iter()
            .zip(&self.partitions)
            .for_each(|(landing, partition)| landing.copy(partition, list));
        Ok(())
    }

    fn new_landings(&self) -> Result<Vec<Landing>, GpuError> {
        self.partitions.iter().map(|partition| Landing::new(&self.gpu, partition)).collect()
    }

    fn fetched(&self) -> Result<Mirror, GpuError> {
        if self.sent {
            return Mirror::take(&self.gpu, &self.landings);
        }
        let mut list = DispatchList::new();
        let landings = self.new_landings()?;
        landings
            .iter()
            .zip(&self.partitions)
            .for_each(|(landing, partition)| landing.copy(partition, &mut list));
        self.gpu.submit(&list)?;
        Mirror::take(&self.gpu, &landings)
    }

    fn read_normals(&self, body: usize) -> Result<Vec<[f32; 3]>, GpuError> {
        self.put_back();
        let found = &self.assembly.bodies[body];
        // A body without nodes has no normals.
        let Some(partition) = self.partition_of(found).map(|index| &self.partitions[index]) else {
            return Ok(Vec::new());
        };
        let mut all = self.normals.lock().unwrap_or_else(PoisonError::into_inner);
        all.of(&self.gpu, partition, (body, found))?.read(&self.gpu, partition)
    }

    fn mirror(&self) -> &Mirror {
        self.mirror.get_or_init(|| self.fetched().unwrap_or_else(|_| Mirror::unknown(self.assembly.places)))
    }

    /// The mirror, in which `node` is about to be changed.
    fn change(&mut self, node: usize) -> Option<(&mut Four, &mut Four)> {
        self.mirror();
        self.changed = if self.changed.is_empty() {
            node..node + 1
        } else {
            self.changed.start.min(node)..self.changed.end.max(node + 1)
        };
        let Mirror { position, velocity } = self.mirror.get_mut()?;
        Some((&mut position[node], &mut velocity[node]))
    }
}

fn three([x, y, z, _]: Four) -> [f64; 3] {
    [x, y, z].map(f64::from)
}

impl Backend for GpuBackend {
    fn frame(&mut self, start: f64, input: FrameInput) -> Result<(), Lost> {
        // Nobody is to see what comes of a blow-up.
        if self.blown_up == 0.0 { Ok(self.run(Some(start), &input)?) } else { Ok(()) }
    }

    fn mark_good(&mut self) {
        (self.is_good, self.blown_up) = (true, 0.0);
    }

    fn return_to_good(&mut self) -> Result<(), Lost> {
        self.blown_up = 0.0;
        if !std::mem::replace(&mut self.is_good, true) {
            let mut list = DispatchList::new();
            for ((partition, good), before) in self.partitions.iter().zip(&self.good).zip(&self.before) {
                good.copy(partition.state(), &mut list);
                if let Some(before) = before {
                    list.copy_buffer(&good.position, before);
                }
            }
            self.gpu.submit(&list)?;
            let features = self.partitions.iter_mut().flat_map(|partition| partition.features.iter_mut());
            features.for_each(|feature| feature.relocate());
            (self.mirror, self.changed, self.sent) = (OnceLock::new(), 0..0, false);
            self.fetch()?;
            // What was pinned or freed since stays so; the inverse mass is part of the state.
            let is_other = |&node: &usize| self.free[node] != (self.mirror().position[node][3] > 0.0);
            for node in (0..self.free.len()).filter(is_other).collect::<Vec<_>>() {
                if self.free[node] { self.unpin(node) } else { self.pin(node) }
            }
        }
        Ok(())
    }

    fn measure(&mut self) -> Result<(), Lost> {
        Ok(self.run(None, &FrameInput::default())?)
    }

    fn sums(&mut self) -> Result<FrameSums, Lost> {
        let volumes = self.assembly.no_volumes();
        let mut sums =
            FrameSums { parts: self.parts, volumes, blown_up: self.blown_up, ..FrameSums::default() };
        for feature in self.partitions.iter().flat_map(|partition| partition.features.iter()) {
            feature.measure(&self.gpu, &mut sums)?;
        }
        Ok(sums)
    }

    fn fetch(&mut self) -> Result<(), Lost> {
        if self.mirror.get().is_none() {
            let mirror = self.fetched()?;
            // It was empty, and nobody else has it.
            let _ = self.mirror.set(mirror);
        }
        Ok(self.gpu.health()?)
    }

    fn assembly(&self) -> &Assembly {
        &self.assembly
    }

    fn alter(&mut self, how: &mut dyn FnMut(&mut Assembly)) {
        how(&mut self.assembly);
    }

    fn position(&self, node: usize) -> [f64; 3] {
        three(self.mirror().position[node])
    }

    fn velocity(&self, node: usize) -> [f64; 3] {
        three(self.mirror().velocity[node])
    }

    fn set(&mut self, node: usize, position: [f64; 3], velocity: [f64; 3]) {
        if position != self.position(node) {
            let features = self.partitions.iter_mut().flat_map(|partition| partition.features.iter_mut());
            features.for_each(|feature| feature.relocate());
        }
        if let Some((x, v)) = self.change(node) {
            for axis in 0..3 {
                x[axis] = position[axis] as f32;
                v[axis] = velocity[axis] as f32;
            }
        }
    }

    fn pin(&mut self, node: usize) {
        self.free[node] = false;
        let mut free = 0.0;
        if let Some((x, v)) = self.change(node) {
            free = std::mem::replace(&mut x[3], 0.0);
            *v = [0.0, 0.0, 0.0, v[3]];
        }
        self.when_free.entry(node).or_insert(free);
    }

    fn unpin(&mut self, node: usize) {
        let Some(&free) = self.when_free.get(&node) else { return };
        self.free[node] = true;
        if let Some((x, _)) = self.change(node) {
            x[3] = free;
        }
    }

    fn is_free(&self, node: usize) -> bool {
        self.free[node]
    }

    fn bytes(&self, node: usize, velocity: bool, sink: &mut Vec<u8>) {
        let mirror = self.mirror();
        let four = if velocity { mirror.velocity[node] } else { mirror.position[node] };
        four[..3].iter().for_each(|number| sink.extend_from_slice(&number.to_le_bytes()));
    }

    fn time_stages(&mut self) {
        self.times = self.gpu.has_timestamps().then(Vec::new);
    }

    fn stage_times(&mut self) -> Vec<(&'static str, f64)> {
        self.times.take().unwrap_or_default()
    }

    fn solver_state(&self) -> SolverState {
        let mut state = SolverState { refinement: self.refinement, ..SolverState::default() };
        for feature in self.partitions.iter().flat_map(|partition| partition.features.iter()) {
            feature.save(&self.gpu, &mut state);
        }
        state
    }

    fn set_solver_state(&mut self, from: &SolverState) {
        self.refinement = from.refinement;
        self.partitions.iter_mut().for_each(|partition| partition.load(from));
    }

    fn normals(&self, body: usize) -> Option<Vec<[f32; 3]>> {
        self.read_normals(body).ok()
    }

    fn make_drawn(&mut self, body: usize, nodes: &[u32]) -> Result<bool, Lost> {
        Ok(self.new_drawn(body, nodes)?)
    }

    fn drawn_vertices(&self, body: usize) -> usize {
        self.drawn.get(&body).map_or(0, Drawn::vertices)
    }

    fn draw(&mut self, body: usize, target: &VertexTarget, view: &View) -> Result<(), Lost> {
        let Some(index) = self.partition_of(&self.assembly.bodies[body]) else { return Ok(()) };
        self.put_back();
        self.changed = 0..0;
        if let (Some(drawn), Some(before)) = (self.drawn.get_mut(&body), &self.before[index]) {
            drawn.draw(&self.gpu, &self.partitions[index], before, target, view)?;
        }
        Ok(())
    }

    fn threads(&self) -> usize {
        1
    }

    fn device(&self) -> Device {
        Device { backend: "gpu", name: format!("gpu, {}", self.gpu.info()) }
    }

    fn failure_hint(&self) -> Option<Warning> {
        self.failure_hint.clone()
    }

    fn memory(&self) -> usize {
        self.gpu.memory_used() as usize
    }
}
