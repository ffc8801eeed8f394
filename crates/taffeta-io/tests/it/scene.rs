//! Scenes as a user writes them: where errors point, what overrides change, which files are found.

use std::fs;
use std::path::Path;
use taffeta::scene::{
    ConstraintForm, LayerMask, Layers, Mesh, Method, SceneError, Solver, VolumeForm, identity,
};
use taffeta_io::{LoadError, Place, load_scene, parse_scene};

const FLAG: &str = r#"title = "flag"

[time]
frames = 300

[[body]]
name = "flag"
node_mass = 0.1
[body.mesh.grid]
rows = 4
cols = 5
size = [1.0, 2]
[body.springs]
structural = { k = 200.0, d = 0.1 }

[[body]]
name = "ball"
mass = 1.0
mesh = { icosphere = { radius = 0.5, subdivisions = 2 } }

[[collider]]
plane = { point = [0.0, -1.0, 0.0] }
"#;

fn sets(texts: &[&str]) -> Vec<String> {
    texts.iter().map(|text| (*text).to_owned()).collect()
}

fn refused(text: &str, set: &[&str]) -> String {
    parse_scene(text, "s.toml", &sets(set)).expect_err("the scene was accepted").to_string()
}

#[test]
fn a_scene_is_read_with_defaults() {
    let scene = parse_scene(FLAG, "s.toml", &[]).unwrap().scene;
    assert_eq!((scene.title.as_str(), scene.time.frames), ("flag", 300));
    assert_eq!(scene.bodies[0].springs.structural.unwrap().k, 200.0);
    let Mesh::Grid(grid) = &scene.bodies[0].mesh else { panic!("not a grid") };
    assert_eq!(grid.size, [1.0, 2.0]);
    assert!(matches!(scene.bodies[1].mesh, Mesh::Icosphere(_)));
    assert_eq!(scene.colliders[0].plane.unwrap().normal, [0.0, 1.0, 0.0]);
}

#[test]
fn unknown_keys_point_at_the_key_and_offer_the_nearest() {
    let error = refused(&FLAG.replace("cols = 5", "  colz = 5"), &[]);
    assert_eq!(
        error,
        "s.toml:11:3: unknown key `colz` in `body[0].mesh.grid`; did you mean `cols`? Valid here: rows, cols, size"
    );
    let error = refused(&FLAG.replace("[[collider]]", "[[colider]]"), &[]);
    assert!(error.starts_with("s.toml:21:3: unknown key `colider`; did you mean `collider`?"), "{error}");
    let error = refused(&FLAG.replace("icosphere = {", "sphere = {"), &[]);
    assert!(error.starts_with("s.toml:19:10: unknown key `sphere` in `body[1].mesh`"), "{error}");
    let error = refused(&FLAG.replace("mass = 1.0", "kind = \"sofd\""), &[]);
    assert_eq!(
        error,
        "s.toml:18:8: `body[1].kind` cannot be `sofd`; did you mean `soft`? Valid here: cloth, soft"
    );
}

