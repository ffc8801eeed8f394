//! The programs of tests that cargo has built.

use crate::program::cargo;
use serde::Deserialize;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// What a build has left.
pub struct Built {
    pub programs: Vec<Program>,
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
    fresh: Option<bool>,
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

/// Runs a cargo command that builds tests.
pub fn build(words: &[&str]) -> Result<Built, String> {
    let mut command = cargo(words);
    command.arg("--message-format=json-render-diagnostics").stderr(Stdio::inherit());
    let output = command.output().map_err(|error| format!("cargo: {error}"))?;
    if !output.status.success() {
        return Err(format!("the tests were not built ({})", output.status));
    }
    let root = crate::root();
    let root = root.canonicalize().map_err(|error| format!("{}: {error}", root.display()))?;
    Ok(parse(&String::from_utf8_lossy(&output.stdout), &root))
}

fn parse(report: &str, root: &Path) -> Built {
    let lines: Vec<Line> = report.lines().filter_map(|line| serde_json::from_str(line).ok()).collect();
    let is_foreign = |line: &Line| line.manifest_path.as_ref().is_some_and(|path| !path.starts_with(root));
    let from_nothing = lines.iter().any(|line| line.fresh == Some(false) && is_foreign(line));
    let mut programs: Vec<Program> = lines.into_iter().filter_map(Program::of).collect();
    programs.sort_by_key(Program::name);
    Built { programs, from_nothing }
}

impl Built {
    /// The program with the tests in a package's file.
    pub fn tests(&self, package: &str, file: &str) -> Option<&Program> {
        self.programs.iter().find(|program| program.package() == package && program.target.name == file)
    }
}

impl Program {
    fn of(line: Line) -> Option<Self> {
        let (target, path) = (line.target?, line.executable?);
        let folder = line.manifest_path?.parent()?.to_owned();
        line.profile?.test.then_some(Self { folder, target, path })
    }

    /// A package is called as its folder.
    fn package(&self) -> String {
        self.folder.file_name().unwrap_or_default().to_string_lossy().into_owned()
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
{"reason":"compiler-artifact","manifest_path":"/r/crates/taffeta/Cargo.toml","target":{"kind":["lib"],"name":"taffeta"},"profile":{"test":false},"executable":null,"fresh":false}
{"reason":"compiler-artifact","manifest_path":"/r/crates/taffeta/Cargo.toml","target":{"kind":["test"],"name":"it"},"profile":{"test":true},"executable":"/t/it-1","fresh":false}
{"reason":"compiler-artifact","manifest_path":"/r/crates/taffeta-cli/Cargo.toml","target":{"kind":["bin"],"name":"taffeta"},"profile":{"test":false},"executable":"/t/taffeta","fresh":true}
{"reason":"build-finished","success":true}
"#;

    #[test]
    fn programs_of_tests_are_found_in_cargos_report() {
        let built = parse(&REPORT.replace("FRESH", "true"), Path::new("/r"));
        let names: Vec<String> = built.programs.iter().map(Program::name).collect();
        assert_eq!((names, built.from_nothing), (vec!["taffeta: test it".to_owned()], false));
        let program = built.tests("taffeta", "it").expect("it");
        assert_eq!((&program.path, &program.folder), (&"/t/it-1".into(), &"/r/crates/taffeta".into()));
        assert!(built.tests("taffeta-cli", "taffeta").is_none());
        assert!(parse(&REPORT.replace("FRESH", "false"), Path::new("/r")).from_nothing);
    }
}
