//! `taffeta run` as a user: files, numbers, endings.

use crate::desk::{BALL, Desk, SHEET, ending};

#[test]
fn a_run_leaves_whole_files_with_the_start_as_frame_0() {
    let desk = Desk::with(SHEET);
    let (out, err, code) = ending(desk.taffeta(&["run", "scene.toml"]));
    assert_eq!(code, Some(0), "{err}");
    assert!(out.starts_with("Small sheet\n  sheet: 35 nodes, 106 springs\n"), "{out}");
    assert!(out.contains("(cpu: the scene is too small to gain by a GPU)"), "{out}");
    assert_eq!(desk.files("out/scene"), ["frames.csv", "positions.npy", "summary.json"]);
    let (header, bytes) = desk.npy("out/scene/positions.npy");
    assert!(header.contains("'<f4'") && header.contains("(5, 35, 3)"), "{header}");
    assert_eq!(bytes, 5 * 35 * 3 * 4);
    let table = std::fs::read_to_string(desk.path("out/scene/frames.csv")).unwrap();
    assert_eq!(table.lines().count(), 1 + 5);
}

#[test]
fn every_format_writes_its_file() {
    let desk = Desk::with(BALL);
    let words = [
        "run",
        "scene.toml",
        "--out",
        "o",
        "--frames",
        "1",
        "--quiet",
        "--format",
        "npy,pc2,usda,ply,obj,vtu,gltf",
    ];
    let (out, err, code) = ending(desk.taffeta(&words));
    assert_eq!((out.as_str(), err.as_str(), code), ("", "", Some(0)));
    let expected =
        "ball.obj ball.pc2 ball.ply frames.csv positions.npy scene.glb scene.pvd scene.usda summary.json vtu";
    assert_eq!(desk.files("o").join(" "), expected);
    assert_eq!(desk.files("o/vtu"), ["ball_000000.vtu", "ball_000001.vtu"]);
    // The next run into the same folder writes all of it again.
    desk.taffeta(&words).assert().success();
    assert_eq!(desk.files("o").join(" "), expected);
    // What the next run does not write goes.
    desk.taffeta(&["run", "scene.toml", "--out", "o", "--frames", "1", "--quiet"]).assert().success();
    assert_eq!(desk.files("o"), ["frames.csv", "positions.npy", "summary.json"]);
}

