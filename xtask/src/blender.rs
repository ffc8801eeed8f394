//! The Blender extension: the zip that users install, and its tests in Blender's own Python module.

use crate::program::target;
use crate::python::{Environment, build_wheel, done, ended, packed};
use crate::test::{Built, build_with};
use crate::{apt, root, vulkan};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode};

/// The Python that Blender's module is made for.
const PYTHON: &str = "3.11";

/// What Blender's module is linked with beside the C library, and the packages that have it.
const LIBRARIES: [(&str, &str); 9] = [
    ("libGL.so.1", "libgl1"),
    ("libICE.so.6", "libice6"),
    ("libSM.so.6", "libsm6"),
    ("libX11.so.6", "libx11-6"),
    ("libXext.so.6", "libxext6"),
    ("libXfixes.so.3", "libxfixes3"),
    ("libXi.so.6", "libxi6"),
    ("libXrender.so.1", "libxrender1"),
    ("libxkbcommon.so.0", "libxkbcommon0"),
];

/// `cargo xtask blender`: builds the zip of this machine; with `--test` builds it less optimised, and tests it.
pub fn run(words: &[&str]) -> ExitCode {
    ended(match words {
        [] => build_wheel()
            .and_then(|wheel| pack(&wheel))
            .map(|zip| println!("xtask: the extension is {}", zip.display())),
        ["--test"] => build_with(&["build", "--profile", "quick", "-p", "taffeta-py", "-p", "taffeta-cli"])
            .and_then(|built| test(&built, &packed(&built)?)),
        _ => Err(format!("blender {}: it takes [--test]", words.join(" "))),
    })
}

/// Tests the extension as users install it. Without the Python that Blender's module needs it says so, and tests nothing.
pub fn test(built: &Built, wheel: &Path) -> Result<(), String> {
    let program = built.program("taffeta-cli", "taffeta");
    let Some(program) = program else {
        return Err("blender: the program `taffeta` was not built".to_owned());
    };
    let Some(python) = python() else {
        println!(
            "xtask: blender: skipped, its module needs Python {PYTHON}, and there is none (PYTHON names one)"
        );
        return Ok(());
    };
    if cfg!(target_os = "linux") {
        let missing: Vec<_> =
            LIBRARIES.into_iter().filter(|(library, _)| !vulkan::linker_knows(library)).collect();
        apt::provide(&missing, "Blender's module needs it")?;
    }
    let list = root().join("blender/tests/requirements.txt");
    let tools = Environment::kept("blender", python.as_os_str(), &list)?;
    let mut tests = tools.python(&["-m", "pytest", "-q", "-p", "no:cacheprovider", "--durations=3"]);
    tests.arg(root().join("blender/tests")).env("TAFFETA_ZIP", pack(wheel)?).env("TAFFETA_PROGRAM", program);
    done(&mut tests, "blender: pytest")
}

/// The first Python of that version.
fn python() -> Option<PathBuf> {
    let named = std::env::var_os("PYTHON").map(PathBuf::from);
    let all = named.into_iter().chain(["python3".into(), format!("python{PYTHON}").into()]);
    let ask = "import sys; print('%d.%d' % sys.version_info[:2])";
    all.into_iter().find(|python| {
        let output = Command::new(python).args(["-c", ask]).output();
        output.is_ok_and(|output| output.stdout.trim_ascii() == PYTHON.as_bytes())
    })
}

/// Packs the extension with a wheel inside.
fn pack(wheel: &Path) -> Result<PathBuf, String> {
    let out = target().join("blender");
    fs::create_dir_all(&out).map_err(|error| format!("{}: {error}", out.display()))?;
    let python = std::env::var_os("PYTHON").unwrap_or_else(|| "python3".into());
    let mut packing = Command::new(python);
    packing.arg(root().join("blender/pack.py")).args([wheel, &out]);
    let output = packing.output().map_err(|error| format!("blender/pack.py: {error}"))?;
    if !output.status.success() {
        return Err(format!("blender/pack.py: {}", String::from_utf8_lossy(&output.stderr).trim()));
    }
    Ok(String::from_utf8_lossy(&output.stdout).trim().into())
}
