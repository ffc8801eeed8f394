//! `cargo xtask faults`: has each call that `taffeta run` makes for its results fail, once; makes what power failures may leave of its
//! files; and has it end for want of memory, by a limit that grows until it ends well. From each of them a run must go on to the same
//! results. `strace` does it.

mod disk;
mod log;
mod power;

use crate::{attack, program, root};
use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Output};

/// A sheet whose solver remembers what it has found, so that all of a run goes on.
const SCENE: &str = r#"
title = "faults"
[time]
dt = 0.01
max_step = 0.005
frames = 6
[solver]
method = "ice"
[[body]]
name = "sheet"
node_mass = 0.01
mesh.grid = { rows = 4, cols = 5, size = [0.4, 0.3] }
springs = { structural = { k = 1e4, d = 0.05 }, shear = { k = 50.0, d = 0.05 } }
[[body.pin]]
select = { nodes = [0, 4] }
"#;
const RUN: &str =
    "run scene.toml --out out --checkpoint-every 2 --format npy,pc2,usda,ply,obj,vtu,glb --threads 1 --quiet";
/// What goes on to as many frames as the scene has, whatever the checkpoint says.
const RESUME: &str = "run scene.toml --resume out/checkpoint.taffeta --frames 6 --threads 1 --quiet";
/// Calls that have to do with files, and how each of them fails.
const CALLS: [(&str, &str); 9] = [
    ("openat", "ENOSPC"),
    ("write", "ENOSPC"),
    ("lseek", "EIO"),
    ("ftruncate", "EIO"),
    ("fsync", "EIO"),
    ("rename", "EIO"),
    ("unlink", "EIO"),
    ("mkdir", "ENOSPC"),
    ("flock", "ENOLCK"),
];

/// How many more addresses a run has each time [kB].
const LARGE_STEP: usize = 1024;
const SMALL_STEP: usize = 16;
/// With which it must begin [kB].
const MOST: usize = 4 << 20;

/// How a run with little memory ended.
#[derive(PartialEq)]
enum Ended {
    BeforeItBegan,
    ForWantOfMemory,
    Well,
}

