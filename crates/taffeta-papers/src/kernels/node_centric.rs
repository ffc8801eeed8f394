//! What node_centric.wgsl is told of each grid.

use crate::kernels::parts::{go_on_in_place, with_loads};
use taffeta::extension::{Bodies, BodyAssembly, BodySprings, Command, Dispatch, Groups, Name};
use taffeta::taffeta_gpu::bytemuck::{Pod, Zeroable};
use taffeta::taffeta_gpu::{Bindable, Buffer, Gpu, GpuError, Uniforms};

/// Rows and columns of a workgroup.
const SIDE: u32 = 32;

/// `Along` of the engine's grid.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
struct Along {
    k: f32,
    damping: f32,
    rest_length: f32,
    there: u32,
}

/// `Sheet` of node_centric.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
#[bytemuck(crate = "taffeta::taffeta_gpu::bytemuck")]
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
    parameters: Uniforms<Sheet>,
    forces: Buffer<[f32; 4]>,
    planes: Vec<Plane>,
}

impl Sheets {
    /// The grids among some bodies.
    pub fn new(gpu: &Gpu, bodies: &Bodies<'_>) -> Result<Self, GpuError> {
        let sheet = |(_, body): (usize, &BodyAssembly)| sheet(body, bodies.local(body.first));
        let records: Vec<Sheet> = bodies.iter().filter_map(sheet).collect();
        let parameters = gpu.uniforms("grids", records.len())?;
        parameters.write(gpu, &records);
        let plane = |(index, sheet): (usize, &Sheet)| Plane {
            offset: parameters.offset(index),
            groups: [sheet.cols, sheet.rows].map(|side| side.unsigned_abs().div_ceil(SIDE)),
        };
        let planes = records.iter().enumerate().map(plane).collect();
        Ok(Self { planes, forces: gpu.buffer("forces of springs", bodies.len())?, parameters })
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
        vec![("sheet", &self.parameters), ("spring_forces", &self.forces)]
    }
}

/// A grid whose nodes are counted from `first` on.
fn sheet(body: &BodyAssembly, first: u32) -> Option<Sheet> {
    let (BodySprings::Grid(along), Some([rows, cols])) = (&body.springs, body.grid_layout) else {
        return None;
    };
    let direction = |numbers: Option<[f64; 3]>| {
        numbers.map_or_else(Along::default, |numbers| {
            let [k, damping, rest_length] = numbers.map(|number| number as f32);
            Along { k, damping, rest_length, there: 1 }
        })
    };
    Some(Sheet { first, rows: rows as i32, cols: cols as i32, padding: 0, along: along.map(direction) })
}
