//! The answer for a scene.

use super::Args;
use super::words::{memory, number};
use crate::console::{self, counted, grouped};
use crate::intersections;
use serde::Serialize;
use std::collections::BTreeMap;
use std::path::Path;
use taffeta::diagnostics::culprit::Culprit;
use taffeta::diagnostics::tension::Tension;
use taffeta::scene::{Collider, ConstraintForm, Method, Scene, Seam, Solver};
use taffeta::{BodyInfo, ColliderInfo, Options, Simulation};
use taffeta_io::Loaded;
use taffeta_io::program::{Failure, one_line};

/// The answer for a scene.
#[derive(Serialize)]
struct Report {
    scene: String,
    title: String,
    bodies: Vec<BodyReport>,
    colliders: Vec<ColliderReport>,
    seams: Vec<SeamReport>,
    /// Before the first frame.
    memory_bytes: usize,
    /// More, for lists of contacts between triangles: while they lie flat, and in a dense pile. Null without such contact.
    contact_list_bytes: Option<[u64; 2]>,
    substeps: u32,
    step: f64,
    method: Method,
    /// With implicit springs: which equations; null with others.
    form: Option<ConstraintForm>,
    /// Of what is explicit [s]: springs, other elements and drag; with the method "ice" not springs, in its primal form drag alone.
    /// Null without any.
    largest_stable_step: Option<f64>,
    /// The same however springs are folded [s].
    largest_stable_step_folded: Option<f64>,
    /// The same in any flow of air [s]. Null where air does not act on the body that sets it.
    largest_stable_step_in_air: Option<f64>,
    /// What sets it; null where nothing does.
    largest_stable_step_set_by: Option<CulpritReport>,
    /// Null with explicit springs, with the form "primal", and where nothing hangs.
    hanging: Option<HangingReport>,
    /// Null where no body has triangles, and where there are very many.
    intersections: Option<IntersectionReport>,
    advice: Vec<String>,
}

/// Edges that pass through triangles at the start.
#[derive(Serialize)]
struct IntersectionReport {
    /// How many; at least so many where not all were looked at.
    pairs: u64,
    complete: bool,
    /// The first in words; null without any.
    first: Option<String>,
    /// What to do about them.
    #[serde(skip)]
    remedy: &'static str,
}

/// What sets the largest stable step.
#[derive(Serialize)]
struct CulpritReport {
    body: String,
    /// The vertex that moves most in the mode that sets the step.
    vertex: usize,
    /// What resists there: `structural springs`, `hinges`, `membranes`, `bends`, `drag`, …
    what: String,
    /// `stiffness` or `damping`.
    quantity: &'static str,
    /// What the scene gives for it, in `unit`; null for the stiffness of a fabric, which is several numbers.
    value: Option<f64>,
    unit: &'static str,
    /// Its fraction of all that resists in this mode.
    share: f64,
    /// Largest step [s] if there were nothing else, and without it; null where the scene's step is not too long, `without` also
    /// where any step would do.
    alone: Option<f64>,
    without: Option<f64>,
    /// What to multiply it by so that the scene's step is stable; null where the step is not too long, or this would not do.
    factor: Option<f64>,
    #[serde(skip)]
    words: String,
}

/// Where implicit springs are pulled hardest by what hangs in them.
#[derive(Serialize)]
struct HangingReport {
    body: String,
    vertex: usize,
    /// T [N].
    pull: f64,
    /// T/(m L) [1/s²].
    rate: f64,
    /// h² T/(m L): waves across the pull grow where it is above 1.
    growth: f64,
    /// The longest step [s] in which they do not.
    largest_step: f64,
}

#[derive(Serialize)]
struct SeamReport {
    from: String,
    to: String,
    /// Pairs of nodes.
    pairs: usize,
}

