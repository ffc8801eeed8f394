// The contact response of two nodes that are closer than the thickness of their cloth. Source and proofs: pair.rs.

#import gpu/wgsl/vector.wgsl

/// The material of a surface, or of two surfaces in contact.
struct ContactMaterial {
    /// Distance between nodes in contact [m].
    thickness: f32,
    friction: f32,
    restitution: f32,
}

/// The response of the first node of a pair; the second gets the opposite.
struct Exchange {
    /// Impulse: change of momentum [N·s].
    impulse: vec3f,
    /// Change of position times mass [kg·m].
    shift: vec3f,
}

/// Fraction of the overlap that is removed in a sub-step.
const FIRM: f32 = 0.2;

/// The response of a pair. `d` [m] and `v` [m/s] are position and velocity of the first node relative to the second,
/// `mobility` [1/kg] is that of [`mobility_of`], `h` [s] the sub-step that has just ended, and `most` the largest
/// separation in a sub-step, relative to the thickness. Nodes at one position separate along y.
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
    // The overlap of this sub-step is removed with the approach. Older overlap gives a separation speed that grows
    // with it, paid for by the energy that the impact has lost.
    let come = h * approach;
    let fresh = select(missing, come, come < missing);
    let release = soft * (at_most((missing - fresh) * FIRM, limit) / h);
    let after = select(release, bounce, bounce > release);
    // Nodes that separate fast enough get no impulse, and hence no friction.
    let gained = select(0.0, after - speed, after > speed);
    let tangential = v - normal * speed;
    let slip = norm3(tangential);
    let grip = material.friction * gained;
    let lost = select(1.0, grip / select(1.0, slip, slip > grip), slip > grip);
    let friction = tangential * select(0.0, -lost, gained > 0.0);
    // Friction takes its distance back, as with colliders, and so does the stopped approach. If no energy is lost,
    // half of the overlap is removed by position, less what the nodes separate by themselves.
    let left = material.restitution * at_most(missing * 0.5, limit) - h * (speed + gained);
    let push = soft * fresh + select(0.0, left, left > 0.0);
    let mass = select(0.0, 1.0 / select(1.0, mobility, mobility > 0.0), mobility > 0.0);
    return Exchange((normal * gained + friction) * mass, (normal * push + friction * h) * mass);
}

fn at_most(way: f32, limit: f32) -> f32 {
    return select(limit, way, way < limit);
}

/// The mobility of a pair [1/kg]: the sum of the inverse masses of its nodes, each times its number of contacts.
fn mobility_of(inverse_mass: vec2f, contacts: vec2u) -> f32 {
    return inverse_mass.x * f32(contacts.x) + inverse_mass.y * f32(contacts.y);
}

/// The material of two surfaces in contact: the mean thickness, the geometric mean of friction, and the larger
/// restitution.
fn combine_materials(a: ContactMaterial, b: ContactMaterial) -> ContactMaterial {
    return ContactMaterial(
        (a.thickness + b.thickness) * 0.5,
        sqrt(a.friction * b.friction),
        select(b.restitution, a.restitution, a.restitution > b.restitution),
    );
}
