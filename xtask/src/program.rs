//! The program that is built here: cargo, where it puts `taffeta`, and which commit that is of.

use crate::root;
use std::path::PathBuf;
use std::process::{Command, ExitCode};

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

/// A program that the command line names. Commands run it in folders of their own.
pub fn named(file: &str) -> Result<PathBuf, String> {
    std::fs::canonicalize(file).map_err(|error| format!("--program {file}: {error}"))
}

/// Writes a page of the repository, or says why there is none.
pub fn write_page(path: &str, page: Result<String, String>) -> ExitCode {
    let write = |page| std::fs::write(root().join(path), page).map_err(|error| format!("{path}: {error}"));
    match page.and_then(write) {
        Ok(()) => {
            println!("xtask: {path} is written");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// The folder of what is built.
pub fn target() -> PathBuf {
    let target = std::env::var_os("CARGO_TARGET_DIR").map_or_else(|| "target".into(), PathBuf::from);
    root().join(target)
}

/// The hash of the commit that is checked out.
pub fn head() -> Result<String, String> {
    git(&["rev-parse", "HEAD"])
}

/// What git says.
fn git(words: &[&str]) -> Result<String, String> {
    let output = Command::new("git").args(words).current_dir(root()).output();
    let output = output.map_err(|error| format!("git: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if output.status.success() {
        Ok(text(&output.stdout))
    } else {
        Err(format!("git: {}", text(&output.stderr)))
    }
}

/// The commit that is built; `-dirty` where the sources differ from it.
pub fn commit() -> Result<String, String> {
    let head = git(&["rev-parse", "--short", "HEAD"])?;
    let same = git(&["diff", "--quiet", "HEAD", "--", "crates", "Cargo.toml", "Cargo.lock"]);
    Ok(if same.is_ok() { head } else { format!("{head}-dirty") })
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
