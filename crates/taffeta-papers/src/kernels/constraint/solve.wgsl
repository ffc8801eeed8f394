// The constraint kernels of 2021, to compare with: LinearSystemSolving, by conjugate gradients.
//
// Source: Va, Choi, Hong, "Real-Time Cloth Simulation Using Compute Shader in Unity3D for AR/VR Contents", 2021 (S1).
// - eqs. 12–17, from λ = 0 and without a preconditioner;
// - table 1: initialStep(), SpMV(), computeAlpha(), updateLambda(), computeBeta() and updateP(), in workgroups of 1,024
//   threads; the host dispatches the last five as often as there are iterations, and reads nothing in between;
// - algorithm 3: SpMV() has a thread for each entry in COO, which adds its product to the result by compare and exchange;
// - sec. 5: sums over all constraints are added up the same way, every thread to one number.
// Changed: a quotient whose divisor is not above 0 is 0. In free fall the right side is 0, and r·r / p·Ap is 0/0.
// Left open: where sums and the result are set back to zero. SpMV() does the former, for it needs none of them, and
// updateP() the latter.

#import papers/constraint/sums.wgsl
#import papers/constraint/tables.wgsl
#import gpu/wgsl/index.wgsl

@compute @workgroup_size(1024)
fn initial_step(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 1024u + lane;
    if i >= arrayLength(&printed_lambda) {
        return;
    }
    let b = printed_rhs[i];
    printed_lambda[i] = 0.0;
    printed_residual[i] = b;
    printed_p[i] = b;
    printed_product[i] = 0.0;
    add_to_printed_sum(PRINTED_NEW_RR, b * b);
    add_to_printed_sum(PRINTED_BB, b * b);
}

@compute @workgroup_size(1024)
fn spmv(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let at = workgroup_index(id) * 1024u + lane;
    if at == 0u {
        start_printed_iteration();
    }
    if at >= min(atomicLoad(&printed_nnz), arrayLength(&printed_sys)) {
        return;
    }
    let entry = printed_sys[at];
    let value = entry.value * printed_p[u32(entry.column)];
    let row = u32(entry.row);
    var seen = atomicLoad(&printed_product_bits[row]);
    loop {
        let sum = bitcast<u32>(bitcast<f32>(seen) + value);
        let result = atomicCompareExchangeWeak(&printed_product_bits[row], seen, sum);
        if result.exchanged {
            break;
        }
        seen = result.old_value;
    }
}

@compute @workgroup_size(1024)
fn compute_alpha(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 1024u + lane;
    if i < arrayLength(&printed_p) {
        add_to_printed_sum(PRINTED_PAP, printed_p[i] * printed_product[i]);
    }
}

@compute @workgroup_size(1024)
fn update_lambda(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 1024u + lane;
    if i >= arrayLength(&printed_lambda) {
        return;
    }
    let alpha = printed_quotient(printed_sum(PRINTED_RR), printed_sum(PRINTED_PAP));
    printed_lambda[i] += alpha * printed_p[i];
    printed_residual[i] -= alpha * printed_product[i];
}

@compute @workgroup_size(1024)
fn compute_beta(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 1024u + lane;
    if i < arrayLength(&printed_residual) {
        add_to_printed_sum(PRINTED_NEW_RR, printed_residual[i] * printed_residual[i]);
    }
}

@compute @workgroup_size(1024)
fn update_p(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let i = workgroup_index(id) * 1024u + lane;
    if i >= arrayLength(&printed_p) {
        return;
    }
    let beta = printed_quotient(printed_sum(PRINTED_NEW_RR), printed_sum(PRINTED_RR));
    printed_p[i] = printed_residual[i] + beta * printed_p[i];
    printed_product[i] = 0.0;
}
