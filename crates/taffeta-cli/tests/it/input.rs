//! What the program answers to bad input, and its smaller commands.

use crate::desk::{BALL, Desk, SHEET, ending};

/// Asserts that the words are refused with exit code 2 and a message with all of `parts`.
fn refused(desk: &Desk, words: &[&str], parts: &[&str]) {
    let (_, err, code) = ending(desk.taffeta(words));
    assert_eq!(code, Some(2), "{words:?}: {err}");
    assert!(err.starts_with("error: "), "{words:?}: {err}");
    for part in parts {
        assert!(err.contains(part), "{words:?}: no `{part}` in: {err}");
    }
}

#[test]
fn what_is_not_there_yet_is_refused_by_name() {
    let desk = Desk::with(SHEET);
    refused(&desk, &["run", "scene.toml", "--format", "gif"], &["npy"]);
}

#[test]
fn the_report_on_the_papers_is_found_by_its_new_command() {
    let desk = Desk::with(SHEET);
    let words = ["reproduce", "s1", "--out", "report", "--quick"];
    refused(&desk, &words, &["cargo run --release -p taffeta-papers -- s1 --out report --quick\n"]);
    refused(&desk, &["reproduce"], &["-p taffeta-papers -- all --out DIR"]);
}

#[test]
fn usage_errors_exit_with_2() {
    let desk = Desk::with(SHEET);
    for words in [
        &["run"][..],
        &["run", "scene.toml", "--threads", "0"],
        &["run", "scene.toml", "--frames", "0"],
        &["walk"],
        &["schema", "mesh"],
    ] {
        refused(&desk, words, &[]);
    }
    refused(&desk, &["bench", "grid", "--rows", "8"], &["--cols"]);
    refused(&desk, &["bench", "grid", "--mesh", "a.ply"], &["bench mesh"]);
}

#[test]
fn an_unknown_key_is_named_with_its_place_and_the_nearest_name() {
    let desk = Desk::with(&SHEET.replace("structural", "strctural"));
    refused(&desk, &["run", "scene.toml"], &["scene.toml:12:1", "strctural", "structural"]);
    refused(&desk, &["check", "scene.toml"], &["scene.toml:12:1"]);
    assert!(!desk.path("out").exists(), "nothing is written for a scene that is refused");
}

#[test]
fn an_impossible_value_is_named_with_its_place() {
    let desk = Desk::with(&SHEET.replace("node_mass = 0.01", "node_mass = -1.0"));
    refused(&desk, &["run", "scene.toml"], &["scene.toml:9:", "node_mass"]);
    refused(&Desk::with(SHEET), &["run", "scene.toml", "--set", "body.sheet.node_mass=-1"], &["--set"]);
    refused(&Desk::with(SHEET), &["run", "scene.toml", "--set", "body.shet.node_mass=1"], &["sheet"]);
    refused(&Desk::with(SHEET), &["run", "nowhere.toml"], &["nowhere.toml"]);
    refused(&Desk::with("title = "), &["run", "scene.toml"], &["scene.toml:1:"]);
    refused(&Desk::with(""), &["run", "scene.toml"], &["body"]);
}

#[test]
fn check_counts_and_measures_the_step() {
    let desk = Desk::with(BALL);
    let (out, err, code) = ending(desk.taffeta(&["check", "scene.toml"]));
    assert_eq!(code, Some(0), "{err}");
    for part in [
        "162 nodes",
        "320 triangles",
        "480 structural",
        "closed, volume",
        "sub-steps a frame: 17",
        "accepted",
    ] {
        assert!(out.contains(part), "no `{part}` in: {out}");
    }
    assert!(out.contains("at rest") && out.contains("however the springs are folded"), "{out}");
    let (out, _, _) = ending(desk.taffeta(&["check", "scene.toml", "--json"]));
    let report: serde_json::Value = serde_json::from_str(&out).expect("nothing but JSON");
    assert_eq!(report["bodies"][0]["springs"][0], serde_json::json!({"kind": "structural", "count": 480}));
    assert!(report["memory_bytes"].as_u64().unwrap() > 162 * 24);
    assert!(report["largest_stable_step"].as_f64().unwrap() > report["step"].as_f64().unwrap());
}

