//! Whole scenes on the GPU against the same scenes on the CPU, and against themselves.

use super::guard::guarded;
use crate::bench::kernels;
use serde::Serialize;
use taffeta::scene::{
    Body, Collider, ConstraintForm, Icosphere, Mass, Material, Mesh, Method, Place, Rotation, Scene, Select,
    Volume, VolumeForm, VolumeWeights,
};
use taffeta::taffeta_gpu::Gpu;
use taffeta::{GpuKernels, GpuOptions, Options, Precision, Simulation};

/// Farthest that a vertex may be from where the CPU has it [m], in scenes of a metre: rounding that a driver does its
/// own way has grown for some hundred sub-steps by then, a wrong force is seen within a few.
const BOUND: f64 = 1e-4;
/// How many times as far as 64 bits lead from 32 on the CPU, where that is more: such scenes make much of any rounding.
const ROUNDING: f64 = 8.0;

/// A scene on both.
#[derive(Serialize)]
pub struct Compared {
    pub name: String,
    pub kernels: &'static str,
    pub frames: u32,
    /// Largest distance of a vertex from where the CPU has it [m].
    pub apart: Option<f64>,
    /// That vertex.
    pub vertex: Option<usize>,
    /// The largest distance that is allowed [m].
    pub allowed: f64,
    /// Whether a second run ended in the same bits.
    pub same_twice: bool,
    pub passed: bool,
    /// Why it could not be run.
    pub error: Option<String>,
}

/// A scene, and which of our kernels run it for how many frames.
pub struct Check {
    pub scene: Scene,
    pub kernels: GpuKernels,
    frames: u32,
}

/// All checks: each scene by every choice of our kernels that treats it differently. Where time is short, of fewer frames.
pub fn checks(small: bool) -> Vec<Check> {
    let check = |scene: fn() -> Scene, frames: u32| {
        let frames = if small { frames.div_ceil(4) } else { frames };
        move |kernels| Check { scene: scene(), kernels, frames }
    };
    let [single, several] = [GpuKernels::Plain, GpuKernels::Best];
    let flags = [single, several, GpuKernels::Tiled].map(check(flag, 20));
    let others =
        [single, several].map(check(drape, 20)).into_iter().chain([single, several].map(check(hinged, 20)));
    let alone = [check(kept, 20)(several), check(touching, 10)(several)];
    let surfaces = [check(surfaces, 8)(several), check(fabrics, 8)(several)];
    flags.into_iter().chain(others).chain(alone).chain(surfaces).collect()
}

fn sheet(rows: u32, cols: u32, size: [f64; 2]) -> Body {
    Body::cloth("sheet", Mesh::grid(rows, cols, size))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .shear(20.0, 0.02)
        .bend(5.0, 0.02)
}

fn flag() -> Scene {
    let mut scene = Scene::new("flag").time(1.0 / 60.0, 1e-3);
    scene.world.drag = 1e-3;
    scene.world.wind_force = [2e-2, 0.0, 1e-2];
    scene.body(sheet(20, 30, [1.5, 1.0]).pin(Select::nodes([0, 29])))
}

fn drape() -> Scene {
    let ball = Collider::sphere([0.0; 3], 0.3).friction(0.3);
    Scene::new("drape on a ball")
        .body(sheet(40, 40, [1.0, 1.0]).at([0.0, 0.31, 0.0]))
        .collider(ball)
        .time(1.0 / 60.0, 1e-3)
}

fn hinged() -> Scene {
    let ball = Body::cloth("ball", Mesh::Icosphere(Icosphere { radius: 0.3, subdivisions: 3 }))
        .with_mass(Mass::Node(0.01))
        .structural(50.0, 0.02)
        .hinge(1e-3, 1e-5)
        .at([0.0, 0.4, 0.0]);
    let slope = Collider::plane([0.0; 3], [0.1, 1.0, 0.0]);
    Scene::new("mesh with hinges").body(ball).collider(slope).time(1.0 / 60.0, 1e-3)
}

