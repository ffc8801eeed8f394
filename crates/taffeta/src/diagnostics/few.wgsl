// The sum of an energy and the largest of a stretch over a workgroup, in a fixed order; the host adds up the workgroups in
// 64 bits.

var<workgroup> few: array<vec2f, 256>;

/// Adds up energies and finds the largest stretch of a workgroup; the result is the first lane's.
fn gather_few(lane: u32, own: vec2f) -> vec2f {
    few[lane] = own;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            let other = few[lane + half];
            few[lane] = vec2f(few[lane].x + other.x, max(few[lane].y, other.y));
        }
    }
    return few[lane];
}
