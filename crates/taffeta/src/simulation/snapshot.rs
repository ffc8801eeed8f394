//! Snapshots: the state of a simulation between two frames, to stop a run and continue it.

use crate::backend::{ContactForce, FrameInput, SolverState};
use crate::motion::keyframes::Track;
use crate::plan::refinement::{CALM_FRAMES, Refinement};
use crate::report::FrameReport;
use crate::scene::{Keyframe, Path, Rotation, World, check_motion};
use crate::simulation::sleeping::Rest;
use crate::simulation::{Frozen, InputError, Precision, Simulation};
use serde::{Deserialize, Serialize};
use std::collections::BTreeSet;

/// A simulation between two frames. A simulation of the same scene that is [restored](Simulation::restore) from it
/// goes on bit by bit as this one would have.
///
/// ```
/// # use taffeta::scene::{Body, Collider, Mass, Mesh, Scene, Select};
/// # use taffeta::{Options, Simulation};
/// # let cloth = Body::cloth("cloth", Mesh::grid(4, 5, [0.4, 0.3])).with_mass(Mass::Area(0.2));
/// # let scene = Scene::new("").time(0.01, 1e-3).body(cloth.structural(50.0, 0.05).pin(Select::nodes([0])))
/// #     .collider(Collider::sphere([0.0, -1.0, 0.0], 0.2).named("ball"));
/// let build = || Simulation::new(&scene, &Options::default());
/// let mut first = build()?;
/// first.advance(3)?;
/// let snapshot = first.snapshot();
/// let mut second = build()?;
/// second.restore(&snapshot)?;
/// assert_eq!(first.step()?, second.step()?);
/// assert_eq!(first.state_hash(), second.state_hash());
/// # Ok::<(), Box<dyn std::error::Error>>(())
/// ```
///
/// It has what a program has changed so far: pinned vertices, poses of colliders and pins, the world. What is asked for the frame to come
/// is not part of it.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Snapshot {
    /// Hash of the scene: of the text that [`identity`](crate::scene::identity) makes of it. Who wants the state in another scene with the
    /// same nodes and constraints takes the hash from a snapshot of that one.
    pub scene: u64,
    /// Arithmetic, and so the width of the numbers in `state`.
    pub precision: Precision,
    /// Number of nodes of all bodies.
    pub nodes: u64,
    /// Report of the start.
    pub start: FrameReport,
    /// Report of the last frame.
    pub report: FrameReport,
    /// Nodes that are held, in user order.
    pub held: Vec<u32>,
    /// Nodes that were moved by the user in the last frame, in user order.
    pub moved: Vec<u32>,
    /// What a program has changed in the scene.
    #[serde(with = "as_json")]
    pub changes: Changes,
    /// Whether it was taken after a frame that blew up or was stopped: positions are those of the frame before, and what constraints
    /// remember is not. No simulation goes on from it.
    pub halted: bool,
    /// Number of constraint forces in `constraints`; 0 if the solver starts from none.
    pub pulls: u64,
    /// Number of adaptive constraints; 0 if there are none.
    pub adaptive: u64,
    /// Number of joints, if some may break; 0 if none can.
    pub joints: u64,
    /// Number of contacts between surfaces that carry a force.
    pub contacts: u64,
    /// Whether surfaces that pass through each other are being pulled apart.
    pub is_tangled: bool,
    /// Into how many parts contact between triangles has each sub-step cut, and for how many frames it could have done with fewer.
    pub refinement: [u32; 2],
    /// Positions [m], then velocities [m/s] of all nodes in user order, little endian. Kept apart when serialized.
    #[serde(skip)]
    pub state: Vec<u8>,
    /// Pulls of constraints [N], little endian, then for each that comes and goes a bit that says whether it is there, the
    /// lowest of each byte first, then the same for each joint, all in an order that the scene alone decides; then contacts.
    /// Kept apart when serialized.
    #[serde(skip)]
    pub constraints: Vec<u8>,
}

/// What a program has changed in a scene while it runs.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[non_exhaustive]
pub struct Changes {
    /// The world as it is.
    pub world: World,
    /// Colliders that a program has brought somewhere, by their number in the scene.
    pub colliders: Vec<(u32, Keyframe)>,
    /// The same of pins, by their number among those that can move.
    pub pins: Vec<(u32, Keyframe)>,
    /// Nodes that were free and that a program has pinned, those of frozen bodies among them but not those of sleeping ones, in user
    /// order.
    pub pinned: Vec<u32>,
    /// Bodies that diverged and stand still.
    pub frozen: Vec<Frozen>,
    /// Frames that each body has been at rest; empty where none ever sleeps.
    pub rest: Vec<u32>,
    /// Bodies that are asleep.
    pub asleep: Vec<u32>,
}

