// Bins: cubes of one side that fill a box, with room for a fixed number of particles each. What is outside of the box
// belongs to the bins at its border.

/// Room in a bin.
override CAPACITY: u32;

struct Bins {
    /// The box's lowest corner [m].
    lowest: vec3f,
    /// Of a bin [m].
    side: f32,
    /// Bins along x, y and z.
    counts: vec3u,
}

@group(1) @binding(3) var<uniform> bins: Bins;
/// Particles in each bin.
@group(3) @binding(0) var<storage, read> filled: array<u32>;
/// The particles of each bin, in `CAPACITY` places.
@group(3) @binding(1) var<storage, read> members: array<u32>;

/// The bin of a place, along x, y and z.
fn bin_at(x: vec3f) -> vec3u {
    return vec3u(clamp((x - bins.lowest) / bins.side, vec3f(0.0), vec3f(bins.counts) - 1.0));
}

/// Number of a bin.
fn number_of(bin: vec3u) -> u32 {
    return (bin.z * bins.counts.y + bin.y) * bins.counts.x + bin.x;
}

/// The bin of this number.
fn bin_of(number: u32) -> vec3u {
    let row = number / bins.counts.x;
    return vec3u(number % bins.counts.x, row % bins.counts.y, row / bins.counts.y);
}

/// The lowest and the highest of a bin and its neighbours.
fn lowest_near(bin: vec3u) -> vec3u {
    return max(bin, vec3u(1u)) - 1u;
}

fn highest_near(bin: vec3u) -> vec3u {
    return min(bin + 1u, bins.counts - 1u);
}
