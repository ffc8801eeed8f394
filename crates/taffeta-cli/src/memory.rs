//! Whether a scene fits into memory, before anything is built, and its results onto the disk.

use crate::console;
use std::path::Path;
use taffeta::Simulation;
use taffeta::scene::Scene;
use taffeta_io::program::{Failure, free_memory, short_of_memory};

pub use taffeta_io::program::size;

/// Refuses a scene that needs more memory than is free, with the numbers. What is impossible as a scene passes: the
/// engine says better what is wrong with it, and where.
pub fn check(scene: &Scene) -> Result<(), Failure> {
    check_run(scene, false)
}

/// As [`check`], for a run whose results hold faces or normals, or do not.
pub fn check_run(scene: &Scene, faces: bool) -> Result<(), Failure> {
    match short_of_memory(scene, faces) {
        Some((why, advice)) => Err(Failure::Input(console::advised(why, &advice))),
        None => Ok(()),
    }
}

/// Watches how much memory a run takes, as lists of contacts grow.
pub struct Watch {
    /// What was foreseen [byte].
    pub foreseen: u64,
    /// Beyond that a warning is due [byte].
    pub expected: u64,
    /// After the frame before [byte].
    pub before: u64,
    /// How much is free [byte].
    pub free: fn() -> u64,
}

/// What a watch has seen.
#[derive(Debug, PartialEq, Eq)]
pub enum Growth {
    /// More than was foreseen.
    Beyond(String),
    /// Another frame like the last one may not fit.
    TooMuch(String),
}

impl Watch {
    /// Of a scene that is about to run.
    pub fn new(scene: &Scene, simulation: &Simulation) -> Self {
        let (needed, now) = (scene.memory_needed(), simulation.memory() as u64);
        let [_, piled] = needed.contact_lists;
        // A GPU says itself what does not fit into its memory.
        let is_here = simulation.backend() == "cpu";
        let free = if is_here { || free_memory().map_or(u64::MAX, |free| free.bytes) } else { || u64::MAX };
        // What does not grow is known best where it has been built.
        let foreseen = now.saturating_add(piled.max(needed.bytes));
        Self { foreseen, expected: foreseen, before: now, free }
    }

    /// Looks after a frame, when the run takes `now` [byte]. Says that it is more than was foreseen once, and again where it has
    /// doubled.
    pub fn look(&mut self, now: u64) -> Option<Growth> {
        let growth = now.saturating_sub(std::mem::replace(&mut self.before, now));
        if now <= self.expected {
            return None;
        }
        let remedy =
            "many layers of triangles are near each other; a coarser mesh or thinner contact would need less";
        let free = (self.free)();
        if growth > free {
            let (now, free) = (size(now), size(free));
            return Some(Growth::TooMuch(format!(
                "the run takes {now} of memory and {free} are free: {remedy}"
            )));
        }
        self.expected = now.saturating_mul(2);
        let (now, foreseen) = (size(now), size(self.foreseen));
        Some(Growth::Beyond(format!(
            "warning: the run takes {now} of memory, and {foreseen} were foreseen: {remedy}"
        )))
    }
}

/// A warning if results of `bytes` will not fit onto the disk that holds `dir` (or will, once it exists).
pub fn disk_warning(dir: &Path, bytes: u64) -> Option<String> {
    let free = free_on_disk(dir)?;
    (bytes > free).then(|| {
        format!(
            "the results will take about {} and {} are free in {}; fewer frames or formats, or another --out, would do",
            size(bytes),
            size(free),
            dir.display()
        )
    })
}

/// Free bytes for this user on the disk of `dir`, or of the nearest folder above it that exists.
#[cfg(unix)]
fn free_on_disk(dir: &Path) -> Option<u64> {
    use std::os::unix::ffi::OsStrExt;
    let full = std::path::absolute(dir).ok()?;
    let there = full.ancestors().find(|folder| folder.exists())?;
    let name = std::ffi::CString::new(there.as_os_str().as_bytes()).ok()?;
    let mut stat = std::mem::MaybeUninit::<libc::statvfs>::zeroed();
    // SAFETY: `name` ends in a zero byte and `stat` is large enough; both outlive the call, which fills `stat` in when
    // it returns 0, and zeros are a valid `statvfs` in any case.
    let stat = unsafe { (libc::statvfs(name.as_ptr(), stat.as_mut_ptr()) == 0).then(|| stat.assume_init())? };
    #[allow(clippy::unnecessary_cast, reason = "32 bits on some systems")]
    Some((stat.f_bavail as u64).saturating_mul(stat.f_frsize as u64))
}

/// Not asked elsewhere.
#[cfg(not(unix))]
fn free_on_disk(_dir: &Path) -> Option<u64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn growth_is_said_once_and_again_when_doubled() {
        let mut watch = Watch { foreseen: 10 << 20, expected: 10 << 20, before: 8 << 20, free: || 99 << 20 };
        let mut looked = |now: u64| watch.look(now << 20);
        let remedy =
            "many layers of triangles are near each other; a coarser mesh or thinner contact would need less";
        let beyond = |now: u64, foreseen: u64| {
            let words = format!(
                "warning: the run takes {now}.0 MiB of memory, and {foreseen}.0 MiB were foreseen: {remedy}"
            );
            Some(Growth::Beyond(words))
        };
        assert_eq!([10, 12, 20, 25].map(&mut looked), [None, beyond(12, 10), None, beyond(25, 10)]);
        // Another frame that adds 100 MiB does not fit into 99.
        let full = format!("the run takes 125.0 MiB of memory and 99.0 MiB are free: {remedy}");
        assert_eq!(looked(125), Some(Growth::TooMuch(full)));
    }

    #[cfg(unix)]
    #[test]
    fn results_larger_than_the_disk_are_told_before_they_are_written() {
        let folder = tempfile::tempdir().unwrap();
        let later = folder.path().join("not/yet/there");
        assert_eq!(disk_warning(&later, 1), None);
        let warning = disk_warning(&later, u64::MAX).unwrap();
        assert!(warning.starts_with("the results will take about 16777216.0 TiB and "), "{warning}");
    }
}
