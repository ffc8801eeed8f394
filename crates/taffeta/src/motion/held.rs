//! Nodes that pins hold, pin by pin, and the reaction: the force with which a pin holds its nodes, m (a − g) − f, where f are
//! all other forces on them but gravity.

use crate::assembly::Assembly;
use crate::assembly::body::BodyAssembly;
use crate::motion::keyframes::Track;
use crate::real::{add, scale, sub};
use crate::report::PinReaction;
use crate::scene::{Method, Time};
use std::collections::BTreeMap;

/// A node that a pin holds.
#[derive(Clone, Copy, Debug)]
pub struct HeldNode {
    /// Solver index.
    pub node: u32,
    /// Which of the groups.
    pub group: u32,
    /// Mass [kg].
    mass: f64,
    /// Place before any motion [m].
    start: [f64; 3],
}

/// The nodes of a pin. Of several pins of a node the one whose motion it follows has it, or else the last.
#[derive(Clone, Debug)]
pub struct HeldGroup {
    /// The body, and which of its pins.
    pub body: usize,
    pub pin: usize,
    /// The motion that its nodes follow.
    track: Option<usize>,
    /// Whether it breaks: joints hold its nodes then, and nothing is told of it.
    breaks: bool,
}

/// All nodes that pins hold.
#[derive(Default)]
pub struct Held {
    /// Ascending by solver index, each node once.
    pub nodes: Vec<HeldNode>,
    /// In the order of bodies and their pins.
    pub groups: Vec<HeldGroup>,
}

/// Which pin holds each node of a body, by solver index within it, and whether it moves.
pub type Holders = BTreeMap<usize, (usize, bool)>;

impl Held {
    /// Adds a body, before any of its pins has moved. `pins` has the track of each pin, and whether it breaks.
    pub fn add(&mut self, body: usize, built: &BodyAssembly, pins: &[(Option<usize>, bool)], by: &Holders) {
        let first = self.groups.len();
        let group = |(pin, &(track, breaks))| HeldGroup { body, pin, track, breaks };
        self.groups.extend((0..).zip(pins).map(group));
        self.nodes.extend(by.iter().map(|(&local, &(pin, _))| HeldNode {
            node: (built.first + local) as u32,
            group: (first + pin) as u32,
            mass: built.mass[local],
            start: built.start[local],
        }));
    }
}

/// Notes that a pin holds a node, unless another one moves it and this one does not.
pub fn hold(by: &mut Holders, local: usize, pin: usize, moves: bool) {
    let before = by.entry(local).or_insert((pin, moves));
    if moves || !before.1 {
        *before = (pin, moves);
    }
}

impl Assembly {
    /// Nodes that pins hold, of which reactions are made: none where springs are constraints on positions, whose forces are not
    /// known.
    pub fn held(&self) -> &[HeldNode] {
        let known = self.solver.method != Method::Xpbd;
        self.extensions.get::<Held>().filter(|_| known).map_or(&[], |held| &held.nodes)
    }

    /// A breakable pin of a body that nothing moves: its joints hold nodes where they started.
    pub fn pin_in_place(&self, body: usize) -> Option<usize> {
        let groups = &self.extensions.get::<Held>()?.groups;
        let stays = |group: &&HeldGroup| group.body == body && group.breaks && group.track.is_none();
        groups.iter().find(stays).map(|group| group.pin)
    }

    pub(crate) fn held_mut(&mut self) -> &mut Held {
        self.extensions.get_mut()
    }

    /// The force with which each of those nodes is held in the last sub-step of a frame that ends at time `t` [s] after so many
    /// sub-steps, from the other forces on them [N]; none where there are none, as at the start.
    pub fn node_reactions(&self, (t, substeps): (f64, u32), forces: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let Some(Held { nodes, groups }) = self.extensions.get::<Held>() else { return Vec::new() };
        let track = |group: &HeldGroup| group.track.and_then(|track| self.tracks().get(track));
        let steps = last_two(&self.time, substeps);
        let accelerations: Vec<Option<Acceleration>> =
            groups.iter().map(|group| Some(acceleration(track(group)?, steps, t))).collect();
        let of = |(held, &force): (&HeldNode, &[f64; 3])| {
            let [x, y, z] = held.start;
            let field = |by: &Acceleration| by.map(|[a, b, c, s]| a * x + b * y + c * z + s);
            let moves = accelerations[held.group as usize].as_ref().map_or([0.0; 3], field);
            sub(scale(sub(moves, self.world.gravity), held.mass), force)
        };
        nodes.iter().zip(forces).map(of).collect()
    }

