//! Nodes that touch each other: S2's scene by S2's programs, rung by rung, and by the engine.

mod bins;
mod ladder;
mod particle;
mod rung;
mod serial;
mod sheet;
#[cfg(test)]
mod tests;
pub mod timing;

pub use rung::Rung;

use ladder::Ladder;
use serde_json::{Value, json};
use serial::Serial;
use sheet::Sheet;
use taffeta::taffeta_gpu::{Choice, Gpu};
use taffeta::{GpuOptions, Options, Simulation};
use timing::Timed;

/// A run: a sheet of some side by one rung.
#[derive(Clone, Copy, Debug)]
pub struct Contact {
    /// How pairs of nodes are found.
    pub rung: Rung,
    /// Nodes along an edge.
    pub side: u32,
    /// Frames that are timed; as many as three seconds have, where nothing is said.
    pub frames: Option<u32>,
    /// Worker threads; as many as help, where nothing is said.
    pub threads: Option<usize>,
    /// Whether the engine computes on a GPU. S2's rungs but the first always do.
    pub gpu: bool,
}

/// Times a run, or its first `frames`.
///
/// # Errors
/// Where there is no GPU for it, or it fails.
pub fn run(contact: &Contact, frames: Option<u32>) -> Result<Value, String> {
    let gpu = contact.gpu || Rung::LADDER.contains(&contact.rung);
    let gpu = if gpu { Some(open()?) } else { None };
    on(contact, frames.or(contact.frames), gpu.as_ref())
}

/// The GPU that the environment names, or the best one.
fn open() -> Result<Gpu, String> {
    Gpu::open(&Choice::from_env()).map_err(|error| error.to_string())
}

fn on(contact: &Contact, frames: Option<u32>, gpu: Option<&Gpu>) -> Result<Value, String> {
    let (sheet, rung) = (Sheet { side: contact.side }, contact.rung);
    let on_cpu = Options { threads: contact.threads, ..Options::default() };
    match (rung, gpu) {
        (Rung::Serial, _) => {
            let mut serial = Serial::new(&sheet, &sheet.settled(&Options { threads: Some(1), ..on_cpu })?);
            let timed = serial.timed(frames, sheet.substeps());
            Ok(line(&sheet, rung, "cpu, 1 thread".to_owned(), &timed))
        }
        (Rung::Binned, gpu) => {
            let options = Options { gpu: gpu.cloned().map(GpuOptions::from), ..on_cpu };
            let mut simulation = sheet.settled(&options)?;
            let timed =
                timing::of_frames(frames, u32::MAX, gpu.is_some(), |count| advanced(&mut simulation, count))?;
            Ok(line(&sheet, rung, simulation.device(), &timed))
        }
        (_, Some(gpu)) => {
            let serial = Serial::new(&sheet, &sheet.settled(&on_cpu)?);
            let timed = Ladder::time(gpu, rung, &serial, frames, sheet.substeps())?;
            Ok(line(&sheet, rung, format!("gpu, {}", gpu.info()), &timed))
        }
        (_, None) => Err(format!("{} needs a GPU", rung.name())),
    }
}

/// Time of one of some frames [ms].
fn advanced(simulation: &mut Simulation, count: u32) -> Result<f64, String> {
    let start = std::time::Instant::now();
    simulation.advance(count).map_err(|error| error.to_string())?;
    Ok(start.elapsed().as_secs_f64() * 1e3 / f64::from(count))
}

/// What is kept of a run, as of a bench.
fn line(sheet: &Sheet, rung: Rung, device: String, timed: &Timed) -> Value {
    let [min, median, max] = timed.spread();
    let substeps = sheet.substeps();
    json!({
        "bench": "contact",
        "rung": rung.name(),
        "device": device,
        "precision": "f32",
        "nodes": sheet.side * sheet.side,
        "springs": sheet.springs(),
        "substeps_per_frame": substeps,
        "frames": timed.frames,
        "ms_per_frame": {"min": min, "median": median, "max": max},
        "steps_per_s": f64::from(substeps) * 1e3 / median,
        "note": timed.note,
    })
}