/// In formats that do not name their fields, one that may be left out has no place; as text it has.
mod as_json {
    use super::Changes;
    use serde::de::Error as _;
    use serde::ser::Error as _;
    use serde::{Deserialize, Deserializer, Serializer};

    pub fn serialize<S: Serializer>(changes: &Changes, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(&serde_json::to_string(changes).map_err(S::Error::custom)?)
    }

    pub fn deserialize<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Changes, D::Error> {
        serde_json::from_str(&String::deserialize(deserializer)?).map_err(D::Error::custom)
    }
}

impl Changes {
    /// Who sleeps.
    fn rest(&self) -> Rest {
        Rest { frames: self.rest.clone(), asleep: self.asleep.iter().map(|&body| body as usize).collect() }
    }

    /// Whether a program could have made them in a scene of so many nodes and so many colliders and tracks of pins.
    fn check(&self, nodes: usize, [colliders, pins]: [usize; 2]) -> Result<(), String> {
        self.world.check().map_err(|error| error.to_string())?;
        for (what, all, count) in [("collider", &self.colliders, colliders), ("pin", &self.pins, pins)] {
            if let Some((number, _)) = all.iter().find(|(number, _)| *number as usize >= count) {
                return Err(format!("it moves {what} {number}, the scene has {count}"));
            }
            let path = Path::of(what);
            for (_, key) in all {
                // No turn at all needs no axis, as in a pose.
                let rotate = key.rotate.filter(|turn| *turn != Rotation::default());
                let turned = Keyframe { rotate, ..key.clone() };
                check_motion(&path, &[turned]).map_err(|error| error.to_string())?;
            }
        }
        match self.pinned.iter().find(|user| **user as usize >= nodes) {
            Some(user) => Err(format!("it pins node {user}, the scene has {nodes}")),
            None => Ok(()),
        }
    }
}

impl Snapshot {
    /// Bytes of `state` that `nodes` nodes take.
    pub fn state_bytes(&self) -> Option<u64> {
        self.nodes.checked_mul(6 * self.precision.bytes() as u64)
    }

    /// Bytes that the pulls and the bits of `constraints` take.
    pub fn constraint_bytes(&self) -> Option<u64> {
        let bits = self.adaptive.div_ceil(8).checked_add(self.joints.div_ceil(8))?;
        let contacts = self.contacts.checked_mul(CONTACT as u64)?;
        self.pulls.checked_mul(self.precision.bytes() as u64)?.checked_add(bits)?.checked_add(contacts)
    }

    /// Three numbers of the state from `index` on.
    fn triple(&self, index: usize) -> [f64; 3] {
        std::array::from_fn(|axis| self.precision.number(&self.state, index + axis))
    }

    /// The state of the solvers.
    fn solver_state(&self) -> SolverState {
        let [pulls, adaptive, joints] = [self.pulls, self.adaptive, self.joints].map(|count| count as usize);
        let (active, there) =
            self.constraints[pulls * self.precision.bytes()..].split_at(adaptive.div_ceil(8));
        let (there, contacts) = there.split_at(joints.div_ceil(8));
        let bit = |bits: &[u8], index: usize| bits[index / 8] >> (index % 8) & 1 == 1;
        let [parts, calm] = self.refinement;
        SolverState {
            warm_start: (0..pulls).map(|index| self.precision.number(&self.constraints, index)).collect(),
            active: (0..adaptive).map(|index| bit(active, index)).collect(),
            joints: (0..joints).map(|index| bit(there, index)).collect(),
            contacts: contacts.as_chunks().0.iter().map(contact).collect(),
            is_tangled: self.is_tangled,
            refinement: Refinement { parts, calm },
        }
    }

    /// Stores the state of the solvers.
    fn note(&mut self, state: &SolverState) {
        let SolverState { warm_start, active, joints, contacts, is_tangled, refinement } = state;
        self.is_tangled = *is_tangled;
        self.refinement = [refinement.parts, refinement.calm];
        [self.pulls, self.adaptive, self.joints, self.contacts] =
            [warm_start.len(), active.len(), joints.len(), contacts.len()].map(|count| count as u64);
        let mut bytes =
            Vec::with_capacity(warm_start.len() * self.precision.bytes() + active.len().div_ceil(8));
        warm_start.iter().for_each(|&number| self.precision.append(number, &mut bytes));
        let byte = |bits: &[bool]| bits.iter().rev().fold(0, |byte, &bit| byte << 1 | u8::from(bit));
        bytes.extend(active.chunks(8).chain(joints.chunks(8)).map(byte));
        bytes.extend(contacts.iter().flat_map(contact_bytes));
        self.constraints = bytes;
    }
}

