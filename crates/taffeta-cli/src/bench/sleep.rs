//! The bench on sleep: many sheets that all move, of which one moves, and of which none does.

use super::measure::{self, Bench};
use super::{Args, print, start};
use crate::run::{Device, Work};
use taffeta::scene::{Keyframe, Scene, Sleep};
use taffeta_io::program::Failure;

/// A frame and its longest sub-step [s].
const TIME: (f64, f64) = (1.0 / 60.0, 5.6e-4);
/// Frames until sheets that nothing moves are asleep.
const SETTLED: u32 = 600;
/// Half the time in which a sheet that is moved swings once [s], and how far [m].
const SWING: (f64, f64) = (0.5, 0.1);

/// The sheets, which air would slow down.
fn sheets(case: &'static str, sleep: bool, swings: usize) -> Bench {
    let mut scene = Scene { sleep: sleep.then(Sleep::default), ..start::sheets().time(TIME.0, TIME.1) };
    scene.world.drag = 1e-3;
    for body in scene.bodies.iter_mut().take(swings) {
        let key = |number: u32| {
            let shift = if number % 2 == 1 { SWING.1 } else { 0.0 };
            Keyframe::translate(SWING.0 * f64::from(number), [0.0, 0.0, shift])
        };
        body.pins[0].motion = (0..200).map(key).collect();
    }
    Bench { case: Some(case), settle: SETTLED, most: 300, ..Bench::new("sleep", vec![100, 20, 20], scene) }
}

/// What is measured, one after the other.
pub fn benches() -> [Bench; 4] {
    [
        sheets("no sleep", false, 0),
        sheets("all awake", true, 100),
        sheets("one awake", true, 1),
        sheets("all asleep", true, 0),
    ]
}

/// Prints a line for each case.
pub fn run(args: &Args) -> Result<(), Failure> {
    for mut bench in benches() {
        let work = || Work::of(&bench.scene, args.threads, args.precision.precision());
        let device = Device::asked(args.backend, work)?;
        bench.notes.extend(device.why);
        print(&measure::run(&bench, args, device.gpu.as_ref())?, args)?;
    }
    Ok(())
}
