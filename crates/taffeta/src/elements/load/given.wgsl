// Where loads were summed up beforehand.

/// Force on each node [N], in xyz.
@group(3) @binding(0) var<storage, read> load: array<vec4f>;

fn load_on(node: u32, velocity: vec3f, substep: u32) -> vec3f {
    return load[node].xyz;
}
