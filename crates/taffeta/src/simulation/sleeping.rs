//! Bodies at rest fall asleep, and wake when something comes near. What happens is decided between frames, from positions,
//! velocities and the scene alone, so that every backend decides the same.

use super::seen::distance_of;
use crate::backend::{BodyMotion, FrameInput, Lost, SETTLING};
use crate::contact::collider_mesh::surface::MeshSurface;
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::layers::Meetings;
use crate::scene::Sleep;
use crate::simulation::{BodyHandle, InputError, Simulation};
use crate::topology::sets::Sets;
use std::collections::BTreeSet;

/// Who sleeps, and who is about to.
#[derive(Clone, Default)]
pub(super) struct Rest {
    /// Frames that each body has been at rest; empty where none ever sleeps.
    pub frames: Vec<u32>,
    /// Which bodies are asleep.
    pub asleep: BTreeSet<usize>,
}

/// What decides who sleeps.
#[derive(Default)]
pub(super) struct Sleeping {
    /// Speed [m/s] that no node of a body at rest exceeds, and how many frames it is at rest before it falls asleep.
    limits: Option<(f64, u32)>,
    pub rest: Rest,
    /// Nodes of bodies that are asleep, which are held as long as they are.
    nodes: BTreeSet<u32>,
    /// How bodies that are asleep lie there, and others were before the last frame.
    motions: Vec<BodyMotion>,
    /// Half the thickness of each body that others may touch [m].
    reach: Vec<Option<f64>>,
    /// What is nearer than this is taken for near in any case [m].
    slack: f64,
    /// Bodies that are sewn to each other.
    joined: BTreeSet<[usize; 2]>,
    /// Frames since the last one that was run.
    pub idle: u32,
    /// How many slept in the last frame that was submitted.
    pub count: u32,
    /// Bodies that the program has woken since frames were submitted.
    pub roused: BTreeSet<usize>,
}

impl Sleeping {
    /// By a scene's wish.
    pub fn new(simulation: &Simulation) -> Self {
        let scene = &simulation.scene;
        let Some(Sleep { speed, after }) = scene.sleep else { return Self::default() };
        let (assembly, bodies) = (simulation.backend.assembly(), scene.bodies.len());
        let thickest = |contact: &crate::scene::SelfCollision| contact.thickest().0;
        Self {
            // A body that was woken has a frame to set out; more frames than are counted are as good as none at all.
            limits: Some((speed, (after / scene.time.dt).ceil().clamp(2.0, 1e9) as u32)),
            rest: Rest { frames: vec![0; bodies], asleep: BTreeSet::new() },
            motions: vec![BodyMotion::NONE; bodies],
            reach: scene
                .bodies
                .iter()
                .map(|body| Some(0.5 * thickest(body.self_collision.as_ref()?)))
                .collect(),
            slack: scene.colliders.iter().map(|collider| collider.offset).fold(0.0, f64::max),
            joined: assembly.joined_bodies(),
            ..Self::default()
        }
    }

    /// Whether the node is held because its body sleeps.
    pub fn holds(&self, node: usize) -> bool {
        self.nodes.contains(&(node as u32))
    }

    /// How near something may come to a body before they touch [m].
    fn margin(&self, body: usize) -> f64 {
        self.reach[body].map_or(0.0, |reach| 2.0 * reach) + self.slack
    }

    /// Sets of bodies that may touch each other before the end of a frame of `dt` seconds, or are sewn to each other, each by its
    /// least.
    fn groups(&self, meetings: &Meetings, [gravity, dt]: [f64; 2], moved: &[f64]) -> Vec<u32> {
        let mut sets = Sets::new(self.motions.len());
        self.joined.iter().for_each(|&[a, b]| sets.join(a as u32, b as u32));
        let swept = |body: usize| {
            let motion = &self.motions[body];
            // What is asleep is only touched.
            let way = if self.rest.asleep.contains(&body) { 0.0 } else { (motion.speed + gravity * dt) * dt };
            let way = way.max(moved[body]);
            self.reach[body].map(|reach| (body, motion.grown(2.0 * way + 2.0 * reach)))
        };
        let mut all: Vec<(usize, [[f64; 3]; 2])> = (0..self.motions.len()).filter_map(swept).collect();
        all.sort_by(|(a, [p, _]), (b, [q, _])| p[0].total_cmp(&q[0]).then(a.cmp(b)));
        for (index, (a, [p, q])) in all.iter().enumerate() {
            for (b, [r, s]) in all[index + 1..].iter().take_while(|(_, [r, _])| r[0] <= q[0]) {
                let is_near = (1..3).all(|axis| r[axis] <= q[axis] && p[axis] <= s[axis]);
                if is_near && meetings.bodies(*a, *b) {
                    sets.join(*a as u32, *b as u32);
                }
            }
        }
        sets.all()
    }
}

impl Simulation {
    /// Whether a body is [asleep](crate::scene::Sleep).
    ///
    /// # Errors
    /// Where the body is one of another simulation.
    pub fn is_asleep(&self, body: BodyHandle) -> Result<bool, InputError> {
        Ok(self.sleeping.rest.asleep.contains(&self.index_of(body)?))
    }