#[test]
fn layers_are_lists_of_numbers_from_0_to_31() {
    let with = |body: &str, collider: &str| {
        FLAG.replace("node_mass = 0.1\n", &format!("node_mass = 0.1\nlayers = {body}\n"))
            + &format!("layers = {collider}\n")
    };
    let text = with("{ memberships = [0, 31], filter = [] }", "{ filter = [3] }");
    let scene = parse_scene(&text, "s.toml", &sets(&["body.ball.layers.filter=[2, 1, 2]"])).unwrap().scene;
    assert_eq!(
        scene.bodies[0].layers,
        Layers { memberships: LayerMask(0x8000_0001), filter: LayerMask::NONE }
    );
    assert_eq!(scene.bodies[1].layers, Layers { filter: LayerMask(0b110), ..Layers::default() });
    assert_eq!(scene.colliders[0].layers, Layers::new(0..32, [3]));
    assert!(
        identity(&scene).contains(r#""layers":{"filter":[],"memberships":[0,31]}"#),
        "{}",
        identity(&scene)
    );
    let wrong = |body: &str| refused(&with(body, "{}"), &[]);
    assert_eq!(
        wrong("{ filter = [1, 32] }"),
        "s.toml:9:25: `body[0].layers.filter[1]` is 32; expected a whole number from 0 to 31"
    );
    assert!(
        wrong("{ memberships = [-1] }")
            .contains("memberships[0]` is -1; expected a whole number from 0 to 31")
    );
    assert!(wrong("{ memberships = 1 }").contains("memberships` is 1; expected a list of layers"));
    assert!(wrong("{ member = [1] }").contains("did you mean `memberships`?"));
}

#[test]
fn columns_count_characters() {
    let error = refused("title = \"größe\"\ntime = { \"ö\" = 1, dt = true }", &[]);
    assert!(error.starts_with("s.toml:2:10: unknown key `ö` in `time`. Valid here: dt"), "{error}");
}

#[test]
fn wrong_values_say_what_was_found_and_what_is_expected() {
    let change = |from: &str, to: &str| refused(&FLAG.replace(from, to), &[]);
    assert_eq!(
        change("k = 200.0", "k = \"stiff\""),
        "s.toml:14:20: `body[0].springs.structural.k` is the text \"stiff\"; expected a number"
    );
    assert_eq!(
        change("rows = 4", "rows = -4"),
        "s.toml:10:8: `body[0].mesh.grid.rows` is -4; expected a whole number from 0 to 4294967295"
    );
    assert!(change("rows = 4", "rows = 4.5").contains("is 4.5; expected a whole number"));
    let two = "s.toml:12:8: `body[0].mesh.grid.size` has 3 entries; expected a list of 2 entries";
    assert_eq!(change("[1.0, 2]", "[1.0, 2, 3]"), two);
    assert_eq!(change("[1.0, 2]", "[1.0]"), two.replace('3', "1"));
    assert_eq!(change("rows = 4\n", ""), "s.toml:9:1: missing key `rows` in `body[0].mesh.grid`");
    assert_eq!(
        change("{ point = [0.0, -1.0, 0.0] }", "[0.0]"),
        "s.toml:22:9: `collider[0].plane` is a list of 1; expected a table"
    );
    assert!(change("cols = 5", "cols = = 5").starts_with("s.toml:11:8: not valid TOML: "));
    assert!(change("subdivisions = 2 }", "subdivisions = 2 }, cube = { size = 1.0 }").contains("has both"));
    assert!(change("frames = 300", "frames = 99999999999999999999").contains("does not fit 64 bits"));
}

#[test]
fn numbers_that_are_not_finite_are_refused_anywhere() {
    for number in ["nan", "-inf", "1e999"] {
        let error = refused(&FLAG.replace("-1.0, 0.0]", &format!("{number}, 0.0]")), &[]);
        assert_eq!(
            error,
            format!("s.toml:22:25: `collider[0].plane.point[1]`: {number} is not a finite number")
        );
    }
    let error = refused(FLAG, &["world.drag=nan"]);
    assert_eq!(error, "world.drag=nan: `world.drag`: nan is not a finite number");
}

#[test]
fn settings_of_a_solver_are_read_with_their_defaults() {
    let solver = |lines: &str| {
        let loaded = parse_scene(&format!("{FLAG}[solver]\n{lines}"), "s.toml", &[]).unwrap();
        loaded.scene.validate().expect("it can be solved");
        (loaded.scene.solver, loaded.notes)
    };
    let (plain, _) = solver("");
    assert_eq!(plain, Solver::default());
    assert_eq!((plain.method, plain.ice.tolerance, plain.ice.max_iterations), (Method::Springs, 1e-3, 200));
    assert_eq!((plain.acad.threshold, plain.acad.epsilon, plain.ice.warm_start), (0.1, 0.3, true));
    let (ice, _) =
        solver("method = \"ice\"\nice = { form = \"printed\", tolerance = 1e-6, warm_start = false }\n");
    assert_eq!((ice.method, ice.ice.form), (Method::Ice, ConstraintForm::Printed));
    assert_eq!((ice.ice.tolerance, ice.ice.warm_start, ice.ice.max_iterations), (1e-6, false, 200));
    let (primal, _) = solver("method = \"ice\"\nice = { form = \"primal\", newton_steps = 2 }\n");
    assert_eq!((primal.ice.form, primal.ice.newton_steps), (ConstraintForm::Primal, 2));
    assert!(primal.is_primal() && plain.ice.newton_steps == 0 && !plain.is_primal());
    let (acad, notes) = solver(
        "method = \"acad\"\n[solver.acad]\ntarget = 0.1\nrelease = 0.1\nepsilon = 0.1\n[solver.ice]\nmax_iterations = 9\n",
    );
    assert_eq!((acad.method, acad.acad.target, acad.acad.release), (Method::Acad, 0.1, 0.1));
    assert_eq!(
        (acad.acad.epsilon, acad.ice.max_iterations, notes),
        (0.1, 9, vec![]),
        "acad uses both tables"
    );
}

#[test]
fn what_a_solver_cannot_be_is_said_at_its_place() {
    let at =
        |table: &str, line: &str| format!("{BALL}[solver]\nmethod = \"acad\"\n[solver.{table}]\n{line}\n");
    let says = |table: &str, line: &str, words: &str| {
        let error = objection(&at(table, line));
        let column = line.find('=').unwrap() + 3;
        assert_eq!(error, format!("s.toml:9:{column}: `solver.{table}.{words}"));
    };
    says("acad", "threshold = 0", "threshold`: is 0, more than 0 would do");
    says("acad", "threshold = -0.1", "threshold`: is -0.1, more than 0 would do");
    says("acad", "release = 0.2", "release`: is 0.2, more than the threshold of 0.1; up to that would do");
    says("acad", "release = -0.1", "release`: is -0.1, 0 or more would do");
    says("acad", "target = 0.11", "target`: is 0.11, more than the threshold of 0.1; up to that would do");
    says("acad", "epsilon = -0.25", "epsilon`: is -0.25, 0 or more would do");
    says("ice", "tolerance = 0", "tolerance`: is 0, more than 0 would do");
    says(
        "ice",
        "tolerance = 1.0",
        "tolerance`: is 1, and the residual is 1 before the first iteration; 0.001 would do",
    );
    says("ice", "max_iterations = 0", "max_iterations`: is 0, 1 or more would do");
    says("ice", "epsilon = -0.5", "epsilon`: is -0.5, 0 or more would do");
    says("ice", "newton_steps = 101", "newton_steps`: is 101, 0 to 100 would do");
    says("ice", "order = 3", "order`: is 3, 1 or 2 would do");
    says(
        "ice",
        "order = 2",
        "order`: is 2, but only the form \"primal\" of the method \"ice\" is of second order in time; 1 would do",
    );
    says(
        "ice",
        "newton_steps = 2",
        "newton_steps`: is 2, but only the form \"primal\" of the method \"ice\" takes Newton steps; 1 would do",
    );
    let primal = |line: &str| {
        let scene = format!("{BALL}[solver]\nmethod = \"ice\"\n[solver.ice]\nform = \"primal\"\n{line}\n");
        objection(&scene)
    };
    assert_eq!(
        primal("epsilon = 0.25"),
        "s.toml:10:11: `solver.ice.epsilon`: is 0.25, and the form \"primal\" has no compliance to add to; 0 would do"
    );
    assert_eq!(
        primal("newton_steps = 101"),
        "s.toml:10:16: `solver.ice.newton_steps`: is 101, 0 to 100 would do"
    );
    let refused = |table: &str, line: &str, words: &str| {
        let error = refused(&at(table, line), &[]);
        assert!(error.starts_with(&format!("s.toml:9:{words}")), "{error}");
    };
    refused(
        "acad",
        "form = \"primal\"",
        "8: `solver.acad.form` cannot be `primal`. Valid here: compliant, printed",
    );
    refused(
        "acad",
        "treshold = 0.1",
        "1: unknown key `treshold` in `solver.acad`; did you mean `threshold`?",
    );
    refused("ice", "max_iterations = -1", "18: ");
    refused("ice", "warm_start = 1", "14: ");
    refused("acad", "release = nan", "11: `solver.acad.release`: nan is not a finite number");
}

const BALL: &str = r#"[[body]]
name = "ball"
kind = "soft"
mass = 1.0
mesh.icosphere = { radius = 0.5, subdivisions = 2 }
"#;

/// What the engine says of a scene that can be read, at its place.
fn objection(text: &str) -> String {
    let loaded = parse_scene(text, "s.toml", &[]).expect("the scene can be read");
    loaded.source.locate(&loaded.scene.validate().expect_err("the scene was accepted")).to_string()
}

#[test]
fn a_volume_is_read_with_all_that_it_may_say() {
    let table = "[body.volume]\nform = \"projected\"\ntarget = 1.5\nweights = { center = [0, 0.5, 0], radius = 0.4 }\n";
    let key = "[[body.volume.motion]]\nt = 1.0\ntarget = 2.0\n";
    let loaded = parse_scene(&format!("{BALL}{table}{key}"), "s.toml", &[]).unwrap();
    let volume = loaded.scene.bodies[0].volume.as_ref().unwrap();
    assert_eq!((volume.form, volume.target, volume.pressure), (VolumeForm::Projected, Some(1.5), None));
    assert_eq!((volume.motion[0].t, volume.motion[0].target), (1.0, Some(2.0)));
    assert_eq!(volume.weights.unwrap().center, [0.0, 0.5, 0.0]);
    loaded.scene.validate().expect("all of it goes together");
    let bare = parse_scene(&format!("{BALL}[body.volume]\n"), "s.toml", &[]).unwrap();
    assert_eq!(bare.scene.bodies[0].volume.as_ref().unwrap().form, VolumeForm::Corrected);
    assert_eq!(parse_scene(BALL, "s.toml", &[]).unwrap().scene.bodies[0].volume, None);
}

#[test]
fn what_a_volume_cannot_be_is_said_at_its_place() {
    let with = |lines: &str| format!("{BALL}[body.volume]\n{lines}");
    assert_eq!(
        refused(&with("form = \"projectd\"\n"), &[]),
        "s.toml:7:8: `body[0].volume.form` cannot be `projectd`; did you mean `projected`? Valid here: corrected, \
         projected, paper-shader, printed, none"
    );
    let error = refused(&with("form = \"none\"\npresure = 1.0\n"), &[]);
    assert!(
        error.starts_with("s.toml:8:1: unknown key `presure` in `body[0].volume`; did you mean `pressure`?"),
        "{error}"
    );
    let begins = |lines: &str, start: &str| {
        let error = objection(&with(lines));
        assert!(error.starts_with(start), "{error}");
    };
    begins("target = 1.0\npressure = 5.0\n", "s.toml:6:1: `body[0].volume`: has a target and a pressure");
    begins("target = -1.0\n", "s.toml:7:10: `body[0].volume.target`: ");
    begins("[[body.volume.motion]]\nt = 1.0\n", "s.toml:7:1: `body[0].volume.motion[0]`: has neither");
    begins(
        "weights = { radius = 0.0, center = [0, 0, 0] }\n",
        "s.toml:7:22: `body[0].volume.weights.radius`: ",
    );
}

#[test]
fn a_cloth_has_no_volume_to_keep() {
    let cloth = |form: &str| {
        format!("{FLAG}[body.volume]\nform = \"{form}\"\n")
            .replace("[[collider]]\nplane = { point = [0.0, -1.0, 0.0] }\n", "")
    };
    let error = objection(&cloth("corrected"));
    assert!(error.starts_with("s.toml:21:1: `body[1].volume`: is for soft bodies"), "{error}");
    let kept_by_nothing = parse_scene(&cloth("none"), "s.toml", &[]).unwrap();
    kept_by_nothing.scene.validate().expect("it asks for nothing");
}

#[test]
fn overrides_go_by_name_or_index_and_make_what_is_missing() {
    let set = sets(&[
        "body.flag.springs.structural.k=500",
        "collider.0.friction=0.1",
        "time.frames=10",
        "world.gravity=[0.0, -1.62, 0.0]",
        "world.gravity.1=-2",
        "body[1].place.position=[0,1,0]",
        "body.ball.springs.hinge.k=2",
        "title=on the moon",
    ]);
    let scene = parse_scene(FLAG, "s.toml", &set).unwrap().scene;
    assert_eq!(scene.bodies[0].springs.structural.unwrap().k, 500.0);
    assert_eq!((scene.colliders[0].friction, scene.time.frames), (0.1, 10));
    assert_eq!(scene.world.gravity, [0.0, -2.0, 0.0]);
    assert_eq!(scene.bodies[1].place.position, [0.0, 1.0, 0.0]);
    assert_eq!((scene.bodies[1].springs.hinge.unwrap().k, scene.title.as_str()), (2.0, "on the moon"));
}

#[test]
fn wrong_overrides_are_named_by_their_text() {
    assert_eq!(
        refused(FLAG, &["body.flagg.mass=1"]),
        "body.flagg.mass=1: no `body` is called `flagg`; did you mean `flag`? Valid here: flag, ball"
    );
    let error = refused(FLAG, &["body.flag.springs.structual.k=5"]);
    assert!(
        error.starts_with(
            "body.flag.springs.structual.k=5: unknown key `structual` in `body[0].springs`; did you mean `structural`?"
        ),
        "{error}"
    );
    let error = refused(FLAG, &["time.frames=ten"]);
    assert!(error.contains("`time.frames` is the text \"ten\"; expected a whole number"), "{error}");
    assert!(refused(FLAG, &["collider.3.friction=1"]).contains("has no element 3; it has 1"));
    assert!(refused(FLAG, &["time.frames.x=1"]).contains("`time.frames` is 300: it has no `x`"));
    assert!(refused(FLAG, &["time.frames"]).contains("has no `=`"));
    let deep = refused(FLAG, &[&format!("title{}=1", ".a".repeat(50_000))]);
    assert!(deep.contains("…: has 50001 steps, 32 are the most") && deep.len() < 500, "{deep}");
    for path in ["", ".", "a..b", "a.", "a[", "a[]", "\"a", "\"a\"b", "a[0]b", "[[["] {
        let error = refused(FLAG, &[&format!("{path}=1")]);
        assert!(error.starts_with(&format!("{path}=1: ")), "{error}");
    }
}

#[test]
fn the_engines_objections_are_found_in_the_file_or_override() {
    let loaded = parse_scene(FLAG, "s.toml", &sets(&["body.ball.mass=-1"])).unwrap();
    let at = |path: &str| loaded.source.locate(&SceneError::new(path, "will not do")).to_string();
    assert_eq!(
        at("body[0].springs.structural.k"),
        "s.toml:14:20: `body[0].springs.structural.k`: will not do"
    );
    assert_eq!(at("body[0].mesh.grid.rows"), "s.toml:10:8: `body[0].mesh.grid.rows`: will not do");
    assert!(at("body[1]").starts_with("s.toml:16:1: "));
    assert!(at("body[0].springs.bend.k").starts_with("s.toml:13:1: "));
    assert_eq!(at("body[1].mass"), "body.ball.mass=-1: `body[1].mass`: will not do");
    for odd in ["", "[", "body[9].x", "a.b.c", "body[0]]]..", "[0][0]"] {
        at(odd);
    }
}

/// A scene in a folder of its own, with a body whose mesh is `mesh`.
fn scene_with(folder: &Path, mesh: &str) -> Result<taffeta_io::Loaded, LoadError> {
    let file = folder.join("scene.toml");
    fs::write(&file, format!("[[body]]\nname = \"b\"\nmass = 1.0\n{mesh}\n")).unwrap();
    load_scene(&file, &[])
}

const TRIANGLE: &str = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";

#[test]
fn meshes_are_found_beside_the_scene_and_in_models_above() {
    let top = tempfile::tempdir().unwrap();
    let scenes = top.path().join("scenes");
    fs::create_dir_all(top.path().join("models")).unwrap();
    fs::create_dir(&scenes).unwrap();
    fs::write(top.path().join("models/far.obj"), TRIANGLE).unwrap();
    fs::write(scenes.join("near.obj"), TRIANGLE).unwrap();
    for name in ["near.obj", "./near.obj", "far.obj"] {
        let loaded = scene_with(&scenes, &format!("mesh = {{ file = \"{name}\" }}")).unwrap();
        let Mesh::Surface(surface) = &loaded.scene.bodies[0].mesh else { panic!("not loaded") };
        assert_eq!(surface.triangles, [[0, 1, 2]]);
    }
}

#[test]
fn no_path_leaves_the_folders() {
    let top = tempfile::tempdir().unwrap();
    let scenes = top.path().join("scenes");
    fs::create_dir(&scenes).unwrap();
    let secret = top.path().join("secret.obj");
    fs::write(&secret, TRIANGLE).unwrap();
    let absolute = secret.display().to_string();
    let mut names = vec!["../secret.obj", "x/../../secret.obj", absolute.as_str(), ""];
    if cfg!(unix) {
        #[cfg(unix)]
        std::os::unix::fs::symlink(&secret, scenes.join("link.obj")).unwrap();
        names.push("link.obj");
    }
    for name in names {
        let mesh =
            format!("mesh = {{ file = {name:?} }}\nstand_in = {{ cube = {{ size = 1.0, divisions = 1 }} }}");
        let error = scene_with(&scenes, &mesh).expect_err(name);
        assert!(matches!(error.place, Place::At { line: 4, column: 17, .. }), "{error}");
        assert!(error.message.contains("TAFFETA_MODELS"), "{error}");
    }
}

#[test]
fn a_folder_in_place_of_a_mesh_is_said_to_be_one() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("bunny.ply")).unwrap();
    let error = scene_with(folder.path(), "mesh = { file = \"bunny.ply\" }").unwrap_err();
    assert!(error.message.contains("`bunny.ply` is a folder; a file would do"), "{error}");
}

