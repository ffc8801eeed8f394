// Bends: forces on their nodes, directions of their modes, and energies.

#import diagnostics/few.wgsl
#import elements/bending/bending.wgsl
#import elements/directions.wgsl
#import elements/energies.wgsl
#import elements/forces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// Corners, then the nodes across from each; angles at rest [rad]; the Σ|∇θ|² [rad²/m²] past which an edge gets no stiffer; L
/// [(N·m)^½] by columns; damping time [s].
struct Bend {
    corners: array<u32, 6>,
    rest_a: f32,
    rest_b: f32,
    rest_c: f32,
    steepest_a: f32,
    steepest_b: f32,
    steepest_c: f32,
    l11: f32,
    l21: f32,
    l31: f32,
    l22: f32,
    l32: f32,
    l33: f32,
    damping: f32,
}

@group(1) @binding(51) var<storage, read> bends: array<Bend>;

fn plate_of(one: Bend) -> Plate {
    return Plate(
        vec3f(one.rest_a, one.rest_b, one.rest_c),
        vec3f(one.steepest_a, one.steepest_b, one.steepest_c),
        vec3f(one.l11, one.l21, one.l31),
        vec3f(one.l22, one.l32, one.l33),
        one.damping,
    );
}

fn positions_at(corners: array<u32, 6>) -> Six {
    return Six(
        position_of(corners[0]),
        position_of(corners[1]),
        position_of(corners[2]),
        position_of(corners[3]),
        position_of(corners[4]),
        position_of(corners[5]),
    );
}

fn velocities_at(corners: array<u32, 6>) -> Six {
    return Six(
        velocity_of(corners[0]),
        velocity_of(corners[1]),
        velocity_of(corners[2]),
        velocity_of(corners[3]),
        velocity_of(corners[4]),
        velocity_of(corners[5]),
    );
}

@compute @workgroup_size(256)
fn bend_triangles(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&bends) {
        return;
    }
    let one = bends[index];
    let forces = bending_forces(plate_of(one), positions_at(one.corners), velocities_at(one.corners));
    element_forces[6u * index] = vec4f(forces.a, 0.0);
    element_forces[6u * index + 1u] = vec4f(forces.b, 0.0);
    element_forces[6u * index + 2u] = vec4f(forces.c, 0.0);
    element_forces[6u * index + 3u] = vec4f(forces.d, 0.0);
    element_forces[6u * index + 4u] = vec4f(forces.e, 0.0);
    element_forces[6u * index + 5u] = vec4f(forces.f, 0.0);
}

/// Keeps the directions of a mode over the step.
fn put_bend(at: u32, directions: Six, root: f32) {
    element_directions[at] = vec4f(directions.a * root, 0.0);
    element_directions[at + 1u] = vec4f(directions.b * root, 0.0);
    element_directions[at + 2u] = vec4f(directions.c * root, 0.0);
    element_directions[at + 3u] = vec4f(directions.d * root, 0.0);
    element_directions[at + 4u] = vec4f(directions.e * root, 0.0);
    element_directions[at + 5u] = vec4f(directions.f * root, 0.0);
}

@compute @workgroup_size(256)
fn bend_directions(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&bends) {
        return;
    }
    let one = bends[index];
    let plate = plate_of(one);
    let folds = folds_of(positions_at(one.corners), plate.steepest);
    let factors = factors_of(folds);
    let h = substeps[0].solving.inner;
    let root = sqrt(h * (h + plate.damping));
    let second = vec3f(0.0, plate.others.x, plate.others.y);
    let third = vec3f(0.0, 0.0, plate.others.z);
    put_bend(18u * index, sum_of_folds(folds, factors * plate.first), root);
    put_bend(18u * index + 6u, sum_of_folds(folds, factors * second), root);
    put_bend(18u * index + 12u, sum_of_folds(folds, factors * third), root);
}

@compute @workgroup_size(256)
fn measure_bends(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    var found = 0.0;
    for (var index = id.x * 256u + lane; index < arrayLength(&bends); index += counts.x * 256u) {
        found += bending_energy(plate_of(bends[index]), positions_at(bends[index].corners));
    }
    let all = gather_few(lane, vec2f(found, 0.0));
    if lane == 0u {
        element_energies[id.x] = all.x;
    }
}
