// Air on panels. Nodes gather their forces with those of hinges, behind which they are (loads.wgsl).

/// A triangle that air acts on: its corners, and 1/M [1/kg] of the mass that moves with it.
struct Panel {
    a: u32,
    b: u32,
    c: u32,
    lightness: f32,
}

@group(1) @binding(60) var<storage, read> panels: array<Panel>;

const THIRD: f32 = 1.0 / 3.0;

@compute @workgroup_size(256)
fn blow_on_panels(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    let index = workgroup_index(id, counts) * 256u + lane;
    if index >= arrayLength(&panels) {
        return;
    }
    let panel = panels[index];
    let a = position_of(panel.a);
    let b = position_of(panel.b);
    let c = position_of(panel.c);
    let velocity = (velocity_of(panel.a) + velocity_of(panel.b) + velocity_of(panel.c)) * THIRD;
    let flow = air_velocity(substeps[0].air, (a + b + c) * THIRD) - velocity;
    let force = corner_force(substeps[0].air, cross3(b - a, c - a), flow, panel.lightness);
    element_forces[substeps[0].air.first_force + index] = vec4f(force, 0.0);
}
