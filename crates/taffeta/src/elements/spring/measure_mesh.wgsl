// Energy and stretch of the springs of meshes.

#import diagnostics/few.wgsl
#import elements/spring/mesh.wgsl
#import elements/spring/places.wgsl
#import elements/spring/spring.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// Of each workgroup over springs: energy [J], largest stretch l/L.
@group(3) @binding(8) var<storage, read_write> mesh_spring_sums: array<vec2f>;

@compute @workgroup_size(256)
fn measure_mesh_springs(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    var found = vec2f(0.0);
    for (var node = id.x * 256u + lane; node < arrayLength(&old_position); node += counts.x * 256u) {
        if is_of_mesh(node) {
            let own = row_springs(node);
            found = vec2f(found.x + own.x, max(found.y, own.y));
        }
    }
    let all = gather_few(lane, found);
    if lane == 0u {
        mesh_spring_sums[id.x] = all;
    }
}

/// Energy and stretch of the springs at a node. Each is met from both ends: half its energy each time.
fn row_springs(node: u32) -> vec2f {
    var found = vec2f(0.0);
    for (var kind = 0u; kind < KINDS; kind++) {
        let run = runs[node / LANES * KINDS + kind];
        for (var i = 0u; i < (run.count & ~IS_RING); i++) {
            let entry = entries[run.start + LANES * i + node % LANES];
            if entry.rest_length > 0.0 {
                let length = norm3(position_of(entry.neighbour) - position_of(node));
                let energy = 0.5 * spring_energy(length, run.k, entry.rest_length);
                found = vec2f(found.x + energy, max(found.y, length / entry.rest_length));
            }
        }
    }
    return found;
}
