//! The program that is built here: cargo, where it puts `taffeta`, and which commit that is of.

use crate::root;
use std::path::PathBuf;
use std::process::Command;

/// A cargo command in the repository.
pub fn cargo(words: &[&str]) -> Command {
    // Cargo sets CARGO for what it runs; the name alone serves when the binary is started by hand.
    let mut command = Command::new(std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into()));
    command.args(words).current_dir(root());
    command
}

/// The built `taffeta`, where cargo puts it.
pub fn path() -> PathBuf {
    target().join("release").join(format!("taffeta{}", std::env::consts::EXE_SUFFIX))
}

/// The folder of what is built.
pub fn target() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    root().join(target)
}

/// The commit that is built; `-dirty` where the sources differ from it.
pub fn commit() -> Result<String, String> {
    let git = |words: &[&str]| Command::new("git").args(words).current_dir(root()).output();
    let head = git(&["rev-parse", "--short", "HEAD"]).map_err(|error| format!("git: {error}"))?;
    if !head.status.success() {
        return Err(format!("git: {}", String::from_utf8_lossy(&head.stderr).trim()));
    }
    let same = git(&["diff", "--quiet", "HEAD", "--", "crates", "Cargo.toml", "Cargo.lock"]);
    let dirty = if same.is_ok_and(|same| same.status.success()) { "" } else { "-dirty" };
    Ok(format!("{}{dirty}", String::from_utf8_lossy(&head.stdout).trim()))
}

/// Lower-case letters and numbers, with one hyphen for all else.
pub fn slug(words: &str) -> String {
    let kept = words.split(|c: char| !c.is_ascii_alphanumeric()).filter(|part| !part.is_empty());
    kept.map(str::to_lowercase).collect::<Vec<_>>().join("-")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_slug_is_letters_numbers_and_hyphens() {
        assert_eq!(slug("AMD EPYC (tm), 2 threads"), "amd-epyc-tm-2-threads");
    }
}
