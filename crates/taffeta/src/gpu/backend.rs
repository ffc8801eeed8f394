//! Memory of the GPU backend, and one frame of it.

use crate::backend::{Backend, Device, FrameInput, Lost, SolverState};
use crate::build::Assembly;
use crate::build::body::BodyAssembly;
use crate::contact::collider_mesh::gpu::{ColliderMeshes, Words};
use crate::contact::colliders::gpu_layout::Collider;
use crate::cpu::apart::Between;
use crate::diagnostics::{FrameSums, PairSums};
use crate::gpu::boundary::ElementForces;
use crate::gpu::drawn::{Drawn, VertexTarget, View};
use crate::gpu::kernels::Kernels;
use crate::gpu::layout::{Four, Motion};
use crate::gpu::mirror::{Landing, Mirror};
use crate::gpu::normals::AllNormals;
use crate::gpu::options::{
    GpuKernels, GpuOptions, doubt, refuse_constraints, refuse_large_meshes, refuse_late, refuse_loops,
    refuse_untiled,
};
use crate::gpu::order;
use crate::gpu::paper::{self, Paper};
use crate::gpu::recorder::Recorder;
use crate::gpu::segment::Segment;
use crate::gpu::sums;
use crate::gpu::tables::{Tables, segments};
use crate::plan;
use crate::scene::Method;
use crate::step::Stage;
use std::collections::HashMap;
use std::ops::Range;
use std::sync::{Mutex, OnceLock, PoisonError};
use taffeta_gpu::{Buffer, DispatchList, Gpu, GpuError};

/// Most sub-steps that are handed over at once, and most bytes that they are told beside their records.
const AT_ONCE: (usize, usize) = (1024, 16 << 20);

/// Most dispatches that find pulls of constraints and are handed over at once.
const MOST_DISPATCHES: usize = 1 << 16;

/// The GPU backend.
pub struct GpuBackend {
    gpu: Gpu,
    from: Stage,
    assembly: Assembly,
    kernels: Kernels,
    segments: Vec<Segment>,
    /// Where the state lands, once it has been asked for.
    landings: Vec<Landing>,
    /// Whether the state of now has been sent to `landings`.
    sent: bool,
    /// Sub-steps of the frame that is measured.
    substeps: usize,
    mirror: OnceLock<Mirror>,
    /// Places that were changed in the mirror.
    changed: Range<usize>,
    free: Vec<bool>,
    /// Times of the stages in the frame that is timed.
    times: Option<Vec<(&'static str, f64)>>,
    /// Of the bodies whose normals were asked for.
    normals: Mutex<AllNormals>,
    /// Vertices that a renderer draws, by body.
    drawn: HashMap<usize, Drawn>,
    /// Positions of each segment before the last frame, where something of it is drawn.
    before: Vec<Option<Buffer<Four>>>,
}

impl From<GpuError> for Lost {
    fn from(error: GpuError) -> Self {
        Self(error.to_string())
    }
}

impl GpuBackend {
    /// Takes a scene to the device. The error says what does not fit.
    pub fn new(options: &GpuOptions, mut assembly: Assembly) -> Result<Self, String> {
        let gpu = options.gpu.clone();
        let words = |error: GpuError| error.to_string();
        paper::check(options, &assembly)?;
        refuse_constraints(options.kernels, &assembly)?;
        refuse_late(options.from, &assembly)?;
        refuse_loops(&gpu, &assembly)?;
        let (meshes, mesh_data) = ColliderMeshes::new(&assembly);
        refuse_large_meshes(&gpu, size_of_val::<[Words]>(&mesh_data))?;
        let mut parts = Vec::new();
        for bodies in segments(&assembly, gpu.largest_binding())? {
            let tables = Tables::new(&assembly, bodies.clone())?;
            let paper = Paper::new(&gpu, options.kernels, &assembly, bodies, &tables).map_err(words)?;
            let apart = options.from > Stage::Elements;
            let colliders = (assembly.colliders.len(), &meshes, &mesh_data[..]);
            let mut segment = Segment::new(&gpu, tables, colliders, options.kernels, apart).map_err(words)?;
            segment.paper = paper;
            parts.push(segment);
        }
        if options.kernels == GpuKernels::Tiled {
            refuse_untiled(&gpu, &parts)?;
        }
        let mut free = vec![false; assembly.places];
        for body in &assembly.bodies {
            free[body.first..body.first + body.nodes].copy_from_slice(&body.free);
        }
        assembly.release();
        let kernels = Kernels::new(gpu.clone());
        let normals = Mutex::new(AllNormals::new(gpu.clone()));
        let before = parts.iter().map(|_| None).collect();
        let mut backend = Self {
            gpu,
            from: options.from,
            assembly,
            kernels,
            segments: parts,
            landings: Vec::new(),
            sent: false,
            substeps: 0,
            mirror: OnceLock::new(),
            changed: 0..0,
            free,
            times: None,
            normals,
            drawn: HashMap::new(),
            before,
        };
        // What the driver refuses is known before the first frame.
        let substeps = plan::frame(&backend.assembly, 0.0);
        let few = &substeps[..substeps.len().min(backend.at_once())];
        backend.record(&mut DispatchList::new(), few, &FrameInput::default(), true).map_err(words)?;
        backend.segments.iter_mut().for_each(|segment| segment.current = 0);
        Ok(backend)
    }

