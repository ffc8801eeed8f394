// Air on triangles: a force for each, which all its corners share. Nodes gather them with their loads.

#import elements/aero/aero.wgsl
#import elements/forces.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// A triangle that air acts on: its corners, and 1/M [1/kg] of the mass that moves with it.
struct AeroTriangle {
    corners: array<u32, 3>,
    lightness: f32,
}

@group(1) @binding(60) var<storage, read> aero_triangles: array<AeroTriangle>;

const THIRD: f32 = 1.0 / 3.0;

@compute @workgroup_size(256)
fn aero_forces(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&aero_triangles) {
        return;
    }
    let triangle = aero_triangles[index];
    let a = position_of(triangle.corners[0]);
    let b = position_of(triangle.corners[1]);
    let c = position_of(triangle.corners[2]);
    let velocity =
        (velocity_of(triangle.corners[0]) + velocity_of(triangle.corners[1]) + velocity_of(triangle.corners[2])) * THIRD;
    let flow = air_velocity(substeps[own()].air, (a + b + c) * THIRD) - velocity;
    let force = corner_force(substeps[0].air, cross3(b - a, c - a), flow, triangle.lightness);
    element_forces[index] = vec4f(force, 0.0);
}
