//! From a scene to what the backends run: bodies one after the other, nodes in an order of good locality, springs,
//! masses, pins, colliders and loads by solver index. All in f64; a backend takes it in its own numbers.
//!
//! User order stays outside: [`BodyAssembly::solver_index`] maps the user's indices to the solver's; nothing else does.

pub mod body;
pub mod grid;
pub mod pins;

use crate::attachments::constraints::Attachments;
use crate::build::body::{BodyAssembly, BodySprings, mesh_body};
use crate::contact::colliders::moving::MovingCollider;
use crate::elements::KINDS;
use crate::elements::element::{Described, List};
use crate::elements::load::build::{self as loads, Load};
use crate::motion::keyframes::Track;
use crate::scene::{Air, Body, Mesh, Scene, SceneError, Solver, Time, World};
use crate::solvers::constraints::Constraints;
use crate::solvers::implicit::levels::Level;
use std::collections::BTreeMap;
use std::ops::Range;

/// A scene, ready to run.
pub struct Assembly {
    /// Bodies in the scene's order.
    pub bodies: Vec<BodyAssembly>,
    /// Number of places for nodes: each body starts at a multiple of the vector width.
    pub places: usize,
    /// Pins that move, ascending by solver index, each node once.
    pub moving_pins: Vec<MovingPin>,
    /// The motions that `moving_pins` follow.
    pub tracks: Vec<Track>,
    /// Which of the tracks a pin follows, by body and pin.
    pub track_of_pin: BTreeMap<(usize, usize), usize>,
    /// Colliders in the scene's order.
    pub colliders: Vec<MovingCollider>,
    /// Point loads and torques.
    pub loads: Vec<Load>,
    /// Springs as a list, where the method makes constraints of them.
    pub constraints: Constraints,
    /// Nodes that are joined to others or to points, or held near others.
    pub attachments: Attachments,
    /// Coarser levels of them, where the form of the constraints asks for some.
    pub levels: Vec<Level>,
    /// Elements whose forces are found one by one, a list for each of [`KINDS`].
    pub elements: Vec<List>,
    /// How springs are solved.
    pub solver: Solver,
    /// Gravity, drag, wind.
    pub world: World,
    /// Frames and steps.
    pub time: Time,
}

/// A node that follows keyframes.
#[derive(Clone, Copy, Debug)]
pub struct MovingPin {
    /// Solver index.
    pub node: u32,
    /// Which of the tracks.
    pub track: u32,
    /// Where it starts [m].
    pub start: [f64; 3],
}

