//! Reading files whose names users give.

use super::MeshError;
use std::io::{ErrorKind, Read};
use std::path::Path;

/// What a mesh takes in memory while it is built, in lengths of its file.
const TIMES: u64 = 4;

/// Refuses what is no regular file: it may never end, and to open a pipe waits for the other end.
pub(super) fn check_kind(path: &Path) -> Result<(), MeshError> {
    match std::fs::metadata(path) {
        Ok(kind) if kind.is_dir() => Err(MeshError::new("is a folder; a mesh file would do")),
        Ok(kind) if !kind.is_file() => Err(MeshError::new("is not a regular file; a mesh file would do")),
        // What is not there is said when it is read.
        _ => Ok(()),
    }
}

/// The bytes of a regular file. Refuses one that would not fit into memory.
pub(super) fn read(path: &Path) -> Result<Vec<u8>, MeshError> {
    let unreadable = |error| MeshError::new(format!("cannot be read: {error}"));
    let file = crate::files::open(path).map_err(|error| match error.kind() {
        ErrorKind::NotFound if in_models(path) => {
            MeshError::new("is not there; `cargo xtask models` fetches the real models")
        }
        _ => unreadable(error),
    })?;
    let length = file.metadata().map_err(unreadable)?.len();
    let limit = free_memory().map_or(u64::MAX, |free| free / TIMES);
    if length > limit {
        let gib = |bytes: u64| bytes as f64 / (1_u64 << 30) as f64;
        return Err(MeshError::new(format!(
            "is {:.1} GiB long; reading it takes about {TIMES} times as much memory, and {:.1} GiB are free",
            gib(length),
            gib(limit.saturating_mul(TIMES)),
        )));
    }
    let mut bytes = Vec::with_capacity(length as usize);
    file.take(limit).read_to_end(&mut bytes).map_err(unreadable)?;
    Ok(bytes)
}

/// Whether a path leads into the folder of models.
fn in_models(path: &Path) -> bool {
    path.parent().and_then(Path::file_name).is_some_and(|folder| folder == "models")
}

/// Memory that is free [byte]; `None` where the system does not say.
fn free_memory() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    kib.checked_mul(1024)
}
