//! `cargo xtask speeds`: runs all benches, and writes what they print to a page.

use crate::{attack, program};
use std::fmt::Write;
use std::path::Path;
use std::process::{Command, ExitCode};

const PAGE: &str = "docs/results/speed.md";
/// What `taffeta bench` is called with, by what it shows.
const BENCHES: [(&str, &[&str]); 9] = [
    (
        "Springs of grids",
        &[
            "grid --n 20 --threads 1",
            "grid --n 40 --threads 1",
            "grid --n 160 --threads 1",
            "grid --n 160 --threads 2",
            "grid --n 512 --threads 1",
            "grid --n 512 --threads 2",
            "grid --rows 1368 --cols 5717",
        ],
    ),
    ("Springs of meshes", &["mesh --n 1250000 --threads 1", "mesh --n 1250000"]),
    (
        "Stiff sheets: implicit, soft ones on tethers, constraints on positions",
        &[
            "flag --n 40 --threads 1",
            "flag --n 160 --threads 1",
            "tethers --n 40 --threads 1",
            "tethers --n 160 --threads 1",
            "xpbd --n 40 --threads 1",
            "xpbd --n 160 --threads 1",
            "xpbd --n 160 --threads 2",
        ],
    ),
    (
        "Implicit constraints",
        &["ice --threads 1", "ice --form primal --threads 1", "ice", "acad --threads 1"],
    ),
    ("Fabric", &["fabric --threads 1", "fabric --form primal --threads 1"]),
    ("Contact", &["drape --threads 1", "contact --threads 1", "contact", "collider --threads 1"]),
    ("Volume", &["volume --threads 1"]),
    ("Starts and sleep", &["start --threads 1", "sleep --threads 1"]),
    ("Beside other programs", &["busy"]),
];

/// Measures with the built program, or the one that `words` name.
pub fn run(words: &[&str]) -> ExitCode {
    let program = match words {
        [] => attack::build(),
        ["--program", file] => program::named(file),
        _ => Err(format!("speeds {}: it takes --program FILE or nothing", words.join(" "))),
    };
    program::write_page(PAGE, program.and_then(|program| page(&program)))
}

fn page(taffeta: &Path) -> Result<String, String> {
    let mut page = format!(
        "# All benches\n\n\
         `cargo xtask speeds` runs every bench once and writes this page. A median says how fast the machine was most of the time, the\n\
         least how fast it can be: read the least where the load was not near 0 at the start.\n\n\
         Commit {}; {}.\n",
        program::commit()?,
        machine(),
    );
    for (heading, benches) in BENCHES {
        let _ = write!(page, "\n## {heading}\n");
        for bench in benches {
            println!("xtask: bench {bench}");
            let output = Command::new(taffeta).arg("bench").args(bench.split(' ')).output();
            let output = output.map_err(|error| format!("{}: {error}", taffeta.display()))?;
            if !output.status.success() {
                return Err(format!("bench {bench}: {}", String::from_utf8_lossy(&output.stderr).trim()));
            }
            let _ = write!(
                page,
                "\n    taffeta bench {bench}\n\n{}",
                shown(&String::from_utf8_lossy(&output.stdout))
            );
        }
    }
    Ok(page)
}

/// What a bench prints for people, as a block of text.
fn shown(output: &str) -> String {
    let lines: String =
        output.lines().filter(|line| !line.starts_with('{')).map(|line| format!("{line}\n")).collect();
    format!("```text\n{lines}```\n")
}

/// The processor, and how many programs waited for it in the last minute, where Linux tells.
fn machine() -> String {
    let read = |path: &str| std::fs::read_to_string(path).unwrap_or_default();
    let cpu = read("/proc/cpuinfo");
    let name =
        cpu.lines().find_map(|line| line.strip_prefix("model name")?.split_once(": ")).map(|(_, name)| name);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    let load = read("/proc/loadavg").split(' ').next().unwrap_or_default().to_owned();
    format!("{cores} cores of {}, load {load} at the start", name.unwrap_or("an unknown processor"))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::root;

    #[test]
    fn only_what_is_for_people_is_shown() {
        assert_eq!(
            shown("grid 40×40\n  34 sub-steps\n{\"bench\":\"grid\"}\n"),
            "```text\ngrid 40×40\n  34 sub-steps\n```\n"
        );
    }

    #[test]
    fn every_bench_is_measured() {
        let source = std::fs::read_to_string(root().join("crates/taffeta-cli/src/bench.rs")).unwrap();
        let kinds = source.split_once("enum What {").and_then(|(_, rest)| rest.split_once('}')).unwrap().0;
        let names: Vec<String> =
            kinds.lines().filter_map(|line| line.trim().strip_suffix(',')).map(str::to_lowercase).collect();
        assert!(names.len() > 10, "{names:?}");
        for name in &names {
            let measures = |bench: &&str| bench.split(' ').next() == Some(name);
            let is_in = BENCHES.iter().any(|(_, all)| all.iter().any(measures));
            assert!(is_in, "`bench {name}` is not measured");
        }
    }
}
