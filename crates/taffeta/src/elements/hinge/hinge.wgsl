// Dihedral bending of two triangles that share an edge.
//
// Energy ½ k (θ − θ₀)² [J], with the fold angle θ (0 when flat) between the triangles' normals and k [N·m/rad]:
// Grinspun, Hirani, Desbrun, Schröder, "Discrete Shells", 2003, with the gradient of θ as in Bridson, Marino,
// Fedkiw, "Simulation of Clothing with Folds and Wrinkles", 2003, sec. 4, and Tamstorf, Grinspun, "Discrete
// bending forces and their Jacobians", 2013. Damping [N·m·s/rad] opposes dθ/dt.

#import gpu/wgsl/angle.wgsl
#import gpu/wgsl/vector.wgsl

/// How much stiffer a hinge may become by its triangles' shape than it is at rest.
const STIFFEST: f32 = 16.0;

/// Fold angle [rad] and its gradient [rad/m] at the four corners: edge a, edge b, opposite in the triangle that runs
/// a→b, opposite in the other.
struct Fold {
    at_a: vec3f,
    theta: f32,
    at_b: vec3f,
    at_c: vec3f,
    at_d: vec3f,
}

/// The fold at corners a, b, c, d. A triangle without area gives no gradient.
fn fold_of(a: vec3f, b: vec3f, c: vec3f, d: vec3f) -> Fold {
    let edge = b - a;
    let left = cross3(edge, c - a);
    let right = cross3(d - a, edge);
    let squared = dot3(edge, edge);
    let area_left = dot3(left, left);
    let area_right = dot3(right, right);
    if !(squared > TINY && area_left > TINY && area_right > TINY) {
        return Fold(vec3f(0.0), 0.0, vec3f(0.0), vec3f(0.0), vec3f(0.0));
    }
    // A compiler may take the square of a root for the number itself: it is not squared again.
    let length = sqrt(squared);
    let sine = dot3(cross3(left, right), edge) / length;
    let theta = angle_of(sine, dot3(left, right));
    // ∇θ at the opposite corners: along the normals, with 1/height.
    let at_c = left * -(length / area_left);
    let at_d = right * -(length / area_right);
    // The rest is shared by the edge's ends so that a rigid motion does not change θ.
    let inverse = 1.0 / squared;
    let along_c = dot3(c - a, edge) * inverse;
    let along_d = dot3(d - a, edge) * inverse;
    let at_b = at_c * -along_c + at_d * -along_d;
    let at_a = at_c * (along_c - 1.0) + at_d * (along_d - 1.0);
    return Fold(at_a, theta, at_b, at_c, at_d);
}

/// Σ|∇θ|² over the corners [rad²/m²].
fn steepness(fold: Fold) -> f32 {
    return dot3(fold.at_a, fold.at_a) + dot3(fold.at_b, fold.at_b) + dot3(fold.at_c, fold.at_c)
        + dot3(fold.at_d, fold.at_d);
}

/// k (θ − θ₀) + d dθ/dt [N·m]: the force on a corner is this times −∇θ.
///
/// On triangles that are squashed to slivers |∇θ| grows without bound, and no step would be stable. There the moment
/// is scaled down so that stiffness and damping along the corners' ways stay within STIFFEST times those at rest.
fn hinge_moment(fold: Fold, rate: f32, k: f32, damping: f32, rest_angle: f32, rest_steepness: f32) -> f32 {
    let moment = k * wrap(fold.theta - rest_angle) + damping * rate;
    let steep = steepness(fold);
    let most = STIFFEST * rest_steepness;
    return select(moment, moment * (most / select(1.0, steep, steep > most)), steep > most);
}

/// How stiff a hinge is beside what its numbers say: less where its triangles are squashed.
fn hinge_ratio(fold: Fold, rest_steepness: f32) -> f32 {
    let steep = steepness(fold);
    let ratio = select(0.0, STIFFEST * rest_steepness / select(1.0, steep, steep > 0.0), steep > 0.0);
    return select(ratio, 1.0, ratio > 1.0);
}

/// Energy ½ k (θ − θ₀)² [J].
fn hinge_energy(fold: Fold, k: f32, rest_angle: f32) -> f32 {
    let turn = wrap(fold.theta - rest_angle);
    return 0.5 * k * turn * turn;
}