/// Bytes of a contact: its kind, its pair, its force.
const CONTACT: usize = 1 + 2 * 4 + 3 * 8;

fn contact(bytes: &[u8; CONTACT]) -> ContactForce {
    ContactForce {
        kind: bytes[0],
        pair: [0, 1].map(|index| u32::from_le_bytes(chunk(&bytes[1..], index))),
        force: [0, 1, 2].map(|index| f64::from_le_bytes(chunk(&bytes[9..], index))),
    }
}

fn contact_bytes(contact: &ContactForce) -> Vec<u8> {
    let ContactForce { kind, pair, force } = contact;
    let pair = pair.iter().flat_map(|number| number.to_le_bytes());
    std::iter::once(*kind).chain(pair).chain(force.iter().flat_map(|number| number.to_le_bytes())).collect()
}

fn chunk<const N: usize>(bytes: &[u8], index: usize) -> [u8; N] {
    bytes.as_chunks().0[index]
}

impl Precision {
    /// Size of a number [byte].
    pub fn bytes(self) -> usize {
        match self {
            Self::F32 => 4,
            Self::F64 => 8,
        }
    }

    /// Number `index` of `bytes`.
    fn number(self, bytes: &[u8], index: usize) -> f64 {
        match self {
            Self::F32 => f64::from(f32::from_le_bytes(chunk(bytes, index))),
            Self::F64 => f64::from_le_bytes(chunk(bytes, index)),
        }
    }

    /// Whether a number is one in this arithmetic.
    fn has(self, number: f64) -> bool {
        match self {
            Self::F32 => (number as f32).is_finite(),
            Self::F64 => number.is_finite(),
        }
    }

    /// What is wrong with a number that it has not.
    fn refuses(self) -> &'static str {
        match self {
            Self::F32 => "is not finite in 32 bits",
            Self::F64 => "is not finite",
        }
    }

    /// The first of `count` numbers in `bytes` that is none in the arithmetic `other`.
    fn beyond(self, other: Self, bytes: &[u8], count: usize) -> Option<usize> {
        (0..count).find(|&index| !other.has(self.number(bytes, index)))
    }

    /// Appends a number to `bytes`.
    fn append(self, number: f64, bytes: &mut Vec<u8>) {
        match self {
            Self::F32 => bytes.extend((number as f32).to_le_bytes()),
            Self::F64 => bytes.extend(number.to_le_bytes()),
        }
    }
}

/// Whether its reports are ones that a run can go on from.
fn check_reports(snapshot: &Snapshot) -> Result<(), String> {
    let Snapshot { start, report, .. } = snapshot;
    for (name, one) in [("start", start), ("last frame", report)] {
        if !one.is_finite() {
            return Err(format!(
                "the report of its {name} has an energy, a momentum or a stretch that is not finite"
            ));
        }
    }
    if report.frame < start.frame {
        return Err(format!("it is of frame {}, before its start in frame {}", report.frame, start.frame));
    }
    Ok(())
}

impl std::fmt::Display for Precision {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::F32 => "f32",
            Self::F64 => "f64",
        })
    }
}

impl Simulation {
    /// The state after the last frame.
    pub fn snapshot(&self) -> Snapshot {
        let order = self.user_order();
        let chosen = |wanted: &dyn Fn(usize) -> bool| {
            order.iter().zip(0..).filter(|&(&node, _)| wanted(node)).map(|(_, user)| user).collect()
        };
        let mut state = Vec::with_capacity(order.len() * 6 * self.precision.bytes());
        self.state(&order, |bytes| state.extend_from_slice(bytes));
        let mut snapshot = Snapshot {
            scene: self.scene_hash(),
            precision: self.precision,
            nodes: order.len() as u64,
            start: self.start.clone(),
            report: FrameReport { frame: self.frame(), ..self.report.clone() },
            held: chosen(&|node| !self.backend.is_free(node)),
            moved: chosen(&|node| self.moved.binary_search(&(node as u32)).is_ok()),
            changes: self.changes(chosen(&|node| self.pinned.contains(&(node as u32)))),
            halted: self.halted.is_some(),
            pulls: 0,
            adaptive: 0,
            joints: 0,
            contacts: 0,
            is_tangled: false,
            refinement: [1, 0],
            state,
            constraints: Vec::new(),
        };
        snapshot.note(&self.backend.solver_state());
        snapshot
    }

