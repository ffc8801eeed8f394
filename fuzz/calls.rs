//! Sequences of calls of a simulation, in any order and with any numbers, held against a model: what a snapshot says is all that counts.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use taffeta::glam::{DQuat, DVec3};
use taffeta::scene::{
    Air, Body, Collider, ConstraintForm, Icosphere, Keyframe, Mass, Material, Mesh, Method, Rotation, Scene,
    Select, Sleep, Volume, World,
};
use taffeta::{InputError, OnDivergence, Options, Pose, Precision, Simulation, Snapshot, StepError};

/// Most calls of a sequence.
const MOST: usize = 48;

/// Decisions, byte by byte.
struct Bytes<'a>(&'a [u8]);

impl Bytes<'_> {
    fn next(&mut self) -> Option<u8> {
        let (first, rest) = self.0.split_first()?;
        self.0 = rest;
        Some(*first)
    }

    fn below(&mut self, count: u8) -> u8 {
        self.next().unwrap_or(0) % count
    }

    /// Some number: mostly one that makes sense.
    fn number(&mut self) -> f64 {
        const ODD: [f64; 12] = [
            0.0,
            -0.0,
            1e-300,
            1e-9,
            999.0,
            1e6,
            -1.000_001e6,
            1e15,
            1e300,
            f64::INFINITY,
            f64::NEG_INFINITY,
            f64::NAN,
        ];
        match self.next().unwrap_or(0) {
            byte if byte < 24 => ODD[usize::from(byte) % ODD.len()],
            byte => (f64::from(byte) - 140.0) / 400.0,
        }
    }

    fn vector(&mut self) -> [f64; 3] {
        [0; 3].map(|_| self.number())
    }

    fn pose(&mut self) -> Pose {
        let axis = self.vector();
        let rotate = if self.below(2) == 0 {
            Rotation::from(DQuat::from_rotation_y(0.1))
        } else {
            Rotation { axis, degrees: 100.0 * self.number() }
        };
        Pose { rotate, translate: self.vector() }
    }
}

/// Something that a program does.
#[derive(Clone, Debug)]
enum Call {
    Step,
    Advance(u32),
    Submit(u32),
    Poll,
    Stopped,
    Pin {
        vertex: usize,
        to: [f64; 3],
    },
    Unpin(usize),
    Force {
        vertex: usize,
        force: [f64; 3],
    },
    MoveCollider(Pose),
    MovePin(Pose),
    World(Box<World>),
    Disturb(f64, u64),
    Threads(usize),
    Wake,
    /// Another simulation of the scene takes over.
    Adopt,
    Save,
    /// Back to what was saved, in the same simulation or in a new one.
    Back {
        rebuilt: bool,
    },
}

impl Call {
    fn read(bytes: &mut Bytes) -> Option<Self> {
        let kind = bytes.next()? % 25;
        // Some are beyond the last one.
        let vertex = usize::from(bytes.below(34));
        Some(match kind {
            0..=4 => Self::Step,
            5 => Self::Advance(u32::from(bytes.below(4))),
            6 => Self::Submit(if bytes.below(9) == 0 { u32::MAX } else { 2 }),
            7 => Self::Poll,
            8 => Self::Stopped,
            9 | 10 => Self::Pin { vertex, to: bytes.vector() },
            11 => Self::Unpin(vertex),
            12 => Self::Force { vertex, force: bytes.vector() },
            13 | 14 => Self::MoveCollider(bytes.pose()),
            15 => Self::MovePin(bytes.pose()),
            16 => {
                let air = (bytes.below(2) == 0).then(|| Air { velocity: bytes.vector(), ..Air::default() });
                Self::World(Box::new(World {
                    gravity: bytes.vector(),
                    drag: bytes.number(),
                    air,
                    ..World::default()
                }))
            }
            17 => Self::Disturb(bytes.number(), u64::from(bytes.below(9))),
            18 => Self::Threads(usize::from(bytes.below(5))),
            19 => Self::Adopt,
            20 | 21 => Self::Save,
            22 => Self::Back { rebuilt: false },
            23 => Self::Wake,
            _ => Self::Back { rebuilt: true },
        })
    }

