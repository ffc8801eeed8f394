//! Runs that are stopped, killed or short of disk, and go on.

use crate::desk::{BALL, Desk, SHEET, ending};
use std::collections::BTreeMap;
use std::path::Path;
use std::process::{Child, Command, Stdio};

/// All formats, two bodies, and so many frames that there is time to be killed.
const TWO: &str = r#"
[time]
dt = 0.01
max_step = 0.002
frames = 40
[[body]]
name = "sheet"
node_mass = 0.01
mesh.grid = { rows = 12, cols = 12, size = [0.6, 0.6] }
springs = { structural = { k = 100.0, d = 0.05 }, shear = { k = 50.0, d = 0.05 } }
[[body.pin]]
select = { nodes = [0, 11] }
motion = [{ t = 0.5, translate = [0.1, 0.0, 0.0] }]
[[body]]
name = "ball"
kind = "soft"
mass = 1.0
mesh.icosphere = { radius = 0.2, subdivisions = 2 }
place.position = [0.0, -0.5, 0.0]
springs.structural = { k = 200.0, d = 0.1 }
springs.hinge = { k = 0.001 }
[[collider]]
plane = { point = [0.0, -0.8, 0.0] }
"#;
const ALL: &str = "npy,pc2,usda,ply,obj,vtu,glb";

/// The files of a run without what tells the time.
fn results(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let entries = std::fs::read_dir(folder).expect("the folder is there");
    let timeless = |entry: std::io::Result<std::fs::DirEntry>| {
        let path = entry.expect("an entry").path();
        let name = path.file_name().expect("a name").to_string_lossy().into_owned();
        if path.is_dir() {
            let within = |(inner, bytes): (String, Vec<u8>)| (format!("{name}/{inner}"), bytes);
            return results(&path).into_iter().map(within).collect();
        }
        let bytes = std::fs::read(&path).expect("a file");
        let text = || String::from_utf8_lossy(&bytes);
        let plain = match name.as_str() {
            // The last column is the time of the frame.
            "frames.csv" => {
                text().lines().map(|line| line.rsplit_once(',').unwrap().0.to_owned() + "\n").collect()
            }
            "summary.json" => text()
                .lines()
                .filter(|line| !line.contains("wall_ms") && !line.contains("substeps_per_s"))
                .collect::<String>(),
            "checkpoint.taffeta" => String::new(),
            _ => return vec![(name, bytes)],
        };
        vec![(name, plain.into_bytes())]
    };
    entries.flat_map(timeless).collect()
}

fn start(desk: &Desk, words: &[&str]) -> Child {
    Command::new(assert_cmd::cargo::cargo_bin!("taffeta"))
        .args(words)
        .current_dir(desk.path(""))
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .expect("the program starts")
}

/// Bytes in a folder; files may come and go.
fn size(folder: &Path) -> u64 {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).map(|metadata| metadata.len()).sum()
}

/// Kills the run as soon as its folder has grown by `bytes`, or lets it end.
fn kill_after(mut run: Child, folder: &Path, bytes: u64) {
    let before = size(folder);
    while size(folder) < before + bytes {
        if run.try_wait().expect("it can be asked").is_some() {
            return;
        }
        std::thread::yield_now();
    }
    run.kill().expect("it can be killed");
    run.wait().expect("it is gone");
}

#[test]
fn a_run_killed_at_any_moment_goes_on_to_the_same_files() {
    killed_at_any_moment(TWO, 20);
}

#[test]
fn constraints_of_a_run_killed_at_any_moment_go_on_to_the_same_files() {
    for method in ["ice\"", "acad\"", "ice\"\nice.form = \"primal\""] {
        let desk = killed_at_any_moment(&format!("[solver]\nmethod = \"{method}\n{TWO}"), 6);
        let solver = desk.json("whole/summary.json")["solver"].clone();
        assert!(solver["active_fraction"].as_f64().is_some_and(|share| share > 0.0), "{method}: {solver}");
        assert!(solver["iterations"].as_u64().is_some_and(|most| most > 1), "{method}: {solver}");
    }
}

