// Numbers that are to hold at the end of a sub-step.

/// Volumes to keep [m³], or pressures [Pa], of all sub-steps of a frame.
@group(0) @binding(7) var<storage, read> goals: array<f32>;
