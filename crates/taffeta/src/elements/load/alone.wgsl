// Where nothing but wind and drag acts on nodes beside springs.

#import elements/load/load.wgsl
#import gpu/wgsl/substep.wgsl

fn load_on(node: u32, velocity: vec3f, substep: u32) -> vec3f {
    return wind_and_drag(substeps[substep].wind, substeps[substep].drag, velocity);
}
