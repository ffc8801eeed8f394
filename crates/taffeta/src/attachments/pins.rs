//! Nodes that are held or follow keyframes.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::attachments::constraints::{Attachments, IS_POINT, JointMaterial, Point};
use crate::motion::held::{self, Holders};
use crate::motion::keyframes::Track;
use crate::motion::moving::{MovingPin, MovingPins};
use crate::motion::posed::{PosedPin, PosedPins};
use crate::motion::poses;
use crate::real::{add, cross, scale, sub};
use crate::scene::{Body, Scene, SceneError};
use std::collections::{BTreeMap, HashSet};

impl Assembly {
    /// Holds the nodes of pins, and notes those that move: of several motions of a node the last one counts.
    pub(crate) fn add_pins(
        &mut self,
        path: &str,
        body: &Body,
        scene: &Scene,
        built: &mut BodyAssembly,
    ) -> Result<(), SceneError> {
        let mut track_of: Vec<u32> = Vec::new();
        let mut breaking: BTreeMap<usize, (u32, Point)> = BTreeMap::new();
        // The pin whose poses a node follows, and the node's number in the mesh.
        let mut posed: BTreeMap<usize, (usize, usize)> = BTreeMap::new();
        let (mut pins, mut holders) = (Vec::new(), Holders::new());
        for (p, pin) in body.pins.iter().enumerate() {
            let chosen = built.select(&pin.select).map_err(|e| e.under(&format!("{path}.pin[{p}]")))?;
            let carrier = pin.collider.as_ref().and_then(|name| scene.collider_named(name));
            let track = Track::new(carrier.map_or(&pin.motion, |collider| &collider.motion));
            let number = if track.is_still() { u32::MAX } else { self.tracks().len() as u32 };
            let locals: Vec<usize> = chosen.iter().map(|&node| built.solver_local(node as usize)).collect();
            if let Some(break_force) = pin.break_force {
                let materials = &mut self.attachments_mut().materials;
                let material = materials.len() as u32;
                materials.push(JointMaterial { length: 0.0, close: [0.0; 2], compliance: 0.0, break_force });
                let point = |local: usize| Point {
                    start: built.start[local],
                    track: number,
                    carried: carrier.is_some(),
                };
                breaking.extend(locals.into_iter().map(|local| (local, (material, point(local)))));
            } else {
                if !track.is_still() {
                    track_of.resize(built.nodes, u32::MAX);
                }
                let moves = !track.is_still() || pin.poses.is_some();
                for (local, &node) in locals.into_iter().zip(&chosen) {
                    held::hold(&mut holders, local, p, moves);
                    built.free[local] = false;
                    if moves {
                        posed.remove(&local);
                        if let Some(track) = track_of.get_mut(local) {
                            *track = number;
                        }
                    }
                    if pin.poses.is_some() {
                        posed.insert(local, (p, node as usize));
                    }
                }
            }
            pins.push(((!track.is_still()).then_some(number as usize), pin.break_force.is_some()));
            if !track.is_still() {
                let (key, moving) = ((self.bodies.len(), p), self.moving_mut());
                moving.track_of_pin.insert(key, moving.tracks.len());
                moving.tracks.push(track);
            }
        }
        let moving = track_of.iter().enumerate().filter(|(_, track)| **track != u32::MAX);
        self.moving_mut().pins.extend(moving.map(|(local, &track)| MovingPin {
            node: (built.first + local) as u32,
            track,
            start: built.start[local],
        }));
        self.pose_pins(path, body, built, &posed)?;
        let index = self.bodies.len();
        self.held_mut().add(index, built, &pins, &holders);
        // What another pin holds for good stays.
        for (local, (material, point)) in breaking.into_iter().filter(|(local, _)| built.free[*local]) {
            self.attachments_mut().hold((built.first + local) as u32, material, point);
        }
        Ok(())
    }

