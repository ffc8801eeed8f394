//! One body's failure is that body's alone: bodies that diverge are frozen, and the others go on.

use super::errors::Diverged;
use crate::backend::{FrameInput, Lost, SolverState};
use crate::motion::keyframes::Track;
use crate::motion::moving::MovingPins;
use crate::report::FrameReport;
use crate::scene::World;
use crate::simulation::sleeping::Rest;
use crate::simulation::{Simulation, StepError};
use serde::{Deserialize, Serialize};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::ops::Range;

/// Most times that frames are run again to find which bodies make them fail. Beyond it, bodies that may be to blame are frozen, too.
const MOST_TRIES: usize = 32;

/// What becomes of a scene in which a body diverges.
///
/// ```
/// use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
/// use taffeta::{OnDivergence, Options, Simulation};
///
/// // One cloth is too stiff for its step, the other one is not.
/// let cloth = |name: &str, k: f64| {
///     let cloth = Body::cloth(name, Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Node(1e-3));
///     cloth.structural(k, 0.0).pin(Select::nodes([0]))
/// };
/// let scene = Scene::new("").time(0.01, 2.5e-3).body(cloth("good", 1.0)).body(cloth("bad", 1e6));
/// let options = Options { on_divergence: OnDivergence::Freeze, ..Options::default() };
/// let mut simulation = Simulation::new(&scene, &options)?;
/// simulation.disturb(1e-6, 1);
/// simulation.advance(50)?;
/// let [frozen] = simulation.frozen() else { panic!("one body") };
/// assert_eq!(frozen.why.body, "bad");
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum OnDivergence {
    /// No frame runs after it: [`StepError::Diverged`].
    #[default]
    Stop,
    /// The frame is run again with that body frozen where it was, and so are all after it. Which bodies are to blame is found by
    /// trying, so a frame in which one diverges takes as long as some. Where freezing bodies does not help, it is as with
    /// [`Self::Stop`].
    Freeze,
}

/// A body that diverged and stands still since. [`OnDivergence`] has an example.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Frozen {
    /// Its number in the scene.
    pub body: u32,
    /// What was seen of it. It stands as it was before the frame [`Diverged::first`].
    pub why: Diverged,
}

/// What a program has set, and what it asks for in the frame to come.
pub(super) struct Given {
    /// Number of frames that run with it; all but the first have no input.
    frames: u32,
    input: FrameInput,
    world: World,
    colliders: Vec<Track>,
    pins: Vec<Track>,
    pinned: BTreeSet<u32>,
    /// Nodes that came to where they were moved, and stop there.
    moved: Vec<u32>,
    /// Bodies that the program has woken before.
    roused: BTreeSet<usize>,
}

/// What the frames since the last good one started from, and what they were given.
#[derive(Default)]
pub(super) struct Kept {
    solvers: SolverState,
    rest: Rest,
    frames: Vec<Given>,
}

/// A body that may have diverged, and its fastest vertex.
#[derive(Clone, Copy)]
pub(super) struct Suspect {
    pub body: usize,
    pub vertex: usize,
    /// Of that vertex [m/s]; infinite where something is not finite.
    speed: f64,
}

/// Frames to run again.
struct Again {
    /// Places [m] and velocities [m/s] by solver index.
    state: Vec<[[f64; 3]; 2]>,
    kept: Kept,
    /// The report of the last good frame, and its forces on held nodes [N].
    report: FrameReport,
    held: Vec<[f64; 3]>,
    frozen: Vec<Frozen>,
    why: Diverged,
}

impl Simulation {
    /// Bodies that diverged and stand still since, in the order in which they did; none with [`OnDivergence::Stop`], unless a snapshot
    /// has some. Forces on them and motions of their pins have no effect. [`Self::restore`] from before it brings them back.
    pub fn frozen(&self) -> &[Frozen] {
        &self.frozen
    }

    /// Whether a body stands still for good.
    pub(super) fn is_frozen(&self, body: usize) -> bool {
        self.frozen.iter().any(|one| one.body as usize == body)
    }

