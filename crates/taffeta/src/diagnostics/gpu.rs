//! Sums over nodes on the GPU: added up in 64 bits what workgroups have summed.

use crate::gpu::feature::{Command, Feature, Features};
use crate::gpu::kernels::Name;
use crate::gpu::schedule::Fused;
use crate::gpu::sums::{capped, sum_groups};
use crate::report::FrameSums;
use crate::step::{Op, Stage};
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Numbers of each workgroup in `node_sums` of measure.wgsl.
pub const NODE_SUMS: usize = 12;

/// Its shaders.
pub const SHADERS: &[Shader] =
    shaders!("diagnostics", ["drawn.wgsl", "few.wgsl", "measure.wgsl", "normals.wgsl"]);

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
