//! The papers' kernels by the clock; a software adapter serves.

use super::desk::Desk;
use serde_json::Value;

/// What a command prints, what it complains of, and its exit code.
fn ending(words: &str) -> (String, String, Option<i32>) {
    let output = Desk::new().papers(&words.split(' ').collect::<Vec<_>>()).output().expect("it runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (text(&output.stdout), text(&output.stderr), output.status.code())
}

fn lines(words: &str) -> Vec<Value> {
    let (out, err, code) = ending(words);
    assert_eq!(code, Some(0), "{err}");
    out.lines().map(|line| serde_json::from_str(line).expect("a line of JSON")).collect()
}

fn number(line: &Value, path: &str) -> f64 {
    line.pointer(path).and_then(Value::as_f64).unwrap_or_else(|| panic!("{path}: {line}"))
}

#[test]
fn the_solver_of_2021_prints_a_line_for_each_product() {
    let lines = lines("kernels ice --n 12 --frames 30");
    let kernels: Vec<_> = lines.iter().map(|line| line["kernels"].as_str().expect("a name")).collect();
    assert_eq!(kernels, ["engine", "printed", "csr", "ell", "matrix-free"]);
    for (index, line) in lines.iter().enumerate() {
        assert_eq!((&line["bench"], &line["backend"]), (&"ice".into(), &"gpu".into()));
        // 264 along rows and columns, 242 across, 240 two apart.
        assert_eq!((&line["nodes"], &line["springs"]), (&144.into(), &746.into()));
        assert_eq!((&line["substeps_per_frame"], &line["frames"]), (&1.into(), &30.into()));
        assert!(number(line, "/ms_per_frame/median") > 0.0 && number(line, "/steps_per_s") > 0.0);
        if index > 0 {
            // Its iterations are counted beforehand, and the equations have no solution.
            assert_eq!(line["iterations"], 10);
            assert!(number(line, "/residual") > 0.01);
        }
    }
}

#[test]
fn the_kernels_of_both_papers_are_set_beside_the_engine_s() {
    let lines = lines("kernels grid --rows 20 --cols 33 --frames 2");
    let kernels: Vec<_> = lines.iter().map(|line| line["kernels"].as_str().expect("a name")).collect();
    assert_eq!(kernels, ["engine", "plain", "node-centric", "spring-centric"]);
    for line in &lines {
        assert_eq!((&line["nodes"], &line["substeps_per_frame"]), (&660.into(), &34.into()));
    }
}

#[test]
fn kernels_that_do_not_fit_are_refused() {
    let refused = |words: &str, parts: &[&str]| {
        let (_, err, code) = ending(words);
        assert_eq!(code, Some(2), "{words}: {err}");
        assert!(parts.iter().all(|part| err.contains(part)), "{words}: {err}");
    };
    refused("kernels ice --kernels plain", &["--kernels plain has no constraints"]);
    refused("kernels grid --kernels csr", &["--kernels csr is for `ice`"]);
    refused("kernels ice --n 36 --kernels printed", &["7418 springs", "7000 springs (49000000 threads)"]);
}
