//! What a bench prints.

use crate::console::grouped;
use crate::limits::Limits;
use serde::Serialize;
use std::collections::BTreeMap;
use taffeta::diagnostics::SolverReport;

/// The line that a bench prints.
#[derive(Serialize)]
pub struct Line {
    pub bench: &'static str,
    /// Which of its scenes.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub case: Option<&'static str>,
    pub backend: &'static str,
    pub device: String,
    /// Of a GPU.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub kernels: Option<&'static str>,
    /// How the volume is kept, or implicit constraints are solved, where that is what is measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub form: Option<&'static str>,
    /// How springs are solved, where that is what is measured.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub method: Option<&'static str>,
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
    /// What the solver for constraints did in the frames that were looked at.
    #[serde(skip_serializing_if = "Option::is_none", flatten)]
    pub solved: Option<Solved>,
    /// Time of a frame by that of springs alone.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_springs: Option<f64>,
    /// Time of a frame by that with a sphere for the mesh.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub over_sphere: Option<f64>,
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

/// What a solver for constraints did in the frames that were looked at: all on a CPU, on a GPU the last of each batch.
#[derive(Clone, Copy, Serialize)]
pub struct Solved {
    /// Mean over frames of the most iterations in a sub-step.
    pub iterations: f64,
    /// Most iterations in a sub-step.
    pub most_iterations: u32,
    /// Largest residual, relative to the right side.
    pub residual: f64,
    /// Mean share of springs that were constraints.
    pub active_fraction: f64,
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
        let case = self.case.map_or_else(String::new, |name| format!(" {name}"));
        let method = self.method.map_or_else(String::new, |name| format!(", method: {name}"));
        let mut lines = vec![
            format!(
                "{}{case} {} on {}, {}{method}{kernels}{form}",
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
        if let Some(solved) = &self.solved {
            lines.push(solved.words());
        }
        if let Some(ratio) = self.over_springs {
            lines.push(format!("  {:+.1} % over springs alone", (ratio - 1.0) * 1e2));
        }
        if let Some(ratio) = self.over_sphere {
            lines.push(format!("  {ratio:.2} times the same with a sphere"));
        }
        if !self.ms_by_stage.is_empty() {
            let stages: Vec<String> =
                self.ms_by_stage.iter().map(|(name, ms)| format!("{name} {ms:.3} ms")).collect();
            lines.push(format!("  by stage, timed apart: {}", stages.join(", ")));
        }
        lines.extend(self.note.iter().map(|note| format!("  {note}")));
        lines.join("\n")
    }
}

impl Solved {
    /// Of some frames; nothing where there are no constraints.
    pub fn of(reports: &[SolverReport]) -> Option<Self> {
        let mean = |of: fn(&SolverReport) -> f64| reports.iter().map(of).sum::<f64>() / reports.len() as f64;
        let most_iterations = reports.iter().map(|report| report.iterations).max()?;
        Some(Self {
            iterations: mean(|report| report.iterations.into()),
            most_iterations,
            residual: reports.iter().map(|report| report.residual).fold(0.0, f64::max),
            active_fraction: mean(|report| report.active_fraction),
        })
    }

    fn words(&self) -> String {
        format!(
            "  {:.1} iterations a step (at most {}), residual at most {:.1e}, {:.1} % of the springs constraints",
            self.iterations,
            self.most_iterations,
            self.residual,
            self.active_fraction * 1e2
        )
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
