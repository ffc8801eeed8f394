//! `frames.csv`: a row a frame, complete at any time.

use super::part::Part;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use taffeta::diagnostics::FrameReport;

/// Writes the table of frames.
pub struct FrameTable {
    part: Part,
    /// For each body, whether it has a column for its volume.
    closed: Vec<bool>,
}

impl FrameTable {
    /// Starts the file at `path`. `bodies` are names, and whether the body is closed and has a volume.
    pub fn create(path: &Path, bodies: &[(String, bool)]) -> io::Result<Self> {
        let mut part = Part::create(path)?;
        write!(part, "frame,time,kinetic,gravitational,springs,hinges,energy,px,py,pz,max_stretch,contacts")?;
        for (name, _) in bodies.iter().filter(|(_, closed)| *closed) {
            write!(part, ",{}", quoted(&format!("volume_{name}")))?;
        }
        writeln!(part, ",ms")?;
        part.flush()?;
        Ok(Self { part, closed: bodies.iter().map(|(_, closed)| *closed).collect() })
    }

    /// Adds a frame that took `ms` [ms].
    pub fn row(&mut self, report: &FrameReport, ms: f64) -> io::Result<()> {
        let r = report;
        let [px, py, pz] = r.momentum;
        write!(
            self.part,
            "{},{},{},{},{},{},{},{px},{py},{pz},{},{}",
            r.frame,
            r.time,
            r.kinetic,
            r.gravitational,
            r.springs,
            r.hinges,
            r.energy(),
            r.max_stretch,
            r.contacts
        )?;
        for (body, _) in self.closed.iter().enumerate().filter(|(_, closed)| **closed) {
            match r.volumes.get(body).copied().flatten() {
                Some(volume) => write!(self.part, ",{volume}")?,
                None => write!(self.part, ",")?,
            }
        }
        writeln!(self.part, ",{ms}")?;
        self.part.flush()
    }

    /// Completes the file and gives it its name, which is returned.
    pub fn finish(self) -> io::Result<PathBuf> {
        self.part.finish()
    }
}

/// A field of a CSV file.
fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) {
        format!("\"{}\"", field.replace('"', "\"\""))
    } else {
        field.to_owned()
    }
}
