// A uniform grid of hashed cells, to find the nodes near a position. Source: cells.rs. This one differs by its 32
// bits: cells are wider by a 64th, so that rounding loses nothing up to FARTHEST cells from the origin. Positions
// beyond that along an axis are in one layer of cells.

/// Cells from the origin to the last layer.
const FARTHEST: f32 = 65536.0;

/// The cell of a place [m] that is a number.
fn cell_at(x: vec3f, cells_a_metre: f32) -> vec3i {
    return vec3i(floor(clamp(x * cells_a_metre, vec3f(-FARTHEST), vec3f(FARTHEST))));
}

/// The part of the hash that the cells of a row have in common. Cells that are neighbours along x are neighbours in
/// the table.
fn row_of_cells(y: i32, z: i32) -> u32 {
    let mixed = (bitcast<u32>(y) * 0x9E3779B1u) ^ (bitcast<u32>(z) * 0x85EBCA77u);
    return (mixed ^ (mixed >> 15u)) * 0x2C1B3C6Du;
}

/// The first of the three buckets, one after the other in a ring, that hold the cells about `cell` in one of the nine rows
/// that surround it.
fn first_around(cell: vec3i, row: u32) -> u32 {
    let y = cell.y + i32(row % 3u) - 1;
    let z = cell.z + i32(row / 3u) - 1;
    return row_of_cells(y, z) + bitcast<u32>(cell.x) - 1u;
}
