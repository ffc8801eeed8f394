//! The strain of all fabric on the GPU.

use crate::elements::gpu::ElementTables;
use crate::elements::membrane::NAME;
use crate::gpu::feature::{Command, Feature, Features};
use crate::gpu::kernels::Name;
use crate::gpu::schedule::Fused;
use crate::gpu::sums::{capped, sum_groups};
use crate::report::{FrameSums, StrainSums};
use crate::step::{Op, Stage};
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack};

/// Numbers of each workgroup in `strains` of stages.wgsl.
pub const STRAINS: usize = 5;

/// The strain of all fabric.
pub struct Strains {
    most: Buffer<f32>,
    read: ReadBack<f32>,
}

impl Strains {
    /// That of some bodies, if they have fabric.
    pub fn new(gpu: &Gpu, tables: &ElementTables) -> Result<Option<Self>, GpuError> {
        let Some(membranes) = tables.of(NAME) else { return Ok(None) };
        let numbers = STRAINS * sum_groups(membranes.set.range.len());
        let label = "strain of fabric";
        Ok(Some(Self { most: gpu.buffer(label, numbers)?, read: gpu.read_back(label, numbers)? }))
    }
}

impl Feature for Strains {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![("strains", &self.most)]
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        // A row for each workgroup.
        let command = Command::run(Name::new("measure_strains"), self.most.len() / STRAINS);
        vec![Fused::new(&[Op::MeasureTiles], vec![command])]
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.most, &self.read);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let mut numbers = Vec::new();
        self.read.take(gpu, &mut numbers)?;
        for row in numbers.as_chunks::<STRAINS>().0 {
            StrainSums(row.map(capped)).add_to(&mut sums.strain);
        }
        Ok(())
    }
}
