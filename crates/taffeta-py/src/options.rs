//! How a simulation is run: backend, threads, arithmetic.

use crate::errors::Failure;
use crate::scene::Read;
use taffeta::taffeta_gpu::{Choice, Gpu};
use taffeta::{GpuOptions, OnDivergence, Options, Precision, Simulation};
use taffeta_io::program::{Work, at_once, faster};

/// Most threads that may be asked for.
const MOST_THREADS: i64 = 1024;

/// What the user asks for.
#[derive(Clone)]
pub struct Choices {
    pub backend: Backend,
    pub threads: Option<u16>,
    pub precision: Precision,
    pub on_divergence: OnDivergence,
}

/// Where to compute.
#[derive(Clone, Copy, PartialEq)]
pub enum Backend {
    Auto,
    Cpu,
    Gpu,
}

impl Choices {
    /// Reads the arguments of `Simulation`.
    pub fn of(
        backend: &str,
        threads: Option<i64>,
        precision: &str,
        on_divergence: &str,
    ) -> Result<Self, Failure> {
        let backends = [("auto", Backend::Auto), ("cpu", Backend::Cpu), ("gpu", Backend::Gpu)];
        let precisions = [("f32", Precision::F32), ("f64", Precision::F64)];
        let endings = [("stop", OnDivergence::Stop), ("freeze", OnDivergence::Freeze)];
        Ok(Self {
            backend: chosen("backend", backend, &backends)?,
            threads: threads.map(|threads| count("threads", threads, MOST_THREADS)).transpose()?,
            precision: chosen("precision", precision, &precisions)?,
            on_divergence: chosen("on_divergence", on_divergence, &endings)?,
        })
    }

    /// Builds a scene where it was asked for, or where it is faster, and says why there.
    pub fn build(&self, read: &Read) -> Result<(Simulation, String), Failure> {
        let scene = &read.loaded.scene;
        let (gpu, why) = match self.backend {
            Backend::Cpu => (None, "asked for".to_owned()),
            Backend::Gpu => (Some(open()?), "asked for".to_owned()),
            Backend::Auto => match faster(&Work::of(scene, self.threads, self.precision)) {
                Ok((gpu, why)) => (Some(gpu), why),
                Err(why) => (None, why),
            },
        };
        let chose_gpu = self.backend == Backend::Auto && gpu.is_some();
        match Simulation::new(scene, &self.options(gpu)) {
            Err(error) if chose_gpu => {
                let why = format!("the GPU cannot run this scene: {error}");
                let built =
                    Simulation::new(scene, &self.options(None)).map_err(|error| read.explain(&error))?;
                Ok((built, why))
            }
            built => Ok((built.map_err(|error| read.explain(&error))?, why)),
        }
    }

    fn options(&self, gpu: Option<Gpu>) -> Options {
        Options {
            threads: at_once(self.threads),
            precision: self.precision,
            on_divergence: self.on_divergence,
            gpu: gpu.map(GpuOptions::from),
            ..Options::default()
        }
    }
}

fn open() -> Result<Gpu, Failure> {
    Gpu::open(&Choice::from_env()).map_err(|error| Failure::Device(format!("backend=\"gpu\": {error}")))
}

/// The choice with a name.
fn chosen<T: Copy>(argument: &str, name: &str, all: &[(&str, T)]) -> Result<T, Failure> {
    let found = all.iter().find(|(one, _)| *one == name).map(|(_, choice)| *choice);
    found.ok_or_else(|| {
        let names: Vec<String> = all.iter().map(|(one, _)| format!("\"{one}\"")).collect();
        Failure::input(format!("{argument} is {name:?}; {} would do", names.join(" or ")))
    })
}

/// A number from 1 on.
fn count(argument: &str, number: i64, most: i64) -> Result<u16, Failure> {
    let within = (1..=most).contains(&number).then(|| u16::try_from(number).ok()).flatten();
    within.ok_or_else(|| Failure::input(format!("{argument} is {number}; 1 to {most} would do")))
}
