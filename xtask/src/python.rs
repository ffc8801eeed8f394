//! The Python package: its tests, and the wheel that users get.

use crate::program::target;
use crate::root;
use crate::test::{Built, build_with};
use crate::vulkan;
use std::ffi::OsStr;
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// The package's folder, and the native part of it in a wheel.
const PACKAGE: &str = "crates/taffeta-py";
const MODULE: &str = "taffeta/_native.abi3.so";

/// What a user does first.
const FIRST: &str = "import taffeta
simulation = taffeta.Simulation('scenes/hanging.toml')
print(simulation.step(3)['frame'], simulation.positions().shape)";

/// Tests the package as users get it.
///
/// Its wheel is packed from the library that was built with everything else: `maturin` would build that package alone, with other
/// features of the engine, and so the engine once more.
pub fn test(built: &Built, wheel: &Path) -> Result<(), String> {
    let program = built.program("taffeta-cli", "taffeta");
    let Some(program) = program else { return Err("python: the program `taffeta` was not built".to_owned()) };
    install_as_a_user(wheel)?;
    let tools = Environment::with_tools()?;
    tools.pip(&["--force-reinstall", "--no-deps", &wheel.to_string_lossy()])?;
    let mut tests = tools.python(&["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations=3"]);
    tests.arg(root().join(PACKAGE).join("tests")).env("TAFFETA_PROGRAM", program);
    done(&mut tests, "pytest")
}

/// The wheel of what was built.
pub fn packed(built: &Built) -> Result<PathBuf, String> {
    let module = built.library("taffeta-py", ".so").or_else(|| built.library("taffeta-py", ".dylib"));
    let Some(module) = module else { return Err("python: the package's library was not built".to_owned()) };
    pack(&Environment::with_tools()?, module)
}

/// `cargo xtask python`: builds the package and the program alone, and tests the package.
pub fn run() -> ExitCode {
    ended(
        build_with(&["build", "--profile", "quick", "-p", "taffeta-py", "-p", "taffeta-cli"])
            .and_then(|built| test(&built, &packed(&built)?)),
    )
}

