//! What a program changes while a scene runs: where colliders and pins go, the world, the scene itself.

#[cfg(feature = "gpu")]
use crate::backend::Lost;
use crate::backend::SolverState;
#[cfg(feature = "gpu")]
use crate::backend::{VertexTarget, View};
use crate::motion::keyframes::Track;
use crate::scene::{Keyframe, Path, Rotation, SceneError, World, check_rotation};
use crate::simulation::{BodyHandle, ColliderHandle, InputError, PinHandle, Simulation};
#[cfg(feature = "gpu")]
use crate::simulation::{BodyInfo, StepError};
use glam::{DAffine3, DMat3, DVec3};

/// A rigid motion from the start: first the turn about the origin, then the shift.
///
/// ```
/// use taffeta::Pose;
/// use taffeta::glam::{DQuat, DVec3};
///
/// let quarter = Pose::new(DQuat::from_rotation_y(std::f64::consts::FRAC_PI_2), DVec3::new(0.0, 0.1, 0.0));
/// assert!((quarter.rotate.degrees - 90.0).abs() < 1e-9);
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Pose {
    /// Turn from the start, about the origin.
    pub rotate: Rotation,
    /// Shift [m].
    pub translate: [f64; 3],
}

impl Pose {
    /// First the turn about the origin, then the shift [m].
    pub fn new(rotate: impl Into<Rotation>, translate: impl Into<DVec3>) -> Self {
        Self { rotate: rotate.into(), translate: translate.into().to_array() }
    }

    /// Refuses what no keyframe could have. No turn at all needs no axis.
    pub(super) fn checked(self) -> Result<Self, InputError> {
        let Self { rotate, translate } = self;
        let path = Path::of("pose");
        path.key("translate").within(&translate)?;
        if rotate == Rotation::default() {
            return Ok(self);
        }
        check_rotation(&path.key("rotate"), &rotate)?;
        Ok(self)
    }
}

impl Simulation {
    /// Brings a collider to a pose during the next frame, evenly; it stays there. The pose counts from where it starts.
    /// Nodes that it carries follow its keyframes, not this.
    ///
    /// # Errors
    /// Where the collider is one of another simulation, it still follows keyframes of the scene, or no keyframe could have the pose:
    /// places within ±10⁶ m and an axis with a direction would do.
    pub fn move_collider(&mut self, collider: ColliderHandle, to: Pose) -> Result<(), InputError> {
        let (index, to) = (self.index_of_collider(collider)?, to.checked()?);
        let what = |simulation: &Self| format!("collider `{}`", simulation.colliders[index].name);
        self.go_to(what, to, |assembly| assembly.colliders_mut()[index].track_mut())
    }

    /// Brings the nodes of a pin to a pose during the next frame, evenly; they stay there. The pose counts from where they
    /// start. On a [frozen](Self::frozen) body it has no effect.
    ///
    /// # Errors
    /// Where the pin is one of another simulation, it has no keyframe at all (one at t = 0 makes it movable) or still follows
    /// some, or no keyframe could have the pose, as in [`Self::move_collider`].
    pub fn move_pin(&mut self, pin: PinHandle, to: Pose) -> Result<(), InputError> {
        let (body, to) = (self.index_of(pin.body())?, to.checked()?);
        let name = |simulation: &Self| simulation.bodies[body].name.clone();
        let Some(track) = self.backend.assembly().track_of_pin(body, pin.index()) else {
            return Err(InputError::Immovable { body: name(self), pin: pin.index() });
        };
        if self.is_frozen(body) {
            return Ok(());
        }
        let what = |simulation: &Self| format!("pin {} of body `{}`", pin.index(), name(simulation));
        self.go_to(what, to, |assembly| &mut assembly.moving_mut().tracks[track])
    }

    fn go_to(
        &mut self,
        what: impl Fn(&Self) -> String,
        to: Pose,
        track: impl Fn(&mut crate::assembly::Assembly) -> &mut Track,
    ) -> Result<(), InputError> {
        let dt = self.dt();
        // As the frame after it starts.
        let [now, end] = [0.0, 1.0].map(|frames| (f64::from(self.frame()) + frames) * dt);
        let mut kept = false;
        self.backend.alter(&mut |assembly| {
            let track = track(assembly);
            kept = track.goes_on_after(now);
            if !kept {
                let Pose { rotate, translate } = to;
                let key = Keyframe { t: end, translate, rotate: Some(rotate), ..Keyframe::default() };
                track.go_to(now, key);
            }
        });
        if kept {
            return Err(InputError::FollowsKeyframes { what: what(self) });
        }
        Ok(())
    }

