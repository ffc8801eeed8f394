//! From a scene to what the backends run: what each feature makes of it, in the order in which they need each other.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings};
use crate::attachments::constraints::{IS_POINT, Point};
use crate::elements::KINDS;
use crate::elements::element::List;
use crate::elements::load::build as loads;
use crate::scene::{Air, Body, Method, Scene, SceneError};
use crate::solvers::constraints::Constraints;
use crate::solvers::implicit::levels::Level;
use crate::solvers::implicit::sewn::sews_levels;
use crate::solvers::xpbd;
use crate::volume::constraint::VolumeConstraint;
use std::collections::BTreeSet;

impl Assembly {
    /// Checks a scene and builds it.
    pub fn new(scene: &Scene) -> Result<Self, SceneError> {
        scene.validate()?;
        let mut assembly = Self::empty(scene);
        assembly.add_colliders(scene)?;
        assembly.add_frictions(scene);
        assembly.add_meetings(scene);
        for (index, body) in scene.bodies.iter().enumerate() {
            assembly.add_body(index, body, scene)?;
        }
        assembly.add_own_lists();
        let loads = loads::loads(&assembly.bodies, &scene.forces)?;
        let constraints = Constraints::new(&assembly.bodies, assembly.solver.method);
        let mut elements: Vec<List> = KINDS.map(|kind| List::new(kind, &assembly.bodies, scene)).into();
        for (body, warning) in elements.iter_mut().flat_map(|list| list.warnings.drain(..)) {
            assembly.bodies[body].warnings.push(warning);
        }
        assembly.bodies.iter_mut().for_each(BodyAssembly::forget_laid);
        assembly.extensions.insert(loads);
        assembly.extensions.insert(elements);
        if assembly.solver.is_primal() {
            let bodies = 0..assembly.bodies.len();
            let elements: Vec<bool> = bodies.map(|body| assembly.has_solved_elements(body)).collect();
            let is_solved = |name: &str| {
                let of = |body: &BodyAssembly| body.name == name;
                assembly.bodies.iter().position(of).is_some_and(|body| elements[body])
            };
            let joined =
                sews_levels(&scene.seams, is_solved) || scene.bodies.iter().any(Body::has_surface_contact);
            assembly.extensions.insert(Level::all(&assembly.bodies, &constraints, &elements, joined));
        }
        if assembly.solver.method == Method::Xpbd {
            let positions = xpbd::levels::Constraints::new(&assembly.bodies, &assembly.solver.xpbd);
            assembly.extensions.insert(positions);
        }
        assembly.extensions.insert(constraints);
        assembly.attach(scene)?;
        assembly.start_pins();
        assembly.start_points();
        assembly.start_velocities(scene);
        assembly.measure_seams();
        assembly.note_sewing();
        assembly.add_surfaces(scene);
        assembly.note_start_contacts(scene)?;
        assembly.note_starts_inside(scene);
        Ok(assembly)
    }

    /// A body of a scene of its own, with its fabric laid on its triangles, and nothing else.
    pub fn with_fabric(body: &Body) -> Result<Self, SceneError> {
        let scene = Scene::new("").body(body.clone());
        scene.validate()?;
        let mut assembly = Self::empty(&scene);
        let mut built = assembly.next_body(0, body)?;
        built.lay_fabric(body)?;
        assembly.push(built);
        Ok(assembly)
    }

    /// Builds a body and adds it.
    fn add_body(&mut self, index: usize, body: &Body, scene: &Scene) -> Result<(), SceneError> {
        let path = format!("body[{index}]");
        let mut built = self.next_body(index, body).map_err(|e| e.under(&path))?;
        self.add_pins(&path, body, scene, &mut built)?;
        if let Some(wish) = &body.volume {
            built.keep_volume(wish).map_err(|e| e.under(&path))?;
        }
        built.lay_fabric(body).map_err(|e| e.under(&path))?;
        built.enable_contact(body).map_err(|e| e.under(&path))?;
        self.push(built);
        Ok(())
    }

    /// Gives back what only the building of a backend needed: at millions of nodes it is most of the memory.
    pub fn release(&mut self) {
        self.forget_elements();
        for body in &mut self.bodies {
            body.start = Vec::new();
            body.start_velocity = Vec::new();
            body.mass = Vec::new();
            body.free = Vec::new();
            body.forget_weights();
            if let BodySprings::Mesh(lists) = &mut body.springs {
                for list in lists {
                    list.rest = Vec::new();
                }
            }
        }
    }

    /// Whether more than gravity may add energy: wind, moving air, loads, moving pins or colliders, pressure, a growing volume.
    pub fn is_driven(&self) -> bool {
        let drives = |body: &BodyAssembly| {
            let volume = body.volume();
            volume.is_some_and(|volume| volume.drives(body.rest_volume.unwrap_or(0.0)))
        };
        self.world.wind_force != [0.0; 3]
            || self.world.air.as_ref().is_some_and(Air::moves)
            || !self.loads().is_empty()
            || !self.moving_pins().is_empty()
            || self.colliders_move()
            || self.attachments().drives()
            || self.bodies.iter().any(drives)
    }
    /// For each body whether what acts on it changes over a span of time [s]: gusts, loads, its pins, its seams, its volume.
    pub fn changing_over(&self, span: [f64; 2]) -> Vec<bool> {
        let is_gusty = self.world.air.as_ref().is_some_and(Air::is_gusty);
        let changes = |volume: &VolumeConstraint| volume.changes_over(span);
        let of_body = |body: &BodyAssembly| is_gusty || body.volume().is_some_and(changes);
        let mut all: Vec<bool> = self.bodies.iter().map(of_body).collect();
        for load in self.loads().iter().filter(|load| load.changes_over(span)) {
            load.nodes.iter().for_each(|&node| all[self.number_of_body(node)] = true);
        }
        let moves: Vec<bool> = self.tracks().iter().map(|track| track.moves_over(span)).collect();
        for pin in self.moving_pins().iter().filter(|pin| moves[pin.track as usize]) {
            all[self.number_of_body(pin.node)] = true;
        }
        let follows = |point: &Point| moves.get(point.track as usize) == Some(&true);
        self.attachments().each_changing(span, follows, |node| all[self.number_of_body(node)] = true);
        all
    }

    /// Pairs of bodies that joints hold together.
    pub fn joined_bodies(&self) -> BTreeSet<[usize; 2]> {
        let pair =
            |ends: [u32; 2]| (ends[1] & IS_POINT == 0).then(|| ends.map(|node| self.number_of_body(node)));
        self.attachments()
            .joints
            .iter()
            .filter_map(|joint| pair(joint.ends))
            .filter(|[a, b]| a != b)
            .collect()
    }
}
