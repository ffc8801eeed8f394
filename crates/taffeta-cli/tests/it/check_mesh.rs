//! What the program says of meshes.

use crate::desk::{Desk, SHEET, ending};
use serde_json::{Value, json};

/// A unit cube of 12 triangles in OBJ lines, vertex 4x + 2y + z; without the two triangles at +x if `open`.
fn cube(open: bool) -> String {
    let bits = |i: u32| [i >> 2 & 1, i >> 1 & 1, i & 1].map(|b| f64::from(b) - 0.5);
    let vertices = (0..8).map(bits).map(|[x, y, z]| format!("v {x} {y} {z}\n"));
    let faces = ["2 4 1", "1 4 3", "5 2 1", "6 2 5", "1 3 5", "3 7 5", "2 8 4", "6 8 2", "4 8 3", "3 8 7"];
    let last = if open { &[][..] } else { &["7 6 5", "8 6 7"] };
    vertices.chain(faces.iter().chain(last).map(|face| format!("f {face}\n"))).collect()
}

fn desk(mesh: &str) -> Desk {
    let desk = Desk::with(SHEET);
    std::fs::write(desk.path("it.obj"), mesh).expect("the mesh is written");
    desk
}

/// The words for the mesh `it.obj`, the complaint, and the exit code.
fn check(desk: &Desk, options: &[&str]) -> (String, String, Option<i32>) {
    ending(desk.taffeta(&[&["check", "it.obj"], options].concat()))
}

fn report(mesh: &str) -> Value {
    let (out, err, code) = check(&desk(mesh), &["--json"]);
    assert_eq!(code, Some(0), "{err}");
    serde_json::from_str(&out).expect("nothing but JSON")
}

/// The scene that the report offers is accepted, and runs.
fn runs_as_offered(desk: &Desk, options: &[&str]) {
    let summary = run_offered(desk, options, "40");
    // It lands, and neither stretches as no cloth does nor passes through itself.
    assert!(summary["contacts_max"].as_u64() > Some(0), "{summary}");
    assert!(summary["max_stretch"].as_f64() < Some(1.2), "{summary}");
    assert_eq!(summary["intersections"]["final"], 0, "{summary}");
}

/// The summary of the scene that is offered for a mesh, run for some frames.
fn run_offered(desk: &Desk, options: &[&str], frames: &str) -> Value {
    let (out, _, _) = check(desk, &[&["--json"], options].concat());
    let report: Value = serde_json::from_str(&out).expect("JSON");
    let scene = report["scene"].as_str().expect("a scene is offered");
    std::fs::write(desk.path("it.toml"), scene).expect("the scene is written");
    let (out, err, code) = ending(desk.taffeta(&["run", "it.toml", "--frames", frames, "--out", "o"]));
    assert_eq!(code, Some(0), "{scene}\n{out}{err}");
    desk.json("o/summary.json")
}

#[test]
fn a_cube_is_counted_measured_and_accepted_as_both() {
    let desk = desk(&cube(false));
    let (out, err, code) = check(&desk, &[]);
    assert_eq!((code, err.as_str()), (Some(0), ""));
    for line in [
        "it.obj: 8 vertices, 12 faces",
        "surface: closed, orientable, Euler characteristic 2, genus 0, 1 component",
        "size: 1.000 × 1.000 × 1.000 m, area 6.000 m², volume 1.000 m³",
        "self-intersections: none",
        "as a shell: accepted",
        "as a body: accepted",
        "kind = \"soft\"",
    ] {
        assert!(out.lines().any(|l| l == line), "no `{line}` in: {out}");
    }
    runs_as_offered(&desk, &[]);
    runs_as_offered(&desk, &["--as", "shell"]);
}

