// The particle stages on a grid, a tile of nodes for each workgroup.

/// Where a tile begins.
struct Tile {
    grid: u32,
    row: i32,
    col: i32,
}

@group(1) @binding(1) var<storage, read> tiles: array<Tile>;

const TILE_COLS: u32 = 32u;

/// The node of an invocation; row -1: none. Reads the tile's grid.
fn cell_of(tile: Tile, lane: u32) -> Cell {
    let row = tile.row + i32(lane / TILE_COLS);
    let col = tile.col + i32(lane % TILE_COLS);
    this_grid = grids[tile.grid];
    if !inside(row, col) {
        return Cell(-1, -1, 0, 0);
    }
    return Cell(row, col, i32(this_grid.first) + row * this_grid.cols + col, this_grid.cols);
}

@compute @workgroup_size(256)
fn grid_springs_all(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_index(id, counts);
    if index >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[index];
    let cell = cell_of(tile, lane);
    if cell.row >= 0 {
        let node = u32(cell.place);
        let springs = grid_springs(cell, position_of(node), velocity_of(node));
        force[node] = vec4f(force[node].xyz + springs, 0.0);
    }
}

@compute @workgroup_size(256)
fn grid_particles(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_index(id, counts);
    if index >= arrayLength(&tiles) {
        return;
    }
    let tile = tiles[index];
    let cell = cell_of(tile, lane);
    if cell.row >= 0 {
        let node = u32(cell.place);
        let x = old_position[node];
        let v = old_velocity[node];
        let total = load_on(node, v.xyz, 0u) + grid_springs(cell, x.xyz, v.xyz);
        let after = touch(integrate(x, v, total, 0u), Origin(x.xyz, true), 0u);
        new_position[node] = after.position;
        new_velocity[node] = after.velocity;
    }
}