    /// Does it; whether it was not refused.
    fn make(&self, simulation: &mut Simulation, build: &dyn Fn() -> Simulation) -> bool {
        let body = simulation.bodies()[0].handle;
        let input = |result: Result<(), InputError>| result.map_err(|error| readable(&error)).is_ok();
        let ran = |result: Result<(), StepError>| result.map_err(|error| readable(&error)).is_ok();
        match self {
            Self::Step => ran(simulation.step().map(drop)),
            Self::Advance(frames) => ran(simulation.advance(*frames).map(drop)),
            // Four thousand million frames would do no harm, but take long.
            Self::Submit(u32::MAX) if simulation.frame() == 0 => true,
            Self::Submit(frames) => ran(simulation.submit(*frames)),
            Self::Poll => ran(simulation.poll().map(drop)),
            Self::Stopped => ran(simulation.step_unless(&Arc::new(AtomicBool::new(true))).map(drop)),
            Self::Pin { vertex, to } => input(simulation.pin_vertex(body, *vertex, *to)),
            Self::Unpin(vertex) => input(simulation.unpin_vertex(body, *vertex)),
            Self::Force { vertex, force } => input(simulation.apply_force(body, *vertex, *force)),
            Self::MoveCollider(pose) => {
                let collider = simulation.colliders()[0].handle;
                input(simulation.move_collider(collider, *pose))
            }
            Self::MovePin(pose) => match simulation.pin(body, 0) {
                Ok(pin) => input(simulation.move_pin(pin, *pose)),
                Err(_) => false,
            },
            Self::World(world) => input(simulation.set_world(world)),
            Self::Disturb(amplitude, seed) => {
                simulation.disturb(*amplitude, *seed);
                true
            }
            Self::Threads(most) => {
                simulation.limit_threads(*most);
                true
            }
            Self::Wake => input(simulation.wake(body)),
            Self::Adopt => {
                let mut next = build();
                next.adopt_state(simulation);
                *simulation = next;
                true
            }
            Self::Save | Self::Back { .. } => true,
        }
    }

    /// Whether a refusal of it leaves all as it was; frames may have been done before the one that failed.
    fn is_input(&self) -> bool {
        use Call::{Force, MoveCollider, MovePin, Pin, Unpin, World};
        matches!(self, Pin { .. } | Unpin(_) | Force { .. } | MoveCollider(_) | MovePin(_) | World(_))
    }
}

fn readable(error: &dyn std::fmt::Display) {
    let words = error.to_string();
    assert!(words.len() < 2000 && !words.contains(char::is_control), "{words:?}");
}

/// A few small scenes: of each solver, with contact, volume, air, a pin that may be moved and a collider.
fn scene(number: u8) -> Scene {
    let sheet = |name: &str| Body::cloth(name, Mesh::grid(5, 6, [0.5, 0.4])).with_mass(Mass::Node(0.01));
    let springs = |body: Body| body.structural(50.0, 0.05).shear(20.0, 0.02).bend(2.0, 0.0);
    let pinned = |body: Body| body.pin_moving(Select::nodes([0, 5]), vec![Keyframe::default()]);
    let ball = || Collider::sphere([0.05, -0.2, 0.0], 0.12).friction(0.4);
    let scene = Scene::new("calls").time(0.02, 0.005);
    match number {
        0 => {
            let air = Some(Air { velocity: [1.0, 0.0, 0.5], ..Air::default() });
            let world = World { air, ..World::default() };
            let scene = scene.body(pinned(springs(sheet("nodes"))).collide_nodes(0.05)).collider(ball());
            Scene { world, ..scene }
        }
        1 => {
            let cotton = |name| sheet(name).with_material(Material::preset("cotton")).collide(0.005);
            let mut scene = scene.method(Method::Ice).time(0.02, 0.02);
            scene.solver.ice.form = ConstraintForm::Primal;
            scene
                .body(pinned(cotton("upper")))
                .body(cotton("lower").at([0.02, -0.02, 0.0]))
                .collider(Collider::cuboid([0.05, -0.2, 0.0], [0.1, 0.1, 0.1]))
        }
        2 => scene.method(Method::Acad).body(pinned(springs(sheet("taut")))).collider(ball()),
        _ => {
            let mesh = Mesh::Icosphere(Icosphere { radius: 0.15, subdivisions: 1 });
            let soft = Body::soft("soft", mesh).with_mass(Mass::Node(0.01));
            let soft = Body { volume: Some(Volume::default()), ..soft.structural(50.0, 0.05) };
            scene.body(pinned(soft)).collider(Collider::plane([0.0, -0.3, 0.0], [0.0, 1.0, 0.0]))
        }
    }
}