#[test]
fn double_precision_writes_doubles() {
    let desk = Desk::with(SHEET);
    let (_, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o", "--precision", "f64"]));
    assert_eq!(code, Some(0), "{err}");
    let (header, bytes) = desk.npy("o/positions.npy");
    assert!(header.contains("'<f8'"), "{header}");
    assert_eq!(bytes, 5 * 35 * 3 * 8);
    assert_eq!(desk.json("o/summary.json")["precision"], "f64");
}

#[test]
fn the_summary_has_the_contract_s_fields_and_is_what_json_prints() {
    let desk = Desk::with(BALL);
    let (out, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o", "--json"]));
    assert_eq!(code, Some(0), "{err}");
    let printed: serde_json::Value = serde_json::from_str(&out).expect("nothing but JSON");
    let summary = desk.json("o/summary.json");
    assert_eq!(printed, summary);
    for (key, value) in
        [("scene", "scene.toml"), ("status", "done"), ("backend", "cpu"), ("precision", "f32")]
    {
        assert_eq!(summary[key], value);
    }
    for (key, value) in [
        ("frames", 12),
        ("substeps", 17),
        ("substeps_max", 17),
        ("nodes", 162),
        ("vertices", 162),
        ("springs", 480),
    ] {
        assert_eq!(summary[key], value, "{key}");
    }
    assert_eq!(summary["triangles"], 320);
    for key in ["dt", "wall_ms_per_frame", "particle_substeps_per_s", "max_stretch", "largest_stable_step"] {
        assert!(summary[key].as_f64().is_some_and(|number| number > 0.0), "{key}");
    }
    for path in ["/energy/start", "/energy/end", "/energy/max", "/momentum/2", "/angular_momentum/2"] {
        assert!(summary.pointer(path).is_some_and(serde_json::Value::is_number), "{path}");
    }
    for key in ["contacts", "contacts_max", "threads"] {
        assert!(summary[key].is_u64(), "{key}");
    }
    assert_eq!(
        summary["solver"],
        serde_json::json!({
            "iterations": 0, "mean_iterations": 0.0, "residual": 0.0, "active_fraction": 0.0,
            "mean_active_fraction": 0.0, "capped": 0
        })
    );
    let volume = &summary["bodies"][0]["volume"];
    let ball = 4.0 / 3.0 * std::f64::consts::PI * 0.2_f64.powi(3);
    assert!((volume["rest"].as_f64().unwrap() / ball - 1.0).abs() < 0.05);
    assert!(volume["final"].is_number() && volume["max_rel_error"].is_number());
    let hash = summary["state_hash"].as_str().unwrap();
    assert!(hash.len() == 16 && hash.chars().all(|digit| digit.is_ascii_hexdigit()), "{hash}");
}

#[test]
fn a_kept_volume_is_told_with_its_form_and_target() {
    let desk = Desk::with(
        &format!("{BALL}[body.volume]\n").replace("[[collider]]\nplane = {}\n[body.volume]", "[body.volume]"),
    );
    let run = |sets: &[&str]| {
        let mut command = desk.taffeta(&["run", "scene.toml", "--out", "o", "--backend", "cpu"]);
        command.args(sets.iter().flat_map(|set| ["--set", set]));
        let (out, err, code) = ending(command);
        assert_eq!(code, Some(0), "{err}");
        (desk.json("o/summary.json")["bodies"][0]["volume"].clone(), out)
    };
    let error = |volume: &serde_json::Value| volume["max_rel_error"].as_f64().unwrap();
    let (kept, out) = run(&[]);
    assert_eq!((&kept["form"], &kept["target"]), (&"corrected".into(), &kept["rest"]));
    assert!(error(&kept) < 1e-3 && !out.contains("warning"), "{kept} {out}");
    let (grown, _) = run(&["body.ball.volume.target=1.05"]);
    assert!((grown["target"].as_f64().unwrap() / kept["rest"].as_f64().unwrap() - 1.05).abs() < 1e-9);
    assert!(error(&grown) < 1e-3, "the error is that to the target: {grown}");
    let (free, _) = run(&["body.ball.volume.form=none"]);
    assert_eq!((&free["form"], &free["target"]), (&serde_json::Value::Null, &serde_json::Value::Null));
    let (pressed, _) = run(&["body.ball.volume.pressure=5"]);
    assert_eq!((&pressed["form"], &pressed["target"]), (&serde_json::Value::Null, &serde_json::Value::Null));
    assert!(error(&pressed) > 1e-4, "under a pressure it is that to rest: {pressed}");
}

#[test]
fn a_volume_that_could_not_be_kept_is_spoken_of() {
    let held = "[[body.pin]]\nselect = { box = { min = [-9, -9, -9], max = [9, 9, 9] } }\n[body.volume]\n";
    let key = "[[body.volume.motion]]\nt = 0.1\ntarget = 1.5\n";
    let scene = format!("{}{held}{key}", BALL.replace("[[collider]]\nplane = {}\n", ""));
    let desk = Desk::with(&scene);
    let (out, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o", "--backend", "cpu"]));
    assert_eq!(code, Some(0), "{err}");
    // One over one and a half is a third less.
    assert!(
        out.contains(
            "warning: body `ball` was off its target volume by 33.33 % in frame 6: most likely nodes"
        ),
        "{out}"
    );
}

#[test]
fn an_open_body_has_no_volume() {
    let desk = Desk::with(SHEET);
    desk.taffeta(&["run", "scene.toml", "--out", "o", "--frames", "1", "--quiet"]).assert().success();
    let summary = desk.json("o/summary.json");
    assert_eq!(summary["bodies"][0]["volume"], serde_json::Value::Null);
    assert_eq!(summary["frames"], 1);
    assert!(desk.npy("o/positions.npy").0.contains("(2, 35, 3)"));
}

#[test]
fn any_number_of_threads_gives_the_same_bits() {
    for scene in [SHEET, BALL] {
        let desk = Desk::with(scene);
        let run = |threads: &str| {
            let out = format!("o{threads}");
            let words = ["run", "scene.toml", "--out", &out, "--threads", threads, "--quiet"];
            desk.taffeta(&words).assert().success();
            let positions = std::fs::read(desk.path(&format!("{out}/positions.npy"))).unwrap();
            (desk.json(&format!("{out}/summary.json"))["state_hash"].clone(), positions)
        };
        let one = run("1");
        for threads in ["2", "3", "8"] {
            assert!(run(threads) == one, "{threads} threads differ from one");
        }
    }
}

#[test]
fn set_changes_a_value_by_the_body_s_name() {
    let desk = Desk::with(SHEET);
    let stretch = |out: &str, sets: &[&str]| {
        let mut command = desk.taffeta(&["run", "scene.toml", "--out", out, "--quiet"]);
        for set in sets {
            command.args(["--set", set]);
        }
        command.assert().success();
        desk.json(&format!("{out}/summary.json"))["max_stretch"].as_f64().unwrap()
    };
    let stiff = stretch("stiff", &[]);
    let soft = stretch("soft", &["body.sheet.springs.structural.k=10", "body.sheet.springs.shear.k=5"]);
    assert!(soft > stiff, "{soft} {stiff}");
    stretch("short", &["time.frames=2"]);
    assert_eq!(desk.json("short/summary.json")["frames"], 2);
}

#[test]
fn a_divergence_keeps_the_good_frames_and_exits_with_1() {
    let desk = Desk::with(SHEET);
    let words = ["run", "scene.toml", "--out", "o", "--frames", "200", "--format", "npy,ply"];
    let mut command = desk.taffeta(&words);
    command.args(["--set", "body.sheet.springs.structural.k=1e7"]);
    let (out, err, code) = ending(command);
    assert_eq!(code, Some(1), "{err}");
    assert!(out.contains("warning: "), "{out}");
    assert!(err.starts_with("error: frame "), "{err}");
    assert!(err.contains("body `sheet`") && err.contains("time.max_step"), "{err}");
    assert_eq!(desk.files("o"), ["frames.csv", "positions.npy", "sheet.ply", "summary.json"]);
    let summary = desk.json("o/summary.json");
    assert_eq!(summary["status"], "diverged");
    let rows = summary["frames"].as_u64().unwrap() + 1;
    assert!((1..200).contains(&rows));
    let (header, bytes) = desk.npy("o/positions.npy");
    assert!(header.contains(&format!("({rows}, 35, 3)")), "{header}");
    let all = std::fs::read(desk.path("o/positions.npy")).unwrap();
    let finite = |number: &[u8; 4]| f32::from_le_bytes(*number).is_finite();
    assert!(all[all.len() - bytes..].as_chunks().0.iter().all(finite));
}

#[test]
fn a_divergence_at_once_keeps_the_start() {
    let desk = Desk::with(SHEET);
    let mut command = desk.taffeta(&["run", "scene.toml", "--out", "o", "--frames", "5", "--quiet"]);
    command.args(["--set", "body.sheet.springs.structural.k=1e12"]);
    let (_, err, code) = ending(command);
    assert_eq!(code, Some(1), "{err}");
    assert!(err.contains("\nframe 0, the start, is in o"), "{err}");
    assert_eq!(desk.json("o/summary.json")["frames"], 0);
}

#[cfg(unix)]
#[test]
fn a_full_disk_exits_with_1_and_says_which_file() {
    let desk = Desk::with(SHEET);
    // No file may become longer than 4 blocks, of 512 or 1024 bytes, which is less than the positions of all frames.
    let limited = "trap '' XFSZ; ulimit -f 4; exec \"$0\" run scene.toml --out o --frames 10";
    let mut shell = assert_cmd::Command::new("sh");
    let taffeta = assert_cmd::cargo::cargo_bin!("taffeta");
    shell.args(["-c".as_ref(), limited.as_ref(), taffeta.as_os_str()]).current_dir(desk.path(""));
    let (_, err, code) = ending(shell);
    assert_eq!(code, Some(1), "{err}");
    assert!(err.starts_with("error: ") && err.contains("positions.npy.part"), "{err}");
}

#[test]
fn no_word_of_a_scene_steers_the_terminal() {
    const ODD: &str = "\\u001b]0;owned\\u0007\\nwarning: forged \\u202e";
    let shown = "\\u001b]0;owned\\u0007\\u000awarning: forged \\u202e";
    let untitled: String =
        SHEET.lines().filter(|line| !line.starts_with("title")).map(|line| format!("{line}\n")).collect();
    let scene = |line: &str| format!("title = \"{ODD}\"\n{line}\n{untitled}");
    let said = |args: &[&str], line: &str| {
        let desk = Desk::with(&scene(line));
        let (out, err, code) = ending(desk.taffeta(args));
        let all = out + &err;
        assert!(all.contains(shown), "{all}");
        assert!(all.chars().all(|c| c == '\n' || !c.is_control() && c != '\u{202e}'), "{all:?}");
        assert!(!all.contains("\nwarning: forged"), "{all}");
        code
    };
    assert_eq!(said(&["check", "scene.toml"], ""), Some(0));
    assert_eq!(said(&["run", "scene.toml", "--frames", "1", "--out", "o"], ""), Some(0));
    assert_eq!(said(&["check", "scene.toml"], &format!("\"{ODD}\" = 1")), Some(2));
    let desk = Desk::with(&scene(""));
    let (json, _, _) = ending(desk.taffeta(&["check", "scene.toml", "--json"]));
    let json: serde_json::Value = serde_json::from_str(&json).unwrap();
    assert_eq!(json["title"], "\u{1b}]0;owned\u{7}\nwarning: forged \u{202e}");
}

#[cfg(unix)]
#[test]
fn nothing_is_written_through_links_in_the_folder_of_results() {
    let link = |name: &str| {
        let desk = Desk::with(SHEET);
        std::fs::create_dir(desk.path("o")).unwrap();
        std::fs::write(desk.path("theirs"), "precious").unwrap();
        std::os::unix::fs::symlink(desk.path("theirs"), desk.path(&format!("o/{name}"))).unwrap();
        let args = ["run", "scene.toml", "--out", "o", "--frames", "3", "--checkpoint-every", "1"];
        let (_, err, code) = ending(desk.taffeta(&args));
        assert_eq!(std::fs::read_to_string(desk.path("theirs")).unwrap(), "precious", "{name}");
        (err, code)
    };
    for name in ["positions.npy.part", "frames.csv.part", "lock.part"] {
        let (err, code) = link(name);
        assert!(err.contains(&format!("o/{name}: is a link to a file elsewhere")), "{err}");
        assert!(matches!(code, Some(1 | 2)), "{code:?}");
    }
    for name in ["positions.npy", "summary.json", "summary.json.part", "checkpoint.taffeta.part"] {
        let (err, code) = link(name);
        assert_eq!(code, Some(0), "{name}: {err}");
    }
}

#[cfg(unix)]
#[test]
fn pipes_are_refused_without_waiting_for_their_other_end() {
    let desk = Desk::with(SHEET);
    let made = std::process::Command::new("mkfifo").arg(desk.path("pipe")).status();
    assert!(made.unwrap().success());
    for args in [
        ["run", "pipe", "--quiet"].as_slice(),
        &["check", "pipe"],
        &["run", "scene.toml", "--resume", "pipe"],
    ] {
        let (_, err, code) = ending(desk.taffeta(args));
        assert_eq!(code, Some(2), "{err}");
        assert!(err.contains("pipe: ") && err.contains("is not a regular file"), "{err}");
    }
}

#[cfg(unix)]
#[test]
fn ctrl_c_ends_the_run_with_whole_files() {
    use std::io::{BufRead, BufReader, Read};
    let desk = Desk::with(SHEET);
    let mut run = std::process::Command::new(assert_cmd::cargo::cargo_bin!("taffeta"))
        .args(["run", "scene.toml", "--out", "o", "--frames", "100000000", "--format", "pc2"])
        .current_dir(desk.path(""))
        .stdout(std::process::Stdio::piped())
        .stderr(std::process::Stdio::piped())
        .spawn()
        .unwrap();
    let mut title = String::new();
    BufReader::new(run.stdout.as_mut().unwrap()).read_line(&mut title).unwrap();
    let kill = std::process::Command::new("kill").args(["-INT", &run.id().to_string()]).status();
    assert!(kill.unwrap().success());
    assert_eq!(run.wait().unwrap().code(), Some(130));
    let mut err = String::new();
    run.stderr.take().unwrap().read_to_string(&mut err).unwrap();
    let summary = desk.json("o/summary.json");
    assert_eq!(summary["status"], "interrupted");
    let frames = summary["frames"].as_u64().unwrap();
    // The signal may arrive before the first frame is done.
    let left = match frames {
        0 => String::from("frame 0, the start, is in o"),
        _ => format!("frames 0 to {frames} are in o"),
    };
    assert!(err.contains(&format!("\ninterrupted: {left}")), "{err}");
    assert_eq!(desk.files("o"), ["checkpoint.taffeta", "frames.csv", "sheet.pc2", "summary.json"]);
    let cache = std::fs::read(desk.path("o/sheet.pc2")).unwrap();
    assert_eq!(u64::from(u32::from_le_bytes(cache[28..32].try_into().unwrap())), frames + 1);
    assert_eq!(cache.len() as u64, 32 + (frames + 1) * 35 * 12);
}

#[test]
fn a_run_does_not_write_over_what_its_scene_is_read_from() {
    let scene = "[[body]]\nname = \"bunny\"\nmass = 1.0\nmesh.file = \"bunny.obj\"\n";
    let desk = Desk::with(scene);
    let mesh = "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n";
    std::fs::write(desk.path("bunny.obj"), mesh).unwrap();
    let run = |format: &str| {
        ending(desk.taffeta(&["run", "scene.toml", "--out", ".", "--frames", "1", "--format", format]))
    };
    let (_, err, code) = run("npy,obj");
    assert_eq!(code, Some(2), "{err}");
    assert!(
        err.contains("--out .: `bunny.obj` would be written over, and the scene is read from it"),
        "{err}"
    );
    // A summary may name it, and still it is not removed.
    std::fs::write(desk.path("summary.json"), "{\"files\": [\"bunny.obj\", \"old.npy\"]}").unwrap();
    std::fs::write(desk.path("old.npy"), "").unwrap();
    assert_eq!(run("npy").2, Some(0));
    assert_eq!(std::fs::read_to_string(desk.path("bunny.obj")).unwrap(), mesh);
    assert!(!desk.path("old.npy").exists());
    let (_, err, code) = ending(desk.taffeta(&["run", "bunny.obj"]));
    assert_eq!(code, Some(2));
    assert!(err.contains("is a mesh and not a scene; `taffeta check bunny.obj` prints a scene"), "{err}");
}

#[test]
fn what_the_solver_of_constraints_did_is_told_and_an_early_stop_is_warned_of() {
    let desk = Desk::with(SHEET);
    let run = |sets: &[&str]| {
        let mut command = desk.taffeta(&["run", "scene.toml", "--out", "o", "--precision", "f64"]);
        command.args(sets.iter().flat_map(|set| ["--set", set]));
        let (out, err, code) = ending(command);
        assert_eq!(code, Some(0), "{err}");
        let table = std::fs::read_to_string(desk.path("o/frames.csv")).unwrap();
        let rows: Vec<Vec<String>> =
            table.lines().map(|line| line.split(',').map(str::to_owned).collect()).collect();
        let column = |name: &str| {
            let at = rows[0].iter().position(|title| title == name).unwrap();
            rows[1..].iter().map(|row| row[at].parse().unwrap()).collect::<Vec<f64>>()
        };
        let columns = ["iterations", "residual", "active_fraction"].map(column);
        (desk.json("o/summary.json")["solver"].clone(), out, columns)
    };
    let largest = |column: &[f64]| column.iter().copied().fold(0.0, f64::max);

    let (solver, out, [iterations, residual, active]) = run(&["solver.method=ice"]);
    assert_eq!((&solver["capped"], &solver["active_fraction"]), (&0.into(), &1.0.into()));
    assert_eq!(solver["iterations"].as_f64(), Some(largest(&iterations)));
    assert_eq!(solver["mean_iterations"].as_f64(), Some(iterations.iter().sum::<f64>() / 4.0));
    assert_eq!(solver["residual"].as_f64(), Some(largest(&residual)));
    assert!(
        solver["residual"].as_f64().is_some_and(|residual| residual > 0.0 && residual <= 1e-3),
        "{solver}"
    );
    assert_eq!(active, [0.0, 1.0, 1.0, 1.0, 1.0], "the start has no solver");
    assert!(out.contains(&format!(", up to {} iterations, state ", solver["iterations"])), "{out}");
    assert!(!out.contains("warning"), "{out}");

    let cut = ["solver.method=ice", "solver.ice.max_iterations=2", "solver.ice.tolerance=1e-9"];
    let (solver, out, _) = run(&cut);
    let capped = solver["capped"].as_u64().unwrap();
    assert!(capped > 10 && solver["iterations"] == 2, "{solver}");
    let said = format!("the tolerance of 1e-9 in {capped} of 20 sub-steps, up to ");
    assert!(out.contains("warning: the solver's residual was beyond ") && out.contains(&said), "{out}");
    assert!(out.contains("after up to 2 iterations; in [solver], a larger ice.max_iterations or "), "{out}");

    let primal = ["solver.method=ice", "solver.ice.form=primal", "solver.ice.newton_steps=2"];
    let (solver, out, [iterations, residual, _]) = run(&primal);
    assert_eq!((&solver["capped"], &solver["iterations"].as_f64()), (&0.into(), &Some(largest(&iterations))));
    assert!(iterations[1..].iter().all(|&count| count >= 2.0), "one in each Newton step: {iterations:?}");
    assert!(largest(&residual) > 0.0 && largest(&residual) <= 1e-3, "{residual:?}");
    assert!(!out.contains("warning"), "{out}");
    let cut = [&primal[..], &["solver.ice.max_iterations=1", "solver.ice.tolerance=1e-6"]].concat();
    let (_, out, _) = run(&cut);
    assert!(out.contains("a larger ice.max_iterations or ice.tolerance, softer springs"), "{out}");

    let (solver, out, [_, _, active]) = run(&["solver.method=acad", "solver.acad.threshold=1e-3"]);
    let most = largest(&active);
    assert!(most > 0.0 && most < 1.0 && solver["active_fraction"].as_f64() == Some(most), "{solver}");
    assert_eq!(solver["mean_active_fraction"].as_f64(), Some(active.iter().sum::<f64>() / 4.0));
    assert!(out.contains(&format!("up to {} % of the springs constraints", (1e2 * most).ceil())), "{out}");
}

/// A small sheet that falls edge first through one that is held.
const PASSING: &str = r#"
[time]
dt = 0.02
max_step = 0.002
frames = 12
[[body]]
name = "held"
node_mass = 0.01
mesh.grid = { rows = 3, cols = 3, size = [0.4, 0.4] }
[body.springs]
structural = { k = 100.0, d = 0.05 }
[[body.pin]]
select = { rows = [0, 2] }
[[body]]
name = "falls"
node_mass = 0.01
mesh.grid = { rows = 3, cols = 3, size = [0.2, 0.2] }
place = { position = [0.03, 0.2, 0.02], rotation = { axis = [1.0, 0.0, 0.0], degrees = 80.0 } }
[body.springs]
structural = { k = 100.0, d = 0.05 }
"#;

#[test]
fn intersections_are_counted_where_they_are_asked_for() {
    let desk = Desk::with(PASSING);
    let words = ["run", "scene.toml", "--out", "o", "--verify-contact"];
    let (out, err, code) = ending(desk.taffeta(&words));
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("warning: surfaces passed through each other, edges through triangles: "), "{out}");
    // One of those that are left is named.
    assert!(out.contains(" in the last frame, such as the edge of vertices "), "{out}");
    let table = std::fs::read_to_string(desk.path("o/frames.csv")).unwrap();
    let column = table.lines().next().unwrap().split(',').position(|name| name == "intersections").unwrap();
    let counted: Vec<u64> =
        table.lines().skip(1).map(|row| row.split(',').nth(column).unwrap().parse().unwrap()).collect();
    assert!(counted[0] == 0 && counted.iter().any(|&pairs| pairs > 0), "{counted:?}");
    let all = &desk.json("o/summary.json")["intersections"];
    assert_eq!(all["max"].as_u64(), counted.iter().copied().max());
    assert_eq!(all["final"].as_u64(), counted.last().copied());
    assert_eq!(all["last_frame"].as_u64(), counted.iter().rposition(|&pairs| pairs > 0).map(|at| at as u64));
}

/// Two boxes that close on a sheet whose middle is pinned, and leave no room for it.
const CRUSHED: &str = r#"
[time]
max_step = 0.0005
frames = 10
[[collider]]
box = { half = [0.1, 0.1, 0.1] }
place.position = [-0.13, 0.0, 0.0]
[[collider.motion]]
t = 0.0
[[collider.motion]]
t = 0.1
translate = [0.07, 0.0, 0.0]
[[collider]]
name = "press"
box = { half = [0.1, 0.1, 0.1] }
place.position = [0.13, 0.0, 0.0]
[[body]]
name = "scarf"
mass = 0.02
mesh.grid = { rows = 7, cols = 5, size = [0.12, 0.08] }
place.rotation = { axis = [0.0, 0.0, 1.0], degrees = 90.0 }
springs = { structural = { k = 30.0, d = 0.004 }, shear = { k = 15.0, d = 0.004 } }
self_collision = { thickness = 0.005 }
[[body.pin]]
select = { nodes = [17] }
"#;

#[test]
fn cloth_that_is_crushed_between_colliders_is_said() {
    let crushed = |text: &str| {
        let desk = Desk::with(text);
        let (_, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o", "--quiet"]));
        assert_eq!(code, Some(0), "{err}");
        err
    };
    let err = crushed(CRUSHED);
    let said: Vec<&str> = err.lines().filter(|line| line.contains("pressed through each other")).collect();
    assert!(said.len() == 1 && said[0].starts_with("warning: frame "), "{err}");
    assert!(said[0].contains("body `scarf`") && said[0].contains("collider `"), "{err}");
    // With room for it nothing is said.
    assert_eq!(crushed(&CRUSHED.replace("translate = [0.07,", "translate = [0.02,")), "");
}

#[test]
fn a_run_may_stop_at_the_first_intersection() {
    let desk = Desk::with(PASSING);
    let words = ["run", "scene.toml", "--out", "o", "--verify-contact=stop", "--quiet"];
    let (_, err, code) = ending(desk.taffeta(&words));
    assert_eq!(code, Some(1), "{err}");
    assert!(err.contains("intersection") && err.contains("body `held`"), "{err}");
    let summary = desk.json("o/summary.json");
    assert_eq!(summary["status"], "intersected");
    let frame = summary["frames"].as_u64().expect("a number");
    assert!(err.contains(&format!("frame {frame} has ")) && frame < 12, "{err}");
    assert_eq!(summary["intersections"]["last_frame"].as_u64(), Some(frame));
}

#[test]
fn intersections_at_the_start_and_at_the_end_are_counted_unasked() {
    // The second sheet starts in the first one, and falls through it.
    let inside =
        PASSING.replace("[0.03, 0.2, 0.02]", "[0.03, 0.05, 0.02]").replace("frames = 12", "frames = 6");
    let desk = Desk::with(&inside);
    let simulation = taffeta::Simulation::new(
        &taffeta_io::load_scene(&desk.path("scene.toml"), &[]).unwrap().scene,
        &taffeta::Options::default(),
    );
    let pairs = simulation.unwrap().intersections().pairs;
    assert!(pairs > 0);
    let (out, _, code) = ending(desk.taffeta(&["check", "scene.toml"]));
    let said = format!(
        "intersections at the start: {pairs} edges pass through triangles, such as the edge of vertices "
    );
    assert!(
        code == Some(0)
            && out.contains(&said)
            && out.contains("nothing pulls bodies apart that have no [body.self_collision]"),
        "{out}"
    );
    let (out, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o"]));
    assert_eq!(code, Some(0), "{err}");
    let found = &desk.json("o/summary.json")["intersections"];
    assert_eq!(found["start"].as_u64(), Some(pairs));
    assert!(out.contains(&format!("edges through triangles: {pairs} at the start, ")), "{out}");
    assert!(out.contains("bodies with [body.self_collision] that start apart stay so"), "{out}");
    // Contact of a third body does not help these two.
    let third = "[[body]]\nname = \"far\"\nnode_mass = 0.01\nmesh.grid = { rows = 3, cols = 3, size = [0.2, 0.2] }\n\
                 place.position = [9.0, 0.0, 0.0]\nself_collision.thickness = 0.003\n";
    let desk = Desk::with(&format!("{inside}{third}"));
    let (out, _, _) = ending(desk.taffeta(&["check", "scene.toml"]));
    assert!(out.contains("nothing pulls bodies apart that have no [body.self_collision]"), "{out}");
    // What is apart is found to be.
    let desk = Desk::with(&inside.replace("0.05, 0.02]", "0.9, 0.02]"));
    let (out, _, _) = ending(desk.taffeta(&["check", "scene.toml"]));
    assert!(out.contains("intersections at the start: none"), "{out}");
    let (out, _, _) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o"]));
    assert!(!out.contains("passed through"), "{out}");
    let found = &desk.json("o/summary.json")["intersections"];
    assert_eq!(*found, serde_json::json!({"start": 0, "final": 0, "max": 0, "last_frame": null}));
}

#[test]
fn springs_that_stretch_as_no_cloth_does_are_said() {
    // A chain of three heavy nodes at a pin: the first spring carries two of them, 2 m g/k = 0.1 m, of 0.1 m.
    let chain = |k: f64| {
        let scene = format!(
            "[time]\nmax_step = 0.001\nframes = 60\n[[body]]\nname = \"c\"\nnode_mass = 0.05\nmesh.chain = {{ links = 2, length = 0.2 }}\n\
             springs.structural = {{ k = {k:?}, d = 0.2 }}\n[[body.pin]]\nselect = {{ nodes = [0] }}\n"
        );
        let desk = Desk::with(&scene);
        let (out, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o"]));
        assert_eq!(code, Some(0), "{err}");
        out
    };
    let soft = chain(9.81);
    assert!(
        soft.contains("times its rest length; cloth does not stretch so far")
            && soft.contains("stiffer springs"),
        "{soft}"
    );
    assert!(!chain(98.1).contains("cloth does not stretch"));
}
