//! Bevy's device as the engine takes it.

use bevy::ecs::system::SystemParam;
use bevy::prelude::*;
use bevy::render::renderer::{RenderAdapterInfo, RenderDevice, RenderQueue};
use taffeta::taffeta_gpu::Gpu;

/// Bevy's device in the engine's hands; nothing until a world has asked for it.
///
/// ```
/// use bevy::prelude::*;
/// use bevy_taffeta::SharedGpu;
///
/// fn tell(gpu: Res<SharedGpu>) {
///     if let Some(gpu) = gpu.get() {
///         info!("the GPU {} may hold bodies, in {} bytes so far", gpu.info(), gpu.memory_used());
///     }
/// }
/// ```
#[derive(Resource, Default, Debug)]
pub struct SharedGpu(Option<Gpu>);

impl SharedGpu {
    /// The device, if a world has asked for it.
    pub fn get(&self) -> Option<&Gpu> {
        self.0.as_ref()
    }
}

/// What it takes to share Bevy's device.
#[derive(SystemParam)]
pub struct Device<'w> {
    shared: ResMut<'w, SharedGpu>,
    device: Option<Res<'w, RenderDevice>>,
    queue: Option<Res<'w, RenderQueue>>,
    info: Option<Res<'w, RenderAdapterInfo>>,
}

impl Device<'_> {
    /// The device, where Bevy has one.
    pub fn gpu(&mut self) -> Option<Gpu> {
        if self.shared.0.is_none()
            && let (Some(device), Some(queue), Some(info)) = (&self.device, &self.queue, &self.info)
        {
            let (device, queue) = (device.wgpu_device().clone(), (**queue.0).clone());
            self.shared.0 = Some(Gpu::on(device, queue, (*info.0).clone()));
        }
        self.shared.0.clone()
    }
}