#[test]
fn an_open_body_is_refused_with_its_edges_and_an_offer_to_fill_it() {
    let desk = desk(&cube(true));
    let (out, err, code) = check(&desk, &["--as", "body"]);
    assert_eq!(code, Some(2), "{out}");
    assert_eq!(err, "error: it.obj: refused as a body\n");
    let verdict = "as a body: refused: a soft body needs a closed surface, and this one has 1 hole, 4 boundary edges \
                   (vertices 4–5, 4–6, 5–7, 6–7); --fill-holes here and fill_holes = true in the scene close it";
    assert!(out.lines().any(|line| line == verdict), "{out}");
    assert!(!out.contains("as a shell") && !out.contains("next:"), "{out}");
    let (out, _, code) = check(&desk, &[]);
    assert_eq!(code, Some(0), "without a wish the answer is that for a shell: {out}");
    assert!(out.contains("as a shell: accepted\n") && out.contains("as a body: refused: "), "{out}");
    runs_as_offered(&desk, &[]);
}

#[test]
fn filling_is_offered_only_where_it_gives_a_body() {
    let remedy = |mesh: &str| report(mesh)["body"]["remedy"].as_str().expect("a remedy").to_owned();
    assert!(remedy(&cube(true)).contains("--fill-holes"));
    let flat = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nf 1 2 3 4\n";
    assert!(remedy(flat).starts_with("mend it in a mesh editor"), "a sheet, filled, holds no volume");
    // The edge between vertices 1 and 2 is halved in one face alone.
    let halved = cube(false).replace("f 2 4 1\n", "f 2 4 9\nf 9 4 1\n") + "v -0.5 -0.5 0\n";
    assert!(remedy(&halved).starts_with("mend it in a mesh editor"), "a hole between nodes on a line");
}

#[test]
fn parts_that_touch_at_a_point_are_named_by_vertices_of_their_own_place() {
    let mesh = "v 9 9 9\nv 0 0 0\nv 1 0 0\nv 1 1 0\nv -1 0 0\nv -1 -1 0\nf 2 3 4\nf 2 5 6\n";
    let report = report(mesh);
    assert_eq!((&report["components"], &report["joined_components"]), (&json!(2), &json!(1)));
    assert_eq!(report["bow_ties"]["count"], json!(1));
    assert_eq!(report["largest_components"][1]["vertex"], json!(1));
    assert_eq!(report["boundary_edges"]["first"], json!([[1, 2], [1, 3], [2, 3], [4, 5], [1, 4], [1, 5]]));
}

#[test]
fn as_many_warnings_are_counted_as_are_said() {
    // A corner order that crosses itself is said by the reader, all else by the check.
    let (out, _, _) = check(&desk("v 0 0 0\nv 1 0 0\nv 0 1 0\nv 1 1 0\nf 1 2 3 4\n"), &[]);
    let said = out.lines().filter(|line| line.starts_with("warning: ")).count();
    assert!(said > 1 && out.contains("warning: not simple"), "{out}");
    assert!(out.contains(&format!("as a shell: accepted with {said} warnings\n")), "{out}");
}

#[test]
fn a_scene_refuses_the_same_mesh_in_the_same_words() {
    let desk = desk(&cube(true));
    let scene = "[[body]]\nname = \"b\"\nkind = \"soft\"\nmass = 1.0\nmesh.file = \"it.obj\"\n";
    std::fs::write(desk.path("it.toml"), scene).expect("the scene is written");
    let (_, err, code) = ending(desk.taffeta(&["run", "it.toml"]));
    assert_eq!(code, Some(2));
    let (out, _, _) = check(&desk, &["--as", "body", "--json"]);
    let report: Value = serde_json::from_str(&out).expect("JSON");
    let reason = report["body"]["reason"].as_str().expect("a reason");
    assert!(err.contains(reason) && err.contains("fill_holes = true"), "{err}");
}

