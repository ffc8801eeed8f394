//! The bench on adaptive constraints: what they cost beside springs alone, by how many of them are active.

use super::ice::{STEP, drop, sheet};
use super::measure::{self, Bench};
use super::{Args, print};
use crate::run::{Device, Work};
use taffeta::scene::{Method, Rotation, Scene, Select};
use taffeta_io::program::Failure;

/// Of each node [kg], and of all springs [N/m], as in S1's figure 15.
const MATERIAL: (f64, f64) = (0.15, 200.0);
/// Gravity on a sheet of so many rows that hangs [m/s²]: its upper springs are 4 to 6 % too long then. One of more rows has
/// less.
const PULL: (f64, f64) = (0.5, 34.0);
/// Drag on each node [kg/s], and frames after which the hanging sheet is at rest.
const REST: (f64, u32) = (0.5, 300);
/// Beyond which lengths springs become constraints in the hanging sheet: none of them, about one in a hundred, one in ten.
const THRESHOLDS: [f64; 3] = [0.1, 0.045, 0.0346];

/// A sheet that hangs from its first row, by springs alone.
pub fn bench(sides: [u32; 2]) -> Bench {
    let mut hanging = sheet(sides, MATERIAL).pin(Select { rows: Some([0, 0]), ..Select::default() });
    hanging.place.rotation = Some(Rotation { axis: [1.0, 0.0, 0.0], degrees: 90.0 });
    let mut scene = Scene::new("bench acad").body(hanging).time(STEP, STEP);
    scene.world.gravity = [0.0, -PULL.0 * PULL.1 / f64::from(sides[0]), 0.0];
    scene.world.drag = REST.0;
    Bench { settle: REST.1, case: Some("hanging"), ..Bench::new("acad", sides.to_vec(), scene) }
}

/// The same with adaptive constraints for springs beyond a length, at which they are held, and below which they are springs
/// again: what was too long while the sheet came to rest does not count.
fn adaptive(bench: &Bench, threshold: f64) -> Bench {
    let mut bench = bench.clone();
    bench.scene.solver.method = Method::Acad;
    let acad = &mut bench.scene.solver.acad;
    (acad.threshold, acad.target, acad.release) = (threshold, threshold, threshold);
    bench
}

/// Prints a line for springs alone, one for each share of active ones, and one for S1's drop.
pub fn run(args: &Args, springs: &Bench) -> Result<(), Failure> {
    let work = || Work::of(&springs.scene, args.threads, args.precision.precision());
    let device = Device::asked(args.backend, work)?;
    let springs = &Bench { notes: device.why.into_iter().collect(), ..springs.clone() };
    let timed = |bench: &Bench| measure::run(bench, args, device.gpu.as_ref());
    let alone = timed(springs)?;
    let of_springs = alone.ms_per_frame.median;
    print(&alone, args)?;
    for threshold in THRESHOLDS {
        let mut line = timed(&adaptive(springs, threshold))?;
        line.over_springs = Some(line.ms_per_frame.median / of_springs);
        print(&line, args)?;
    }
    let mut falling = drop("acad", [springs.n[0], springs.n[1]], MATERIAL);
    falling.scene.solver.method = Method::Acad;
    falling.case = Some("drop");
    print(&timed(&falling)?, args)
}
