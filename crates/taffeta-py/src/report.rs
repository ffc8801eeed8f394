//! The report of a frame as a dict.

use pyo3::prelude::*;
use pyo3::types::PyDict;
use taffeta::Simulation;
use taffeta::diagnostics::{FrameReport, energy_kinds};

/// What a report names: bodies with their numbers of pins, and colliders.
pub struct Names {
    pub bodies: Vec<(String, usize)>,
    pub colliders: Vec<String>,
}

impl Names {
    /// Those of a simulation.
    pub fn of(simulation: &Simulation) -> Self {
        Self {
            bodies: simulation.bodies().iter().map(|body| (body.name.clone(), body.pins)).collect(),
            colliders: simulation.colliders().iter().map(|collider| collider.name.clone()).collect(),
        }
    }
}

/// A frame in numbers.
pub fn dict<'py>(py: Python<'py>, report: &FrameReport, names: &Names) -> PyResult<Bound<'py, PyDict>> {
    let dict = PyDict::new(py);
    dict.set_item("frame", report.frame)?;
    dict.set_item("time", report.time)?;
    dict.set_item("substeps", report.substeps)?;
    energies(&dict, report)?;
    dict.set_item("momentum", report.momentum)?;
    dict.set_item("angular_momentum", report.angular_momentum)?;
    dict.set_item("max_stretch", report.max_stretch)?;
    strain(&dict, report)?;
    dict.set_item("contacts", report.contacts)?;
    dict.set_item("pairs", report.pairs)?;
    dict.set_item("nearest_pair", report.nearest_pair)?;
    dict.set_item("pair_searches", report.pair_searches)?;
    dict.set_item("intersections", report.intersections)?;
    dict.set_item("iterations", report.solver.iterations)?;
    dict.set_item("residual", report.solver.residual)?;
    dict.set_item("active_fraction", report.solver.active_fraction)?;
    dict.set_item("capped", report.solver.capped)?;
    dict.set_item("broken", report.broken)?;
    dict.set_item("asleep", report.asleep)?;
    of_bodies(&dict, names, report)?;
    squeezed(&dict, names, report)?;
    Ok(dict)
}

/// Energies [J], also those of kinds that the scene has none of.
fn energies(dict: &Bound<'_, PyDict>, report: &FrameReport) -> PyResult<()> {
    dict.set_item("kinetic", report.kinetic)?;
    dict.set_item("gravitational", report.gravitational)?;
    dict.set_item("springs", report.springs)?;
    energy_kinds().try_for_each(|kind| dict.set_item(kind, report.energy_of(kind)))?;
    dict.set_item("energy", report.energy())
}

fn strain(dict: &Bound<'_, PyDict>, report: &FrameReport) -> PyResult<()> {
    let Some(strain) = &report.strain else { return dict.set_item("strain", dict.py().None()) };
    let all = PyDict::new(dict.py());
    all.set_item("warp", strain.warp)?;
    all.set_item("weft", strain.weft)?;
    all.set_item("shear", strain.shear)?;
    dict.set_item("strain", all)
}

/// Volumes by body, and reactions by body and pin.
fn of_bodies(dict: &Bound<'_, PyDict>, names: &Names, report: &FrameReport) -> PyResult<()> {
    let (volumes, targets, reactions) =
        (PyDict::new(dict.py()), PyDict::new(dict.py()), PyDict::new(dict.py()));
    for (index, (name, pins)) in names.bodies.iter().enumerate() {
        if let Some(volume) = report.volumes.get(index).copied().flatten() {
            volumes.set_item(name, volume)?;
        }
        if let Some(target) = report.volume_targets.get(index).copied().flatten() {
            targets.set_item(name, target)?;
        }
        if *pins > 0 {
            let of_pins: Vec<_> = (0..*pins).map(|pin| report.reaction(index, pin)).collect();
            reactions.set_item(name, of_pins)?;
        }
    }
    dict.set_item("volumes", volumes)?;
    dict.set_item("volume_targets", targets)?;
    dict.set_item("reactions", reactions)
}

fn squeezed(dict: &Bound<'_, PyDict>, names: &Names, report: &FrameReport) -> PyResult<()> {
    let Some(squeezed) = &report.squeezed else { return dict.set_item("squeezed", dict.py().None()) };
    let all = PyDict::new(dict.py());
    all.set_item("body", names.bodies.get(squeezed.body).map(|(name, _)| name))?;
    all.set_item("vertex", squeezed.vertex)?;
    let colliders = squeezed.colliders.iter().filter_map(|&index| names.colliders.get(index));
    all.set_item("colliders", colliders.collect::<Vec<_>>())?;
    dict.set_item("squeezed", all)
}
