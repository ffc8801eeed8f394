//! The report of a frame as an object, with the names of docs/outputs.md.

use crate::object::{Object, list, or_null};
use taffeta::Simulation;
use taffeta::diagnostics::{FrameReport, energy_kinds};
use wasm_bindgen::JsValue;

/// A frame in numbers.
pub fn object(simulation: &Simulation) -> JsValue {
    let report = simulation.report();
    let object = Object::new()
        .with("frame", report.frame)
        .with("time", report.time)
        .with("substeps", report.substeps as f64)
        .with("momentum", list(report.momentum))
        .with("angular_momentum", list(report.angular_momentum))
        .with("max_stretch", report.max_stretch)
        .with("strain", strain(report))
        .with("contacts", report.contacts as f64)
        .with("pairs", report.pairs as f64)
        .with("nearest_pair", or_null(report.nearest_pair))
        .with("pair_searches", report.pair_searches as f64)
        .with("intersections", or_null(report.intersections.map(|count| count as f64)))
        .with("iterations", report.solver.iterations as f64)
        .with("residual", report.solver.residual)
        .with("active_fraction", report.solver.active_fraction)
        .with("capped", report.solver.capped as f64)
        .with("broken", report.broken as f64)
        .with("asleep", report.asleep as f64);
    of_bodies(energies(object, report), simulation, report)
        .with("squeezed", squeezed(simulation, report))
        .into()
}

/// Energies [J], also those of kinds that the scene has none of.
fn energies(object: Object, report: &FrameReport) -> Object {
    let object = object
        .with("kinetic", report.kinetic)
        .with("gravitational", report.gravitational)
        .with("springs", report.springs)
        .with("energy", report.energy());
    energy_kinds().fold(object, |object, kind| object.with(kind, report.energy_of(kind)))
}

fn strain(report: &FrameReport) -> JsValue {
    let of = |strain: &taffeta::diagnostics::FabricStrain| {
        let object = Object::new().with("warp", list(strain.warp)).with("weft", list(strain.weft));
        object.with("shear", strain.shear)
    };
    or_null(report.strain.as_ref().map(of))
}

/// Volumes by body, and reactions by body and pin.
fn of_bodies(object: Object, simulation: &Simulation, report: &FrameReport) -> Object {
    let [mut volumes, mut targets, mut reactions] = [(); 3].map(|()| Object::new());
    for (index, body) in simulation.bodies().iter().enumerate() {
        if let Some(volume) = report.volumes.get(index).copied().flatten() {
            volumes = volumes.with(&body.name, volume);
        }
        if let Some(target) = report.volume_targets.get(index).copied().flatten() {
            targets = targets.with(&body.name, target);
        }
        if body.pins > 0 {
            let of_pins = (0..body.pins).map(|pin| or_null(report.reaction(index, pin).map(list)));
            reactions = reactions.with(&body.name, list(of_pins));
        }
    }
    object.with("volumes", volumes).with("volume_targets", targets).with("reactions", reactions)
}

fn squeezed(simulation: &Simulation, report: &FrameReport) -> JsValue {
    let Some(squeezed) = &report.squeezed else { return JsValue::NULL };
    let body = simulation.bodies().get(squeezed.body).map(|body| body.name.clone());
    let colliders = squeezed.colliders.iter().filter_map(|&index| simulation.colliders().get(index));
    Object::new()
        .with("body", or_null(body))
        .with("vertex", squeezed.vertex as u32)
        .with("colliders", list(colliders.map(|collider| collider.name.clone())))
        .into()
}
