//! GPUs that are not there: Mesa's driver for AMD compiles for the one that `RADV_FORCE_FAMILY` names.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Folders in which drivers' manifests lie on Linux.
const FOLDERS: [&str; 3] = ["/usr/share/vulkan/icd.d", "/usr/local/share/vulkan/icd.d", "/etc/vulkan/icd.d"];

/// This program's output for each of them, as one array.
///
/// # Errors
/// Says what cannot be run, or what a run said.
pub fn all(names: &[String]) -> Result<String, String> {
    let manifest = manifest(&FOLDERS).ok_or(
        "there is no manifest of Mesa's driver for AMD (radeon_icd): on Debian and Ubuntu, mesa-vulkan-drivers has it",
    )?;
    let outputs = names.iter().map(|name| of(name, &manifest)).collect::<Result<Vec<_>, _>>()?;
    Ok(format!("[{}]", outputs.join(",")))
}

fn of(name: &str, manifest: &Path) -> Result<String, String> {
    let program = std::env::current_exe().map_err(|error| format!("this program is nowhere: {error}"))?;
    // An environment of another process: Vulkan's loader and driver read it where they please.
    let output = Command::new(program)
        .env("RADV_FORCE_FAMILY", name)
        .envs(["VK_DRIVER_FILES", "VK_ICD_FILENAMES"].map(|key| (key, manifest)))
        .output()
        .map_err(|error| format!("{name}: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if output.status.success() {
        Ok(text(&output.stdout))
    } else {
        Err(format!("{name}: {} {}", output.status, text(&output.stderr)))
    }
}

fn manifest(folders: &[&str]) -> Option<PathBuf> {
    let is_it = |path: &PathBuf| {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        name.starts_with("radeon_icd") && name.ends_with(".json")
    };
    let files = |folder: &&str| Some(std::fs::read_dir(folder).ok()?.flatten().map(|entry| entry.path()));
    folders.iter().filter_map(files).flatten().find(is_it)
}
