//! Whether a scene fits into memory, before anything is built.

use crate::failure::Failure;
use taffeta::scene::Scene;

/// Refuses a scene that needs more memory than is free, with the numbers.
pub fn check(scene: &Scene) -> Result<(), Failure> {
    let Some(free) = available() else { return Ok(()) };
    let needed = scene.memory_needed();
    if needed <= free {
        return Ok(());
    }
    let gib = |bytes: u64| bytes as f64 / (1_u64 << 30) as f64;
    Err(Failure::Input(format!(
        "the scene needs about {:.1} GiB of memory and {:.1} GiB are free; fewer nodes would do",
        gib(needed),
        gib(free)
    )))
}

/// Memory that is free [byte], less a tenth for others; `None` where the system does not say.
fn available() -> Option<u64> {
    let text = std::fs::read_to_string("/proc/meminfo").ok()?;
    let line = text.lines().find_map(|line| line.strip_prefix("MemAvailable:"))?;
    let kib: u64 = line.trim().strip_suffix("kB")?.trim().parse().ok()?;
    Some(kib * 1024 / 10 * 9)
}
