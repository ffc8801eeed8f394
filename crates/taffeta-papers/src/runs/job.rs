//! What is run: benches of the program, and scenes.

use crate::contact::{self, Contact};
use crate::kernels::bench::KernelRun;
use crate::runs::behaviour::{self, Scene};
use crate::runs::scenes;
use crate::runs::turns::{self, Turns};
use crate::tournament;
use serde_json::{Map, Value, json};
use std::path::Path;
use std::process::{Command, Stdio};
use taffeta::{Options, Simulation};

/// A run whose result is kept.
#[derive(Clone, Debug)]
pub struct Job {
    /// What it is called: letters, numbers and hyphens.
    pub name: String,
    /// What is run.
    pub what: What,
    /// Whether only a hardware GPU can do it.
    pub gpu: bool,
    /// What a quick look makes of it.
    pub quick: Quick,
}

/// What is run.
#[derive(Clone, Debug)]
pub enum What {
    /// The program with these words, which prints a line of JSON.
    Bench(String),
    /// A scene.
    Scene(Scene),
    /// S2's scene by one of its programs, or by the engine.
    Contact(Contact),
    /// Kernels of a paper, or of the engine.
    Kernels(KernelRun),
    /// What keeping volumes costs the bodies of a scene.
    Turns(Turns),
    /// The springs of a scene are counted.
    Counts(Scene),
    /// A run of the tournament, by its name.
    Bout,
    /// Another program, which leaves lines for `--merge`: how it is run.
    Elsewhere(&'static str),
}

/// What a quick look makes of a run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quick {
    /// The same.
    Whole,
    /// Only so many frames.
    Frames(u32),
    /// Nothing.
    Out,
}

/// What runs need beside themselves.
pub struct Place<'a> {
    /// The program `taffeta`, where there are benches.
    pub taffeta: Option<&'a Path>,
    /// Where what takes long to compute may be left for a later run.
    pub cache: &'a Path,
    /// Whether the user wants it to end.
    pub stopped: &'a dyn Fn() -> bool,
}

impl Job {
    /// A bench.
    pub fn bench(name: impl Into<String>, words: impl Into<String>, quick: Quick) -> Self {
        Self { name: name.into(), what: What::Bench(words.into()), gpu: false, quick }
    }

    /// A scene with values set.
    pub fn scene(name: impl Into<String>, scene: &'static str, sets: &[String], quick: Quick) -> Self {
        let scene = Scene { name: scene, sets: sets.to_vec(), threads: None, pictured: false };
        Self { name: name.into(), what: What::Scene(scene), gpu: false, quick }
    }

    /// S2's scene.
    pub fn contact(name: String, contact: Contact, quick: Quick) -> Self {
        Self { name, what: What::Contact(contact), gpu: false, quick }
    }

    /// Kernels of a paper, which only a hardware GPU is to run.
    pub fn kernels(name: String, run: KernelRun) -> Self {
        Self { name, what: What::Kernels(run), gpu: true, quick: Quick::Whole }
    }

    /// What keeping volumes costs.
    pub fn turns(name: String, turns: Turns, quick: Quick) -> Self {
        Self { name, what: What::Turns(turns), gpu: false, quick }
    }

    /// A run of the tournament.
    pub fn bout(name: String, quick: Quick) -> Self {
        Self { name, what: What::Bout, gpu: false, quick }
    }

    /// The same where only a hardware GPU can do it.
    pub fn on_gpu(self) -> Self {
        Self { gpu: true, ..self }
    }

    /// The same with pictures of the cloth.
    pub fn pictured(mut self) -> Self {
        if let What::Scene(scene) = &mut self.what {
            scene.pictured = true;
        }
        self
    }

    /// The same on so many threads.
    pub fn threads(mut self, threads: usize) -> Self {
        if let What::Scene(scene) = &mut self.what {
            scene.threads = Some(threads);
        }
        self
    }

