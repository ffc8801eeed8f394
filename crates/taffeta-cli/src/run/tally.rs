//! What a run adds up to.

use super::args::Args;
use super::solves::Solves;
use super::volumes::Volumes;
use crate::intersections::are_kept_out;
use crate::summary::{BodySummary, Energy, IntersectionSummary, PairSummary, Status, Strain, Summary};
use serde::{Deserialize, Serialize};
use taffeta::diagnostics::{FabricStrain, FrameReport, Squeezed};
use taffeta::scene::Scene;
use taffeta::{BodyInfo, Diverged, Frozen, Simulation};

/// Engineering strain that no fabric bears: knits reach a third when they land.
const TOO_FAR: f64 = 0.5;
/// Length of a sub-step [s] that follows cloth that lands where 1/60 s does not.
const FOLLOWS: f64 = 4e-3;

/// Extremes and times over the frames.
#[derive(Clone, Serialize, Deserialize)]
pub struct Tally {
    energy_start: f64,
    energy_max: f64,
    max_stretch: f64,
    strain: Option<FabricStrain>,
    contacts_max: u64,
    substeps: u64,
    substeps_max: u32,
    pairs: PairSummary,
    intersections: Option<IntersectionSummary>,
    /// The first frame in which surfaces had no room between colliders, with one such vertex; and in how many they had none.
    squeezed: Option<(u32, Squeezed)>,
    squeezed_frames: u32,
    solves: Solves,
    volumes: Volumes,
    ms: Vec<f64>,
}

impl Tally {
    /// The start of a run.
    pub fn new(simulation: &Simulation) -> Self {
        let report = simulation.report();
        let mut tally = Self {
            energy_start: report.energy(),
            energy_max: report.energy(),
            max_stretch: 0.0,
            strain: None,
            contacts_max: 0,
            substeps: 0,
            substeps_max: 0,
            pairs: PairSummary::default(),
            intersections: None,
            squeezed: None,
            squeezed_frames: 0,
            solves: Solves::default(),
            volumes: Volumes::new(simulation),
            ms: Vec::new(),
        };
        tally.take(report);
        tally
    }

    /// A frame that took `ms` [ms].
    pub fn add(&mut self, report: &FrameReport, ms: f64) {
        self.take(report);
        self.volumes.add(report);
        self.solves.add(report);
        self.ms.push(ms);
    }

    /// The number of intersections in a frame.
    pub fn intersections(&mut self, frame: u32, pairs: u64) {
        let all = self.intersections.get_or_insert_default();
        (all.end, all.max) = (pairs, all.max.max(pairs));
        if frame == 0 {
            all.start = Some(pairs);
        }
        all.last_frame = if pairs > 0 { Some(frame) } else { all.last_frame };
    }

    fn take(&mut self, report: &FrameReport) {
        self.energy_max = self.energy_max.max(report.energy());
        self.max_stretch = self.max_stretch.max(report.max_stretch);
        self.strain = match (self.strain, report.strain) {
            (Some(all), Some(now)) => Some(all.with(&now)),
            (all, now) => all.or(now),
        };
        self.contacts_max = self.contacts_max.max(report.contacts);
        self.substeps += u64::from(report.substeps);
        self.substeps_max = self.substeps_max.max(report.substeps);
        self.pairs.take(report);
        if let Some(squeezed) = &report.squeezed {
            self.squeezed.get_or_insert_with(|| (report.frame, squeezed.clone()));
            self.squeezed_frames += 1;
        }
    }

