//! Bodies and colliders that a program puts elsewhere at once.

use crate::backend::SolverState;
use crate::motion::keyframes;
use crate::scene::{Keyframe, Path};
use crate::simulation::live::Pose;
use crate::simulation::{BodyHandle, ColliderHandle, InputError, Simulation};
use std::ops::Range;

impl Simulation {
    /// Carries a body along in the world at once, as a rigid motion from where it is `by` has it: first the turn about the origin, then
    /// the shift. Velocities are turned with it, and its pins go along: what moves them later counts from where they started, as ever.
    /// Nothing is swept on the way, and contacts of surfaces start from no force. Where it comes to lie in others it is pushed out as
    /// at a start. All bodies wake up. Other bodies that are sewn to it stay: carry them along before the next frame. On a
    /// [frozen](Self::frozen) body it has no effect.
    ///
    /// For what a game puts elsewhere: a pin that is moved so far in a frame would tear the cloth after it.
    ///
    /// # Errors
    /// Where the body is one of another simulation, a pin of it still follows keyframes of the scene, or may break and has none (one at
    /// t = 0 makes it movable), the pose is none that a keyframe could have, as in [`Self::move_collider`], or a vertex would come to
    /// lie beyond ±10⁶ m. Nothing is changed then.
    ///
    /// ```
    /// # use taffeta::scene::{Body, Keyframe, Mass, Mesh, Scene, Select};
    /// # use taffeta::{Options, Pose, Simulation};
    /// # use taffeta::glam::{DQuat, DVec3};
    /// let held = Keyframe::translate(0.0, [0.0; 3]);
    /// let cape = Body::cloth("cape", Mesh::grid(8, 6, [0.5, 0.7])).with_mass(Mass::Area(0.2)).structural(50.0, 0.05);
    /// let scene = Scene::new("").time(0.01, 1e-3).body(cape.pin_moving(Select::rows(0, 0), vec![held]));
    /// let mut simulation = Simulation::new(&scene, &Options::default())?;
    /// simulation.advance(30)?;
    /// let mut places = Vec::<[f64; 3]>::new();
    /// simulation.positions_f64(&mut places);
    /// let before = places[47];
    ///
    /// let cape = simulation.bodies()[0].handle;
    /// let far = Pose::new(DQuat::IDENTITY, DVec3::new(50.0, 0.0, 0.0));
    /// simulation.teleport_body(cape, far)?;
    /// simulation.positions_f64(&mut places);
    /// assert!((places[47][0] - before[0] - 50.0).abs() < 1e-5);
    /// // From now on its carrier, which is there, moves the pin.
    /// let pin = simulation.pin(cape, 0)?;
    /// simulation.move_pin(pin, far)?;
    /// simulation.step()?;
    /// # Ok::<(), Box<dyn std::error::Error>>(())
    /// ```
    pub fn teleport_body(&mut self, body: BodyHandle, by: Pose) -> Result<(), InputError> {
        self.teleport(&[(body, by)], &[])
    }

    /// Puts a collider into a pose at once: nothing is swept on the way, and it has no velocity from it. The pose counts from where it
    /// starts. Cloth that it comes to lie in is pushed out as at a start, and all bodies wake up. Nodes that it carries follow its
    /// keyframes, not this.
    ///
    /// # Errors
    /// As in [`Self::move_collider`].
    pub fn teleport_collider(&mut self, collider: ColliderHandle, to: Pose) -> Result<(), InputError> {
        self.teleport(&[], &[(collider, to)])
    }

    /// Puts several at once, at the cost of one: bodies as [`Self::teleport_body`], each once, and colliders as
    /// [`Self::teleport_collider`].
    ///
    /// # Errors
    /// As those. Nothing is changed then.
    pub fn teleport(
        &mut self,
        bodies: &[(BodyHandle, Pose)],
        colliders: &[(ColliderHandle, Pose)],
    ) -> Result<(), InputError> {
        // Frames under way are looked at first: what has blown up stays where it is, and says so in the next step.
        let _ = self.poll();
        let now = f64::from(self.frame()) * self.dt();
        let bodies = bodies.iter().map(|&(body, by)| self.carried(body, by, now));
        let bodies: Vec<Carried> = bodies.collect::<Result<_, _>>()?;
        let colliders = colliders.iter().map(|&(collider, to)| self.put(collider, to, now));
        let colliders: Vec<(usize, Keyframe)> = colliders.collect::<Result<_, _>>()?;
        self.rouse_all();
        let mut solvers = self.backend.solver_state();
        for carried in &bodies {
            if !self.is_frozen(carried.body) {
                self.carry(carried, now, &mut solvers);
            }
        }
        if !colliders.is_empty() {
            self.backend.alter(&mut |assembly| {
                for (index, key) in &colliders {
                    assembly.colliders_mut()[*index].track_mut().bring_back(Some(key));
                }
            });
            // What is remembered of nodes is of where the colliders were.
            for node in 0..self.backend.assembly().places {
                let [place, velocity] = [self.backend.position(node), self.backend.velocity(node)];
                self.backend.set(node, place, velocity);
            }
        }
        // A device that is lost says so in the next step.
        let _ = self.measure();
        // Only now: where nothing moved yet, nothing is tangled. Forces of contacts are of other places.
        let state = SolverState { contacts: Vec::new(), is_tangled: true, ..solvers };
        self.backend.set_solver_state(&state);
        Ok(())
    }

