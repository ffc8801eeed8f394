// Forces of elements that several nodes share. Nothing scatters: nodes gather them with their loads.

/// Force on each corner of each element, or on all corners of each [N], in xyz. Kernels of a kind see those of their kind.
@group(3) @binding(3) var<storage, read_write> element_forces: array<vec4f>;
