//! Whether a scene fits into memory, before anything is built.

use std::path::Path;
use taffeta::Advice;
use taffeta::scene::Scene;

/// Memory that may still be taken, and what sets the limit.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct FreeMemory {
    /// [byte]
    pub bytes: u64,
    /// What sets the limit, as the end of a sentence; empty for the machine itself.
    pub limit: &'static str,
}

/// Why a scene does not fit into the memory that is free, with the numbers and what would do; for a run whose results hold `faces` or
/// normals, or do not. What is impossible as a scene passes: the engine says better what is wrong with it, and where.
pub fn short_of_memory(scene: &Scene, faces: bool) -> Option<(String, Vec<Advice>)> {
    let free = free_memory()?;
    let needed = scene.memory_needed();
    let bytes = needed.bytes.saturating_add(if faces { needed.faces } else { 0 });
    if bytes <= free.bytes || scene.validate().is_err() {
        return None;
    }
    let why = format!(
        "the scene needs about {} of memory, most of it for {}, and {} are free{}; {}",
        size(bytes),
        needed.mostly,
        size(free.bytes),
        free.limit,
        needed.remedy
    );
    Some((why, needed.advice))
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
pub fn free_memory() -> Option<FreeMemory> {
    let read = |path: &str| std::fs::read_to_string(path).ok();
    let machine = read("/proc/meminfo").and_then(|text| of_machine(&text));
    let groups = read("/proc/self/cgroup").unwrap_or_default();
    let group = of_groups(&groups, &read);
    let least = [machine, group].into_iter().flatten().min_by_key(|free| free.bytes)?;
    Some(FreeMemory { bytes: least.bytes / 10 * 9, ..least })
}

fn of_machine(meminfo: &str) -> Option<FreeMemory> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(FreeMemory { bytes: kib.checked_mul(1024)?, limit: "" })
}

/// What the limits of the control groups of this process leave, the least of them: `groups` is /proc/self/cgroup.
fn of_groups(groups: &str, read: &impl Fn(&str) -> Option<String>) -> Option<FreeMemory> {
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
    Some(FreeMemory { bytes, limit: " within the memory limit of this container (cgroup)" })
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
}