#[test]
fn a_fin_is_named_and_a_shell_takes_it_with_a_warning() {
    let fin = cube(false) + "v 2 2 2\nf 2 4 9\n";
    let (out, _, code) = check(&desk(&fin), &["--as", "shell"]);
    assert_eq!(code, Some(0));
    assert!(
        out.contains("\nwarning: not a manifold: 1 edge with more than two triangles, vertices 1–3;"),
        "{out}"
    );
    assert!(out.contains("as a shell: accepted with 1 warning\n"), "{out}");
    let report = report(&fin);
    assert_eq!(report["non_manifold_edges"], json!({"count": 1, "first": [[1, 3]]}));
    assert_eq!(
        (&report["genus"], &report["holes"], &report["open_borders"]),
        (&json!(null), &json!(0), &json!(1))
    );
    let reason = report["body"]["reason"].as_str().expect("refused");
    assert!(reason.contains("has 1 edge with more than two triangles (vertices 1–3)"), "{reason}");
    assert!(!report["body"]["remedy"].as_str().unwrap().contains("fill"), "filling would not do");
}

#[test]
fn a_cavity_counts_against_the_volume_and_parts_are_listed() {
    let inner: String = cube(false)
        .lines()
        .map(|line| match line.split_once(' ').unwrap() {
            ("v", at) => {
                let at = at.split(' ').map(|x| (x.parse::<f64>().unwrap() / 2.0).to_string());
                format!("v {}\n", at.collect::<Vec<_>>().join(" "))
            }
            (_, face) => {
                let mut corners: Vec<String> =
                    face.split(' ').map(|c| (c.parse::<u32>().unwrap() + 8).to_string()).collect();
                corners.reverse();
                format!("f {}\n", corners.join(" "))
            }
        })
        .collect();
    let report = report(&(cube(false) + &inner));
    assert_eq!((&report["volume"], &report["components"]), (&json!(0.875), &json!(2)));
    let part = json!({"triangles": 12, "vertex": 8, "closed": true, "volume": -0.125, "genus": 0});
    assert_eq!(report["largest_components"][1]["volume"], part["volume"]);
    assert_eq!(report["body"]["accepted"], json!(true));
}

#[test]
fn triangles_that_pass_through_each_other_are_counted_and_named() {
    let crossed = "v 0 0 0\nv 1 0 0\nv 0 1 0\nv 0.2 0.2 -1\nv 0.3 0.2 1\nv 0.2 0.3 1\nf 1 2 3\nf 4 5 6\n";
    let report = report(crossed);
    let found = json!({"crossing": 1, "folded": 0, "complete": true, "first": [[[0, 1, 2], [3, 4, 5]]]});
    assert_eq!(report["self_intersections"], found);
    let (out, _, _) = check(&desk(crossed), &[]);
    let words = "1 pair of triangles passes through each other or touches; first (0, 1, 2) and (3, 4, 5)";
    assert!(out.contains(words), "{out}");
}

#[test]
fn a_figure_in_centimetres_gets_a_scale() {
    // A small one is not within the distance that is kept from the floor.
    let small = desk(&cube(false).replace("0.5", "0.01"));
    runs_as_offered(&small, &["--as", "body"]);
    let large = cube(false).replace("0.5", "90");
    let desk = desk(&large);
    let (out, _, code) = check(&desk, &["--as", "body"]);
    assert_eq!(code, Some(0));
    assert!(
        out.contains("if this is a garment or figure it is probably in centimetres: place.scale = 0.01"),
        "{out}"
    );
    assert!(out.contains("\nplace.scale = 0.01\n"), "{out}");
    runs_as_offered(&desk, &[]);
}

