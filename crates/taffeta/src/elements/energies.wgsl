// Energies of elements.

/// Of each workgroup [J].
@group(3) @binding(6) var<storage, read_write> element_energies: array<f32>;
