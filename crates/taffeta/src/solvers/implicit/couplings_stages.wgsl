// Blocks of elements that are solved for, set up in each Newton step on all levels.

#import elements/directions.wgsl
#import elements/forces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/implicit/couplings.wgsl
#import solvers/implicit/implicit.wgsl
#import solvers/implicit/levels.wgsl

fn no_block() -> Block {
    return Block(vec3f(0.0), vec3f(0.0), vec3f(0.0));
}

fn symmetric_part(block: Block) -> Symmetric {
    let diagonal = vec3f(block.x.x, block.y.y, block.z.z);
    return Symmetric(diagonal, 0.5 * vec3f(block.x.y + block.y.x, block.x.z + block.z.x, block.y.z + block.z.y));
}

/// The block of a spring's slot.
fn spring_block(slot: u32) -> Block {
    let linear = spring_blocks[slot];
    return whole(block_of(linear.xyz, linear.w));
}

/// The block of a mode with directions `a` here and `b` at the other node, taken off; their fourth numbers are weights of what
/// resists alike in all directions.
fn with_mode(block: Block, a: vec4f, b: vec4f) -> Block {
    let alike = a.w * b.w;
    return Block(
        block.x - a.x * b.xyz - vec3f(alike, 0.0, 0.0),
        block.y - a.y * b.xyz - vec3f(0.0, alike, 0.0),
        block.z - a.z * b.xyz - vec3f(0.0, 0.0, alike),
    );
}

/// A block on the finest level from the directions of its modes.
fn block_of_modes(at: u32) -> Block {
    var block = no_block();
    let last = couplings[at + 2u * ROW].w;
    for (var i = couplings[at + ROW].w; i < last; i++) {
        let source = coupling_sources[i];
        block = with_mode(block, element_directions[source.x], element_directions[source.y]);
    }
    return block;
}

/// Blocks of a node on the finest level, their sum, and the impulse of its elements.
@compute @workgroup_size(256)
fn set_up_couplings(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let row = couplings[node];
    var impulse = vec3f(0.0);
    for (var i = row.z; i < row.w; i++) {
        impulse += substeps[0].solving.inner * element_forces[coupling_sources[i].x].xyz;
    }
    var all = Symmetric(vec3f(0.0), vec3f(0.0));
    let range = blocks_of(node);
    for (var at = range.x; at < range.y; at += SLOT) {
        let block = block_of_modes(at);
        put_block(at, block);
        all = sum_of(all, symmetric_part(block));
    }
    put_vector(IMPULSE, node, impulse);
    diagonals[node].own = all;
}

/// A block of a coarser level from finer ones.
fn coarser_block(at: u32) -> Block {
    var sum = no_block();
    let last = couplings[at + 2u * ROW].w;
    for (var i = couplings[at + ROW].w; i < last; i++) {
        let source = coupling_sources[i];
        let weight = bitcast<f32>(source.y);
        var finer = no_block();
        if (source.x & SPRING) != 0u {
            finer = spring_block(source.x & ~SPRING);
        } else {
            finer = block_at(source.x);
        }
        sum = Block(sum.x + weight * finer.x, sum.y + weight * finer.y, sum.z + weight * finer.z);
    }
    return sum;
}

/// Blocks and diagonals of a coarser level.
@compute @workgroup_size(256)
fn coarsen_couplings(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let own = own_of_children(node);
    var all = Symmetric(vec3f(0.0), vec3f(0.0));
    let range = blocks_of(node);
    for (var at = range.x; at < range.y; at += SLOT) {
        let block = coarser_block(at);
        put_block(at, block);
        all = sum_of(all, symmetric_part(block));
    }
    keep_sum(node, all);
    diagonals[node] = Diagonal(own, inverse_of(sum_of(own, all)));
}

/// How much a block couples two nodes whose diagonals have these inverses: the Frobenius norm of D_i^−½ B D_j^−½, from
/// tr(D_i⁻¹ B D_j⁻¹ Bᵀ).
fn coupling_of(inverse: Symmetric, block: Block, other: Symmetric) -> f32 {
    let first = times(inverse, vec3f(block.x.x, block.y.x, block.z.x));
    let second = times(inverse, vec3f(block.x.y, block.y.y, block.z.y));
    let third = times(inverse, vec3f(block.x.z, block.y.z, block.z.z));
    let x = times(other, block.x);
    let y = times(other, block.y);
    let z = times(other, block.z);
    let trace = first.x * x.x + second.x * x.y + third.x * x.z + first.y * y.x + second.y * y.y + third.y * y.z
        + first.z * z.x + second.z * z.y + third.z * z.z;
    return select(0.0, sqrt(trace), trace > 0.0);
}

/// What the inverses of diagonals are multiplied by so that Jacobi's iteration converges: with Σ of a node's couplings, the
/// system is not above 1 + Σ times its diagonal (Gershgorin, by blocks), and may be 2 times it. Into `PRODUCT`.
@compute @workgroup_size(256)
fn bound_couplings(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    let row = couplings[node];
    if row.z == row.w {
        // Springs alone: no more than 2 times the diagonal.
        put_vector(PRODUCT, node, vec3f(1.0, 0.0, 0.0));
        return;
    }
    let own = diagonals[node].inverse;
    var sum = 0.0;
    let range = slots_of(node);
    let first = slots[1];
    for (var at = range.x; at < range.y; at += LANES) {
        sum += coupling_of(own, spring_block(at - first), diagonals[slots[at]].inverse);
    }
    let blocks = blocks_of(node);
    for (var at = blocks.x; at < blocks.y; at += SLOT) {
        sum += coupling_of(own, block_at(at), diagonals[couplings[at].w].inverse);
    }
    let all = 1.0 + sum;
    put_vector(PRODUCT, node, vec3f(select(1.0, 2.0 / all, all > 2.0), 0.0, 0.0));
}

/// Multiplies the inverses of diagonals by what was found.
@compute @workgroup_size(256)
fn scale_inverses(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&level_groups) || lane >= level_groups[index].count {
        return;
    }
    let node = level_groups[index].first + lane;
    diagonals[node].inverse = scaled(diagonals[node].inverse, vector_of(PRODUCT, node).x);
}