#[derive(Serialize)]
struct BodyReport {
    name: String,
    nodes: usize,
    pinned: usize,
    /// Nodes that pins hold until they break.
    breaking: usize,
    tethers: usize,
    vertices: usize,
    triangles: usize,
    springs: Vec<KindCount>,
    /// Nodes of coarser levels, where springs are solved for by multigrid.
    levels: Vec<usize>,
    /// Elements beside springs: a key for each kind, in alphabetical order.
    #[serde(flatten)]
    elements: BTreeMap<&'static str, usize>,
    mass: f64,
    closed: bool,
    volume: Option<f64>,
    /// Stretch up to which its layers stop each other; null where they do not touch.
    layers_hold_to: Option<f64>,
    /// As layers have it.
    does_not_meet: Apart,
    repairs: Vec<String>,
}

#[derive(Serialize)]
struct ColliderReport {
    name: String,
    /// The key of its shape.
    shape: &'static str,
    /// Null where it is no surface of triangles.
    triangles: Option<usize>,
    /// Whether they close around an inside; null where it is no surface of triangles.
    closed: Option<bool>,
    keyframes: usize,
    poses: usize,
    repairs: Vec<String>,
    /// Names of bodies that it does not meet, as layers have it, and whether these are all.
    does_not_meet: Vec<String>,
    #[serde(skip)]
    meets_none: bool,
}

/// Names of other bodies and of colliders.
#[derive(Serialize)]
struct Apart {
    bodies: Vec<String>,
    colliders: Vec<String>,
}

#[derive(Serialize)]
struct KindCount {
    kind: &'static str,
    count: usize,
}

/// Checks a scene.
pub fn check(args: &Args) -> Result<(), Failure> {
    let loaded = taffeta_io::load_scene(&args.path, &args.sets)?;
    crate::memory::check(&loaded.scene)?;
    let simulation =
        Simulation::new(&loaded.scene, &Options { find_largest_steps: true, ..Options::default() })
            .map_err(|error| console::not_built(&loaded.source, &error))?;
    let report = Report::of(&args.path, &loaded, &simulation);
    console::say(&if args.json { console::json(&report)? } else { report.words() })
}

impl Report {
    fn of(path: &Path, loaded: &Loaded, simulation: &Simulation) -> Self {
        let step = loaded.scene.time.substep(0).1;
        Self {
            scene: path.display().to_string(),
            title: loaded.scene.title.clone(),
            bodies: bodies(&loaded.scene, simulation),
            colliders: colliders(&loaded.scene, simulation),
            seams: loaded.scene.seams.iter().zip(simulation.seam_pair_counts()).map(SeamReport::of).collect(),
            memory_bytes: simulation.memory(),
            contact_list_bytes: Some(loaded.scene.memory_needed().contact_lists).filter(|lists| lists[1] > 0),
            substeps: loaded.scene.time.substeps(),
            step,
            method: loaded.scene.solver.method,
            form: form(&loaded.scene.solver),
            largest_stable_step: finite(simulation.largest_stable_step()),
            largest_stable_step_folded: finite(simulation.largest_stable_step_folded()),
            largest_stable_step_in_air: simulation.largest_stable_step_in_air().and_then(finite),
            largest_stable_step_set_by: simulation.largest_step_culprit().map(CulpritReport::of),
            hanging: simulation.max_tension().map(|pulled| HangingReport::of(pulled, step)),
            intersections: IntersectionReport::of(&loaded.scene, simulation),
            advice: loaded.notes.iter().cloned().chain(console::warnings(simulation)).collect(),
        }
    }