    /// Whether the program `taffeta` runs it.
    pub fn is_bench(&self) -> bool {
        matches!(self.what, What::Bench(_))
    }

    /// The file of the mesh that a bench is asked for.
    pub fn mesh(&self) -> Option<&str> {
        match &self.what {
            What::Bench(words) => words.split(' ').skip_while(|word| *word != "--mesh").nth(1),
            _ => None,
        }
    }

    /// The command that does the same.
    pub fn command(&self, quick: bool) -> String {
        let frames = self.frames(quick).map_or_else(String::new, |frames| format!(" --frames {frames}"));
        match &self.what {
            What::Bench(words) => format!("taffeta {words}{frames}"),
            What::Scene(scene) => {
                let threads =
                    scene.threads.map_or_else(String::new, |threads| format!(" --threads {threads}"));
                format!("{} --backend cpu{threads}{frames}", scenes::command("run", scene.name, &scene.sets))
            }
            What::Counts(scene) => {
                format!("{} --json", scenes::command("check", scene.name, &scene.sets))
            }
            What::Contact(_) => format!("taffeta-papers s2 --out DIR # {}", self.name),
            What::Kernels(run) => run.command(),
            What::Turns(_) => format!("taffeta-papers s3 --out DIR # {}", self.name),
            What::Bout => format!("taffeta-papers all --out DIR # {}", self.name),
            What::Elsewhere(command) => (*command).to_owned(),
        }
    }

    fn frames(&self, quick: bool) -> Option<u32> {
        match self.quick {
            Quick::Frames(frames) if quick => Some(frames),
            _ => None,
        }
    }

    /// Runs it.
    ///
    /// # Errors
    /// What went wrong, in words.
    pub fn run(&self, quick: bool, place: &Place) -> Result<Value, String> {
        let frames = self.frames(quick);
        let json = |error: serde_json::Error| error.to_string();
        match &self.what {
            What::Bench(words) => bench(place.taffeta.ok_or("there is no `taffeta`")?, words, frames),
            What::Scene(scene) => behaviour::run(scene, frames, place.stopped)
                .and_then(|done| serde_json::to_value(done).map_err(json)),
            What::Contact(run) => contact::run(run, frames),
            What::Kernels(run) => run.run(frames),
            What::Turns(run) => turns::run(run),
            What::Counts(scene) => counts(scene),
            What::Bout => tournament::run(&self.name, place.cache),
            What::Elsewhere(command) => Err(format!("is run by `{command}`")),
        }
    }
}

/// The line that a bench prints.
fn bench(taffeta: &Path, words: &str, frames: Option<u32>) -> Result<Value, String> {
    let mut command = Command::new(taffeta);
    command.args(words.split(' ')).stdin(Stdio::null());
    if let Some(frames) = frames {
        command.args(["--frames", &frames.to_string()]);
    }
    let output = command.output().map_err(|error| format!("{}: {error}", taffeta.display()))?;
    let said = String::from_utf8_lossy(&output.stderr);
    if !output.status.success() {
        return Err(format!("taffeta {words}: {}", said.trim()));
    }
    serde_json::from_slice(&output.stdout).map_err(|error| format!("taffeta {words}: {error}"))
}

/// How many springs of each kind a scene has.
fn counts(scene: &Scene) -> Result<Value, String> {
    let loaded = scenes::load(scene.name, &scene.sets)?;
    let simulation =
        Simulation::new(&loaded.scene, &Options::default()).map_err(|error| error.to_string())?;
    let body = simulation.bodies().first().ok_or("the scene has no body")?;
    let kinds = body.springs.iter().map(|(kind, count)| (kind.to_string(), Value::from(*count)));
    let sum: usize = body.springs.iter().map(|(_, count)| count).sum();
    Ok(json!({"nodes": body.nodes, "springs": sum, "kinds": kinds.collect::<Map<_, _>>()}))
}
