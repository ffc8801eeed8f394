//! The scenes, each soft and stiff, and the steps that are taken on large ones.

use super::method::Method;
use super::rk4::{State, System};
use std::f64::consts::PI;
use std::hash::Hasher;
use taffeta::scene::{Body, Mass, Mesh, Rotation, Scene, Select};
use taffeta::{Options, Precision, Simulation, springs_of};
use twox_hash::XxHash64;

/// Length of a frame [s].
pub const FRAME: f64 = 1.0 / 60.0;
/// Nodes along an edge of a small sheet, and mass of such a node [kg].
const SIDE: u32 = 32;
const SHEET_NODE: f64 = 2e-4;
/// Mass of a large sheet [kg].
const SHEET: f64 = 0.2;

/// A scene with its stiffness.
#[derive(Debug)]
pub struct Case {
    /// What it is called in names of runs.
    pub name: &'static str,
    /// What the reader calls it.
    pub title: &'static str,
    shape: Shape,
    /// Nodes along an edge, of a sheet.
    side: u32,
    /// Stiffness of all springs [N/m].
    pub k: f64,
    /// Frames that are run.
    pub frames: u32,
    /// Sub-steps in a frame with which explicit springs hold, and with which the method of Runge and Kutta does: the fewest, with
    /// a twentieth to a tenth to spare.
    pub fewest: [u32; 2],
    /// The steps that are taken on a large sheet. It is compared with explicit springs, which cost less than the method of Runge
    /// and Kutta, and runs on as many threads as help.
    pub steps: Option<Steps>,
}

/// Steps of a sheet, where runs are dear.
#[derive(Clone, Copy, Debug)]
pub struct Steps {
    /// Of explicit springs, in multiples of the fewest that hold.
    pub springs: &'static [u32],
    /// Sub-steps in a frame of the dual form.
    pub dual: &'static [u32],
    /// The same, where it goes on until it is solved.
    pub solved: &'static [u32],
    /// Sub-steps in a frame of the primal form.
    pub primal: &'static [u32],
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Shape {
    Swing,
    Drum,
    Chain,
}

const fn small(name: &'static str, title: &'static str, shape: Shape, k: f64, fewest: [u32; 2]) -> Case {
    Case { name, title, shape, side: SIDE, k, frames: 30, fewest, steps: None }
}

/// Small scenes, which are compared with the method of Runge and Kutta.
pub const CASES: [Case; 6] = [
    small("swing-soft", "swing, 100 N/m", Shape::Swing, 1e2, [20, 15]),
    small("swing-stiff", "swing, 10,000 N/m", Shape::Swing, 1e4, [200, 140]),
    small("drum-soft", "drum, 30 N/m", Shape::Drum, 3e1, [12, 9]),
    small("drum-stiff", "drum, 300 N/m", Shape::Drum, 3e2, [36, 27]),
    small("chain-soft", "chain, 10,000 N/m", Shape::Chain, 1e4, [25, 18]),
    small("chain-stiff", "chain, 1,000,000 N/m", Shape::Chain, 1e6, [250, 170]),
];

/// Fewer frames are run where a reference costs more.
const fn sheet(
    name: &'static str,
    title: &'static str,
    k: f64,
    (side, frames, steps): (u32, u32, Steps),
    fewest: u32,
) -> Case {
    Case { name, title, shape: Shape::Swing, side, k, frames, fewest: [fewest, 0], steps: Some(steps) }
}

const OF_1K: (u32, u32, Steps) = (
    32,
    30,
    Steps {
        springs: &[1, 2, 4],
        dual: &[1, 2, 4, 8, 16, 32],
        solved: &[1, 2, 4],
        primal: &[1, 2, 4, 8, 16, 32],
    },
);
const OF_10K: (u32, u32, Steps) =
    (100, 30, Steps { springs: &[1, 2, 4], dual: &[1, 2, 4, 8], solved: &[1, 4], primal: &[1, 2, 4, 8, 16] });
const OF_100K: (u32, u32, Steps) =
    (316, 15, Steps { springs: &[1, 2], dual: &[1, 4], solved: &[], primal: &[1, 2, 4, 8] });
const OF_1M: (u32, u32, Steps) =
    (1000, 2, Steps { springs: &[1], dual: &[1, 2], solved: &[], primal: &[1, 2, 4] });

/// The sheet that swings, on finer and finer grids. The small one has the other two stiffnesses.
pub const SHEETS: [Case; 10] = [
    sheet("sheet-1k-1000", "1k nodes, 1,000 N/m", 1e3, OF_1K, 88),
    sheet("sheet-10k-100", "10k nodes, 100 N/m", 1e2, OF_10K, 89),
    sheet("sheet-10k-1000", "10k nodes, 1,000 N/m", 1e3, OF_10K, 279),
    sheet("sheet-10k-10000", "10k nodes, 10,000 N/m", 1e4, OF_10K, 883),
    sheet("sheet-100k-100", "100k nodes, 100 N/m", 1e2, OF_100K, 281),
    sheet("sheet-100k-1000", "100k nodes, 1,000 N/m", 1e3, OF_100K, 888),
    sheet("sheet-100k-10000", "100k nodes, 10,000 N/m", 1e4, OF_100K, 2807),
    sheet("sheet-1m-100", "1M nodes, 100 N/m", 1e2, OF_1M, 891),
    sheet("sheet-1m-1000", "1M nodes, 1,000 N/m", 1e3, OF_1M, 2815),
    sheet("sheet-1m-10000", "1M nodes, 10,000 N/m", 1e4, OF_1M, 8902),
];

impl Case {
    /// The one of that name.
    #[cfg(test)]
    pub fn named(name: &str) -> Option<&'static Self> {
        CASES.iter().find(|case| case.name == name)
    }