    /// A body that can be carried.
    fn carried(&self, body: BodyHandle, by: Pose, now: f64) -> Result<Carried, InputError> {
        let (body, by) = (self.index_of(body)?, by.checked()?);
        let (assembly, name) = (self.backend.assembly(), &self.bodies[body].name);
        if let Some(pin) = assembly.pin_in_place(body) {
            return Err(InputError::Immovable { body: name.clone(), pin });
        }
        if assembly.is_posed_after(body, now) {
            return Err(InputError::FollowsKeyframes { what: format!("a pin of body `{name}`") });
        }
        let pins =
            (0..self.bodies[body].pins).filter_map(|pin| Some((pin, assembly.track_of_pin(body, pin)?)));
        let track = |(pin, track): (usize, usize)| {
            let follows = assembly.tracks()[track].goes_on_after(now);
            let what = || format!("pin {pin} of body `{name}`");
            if follows { Err(InputError::FollowsKeyframes { what: what() }) } else { Ok(track) }
        };
        let tracks = pins.map(track).collect::<Result<_, _>>()?;
        let (motion, path) = (keyframes::pose(&by.keyframe(now)), Path::of("pose"));
        for node in assembly.bodies[body].solver_range() {
            path.within(&motion.apply(self.backend.position(node)))?;
        }
        Ok(Carried { body, by, motion, tracks })
    }

    /// A collider that can be put into a pose, and that.
    fn put(&self, collider: ColliderHandle, to: Pose, now: f64) -> Result<(usize, Keyframe), InputError> {
        let (index, to) = (self.index_of_collider(collider)?, to.checked()?);
        if self.backend.assembly().colliders()[index].track().goes_on_after(now) {
            let what = format!("collider `{}`", self.colliders[index].name);
            return Err(InputError::FollowsKeyframes { what });
        }
        Ok((index, to.keyframe(now)))
    }

    /// Carries a body along, and what solvers remember of it.
    fn carry(&mut self, Carried { body, by, motion, tracks }: &Carried, now: f64, solvers: &mut SolverState) {
        let assembly = self.backend.assembly();
        let nodes = assembly.bodies[*body].solver_range();
        if assembly.solver.is_primal() {
            turn_vectors(&mut solvers.warm_start, assembly.places, nodes.clone(), motion);
        }
        for node in nodes {
            let [place, velocity] = [self.backend.position(node), self.backend.velocity(node)];
            self.backend.set(node, motion.apply(place), motion.turn(velocity));
        }
        for (node, from, _) in &mut self.input.moves {
            if self.backend.assembly().number_of_body(*node) == *body {
                *from = motion.apply(*from);
            }
        }
        if !tracks.is_empty() {
            self.backend.alter(&mut |assembly| {
                for &track in tracks {
                    assembly.moving_mut().tracks[track].carry(now, by.rotate, by.translate);
                }
            });
        }
    }
}

/// A body that is carried along, by a pose and as the motion that it is, and the tracks of its pins.
struct Carried {
    body: usize,
    by: Pose,
    motion: keyframes::Pose,
    tracks: Vec<usize>,
}

/// Turns vectors of some nodes, of each sort that is kept of all `places`.
fn turn_vectors(all: &mut [f64], places: usize, nodes: Range<usize>, motion: &keyframes::Pose) {
    for sort in all.chunks_mut(3 * places) {
        for vector in &mut sort.as_chunks_mut::<3>().0[nodes.clone()] {
            *vector = motion.turn(*vector);
        }
    }
}

impl Pose {
    fn keyframe(&self, t: f64) -> Keyframe {
        Keyframe { t, translate: self.translate, rotate: Some(self.rotate), ..Keyframe::default() }
    }
}
