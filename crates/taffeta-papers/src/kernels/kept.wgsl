// Sums over the bodies that keep their volume (see volume.wgsl).

/// Of each body, by their bits: volume [m³], Σ g·v* [m³/s], D [m⁴/kg].
@group(3) @binding(14) var<storage, read_write> kept_bits: array<atomic<u32>>;
/// The same as numbers, for kernels that do not add to them.
@group(3) @binding(15) var<storage, read_write> kept_numbers: array<f32>;
