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

/// A node on a sphere or a circle: its position, and the translation [m].
struct Projected {
    x: vec3f,
    shift: vec3f,
}

/// The ball around an anchor that a tether keeps its node in [m].
struct Ball {
    center: vec3f,
    radius: f32,
}

/// By how much the squared distance of a node is beyond a ball [m²]. At most 0: it is inside.
fn excess(x: vec3f, ball: Ball) -> f32 {
    let d = x - ball.center;
    return dot3(d, d) - ball.radius * ball.radius;
}

/// The same beyond what rounding may have done.
fn sure_excess(x: vec3f, ball: Ball) -> f32 {
    let d = x - ball.center;
    let room = 8.0 * EPSILON * (ball.radius + (abs(x.x) + abs(x.y) + abs(x.z)));
    return dot3(d, d) - ball.radius * (ball.radius + room);
}

/// Projects a node onto the surface of a ball, whose center it is not at.
fn project_to_sphere(x: vec3f, ball: Ball) -> Projected {
    let d = x - ball.center;
    let ratio = ball.radius / sqrt(dot3(d, d));
    return Projected(ball.center + d * ratio, d * (ratio - 1.0));
}

/// Projects a node onto the circle in which the surfaces of two balls meet, which it is farther out than. Balls that do not meet have a point
/// between them in place of the circle.
fn project_to_circle(x: vec3f, a: Ball, b: Ball) -> Projected {
    let d = x - a.center;
    let axis = b.center - a.center;
    let squared = dot3(axis, axis);
    // Where on the axis the circle's plane and the node are: 0 is a, 1 is b.
    let plane = ((a.radius - b.radius) * (a.radius + b.radius) / squared + 1.0) * 0.5;
    let along = dot3(d, axis) / squared;
    let across = d - axis * along;
    let distance = sqrt(dot3(across, across));
    let left = a.radius * a.radius - plane * plane * squared;
    let radius = sqrt(select(0.0, left, left > 0.0));
    // Only rounding would lead away from the axis.
    let ratio = select(1.0, radius / distance, distance > radius);
    return Projected(a.center + axis * plane + across * ratio, axis * (plane - along) + across * (ratio - 1.0));
}

/// A node that its tethers have moved: its position and the translation [m], and a bit for each tether that is taut.
struct HeldBack {
    x: vec3f,
    shift: vec3f,
    taut: u32,
}

/// Moves a node to the nearest point of two balls: of the one that it exceeds most, or of the other, or where both surfaces meet. `both`: there
/// is a second.
fn project_to_two(x: vec3f, p: Ball, q: Ball, both: bool) -> HeldBack {
    let of_p = excess(x, p);
    let of_q = excess(x, q);
    let is_q = both && of_q > of_p;
    var first = p;
    var second = q;
    if is_q {
        first = q;
        second = p;
    }
    if !(select(of_p, of_q, is_q) > 0.0) {
        return HeldBack(x, vec3f(0.0), 0u);
    }
    let bits = select(vec2u(1u, 2u), vec2u(2u, 1u), is_q);
    let at_first = project_to_sphere(x, first);
    // Of balls around nearly the same point, one is as good as both, and the circle is anywhere.
    let apart = second.center - first.center;
    let blur = 1000.0 * EPSILON * (first.radius + (abs(x.x) + abs(x.y) + abs(x.z)));
    if !both || sure_excess(at_first.x, second) <= 0.0 || dot3(apart, apart) <= blur * blur {
        return HeldBack(at_first.x, at_first.shift, bits.x);
    }
    let at_second = project_to_sphere(x, second);
    // A node within the second needs both.
    if sure_excess(at_second.x, first) <= 0.0 && excess(x, second) > 0.0 {
        return HeldBack(at_second.x, at_second.shift, bits.y);
    }
    let circle = project_to_circle(x, first, second);
    return HeldBack(circle.x, circle.shift, 3u);
}

/// The velocity [m/s] of a node that tethers have moved by `shift` [m] in a sub-step of `h` [s]. It loses the part
/// that the tethers have undone. Their anchors have the velocity `along` [m/s].
fn without_lost_motion(v: vec3f, shift: vec3f, along: vec3f, h: f32) -> vec3f {
    let against = dot3(shift, along - v);
    let squared = dot3(shift, shift);
    let whole = against / squared;
    let all = 1.0 / h;
    return v + shift * select(0.0, select(all, whole, whole < all), against > 0.0 && squared > 0.0);
}

/// The velocity [m/s] of a node on a taut tether, `d` [m] from its anchor, which has the velocity `along` [m/s]. The
/// node loses its speed away from the anchor.
fn without_stretching(v: vec3f, d: vec3f, along: vec3f) -> vec3f {
    let speed = dot3(v - along, d);
    let squared = dot3(d, d);
    return v - d * select(0.0, speed / squared, speed > 0.0 && squared > 0.0);
}

/// A node after its tethers.
struct Tethered {
    x: vec3f,
    v: vec3f,
}

/// Most rounds over the tethers of a node in a sub-step.
const TETHER_ROUNDS: u32 = 8u;