/// Says what went wrong.
pub fn ended(result: Result<(), String>) -> ExitCode {
    match result {
        Ok(()) => ExitCode::SUCCESS,
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// `cargo xtask wheel`: builds the wheel of this machine into `target/wheels`.
pub fn wheel() -> ExitCode {
    ended(build_wheel().map(|wheel| println!("xtask: the wheel is {}", wheel.display())))
}

/// The wheel, fully optimised.
pub fn build_wheel() -> Result<PathBuf, String> {
    let out = target().join("wheels");
    let _ = fs::remove_dir_all(&out);
    let tools = Environment::with_tools()?;
    let mut maturin = tools.tool("maturin");
    maturin.args(["build", "--release", "--locked", "--out"]).arg(&out).current_dir(root().join(PACKAGE));
    done(&mut maturin, "maturin")?;
    only_file(&out)
}

/// A virtual environment.
pub struct Environment(PathBuf);

impl Environment {
    /// A new one, in place of what was there.
    fn new(name: &str) -> Result<Self, String> {
        Self::of(name, &std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into()))
    }

    /// The same of some Python.
    fn of(name: &str, python: &OsStr) -> Result<Self, String> {
        let folder = target().join("python").join(name);
        let mut make = Command::new(python);
        make.args(["-m", "venv", "--clear"]).arg(&folder);
        done(
            &mut make,
            &format!(
                "{} -m venv (Python 3.10 or newer is needed; PYTHON names one)",
                Path::new(python).display()
            ),
        )?;
        Ok(Self(folder))
    }

    /// The one with all that the package's tests need.
    fn with_tools() -> Result<Self, String> {
        let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
        Self::kept("tools", &python, &root().join(PACKAGE).join("tests/requirements.txt"))
    }

    /// The one with the packages of a list, which is kept as long as that is the same.
    pub fn kept(name: &str, python: &OsStr, list: &Path) -> Result<Self, String> {
        let wanted = fs::read_to_string(list).map_err(|error| format!("{}: {error}", list.display()))?;
        let there = Self(target().join("python").join(name));
        let kept = there.0.join("requirements.txt");
        if fs::read_to_string(&kept).is_ok_and(|there| there == wanted) {
            return Ok(there);
        }
        let made = Self::of(name, python)?;
        made.pip(&["-r", &list.to_string_lossy()])?;
        fs::write(&kept, wanted).map_err(|error| format!("{}: {error}", kept.display()))?;
        Ok(made)
    }

    /// A program of it.
    fn tool(&self, name: &str) -> Command {
        let folder = if cfg!(windows) { "Scripts" } else { "bin" };
        let mut command = Command::new(self.0.join(folder).join(name));
        // Nothing of another environment, or of the sources.
        command
            .env_remove("PYTHONPATH")
            .env_remove("VIRTUAL_ENV")
            .env("PYTHONDONTWRITEBYTECODE", "1")
            .current_dir(root());
        command
    }

    pub fn python(&self, words: &[&str]) -> Command {
        let mut command = self.tool("python");
        command.args(words);
        command
    }

    fn pip(&self, words: &[&str]) -> Result<(), String> {
        let all = [&["-m", "pip", "install", "--quiet", "--disable-pip-version-check"][..], words].concat();
        done(&mut self.python(&all), "pip install")
    }
}

/// Packs the wheel, with the description that maturin writes.
fn pack(tools: &Environment, module: &Path) -> Result<PathBuf, String> {
    let package = root().join(PACKAGE);
    let (staged, out) = (target().join("python/staged"), target().join("python/wheel"));
    for folder in [&staged, &out] {
        let _ = fs::remove_dir_all(folder);
        fs::create_dir_all(folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    }
    let mut describe = tools.tool("maturin");
    describe.args(["pep517", "write-dist-info", "--metadata-directory"]).arg(&staged).current_dir(&package);
    done(describe.stdout(Stdio::null()).stderr(Stdio::null()), "maturin pep517 write-dist-info")?;
    copy(&package.join("python"), &staged)?;
    let to = staged.join(MODULE);
    fs::copy(module, &to).map_err(|error| format!("{}: {error}", to.display()))?;
    let mut packed = tools.python(&["-m", "wheel", "pack"]);
    packed.arg(&staged).arg("--dest-dir").arg(&out).stdout(Stdio::null());
    done(&mut packed, "wheel pack")?;
    only_file(&out)
}

/// The file in a folder that has one.
fn only_file(folder: &Path) -> Result<PathBuf, String> {
    let mut files = fs::read_dir(folder).map_err(|error| format!("{}: {error}", folder.display()))?.flatten();
    files.next().map(|file| file.path()).ok_or_else(|| format!("{}: there is no wheel", folder.display()))
}

/// Installs the wheel where nothing else is, and runs a scene in three lines.
fn install_as_a_user(wheel: &Path) -> Result<(), String> {
    let clean = Environment::new("clean")?;
    clean.pip(&[&wheel.to_string_lossy()])?;
    done(&mut clean.python(&["-c", FIRST]), "three lines of Python")
}

/// Copies the files of a folder, and of those in it, but for what Python and builds leave there.
fn copy(from: &Path, to: &Path) -> Result<(), String> {
    let unread = |error: std::io::Error| format!("{}: {error}", from.display());
    fs::create_dir_all(to).map_err(|error| format!("{}: {error}", to.display()))?;
    for entry in fs::read_dir(from).map_err(unread)? {
        let path = entry.map_err(unread)?.path();
        let Some(name) = path.file_name() else { continue };
        let is_left = name == "__pycache__" || path.extension().is_some_and(|is| is == "so");
        match path.is_dir() {
            _ if is_left => {}
            true => copy(&path, &to.join(name))?,
            false => drop(fs::copy(&path, to.join(name)).map_err(unread)?),
        }
    }
    Ok(())
}

pub fn done(command: &mut Command, name: &str) -> Result<(), String> {
    let status = vulkan::quiet(command).status().map_err(|error| format!("{name}: cannot start: {error}"))?;
    if status.success() { Ok(()) } else { Err(format!("{name}: failed ({status})")) }
}
