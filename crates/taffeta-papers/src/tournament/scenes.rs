//! The three scenes, each soft and stiff, and the steps that are taken on them.

use super::Method;
use super::rk4::{State, System};
use std::f64::consts::PI;
use taffeta::scene::{Body, Mass, Mesh, Rotation, Scene, Select};
use taffeta::{Options, Precision, Simulation, springs_of};

/// Length of a frame [s].
pub const FRAME: f64 = 1.0 / 60.0;
/// Frames that are run.
pub const FRAMES: u32 = 30;
/// Nodes along an edge of a sheet.
const SIDE: u32 = 32;
/// Mass of a sheet's node [kg].
const SHEET_NODE: f64 = 2e-4;

/// A scene with its stiffness.
#[derive(Debug)]
pub struct Case {
    /// What it is called in names of runs.
    pub name: &'static str,
    /// What the reader calls it.
    pub title: &'static str,
    shape: Shape,
    /// Stiffness of all springs [N/m].
    pub k: f64,
    /// Sub-steps in a frame with which explicit springs hold, and with which the method of Runge and Kutta does: the fewest, with
    /// a twentieth to a tenth to spare.
    pub fewest: [u32; 2],
}

#[derive(Clone, Copy, Debug)]
enum Shape {
    Swing,
    Drum,
    Chain,
}

/// All of them.
pub const CASES: [Case; 6] = [
    Case { name: "swing-soft", title: "swing, 100 N/m", shape: Shape::Swing, k: 1e2, fewest: [20, 15] },
    Case { name: "swing-stiff", title: "swing, 10,000 N/m", shape: Shape::Swing, k: 1e4, fewest: [200, 140] },
    Case { name: "drum-soft", title: "drum, 30 N/m", shape: Shape::Drum, k: 3e1, fewest: [12, 9] },
    Case { name: "drum-stiff", title: "drum, 300 N/m", shape: Shape::Drum, k: 3e2, fewest: [36, 27] },
    Case { name: "chain-soft", title: "chain, 10,000 N/m", shape: Shape::Chain, k: 1e4, fewest: [25, 18] },
    Case {
        name: "chain-stiff",
        title: "chain, 1,000,000 N/m",
        shape: Shape::Chain,
        k: 1e6,
        fewest: [250, 170],
    },
];