    /// Notes nodes that follow poses: each with the pin whose poses they are, and its number in the mesh.
    fn pose_pins(
        &mut self,
        path: &str,
        body: &Body,
        built: &BodyAssembly,
        posed: &BTreeMap<usize, (usize, usize)>,
    ) -> Result<(), SceneError> {
        for (p, pin) in body.pins.iter().enumerate() {
            let Some(given) = &pin.poses else { continue };
            let poses = poses::given(given, &built.user_surface(), false)
                .map_err(|e| e.under(&format!("{path}.pin[{p}]")))?;
            let nodes = posed.iter().filter(|(_, (pin, _))| *pin == p);
            let nodes: Vec<(u32, usize)> =
                nodes.map(|(&local, &(_, node))| ((built.first + local) as u32, node)).collect();
            let of = |pose: Vec<[f64; 3]>| -> Vec<[f64; 3]> {
                nodes.iter().map(|&(_, node)| built.placement.apply(pose[node])).collect()
            };
            let all: &mut PosedPins = self.extensions.get_mut();
            all.0.push(PosedPin {
                nodes: nodes.iter().map(|&(node, _)| node).collect(),
                poses: poses.into_iter().map(of).collect(),
                interval: given.interval,
                start: given.start,
            });
        }
        Ok(())
    }

    /// Brings moving pins to where their motion starts. All selections have been made by then: they see the bodies as
    /// placed, whatever moves them.
    pub(crate) fn start_pins(&mut self) {
        let Self { bodies, extensions, .. } = self;
        for pin in extensions.get::<PosedPins>().into_iter().flat_map(|posed| &posed.0) {
            for (&node, place) in pin.nodes.iter().zip(pin.at(0.0)) {
                let body = bodies.partition_point(|body| body.first <= node as usize) - 1;
                let body = &mut bodies[body];
                body.start[node as usize - body.first] = place;
            }
        }
        let moving: &MovingPins = extensions.get_mut();
        let mut bodies = bodies.iter_mut().peekable();
        for pin in &moving.pins {
            let node = pin.node as usize;
            while bodies.next_if(|body| body.first + body.nodes <= node).is_some() {}
            let Some(body) = bodies.peek_mut() else { return };
            body.start[node - body.first] = moving.tracks[pin.track as usize].pose(0.0).apply(pin.start);
        }
    }

    /// Gives bodies their velocities at the start. Nodes that pins hold, those that break among them, start at rest.
    pub(crate) fn start_velocities(&mut self, scene: &Scene) {
        let Self { bodies, extensions, .. } = self;
        let joints = extensions.get::<Attachments>().map_or(&[][..], |all| &all.joints);
        let pinned: HashSet<u32> =
            joints.iter().filter(|joint| joint.ends[1] & IS_POINT != 0).map(|joint| joint.ends[0]).collect();
        for (body, described) in bodies.iter_mut().zip(&scene.bodies) {
            let Body { velocity, angular_velocity: spin, .. } = *described;
            if velocity == [0.0; 3] && spin == [0.0; 3] {
                continue;
            }
            let centre = centre_of_mass(&body.mass, &body.start);
            let is_free = |local: usize| body.free[local] && !pinned.contains(&((body.first + local) as u32));
            let of_node = |local: usize| {
                if is_free(local) {
                    add(velocity, cross(spin, sub(body.start[local], centre)))
                } else {
                    [0.0; 3]
                }
            };
            body.start_velocity = (0..body.nodes).map(of_node).collect();
        }
    }
}

/// Σ m x/Σ m [m].
fn centre_of_mass(mass: &[f64], places: &[[f64; 3]]) -> [f64; 3] {
    let (mut sum, mut whole) = ([0.0; 3], 0.0);
    for (&m, &x) in mass.iter().zip(places) {
        (sum, whole) = (add(sum, scale(x, m)), whole + m);
    }
    sum.map(|c| c / whole)
}
