// Angle of (x, y), by operations that are exactly rounded; the language's own may be off by thousands of units in the
// last place. Twin of `angle` in real.rs.

const TAN_EIGHTH: f32 = 0.41421357;
const QUARTER_PI: f32 = 0.785398163;
const HALF_PI: f32 = 1.57079633;
const PI: f32 = 3.14159265;

fn angle_of(y: f32, x: f32) -> f32 {
    let across = abs(x);
    let up = abs(y);
    let is_up = up > across;
    let small = select(up, across, is_up);
    let large = select(across, up, is_up);
    let steep = small > TAN_EIGHTH * large;
    let num = select(small, small - large, steep);
    let den = select(large, small + large, steep);
    let t = num / select(den, 1.0, den == 0.0);
    let z = t * t;
    let series = ((0.080537125 * z - 0.13877675) * z + 0.1997771) * z - 0.3333295;
    var angle = t + t * z * series;
    angle = select(angle, angle + QUARTER_PI, steep);
    angle = select(angle, HALF_PI - angle, is_up);
    angle = select(angle, PI - angle, x < 0.0);
    return select(angle, -angle, y < 0.0);
}

/// The difference of two angles, by the shorter way round.
fn wrap(angle: f32) -> f32 {
    if angle > PI {
        return angle - 2.0 * PI;
    }
    if angle < -PI {
        return angle + 2.0 * PI;
    }
    return angle;
}
