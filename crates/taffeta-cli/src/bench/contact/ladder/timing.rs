//! Times a rung.

use super::bins::Lost;
use super::{Baseline, Rung, Serial};
use crate::bench::Args;
use crate::bench::line::Line;
use crate::bench::measure::{self, BUDGET, Bench, Times};
use crate::console::counted;
use std::time::Instant;
use taffeta::taffeta_gpu::{DispatchList, Gpu, GpuError};
use taffeta::{GpuOptions, Simulation};
use taffeta_io::program::Failure;

/// Frames that take longer are timed by their sub-steps [s]: drivers give up what takes too long.
const LONGEST: f64 = 1.0;
/// Turns after which a software adapter leaves a loop: all pairs of more nodes are not looked at.
const SOFTWARE_TURNS: usize = 65_536;

/// Refuses what the GPU would not do to the end, without a word.
pub fn refuse(bench: &Bench, gpu: &Gpu, rung: Rung) -> Result<(), Failure> {
    let count: usize = bench.n.iter().map(|&side| side as usize).product();
    if !gpu.info().is_software() || count < SOFTWARE_TURNS {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "--rungs {}: {count} nodes on {}, which leaves a loop after {SOFTWARE_TURNS} turns; a smaller --n would do",
        rung.name(),
        gpu.info()
    )))
}

/// Times a rung from where the scene has settled.
pub fn run(bench: &Bench, args: &Args, gpu: &Gpu, rung: Rung, settled: &Simulation) -> Result<Line, Failure> {
    let (name, serial) = (rung.name(), Serial::new(bench, settled));
    let count = serial.now.len();
    let failed = |error: GpuError| Failure::Work(format!("--rungs {name}: {error}"));
    let mut baseline = Baseline::new(gpu, rung, &serial).map_err(failed)?;
    let substeps = bench.scene.time.substeps();
    let (times, timed) = baseline.times(args.frames, substeps).map_err(failed)?;
    let particles = baseline.particles().map_err(failed)?;
    if !particles.iter().all(|particle| particle.x.iter().all(|x| x.is_finite())) {
        return Err(Failure::Work(format!(
            "--rungs {name}: positions are no numbers any more, so its time says nothing"
        )));
    }
    let lost = baseline.bins.as_ref().map(|bins| bins.lost(gpu, count)).transpose().map_err(failed)?;
    let line = measure::line(bench, args, settled, &times, Some(&GpuOptions::from(gpu.clone())))?;
    let notes = [line.note, timed, lost.map(|lost| lost.words(rung))];
    let notes: Vec<String> = notes.into_iter().flatten().collect();
    Ok(Line {
        backend: "gpu",
        device: format!("gpu, {}", gpu.info()),
        kernels: None,
        rung: Some(name),
        precision: "f32".to_owned(),
        note: (!notes.is_empty()).then(|| notes.join("; ")),
        ..line
    })
}

impl Lost {
    /// For people: what the bins of `rung` lack.
    pub fn words(&self, rung: Rung) -> String {
        let left_out = counted(self.left_out as usize, "node", "nodes");
        if rung == Rung::Scanned {
            return format!("{left_out} found no room in a bin, in all frames together");
        }
        let (missing, verb) = match self.missing {
            1 => ("1 node".to_owned(), "is"),
            count => (counted(count as usize, "node", "nodes"), "are"),
        };
        let crossed = self.missing.saturating_sub(self.left_out);
        format!(
            "{missing} {verb} in no bin any more: {} found no room, {crossed} crossed a whole bin in a frame",
            self.left_out
        )
    }
}

impl Baseline {
    /// Times whole frames; where these are long and nothing says how many, some sub-steps, and says so.
    fn times(&mut self, frames: Option<u32>, substeps: u32) -> Result<(Times, Option<String>), GpuError> {
        // The first of each takes the memory.
        self.time(Self::refresh)?;
        let refresh = self.time(Self::refresh)?;
        self.time(Self::step)?;
        let step = self.time(Self::step)?;
        if frames.is_none() && refresh + step * f64::from(substeps) > LONGEST {
            return self.by_substeps(refresh, substeps);
        }
        let mut times = Times::of((frames, u32::MAX), true, |count| {
            let seconds =
                self.time(|baseline, list| (0..count).for_each(|_| baseline.frame(list, substeps)))?;
            Ok::<f64, GpuError>(seconds * 1e3 / f64::from(count))
        })?;
        if self.gpu.has_timestamps() {
            let mut list = DispatchList::new();
            self.frame(&mut list, substeps);
            times.stages = self.gpu.submit_timed(&list)?;
        }
        Ok((times, None))
    }

    /// Times as many sub-steps as the budget allows, for frames in which filling the bins takes `refresh` [s].
    fn by_substeps(&mut self, refresh: f64, substeps: u32) -> Result<(Times, Option<String>), GpuError> {
        let (mut ms, start) = (Vec::new(), Instant::now());
        while ms.is_empty() || start.elapsed().as_secs_f64() < BUDGET.0 {
            let step = self.time(Self::step)?;
            ms.push((refresh + step * f64::from(substeps)) * 1e3);
        }
        let filling = if self.bins.is_some() { " and bins filled once" } else { "" };
        let sub_steps = counted(ms.len(), "sub-step", "sub-steps");
        let note = format!("timed: {sub_steps}{filling}; a frame has {substeps}");
        let times = Times {
            frames: (ms.len() as u32).div_ceil(substeps),
            ms,
            batch: 1,
            stages: Vec::new(),
            solved: None,
        };
        Ok((times, Some(note)))
    }

    /// Time until what is recorded is done [s].
    fn time(&mut self, record: impl FnOnce(&mut Self, &mut DispatchList)) -> Result<f64, GpuError> {
        let start = Instant::now();
        let mut list = DispatchList::new();
        record(self, &mut list);
        self.gpu.submit(&list)?;
        self.gpu.wait()?;
        Ok(start.elapsed().as_secs_f64())
    }
}
