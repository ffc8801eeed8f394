//! What a bench prints.

use crate::console::grouped;
use crate::limits::Limits;
use serde::Serialize;
use std::collections::BTreeMap;

/// The line that a bench prints.
#[derive(Serialize)]
pub struct Line {
    pub bench: &'static str,
    pub backend: &'static str,
    pub device: String,
    /// Of a GPU.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernels: Option<&'static str>,
    /// How the volume is kept, where that is what is measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<&'static str>,
    /// How pairs of nodes are found, where that is what is measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub rung: Option<&'static str>,
    pub precision: String,
    pub n: Vec<u32>,
    pub nodes: usize,
    pub springs: usize,
    pub substeps_per_frame: u32,
    /// Frames that were timed.
    pub frames: usize,
    /// Frames that a GPU does one after the other without the host.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub frames_between_waits: Option<u32>,
    pub ms_per_frame: Spread,
    /// Sub-steps a second.
    pub steps_per_s: f64,
    pub particle_substeps_per_s: f64,
    pub springs_per_s: f64,
    /// Time of each stage of a GPU that tells, in a frame where they are timed apart [ms].
    #[serde(skip_serializing_if = "BTreeMap::is_empty")]
    pub ms_by_stage: BTreeMap<&'static str, f64>,
    pub limits: Shares,
    #[serde(skip_serializing_if = "Option::is_none")]
    pub note: Option<String>,
}

#[derive(Serialize)]
pub struct Spread {
    pub min: f64,
    pub median: f64,
    pub max: f64,
}

/// The device's limits, and the share of each that the median frame used.
#[derive(Serialize)]
#[serde(untagged)]
pub enum Shares {
    Cpu {
        #[serde(flatten)]
        machine: Limits,
        memory_fraction: f64,
        fma_fraction: f64,
    },
    Gpu {
        memory_gb_per_s: f64,
        memory_fraction: f64,
    },
}

impl Line {
    /// For people.
    pub fn table(&self) -> String {
        let n: Vec<String> = self.n.iter().map(u32::to_string).collect();
        let kernels = self.kernels.map_or_else(String::new, |name| format!(", kernels: {name}"));
        let form = self.form.map_or_else(String::new, |name| format!(", form: {name}"));
        let rung = self.rung.map_or_else(String::new, |name| format!(", rung: {name}"));
        let mut lines = vec![
            format!(
                "{} {} on {}, {}{kernels}{form}{rung}",
                self.bench,
                n.join("×"),
                self.device,
                self.precision
            ),
            format!("  {} nodes, {} springs", grouped(self.nodes), grouped(self.springs)),
            format!(
                "  {:.3} ms a frame of {} sub-steps (median of {}; {:.3} to {:.3})",
                self.ms_per_frame.median,
                self.substeps_per_frame,
                self.frames,
                self.ms_per_frame.min,
                self.ms_per_frame.max
            ),
            format!(
                "  {:.0} sub-steps/s, {:.0} M particle-substeps/s, {:.0} M springs/s",
                self.steps_per_s,
                self.particle_substeps_per_s * 1e-6,
                self.springs_per_s * 1e-6
            ),
            self.limits.words(),
        ];
        if !self.ms_by_stage.is_empty() {
            let stages: Vec<String> =
                self.ms_by_stage.iter().map(|(name, ms)| format!("{name} {ms:.3} ms")).collect();
            lines.push(format!("  by stage, timed apart: {}", stages.join(", ")));
        }
        lines.extend(self.note.iter().map(|note| format!("  {note}")));
        lines.join("\n")
    }
}

impl Shares {
    fn words(&self) -> String {
        match self {
            Self::Cpu { machine, memory_fraction, fma_fraction } => format!(
                "  {:.0} % of {:.1} GB/s (state once in, once out), {:.0} % of {:.0} GFLOP/s",
                memory_fraction * 1e2,
                machine.memory_gb_per_s,
                fma_fraction * 1e2,
                machine.fma_gflop_per_s
            ),
            Self::Gpu { memory_gb_per_s, memory_fraction } => format!(
                "  {:.0} % of {memory_gb_per_s:.1} GB/s of a copy (64 bytes a node and sub-step)",
                memory_fraction * 1e2,
            ),
        }
    }
}
