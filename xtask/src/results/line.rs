//! What a bench printed, and what it was run on.

use serde::Deserialize;
use std::path::Path;

/// A measured line. The file also keeps what the tables do not use.
#[derive(Clone, Deserialize)]
pub struct Line {
    /// The processor in words.
    pub machine: String,
    /// Of the project; `-dirty` where the sources were not as committed.
    pub commit: String,
    /// What was run.
    pub command: String,
    pub bench: String,
    pub n: Vec<u32>,
    pub nodes: usize,
    /// `cpu, 2 threads, avx512`
    pub device: String,
    pub substeps_per_frame: u32,
    pub ms_per_frame: Spread,
    pub particle_substeps_per_s: f64,
    pub springs_per_s: f64,
    pub limits: Shares,
    pub note: Option<String>,
}

#[derive(Clone, Deserialize)]
pub struct Spread {
    pub min: f64,
    pub median: f64,
    pub max: f64,
}

/// Shares of what the machine can do at most, 0 to 1.
#[derive(Clone, Deserialize)]
pub struct Shares {
    pub memory_fraction: f64,
    pub fma_fraction: f64,
}

impl Line {
    /// Threads that ran: those that `device` names.
    pub fn threads(&self) -> usize {
        let number = self.device.split(", ").find_map(|part| part.split_once(" thread")?.0.parse().ok());
        number.unwrap_or(1)
    }

    /// Whether the bench chose its threads itself.
    pub fn free(&self) -> bool {
        !self.command.contains("--threads")
    }
}

/// A file's last line of each command, in the order in which the commands first came.
pub fn latest(file: &Path) -> Result<Vec<Line>, String> {
    let text = std::fs::read_to_string(file).map_err(|error| format!("{}: {error}", file.display()))?;
    let mut lines: Vec<Line> = Vec::new();
    for (index, text) in text.lines().enumerate() {
        let line: Line = serde_json::from_str(text)
            .map_err(|error| format!("{}:{}: {error}", file.display(), index + 1))?;
        match lines.iter_mut().find(|known| known.command == line.command) {
            Some(known) => *known = line,
            None => lines.push(line),
        }
    }
    Ok(lines)
}
