// Sums over the state, each workgroup's in a fixed order; the host adds up the workgroups in 64 bits.

#import gpu/wgsl/state.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// Of each workgroup over nodes: Σ m v², Σ m x (3), Σ m v (3), Σ m x × v (3), nodes that touch, nodes that are not finite.
@group(3) @binding(4) var<storage, read_write> node_sums: array<f32>;

const NUMBERS: u32 = 12u;
var<workgroup> many: array<array<f32, 12>, 256>;

@compute @workgroup_size(256)
fn measure_nodes(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    var sums: array<f32, 12>;
    for (var node = id.x * 256u + lane; node < arrayLength(&old_position); node += counts.x * 256u) {
        let x = position_of(node);
        let v = velocity_of(node);
        let signed_mass = old_velocity[node].w;
        let p = abs(signed_mass) * v;
        let turning = cross3(x, p);
        let m_x = abs(signed_mass) * x;
        let terms = array<f32, 12>(
            dot3(p, v), m_x.x, m_x.y, m_x.z, p.x, p.y, p.z, turning.x, turning.y, turning.z,
            select(0.0, 1.0, signed_mass < 0.0), select(0.0, 1.0, are_odd(x) || are_odd(v)),
        );
        for (var i = 0u; i < NUMBERS; i++) {
            sums[i] += terms[i];
        }
    }
    many[lane] = sums;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            for (var i = 0u; i < NUMBERS; i++) {
                many[lane][i] += many[lane + half][i];
            }
        }
    }
    workgroupBarrier();
    if lane < NUMBERS {
        node_sums[id.x * NUMBERS + lane] = many[0][lane];
    }
}

