// The state of conjugate gradients, and sums over all constraints (see solve.wgsl).

/// Numbers of `printed_sums`: r·r before the iteration, p·Ap, r·r after it, |b|².
const PRINTED_RR: u32 = 0u;
const PRINTED_PAP: u32 = 1u;
const PRINTED_NEW_RR: u32 = 2u;
const PRINTED_BB: u32 = 3u;

@group(3) @binding(27) var<storage, read_write> printed_residual: array<f32>;
/// The direction p.
@group(3) @binding(28) var<storage, read_write> printed_p: array<f32>;
/// A p, by its bits.
@group(3) @binding(29) var<storage, read_write> printed_product_bits: array<atomic<u32>>;
/// The same as numbers, for kernels that have each constraint to themselves.
@group(3) @binding(30) var<storage, read_write> printed_product: array<f32>;
/// Sums over all constraints, by their bits.
@group(3) @binding(31) var<storage, read_write> printed_sums: array<atomic<u32>>;

fn add_to_printed_sum(index: u32, value: f32) {
    var seen = atomicLoad(&printed_sums[index]);
    loop {
        let sum = bitcast<u32>(bitcast<f32>(seen) + value);
        let result = atomicCompareExchangeWeak(&printed_sums[index], seen, sum);
        if result.exchanged {
            break;
        }
        seen = result.old_value;
    }
}

fn printed_sum(index: u32) -> f32 {
    return bitcast<f32>(atomicLoad(&printed_sums[index]));
}

fn printed_quotient(a: f32, b: f32) -> f32 {
    return select(0.0, a / select(1.0, b, b > 0.0), b > 0.0);
}

/// What the last iteration has found is what this one starts from.
fn start_printed_iteration() {
    atomicStore(&printed_sums[PRINTED_RR], atomicLoad(&printed_sums[PRINTED_NEW_RR]));
    atomicStore(&printed_sums[PRINTED_NEW_RR], 0u);
    atomicStore(&printed_sums[PRINTED_PAP], 0u);
}