#[test]
fn a_missing_mesh_is_refused_or_replaced_by_its_stand_in() {
    let folder = tempfile::tempdir().unwrap();
    let mesh = "mesh = { file = \"bunny.ply\" }";
    let error = scene_with(folder.path(), mesh).unwrap_err();
    assert!(error.message.contains("`bunny.ply` was not found; looked in "), "{error}");
    assert!(error.message.contains("cargo xtask models"), "{error}");
    let stand_in = "stand_in = { icosphere = { radius = 0.5, subdivisions = 4 } }";
    let error = scene_with(
        folder.path(),
        &format!("mesh.grid = {{ rows = 2, cols = 2, size = [1, 1] }}\n{stand_in}"),
    );
    assert!(error.unwrap_err().message.contains("stands in for a mesh file that is not there"));
    let loaded = scene_with(folder.path(), &format!("{mesh}\n{stand_in}")).unwrap();
    assert!(matches!(loaded.scene.bodies[0].mesh, Mesh::Icosphere(_)));
    assert!(loaded.notes[0].starts_with("body `b` uses its stand-in: `bunny.ply` was not found"));
}

#[test]
fn a_file_that_may_be_meant_is_named() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("people")).unwrap();
    fs::write(folder.path().join("people/human.ply"), "").unwrap();
    fs::write(folder.path().join("people/teapot.toml"), "").unwrap();
    let message =
        |name: &str| scene_with(folder.path(), &format!("mesh.file = {name:?}")).unwrap_err().message;
    let near = message("people/humen.ply");
    assert!(
        near.starts_with("`people/humen.ply` was not found; did you mean `people/human.ply`? Looked in "),
        "{near}"
    );
    assert!(message("people/human.obj").contains("did you mean `people/human.ply`?"));
    assert!(message("people/humen.obj").starts_with("`people/humen.obj` was not found; looked in "));
    assert!(message("people/teapot.obj").starts_with("`people/teapot.obj` was not found; looked in "));
}

