//! Elements: what acts between a few neighbouring nodes, or on a node alone.

pub mod aero;
pub mod bending;
pub mod cpu;
pub mod directions;
pub mod element;
pub mod fabric;
pub mod gathered;
#[cfg(feature = "gpu")]
pub mod gpu;
pub mod hinge;
pub mod lanes;
pub mod load;
pub mod membrane;
#[cfg(feature = "gpu")]
pub mod parity;
pub mod sets;
pub mod spring;

use element::Kind;

/// All kinds of elements whose forces are found one by one, in the order in which nodes add them up.
pub const KINDS: [&Kind; 4] = [&hinge::KIND, &membrane::KIND, &bending::KIND, &aero::KIND];

/// The kinds of elements that have an energy, in the order of reports.
///
/// ```
/// use taffeta::diagnostics::{FrameReport, energy_kinds};
///
/// // A line of a table that has the same columns for every scene.
/// let report = FrameReport::default();
/// let line: Vec<(&str, f64)> = energy_kinds().map(|kind| (kind, report.energy_of(kind))).collect();
/// assert!(line.contains(&("hinges", 0.0)));
/// ```
pub fn energy_kinds() -> impl Iterator<Item = &'static str> {
    KINDS.iter().filter(|kind| kind.kernels.energies.is_some()).map(|kind| kind.name)
}
