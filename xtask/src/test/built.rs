//! The programs of tests that cargo has built, with the lints of our own code.

use crate::program::cargo;
use serde::Deserialize;
use std::collections::BTreeSet;
use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// rustc with clippy's lints.
const LINTER: &str = "clippy-driver";

/// What a build has left.
pub struct Built {
    pub programs: Vec<Program>,
    /// Libraries and programs without tests, with their package and name.
    others: Vec<(String, String, PathBuf)>,
    /// Whether something from outside of this repository was compiled.
    pub from_nothing: bool,
}

/// A program of tests.
pub struct Program {
    /// The folder of its package: its tests run there.
    folder: PathBuf,
    target: Target,
    path: PathBuf,
}

/// A line of cargo's report, as far as it is read.
#[derive(Deserialize)]
struct Line {
    manifest_path: Option<PathBuf>,
    target: Option<Target>,
    profile: Option<Profile>,
    executable: Option<PathBuf>,
    filenames: Option<Vec<PathBuf>>,
    fresh: Option<bool>,
    message: Option<Message>,
}

/// What the compiler says of our code.
#[derive(Deserialize)]
struct Message {
    level: String,
    rendered: Option<String>,
}

/// What has the tests: a library, a program, or a file of tests alone.
#[derive(Deserialize)]
struct Target {
    kind: Vec<String>,
    name: String,
}

#[derive(Deserialize)]
struct Profile {
    test: bool,
}

/// A cargo command whose compiler also lints our code where clippy is installed.
///
/// `cargo clippy` would check all dependencies again, which takes a third as long as compiling them. All commands of a run
/// need the same compiler: cargo keeps what each has built apart.
pub fn linting(words: &[&str]) -> Command {
    let mut command = cargo(words);
    if has_linter() {
        command.env("RUSTC_WORKSPACE_WRAPPER", LINTER);
    }
    command
}

/// Whether clippy is installed.
pub fn has_linter() -> bool {
    let probe = Command::new(LINTER).arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    probe.is_ok_and(|status| status.success())
}

/// Runs a cargo command that builds tests. A warning of our code is an error.
pub fn build(words: &[&str]) -> Result<Built, String> {
    let mut command = linting(words);
    command.arg("--message-format=json").stdout(Stdio::piped());
    let mut cargo = command.spawn().map_err(|error| format!("cargo: {error}"))?;
    let mut lines = Vec::new();
    let mut warnings = BTreeSet::new();
    for line in cargo.stdout.take().into_iter().flat_map(|report| BufReader::new(report).lines()) {
        let line = line.map_err(|error| format!("cargo: {error}"))?;
        let Ok(mut line) = serde_json::from_str::<Line>(&line) else { continue };
        if let Some(Message { level, rendered: Some(rendered) }) = line.message.take()
            // The same file is compiled several times, as a library and with its tests.
            && (level != "warning" || warnings.insert(rendered.clone()))
        {
            eprint!("{rendered}");
        }
        lines.push(line);
    }
    let status = cargo.wait().map_err(|error| format!("cargo: {error}"))?;
    if !status.success() {
        return Err(format!("the tests were not built ({status})"));
    }
    if !warnings.is_empty() {
        return Err("lints: there are warnings, which are above".to_owned());
    }
    let root = crate::root();
    let root = root.canonicalize().map_err(|error| format!("{}: {error}", root.display()))?;
    Ok(built(lines, &root))
}

fn built(lines: Vec<Line>, root: &Path) -> Built {
    let is_foreign = |line: &Line| line.manifest_path.as_ref().is_some_and(|path| !path.starts_with(root));
    let from_nothing = lines.iter().any(|line| line.fresh == Some(false) && is_foreign(line));
    let others = lines.iter().flat_map(Line::others).collect();
    let mut programs: Vec<Program> = lines.into_iter().filter_map(Program::of).collect();
    programs.sort_by_key(Program::name);
    Built { programs, others, from_nothing }
}

impl Built {
    /// The program with the tests in a package's file.
    pub fn tests(&self, package: &str, file: &str) -> Option<&Program> {
        self.programs.iter().find(|program| program.package() == package && program.target.name == file)
    }

