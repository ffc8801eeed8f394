//! `cargo xtask attack`: runs `taffeta` on scenes that are made up at random, and looks for panics, hangs and numbers that are none.

mod scene;

pub use scene::Chance;

use crate::{program, root};
use std::fs;
use std::io::Read;
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitCode, Stdio};
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Scenes, if no number is given.
const SCENES: u64 = 10_000;
/// After that a run is asked to end, and it must soon: the machine may be busy.
const PATIENCE: Duration = Duration::from_secs(20);
const AT_ONCE: Duration = Duration::from_secs(3);

/// What to do.
#[derive(Debug, PartialEq)]
struct Plan {
    seeds: Range<u64>,
    /// The program, where it is not to be built.
    program: Option<PathBuf>,
}

/// Runs the scenes of the seeds that `words` name.
pub fn run(words: &[&str]) -> ExitCode {
    match parse(words).and_then(|plan| attack(&plan)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn parse(words: &[&str]) -> Result<Plan, String> {
    let (mut first, mut count, mut program) = (0, SCENES, None);
    let (pairs, rest) = words.as_chunks();
    let number = |word: &str| word.parse().map_err(|_| format!("attack: `{word}`; a whole number would do"));
    for [name, value] in pairs {
        match *name {
            "--first" => first = number(value)?,
            "--scenes" => count = number(value)?,
            "--program" => program = Some(program::named(value)?),
            _ => return Err(format!("attack {name}: it takes --first SEED, --scenes N and --program FILE")),
        }
    }
    match rest {
        [] => Ok(Plan { seeds: first..first.saturating_add(count), program }),
        _ => Err("attack: a value is missing at the end".into()),
    }
}

/// Builds the program as users have it. Returns where it is.
pub fn build() -> Result<PathBuf, String> {
    let status = program::cargo(&["build", "--release", "-p", "taffeta-cli"]).status();
    if status.is_ok_and(|status| status.success()) {
        Ok(program::path())
    } else {
        Err("the program cannot be built".into())
    }
}

fn attack(plan: &Plan) -> Result<(), String> {
    let program = plan.program.clone().map_or_else(build, Ok)?;
    let folder = root().join("target/attack");
    fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    let (next, counts, failures) =
        (AtomicU64::new(plan.seeds.start), Mutex::new([0_u64; 4]), Mutex::new(Vec::new()));
    std::thread::scope(|scope| {
        for worker in 0..std::thread::available_parallelism().map_or(1, usize::from) {
            let (program, folder, next, counts, failures) = (&program, &folder, &next, &counts, &failures);
            scope.spawn(move || {
                let desk = folder.join(format!("desk{worker}"));
                loop {
                    let seed = next.fetch_add(1, Ordering::Relaxed);
                    if seed >= plan.seeds.end {
                        return;
                    }
                    match try_seed(program, &desk, seed) {
                        Ok(code) => counts.lock().expect("no panic")[code] += 1,
                        Err(what) => {
                            let kept = folder.join(format!("{seed}.toml"));
                            let _ = fs::write(&kept, scene::scene(seed));
                            println!("xtask: {}: {what}", kept.display());
                            failures.lock().expect("no panic").push(seed);
                        }
                    }
                    if (seed + 1 - plan.seeds.start).is_multiple_of(500) {
                        println!("xtask: {} scenes", seed + 1 - plan.seeds.start);
                    }
                }
            });
        }
    });
    let ([done, diverged, refused, slow], failures) =
        (*counts.lock().expect("no panic"), failures.lock().expect("no panic"));
    println!(
        "xtask: {done} scenes ran, {diverged} diverged, {refused} were refused, {slow} took longer than {} s and ended when asked, {} failed",
        PATIENCE.as_secs(),
        failures.len()
    );
    if failures.is_empty() { Ok(()) } else { Err(format!("scenes failed: {failures:?}")) }
}

/// Runs the scene of a seed in a folder. Returns how it ended, or what is wrong with that.
fn try_seed(program: &Path, desk: &Path, seed: u64) -> Result<usize, String> {
    let words = |error: std::io::Error| format!("{}: {error}", desk.display());
    let _ = fs::remove_dir_all(desk);
    fs::create_dir_all(desk).map_err(words)?;
    fs::write(desk.join("scene.toml"), scene::scene(seed)).map_err(words)?;
    let threads = (1 + seed % 3).to_string();
    let mut command = Command::new(program);
    command.args(["run", "scene.toml", "--out", "out", "--quiet", "--backend", "cpu", "--threads", &threads]);
    if seed.is_multiple_of(5) {
        command.args(["--on-divergence", "freeze"]);
    }
    let errors = fs::File::create(desk.join("errors.txt")).map_err(words)?;
    let child = command.current_dir(desk).stdout(Stdio::null()).stderr(errors).spawn();
    let code = wait(&mut child.map_err(words)?)?;
    let said = fs::read_to_string(desk.join("errors.txt")).map_err(words)?;
    if said.contains("panicked") {
        return Err(format!("it panics: {said}"));
    }
    match code {
        Some(code @ (0 | 1)) => check_results(&desk.join("out"), seed).map(|()| code as usize),
        Some(130) => check_results(&desk.join("out"), seed).map(|()| {
            println!("xtask: scene {seed} takes longer than {} s", PATIENCE.as_secs());
            3
        }),
        Some(2) if said.starts_with("error: ") => Ok(2),
        code => Err(format!("it ends with {code:?}: {said}")),
    }
}

/// Waits for the program's end; its exit code, none where a signal ended it. A run that takes long is asked to end, and does so at once.
fn wait(child: &mut Child) -> Result<Option<i32>, String> {
    if let Some(code) = ended(child, PATIENCE)? {
        return Ok(code);
    }
    // As Ctrl-C does.
    let asked = Command::new("kill").args(["-INT", &child.id().to_string()]).status();
    if asked.is_ok_and(|status| status.success())
        && let Some(code) = ended(child, AT_ONCE)?
    {
        return Ok(code);
    }
    let _ = child.kill();
    let _ = child.wait();
    Err(format!("it does not end {} s after it was asked to", AT_ONCE.as_secs()))
}

/// How the program ended, if it does within that time.
fn ended(child: &mut Child, within: Duration) -> Result<Option<Option<i32>>, String> {
    let start = Instant::now();
    while start.elapsed() < within {
        if let Some(status) = child.try_wait().map_err(|error| error.to_string())? {
            return Ok(Some(status.code()));
        }
        std::thread::sleep(Duration::from_millis(5));
    }
    Ok(None)
}

/// Sees that every number of the results is one.
fn check_results(out: &Path, seed: u64) -> Result<(), String> {
    let words = |error: std::io::Error| format!("{}, seed {seed}: {error}", out.display());
    let summary = fs::read_to_string(out.join("summary.json")).map_err(words)?;
    let summary: serde_json::Value = serde_json::from_str(&summary).map_err(|error| error.to_string())?;
    if !summary["energy"]["end"].is_number() {
        return Err(format!("its energy at the end is {}", summary["energy"]["end"]));
    }
    let mut bytes = Vec::new();
    let mut positions = fs::File::open(out.join("positions.npy")).map_err(words)?;
    positions.read_to_end(&mut bytes).map_err(words)?;
    // Magic, version and length of the header come before it.
    let head =
        bytes.get(8..10).map_or(0, |length| 10 + usize::from(u16::from_le_bytes([length[0], length[1]])));
    let (numbers, _) = bytes.get(head..).unwrap_or_default().as_chunks();
    let is_number = |bytes: &[u8; 4]| f32::from_le_bytes(*bytes).is_finite();
    if numbers.is_empty() || !numbers.iter().all(is_number) {
        return Err("a position is no number".into());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn words_name_the_seeds_and_the_program() {
        assert_eq!(parse(&[]).unwrap(), Plan { seeds: 0..10_000, program: None });
        let plan = parse(&["--scenes", "5", "--first", "7", "--program", "Cargo.toml"]).unwrap();
        assert_eq!(plan, Plan { seeds: 7..12, program: Some(program::named("Cargo.toml").unwrap()) });
        assert!(parse(&["--scenes"]).unwrap_err().contains("a value is missing"));
        assert!(parse(&["--scenes", "x"]).unwrap_err().contains("`x`"));
        assert!(parse(&["--all", "1"]).unwrap_err().contains("it takes"));
    }
}
