// Puts moving pins where their motion says, with the velocity of their way.

#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import motion/pins.wgsl

@group(0) @binding(4) var<storage, read> pins: array<Pin>;

@compute @workgroup_size(256)
fn pins_all(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= substeps[own()].pins {
        return;
    }
    let pin = pins[index];
    var x = on_the_way(pin.start, pin.goal, substeps[0].frame_fraction);
    var v = (pin.goal - pin.start) * substeps[0].frame_rate;
    if pin.track != MOVED_BY_USER {
        let motion = motions[substeps[0].first_motion + pin.track];
        x = affine(motion.x, motion.y, motion.z, pin.start);
        v = affine(motion.rate_x, motion.rate_y, motion.rate_z, pin.start);
    }
    new_position[pin.node] = vec4f(x, new_position[pin.node].w);
    if substeps[own()].pins_may_lag != 0u {
        v = catching_up(x, v, pin.start, old_position[pin.node].xyz, substeps[0].h);
    }
    new_velocity[pin.node] = vec4f(v, abs(new_velocity[pin.node].w));
}
