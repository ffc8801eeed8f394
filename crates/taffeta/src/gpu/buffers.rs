//! The buffers of a segment, by how long what is in them lasts.

use crate::contact::colliders::gpu_layout::Collider;
use crate::gpu::layout::{
    Chunk, Entry, Four, GROUP, Grid, Hinge, Load, Motion, NODE_SUMS, Panel, Patch, Pin, Run, SUBSTEPS_SEEN,
    Small, Substep, Surface, Tile, VolumeGroup,
};
use crate::gpu::tables::Tables;
use crate::solvers::explicit::patches::Patches;
use taffeta_gpu::bytemuck::Pod;
use taffeta_gpu::{Buffer, DispatchList, Gpu, GpuError, ReadBack, Uniforms};

/// Workgroups that share a sum over all nodes, springs or hinges: enough to fill a large GPU.
const SUM_GROUPS: usize = 1024;

/// What a frame never changes.
pub struct Fixed {
    pub grids: Buffer<Grid>,
    pub tiles: Buffer<Tile>,
    pub patches: Buffer<Patch>,
    pub smalls: Buffer<Small>,
    pub runs: Buffer<Run>,
    pub entries: Buffer<Entry>,
    pub hinges: Buffer<Hinge>,
    pub panels: Buffer<Panel>,
    pub load_nodes: Buffer<u32>,
    pub node_starts: Buffer<u32>,
    pub node_elements: Buffer<u32>,
    pub chunks: Buffer<Chunk>,
    pub corners: Buffer<u32>,
    pub volume_groups: Buffer<VolumeGroup>,
    pub surfaces: Buffer<Surface>,
    pub apart: Buffer<u32>,
}

/// What lasts for a sub-step.
pub struct Scratch {
    pub loads: Buffer<Load>,
    pub force: Buffer<Four>,
    pub element_forces: Buffer<Four>,
    pub volume_sums: Buffer<Four>,
    pub pair_work: Buffer<u32>,
}

/// Sums, and where the host reads them.
pub struct Sums {
    pub nodes: Buffer<f32>,
    pub grid_springs: Buffer<[f32; 2]>,
    pub mesh_springs: Buffer<[f32; 2]>,
    pub hinges: Buffer<f32>,
    pub volumes: Buffer<f32>,
    pub pairs: Buffer<[u32; 2]>,
    pub read_nodes: ReadBack<f32>,
    pub read_grid_springs: ReadBack<[f32; 2]>,
    pub read_mesh_springs: ReadBack<[f32; 2]>,
    pub read_hinges: ReadBack<f32>,
    pub read_volumes: ReadBack<f32>,
    pub read_pairs: ReadBack<[u32; 2]>,
}

/// What the sub-steps of a frame are told.
pub struct Told {
    pub substeps: Uniforms<Substep>,
    pub colliders: Buffer<Collider>,
    pub motions: Buffer<Motion>,
    pub scales: Buffer<f32>,
    pub goals: Buffer<f32>,
    pub pins: Buffer<Pin>,
    pub input_forces: Buffer<Four>,
}

/// Writes data into a buffer, or makes a larger one; whether it is a new one.
pub fn fill<T: Pod>(gpu: &Gpu, label: &str, buffer: &mut Buffer<T>, data: &[T]) -> Result<bool, GpuError> {
    let new = data.len() > buffer.len();
    if new {
        *buffer = gpu.buffer(label, data.len())?;
    }
    buffer.write(gpu, 0, data);
    Ok(new)
}

