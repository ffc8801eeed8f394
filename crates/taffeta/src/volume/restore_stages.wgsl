// The kernel that restores volumes after contact.

#import contact/colliders/resolve_contact_again.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import volume/groups.wgsl
#import volume/volume.wgsl

/// Moves nodes that are not in contact so that the volume is restored, and keeps them out of colliders again.
@compute @workgroup_size(256)
fn restore_volumes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id);
    if index >= arrayLength(&volume_groups) {
        return;
    }
    let group = volume_groups[index];
    if !is_flagged(group, RESTORED) {
        return;
    }
    let found = find_correction(group, lane);
    if lane >= group.count || is_restored(found.sums, found.goal) {
        return;
    }
    let lambda = projection(found.sums, found.goal);
    let place = group.first + lane;
    let x = new_position[place];
    let v = new_velocity[place];
    let direction = direction_of(group, found.correction, lane, x.xyz, abs(v.w));
    let factor = select(x.w, 0.0, v.w < 0.0) * lambda;
    resolve_contact_again(place, x, v, x.xyz + direction * factor, v.xyz);
}
