/// Whether `d` is shorter than `reach`, without a root.
fn nearer(d: vec3f, reach: f32) -> bool {
    return dot(d, d) < reach * reach;
}