#[test]
fn check_takes_values_as_run_does() {
    let desk = Desk::with(&BALL.replace("title = \"Ball\"\n", ""));
    let fewer = "body.ball.mesh.icosphere.subdivisions=1";
    let (out, err, code) = ending(desk.taffeta(&["check", "scene.toml", "--set", fewer]));
    assert_eq!(code, Some(0), "{err}");
    assert!(out.starts_with("scene.toml: untitled scene\n") && out.contains("42 nodes"), "{out}");
    assert!(out.contains(" kB\n") && !out.contains("0.0 MB"), "{out}");
    let (out, _, _) = ending(desk.taffeta(&["check", "scene.toml", "--set", "title=Small", "--set", fewer]));
    assert!(out.starts_with("scene.toml: Small\n") && out.contains("42 nodes"), "{out}");
    refused(&desk, &["check", "scene.toml", "--set", "body.bal.mass=1"], &["--set", "`ball`"]);
    refused(&desk, &["check", "ball.ply", "--set", "title=Small"], &["--set is for scenes", "ball.ply"]);
}

#[test]
fn check_describes_colliders_and_what_was_repaired_in_them() {
    // A tetrahedron whose faces have vertices of their own, and without its last face.
    let faces = ["1 2 3", "1 4 2", "2 4 3", "3 4 1"];
    let corners = ["v 0 0 0", "v 0.1 0 0", "v 0 0 0.1", "v 0 0.1 0"];
    let soup = |faces: &[&str]| {
        let lines = faces.iter().enumerate().map(|(i, face)| {
            let vertices = face.split(' ').map(|vertex| corners[vertex.parse::<usize>().unwrap() - 1]);
            format!(
                "{}\nf {} {} {}\n",
                vertices.collect::<Vec<_>>().join("\n"),
                3 * i + 1,
                3 * i + 2,
                3 * i + 3
            )
        });
        lines.collect::<String>()
    };
    let scene = format!(
        "{SHEET}[[collider]]\nname = \"stone\"\nmesh.file = \"stone.obj\"\nplace.position = [0, -2, 0]\n\
         motion = [{{ t = 1.0, translate = [0, 1, 0] }}]\n[[collider]]\nsphere.radius = 0.1\nplace.position = [0, -9, 0]\n"
    );
    let desk = Desk::with(&scene);
    let check = |faces: &[&str]| {
        std::fs::write(desk.path("stone.obj"), soup(faces)).unwrap();
        ending(desk.taffeta(&["check", "scene.toml"])).0
    };
    let whole = check(&faces);
    let said = "\ncollider `stone`: mesh, 4 triangles, closed: solid, 1 keyframe\n  repaired: welded 12 vertices into 4";
    assert!(whole.contains(said) && whole.contains("\ncollider `collider1`: sphere\n"), "{whole}");
    let open = check(&faces[..3]);
    assert!(
        open.contains("\ncollider `stone`: mesh, 3 triangles, open: a sheet with two sides, 1 keyframe\n"),
        "{open}"
    );
    let (out, _, code) = ending(desk.taffeta(&["run", "scene.toml", "--frames", "1", "--out", "out"]));
    assert!(
        code == Some(0) && out.contains("  collider stone: mesh\n    repaired: welded 9 vertices"),
        "{out}"
    );
}

#[test]
fn check_says_how_many_nodes_are_held() {
    let of = |scene: &str| ending(Desk::with(scene).taffeta(&["check", "scene.toml"])).0;
    assert!(of(SHEET).contains("\n  pinned: 2\n"));
    assert!(!of(BALL).contains("pinned"));
    let all = of(&SHEET.replace("nodes = [0, 6]", "rows = [0, 4]"));
    assert!(all.contains("\n  pinned: 35, all of them: nothing moves freely\n"), "{all}");
    assert!(all.contains("largest stable step: any; no spring pulls on a free node"), "{all}");
}

#[test]
fn check_warns_of_a_step_that_is_too_long() {
    let desk = Desk::with(&SHEET.replace("k = 100.0", "k = 1e6"));
    let (out, _, code) = ending(desk.taffeta(&["check", "scene.toml"]));
    assert_eq!(code, Some(0));
    assert!(out.contains("advice: ") && out.contains("time.max_step"), "{out}");
}

/// A sheet whose rows hang from the first, in long steps.
fn curtain(method: &str) -> Desk {
    let changes = [
        ("nodes = [0, 6]", "rows = [0, 0]"),
        ("rows = 5, cols = 7, size = [0.6, 0.4]", "rows = 4, cols = 7, size = [0.6, 0.3]"),
        ("max_step = 0.002", "max_step = 0.08"),
        ("dt = 0.01", "dt = 0.08"),
        ("structural = { k = 100.0, d = 0.05 }", "structural.k = 1e6"),
        ("shear = { k = 50.0, d = 0.05 }", ""),
    ];
    let sheet = changes.into_iter().fold(SHEET.to_owned(), |sheet, (from, to)| sheet.replace(from, to));
    Desk::with(&format!("{sheet}[solver]\nmethod = \"{method}\"\n"))
}