/// Soft balls that keep their volume by forces, by moving nodes, and where they give way alone.
fn kept() -> Scene {
    let ball = |name: &str, x: f64, volume| {
        let ball = Body::soft(name, Mesh::Icosphere(Icosphere { radius: 0.2, subdivisions: 3 }))
            .with_mass(Mass::Volume(30.0))
            .structural(60.0, 0.05)
            .at([x, 0.3, 0.0]);
        Body { volume: Some(volume), ..ball }
    };
    let form = |form| Volume { form, ..Volume::default() };
    let weights = VolumeWeights { center: [2.0, 0.4, 0.0], radius: 0.3 };
    Scene::new("soft balls")
        .body(ball("forces", 0.0, form(VolumeForm::Corrected)))
        .body(ball("projected", 1.0, form(VolumeForm::Projected)))
        .body(ball("weighted", 2.0, Volume { weights: Some(weights), ..form(VolumeForm::Corrected) }))
        .collider(Collider::plane([0.0; 3], [0.02, 1.0, 0.0]).friction(0.3))
        .time(1.0 / 60.0, 1e-3)
}

/// A sheet that falls onto one that is held at its edges.
fn touching() -> Scene {
    let low = sheet(24, 24, [0.6, 0.6]).collide_nodes(0.03);
    let high = Body { name: "high".to_owned(), ..sheet(20, 20, [0.45, 0.45]) }.collide_nodes(0.025);
    Scene::new("sheets that touch")
        .body(low.pin(Select::cols(0, 0)).pin(Select::cols(23, 23)))
        .body(high.at([0.007, 0.03, 0.011]))
        .time(1.0 / 60.0, 1e-3)
}

/// The place of a sheet just above another, turned so that no edges lie along each other: rounding would choose between them.
fn turned(height: f64) -> Place {
    let rotation = Some(Rotation { axis: [0.1, 1.0, 0.0], degrees: 17.0 });
    Place { position: [0.0, height, 0.01], rotation, ..Place::default() }
}

/// The triangles of a sheet that falls onto one that is held, and both onto the edges of a box.
fn surfaces() -> Scene {
    let low = sheet(9, 9, [0.4, 0.4]).collide(0.01).pin(Select::cols(0, 0)).pin(Select::cols(8, 8));
    let high = Body { name: "high".to_owned(), place: turned(0.028), ..sheet(8, 8, [0.3, 0.3]) };
    Scene::new("triangles that touch")
        .body(low)
        .body(high.collide(0.01))
        .collider(Collider::cuboid([0.03, -0.06, 0.02], [0.05, 0.04, 0.04]))
        .time(1.0 / 60.0, 2e-3)
}

/// Two fabrics whose forces and contacts are one system of equations.
fn fabrics() -> Scene {
    let fabric = |name: &str, nodes: u32, side: f64, preset: &str| {
        let material = Material::preset(preset);
        Body::cloth(name, Mesh::grid(nodes, nodes, [side, side])).with_material(material).collide(0.004)
    };
    let held = fabric("held", 9, 0.2, "cotton").pin(Select::cols(0, 0)).pin(Select::cols(8, 8));
    let loose = Body { place: turned(0.011), ..fabric("loose", 10, 0.15, "jersey") };
    let scene = Scene::new("fabrics that touch").body(held).body(loose);
    let mut scene = scene.time(1.0 / 60.0, 1.0 / 240.0).method(Method::Ice);
    scene.solver.ice.form = ConstraintForm::Primal;
    scene.solver.ice.tolerance = 1e-6;
    scene
}

