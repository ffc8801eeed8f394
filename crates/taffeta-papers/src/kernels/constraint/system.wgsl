// The constraint kernels of 2021, to compare with: building the system, and the force of its solution.
//
// Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021 (S1).
// - eqs. 3, 5 and 11: (J M⁻¹ Jᵀ) λ = Φ/h² + J (v/h + M⁻¹ F), Φ = |x_a − x_b|² − L²; the force is −Jᵀ λ (eq. 6);
// - table 1: ConstructingSys is computePhi(), computeVect(), computeRHS() and SpMM(), ConstraintForce is computeForce(),
//   in workgroups of 1,024 threads, 32 × 32 for SpMM();
// - table 2: J in CSR (A, IA, JA), its transpose in CSC (the same values, IB, JB), the system in COO (Sys, nnz);
// - algorithm 2: SpMM() has a thread for each entry of the system, m² of them, and stores those that are not zero.
// Changed, for as printed it does not give that system:
// - eq. 5 mixes indices: the row of a constraint is 2 (x_a − x_b) at a, and its negative at b;
// - algorithm 2 leaves out M⁻¹, and reads the counter again after it has been raised, when others may have raised it too:
//   here the entry goes where the sum pointed before;
// - Φ_t is 0: a length at rest does not change with time by itself;
// - a constraint between two nodes that are held has a row of zeros and Φ = 0, so that its multiplier stays 0.
// Left open: where the counter and sums are set back to zero. ComputePhi() does it.

#import papers/constraint/sums.wgsl
#import papers/constraint/tables.wgsl
#import papers/springs.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/explicit/euler.wgsl
#import loads
#import memory

@compute @workgroup_size(1024)
fn compute_phi(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 1024u + lane;
    if i == 0u {
        atomicStore(&printed_nnz, 0u);
        atomicStore(&printed_sums[PRINTED_NEW_RR], 0u);
        atomicStore(&printed_sums[PRINTED_BB], 0u);
    }
    if i >= arrayLength(&springs) {
        return;
    }
    let spring = springs[i];
    let a = old_position[spring.a];
    let b = old_position[spring.b];
    let moves = a.w + b.w > 0.0;
    let d = select(vec3f(0.0), a.xyz - b.xyz, moves);
    printed_phi[i] = select(0.0, dot3(d, d) - spring.rest_length * spring.rest_length, moves);
    for (var axis = 0u; axis < 3u; axis++) {
        printed_j[6u * i + axis] = 2.0 * d[axis];
        printed_j[6u * i + 3u + axis] = -2.0 * d[axis];
    }
}

@compute @workgroup_size(1024)
fn compute_vect(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = workgroup_index(id) * 1024u + lane;
    if node >= arrayLength(&old_position) {
        return;
    }
    let v = velocity_of(node);
    let h = substeps[0].h;
    let free = new_velocity_of(v, load_on(node, v, 0u), old_position[node].w, substeps[0].gravity, h);
    for (var axis = 0u; axis < 3u; axis++) {
        printed_vect[3u * node + axis] = free[axis] / h;
    }
}

@compute @workgroup_size(1024)
fn compute_rhs(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 1024u + lane;
    if i >= arrayLength(&printed_phi) {
        return;
    }
    let h = substeps[0].h;
    var value = printed_phi[i] / (h * h);
    for (var ia = printed_ia[i]; ia < printed_ia[i + 1u]; ia++) {
        value += printed_j[ia] * printed_vect[printed_ja[ia]];
    }
    printed_rhs[i] = value;
}

@compute @workgroup_size(32, 32)
fn spmm(@builtin(global_invocation_id) id: vec3u) {
    let m = arrayLength(&printed_ia) - 1u;
    let i = id.x;
    let j = id.y;
    if i >= m || j >= m {
        return;
    }
    var value = 0.0;
    for (var ia = printed_ia[i]; ia < printed_ia[i + 1u]; ia++) {
        let column = printed_ja[ia];
        for (var jb = printed_jb[j]; jb < printed_jb[j + 1u]; jb++) {
            if printed_ib[jb] == column {
                value += printed_j[ia] * printed_j[jb] * old_position[column / 3u].w;
            }
        }
    }
    if value != 0.0 {
        let at = atomicAdd(&printed_nnz, 1u);
        if at < arrayLength(&printed_sys) {
            printed_sys[at] = PrintedTriplet(f32(i), f32(j), value);
        }
    }
}

/// SpMVT: a row of J adds to the nodes at its ends.
@compute @workgroup_size(1024)
fn compute_force(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 1024u + lane;
    if i >= arrayLength(&printed_lambda) {
        return;
    }
    for (var ia = printed_ia[i]; ia < printed_ia[i + 1u]; ia++) {
        add_by_exchange(printed_ja[ia], -printed_j[ia] * printed_lambda[i]);
    }
}
