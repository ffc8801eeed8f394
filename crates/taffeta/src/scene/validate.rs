//! Refuses at the door what cannot be simulated, with the place in the scene and what would do.

mod air;
mod attach;
mod body;
mod collider;
mod counts;
mod friction;
mod layers;
mod material;
mod path;
mod shape;
mod surface;
#[cfg(test)]
mod tests;

use crate::real::{cross, dot};
use crate::scene::error::SceneError;
use crate::scene::{Collider, ConstraintForm, Force, Keyframe, Rotation, Scene, Solver, World};
pub(crate) use friction::Side;
use path::Checked;
pub(crate) use path::{Path, plain};
pub(crate) use shape::{LARGEST_LENGTH, check_shape};
use std::collections::HashMap;

/// Newton steps beyond which nothing is gained.
const MOST_NEWTON_STEPS: u32 = 100;

/// Most sweeps over springs that are constraints on positions, in a sub-step.
const MOST_SWEEPS: u32 = 1000;

/// Most sub-steps of a frame.
const MOST_SUBSTEPS: f64 = 1e6;
/// Largest number in a matrix that deforms.
const LARGEST_STRETCH: f64 = 1e3;
/// Most names in a message.
const MOST_NAMES: usize = 20;

impl Scene {
    /// Checks everything that can be told without building meshes. The first thing found is the error.
    pub fn validate(&self) -> Result<(), SceneError> {
        self.check_time()?;
        self.world.check()?;
        self.check_solver()?;
        self.check_sleep()?;
        Path::of("body")
            .demand(!self.bodies.is_empty(), || "the scene has none, one or more would do".into())?;
        let mut names = HashMap::new();
        for (i, body) in self.bodies.iter().enumerate() {
            self.check_name(i, &mut names)?;
            body::check(&Path::item("body", i), body)?;
        }
        for (i, body) in self.bodies.iter().enumerate() {
            layers::check(self, i, body, &names)?;
        }
        counts::check(self)?;
        for (i, collider) in self.colliders.iter().enumerate() {
            collider::check(&Path::item("collider", i), collider)?;
        }
        attach::check_carried(self)?;
        for (i, force) in self.forces.iter().enumerate() {
            self.check_force(&Path::item("force", i), force, &names)?;
        }
        for (i, seam) in self.seams.iter().enumerate() {
            attach::check_seam(self, &Path::item("seam", i), seam, &names)?;
        }
        friction::check(self)
    }

    /// Name of a body: its own or, without one, `body0`, `body1`, … by its place in the scene.
    pub fn body_name(&self, index: usize) -> String {
        match self.bodies.get(index) {
            Some(body) if !body.name.is_empty() => body.name.clone(),
            _ => format!("body{index}"),
        }
    }

    /// Name of a collider: its own or, without one, `collider0`, `collider1`, … by its place in the scene.
    pub fn collider_name(&self, index: usize) -> String {
        match self.colliders.get(index) {
            Some(collider) if !collider.name.is_empty() => collider.name.clone(),
            _ => format!("collider{index}"),
        }
    }

    /// The collider of that name.
    pub fn collider_named(&self, name: &str) -> Option<&Collider> {
        (0..self.colliders.len()).find(|&i| self.collider_name(i) == name).map(|i| &self.colliders[i])
    }

    fn check_time(&self) -> Checked {
        let path = Path::of("time");
        path.key("dt").positive(self.time.dt, "s")?;
        if let Some(max_step) = self.time.max_step {
            let path = path.key("max_step");
            path.positive(max_step, "s")?;
            let steps = self.time.dt / max_step;
            path.demand(steps <= MOST_SUBSTEPS, || {
                let (steps, least) = (plain(steps.ceil()), plain(self.time.dt / MOST_SUBSTEPS));
                format!("is {} s, {steps} sub-steps a frame; {least} s or more would do", plain(max_step))
            })?;
        }
        path.key("frames").demand(self.time.frames >= 1, || "is 0, 1 or more would do".into())
    }

    fn check_sleep(&self) -> Checked {
        let (Some(sleep), path) = (&self.sleep, Path::of("sleep")) else { return Ok(()) };
        path.key("speed").positive(sleep.speed, "m/s")?;
        path.key("after").not_negative(sleep.after, "s")
    }

