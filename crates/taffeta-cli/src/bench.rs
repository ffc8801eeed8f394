//! `taffeta bench`: how fast the engine is, beside what the machine can do at most.

mod acad;
mod busy;
mod collider;
mod contact;
mod fabric;
mod form;
mod ice;
pub mod kernels;
mod line;
mod measure;
mod mesh;
pub mod scenes;
mod sleep;
mod start;
mod volume;

use crate::console;
use crate::run::{Arithmetic, Backend, Device, Work, refuse_precision, too_many};
use clap::ValueEnum;
use clap::builder::TypedValueParser as _;
use form::Form;
use line::Line;
use measure::Bench;
use serde::Serialize;
use std::path::PathBuf;
use taffeta::scene::VolumeForm;
use taffeta::{GpuKernels, GpuOptions};
use taffeta_io::program::{Failure, complain};

/// Measure the engine's speed
#[derive(clap::Args)]
pub struct Args {
    /// What to measure
    #[arg(value_enum, default_value_t = What::Grid)]
    what: What,
    /// Side of the grid in nodes; for mesh: at least that many springs; for volume: triangles of a torus, or at least
    /// that many of --mesh [default: 160, ice and acad: 34, flag, tethers, xpbd, fabric and collider: 100, mesh: 1000000, volume: the dragon, or 20000]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(2..=20_000_000))]
    n: Option<u32>,
    /// Rows of the grid
    #[arg(long, value_name = "R", requires = "cols", conflicts_with = "n",
          value_parser = clap::value_parser!(u32).range(2..=65_536))]
    rows: Option<u32>,
    /// Columns of the grid
    #[arg(long, value_name = "C", requires = "rows",
          value_parser = clap::value_parser!(u32).range(2..=65_536))]
    cols: Option<u32>,
    /// Frames to time, after one that is not [default: about three seconds' worth]
    #[arg(long, value_name = "F", value_parser = clap::value_parser!(u32).range(1..))]
    frames: Option<u32>,
    /// Worker threads [default: as many as help, at most all]
    #[arg(long, value_name = "T", value_parser = clap::value_parser!(u16).range(1..=1024))]
    threads: Option<u16>,
    /// Where to compute
    #[arg(long, value_enum, default_value_t = Backend::Cpu)]
    backend: Backend,
    /// Arithmetic
    #[arg(long, value_enum, default_value_t = Arithmetic::F32)]
    precision: Arithmetic,
    /// For explicit springs on a GPU: which kernels, a line for each [default: best]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = kernels::parser())]
    kernels: Option<Vec<GpuKernels>>,
    /// For volume: how it is kept; for ice and flag: compliant or primal; for fabric: primal. A line for each [default:
    /// corrected, compliant, flag: primal, fabric: explicit]
    #[arg(long, value_name = "NAMES", value_delimiter = ',', value_parser = form::parser())]
    form: Option<Vec<Form>>,
    /// For mesh and volume: an OBJ, PLY, STL, OFF or glTF file
    #[arg(long, value_name = "FILE")]
    mesh: Option<PathBuf>,
    /// For fabric: how many times stiffer the warp is than the weft [default: as cotton is]
    #[arg(long, value_name = "R", value_parser = ratio())]
    ratio: Option<f64>,
    /// For fabric: an irregular mesh of as many nodes in place of the grid
    #[arg(long)]
    irregular: bool,
    /// Print only the JSON line
    #[arg(long)]
    json: bool,
}