    fn words(&self) -> String {
        let title = if self.title.is_empty() { "untitled scene" } else { &self.title };
        let mut lines = vec![format!("{}: {}", self.scene, one_line(title))];
        self.bodies.iter().for_each(|body| lines.extend(body.words()));
        self.colliders.iter().for_each(|collider| lines.extend(collider.words()));
        lines.extend(self.seams.iter().map(SeamReport::words));
        lines.push(self.memory());
        lines.push(format!("sub-steps a frame: {}, of {:.3e} s", self.substeps, self.step));
        lines.push(self.stable_step());
        lines.extend(self.largest_stable_step_set_by.iter().map(CulpritReport::words));
        lines.extend(self.hanging.iter().map(HangingReport::words));
        lines.extend(self.intersections.iter().map(IntersectionReport::words));
        lines.extend(self.advice.iter().map(|advice| format!("advice: {advice}")));
        lines.push("accepted".to_owned());
        lines.join("\n")
    }

    fn memory(&self) -> String {
        let lists = self.contact_list_bytes.map_or_else(String::new, |lists| {
            let [flat, piled] = lists.map(memory);
            format!(
                ", and lists of contacts: about {flat} while surfaces lie flat, about {piled} in a dense pile"
            )
        });
        format!("memory: {}{lists}", memory(self.memory_bytes as u64))
    }

    fn stable_step(&self) -> String {
        let by_nodes = self.form == Some(ConstraintForm::Primal);
        let (what, none) = match self.method {
            Method::Ice if by_nodes => (
                " (drag: springs and other elements are implicit)",
                "springs are implicit along and across themselves, and so are other elements; their accuracy is of first \
                 order in the step",
            ),
            Method::Ice => (" (other elements and drag: springs are implicit)", "springs are implicit"),
            Method::Xpbd => (
                " (other elements and drag: springs are constraints on positions)",
                "springs are constraints on positions, which hold at any step; shorter steps and more sweeps make them stiffer",
            ),
            Method::Acad => (" (springs below the threshold are explicit)", "no spring pulls on a free node"),
            _ => ("", "no spring pulls on a free node"),
        };
        let air = self.largest_stable_step_in_air;
        let air = air.map_or_else(String::new, |step| format!(", {step:.3e} s in any air"));
        match (self.largest_stable_step, self.largest_stable_step_folded) {
            (Some(rest), Some(folded)) => format!(
                "largest stable step: {rest:.3e} s at rest, {folded:.3e} s however the springs are folded{air}{what}"
            ),
            _ => format!("largest stable step: any; {none}"),
        }
    }
}

impl IntersectionReport {
    fn of(scene: &Scene, simulation: &Simulation) -> Option<Self> {
        let found = intersections::counted(simulation)?;
        let remedy = if intersections::are_kept_out(scene, simulation) {
            "the first frames pull them apart where there is room; place them apart to be sure"
        } else {
            "nothing pulls bodies apart that have no [body.self_collision]; place them apart, and it keeps them so"
        };
        Some(Self { pairs: found.pairs, complete: found.complete, first: found.first, remedy })
    }

    fn words(&self) -> String {
        let least = if self.complete { "" } else { "at least " };
        match &self.first {
            Some(first) => format!(
                "intersections at the start: {least}{}, such as {first}; {}",
                counted(
                    self.pairs as usize,
                    "edge passes through a triangle",
                    "edges pass through triangles"
                ),
                self.remedy
            ),
            None if self.complete => "intersections at the start: none".to_owned(),
            None => "intersections at the start: none found among too many to count".to_owned(),
        }
    }
}

impl CulpritReport {
    fn of(culprit: &Culprit) -> Self {
        Self {
            body: culprit.body.clone(),
            vertex: culprit.vertex,
            what: culprit.name(),
            quantity: culprit.quantity(),
            value: culprit.value,
            unit: culprit.unit(),
            share: culprit.share,
            alone: culprit.alone.and_then(finite),
            without: culprit.without.and_then(finite),
            factor: culprit.factor,
            words: culprit.to_string(),
        }
    }

    fn words(&self) -> String {
        let percent = 100.0 * self.share;
        format!("  set by {}: {percent:.0} % of what resists at vertex {}", self.words, self.vertex)
    }
}

