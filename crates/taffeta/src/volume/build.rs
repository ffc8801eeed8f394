//! What keeps the volumes of bodies.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::scene::{SceneError, Volume, VolumeForm, VolumeWeights, plain};
use crate::topology::measure;
use crate::volume::constraint::VolumeConstraint;
use crate::volume::volume::{Form, weight};

/// Share of area × extent / 6 below which a volume is nothing: 32 bits tell it from none by two digits.
const NOTHING: f64 = 1e-5;

impl Assembly {
    /// Bodies whose volume is kept, or that are under a pressure, in the scene's order.
    pub fn volumes(&self) -> impl Iterator<Item = (&BodyAssembly, &VolumeConstraint)> {
        self.bodies.iter().filter_map(|body| Some((body, body.volume()?)))
    }

    /// A volume of 0 for each closed body.
    pub fn no_volumes(&self) -> Vec<Option<f64>> {
        self.bodies.iter().map(|body| body.rest_volume.map(|_| 0.0)).collect()
    }

    /// The volume that each body is to have at time `t` [s], in m³, where it keeps one.
    pub fn volume_targets(&self, t: f64) -> Vec<Option<f64>> {
        self.bodies.iter().map(|body| body.volume()?.target(t)).collect()
    }
}

impl BodyAssembly {
    /// What keeps its volume.
    pub fn volume(&self) -> Option<&VolumeConstraint> {
        self.extensions.get::<Option<VolumeConstraint>>()?.as_ref()
    }

    pub(crate) fn volume_mut(&mut self) -> Option<&mut VolumeConstraint> {
        self.extensions.get_mut::<Option<VolumeConstraint>>().as_mut()
    }

    /// Gives back the weights of its nodes once backends have theirs.
    pub(crate) fn forget_weights(&mut self) {
        if let Some(volume) = self.volume_mut() {
            volume.weights = None;
        }
    }

    /// Has the body, whose pins are there, keep its volume.
    pub(crate) fn keep_volume(&mut self, wish: &Volume) -> Result<(), SceneError> {
        let form = match wish.form {
            VolumeForm::None => return Ok(()),
            _ if wish.is_pressure() => Form::Pressure,
            VolumeForm::Corrected | VolumeForm::Projected => Form::Kept,
            #[cfg(feature = "paper-forms")]
            VolumeForm::PaperShader => Form::PaperShader,
            #[cfg(feature = "paper-forms")]
            VolumeForm::Printed => Form::Printed,
        };
        let rest = self.rest_volume.unwrap_or(0.0);
        check_inside(form, rest, self)?;
        let weights = wish.weights.map(|ball| weights(ball, self)).transpose()?;
        if let Some(why) = immovable(form, weights.as_deref(), &self.free) {
            self.warnings.push(why.into());
        }
        let unit = if form == Form::Pressure { 1.0 } else { rest };
        let keys = keys(wish).into_iter().map(|(t, goal)| (t, goal * unit)).collect();
        let projects = wish.form == VolumeForm::Projected;
        self.extensions.insert(Some(VolumeConstraint { form, projects, weights, keys }));
        Ok(())
    }
}

/// Times and targets, or pressures. A motion starts at t = 0.
fn keys(wish: &Volume) -> Vec<(f64, f64)> {
    let first = if wish.is_pressure() { wish.pressure.unwrap_or(0.0) } else { wish.target.unwrap_or(1.0) };
    let later = wish.motion.iter().filter_map(|key| Some((key.t, key.target.or(key.pressure)?)));
    let starts = wish.motion.first().is_none_or(|key| key.t > 0.0);
    starts.then_some((0.0, first)).into_iter().chain(later).collect()
}

/// Refuses a surface that encloses nothing that could be kept.
fn check_inside(form: Form, rest: f64, body: &BodyAssembly) -> Result<(), SceneError> {
    let triangles = &body.closed_triangles;
    let area: f64 = triangles.iter().map(|t| measure::area(&body.start, *t)).sum();
    let [lo, hi] = measure::bounds(&body.start);
    let extent = (0..3).map(|i| hi[i] - lo[i]).fold(0.0, f64::max);
    if form == Form::Pressure || rest >= NOTHING * area * extent / 6.0 {
        return Ok(());
    }
    Err(SceneError::new(
        "volume",
        format!(
            "the mesh encloses {rest:.3e} m³, next to nothing between {area:.3e} m² of surface, and there is no volume to \
             keep; a thicker mesh or volume.pressure would do"
        ),
    ))
}

