//! The benches on constraints.

use crate::desk::{Desk, SHEET, ending};
use serde_json::Value;

fn lines(words: &str) -> Vec<Value> {
    let desk = Desk::with(SHEET);
    let (out, err, code) = ending(desk.taffeta(&words.split(' ').collect::<Vec<_>>()));
    assert_eq!(code, Some(0), "{err}");
    out.lines().map(|line| serde_json::from_str(line).unwrap()).collect()
}

fn number(line: &Value, path: &str) -> f64 {
    line.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {line}"))
}

#[test]
fn the_engine_solves_its_constraints_to_the_tolerance() {
    let lines = lines("bench ice --n 8 --frames 40 --json --precision f64");
    assert_eq!(lines.len(), 1);
    let line = &lines[0];
    assert_eq!((&line["bench"], &line["backend"]), (&"ice".into(), &"cpu".into()));
    assert!(number(line, "/iterations") >= 1.0 && number(line, "/residual") <= 1e-3, "{line}");
    assert_eq!(number(line, "/active_fraction"), 1.0);
}

#[test]
fn forms_of_implicit_constraints_print_a_line_each() {
    let lines = lines("bench ice --n 12 --frames 30 --json --form compliant,primal");
    let forms: Vec<_> = lines.iter().map(|line| line["form"].as_str().unwrap()).collect();
    assert_eq!(forms, ["compliant", "primal"]);
    for line in &lines {
        assert_eq!(
            (&line["nodes"], &line["springs"], &line["method"]),
            (&144.into(), &746.into(), &"ice".into())
        );
        assert!(number(line, "/residual") <= 1e-3 && number(line, "/ms_per_frame/median") > 0.0, "{line}");
    }
    let [dual, primal] = [0, 1].map(|form| number(&lines[form], "/iterations"));
    assert!(primal >= 1.0 && primal < 0.5 * dual, "{primal} iterations by nodes, {dual} by springs");
}

#[test]
fn a_stiff_flag_is_solved_by_nodes_at_one_step_a_frame() {
    let lines = lines("bench flag --n 20 --frames 20 --json --precision f64");
    assert_eq!(lines.len(), 1);
    let line = &lines[0];
    assert_eq!(
        (&line["bench"], &line["form"], &line["nodes"]),
        (&"flag".into(), &"primal".into(), &400.into())
    );
    assert_eq!((&line["method"], &line["substeps_per_frame"]), (&"ice".into(), &1.into()));
    assert!(number(line, "/iterations") >= 1.0 && number(line, "/residual") <= 1e-3, "{line}");
}

#[test]
fn adaptive_constraints_are_set_beside_springs_by_how_many_are_active() {
    let lines = lines("bench acad --n 16 --frames 20 --json");
    let of = |key: &str| lines.iter().map(|line| line[key].as_str().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(of("method"), ["springs", "acad", "acad", "acad", "acad"]);
    assert_eq!(of("case"), ["hanging", "hanging", "hanging", "hanging", "drop"]);
    assert!(lines[0]["active_fraction"].is_null() && lines[0]["over_springs"].is_null());
    let active: Vec<f64> = lines[1..4].iter().map(|line| number(line, "/active_fraction")).collect();
    assert!(active[0] == 0.0 && active[1] > 0.0 && active[2] > active[1] && active[2] < 0.2, "{active:?}");
    lines[1..4].iter().for_each(|line| assert!(number(line, "/over_springs") > 0.0));
}

#[test]
fn a_ball_of_triangles_is_set_beside_a_sphere() {
    let lines = lines("bench collider --n 12 --frames 2 --json");
    let of = |key: &str| lines.iter().map(|line| line[key].as_str().unwrap().to_owned()).collect::<Vec<_>>();
    assert_eq!(of("case")[..4], ["sphere", "mesh", "sphere", "mesh"]);
    assert_eq!(of("method")[..4], ["springs", "springs", "ice", "ice"]);
    for pair in lines[..4].chunks(2) {
        let [sphere, mesh] = [0, 1].map(|i| number(&pair[i], "/ms_per_frame/median"));
        assert!(pair[0]["over_sphere"].is_null());
        assert!((number(&pair[1], "/over_sphere") / (mesh / sphere) - 1.0).abs() < 1e-12);
    }
}

#[test]
fn kernels_and_forms_that_do_not_fit_a_bench_are_refused() {
    let desk = Desk::with(SHEET);
    let refused = |words: &str, parts: &[&str]| {
        let mut command = desk.taffeta(&words.split(' ').collect::<Vec<_>>());
        command.env("TAFFETA_ADAPTER", "nonsense");
        let (_, err, code) = ending(command);
        assert_eq!(code, Some(2), "{words}: {err}");
        assert!(parts.iter().all(|part| err.contains(part)), "{words}: {err}");
    };
    refused("bench ice --kernels plain", &["--kernels is for benches on explicit springs"]);
    refused(
        "bench ice --form corrected",
        &["--form corrected is not for this bench, which takes compliant, primal"],
    );
    refused(
        "bench volume --form primal",
        &["--form primal is not for this bench, which takes corrected, projected"],
    );
    refused(
        "bench grid --form primal",
        &["--form is for `bench volume`, `bench ice`, `bench flag` and `bench fabric`"],
    );
}