impl Assembly {
    /// Checks a scene and builds it.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        scene.validate()?;
        let mut assembly = Self {
            bodies: Vec::new(),
            places: 0,
            moving_pins: Vec::new(),
            tracks: Vec::new(),
            track_of_pin: BTreeMap::new(),
            colliders: colliders(scene)?,
            loads: Vec::new(),
            constraints: Constraints::default(),
            attachments: Attachments::default(),
            levels: Vec::new(),
            elements: Vec::new(),
            solver: scene.solver.clone(),
            world: scene.world.clone(),
            time: scene.time.clone(),
        };
        for (index, body) in scene.bodies.iter().enumerate() {
            assembly.add_body(index, body, scene)?;
        }
        assembly.loads = loads::loads(&assembly.bodies, &scene.forces)?;
        assembly.constraints = Constraints::new(&assembly.bodies, assembly.solver.method);
        assembly.elements = KINDS.map(|kind| List::new(kind, &assembly.bodies, scene)).into();
        if assembly.solver.is_primal() {
            let bodies = 0..assembly.bodies.len();
            let elements: Vec<bool> = bodies.map(|body| assembly.has_solved_elements(body)).collect();
            assembly.levels = Level::all(&assembly.bodies, &assembly.constraints, &elements);
        }
        assembly.attach(scene)?;
        assembly.start_pins();
        assembly.start_points();
        assembly.measure_seams();
        assembly.note_start_contacts();
        assembly.note_starts_inside(scene);
        Ok(assembly)
    }

    /// Builds a body and adds it.
    fn add_body(&mut self, index: usize, body: &Body, scene: &Scene) -> Result<(), SceneError> {
        let path = format!("body[{index}]");
        let mut built = match &body.mesh {
            Mesh::Grid(grid) => grid::build(body, *grid),
            mesh => mesh_body(body, mesh),
        }
        .map_err(|e| e.under(&path))?;
        built.name = if body.name.is_empty() { format!("body{index}") } else { body.name.clone() };
        built.first = self.places;
        self.add_pins(&path, body, scene, &mut built)?;
        if let Some(wish) = &body.volume {
            built.keep_volume(wish).map_err(|e| e.under(&path))?;
        }
        built.enable_contact(body).map_err(|e| e.under(&path))?;
        self.places += built.places();
        self.bodies.push(built);
        Ok(())
    }

    /// Gives back what only the building of a backend needed: at millions of nodes it is most of the memory.
    pub fn release(&mut self) {
        self.elements.iter_mut().for_each(|list| list.all = Described::default());
        for body in &mut self.bodies {
            body.start = Vec::new();
            body.mass = Vec::new();
            body.free = Vec::new();
            if let Some(volume) = &mut body.volume {
                volume.weights = None;
            }
            if let BodySprings::Mesh(lists) = &mut body.springs {
                for list in lists {
                    list.rest = Vec::new();
                }
            }
        }
    }

    /// The elements of a kind, by name, that a body has, among all of its kind.
    pub fn elements_of(&self, kind: &str, body: usize) -> Range<usize> {
        let list = self.elements.iter().find(|list| list.kind.name == kind);
        list.map_or(0..0, |list| list.bodies[body].clone())
    }

    /// Whether anything of a body is solved for: springs or other elements.
    pub fn is_solved_for(&self, body: usize) -> bool {
        let springs = self.constraints.bodies.get(body).is_some_and(|all| !all.is_empty());
        springs || self.has_solved_elements(body)
    }

    /// Whether a body has elements other than springs that are solved for.
    pub fn has_solved_elements(&self, body: usize) -> bool {
        self.elements.iter().any(|list| list.implicit && !list.bodies[body].is_empty())
    }

    /// A volume of 0 for each closed body.
    pub fn no_volumes(&self) -> Vec<Option<f64>> {
        self.bodies.iter().map(|body| body.rest_volume.map(|_| 0.0)).collect()
    }

    /// Whether any collider moves.
    pub fn colliders_move(&self) -> bool {
        self.colliders.iter().any(MovingCollider::moves)
    }

    /// The volume that each body is to have at time `t` [s], in m³, where it keeps one.
    pub fn volume_targets(&self, t: f64) -> Vec<Option<f64>> {
        self.bodies.iter().map(|body| body.volume.as_ref()?.target(t)).collect()
    }

    /// Whether more than gravity may add energy: wind, moving air, loads, moving pins or colliders, pressure, a growing volume.
    pub fn is_driven(&self) -> bool {
        let drives = |body: &BodyAssembly| {
            let volume = body.volume.as_ref();
            volume.is_some_and(|volume| volume.drives(body.rest_volume.unwrap_or(0.0)))
        };
        self.world.wind_force != [0.0; 3]
            || self.world.air.as_ref().is_some_and(Air::moves)
            || !self.loads.is_empty()
            || !self.moving_pins.is_empty()
            || self.colliders_move()
            || self.attachments.drives()
            || self.bodies.iter().any(drives)
    }
}

fn colliders(scene: &Scene) -> Result<Vec<MovingCollider>, SceneError> {
    let step = scene.time.longest_step();
    let at = |i: usize| move |error: SceneError| error.under(&format!("collider[{i}]"));
    let numbered = scene.colliders.iter().enumerate();
    numbered.map(|(i, one)| MovingCollider::in_steps(one, step).map_err(at(i))).collect()
}

impl SceneError {
    /// The same error, its path taken to be under `parent`.
    pub(crate) fn under(self, parent: &str) -> Self {
        let path = if self.path.is_empty() { parent.to_owned() } else { format!("{parent}.{}", self.path) };
        Self { path, ..self }
    }
}
