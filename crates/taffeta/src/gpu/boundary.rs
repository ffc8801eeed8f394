//! A frame whose first stages run on the CPU and whose others run on the GPU, to find the stage in which the two differ.
//! Every sub-step crosses over and back: slow, and right. Sub-steps are those of the scene, never cut into parts.

use crate::assembly::Assembly;
use crate::backend::{Backend, Device, FrameInput, Lost, SolverState};
use crate::cpu::CpuBackend;
use crate::cpu::between::Between;
use crate::gpu::backend::GpuBackend;
use crate::gpu::layout::Four;
use crate::plan;
use crate::plan::refinement::InVain;
use crate::report::FrameSums;
use crate::step::Stage;

/// Both backends, and where one hands over to the other.
pub struct Boundary {
    cpu: CpuBackend<f32>,
    gpu: GpuBackend,
    from: Stage,
}

impl Boundary {
    /// Of a scene that is on both; the GPU does what is left from a stage on.
    pub fn new(cpu: CpuBackend<f32>, gpu: GpuBackend, from: Stage) -> Self {
        Self { cpu, gpu, from }
    }

    fn substep(&mut self, substep: &plan::Substep<f32>, input: &FrameInput) -> Result<(), Lost> {
        let places = self.cpu.assembly().places;
        let mut between = Between { force: vec![[0.0; 3]; places], ..Between::default() };
        let from = self.from;
        self.cpu.run_separately(substep, input, &mut between, |op| op.stage() < from);
        self.upload(substep, &between)?;
        self.gpu.finish(substep, input)?;
        let (position, velocity) = self.gpu.places()?;
        self.cpu.end(|axis, place| if axis < 3 { position[place][axis] } else { velocity[place][axis - 3] });
        Ok(())
    }

    /// State and findings of the CPU, as the GPU's stages expect them.
    fn upload(&mut self, substep: &plan::Substep<f32>, between: &Between<f32>) -> Result<(), Lost> {
        let places = self.cpu.assembly().places;
        let old = self.fours(places, false, &[]);
        self.gpu.put_state(false, &old);
        if self.from > Stage::Integrate {
            let collided = self.from > Stage::Contact && !substep.colliders().is_empty();
            let last_collider = if collided { &between.last_collider[..] } else { &[] };
            self.gpu.put_state(true, &self.fours(places, true, last_collider));
        }
        self.gpu.adopt_state(between, &mut self.cpu, substep);
        Ok(self.gpu.health()?)
    }

    /// Position and velocity of all places with what stands in their last numbers.
    fn fours(&self, places: usize, next: bool, last_collider: &[u32]) -> [Vec<Four>; 2] {
        let fields = self.cpu.fields(next);
        let (inverse_mass, mass) = self.cpu.masses();
        let four = |first: usize, place: usize, last: f32| -> Four {
            [fields[first][place], fields[first + 1][place], fields[first + 2][place], last]
        };
        let sign =
            |place: usize| if last_collider.get(place).is_some_and(|&last| last > 0) { -1.0 } else { 1.0 };
        [
            (0..places).map(|place| four(0, place, inverse_mass[place])).collect(),
            (0..places).map(|place| four(3, place, sign(place) * mass[place])).collect(),
        ]
    }
}

impl Backend for Boundary {
    fn frame(&mut self, start: f64, input: FrameInput) -> Result<(), Lost> {
        let substeps = plan::frame(self.cpu.assembly(), start, (1, InVain::NEVER), self.cpu.parameters);
        self.gpu.start_frame();
        substeps.iter().try_for_each(|substep| self.substep(substep, &input))
    }

    fn mark_good(&mut self) {
        self.cpu.mark_good();
    }

    fn return_to_good(&mut self) -> Result<(), Lost> {
        self.cpu.return_to_good()
    }

    fn measure(&mut self) -> Result<(), Lost> {
        let state = self.fours(self.cpu.assembly().places, false, &[]);
        self.gpu.put_state(false, &state);
        self.gpu.measure()
    }

    fn sums(&mut self) -> Result<FrameSums, Lost> {
        Ok(FrameSums { parts: 1, ..self.gpu.sums()? })
    }

    fn fetch(&mut self) -> Result<(), Lost> {
        Ok(())
    }

    fn assembly(&self) -> &Assembly {
        self.cpu.assembly()
    }

    fn alter(&mut self, how: &mut dyn FnMut(&mut Assembly)) {
        self.cpu.alter(how);
        self.gpu.alter(how);
    }

    fn position(&self, node: usize) -> [f64; 3] {
        self.cpu.position(node)
    }

    fn velocity(&self, node: usize) -> [f64; 3] {
        self.cpu.velocity(node)
    }

    fn set(&mut self, node: usize, position: [f64; 3], velocity: [f64; 3]) {
        self.cpu.set(node, position, velocity);
    }

    fn pin(&mut self, node: usize) {
        self.cpu.pin(node);
    }

    fn unpin(&mut self, node: usize) {
        self.cpu.unpin(node);
    }

    fn is_free(&self, node: usize) -> bool {
        self.cpu.is_free(node)
    }

    fn bytes(&self, node: usize, velocity: bool, sink: &mut Vec<u8>) {
        self.cpu.bytes(node, velocity, sink);
    }

    fn solver_state(&self) -> SolverState {
        self.gpu.solver_state()
    }

    fn set_solver_state(&mut self, from: &SolverState) {
        self.gpu.set_solver_state(from);
    }

    fn threads(&self) -> usize {
        1
    }

    fn device(&self) -> Device {
        let name = format!("cpu before {}, then {}", self.from.name(), self.gpu.device().name);
        Device { backend: "gpu", name }
    }

    fn memory(&self) -> usize {
        self.cpu.memory() + self.gpu.memory()
    }
}
