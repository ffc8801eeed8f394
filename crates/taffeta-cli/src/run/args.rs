//! The arguments of `taffeta run`.

use super::format::Format;
use clap::ValueEnum;
use clap::builder::{PossibleValuesParser, TypedValueParser};
use serde::{Deserialize, Serialize};
use std::path::PathBuf;
use taffeta::{Precision, Stage};

/// Run a scene and write its results
#[derive(clap::Args)]
pub struct Args {
    /// The scene, a TOML file
    pub(super) scene: PathBuf,
    /// Folder for the results [default: out/SCENE, or that of the checkpoint]
    #[arg(long, value_name = "DIR")]
    pub(super) out: Option<PathBuf>,
    /// Number of frames, instead of the scene's
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) frames: Option<u32>,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = Backend::Auto)]
    pub(super) backend: Backend,
    /// Worker threads [default: as many as help, at most all]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    pub(super) threads: Option<u16>,
    /// Arithmetic [default: f32]
    #[arg(long, value_enum)]
    pub(super) precision: Option<Arithmetic>,
    /// Change a value of the scene: body.flag.springs.structural.k=500; may be given several times
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(super) sets: Vec<String>,
    /// Formats of the results, with commas between [default: npy]
    #[arg(long, value_enum, value_delimiter = ',')]
    pub(super) format: Option<Vec<Format>>,
    /// Write a checkpoint every N frames
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..))]
    pub(super) checkpoint_every: Option<u32>,
    /// Count in every frame where surfaces pass through each other, by exact arithmetic; `stop` ends the run at the first
    #[arg(long, value_name = "HOW", value_enum, num_args = 0..=1, require_equals = true, default_missing_value = "count")]
    pub(super) verify_contact: Option<Verify>,
    /// What to do where a body diverges [default: stop]
    #[arg(long, value_name = "WHAT", value_enum)]
    pub(super) on_divergence: Option<OnDivergence>,
    /// Resume from a checkpoint of the same scene, or from that in a folder of results
    #[arg(long, value_name = "FILE")]
    pub(super) resume: Option<PathBuf>,
    /// Compute the stages before STAGE on the CPU, to find where CPU and GPU differ
    #[arg(long, value_name = "STAGE", hide_short_help = true, value_parser = stages())]
    pub(super) gpu_from: Option<Stage>,
    /// Print the summary as JSON, and nothing else on standard output
    #[arg(long)]
    pub(super) json: bool,
    /// Say nothing unless something is wrong
    #[arg(long)]
    pub(super) quiet: bool,
}

/// Where to compute.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum Backend {
    /// What is best for the scene
    Auto,
    /// CPU threads
    Cpu,
    /// A GPU; TAFFETA_ADAPTER chooses among several
    Gpu,
}

/// What to do where surfaces pass through each other.
#[derive(Clone, Copy, PartialEq, Eq, ValueEnum, Serialize, Deserialize)]
pub enum Verify {
    /// Go on
    Count,
    /// Stop, with exit code 1
    Stop,
}

/// What to do where a body diverges.
#[derive(Clone, Copy, ValueEnum)]
pub enum OnDivergence {
    /// Stop, with exit code 1
    Stop,
    /// Freeze it where it was, and go on with the others
    Freeze,
}

impl OnDivergence {
    /// As the engine calls it.
    pub fn of_engine(self) -> taffeta::OnDivergence {
        match self {
            Self::Stop => taffeta::OnDivergence::Stop,
            Self::Freeze => taffeta::OnDivergence::Freeze,
        }
    }
}

/// Arithmetic of a run.
#[derive(Clone, Copy, ValueEnum)]
pub enum Arithmetic {
    /// 32 bits: fast
    F32,
    /// 64 bits: slower, to compare with
    F64,
}

impl Arithmetic {
    /// As the engine calls it.
    pub fn precision(self) -> Precision {
        match self {
            Self::F32 => Precision::F32,
            Self::F64 => Precision::F64,
        }
    }
}

/// The names of the stages.
fn stages() -> impl TypedValueParser<Value = Stage> {
    PossibleValuesParser::new(Stage::ALL.map(Stage::name))
        .try_map(|name| Stage::ALL.into_iter().find(|stage| stage.name() == name).ok_or("no stage"))
}