    /// Sub-steps that are handed over at once.
    fn at_once(&self) -> usize {
        let Assembly { colliders, tracks, loads, .. } = &self.assembly;
        let bytes = if self.assembly.colliders_move() { colliders.len() * size_of::<Collider>() } else { 0 }
            + tracks.len() * size_of::<Motion>()
            + (loads.len() + self.assembly.volumes().count() + self.assembly.attachments.laws.len())
                * size_of::<f32>();
        let dispatches: usize = self.segments.iter().map(Segment::solver_dispatches).sum();
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
        let numbers: Vec<usize> = (0..substeps.len()).collect();
        for segment in &mut self.segments {
            let counts = segment.tell(&self.assembly, substeps, input)?;
            let mut recorder = Recorder {
                segment,
                kernels: &mut self.kernels,
                list,
                counts,
                from: self.from,
                last,
                ahead: 0,
                all: substeps.len(),
                fault: Ok(()),
            };
            order::frame(&mut recorder, &numbers);
            recorder.fault?;
        }
        Ok(())
    }

    /// Keeps the positions of now for what is drawn after the next frame.
    fn remember_places(&self) -> DispatchList {
        let mut list = DispatchList::new();
        for (segment, before) in self.segments.iter().zip(&self.before) {
            if let Some(before) = before {
                list.copy_buffer(&segment.state().position, before);
            }
        }
        list
    }

    /// The number of the segment that a body is in; none has a body without nodes.
    fn segment_of(&self, body: &BodyAssembly) -> Option<usize> {
        self.segments.iter().position(|segment| segment.tables.places.contains(&body.first))
    }

    fn new_drawn(&mut self, body: usize, nodes: &[u32]) -> Result<bool, GpuError> {
        let found = &self.assembly.bodies[body];
        let Some(index) = self.segment_of(found) else { return Ok(false) };
        let segment = &self.segments[index];
        let drawn = Drawn::new(&self.gpu, &mut self.kernels, segment, found, nodes)?;
        self.drawn.insert(body, drawn);
        if self.before[index].is_none() {
            self.put_back();
            self.changed = 0..0;
            self.before[index] =
                Some(self.gpu.buffer("positions before", self.segments[index].tables.len())?);
            self.gpu.submit(&self.remember_places())?;
        }
        Ok(true)
    }