#[test]
fn a_rest_shape_is_found_as_meshes_are_and_its_errors_point_at_it() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    file("start.obj", TRIANGLE);
    let refused = |rest: &str| {
        let keys = format!("mesh.file = \"start.obj\"\nrest_shape = {rest:?}");
        let error = scene_with(folder.path(), &keys).expect_err(rest);
        assert!(matches!(error.place, Place::At { line: 5, column: 14, .. }), "{error}");
        error.message
    };
    assert!(refused("none.obj").contains("`none.obj` was not found"));
    assert!(refused("../start.obj").contains("not a path inside"));
}

#[test]
fn a_rest_shape_is_read_with_its_mesh() {
    let folder = tempfile::tempdir().unwrap();
    let file = |name: &str, text: &str| fs::write(folder.path().join(name), text).unwrap();
    file("start.obj", TRIANGLE);
    file("broken.obj", "v 0 0\n");
    let keys = "mesh.file = \"start.obj\"\nrest_shape = \"broken.obj\"";
    let error = scene_with(folder.path(), keys).unwrap_err();
    assert!(matches!(error.place, Place::At { line: 5, column: 14, .. }), "{error}");
    assert!(error.message.contains("broken.obj:1: a vertex needs 3 coordinates, found 2"), "{error}");
    file("wide.obj", &TRIANGLE.replace("v 1 0 0", "v 3 0 0"));
    let keys = "mesh.file = \"start.obj\"\nrest_shape = \"wide.obj\"\nfill_holes = true";
    let scene = scene_with(folder.path(), keys).unwrap().scene;
    let Mesh::Surface(surface) = &scene.bodies[0].mesh else { panic!("not loaded") };
    assert_eq!(surface.rest, Some(vec![[[0.0; 3], [3.0, 0.0, 0.0], [0.0, 1.0, 0.0]]]));
    scene.validate().expect("the mesh has what the keys say");
}

