// Several sub-steps at once on small meshes, each whole in the memory of a workgroup.

#import contact/collider_mesh/no_mesh.wgsl as meshes
#import elements/load/alone.wgsl as loads
#import solvers/explicit/reach_patch.wgsl as memory
#import contact/colliders/response.wgsl
#import elements/spring/mesh.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import solvers/explicit/node.wgsl
#import resolve_contact

/// A mesh: its first place, and its number of places.
struct ResidentMesh {
    first: u32,
    count: u32,
}

@group(1) @binding(1) var<storage, read> resident_meshes: array<ResidentMesh>;

@compute @workgroup_size(256)
fn mesh_patches(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&resident_meshes) {
        return;
    }
    let small = resident_meshes[index];
    patch_base = small.first;
    for (var place = lane; place < small.count; place += 256u) {
        keep(place, old_position[small.first + place], old_velocity[small.first + place].xyz);
    }
    var after: array<Node, 4>;
    let steps = min(STEPS, substeps[own()].left);
    for (var substep = 0u; substep < steps; substep++) {
        workgroupBarrier();
        for (var i = 0u; i < OWN; i++) {
            let place = i * 256u + lane;
            if place < small.count {
                let node = kept(place);
                let load = load_on(0u, node.velocity.xyz, substep);
                let total =
                    add_mesh_springs(load, small.first + place, node.position.xyz, node.velocity.xyz);
                let moved = integrate(node.position, node.velocity, total, substep);
                after[i] = resolve_contact(small.first + place, moved, Origin(node.position.xyz, true), substep);
            }
        }
        workgroupBarrier();
        for (var i = 0u; i < OWN; i++) {
            let place = i * 256u + lane;
            if place < small.count {
                keep(place, after[i].position, after[i].velocity.xyz);
            }
        }
    }
    for (var i = 0u; i < OWN; i++) {
        let place = i * 256u + lane;
        if place < small.count {
            release(small.first + place, after[i]);
        }
    }
}