    /// Pins a vertex, and moves it to a place [m] during the next frame, in a straight line; it stays there, until
    /// [`Self::unpin_vertex`] where no pin of the scene holds it. On a [frozen](Self::frozen) body it has no effect.
    ///
    /// # Errors
    /// Where the body has no such vertex or is one of another simulation, the vertex follows keyframes of the scene, or `to`
    /// is not within ±10⁶ m.
    pub fn pin_vertex(
        &mut self,
        body: BodyHandle,
        vertex: usize,
        to: impl Into<DVec3>,
    ) -> Result<(), InputError> {
        let (found, node) = self.node_of(body, vertex)?;
        let to = to.into().to_array();
        Path::of("place").within(&to)?;
        let nodes: Vec<usize> = found.nodes_at(node).map(|node| found.solver_index(node)).collect();
        let moving = self.backend.assembly().moving_pins();
        let posed = self.backend.assembly().posed_pins();
        let keyed = |node: &usize| {
            let node = *node as u32;
            moving.binary_search_by_key(&node, |pin| pin.node).is_ok()
                || posed.iter().any(|pin| pin.nodes.contains(&node))
        };
        if nodes.iter().any(keyed) {
            let what = format!("vertex {vertex} of body `{}`", found.name);
            return Err(InputError::FollowsKeyframes { what });
        }
        if self.is_frozen(body.index()) {
            return Ok(());
        }
        self.rouse(std::iter::once(body.index()));
        for node in nodes {
            if self.backend.is_free(node) {
                self.backend.pin(node);
                self.pinned.insert(node as u32);
            }
            let from = self.backend.position(node);
            let moves = &mut self.input.moves;
            moves.retain(|&(other, ..)| other as usize != node);
            let place = moves.partition_point(|&(other, ..)| (other as usize) < node);
            moves.insert(place, (node as u32, from, to));
        }
        Ok(())
    }

    /// Frees a vertex that [`Self::pin_vertex`] has pinned, with the velocity that it was moved with in the last frame. What a
    /// pin of the scene holds stays pinned, and so does a [frozen](Self::frozen) body.
    ///
    /// # Errors
    /// Where the body has no such vertex, or is one of another simulation.
    pub fn unpin_vertex(&mut self, body: BodyHandle, vertex: usize) -> Result<(), InputError> {
        let (found, node) = self.node_of(body, vertex)?;
        let nodes: Vec<u32> = found.nodes_at(node).map(|node| found.solver_index(node) as u32).collect();
        let pinned = |node: &u32| self.pinned.contains(node) && !self.is_frozen(body.index());
        let nodes: Vec<u32> = nodes.into_iter().filter(pinned).collect();
        self.rouse(std::iter::once(body.index()));
        for node in nodes {
            self.pinned.remove(&node);
            self.moved.retain(|&other| other != node);
            self.input.moves.retain(|&(other, ..)| other != node);
            self.backend.unpin(node as usize);
        }
        Ok(())
    }

    /// Where keyframes, or the program, have brought a collider from its start when a `fraction` of the last frame has gone by
    /// [m].
    ///
    /// # Errors
    /// Where the collider is one of another simulation.
    pub fn collider_pose(&self, collider: ColliderHandle, fraction: f64) -> Result<DAffine3, InputError> {
        let collider = &self.backend.assembly().colliders()[self.index_of_collider(collider)?];
        let pose = collider.track().pose(self.time_at(fraction));
        let rows = DMat3::from_cols_array_2d(&pose.rotation);
        Ok(DAffine3::from_mat3_translation(rows.transpose(), pose.shift.into()))
    }

    /// Nodes of a collider's mesh [m] where poses have brought them when a `fraction` of the last frame has gone by, before
    /// [`Self::collider_pose`] moves them all. `None` where it keeps its shape.
    ///
    /// # Errors
    /// Where the collider is one of another simulation.
    pub fn collider_nodes(
        &self,
        collider: ColliderHandle,
        fraction: f64,
    ) -> Result<Option<Vec<[f64; 3]>>, InputError> {
        let mesh = self.backend.assembly().colliders()[self.index_of_collider(collider)?].mesh();
        Ok(mesh.filter(|mesh| mesh.deforms()).map(|mesh| mesh.nodes(self.time_at(fraction))))
    }

    /// When a `fraction` of the last frame has gone by [s].
    fn time_at(&self, fraction: f64) -> f64 {
        (f64::from(self.frame()) - 1.0 + fraction).max(0.0) * self.dt()
    }

    /// Length of a frame [s].
    pub fn dt(&self) -> f64 {
        self.backend.assembly().time.dt
    }

