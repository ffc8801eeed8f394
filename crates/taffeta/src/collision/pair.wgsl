// What two nodes do to each other that have come nearer than the thickness of their cloth. Source and proofs: pair.rs.

/// Two surfaces as they meet, or one of them.
struct Meeting {
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

/// What a pair does: `d` [m] and `v` [m/s] are place and velocity of the first node less those of the second, `mobility`
/// [1/kg] the sum of their inverse masses, `h` [s] the sub-step that has just gone by, `most` the longest way apart in one,
/// by the thickness. Nodes at one place part along y.
fn exchange(d: vec3f, v: vec3f, mobility: f32, meeting: Meeting, h: f32, most: f32) -> Exchange {
    let distance = norm3(d);
    let is_apart = distance > 0.0;
    let normal = select(vec3f(0.0, 1.0, 0.0), d / select(1.0, distance, is_apart), is_apart);
    let speed = dot3(v, normal);
    // Nodes that part already get no impulse, and hence no friction.
    let approach = select(0.0, -speed, speed < 0.0);
    let gained = (1.0 + meeting.restitution) * approach;
    let tangential = v - normal * speed;
    let slip = norm3(tangential);
    let grip = meeting.friction * gained;
    let lost = select(1.0, grip / select(1.0, slip, slip > grip), slip > grip);
    let friction = tangential * select(0.0, -lost, gained > 0.0);
    // Half of what is missing, less what they part by themselves; friction takes its way back, as with colliders.
    let half_missing = (meeting.thickness - distance) * 0.5;
    let limit = most * meeting.thickness;
    let wanted = select(limit, half_missing, half_missing < limit);
    let left = wanted - h * (speed + gained);
    let push = select(0.0, left, left > 0.0);
    let share = select(0.0, 1.0 / select(1.0, mobility, mobility > 0.0), mobility > 0.0);
    return Exchange((normal * gained + friction) * share, (normal * push + friction * h) * share);
}

/// How two surfaces meet: at the mean distance, with the geometric mean of their friction and the larger restitution.
fn meeting_of(a: Meeting, b: Meeting) -> Meeting {
    return Meeting(
        (a.thickness + b.thickness) * 0.5,
        sqrt(a.friction * b.friction),
        select(b.restitution, a.restitution, a.restitution > b.restitution),
    );
}

/// Share of a pair's exchange that a node gets of which it is the first, or not, where the one of the two that has most
/// contacts has so many.
fn share_of_pair(contacts: u32, is_first: bool) -> f32 {
    let share = 1.0 / f32(contacts);
    return select(-share, share, is_first);
}
