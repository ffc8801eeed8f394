//! What the tests share: vectors, runs in 64 bits, and a reference to compare with.

pub mod alike;
pub mod compare;
pub mod constraints;
pub mod levels;
pub mod lists;
pub mod plates;
pub mod primal;
pub mod reference;
pub mod second_order;
pub mod settled;
pub mod state;

use std::sync::LazyLock;
use taffeta::scene::{Place, Rotation, Scene, SceneError};
use taffeta::taffeta_gpu::{Choice, Gpu};
use taffeta::topology::Surface;
use taffeta::{BuildError, Options, Precision, Simulation};

/// A vector: [m], [m/s] or [N].
pub type V = [f64; 3];

pub fn add(a: V, b: V) -> V {
    std::array::from_fn(|i| a[i] + b[i])
}

pub fn sub(a: V, b: V) -> V {
    std::array::from_fn(|i| a[i] - b[i])
}

pub fn scale(a: V, s: f64) -> V {
    a.map(|c| c * s)
}

pub fn dot(a: V, b: V) -> f64 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

pub fn cross(a: V, b: V) -> V {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

pub fn norm(a: V) -> f64 {
    dot(a, a).sqrt()
}

/// The GPU of `TAFFETA_ADAPTER`, else a software adapter, which gives the bits of the CPU, else the best: one device for all tests.
pub fn gpu() -> Gpu {
    static SHARED: LazyLock<Gpu> = LazyLock::new(own_gpu);
    SHARED.clone()
}

/// The same as a device of its own, for a test that loses it.
pub fn own_gpu() -> Gpu {
    let asked = Choice::from_env();
    let software = Some(Choice::Named("software".to_owned())).filter(|_| asked == Choice::BestOrSoftware);
    let gpu = software.and_then(|choice| Gpu::open(&choice).ok());
    gpu.unwrap_or_else(|| Gpu::open(&asked).unwrap_or_else(|error| panic!("{error}")))
}

/// A scene without gravity.
pub fn weightless(title: &str, dt: f64, max_step: f64) -> Scene {
    let mut scene = Scene::new(title).time(dt, max_step);
    scene.world.gravity = [0.0; 3];
    scene
}

/// A place turned about an axis and then shifted.
pub fn turned(axis: V, degrees: f64, position: V) -> Place {
    Place { position, rotation: Some(Rotation { axis, degrees }), ..Place::default() }
}

/// What is said before a scene runs, in words.
pub fn warnings(simulation: &Simulation) -> Vec<String> {
    simulation.warnings().iter().map(ToString::to_string).collect()
}

/// What is wrong with a scene that is not built.
pub fn scene_error<T>(built: Result<T, BuildError>) -> SceneError {
    match built.err().expect("refused") {
        BuildError::Scene(error) => error,
        error => panic!("not refused as a scene: {error}"),
    }
}

/// A scene that runs in 64 bits on one thread.
pub fn build(scene: &Scene) -> Simulation {
    build_as(scene, Precision::F64, 1)
}

pub fn build_as(scene: &Scene, precision: Precision, threads: usize) -> Simulation {
    let options =
        Options { threads: Some(threads), precision, find_largest_steps: true, ..Options::default() };
    Simulation::new(scene, &options).unwrap_or_else(|error| panic!("{}: {error}", scene.title))
}

/// Runs a number of frames.
pub fn run(simulation: &mut Simulation, frames: u32) {
    for _ in 0..frames {
        simulation.step().unwrap_or_else(|error| panic!("{error}"));
    }
}

/// The surface of a body, by its place in the scene.
pub fn surface(simulation: &Simulation, body: usize) -> Surface {
    simulation.surface(simulation.bodies()[body].handle).unwrap()
}

/// Unit normals of the vertices of a body, by its place in the scene.
pub fn normals(simulation: &Simulation, body: usize) -> Vec<[f32; 3]> {
    simulation.normals(simulation.bodies()[body].handle).unwrap()
}

/// Positions of all vertices [m].
pub fn positions(simulation: &Simulation) -> Vec<V> {
    let mut places = Vec::new();
    simulation.positions_f64(&mut places);
    places
}

/// The largest distance of two lists of points [m].
pub fn farthest(a: &[V], b: &[V]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(&p, &q)| norm(sub(p, q))).fold(0.0, f64::max)
}

/// Fails unless two numbers agree within `tolerance`.
#[track_caller]
pub fn near(what: &str, got: f64, expected: f64, tolerance: f64) {
    assert!((got - expected).abs() <= tolerance, "{what}: {got}, expected {expected} ± {tolerance:e}");
}