    /// The same for fewer frames.
    #[cfg(test)]
    pub fn shortened(&self, frames: u32) -> Self {
        Self { frames, ..*self }
    }

    /// Time that is run [s].
    pub fn seconds(&self) -> f64 {
        f64::from(self.frames) * FRAME
    }

    /// Whether it is a sheet that swings.
    pub fn swings(&self) -> bool {
        self.shape == Shape::Swing
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
        let mass = if self.steps.is_some() { Mass::Whole(SHEET) } else { Mass::Node(SHEET_NODE) };
        let sheet = Body::cloth("sheet", Mesh::grid(self.side, self.side, [1.0; 2])).with_mass(mass);
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
        self.started(method, steps, precision, false)
    }

    /// Explicit springs in 64 bits that are exact to second order in their places: their velocities are those of half a step
    /// before the start, which makes symplectic Euler the method of Störmer and Verlet. Springs pull nowhere at the start of a
    /// swing, so gravity is all that acts in this half step.
    ///
    /// # Errors
    /// What the scene's own check says.
    pub fn verlet(&self, steps: u32) -> Result<Simulation, String> {
        self.started(Method::Springs, steps, Precision::F64, true)
    }

    fn started(
        &self,
        method: Method,
        steps: u32,
        precision: Precision,
        half_a_step_early: bool,
    ) -> Result<Simulation, String> {
        let threads = if self.steps.is_some() { None } else { Some(1) };
        let options = Options { precision, threads, find_largest_steps: true, ..Options::default() };
        let scene = self.scene(method, steps);
        let mut simulation = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
        let mut snapshot = simulation.snapshot();
        let mut start = self.state(&simulation);
        if half_a_step_early {
            let half = 0.5 * scene.time.substep(0).1;
            for (v, held) in start.v.iter_mut().zip(held(&simulation)) {
                let pulled = if held { 0.0 } else { half };
                *v = std::array::from_fn(|axis| v[axis] - pulled * scene.world.gravity[axis]);
            }
        }
        let numbers = start.x.iter().chain(&start.v).flatten();
        snapshot.state = match precision {
            Precision::F32 => numbers.flat_map(|&number| (number as f32).to_le_bytes()).collect(),
            Precision::F64 => numbers.flat_map(|number| number.to_le_bytes()).collect(),
        };
        simulation.restore(&snapshot).map_err(|error| error.to_string())?;
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

    /// A hash of all that its motion depends on: the scene, and the start.
    ///
    /// # Errors
    /// What the scene's own check says.
    pub fn hash(&self) -> Result<String, String> {
        let scene = self.scene(Method::Springs, 1);
        let options = Options { precision: Precision::F64, ..Options::default() };
        let at_rest = Simulation::new(&scene, &options).map_err(|error| error.to_string())?;
        let State { x, v } = self.state(&at_rest);
        let mut hasher = XxHash64::with_seed(0);
        hasher.write(serde_json::to_string(&scene).map_err(|error| error.to_string())?.as_bytes());
        x.iter().chain(&v).flatten().for_each(|number| hasher.write(&number.to_le_bytes()));
        Ok(format!("{:016x}", hasher.finish()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn explicit_springs_take_the_fewest_steps_on_a_sheet_that_are_stable_with_a_twentieth_to_spare() {
        for case in SHEETS.iter().filter(|case| case.side <= 100) {
            let largest = case.simulation(Method::Springs, 1, Precision::F32).unwrap().largest_stable_step();
            assert_eq!((FRAME / (0.95 * largest)).ceil() as u32, case.fewest[0], "{}", case.name);
        }
    }

    #[test]
    fn energy_of_the_start_is_that_of_the_turn_and_held_nodes_stand_still() {
        let start = SHEETS[0].simulation(Method::Springs, 100, Precision::F64).unwrap();
        let report = start.report();
        // ½ m ω² L²/3 (1 + ½ 5 %²), up to the lumping of masses.
        let exact = 0.5 * SHEET * SWING_RATE.powi(2) / 3.0 * (1.0 + 0.5 * SWING_FASTER.powi(2));
        assert!((report.kinetic / exact - 1.0).abs() < 2e-3, "{} and {exact}", report.kinetic);
        assert!(report.frame == 0 && (report.max_stretch - 1.0).abs() < 1e-12 && report.springs < 1e-12);
        assert_eq!(report.momentum[1], 0.0);
    }

    #[test]
    fn a_start_half_a_step_early_makes_places_exact_to_second_order() {
        let case = Case { side: 6, ..sheet("", "", 1e2, OF_1K, 100) };
        let place = |steps, early| {
            let mut start = case.started(Method::Springs, steps, Precision::F64, early).unwrap();
            start.advance(3).unwrap();
            let mut places: Vec<[f64; 3]> = Vec::new();
            start.positions_f64(&mut places);
            places[places.len() - 1][1]
        };
        let ratio = |early| {
            let [a, b, c] = [100, 200, 400].map(|steps| place(steps, early));
            (a - b) / (b - c)
        };
        assert!((ratio(true) - 4.0).abs() < 0.1, "{}", ratio(true));
        assert!((ratio(false) - 2.0).abs() < 0.2, "{}", ratio(false));
    }
}
