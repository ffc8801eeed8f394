//! Whether a scene fits into memory, before anything is built, and its results onto the disk.

use crate::console;
use std::path::Path;
use taffeta::Simulation;
use taffeta::scene::Scene;
use taffeta_io::program::Failure;

/// Memory that may still be taken, and what sets the limit.
#[derive(Clone, Debug, PartialEq, Eq)]
struct Free {
    bytes: u64,
    limit: &'static str,
}

/// Refuses a scene that needs more memory than is free, with the numbers. What is impossible as a scene passes: the
/// engine says better what is wrong with it, and where.
pub fn check(scene: &Scene) -> Result<(), Failure> {
    check_run(scene, false)
}

/// As [`check`], for a run whose results hold faces or normals, or do not.
pub fn check_run(scene: &Scene, faces: bool) -> Result<(), Failure> {
    let Some(free) = available() else { return Ok(()) };
    let needed = scene.memory_needed();
    let bytes = needed.bytes.saturating_add(if faces { needed.faces } else { 0 });
    if bytes <= free.bytes || scene.validate().is_err() {
        return Ok(());
    }
    Err(Failure::Input(format!(
        "the scene needs about {} of memory, most of it for {}, and {} are free{}; {}",
        size(bytes),
        needed.mostly,
        size(free.bytes),
        free.limit,
        console::advised(needed.remedy, &needed.advice)
    )))
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
        let free = if is_here { || available().map_or(u64::MAX, |free| free.bytes) } else { || u64::MAX };
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

/// A number of bytes for people.
pub fn size(bytes: u64) -> String {
    let units = ["bytes", "KiB", "MiB", "GiB", "TiB"];
    let unit = (1..units.len()).rev().find(|unit| bytes >> (10 * unit) > 0).unwrap_or(0);
    match unit {
        0 => format!("{bytes} bytes"),
        unit => format!("{:.1} {}", bytes as f64 / (1_u64 << (10 * unit)) as f64, units[unit]),
    }
}

/// Memory that is free: the machine's, or what a container's limit leaves of it; less a tenth for others. `None` where
/// the system does not say.
fn available() -> Option<Free> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| of_machine(&text));
    let groups = read("/proc/self/cgroup").unwrap_or_default();
    let group = of_groups(&groups, &read);
    let least = [machine, group].into_iter().flatten().min_by_key(|free| free.bytes)?;
    Some(Free { bytes: least.bytes / 10 * 9, ..least })
}

fn of_machine(meminfo: &str) -> Option<Free> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(Free { bytes: kib.checked_mul(1024)?, limit: "" })
}

/// What the limits of the control groups of this process leave, the least of them: `groups` is /proc/self/cgroup.
fn of_groups(groups: &str, read: &impl Fn(&str) -> Option<String>) -> Option<Free> {
    const V2: [&str; 3] = ["memory.max", "memory.current", "inactive_file "];
    const V1: [&str; 3] = ["memory.limit_in_bytes", "memory.usage_in_bytes", "total_inactive_file "];
    let of_line = |line: &str| {
        let mut parts = line.splitn(3, ':').skip(1);
        let (controllers, path) = (parts.next()?, parts.next()?);
        let (root, files) = match controllers {
            "" => ("/sys/fs/cgroup", V2),
            names if names.split(',').any(|name| name == "memory") => ("/sys/fs/cgroup/memory", V1),
            _ => return None,
        };
        // Inside a container its own group is mounted as the root.
        let above =
            Path::new(path).ancestors().filter_map(Path::to_str).map(|path| path.trim_end_matches('/'));
        above.filter_map(|path| left_by(&format!("{root}{path}"), files, read)).min()
    };
    let bytes = groups.lines().filter_map(of_line).min()?;
    Some(Free { bytes, limit: " within the memory limit of this container (cgroup)" })
}

/// Bytes that the group in `folder` may still take: its limit less what it uses, but for what can be dropped.
fn left_by(folder: &str, files: [&str; 3], read: &impl Fn(&str) -> Option<String>) -> Option<u64> {
    let number = |file: &str| read(&format!("{folder}/{file}"))?.trim().parse::<u64>().ok();
    let limit = number(files[0])?;
    let used = number(files[1]).unwrap_or(0);
    let statistics = read(&format!("{folder}/memory.stat")).unwrap_or_default();
    let dropped = statistics.lines().find_map(|line| line.strip_prefix(files[2])?.trim().parse::<u64>().ok());
    Some(limit.saturating_sub(used.saturating_sub(dropped.unwrap_or(0))))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashMap;

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

    #[test]
    fn the_machines_free_memory_is_read() {
        let text = "MemTotal:  200 kB\nMemFree: 1 kB\nMemAvailable:     100 kB\n";
        assert_eq!(of_machine(text).unwrap().bytes, 102_400);
        assert_eq!(of_machine("MemTotal: 3 kB\n"), None);
    }

    /// What is free under the files given.
    fn left(groups: &str, files: &[(&str, &str)]) -> Option<u64> {
        let files: HashMap<_, _> = files.iter().copied().collect();
        of_groups(groups, &|path: &str| files.get(path).map(ToString::to_string)).map(|free| free.bytes)
    }

    #[test]
    fn limits_of_control_groups_leave_what_is_not_used() {
        let v2 = [("/sys/fs/cgroup/a/memory.max", "1000\n"), ("/sys/fs/cgroup/a/memory.current", "300\n")];
        assert_eq!(left("0::/a\n", &v2), Some(700));
        assert_eq!(left("0::/a/b\n", &v2), Some(700), "a group above limits those in it");
        let cached = [v2[0], v2[1], ("/sys/fs/cgroup/a/memory.stat", "anon 5\ninactive_file 200\n")];
        assert_eq!(left("0::/a\n", &cached), Some(900));
        assert_eq!(left("0::/\n", &[("/sys/fs/cgroup/memory.max", "max\n")]), None);
        let v1 = [
            ("/sys/fs/cgroup/memory/memory.limit_in_bytes", "500"),
            ("/sys/fs/cgroup/memory/memory.usage_in_bytes", "600"),
        ];
        assert_eq!(left("5:cpu,memory:/docker/x\n1:name=systemd:/\n", &v1), Some(0));
        assert_eq!(left("", &v1), None);
    }

    #[test]
    fn sizes_are_told_in_units_that_people_read() {
        assert_eq!([0, 1023, 1024, 3 << 29].map(size), ["0 bytes", "1023 bytes", "1.0 KiB", "1.5 GiB"]);
        assert_eq!(size(u64::MAX), "16777216.0 TiB");
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
