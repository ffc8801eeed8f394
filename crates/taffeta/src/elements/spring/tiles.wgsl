// Tiles of grids: 8 rows of 32 nodes, one for each workgroup.

#import elements/spring/grid.wgsl

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