    /// Wakes a body, and in the next frame what it touches.
    ///
    /// # Errors
    /// Where the body is one of another simulation.
    pub fn wake(&mut self, body: BodyHandle) -> Result<(), InputError> {
        let body = self.index_of(body)?;
        self.rouse(std::iter::once(body));
        Ok(())
    }

    /// Wakes a body.
    pub(super) fn wake_body(&mut self, body: usize) {
        if let Some(frames) = self.sleeping.rest.frames.get_mut(body) {
            *frames = 0;
        }
        if self.sleeping.rest.asleep.remove(&body) {
            self.unpin_nodes(body);
            self.say_who_rests();
        }
    }

    /// Wakes all bodies.
    pub(super) fn wake_all(&mut self) {
        (0..self.bodies.len()).for_each(|body| self.wake_body(body));
    }

    /// Wakes bodies because the program says so, or changes them.
    pub(super) fn rouse(&mut self, bodies: impl Iterator<Item = usize>) {
        for body in bodies {
            self.sleeping.roused.insert(body);
            self.wake_body(body);
        }
    }

    /// The same of all bodies.
    pub(super) fn rouse_all(&mut self) {
        self.rouse(0..self.bodies.len());
    }

    /// Who sleeps from now on.
    pub(super) fn set_rest(&mut self, rest: &Rest) {
        self.wake_all();
        self.sleeping.idle = 0;
        self.sleeping.rest.frames.clone_from(&rest.frames);
        rest.asleep.iter().for_each(|&body| self.fall_asleep(body));
        self.say_who_rests();
    }

    fn fall_asleep(&mut self, body: usize) {
        self.sleeping.rest.asleep.insert(body);
        for node in self.backend.assembly().bodies[body].solver_range() {
            if self.backend.is_free(node) {
                self.backend.pin(node);
                self.sleeping.nodes.insert(node as u32);
            }
        }
        self.sleeping.motions[body] = self.backend.motion(body);
    }

    fn unpin_nodes(&mut self, body: usize) {
        let range = self.backend.assembly().bodies[body].solver_range();
        let (start, end) = (range.start as u32, range.end as u32);
        let held: Vec<u32> = self.sleeping.nodes.range(start..end).copied().collect();
        for node in held {
            self.sleeping.nodes.remove(&node);
            if !self.pinned.contains(&node) {
                self.backend.unpin(node as usize);
            }
        }
    }

    fn say_who_rests(&mut self) {
        let asleep = &self.sleeping.rest.asleep;
        let all: Vec<bool> = (0..self.bodies.len()).map(|body| asleep.contains(&body)).collect();
        self.backend.let_rest(&all);
    }

    /// Who falls asleep and who wakes before the frame after `before`, and whether there is nothing to do in it.
    pub(super) fn decide_who_sleeps(&mut self, before: u32, input: &FrameInput) -> Result<bool, Lost> {
        let Some((limit, needed)) = self.sleeping.limits else { return Ok(false) };
        let (bodies, start) = (self.bodies.len(), f64::from(before) * self.dt());
        let span = [start, f64::from(before + 1) * self.dt()];
        self.look_at_motions()?;
        let assembly = self.backend.assembly();
        let mut stirred = assembly.changing_over(span);
        let nodes =
            input.forces.iter().map(|&(node, _)| node).chain(input.moves.iter().map(|&(node, ..)| node));
        nodes
            .chain(self.moved.iter().copied())
            .for_each(|node| stirred[assembly.number_of_body(node)] = true);
        for (body, motion) in self.sleeping.motions.iter().enumerate() {
            // What is no number does not rest.
            stirred[body] |= motion.speed.is_nan() || motion.speed > limit;
        }
        self.stir_by_colliders(span, &mut stirred);
        let frames = &mut self.sleeping.rest.frames;
        for (frames, stirred) in frames.iter_mut().zip(stirred) {
            *frames = if stirred { 0 } else { frames.saturating_add(1).min(needed + SETTLING) };
        }
        let gravity = self.backend.assembly().world.gravity;
        let gravity = gravity.iter().map(|g| g * g).sum::<f64>().sqrt();
        let group_of = {
            let meetings = self.backend.assembly().meetings();
            self.sleeping.groups(meetings, [gravity, span[1] - span[0]], &self.ways_of_pins(span, input))
        };
        let mut least = vec![u32::MAX; bodies];
        for (&group, &frames) in group_of.iter().zip(&self.sleeping.rest.frames) {
            least[group as usize] = least[group as usize].min(frames);
        }
        let rested = |body: usize| least[group_of[body] as usize];
        let asleep: BTreeSet<usize> = (0..bodies).filter(|&body| rested(body) >= needed).collect();
        let is_settled = (0..bodies).all(|body| rested(body) >= needed + SETTLING);
        if asleep != self.sleeping.rest.asleep {
            let woken: Vec<usize> = self.sleeping.rest.asleep.difference(&asleep).copied().collect();
            for body in woken {
                self.sleeping.rest.asleep.remove(&body);
                self.unpin_nodes(body);
            }
            let tired: Vec<usize> = asleep.difference(&self.sleeping.rest.asleep).copied().collect();
            tired.into_iter().for_each(|body| self.fall_asleep(body));
            self.say_who_rests();
        }
        self.sleeping.count = asleep.len() as u32;
        Ok(is_settled)
    }