/// Runs a scene once on the CPU and twice on the GPU.
pub fn compare(check: &Check, gpu: &Gpu) -> Compared {
    let found = guarded(|| both(check, gpu));
    let mut compared = Compared {
        name: check.scene.title.clone(),
        kernels: kernels::name(check.kernels),
        frames: check.frames,
        apart: None,
        vertex: None,
        allowed: BOUND,
        same_twice: false,
        passed: false,
        error: None,
    };
    match found {
        Ok(Both { apart: (vertex, apart), by_rounding, same_twice }) => {
            compared.apart = Some(apart).filter(|apart| apart.is_finite());
            compared.vertex = Some(vertex).filter(|_| apart > 0.0);
            compared.allowed = BOUND.max(ROUNDING * by_rounding);
            compared.same_twice = same_twice;
            compared.passed = apart <= compared.allowed && same_twice;
        }
        Err(error) => compared.error = Some(error),
    }
    compared
}

/// What runs on both have shown.
struct Both {
    /// The vertex that is farthest from its place on the CPU, and how far that is [m].
    apart: (usize, f64),
    /// How far 64 bits lead from 32 on the CPU [m].
    by_rounding: f64,
    /// Whether two runs had the same bits.
    same_twice: bool,
}

fn both(check: &Check, gpu: &Gpu) -> Result<Both, String> {
    let options = GpuOptions { kernels: check.kernels, ..gpu.clone().into() };
    let on_gpu = Options { gpu: Some(options), ..Options::default() };
    let exact = Options { precision: Precision::F64, ..Options::default() };
    let run = |options: &Options| run(&check.scene, check.frames, options);
    let (cpu, exact) = (run(&Options::default())?, run(&exact)?);
    let (first, second) = (run(&on_gpu)?, run(&on_gpu)?);
    let by_rounding = farthest(&cpu.places, &exact.places).1;
    let same_twice = first.hash == second.hash;
    Ok(Both { apart: farthest(&cpu.places, &first.places), by_rounding, same_twice })
}

struct Ended {
    places: Vec<[f64; 3]>,
    hash: u64,
}

fn run(scene: &Scene, frames: u32, options: &Options) -> Result<Ended, String> {
    let mut simulation = Simulation::new(scene, options).map_err(|error| error.to_string())?;
    simulation.advance(frames).map_err(|error| error.to_string())?;
    simulation.fetch().map_err(|error| error.to_string())?;
    let mut places = Vec::new();
    simulation.positions_f64(&mut places);
    Ok(Ended { places, hash: simulation.state_hash() })
}

/// The index at which two lists of places are farthest apart, and how far [m]; no number counts as infinitely far.
fn farthest(a: &[[f64; 3]], b: &[[f64; 3]]) -> (usize, f64) {
    let distance = |(p, q): (&[f64; 3], &[f64; 3])| {
        let apart = (0..3).map(|axis| (p[axis] - q[axis]).powi(2)).sum::<f64>().sqrt();
        if apart.is_nan() { f64::INFINITY } else { apart }
    };
    let distances = a.iter().zip(b).map(distance).enumerate();
    distances.fold((0, 0.0), |most, one| if one.1 > most.1 { one } else { most })
}

#[cfg(test)]
mod tests {
    use super::{checks, farthest};
    use taffeta::{Options, Simulation};

    #[test]
    fn what_is_there_for_contact_touches() {
        for check in checks(false).iter().filter(|check| check.scene.title.contains("touch")) {
            let mut simulation = Simulation::new(&check.scene, &Options::default()).expect("a scene");
            let pairs = |_| simulation.advance(1).expect("a frame").pairs;
            assert!((0..check.frames).map(pairs).max() > Some(10), "{}", check.scene.title);
        }
    }

    #[test]
    fn what_is_no_number_is_farthest() {
        let a = [[0.0; 3], [1.0, 2.0, 3.0], [4.0; 3]];
        let mut b = a;
        assert_eq!(farthest(&a, &b), (0, 0.0));
        b[1][2] = 2.5;
        assert_eq!(farthest(&a, &b), (1, 0.5));
        b[2][0] = f64::NAN;
        assert_eq!(farthest(&a, &b), (2, f64::INFINITY));
    }
}
