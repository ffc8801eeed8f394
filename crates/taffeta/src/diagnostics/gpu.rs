//! Sums over nodes on the GPU: added up in 64 bits what workgroups have summed.

use crate::diagnostics::FrameSums;
use crate::gpu::feature::{Command, Feature, Features};
use crate::gpu::kernels::Name;
use crate::gpu::layout::GROUP;
use crate::gpu::schedule::Fused;
use crate::step::{Op, Stage};
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Numbers of each workgroup in `node_sums` of measure.wgsl.
pub const NODE_SUMS: usize = 12;

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "diagnostics",
    [
        "drawn.wgsl",
        "few.wgsl",
        "measure.wgsl",
        "measure_grid.wgsl",
        "measure_mesh.wgsl",
        "measure_volumes.wgsl",
        "normals.wgsl"
    ]
);

/// Workgroups that share a sum over all nodes, springs or hinges: enough to fill a large GPU.
const SUM_GROUPS: usize = 1024;

/// Workgroups for a sum over `count` things.
pub fn sum_groups(count: usize) -> usize {
    count.div_ceil(GROUP).min(SUM_GROUPS)
}

/// A sum; the largest number where 32 bits were too few for it. Whether the state is finite is counted apart.
pub fn capped(sum: f32) -> f64 {
    f64::from(if sum.is_finite() { sum } else { f32::MAX })
}

/// Sums over nodes.
pub struct Measures {
    nodes: Buffer<f32>,
    read_nodes: ReadBack<f32>,
}

impl Measures {
    /// Of so many places.
    pub fn new(gpu: &Gpu, places: usize) -> Result<Self, GpuError> {
        let nodes = NODE_SUMS * sum_groups(places);
        Ok(Self {
            nodes: gpu.buffer("sums over nodes", nodes)?,
            read_nodes: gpu.read_back("sums over nodes", nodes)?,
        })
    }
}

impl Feature for Measures {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![("node_sums", &self.nodes)]
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        // A row for each workgroup.
        let commands = vec![Command::run(Name::new("measure_nodes"), self.nodes.len() / NODE_SUMS)];
        vec![Fused::new(&[Op::MeasureTiles], commands)]
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.nodes, &self.read_nodes);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let (mut numbers, all) = (Vec::new(), &mut sums.all);
        self.read_nodes.take(gpu, &mut numbers)?;
        for row in numbers.chunks_exact(NODE_SUMS) {
            let row: [f64; NODE_SUMS] = std::array::from_fn(|i| capped(row[i]));
            all.m_v2 += if row[11] > 0.0 { f64::NAN } else { row[0] };
            for axis in 0..3 {
                all.m_x[axis] += row[1 + axis];
                all.momentum[axis] += row[4 + axis];
                all.angular_momentum[axis] += row[7 + axis];
            }
            all.contacts += row[10] as u64;
        }
        Ok(())
    }
}