#[test]
fn check_says_how_hard_implicit_springs_are_pulled_by_what_hangs() {
    let (out, err, code) = ending(curtain("ice").taffeta(&["check", "scene.toml"]));
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("largest stable step: any; springs are implicit"), "{out}");
    // Three rows at 0.1 m hang from the first, which gives (3·3 − 2)/4 g/L.
    assert!(out.contains("T/(m L) = 171.7 1/s²; h² T/(m L) = 1.099"), "{out}");
    assert!(out.contains("advice: ") && out.contains("max_step = 7.6e-2 or less"), "{out}");
    let (out, _, _) = ending(curtain("ice").taffeta(&["check", "scene.toml", "--json"]));
    let report: serde_json::Value = serde_json::from_str(&out).expect("nothing but JSON");
    assert_eq!(
        (&report["method"], &report["largest_stable_step"]),
        (&"ice".into(), &serde_json::Value::Null)
    );
    let hanging = &report["hanging"];
    assert_eq!(hanging["body"], "sheet");
    for (key, expected) in
        [("rate", 171.675), ("growth", 1.098_72), ("largest_step", 0.076_321), ("pull", 0.294_3)]
    {
        let got = hanging[key].as_f64().expect(key);
        assert!((got - expected).abs() < 1e-4 * expected, "{key}: {got}, expected {expected}");
    }
}

#[test]
fn check_says_which_springs_stay_explicit() {
    let (out, _, _) = ending(curtain("acad").taffeta(&["check", "scene.toml"]));
    assert!(out.contains("(springs below the threshold are explicit)") && out.contains("hanging: "), "{out}");
    assert!(!out.contains("bend springs"), "acad is not warned for what hangs: {out}");
    let (out, _, _) = ending(curtain("springs").taffeta(&["check", "scene.toml", "--json"]));
    let report: serde_json::Value = serde_json::from_str(&out).expect("nothing but JSON");
    assert_eq!((&report["method"], &report["hanging"]), (&"springs".into(), &serde_json::Value::Null));
}

#[test]
fn springs_solved_for_by_nodes_have_no_longest_step_but_levels() {
    let primal = curtain("ice\"\nice.form = \"primal");
    let (out, err, code) = ending(primal.taffeta(&["check", "scene.toml"]));
    assert_eq!(code, Some(0), "{err}");
    assert!(
        out.contains("largest stable step: any; springs are implicit along and across themselves"),
        "{out}"
    );
    // 4 × 7 nodes: rows and columns that go in halves.
    assert!(out.contains("coarser levels: 12 nodes"), "{out}");
    assert!(!out.contains("hanging") && !out.contains("advice"), "{out}");
    let (out, _, _) = ending(primal.taffeta(&["check", "scene.toml", "--json"]));
    let report: serde_json::Value = serde_json::from_str(&out).expect("nothing but JSON");
    assert_eq!((&report["form"], &report["hanging"]), (&"primal".into(), &serde_json::Value::Null));
    assert_eq!(report["bodies"][0]["levels"], serde_json::json!([12]));
    let (out, _, code) = ending(primal.taffeta(&["run", "scene.toml"]));
    assert!(code == Some(0) && !out.contains("warning"), "{out}");
    // Both of the others name it.
    for (method, words) in [("ice", "h² T/(m L)"), ("springs", "will blow up")] {
        let (out, _, _) = ending(curtain(method).taffeta(&["check", "scene.toml"]));
        assert!(out.contains(words) && out.contains("ice.form = \"primal\""), "{out}");
    }
}

#[test]
fn run_warns_in_one_line_of_a_step_too_long_for_what_hangs() {
    let (out, _, _) = ending(curtain("ice").taffeta(&["run", "scene.toml", "--frames", "1"]));
    let warnings: Vec<&str> = out.lines().filter(|line| line.starts_with("warning: ")).collect();
    assert!(matches!(warnings[..], [one] if one.contains("h² T/(m L) is 1.10")), "{out}");
}

