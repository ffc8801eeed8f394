//! The program on a GPU; a software adapter serves.

use crate::desk::{BALL, Desk, SHEET, ending};
use std::path::Path;

/// Runs the scene on a GPU, with more words; what it said and how it ended.
fn on_gpu(desk: &Desk, out: &str, words: &[&str]) -> (String, String, Option<i32>) {
    let mut command = desk.taffeta(&["run", "scene.toml", "--backend", "gpu", "--out", out]);
    // Nobody has logged in on a server.
    command.args(words).env_remove("XDG_RUNTIME_DIR");
    ending(command)
}

/// The numbers of positions.npy.
fn positions(desk: &Desk, out: &str) -> Vec<f32> {
    let name = format!("{out}/positions.npy");
    let (_, length) = desk.npy(&name);
    let bytes = std::fs::read(desk.path(&name)).unwrap();
    bytes[bytes.len() - length..].as_chunks().0.iter().map(|number| f32::from_le_bytes(*number)).collect()
}

/// The largest difference.
fn farthest(a: &[f32], b: &[f32]) -> f32 {
    assert!(a.len() == b.len() && !a.is_empty());
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, |most, one| if one <= most { most } else { one })
}

#[test]
fn a_run_on_the_gpu_says_so_and_gives_the_same_bits_twice() {
    let desk = Desk::with(BALL);
    let (out, err, code) = on_gpu(&desk, "a", &[]);
    assert_eq!((err.as_str(), code), ("", Some(0)), "{out}");
    assert!(out.contains("\ngpu, "), "{out}");
    assert_eq!(desk.files("a"), ["frames.csv", "positions.npy", "summary.json"]);
    assert!(desk.npy("a/positions.npy").0.contains("(13, 162, 3)"));
    assert_eq!(on_gpu(&desk, "b", &["--quiet"]), (String::new(), String::new(), Some(0)));
    let [a, b] = ["a", "b"].map(|folder| desk.json(&format!("{folder}/summary.json")));
    assert_eq!(
        (&a["backend"], &a["precision"], &a["status"]),
        (&"gpu".into(), &"f32".into(), &"done".into())
    );
    let device = a["device"].as_str().unwrap();
    assert!(device.starts_with("gpu, "), "{device}");
    assert_eq!(
        out.contains("is a software adapter: its results are valid, its timings say nothing of hardware"),
        device.contains("software")
    );
    assert!(a["state_hash"].is_string());
    assert_eq!(a["state_hash"], b["state_hash"]);
}

#[test]
fn cpu_and_gpu_agree() {
    let scenes = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes");
    let read = |name: &str| std::fs::read_to_string(scenes.join(name)).unwrap();
    // The GPU does not keep volumes yet.
    let twist = read("twist_pins.toml").replace("\"corrected\"", "\"none\"");
    for scene in [SHEET, BALL, &read("flag_gusts.toml"), &twist] {
        let desk = Desk::with(scene);
        let (_, err, code) = on_gpu(&desk, "gpu", &["--frames", "3", "--quiet"]);
        assert_eq!(code, Some(0), "{err}");
        let words = ["run", "scene.toml", "--backend", "cpu", "--out", "cpu", "--frames", "3", "--quiet"];
        desk.taffeta(&words).assert().success();
        let most = farthest(&positions(&desk, "cpu"), &positions(&desk, "gpu"));
        assert!(most < 1e-5, "{most} m in\n{scene}");
    }
}

