//! Every kernel beside its twin on the CPU.

use super::guard::guarded;
use serde::Serialize;
use taffeta::parity;
use taffeta::taffeta_gpu::Gpu;

/// What one comparison has found.
#[derive(Serialize)]
pub struct Row {
    pub name: String,
    /// Largest difference, in units in the last place; null where it is infinite or the row did not run.
    pub ulps: Option<f64>,
    /// The largest that is allowed on this adapter.
    pub allowed: f64,
    /// Numbers compared.
    pub compared: usize,
    /// Where the largest difference is.
    pub place: Option<String>,
    pub passed: bool,
    /// Why the kernel could not be run.
    pub error: Option<String>,
}

/// Runs one row.
pub fn run(row: &parity::Row, gpu: &Gpu) -> Row {
    let allowed = row.tolerance.on(gpu);
    let name = row.name.to_owned();
    match guarded(|| row.run(gpu)) {
        Ok(found) => Row {
            name,
            ulps: Some(found.ulps).filter(|ulps| ulps.is_finite()),
            allowed,
            compared: found.compared,
            place: found.place.map(|place| place.to_string()),
            passed: found.compared > 0 && found.ulps <= allowed,
            error: None,
        },
        Err(error) => {
            Row { name, ulps: None, allowed, compared: 0, place: None, passed: false, error: Some(error) }
        }
    }
}
