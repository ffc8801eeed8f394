//! What a program changes while a scene runs: where colliders and pins go, the world, the scene itself.

#[cfg(feature = "gpu")]
use crate::backend::Lost;
#[cfg(feature = "gpu")]
use crate::gpu::{VertexTarget, View};
use crate::motion::keyframes::Track;
use crate::scene::{Keyframe, Rotation, SceneError, World};
use crate::simulation::Simulation;
#[cfg(feature = "gpu")]
use crate::simulation::StepError;

/// A rigid motion from the start: first the turn about the origin, then the shift.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Turn from the start, about the origin.
    pub rotate: Rotation,
    /// Shift [m].
    pub translate: [f64; 3],
}

impl Pose {
    fn checked(self, what: &str) -> Result<Self, SceneError> {
        let Self { rotate: Rotation { axis, degrees }, translate } = self;
        let numbers = axis.iter().chain(&translate).chain(std::iter::once(&degrees));
        if numbers.clone().all(|number| number.is_finite()) {
            return Ok(self);
        }
        Err(SceneError::new(what, format!("{self:?} is no pose: finite numbers would do")))
    }
}

impl Simulation {
    /// Brings a collider, by its place in the scene's list, to a pose during the next frame, evenly; it stays there. The
    /// pose counts from where it starts. Nodes that it carries follow its keyframes, not this.
    ///
    /// # Errors
    /// Where there is no such collider, it still follows keyframes of the scene, or the pose is not finite.
    pub fn move_collider(&mut self, collider: usize, to: Pose) -> Result<(), SceneError> {
        let what = format!("collider[{collider}]");
        let to = to.checked(&what)?;
        let count = self.backend.assembly().colliders.len();
        if collider >= count {
            return Err(SceneError::new(what, format!("is not there; the scene has {count}")));
        }
        self.go_to(&what, to, |assembly| assembly.colliders[collider].track_mut())
    }

    /// Brings the nodes of a pin, by its place in the body's list, to a pose during the next frame, evenly; they stay there.
    /// The pose counts from where they start.
    ///
    /// # Errors
    /// Where there is no such body or pin, it has no keyframe at all (one at t = 0 makes it movable) or still follows some,
    /// or the pose is not finite.
    pub fn move_pins(&mut self, body: usize, pin: usize, to: Pose) -> Result<(), SceneError> {
        let what = format!("body[{body}].pin[{pin}]");
        let to = to.checked(&what)?;
        let Some(&track) = self.backend.assembly().track_of_pin.get(&(body, pin)) else {
            return Err(SceneError::new(
                what,
                "is not there or never moves; a keyframe at t = 0 makes a pin movable",
            ));
        };
        self.go_to(&what, to, |assembly| &mut assembly.tracks[track])
    }

    fn go_to(
        &mut self,
        what: &str,
        to: Pose,
        track: impl Fn(&mut crate::build::Assembly) -> &mut Track,
    ) -> Result<(), SceneError> {
        let dt = self.dt();
        let now = f64::from(self.frame()) * dt;
        let mut kept = false;
        self.backend.alter(&mut |assembly| {
            let track = track(assembly);
            kept = track.goes_on_after(now);
            if !kept {
                let Pose { rotate, translate } = to;
                track.go_to(now, Keyframe { t: now + dt, translate, rotate: Some(rotate), pivot: [0.0; 3] });
            }
        });
        if kept {
            return Err(SceneError::new(what, "follows keyframes; one that does not could be moved"));
        }
        Ok(())
    }

    /// Lets go of a vertex that [`Self::move_pin`] has taken: it is free again, with the velocity that it was moved with in
    /// the last frame. What a pin of the scene holds stays held. Which vertices were taken is no part of a snapshot.
    ///
    /// # Errors
    /// Where there is no such body or vertex.
    pub fn let_go(&mut self, body: &str, vertex: usize) -> Result<(), SceneError> {
        let (found, node) = self.node_of(body, vertex)?;
        let nodes: Vec<u32> = found.nodes_at(node).map(|node| found.solver_index(node) as u32).collect();
        let taken = |node: &u32| self.taken.contains(node);
        for node in nodes.into_iter().filter(taken).collect::<Vec<_>>() {
            self.taken.retain(|&other| other != node);
            self.moved.retain(|&other| other != node);
            self.input.moves.retain(|&(other, ..)| other != node);
            self.backend.let_go(node as usize);
        }
        Ok(())
    }

