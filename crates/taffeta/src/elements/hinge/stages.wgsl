// Hinges: forces on their corners, and energies.

#import diagnostics/few.wgsl
#import elements/directions.wgsl
#import elements/energies.wgsl
#import elements/forces.wgsl
#import elements/hinge/hinge.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// Corners a, b, left, right; fold angle [rad] and Σ|∇θ|² [rad²/m²] at rest; stiffness [N·m/rad] and damping [N·m·s/rad].
struct Hinge {
    corners: array<u32, 4>,
    rest_angle: f32,
    rest_steepness: f32,
    k: f32,
    damping: f32,
}

@group(1) @binding(4) var<storage, read> hinges: array<Hinge>;

fn fold_at(corners: array<u32, 4>) -> Fold {
    return fold_of(
        position_of(corners[0]),
        position_of(corners[1]),
        position_of(corners[2]),
        position_of(corners[3]),
    );
}

@compute @workgroup_size(256)
fn bend_hinges(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&hinges) {
        return;
    }
    let hinge = hinges[index];
    let fold = fold_at(hinge.corners);
    let rate = dot3(fold.at_a, velocity_of(hinge.corners[0])) + dot3(fold.at_b, velocity_of(hinge.corners[1]))
        + dot3(fold.at_c, velocity_of(hinge.corners[2])) + dot3(fold.at_d, velocity_of(hinge.corners[3]));
    let moment = hinge_moment(fold, rate, hinge.k, hinge.damping, hinge.rest_angle, hinge.rest_steepness);
    element_forces[4u * index] = vec4f(fold.at_a * -moment, 0.0);
    element_forces[4u * index + 1u] = vec4f(fold.at_b * -moment, 0.0);
    element_forces[4u * index + 2u] = vec4f(fold.at_c * -moment, 0.0);
    element_forces[4u * index + 3u] = vec4f(fold.at_d * -moment, 0.0);
}

@compute @workgroup_size(256)
fn hinge_directions(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&hinges) {
        return;
    }
    let hinge = hinges[index];
    let fold = fold_at(hinge.corners);
    let ratio = hinge_ratio(fold, hinge.rest_steepness);
    let h = substeps[0].solving.inner;
    let root = sqrt(h * (h * (ratio * hinge.k) + ratio * hinge.damping));
    element_directions[4u * index] = vec4f(fold.at_a * root, 0.0);
    element_directions[4u * index + 1u] = vec4f(fold.at_b * root, 0.0);
    element_directions[4u * index + 2u] = vec4f(fold.at_c * root, 0.0);
    element_directions[4u * index + 3u] = vec4f(fold.at_d * root, 0.0);
}

@compute @workgroup_size(256)
fn measure_hinges(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    var found = 0.0;
    for (var index = id.x * 256u + lane; index < arrayLength(&hinges); index += counts.x * 256u) {
        found += hinge_energy(fold_at(hinges[index].corners), hinges[index].k, hinges[index].rest_angle);
    }
    let all = gather_few(lane, vec2f(found, 0.0));
    if lane == 0u {
        element_energies[id.x] = all.x;
    }
}
