// The impulses of contacts, in the order of operations of impulse.rs.

#import gpu/wgsl/vector.wgsl

/// Part of an old overlap that is removed in a sub-step; what stays of it, relative to the thickness; the shortest time in which
/// a contact separates by its thickness [s].
const CONTACT_FIRM: f32 = 0.2;
const SLOP: f32 = 0.01;
const RELEASE: f32 = 0.02;
/// A contact that carried an impulse remains one up to this distance, relative to the thickness.
const KEEPS: f32 = 1.05;
const LEVER: f32 = 2.0;

/// A contact of the sub-step, with its nodes.
struct SurfaceContact {
    nodes: vec4u,
    weights: vec4f,
    /// Unit normal, from the second side to the first.
    normal: vec3f,
    /// Distance of the sides less their thickness where the sub-step begins [m].
    gap: f32,
    /// Impulse on the first side [N·s].
    impulse: vec3f,
    /// How much the relative velocity changes by an impulse [1/kg].
    mobility: f32,
    /// Force that the sub-step starts from [N].
    force: vec3f,
    /// Thickness [m].
    thickness: f32,
    /// Its two leaves, and what it is in them.
    order: vec3u,
    friction: f32,
    /// The impulse that the solver of an implicit sub-step has given it [N·s].
    solved: vec3f,
    /// What removes old overlaps, along the normal [kg·m].
    push: f32,
    /// 1: it leads back what passes through a surface, and keeps no force.
    leads: u32,
    /// How much friction [N·s] there is beside that of its impulse: what the solver has left of it.
    grip: f32,
}

/// What an impulse along a normal leaves of friction [N·s].
fn grip_of(impulse: vec3f, normal: vec3f, friction: f32) -> f32 {
    let along = dot3(impulse, normal);
    return max(friction * along - norm3(impulse - normal * along), 0.0);
}

/// The mobility of a contact: for each of its nodes the size of its weight, and the inverse of the contact's part of its mass [1/kg].
fn mobility_by(weights: vec4f, inverse_mass: vec4f) -> f32 {
    let alone = weights * inverse_mass;
    let shares = weights * alone;
    let sum = shares.x + shares.y + shares.z + shares.w;
    let most = max(max(alone.x, alone.y), max(alone.z, alone.w));
    return max(sum, most / LEVER);
}

/// Normal and tangential parts put together, the tangential one no longer than friction allows.
fn in_cone(one: SurfaceContact, normal: f32, across: vec3f) -> vec3f {
    let length = norm3(across);
    let most = one.friction * normal + one.grip;
    let kept = select(1.0, most / select(1.0, length, length > most), length > most);
    return one.normal * normal + across * kept;
}

/// The impulse of the last sub-step as this one's first guess.
fn first_impulse(one: SurfaceContact) -> vec3f {
    let along = dot3(one.impulse, one.normal);
    return in_cone(one, max(along, 0.0), one.impulse - one.normal * along);
}

/// The inverse mobility; 1 where there is none.
fn mass_by(mobility: f32) -> f32 {
    return 1.0 / select(1.0, mobility, mobility > 0.0);
}

/// The impulse after a round, where the sides have this relative velocity [m/s].
fn corrected_impulse(one: SurfaceContact, velocity: vec3f, h: f32) -> vec3f {
    let by = mass_by(one.mobility);
    let speed = dot3(velocity, one.normal);
    let along = dot3(one.impulse, one.normal);
    let wanted = -max(one.gap, 0.0) / h;
    let normal = max(along + (wanted - speed) * by, 0.0);
    let slip = velocity - one.normal * speed;
    let across = (one.impulse - one.normal * along) - slip * by;
    return select(vec3f(0.0), in_cone(one, normal, across), one.mobility > 0.0);
}

/// How far the contact would sink in by the sub-step, relative to its thickness.
fn sinks_by(one: SurfaceContact, velocity: vec3f, h: f32) -> f32 {
    let way = -(dot3(velocity, one.normal) * h + max(one.gap, 0.0)) / one.thickness;
    return select(0.0, way, one.mobility > 0.0);
}

/// How far an overlap of earlier sub-steps is removed in this one [m].
fn lead_of(one: SurfaceContact, h: f32) -> f32 {
    let missing = max(-one.gap - SLOP * one.thickness, 0.0) * CONTACT_FIRM;
    let most = one.thickness * h / RELEASE;
    return select(most, missing, missing < most);
}

/// What removes an overlap of earlier sub-steps, along the normal [kg·m], where a collider comes nearer by `advance` [m]: who is in its
/// way goes along with it.
fn push_of(one: SurfaceContact, mobility: f32, h: f32, advance: f32) -> f32 {
    let lead = lead_of(one, h);
    let way = select(lead, lead + advance, lead > 0.0);
    return select(0.0, way * mass_by(mobility), mobility > 0.0);
}
