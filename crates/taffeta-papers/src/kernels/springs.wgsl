// Springs as the papers have them, and the forces that they add up by compare and exchange (see spring_centric.wgsl).

/// A spring: the nodes at its ends, its length at rest [m], its kind.
struct Spring {
    a: u32,
    b: u32,
    rest_length: f32,
    kind: u32,
}

/// Springs that are alike: stiffness [N/m], damping [kg/s].
struct SpringKind {
    k: f32,
    damping: f32,
}

@group(1) @binding(10) var<storage, read> springs: array<Spring>;
@group(1) @binding(11) var<storage, read> spring_kinds: array<SpringKind>;
/// Force of the springs on each node [N], three numbers each, by their bits.
@group(3) @binding(10) var<storage, read_write> force_bits: array<atomic<u32>>;
/// The same as numbers, for the kernel that has each node to itself.
@group(3) @binding(11) var<storage, read_write> force_numbers: array<f32>;

fn add_by_exchange(index: u32, value: f32) {
    var seen = atomicLoad(&force_bits[index]);
    loop {
        let sum = bitcast<u32>(bitcast<f32>(seen) + value);
        let result = atomicCompareExchangeWeak(&force_bits[index], seen, sum);
        if result.exchanged {
            break;
        }
        seen = result.old_value;
    }
}

fn add_force(node: u32, f: vec3f) {
    add_by_exchange(3u * node, f.x);
    add_by_exchange(3u * node + 1u, f.y);
    add_by_exchange(3u * node + 2u, f.z);
}