/// Kills runs of a scene twice each, and lets them go on.
fn killed_at_any_moment(scene: &str, moments: u32) -> Desk {
    let desk = Desk::with(scene);
    let new = |out: &str, every: &str| {
        ["run", "scene.toml", "--quiet", "--out", out, "--format", ALL, "--checkpoint-every", every]
            .map(str::to_owned)
    };
    desk.taffeta(&new("whole", "7").each_ref().map(String::as_str)).assert().success();
    let whole = results(&desk.path("whole"));
    let total = size(&desk.path("whole"));
    let mut random = 88_172_645_463_325_252_u64;
    for moment in 0..moments {
        let out = format!("o{moment}");
        // One in two writes a checkpoint every frame, so that most moments are within one.
        let words = new(&out, if moment % 2 == 0 { "7" } else { "1" });
        let words = words.each_ref().map(String::as_str);
        let checkpoint = format!("{out}/checkpoint.taffeta");
        for _ in 0..2 {
            random ^= random << 13;
            random ^= random >> 7;
            random ^= random << 17;
            let resume = ["run", "scene.toml", "--quiet", "--resume", &checkpoint];
            let words = if desk.path(&checkpoint).exists() { &resume[..] } else { &words[..] };
            kill_after(start(&desk, words), &desk.path(&out), random % total);
        }
        let resume = ["run", "scene.toml", "--resume", &checkpoint, "--quiet"];
        let words = if desk.path(&checkpoint).exists() { &resume[..] } else { &words[..] };
        let (_, err, code) = ending(desk.taffeta(words));
        assert_eq!((err.as_str(), code), ("", Some(0)), "moment {moment}");
        let now = results(&desk.path(&out));
        for (name, bytes) in &whole {
            assert!(now.get(name) == Some(bytes), "{name} differs after a kill at moment {moment}");
        }
        assert_eq!(now.len(), whole.len(), "moment {moment} left {:?}", now.keys());
    }
    desk
}

#[cfg(unix)]
#[test]
fn ctrl_c_writes_a_checkpoint_and_the_command_it_prints_goes_on() {
    let desk = Desk::with(SHEET);
    let words = ["run", "scene.toml", "--out", "my out", "--frames", "20000", "--format", "npy,usda,ply"];
    let set = ["--set", "body.sheet.springs.structural.k=90"];
    let mut run = Command::new(assert_cmd::cargo::cargo_bin!("taffeta"));
    run.args(words).args(set).current_dir(desk.path("")).stdout(Stdio::null()).stderr(Stdio::piped());
    let mut run = run.spawn().unwrap();
    while size(&desk.path("my out")) < 5_000 {
        assert!(run.try_wait().unwrap().is_none(), "the run was over at once");
        std::thread::yield_now();
    }
    assert!(Command::new("kill").args(["-INT", &run.id().to_string()]).status().unwrap().success());
    let stopped = run.wait_with_output().unwrap();
    let err = String::from_utf8(stopped.stderr).unwrap();
    assert_eq!(stopped.status.code(), Some(130), "{err}");
    let said = err.split("to go on: taffeta ").nth(1).expect(&err).trim();
    assert_eq!(
        said,
        "run scene.toml --resume 'my out/checkpoint.taffeta' --set body.sheet.springs.structural.k=90"
    );
    assert!(desk.path("my out/scene.usda").exists(), "a stopped run leaves whole files");

    let resume = ["run", "scene.toml", "--resume", "my out/checkpoint.taffeta"];
    let mut again = desk.taffeta(&resume);
    again.args(set);
    let (out, err, code) = ending(again);
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("resuming from frame ") && out.contains(" of 20000"), "{out}");
    assert!(!desk.path("my out/checkpoint.taffeta").exists(), "a run that is done needs no checkpoint");
    let mut whole = desk.taffeta(&words.map(|word| if word == "my out" { "whole" } else { word }));
    whole.args(set).assert().success();
    assert!(results(&desk.path("my out")) == results(&desk.path("whole")));
}

/// A finished run of 4 frames with a checkpoint at frame 2.
fn stopped_at_2() -> Desk {
    let desk = Desk::with(SHEET);
    let words = ["run", "scene.toml", "--out", "o", "--quiet", "--frames", "2", "--checkpoint-every", "2"];
    desk.taffeta(&words).assert().success();
    desk
}

