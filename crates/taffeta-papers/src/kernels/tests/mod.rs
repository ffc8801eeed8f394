//! Records as the sources have them, what a device must allow, and whole scenes.

mod explicit;
mod implicit;

use crate::kernels::constraint::Triplet;
use crate::kernels::node_centric::Sheet;
use crate::kernels::spring_centric::Spring;
use crate::kernels::volume::{KeptBody, KeptTriangle};
use crate::kernels::{GROUP, SHADERS, fits};
use std::sync::LazyLock;
use taffeta::extension::{Kernels, Name, Overrides, shaders};
use taffeta::scene::Scene;
use taffeta::taffeta_gpu::{Choice, Gpu, wgpu};
use taffeta::{GpuOptions, Options, Simulation};

/// A vector: [m], [m/s] or [N].
type V = [f64; 3];

fn sub(a: V, b: V) -> V {
    std::array::from_fn(|i| a[i] - b[i])
}

fn norm(a: V) -> f64 {
    a.iter().map(|c| c * c).sum::<f64>().sqrt()
}

fn farthest(a: &[V], b: &[V]) -> f64 {
    assert_eq!(a.len(), b.len());
    a.iter().zip(b).map(|(&p, &q)| norm(sub(p, q))).fold(0.0, f64::max)
}

/// A scene without gravity.
fn weightless(title: &str, dt: f64, max_step: f64) -> Scene {
    let mut scene = Scene::new(title).time(dt, max_step);
    scene.world.gravity = [0.0; 3];
    scene
}

/// The device that tests share.
pub fn gpu() -> Gpu {
    static SHARED: LazyLock<Gpu> =
        LazyLock::new(|| Gpu::open(&Choice::from_env()).unwrap_or_else(|error| panic!("{error}")));
    SHARED.clone()
}

fn on(scene: &Scene, gpu: GpuOptions) -> Result<Simulation, String> {
    let options = Options { gpu: Some(gpu), ..Options::default() };
    Simulation::new(scene, &options).map_err(|error| error.to_string())
}

fn run(simulation: &mut Simulation, frames: u32) {
    (0..frames).for_each(|_| drop(simulation.step().unwrap().clone()));
}

fn positions(simulation: &Simulation) -> Vec<V> {
    let mut positions = Vec::new();
    simulation.positions_f64(&mut positions);
    positions
}

#[test]
fn records_and_groups_are_as_large_as_the_sources_say() {
    let kernels = Kernels::new(gpu(), shaders().with(SHADERS.iter().copied()));
    let entries = [
        "node_centric_forces",
        "node_centric_update",
        "spring_centric_forces",
        "compute_volume",
        "compute_jacobian",
        "build_system",
        "accumulate_force",
        "spring_centric_update",
        "compute_phi",
        "compute_vect",
        "compute_rhs",
        "spmm",
        "initial_step",
        "spmv",
        "compute_alpha",
        "update_lambda",
        "compute_beta",
        "update_p",
        "compute_force",
    ];
    let mut sizes = Vec::new();
    for kernel in entries.map(|entry| kernels.get(Name::new(entry), &Overrides::new()).unwrap()) {
        assert_eq!(kernel.workgroup_size().iter().product::<u32>() as usize, GROUP);
        sizes.extend(kernel.bindings().iter().map(|binding| (binding.name.clone(), binding.size)));
    }
    let records = [
        ("sheet", size_of::<Sheet>()),
        ("springs", size_of::<Spring>()),
        ("spring_kinds", 8),
        ("kept_triangles", size_of::<KeptTriangle>()),
        ("kept_bodies", size_of::<KeptBody>()),
        ("printed_sys", size_of::<Triplet>()),
    ];
    for (name, size) in records {
        let found = sizes.iter().find(|(other, _)| other == name);
        assert_eq!(found, Some(&(name.to_owned(), size as u64)));
    }
}

#[test]
fn a_device_with_small_workgroups_is_refused_with_the_numbers() {
    let why = fits("the kernels", &wgpu::Limits::default()).unwrap_err();
    assert!(why.contains("1024 invocations, and this GPU allows 256"), "{why}");
    let large = wgpu::Limits {
        max_compute_invocations_per_workgroup: 1024,
        max_compute_workgroup_size_x: 1024,
        ..wgpu::Limits::default()
    };
    assert_eq!(fits("the kernels", &large), Ok(()));
}