    fn run(&mut self, substeps: &[plan::Substep<f32>], input: &FrameInput) -> Result<(), GpuError> {
        self.put_back();
        self.start_frame();
        self.changed = 0..0;
        self.substeps = substeps.len();
        let wanted = self.mirror.take().is_some();
        let mut done = 0;
        let mut before = self.remember_places();
        loop {
            let end = substeps.len().min(done + self.at_once());
            let last = end == substeps.len();
            let mut list = std::mem::take(&mut before);
            self.record(&mut list, &substeps[done..end], input, last)?;
            if last && wanted {
                self.send(&mut list)?;
            }
            match &mut self.times {
                Some(times) => times.extend(self.gpu.submit_timed(&list)?),
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
    pub fn start_frame(&self) {
        let constrained = self.segments.iter().filter_map(|segment| segment.constrained.as_ref());
        constrained.for_each(|constrained| constrained.start_frame(&self.gpu));
        let primal = self.segments.iter().filter_map(|segment| segment.primal.as_ref());
        primal.for_each(|primal| primal.start_frame(&self.gpu));
    }

    /// Does the stages of a sub-step that are the GPU's, and measures.
    pub fn finish(&mut self, substep: &plan::Substep<f32>, input: &FrameInput) -> Result<(), Lost> {
        self.substeps = 1;
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
        for segment in &self.segments {
            let state = &segment.states[if next { 1 - segment.current } else { segment.current }];
            state.position.write(&self.gpu, 0, &position[segment.tables.places.clone()]);
            state.velocity.write(&self.gpu, 0, &velocity[segment.tables.places.clone()]);
        }
    }

    /// Puts the forces that the CPU has found where the GPU's stages look for them.
    pub fn put_forces(&self, between: &Between<f32>, elements: &ElementForces, scales: &[f32]) {
        let (mut hinge, mut panel) = (0, 0);
        for segment in &self.segments {
            let hinges = hinge..hinge + 4 * segment.tables.hinges.len();
            let panels = panel..panel + segment.tables.panels.len();
            (hinge, panel) = (hinges.end, panels.end);
            let hinges = elements.hinges.get(hinges).unwrap_or_default();
            let all = [hinges, elements.panels.get(panels).unwrap_or_default()].concat();
            segment.put_forces(&between.force, &all, &elements.torques, scales);
        }
    }

    /// What went wrong so far.
    pub fn health(&self) -> Result<(), GpuError> {
        self.gpu.health()
    }

    /// Puts back what was changed on the host.
    fn put_back(&self) {
        if let Some(mirror) = self.mirror.get().filter(|_| !self.changed.is_empty()) {
            mirror.put(&self.gpu, &self.segments, &self.changed);
        }
    }

    /// Has the state of now sent to the host with `list`.
    fn send(&mut self, list: &mut DispatchList) -> Result<(), GpuError> {
        if self.landings.is_empty() {
            self.landings = self.new_landings()?;
        }
        self.landings.iter().zip(&self.segments).for_each(|(landing, segment)| landing.copy(segment, list));
        Ok(())
    }

    fn new_landings(&self) -> Result<Vec<Landing>, GpuError> {
        self.segments.iter().map(|segment| Landing::new(&self.gpu, segment)).collect()
    }

    fn fetched(&self) -> Result<Mirror, GpuError> {
        if self.sent {
            return Mirror::take(&self.gpu, &self.landings);
        }
        let mut list = DispatchList::new();
        let landings = self.new_landings()?;
        landings.iter().zip(&self.segments).for_each(|(landing, segment)| landing.copy(segment, &mut list));
        self.gpu.submit(&list)?;
        Mirror::take(&self.gpu, &landings)
    }

    fn read_normals(&self, body: usize) -> Result<Vec<[f32; 3]>, GpuError> {
        self.put_back();
        let found = &self.assembly.bodies[body];
        // A body without nodes has no normals.
        let Some(segment) = self.segment_of(found).map(|index| &self.segments[index]) else {
            return Ok(Vec::new());
        };
        let mut all = self.normals.lock().unwrap_or_else(PoisonError::into_inner);
        all.of(&self.gpu, segment, (body, found))?.read(&self.gpu, segment)
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
        let substeps = plan::frame(&self.assembly, start);
        Ok(self.run(&substeps, &input)?)
    }

    fn measure(&mut self) -> Result<(), Lost> {
        Ok(self.run(&[], &FrameInput::default())?)
    }

    fn sums(&mut self) -> Result<FrameSums, Lost> {
        let mut sums = FrameSums { volumes: self.assembly.no_volumes(), ..FrameSums::default() };
        for segment in &self.segments {
            sums::add(&self.gpu, segment, &mut sums)?;
            if let Some(paper) = &segment.paper {
                paper.report(&self.gpu, &mut sums.solver)?;
            }
        }
        // Every sub-step searches; one that there was not has found nothing.
        let searched = self.assembly.touching().next().is_some() && self.substeps > 0;
        sums.pairs = if searched {
            PairSums { searches: self.substeps as u64, ..sums.pairs }
        } else {
            PairSums::default()
        };
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
        if let Some((x, v)) = self.change(node) {
            for axis in 0..3 {
                x[axis] = position[axis] as f32;
                v[axis] = velocity[axis] as f32;
            }
        }
    }

    fn hold(&mut self, node: usize) {
        self.free[node] = false;
        if let Some((x, v)) = self.change(node) {
            x[3] = 0.0;
            *v = [0.0, 0.0, 0.0, v[3]];
        }
    }

    fn let_go(&mut self, node: usize) {
        self.free[node] = true;
        if let Some((x, v)) = self.change(node) {
            x[3] = 1.0 / v[3];
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
        let mut all = SolverState::default();
        for constrained in self.segments.iter().filter_map(|segment| segment.constrained.as_ref()) {
            let unknown = |_| (vec![f64::NAN; constrained.len()], vec![false; constrained.len()]);
            let (pulls, active) = constrained.solver_state(&self.gpu).unwrap_or_else(unknown);
            all.pulls.extend(pulls);
            all.active.extend(active);
        }
        if self.segments.iter().any(|segment| segment.primal.is_some()) {
            all.pulls.extend(self.segments.iter().flat_map(|segment| segment.pulled(&self.gpu)));
        }
        let solver = &self.assembly.solver;
        let surfaces = solver.method == Method::Ice && !self.assembly.colliders.is_empty();
        if !(solver.ice.warm_start || surfaces) {
            all.pulls.clear();
        }
        if self.assembly.solver.method != Method::Acad {
            all.active.clear();
        }
        let attached = &self.assembly.attachments;
        if attached.breaks() {
            all.joints = vec![true; attached.rows.len()];
            let attaching = self.segments.iter().filter_map(|segment| segment.attaching.as_ref());
            attaching.for_each(|attaching| attaching.solver_state(&self.gpu, &mut all.joints));
        }
        all
    }

    fn set_solver_state(&mut self, from: &SolverState) {
        for segment in &self.segments {
            if let Some(attaching) = &segment.attaching {
                attaching.set_solver_state(&self.gpu, &from.joints);
            }
            if let Some(primal) = &segment.primal {
                let places = &segment.tables.places;
                primal.set_solver_state(
                    &self.gpu,
                    from.pulls.get(3 * places.start..3 * places.end).unwrap_or_default(),
                );
            }
            let Some(constrained) = &segment.constrained else { continue };
            let numbers = segment.tables.linked.numbers.clone();
            let pulls = from.pulls.get(numbers.clone()).unwrap_or_default();
            let active = from.active.get(numbers).unwrap_or_default();
            // A device that is lost says so when the next frame is handed over.
            let _ = constrained.set_solver_state(&self.gpu, pulls, active);
        }
    }

    fn normals(&self, body: usize) -> Option<Vec<[f32; 3]>> {
        self.read_normals(body).ok()
    }

    fn make_drawn(&mut self, body: usize, nodes: &[u32]) -> Result<bool, Lost> {
        Ok(self.new_drawn(body, nodes)?)
    }

    fn draw(&mut self, body: usize, target: &VertexTarget, view: &View) -> Result<(), Lost> {
        let Some(index) = self.segment_of(&self.assembly.bodies[body]) else { return Ok(()) };
        self.put_back();
        self.changed = 0..0;
        if let (Some(drawn), Some(before)) = (self.drawn.get_mut(&body), &self.before[index]) {
            drawn.draw(&self.gpu, &self.segments[index], before, target, view)?;
        }
        Ok(())
    }

    fn threads(&self) -> usize {
        1
    }

    fn device(&self) -> Device {
        Device { backend: "gpu", name: format!("gpu, {}", self.gpu.info()) }
    }

    fn doubt(&self) -> Option<String> {
        doubt(&self.gpu, &self.assembly)
    }

    fn memory(&self) -> usize {
        self.gpu.memory_used() as usize
    }
}
