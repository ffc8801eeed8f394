// Springs of a mesh, gathered by node from a sliced-ELL table: each node adds up the springs of its row, sixteen nodes
// side by side (cpu_mesh.rs).

#import elements/spring/spring.wgsl
#import gpu/wgsl/index.wgsl
#import memory

/// The springs of one kind of a slice of 16 nodes: entry `i` of the slice's `lane` is at start + 16·i + lane.
struct Run {
    start: u32,
    count: u32,
    /// [N/m]
    k: f32,
    /// [kg/s]
    damping: f32,
}

/// A spring as one of its ends sees it. Padding leads to the node itself, with rest length 0.
struct Entry {
    neighbour: u32,
    /// [m]
    rest_length: f32,
}

@group(1) @binding(2) var<storage, read> runs: array<Run>;
@group(1) @binding(3) var<storage, read> entries: array<Entry>;

/// Runs of each slice.
override KINDS: u32 = 1u;

/// The force so far [N] and that of all springs at a node.
fn add_mesh_springs(before: vec3f, node: u32, x: vec3f, v: vec3f) -> vec3f {
    return add_kinds(before, 0u, node, x, v);
}

/// The same for the springs of some kinds, from `first` on.
fn add_kinds(before: vec3f, first: u32, node: u32, x: vec3f, v: vec3f) -> vec3f {
    var total = before;
    for (var kind = first; kind < KINDS; kind++) {
        let run = runs[node / LANES * KINDS + kind];
        var sum = vec3f(0.0);
        for (var i = 0u; i < run.count; i++) {
            let entry = entries[run.start + LANES * i + node % LANES];
            let d = position_of(entry.neighbour) - x;
            let dv = velocity_of(entry.neighbour) - v;
            sum += spring_factor(d, dv, run.k, run.damping, entry.rest_length) * d;
        }
        total += sum;
    }
    return total;
}
