// The node-centric kernels of 2021, to compare with: a thread for each node of a grid.
//
// Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021 (S1).
// From it is the structure alone:
// - sec. 3.1: one thread a node, workgroups of 32 × 32 in a plane that covers the grid, a node's place j · columns + i;
// - algorithm 1: the twelve neighbours one by one, in the printed order, read from the buffers, nothing shared;
// - sec. 3.2: a kernel ends before the next begins, so forces go through a buffer; sizes are uniform variables;
// - sec. 3.4: contact after time integration.
// Not from it: the formulas, which are the engine's own (elements/spring, solvers/explicit, contact/colliders); the sum, where
// algorithm 1 prints assignments; and x along the columns, where sec. 3.1 has the rows, which only a square allows.
// Where the paper is silent, what is faster is taken: forces are summed in registers and stored once, contact shares
// the kernel of time integration.

#import contact/colliders/response.wgsl
#import elements/spring/grid.wgsl
#import gpu/wgsl/state.wgsl
#import solvers/explicit/node.wgsl
#import loads
#import memory
#import resolve_contact

/// A grid whose nodes lie row by row from `first` on.
struct Sheet {
    first: u32,
    rows: i32,
    cols: i32,
    @align(16) along: array<Along, 6>,
}

/// The grid of this dispatch.
@group(0) @binding(6) var<uniform> sheet: Sheet;
/// Force of the springs on each node [N], in xyz.
@group(3) @binding(9) var<storage, read_write> spring_forces: array<vec4f>;

/// Force [N] on the node (i, j) of its spring to the node (to_i, to_j); none beyond the border.
fn spring_to(i: i32, j: i32, to_i: i32, to_j: i32, direction: u32) -> vec3f {
    let along = sheet.along[direction];
    if along.there == 0u || to_i < 0 || to_j < 0 || to_i >= sheet.cols || to_j >= sheet.rows {
        return vec3f(0.0);
    }
    let first = i32(sheet.first);
    let node = u32(first + j * sheet.cols + i);
    return pull(position_of(node), velocity_of(node), first + to_j * sheet.cols + to_i, along);
}

@compute @workgroup_size(32, 32)
fn node_centric_forces(@builtin(global_invocation_id) thread: vec3u) {
    let i = i32(thread.x);
    let j = i32(thread.y);
    if i >= sheet.cols || j >= sheet.rows {
        return;
    }
    var total = spring_to(i, j, i, j + 1, 2u);
    total += spring_to(i, j, i, j - 1, 2u);
    total += spring_to(i, j, i + 1, j, 0u);
    total += spring_to(i, j, i - 1, j, 0u);
    total += spring_to(i, j, i + 1, j + 1, 4u);
    total += spring_to(i, j, i + 1, j - 1, 5u);
    total += spring_to(i, j, i - 1, j - 1, 4u);
    total += spring_to(i, j, i - 1, j + 1, 5u);
    total += spring_to(i, j, i, j + 2, 3u);
    total += spring_to(i, j, i, j - 2, 3u);
    total += spring_to(i, j, i + 2, j, 1u);
    total += spring_to(i, j, i - 2, j, 1u);
    spring_forces[sheet.first + u32(j * sheet.cols + i)] = vec4f(total, 0.0);
}

/// Works in place, as one buffer for positions and one for velocities is all that the paper has.
@compute @workgroup_size(32, 32)
fn node_centric_update(@builtin(global_invocation_id) thread: vec3u) {
    let i = i32(thread.x);
    let j = i32(thread.y);
    if i >= sheet.cols || j >= sheet.rows {
        return;
    }
    let node = sheet.first + u32(j * sheet.cols + i);
    let x = new_position[node];
    let v = new_velocity[node];
    let total = load_on(node, v.xyz, 0u) + spring_forces[node].xyz;
    let after = resolve_contact(node, integrate(x, v, total, 0u), Origin(x.xyz, true), 0u);
    new_position[node] = after.position;
    new_velocity[node] = after.velocity;
}
