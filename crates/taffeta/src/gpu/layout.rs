//! Records as the kernels see them: the same fields in the same order, at the offsets that naga reads from the WGSL
//! (`layout_tests` compares them).

use crate::elements::aero::aero::AirNow;
use crate::motion::pins;
use bytemuck::{Pod, Zeroable};

/// Position or velocity in the first three; inverse mass [1/kg] or mass [kg] in the last.
pub type Four = [f32; 4];

/// `Substep` of substep.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Substep {
    pub gravity: [f32; 3],
    pub h: f32,
    pub wind: [f32; 3],
    pub drag: f32,
    pub first_collider: u32,
    pub colliders: u32,
    pub first_motion: u32,
    pub first_scale: u32,
    pub frame_fraction: f32,
    pub frame_rate: f32,
    pub input_forces: u32,
    pub pins: u32,
    pub solving: Solving,
    pub left: u32,
    pub first_goal: u32,
    pub most_apart: f32,
    pub gap: u32,
    pub air: Air,
    pub padding: [u32; 16],
}

/// `Solving` of substep.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Solving {
    pub activation: f32,
    pub release: f32,
    pub aim: f32,
    pub epsilon: f32,
    pub form: u32,
    pub tolerance_squared: f32,
    pub most_iterations: u32,
    pub is_adaptive: u32,
    pub is_warm: u32,
    pub padding: [u32; 3],
}

/// `Air` of air.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Air {
    pub velocity: [f32; 3],
    pub density: f32,
    pub exposure: f32,
    pub drag: f32,
    pub lift: f32,
    pub gap: u32,
    pub gusts: Gusts,
}

/// `Gusts` of gust.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Gusts {
    pub offset: [f32; 3],
    pub cells_a_metre: f32,
    pub keys: [u32; 2],
    pub weights: [f32; 2],
}

impl Air {
    /// That of a sub-step.
    pub fn of(air: Option<&AirNow<f32>>) -> Self {
        let Some(air) = air else { return Self::default() };
        let AirNow { velocity, density, exposure, drag, lift, gust } = *air;
        let gusts = gust.map_or_else(Gusts::default, |gust| Gusts {
            offset: gust.offset,
            cells_a_metre: gust.cells_a_metre,
            keys: gust.keys,
            weights: gust.weights,
        });
        Self { velocity, density, exposure, drag, lift, gap: 0, gusts }
    }
}

/// Records of sub-steps that a dispatch sees: its own and those after it.
pub const SUBSTEPS_SEEN: usize = 64;

/// `Motion` of pins.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Motion {
    pub x: Four,
    pub y: Four,
    pub z: Four,
    pub rate_x: Four,
    pub rate_y: Four,
    pub rate_z: Four,
}

/// `Pin` of pins.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Pin {
    pub start: [f32; 3],
    pub node: u32,
    pub goal: [f32; 3],
    pub track: u32,
}

/// In [`Pin::track`]: moved by the program.
pub const MOVED_BY_USER: u32 = u32::MAX;

/// `Along` of grid.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Default, Pod, Zeroable)]
pub struct Along {
    pub k: f32,
    pub damping: f32,
    pub rest_length: f32,
    pub there: u32,
}

/// `Grid` of grid.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Grid {
    pub first: u32,
    pub rows: i32,
    pub cols: i32,
    pub along: [Along; 6],
}

/// `Tile` of grid_stages.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Tile {
    pub grid: u32,
    pub row: i32,
    pub col: i32,
}

/// `Part` of grid_patches.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct Part {
    pub first_row: i32,
    pub first_col: i32,
    pub end_row: i32,
    pub end_col: i32,
}

/// `Patch` of grid_patches.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Patch {
    pub grid: u32,
    pub all: Part,
    pub inner: Part,
}

/// `Small` of mesh_patches.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Small {
    pub first: u32,
    pub count: u32,
}

/// `Run` of mesh.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Run {
    pub start: u32,
    pub count: u32,
    pub k: f32,
    pub damping: f32,
}

/// In [`Run::count`]: the slice belongs to a grid.
pub const NOT_A_MESH: u32 = u32::MAX;

/// In [`Run::count`]: the entries are a ring of a body that keeps its volume.
pub const IS_RING: u32 = 1 << 31;

/// `Entry` of mesh.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Entry {
    pub neighbour: u32,
    pub rest_length: f32,
}

/// `Load` of load/stages.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Load {
    pub vector: [f32; 3],
    pub kind: u32,
    pub about: [f32; 3],
    pub torque: f32,
    pub first: u32,
    pub count: u32,
    pub factor: f32,
    pub padding: u32,
}

/// In [`Load::kind`].
pub const FORCE: u32 = 0;
/// In [`Load::kind`].
pub const TORQUE: u32 = 1;
/// Marks a load among a node's elements.
pub const IS_LOAD: u32 = 1 << 31;

/// `Chunk` of measure_volumes.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct Chunk {
    pub origin: u32,
    pub first: u32,
    pub count: u32,
}

/// `VolumeGroup` of volume.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
pub struct VolumeGroup {
    pub first: u32,
    pub count: u32,
    pub gradients: u32,
    pub origin: u32,
    pub first_group: u32,
    pub groups: u32,
    pub goal: u32,
    pub form: u32,
    pub flags: u32,
}

/// In [`VolumeGroup::flags`]: nodes have weights.
pub const WEIGHTED: u32 = 1;
/// In [`VolumeGroup::flags`]: nodes are moved after contact.
pub const RESTORED: u32 = 2;
/// Vectors of each group in `volume_sums` of volume.wgsl.
pub const VOLUME_PARTS: usize = 7;

/// `Meeting` of pair.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Meeting {
    pub thickness: f32,
    pub friction: f32,
    pub restitution: f32,
}

/// `Surface` of pairs.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Surface {
    pub first: u32,
    pub count: u32,
    pub cols: u32,
    pub high: u32,
    pub wide: u32,
    pub apart: u32,
    pub meeting: Meeting,
    pub cells_a_metre: f32,
}

/// `Joint` of attach_stages.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Debug, PartialEq, Pod, Zeroable)]
pub struct Joint {
    pub point: [f32; 3],
    pub track: u32,
    pub a: u32,
    pub b: u32,
    pub start: f32,
    pub end: f32,
    pub compliance: f32,
    pub break_force: f32,
    pub closing: u32,
    pub grouped: u32,
}

/// No node, or no surface.
pub const NONE: u32 = u32::MAX;
/// Cells of pairs from the origin to the last layer.
pub const FARTHEST: f32 = 65_536.0;

/// Bytes of a node in a patch.
pub const PATCH_NODE_BYTES: u32 = 28;
/// Nodes that an invocation works on in a patch at most.
pub const OWN: usize = 4;
/// Numbers of each workgroup in `node_sums` of measure.wgsl.
pub const NODE_SUMS: usize = 12;
/// Invocations of a workgroup.
pub const GROUP: usize = 256;
/// Rows and columns of a tile; together [`GROUP`].
pub const TILE: [usize; 2] = [8, 32];

impl From<&pins::Motion<f32>> for Motion {
    fn from(motion: &pins::Motion<f32>) -> Self {
        let ([x, y, z], [rate_x, rate_y, rate_z]) = (motion.place, motion.rate);
        Self { x, y, z, rate_x, rate_y, rate_z }
    }
}
