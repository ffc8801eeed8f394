//! `cargo xtask gpu`: what to take to a machine with a GPU, and the page of what it brings back.

mod page;
mod report;

use crate::{program, root};
use report::Report;
use std::path::Path;
use std::process::ExitCode;

/// The programs that are taken along.
const PROGRAMS: [&str; 2] = ["taffeta", "taffeta-papers"];

/// Without words: builds what to take along. With `--merge FILE`: writes the page of what was found.
pub fn run(words: &[&str]) -> ExitCode {
    let result = match words {
        [] => prepare(),
        ["--merge", file] => merge(Path::new(file), &root().join("docs/results")),
        _ => {
            Err(format!("gpu {}: it takes nothing, or --merge with FILE.json of gpu-check", words.join(" ")))
        }
    };
    match result {
        Ok(words) => {
            println!("{words}");
            ExitCode::SUCCESS
        }
        Err(message) => {
            eprintln!("xtask: {message}");
            ExitCode::FAILURE
        }
    }
}

/// Builds the programs and puts them alone into a folder; returns what to do with them.
fn prepare() -> Result<String, String> {
    let commit = program::commit()?;
    let [first, second] = PROGRAMS;
    let mut build = program::cargo(&["build", "--release", "--bin", first, "--bin", second]);
    build.env("TAFFETA_COMMIT", &commit);
    if !build.status().map_err(|error| format!("cargo: {error}"))?.success() {
        return Err("the programs were not built".into());
    }
    let folder = program::target().join("gpu");
    // What lies there from an earlier build must not go along.
    let _ = std::fs::remove_dir_all(&folder);
    std::fs::create_dir_all(&folder).map_err(|error| format!("{}: {error}", folder.display()))?;
    for name in PROGRAMS {
        let built = program::path().with_file_name(format!("{name}{}", std::env::consts::EXE_SUFFIX));
        let copy = folder.join(built.file_name().unwrap_or_default());
        std::fs::copy(&built, &copy).map_err(|error| format!("{}: {error}", copy.display()))?;
    }
    let place = folder.strip_prefix(root()).unwrap_or(&folder).display();
    Ok(format!(
        "{place} has all that is needed (taffeta {commit}). Take it to a machine with a GPU and run there:

    ./taffeta gpu-check --out gpu-check.json

It takes some minutes: every kernel and some scenes beside their twins on the CPU, then measurements. The machine needs
the GPU's driver and the Vulkan loader (Debian and Ubuntu: `apt-get install libvulkan1`; with NVIDIA's driver in a
container also `libegl1 libglvnd0`), a C library no older than this machine's, and nothing else. Exit code 1: something
differs between GPU and CPU. TAFFETA_ADAPTER chooses among several GPUs; `taffeta info` lists them.
Bring back gpu-check.json, and then:

    cargo xtask gpu --merge gpu-check.json

For the report on the papers, run there too

    ./taffeta-papers all --out papers

and bring back papers/raw.jsonl; docs/papers.md says how its rows get into a report."
    ))
}

fn read(file: &Path) -> Result<Report, String> {
    let at = |error: &dyn std::fmt::Display| format!("{}: {error}", file.display());
    let text = std::fs::read_to_string(file).map_err(|error| at(&error))?;
    serde_json::from_str(&text).map_err(|error| at(&error))
}

/// Writes the page of a device beside the results of others; returns what to do with it.
fn merge(file: &Path, folder: &Path) -> Result<String, String> {
    let report = read(file)?;
    if report.device.software {
        return Err(format!(
            "{}: was measured on {}, a software adapter: its results are valid, its timings say nothing of hardware, and gets no page",
            file.display(),
            report.device.name
        ));
    }
    let slug = program::slug(&report.device.name);
    let page = folder.join(&slug).with_extension("md");
    std::fs::write(&page, page::of(&report)).map_err(|error| format!("{}: {error}", page.display()))?;
    Ok(format!(
        "docs/results/{slug}.md: {}\nLink it in docs/results/README.md: [{}]({slug}.md)",
        report.verdict(),
        report.device.name
    ))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::PathBuf;

    fn folder(name: &str) -> PathBuf {
        let folder = std::env::temp_dir().join(format!("taffeta-merge-{name}-{}", std::process::id()));
        std::fs::create_dir_all(&folder).expect("a folder");
        folder
    }

    #[test]
    fn a_gpu_gets_a_page_and_a_link() {
        let folder = folder("hardware");
        let file = folder.join("brought.txt");
        std::fs::write(&file, report::EXAMPLE).expect("a file");
        let said = merge(&file, &folder).expect("merged");
        let page = std::fs::read_to_string(folder.join("example-gpu-3000.md")).expect("a page");
        assert!(page.starts_with("# Example GPU 3000\n"), "{page}");
        assert!(said.contains("[Example GPU 3000](example-gpu-3000.md)"), "{said}");
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn a_software_adapter_gets_none() {
        let folder = folder("software");
        let file = folder.join("brought.json");
        let text = report::EXAMPLE.replace("\"software\": false", "\"software\": true");
        std::fs::write(&file, text).expect("a file");
        let error = merge(&file, &folder).expect_err("refused");
        assert!(
            error.contains("Example GPU 3000, a software adapter: its results are valid, its timings say nothing of hardware"),
            "{error}"
        );
        assert!(!folder.join("example-gpu-3000.md").exists());
        std::fs::remove_dir_all(&folder).expect("removed");
    }

    #[test]
    fn what_is_no_report_is_refused_with_its_name() {
        let folder = folder("other");
        let file = folder.join("other.json");
        std::fs::write(&file, "{\"version\": 3}").expect("a file");
        assert!(merge(&file, &folder).expect_err("refused").contains("other.json: "));
        std::fs::remove_dir_all(&folder).expect("removed");
    }
}