    /// The reaction of each pin: the sum over its nodes.
    pub fn reactions(&self, frame: (f64, u32), forces: &[[f64; 3]]) -> Vec<PinReaction> {
        let Some(Held { nodes, groups }) = self.extensions.get::<Held>() else { return Vec::new() };
        let known = !nodes.is_empty() && forces.len() == nodes.len();
        let mut sums = vec![[0.0; 3]; groups.len()];
        for (held, force) in nodes.iter().zip(self.node_reactions(frame, forces)) {
            let sum = &mut sums[held.group as usize];
            *sum = add(*sum, force);
        }
        let of = |(group, sum): (&HeldGroup, [f64; 3])| {
            let force = (known && !group.breaks).then_some(sum);
            PinReaction { body: group.body, pin: group.pin, force }
        };
        groups.iter().zip(sums).map(of).collect()
    }

    /// Solver indices of the nodes of a pin, and which of the held nodes they are.
    pub fn held_by(&self, body: usize, pin: usize) -> impl Iterator<Item = (usize, usize)> {
        let held = self.extensions.get::<Held>();
        let group =
            held.and_then(|held| held.groups.iter().position(|one| (one.body, one.pin) == (body, pin)));
        let all = self.held().iter().enumerate();
        all.filter(move |(_, one)| Some(one.group as usize) == group)
            .map(|(index, one)| (one.node as usize, index))
    }
}

/// An affine field of accelerations by places before any motion, by rows [1/s²]; the last number of each in [m/s²].
type Acceleration = [[f64; 4]; 3];

/// Lengths of the last sub-step but one, and of the last, in a frame of so many [s].
fn last_two(time: &Time, substeps: u32) -> [f64; 2] {
    let last = time.substeps() - 1;
    let parts = substeps / time.substeps();
    if parts > 1 {
        return [time.substep(last).1 / f64::from(parts); 2];
    }
    [last.saturating_sub(1), last].map(|index| time.substep(index).1)
}

/// The change of velocity over the last of two sub-steps of these lengths [s] that ends at time `t` [s], by its length. Before the
/// start all is at rest.
fn acceleration(track: &Track, [before, h]: [f64; 2], t: f64) -> Acceleration {
    let pose = |t: f64| {
        let pose = track.pose(t.max(0.0));
        [0, 1, 2].map(|i| {
            let [a, b, c] = pose.rotation[i];
            [a, b, c, pose.shift[i]]
        })
    };
    let [first, second, third] = [t - h - before, t - h, t].map(pose);
    std::array::from_fn(|i| {
        std::array::from_fn(|j| {
            ((third[i][j] - second[i][j]) / h - (second[i][j] - first[i][j]) / before) / h
        })
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::{Keyframe, Scene};

    #[test]
    fn a_node_belongs_to_the_pin_that_moves_it_or_to_the_last() {
        let mut by = Holders::new();
        for (pin, moves) in [(0, false), (1, false)] {
            hold(&mut by, 7, pin, moves);
        }
        assert_eq!(by[&7], (1, false));
        for (pin, moves) in [(2, true), (3, false), (4, true), (5, false)] {
            hold(&mut by, 7, pin, moves);
        }
        assert_eq!(by[&7], (4, true));
    }

    #[test]
    fn an_acceleration_is_the_second_difference_of_places() {
        // x = t² at keys a sub-step apart: 2 m/s², from rest at the start.
        let h = 0.25;
        let keys: Vec<Keyframe> = (1..9_u8)
            .map(|n| f64::from(n) * h)
            .map(|t| Keyframe::translate(t, [t * (t + h), 0.0, 0.0]))
            .collect();
        let track = Track::new(&keys);
        // In sub-steps of the scene, and in parts of such.
        for (substeps, parts) in [1, 2, 4].into_iter().flat_map(|count| [1, 2].map(|parts| (count, parts))) {
            let step = f64::from(parts) * h;
            let time = Scene::new("").time(step * f64::from(substeps), step).time;
            for frame in 1..=8 / (substeps * parts) {
                let steps = last_two(&time, substeps * parts);
                let by = acceleration(&track, steps, time.dt * f64::from(frame));
                assert!((by[0][3] - 2.0).abs() < 1e-12 && by[1] == [0.0; 4], "{by:?}");
            }
        }
    }
}
