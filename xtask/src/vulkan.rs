//! Whether tests can have a Vulkan adapter, and a software one where there is none.

use crate::apt;
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

const PACKAGES: [&str; 2] = ["mesa-vulkan-drivers", "libvulkan1"];
const LOADER: &str = "libvulkan.so.1";
/// Folders in which loaders are looked for after those that the environment names.
const LIBRARIES: [&str; 5] = ["/usr/local/lib", "/usr/lib", "/usr/lib64", "/lib", "/lib64"];

/// What is missing.
#[derive(Debug, PartialEq, Eq)]
enum Missing {
    Loader,
    /// Where the environment names the manifests, no package mends that: the variable with its value.
    Drivers(Option<String>),
}

/// Finds a loader and a driver, or installs them, or says what would do. Only Linux needs it: elsewhere the system
/// brings its own API.
pub fn provide() -> Result<(), String> {
    if !cfg!(target_os = "linux") {
        return Ok(());
    }
    let Some(missing) = missing(&environment) else { return Ok(()) };
    if let Missing::Drivers(Some(variable)) = &missing {
        return Err(format!("{variable} names no driver's manifest; unset it, or name one"));
    }
    let packages = PACKAGES.join(" ");
    if !apt::is_ours() {
        return Err(format!(
            "there is no Vulkan {}; tests need one, and a software driver will do: on Debian and Ubuntu `sudo apt-get \
             install {packages}`, on Fedora `dnf install mesa-vulkan-drivers vulkan-loader`, on Arch `pacman -S \
             vulkan-swrast vulkan-icd-loader`",
            missing.words()
        ));
    }
    println!("xtask: installs {packages}: there is no Vulkan {}", missing.words());
    apt::install(&PACKAGES)?;
    match self::missing(&environment) {
        None => Ok(()),
        Some(still) => {
            Err(format!("{packages} are installed, and still there is no Vulkan {}", still.words()))
        }
    }
}

/// Keeps Mesa from complaining on a machine without a desktop: it wants a folder for sockets.
pub fn quiet(command: &mut Command) -> &mut Command {
    if environment("XDG_RUNTIME_DIR").is_none() {
        command.env("XDG_RUNTIME_DIR", std::env::temp_dir());
    }
    command
}

impl Missing {
    fn words(&self) -> &'static str {
        match self {
            Self::Loader => "loader (libvulkan.so.1)",
            Self::Drivers(_) => "driver",
        }
    }
}

/// A variable that says something.
fn environment(name: &str) -> Option<String> {
    std::env::var(name).ok().filter(|value| !value.is_empty())
}

fn missing(env: &dyn Fn(&str) -> Option<String>) -> Option<Missing> {
    if !has_loader(env) {
        return Some(Missing::Loader);
    }
    match named_manifests(env) {
        Some((_, paths)) if paths.iter().any(|path| is_manifest(path)) => None,
        Some((variable, _)) => Some(Missing::Drivers(Some(variable))),
        None => {
            let found = manifest_folders(env).iter().any(|folder| is_manifest(folder));
            (!found).then_some(Missing::Drivers(None))
        }
    }
}

/// Whether the system's linker knows a loader, or one lies in a usual place.
fn has_loader(env: &dyn Fn(&str) -> Option<String>) -> bool {
    let named = paths(env("LD_LIBRARY_PATH"));
    linker_knows(LOADER)
        || named.into_iter().chain(LIBRARIES.map(PathBuf::from)).any(|folder| folder.join(LOADER).exists())
}

/// Whether a library is in the linker's table.
pub fn linker_knows(library: &str) -> bool {
    ["ldconfig", "/sbin/ldconfig"].iter().any(|program| {
        let output = Command::new(program).arg("-p").stderr(Stdio::null()).output();
        output.is_ok_and(|output| lists(&String::from_utf8_lossy(&output.stdout), library))
    })
}

fn lists(table: &str, library: &str) -> bool {
    table.lines().any(|line| line.split_whitespace().next() == Some(library))
}

