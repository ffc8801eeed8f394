// The state before and after a sub-step, one after the other.

/// Position [m], and the inverse mass [1/kg] in w; 0: held, or no node.
@group(2) @binding(0) var<storage, read> old_position: array<vec4f>;
/// Velocity [m/s], and the mass [kg] in w; below 0: the node has touched a collider in the last sub-step.
@group(2) @binding(1) var<storage, read> old_velocity: array<vec4f>;
@group(2) @binding(2) var<storage, read_write> new_position: array<vec4f>;
@group(2) @binding(3) var<storage, read_write> new_velocity: array<vec4f>;