    fn changes(&self, pinned: Vec<u32>) -> Changes {
        let assembly = self.backend.assembly();
        let now = f64::from(self.frame()) * assembly.time.dt;
        let brought = |(number, track): (u32, &Track)| Some((number, track.brought(now)?.clone()));
        Changes {
            world: assembly.world.clone(),
            colliders: (0..)
                .zip(assembly.colliders().iter().map(|one| one.track()))
                .filter_map(brought)
                .collect(),
            pins: (0..).zip(assembly.tracks()).filter_map(brought).collect(),
            pinned,
            frozen: self.frozen.clone(),
            rest: self.sleeping.rest.frames.clone(),
            asleep: self.sleeping.rest.asleep.iter().map(|&body| body as u32).collect(),
        }
    }

    fn take_changes(&mut self, changes: &Changes) {
        let of = |all: &[(u32, Keyframe)], number: usize| {
            all.iter().find(|(one, _)| *one as usize == number).map(|(_, key)| key.clone())
        };
        self.backend.alter(&mut |assembly| {
            assembly.world = changes.world.clone();
            for (number, collider) in assembly.colliders_mut().iter_mut().enumerate() {
                collider.track_mut().bring_back(of(&changes.colliders, number).as_ref());
            }
            if !assembly.tracks().is_empty() {
                for (number, track) in assembly.moving_mut().tracks.iter_mut().enumerate() {
                    track.bring_back(of(&changes.pins, number).as_ref());
                }
            }
        });
    }

    /// Takes up where a simulation of the same scene was, with what a program had changed by then. A snapshot in another precision is
    /// converted. What was asked for the frame to come, and frames that were submitted and not polled, are given up.
    ///
    /// # Errors
    /// Where the snapshot is of another scene, or has numbers that no simulation of this one could have; nothing is changed then.
    pub fn restore(&mut self, snapshot: &Snapshot) -> Result<(), InputError> {
        let order = self.user_order();
        self.fits(snapshot, &order).map_err(InputError::Snapshot)?;
        // What was asked for before belongs to frames that are given up. A device that is lost says so in the next one.
        if std::mem::take(&mut self.submitted).0 > 0 {
            let _ = self.backend.sums();
        }
        self.input = FrameInput::default();
        self.halted = None;
        self.take_changes(&snapshot.changes);
        // Before others hold their nodes.
        self.wake_all();
        let pinned = |user: &u32| order[*user as usize] as u32;
        self.pin_exactly(&snapshot.changes.pinned.iter().map(pinned).collect());
        self.frozen.clone_from(&snapshot.changes.frozen);
        self.hold_frozen();
        for (user, &node) in order.iter().enumerate() {
            let [place, velocity] = [3 * user, 3 * (order.len() + user)].map(|at| snapshot.triple(at));
            self.backend.set(node, place, velocity);
        }
        self.set_rest(&snapshot.changes.rest());
        self.sleeping.roused.clear();
        self.backend.set_solver_state(&snapshot.solver_state());
        self.moved = snapshot.moved.iter().map(|&user| order[user as usize] as u32).collect();
        self.moved.sort_unstable();
        self.held.clear();
        self.start = snapshot.start.clone();
        self.report = snapshot.report.clone();
        self.mark_good();
        Ok(())
    }

