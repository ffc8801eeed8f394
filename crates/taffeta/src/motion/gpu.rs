//! Moving pins on the GPU.

use crate::assembly::Assembly;
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features, Upload};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{GROUP, Substep};
use crate::gpu::partition::fill;
use crate::gpu::schedule::Fused;
use crate::motion::gpu_layout::{MOVED_BY_USER, Motion, Pin};
use crate::motion::moving::MovingPin;
use crate::step::{Op, Stage};
use taffeta_gpu::{Bindable, Buffer, Gpu, GpuError, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!("motion", ["held.wgsl", "pins.wgsl", "stages.wgsl"]);

/// The moving pins of some bodies.
pub fn pins(bodies: &Bodies<'_>) -> Vec<Pin> {
    let inside = bodies.assembly.moving_pins().iter().filter(|pin| bodies.has(pin.node));
    let pin = |pin: &MovingPin| Pin {
        start: pin.start.map(|c| c as f32),
        node: bodies.local(pin.node as usize),
        goal: [0.0; 3],
        track: pin.track,
    };
    inside.map(pin).collect()
}

/// Moving pins on the device, and the motions of all tracks.
pub struct Pins {
    /// Those that follow keyframes.
    moving: Vec<Pin>,
    pins: Buffer<Pin>,
    motions: Buffer<Motion>,
    /// How many there are in this frame, those that the user moves among them.
    count: usize,
}

impl Pins {
    /// Takes them to the device.
    pub fn new(gpu: &Gpu, moving: &[Pin]) -> Result<Self, GpuError> {
        Ok(Self {
            moving: moving.to_vec(),
            pins: gpu.buffer("pins", moving.len())?,
            motions: gpu.buffer("motions", 1)?,
            count: moving.len(),
        })
    }

    /// Moves all of them.
    pub fn command<'f>(&self) -> Command<'f> {
        Command::run(Name::new("pins_all"), self.count.div_ceil(GROUP))
    }

    /// Whether any moves in this frame.
    pub fn any(&self) -> bool {
        self.count > 0
    }
}

impl Feature for Pins {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![("pins", &self.pins), ("motions", &self.motions)]
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        vec![Fused { writes_state: true, ..Fused::new(&[Op::Pins], vec![self.command()]) }]
    }

    fn bytes(&self, assembly: &Assembly) -> usize {
        assembly.tracks().len() * size_of::<Motion>()
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        let first = upload.places.start as u32;
        let inside = upload.input.moves.iter().filter(|(node, ..)| upload.places.contains(&(*node as usize)));
        let moved = inside.map(|&(node, from, to)| Pin {
            start: from.map(|c| c as f32),
            node: node - first,
            goal: to.map(|c| c as f32),
            track: MOVED_BY_USER,
        });
        let pins: Vec<Pin> = self.moving.iter().copied().chain(moved).collect();
        self.count = pins.len();
        let mut motions: Vec<Motion> = Vec::new();
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            record.first_motion = motions.len() as u32;
            record.pins = pins.len() as u32;
            record.pins_may_lag = substep.pins_may_lag.into();
            (record.frame_fraction, record.frame_rate) = substep.frame_fraction;
            motions.extend(substep.motions().iter().map(Motion::from));
        }
        let new = fill(upload.gpu, "motions", &mut self.motions, &motions)?;
        Ok(fill(upload.gpu, "pins", &mut self.pins, &pins)? | new)
    }
}