    /// Keeps what frames to come are given, and what the first since the last good one starts from.
    pub(super) fn keep_given(&mut self, frames: u32) {
        if self.on_divergence == OnDivergence::Freeze && frames > 0 {
            if self.kept.frames.is_empty() {
                self.kept.solvers = self.backend.solver_state();
                self.kept.rest = self.sleeping.rest.clone();
            }
            let given = self.given(frames);
            self.kept.frames.push(given);
            self.sleeping.roused.clear();
        }
    }

    /// The frames that ended by now are not run again.
    pub(super) fn mark_good(&mut self) {
        self.backend.mark_good();
        self.kept.frames.clear();
    }

    /// What the program has set by now.
    pub(super) fn given(&self, frames: u32) -> Given {
        let assembly = self.backend.assembly();
        Given {
            frames,
            input: self.input.clone(),
            world: assembly.world.clone(),
            colliders: assembly.colliders().iter().map(|one| one.track().clone()).collect(),
            pins: assembly.tracks().to_vec(),
            pinned: self.pinned.clone(),
            moved: self.moved.clone(),
            roused: self.sleeping.roused.clone(),
        }
    }

    /// Sets what the program had set then; what it wants of bodies that are frozen now is left out, but that their pins go as the first of
    /// the frames had them go.
    fn give(&mut self, given: &Given, first: &Given) {
        let Given { input, world, colliders, pins, pinned, moved, roused, .. } = given;
        // Before others hold their nodes.
        roused.iter().for_each(|&body| self.wake_body(body));
        let frozen: Vec<usize> = self.frozen.iter().map(|one| one.body as usize).collect();
        self.backend.alter(&mut |assembly| {
            assembly.world = world.clone();
            assembly
                .colliders_mut()
                .iter_mut()
                .zip(colliders)
                .for_each(|(to, from)| to.track_mut().clone_from(from));
            if !pins.is_empty() {
                let MovingPins { tracks, track_of_pin, .. } = assembly.moving_mut();
                tracks.clone_from_slice(pins);
                let still = track_of_pin.iter().filter(|((body, _), _)| frozen.contains(body));
                still.for_each(|(_, &track)| tracks[track].clone_from(&first.pins[track]));
            }
        });
        self.pin_exactly(pinned);
        self.hold_frozen();
        let assembly = self.backend.assembly();
        let nodes = |one: &Frozen| assembly.bodies[one.body as usize].solver_range();
        let ranges: Vec<Range<usize>> = self.frozen.iter().map(nodes).collect();
        let is_free = |node: u32| !ranges.iter().any(|range| range.contains(&(node as usize)));
        self.input = input.clone();
        self.input.moves.retain(|&(node, ..)| is_free(node));
        self.input.forces.retain(|&(node, _)| is_free(node));
        self.moved = moved.iter().copied().filter(|&node| is_free(node)).collect();
        // Where they go from may have been a place of the frames that failed.
        for (node, from, _) in &mut self.input.moves {
            *from = self.backend.position(*node as usize);
        }
    }

    /// Pins those nodes that would be free, and no others.
    pub(super) fn pin_exactly(&mut self, pinned: &BTreeSet<u32>) {
        for node in std::mem::replace(&mut self.pinned, pinned.clone()) {
            if !pinned.contains(&node) {
                self.backend.unpin(node as usize);
            }
        }
        for &node in pinned {
            if self.backend.is_free(node as usize) {
                self.backend.pin(node as usize);
            }
        }
    }

    /// Pins the nodes of frozen bodies, and has their pins stay where they were when they were frozen.
    pub(super) fn hold_frozen(&mut self) {
        let dt = self.dt();
        let until = |body: usize| {
            let one = self.frozen.iter().find(|one| one.body as usize == body)?;
            Some(f64::from(one.why.first.saturating_sub(1)) * dt)
        };
        self.backend.alter(&mut |assembly| {
            if !assembly.tracks().is_empty() {
                let MovingPins { tracks, track_of_pin, .. } = assembly.moving_mut();
                track_of_pin.iter().for_each(|(&(body, _), &track)| tracks[track].stay_from(until(body)));
            }
        });
        for body in self.frozen.iter().map(|one| one.body as usize).collect::<Vec<_>>() {
            self.wake_body(body);
        }
        for one in &self.frozen {
            for node in self.backend.assembly().bodies[one.body as usize].solver_range() {
                if self.backend.is_free(node) {
                    self.backend.pin(node);
                    self.pinned.insert(node as u32);
                }
            }
        }
    }

