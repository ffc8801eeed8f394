//! What the package is built and tested with: a compiler that makes wasm, wasm-bindgen, node with its packages, a browser.

use super::{TRIPLE, done, web};
use crate::program::target;
use crate::{apt, root};
use std::fs;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// Debian's compiler with the sources of the standard library, and its linker.
const DEBIAN: [&str; 4] = ["rustc-web", "cargo-web", "rust-web-src", "lld-19"];
const DEBIANS_LINKER: &str = "/usr/bin/wasm-ld-19";
/// Oldest node that has all that the package needs.
const NODE: u32 = 20;

/// A compiler for wasm.
pub enum Compiler {
    /// The one that runs this, with the target that rustup adds.
    Own,
    /// Debian's, which builds the standard library as well.
    Debian,
}

impl Compiler {
    fn find() -> Option<Self> {
        let sysroot = Command::new("rustc").args(["--print", "sysroot"]).output().ok()?;
        let sysroot = PathBuf::from(String::from_utf8_lossy(&sysroot.stdout).trim());
        if sysroot.join("lib/rustlib").join(TRIPLE).is_dir() {
            return Some(Self::Own);
        }
        let sources = Command::new("/usr/bin/rustc").args(["--print", "sysroot"]).output().ok()?;
        let sources = PathBuf::from(String::from_utf8_lossy(&sources.stdout).trim()).join("lib/rustlib/src");
        (sources.is_dir() && Path::new("/usr/bin/cargo").is_file() && Path::new(DEBIANS_LINKER).is_file())
            .then_some(Self::Debian)
    }

    /// Its cargo.
    pub fn cargo(&self) -> Command {
        let Self::Debian = self else { return crate::program::cargo(&[]) };
        let mut command = Command::new("/usr/bin/cargo");
        command.env("RUSTC", "/usr/bin/rustc").env("RUSTC_BOOTSTRAP", "1").arg("-Zbuild-std=std,panic_abort");
        command.env("CARGO_TARGET_WASM32_UNKNOWN_UNKNOWN_LINKER", DEBIANS_LINKER);
        // Those of the cargo that runs this.
        command.env_remove("CARGO").env_remove("RUSTUP_TOOLCHAIN").env_remove("RUSTC_WORKSPACE_WRAPPER");
        command
    }
}

/// The first thing that is missing, in words.
pub fn missing() -> Option<&'static str> {
    if Compiler::find().is_none() {
        return Some("compiler for wasm32-unknown-unknown");
    }
    match (has_node(), browser()) {
        (false, _) => Some("node 20 or newer with npm"),
        (_, None) => Some("Chromium"),
        _ => None,
    }
}

/// Finds a compiler and node, or installs them, or says what would do.
pub fn provide() -> Result<Compiler, String> {
    if missing().is_some() && apt::is_ours() {
        let mut packages: Vec<&str> = Vec::new();
        if Compiler::find().is_none() {
            packages.extend(DEBIAN);
        }
        if !has_node() {
            packages.extend(["nodejs", "npm"]);
        }
        if browser().is_none() {
            packages.push("chromium");
        }
        println!("xtask: installs {}", packages.join(" "));
        apt::install(&packages)?;
    }
    if !has_node() {
        return Err(format!("web: there is no node {NODE} or newer with npm; it would do"));
    }
    Compiler::find().ok_or_else(|| {
        format!(
            "web: there is no compiler for {TRIPLE}: `rustup target add {TRIPLE}` would do, or on Debian `sudo apt-get install {}`",
            DEBIAN.join(" ")
        )
    })
}

fn has_node() -> bool {
    let Ok(output) = Command::new("node").arg("--version").output() else { return false };
    let version = String::from_utf8_lossy(&output.stdout).trim().trim_start_matches('v').to_owned();
    let major = version.split('.').next().and_then(|major| major.parse::<u32>().ok());
    let npm = Command::new("npm").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    major.is_some_and(|major| major >= NODE) && npm.is_ok_and(|status| status.success())
}

/// The browser: the one that `TAFFETA_CHROMIUM` names, or one that is installed.
pub fn browser() -> Option<PathBuf> {
    if let Some(named) = std::env::var_os("TAFFETA_CHROMIUM") {
        return Some(named.into());
    }
    let folders: Vec<PathBuf> = std::env::split_paths(&std::env::var_os("PATH")?).collect();
    let names = ["chromium", "chromium-browser", "google-chrome"];
    let all = names.iter().flat_map(|name| folders.iter().map(move |folder| folder.join(name)));
    all.into_iter().find(|file| file.is_file())
}

/// wasm-bindgen of the version that the crates are built with; it is kept.
pub fn bindgen() -> Result<PathBuf, String> {
    let lock =
        fs::read_to_string(root().join("Cargo.lock")).map_err(|error| format!("Cargo.lock: {error}"))?;
    let version = version_of(&lock, "wasm-bindgen").ok_or("Cargo.lock: it has no wasm-bindgen")?;
    let tools = target().join("web/tools").join(version);
    let program = tools.join("bin").join(format!("wasm-bindgen{}", std::env::consts::EXE_SUFFIX));
    if !program.is_file() {
        let mut install =
            crate::program::cargo(&["install", "wasm-bindgen-cli", "--quiet", "--version", version]);
        install.arg("--root").arg(&tools).arg("--target-dir").arg(target().join("web/tools-build"));
        done(&mut install, "cargo install wasm-bindgen-cli")?;
    }
    Ok(program)
}

/// The version of a package in a lock file.
fn version_of<'a>(lock: &'a str, package: &str) -> Option<&'a str> {
    let (_, after) = lock.split_once(&format!("name = \"{package}\"\n"))?;
    after.lines().next()?.strip_prefix("version = \"")?.strip_suffix('"')
}

/// Installs the packages of node that the lock file says, where they are not there.
pub fn modules() -> Result<(), String> {
    let wanted =
        fs::read_to_string(web().join("package-lock.json")).map_err(|error| format!("web: {error}"))?;
    let kept = web().join("node_modules/.installed");
    if fs::read_to_string(&kept).is_ok_and(|there| there == wanted) {
        return Ok(());
    }
    let mut install = Command::new("npm");
    install.args(["ci", "--silent"]).current_dir(web());
    done(&mut install, "npm ci")?;
    fs::write(&kept, wanted).map_err(|error| format!("{}: {error}", kept.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_version_is_that_of_the_very_package() {
        let lock = "[[package]]\nname = \"wasm-bindgen-shared\"\nversion = \"1.2.3\"\n\n[[package]]\nname = \"wasm-bindgen\"\n\
                    version = \"0.2.130\"\nsource = \"x\"\n";
        assert_eq!(version_of(lock, "wasm-bindgen"), Some("0.2.130"));
        assert_eq!(version_of(lock, "js-sys"), None);
    }
}
