//! The report on three papers.

use super::desk::Desk;
use serde_json::{Value, json};
use std::collections::HashSet;
use std::fs;

/// Every table of the whole report.
const TABLES: [&str; 32] = [
    "s1-springs",
    "s1-sheets",
    "s1-others",
    "s1-methods",
    "s1-solves",
    "s1-fig11",
    "s1-fig12",
    "s1-fig13",
    "s1-fig14",
    "s1-fig15",
    "s1-ice-sizes",
    "s1-printed-ice",
    "s1-printed-acad",
    "s1-acad-options",
    "s1-hanging",
    "s2-ladder",
    "s2-times",
    "s3-speed",
    "s3-forms",
    "s3-added",
    "s3-own",
    "s3-loss",
    "s3-printed",
    "s3-press",
    "s3-stiffness",
    "aims",
    "sheets-fastest",
    "sheets-runs",
    "tournament-fastest",
    "tournament-runs",
    "limits",
    "errata",
];

/// What follows `start` in a text, up to `end`, wherever it is.
fn all<'a>(text: &'a str, start: &'a str, end: char) -> impl Iterator<Item = &'a str> {
    text.split(start).skip(1).filter_map(move |rest| rest.split(end).next())
}

/// The lines of a report's raw numbers.
fn raw(desk: &Desk) -> Vec<Value> {
    let text = fs::read_to_string(desk.path("out/raw.jsonl")).expect("raw numbers");
    text.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

#[test]
fn a_quick_report_has_every_table_and_every_number_of_ours_its_run() {
    let desk = Desk::new();
    let words = ["all", "--quick", "--out", "out"];
    desk.papers(&words).assert().success();
    let page = fs::read_to_string(desk.path("out/report.html")).expect("the report");
    let tables: HashSet<&str> = all(&page, "<table id=\"", '"').collect();
    for table in TABLES {
        assert!(tables.contains(table), "{table} of {tables:?}");
        assert!(desk.path(&format!("out/tables/{table}.csv")).is_file(), "{table}.csv");
    }
    let runs: HashSet<&str> = all(&page, "<details id=\"", '"').collect();
    let links: HashSet<&str> = all(&page, "<td><a href=\"#", '"').collect();
    assert!(links.len() > 60, "{} links", links.len());
    assert_eq!(links, runs);
    // Nothing from elsewhere: it opens from the disk.
    let sources: Vec<&str> = all(&page, "src=\"", '"').collect();
    assert!(!sources.is_empty() && sources.iter().all(|source| source.starts_with("data:")));
    assert!(!page.contains("<script") && !page.contains("url("));
    let names: HashSet<String> = raw(&desk)
        .iter()
        .filter_map(|kept| kept["name"].as_str().map(|name| format!("run-{name}")))
        .collect();
    assert!(runs.iter().all(|run| names.contains(*run)));
    assert_published_and_measured(&page, &desk);
    // What was run is not run again.
    let again = desk.papers(&words).assert().success();
    let said = String::from_utf8_lossy(&again.get_output().stdout).into_owned();
    assert_markdown(&desk);
    assert!(said.starts_with("0 runs, ") && again.get_output().stderr.is_empty(), "{said}");
}

/// The report as Markdown has the same parts, and leads to files that are there.
fn assert_markdown(desk: &Desk) {
    let text = fs::read_to_string(desk.path("out/report.md")).expect("the report as Markdown");
    let files: Vec<&str> =
        all(&text, "](", ')').filter(|link| !link.contains(':') && !link.starts_with('#')).collect();
    assert!(
        files.len() > 20 && files.iter().all(|file| desk.path(&format!("out/{file}")).is_file()),
        "{files:?}"
    );
    assert!(text.contains("\n## S1: numbers of springs\n") && text.contains("| 32 × 32 | 1,024 |"));
}

/// Counts of springs are the published ones, springs of figure 15 blow up where ACAD does not, and a kept volume is kept.
fn assert_published_and_measured(page: &str, desk: &Desk) {
    for (ours, theirs) in [("5,826", "5,826"), ("6,598", "6,598"), ("3,906", "3,906"), ("5,550", "5,550")] {
        assert!(page.contains(&format!("\">{ours}</a></td><td class=\"theirs\">{theirs}</td>")), "{ours}");
    }
    let raw = raw(desk);
    let of = |name: &str| raw.iter().find(|kept| kept["name"] == name).map(|kept| kept["result"].clone());
    let result = |name: &str| of(name).unwrap_or_else(|| panic!("{name} was not run"));
    assert!(result("s1-fig15-springs")["diverged"].is_u64() && result("s1-fig15-acad")["diverged"].is_null());
    let loss =
        |form: &str| result(&format!("s3-fall-sphere-{form}-1000"))["max_loss"].as_f64().unwrap_or(f64::NAN);
    assert!(loss("none") > 0.2 && loss("corrected") < 1e-4, "{} {}", loss("none"), loss("corrected"));
}

#[test]
fn what_a_machine_with_a_gpu_brought_fills_its_rows() {
    let desk = Desk::new();
    let line = json!({
        "name": "s2-binned-gpu-160", "command": "taffeta bench contact", "machine": "elsewhere", "program": "1", "quick": false,
        "result": {
            "device": "gpu, H9 (vulkan, discrete)", "nodes": 25600, "springs": 152002, "precision": "f32",
            "substeps_per_frame": 34, "ms_per_frame": {"min": 0.4, "median": 0.5, "max": 0.6}, "steps_per_s": 68000.0,
            "limits": {"memory_gb_per_s": 4000.0, "memory_fraction": 0.25}
        }
    });
    fs::write(desk.path("gpu.jsonl"), format!("{line}\n")).expect("a file");
    desk.papers(&["s2", "--quick", "--out", "out", "--merge", "gpu.jsonl"]).assert().success();
    let page = fs::read_to_string(desk.path("out/report.html")).expect("the report");
    assert!(page.contains("<a href=\"#run-s2-binned-gpu-160\">gpu, H9 (vulkan, discrete)</a>"));
    assert!(page.contains("<a href=\"#run-s2-binned-gpu-160\">25 %</a>"));
    // What was brought stays when the report is written again.
    fs::remove_file(desk.path("out/report.html")).expect("the report");
    desk.papers(&["s2", "--out", "out", "--only-report"]).assert().success();
    let again = fs::read_to_string(desk.path("out/report.html")).expect("the report");
    assert!(again.contains("run-s2-binned-gpu-160") && again.contains("run-s2-serial-10"));
    fs::write(desk.path("gpu.jsonl"), "{\"name\": 1}\n").expect("a file");
    let wrong = ["s2", "--quick", "--out", "out", "--merge", "gpu.jsonl"];
    let said = desk.papers(&wrong).assert().code(2);
    let said = String::from_utf8_lossy(&said.get_output().stderr).into_owned();
    assert!(said.contains("--merge gpu.jsonl: line 1: "), "{said}");
    // What is refused leaves nothing behind.
    for (file, out, options) in [("gpu.jsonl", "new", &["--quick"][..]), ("nowhere", "new", &[])] {
        let words = [&["s2", "--out", out, "--merge", file], options].concat();
        desk.papers(&words).assert().code(2);
        assert!(!desk.path(out).exists());
    }
    let said = desk.papers(&["s2", "--out", "new", "--only-report"]).assert().code(2);
    let said = String::from_utf8_lossy(&said.get_output().stderr).into_owned();
    assert!(said.contains("new has no runs"), "{said}");
}

#[test]
fn a_folder_that_cannot_be_one_is_refused_and_what_is_in_it_stays() {
    let desk = Desk::new();
    let refused = |out: &str| {
        let said = desk.papers(&["s1", "--quick", "--out", out]).assert().code(2);
        String::from_utf8_lossy(&said.get_output().stderr).into_owned()
    };
    fs::write(desk.path("file"), "").expect("a file");
    assert!(refused("file").contains("--out file: is a file; a folder would do"));
    fs::create_dir(desk.path("other")).expect("a folder");
    fs::write(desk.path("other/raw.jsonl"), "[1]\n").expect("a file");
    let said = refused("other");
    assert!(said.contains("other/raw.jsonl: line 1: ") && said.contains("remove that line"), "{said}");
    assert_eq!(fs::read_to_string(desk.path("other/raw.jsonl")).ok().as_deref(), Some("[1]\n"));
    fs::create_dir(desk.path("busy")).expect("a folder");
    let lock = fs::File::create(desk.path("busy/lock.part")).expect("a file");
    lock.try_lock().expect("nobody else has it");
    let said = refused("busy");
    assert!(said.contains("--out busy: another run is writing here"), "{said}");
    assert_eq!(desk.files("busy"), ["lock.part"]);
}

#[test]
fn a_taffeta_that_is_not_there_is_told_how_to_be_built_and_a_report_of_what_is_there_needs_none() {
    let desk = Desk::new();
    let said = desk.papers(&["s1", "--quick", "--out", "out", "--taffeta", "nowhere"]).assert().code(2);
    let said = String::from_utf8_lossy(&said.get_output().stderr).into_owned();
    assert!(said.contains("none at nowhere: `cargo build --release -p taffeta-cli`"), "{said}");
    assert!(!desk.path("out").exists());
    let line = json!({
        "name": "s1-grid-160", "command": "", "machine": "here", "program": "", "quick": false,
        "result": {"ms_per_frame": {"min": 1.0, "median": 2.0, "max": 3.0}, "nodes": 25600}
    });
    fs::create_dir(desk.path("out")).expect("a folder");
    fs::write(desk.path("out/raw.jsonl"), format!("{line}\n")).expect("a file");
    desk.papers(&["s1", "--out", "out", "--only-report", "--taffeta", "nowhere"]).assert().success();
    let page = fs::read_to_string(desk.path("out/report.html")).expect("the report");
    assert!(page.contains("<a href=\"#run-s1-grid-160\">2.00 (1.00 to 3.00)</a>"));
}

/// A Ctrl-C during the first long run: what was run before is kept.
#[cfg(unix)]
#[test]
fn a_report_that_is_stopped_goes_on_where_it_was() {
    let desk = Desk::new();
    let mut child = std::process::Command::new(assert_cmd::cargo::cargo_bin!("taffeta-papers"))
        .args(["s3", "--quick", "--out", "out"])
        .current_dir(desk.path(""))
        .stderr(std::process::Stdio::piped())
        .spawn()
        .expect("the program starts");
    let stderr = child.stderr.take().expect("its words");
    let mut lines = std::io::BufRead::lines(std::io::BufReader::new(stderr));
    // The fourth run begins: three are done.
    assert!(lines.by_ref().take(4).all(|line| line.is_ok()));
    // SAFETY: the child is ours and was not waited for.
    assert_eq!(unsafe { libc::kill(child.id().cast_signed(), libc::SIGINT) }, 0);
    let last = lines.map_while(Result::ok).last().unwrap_or_default();
    assert!(last.contains("the same command goes on"), "{last}");
    assert_eq!(child.wait().ok().and_then(|status| status.code()), Some(130));
    let kept = raw(&desk).len();
    assert!(kept >= 3 && !desk.path("out/report.html").exists(), "{kept}");
    let done = desk.papers(&["s3", "--quick", "--out", "out"]).assert().success();
    let said = String::from_utf8_lossy(&done.get_output().stdout).into_owned();
    assert!(said.contains(&format!(", {kept} were there: ")), "{said}");
}
