// Nodes that closed seams make one point: in the system they change their velocity alike (sewn.rs).

#import gpu/wgsl/vector.wgsl
#import solvers/implicit/implicit.wgsl

/// A matrix by rows: what part of a point's residual some nodes have.
struct Weight {
    x: vec3f,
    y: vec3f,
    z: vec3f,
}

/// Of two blocks the weight of the first, and the inverse of their sum.
struct Parallel {
    weight: Weight,
    together: Symmetric,
}

/// Where in `sewn_nodes` the nodes of each point begin, and where the last one's end.
@group(1) @binding(80) var<storage, read> sewn_starts: array<u32>;
/// Nodes of points, those of each ascending.
@group(1) @binding(81) var<storage, read> sewn_nodes: array<u32>;
/// By node of points: the weight of the nodes before it.
@group(3) @binding(80) var<storage, read_write> sewn_weights: array<Weight>;

fn weight_times(m: Weight, v: vec3f) -> vec3f {
    return vec3f(dot3(m.x, v), dot3(m.y, v), dot3(m.z, v));
}

fn transposed_times(m: Weight, v: vec3f) -> vec3f {
    return m.x * v.x + m.y * v.y + m.z * v.z;
}

/// W = B (A + B)⁻¹ and W A, of inverses A and B.
fn parallel(a: Symmetric, b: Symmetric) -> Parallel {
    if a.diagonal.x + a.diagonal.y + a.diagonal.z <= 0.0 {
        // What nothing moves takes all; of two such the first.
        let all = Weight(vec3f(1.0, 0.0, 0.0), vec3f(0.0, 1.0, 0.0), vec3f(0.0, 0.0, 1.0));
        return Parallel(all, Symmetric(vec3f(0.0), vec3f(0.0)));
    }
    let sum = inverse_of(sum_of(a, b));
    let weight = Weight(
        times(sum, vec3f(b.diagonal.x, b.mixed.x, b.mixed.y)),
        times(sum, vec3f(b.mixed.x, b.diagonal.y, b.mixed.z)),
        times(sum, vec3f(b.mixed.y, b.mixed.z, b.diagonal.z)),
    );
    // A row of W times A, as A is symmetric.
    let x = times(a, weight.x);
    let y = times(a, weight.y);
    let z = times(a, weight.z);
    let mixed = vec3f((x.y + y.x) * 0.5, (x.z + z.x) * 0.5, (y.z + z.y) * 0.5);
    return Parallel(weight, Symmetric(vec3f(x.x, y.y, z.z), mixed));
}