impl Case {
    /// The one of that name.
    #[cfg(test)]
    pub fn named(name: &str) -> Option<&'static Self> {
        CASES.iter().find(|case| case.name == name)
    }

    /// Time that is run [s].
    pub fn seconds() -> f64 {
        f64::from(FRAMES) * FRAME
    }

    /// The scene at rest.
    pub fn scene(&self, method: Method, steps: u32) -> Scene {
        let body = match self.shape {
            Shape::Swing => self.sheet(0.0).at([0.0, -0.5, 0.0]).pin(Select::rows(0, 0)),
            Shape::Drum => {
                self.sheet(DRUM_DAMPING * self.k).pin(Select { boundary: Some(true), ..Select::default() })
            }
            Shape::Chain => Body::cloth("chain", Mesh::chain(CHAIN_LINKS, CHAIN_LENGTH))
                .with_mass(Mass::Node(CHAIN_NODE))
                .structural(self.k, 0.0)
                .pin(Select::nodes([0])),
        };
        let mut scene = Scene::new(self.title).time(FRAME, FRAME / f64::from(steps)).body(body);
        if matches!(self.shape, Shape::Swing) {
            scene.bodies[0].place.rotation = Some(Rotation { axis: [1.0, 0.0, 0.0], degrees: 90.0 });
        }
        if matches!(self.shape, Shape::Drum) {
            scene.world.gravity = [0.0; 3];
        }
        scene.solver = method.solver();
        scene
    }

    /// A square of 1 m with springs of all kinds.
    fn sheet(&self, d: f64) -> Body {
        let sheet = Body::cloth("sheet", Mesh::grid(SIDE, SIDE, [1.0; 2])).with_mass(Mass::Node(SHEET_NODE));
        sheet.structural(self.k, d).shear(self.k, d).bend(self.k, d)
    }

    /// Place [m] and velocity [m/s] at the start of a free node that is there at rest; held nodes have the place alone.
    fn start(&self, [x, y, z]: [f64; 3]) -> ([f64; 3], [f64; 3]) {
        match self.shape {
            Shape::Swing => {
                ([x, y, z], [0.0, 0.0, -SWING_RATE * y * (1.0 + SWING_FASTER * (PI * (x + 0.5)).cos())])
            }
            Shape::Drum => {
                let [x, z] = [x, z].map(|at| at * DRUM_STRETCH);
                let away = ((x - 0.05).hypot(z - 0.03) / BUMP_RADIUS).min(1.0);
                ([x, 0.5 * BUMP_HEIGHT * (1.0 + (PI * away).cos()), z], [0.0; 3])
            }
            Shape::Chain => ([x, y, z], [0.0; 3]),
        }
    }

    /// A simulation that stands at the start.
    ///
    /// # Errors
    /// What the scene's own check says.
    pub fn simulation(&self, method: Method, steps: u32, precision: Precision) -> Result<Simulation, String> {
        #[allow(
            clippy::needless_update,
            reason = "with the feature `gpu` of the engine there is one more option"
        )]
        let options = Options { precision, threads: Some(1), ..Options::default() };
        let scene = self.scene(method, steps);
        let mut simulation = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
        let mut snapshot = simulation.snapshot();
        let start = self.state(&simulation);
        let numbers = start.x.iter().chain(&start.v).flatten();
        snapshot.state = match precision {
            Precision::F32 => numbers.flat_map(|&number| (number as f32).to_le_bytes()).collect(),
            Precision::F64 => numbers.flat_map(|number| number.to_le_bytes()).collect(),
        };
        simulation.restore(&snapshot)?;
        // Moves nothing; but energies are counted from here on.
        simulation.disturb(0.0, 0);
        Ok(simulation)
    }

    /// The start, in 64 bits, of a simulation that is at rest.
    fn state(&self, at_rest: &Simulation) -> State<f64> {
        let mut places = Vec::new();
        at_rest.positions_f64(&mut places);
        let held = held(at_rest);
        let nodes = places.iter().zip(held).map(|(&place, held)| {
            let (x, v) = self.start(place);
            (x, if held { [0.0; 3] } else { v })
        });
        let (x, v) = nodes.unzip();
        State { x, v }
    }

    /// What the method of Runge and Kutta runs: springs and masses, and the start.
    ///
    /// # Errors
    /// What the scene's own check says.
    pub fn system<T: super::rk4::Number>(&self) -> Result<(System<T>, State<f64>), String> {
        let scene = self.scene(Method::Springs, 1);
        let lists = springs_of(&scene, 0).map_err(|error| error.to_string())?;
        let options = Options { precision: Precision::F64, ..Options::default() };
        let at_rest = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
        let mass = scene.bodies[0].node_mass.unwrap_or(SHEET_NODE);
        let system = System::new(&lists, mass, &held(&at_rest), scene.world.gravity);
        Ok((system, self.state(&at_rest)))
    }
}

/// Which nodes are held.
fn held(simulation: &Simulation) -> Vec<bool> {
    let snapshot = simulation.snapshot();
    let mut held = vec![false; snapshot.nodes as usize];
    snapshot.held.iter().for_each(|&node| held[node as usize] = true);
    held
}

/// Rate of the turn about the upper edge [rad/s], and how much faster one side is than the middle.
const SWING_RATE: f64 = 3.0;
const SWING_FASTER: f64 = 0.05;
/// Length by that at rest of the drum's springs while it is flat, and their damping by stiffness [s].
const DRUM_STRETCH: f64 = 1.05;
const DRUM_DAMPING: f64 = 2e-5;
/// Height and radius of the bump [m].
const BUMP_HEIGHT: f64 = 0.05;
const BUMP_RADIUS: f64 = 0.45;
/// The chain: links, length [m], mass of a node [kg].
const CHAIN_LINKS: u32 = 100;
const CHAIN_LENGTH: f64 = 2.0;
const CHAIN_NODE: f64 = 0.005;