#[test]
fn what_cannot_go_together_is_refused_before_anything_is_written() {
    let desk = Desk::with(SHEET);
    let refused = |words: &[&str], parts: &[&str]| {
        let mut command = desk.taffeta(words);
        command.env("TAFFETA_ADAPTER", "nonsense");
        let (_, err, code) = ending(command);
        assert_eq!(code, Some(2), "{err}");
        assert!(parts.iter().all(|part| err.contains(part)), "{err}");
        assert!(!desk.path("out/scene").exists(), "{words:?}");
    };
    let run = ["run", "scene.toml"];
    let with = |words: &[&'static str]| [&run[..], words].concat();
    let adapter = ["--backend gpu: TAFFETA_ADAPTER=`nonsense` fits no adapter; there ", "0: "];
    refused(&with(&["--backend", "gpu"]), &adapter);
    refused(&["bench", "grid", "--n", "8", "--backend", "gpu"], &adapter);
    let bits = ["--backend gpu computes in 32 bits, not with --precision f64"];
    refused(&with(&["--backend", "gpu", "--precision", "f64"]), &bits);
    refused(&["bench", "grid", "--backend", "gpu", "--precision", "f64"], &bits);
    refused(&with(&["--gpu-from", "springs"]), &["--gpu-from is for --backend gpu"]);
    refused(&with(&["--gpu-from", "springs", "--backend", "cpu"]), &["--gpu-from is for --backend gpu"]);
    let stages = "elements, loads, springs, constraints, volumes, integrate, pins, contact, positions, attach, pairs, project, filter, diagnose";
    refused(&with(&["--gpu-from", "spring", "--backend", "gpu"]), &["invalid value 'spring'", stages]);
    refused(&["bench", "grid", "--kernels", "plain"], &["--kernels is for --backend gpu"]);
}

/// Large enough for a GPU to gain.
const LARGE: [&str; 8] = [
    "--set",
    "body.sheet.mesh.grid.rows=200",
    "--set",
    "body.sheet.mesh.grid.cols=200",
    "--set",
    "time.max_step=0.0005",
    "--threads",
    "1",
];

#[test]
fn auto_takes_the_cpu_where_a_gpu_gains_nothing_and_says_why() {
    let desk = Desk::with(SHEET);
    let auto = |adapter: &str, words: &[&str]| {
        let mut command = desk.taffeta(&["run", "scene.toml", "--frames", "1"]);
        command.args(words).env("TAFFETA_ADAPTER", adapter).env_remove("XDG_RUNTIME_DIR");
        let (out, err, code) = ending(command);
        assert_eq!((err.as_str(), code), ("", Some(0)));
        assert_eq!(desk.json("out/scene/summary.json")["backend"], "cpu");
        out
    };
    assert!(auto("", &[]).contains(" (cpu: the scene is too small to gain by a GPU)\n"));
    // Where there is a GPU there may be no software adapter.
    if ending(desk.taffeta(&["info"])).0.contains(", software)") {
        let out = auto("software", &LARGE);
        assert!(out.contains(" (cpu: only a software adapter (") && out.contains(") is there)\n"), "{out}");
    }
    let out = auto("nonsense", &LARGE);
    assert!(out.contains(" (cpu: TAFFETA_ADAPTER=`nonsense` fits no adapter"), "{out}");
    let out = auto("", &[&LARGE[..], &["--precision", "f64"]].concat());
    assert!(out.contains(" (cpu: a GPU computes in f32)\n"), "{out}");
}

/// The Vulkan loader looks for drivers where these say.
#[cfg(target_os = "linux")]
#[test]
fn without_an_adapter_the_error_says_what_to_install_and_auto_goes_on() {
    let desk = Desk::with(SHEET);
    let without = |words: &[&str]| {
        let mut command = desk.taffeta(words);
        command.env("VK_DRIVER_FILES", "/none").env("VK_ICD_FILENAMES", "/none");
        ending(command)
    };
    let (_, err, code) = without(&["run", "scene.toml", "--backend", "gpu"]);
    assert_eq!(code, Some(2));
    assert!(
        err.starts_with("error: --backend gpu: no GPU was found; ") && err.contains("apt-get install"),
        "{err}"
    );
    let (out, err, code) = without(&[&["run", "scene.toml", "--frames", "1"][..], &LARGE].concat());
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains(" (cpu: no GPU was found; "), "{out}");
    let (out, _, code) = without(&["info"]);
    assert_eq!(code, Some(0));
    assert!(out.contains("\ngpu: no GPU was found; "), "{out}");
}

#[test]
fn info_numbers_the_adapters_and_names_the_one_that_is_taken() {
    let (out, err, code) = ending(Desk::with(SHEET).taffeta(&["info"]));
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("\ngpu 0: ") && out.contains("vulkan"), "{out}");
    assert!(out.contains("\n--backend gpu takes ") && out.contains("iB in one piece at most\n"), "{out}");
}

