// The largest numbers of a workgroup.

var<workgroup> most_lanes: array<vec3f, 256>;

/// The largest of each lane's numbers; the first lane has them.
fn most_of_lanes(lane: u32, own: vec3f) -> vec3f {
    most_lanes[lane] = own;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            most_lanes[lane] = max(most_lanes[lane], most_lanes[lane + half]);
        }
    }
    return most_lanes[lane];
}