#[test]
fn what_is_offered_suits_many_springs_and_a_fabric_of_thin_triangles() {
    let thin = "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 0.5 -0.0001 0\nf 1 2 3\nf 1 3 4\nf 1 5 2\n";
    let thin = desk(thin);
    let (out, _, _) = check(&thin, &[]);
    assert!(out.contains("thin triangles, the thinnest (0, 4, 1) 10000 times as long as high"), "{out}");
    // Slivers are not promised more than a start.
    run_offered(&thin, &[], "3");
    // Two cones on one circle: their tips have 300 springs each.
    let around = |i: u32| {
        let angle = f64::from(i) * std::f64::consts::TAU / 300.0;
        format!("v {} {} 0\n", angle.cos(), angle.sin())
    };
    let faces = (0..300).map(|i| {
        let [here, next] = [i + 3, (i + 1) % 300 + 3];
        format!("f 1 {here} {next}\nf 2 {next} {here}\n")
    });
    let hubs: String =
        std::iter::once("v 0 0 1\nv 0 0 -1\n".to_owned()).chain((0..300).map(around)).chain(faces).collect();
    runs_as_offered(&desk(&hubs), &["--as", "body"]);
}

/// A sheet of squares, cut along one diagonal or along both in turn.
fn squares(alternating: bool) -> String {
    let node = |i: u32| format!("v {} 0 {}\n", f64::from(i % 9) * 0.1, f64::from(i / 9) * 0.1);
    let square = |i: u32| {
        let (row, col) = (i / 8, i % 8);
        let [a, b, c, d] = [0, 1, 9, 10].map(|step| 9 * row + col + step + 1);
        if alternating && (row + col) % 2 == 1 {
            format!("f {a} {c} {d}\nf {a} {d} {b}\n")
        } else {
            format!("f {a} {c} {b}\nf {b} {c} {d}\n")
        }
    };
    (0..81).map(node).chain((0..64).map(square)).collect()
}

#[test]
fn cloth_is_offered_as_a_fabric_and_its_mesh_is_held_against_it() {
    let desk = desk(&squares(false));
    let (out, _, code) = check(&desk, &[]);
    assert_eq!(code, Some(0));
    for line in [
        "bending of a fabric on this mesh: 1.00–1.00 of the fabric's own",
        "material.preset = \"cotton\"",
        "ice.form = \"primal\"",
    ] {
        assert!(out.lines().any(|l| l == line), "no `{line}` in: {out}");
    }
    assert!(!out.contains("springs."), "{out}");
    runs_as_offered(&desk, &[]);
    let factors = report(&squares(true))["bending_factors"].clone();
    let [least, largest] = [0, 1].map(|i| factors[i].as_f64().expect("a number"));
    // Along the squares' sides the mean of sum and fit is exact; across them the sum alone is off by a half, and its energy counts
    // a quarter.
    assert!((least - 1.0).abs() < 1e-9 && (largest - 1.125).abs() < 1e-9, "{least}, {largest}");
}

#[test]
fn what_cannot_be_read_is_refused_as_anything() {
    let desk = desk("v 0 0 0\nf 1 1 9\n");
    for kind in ["body", "shell"] {
        let (out, err, code) = check(&desk, &["--as", kind]);
        assert_eq!((code, out.as_str()), (Some(2), ""));
        assert!(err.starts_with("error: it.obj:2: face 0: vertex index 9"), "{err}");
    }
    let (_, err, code) = ending(desk.taffeta(&["check", "nowhere.ply"]));
    assert!(code == Some(2) && err.contains("nowhere.ply"), "{err}");
}

#[test]
fn a_scene_says_itself_what_its_bodies_are() {
    let desk = Desk::with(SHEET);
    for options in [&["--as", "body"][..], &["--fill-holes"]] {
        let (_, err, code) = ending(desk.taffeta(&[&["check", "scene.toml"], options].concat()));
        assert_eq!(code, Some(2));
        assert!(err.contains(&format!("{} is for meshes", options[0])), "{err}");
    }
}

#[test]
fn the_schema_names_what_the_answer_has() {
    let (out, _, code) = ending(Desk::with(SHEET).taffeta(&["schema", "check"]));
    assert_eq!(code, Some(0));
    let schema: Value = serde_json::from_str(&out).expect("JSON");
    let report = report(&cube(false));
    for key in report.as_object().expect("an object").keys() {
        assert!(schema["properties"][key].is_object(), "{key}");
    }
}
