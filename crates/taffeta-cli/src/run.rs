//! `taffeta run`: a scene to files.

mod args;
mod device;
mod format;
mod job;
mod outputs;
mod plan;
mod progress;
mod solves;
mod tally;
mod volumes;

use crate::console::{self, grouped};
use crate::memory;
use crate::summary::{SolverSummary, Summary};
pub use args::{Args, Arithmetic, Backend};
pub use device::{Device, refuse_precision};
use format::Poses;
use job::{Ending, Job, stop_on_ctrl_c};
pub use outputs::unwritable;
use plan::Plan;
use std::path::Path;
use taffeta::Simulation;
use taffeta_io::Loaded;
use taffeta_io::program::{Failure, RunLock, one_line};
pub use taffeta_io::program::{Work, at_once, too_many};
pub use tally::{median, rate};

/// Runs a scene.
pub fn run(args: &Args) -> Result<(), Failure> {
    device::refuse(args)?;
    let loaded = taffeta_io::load_scene(&args.scene, &args.sets)?;
    let dir = Plan::dir(args);
    let _lock = RunLock::take(&dir).map_err(|error| unwritable(&dir, error))?;
    let plan = Plan::new(args, &loaded)?;
    memory::check_run(&loaded.scene, plan.formats.iter().any(|format| format.has_faces()))?;
    let mut device = Device::new(args, &plan, &loaded.scene)?;
    let simulation = device.build(args, &plan, &loaded)?;
    let stop = stop_on_ctrl_c()?;
    args.say(&opening(args, &loaded, &simulation, &device, &plan))?;

    let mut job = Job::new(&plan, simulation, &loaded.scene)?;
    let ending = job.run(args.quiet, &stop);
    close(args, &loaded, job, ending)
}

/// Completes the files, writes the summary and says how it went.
fn close(args: &Args, loaded: &Loaded, job: Job, ending: Ending) -> Result<(), Failure> {
    let (path, saved, frames) = (job.path(), job.saved, job.outputs.frames());
    let Job { plan, simulation, outputs, tally, .. } = job;
    let poses = match ending {
        _ if ending.is_orderly() => Poses::Full,
        // The files have kept the positions of the last good frame.
        Ending::Diverged(_) | Ending::Lost(_) if frames > 0 => Poses::Bare,
        _ => Poses::None,
    };
    let lost = matches!(ending, Ending::Lost(_));
    let (files, failed) = outputs.finish(&simulation, poses);
    // What went wrong first is what is said.
    let ending = match (ending, failed) {
        (ending, Some(error)) if ending.is_orderly() => Ending::Failed(error),
        (ending, _) => ending,
    };
    let mut summary = tally.summary(args, &loaded.scene, &simulation, ending.status(), lost);
    summary.files = files;
    // The frame that could not be kept does not count.
    summary.frames = u32::try_from(frames).unwrap_or(u32::MAX).saturating_sub(1);
    let ending = match (ending, outputs::write_summary(&plan.dir, &summary)) {
        (ending, Err(error)) if ending.is_orderly() => Ending::Failed(error),
        (ending, _) => ending,
    };
    if args.json {
        console::say(&console::json(&summary)?)?;
    }
    let kept = match frames {
        0 => format!("no frame is in {}", plan.dir.display()),
        1 => format!("frame 0, the start, is in {}", plan.dir.display()),
        _ => format!("frames 0 to {} are in {}", frames - 1, plan.dir.display()),
    };
    let go_on =
        saved.map(|frame| format!("\ncheckpoint at frame {frame}; to go on: {}", args.resume_command(&path)));
    let go_on = go_on.unwrap_or_default();
    match ending {
        Ending::Done => {
            if plan.every.is_none() {
                // All is done: there is nothing to go on with.
                let _ = std::fs::remove_file(&path);
            }
            args.say(&closing(&summary, &tally.warnings(&simulation, &loaded.scene), &plan.dir))
        }
        Ending::Diverged(error) | Ending::Lost(error) => {
            let error = console::advised(&error, error.advice());
            Err(Failure::Work(format!("{error}\n{kept}{go_on}")))
        }
        Ending::Failed(error) => Err(Failure::Work(format!("{error}\n{kept}{go_on}"))),
        Ending::Intersected(what) => Err(Failure::Work(format!("{what}\n{kept}"))),
        Ending::Full(what) => Err(Failure::Work(format!("{what}\n{kept}{go_on}"))),
        Ending::Interrupted => Err(Failure::Interrupted(format!("interrupted: {kept}{go_on}"))),
    }
}