    fn check_solver(&self) -> Checked {
        let Solver { ice, acad, .. } = &self.solver;
        let path = Path::of("solver.ice");
        path.key("tolerance").positive(ice.tolerance, "")?;
        path.key("tolerance").demand(ice.tolerance < 1.0, || {
            format!("is {}, and the residual is 1 before the first iteration; 0.001 would do", ice.tolerance)
        })?;
        path.key("max_iterations")
            .demand(ice.max_iterations >= 1, || "is 0, 1 or more would do".to_owned())?;
        path.key("epsilon").not_negative(ice.epsilon, "")?;
        path.key("epsilon").demand(ice.epsilon == 0.0 || !self.solver.is_primal(), || {
            format!("is {}, and the form \"primal\" has no compliance to add to; 0 would do", ice.epsilon)
        })?;
        path.key("newton_steps").demand((..=MOST_NEWTON_STEPS).contains(&ice.newton_steps), || {
            format!("is {}, 0 to {MOST_NEWTON_STEPS} would do", ice.newton_steps)
        })?;
        path.key("newton_steps").demand(ice.newton_steps <= 1 || self.solver.is_primal(), || {
            format!(
                "is {}, but only the form \"primal\" of the method \"ice\" takes Newton steps; 1 would do",
                ice.newton_steps
            )
        })?;
        self.check_order()?;
        self.check_xpbd()?;
        let path = Path::of("solver.acad");
        path.key("threshold").positive(acad.threshold, "")?;
        for (key, share) in [("release", acad.release), ("target", acad.target)] {
            path.key(key).not_negative(share, "")?;
            path.key(key).demand(share <= acad.threshold, || {
                format!("is {share}, more than the threshold of {}; up to that would do", acad.threshold)
            })?;
        }
        path.key("form").demand(acad.form != ConstraintForm::Primal, || {
            "is \"primal\", a form of the method \"ice\" alone; \"compliant\" would do".to_owned()
        })?;
        path.key("epsilon").not_negative(acad.epsilon, "")
    }

    fn check_xpbd(&self) -> Checked {
        let (path, xpbd) = (Path::of("solver.xpbd"), &self.solver.xpbd);
        path.key("sweeps").demand((1..=MOST_SWEEPS).contains(&xpbd.sweeps), || {
            format!("is {}, 1 to {MOST_SWEEPS} would do", xpbd.sweeps)
        })?;
        path.key("stretch_limit").not_negative(xpbd.stretch_limit, "")?;
        path.key("stretch_limit").demand(xpbd.stretch_limit <= 1.0, || {
            format!(
                "is {}, twice the length and more; up to 1 would do, or levels = 0 for no limit",
                xpbd.stretch_limit
            )
        })
    }

    /// Second order in time is of the primal form, and of bodies that do not keep their volume: that is of first order.
    fn check_order(&self) -> Checked {
        let (path, order) = (Path::of("solver.ice").key("order"), self.solver.ice.order);
        path.demand((1..=2).contains(&order), || format!("is {order}, 1 or 2 would do"))?;
        path.demand(order == 1 || self.solver.is_primal(), || {
            format!(
                "is {order}, but only the form \"primal\" of the method \"ice\" is of second order in time; 1 would do"
            )
        })?;
        let kept = (0..).zip(&self.bodies).find(|(_, body)| order == 2 && body.volume.is_some());
        path.demand(kept.is_none(), || {
            let name = kept.map_or_else(String::new, |(index, _)| self.body_name(index));
            format!("is 2, but body `{name}` keeps its volume, at first order; 1 would do")
        })
    }

    /// A name is the body's own, and that of its output files. `names` are those of the bodies before.
    fn check_name(&self, index: usize, names: &mut HashMap<String, usize>) -> Checked {
        let path = Path::item("body", index).key("name");
        let name = self.body_name(index);
        let odd = |c: char| c.is_control() || r#"/\:*?"<>|"#.contains(c);
        let plain = !name.contains(odd) && !name.starts_with(['.', ' ']) && !name.ends_with(['.', ' ']);
        path.demand(plain && name.len() <= 100, || {
            format!("is {name:?}, but names files too; up to 100 letters, digits, `-` and `_` would do")
        })?;
        if let Some(twin) = names.get(&name) {
            return path
                .refuse(&format!("is `{name}`, as is that of body[{twin}]; a name of its own would do"));
        }
        names.insert(name, index);
        Ok(())
    }

