// Nodes that are moved: by keyframes, or by the program.
//
// Motions are evaluated in 64 bits on the host (keyframes.rs). A sub-step is told the pose at its end and the
// rate at which it was reached, (R₁ − R₀)/h and (s₁ − s₀)/h: in 32 bits, the difference of two rounded places over a
// short step would be mostly noise.

#import gpu/wgsl/vector.wgsl

/// A pose x = R x₀ + s by rows (R, s), and its rate.
struct Motion {
    x: vec4f,
    y: vec4f,
    z: vec4f,
    /// [1/s], and [m/s] in w.
    rate_x: vec4f,
    rate_y: vec4f,
    rate_z: vec4f,
}

/// Motions of all sub-steps of a frame.
@group(0) @binding(5) var<storage, read> motions: array<Motion>;

/// A node that moves.
struct Pin {
    /// Where it starts, or where the program moves it from in this frame [m].
    start: vec3f,
    node: u32,
    /// Where the program moves it to [m].
    goal: vec3f,
    /// The motion that it follows; MOVED_BY_USER: the program's.
    track: u32,
}

const MOVED_BY_USER: u32 = 0xffffffffu;

fn affine(x: vec4f, y: vec4f, z: vec4f, p: vec3f) -> vec3f {
    return vec3f(dot3(x.xyz, p), dot3(y.xyz, p), dot3(z.xyz, p)) + vec3f(x.w, y.w, z.w);
}

/// How many units in the last place of its coordinates a node may be off its way before it is taken to lag.
const WAY_ULPS: f32 = 32.0;

/// The velocity [m/s] of a node that its pin wants at `place` after a step of `h` [s], by a motion of `velocity` that began at
/// `start`; where it was held back, at `before`, that which makes up for it.
fn catching_up(place: vec3f, velocity: vec3f, start: vec3f, before: vec3f, h: f32) -> vec3f {
    let lag = (place - velocity * h) - before;
    let rounding = WAY_ULPS * EPSILON;
    if dot3(lag, lag) > rounding * rounding * (dot3(start, start) + dot3(place, place)) {
        return (place - before) / h;
    }
    return velocity;
}

/// The place [m] on the straight way from one place to another, when a `fraction` of the frame has gone by.
fn on_the_way(start: vec3f, goal: vec3f, fraction: f32) -> vec3f {
    return start * (1.0 - fraction) + goal * fraction;
}