    /// Where keyframes, or the program, have brought a collider when a `share` of the last frame has gone by: rows of the
    /// rotation from its start, and the shift after it [m]. `None` where there is no such collider.
    pub fn collider_pose(&self, collider: usize, share: f64) -> Option<([[f64; 3]; 3], [f64; 3])> {
        let pose = self.backend.assembly().colliders.get(collider)?.track().pose(self.time_at(share));
        Some((pose.rotation, pose.shift))
    }

    /// Nodes of a collider's mesh [m] where poses have brought them when a `share` of the last frame has gone by, before
    /// [`Self::collider_pose`] moves them all. `None` where there is no such collider, or it keeps its shape.
    pub fn collider_nodes(&self, collider: usize, share: f64) -> Option<Vec<[f64; 3]>> {
        let mesh = self.backend.assembly().colliders.get(collider)?.mesh()?;
        mesh.deforms().then(|| mesh.nodes(self.time_at(share)))
    }

    /// When a `share` of the last frame has gone by [s].
    fn time_at(&self, share: f64) -> f64 {
        (f64::from(self.frame()) - 1.0 + share).max(0.0) * self.dt()
    }

    /// Length of a frame [s].
    pub fn dt(&self) -> f64 {
        self.backend.assembly().time.dt
    }

    /// Changes gravity, drag, wind and air from the next frame on.
    ///
    /// # Errors
    /// Names what is impossible. Where a scene was built without air there is nothing that it could blow on.
    pub fn set_world(&mut self, world: &World) -> Result<(), SceneError> {
        world.check()?;
        if world.air.is_some() && self.backend.assembly().world.air.is_none() {
            return Err(SceneError::new(
                "world.air",
                "comes to a scene without air; it must be built with some",
            ));
        }
        self.backend.alter(&mut |assembly| assembly.world = world.clone());
        Ok(())
    }

    /// Makes the vertices at the nodes `nodes` of a body ready to be drawn by [`Self::draw`]; `u32::MAX` for one that no node
    /// carries. False where it does not run on a GPU.
    ///
    /// # Errors
    /// A GPU may be lost, or have no memory for it.
    ///
    /// # Panics
    /// Where there is no body with this index, or no such node.
    #[cfg(feature = "gpu")]
    pub fn make_drawn(&mut self, body: usize, nodes: &[u32]) -> Result<bool, StepError> {
        let (count, frame) = (self.bodies[body].nodes, self.frame());
        let beyond = nodes.iter().find(|&&node| node != u32::MAX && node as usize >= count);
        assert!(beyond.is_none(), "node {beyond:?} of a body with {count}");
        self.backend.make_drawn(body, nodes).map_err(|Lost(why)| StepError::Lost { frame, why })
    }

    /// Has the GPU write places and unit normals of a body's vertices, as they were [made ready](Self::make_drawn), to where
    /// a renderer on the same device draws them, after all frames that were launched. Normals are area-weighted. Nothing
    /// comes to the host; what is not finite is not written.
    ///
    /// # Errors
    /// A GPU may be lost, or not give a kernel that much of the renderer's buffer.
    ///
    /// # Panics
    /// Where there is no body with this index.
    #[cfg(feature = "gpu")]
    pub fn draw(&mut self, body: usize, target: &VertexTarget, view: &View) -> Result<(), StepError> {
        let frame = self.frame();
        self.backend.draw(body, target, view).map_err(|Lost(why)| StepError::Lost { frame, why })
    }

    /// Goes on where a simulation of another scene is: takes its time, and place and velocity of the nodes of each body that
    /// has the same name and as many nodes here as there. What constraints remember comes along where there are as many.
    /// Nodes held here stand still.
    pub fn take_over(&mut self, from: &Self) {
        for to in 0..self.bodies.len() {
            let name = &self.bodies[to].name;
            let Some(other) = from.bodies.iter().position(|body| body.name == *name) else { continue };
            let nodes = self.bodies[to].nodes;
            if from.bodies[other].nodes != nodes {
                continue;
            }
            for node in 0..nodes {
                let here = self.backend.assembly().bodies[to].solver_index(node);
                let there = from.backend.assembly().bodies[other].solver_index(node);
                let free = self.backend.is_free(here);
                let velocity = if free { from.backend.velocity(there) } else { [0.0; 3] };
                self.backend.set(here, from.backend.position(there), velocity);
            }
        }
        let (mine, theirs) = (self.backend.solver_state(), from.backend.solver_state());
        let lengths =
            |all: &crate::backend::SolverState| (all.pulls.len(), all.active.len(), all.joints.len());
        if lengths(&mine) == lengths(&theirs) {
            self.backend.set_solver_state(&theirs);
        }
        self.report.frame = from.frame();
        // A device that is lost says so in the next step.
        let _ = self.measure();
    }
}
