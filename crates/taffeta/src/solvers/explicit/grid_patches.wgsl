// Several sub-steps at once on patches of grids, in the memory of workgroups: whole small grids, or tiles with a rim of two
// nodes for each sub-step. What lies near the rim becomes wrong, two nodes further in with each sub-step; the inner
// part is right and written. A dispatch costs as much as a sub-step of some thousand nodes.

#import contact/collider_mesh/no_mesh.wgsl as meshes
#import elements/load/alone.wgsl as loads
#import solvers/explicit/reach_patch.wgsl as memory
#import contact/colliders/response.wgsl
#import elements/spring/grid.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import solvers/explicit/node.wgsl
#import resolve_contact

/// Rows and columns `first` to `end`.
struct Part {
    first_row: i32,
    first_col: i32,
    end_row: i32,
    end_col: i32,
}

/// A part of a grid, and within it the part that is written.
struct Patch {
    grid: u32,
    all: Part,
    inner: Part,
}

@group(1) @binding(1) var<storage, read> patches: array<Patch>;

fn is_in(row: i32, col: i32, part: Part) -> bool {
    return row >= part.first_row && row < part.end_row && col >= part.first_col && col < part.end_col;
}

/// The part that is still right one sub-step later: two nodes less where the grid goes on.
fn shrunk(part: Part) -> Part {
    return Part(
        select(part.first_row + 2, 0, part.first_row == 0),
        select(part.first_col + 2, 0, part.first_col == 0),
        select(part.end_row - 2, part.end_row, part.end_row == this_grid.rows),
        select(part.end_col - 2, part.end_col, part.end_col == this_grid.cols),
    );
}

@compute @workgroup_size(256)
fn grid_patches(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&patches) {
        return;
    }
    let patch_of = patches[index];
    this_grid = grids[patch_of.grid];
    let width = patch_of.all.end_col - patch_of.all.first_col;
    let count = u32(width * (patch_of.all.end_row - patch_of.all.first_row));
    for (var place = lane; place < count; place += 256u) {
        let node = this_grid.first
            + u32((patch_of.all.first_row + i32(place) / width) * this_grid.cols + patch_of.all.first_col + i32(place) % width);
        keep(place, old_position[node], old_velocity[node].xyz);
    }
    var right = patch_of.all;
    var after: array<Node, 4>;
    let steps = min(STEPS, substeps[own()].left);
    for (var substep = 0u; substep < steps; substep++) {
        right = shrunk(right);
        workgroupBarrier();
        for (var i = 0u; i < OWN; i++) {
            let place = i32(i * 256u + lane);
            let row = patch_of.all.first_row + place / width;
            let col = patch_of.all.first_col + place % width;
            if u32(place) < count && is_in(row, col, right) {
                let node = kept(u32(place));
                let springs =
                    grid_springs(Cell(row, col, place, width), node.position.xyz, node.velocity.xyz);
                let total = load_on(0u, node.velocity.xyz, substep) + springs;
                let moved = integrate(node.position, node.velocity, total, substep);
                let at = this_grid.first + u32(row * this_grid.cols + col);
                after[i] = resolve_contact(at, moved, Origin(node.position.xyz, true), substep);
            }
        }
        workgroupBarrier();
        for (var i = 0u; i < OWN; i++) {
            let place = i32(i * 256u + lane);
            let row = patch_of.all.first_row + place / width;
            let col = patch_of.all.first_col + place % width;
            if u32(place) < count && is_in(row, col, right) {
                keep(u32(place), after[i].position, after[i].velocity.xyz);
            }
        }
    }
    for (var i = 0u; i < OWN; i++) {
        let place = i32(i * 256u + lane);
        let row = patch_of.all.first_row + place / width;
        let col = patch_of.all.first_col + place % width;
        if u32(place) < count && is_in(row, col, patch_of.inner) {
            release(this_grid.first + u32(row * this_grid.cols + col), after[i]);
        }
    }
}
