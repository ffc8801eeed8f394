//! Nodes that are held or follow keyframes.

use super::{Assembly, BodyAssembly, MovingPin};
use crate::integrate::keyframes::Track;
use crate::scene::{Body, SceneError};

impl Assembly {
    /// Holds the nodes of pins, and notes those that move: of several motions of a node the last one counts.
    pub(super) fn add_pins(
        &mut self,
        path: &str,
        body: &Body,
        built: &mut BodyAssembly,
    ) -> Result<(), SceneError> {
        let mut track_of: Vec<u32> = Vec::new();
        for (p, pin) in body.pins.iter().enumerate() {
            let chosen = built.select(&pin.select).map_err(|e| e.under(&format!("{path}.pin[{p}]")))?;
            let track = Track::new(&pin.motion);
            if !track.is_still() {
                track_of.resize(built.nodes, u32::MAX);
            }
            for node in chosen {
                let local = built.solver_local(node as usize);
                built.free[local] = false;
                if !track.is_still() {
                    track_of[local] = self.tracks.len() as u32;
                }
            }
            if !track.is_still() {
                self.tracks.push(track);
            }
        }
        let moving = track_of.iter().enumerate().filter(|(_, track)| **track != u32::MAX);
        self.moving_pins.extend(moving.map(|(local, &track)| MovingPin {
            node: (built.first + local) as u32,
            track,
            start: built.start[local],
        }));
        Ok(())
    }

    /// Brings moving pins to where their motion starts. All selections have been made by then: they see the bodies as
    /// placed, whatever moves them.
    pub(super) fn start_pins(&mut self) {
        let mut bodies = self.bodies.iter_mut().peekable();
        for pin in &self.moving_pins {
            let node = pin.node as usize;
            while bodies.next_if(|body| body.first + body.nodes <= node).is_some() {}
            let Some(body) = bodies.peek_mut() else { return };
            body.start[node - body.first] = self.tracks[pin.track as usize].pose(0.0).apply(pin.start);
        }
    }
}
