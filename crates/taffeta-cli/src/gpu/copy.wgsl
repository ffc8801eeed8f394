// The least that a kernel can do with memory: each number read once and written once.

@group(2) @binding(0) var<storage, read> copied_from: array<vec4f>;
@group(2) @binding(1) var<storage, read_write> copied_to: array<vec4f>;

@compute @workgroup_size(256)
fn copy(@builtin(workgroup_id) group: vec3u, @builtin(local_invocation_index) local: u32) {
    let index = (group.x + group.y * 32768u) * 256u + local;
    if index < arrayLength(&copied_to) {
        copied_to[index] = copied_from[index];
    }
}
