// Vertex normals: node-centric, area-weighted (Va, Choi, Hong 2021, sec. 3.5).

#import gpu/wgsl/normal.wgsl

/// Places of triangles' corners, three by three.
@group(1) @binding(0) var<storage, read> triangle_places: array<u32>;
/// Where each node's row in `node_corners` begins; one more than there are nodes.
@group(1) @binding(1) var<storage, read> corner_starts: array<u32>;
/// Corners at each node: 3·triangle + corner.
@group(1) @binding(2) var<storage, read> node_corners: array<u32>;
@group(2) @binding(0) var<storage, read> old_position: array<vec4f>;
@group(3) @binding(0) var<storage, read_write> normals: array<vec4f>;

/// Unit normal of each node, the sum over its triangles of normal times area; +y where a node has none.
@compute @workgroup_size(256)
fn vertex_normals(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let node = (id.x + id.y * counts.x) * 256u + lane;
    if node >= arrayLength(&normals) {
        return;
    }
    var sum = vec3f(0.0);
    for (var at = corner_starts[node]; at < corner_starts[node + 1u]; at++) {
        let first = node_corners[at] / 3u * 3u;
        let a = old_position[triangle_places[first]].xyz;
        let b = old_position[triangle_places[first + 1u]].xyz;
        let c = old_position[triangle_places[first + 2u]].xyz;
        sum = add_normal(sum, a, b, c);
    }
    normals[node] = vec4f(unit_or_up(sum), 0.0);
}
