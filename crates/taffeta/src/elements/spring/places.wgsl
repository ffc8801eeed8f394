// Which places belong to meshes.

#import elements/spring/mesh.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl

/// In a run's count: the slice belongs to a grid.
const NOT_A_MESH: u32 = 0xffffffffu;

/// In a run's count: its entries are a ring of a body that keeps its volume, which has kernels of its own. A grid's count
/// has this bit as well.
const IS_RING: u32 = 0x80000000u;

/// Whether a place belongs to a mesh.
fn is_of_mesh(node: u32) -> bool {
    return node < arrayLength(&old_position) && runs[node / LANES * KINDS].count != NOT_A_MESH;
}

/// Whether it belongs to a mesh that keeps no volume.
fn is_of_free_mesh(node: u32) -> bool {
    return node < arrayLength(&old_position) && (runs[node / LANES * KINDS].count & IS_RING) == 0u;
}
