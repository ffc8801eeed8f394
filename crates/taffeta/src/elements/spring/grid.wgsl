// Springs of a grid, node by node: each node computes its twelve springs, in pairs of an own one and the one that ends
// at it from the other side, in the order in which the CPU's sweep adds them up (cpu_grid.rs).

#import elements/spring/spring.wgsl
#import memory

/// Springs in one direction; `there` is 0 where there are none.
struct Along {
    /// [N/m]
    k: f32,
    /// [kg/s]
    damping: f32,
    /// [m]
    rest_length: f32,
    there: u32,
}

/// A grid whose nodes lie row by row from `first` on.
struct Grid {
    first: u32,
    rows: i32,
    cols: i32,
    along: array<Along, 6>,
}

@group(1) @binding(0) var<storage, read> grids: array<Grid>;

/// The grid that an invocation works on, read once.
var<private> this_grid: Grid;

/// Where a node is: its row and column, its place, and the places from one row to the next.
struct Cell {
    row: i32,
    col: i32,
    place: i32,
    stride: i32,
}

/// Force [N] of a node's spring to another place.
fn pull(x: vec3f, v: vec3f, there: i32, along: Along) -> vec3f {
    let d = position_of(u32(there)) - x;
    let dv = velocity_of(u32(there)) - v;
    return spring_factor(d, dv, along.k, along.damping, along.rest_length) * d;
}

/// Whether a row and a column are in the grid.
fn inside(row: i32, col: i32) -> bool {
    return row >= 0 && col >= 0 && row < this_grid.rows && col < this_grid.cols;
}

/// Force [N] of the two springs of a direction at a node.
fn pull_both(cell: Cell, x: vec3f, v: vec3f, direction: u32, down: i32, across: i32) -> vec3f {
    let along = this_grid.along[direction];
    let way = down * cell.stride + across;
    var own = vec3f(0.0);
    var ending = vec3f(0.0);
    if along.there != 0u && inside(cell.row + down, cell.col + across) {
        own = pull(x, v, cell.place + way, along);
    }
    if along.there != 0u && inside(cell.row - down, cell.col - across) {
        ending = pull(x, v, cell.place - way, along);
    }
    return own + ending;
}

/// Force [N] of all springs at a node.
fn grid_springs(cell: Cell, x: vec3f, v: vec3f) -> vec3f {
    var sum = pull_both(cell, x, v, 0u, 0, 1);
    sum += pull_both(cell, x, v, 1u, 0, 2);
    sum += pull_both(cell, x, v, 2u, 1, 0);
    sum += pull_both(cell, x, v, 3u, 2, 0);
    sum += pull_both(cell, x, v, 4u, 1, 1);
    return sum + pull_both(cell, x, v, 5u, 1, -1);
}
