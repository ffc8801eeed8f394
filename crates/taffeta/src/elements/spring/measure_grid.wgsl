// Energy and stretch of the springs of grids.

#import diagnostics/few.wgsl
#import elements/spring/grid.wgsl
#import elements/spring/spring.wgsl
#import elements/spring/tiles.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// Of each workgroup over springs: energy [J], largest stretch l/L.
@group(3) @binding(5) var<storage, read_write> grid_spring_sums: array<vec2f>;

/// Energy and stretch of the springs that a grid's nodes own.
fn own_springs(cell: Cell) -> vec2f {
    var steps = array<vec2i, 6>(vec2i(0, 1), vec2i(0, 2), vec2i(1, 0), vec2i(2, 0), vec2i(1, 1), vec2i(1, -1));
    var found = vec2f(0.0);
    for (var direction = 0u; direction < 6u; direction++) {
        let step = steps[direction];
        let along = this_grid.along[direction];
        if along.there != 0u && inside(cell.row + step.x, cell.col + step.y) {
            let there = u32(cell.place + step.x * cell.stride + step.y);
            let length = norm3(position_of(there) - position_of(u32(cell.place)));
            let energy = spring_energy(length, along.k, along.rest_length);
            found = vec2f(found.x + energy, max(found.y, length / along.rest_length));
        }
    }
    return found;
}

@compute @workgroup_size(256)
fn measure_grid_springs(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    var found = vec2f(0.0);
    for (var index = id.x; index < arrayLength(&tiles); index += counts.x) {
        let cell = cell_of(tiles[index], lane);
        if cell.row >= 0 {
            let own = own_springs(cell);
            found = vec2f(found.x + own.x, max(found.y, own.y));
        }
    }
    let all = gather_few(lane, found);
    if lane == 0u {
        grid_spring_sums[id.x] = all;
    }
}
