// What two nodes do to each other that have come nearer than the thickness of their cloth. Source and proofs: pair.rs.

#import gpu/wgsl/vector.wgsl

/// Two surfaces as they meet, or one of them.
struct ContactMaterial {
    /// Distance that is kept between their nodes [m].
    thickness: f32,
    friction: f32,
    restitution: f32,
}

/// What a pair does to its first node; to its second the opposite.
struct Exchange {
    /// Change of momentum [N·s].
    impulse: vec3f,
    /// Change of place times mass [kg·m].
    shift: vec3f,
}

/// Share of what is missing that nodes make up for in a sub-step.
const FIRM: f32 = 0.2;

/// What a pair does: `d` [m] and `v` [m/s] are place and velocity of the first node less those of the second, `mobility`
/// [1/kg] as [`mobility_of`] says, `h` [s] the sub-step that has just gone by, `most` the longest way apart in one, by the
/// thickness. Nodes at one place part along y.
fn exchange(d: vec3f, v: vec3f, mobility: f32, material: ContactMaterial, h: f32, most: f32) -> Exchange {
    let distance = norm3(d);
    let is_separated = distance > 0.0;
    let normal = select(vec3f(0.0, 1.0, 0.0), d / select(1.0, distance, is_separated), is_separated);
    let speed = dot3(v, normal);
    let missing = material.thickness - distance;
    let limit = most * material.thickness;
    let approach = select(0.0, -speed, speed < 0.0);
    let bounce = material.restitution * approach;
    let soft = 1.0 - material.restitution;
    // What went missing in this sub-step goes with the approach; what was missing before gives a speed, the more the
    // faster, paid for by what the impact has lost.
    let come = h * approach;
    let fresh = select(missing, come, come < missing);
    let release = soft * (at_most((missing - fresh) * FIRM, limit) / h);
    let after = select(release, bounce, bounce > release);
    // Nodes that part fast enough get no impulse, and hence no friction.
    let gained = select(0.0, after - speed, after > speed);
    let tangential = v - normal * speed;
    let slip = norm3(tangential);
    let grip = material.friction * gained;
    let lost = select(1.0, grip / select(1.0, slip, slip > grip), slip > grip);
    let friction = tangential * select(0.0, -lost, gained > 0.0);
    // Friction takes its way back, as with colliders, and so does what stops the approach. Where nothing is lost, nodes
    // that are too near are put apart: by half of what is missing, less what they part by themselves.
    let left = material.restitution * at_most(missing * 0.5, limit) - h * (speed + gained);
    let push = soft * fresh + select(0.0, left, left > 0.0);
    let mass = select(0.0, 1.0 / select(1.0, mobility, mobility > 0.0), mobility > 0.0);
    return Exchange((normal * gained + friction) * mass, (normal * push + friction * h) * mass);
}

fn at_most(way: f32, limit: f32) -> f32 {
    return select(limit, way, way < limit);
}

/// How easily a pair gives way [1/kg]: inverse masses of its nodes, each of which has so many contacts, and as many shares.
fn mobility_of(inverse_mass: vec2f, contacts: vec2u) -> f32 {
    return inverse_mass.x * f32(contacts.x) + inverse_mass.y * f32(contacts.y);
}

/// How two surfaces meet: at the mean distance, with the geometric mean of their friction and the larger restitution.
fn combine_materials(a: ContactMaterial, b: ContactMaterial) -> ContactMaterial {
    return ContactMaterial(
        (a.thickness + b.thickness) * 0.5,
        sqrt(a.friction * b.friction),
        select(b.restitution, a.restitution, a.restitution > b.restitution),
    );
}
