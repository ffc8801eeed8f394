// Lift and drag of a triangle in a flow of air (see air.rs for source and derivation).
//
//   f = ½ ρ A |w|² (C_D |s| ŵ + C_L s (n − s ŵ))  [N],  s = n·ŵ,
//
// with some of the triangle's own flow w at the end of the step where that matters, |w|, n and the direction of lift held.

#import elements/aero/gust.wgsl
#import gpu/wgsl/vector.wgsl

/// Air in one sub-step.
struct Air {
    /// Velocity [m/s].
    velocity: vec3f,
    /// ρ/12 [kg/m³].
    density: f32,
    /// h ρ/4 [kg·s/m³].
    exposure: f32,
    /// Coefficients.
    drag: f32,
    lift: f32,
    gusts: Gusts,
}

/// Velocity [m/s] at `x` [m], with gusts where there are any.
fn air_velocity(air: Air, x: vec3f) -> vec3f {
    if air.gusts.cells_a_metre > 0.0 {
        return air.velocity + gust_velocity(air.gusts, x);
    }
    return air.velocity;
}

/// β, how much of the flow that counts is that at the end of the step, for d and l².
fn at_end(d: f32, l_squared: f32) -> f32 {
    let squared = d * d + l_squared;
    let root = sqrt(squared);
    let size = select(0.5, root, root > 0.5);
    let enough = 2.0 - 1.0 / size;
    // What is added across a velocity makes it longer: lift alone needs half at any step.
    let least = 0.5 - d / select(TINY, squared, squared > TINY);
    let share = select(least, enough, enough > least);
    return select(1.0, share, share < 1.0);
}

/// Force on each corner [N] of a triangle with the normal `twice`, twice its area long [m²], in the flow `w` [m/s].
/// `lightness` is 1/M [1/kg]. Without area or flow there is none.
fn corner_force(air: Air, twice: vec3f, w: vec3f, lightness: f32) -> vec3f {
    let area = dot3(twice, twice);
    let speed = dot3(w, w);
    let through = dot3(twice, w);
    let is_in_flow = area > TINY && speed > TINY;
    let size = select(1.0, sqrt(area) * sqrt(speed), is_in_flow);
    let sine = through / size;
    let rest = 1.0 - sine * sine;
    let cosine_squared = select(0.0, rest, rest > 0.0);
    let drag = air.drag * abs(through);
    let lift = air.lift * through;
    let whole = air.exposure * lightness;
    let exposure = whole * at_end(whole * drag, whole * whole * lift * lift * cosine_squared);
    let d = 1.0 + exposure * drag;
    let turn = exposure * lift * cosine_squared;
    let left = d * d + exposure * lift * turn;
    let along = drag * d + lift * (turn - sine);
    let across = lift * (speed / size);
    let factor = select(0.0, air.density / left, is_in_flow);
    return (w * along + twice * across) * factor;
}