    /// A package's library with this ending.
    pub fn library(&self, package: &str, ending: &str) -> Option<&Path> {
        let is_it = |file: &Path| file.to_string_lossy().ends_with(ending);
        let found = self.others.iter().find(|(of, _, file)| of == package && is_it(file));
        found.map(|(.., file)| file.as_path())
    }

    /// A package's program.
    pub fn program(&self, package: &str, name: &str) -> Option<&Path> {
        let is_it = |file: &Path| file.file_stem() == Some(name.as_ref());
        let found = self.others.iter().find(|(of, one, file)| of == package && one == name && is_it(file));
        found.map(|(.., file)| file.as_path())
    }
}

impl Line {
    /// What it has built that is no test.
    fn others(&self) -> Vec<(String, String, PathBuf)> {
        let (Some(target), Some(manifest)) = (&self.target, &self.manifest_path) else { return Vec::new() };
        let package = package(manifest.parent().unwrap_or(manifest));
        let is_test = self.profile.as_ref().is_some_and(|profile| profile.test);
        let files = self.filenames.iter().flatten().filter(|_| !is_test);
        files.map(|file| (package.clone(), target.name.clone(), file.clone())).collect()
    }
}

/// A package is called as its folder.
fn package(folder: &Path) -> String {
    folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
}

impl Program {
    fn of(line: Line) -> Option<Self> {
        let (target, path) = (line.target?, line.executable?);
        let folder = line.manifest_path?.parent()?.to_owned();
        line.profile?.test.then_some(Self { folder, target, path })
    }

    fn package(&self) -> String {
        package(&self.folder)
    }

    /// Whose tests it has, in words.
    pub fn name(&self) -> String {
        let kind = self.target.kind.first().map_or("", String::as_str);
        format!("{}: {kind} {}", self.package(), self.target.name)
    }

    /// It, to be run as cargo runs it.
    pub fn command(&self) -> Command {
        let mut command = Command::new(&self.path);
        command.current_dir(&self.folder).env("CARGO_MANIFEST_DIR", &self.folder);
        command
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const REPORT: &str = r#"
{"reason":"compiler-artifact","manifest_path":"/home/me/.cargo/naga/Cargo.toml","target":{"kind":["lib"],"name":"naga"},"profile":{"test":false},"executable":null,"fresh":FRESH}
{"reason":"compiler-artifact","manifest_path":"/r/crates/taffeta/Cargo.toml","target":{"kind":["lib"],"name":"taffeta"},"profile":{"test":false},"executable":null,"filenames":["/t/libtaffeta.rlib","/t/libtaffeta.so"],"fresh":false}
{"reason":"compiler-artifact","manifest_path":"/r/crates/taffeta/Cargo.toml","target":{"kind":["test"],"name":"it"},"profile":{"test":true},"executable":"/t/it-1","fresh":false}
{"reason":"compiler-artifact","manifest_path":"/r/crates/taffeta-cli/Cargo.toml","target":{"kind":["bin"],"name":"taffeta"},"profile":{"test":false},"executable":"/t/taffeta","filenames":["/t/taffeta"],"fresh":true}
{"reason":"build-finished","success":true}
"#;

    fn parse(report: &str, root: &Path) -> Built {
        built(report.lines().filter_map(|line| serde_json::from_str(line).ok()).collect(), root)
    }

    #[test]
    fn programs_of_tests_are_found_in_cargos_report() {
        let built = parse(&REPORT.replace("FRESH", "true"), Path::new("/r"));
        let names: Vec<String> = built.programs.iter().map(Program::name).collect();
        assert_eq!((names, built.from_nothing), (vec!["taffeta: test it".to_owned()], false));
        let program = built.tests("taffeta", "it").expect("it");
        assert_eq!((&program.path, &program.folder), (&"/t/it-1".into(), &"/r/crates/taffeta".into()));
        assert!(built.tests("taffeta-cli", "taffeta").is_none());
        assert_eq!(built.program("taffeta-cli", "taffeta"), Some(Path::new("/t/taffeta")));
        assert_eq!(built.library("taffeta", ".so"), Some(Path::new("/t/libtaffeta.so")));
        assert_eq!(built.library("taffeta-cli", ".so"), None);
        assert!(parse(&REPORT.replace("FRESH", "false"), Path::new("/r")).from_nothing);
    }
}
