// Volumes of closed bodies.

#import diagnostics/few.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// Some triangles of one closed body, and a node of it: places are taken from there, so that no digits are lost far
/// from the origin.
struct Chunk {
    origin: u32,
    first: u32,
    count: u32,
}

@group(1) @binding(8) var<storage, read> chunks: array<Chunk>;
/// Corners of triangles, three by three.
@group(1) @binding(9) var<storage, read> corners: array<u32>;
/// Of each chunk of triangles: volume [m³].
@group(3) @binding(7) var<storage, read_write> volumes: array<f32>;

/// A workgroup for each chunk: Σ (a−o)·((b−o)×(c−o))/6.
@compute @workgroup_size(256)
fn measure_volumes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&chunks) {
        return;
    }
    let chunk = chunks[index];
    let origin = position_of(chunk.origin);
    var six = 0.0;
    for (var triangle = lane; triangle < chunk.count; triangle += 256u) {
        let at = 3u * (chunk.first + triangle);
        let a = position_of(corners[at]) - origin;
        let b = position_of(corners[at + 1u]) - origin;
        let c = position_of(corners[at + 2u]) - origin;
        six += dot3(a, cross3(b, c));
    }
    let all = gather_few(lane, vec2f(six, 0.0));
    if lane == 0u {
        volumes[index] = all.x / 6.0;
    }
}
