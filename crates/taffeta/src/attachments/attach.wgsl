// Joints between two nodes, or between a node and a point, and tethers. Sources and equations: attach.rs.

#import gpu/wgsl/vector.wgsl

/// The correction of a joint at its first node; the second node gets the opposite.
struct JointCorrection {
    /// Change of position times mass [kg·m]. Divided by the sub-step, it is the impulse.
    shift: vec3f,
    /// Its length [kg·m]. Divided by the square of the sub-step, it is the force.
    size: f32,
}

/// Solves a joint whose ends are `d` [m] apart, first less second, and should be `goal` [m]. `give` [1/kg] is the sum
/// of their inverse masses, and `softness` [1/kg] the joint's own compliance 1/(k h²).
fn solve_joint(d: vec3f, goal: f32, give: f32, softness: f32) -> JointCorrection {
    let distance = sqrt(dot3(d, d));
    if distance > 0.0 && give > 0.0 {
        let size = (distance - goal) / (give + softness);
        let by = -size / distance;
        return JointCorrection(d * by, select(-size, size, size > 0.0));
    }
    return JointCorrection(vec3f(0.0), 0.0);
}

/// Length [m] of a joint at a `fraction` of its closing.
fn joint_length(start: f32, end: f32, fraction: f32) -> f32 {
    return start * (1.0 - fraction) + end * fraction;
}

/// A node after a tether: its position [m], the translation, and whether it has moved.
struct Projected {
    x: vec3f,
    way: vec3f,
    moved: bool,
}

/// Projects a node that is farther than `reach` [m] from its anchor at `at` [m] onto the sphere.
fn project_to_sphere(x: vec3f, at: vec3f, reach: f32) -> Projected {
    let d = x - at;
    let squared = dot3(d, d);
    if squared > reach * reach {
        let distance = sqrt(squared);
        let outward = d / distance;
        return Projected(at + outward * reach, outward * (reach - distance), true);
    }
    return Projected(x, vec3f(0.0), false);
}

/// The velocity [m/s] of a node that tethers have moved by `shift` [m] in a sub-step of `h` [s]. It loses the part
/// that the tethers have undone. Their anchors have the velocity `along` [m/s].
fn without_lost_motion(v: vec3f, shift: vec3f, along: vec3f, h: f32) -> vec3f {
    let against = dot3(shift, along - v);
    let squared = dot3(shift, shift);
    if against > 0.0 && squared > 0.0 {
        let whole = against / squared;
        let all = 1.0 / h;
        return v + shift * select(all, whole, whole < all);
    }
    return v;
}

/// The velocity [m/s] of a node on a taut tether, `d` [m] from its anchor, which has the velocity `along` [m/s]. The
/// node loses its speed away from the anchor.
fn without_stretching(v: vec3f, d: vec3f, along: vec3f) -> vec3f {
    let speed = dot3(v - along, d);
    let squared = dot3(d, d);
    if speed > 0.0 && squared > 0.0 {
        return v - d * (speed / squared);
    }
    return v;
}

/// A node after its tethers.
struct Tethered {
    x: vec3f,
    v: vec3f,
}

/// Most rounds over the tethers of a node in a sub-step.
const TETHER_ROUNDS: u32 = 8u;
