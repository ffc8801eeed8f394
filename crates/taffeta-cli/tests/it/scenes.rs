//! Every scene for some frames on the CPU, then for two on the CPU and on the GPU, and the distance of the two.

use std::path::Path;
use std::sync::LazyLock;
use taffeta::scene::Scene;
use taffeta::taffeta_gpu::{Choice, Gpu};
use taffeta::{Options, Simulation};

/// Frames on the CPU alone: then colliders hold nodes in a third of the scenes, and nodes of `heap` touch.
const BEFORE: u32 = 10;
/// Frames on both.
const TOGETHER: u32 = 2;

/// Farthest that a vertex may be on the GPU from its place on the CPU after these frames [m], in scenes of a metre; ten times
/// as far of cloth so stiff that the last digits of places are forces which fold it. Rounding of 1e-7 m grows a
/// hundredfold at most in that time; a wrong force is seen at once. Hardware rounds otherwise in every operation, software
/// only in sums.
fn bound(name: &str) -> f64 {
    let bound = if is_primal(name) { 1e-4 } else { 1e-5 };
    if GPU.info().is_software() { bound } else { 10.0 * bound }
}

static GPU: LazyLock<Gpu> =
    LazyLock::new(|| Gpu::open(&Choice::from_env()).unwrap_or_else(|error| panic!("{error}")));

macro_rules! scenes {
    ($($name:ident)*) => {
        $(#[test] fn $name() { both(stringify!($name)); })*
        const NAMES: &[&str] = &[$(stringify!($name)),*];
    };
}

scenes! {
    balloon bunny chain curtain curtain_tethers drape fall_armadillo fall_bunny fall_dragon fall_sphere fall_torus flag
    flag_gusts flag_primal hanging hanging_ice hanging_primal heap incline pile poke press_armadillo press_bunny s1_fig11
    s1_fig12 s1_fig13 s1_fig14 s1_fig15 s2_demo sewn shirt_jacket skirt tights torn trampoline tshirt twist_pins twist_torque
}

#[test]
fn every_scene_is_tested_by_its_name() {
    let entries = std::fs::read_dir(folder()).expect("the scenes");
    let mut names: Vec<_> = entries
        .map(|entry| entry.expect("an entry").path())
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .map(|path| path.file_stem().expect("a name").to_string_lossy().into_owned())
        .collect();
    names.sort();
    assert_eq!(names, NAMES);
}

fn folder() -> std::path::PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../scenes")
}

/// A scene with its stand-ins in place of models: garments that start half inside a body depend on the last digit.
fn load(name: &str) -> Scene {
    let text = std::fs::read_to_string(folder().join(name).with_extension("toml")).expect("a scene");
    let copy = tempfile::tempdir().expect("a folder");
    let file = copy.path().join("scene.toml");
    std::fs::write(&file, text.replace("mesh.file = \"", "mesh.file = \"no_")).expect("a copy");
    // Of springs solved for by nodes solutions are compared, not how far each backend's are from them.
    let sets = is_primal(name).then(|| "solver.ice.tolerance=1e-6".to_owned());
    let loaded = taffeta_io::load_scene(&file, sets.as_slice());
    loaded.unwrap_or_else(|error| panic!("{name}: {error}")).scene
}

fn is_primal(name: &str) -> bool {
    name.ends_with("_primal")
}

fn built(name: &str, scene: &Scene, options: &Options) -> Simulation {
    Simulation::new(scene, options).unwrap_or_else(|error| panic!("{name}: {error}"))
}

/// Positions some frames later [m].
fn after(name: &str, frames: u32, simulation: &mut Simulation) -> Vec<[f64; 3]> {
    simulation.advance(frames).unwrap_or_else(|error| panic!("{name}: {error}"));
    simulation.fetch().unwrap_or_else(|error| panic!("{name}: {error}"));
    let mut positions = Vec::new();
    simulation.positions_f64(&mut positions);
    positions
}

/// A scene on both backends.
fn both(name: &str) {
    let scene = load(name);
    let mut cpu = built(name, &scene, &Options { threads: Some(1), ..Options::default() });
    after(name, BEFORE, &mut cpu);
    let mut gpu = built(name, &scene, &Options { gpu: Some(GPU.clone().into()), ..Options::default() });
    gpu.restore(&cpu.snapshot()).unwrap_or_else(|error| panic!("{name}: {error}"));
    let [cpu, gpu] = [&mut cpu, &mut gpu].map(|simulation| after(name, TOGETHER, simulation));
    let bound = bound(name);
    let (vertex, apart) = farthest(&cpu, &gpu);
    println!("{name}: at most {apart:.1e} m between CPU and GPU");
    assert!(
        apart <= bound,
        "{name}: vertex {vertex} is {apart:.3e} m from its place on the CPU after {TOGETHER} frames on the GPU; {bound:e} m \
         are allowed"
    );
}

/// The vertex that is farthest from its place, and how far [m]. What is no number is infinitely far.
fn farthest(cpu: &[[f64; 3]], gpu: &[[f64; 3]]) -> (usize, f64) {
    assert_eq!(cpu.len(), gpu.len());
    let distance = |(p, q): (&[f64; 3], &[f64; 3])| {
        let apart = (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f64>().sqrt();
        if apart.is_finite() { apart } else { f64::INFINITY }
    };
    let distances = cpu.iter().zip(gpu).map(distance).enumerate();
    distances.fold((0, 0.0), |most, one| if one.1 > most.1 { one } else { most })
}

#[test]
fn the_farthest_vertex_is_found_and_what_is_no_number_is_farther() {
    let a = [[0.0; 3], [1.0; 3], [2.0; 3]];
    assert_eq!(farthest(&a, &a), (0, 0.0));
    assert_eq!(farthest(&a, &[[0.0; 3], [1.0, 1.5, 1.0], [2.0; 3]]), (1, 0.5));
    let nan = [[0.0; 3], [1.0, 1.5, 1.0], [2.0, f64::NAN, 2.0]];
    assert_eq!(farthest(&a, &nan), (2, f64::INFINITY));
    assert_eq!(farthest(&nan, &nan), (2, f64::INFINITY));
}