    /// The whole run. A simulation whose device is `lost` is not asked for its state.
    pub fn summary(
        &self,
        args: &Args,
        scene: &Scene,
        simulation: &Simulation,
        status: Status,
        lost: bool,
    ) -> Summary {
        let (bodies, last) = (simulation.bodies(), simulation.report());
        let nodes = bodies.iter().map(|body| body.nodes).sum();
        let wall_ms_per_frame = median(&self.ms);
        let mean_substeps = self.substeps as f64 / self.ms.len().max(1) as f64;
        Summary {
            scene: args.scene.display().to_string(),
            status,
            backend: simulation.backend(),
            device: simulation.device(),
            precision: simulation.precision().to_string(),
            threads: simulation.threads(),
            frames: simulation.frame(),
            substeps: scene.time.substeps(),
            substeps_max: self.substeps_max,
            dt: scene.time.dt,
            largest_stable_step: Some(simulation.largest_stable_step()).filter(|step| step.is_finite()),
            nodes,
            vertices: bodies.iter().map(|body| body.vertices).sum(),
            springs: bodies.iter().flat_map(|body| &body.springs).map(|(_, count)| count).sum(),
            triangles: bodies.iter().map(|body| body.triangles).sum(),
            wall_ms_per_frame,
            particle_substeps_per_s: rate(nodes as f64 * mean_substeps, wall_ms_per_frame),
            energy: Energy { start: self.energy_start, end: last.energy(), max: self.energy_max },
            momentum: last.momentum,
            angular_momentum: last.angular_momentum,
            max_stretch: self.max_stretch,
            strain: self.strain.map(|FabricStrain { warp, weft, shear, .. }| Strain { warp, weft, shear }),
            bodies: self.bodies(simulation, scene),
            contacts: last.contacts,
            contacts_max: self.contacts_max,
            pairs: self.pairs,
            intersections: self.intersections,
            solver: self.solves.summary(),
            state_hash: (!lost).then(|| format!("{:016x}", simulation.state_hash())),
            files: Vec::new(),
        }
    }

    /// What the user should know of the run that is over.
    pub fn warnings(&self, simulation: &Simulation, scene: &Scene) -> Vec<String> {
        let mut warnings: Vec<String> = simulation.frozen().iter().map(frozen).collect();
        warnings.extend(self.volumes.warnings(scene));
        warnings.extend(self.solves.warning(scene, self.substeps));
        warnings.extend(self.stretched(scene));
        warnings.extend(self.squeezed(simulation));
        warnings.extend(self.intersected(simulation, scene));
        warnings.extend(self.too_long(simulation, scene));
        warnings
    }

    /// What to say of surfaces that had no room between colliders.
    fn squeezed(&self, simulation: &Simulation) -> Option<String> {
        let (frame, Squeezed { body, vertex, colliders }) = self.squeezed.as_ref()?;
        let all = simulation.colliders();
        let name = |&index: &usize| all.get(index).map(|collider| format!("`{}`", collider.name));
        let names: Vec<String> = colliders.iter().filter_map(name).collect();
        let between = if names.len() > 1 { "between colliders" } else { "beside collider" };
        let since = match self.squeezed_frames {
            1 => String::new(),
            frames => format!(", the first of {frames} such frames"),
        };
        Some(format!(
            "body `{}`, vertex {vertex} had no room {between} {} in frame {frame}{since}: however near to each other surfaces \
             came, some may have passed through others there; colliders that leave more room, a smaller \
             self_collision.thickness or a finer mesh would do",
            simulation.bodies()[*body].name,
            names.join(" and ")
        ))
    }

    /// What to say of surfaces that passed through each other, with one of those that still do.
    fn intersected(&self, simulation: &Simulation, scene: &Scene) -> Option<String> {
        let IntersectionSummary { start, end, max, last_frame } = self.intersections?;
        let (frame, start) = (last_frame?, start.unwrap_or(0));
        let last = match end {
            0 if frame == 0 => "none in the last frame".to_owned(),
            0 => format!("the last in frame {frame}"),
            _ => {
                let first = simulation.intersections().first;
                let first = first.map_or_else(String::new, |first| format!(", such as {first}"));
                format!("{end} in the last frame{first}")
            }
        };
        let at_start = (start > 0).then(|| format!("{start} at the start"));
        let at_most = (max > start.max(end)).then(|| format!("{max} at most"));
        let counts: Vec<String> = at_start.into_iter().chain(at_most).chain([last]).collect();
        let counts = counts.join(", ");
        let remedy = if end > 0 && !are_kept_out(scene, simulation) {
            "; bodies with [body.self_collision] that start apart stay so"
        } else {
            ""
        };
        Some(format!("surfaces passed through each other, edges through triangles: {counts}{remedy}"))
    }