    /// Bodies with their fastest vertices, the fastest body first.
    pub(super) fn suspects(&self) -> Vec<Suspect> {
        let squared = |a: [f64; 3]| a.iter().map(|c| c * c).sum::<f64>();
        let mut suspects = Vec::new();
        for (number, body) in self.backend.assembly().bodies.iter().enumerate() {
            let mut worst = (-1.0, 0);
            for node in body.solver_range() {
                let [x, v] = [self.backend.position(node), self.backend.velocity(node)].map(squared);
                let speed = if (x + v).is_finite() { v } else { f64::INFINITY };
                if speed > worst.0 {
                    worst = (speed, node - body.first);
                }
            }
            if body.nodes > 0 {
                suspects.push(Suspect {
                    body: number,
                    vertex: body.vertex_of_solver(worst.1),
                    speed: worst.0,
                });
            }
        }
        suspects.sort_by(|a, b| b.speed.total_cmp(&a.speed));
        suspects
    }

    /// Returns to the last good state, with the nodes pinned that were.
    pub(super) fn return_to_good(&mut self) -> Result<(), Lost> {
        if let Some(first) = self.kept.frames.first() {
            let pinned = first.pinned.clone();
            self.pin_exactly(&pinned);
        }
        self.backend.return_to_good()
    }

    /// Runs the frames since the last good state, which is that of now, again, with those bodies frozen that make them fail: as few of
    /// the `suspects` as trying finds, the first ones before others. After them all is set as it is `now`.
    pub(super) fn go_on_without(
        &mut self,
        now: &Given,
        mut suspects: Vec<Suspect>,
        why: Diverged,
    ) -> Result<(), StepError> {
        suspects.retain(|one| self.could_move(one.body));
        let places = 0..self.backend.assembly().places;
        let state = places.map(|node| [self.backend.position(node), self.backend.velocity(node)]).collect();
        let kept = std::mem::take(&mut self.kept);
        let (report, held, frozen) = (self.report.clone(), self.held.clone(), self.frozen.clone());
        let again = Again { state, kept, report, held, frozen, why };
        let mut try_without = |which: &[usize]| {
            let which: Vec<Suspect> = which.iter().map(|&one| suspects[one]).collect();
            self.run_again(&again, &which)
        };
        // Looked at one by one, frames that were looked at together may be good.
        let were_several = again.kept.frames.iter().map(|given| given.frames).sum::<u32>() > 1;
        let found = match if were_several { try_without(&[]) } else { Ok(false) } {
            Ok(true) => Ok(Some(Vec::new())),
            Ok(false) => culprits(suspects.len(), MOST_TRIES, try_without),
            Err(error) => Err(error),
        };
        if !matches!(found, Ok(Some(_))) {
            self.frozen.clone_from(&again.frozen);
            self.return_to(&again);
        }
        self.give(now, &again.kept.frames[0]);
        match found {
            Ok(Some(_)) => Ok(()),
            Ok(None) => Err(self.halt(again.why.into())),
            Err(error @ StepError::Stopped { .. }) => Err(self.halt(error)),
            Err(error) => Err(error),
        }
    }

    /// Whether a body had a node that was free in any of the frames since the last good one, and is not frozen.
    fn could_move(&self, number: usize) -> bool {
        let body = &self.backend.assembly().bodies[number];
        let was_free = |node: usize| {
            let number = node as u32;
            (self.backend.is_free(node) || self.pinned.contains(&number))
                && self.kept.frames.iter().any(|given| !given.pinned.contains(&number))
        };
        !self.is_frozen(number) && body.solver_range().any(was_free)
    }

    /// Puts the state back that frames are run again from.
    fn return_to(&mut self, again: &Again) {
        // Before others hold their nodes.
        self.wake_all();
        self.pin_exactly(&again.kept.frames[0].pinned);
        for (node, &[x, v]) in again.state.iter().enumerate() {
            self.backend.set(node, x, v);
        }
        self.set_rest(&again.kept.rest);
        self.backend.set_solver_state(&again.kept.solvers);
        self.report.clone_from(&again.report);
        self.held.clone_from(&again.held);
        self.backend.mark_good();
    }

