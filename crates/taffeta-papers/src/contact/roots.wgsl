/// Whether `d` is shorter than `reach`, by its length.
fn nearer(d: vec3f, reach: f32) -> bool {
    return length(d) < reach;
}
