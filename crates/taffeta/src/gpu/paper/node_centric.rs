//! What node_centric.wgsl is told of each grid.

use crate::gpu::layout::{Along, Four, Grid};
use crate::gpu::tables::Tables;
use bytemuck::{Pod, Zeroable};
use taffeta_gpu::{Bindable, Buffer, Gpu, GpuError, Uniforms};

/// Rows and columns of a workgroup.
const SIDE: u32 = 32;

/// `Sheet` of node_centric.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Sheet {
    first: u32,
    rows: i32,
    cols: i32,
    padding: u32,
    along: [Along; 6],
}

/// How a grid is dispatched: where its record is, and workgroups along columns and rows.
#[derive(Clone, Copy, Debug)]
pub struct Plane {
    pub offset: u32,
    pub groups: [u32; 2],
}

/// The grids of a segment.
pub struct Sheets {
    told: Uniforms<Sheet>,
    forces: Buffer<Four>,
    pub planes: Vec<Plane>,
}

impl Sheets {
    pub fn new(gpu: &Gpu, tables: &Tables) -> Result<Self, GpuError> {
        let sheet =
            |&Grid { first, rows, cols, along }: &Grid| Sheet { first, rows, cols, padding: 0, along };
        let records: Vec<Sheet> = tables.grids.iter().map(sheet).collect();
        let told = gpu.uniforms("grids", records.len())?;
        told.write(gpu, &records);
        let plane = |(index, sheet): (usize, &Sheet)| Plane {
            offset: told.offset(index),
            groups: [sheet.cols, sheet.rows].map(|side| side.unsigned_abs().div_ceil(SIDE)),
        };
        let planes = records.iter().enumerate().map(plane).collect();
        Ok(Self { planes, forces: gpu.buffer("forces of springs", tables.len())?, told })
    }

    pub fn buffers(&self) -> Vec<(&'static str, &dyn Bindable)> {
        vec![("sheet", &self.told), ("spring_forces", &self.forces)]
    }
}
