// Vertices of a body as a renderer draws them: between two states, in the renderer's coordinates, with normals as in
// normals.wgsl. Triangles, corner_starts and node_corners are those of normals.wgsl.

#import gpu/wgsl/index.wgsl
#import gpu/wgsl/normal.wgsl
#import gpu/wgsl/vector.wgsl

/// Rows of the maps of positions and of normals into the renderer's coordinates; alpha between the state before and
/// the present one; and where the first vertex is in `vertices`, how many words there are from one to the next, and
/// from its position to its normal.
struct Drawing {
    place_x: vec4f,
    place_y: vec4f,
    place_z: vec4f,
    normal_x: vec4f,
    normal_y: vec4f,
    normal_z: vec4f,
    alpha: f32,
    first: u32,
    stride: u32,
    normal: u32,
}

@group(0) @binding(8) var<storage, read> drawing: array<Drawing>;
@group(1) @binding(0) var<storage, read> triangle_places: array<u32>;
@group(1) @binding(1) var<storage, read> corner_starts: array<u32>;
@group(1) @binding(2) var<storage, read> node_corners: array<u32>;
/// Place and node of each vertex; the largest number twice where it has none and stays where the renderer has it.
@group(1) @binding(3) var<storage, read> drawn_nodes: array<vec2u>;
@group(2) @binding(0) var<storage, read> old_position: array<vec4f>;
@group(2) @binding(2) var<storage, read> new_position: array<vec4f>;
@group(3) @binding(0) var<storage, read_write> vertices: array<f32>;

fn shown(place: u32) -> vec3f {
    let before = old_position[place].xyz;
    return before + drawing[0].alpha * (new_position[place].xyz - before);
}

/// Place and unit normal of each vertex. One that is not finite is left as it was drawn last.
@compute @workgroup_size(256)
fn draw_vertices(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let vertex = (id.x + id.y * counts.x) * 256u + lane;
    if vertex >= arrayLength(&drawn_nodes) || drawn_nodes[vertex].x == NONE {
        return;
    }
    let node = drawn_nodes[vertex].y;
    var sum = vec3f(0.0);
    for (var at = corner_starts[node]; at < corner_starts[node + 1u]; at++) {
        let first = node_corners[at] / 3u * 3u;
        let a = shown(triangle_places[first]);
        let b = shown(triangle_places[first + 1u]);
        let c = shown(triangle_places[first + 2u]);
        sum = add_normal(sum, a, b, c);
    }
    let view = drawing[0];
    let x = shown(drawn_nodes[vertex].x);
    let turned = vec3f(dot3(view.normal_x.xyz, sum), dot3(view.normal_y.xyz, sum), dot3(view.normal_z.xyz, sum));
    if are_odd(x) || are_odd(turned) {
        return;
    }
    let n = unit_or_up(turned);
    let place = view.first + vertex * view.stride;
    vertices[place] = dot3(view.place_x.xyz, x) + view.place_x.w;
    vertices[place + 1u] = dot3(view.place_y.xyz, x) + view.place_y.w;
    vertices[place + 2u] = dot3(view.place_z.xyz, x) + view.place_z.w;
    vertices[place + view.normal] = n.x;
    vertices[place + view.normal + 1u] = n.y;
    vertices[place + view.normal + 2u] = n.z;
}
