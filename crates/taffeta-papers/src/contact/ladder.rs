//! S2's programs for a GPU ("CUDA Cloth Simulation"): six rungs, each of which goes on from the one before.

use super::bins::{self, Bins};
use super::particle::{CONSTANTS, GROUP, PARTICLE, Particle, Spring, World};
use super::rung::Rung;
use super::serial::Serial;
use super::timing::{self, BUDGET, Timed};
use std::time::Instant;
use taffeta::taffeta_gpu::{Bindable, Bound, Buffer, DispatchList, Gpu, GpuError};

/// Frames that take longer are timed by their sub-steps [s]: drivers give up what takes too long.
const LONGEST: f64 = 1.0;

/// The sheet on a GPU, by the program of a rung.
pub struct Ladder {
    pub gpu: Gpu,
    rung: Rung,
    pub particles: [Buffer<Particle>; 2],
    /// By the buffer of particles that is read, then by the table of bins.
    substeps: [Vec<Bound>; 2],
    pub bins: Option<Bins>,
    /// Which buffer has the particles.
    pub now: usize,
}

/// The program of a sub-step, in whole files.
fn sources(rung: Rung) -> Vec<&'static str> {
    let bound = if rung >= Rung::Constants { CONSTANTS } else { include_str!("naive.wgsl") };
    let near = if rung >= Rung::Squared { include_str!("squares.wgsl") } else { include_str!("roots.wgsl") };
    let mut sources = vec![PARTICLE, bound, near, include_str!("substep.wgsl")];
    if rung.has_bins() {
        sources.extend([bins::SOURCE, include_str!("binned.wgsl")]);
    } else {
        sources.push(include_str!("all.wgsl"));
    }
    sources
}

impl Ladder {
    /// Starts from the same state as `serial`.
    pub fn new(gpu: &Gpu, rung: Rung, serial: &Serial) -> Result<Self, GpuError> {
        let particles: Vec<Particle> = serial.now.iter().map(Particle::from).collect();
        let springs: Vec<Spring> = serial.springs.iter().map(Spring::from).collect();
        let particles =
            [gpu.buffer_from("particles", &particles)?, gpu.buffer_from("particles, new", &particles)?];
        let starts = gpu.buffer_from("starts", &serial.starts)?;
        let springs = gpu.buffer_from("springs", &springs)?;
        let world = world(gpu, rung, serial)?;
        let bins = match rung.has_bins() {
            true => Some(Bins::new(gpu, rung, serial, &particles)?),
            false => None,
        };
        let overrides = if rung.has_bins() { &bins::overrides()[..] } else { &[] };
        let kernel = gpu.kernel("substep", &sources(rung), "substep", overrides)?;
        let bound = |from: usize, table: &[(&str, &dyn Bindable)]| {
            let buffers: [(&str, &dyn Bindable); 5] = [
                ("world", &*world),
                ("starts", &starts),
                ("springs", &springs),
                ("input", &particles[from]),
                ("result", &particles[1 - from]),
            ];
            kernel.bind(gpu, &[&buffers, table].concat())
        };
        let substeps = [0, 1].map(|from| match &bins {
            Some(bins) => bins.seen().iter().map(|table| bound(from, table)).collect(),
            None => vec![bound(from, &[])],
        });
        Ok(Self { gpu: gpu.clone(), rung, particles, substeps, bins, now: 0 })
    }

    /// Records a frame.
    pub fn frame(&mut self, list: &mut DispatchList, substeps: u32) {
        self.refresh(list);
        (0..substeps).for_each(|_| self.step(list));
    }

    /// Records that bins are filled again, where there are any.
    pub fn refresh(&mut self, list: &mut DispatchList) {
        if let Some(bins) = &mut self.bins {
            bins.refill(list, self.now);
        }
    }

