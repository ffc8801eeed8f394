//! Springs on the GPU: grids by tiles, meshes by gathers.

use crate::assembly::Assembly;
use crate::assembly::body::{BodyAssembly, BodySprings, GridDirections};
use crate::assembly::springs::SpringKind;
use crate::elements::spring::gpu_layout::{
    Along, Entry, Grid, IS_RING, NOT_A_MESH, ResidentMesh, Run, TILE, Tile,
};
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Feature, Features};
use crate::gpu::kernels::{Name, Overrides};
use crate::gpu::layout::GROUP;
use crate::gpu::schedule::Fused;
use crate::gpu::sums::{capped, sum_groups};
use crate::report::FrameSums;
use crate::step::{Marks, Op, Stage};
use crate::topology::LANES;
use taffeta_gpu::{Bindable, Buffer, DispatchList, Gpu, GpuError, ReadBack, Shader, shaders};

/// Its shaders.
pub const SHADERS: &[Shader] = shaders!(
    "elements/spring",
    [
        "grid.wgsl",
        "measure_grid.wgsl",
        "measure_mesh.wgsl",
        "mesh.wgsl",
        "places.wgsl",
        "spring.wgsl",
        "tiles.wgsl"
    ]
);

/// Workgroups that share a sum over tiles: enough to fill a large GPU.
const SUM_TILES: usize = 1024;

/// Bytes of the array of a body's springs, and what it holds.
pub fn arrays(assembly: &Assembly, body: usize) -> Vec<(u64, &'static str)> {
    let springs: usize = match &assembly.bodies[body].springs {
        BodySprings::Grid(_) => 0,
        // Slices are as long as their longest row; a quarter more is what meshes were seen to need.
        BodySprings::Mesh(lists) => lists.iter().map(|list| list.pairs.len() * 5 / 2).sum(),
    };
    vec![((springs * size_of::<Entry>()) as u64, "springs")]
}

/// Springs on the host.
#[derive(Default)]
pub struct SpringTables {
    pub grids: Vec<Grid>,
    pub tiles: Vec<Tile>,
    /// Meshes that keep no volume.
    pub meshes: Vec<ResidentMesh>,
    /// Kinds of springs that a slice has at most; 0: no mesh.
    pub kinds: usize,
    pub runs: Vec<Run>,
    pub entries: Vec<Entry>,
}

impl SpringTables {
    /// Those of some bodies.
    pub fn new(bodies: &Bodies<'_>) -> Result<Self, String> {
        let kinds = bodies.iter().map(|(_, body)| kinds(body)).max().unwrap_or(0);
        let mut tables = Self { kinds, ..Self::default() };
        for (_, body) in bodies.iter() {
            let first = bodies.local(body.first);
            match &body.springs {
                BodySprings::Grid(along) => tables.add_grid(first, body, along),
                BodySprings::Mesh(_) => tables.add_mesh(first, body)?,
            }
        }
        Ok(tables)
    }

    fn add_grid(&mut self, first: u32, body: &BodyAssembly, along: &GridDirections) {
        let Some([rows, cols]) = body.grid_layout else { return };
        let grid = self.grids.len() as u32;
        let direction = |along: Option<[f64; 3]>| {
            along.map_or_else(Along::default, |numbers| {
                let [k, damping, rest_length] = numbers.map(|number| number as f32);
                Along { k, damping, rest_length, there: 1 }
            })
        };
        let (wide, high) = (cols as i32, rows as i32);
        self.grids.push(Grid { first, rows: high, cols: wide, along: along.map(direction) });
        for row in (0..rows).step_by(TILE[0]) {
            let tile = |col: usize| Tile { grid, row: row as i32, col: col as i32 };
            self.tiles.extend((0..cols).step_by(TILE[1]).map(tile));
        }
        let no_run = Run { start: 0, count: NOT_A_MESH, k: 0.0, damping: 0.0 };
        self.runs.resize(self.runs.len() + body.places() / LANES * self.kinds, no_run);
    }

    /// Lays out a mesh's springs, and gives back their lengths in the assembly's lists.
    fn add_mesh(&mut self, first: u32, body: &BodyAssembly) -> Result<(), String> {
        let (slices, base) = (body.places() / LANES, self.runs.len());
        let none = Run { start: 0, count: 0, k: 0.0, damping: 0.0 };
        self.runs.resize(base + slices * self.kinds, none);
        let is_kept = body.volume().is_some();
        if !is_kept {
            self.meshes.push(ResidentMesh { first, count: body.places() as u32 });
        }
        for (kind, (k, damping, gather)) in body.gathered()?.into_iter().enumerate() {
            let start =
                u32::try_from(self.entries.len()).map_err(|_| "too many springs for 32 bits".to_owned())?;
            for (slice, ends) in gather.slice_starts.windows(2).enumerate() {
                let mark = if is_kept && kind == 0 { IS_RING } else { 0 };
                self.runs[base + slice * self.kinds + kind] = Run {
                    start: start + ends[0],
                    count: ((ends[1] - ends[0]) / LANES as u32) | mark,
                    k: k as f32,
                    damping: damping as f32,
                };
            }
            let entry = |(&neighbour, &rest): (&u32, &f64)| Entry {
                neighbour: first + neighbour,
                rest_length: rest as f32,
            };
            self.entries.extend(gather.neighbour.iter().zip(&gather.rest).map(entry));
        }
        Ok(())
    }
}