    /// Changes gravity, drag, wind and air from the next frame on.
    ///
    /// # Errors
    /// Names what is impossible. A scene that was built without air has no aerodynamic triangles, so air cannot be
    /// added later.
    pub fn set_world(&mut self, world: &World) -> Result<(), InputError> {
        world.check()?;
        if world.air.is_some() && self.backend.assembly().world.air.is_none() {
            let message = "cannot be added to a scene that was built without air";
            return Err(SceneError::new("world.air", message).into());
        }
        if *world != self.backend.assembly().world {
            self.rouse_all();
        }
        self.backend.alter(&mut |assembly| assembly.world = world.clone());
        Ok(())
    }

    /// Makes the vertices at the nodes `nodes` of a body ready to be drawn by [`Self::draw`]; `u32::MAX` for one that no node
    /// carries. False where it does not run on a GPU.
    ///
    /// # Errors
    /// A GPU may be lost, or have no memory for it. The body may be one of another simulation, or have no such node.
    #[cfg(feature = "gpu")]
    pub fn make_drawn(&mut self, body: BodyHandle, nodes: &[u32]) -> Result<bool, StepError> {
        let (body, frame) = (self.index_of(body)?, self.frame());
        let BodyInfo { name, nodes: count, .. } = &self.bodies[body];
        if let Some(&node) = nodes.iter().find(|&&node| node != u32::MAX && node as usize >= *count) {
            return Err(InputError::NoNode { body: name.clone(), node, nodes: *count }.into());
        }
        self.backend.make_drawn(body, nodes).map_err(|Lost(why)| StepError::Lost { frame, why })
    }

    /// Has the GPU write places and unit normals of a body's vertices, as they were [made ready](Self::make_drawn), to where
    /// a renderer on the same device draws them, after all frames that were submitted. Normals are area-weighted. Nothing
    /// comes to the host; what is not finite is not written.
    ///
    /// # Errors
    /// A GPU may be lost, or not give a kernel that much of the renderer's buffer. The body may be one of another simulation, or
    /// its vertices not fit `target`.
    #[cfg(feature = "gpu")]
    pub fn draw(&mut self, body: BodyHandle, target: &VertexTarget, view: &View) -> Result<(), StepError> {
        let (body, frame) = (self.index_of(body)?, self.frame());
        let name = || self.bodies[body].name.clone();
        target
            .check(self.backend.drawn_vertices(body))
            .map_err(|why| InputError::VertexTarget { body: name(), why })?;
        self.backend.draw(body, target, view).map_err(|Lost(why)| StepError::Lost { frame, why })
    }

    /// Goes on where a simulation of another scene is: takes its time, and place and velocity of the nodes of each body that
    /// has the same name and as many nodes here as there. What constraints remember comes along where there are as many.
    /// Nodes held here stand still. Of one that blew up or was stopped it is the last good state, and what constraints remember stays there.
    pub fn adopt_state(&mut self, from: &Self) {
        let named = |name: &str| from.bodies.iter().position(|body| body.name == name);
        let pairs = self.bodies.iter().enumerate();
        let pairs = pairs.filter_map(|(to, body)| Some([to, named(&body.name)?])).collect();
        self.adopt(from, pairs);
    }

    /// The same with the first body of each pair, of this simulation, for the second one, of the other, whatever their names are.
    ///
    /// # Errors
    /// Where a body is one of another simulation.
    pub fn adopt_bodies(&mut self, from: &Self, pairs: &[[BodyHandle; 2]]) -> Result<(), InputError> {
        let pair = |&[to, other]: &[BodyHandle; 2]| Ok([self.index_of(to)?, from.index_of(other)?]);
        let pairs = pairs.iter().map(pair).collect::<Result<_, InputError>>()?;
        self.adopt(from, pairs);
        Ok(())
    }

    fn adopt(&mut self, from: &Self, pairs: Vec<[usize; 2]>) {
        self.rouse_all();
        let in_order = pairs.iter().all(|[to, other]| to == other);
        for [to, other] in pairs {
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
        let lengths = |all: &SolverState| (all.warm_start.len(), all.active.len(), all.joints.len());
        if in_order && lengths(&mine) == lengths(&theirs) {
            // After a blow-up, or in the middle of a frame, they remember what nobody should.
            let taken =
                if from.halted.is_some() { SolverState { joints: theirs.joints, ..mine } } else { theirs };
            self.backend.set_solver_state(&taken);
        }
        self.halted = None;
        self.report.frame = from.frame();
        // A device that is lost says so in the next step.
        let _ = self.measure();
    }
}
