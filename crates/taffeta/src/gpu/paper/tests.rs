//! Records as the sources have them, and what a device must allow.

use crate::gpu::kernels::{Kernels, Name, Sizes};
use crate::gpu::paper::constraint::Triplet;
use crate::gpu::paper::node_centric::Sheet;
use crate::gpu::paper::spring_centric::Spring;
use crate::gpu::paper::volume::{KeptBody, KeptTriangle};
use crate::gpu::paper::{GROUP, fits};
use taffeta_gpu::{Choice, Gpu, wgpu};

const SIZES: Sizes = Sizes { kinds: 1, room: 1, steps: 1 };

#[test]
fn records_and_groups_are_as_large_as_the_sources_say() {
    let gpu = Gpu::open(&Choice::from_env()).unwrap_or_else(|error| panic!("{error}"));
    let mut kernels = Kernels::new(gpu);
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
    for kernel in entries.map(|entry| kernels.get(Name::new(entry), SIZES).unwrap()) {
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