#[test]
fn a_stand_in_has_no_rest_shape_and_other_shapes_neither() {
    let folder = tempfile::tempdir().unwrap();
    let keys =
        "mesh.file = \"gone.obj\"\nrest_shape = \"wide.obj\"\nstand_in.chain = { links = 1, length = 1.0 }";
    let loaded = scene_with(folder.path(), keys).unwrap();
    let said =
        "body `b` uses its stand-in, and its rest shape `wide.obj` is not used: `gone.obj` was not found";
    assert!(loaded.notes[0].starts_with(said), "{:?}", loaded.notes);
    loaded.scene.validate().expect("a stand-in has no rest shape");

    let grid =
        scene_with(folder.path(), "mesh.chain = { links = 1, length = 1.0 }\nfill_holes = true").unwrap();
    let error = grid.source.locate(&grid.scene.validate().unwrap_err()).to_string();
    assert!(error.contains("scene.toml:5:14: `body[0].fill_holes`: is for a mesh from a file"), "{error}");
}

#[test]
fn a_mesh_error_points_at_the_scene_and_at_the_mesh() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("bad.obj"), "v 0 0\n").unwrap();
    let error = scene_with(folder.path(), "mesh.file = \"bad.obj\"").unwrap_err().to_string();
    assert!(error.contains("scene.toml:4:13: "), "{error}");
    assert!(error.ends_with("bad.obj:1: a vertex needs 3 coordinates, found 2"), "{error}");
}

