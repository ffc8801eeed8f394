//! `cargo xtask shaders`: a table of what Mesa's compiler for AMD makes of every kernel, for GPUs that are not there.

use crate::{program, vulkan};
use serde::Deserialize;
use std::collections::BTreeMap;
use std::fmt::Write;
use std::process::ExitCode;

/// RDNA 2, RDNA 3 (by its names in newer and older versions) and GCN 5.
const FAMILIES: [&str; 3] = ["navi21", "navi31|gfx1100", "vega10"];
const PAGE: &str = "docs/results/shaders.md";
/// Most kernels have nothing to be said of; these are the ones with the fewest waves.
const SHOWN: usize = 40;

#[derive(Deserialize)]
struct Found {
    device: String,
    driver: String,
    kernels: Vec<Compiled>,
}

#[derive(Deserialize)]
struct Compiled {
    entry: String,
    with: String,
    statistics: BTreeMap<String, f64>,
}

impl Compiled {
    fn of(&self, name: &str) -> f64 {
        self.statistics.get(name).copied().unwrap_or(f64::NAN)
    }
}

/// Writes the page.
pub fn run() -> ExitCode {
    program::write_page(PAGE, found().map(|found| page(&found)))
}

fn found() -> Result<Vec<Found>, String> {
    vulkan::provide()?;
    let words = ["run", "--quiet", "--profile", "quick", "-p", "taffeta-shaders", "--"];
    let mut command = program::cargo(&[&words[..], &FAMILIES[..]].concat());
    let output = command.output().map_err(|error| format!("cargo: {error}"))?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).trim().to_owned());
    }
    serde_json::from_slice(&output.stdout).map_err(|error| format!("taffeta-shaders: {error}"))
}

fn page(found: &[Found]) -> String {
    let mut page = String::from(
        "# Kernels as a GPU's compiler sees them\n\n\
         `cargo xtask shaders` writes this page. Mesa's driver for AMD compiles every kernel with each choice of files that it is\n\
         put together with, for GPUs that are not there; nothing is run. Shown are the kernels with the fewest waves that a\n\
         SIMD can have in flight, by their registers and shared memory: in units of 32 lanes and of at most 32, so that a wave of 64\n\
         counts twice; on vega10 waves of 64, of at most 10. Bytes are of code: the cache for instructions has 32,768. `cost` is the\n\
         compiler's own guess of a wave's cycles, to be compared among kernels that are alike.\n",
    );
    for one in found {
        let mut kernels: Vec<&Compiled> = one.kernels.iter().collect();
        let key =
            |kernel: &Compiled| (kernel.of("Subgroups per SIMD") as u64, -kernel.of("Code size") as i64);
        kernels.sort_by_key(|kernel| key(kernel));
        let largest = kernels.iter().map(|kernel| kernel.of("Code size")).fold(0.0, f64::max);
        let spilled = |name| kernels.iter().filter(|kernel| kernel.of(name) > 0.0).count();
        let _ = write!(
            page,
            "\n## {}\n\n{}; {} kernels; most code {largest} bytes; {} spill vector registers, {} scalar ones (to vector registers).\n\n\
             | kernel | with | waves | vector registers | scalar spills | shared bytes | instructions | bytes | cost |\n\
             |---|---|---|---|---|---|---|---|---|\n",
            one.device,
            one.driver,
            kernels.len(),
            spilled("Spilled VGPRs"),
            spilled("Spilled SGPRs"),
        );
        for kernel in kernels.iter().take(SHOWN) {
            let names: Vec<&str> =
                kernel.with.split(' ').map(|path| path.rsplit('/').next().unwrap_or(path)).collect();
            let _ = writeln!(
                page,
                "| {} | {} | {} | {} | {} | {} | {} | {} | {} |",
                kernel.entry,
                names.join(" "),
                kernel.of("Subgroups per SIMD"),
                kernel.of("VGPRs"),
                kernel.of("Spilled SGPRs"),
                kernel.of("LDS size"),
                kernel.of("Instructions"),
                kernel.of("Code size"),
                kernel.of("Inverse Throughput"),
            );
        }
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn kernels_with_few_waves_come_first_and_files_lose_their_folders() {
        let kernel = |entry: &str, waves, bytes| Compiled {
            entry: entry.into(),
            with: "a/b.wgsl c.wgsl".into(),
            statistics: [("Subgroups per SIMD", waves), ("Code size", bytes), ("Spilled SGPRs", 1.0)]
                .map(|(name, value)| (name.to_owned(), value))
                .into(),
        };
        let kernels = vec![kernel("light", 32.0, 9.0), kernel("short", 8.0, 5.0), kernel("long", 8.0, 70.0)];
        let page = page(&[Found { device: "Navi".into(), driver: "Mesa".into(), kernels }]);
        let at = |word: &str| page.find(&format!("| {word} |")).expect(word);
        assert!(at("long") < at("short") && at("short") < at("light"));
        assert!(page.contains("| long | b.wgsl c.wgsl | 8 |"));
        assert!(page.contains("most code 70 bytes; 0 spill vector registers, 3 scalar"));
    }
}
