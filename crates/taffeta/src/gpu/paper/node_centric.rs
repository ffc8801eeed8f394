//! What node_centric.wgsl is told of each grid.

use crate::gpu::feature::{Command, Dispatch, Groups};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Along, Four, Grid};
use crate::gpu::paper::{go_on_in_place, with_loads};
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
struct Plane {
    offset: u32,
    groups: [u32; 2],
}

/// All grids.
pub struct Sheets {
    told: Uniforms<Sheet>,
    forces: Buffer<Four>,
    planes: Vec<Plane>,
}

impl Sheets {
    pub fn new(gpu: &Gpu, grids: &[Grid], places: usize) -> Result<Self, GpuError> {
        let sheet =
            |&Grid { first, rows, cols, along }: &Grid| Sheet { first, rows, cols, padding: 0, along };
        let records: Vec<Sheet> = grids.iter().map(sheet).collect();
        let told = gpu.uniforms("grids", records.len())?;
        told.write(gpu, &records);
        let plane = |(index, sheet): (usize, &Sheet)| Plane {
            offset: told.offset(index),
            groups: [sheet.cols, sheet.rows].map(|side| side.unsigned_abs().div_ceil(SIDE)),
        };
        let planes = records.iter().enumerate().map(plane).collect();
        Ok(Self { planes, forces: gpu.buffer("forces of springs", places)?, told })
    }

    /// Forces, then the rest.
    pub fn commands<'f>(&self, loads_given: bool) -> Vec<Command<'f>> {
        let over = |name: Name| {
            let plane = move |plane: &Plane| {
                let groups = Groups::Plane(plane.groups, Some(plane.offset));
                Command::Dispatch(Dispatch { name, part: 0, groups })
            };
            self.planes.iter().map(plane)
        };
        let forces = over(Name::new("node_centric_forces"));
        forces.chain(go_on_in_place()).chain(over(with_loads("node_centric_update", loads_given))).collect()
    }

    pub fn buffers(&self) -> Vec<(&'static str, &dyn Bindable)> {
        vec![("sheet", &self.told), ("spring_forces", &self.forces)]
    }
}
