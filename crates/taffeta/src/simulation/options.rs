//! How to run a scene, apart from what it is.

use crate::cpu::team::Pool;
#[cfg(feature = "gpu")]
use crate::gpu::GpuOptions;
use crate::simulation::OnDivergence;
use serde::{Deserialize, Serialize};

/// Arithmetic of a run.
///
/// ```
/// # use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
/// # use taffeta::{Options, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05).pin(Select::nodes([0])));
/// use taffeta::Precision;
///
/// // How many digits 32 bits keep in ten frames.
/// let mut places: [Vec<[f64; 3]>; 2] = Default::default();
/// for (precision, places) in [Precision::F32, Precision::F64].into_iter().zip(&mut places) {
///     let mut simulation = Simulation::new(&scene, &Options { precision, ..Options::default() })?;
///     simulation.advance(10)?;
///     simulation.positions_f64(places);
/// }
/// let [fast, oracle] = places.each_ref().map(|places| places.as_flattened());
/// let off = fast.iter().zip(oracle).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
/// assert!(off > 0.0 && off < 1e-5, "{off} m");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Precision {
    /// 32 bits: the fast path.
    #[default]
    F32,
    /// 64 bits: the oracle.
    F64,
}

/// How to run a scene, apart from what it is. More may come: write `..Options::default()`.
///
/// ```
/// use taffeta::{Options, Precision};
///
/// let reference = Options { precision: Precision::F64, threads: Some(1), ..Options::default() };
/// # let _ = reference;
/// ```
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Worker threads; `None`: all that the machine has, but one for every 4,096 nodes at most, for less work than
    /// that is done before the workers have met.
    pub threads: Option<usize>,
    /// Threads of the program to work on; `None`: threads of its own.
    pub pool: Option<Pool>,
    /// Arithmetic; a GPU computes in [`Precision::F32`] alone.
    pub precision: Precision,
    /// Whether to find the largest stable steps ([`crate::Simulation::largest_stable_step`]) in any case. Otherwise they are found
    /// only where a bound does not tell that the scene's own step is stable; else that bound is given for them. It may take as
    /// long as the rest of the start.
    pub find_largest_steps: bool,
    /// What becomes of a scene in which a body diverges.
    pub on_divergence: OnDivergence,
    /// The GPU to run on; `None`: the CPU.
    #[cfg(feature = "gpu")]
    pub gpu: Option<GpuOptions>,
}
