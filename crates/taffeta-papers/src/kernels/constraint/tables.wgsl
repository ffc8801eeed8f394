// The system of constraints, and what it is made of (see system.wgsl).

/// An entry of the system in COO, all three as numbers.
struct PrintedTriplet {
    row: f32,
    column: f32,
    value: f32,
}

/// IA: where each row of J begins in A and JA.
@group(1) @binding(20) var<storage, read> printed_ia: array<u32>;
/// JA: columns of A, three for each node.
@group(1) @binding(21) var<storage, read> printed_ja: array<u32>;
/// JB: where each column of Jᵀ begins in A and IB.
@group(1) @binding(22) var<storage, read> printed_jb: array<u32>;
/// IB: rows of Jᵀ.
@group(1) @binding(23) var<storage, read> printed_ib: array<u32>;
/// Φ [m²].
@group(3) @binding(20) var<storage, read_write> printed_phi: array<f32>;
/// A: the values of J [m], and of Jᵀ.
@group(3) @binding(21) var<storage, read_write> printed_j: array<f32>;
/// v/h + M⁻¹ F [m/s²], three numbers a node.
@group(3) @binding(22) var<storage, read_write> printed_vect: array<f32>;
/// The right side [m²/s²].
@group(3) @binding(23) var<storage, read_write> printed_rhs: array<f32>;
/// λ [N/m].
@group(3) @binding(24) var<storage, read_write> printed_lambda: array<f32>;
/// The system's matrix [m²/kg].
@group(3) @binding(25) var<storage, read_write> printed_sys: array<PrintedTriplet>;
/// How many entries it has.
@group(3) @binding(26) var<storage, read_write> printed_nnz: atomic<u32>;
