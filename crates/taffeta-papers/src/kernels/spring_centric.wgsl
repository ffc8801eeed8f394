// The spring-centric kernels of 2023, to compare with: a thread for each spring.
//
// Source: Va, Choi, Hong, "Real-Time Surface-Based Volume Constraints on Mass-Spring Model in Unity3D", 2023 (S3).
// From it is the structure alone:
// - table 2: ComputeSpringForce() over springs, then UpdateNodes() over nodes, each in workgroups of 1,024 threads;
// - table 1 and sec. IV: a buffer of springs with two nodes and a length; one of forces, in which a force is added to by
//   compare and exchange of unsigned integers, for want of an atomic sum of floats;
// - algorithm 3: a spring adds its force to the one end and subtracts it from the other.
// Not from it: the formulas, which are the engine's own (elements/spring, solvers/explicit, contact/colliders), and a fourth
// number for each spring, that of its kind, as stiffness differs by kind here. The paper does not say where forces are
// set back to zero: UpdateNodes() does it, having read them, which takes no further kernel.
//
// Sums come in the order in which threads arrive. This is the one place with sums of floats by atomics, for the
// comparison's sake: two runs differ in rounding, and no state hash is promised.

#import contact/colliders/response.wgsl
#import elements/spring/spring.wgsl
#import papers/kept.wgsl
#import papers/springs.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/state.wgsl
#import solvers/explicit/node.wgsl
#import loads
#import memory
#import resolve_contact

@compute @workgroup_size(1024)
fn spring_centric_forces(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 1024u + lane;
    if index >= arrayLength(&springs) {
        return;
    }
    let spring = springs[index];
    let kind = spring_kinds[spring.kind];
    let d = position_of(spring.b) - position_of(spring.a);
    let dv = velocity_of(spring.b) - velocity_of(spring.a);
    let f = spring_factor(d, dv, kind.k, kind.damping, spring.rest_length) * d;
    add_force(spring.a, f);
    add_force(spring.b, -f);
}

/// Works in place, as one buffer for positions and one for velocities is all that the paper has.
@compute @workgroup_size(1024)
fn spring_centric_update(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let node = workgroup_index(id) * 1024u + lane;
    if node >= arrayLength(&new_position) {
        return;
    }
    let x = new_position[node];
    let v = new_velocity[node];
    let at = 3u * node;
    let springs_pull = vec3f(force_numbers[at], force_numbers[at + 1u], force_numbers[at + 2u]);
    force_numbers[at] = 0.0;
    force_numbers[at + 1u] = 0.0;
    force_numbers[at + 2u] = 0.0;
    if node < arrayLength(&kept_numbers) {
        kept_numbers[node] = 0.0;
    }
    let moved = integrate(x, v, load_on(node, v.xyz, 0u) + springs_pull, 0u);
    let after = resolve_contact(node, moved, Origin(x.xyz, true), 0u);
    new_position[node] = after.position;
    new_velocity[node] = after.velocity;
}
