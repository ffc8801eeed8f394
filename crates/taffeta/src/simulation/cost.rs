//! What a sub-step costs on a GPU, found by running some.

use crate::gpu::{GpuKernels, GpuOptions};
use crate::scene::{Body, Mass, Mesh, Scene};
use crate::simulation::{Options, Simulation};
use std::time::Instant;
use taffeta_gpu::Gpu;

/// Time of a sub-step: so much for each, and so much for each node.
///
/// ```no_run
/// use taffeta::GpuCost;
/// use taffeta::taffeta_gpu::{Choice, Gpu};
///
/// let cost = GpuCost::measure(&Gpu::open(&Choice::from_env())?)?;
/// // A frame of 33 sub-steps of a sheet of 256 x 256 nodes.
/// let seconds = 33.0 * (cost.seconds_per_substep + 256.0 * 256.0 * cost.seconds_per_node);
/// println!("{:.1} ms a frame", 1e3 * seconds);
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug)]
pub struct GpuCost {
    /// [s]
    pub seconds_per_substep: f64,
    /// [s], of a grid with all springs.
    pub seconds_per_node: f64,
}

/// Side and sub-steps of the sheets that are timed: one that any GPU finds small, and one that fills it.
const SHEETS: [(u32, u32); 2] = [(32, 256), (512, 32)];
/// The same on a processor, which a smaller sheet fills.
const SOFTWARE_SHEETS: [(u32, u32); 2] = [(32, 256), (128, 32)];

impl GpuCost {
    /// Times sub-steps on a small and on a large sheet; takes some tenths of a second.
    ///
    /// # Errors
    /// What the device refuses, in words.
    pub fn measure(gpu: &Gpu) -> Result<Self, String> {
        let sheets = if gpu.info().is_software() { SOFTWARE_SHEETS } else { SHEETS };
        let [(small, short), (large, long)] = sheets.map(|(side, steps)| (side, time(gpu, side, steps)));
        let (short, long) = (short?, long?);
        let nodes = f64::from(large * large - small * small);
        let per_node = (long - short).max(0.0) / nodes;
        let per_substep = (short - per_node * f64::from(small * small)).max(0.0);
        Ok(Self { seconds_per_substep: per_substep, seconds_per_node: per_node })
    }
}

/// Median time of a sub-step [s] of a sheet of `side` × `side` nodes.
fn time(gpu: &Gpu, side: u32, steps: u32) -> Result<f64, String> {
    let extent = f64::from(side) * 0.01;
    let sheet = Body::cloth("sheet", Mesh::grid(side, side, [extent, extent])).with_mass(Mass::Node(1e-3));
    let sheet = sheet.structural(60.0, 0.01).shear(60.0, 0.01).bend(60.0, 0.01);
    let scene = Scene::new("cost").body(sheet).time(f64::from(steps) * 1e-3, 1e-3);
    let options = GpuOptions { kernels: GpuKernels::Plain, ..gpu.clone().into() };
    let options = Options { gpu: Some(options), ..Options::default() };
    let mut simulation = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
    let mut frame = || {
        let start = Instant::now();
        simulation.step().map_err(|error| error.to_string())?;
        Ok::<f64, String>(start.elapsed().as_secs_f64() / f64::from(steps))
    };
    frame()?;
    let mut times = [frame()?, frame()?, frame()?];
    times.sort_by(f64::total_cmp);
    Ok(times[1])
}
