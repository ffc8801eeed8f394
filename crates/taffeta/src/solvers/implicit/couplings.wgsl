// The system where elements are solved for beside springs: blocks of three by three between two nodes.
//
// A mode of an element adds g gᵀ to the system, where g [kg^½] has a direction for each of its nodes. As the directions of a
// mode add up to 0, so do the blocks of a row, and the product at node i is Σ B (u_i − u_j) with B = −g_i g_jᵀ. On coarser levels
// blocks are those of the Galerkin product, and springs are among them.

#import contacts
#import solvers/implicit/levels.wgsl

/// For each node on all levels where here its first slot is, 0 where it has none, and how many blocks; then on the finest level where in
/// `coupling_sources` the forces on it begin and end, on others 0, and 1 if its body has elements. Then slots: that of entry `k` of a lane has its rows at
/// start + 16·(3·k + row) + lane, with the bits of three numbers. In w the first row has the other node, the second and third
/// where the sources of the block begin and end. The first slot has the sum of a node's blocks.
@group(3) @binding(47) var<storage, read_write> couplings: array<vec4u>;
/// Forces, in x; sources of blocks: on the finest level two of `element_directions`; on coarser ones the first row of a finer
/// block, or SPRING and the slot of a spring, and the bits of a weight.
@group(1) @binding(48) var<storage, read> coupling_sources: array<vec2u>;

/// From one row of a block to the next, and from one slot to the next.
const ROW: u32 = 16u;
const SLOT: u32 = 48u;
/// Marks the slot of a spring.
const SPRING: u32 = 0x80000000u;

/// A block, row by row.
struct Block {
    x: vec3f,
    y: vec3f,
    z: vec3f,
}

fn block_at(at: u32) -> Block {
    return Block(
        bitcast<vec3f>(couplings[at].xyz),
        bitcast<vec3f>(couplings[at + ROW].xyz),
        bitcast<vec3f>(couplings[at + 2u * ROW].xyz),
    );
}

fn block_times(block: Block, v: vec3f) -> vec3f {
    return vec3f(dot3(block.x, v), dot3(block.y, v), dot3(block.z, v));
}

/// Where the blocks of a node begin and end.
fn blocks_of(node: u32) -> vec2u {
    let first = couplings[node].x + SLOT;
    return vec2u(first, first + SLOT * couplings[node].y);
}

fn put_block(at: u32, block: Block) {
    couplings[at] = vec4u(bitcast<vec3u>(block.x), couplings[at].w);
    couplings[at + ROW] = vec4u(bitcast<vec3u>(block.y), couplings[at + ROW].w);
    couplings[at + 2u * ROW] = vec4u(bitcast<vec3u>(block.z), couplings[at + 2u * ROW].w);
}

/// A symmetric matrix as a block.
fn whole(m: Symmetric) -> Block {
    return Block(
        vec3f(m.diagonal.x, m.mixed.x, m.mixed.y),
        vec3f(m.mixed.x, m.diagonal.y, m.mixed.z),
        vec3f(m.mixed.y, m.mixed.z, m.diagonal.z),
    );
}

/// A sum, and the product of a node's blocks with a vector that is `own` there.
fn add_coupled(start: vec3f, which: u32, node: u32, own: vec3f) -> vec3f {
    var sum = start;
    let range = blocks_of(node);
    for (var at = range.x; at < range.y; at += SLOT) {
        sum += block_times(block_at(at), own - vector_of(which, couplings[at].w));
    }
    return sum;
}

/// The finest level's system times a vector, at a node; nothing holds it.
fn system_times(mass: f32, which: u32, node: u32) -> vec3f {
    let all = add_coupled(springs_times(mass, which, node), which, node, vector_of(which, node));
    return all + taken_by_contacts(node);
}

/// A coarser level's system times a vector, at a node.
fn level_times(which: u32, node: u32) -> vec3f {
    let own = vector_of(which, node);
    return add_coupled(times(diagonals[node].own, own), which, node, own);
}

/// What other elements give a node, as `set_up_couplings` has found it.
fn given_by_elements(node: u32) -> ElementSums {
    return ElementSums(vector_of(IMPULSE, node), diagonals[node].own);
}

/// Keeps the sum of all blocks of a node, those of springs among them.
fn keep_sum(node: u32, sum: Symmetric) {
    if couplings[node].x > 0u {
        put_block(couplings[node].x, whole(sum));
    }
}
