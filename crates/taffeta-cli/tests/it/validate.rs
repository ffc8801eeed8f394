//! `taffeta validate` as a user runs it.

use crate::desk::{Desk, ending};
use serde_json::Value;
use std::fs;

/// The quick form of all groups: theory holds on turned grids, equilateral and irregular meshes, for both solvers.
#[test]
fn cloth_is_as_theory_says() {
    let desk = Desk::with("");
    let (said, complaints, code) =
        ending(desk.taffeta(&["validate", "--quick", "--no-gpu", "--out", "report"]));
    assert_eq!(code, Some(0), "{said}{complaints}");
    assert!(said.contains("cantilever") && said.contains("report.html"), "{said}");
    let report: Value = desk.json("report/report.json");
    let groups = report["groups"].as_array().unwrap();
    assert_eq!(groups.len(), 8);
    for group in groups {
        let rows = group["rows"].as_array().unwrap();
        assert!(!rows.is_empty(), "{} has no rows", group["name"]);
        let scene = desk.path("report").join(rows[0]["scene"].as_str().unwrap());
        assert!(scene.is_file(), "{} is not there", scene.display());
    }
    let page = fs::read_to_string(desk.path("report/report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("drop/reach"));
}

#[test]
fn unknown_tests_are_refused_with_the_names_that_there_are() {
    let desk = Desk::with("");
    let (_, said, code) = ending(desk.taffeta(&["validate", "cantilevers"]));
    assert_eq!(code, Some(2), "{said}");
    assert!(
        said.contains("no tests `cantilevers`; cantilever, buckling") && said.contains("would do"),
        "{said}"
    );
}
