//! The device, its driver and its limits.

use serde::Serialize;
use taffeta::taffeta_gpu::Gpu;

/// A GPU in words and numbers.
#[derive(Serialize)]
pub struct Device {
    pub name: String,
    /// `discrete`, `integrated`, `virtual`, `unknown` or `software`.
    pub kind: String,
    pub api: String,
    pub driver: String,
    /// Whether kernels run on the CPU.
    pub software: bool,
    pub timestamps: bool,
    /// Operating system and architecture of the host.
    pub host: String,
    pub limits: Limits,
}

/// Limits that decide what fits and which kernels run.
#[derive(Serialize)]
pub struct Limits {
    pub storage_binding_bytes: u64,
    pub buffer_bytes: u64,
    pub storage_buffers_per_stage: u32,
    pub workgroup_invocations: u32,
    pub workgroup_bytes: u32,
    pub workgroups_per_dimension: u32,
}

impl Device {
    /// That of an open GPU.
    pub fn of(gpu: &Gpu) -> Self {
        let (info, limits) = (gpu.info(), gpu.limits());
        Self {
            name: info.name.clone(),
            kind: info.kind.to_string(),
            api: info.api.clone(),
            driver: info.driver.clone(),
            software: info.is_software(),
            timestamps: gpu.has_timestamps(),
            host: format!("{}, {}", std::env::consts::OS, std::env::consts::ARCH),
            limits: Limits {
                storage_binding_bytes: limits.max_storage_buffer_binding_size,
                buffer_bytes: limits.max_buffer_size,
                storage_buffers_per_stage: limits.max_storage_buffers_per_shader_stage,
                workgroup_invocations: limits.max_compute_invocations_per_workgroup,
                workgroup_bytes: limits.max_compute_workgroup_storage_size,
                workgroups_per_dimension: limits.max_compute_workgroups_per_dimension,
            },
        }
    }
}