#[test]
fn a_run_goes_on_on_the_other_backend_and_says_so() {
    let desk = Desk::with(SHEET);
    let words = ["run", "scene.toml", "--out", "o", "--quiet", "--frames", "2", "--checkpoint-every", "2"];
    desk.taffeta(&words).assert().success();
    let resume = |words: &[&str]| {
        let (out, err, code) =
            ending(desk.taffeta(&[&["run", "scene.toml", "--resume", "o"], words].concat()));
        assert_eq!(code, Some(0), "{err}");
        (out, desk.json("o/summary.json"))
    };
    let (out, summary) = resume(&["--frames", "4", "--backend", "gpu"]);
    let said = "resuming from frame 2 of 4, from cpu to gpu: not bit by bit the same as without the stop\n";
    assert!(out.contains(said), "{out}");
    assert_eq!(summary["backend"], "gpu");
    assert!(desk.npy("o/positions.npy").0.contains("(5, 35, 3)"));
    // Without a word it stays there.
    let (out, summary) = resume(&["--frames", "6"]);
    assert!(out.contains("resuming from frame 4 of 6\n") && out.contains(" (gpu: as until now)\n"), "{out}");
    assert_eq!(summary["backend"], "gpu");
    let (out, _) = resume(&["--frames", "7", "--precision", "f64"]);
    assert!(
        out.contains("frame 6 of 7, converted from f32 to f64, from gpu to cpu: not bit by bit"),
        "{out}"
    );
    assert!(out.contains(" (cpu: a GPU computes in f32)\n"), "{out}");
    let words = ["run", "scene.toml", "--resume", "o", "--frames", "8", "--backend", "gpu"];
    let (_, err, code) = ending(desk.taffeta(&words));
    assert_eq!(code, Some(2));
    assert!(err.contains("--precision f32 or --backend cpu would do"), "{err}");
}

#[test]
fn a_run_that_was_stopped_on_the_gpu_ends_with_the_same_bits() {
    let desk = Desk::with(BALL);
    assert_eq!(on_gpu(&desk, "whole", &["--quiet"]).2, Some(0));
    assert_eq!(on_gpu(&desk, "o", &["--quiet", "--frames", "5", "--checkpoint-every", "5"]).2, Some(0));
    assert_eq!(on_gpu(&desk, "o", &["--quiet", "--resume", "o", "--frames", "12"]).2, Some(0));
    let [whole, o] = ["whole", "o"].map(|folder| desk.json(&format!("{folder}/summary.json")));
    assert_eq!(whole["state_hash"], o["state_hash"]);
    assert!(positions(&desk, "whole") == positions(&desk, "o"));
}

#[test]
fn stages_before_the_one_named_are_done_on_the_cpu() {
    let desk = Desk::with(SHEET);
    desk.taffeta(&["run", "scene.toml", "--backend", "cpu", "--out", "cpu", "--quiet"]).assert().success();
    let (out, err, code) = on_gpu(&desk, "o", &["--gpu-from", "contact"]);
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("note: stages before contact are done on the CPU, step by step\n"), "{out}");
    assert!(farthest(&positions(&desk, "cpu"), &positions(&desk, "o")) < 1e-5);
}

#[test]
fn a_bench_on_the_gpu_prints_a_line_for_each_kind_of_kernels() {
    let desk = Desk::with(SHEET);
    let words = "bench grid --n 16 --frames 2 --backend gpu --kernels best,plain --json";
    let (out, err, code) = ending(desk.taffeta(&words.split(' ').collect::<Vec<_>>()));
    assert_eq!(code, Some(0), "{err}");
    let lines: Vec<serde_json::Value> = out.lines().map(|line| serde_json::from_str(line).unwrap()).collect();
    assert_eq!(lines.len(), 2);
    for (line, kernels) in lines.iter().zip(["best", "plain"]) {
        assert_eq!((&line["kernels"], &line["backend"]), (&kernels.into(), &"gpu".into()));
        assert_eq!(
            (&line["nodes"], &line["substeps_per_frame"], &line["frames"]),
            (&256.into(), &34.into(), &2.into())
        );
        for path in [
            "/ms_per_frame/min",
            "/particle_substeps_per_s",
            "/limits/memory_gb_per_s",
            "/limits/memory_fraction",
        ] {
            assert!(line.pointer(path).unwrap().as_f64().unwrap() > 0.0, "{path}");
        }
        let software = line["device"].as_str().unwrap().contains("software");
        assert_eq!(line["note"].as_str().unwrap_or_default().contains("say nothing of hardware"), software);
    }
}