    /// How far pins bring nodes of each body in a frame at most [m].
    fn ways_of_pins(&self, span: [f64; 2], input: &FrameInput) -> Vec<f64> {
        let assembly = self.backend.assembly();
        let mut ways = vec![0.0_f64; self.bodies.len()];
        let mut note = |node: u32, [from, to]: [[f64; 3]; 2]| {
            let way = (0..3).map(|axis| (to[axis] - from[axis]).powi(2)).sum::<f64>().sqrt();
            let most = &mut ways[assembly.number_of_body(node)];
            *most = most.max(way);
        };
        input.moves.iter().for_each(|&(node, from, to)| note(node, [from, to]));
        let poses: Vec<_> = assembly.tracks().iter().map(|track| span.map(|t| track.pose(t))).collect();
        for pin in assembly.moving_pins() {
            note(pin.node, poses[pin.track as usize].map(|pose| pose.apply(pin.start)));
        }
        ways
    }

    /// Notes how bodies move that are awake.
    fn look_at_motions(&mut self) -> Result<(), Lost> {
        let awake = |body: &usize| !self.sleeping.rest.asleep.contains(body);
        let awake: Vec<usize> = (0..self.bodies.len()).filter(awake).collect();
        if awake.is_empty() {
            return Ok(());
        }
        self.backend.fetch()?;
        for body in awake {
            self.sleeping.motions[body] = self.backend.motion(body);
        }
        Ok(())
    }

    /// Notes which bodies colliders come near to that move over a span of time [s].
    fn stir_by_colliders(&self, span: [f64; 2], stirred: &mut [bool]) {
        let (all, meetings) = (self.backend.assembly().colliders(), self.backend.assembly().meetings());
        let deforms = |index: usize| {
            let mesh = all[index].mesh().filter(|mesh| mesh.deforms());
            mesh.is_some_and(|mesh| mesh.nodes(span[0]) != mesh.nodes(span[1]))
        };
        let deforms: Vec<bool> = (0..all.len()).map(deforms).collect();
        let moving = |index: &usize| deforms[*index] || all[*index].track().moves_over(span);
        let moving: Vec<usize> = (0..all.len()).filter(moving).collect();
        if moving.is_empty() {
            return;
        }
        // From keyframe to keyframe, as a collider may come and go in a frame.
        let mut times: Vec<f64> = span.into();
        times.extend(moving.iter().flat_map(|&index| all[index].track().turns_within(span)));
        times.sort_by(f64::total_cmp);
        times.dedup();
        for piece in times.windows(2) {
            let (from, to) = (piece[0], piece[1]);
            let (now, surfaces) = self.colliders_after([from, to]);
            let corners = |index: &usize| deforms[*index].then(|| [from, to].map(|t| all[*index].corners(t)));
            let corners: Vec<_> = moving.iter().map(corners).collect();
            for (body, stirred) in stirred.iter_mut().enumerate().filter(|(_, stirred)| !**stirred) {
                let met = moving.iter().zip(&corners).filter(|(index, _)| meetings.collider(body, **index));
                *stirred = met.into_iter().any(|(&index, corners)| match corners {
                    Some(corners) => self.is_near_corners(body, corners),
                    None => self.is_near(body, &now[index], surfaces, to - from),
                });
            }
        }
    }

    /// Whether the nodes of a collider that changes its shape come near to a body.
    fn is_near_corners(&self, body: usize, corners: &[Vec<[f64; 3]>; 2]) -> bool {
        let around = BodyMotion::of(corners.iter().flatten().map(|&x| [x, [0.0; 3]])).bounds;
        let way =
            |[from, to]: [&[f64; 3]; 2]| (0..3).map(|axis| (to[axis] - from[axis]).abs()).fold(0.0, f64::max);
        let longest =
            corners[0].iter().zip(&corners[1]).map(|(from, to)| way([from, to])).fold(0.0, f64::max);
        // On an arc they go beyond where it begins and ends.
        let [low, high] = self.sleeping.motions[body].grown(self.sleeping.margin(body) + longest);
        (0..3).all(|axis| around[0][axis] <= high[axis] && low[axis] <= around[1][axis])
    }

    /// Whether a collider comes near to a body on its way in `h` seconds.
    fn is_near(&self, body: usize, now: &ColliderNow<f64>, surfaces: &[MeshSurface<f64>], h: f64) -> bool {
        let (center, radius) = self.sleeping.motions[body].ball();
        let way = now.surface.way_through(center, radius, h) + self.sleeping.margin(body);
        if distance_of(now, surfaces, center, radius + way) >= radius + way {
            return false;
        }
        let near = |node| distance_of(now, surfaces, self.backend.position(node), way) < way;
        self.backend.assembly().bodies[body].solver_range().any(near)
    }
}
