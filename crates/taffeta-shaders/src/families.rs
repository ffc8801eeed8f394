//! GPUs that are not there: Mesa's driver for AMD compiles for the one that `RADV_FORCE_FAMILY` names.

use crate::{Failure, NO_DRIVER};
use std::ffi::OsString;
use std::process::Command;

/// Folders in which drivers' manifests lie on Linux.
const FOLDERS: [&str; 3] = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];

/// This program's output for each of them, as one array. A family that has names of several versions is given with them, by `|`.
pub fn all(families: &[String]) -> Result<String, Failure> {
    let manifests = manifests(&FOLDERS);
    if manifests.is_empty() {
        let message = "there is no manifest of Mesa's driver for AMD (radeon_icd): on Debian and Ubuntu, mesa-vulkan-drivers has it";
        return Err(Failure::NoDriver(message.to_owned()));
    }
    let manifests = manifests.join(&OsString::from(":"));
    let outputs = families.iter().map(|names| {
        let tried = names.split('|').map(|name| of(name, &manifests));
        tried.reduce(|found, next| if found.is_ok() { found } else { next }).expect("a text has a part")
    });
    Ok(format!("[{}]", outputs.collect::<Result<Vec<_>, _>>()?.join(",")))
}

fn of(name: &str, manifests: &OsString) -> Result<String, Failure> {
    let words = |error: std::io::Error| Failure::Other(format!("{name}: {error}"));
    // An environment of another process: Vulkan's loader and driver read it where they please.
    let output = Command::new(std::env::current_exe().map_err(words)?)
        .env("RADV_FORCE_FAMILY", name)
        .envs(["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].map(|key| (key, manifests)))
        .output()
        .map_err(words)?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    let message = || format!("{name}: {} {}", output.status, text(&output.stderr));
    match output.status.code() {
        Some(0) => Ok(text(&output.stdout)),
        Some(code) if code == i32::from(NO_DRIVER) => Err(Failure::NoDriver(message())),
        _ => Err(Failure::Other(message())),
    }
}

/// All of the driver: a loader takes those that it can use.
fn manifests(folders: &[&str]) -> Vec<OsString> {
    let is_it = |name: &str| name.starts_with("radeon_icd") && name.ends_with(".json");
    let files = folders.iter().filter_map(|folder| std::fs::read_dir(folder).ok()).flatten().flatten();
    let named = files.filter(|file| is_it(&file.file_name().to_string_lossy()));
    let mut found: Vec<OsString> = named.map(|file| file.path().into_os_string()).collect();
    found.sort();
    found
}