/// Runs it on the built program, or the one that `words` name.
pub fn run(words: &[&str]) -> ExitCode {
    let program = match words {
        [] => attack::build(),
        ["--program", file] => program::named(file),
        _ => Err(format!("faults {}: it takes --program FILE or nothing", words.join(" "))),
    };
    match program.and_then(|program| try_all(&program)) {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

fn try_all(program: &Path) -> Result<(), String> {
    let desk = Desk { program, folder: folder() };
    let found = desk.try_all();
    let _ = fs::remove_dir_all(&desk.folder);
    found
}

/// Where it runs: in memory, if that can be, where syncs take no time.
fn folder() -> PathBuf {
    let own = format!("taffeta-faults-{}", std::process::id());
    let in_memory = Path::new("/dev/shm").join(own);
    if fs::create_dir(&in_memory).is_ok() { in_memory } else { root().join("target/faults") }
}

fn names() -> String {
    CALLS.map(|(name, _)| name).join(",")
}

/// A folder to run in.
struct Desk<'a> {
    program: &'a Path,
    folder: PathBuf,
}

impl Desk<'_> {
    fn clear(&self) -> Result<(), String> {
        let words = |error: std::io::Error| format!("{}: {error}", self.folder.display());
        let _ = fs::remove_dir_all(&self.folder);
        fs::create_dir_all(&self.folder).map_err(words)?;
        fs::write(self.folder.join("scene.toml"), SCENE).map_err(words)?;
        fs::write(self.folder.join("other.toml"), SCENE.replace("\"sheet\"", "\"other\"")).map_err(words)
    }

    /// Runs the program, watched.
    fn trace(&self, how: &[&str], words: &str) -> Result<Output, String> {
        let mut command = Command::new("strace");
        command.args(["-o", "log.txt"]).args(how).arg(self.program).args(words.split(' '));
        let output = command.current_dir(&self.folder).output();
        output.map_err(|error| format!("strace: {error}; on Debian `apt-get install strace` has it"))
    }

    fn log(&self) -> Result<String, String> {
        let bytes = fs::read(self.folder.join("log.txt")).map_err(|error| format!("the log: {error}"))?;
        Ok(String::from_utf8_lossy(&bytes).into_owned())
    }

    fn try_all(&self) -> Result<(), String> {
        self.clear()?;
        self.trace(&["-f", "-y", "-e", &format!("trace={}", names())], RUN)?;
        let whole = results(&self.folder.join("out"))?;
        let calls = calls(&self.log()?);
        let [states, mut wrong] = power::try_all(self, &whole)?;
        println!("xtask: {states} states that power failures leave");
        println!("xtask: {} calls, each of which fails", calls.len());
        for (number, (call, when)) in calls.iter().enumerate() {
            if let Err(what) = self.try_one(call, *when, &whole) {
                println!("xtask: {call} {when} (call {number}) fails: {what}");
                wrong += 1;
            }
        }
        println!("xtask: runs with too little memory");
        let poor = self.try_with_little_memory(&whole)?;
        println!("xtask: {poor} runs ended for want of memory");
        if wrong == 0 { Ok(()) } else { Err(format!("{wrong} faults were not withstood")) }
    }

    fn try_one(&self, call: &str, when: usize, whole: &Results) -> Result<(), String> {
        self.clear()?;
        let error = CALLS.iter().find(|(name, _)| *name == call).map_or("EIO", |(_, error)| error);
        let inject = format!("inject={call}:error={error}:when={when}");
        let ended = self.trace(&["-f", "-y", "-e", &format!("trace={}", names()), "-e", &inject], RUN)?;
        let said = String::from_utf8_lossy(&ended.stderr).into_owned();
        if said.contains("panicked") {
            return Err(format!("it panics: {said}"));
        }
        match ended.status.code() {
            Some(0) if results(&self.folder.join("out"))? == *whole => return Ok(()),
            Some(0) => return Err("it says nothing, and the results are others".into()),
            Some(1 | 2) if said.starts_with("error: ") => {}
            code => return Err(format!("it ends with {code:?}: {said}")),
        }
        self.goes_on_to(whole)
    }

    /// Runs it with more and more memory until that is enough: in large steps up to the least with which it begins, then in small ones.
    /// Returns how many runs ended for want of it.
    fn try_with_little_memory(&self, whole: &Results) -> Result<usize, String> {
        let mut least = LARGE_STEP;
        while self.with_memory(least, whole)? == Ended::BeforeItBegan {
            least += LARGE_STEP;
            if least > MOST {
                return Err(format!("it does not begin with {MOST} kB"));
            }
        }
        let mut count = 0;
        for kilobytes in (least - LARGE_STEP..).step_by(SMALL_STEP) {
            match self.with_memory(kilobytes, whole)? {
                Ended::Well => break,
                Ended::ForWantOfMemory => count += 1,
                Ended::BeforeItBegan => {}
            }
        }
        if count > 0 { Ok(count) } else { Err("no run ended for want of memory".into()) }
    }

    /// Runs it with so many kilobytes of addresses.
    fn with_memory(&self, kilobytes: usize, whole: &Results) -> Result<Ended, String> {
        self.clear()?;
        let limited = format!("ulimit -v {kilobytes}; exec \"$@\"");
        let mut command = Command::new("sh");
        command.args(["-c", &limited, "sh"]).arg(self.program).args(RUN.split(' '));
        let ended = command.current_dir(&self.folder).output().map_err(|error| format!("sh: {error}"))?;
        let said = String::from_utf8_lossy(&ended.stderr);
        let with = |what: String| format!("with {kilobytes} kB: {what}");
        if ended.status.success() {
            let is_whole = results(&self.folder.join("out"))? == *whole;
            return if is_whole { Ok(Ended::Well) } else { Err(with("the results are others".into())) };
        }
        // What the kernel, the loader of libraries and Rust itself do first.
        let before =
            ["shared librar", "alternative stack"].iter().any(|word| said.contains(word)) || said.is_empty();
        if before && !self.folder.join("out").exists() {
            return Ok(Ended::BeforeItBegan);
        }
        let is_told = match ended.status.code() {
            Some(code) => matches!(code, 1 | 2) && said.starts_with("error: "),
            None => said.contains("memory allocation of"),
        };
        if said.contains("panicked") || !is_told {
            return Err(with(format!("it ends with {}: {said}", ended.status)));
        }
        self.goes_on_to(whole).map_err(with)?;
        Ok(Ended::ForWantOfMemory)
    }

    /// Whether a run goes on from what is there to the same results: from the checkpoint, or from the start where there is none.
    fn goes_on_to(&self, whole: &Results) -> Result<(), String> {
        self.run(if self.folder.join("out/checkpoint.taffeta").exists() { RESUME } else { RUN })?;
        self.has(whole)
    }

    /// Runs the program to a good end.
    fn run(&self, words: &str) -> Result<(), String> {
        let output = Command::new(self.program).args(words.split(' ')).current_dir(&self.folder).output();
        let output = output.map_err(|error| format!("{}: {error}", self.program.display()))?;
        let said = String::from_utf8_lossy(&output.stderr);
        if output.status.success() { Ok(()) } else { Err(format!("it does not go on: {said}")) }
    }

    /// Whether the results are those.
    fn has(&self, whole: &Results) -> Result<(), String> {
        let found = results(&self.folder.join("out"))?;
        let names = |all: &Results| all.keys().cloned().collect::<Vec<_>>().join(" ");
        if names(&found) != names(whole) {
            return Err(format!("there are {}", names(&found)));
        }
        let odd: Vec<&String> =
            found.iter().filter(|(name, bytes)| whole[*name] != **bytes).map(|(name, _)| name).collect();
        if odd.is_empty() { Ok(()) } else { Err(format!("{odd:?} are others")) }
    }
}

