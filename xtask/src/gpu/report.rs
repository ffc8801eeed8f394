//! What `taffeta gpu-check` has found, as far as pages show it.

use serde::Deserialize;

#[derive(Deserialize)]
pub struct Report {
    pub version: String,
    pub commit: Option<String>,
    pub quick: bool,
    #[serde(default)]
    pub only: Vec<String>,
    /// Whether the check came to its end.
    pub complete: bool,
    pub seconds: f64,
    pub device: Device,
    pub parity: Vec<Row>,
    pub scenes: Vec<Scene>,
    pub copy: Option<Copy>,
    pub substep: Option<Substep>,
    pub speeds: Vec<Speed>,
    pub read_back: Option<ReadBack>,
    pub faults: Vec<String>,
}

#[derive(Deserialize)]
pub struct Device {
    pub name: String,
    pub api: String,
    pub kind: String,
    pub driver: String,
    pub software: bool,
    pub host: String,
}

/// A kernel beside its twin.
#[derive(Deserialize)]
pub struct Row {
    pub name: String,
    pub ulps: Option<f64>,
    pub allowed: f64,
    pub place: Option<String>,
    pub passed: bool,
    pub error: Option<String>,
}

/// A scene beside itself on the CPU [m].
#[derive(Deserialize)]
pub struct Scene {
    pub name: String,
    pub kernels: String,
    pub frames: u32,
    pub apart: Option<f64>,
    pub allowed: f64,
    pub same_twice: bool,
    pub passed: bool,
    pub error: Option<String>,
}

#[derive(Deserialize)]
pub struct Copy {
    pub kernel_gb_per_s: f64,
    pub buffer_gb_per_s: f64,
}

#[derive(Deserialize)]
pub struct Substep {
    pub microseconds: f64,
    pub nanoseconds_per_node: f64,
}

#[derive(Deserialize)]
pub struct Speed {
    pub part: String,
    pub kernels: String,
    pub n: [u32; 2],
    pub nodes: u64,
    pub springs: u64,
    pub ms_per_substep: Spread,
    pub particle_substeps_per_s: f64,
    pub springs_per_s: f64,
    pub gb_per_s: f64,
    pub copy_fraction: Option<f64>,
}

#[derive(Deserialize)]
pub struct Spread {
    pub min: f64,
    pub median: f64,
    pub max: f64,
}

#[derive(Deserialize)]
pub struct ReadBack {
    pub n: [u32; 2],
    pub ms_without_waiting: f64,
    pub ms_with_report: f64,
    pub ms_with_state: f64,
}

impl Report {
    /// The measurement of a scene with some kernels.
    pub fn speed(&self, part: &str, n: [u32; 2], kernels: &str) -> Option<&Speed> {
        self.speeds.iter().find(|one| one.part == part && one.n == n && one.kernels == kernels)
    }

    /// Whether the GPU computes what the CPU does, in words.
    pub fn verdict(&self) -> String {
        let (rows, scenes) = (self.parity.len(), self.scenes.len());
        let good_rows = self.parity.iter().filter(|row| row.passed).count();
        let good_scenes = self.scenes.iter().filter(|scene| scene.passed).count();
        let all = rows > 0 && scenes > 0 && (good_rows, good_scenes) == (rows, scenes);
        let word = if all {
            "The GPU computes what the CPU does"
        } else {
            "**The GPU does NOT compute what the CPU does**"
        };
        format!("{word}: {good_rows} of {rows} kernels and {good_scenes} of {scenes} scenes agree.")
    }
}

#[cfg(test)]
pub const EXAMPLE: &str = r#"{
  "version": "0.1.0", "commit": "abc1234", "quick": false, "complete": true, "seconds": 90.5,
  "device": { "name": "Example GPU 3000", "kind": "discrete", "api": "vulkan", "driver": "Example 1.2", "software": false,
    "timestamps": true, "host": "linux, x86_64", "limits": { "storage_binding_bytes": 4294967295 } },
  "parity": [
    { "name": "euler", "ulps": 0.5, "allowed": 4.0, "compared": 100, "place": null, "passed": true, "error": null },
    { "name": "fold_of", "ulps": null, "allowed": 4.0, "compared": 100, "place": "fold[3] is 1e0 on the CPU and NaN on the GPU",
      "passed": false, "error": null } ],
  "scenes": [ { "name": "flag", "kernels": "best", "frames": 20, "apart": 2e-7, "vertex": 17, "allowed": 1e-4,
    "same_twice": true, "passed": true, "error": null } ],
  "copy": { "kernel_gb_per_s": 4000.0, "buffer_gb_per_s": 3900.0, "bytes": 536870912 },
  "substep": { "microseconds": 3.5, "nanoseconds_per_node": 0.02 },
  "speeds": [
    { "part": "grid", "kernels": "best", "n": [1368, 5717], "nodes": 7820856, "springs": 46882626, "substeps_per_frame": 34,
      "frames_per_batch": 10, "batches": 7, "ms_per_substep": { "min": 0.24, "median": 0.25, "max": 0.26 },
      "particle_substeps_per_s": 3.1283e10, "springs_per_s": 1.8753e11, "gb_per_s": 2002.1, "copy_fraction": 0.5005 },
    { "part": "kernels", "kernels": "best", "n": [32, 32], "nodes": 1024, "springs": 5890, "substeps_per_frame": 34,
      "frames_per_batch": 10, "batches": 7, "ms_per_substep": { "min": 0.001, "median": 0.002, "max": 0.003 },
      "particle_substeps_per_s": 5.12e8, "springs_per_s": 2.9e9, "gb_per_s": 32.8, "copy_fraction": 0.0082 },
    { "part": "kernels", "kernels": "node-centric", "n": [32, 32], "nodes": 1024, "springs": 5890, "substeps_per_frame": 34,
      "frames_per_batch": 10, "batches": 7, "ms_per_substep": { "min": 0.004, "median": 0.005, "max": 0.006 },
      "particle_substeps_per_s": 2.05e8, "springs_per_s": 1.2e9, "gb_per_s": 13.1, "copy_fraction": 0.0033 } ],
  "read_back": { "n": [512, 512], "ms_without_waiting": 0.5, "ms_with_report": 0.7, "ms_with_state": 3.0 },
  "faults": [ "mesh 1000×334, best: the GPU has no memory left" ]
}"#;
