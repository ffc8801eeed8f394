//! The air of each sub-step, in its record.

use crate::gpu::feature::{Feature, Upload};
use crate::gpu::layout::Air;
use crate::gpu::layout::Substep;
use taffeta_gpu::{Bindable, GpuError};

/// Brings what changes from one sub-step to the next; triangles are [`crate::elements::gpu::Elements`].
pub struct AirOfSubsteps;

impl Feature for AirOfSubsteps {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        Vec::new()
    }

    fn upload(&mut self, upload: &Upload<'_>, records: &mut [Substep]) -> Result<bool, GpuError> {
        for (record, substep) in records.iter_mut().zip(upload.substeps) {
            record.air = Air::of(substep.air());
        }
        Ok(false)
    }
}
