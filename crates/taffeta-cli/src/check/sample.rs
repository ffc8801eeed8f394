//! A scene to begin with: a body over a floor. Cloth is a fabric, solved for implicitly; a soft body has springs that its nodes
//! stand at a usual step.

use super::report::MeshReport;
use super::{Args, MeshKind};
use std::ffi::OsStr;
use std::sync::Arc;
use taffeta::diagnostics::bending_factors;
use taffeta::scene::{Body, ConstraintForm, Internal, Mass, Material, Mesh, Method, Scene};
use taffeta::topology::Surface;
use taffeta::{Options, Simulation};

/// Usual step [s].
const STEP: f64 = 0.0005;
/// Longest step of an implicit fabric [s]: four a frame.
const FABRIC_STEP: f64 = 0.005;
/// What cloth is made of.
const FABRIC: &str = "cotton";
/// Mass of a soft body [kg].
const SOFT_MASS: f64 = 1.0;
/// Most struts inside a soft body: one for each node of most meshes.
const STRUTS: usize = 10_000;
/// Nodes up to which the step is measured; for more the body is not built.
const MANY: usize = 200_000;

/// A body: cloth of a fabric, or a soft body with springs along its edges and struts inside. All nodes of the latter have the same
/// mass, so that no light one needs short steps.
pub struct Sample {
    soft: bool,
    node_mass: f64,
    scale: Option<f64>,
    stiffness: f64,
    struts: usize,
    /// Height of the floor [m].
    floor: f64,
    /// Longest step [s].
    pub step: f64,
}

impl Sample {
    /// For what the mesh is to be; for what it can be, where that is left open. `lowest` is the least height of its
    /// nodes [m].
    pub fn new(report: &MeshReport, kind: Option<MeshKind>, lowest: f64) -> Self {
        let soft = kind.map_or(report.body.accepted, |kind| kind == MeshKind::Body);
        let scale = report.unit.as_ref().and_then(|unit| unit.scale);
        let factor = scale.unwrap_or(1.0);
        let node_mass = one_digit(SOFT_MASS / report.nodes as f64);
        let largest = report.extent.into_iter().fold(0.0, f64::max);
        Self {
            soft,
            node_mass,
            scale,
            stiffness: stiffness(node_mass),
            struts: if soft && report.nodes <= MANY { report.nodes.min(STRUTS) } else { 0 },
            floor: rounded(factor * (lowest - 0.2 * largest), factor * largest),
            step: if soft { STEP } else { FABRIC_STEP },
        }
    }

    /// The body.
    fn body(&self, surface: &Arc<Surface>) -> Body {
        let mesh = Mesh::Surface(Arc::clone(surface));
        let mut body = if self.soft {
            let (k, d) = (self.stiffness, self.damping());
            let mut body = Body::soft("", mesh).with_mass(Mass::Node(self.node_mass)).structural(k, d);
            if self.struts > 0 {
                let internal = Internal { count: self.struts as u32, k, d, ..Internal::default() };
                body.springs.internal = Some(internal);
            }
            body
        } else {
            Body::cloth("", mesh).with_material(Material::preset(FABRIC))
        };
        body.place.scale = self.scale;
        body
    }

    /// A scene with this body.
    fn scene(&self, surface: &Arc<Surface>) -> Scene {
        let mut scene = Scene::new("").body(self.body(surface));
        if !self.soft {
            scene.solver.method = Method::Ice;
            scene.solver.ice.form = ConstraintForm::Primal;
        }
        scene
    }

    /// How true the mesh is to the bending of a fabric; not where there are very many nodes.
    pub fn bending(&self, surface: &Arc<Surface>) -> Option<[f64; 2]> {
        let body =
            Body { place: self.body(surface).place, ..Body::cloth("", Mesh::Surface(Arc::clone(surface))) };
        let few = surface.nodes.len() <= MANY;
        let factors = || bending_factors(&body.with_material(Material::preset(FABRIC))).ok().flatten();
        if few { factors() } else { None }
    }

    /// Memory that building the scene takes [byte], roughly.
    pub fn memory(&self, surface: &Arc<Surface>) -> u64 {
        self.scene(surface).memory_needed().bytes
    }

    /// Leaves out struts that have no room, and shortens the step to one of one digit that all nodes stand; not where there
    /// are very many.
    pub fn measure(&mut self, surface: &Arc<Surface>) {
        if !self.soft || surface.nodes.len() > MANY {
            return;
        }
        let options = Options { threads: Some(1), find_largest_steps: true, ..Options::default() };
        loop {
            match Simulation::new(&self.scene(surface), &options) {
                Ok(simulation) => {
                    self.step = STEP.min(one_digit(simulation.largest_stable_step_folded()));
                    return;
                }
                // There is not room inside for as many.
                Err(_) if self.struts > 0 => self.struts /= 2,
                Err(_) => return,
            }
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
        let mut lines = vec![format!("[time]\nmax_step = {:?}", self.step)];
        if !self.soft {
            lines.push("[solver]\nmethod = \"ice\"\nice.form = \"primal\"".to_owned());
        }
        let (kind, mass) = if self.soft {
            ("soft", format!("node_mass = {:?}", self.node_mass))
        } else {
            ("cloth", format!("material.preset = \"{FABRIC}\""))
        };
        lines.push(format!("[[body]]\nname = \"{body}\"\nkind = \"{kind}\"\n{mass}\nmesh.file = {file}"));
        lines.extend(args.fill_holes.then(|| "fill_holes = true".to_owned()));
        lines.extend(self.scale.map(|scale| format!("place.scale = {scale}")));
        if self.soft {
            let (k, d) = (self.stiffness, one_digit(self.damping()));
            lines.push(format!("springs.structural = {{ k = {k:?}, d = {d:?} }}"));
            let struts = || format!("springs.internal = {{ count = {}, k = {k:?}, d = {d:?} }}", self.struts);
            lines.extend((self.struts > 0).then(struts));
        }
        lines.push(format!("[[collider]]\nplane = {{ point = [0.0, {:?}, 0.0] }}", self.floor));
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

/// `x` with two digits of `size`.
fn rounded(x: f64, size: f64) -> f64 {
    let digit = 10_f64.powf(size.log10().floor() - 1.0);
    format!("{:.*}", (-digit.log10()).max(0.0) as usize, (x / digit).round() * digit).parse().unwrap_or(x)
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