#[derive(Clone, Copy, PartialEq, Eq, ValueEnum)]
enum What {
    /// A disturbed sheet: structural, shear and bend springs with damping
    Grid,
    /// Edges of a triangle mesh, with damping
    Mesh,
    /// A sheet falling on a ball
    Drape,
    /// A sheet falling on a ball, the floor and itself
    Contact,
    /// S1's drop of a sheet on a ball by implicit constraints
    Ice,
    /// A stiff sheet that swings from two corners by implicit constraints, at one step a frame
    Flag,
    /// The same on soft explicit springs and tethers
    Tethers,
    /// The same by constraints on positions over several levels, in four sub-steps a frame
    Xpbd,
    /// A cotton flag that swings from two corners; with --form primal at one step a frame
    Fabric,
    /// Springs that become constraints where they are too long, beside springs alone
    Acad,
    /// A sheet on a ball of triangles beside the same on a sphere, and a skirt on a human
    Collider,
    /// A body that keeps its volume, falling on a floor
    Volume,
    /// How long it takes to build many small sheets, and a ball
    Start,
    /// Many small sheets of which all, one and none are awake
    Sleep,
    /// One thread and several beside other threads that take the cores
    Busy,
}

/// Runs one bench and prints its lines.
pub fn run(args: &Args) -> Result<(), Failure> {
    args.refuse()?;
    if let Some(note) = too_many(args.threads) {
        complain(&format!("note: {note}"));
    }
    let bench = args.bench()?;
    crate::memory::check(&bench.scene)?;
    match args.what {
        What::Ice | What::Flag => ice::run(args, &bench),
        What::Fabric => run_fabric(args),
        What::Acad => acad::run(args, &bench),
        What::Collider => collider::run(args, &bench),
        What::Start => start::run(args),
        What::Sleep => sleep::run(args),
        What::Busy => busy::run(args),
        _ => run_scene(args, bench),
    }
}

/// Prints a line for a scene; one for each form, and for each kind of kernels.
fn run_scene(args: &Args, mut bench: Bench) -> Result<(), Failure> {
    let precision = args.precision.precision();
    let device = Device::asked(args.backend, || Work::of(&bench.scene, args.threads, precision))?;
    bench.notes.extend(device.why);
    for form in args.forms() {
        if let Some(form) = form {
            bench.scene = volume::keeping(&bench, form);
            bench.form = Some(Form::Volume(form));
        }
        let Some(gpu) = &device.gpu else {
            print(&measure::run(&bench, args, None)?, args)?;
            continue;
        };
        for &kernels in args.kernels.as_deref().unwrap_or(&[GpuKernels::Best]) {
            let options = GpuOptions { kernels, ..gpu.clone() };
            print(&measure::run(&bench, args, Some(&options))?, args)?;
        }
    }
    Ok(())
}

/// Prints a line for each way of solving for a fabric.
fn run_fabric(args: &Args) -> Result<(), Failure> {
    let forms =
        args.form.as_ref().map_or_else(|| vec![None], |forms| forms.iter().copied().map(Some).collect());
    for form in forms {
        let mut bench = args.cloth(form).bench();
        let device =
            Device::asked(args.backend, || Work::of(&bench.scene, args.threads, args.precision.precision()))?;
        bench.notes.extend(device.why);
        print(&measure::run(&bench, args, device.gpu.as_ref())?, args)?;
    }
    Ok(())
}

fn print(line: &Line, args: &Args) -> Result<(), Failure> {
    say(line, || line.table(), args)
}

/// Prints a line of any bench, for people and as JSON.
fn say(line: &impl Serialize, table: impl FnOnce() -> String, args: &Args) -> Result<(), Failure> {
    if !args.json {
        console::say(&table())?;
    }
    let text = serde_json::to_string(line).map_err(|error| Failure::Work(format!("JSON: {error}")))?;
    console::say(&text)
}

impl Args {
    /// Refuses what does not go together.
    fn refuse(&self) -> Result<(), Failure> {
        let refused = |why: &str| Err(Failure::Input(why.into()));
        if self.mesh.is_some() && !matches!(self.what, What::Mesh | What::Volume) {
            return refused("--mesh is for `bench mesh` and `bench volume`");
        }
        if (self.ratio.is_some() || self.irregular) && self.what != What::Fabric {
            return refused("--ratio and --irregular are for `bench fabric`");
        }
        self.refuse_forms()?;
        if self.kernels.is_some() && matches!(self.what, What::Ice | What::Flag | What::Fabric) {
            return refused("--kernels is for benches on explicit springs");
        }
        if self.backend == Backend::Gpu {
            return refuse_precision(self.precision.precision());
        }
        if self.kernels.is_some() { refused("--kernels is for --backend gpu") } else { Ok(()) }
    }