#[test]
fn a_run_that_was_done_goes_on_for_longer() {
    let desk = stopped_at_2();
    let more = ["run", "scene.toml", "--resume", "o", "--frames", "4", "--quiet"];
    desk.taffeta(&more).assert().success();
    desk.taffeta(&["run", "scene.toml", "--out", "whole", "--quiet"]).assert().success();
    let [mut longer, whole] = ["o", "whole"].map(|folder| results(&desk.path(folder)));
    longer.remove("checkpoint.taffeta");
    assert!(longer == whole);
    let (_, err, code) =
        ending(desk.taffeta(&["run", "scene.toml", "--resume", "o/checkpoint.taffeta", "--frames", "3"]));
    assert_eq!(code, Some(2));
    assert!(err.contains("the checkpoint is at frame 4") && err.contains("--frames 4 or more"), "{err}");
}

#[test]
fn a_checkpoint_that_does_not_fit_is_refused_with_the_reason() {
    let desk = stopped_at_2();
    let good = std::fs::read(desk.path("o/checkpoint.taffeta")).unwrap();
    let refused = |bytes: &[u8], more: &[&str], reason: &str| {
        std::fs::write(desk.path("o/checkpoint.taffeta"), bytes).unwrap();
        let mut words = vec!["run", "scene.toml", "--frames", "4", "--resume", "o/checkpoint.taffeta"];
        words.extend(more);
        let before = std::fs::read(desk.path("o/positions.npy")).unwrap();
        let (_, err, code) = ending(desk.taffeta(&words));
        assert_eq!(code, Some(2), "{err}");
        assert!(err.contains(reason), "{err}");
        assert!(std::fs::read(desk.path("o/positions.npy")).unwrap() == before, "results were touched");
    };
    let mut flipped = good.clone();
    flipped[good.len() / 2] ^= 16;
    refused(&flipped, &[], "checkpoint.taffeta: damaged: its checksum");
    refused(&good[..good.len() - 1], &[], "damaged: it has");
    refused(b"", &[], "not a checkpoint of taffeta");
    refused(b"PK\x03\x04 something else entirely, long enough", &[], "not a checkpoint of taffeta");
    let mut older = good.clone();
    older[8..12].copy_from_slice(&0_u32.to_le_bytes());
    refused(
        &older,
        &[],
        "written by an older program, in version 0 of the format; this one reads version 16",
    );
    older[8] = 99;
    refused(&older, &[], "written by a newer program");
    let stiffer = ["--set", "body.sheet.springs.structural.k=101"];
    let named = "another scene: `body[0].springs.structural.k` was 100.0 and is 101.0";
    refused(&good, &stiffer, named);
    refused(&good, &["--set", "world.drag=0.5"], "`world.drag` was 0.0 and is 0.5");
    refused(&good, &["--format", "npy,pc2"], "--format: the run writes npy");
    refused(&good, &["--out", "elsewhere"], "the files that the run left are needed to go on");
    let missing = ["run", "scene.toml", "--resume", "none.taffeta"];
    let (_, err, code) = ending(desk.taffeta(&missing));
    assert_eq!(code, Some(2));
    assert!(err.starts_with("error: --resume none.taffeta: cannot be read"), "{err}");
}

