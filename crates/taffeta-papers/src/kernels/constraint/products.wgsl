// The product A p, A = J M⁻¹ Jᵀ, in other ways than that of 2021, to compare with: rows in CSR, rows in ELLPACK, and
// without the matrix. Each takes the place of SpMM() and SpMV(); sums are added up by workgroups first, so that systems may
// be larger.
//
// Source: Bell, Garland, "Implementing Sparse Matrix-Vector Multiplication on Throughput-Oriented Processors", 2009: a
// thread a row, and ELLPACK by columns, so that neighbouring threads read neighbouring numbers.

#import papers/constraint/sums.wgsl
#import papers/constraint/tables.wgsl
#import papers/springs.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/vector.wgsl

/// CSR: where each row of the system begins.
@group(1) @binding(24) var<storage, read> printed_sys_starts: array<u32>;
/// Columns of the system; in ELLPACK the k-th entries of all rows follow each other, and rows are padded with their own
/// number.
@group(1) @binding(25) var<storage, read> printed_sys_columns: array<u32>;
/// For each node, where its row in `printed_ends_at` begins.
@group(1) @binding(26) var<storage, read> printed_end_starts: array<u32>;
/// Constraints at each node: twice the number, and 1 more where the node is b.
@group(1) @binding(27) var<storage, read> printed_ends_at: array<u32>;
/// Values of the system [m²/kg].
@group(3) @binding(32) var<storage, read_write> printed_sys_values: array<f32>;
/// M⁻¹ Jᵀ p of each node, three numbers.
@group(3) @binding(33) var<storage, read_write> printed_node_product: array<f32>;

var<workgroup> printed_parts: array<f32, 256>;

/// The row of J of constraint `i` at its node a; at b it is the negative.
fn printed_row(i: u32) -> vec3f {
    return vec3f(printed_j[6u * i], printed_j[6u * i + 1u], printed_j[6u * i + 2u]);
}

/// The entry of the system of two constraints: what they share.
fn printed_entry(i: u32, j: u32) -> f32 {
    let one = springs[i];
    let other = springs[j];
    let wa = old_position[one.a].w;
    let wb = old_position[one.b].w;
    var shared_mass = 0.0;
    if one.a == other.a { shared_mass += wa; }
    if one.a == other.b { shared_mass -= wa; }
    if one.b == other.b { shared_mass += wb; }
    if one.b == other.a { shared_mass -= wb; }
    return shared_mass * dot3(printed_row(i), printed_row(j));
}

@compute @workgroup_size(256)
fn fill_csr(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 256u + lane;
    if i >= arrayLength(&springs) {
        return;
    }
    for (var at = printed_sys_starts[i]; at < printed_sys_starts[i + 1u]; at++) {
        printed_sys_values[at] = printed_entry(i, printed_sys_columns[at]);
    }
}

@compute @workgroup_size(256)
fn spmv_csr(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 256u + lane;
    if i == 0u {
        start_printed_iteration();
    }
    if i >= arrayLength(&printed_product) {
        return;
    }
    var value = 0.0;
    for (var at = printed_sys_starts[i]; at < printed_sys_starts[i + 1u]; at++) {
        value += printed_sys_values[at] * printed_p[printed_sys_columns[at]];
    }
    printed_product[i] = value;
}

@compute @workgroup_size(256)
fn fill_ell(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let m = arrayLength(&springs);
    let i = workgroup_index(id) * 256u + lane;
    if i >= m {
        return;
    }
    // The first entry is the diagonal; later ones that are it are padding.
    for (var at = i; at < arrayLength(&printed_sys_columns); at += m) {
        let j = printed_sys_columns[at];
        printed_sys_values[at] = select(printed_entry(i, j), 0.0, j == i && at != i);
    }
}

@compute @workgroup_size(256)
fn spmv_ell(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let m = arrayLength(&printed_product);
    let i = workgroup_index(id) * 256u + lane;
    if i == 0u {
        start_printed_iteration();
    }
    if i >= m {
        return;
    }
    var value = 0.0;
    for (var at = i; at < arrayLength(&printed_sys_columns); at += m) {
        value += printed_sys_values[at] * printed_p[printed_sys_columns[at]];
    }
    printed_product[i] = value;
}

@compute @workgroup_size(256)
fn gather_printed_nodes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = workgroup_index(id) * 256u + lane;
    if node >= arrayLength(&old_position) {
        return;
    }
    var sum = vec3f(0.0);
    for (var at = printed_end_starts[node]; at < printed_end_starts[node + 1u]; at++) {
        let i = printed_ends_at[at] / 2u;
        let p = select(printed_p[i], -printed_p[i], (printed_ends_at[at] & 1u) == 1u);
        sum += p * printed_row(i);
    }
    sum *= old_position[node].w;
    printed_node_product[3u * node] = sum.x;
    printed_node_product[3u * node + 1u] = sum.y;
    printed_node_product[3u * node + 2u] = sum.z;
}

@compute @workgroup_size(256)
fn apply_printed_rows(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 256u + lane;
    if i == 0u {
        start_printed_iteration();
    }
    if i >= arrayLength(&springs) {
        return;
    }
    let a = 3u * springs[i].a;
    let b = 3u * springs[i].b;
    let apart = vec3f(
        printed_node_product[a] - printed_node_product[b],
        printed_node_product[a + 1u] - printed_node_product[b + 1u],
        printed_node_product[a + 2u] - printed_node_product[b + 2u],
    );
    printed_product[i] = dot3(printed_row(i), apart);
}

/// The sum over the workgroup, in its first thread.
fn printed_group_sum(value: f32, lane: u32) -> f32 {
    printed_parts[lane] = value;
    workgroupBarrier();
    for (var half = 128u; half > 0u; half /= 2u) {
        if lane < half {
            printed_parts[lane] += printed_parts[lane + half];
        }
        workgroupBarrier();
    }
    return printed_parts[0];
}

@compute @workgroup_size(256)
fn initial_step_by_groups(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 256u + lane;
    var b = 0.0;
    if i < arrayLength(&printed_lambda) {
        b = printed_rhs[i];
        printed_lambda[i] = 0.0;
        printed_residual[i] = b;
        printed_p[i] = b;
    }
    let sum = printed_group_sum(b * b, lane);
    if lane == 0u {
        add_to_printed_sum(PRINTED_NEW_RR, sum);
        add_to_printed_sum(PRINTED_BB, sum);
    }
}

@compute @workgroup_size(256)
fn compute_alpha_by_groups(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 256u + lane;
    var value = 0.0;
    if i < arrayLength(&printed_p) {
        value = printed_p[i] * printed_product[i];
    }
    let sum = printed_group_sum(value, lane);
    if lane == 0u {
        add_to_printed_sum(PRINTED_PAP, sum);
    }
}

@compute @workgroup_size(256)
fn compute_beta_by_groups(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 256u + lane;
    var value = 0.0;
    if i < arrayLength(&printed_residual) {
        value = printed_residual[i] * printed_residual[i];
    }
    let sum = printed_group_sum(value, lane);
    if lane == 0u {
        add_to_printed_sum(PRINTED_NEW_RR, sum);
    }
}
