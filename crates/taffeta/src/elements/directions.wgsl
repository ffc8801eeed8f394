// Modes of elements that are solved for.

/// Directions of an element's modes over the step [kg^½], by mode, then by node, in xyz; in w weights of what resists alike in all
/// directions. Kernels of a kind see those of their kind.
@group(3) @binding(48) var<storage, read_write> element_directions: array<vec4f>;
