//! The bench on implicit constraints: S1's drop.

use super::form::Form;
use super::measure::{self, Bench};
use super::{Args, print};
use crate::run::{Device, Work};
use taffeta::scene::{Body, Collider, ConstraintForm, Mass, Mesh, Method, Rotation, Scene, Select};
use taffeta_io::program::Failure;

/// Nodes of a side, where nothing is said: S1's 6,598 springs.
pub const SIDE: u32 = 34;
/// Sides of the sheet of so many nodes [m].
const EXTENT: f64 = 2.0;
/// A frame, which is one step [s].
pub const STEP: f64 = 0.016;
/// Of each node [kg], and of all springs [N/m].
const MATERIAL: (f64, f64) = (0.1, 2e4);
/// Damping of all springs [kg/s].
const DAMPING: f64 = 0.1;
/// Frames before the sheet lies on the ball, and frames from there on in which it slides over it.
const DROP: (u32, u32) = (20, 180);
/// Nodes of a side of the flag, where nothing is said.
pub const FLAG_SIDE: u32 = 100;
/// Of the flag: side [m], mass [kg], stiffness of all springs [N/m], step, which is a frame [s], and frames in which it
/// comes down.
const FLAG: (f64, f64, f64, f64, u32) = (1.0, 0.2, 1e5, 1.0 / 60.0, 60);

/// Of the flag on tethers: stiffness of structural, shear and bend springs [N/m]; damping [kg/s] and sub-steps a frame of 40 × 40 nodes.
const SOFT: [f64; 3] = [85.0, 21.0, 8.0];
const SOFT_DAMPING: f64 = 0.008;
const SOFT_STEPS: f64 = 34.0;

/// Of the flag on constraints: stiffness of structural, shear and bend springs [N/m].
const STIFF: [f64; 3] = [10_000.0, 100.0, 1.0];

/// A level sheet of `rows` × `cols` nodes of `mass` [kg], with springs of `k` [N/m].
pub fn sheet([rows, cols]: [u32; 2], (mass, k): (f64, f64)) -> Body {
    let extent = |nodes: u32| EXTENT * f64::from(nodes - 1) / f64::from(SIDE - 1);
    Body::cloth("sheet", Mesh::grid(rows, cols, [extent(cols), extent(rows)]))
        .with_mass(Mass::Node(mass))
        .structural(k, DAMPING)
        .shear(k, DAMPING)
        .bend(k, DAMPING)
}

/// S1's drop (figure 15): the sheet falls on a ball. Sheets of other sizes have its spacing, mass of a node and step.
pub fn drop(name: &'static str, sides: [u32; 2], material: (f64, f64)) -> Bench {
    let ball = Collider::sphere([0.0; 3], 0.5).offset(0.01).friction(0.3);
    let floor = Collider::plane([0.0, -0.5, 0.0], [0.0, 1.0, 0.0]).friction(0.3);
    let falling = sheet(sides, material).at([0.0, 0.55, 0.0]);
    let scene =
        Scene::new(format!("bench {name}")).body(falling).collider(ball).collider(floor).time(STEP, STEP);
    Bench { settle: DROP.0, most: DROP.1, ..Bench::new(name, sides.to_vec(), scene) }
}

/// The drop by implicit constraints.
pub fn bench(sides: [u32; 2]) -> Bench {
    let mut bench = drop("ice", sides, MATERIAL);
    bench.scene.solver.method = Method::Ice;
    bench
}

/// A sheet that hangs by two corners of its upper edge, lifted by an eighth of a turn at the start. By nodes, if nothing
/// else is said.
pub fn flag(sides: [u32; 2]) -> Bench {
    let (.., k, step, most) = FLAG;
    let body = hanging(sides, [k; 3], DAMPING);
    let mut scene = Scene::new("bench flag").body(body).time(step, step).method(Method::Ice);
    scene.solver.ice.form = ConstraintForm::Primal;
    Bench { most, ..Bench::new("flag", sides.to_vec(), scene) }
}

/// The same on explicit springs that are so soft that they need few sub-steps, and on tethers, which bear the load.
pub fn tethers(sides: [u32; 2]) -> Bench {
    let (.., step, most) = FLAG;
    let refined = f64::from(sides[0].max(sides[1])) / 40.0;
    let body = hanging(sides, SOFT, SOFT_DAMPING / (refined * refined)).tether(0.0);
    let scene = Scene::new("bench tethers").body(body).time(step, step / (SOFT_STEPS * refined).ceil());
    Bench { most, ..Bench::new("tethers", sides.to_vec(), scene) }
}

/// The same on constraints on positions, in four sub-steps a frame.
pub fn xpbd(sides: [u32; 2]) -> Bench {
    let (.., step, most) = FLAG;
    let body = hanging(sides, STIFF, 0.0);
    let scene = Scene::new("bench xpbd").body(body).time(step, step / 4.0).method(Method::Xpbd);
    Bench { most, ..Bench::new("xpbd", sides.to_vec(), scene) }
}

/// The sheet of all three, with structural, shear and bend springs of `k` [N/m] and damping [kg/s].
fn hanging([rows, cols]: [u32; 2], k: [f64; 3], damping: f64) -> Body {
    let (side, mass, ..) = FLAG;
    let mut body = Body::cloth("flag", Mesh::grid(rows, cols, [side; 2]))
        .with_mass(Mass::Whole(mass))
        .structural(k[0], damping)
        .shear(k[1], damping)
        .bend(k[2], damping)
        .pin(Select::nodes([0, cols - 1]));
    body.place.rotation = Some(Rotation { axis: [1.0, 0.0, 0.0], degrees: 45.0 });
    body
}

/// Prints a line for each form.
pub fn run(args: &Args, bench: &Bench) -> Result<(), Failure> {
    let usual = [Form::Ice(bench.scene.solver.ice.form)];
    for &form in args.form.as_deref().unwrap_or(&usual) {
        let mut bench = Bench { form: Some(form), ..bench.clone() };
        if let Form::Ice(form) = form {
            bench.scene.solver.ice.form = form;
        }
        let work = || Work::of(&bench.scene, args.threads, args.precision.precision());
        let device = Device::asked(args.backend, work)?;
        bench.notes = device.why.into_iter().collect();
        print(&measure::run(&bench, args, device.gpu.as_ref())?, args)?;
    }
    Ok(())
}