    /// What to say of springs and fabric that were longer than cloth ever is, or so long that its layers do not stop each other.
    fn too_long(&self, simulation: &Simulation, scene: &Scene) -> Option<String> {
        let slips = |body: &&BodyInfo| {
            // From 1 down the body was warned of before.
            body.slips_from.is_some_and(|stretch| stretch > 1.0 && self.max_stretch > stretch)
        };
        let then = if let Some(body) = simulation.bodies().iter().find(slips) {
            format!(
                "from {:.2} on nodes of another layer slip between those of body `{}`: a larger self_collision.thickness, stiffer \
                 springs or a finer mesh would do",
                body.slips_from.unwrap_or_default(),
                body.name
            )
        } else if self.max_stretch > 1.0 + TOO_FAR && self.stretched(scene).is_none() {
            let remedy = if scene.solver.is_primal() {
                "slower colliders and pins or a smaller time.max_step"
            } else {
                "shorter steps for them, or solver.method = \"ice\" with solver.ice.form = \"primal\", which holds them at any step"
            };
            format!(
                "cloth does not stretch so far, rubber may: stiffer springs or fabric would do, and {remedy}"
            )
        } else {
            return None;
        };
        Some(format!("a spring or the fabric was {:.2} times its rest length; {then}", self.max_stretch))
    }

    /// What to say of a fabric that implicit steps have stretched beyond what fabrics bear.
    fn stretched(&self, scene: &Scene) -> Option<String> {
        let strain = self.strain.as_ref()?;
        let most = strain.warp[1].max(strain.weft[1]);
        let (ice, step) = (&scene.solver.ice, scene.time.dt / f64::from(scene.time.substeps()));
        (scene.solver.is_primal() && step > FOLLOWS && most > TOO_FAR).then(|| {
            let steps = match ice.newton_steps {
                0 => String::new(),
                1 => "one Newton step in ".to_owned(),
                steps => format!("{steps} Newton steps in "),
            };
            let advice = if ice.newton_steps > 0 { "solver.ice.newton_steps = 0, or " } else { "" };
            let is_pulled_apart = self.intersections.is_some_and(|found| found.max > 0);
            let other = if is_pulled_apart {
                "what starts through something else stretches while it is pulled apart; if it was not that, "
            } else {
                ""
            };
            let shortest = scene.time.dt / f64::from(self.substeps_max.max(1));
            let why = if shortest > FOLLOWS {
                format!(
                    "{steps}a sub-step of {step:.1e} s may not follow cloth that folds or lands quickly; {advice}time.max_step = \
                     {FOLLOWS} would do"
                )
            } else {
                format!(
                    "it was pressed or pulled faster than it could follow, though contact cut sub-steps down to {shortest:.1e} s; slower \
                     colliders and pins, or a smaller time.max_step, may help"
                )
            };
            format!("a fabric was {:.2} times its rest length: {other}{why}", 1.0 + most)
        })
    }

    fn bodies(&self, simulation: &Simulation, scene: &Scene) -> Vec<BodySummary> {
        let summary = |(index, body): (usize, &BodyInfo)| BodySummary {
            name: body.name.clone(),
            nodes: body.nodes,
            vertices: body.vertices,
            triangles: body.triangles,
            frozen: simulation
                .frozen()
                .iter()
                .find(|one| one.body as usize == index)
                .map(|one| one.why.first),
            volume: self.volumes.summary(index, scene, simulation.report()),
        };
        simulation.bodies().iter().enumerate().map(summary).collect()
    }
}

/// What to say of a body that diverged.
fn frozen(one: &Frozen) -> String {
    let Diverged { body, first, what, .. } = &one.why;
    format!("body `{body}` was frozen as it was before frame {first}, in which it diverged: {what}")
}

impl PairSummary {
    fn take(&mut self, report: &FrameReport) {
        self.end = report.pairs;
        self.max = self.max.max(report.pairs);
        self.nearest = match (self.nearest, report.nearest_pair) {
            (Some(least), Some(now)) => Some(least.min(now)),
            (least, now) => least.or(now),
        };
        self.searches += report.pair_searches;
    }
}

/// The middle of `values`, the mean of the two where there are two; 0 without any.
pub fn median(values: &[f64]) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    match sorted.len() {
        0 => 0.0,
        n if n % 2 == 1 => sorted[n / 2],
        n => 0.5 * (sorted[n / 2 - 1] + sorted[n / 2]),
    }
}

/// `count` things in `ms` [ms] as things a second; 0 where nothing was timed.
pub fn rate(count: f64, ms: f64) -> f64 {
    if ms > 0.0 { count / (ms * 1e-3) } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::{median, rate};

    #[test]
    fn the_median_is_the_middle() {
        assert_eq!(median(&[]), 0.0);
        assert_eq!(median(&[3.0, 1.0, 9.0]), 3.0);
        assert_eq!(median(&[4.0, 1.0, 9.0, 2.0]), 3.0);
        assert_eq!((rate(10.0, 5.0), rate(10.0, 0.0)), (2000.0, 0.0));
    }
}