    /// Records a sub-step.
    pub fn step(&mut self, list: &mut DispatchList) {
        let table = self.bins.as_ref().map_or(0, Bins::now);
        let groups = (self.particles[0].len() as u32).div_ceil(GROUP);
        list.dispatch(&self.substeps[self.now][table], &[], groups);
        if self.rung >= Rung::Swapped {
            self.now = 1 - self.now;
        } else {
            list.copy_buffer(&self.particles[1], &self.particles[0]);
        }
    }

    /// The particles, once all that was submitted is done.
    pub fn particles(&self) -> Result<Vec<Particle>, GpuError> {
        self.particles[self.now].read(&self.gpu)
    }

    /// Times a rung from where the scene has settled: whole frames, or where these are long and nothing says how many, sub-steps.
    ///
    /// # Errors
    /// What the GPU has to complain of; and where positions are no numbers any more.
    pub fn time(
        gpu: &Gpu,
        rung: Rung,
        serial: &Serial,
        frames: Option<u32>,
        substeps: u32,
    ) -> Result<Timed, String> {
        let failed = |error: GpuError| format!("{}: {error}", rung.name());
        let mut ladder = Self::new(gpu, rung, serial).map_err(failed)?;
        let mut timed = ladder.times(frames, substeps).map_err(failed)?;
        let particles = ladder.particles().map_err(failed)?;
        if !particles.iter().all(|particle| particle.x.iter().all(|x| x.is_finite())) {
            return Err(format!(
                "{}: positions are no numbers any more, so its time says nothing",
                rung.name()
            ));
        }
        if let Some(bins) = &ladder.bins {
            let lost = bins.lost(gpu, particles.len()).map_err(failed)?.words(rung);
            timed.note = Some(timed.note.map_or_else(|| lost.clone(), |note| format!("{note}; {lost}")));
        }
        Ok(timed)
    }

    fn times(&mut self, frames: Option<u32>, substeps: u32) -> Result<Timed, GpuError> {
        // The first of each takes the memory.
        self.seconds(Self::refresh)?;
        let refresh = self.seconds(Self::refresh)?;
        self.seconds(Self::step)?;
        let step = self.seconds(Self::step)?;
        if frames.is_none() && refresh + step * f64::from(substeps) > LONGEST {
            return self.by_substeps(refresh, substeps);
        }
        timing::of_frames(frames, u32::MAX, true, |count| {
            let seconds =
                self.seconds(|ladder, list| (0..count).for_each(|_| ladder.frame(list, substeps)))?;
            Ok(seconds * 1e3 / f64::from(count))
        })
    }

    /// Times as many sub-steps as the budget allows, for frames in which filling the bins takes `refresh` [s].
    fn by_substeps(&mut self, refresh: f64, substeps: u32) -> Result<Timed, GpuError> {
        let (mut ms, start) = (Vec::new(), Instant::now());
        while ms.is_empty() || start.elapsed().as_secs_f64() < BUDGET.0 {
            let step = self.seconds(Self::step)?;
            ms.push((refresh + step * f64::from(substeps)) * 1e3);
        }
        let filling = if self.bins.is_some() { " and bins filled once" } else { "" };
        let note = format!("sub-steps timed: {}{filling}; a frame has {substeps}", ms.len());
        Ok(Timed { frames: (ms.len() as u32).div_ceil(substeps), ms, note: Some(note) })
    }

    /// Time until what is recorded is done [s].
    fn seconds(&mut self, record: impl FnOnce(&mut Self, &mut DispatchList)) -> Result<f64, GpuError> {
        let start = Instant::now();
        let mut list = DispatchList::new();
        record(self, &mut list);
        self.gpu.submit(&list)?;
        self.gpu.wait()?;
        Ok(start.elapsed().as_secs_f64())
    }
}

/// What all particles share, where constants lie or in storage.
fn world(gpu: &Gpu, rung: Rung, serial: &Serial) -> Result<Box<dyn Bindable>, GpuError> {
    if rung < Rung::Constants {
        return Ok(Box::new(gpu.buffer_from("world", &[World::of(serial)])?));
    }
    let world = gpu.uniforms("world", 1)?;
    world.write(gpu, &[World::of(serial)]);
    Ok(Box::new(world))
}
