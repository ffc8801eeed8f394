//! What it costs to have every frame on the host.

use super::jobs::sheet;
use super::speed::{build, frames_in};
use serde::Serialize;
use std::time::Instant;
use taffeta::taffeta_gpu::Gpu;
use taffeta::{GpuKernels, Simulation, StepError};

/// Side of the sheet, and where time is short.
const SIDES: [u32; 2] = [512, 64];
/// Time for each way [s], and where time is short.
const BUDGET: [f64; 2] = [0.5, 0.1];

/// Time of a frame of a grid, by what the host waits for [ms].
#[derive(Serialize)]
pub struct ReadBack {
    /// Rows and columns.
    pub n: [u32; 2],
    /// Frames one after the other, one wait at the end.
    pub ms_without_waiting: f64,
    /// A wait for each frame's report.
    pub ms_with_report: f64,
    /// A wait for each frame's report and for all positions and velocities.
    pub ms_with_state: f64,
}

/// Measures the three.
pub fn measure(gpu: &Gpu, small: bool) -> Result<ReadBack, String> {
    let side = SIDES[usize::from(small)];
    let mut simulation = build(&sheet([side, side]), gpu, GpuKernels::Best)?;
    let frames = frames_in(&mut simulation, BUDGET[usize::from(small)])?;
    let mut ms = |run: fn(&mut Simulation, u32) -> Result<(), StepError>| {
        run(&mut simulation, 1).map_err(|error| error.to_string())?;
        let start = Instant::now();
        run(&mut simulation, frames).map_err(|error| error.to_string())?;
        Ok::<f64, String>(start.elapsed().as_secs_f64() * 1e3 / f64::from(frames))
    };
    Ok(ReadBack {
        n: [side, side],
        ms_without_waiting: ms(|simulation, frames| simulation.advance(frames).map(drop))?,
        ms_with_report: ms(|simulation, frames| (0..frames).try_for_each(|_| simulation.step().map(drop)))?,
        ms_with_state: ms(|simulation, frames| {
            (0..frames).try_for_each(|_| {
                simulation.step()?;
                simulation.fetch()
            })
        })?,
    })
}