impl HangingReport {
    fn of(pulled: &Tension, step: f64) -> Self {
        Self {
            body: pulled.body.clone(),
            vertex: pulled.vertex,
            pull: pulled.pull,
            rate: pulled.rate,
            growth: pulled.growth(step),
            largest_step: pulled.largest_step(),
        }
    }

    fn words(&self) -> String {
        format!(
            "hanging: body `{}` pulls hardest at vertex {}, T = {} N, T/(m L) = {} 1/s²; h² T/(m L) = {}, implicit \
             springs hold below 1: steps up to {:.3e} s",
            self.body,
            self.vertex,
            number(self.pull),
            number(self.rate),
            number(self.growth),
            self.largest_step
        )
    }
}

impl SeamReport {
    fn of((seam, pairs): (&Seam, usize)) -> Self {
        Self { from: seam.from.body.clone(), to: seam.to.body.clone(), pairs }
    }

    fn words(&self) -> String {
        let plural = if self.pairs == 1 { "" } else { "s" };
        format!("seam: `{}` to `{}`, {} pair{plural} of nodes", self.from, self.to, grouped(self.pairs))
    }
}

impl BodyReport {
    fn of(body: &BodyInfo, does_not_meet: Apart) -> Self {
        Self {
            name: body.name.clone(),
            nodes: body.nodes,
            pinned: body.pinned,
            breaking: body.breaking,
            tethers: body.tethers,
            vertices: body.vertices,
            triangles: body.triangles,
            springs: body.springs.iter().map(|&(kind, count)| KindCount { kind, count }).collect(),
            levels: body.levels.clone(),
            elements: body.elements.iter().copied().collect(),
            mass: body.mass,
            closed: body.rest_volume.is_some(),
            volume: body.rest_volume,
            layers_hold_to: body.slips_from,
            does_not_meet,
            repairs: body.repairs.clone(),
        }
    }

    fn words(&self) -> Vec<String> {
        let kinds: Vec<String> =
            self.springs.iter().map(|of| format!("{} {}", grouped(of.count), of.kind)).collect();
        let springs = if kinds.is_empty() { "none".to_owned() } else { kinds.join(", ") };
        let inside = match self.volume {
            Some(volume) => format!("closed, volume {} m³", number(volume)),
            None => "open".to_owned(),
        };
        let mut lines = vec![
            format!(
                "body `{}`: {} nodes, {} vertices, {} triangles, {:.4} kg, {inside}",
                self.name,
                grouped(self.nodes),
                grouped(self.vertices),
                grouped(self.triangles),
                self.mass
            ),
            format!("  springs: {springs}"),
        ];
        if !self.levels.is_empty() {
            let coarser: Vec<String> = self.levels.iter().map(|&nodes| grouped(nodes)).collect();
            lines.push(format!("  coarser levels: {} nodes", coarser.join(", ")));
        }
        if self.pinned > 0 {
            let all = if self.pinned == self.nodes { ", all of them: nothing moves freely" } else { "" };
            lines.push(format!("  pinned: {}{all}", grouped(self.pinned)));
        }
        if self.breaking > 0 {
            lines.push(format!("  pinned until that takes too much: {}", grouped(self.breaking)));
        }
        if self.tethers > 0 {
            lines.push(format!("  tethers: {}", grouped(self.tethers)));
        }
        for (kind, &count) in self.elements.iter().filter(|(_, count)| **count > 0) {
            lines.push(format!("  {}: {}", kind.replace('_', " "), grouped(count)));
        }
        if let Some(stretch) = self.layers_hold_to {
            lines.push(format!("  self-collision: layers stop each other up to a stretch of {stretch:.2}"));
        }
        for (kind, names) in
            [("body", &self.does_not_meet.bodies), ("collider", &self.does_not_meet.colliders)]
        {
            if !names.is_empty() {
                lines.push(format!("  layers: does not meet {}", listed(kind, names)));
            }
        }
        lines.extend(self.repairs.iter().map(|repair| format!("  {}", console::repaired(repair))));
        lines
    }
}

