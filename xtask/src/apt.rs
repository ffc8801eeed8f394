//! Packages of Debian and Ubuntu, where they may be installed.

use std::process::{Command, Stdio};

/// Whether packages can be installed: there is apt-get, and the right to use it.
pub fn is_ours() -> bool {
    has_apt() && is_root()
}

/// Installs what is missing, each with its package, or says what would do and `why`.
pub fn provide(missing: &[(&str, &str)], why: &str) -> Result<(), String> {
    let packages: Vec<&str> = missing.iter().map(|(_, package)| *package).collect();
    if packages.is_empty() {
        return Ok(());
    }
    let (names, list): (Vec<&str>, _) = (missing.iter().map(|(name, _)| *name).collect(), packages.join(" "));
    if !is_ours() {
        let names = names.join(", ");
        return Err(format!(
            "there is no {names}; {why}: on Debian and Ubuntu `sudo apt-get install {list}`"
        ));
    }
    println!("xtask: installs {list}");
    install(&packages)
}

/// Installs packages, from the lists that are there; where those are missing or old, from new ones.
pub fn install(packages: &[&str]) -> Result<(), String> {
    let words = [&["install", "-y", "-qq", "--no-install-recommends"][..], packages].concat();
    apt(&words).or_else(|_| apt(&["update", "-qq"]).and_then(|()| apt(&words)))
}

fn has_apt() -> bool {
    let probe = Command::new("apt-get").arg("--version").stdout(Stdio::null()).stderr(Stdio::null()).status();
    probe.is_ok_and(|status| status.success())
}

fn is_root() -> bool {
    let id = Command::new("id").arg("-u").output();
    id.is_ok_and(|output| output.stdout.trim_ascii() == b"0")
}

fn apt(words: &[&str]) -> Result<(), String> {
    let mut command = Command::new("apt-get");
    command.args(words).env("DEBIAN_FRONTEND", "noninteractive").stdin(Stdio::null());
    let failed = |why: String| format!("`apt-get {}`: {why}", words.join(" "));
    let output = command.output().map_err(|error| failed(error.to_string()))?;
    if output.status.success() {
        return Ok(());
    }
    Err(failed(String::from_utf8_lossy(&output.stderr).trim().to_owned()))
}
