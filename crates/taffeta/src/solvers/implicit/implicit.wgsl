// Springs by nodes: Newton steps of implicit Euler.
//
// Source: Baraff and Witkin, "Large Steps in Cloth Simulation", SIGGRAPH 1998, eq. 16, here for u = v⁺; the stiffness across
// a spring by its absolute value after Chen, Liu, Levin, Zheng, Kim, "Stabler Neo-Hookean Simulation: Absolute Eigenvalue
// Filtering for Projected Newton", SIGGRAPH 2024.
//
// With mass M, step h, and the velocity v* that all other forces would give, the velocity u after the step solves
//
// M (u − v*) = h f(x + h u, u),
//
// where f are the springs' forces [N] at the end of the step. Newton's iteration starts from u = v, the velocity before
// (nodes that are held: from theirs after the step), and each of its steps solves
//
// (M + K') δ = h f(x + h u, u) − M (u − v*),   u ← u + δ.
//
// K' is made of one block for each spring, at the places x + h u: B = (h² k + h e) n nᵀ + h² g (1 − n nᵀ), with
// g = |k (l − L)|/l at most k: the change of its impulse per change of velocity [kg].

#import gpu/wgsl/vector.wgsl

/// What a spring contributes: B u = q (q·u) + across·u.
struct LinearSpring {
    /// q [kg^½].
    q: vec3f,
    /// h² g [kg].
    across: f32,
    /// n, and k (l − L) [N], its pull towards the other end.
    along: vec3f,
    pull: f32,
}

/// A symmetric matrix: xx, yy, zz; xy, xz, yz.
struct Symmetric {
    diagonal: vec3f,
    mixed: vec3f,
}

/// Share of the diagonal that is added to a diagonal block before it is inverted, in units of the last place.
const FLOOR: f32 = 16.0;

/// The spring with `d` from its one end to the other [m], of stiffness `k` [N/m] and damping `e` [kg/s] over a step `h` [s].
fn linear_spring(k: f32, e: f32, h: f32, d: vec3f, rest_length: f32) -> LinearSpring {
    let length_squared = dot3(d, d);
    let squared = select(length_squared, TINY, length_squared < TINY);
    let length = sqrt(squared);
    let inverse = 1.0 / length;
    let pull = k * (length - rest_length);
    let taut = abs(pull) * inverse;
    let across = h * h * select(taut, k, taut > k);
    // No less than h e, for the stiffness across is at most k.
    let axial = h * (k * h + e) - across;
    let n = d * inverse;
    return LinearSpring(n * sqrt(max(axial, 0.0)), across, n, pull);
}

/// A sum, and a spring's block times a vector.
fn add_block_times(sum: vec3f, q: vec3f, across: f32, u: vec3f) -> vec3f {
    return sum + q * dot3(q, u) + across * u;
}

/// A sum, and a spring's block.
fn add_block(sum: Symmetric, q: vec3f, across: f32) -> Symmetric {
    return Symmetric(sum.diagonal + q * q + across, sum.mixed + vec3f(q.x * q.y, q.x * q.z, q.y * q.z));
}

/// A matrix times a vector.
fn times(m: Symmetric, v: vec3f) -> vec3f {
    return vec3f(
        m.diagonal.x * v.x + m.mixed.x * v.y + m.mixed.y * v.z,
        m.mixed.x * v.x + m.diagonal.y * v.y + m.mixed.z * v.z,
        m.mixed.y * v.x + m.mixed.z * v.y + m.diagonal.z * v.z,
    );
}

/// q qᵀ + across.
fn block_of(q: vec3f, across: f32) -> Symmetric {
    return Symmetric(q * q + across, vec3f(q.x * q.y, q.x * q.z, q.y * q.z));
}

fn sum_of(a: Symmetric, b: Symmetric) -> Symmetric {
    return Symmetric(a.diagonal + b.diagonal, a.mixed + b.mixed);
}

fn scaled(a: Symmetric, by: f32) -> Symmetric {
    return Symmetric(a.diagonal * by, a.mixed * by);
}

/// The inverse of a diagonal block, for Jacobi's iteration; 0 of 0. What is less than some last digits of the trace is
/// noise: as much is added first.
fn inverse_of(m: Symmetric) -> Symmetric {
    let trace = m.diagonal.x + m.diagonal.y + m.diagonal.z;
    let unit = 1.0 / select(1.0, trace, trace > 0.0);
    let p = unit * (m.diagonal + FLOOR * EPSILON * trace);
    let s = unit * m.mixed;
    let major = vec3f(p.y * p.z - s.z * s.z, p.x * p.z - s.y * s.y, p.x * p.y - s.x * s.x);
    let minor = vec3f(s.y * s.z - s.x * p.z, s.x * s.z - s.y * p.y, s.x * s.y - p.x * s.z);
    let determinant = p.x * major.x + s.x * minor.x + s.y * minor.y;
    let some = determinant > 0.0;
    let by = select(0.0, unit / select(1.0, determinant, some), some);
    return Symmetric(major * by, minor * by);
}

/// The inverse of a diagonal block among the directions in which a surface with unit normal `n` lets the node go.
fn inverse_along(m: Symmetric, n: vec3f) -> Symmetric {
    // P m P + τ n nᵀ, with P = 1 − n nᵀ: its inverse is that among P's directions, and 1/τ along n.
    let tau = m.diagonal.x + m.diagonal.y + m.diagonal.z;
    let w = times(m, n);
    let half = (dot3(n, w) + tau) * 0.5;
    let v = w - half * n;
    let mixed = vec3f(n.x * v.y + v.x * n.y, n.x * v.z + v.x * n.z, n.y * v.z + v.y * n.z);
    let all = inverse_of(Symmetric(m.diagonal - (n * v + v * n), m.mixed - mixed));
    let by = select(0.0, 1.0 / select(1.0, tau, tau > 0.0), tau > 0.0);
    let normal = block_of(n, 0.0);
    return Symmetric(all.diagonal - by * normal.diagonal, all.mixed - by * normal.mixed);
}

/// What holds a node on coarser levels: its diagonal block in the directions in which a surface with unit normal `n` holds it.
fn held_block(m: Symmetric, n: vec3f) -> Symmetric {
    return scaled(block_of(n, 0.0), dot3(n, times(m, n)));
}