    /// Runs frames again with some more bodies frozen; whether all of them are good.
    fn run_again(&mut self, again: &Again, suspects: &[Suspect]) -> Result<bool, StepError> {
        self.frozen.clone_from(&again.frozen);
        self.return_to(again);
        let name = |number: usize| self.backend.assembly().bodies[number].name.clone();
        let frozen = |one: &Suspect| Frozen {
            body: one.body as u32,
            why: Diverged { body: name(one.body), vertex: one.vertex, ..again.why.clone() },
        };
        let frozen: Vec<Frozen> = suspects.iter().map(frozen).collect();
        self.frozen.extend(frozen);
        for given in &again.kept.frames {
            self.give(given, &again.kept.frames[0]);
            for _ in 0..given.frames {
                let frame = self.report.frame;
                let driven = self.start_frame(frame)?;
                if self.judge(frame + 1, driven)?.is_some() {
                    return Ok(false);
                }
            }
        }
        Ok(true)
    }
}

/// Of `count` things, those that make something fail: as few as can be found by trying what is good without which of them, the first
/// ones before others. Once that was tried `most_tries` times, more than that. None where it is not good without all of them. The last
/// try is the one without those that are returned.
fn culprits<E>(
    count: usize,
    most_tries: usize,
    mut is_good_without: impl FnMut(&[usize]) -> Result<bool, E>,
) -> Result<Option<Vec<usize>>, E> {
    let (mut found, mut left) = (Vec::new(), (0..count).collect::<Vec<_>>());
    let tries = Cell::new(0);
    loop {
        let mut is_good = |more: usize| {
            tries.set(tries.get() + 1);
            is_good_without(&[&found[..], &left[..more]].concat())
        };
        // Without the first `few` of those left it fails, without the first `enough` it is good.
        let (mut few, mut enough) = (0, left.len().min(1));
        while !is_good(enough)? {
            if enough == left.len() {
                return Ok(None);
            }
            (few, enough) = (enough, (2 * enough).min(left.len()));
        }
        let was_first = enough == 1;
        while enough - few > 1 && tries.get() < most_tries {
            let middle = few.midpoint(enough);
            *(if is_good(middle)? { &mut enough } else { &mut few }) = middle;
        }
        if enough == 0 {
            return Ok(Some(found));
        }
        if enough - few > 1 {
            found.extend(left.drain(..enough));
            left.clear();
        } else {
            found.push(left[enough - 1]);
            left.truncate(enough - 1);
        }
        if was_first || is_good_without(&found)? {
            return Ok(Some(found));
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Tries to find what fails without `guilty` among `count`; what was found, and how often was tried.
    fn search(count: usize, guilty: &[usize], most: usize) -> (Option<Vec<usize>>, usize) {
        let mut tried = Vec::new();
        let found = culprits::<()>(count, most, |without| {
            tried.push(without.to_vec());
            Ok(guilty.iter().all(|one| without.contains(one)))
        })
        .unwrap();
        assert!(found.is_none() || found == tried.pop(), "the last try is the one that stays");
        (found, tried.len() + 1)
    }

    #[test]
    fn exactly_those_are_found_that_make_it_fail() {
        for guilty in [&[0][..], &[3], &[0, 1], &[2, 5, 6], &[6], &[0, 1, 2, 3, 4, 5, 6]] {
            let (found, _) = search(7, guilty, 1000);
            let mut found = found.unwrap();
            found.sort_unstable();
            assert_eq!(found, guilty);
        }
        assert_eq!(search(100, &[0], 32), (Some(vec![0]), 1));
        assert!(search(1000, &[777], 32).1 < 24);
        assert_eq!(search(3, &[7], 32).0, None);
        assert_eq!(search(0, &[7], 32).0, None);
        assert_eq!(search(0, &[], 32).0, Some(Vec::new()));
    }

    #[test]
    fn after_many_tries_others_may_be_taken_for_guilty_too() {
        let guilty: Vec<usize> = (0..100).step_by(3).collect();
        let (found, tries) = search(100, &guilty, 32);
        assert!(guilty.iter().all(|one| found.as_ref().unwrap().contains(one)));
        assert!(tries < 60, "{tries}");
    }
}