impl Fixed {
    /// For a segment.
    pub fn new(gpu: &Gpu, tables: &Tables, patches: &Patches) -> Result<Self, GpuError> {
        Ok(Self {
            grids: gpu.buffer_from("grids", &tables.grids)?,
            tiles: gpu.buffer_from("tiles of grids", &tables.tiles)?,
            patches: gpu.buffer_from("patches of grids", &patches.grids)?,
            smalls: gpu.buffer_from("small meshes", &patches.meshes)?,
            runs: gpu.buffer_from("rows of springs", &tables.runs)?,
            entries: gpu.buffer_from("springs", &tables.entries)?,
            hinges: gpu.buffer_from("hinges", &tables.hinges)?,
            panels: gpu.buffer_from("panels", &tables.panels)?,
            load_nodes: gpu.buffer_from("nodes with loads", &tables.load_nodes)?,
            node_starts: gpu.buffer_from("rows of loads and hinges", &tables.elements.offsets)?,
            node_elements: gpu.buffer_from("loads and hinges by node", &tables.elements.items)?,
            chunks: gpu.buffer_from("chunks of triangles", &tables.chunks)?,
            corners: gpu.buffer_from("triangles", &tables.corners)?,
            volume_groups: gpu.buffer_from("groups of volumes", &tables.volume_groups)?,
            surfaces: gpu.buffer_from("surfaces", &tables.surfaces)?,
            apart: gpu.buffer_from("nodes that do not touch", &tables.apart)?,
        })
    }
}

/// Workgroups for a sum over `count` things.
fn sum_groups(count: usize) -> usize {
    count.div_ceil(GROUP).min(SUM_GROUPS)
}

impl Sums {
    /// For a segment.
    pub fn new(gpu: &Gpu, tables: &Tables) -> Result<Self, GpuError> {
        let nodes = NODE_SUMS * sum_groups(tables.len());
        let grid_springs = tables.tiles.len().min(SUM_GROUPS);
        let mesh_springs = if tables.kinds > 0 { sum_groups(tables.len()) } else { 0 };
        let (hinges, volumes) = (sum_groups(tables.hinges.len()), tables.chunks.len());
        let pairs = if tables.surfaces.is_empty() { 0 } else { sum_groups(tables.len()) };
        Ok(Self {
            nodes: gpu.buffer("sums over nodes", nodes)?,
            grid_springs: gpu.buffer("sums over springs of grids", grid_springs)?,
            mesh_springs: gpu.buffer("sums over springs of meshes", mesh_springs)?,
            hinges: gpu.buffer("sums over hinges", hinges)?,
            volumes: gpu.buffer("volumes", volumes)?,
            pairs: gpu.buffer("sums over pairs", pairs)?,
            read_nodes: gpu.read_back("sums over nodes", nodes)?,
            read_grid_springs: gpu.read_back("sums over springs of grids", grid_springs)?,
            read_mesh_springs: gpu.read_back("sums over springs of meshes", mesh_springs)?,
            read_hinges: gpu.read_back("sums over hinges", hinges)?,
            read_volumes: gpu.read_back("volumes", volumes)?,
            read_pairs: gpu.read_back("sums over pairs", pairs)?,
        })
    }

    /// Has the sums copied to where the host reads them.
    pub fn copy(&self, list: &mut DispatchList) {
        list.copy(&self.nodes, &self.read_nodes);
        list.copy(&self.grid_springs, &self.read_grid_springs);
        list.copy(&self.mesh_springs, &self.read_mesh_springs);
        list.copy(&self.hinges, &self.read_hinges);
        list.copy(&self.volumes, &self.read_volumes);
        list.copy(&self.pairs, &self.read_pairs);
    }
}

impl Told {
    /// For a segment.
    pub fn new(gpu: &Gpu, tables: &Tables) -> Result<Self, GpuError> {
        Ok(Self {
            substeps: gpu.uniforms("sub-steps", SUBSTEPS_SEEN)?,
            colliders: gpu.buffer("colliders", 1)?,
            motions: gpu.buffer("motions", 1)?,
            scales: gpu.buffer("scales of loads", 1)?,
            goals: gpu.buffer("volumes to keep", 1)?,
            pins: gpu.buffer("pins", tables.pins.len())?,
            input_forces: gpu.buffer("forces by the user", 1)?,
        })
    }
}