impl ColliderReport {
    fn of(collider: &ColliderInfo, does_not_meet: Vec<String>, meets_none: bool) -> Self {
        Self {
            name: collider.name.clone(),
            shape: collider.shape,
            triangles: collider.surface.map(|(triangles, _)| triangles),
            closed: collider.surface.map(|(_, closed)| closed),
            keyframes: collider.keyframes,
            poses: collider.poses,
            repairs: collider.repairs.clone(),
            does_not_meet,
            meets_none,
        }
    }

    fn words(&self) -> Vec<String> {
        let mut words = format!("collider `{}`: {}", self.name, self.shape);
        if let (Some(triangles), Some(closed)) = (self.triangles, self.closed) {
            let what = if closed { "closed: solid" } else { "open: a sheet with two sides" };
            words += &format!(", {} triangles, {what}", grouped(triangles));
        }
        for (number, what) in [(self.keyframes, "keyframe"), (self.poses, "pose")] {
            if number > 0 {
                words += &format!(", {} {what}{}", grouped(number), if number == 1 { "" } else { "s" });
            }
        }
        let layers = match &self.does_not_meet[..] {
            [] => None,
            _ if self.meets_none => Some("  layers: meets no body".to_owned()),
            names => Some(format!("  layers: does not meet {}", listed("body", names))),
        };
        let repairs = self.repairs.iter().map(|repair| format!("  {}", console::repaired(repair)));
        std::iter::once(words).chain(layers).chain(repairs).collect()
    }
}

fn bodies(scene: &Scene, simulation: &Simulation) -> Vec<BodyReport> {
    let of = |(index, body): (usize, &BodyInfo)| {
        let own = &scene.bodies[index].layers;
        let others = scene.bodies.iter().enumerate();
        let bodies = others.filter(|(other, body)| *other != index && !own.meets(&body.layers));
        let colliders = scene.colliders.iter().zip(simulation.colliders());
        let colliders = colliders.filter(|(collider, _)| !own.meets(&collider.layers));
        let apart = Apart {
            bodies: bodies.map(|(_, body)| body.name.clone()).collect(),
            colliders: colliders.map(|(_, collider)| collider.name.clone()).collect(),
        };
        BodyReport::of(body, apart)
    };
    simulation.bodies().iter().enumerate().map(of).collect()
}

fn colliders(scene: &Scene, simulation: &Simulation) -> Vec<ColliderReport> {
    let of = |(described, collider): (&Collider, &ColliderInfo)| {
        let apart = scene.bodies.iter().filter(|body| !described.layers.meets(&body.layers));
        let does_not_meet: Vec<String> = apart.map(|body| body.name.clone()).collect();
        let meets_none = does_not_meet.len() == scene.bodies.len();
        ColliderReport::of(collider, does_not_meet, meets_none)
    };
    scene.colliders.iter().zip(simulation.colliders()).map(of).collect()
}

/// The names of some bodies or colliders, the first ones where they are many.
fn listed(kind: &str, names: &[String]) -> String {
    const FIRST: usize = 4;
    let first: Vec<String> = names.iter().take(FIRST).map(|name| format!("`{name}`")).collect();
    let more = match names.len().saturating_sub(FIRST) {
        0 => String::new(),
        more => format!(" and {} more", grouped(more)),
    };
    let kind = match (kind, names.len()) {
        (kind, 1) => kind.to_owned(),
        ("body", _) => "bodies".to_owned(),
        (kind, _) => format!("{kind}s"),
    };
    format!("{kind} {}{more}", first.join(", "))
}

fn form(solver: &Solver) -> Option<ConstraintForm> {
    match solver.method {
        Method::Ice => Some(solver.ice.form),
        Method::Acad => Some(solver.acad.form),
        _ => None,
    }
}

fn finite(step: f64) -> Option<f64> {
    Some(step).filter(|step| step.is_finite())
}