/// All that can be seen of a simulation's state.
fn state(simulation: &Simulation) -> (u64, u32, Snapshot) {
    let mut snapshot = simulation.snapshot();
    // Lists of pairs that are there already need no search; nothing else depends on them.
    (snapshot.start.pair_searches, snapshot.report.pair_searches) = (0, 0);
    // At a start on the way, colliders count as they were in the frame before.
    snapshot.start.intersections = None;
    (simulation.state_hash(), simulation.frame(), snapshot)
}

/// The same in both; if not, says what is different.
fn assert_same(a: &(u64, u32, Snapshot), b: &(u64, u32, Snapshot), what: impl Fn() -> String) {
    assert_eq!((a.0, a.1), (b.0, b.1), "{}", what());
    assert_eq!((&a.2.start, &a.2.report), (&b.2.start, &b.2.report), "{}", what());
    assert_eq!((&a.2.changes, &a.2.held, &a.2.moved), (&b.2.changes, &b.2.held, &b.2.moved), "{}", what());
    assert!(a.2 == b.2, "solvers: {}", what());
}

/// Does what `input` says. Whatever it is, there is no panic and no number that is none; what is refused changes nothing; and going back to
/// a snapshot, the same calls have the same results.
pub fn calls(input: &[u8]) -> bool {
    let mut bytes = Bytes(input);
    let mut scene = scene(bytes.below(4));
    // Some fall asleep while they move, and soon.
    scene.sleep = (bytes.below(2) == 0).then_some(Sleep { speed: 0.3, after: 0.03 });
    let scene = scene;
    let precision = if bytes.below(2) == 0 { Precision::F32 } else { Precision::F64 };
    let on_divergence = if bytes.below(2) == 0 { OnDivergence::Freeze } else { OnDivergence::Stop };
    let threads = Some(1 + usize::from(bytes.below(2)));
    let options = Options { threads, precision, on_divergence, ..Options::default() };
    let build = || Simulation::new(&scene, &options).expect("the scene runs");
    let mut simulation = build();
    let mut saved: Option<(Snapshot, Vec<Call>)> = None;
    for _ in 0..MOST {
        let Some(call) = Call::read(&mut bytes) else { break };
        match call {
            Call::Save => {
                // Frames under way, and what is asked for those to come, are no part of it. What blew up may remember no numbers.
                let _ = simulation.poll();
                let snapshot = simulation.snapshot();
                saved = simulation.restore(&snapshot).is_ok().then(|| (snapshot, Vec::new()));
            }
            Call::Back { rebuilt } => {
                let Some((snapshot, since)) = &mut saved else { continue };
                let _ = simulation.poll();
                since.push(Call::Poll);
                let wanted = state(&simulation);
                if rebuilt {
                    simulation = build();
                }
                simulation.restore(snapshot).expect("it is of this scene");
                assert_eq!(simulation.snapshot(), *snapshot, "what is restored is what was taken");
                for call in since.iter() {
                    call.make(&mut simulation, &build);
                }
                assert_same(&state(&simulation), &wanted, || format!("rebuilt: {rebuilt}, {since:?}"));
            }
            call => {
                let before = call.is_input().then(|| state(&simulation));
                let accepted = call.make(&mut simulation, &build);
                if let Some(before) = before.filter(|_| !accepted) {
                    assert_same(&state(&simulation), &before, || format!("{call:?}"));
                }
                if let Some((_, since)) = &mut saved {
                    since.push(call);
                }
            }
        }
        let mut positions: Vec<DVec3> = Vec::new();
        simulation.positions_f64(&mut positions);
        assert!(positions.iter().all(|x| x.is_finite()) && simulation.report().is_finite());
    }
    true
}