/// The manifests that the environment allows alone, with the variable: the loader then looks nowhere else.
fn named_manifests(env: &dyn Fn(&str) -> Option<String>) -> Option<(String, Vec<PathBuf>)> {
    let named = |name: &str| env(name).map(|value| (format!("{name}={value}"), paths(Some(value))));
    named("VK_DRIVER_FILES").or_else(|| named("VK_ICD_FILENAMES"))
}

/// The folders in which the loader looks for manifests, in its order.
fn manifest_folders(env: &dyn Fn(&str) -> Option<String>) -> Vec<PathBuf> {
    let home = |folder: &str| env("HOME").map(|home| format!("{home}/{folder}"));
    let roots = [
        env("XDG_CONFIG_HOME").or_else(|| home(".config")),
        Some(env("XDG_CONFIG_DIRS").unwrap_or_else(|| "/etc/xdg".into())),
        Some("/etc".into()),
        env("XDG_DATA_HOME").or_else(|| home(".local/share")),
        Some(env("XDG_DATA_DIRS").unwrap_or_else(|| "/usr/local/share:/usr/share".into())),
    ];
    let icd = |root: PathBuf| root.join("vulkan/icd.d");
    let more = paths(env("VK_ADD_DRIVER_FILES"));
    more.into_iter().chain(roots.into_iter().flat_map(paths).map(icd)).collect()
}

/// The parts of a list with colons.
fn paths(list: Option<String>) -> Vec<PathBuf> {
    let list = list.unwrap_or_default();
    list.split(':').filter(|part| !part.is_empty()).map(PathBuf::from).collect()
}

/// Whether this is a manifest, or a folder with one in it.
fn is_manifest(path: &Path) -> bool {
    let is_json = |path: &Path| path.is_file() && path.extension().is_some_and(|ext| ext == "json");
    let inside = || {
        let entries = std::fs::read_dir(path).into_iter().flatten();
        entries.filter_map(|entry| entry.ok().map(|entry| entry.path())).any(|path| is_json(&path))
    };
    is_json(path) || inside()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn none(_: &str) -> Option<String> {
        None
    }

    #[test]
    fn the_loader_is_found_in_the_linkers_table() {
        assert!(lists("3 libs found\n\tlibvulkan.so.1 (libc6,x86-64) => /lib/libvulkan.so.1\n", LOADER));
        assert!(!lists("\tlibvulkan_lvp.so (libc6,x86-64) => /lib/libvulkan_lvp.so\n", LOADER));
    }

    #[test]
    fn manifests_that_are_named_are_the_only_ones() {
        let env = |name: &str| (name == "VK_DRIVER_FILES").then(|| "/nonexistent:/none".to_owned());
        let (variable, paths) = named_manifests(&env).expect("named");
        assert_eq!(variable, "VK_DRIVER_FILES=/nonexistent:/none");
        assert_eq!(paths, [PathBuf::from("/nonexistent"), PathBuf::from("/none")]);
        let env = |name: &str| match name {
            "LD_LIBRARY_PATH" => Some(env!("CARGO_MANIFEST_DIR").to_owned()),
            other => env(other),
        };
        if has_loader(&env) {
            assert_eq!(missing(&env), Some(Missing::Drivers(Some(variable))));
        }
        assert_eq!(named_manifests(&none), None);
    }

    #[test]
    fn manifests_are_looked_for_where_the_loader_looks() {
        let env = |name: &str| (name == "HOME").then(|| "/home/me".to_owned());
        let folders: Vec<String> =
            manifest_folders(&env).iter().map(|folder| folder.display().to_string()).collect();
        for root in ["/home/me/.config", "/etc", "/home/me/.local/share", "/usr/share", "/usr/local/share"] {
            assert!(folders.contains(&format!("{root}/vulkan/icd.d")), "{root}: {folders:?}");
        }
    }

    #[test]
    fn a_manifest_is_json_itself_or_in_a_folder() {
        let folder = std::env::temp_dir().join(format!("taffeta-icd-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        assert!(!is_manifest(&folder));
        let file = folder.join("driver.json");
        std::fs::write(&file, "{}").expect("a file");
        assert!(is_manifest(&folder) && is_manifest(&file));
        std::fs::remove_dir_all(&folder).expect("removed");
        assert!(!is_manifest(&file));
    }
}
