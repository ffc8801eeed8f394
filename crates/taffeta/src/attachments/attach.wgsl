// What holds two nodes together, a node to a point, and a node near another one. Sources and equations: attach.rs.

#import gpu/wgsl/vector.wgsl

/// What a joint does to its first node; to its second the opposite.
struct JointCorrection {
    /// Change of place times mass [kg·m]; by the sub-step, change of momentum.
    shift: vec3f,
    /// Its length [kg·m]; by the square of the sub-step, the force.
    size: f32,
}

/// A joint of two ends that are `d` [m] apart, first less second, and should be `goal` [m]. `give` [1/kg] is the sum of their
/// inverse masses, and `softness` [1/kg] how easily it gives way itself.
fn solve_joint(d: vec3f, goal: f32, give: f32, softness: f32) -> JointCorrection {
    let distance = sqrt(dot3(d, d));
    if distance > 0.0 && give > 0.0 {
        let size = (distance - goal) / (give + softness);
        let by = -size / distance;
        return JointCorrection(d * by, select(-size, size, size > 0.0));
    }
    return JointCorrection(vec3f(0.0), 0.0);
}

/// Distance [m] of a joint's ends when a `fraction` of its closing has gone by.
fn joint_length(start: f32, end: f32, fraction: f32) -> f32 {
    return start * (1.0 - fraction) + end * fraction;
}

/// Where a node comes after a tether [m], the way there, and whether it has moved.
struct Projected {
    x: vec3f,
    way: vec3f,
    moved: bool,
}

/// Puts a node that is farther than `reach` [m] from an anchor at `at` [m] on the sphere.
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

/// The velocity [m/s] of a node that tethers, whose anchors go `along` [m/s], have moved by `shift` [m] in a sub-step of
/// `h` [s]: it loses that with which it did not get anywhere.
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

/// The velocity [m/s] of a node whose tether is taut, `d` [m] from its anchor, which goes `along` [m/s]: it loses the speed at
/// which it leaves it.
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

/// Times that the tethers of a node are looked at in a sub-step, at most.
const TETHER_ROUNDS: u32 = 8u;