#[test]
fn struts_come_from_their_file() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("struts.txt"), "# a\n0 5\n").unwrap();
    let text =
        "mesh.cube = { size = 1.0, divisions = 1 }\nsprings.internal = { file = \"struts.txt\", k = 1.0 }";
    let loaded = scene_with(folder.path(), text).unwrap();
    assert_eq!(loaded.scene.bodies[0].springs.internal.as_ref().unwrap().pairs, Some(vec![[0, 5]]));
    let at = |path: &str| loaded.source.locate(&SceneError::new(path, "has no length")).to_string();
    assert!(at("body[0].springs.internal.pairs[0]").ends_with("struts.txt:2:1: has no length"));
    assert!(at("body[0].springs.internal.pairs[1]").contains("scene.toml:5:"), "there is no such line");
}

#[test]
fn a_scene_too_long_to_be_read_is_refused_before_it_is() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.toml");
    fs::write(&file, "[".repeat(10_000_001)).unwrap();
    let error = load_scene(&file, &[]).unwrap_err();
    assert!(error.message.starts_with("has more than 10000000 bytes"), "{error}");
}

#[test]
fn a_scene_that_is_not_text_names_the_place() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("s.toml");
    fs::write(&file, b"title = 'a'\n# \xff").unwrap();
    let error = load_scene(&file, &[]).unwrap_err().to_string();
    assert!(error.ends_with("s.toml:2:3: is not UTF-8 from here on; save the file as UTF-8"), "{error}");
    assert!(
        load_scene(&folder.path().join("none.toml"), &[]).unwrap_err().message.contains("cannot be read")
    );
}
