//! A GPU that is lost in the middle of a run, and memory that is full.

use super::*;
use crate::run::{Args, close};
use clap::Parser;
use std::path::Path;
use std::sync::Arc;
use taffeta::Options;
use taffeta::taffeta_gpu::Gpu;
use taffeta_io::Loaded;

const SCENE: &str = r#"
[time]
dt = 0.01
max_step = 0.005
frames = 6
[[body]]
name = "sheet"
node_mass = 0.01
mesh.grid = { rows = 4, cols = 5, size = [0.4, 0.3] }
springs.structural = { k = 50.0, d = 0.05 }
pin = [{ select = { nodes = [0, 4] } }]
"#;

#[derive(Parser)]
struct Line {
    #[command(flatten)]
    args: Args,
}

/// A folder with a scene in it.
struct Desk(tempfile::TempDir);

impl Desk {
    fn new() -> Self {
        let desk = Self(tempfile::tempdir().unwrap());
        std::fs::write(desk.0.path().join("scene.toml"), SCENE).unwrap();
        desk
    }

    fn args(&self, words: &str) -> Args {
        let scene = self.0.path().join("scene.toml");
        let out = format!("--out={}", self.out().display());
        let words = words.split(' ').map(str::to_owned);
        let line = ["run".to_owned(), scene.display().to_string(), out, "--quiet".to_owned()];
        Line::parse_from(line.into_iter().chain(words)).args
    }

    fn out(&self) -> PathBuf {
        self.0.path().join("o")
    }

    fn summary(&self) -> serde_json::Value {
        serde_json::from_str(&std::fs::read_to_string(self.out().join("summary.json")).unwrap()).unwrap()
    }

    fn frames(&self) -> usize {
        let text = std::fs::read_to_string(self.out().join("frames.csv")).unwrap();
        // The first line has the names.
        text.lines().count() - 1
    }
}

fn prepared(args: &Args) -> (Loaded, Plan) {
    std::fs::create_dir_all(args.out.as_ref().unwrap()).unwrap();
    let loaded = taffeta_io::load_scene(&args.scene, &[]).unwrap();
    let plan = Plan::new(args, &loaded).unwrap();
    (loaded, plan)
}

fn job<'a>(plan: &'a Plan, loaded: &Loaded, gpu: Gpu) -> Job<'a> {
    let options = Options { gpu: Some(gpu.into()), ..Options::default() };
    let simulation = Simulation::new(&loaded.scene, &options).unwrap();
    Job::new(plan, simulation, &loaded.scene).unwrap()
}

fn whole(desk: &Desk, words: &str) {
    let args = desk.args(words);
    let (loaded, plan) = prepared(&args);
    let mut job = job(&plan, &loaded, crate::gpu::open().unwrap());
    let ending = job.run(true, &Arc::new(AtomicBool::new(false)));
    close(&args, &loaded, job, ending).unwrap();
}

fn bytes(path: &Path) -> Vec<u8> {
    std::fs::read(path).unwrap()
}

#[test]
fn a_lost_gpu_leaves_the_good_frames_and_a_checkpoint_from_which_another_goes_on() {
    let desk = Desk::new();
    let args = desk.args("--format=npy,obj --checkpoint-every=2");
    let (loaded, plan) = prepared(&args);
    let gpu = crate::gpu::open().unwrap();
    let mut lost = job(&plan, &loaded, gpu.clone());
    let first = Plan { end: 3, ..prepared(&args).1 };
    lost.plan = &first;
    assert!(matches!(lost.frames(true, &Arc::new(AtomicBool::new(false))), Ok(Ending::Done)));
    lost.plan = &plan;
    gpu.lose();
    let ending = lost.run(true, &Arc::new(AtomicBool::new(false)));
    assert!(matches!(ending, Ending::Lost(_)));
    let said = close(&args, &loaded, lost, ending).unwrap_err().to_string();
    assert!(said.starts_with("error: frame 4: the GPU was lost: "), "{said}");
    assert!(said.contains("\nframes 0 to 3 are in "), "{said}");
    assert!(said.contains("\ncheckpoint at frame 2; to go on: taffeta run "), "{said}");

    let summary = desk.summary();
    assert_eq!((&summary["status"], &summary["frames"]), (&"failed".into(), &3.into()));
    assert_eq!((&summary["backend"], &summary["state_hash"]), (&"gpu".into(), &serde_json::Value::Null));
    assert_eq!(summary["files"], serde_json::json!(["positions.npy", "frames.csv", "sheet.obj"]));
    assert_eq!(desk.frames(), 4);
    let npy = bytes(&desk.out().join("positions.npy"));
    let numbers = npy[npy.len() - 4 * 20 * 3 * 4..].as_chunks().0;
    assert!(numbers.iter().all(|number| f32::from_le_bytes(*number).is_finite()));
    let pose = String::from_utf8(bytes(&desk.out().join("sheet.obj"))).unwrap();
    // Normals would be those of a state that is gone.
    assert!(pose.contains("\nv ") && !pose.contains("NaN") && !pose.contains("\nvn "), "{pose}");

    whole(&desk, &format!("--resume={}", desk.out().display()));
    let other = Desk::new();
    whole(&other, "--format=npy,obj");
    assert_eq!(desk.frames(), 7);
    assert_eq!(desk.summary()["state_hash"], other.summary()["state_hash"]);
    for name in ["positions.npy", "sheet.obj"] {
        assert!(bytes(&desk.out().join(name)) == bytes(&other.out().join(name)), "{name} differs");
    }
}

#[test]
fn memory_that_is_full_ends_a_run_with_a_checkpoint() {
    let desk = Desk::new();
    let args = desk.args("--format=npy");
    let (loaded, plan) = prepared(&args);
    let simulation = Simulation::new(&loaded.scene, &Options::default()).unwrap();
    let mut job = Job::new(&plan, simulation, &loaded.scene).unwrap();
    job.memory = Watch { foreseen: 0, expected: 0, before: 0, free: || 0 };
    let ending = job.run(true, &Arc::new(AtomicBool::new(false)));
    let said = close(&args, &loaded, job, ending).unwrap_err().to_string();
    assert!(said.contains(" of memory and 0 bytes are free: "), "{said}");
    assert!(said.contains("\nframes 0 to 1 are in "), "{said}");
    assert!(said.contains("\ncheckpoint at frame 1; to go on: taffeta run "), "{said}");
    assert_eq!((&desk.summary()["status"], desk.frames()), (&"interrupted".into(), 2));
}

#[test]
fn a_gpu_lost_before_the_first_frame_leaves_no_frame() {
    let desk = Desk::new();
    let args = desk.args("--format=npy,obj");
    let (loaded, plan) = prepared(&args);
    let gpu = crate::gpu::open().unwrap();
    let mut job = job(&plan, &loaded, gpu.clone());
    gpu.lose();
    let ending = job.run(true, &Arc::new(AtomicBool::new(false)));
    let said = close(&args, &loaded, job, ending).unwrap_err().to_string();
    assert!(said.contains("\nno frame is in "), "{said}");
    assert_eq!(desk.summary()["files"], serde_json::json!(["positions.npy", "frames.csv"]));
}