    fn fits(&self, snapshot: &Snapshot, order: &[usize]) -> Result<(), String> {
        if snapshot.scene != self.scene_hash() {
            return Err(
                "it is of another scene; the same scene would do, and adopt_state() takes places and velocities \
                 over into a simulation of another"
                    .to_owned(),
            );
        }
        if snapshot.halted {
            let frame = snapshot.report.frame;
            return Err(format!(
                "the frame after its frame {frame} blew up or was stopped; one from before would do"
            ));
        }
        let nodes = order.len();
        check_reports(snapshot)?;
        let assembly = self.backend.assembly();
        let counts = [assembly.colliders().len(), assembly.tracks().len()];
        snapshot.changes.check(nodes, counts)?;
        self.check_rest(&snapshot.changes)?;
        if snapshot.nodes != nodes as u64 {
            return Err(format!("it holds {} nodes, the scene has {nodes}", snapshot.nodes));
        }
        if snapshot.state_bytes() != Some(snapshot.state.len() as u64) {
            return Err(format!("its state of {nodes} nodes has {} bytes", snapshot.state.len()));
        }
        self.check_state(snapshot)?;
        let beyond = |user: &&u32| **user as usize >= nodes;
        if let Some(user) = snapshot.held.iter().chain(&snapshot.moved).find(beyond) {
            return Err(format!("it holds node {user}, the scene has {nodes}"));
        }
        let mut held = snapshot.held.clone();
        held.sort_unstable();
        // What a program has pinned here is freed; what the scene holds cannot be, and nothing else can be held.
        let is_held = |node: usize| {
            !self.backend.is_free(node) && !self.pinned.contains(&(node as u32)) && !self.sleeping.holds(node)
        };
        let pinned: BTreeSet<u32> = snapshot.changes.pinned.iter().copied().collect();
        let asleep = snapshot.changes.rest().asleep;
        for (user, &node) in (0..).zip(order) {
            let in_it = held.binary_search(&user).is_ok();
            if pinned.contains(&user) && !in_it {
                return Err(format!("node {user} is pinned by a program in it, and not held"));
            }
            if asleep.contains(&assembly.number_of_body(node as u32)) {
                if !in_it {
                    return Err(format!("node {user} is of a body that is asleep in it, and not held"));
                }
                continue;
            }
            if is_held(node) != (in_it && !pinned.contains(&user)) {
                let [there, here] = if in_it { ["held", "free"] } else { ["free", "held"] };
                return Err(format!("node {user} is {there} in it and {here} in the scene"));
            }
        }
        for Frozen { body, .. } in &snapshot.changes.frozen {
            let Some(body) = assembly.bodies.get(*body as usize) else {
                return Err(format!("its body {body} is frozen, the scene has {}", assembly.bodies.len()));
            };
            let is_loose = |(user, node): (u32, &usize)| {
                (body.solver_range().contains(node) && held.binary_search(&user).is_err()).then_some(user)
            };
            if let Some(user) = (0..).zip(order).find_map(is_loose) {
                return Err(format!("body `{}` is frozen in it, but node {user} is not held", body.name));
            }
        }
        match snapshot.precision.beyond(self.precision, &snapshot.state, 6 * nodes) {
            Some(index) => {
                Err(format!("its node {} has a number that {}", index / 3 % nodes, self.precision.refuses()))
            }
            None => Ok(()),
        }
    }

    /// Whether bodies of this scene may sleep as they do in it.
    fn check_rest(&self, Changes { rest, asleep, .. }: &Changes) -> Result<(), String> {
        let bodies = self.bodies.len();
        let counted = if self.scene.sleep.is_some() { bodies } else { 0 };
        if rest.len() != counted {
            return Err(format!(
                "it says of {} bodies how long they have been at rest, not of {counted}",
                rest.len()
            ));
        }
        match asleep.iter().find(|body| **body as usize >= counted) {
            Some(body) => {
                Err(format!("its body {body} is asleep, and of this scene {counted} bodies may be"))
            }
            None => Ok(()),
        }
    }

    /// Whether it has the state of this scene's solvers.
    fn check_state(&self, snapshot: &Snapshot) -> Result<(), String> {
        let SolverState { warm_start, active, joints, .. } = self.backend.solver_state();
        let counts = [
            ("pulls of constraints", snapshot.pulls, warm_start.len()),
            ("constraints that come and go", snapshot.adaptive, active.len()),
            ("joints", snapshot.joints, joints.len()),
        ];
        if let Some((what, held, count)) = counts.into_iter().find(|&(_, held, count)| held != count as u64) {
            return Err(format!("it holds {held} {what}, the scene has {count}"));
        }
        if snapshot.constraint_bytes() != Some(snapshot.constraints.len() as u64) {
            let (bytes, count) =
                (snapshot.constraints.len(), warm_start.len().max(active.len()).max(joints.len()));
            return Err(format!("what its {count} constraints remember has {bytes} bytes"));
        }
        if let Some(index) =
            snapshot.precision.beyond(self.precision, &snapshot.constraints, warm_start.len())
        {
            return Err(format!("its constraint {index} has a pull that {}", self.precision.refuses()));
        }
        let state = snapshot.solver_state();
        let most = self.backend.assembly().time.most_parts();
        if !state.refinement.is_possible(most) {
            let Refinement { parts, calm } = state.refinement;
            return Err(format!(
                "it cuts sub-steps into {parts} parts since {calm} frames; a power of two up to {most}, and less than \
                 {CALM_FRAMES} frames, would do"
            ));
        }
        let beyond = |one: &ContactForce| one.force.iter().any(|&number| !self.precision.has(number));
        match state.contacts.iter().position(beyond) {
            Some(index) => Err(format!("its contact {index} has a force that {}", self.precision.refuses())),
            None => Ok(()),
        }
    }
}
