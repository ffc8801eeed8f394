//! What a check has found, as its JSON file has it.

use super::device::Device;
use super::parity::Row;
use super::readback::ReadBack;
use super::scenes::Compared;
use super::speed::Speed;
use crate::gpu::Copied;
use serde::Serialize;
use taffeta::taffeta_gpu::Gpu;

/// Everything.
#[derive(Serialize)]
pub struct Report {
    /// Of the program.
    pub version: &'static str,
    /// That the program was built from, where the build was told.
    pub commit: Option<&'static str>,
    /// Whether scenes were small and frames few.
    pub quick: bool,
    /// Words of which the name of each part has one; all parts, if there are none.
    pub only: Vec<String>,
    /// Whether the check came to its end.
    pub complete: bool,
    /// Wall time [s].
    pub seconds: f64,
    pub device: Device,
    pub parity: Vec<Row>,
    pub scenes: Vec<Compared>,
    pub copy: Option<Copied>,
    pub substep: Option<Substep>,
    pub speeds: Vec<Speed>,
    pub read_back: Option<ReadBack>,
    /// Parts that could not be done, and why.
    pub faults: Vec<String>,
}

/// What a sub-step costs with each step on its own.
#[derive(Serialize)]
pub struct Substep {
    /// Whatever the number of nodes [µs].
    pub microseconds: f64,
    /// A node of a grid [ns].
    pub nanoseconds_per_node: f64,
}

impl Report {
    /// Nothing checked yet.
    pub fn new(gpu: &Gpu, quick: bool, only: &[String]) -> Self {
        Self {
            version: env!("CARGO_PKG_VERSION"),
            commit: option_env!("TAFFETA_COMMIT"),
            quick,
            only: only.to_owned(),
            complete: false,
            seconds: 0.0,
            device: Device::of(gpu),
            parity: Vec::new(),
            scenes: Vec::new(),
            copy: None,
            substep: None,
            speeds: Vec::new(),
            read_back: None,
            faults: Vec::new(),
        }
    }

    /// Checks whose results were wrong, or that could not be run. Without a row there was no comparison.
    pub fn failed(&self) -> usize {
        let rows = self.parity.iter().filter(|row| !row.passed).count();
        let scenes = self.scenes.iter().filter(|scene| !scene.passed).count();
        let missing = usize::from(self.parity.is_empty()) + usize::from(self.scenes.is_empty());
        rows + scenes + if self.only.is_empty() { missing } else { 0 }
    }

    /// Whether no part was asked for that there is.
    pub fn is_empty(&self) -> bool {
        let measured = self.copy.is_some() || self.substep.is_some() || self.read_back.is_some();
        let checked = !self.parity.is_empty() || !self.scenes.is_empty() || !self.speeds.is_empty();
        !measured && !checked && self.faults.is_empty()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_differs_or_was_not_compared_has_failed() {
        let gpu = Gpu::open(&taffeta::taffeta_gpu::Choice::from_env()).expect("an adapter");
        let mut report = Report::new(&gpu, true, &[]);
        assert_eq!(report.failed(), 2, "nothing was compared");
        let row = |passed| Row {
            name: "kernel".into(),
            ulps: None,
            allowed: 1.0,
            compared: 1,
            place: None,
            passed,
            error: None,
        };
        report.parity = vec![row(true), row(false), row(true)];
        assert_eq!(report.failed(), 2, "one kernel differs, and no scene was run");
    }
}