type Results = BTreeMap<String, Vec<u8>>;

/// All files of a folder of results, without what tells the time, the checkpoint and the lock.
fn results(folder: &Path) -> Result<Results, String> {
    let words = |error: std::io::Error| format!("{}: {error}", folder.display());
    let mut all = Results::new();
    for entry in fs::read_dir(folder).map_err(words)? {
        let path = entry.map_err(words)?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        if path.is_dir() {
            all.extend(results(&path)?.into_iter().map(|(inner, bytes)| (format!("{name}/{inner}"), bytes)));
            continue;
        }
        let bytes = fs::read(&path).map_err(words)?;
        let text = String::from_utf8_lossy(&bytes);
        let kept = match name.as_str() {
            // What is left of the lock blocks nobody.
            "checkpoint.taffeta" | "lock.part" => continue,
            "frames.csv" => text
                .lines()
                .filter_map(|line| Some(line.rsplit_once(',')?.0.to_owned() + "\n"))
                .collect::<String>()
                .into_bytes(),
            "summary.json" => {
                let is_time = |line: &&str| line.contains("wall_ms") || line.contains("substeps_per_s");
                text.lines().filter(|line| !is_time(line)).collect::<String>().into_bytes()
            }
            _ => bytes,
        };
        all.insert(name, kept);
    }
    Ok(all)
}

/// The calls of a log that are about the folder of results, each with its number among those of its name.
fn calls(log: &str) -> Vec<(String, usize)> {
    let first = log.split_whitespace().next().unwrap_or_default();
    let (mut counts, mut found) = (HashMap::new(), Vec::new());
    // Each thread counts its own.
    for line in log.lines().filter_map(|line| line.strip_prefix(first)) {
        let Some((name, rest)) = line.trim_start().split_once('(') else { continue };
        let count = counts.entry(name.to_owned()).or_insert(0);
        *count += 1;
        if (rest.contains("/out/") || rest.contains("\"out")) && CALLS.iter().any(|(call, _)| *call == name) {
            found.push((name.to_owned(), *count));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;

    const LOG: &str = "7 openat(AT_FDCWD</d>, \"lib.so\", O_RDONLY) = 3</lib.so>\n\
         7 openat(AT_FDCWD</d>, \"out/a.part\", O_RDWR) = 4</d/out/a.part>\n\
         7 write(4</d/out/a.part>, \"abc\", 3) = 3\n7 fsync(4</d/out/a.part>) = 0\n\
         7 write(4</d/out/a.part>, \"de\", 2) = 2\n8 write(9</d/out/b>, \"x\", 1) = 1\n";

    #[test]
    fn calls_are_counted_by_name_and_those_for_results_are_taken() {
        let named = |name: &str, when| (name.to_owned(), when);
        let expected = [named("openat", 2), named("write", 1), named("fsync", 1), named("write", 2)];
        assert_eq!(calls(LOG), expected);
    }
}
