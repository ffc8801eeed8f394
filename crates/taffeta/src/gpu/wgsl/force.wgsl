// Forces that wait between kernels.

/// Force on each node [N], in xyz.
@group(3) @binding(1) var<storage, read_write> force: array<vec4f>;