    /// Names of bodies, in words.
    fn some_names(&self) -> String {
        let some = self.bodies.len().min(MOST_NAMES);
        let mut all: Vec<_> = (0..some).map(|i| format!("`{}`", self.body_name(i))).collect();
        if some < self.bodies.len() {
            all.push(format!("{} more", self.bodies.len() - some));
        }
        all.join(", ")
    }

    fn check_force(&self, path: &Path, force: &Force, names: &HashMap<String, usize>) -> Checked {
        path.key("body").demand(names.contains_key(&force.body), || {
            format!("there is no body `{}`; {} would do", force.body, self.some_names())
        })?;
        body::check_select(&path.key("select"), &force.select)?;
        match (&force.force, &force.torque) {
            (Some(newtons), None) => path.key("force").finite(newtons)?,
            (None, Some(torque)) => {
                let path = path.key("torque");
                path.key("axis").direction(torque.axis)?;
                path.key("value").finite(&[torque.value])?;
                path.key("about").finite(&torque.about)?;
            }
            (Some(_), Some(_)) => return path.refuse("has force and torque; one of them would do"),
            (None, None) => return path.refuse("has neither force nor torque; one of them would do"),
        }
        check_times(path, force.motion.iter().map(|key| key.t))?;
        for (i, key) in force.motion.iter().enumerate() {
            path.nth("motion", i).key("scale").finite(&[key.scale])?;
        }
        Ok(())
    }
}

impl World {
    /// Refuses what is impossible.
    pub(crate) fn check(&self) -> Checked {
        let path = Path::of("world");
        path.key("gravity").finite(&self.gravity)?;
        path.key("drag").not_negative(self.drag, "kg/s")?;
        path.key("wind_force").finite(&self.wind_force)?;
        self.air.as_ref().map_or(Ok(()), |air| air::check(&path.key("air"), air))
    }
}

/// Keyframes of a pin or collider at `path`.
pub(crate) fn check_motion(path: &Path, motion: &[Keyframe]) -> Checked {
    check_times(path, motion.iter().map(|key| key.t))?;
    for (i, key) in motion.iter().enumerate() {
        let path = path.nth("motion", i);
        path.key("translate").within(&key.translate)?;
        path.key("pivot").within(&key.pivot)?;
        if let Some(turn) = &key.rotate {
            check_rotation(&path.key("rotate"), turn)?;
        }
        if let Some(deform) = &key.deform {
            check_deform(&path.key("deform"), deform)?;
        }
    }
    Ok(())
}

/// A matrix that stretches and shears, but turns nothing inside out.
fn check_deform(path: &Path, deform: &[[f64; 3]; 3]) -> Checked {
    deform.iter().try_for_each(|row| path.finite(row))?;
    let large = deform.as_flattened().iter().any(|x| x.abs() > LARGEST_STRETCH);
    path.demand(!large, || format!("is {deform:?}, numbers up to {LARGEST_STRETCH} would do"))?;
    let [a, b, c] = *deform;
    let determinant = dot(a, cross(b, c));
    path.demand(determinant > 0.0, || {
        format!("is {deform:?}, whose determinant is {}; one above 0 would do", plain(determinant))
    })
}

pub(crate) fn check_rotation(path: &Path, turn: &Rotation) -> Checked {
    path.key("axis").direction(turn.axis)?;
    path.key("degrees").finite(&[turn.degrees])
}

/// Times of keyframes: finite, none before the start, each after the one before it.
fn check_times(path: &Path, times: impl Iterator<Item = f64>) -> Checked {
    let mut before: Option<f64> = None;
    for (i, t) in times.enumerate() {
        let path = path.nth("motion", i).key("t");
        path.not_negative(t, "s")?;
        if let Some(last) = before {
            path.demand(t > last, || format!("is {t} s after {last} s; times that ascend would do"))?;
        }
        before = Some(t);
    }
    Ok(())
}