    /// Refuses forms of something else.
    fn refuse_forms(&self) -> Result<(), Failure> {
        let Some(forms) = &self.form else { return Ok(()) };
        let fits: fn(Form) -> bool = match self.what {
            What::Volume => |form| matches!(form, Form::Volume(_)),
            What::Ice | What::Flag => |form| matches!(form, Form::Ice(_)),
            What::Fabric => fabric::fits,
            _ => {
                return Err(Failure::Input(
                    "--form is for `bench volume`, `bench ice`, `bench flag` and `bench fabric`".into(),
                ));
            }
        };
        forms.iter().find(|&&form| !fits(form)).map_or(Ok(()), |form| {
            let (name, valid) = (form.name(), Form::names(fits));
            Err(Failure::Input(format!("--form {name} is not for this bench, which takes {valid}")))
        })
    }

    /// How the volume is kept, one after the other; nothing to say elsewhere.
    fn forms(&self) -> Vec<Option<VolumeForm>> {
        match (&self.form, self.what) {
            (Some(forms), _) => forms.iter().map(|form| form.of_volume()).collect(),
            (None, What::Volume) => vec![Some(VolumeForm::Corrected)],
            (None, _) => vec![None],
        }
    }

    /// The fabric of the bench on fabric.
    fn cloth(&self, form: Option<Form>) -> fabric::Cloth {
        fabric::Cloth { sides: self.sides(), ratio: self.ratio, is_irregular: self.irregular, form }
    }

    /// Rows and columns.
    fn sides(&self) -> [u32; 2] {
        let usual = match self.what {
            What::Ice | What::Acad => ice::SIDE,
            What::Flag | What::Tethers | What::Xpbd | What::Fabric => ice::FLAG_SIDE,
            What::Collider => collider::SIDE,
            _ => 160,
        };
        let side = self.n.unwrap_or(usual);
        [self.rows.unwrap_or(side), self.cols.unwrap_or(side)]
    }

    fn bench(&self) -> Result<Bench, Failure> {
        let [rows, cols] = self.sides();
        match self.what {
            What::Grid => Ok(scenes::grid(rows, cols)),
            What::Drape => Ok(scenes::drape(rows, cols)),
            What::Contact => Ok(contact::bench(rows, cols)),
            What::Ice => Ok(ice::bench([rows, cols])),
            What::Flag => Ok(ice::flag([rows, cols])),
            What::Tethers => Ok(ice::tethers([rows, cols])),
            What::Xpbd => Ok(ice::xpbd([rows, cols])),
            What::Fabric => Ok(self.cloth(None).bench()),
            What::Acad => Ok(acad::bench([rows, cols])),
            What::Collider => Ok(collider::bench([rows, cols])),
            What::Mesh | What::Volume if self.rows.is_some() => Err(Failure::Input(
                "--rows and --cols are for grids; `bench mesh` takes --n springs, `bench volume` --n triangles".into(),
            )),
            What::Mesh => mesh::bench(self.mesh.as_deref(), self.n.unwrap_or(1_000_000) as usize),
            What::Volume => volume::bench(self.mesh.as_deref(), self.n),
            What::Start | What::Busy => Ok(Bench::new("start", vec![100, 20, 20], start::sheets())),
            What::Sleep => Ok(sleep::benches()[0].clone()),
        }
    }
}

/// Takes a ratio of stiffnesses on the command line.
fn ratio() -> impl clap::builder::TypedValueParser<Value = f64> {
    clap::builder::NonEmptyStringValueParser::new().try_map(|text| match text.parse::<f64>() {
        Ok(ratio) if (1e-3..=1e3).contains(&ratio) => Ok(ratio),
        _ => Err("is a number from 0.001 to 1000"),
    })
}