impl Args {
    /// The command that goes on from the checkpoint at `path`.
    fn resume_command(&self, path: &Path) -> String {
        let mut words = vec!["taffeta run".to_owned(), path_word(&self.scene)];
        words.push(format!("--resume {}", path_word(path)));
        if let Some(stage) = self.gpu_from {
            words.push(format!("--backend gpu --gpu-from {}", stage.name()));
        }
        words.extend(self.sets.iter().map(|set| format!("--set {}", quoted(set))));
        words.join(" ")
    }

    /// To people, where the output is not for a program.
    fn say(&self, text: &str) -> Result<(), Failure> {
        if self.quiet || self.json { Ok(()) } else { console::say(text) }
    }
}

/// A path as a shell takes it, and as no option.
fn path_word(path: &Path) -> String {
    let text = path.to_string_lossy();
    quoted(&if text.starts_with('-') { format!("./{text}") } else { text.into_owned() })
}

/// A word as a shell takes it.
fn quoted(word: &str) -> String {
    let plain = |c: char| c.is_alphanumeric() || "-_./=,:+@%".contains(c);
    if !word.is_empty() && word.chars().all(plain) {
        return word.to_owned();
    }
    format!("'{}'", word.replace('\'', "'\\''"))
}

/// What is run, and what is to be known about it.
fn opening(args: &Args, loaded: &Loaded, simulation: &Simulation, device: &Device, plan: &Plan) -> String {
    let mut lines = vec![match loaded.scene.title.as_str() {
        "" => "untitled scene".to_owned(),
        title => one_line(title).into_owned(),
    }];
    for body in simulation.bodies() {
        let springs = body.springs.iter().map(|(_, count)| count).sum();
        lines.push(format!("  {}: {} nodes, {} springs", body.name, grouped(body.nodes), grouped(springs)));
        lines.extend(body.repairs.iter().map(|repair| format!("    {}", console::repaired(repair))));
    }
    for collider in simulation.colliders().iter().filter(|collider| !collider.repairs.is_empty()) {
        lines.push(format!("  collider {}: {}", collider.name, collider.shape));
        lines.extend(collider.repairs.iter().map(|repair| format!("    {}", console::repaired(repair))));
    }
    let on_cpu = device.gpu.is_none();
    let notes = device.notes().into_iter().chain(on_cpu.then(|| too_many(args.threads)).flatten());
    let notes: Vec<String> = loaded.notes.iter().cloned().chain(notes).collect();
    lines.extend(notes.into_iter().map(|note| format!("note: {note}")));
    let disk = memory::disk_warning(&plan.dir, plan.bytes(simulation));
    lines.extend(console::warnings(simulation).chain(disk).map(|warning| format!("warning: {warning}")));
    lines.extend(plan.going_on(simulation));
    lines.push(match &device.why {
        Some(why) => format!("{} ({why})", simulation.device()),
        None => simulation.device(),
    });
    lines.join("\n")
}

fn closing(summary: &Summary, warnings: &[String], dir: &Path) -> String {
    let warnings: String = warnings.iter().map(|warning| format!("warning: {warning}\n")).collect();
    let SolverSummary { iterations, active_fraction, .. } = summary.solver;
    let mut solver = String::new();
    if active_fraction > 0.0 && active_fraction < 1.0 {
        solver += &format!(", up to {} % of the springs constraints", (1e2 * active_fraction).ceil());
    }
    if iterations > 0 {
        solver += &format!(", up to {}", console::counted(iterations as usize, "iteration", "iterations"));
    }
    format!(
        "{warnings}{}, {:.3} ms a frame, largest stretch {:.3}{solver}, state {}\nresults in {}",
        console::counted(summary.frames as usize, "frame", "frames"),
        summary.wall_ms_per_frame,
        summary.max_stretch,
        summary.state_hash.as_deref().unwrap_or("unknown"),
        dir.display()
    )
}
