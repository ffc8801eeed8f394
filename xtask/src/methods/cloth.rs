//! The cloth that swings.
//!
//! A square of 1 m and 0.2 kg hangs from its upper edge, flat and at rest length, and swings out: each node has the speed that a
//! turn about this edge at 3 rad/s gives it, 5 % more at one side and less at the other. A rigid plate would swing to 46°. The
//! sheet stays taut, for slack cloth folds at random, and no two steps agree for long; the difference of sides excites waves of
//! all directions.
//!
//! The springs of a grid stand for the same membrane however fine it is: with k [N/m] of all three kinds, tensions by
//! strains are C₁₁ = 6 k (structural k, shear k, bend 4 k), C₁₂ = k and C₆₆ = k. Resistance to folds, which bend springs have
//! as well, vanishes with the spacing.

use super::cell::{Cell, FRAME};
use super::way::Way;
use taffeta::scene::{Body, Mass, Mesh, Rotation, Scene, Select};
use taffeta::{Options, Precision, Simulation};

/// Length of an edge [m].
const EDGE: f64 = 1.0;
/// Mass of the sheet [kg].
const MASS: f64 = 0.2;
/// Rate of the turn [rad/s].
const TURN: f64 = 3.0;
/// How much faster one side is than the middle.
const FASTER: f64 = 0.05;

/// The scene of a cell, at rest.
pub fn scene(cell: &Cell, way: Way, steps: u32) -> Scene {
    let side = cell.size.side;
    let mut sheet = Body::cloth("sheet", Mesh::grid(side, side, [EDGE; 2]))
        .with_mass(Mass::Whole(MASS))
        .at([0.0, -EDGE / 2.0, 0.0])
        .structural(cell.k, 0.0)
        .shear(cell.k, 0.0)
        .bend(cell.k, 0.0)
        .pin(Select::rows(0, 0));
    sheet.place.rotation = Some(Rotation { axis: [1.0, 0.0, 0.0], degrees: 90.0 });
    let mut scene = Scene::new("Swinging sheet").time(FRAME, FRAME / f64::from(steps)).body(sheet);
    scene.solver = way.solver();
    scene
}

/// Velocity [m/s] at a place [m] of the sheet at rest.
fn velocity([x, y, _]: [f64; 3]) -> [f64; 3] {
    let side = (std::f64::consts::PI * (x / EDGE + 0.5)).cos();
    [0.0, 0.0, -TURN * y * (1.0 + FASTER * side)]
}

/// The scene as it swings out. With `second_order` the velocities are those of half a step before the start, which makes
/// symplectic Euler the method of Störmer and Verlet: places are exact to second order then. Springs pull nowhere at the start,
/// so gravity is all that acts in this half step.
///
/// # Errors
/// What the scene's own check says.
pub fn swinging(scene: &Scene, precision: Precision, second_order: bool) -> Result<Simulation, String> {
    let options = Options { precision, ..Options::default() };
    let mut simulation = Simulation::new(scene, &options).map_err(|error| error.to_string())?;
    let half = if second_order { 0.5 * scene.time.substep(0).1 } else { 0.0 };
    let mut places = Vec::new();
    simulation.positions_f64(&mut places);
    let mut snapshot = simulation.snapshot();
    let mut bytes = Vec::with_capacity(snapshot.state.len() / 2);
    let mut held = snapshot.held.iter().peekable();
    for (node, &place) in (0..).zip(&places) {
        let at_rest = held.next_if_eq(&&node).is_some();
        let (v, gravity) = (velocity(place), scene.world.gravity);
        (0..3).for_each(|axis| {
            let speed = if at_rest { 0.0 } else { v[axis] - half * gravity[axis] };
            append(&mut bytes, precision, speed);
        });
    }
    let first = snapshot.state.len() - bytes.len();
    snapshot.state[first..].copy_from_slice(&bytes);
    simulation.restore(&snapshot)?;
    // Moves nothing; but energies are counted from here on.
    simulation.disturb(0.0, 0);
    Ok(simulation)
}

fn append(bytes: &mut Vec<u8>, precision: Precision, number: f64) {
    match precision {
        Precision::F32 => bytes.extend((number as f32).to_le_bytes()),
        Precision::F64 => bytes.extend(number.to_le_bytes()),
    }
}

/// The fewest sub-steps in a frame with which explicit springs hold, with a twentieth to spare.
///
/// # Errors
/// As [`swinging`].
pub fn fewest_steps(cell: &Cell) -> Result<u32, String> {
    let still = Simulation::new(&scene(cell, Way::Springs, 1), &Options::default());
    let largest = still.map_err(|error| error.to_string())?.largest_stable_step();
    Ok((FRAME / (0.95 * largest)).ceil() as u32)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::methods::cell::{SIZES, Size};

    #[test]
    fn energy_of_the_start_is_that_of_the_turn_and_held_nodes_stand_still() {
        let cell = Cell { size: SIZES[0], k: 1e3 };
        let start = swinging(&scene(&cell, Way::Springs, 100), Precision::F64, false);
        let report = start.map(|simulation| simulation.report().clone()).unwrap_or_default();
        // ½ m ω² L²/3 (1 + ½ 5 %²), up to the lumping of masses.
        let exact = 0.5 * MASS * TURN.powi(2) / 3.0 * (1.0 + 0.5 * FASTER.powi(2));
        assert!((report.kinetic / exact - 1.0).abs() < 2e-3, "{} and {exact}", report.kinetic);
        assert!(report.frame == 0 && (report.max_stretch - 1.0).abs() < 1e-12 && report.springs < 1e-12);
        assert_eq!(report.momentum[1], 0.0);
    }

    #[test]
    fn a_start_half_a_step_early_makes_places_exact_to_second_order() {
        let cell = Cell { size: Size { side: 6, ..SIZES[0] }, k: 1e2 };
        let place = |steps, second_order| {
            let mut start =
                swinging(&scene(&cell, Way::Springs, steps), Precision::F64, second_order).ok()?;
            start.advance(3).ok()?;
            let mut places = Vec::new();
            start.positions_f64(&mut places);
            places.last().map(|place| place[1])
        };
        let ratio = |second_order| {
            let [a, b, c] = [100, 200, 400].map(|steps| place(steps, second_order).unwrap_or(f64::NAN));
            (a - b) / (b - c)
        };
        assert!((ratio(true) - 4.0).abs() < 0.1, "{}", ratio(true));
        assert!((ratio(false) - 2.0).abs() < 0.2, "{}", ratio(false));
    }
}