fn weights(ball: VolumeWeights, body: &BodyAssembly) -> Result<Vec<f64>, SceneError> {
    let distance = |node: &[f64; 3]| (0..3).map(|i| (node[i] - ball.center[i]).powi(2)).sum::<f64>().sqrt();
    let weights: Vec<f64> = body.start.iter().map(|x| weight(distance(x), ball.radius)).collect();
    if weights.iter().any(|weight| *weight > 0.0) {
        return Ok(weights);
    }
    let nearest =
        (0..body.nodes).min_by(|a, b| distance(&body.start[*a]).total_cmp(&distance(&body.start[*b])));
    let nearest = nearest.unwrap_or_default();
    Err(SceneError::new(
        "volume.weights",
        format!(
            "no node is within {} m of {:?}: the nearest, vertex {} at {:.4?}, is {:.4} m away; a larger radius or a \
             center on the surface would do",
            plain(ball.radius),
            ball.center,
            body.vertex_of_solver(nearest),
            body.start[nearest],
            distance(&body.start[nearest])
        ),
    ))
}

/// What to say where no node can move to keep the volume.
fn immovable(form: Form, weights: Option<&[f64]>, free: &[bool]) -> Option<&'static str> {
    let movable = |node: usize| free[node] && weights.is_none_or(|weights| weights[node] > 0.0);
    if form == Form::Pressure || (0..free.len()).any(movable) {
        return None;
    }
    Some(match weights {
        None => "all its nodes are pinned, and nothing can keep its volume",
        Some(_) => {
            "all nodes within the radius of its volume.weights are held, and nothing can keep its volume"
        }
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::VolumeKey;

    #[test]
    fn a_target_moves_from_where_it_starts_and_then_stays() {
        let motion = vec![
            VolumeKey { t: 1.0, target: Some(2.0), pressure: None },
            VolumeKey { t: 3.0, target: Some(0.5), pressure: None },
        ];
        let wish = Volume { motion, ..Volume::default() };
        let kept = VolumeConstraint { form: Form::Kept, projects: false, weights: None, keys: keys(&wish) };
        assert_eq!([0.0, 0.5, 1.0, 2.0, 3.0, 9.0].map(|t| kept.goal(t)), [1.0, 1.5, 2.0, 1.25, 0.5, 0.5]);
        assert_eq!(keys(&Volume { pressure: Some(-5.0), ..Volume::default() }), [(0.0, -5.0)]);
        let at_once = vec![VolumeKey { t: 0.0, target: Some(1.2), pressure: None }];
        assert_eq!(keys(&Volume { motion: at_once, ..Volume::default() }), [(0.0, 1.2)]);
    }

    #[test]
    fn only_what_differs_from_rest_drives_a_body() {
        let kept = |form, goals: &[f64]| VolumeConstraint {
            form,
            projects: false,
            weights: None,
            keys: goals.iter().enumerate().map(|(t, &goal)| (t as f64, goal)).collect(),
        };
        assert!(!kept(Form::Kept, &[2.0, 2.0]).drives(2.0));
        assert!(kept(Form::Kept, &[2.0, 2.1]).drives(2.0) && kept(Form::Pressure, &[2.0]).drives(2.0));
        assert_eq!(kept(Form::Kept, &[2.0]).target(5.0), Some(2.0));
        assert_eq!(kept(Form::Pressure, &[2.0]).target(5.0), None);
    }

    #[test]
    fn a_body_gives_way_where_a_node_is_free_and_has_a_weight() {
        let weights = Some(&[0.5, 0.0, 0.0][..]);
        assert_eq!(immovable(Form::Kept, None, &[false, false, true]), None);
        assert_eq!(immovable(Form::Kept, weights, &[true, false, false]), None);
        assert_eq!(immovable(Form::Pressure, None, &[false; 3]), None);
        assert!(immovable(Form::Kept, None, &[false; 3]).is_some_and(|why| why.starts_with("all its nodes")));
        assert!(
            immovable(Form::Kept, weights, &[false, true, true]).is_some_and(|why| why.contains("radius"))
        );
    }
}