#[test]
fn schemas_are_json_and_know_the_contract_s_names() {
    let desk = Desk::with(SHEET);
    for (format, key) in [("scene", "body"), ("summary", "state_hash")] {
        let (out, _, code) = ending(desk.taffeta(&["schema", format]));
        assert_eq!(code, Some(0));
        assert!(!out.contains("```"), "{format}: an example in Rust");
        let schema: serde_json::Value = serde_json::from_str(&out).expect("JSON");
        assert!(schema["properties"][key].is_object(), "{key}");
    }
}

#[test]
fn info_names_the_build() {
    let (out, _, code) = ending(Desk::with(SHEET).taffeta(&["info"]));
    assert_eq!(code, Some(0));
    assert!(out.starts_with("taffeta ") && out.contains("\nthreads: "), "{out}");
}

#[test]
fn every_bench_prints_one_line_with_the_contract_s_fields() {
    let desk = Desk::with(SHEET);
    let cases: [&[&str]; 4] = [
        &["grid", "--n", "8"],
        &["drape", "--rows", "6", "--cols", "9"],
        &["mesh", "--n", "1000"],
        &["contact", "--n", "8"],
    ];
    for words in cases {
        let words = [&["bench"], words, &["--frames", "2", "--threads", "1", "--json"]].concat();
        let mut command = desk.taffeta(&words);
        command.env_remove("TAFFETA_MODELS");
        let (out, err, code) = ending(command);
        assert_eq!(code, Some(0), "{err}");
        assert_eq!(out.lines().count(), 1, "{out}");
        let line: serde_json::Value = serde_json::from_str(&out).expect("JSON");
        assert_eq!((&line["bench"], &line["backend"]), (&words[1].into(), &"cpu".into()));
        assert_eq!(line["substeps_per_frame"], 34);
        for path in ["/nodes", "/springs", "/ms_per_frame/min", "/ms_per_frame/median", "/ms_per_frame/max"] {
            assert!(line.pointer(path).is_some_and(serde_json::Value::is_number), "{path}");
        }
        for path in ["/limits/memory_gb_per_s", "/limits/fma_gflop_per_s", "/limits/memory_fraction"] {
            assert!(line.pointer(path).is_some_and(serde_json::Value::is_number), "{path}");
        }
        assert!(line["particle_substeps_per_s"].is_number() && line["springs_per_s"].is_number());
    }
}

/// Two sheets and two colliders; the second of each is in layer 1 alone, and meets that alone.
#[test]
fn a_check_names_what_layers_keep_apart() {
    let desk = Desk::with(
        r#"
[[body]]
name = "shirt"
mesh.grid = { rows = 4, cols = 4, size = [0.3, 0.3] }
material.preset = "cotton"
layers = { memberships = [0], filter = [0] }
[[body]]
name = "cape"
mesh.grid = { rows = 4, cols = 4, size = [0.3, 0.3] }
material.preset = "cotton"
place.position = [0.0, 1.0, 0.0]
layers = { memberships = [1], filter = [1] }
[[collider]]
name = "arm"
sphere = { center = [0.0, -1.0, 0.0], radius = 0.1 }
layers = { memberships = [0, 1], filter = [0] }
[[collider]]
name = "lost"
sphere = { center = [0.0, -2.0, 0.0], radius = 0.1 }
layers = { memberships = [2], filter = [2] }
[[collider]]
name = "floor"
plane = { point = [0.0, -3.0, 0.0] }
"#,
    );
    let (out, err, code) = ending(desk.taffeta(&["check", "scene.toml"]));
    assert_eq!(code, Some(0), "{err}");
    let of = |name: &str| -> Vec<&str> {
        let after = out.lines().skip_while(|line| !line.contains(&format!("`{name}`: "))).skip(1);
        after.take_while(|line| line.starts_with("  ")).filter(|line| line.starts_with("  layers")).collect()
    };
    assert_eq!(
        of("shirt"),
        ["  layers: does not meet body `cape`", "  layers: does not meet collider `lost`"]
    );
    assert_eq!(
        of("cape"),
        ["  layers: does not meet body `shirt`", "  layers: does not meet colliders `arm`, `lost`"]
    );
    assert_eq!(of("arm"), ["  layers: does not meet body `cape`"]);
    assert_eq!(of("lost"), ["  layers: meets no body"]);
    assert!(of("floor").is_empty(), "{out}");
    let (out, _, _) = ending(desk.taffeta(&["check", "scene.toml", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&out).unwrap();
    assert_eq!(json["bodies"][1]["does_not_meet"]["colliders"], serde_json::json!(["arm", "lost"]));
    assert_eq!(json["colliders"][2]["does_not_meet"], serde_json::json!([]));
}