fn kinds(body: &BodyAssembly) -> usize {
    match &body.springs {
        BodySprings::Grid(_) => 0,
        // A mesh without springs still has places: an empty kind.
        BodySprings::Mesh(lists) => {
            let structural = lists.first().is_some_and(|list| list.kind == SpringKind::Structural);
            // A volume needs rings, with springs or without.
            (lists.len() + usize::from(body.volume().is_some() && !structural)).max(1)
        }
    }
}

/// Springs on the device.
pub struct Springs {
    grids: Buffer<Grid>,
    tiles: Buffer<Tile>,
    runs: Buffer<Run>,
    entries: Buffer<Entry>,
    kinds: usize,
    /// Workgroups over places where a mesh keeps no volume.
    mesh_groups: usize,
    /// By workgroup: energy [J], and the largest stretch.
    grid_sums: Buffer<[f32; 2]>,
    mesh_sums: Buffer<[f32; 2]>,
    read_grid_sums: ReadBack<[f32; 2]>,
    read_mesh_sums: ReadBack<[f32; 2]>,
}

impl Springs {
    /// Takes tables to the device, of so many places.
    pub fn new(gpu: &Gpu, tables: &SpringTables, places: usize) -> Result<Self, GpuError> {
        let of_grids = tables.tiles.len().min(SUM_TILES);
        let of_meshes = if tables.kinds > 0 { sum_groups(places) } else { 0 };
        Ok(Self {
            grids: gpu.buffer_from("grids", &tables.grids)?,
            tiles: gpu.buffer_from("tiles of grids", &tables.tiles)?,
            runs: gpu.buffer_from("rows of springs", &tables.runs)?,
            entries: gpu.buffer_from("springs", &tables.entries)?,
            kinds: tables.kinds,
            mesh_groups: if tables.meshes.is_empty() { 0 } else { places.div_ceil(GROUP) },
            grid_sums: gpu.buffer("sums over springs of grids", of_grids)?,
            mesh_sums: gpu.buffer("sums over springs of meshes", of_meshes)?,
            read_grid_sums: gpu.read_back("sums over springs of grids", of_grids)?,
            read_mesh_sums: gpu.read_back("sums over springs of meshes", of_meshes)?,
        })
    }

    /// Workgroups over tiles of grids, and over places where a mesh keeps no volume.
    pub fn groups(&self) -> [usize; 2] {
        [self.tiles.len(), self.mesh_groups]
    }
}

impl Feature for Springs {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        vec![
            ("grids", &self.grids),
            ("tiles", &self.tiles),
            ("runs", &self.runs),
            ("entries", &self.entries),
            ("grid_spring_sums", &self.grid_sums),
            ("mesh_spring_sums", &self.mesh_sums),
        ]
    }

    fn overrides(&self, _: &Gpu, overrides: &mut Overrides) {
        overrides.insert("KINDS", self.kinds.max(1) as f64);
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let [tiles, meshes] = self.groups();
        let forces = vec![
            Command::run(Name::new("grid_springs_all"), tiles),
            Command::run(Name::new("mesh_springs_all"), meshes),
        ];
        let sums = vec![
            Command::run(Name::new("measure_grid_springs"), self.grid_sums.len()),
            Command::run(Name::new("measure_mesh_springs"), self.mesh_sums.len()),
        ];
        vec![
            Fused::new(&[Op::Springs], forces).on(Marks::NONE, Marks::VOLUME),
            Fused::new(&[Op::MeasureTiles], sums),
        ]
    }

    fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.grid_sums, &self.read_grid_sums);
        list.copy(&self.mesh_sums, &self.read_mesh_sums);
    }

    fn measure(&self, gpu: &Gpu, sums: &mut FrameSums) -> Result<(), GpuError> {
        let (mut pairs, all) = (Vec::new(), &mut sums.all);
        for springs in [&self.read_grid_sums, &self.read_mesh_sums] {
            springs.take(gpu, &mut pairs)?;
            for [energy, stretch] in pairs.iter().map(|pair| pair.map(capped)) {
                all.springs += energy;
                all.max_stretch = if stretch > all.max_stretch { stretch } else { all.max_stretch };
            }
        }
        Ok(())
    }
}
