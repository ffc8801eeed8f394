// Contacts as part of an implicit step, in the order of operations of solved.rs.

#import contact/triangles/impulse.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/implicit/implicit.wgsl

/// κ, relative to the mass that the diagonal of the system makes of a contact.
const STIFFNESS: f32 = 4.0;
/// Share of a force that the sub-step after the first starts from.
const NEW: f32 = 0.125;
/// A contact some of whose nodes colliders hold, and which makes them so many times as hard to move as alone, is none of the system.
const STIFF: f32 = 256.0;

/// A contact that may come about in a sub-step.
struct SolvedContact {
    nodes: vec4u,
    weights: vec4f,
    /// Unit normal, from the second side to the first.
    normal: vec3f,
    /// Distance of the sides less their thickness where the sub-step begins [m].
    gap: f32,
    /// λ [N·s].
    first: vec3f,
    /// How far an old overlap is to be removed in the sub-step [m].
    lead: f32,
    /// p where the Newton step starts [N·s], and how much it takes back of relative velocities along the normal and across it [kg].
    impulse: vec3f,
    along: f32,
    /// p with what the Newton step has changed [N·s].
    applied: vec3f,
    across: f32,
    friction: f32,
    /// κ [kg].
    stiffness: f32,
    /// A system that it is part of; NONE of a contact that is none of any.
    system: u32,
    /// 1 if one of its sides cannot move, so that coarser levels know of it, too.
    is_held: u32,
}

/// By contact of `surface_contacts`.
@group(3) @binding(77) var<storage, read_write> solved_contacts: array<SolvedContact>;

/// With κ, by the inverse masses [1/kg] of the nodes, the inverse diagonal blocks of these in the system, and whether colliders hold
/// them. A contact that would hardly give way because they do is left to the rounds after the solver.
fn stiffened(one: SolvedContact, inverse_mass: vec4f, blocks: array<Symmetric, 4>, is_held: vec4<bool>) -> SolvedContact {
    var sum = 0.0;
    var most = 0.0;
    var alone = 0.0;
    var first_moves = false;
    var second_moves = false;
    for (var i = 0u; i < 4u; i++) {
        let weight = one.weights[i];
        let by_impulse = times(blocks[i], one.normal);
        sum += weight * weight * dot3(one.normal, by_impulse);
        most = max(most, abs(weight) * norm3(by_impulse));
        alone += weight * weight * inverse_mass[i];
        let moves = weight * inverse_mass[i] != 0.0;
        first_moves = first_moves || (moves && weight >= 0.0);
        second_moves = second_moves || (moves && weight < 0.0);
    }
    let compliance = max(sum, most / LEVER);
    let any_held = any(is_held & (one.weights * inverse_mass != vec4f(0.0)));
    let gives_way = compliance * STIFF > select(0.0, alone, any_held) && alone > 0.0;
    var found = one;
    found.is_held = select(1u, 0u, first_moves && second_moves);
    found.stiffness = select(0.0, STIFFNESS / select(1.0, compliance, gives_way), gives_way);
    return found;
}

/// With the impulse where the gap would become `gap` [m] in a step of `h` [s], at this relative velocity [m/s].
fn linearised(one: SolvedContact, gap: f32, velocity: vec3f, h: f32) -> SolvedContact {
    let n = one.normal;
    let kappa = one.stiffness;
    let least = one.lead + min(one.gap, 0.0);
    let along = dot3(one.first, n);
    let wanted = along + kappa * ((least - gap) / h);
    let pressed = select(0.0, max(wanted, 0.0), kappa > 0.0);
    let slip = velocity - n * dot3(velocity, n);
    let drag = slip * kappa - (one.first - n * along);
    let length = norm3(drag);
    let most = one.friction * pressed;
    let part = select(1.0, most / select(1.0, length, length > most), length > most);
    let acts = pressed > 0.0;
    var found = one;
    found.impulse = n * pressed - drag * part;
    found.along = select(0.0, kappa, acts);
    found.across = select(0.0, kappa * part, acts);
    found.applied = found.impulse;
    return found;
}

/// What a contact takes back of a relative velocity [N·s].
fn taken_back(one: SolvedContact, velocity: vec3f) -> vec3f {
    let along = one.normal * dot3(velocity, one.normal);
    return along * one.along + (velocity - along) * one.across;
}

/// The diagonal block of one of its nodes with its share of the contact.
fn with_share(one: SolvedContact, corner: u32, block: Symmetric) -> Symmetric {
    let weight = abs(one.weights[corner]);
    let across = weight * one.across;
    let more = weight * (one.along - one.across);
    let n = one.normal;
    return Symmetric(
        block.diagonal + more * (n * n) + across,
        block.mixed + more * vec3f(n.x * n.y, n.x * n.z, n.y * n.z),
    );
}

/// The inverse of a matrix to which `by` times q qᵀ is added (Sherman and Morrison, 1950).
fn inverse_with(inverse: Symmetric, q: vec3f, by: f32) -> Symmetric {
    let y = times(inverse, q);
    let part = by / (1.0 + by * dot3(q, y));
    return Symmetric(
        inverse.diagonal - part * (y * y),
        inverse.mixed - part * vec3f(y.x * y.y, y.x * y.z, y.y * y.z),
    );
}

/// The inverse of a diagonal block with its share of the contact.
fn softened(one: SolvedContact, corner: u32, inverse: Symmetric) -> Symmetric {
    let weight = abs(one.weights[corner]);
    let n = one.normal;
    let axis = select(vec3f(0.0, 1.0, 0.0), vec3f(1.0, 0.0, 0.0), abs(n.x) < abs(n.y));
    let perpendicular = cross3(n, axis);
    let first = perpendicular * (1.0 / norm3(perpendicular));
    var all = inverse_with(inverse, n, weight * one.along);
    if one.across > 0.0 {
        all = inverse_with(all, first, weight * one.across);
        all = inverse_with(all, cross3(n, first), weight * one.across);
    }
    return all;
}

/// The force that a sub-step starts from [N], of what a contact had in the last one and before that.
fn sustained(force: vec3f, last: vec3f) -> vec3f {
    let most = 2.0 * norm3(last) + NEW * norm3(force);
    let length = norm3(force);
    return select(force, force * (most / select(1.0, length, length > most)), length > most);
}
