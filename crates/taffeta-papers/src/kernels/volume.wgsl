// The volume constraint's kernels of 2023, to compare with: one thread a triangle, then one a node.
//
// Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023 (S3).
// From it is the structure alone:
// - table 2: ComputeVolume(), ComputeJacobian(), BuildSystem() and AccumulateForce() between ComputeSpringForce() and
//   UpdateNodes(), each in workgroups of 1,024 threads;
// - table 3: a volume for the body, and a buffer of Jacobian vectors of three numbers;
// - algorithm 4: a triangle adds its part to the volume by compare and exchange;
// - algorithm 5: a node loops over its triangles, and looks which of their corners it is;
// - sec. IV: BuildSystem() adds both sides of eq. 14 the same way, and AccumulateForce() divides them in every thread.
// Not from it: the formulas, which are the engine's own (volume/volume.wgsl): in algorithm 4 the printed
// normalisation does not give a volume, and eq. 10 is the gradient times -3. Bodies have a number each, where the paper
// has one body. It does not say where sums are set back to zero: UpdateNodes() does it.

#import papers/kept.wgsl
#import papers/springs.wgsl
#import gpu/wgsl/goals.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/explicit/euler.wgsl
#import volume/volume.wgsl
#import loads
#import memory

/// A triangle of a body that keeps its volume: its corners, and which body it is of.
struct KeptTriangle {
    a: u32,
    b: u32,
    c: u32,
    body: u32,
}

/// A body: the node from which places are counted, and how its multiplier is found.
struct KeptBody {
    origin: u32,
    form: u32,
}

/// In `kept_of_node`: a node of no such body.
const NOT_KEPT: u32 = 0xffffffffu;

@group(1) @binding(13) var<storage, read> kept_triangles: array<KeptTriangle>;
@group(1) @binding(14) var<storage, read> kept_bodies: array<KeptBody>;
@group(1) @binding(15) var<storage, read> kept_of_node: array<u32>;
/// For each place, where its row in `triangles_of_node` begins; one more than there are places.
@group(1) @binding(16) var<storage, read> triangle_starts: array<u32>;
@group(1) @binding(17) var<storage, read> triangles_of_node: array<u32>;
/// Three numbers a place [m²].
@group(3) @binding(13) var<storage, read_write> jacobians: array<f32>;

fn add_to_body(index: u32, value: f32) {
    var seen = atomicLoad(&kept_bits[index]);
    loop {
        let sum = bitcast<u32>(bitcast<f32>(seen) + value);
        let result = atomicCompareExchangeWeak(&kept_bits[index], seen, sum);
        if result.exchanged {
            break;
        }
        seen = result.old_value;
    }
}

fn jacobian_of(node: u32) -> vec3f {
    return vec3f(jacobians[3u * node], jacobians[3u * node + 1u], jacobians[3u * node + 2u]);
}

fn force_of(node: u32) -> vec3f {
    return vec3f(force_numbers[3u * node], force_numbers[3u * node + 1u], force_numbers[3u * node + 2u]);
}

@compute @workgroup_size(1024)
fn compute_volume(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 1024u + lane;
    if index >= arrayLength(&kept_triangles) {
        return;
    }
    let triangle = kept_triangles[index];
    let origin = position_of(kept_bodies[triangle.body].origin);
    let a = position_of(triangle.a) - origin;
    let b = position_of(triangle.b) - origin;
    let c = position_of(triangle.c) - origin;
    add_to_body(3u * triangle.body, dot3(a, cross3(b, c)) / 6.0);
}

@compute @workgroup_size(1024)
fn compute_jacobian(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = workgroup_index(id) * 1024u + lane;
    if node >= arrayLength(&old_position) {
        return;
    }
    let x = position_of(node);
    var sum = vec3f(0.0);
    for (var i = triangle_starts[node]; i < triangle_starts[node + 1u]; i++) {
        let triangle = kept_triangles[triangles_of_node[i]];
        if node == triangle.a {
            sum += cross3(position_of(triangle.b) - x, position_of(triangle.c) - x) / 6.0;
        } else if node == triangle.b {
            sum += cross3(position_of(triangle.c) - x, position_of(triangle.a) - x) / 6.0;
        } else {
            sum += cross3(position_of(triangle.a) - x, position_of(triangle.b) - x) / 6.0;
        }
    }
    jacobians[3u * node] = sum.x;
    jacobians[3u * node + 1u] = sum.y;
    jacobians[3u * node + 2u] = sum.z;
}

@compute @workgroup_size(1024)
fn build_system(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = workgroup_index(id) * 1024u + lane;
    if node >= arrayLength(&old_position) || kept_of_node[node] == NOT_KEPT {
        return;
    }
    let v = velocity_of(node);
    let inverse_mass = old_position[node].w;
    let total = load_on(node, v, 0u) + force_of(node);
    let velocity = new_velocity_of(v, total, inverse_mass, substeps[0].gravity, substeps[0].h);
    let g = jacobian_of(node);
    let at = 3u * kept_of_node[node];
    add_to_body(at + 1u, dot3(g, velocity));
    add_to_body(at + 2u, inverse_mass * dot3(g, g));
}

@compute @workgroup_size(1024)
fn accumulate_force(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = workgroup_index(id) * 1024u + lane;
    if node >= arrayLength(&kept_of_node) || kept_of_node[node] == NOT_KEPT {
        return;
    }
    let body = kept_of_node[node];
    let at = 3u * body;
    let sums = vec3f(3.0 * kept_numbers[at], kept_numbers[at + 1u], kept_numbers[at + 2u]);
    let goal = goals[substeps[0].first_goal + body];
    let f = force_of(node) - jacobian_of(node) * multiplier(kept_bodies[body].form, sums, goal, substeps[0].h);
    force_numbers[3u * node] = f.x;
    force_numbers[3u * node + 1u] = f.y;
    force_numbers[3u * node + 2u] = f.z;
}
