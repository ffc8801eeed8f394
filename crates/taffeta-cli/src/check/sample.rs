//! A scene to begin with: springs that the average node stands at a usual step, and the step that all nodes stand.

use super::report::MeshReport;
use super::{Args, MeshKind};
use std::ffi::OsStr;
use std::sync::Arc;
use taffeta::scene::{Body, Mass, Mesh, Scene};
use taffeta::topology::Surface;
use taffeta::{Options, Simulation};

/// Usual step [s].
const STEP: f64 = 0.0005;
/// Mass per area of cloth [kg/m²].
const AREA_DENSITY: f64 = 0.2;
/// Nodes up to which the step is measured; for more the body is not built.
const MANY: usize = 200_000;

/// A body with structural springs.
pub struct Sample {
    soft: bool,
    mass: Mass,
    scale: Option<f64>,
    stiffness: f64,
    /// Longest step [s].
    pub step: f64,
}

impl Sample {
    /// For what the mesh is to be; for what it can be, where that is left open.
    pub fn new(report: &MeshReport, kind: Option<MeshKind>) -> Self {
        let soft = kind.map_or(report.body.accepted, |kind| kind == MeshKind::Body);
        let scale = report.unit.as_ref().and_then(|unit| unit.scale);
        let area = report.area * scale.unwrap_or(1.0).powi(2);
        let (mass, whole) =
            if soft { (Mass::Whole(1.0), 1.0) } else { (Mass::Area(AREA_DENSITY), AREA_DENSITY * area) };
        Self { soft, mass, scale, stiffness: stiffness(whole / report.nodes as f64), step: STEP }
    }

    /// A scene with this body.
    fn scene(&self, surface: &Arc<Surface>) -> Scene {
        let mesh = Mesh::Surface(Arc::clone(surface));
        let body = if self.soft { Body::soft("", mesh) } else { Body::cloth("", mesh) };
        let mut body = body.with_mass(self.mass).structural(self.stiffness, self.damping());
        body.place.scale = self.scale;
        Scene::new("").body(body)
    }

    /// Memory that building the scene takes [byte], roughly.
    pub fn memory(&self, surface: &Arc<Surface>) -> u64 {
        self.scene(surface).memory_needed().bytes
    }

    /// Shortens the step to one that all nodes stand, of one digit, unless there are very many.
    pub fn measure(&mut self, surface: &Arc<Surface>) {
        if surface.nodes.len() > MANY {
            return;
        }
        let options = Options { threads: Some(1), ..Options::default() };
        if let Ok(simulation) = Simulation::new(&self.scene(surface), &options) {
            self.step = STEP.min(one_digit(simulation.largest_stable_step_folded()));
        }
    }

    fn damping(&self) -> f64 {
        0.5 * self.stiffness * STEP
    }

    /// The scene in TOML, to be saved beside the mesh.
    pub fn toml(&self, args: &Args) -> String {
        let name = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' };
        let body: String = name(args.path.file_stem()).chars().take(25).map(plain).collect();
        // A string of JSON is one of TOML.
        let file = serde_json::Value::from(name(args.path.file_name()));
        let (kind, mass) = if self.soft {
            ("soft", "mass = 1.0".to_owned())
        } else {
            ("cloth", format!("area_density = {AREA_DENSITY}"))
        };
        let mut lines = vec![
            format!("[time]\nmax_step = {:?}", self.step),
            format!("[[body]]\nname = \"{body}\"\nkind = \"{kind}\"\n{mass}\nmesh.file = {file}"),
        ];
        lines.extend(args.fill_holes.then(|| "fill_holes = true".to_owned()));
        lines.extend(self.scale.map(|scale| format!("place.scale = {scale}")));
        lines.push(format!(
            "springs.structural = {{ k = {:?}, d = {:?} }}",
            self.stiffness,
            one_digit(self.damping())
        ));
        lines.join("\n") + "\n"
    }
}

/// A stiffness [N/m] at which a node of this mass [kg] with some twenty springs is stable at the usual step.
fn stiffness(mass: f64) -> f64 {
    one_digit(0.05 * mass / (STEP * STEP))
}

/// The next smaller number of one digit.
fn one_digit(x: f64) -> f64 {
    let digit = 10_f64.powf(x.log10().floor());
    // Through its digits, so that no rounding shows.
    format!("{:.0e}", (x / digit).floor() * digit).parse().unwrap_or(x)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_of_one_digit_are_not_larger() {
        assert_eq!([108.0, 0.296, 690_000.0, 4.28e-4].map(one_digit), [100.0, 0.2, 600_000.0, 4e-4]);
        assert_eq!(stiffness(5.4e-4), 100.0);
    }
}
