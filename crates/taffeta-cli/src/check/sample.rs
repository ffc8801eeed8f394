//! A scene to begin with: a body that touches itself, over a floor. Cloth is a fabric; a soft body has springs. Both are solved for
//! implicitly, so that what is light or stiff needs no short steps.

use super::report::MeshReport;
use super::{Args, MeshKind};
use std::ffi::OsStr;
use std::sync::Arc;
use taffeta::diagnostics::bending_factors;
use taffeta::scene::{Body, ConstraintForm, Internal, Mass, Material, Mesh, Method, Scene};
use taffeta::topology::Surface;
use taffeta::{Options, Simulation};

/// Longest step [s]: four a frame.
const STEP: f64 = 0.005;
/// What cloth is made of.
const FABRIC: &str = "cotton";
/// Mass of a soft body [kg].
const SOFT_MASS: f64 = 1.0;
/// Stiffness of a soft body's springs times its largest extent [N]: thousands of times its weight, so that most shapes land without
/// stretching by a fifth. A human who falls over stretches by a half.
const SOFT_FORCE: f64 = 30_000.0;
/// Damping of its springs by their stiffness [s].
const SOFT_DAMPING: f64 = 1e-3;
/// Most struts inside a soft body: one for each node of most meshes.
const STRUTS: usize = 10_000;
/// Nodes up to which struts are tried; for more the body is not built.
const MANY: usize = 200_000;
/// Thickness of contact by the largest extent, and the most of it [m]: two millimetres on a figure.
const THICKNESS: (f64, f64) = (0.0012, 0.003);
/// The same of the distance from the floor.
const OFFSET: (f64, f64) = (0.006, 0.01);

/// A body: cloth of a fabric, or a soft body with springs along its edges and struts inside. All nodes of the latter have the same
/// mass.
pub struct Sample {
    soft: bool,
    node_mass: f64,
    scale: Option<f64>,
    stiffness: f64,
    struts: usize,
    /// Thickness of contact [m].
    thickness: f64,
    /// Height of the floor, and the distance that is kept from it [m].
    floor: f64,
    offset: f64,
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
            stiffness: one_digit(SOFT_FORCE / (factor * largest)),
            struts: if soft && report.nodes <= MANY { report.nodes.min(STRUTS) } else { 0 },
            thickness: one_digit(THICKNESS.0 * factor * largest).min(THICKNESS.1),
            offset: one_digit(OFFSET.0 * factor * largest).min(OFFSET.1),
            floor: rounded(factor * (lowest - 0.2 * largest), factor * largest),
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
        body.collide(self.thickness)
    }

    /// A scene with this body.
    fn scene(&self, surface: &Arc<Surface>) -> Scene {
        let mut scene = Scene::new("").body(self.body(surface));
        scene.solver.method = Method::Ice;
        scene.solver.ice.form = ConstraintForm::Primal;
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

    /// Leaves out struts that have no room; not where there are very many nodes.
    pub fn make_room(&mut self, surface: &Arc<Surface>) {
        if !self.soft || surface.nodes.len() > MANY {
            return;
        }
        let options = Options { threads: Some(1), ..Options::default() };
        while self.struts > 0 && Simulation::new(&self.scene(surface), &options).is_err() {
            self.struts /= 2;
        }
    }

    fn damping(&self) -> f64 {
        SOFT_DAMPING * self.stiffness
    }

    /// The scene in TOML, to be saved beside the mesh.
    pub fn toml(&self, args: &Args) -> String {
        let name = |part: Option<&OsStr>| part.unwrap_or_default().to_string_lossy().into_owned();
        let plain = |c: char| if c.is_alphanumeric() || "-_".contains(c) { c } else { '_' };
        let body: String = name(args.path.file_stem()).chars().take(25).map(plain).collect();
        // A string of JSON is one of TOML.
        let file = serde_json::Value::from(name(args.path.file_name()));
        let mut lines = vec![format!("[time]\nmax_step = {STEP:?}")];
        lines.push("[solver]\nmethod = \"ice\"\nice.form = \"primal\"".to_owned());
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
        lines.push(format!("self_collision.thickness = {:?}", self.thickness));
        let (floor, offset) = (self.floor, self.offset);
        lines.push(format!("[[collider]]\nplane = {{ point = [0.0, {floor:?}, 0.0] }}\noffset = {offset:?}"));
        lines.join("\n") + "\n"
    }
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
    }
}