#[test]
fn a_refused_resume_leaves_a_finished_run_as_it_was() {
    let desk = Desk::with(TWO);
    let words = ["run", "scene.toml", "--out", "o", "--quiet", "--format", ALL, "--frames", "4"];
    desk.taffeta(&words).args(["--checkpoint-every", "2"]).assert().success();
    let whole = results(&desk.path("o"));
    let caches = ["positions.npy", "sheet.pc2", "ball.pc2", "scene.usda", "scene.pvd", "vtu/ball_000003.vtu"];
    for name in caches.into_iter().chain(["frames.csv"]) {
        let kept = std::fs::read(desk.path("o").join(name)).unwrap();
        std::fs::remove_file(desk.path("o").join(name)).unwrap();
        let (_, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--resume", "o", "--frames", "6"]));
        assert_eq!(code, Some(2), "{err}");
        assert!(err.contains(name) && err.contains("are needed to go on"), "{name}: {err}");
        std::fs::write(desk.path("o").join(name), kept).unwrap();
        assert!(results(&desk.path("o")) == whole, "without {name} the others were touched");
    }
}

#[test]
fn what_a_resumed_run_was_asked_for_holds_when_it_is_stopped_at_once() {
    let desk = stopped_at_2();
    let words = ["run", "scene.toml", "--resume", "o", "--frames", "100000", "--precision", "f64"];
    // No other checkpoint comes in between.
    let run = start(&desk, &[&words[..], &["--checkpoint-every", "100000"]].concat());
    // It is at work when it has taken its files up.
    while !desk.path("o/positions.npy.part").exists() {
        std::thread::yield_now();
    }
    kill_after(run, &desk.path("o"), 0);
    let (_, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o"]));
    assert_eq!(code, Some(2), "{err}");
    assert!(err.contains("o holds a run that stopped at frame 2 of 100000; to go on: "), "{err}");
    desk.taffeta(&["run", "scene.toml", "--resume", "o", "--frames", "4", "--quiet"]).assert().success();
    let summary = desk.json("o/summary.json");
    assert_eq!((&summary["frames"], &summary["precision"]), (&4.into(), &"f64".into()));
}

#[test]
fn a_checkpoint_that_cannot_be_read_keeps_its_folder_from_a_new_run() {
    let desk = stopped_at_2();
    let path = desk.path("o/checkpoint.taffeta");
    let mut bytes = std::fs::read(&path).unwrap();
    *bytes.last_mut().unwrap() ^= 1;
    std::fs::write(&path, &bytes).unwrap();
    let before = results(&desk.path("o"));
    let (_, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o"]));
    assert_eq!(code, Some(2));
    assert!(err.contains("o/checkpoint.taffeta: damaged") && err.contains("choose another --out"), "{err}");
    assert!(results(&desk.path("o")) == before);
}

#[test]
fn a_folder_is_for_one_run_at_a_time_and_a_refused_run_leaves_none_behind() {
    let desk = Desk::with(SHEET);
    let mut run = start(&desk, &["run", "scene.toml", "--out", "o", "--frames", "100000000"]);
    while !desk.path("o/positions.npy.part").exists() {
        std::thread::yield_now();
    }
    let (_, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o", "--format", "ply"]));
    assert_eq!(code, Some(2));
    assert!(err.contains("--out o: another run is writing here"), "{err}");
    run.kill().unwrap();
    run.wait().unwrap();
    // What the killed one left of its lock is no lock.
    desk.taffeta(&["run", "scene.toml", "--out", "o", "--quiet"]).assert().success();
    assert_eq!(desk.files("o"), ["frames.csv", "positions.npy", "summary.json"]);
    let words = ["run", "scene.toml", "--out", "new", "--set", "body.sheet.node_mass=-1"];
    assert_eq!(ending(desk.taffeta(&words)).2, Some(2));
    assert!(!desk.path("new").exists());
}

#[test]
fn another_precision_is_converted_and_said() {
    let desk = Desk::with(SHEET);
    let words = ["run", "scene.toml", "--out", "o", "--quiet", "--frames", "2", "--format", "npy,vtu"];
    desk.taffeta(&words).args(["--checkpoint-every", "2"]).assert().success();
    let words =
        ["run", "scene.toml", "--resume", "o/checkpoint.taffeta", "--frames", "4", "--precision", "f64"];
    let (out, err, code) = ending(desk.taffeta(&words));
    assert_eq!(code, Some(0), "{err}");
    assert!(out.contains("resuming from frame 2 of 4, converted from f32 to f64"), "{out}");
    let (header, bytes) = desk.npy("o/positions.npy");
    assert!(header.contains("'<f4'") && header.contains("(5, 35, 3)"), "{header}");
    assert_eq!(bytes, 5 * 35 * 3 * 4);
    assert_eq!(desk.json("o/summary.json")["precision"], "f64");
}

#[test]
fn a_long_run_is_not_overwritten_because_resume_was_forgotten() {
    let desk = Desk::with(SHEET);
    let words = ["run", "scene.toml", "--out", "o", "--frames", "100000", "--checkpoint-every", "1"];
    let run = start(&desk, &words);
    while !desk.path("o/checkpoint.taffeta").exists() {
        std::thread::yield_now();
    }
    kill_after(run, &desk.path("o"), 0);
    let (_, err, code) = ending(desk.taffeta(&["run", "scene.toml", "--out", "o"]));
    assert_eq!(code, Some(2));
    assert!(err.contains("o holds a run that stopped at frame "), "{err}");
    assert!(err.contains("to go on: taffeta run scene.toml --resume o/checkpoint.taffeta"), "{err}");
    std::fs::remove_file(desk.path("o/checkpoint.taffeta")).unwrap();
    desk.taffeta(&["run", "scene.toml", "--out", "o", "--quiet"]).assert().success();
}

/// A limit on the size of a file is the nearest to a full disk that needs no rights.
#[cfg(unix)]
#[test]
fn a_full_disk_loses_nothing_and_the_run_goes_on_when_there_is_space() {
    let desk = Desk::with(BALL);
    let words = "run scene.toml --quiet --checkpoint-every 3 --format npy,pc2,usda,ply --frames 30";
    desk.taffeta(&format!("{words} --out whole").split(' ').collect::<Vec<_>>()).assert().success();
    let program = assert_cmd::cargo::cargo_bin!("taffeta").display();
    // Blocks of 512 bytes: enough for some frames of the text, which is the largest file.
    let script = format!("trap '' XFSZ; ulimit -f 120; exec {program} {words} --out o");
    let stopped = Command::new("sh").args(["-c", &script]).current_dir(desk.path("")).output().unwrap();
    let err = String::from_utf8(stopped.stderr).unwrap();
    assert_eq!(stopped.status.code(), Some(1), "{err}");
    let frames = desk.json("o/summary.json")["frames"].as_u64().unwrap();
    assert!(err.starts_with("error: o/scene.usda.part: "), "{err}");
    assert!(err.contains(&format!("\nframes 0 to {frames} are in o\ncheckpoint at frame ")), "{err}");
    assert_eq!(desk.json("o/summary.json")["status"], "failed");
    let (header, _) = desk.npy("o/positions.npy");
    assert!(header.contains(&format!("({}, 162, 3)", frames + 1)), "{header}");
    let table = std::fs::read_to_string(desk.path("o/frames.csv")).unwrap();
    assert_eq!(table.lines().count() as u64, frames + 2);
    desk.taffeta(&["run", "scene.toml", "--resume", "o/checkpoint.taffeta", "--quiet"]).assert().success();
    assert!(results(&desk.path("o")) == results(&desk.path("whole")));
}

#[test]
fn a_body_that_diverges_is_frozen_if_asked_for_and_stays_so_when_a_run_goes_on() {
    let beside = SHEET.split_once("[[body]]").unwrap().1;
    let beside = beside.replace("\"sheet\"", "\"tin\"\nplace.position = [5.0, 0.0, 0.0]");
    let desk = Desk::with(&format!("{SHEET}[[body]]{beside}"));
    let run = |out: &str, more: &[&str]| {
        let words = ["run", "scene.toml", "--set", "body.tin.springs.structural.k=3000", out];
        ending(desk.taffeta(&[&words[..], more].concat()))
    };
    let freeze = ["--on-divergence", "freeze"];
    let (out, err, code) = run("--out=o", &[&freeze[..], &["--frames", "40"]].concat());
    assert_eq!(code, Some(0), "{err}");
    assert!(err.contains("body `tin`") && err.contains("the others go on"), "{err}");
    assert!(out.contains("warning: body `tin` was frozen as it was before frame "), "{out}");
    let summary = desk.json("o/summary.json");
    assert_eq!(summary["status"], "done");
    let frozen = summary["bodies"][1]["frozen"].as_u64().unwrap();
    assert!(summary["bodies"][0]["frozen"].is_null() && frozen < 30);
    // Stopped when it is frozen, it goes on to the same.
    run("--out=part", &[&freeze[..], &["--frames", "30", "--checkpoint-every", "30"]].concat());
    let (_, err, code) = run("--resume=part", &["--frames", "40"]);
    assert_eq!(code, Some(0), "{err}");
    let [mut part, whole] = ["part", "o"].map(|folder| results(&desk.path(folder)));
    part.remove("checkpoint.taffeta");
    assert!(part == whole);
    // From a run that was to stop it goes on if it is asked to.
    let stops = run("--out=stop", &["--frames", "40", "--checkpoint-every", "1"]);
    assert_eq!(stops.2, Some(1), "{}", stops.1);
    let on = run("--resume=stop", &freeze);
    assert_eq!(on.2, Some(0), "{}", on.1);
    let [mut stop, whole] = ["stop", "o"].map(|folder| results(&desk.path(folder)));
    stop.remove("checkpoint.taffeta");
    assert!(stop == whole);
}
