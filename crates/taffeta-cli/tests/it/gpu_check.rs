//! `taffeta gpu-check` as a user, on whatever adapter there is.

use crate::desk::{Desk, SHEET, ending};

#[test]
fn a_quick_check_passes_and_leaves_everything_it_found() {
    let desk = Desk::with(SHEET);
    // The engine's own tests run all kernels beside their twins.
    let only = [
        "parity spring",
        "parity node",
        "scene",
        "copy",
        "sub-step",
        "read-back",
        "grid",
        "kernels",
        "mesh",
        "bod",
    ];
    let only = only.join(",");
    let (out, err, code) =
        ending(desk.taffeta(&["gpu-check", "--quick", "--out", "x.json", "--only", &only]));
    assert_eq!(code, Some(0), "{out}{err}");
    assert!(
        out.trim_end().lines().last().is_some_and(|line| line.starts_with("all checks passed, ")),
        "{out}"
    );
    assert!(err.contains(" s: scene flag, best\n") && err.contains(" s: copy bandwidth\n"), "{err}");
    let found = desk.json("x.json");
    assert_eq!((&found["complete"], &found["quick"]), (&true.into(), &true.into()));
    assert_eq!(found["faults"].as_array().map(Vec::len), Some(0), "{}", found["faults"]);
    let all = |part: &str| found[part].as_array().expect("a list").clone();
    assert!(all("parity").len() > 10 && all("parity").iter().all(|row| row["passed"] == true));
    assert!(all("scenes").len() > 3 && all("scenes").iter().all(|scene| scene["same_twice"] == true));
    let speeds = all("speeds");
    for part in ["grid", "kernels", "mesh", "bodies"] {
        assert!(speeds.iter().any(|speed| speed["part"] == part), "{part}");
    }
    for speed in &speeds {
        let (nodes, ms) = (speed["nodes"].as_f64(), speed["ms_per_substep"]["median"].as_f64());
        let rate = nodes.zip(ms).map(|(nodes, ms)| nodes * 1e3 / ms);
        let told = speed["particle_substeps_per_s"].as_f64();
        assert!(rate.zip(told).is_some_and(|(rate, told)| (rate / told - 1.0).abs() < 1e-9), "{speed}");
    }
    assert!(found["copy"]["kernel_gb_per_s"].as_f64() > Some(0.0), "{}", found["copy"]);
}

#[test]
fn a_check_that_there_is_not_is_refused() {
    let desk = Desk::with(SHEET);
    let (out, err, code) = ending(desk.taffeta(&["gpu-check", "--only", "colour"]));
    assert_eq!((code, out.as_str()), (Some(2), ""), "{err}");
    assert!(err.ends_with("error: --only colour: no check has such a name\n"), "{err}");
}

#[test]
fn an_adapter_that_is_not_there_is_refused_by_name() {
    let desk = Desk::with(SHEET);
    let mut command = desk.taffeta(&["gpu-check", "--out", "x.json"]);
    command.env("TAFFETA_ADAPTER", "no such adapter");
    let (out, err, code) = ending(command);
    assert_eq!((out.as_str(), code), ("", Some(2)));
    assert!(err.contains("TAFFETA_ADAPTER=`no such adapter` fits no adapter"), "{err}");
    assert!(!desk.path("x.json").exists());
}
