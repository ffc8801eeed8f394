// One triangle and a node: the nearest point, and the crossing of a segment. Source: triangle.rs.

#import gpu/wgsl/angle.wgsl
#import gpu/wgsl/vector.wgsl

/// Corners [m].
struct Corners {
    a: vec3f,
    b: vec3f,
    c: vec3f,
}

/// The crossing of a segment and a triangle, if there is one.
struct Crossing {
    /// Fraction of the segment before it.
    fraction: f32,
    /// The triangle; NO_TRIANGLE: none.
    triangle: u32,
    /// Squared distance of its start from the triangle's plane at that time [m²].
    height: f32,
    /// Whether the segment goes inward: from the side to which the triangle's own normal points.
    inward: bool,
}

const NO_TRIANGLE: u32 = 0xffffffffu;
/// Relative excess of the area in which a triangle is crossed.
const PASSED: f32 = 1e-4;

/// Σ weight · corner.
fn mix_of(corners: Corners, barycentric: vec3f) -> vec3f {
    return corners.a * barycentric.x + corners.b * barycentric.y + corners.c * barycentric.z;
}

/// A fraction of an edge; 0 if the edge has no length.
fn share_of_edge(some: f32, all: f32) -> f32 {
    return select(0.0, some / select(1.0, all, all > 0.0), all > 0.0);
}

/// Barycentric coordinates of the point of a triangle nearest to `x`; exactly 0 if the point is on an edge or corner
/// without that corner.
fn barycentric_of_nearest(x: vec3f, corners: Corners) -> vec3f {
    let ab = corners.b - corners.a;
    let ac = corners.c - corners.a;
    let from_a = x - corners.a;
    let d1 = dot3(ab, from_a);
    let d2 = dot3(ac, from_a);
    if d1 <= 0.0 && d2 <= 0.0 {
        return vec3f(1.0, 0.0, 0.0);
    }
    let from_b = x - corners.b;
    let d3 = dot3(ab, from_b);
    let d4 = dot3(ac, from_b);
    if d3 >= 0.0 && d4 <= d3 {
        return vec3f(0.0, 1.0, 0.0);
    }
    // Areas along the normal, instead of differences of products of d1 to d6, which cancel for narrow triangles.
    let normal = cross3(ab, ac);
    let all = dot3(normal, normal);
    let vc = dot3(cross3(ab, from_a), normal);
    if vc <= 0.0 && d1 >= 0.0 && d3 <= 0.0 {
        let v = share_of_edge(d1, d1 - d3);
        return vec3f(1.0 - v, v, 0.0);
    }
    let from_c = x - corners.c;
    let d5 = dot3(ab, from_c);
    let d6 = dot3(ac, from_c);
    if d6 >= 0.0 && d5 <= d6 {
        return vec3f(0.0, 0.0, 1.0);
    }
    let vb = dot3(cross3(from_a, ac), normal);
    if vb <= 0.0 && d2 >= 0.0 && d6 <= 0.0 {
        let w = share_of_edge(d2, d2 - d6);
        return vec3f(1.0 - w, 0.0, w);
    }
    let va = all - vb - vc;
    if va <= 0.0 && d4 >= d3 && d5 >= d6 {
        let w = share_of_edge(d4 - d3, (d4 - d3) + (d5 - d6));
        return vec3f(0.0, 1.0 - w, w);
    }
    let inverse = 1.0 / all;
    let v = vb * inverse;
    let w = vc * inverse;
    return vec3f(1.0 - v - w, v, w);
}

/// Twice the area of a triangle [m²] times its unit normal.
fn normal_of(corners: Corners) -> vec3f {
    return cross3(corners.b - corners.a, corners.c - corners.a);
}

/// Linear interpolation between two triangles.
fn corners_between(start: Corners, end: Corners, fraction: f32) -> Corners {
    return Corners(
        start.a + (end.a - start.a) * fraction,
        start.b + (end.b - start.b) * fraction,
        start.c + (end.c - start.c) * fraction,
    );
}

fn no_crossing() -> Crossing {
    return Crossing(0.0, NO_TRIANGLE, 0.0, false);
}

/// Where a segment crosses the plane of a triangle that moves.
struct Crossed {
    /// Areas of the triangles of that point and two corners, times that of the whole: barycentric coordinates times `squared`.
    areas: vec3f,
    /// Normal of the triangle then, and its squared length.
    normal: vec3f,
    squared: f32,
}

/// The same at a fraction of the segment.
fn crossed_at(start: vec3f, end: vec3f, before: Corners, after: Corners, fraction: f32) -> Crossed {
    let place = start + (end - start) * fraction;
    let corners = corners_between(before, after, fraction);
    let normal = normal_of(corners);
    let a = dot3(cross3(corners.c - corners.b, place - corners.b), normal);
    let b = dot3(cross3(corners.a - corners.c, place - corners.c), normal);
    let c = dot3(cross3(corners.b - corners.a, place - corners.a), normal);
    return Crossed(vec3f(a, b, c), normal, dot3(normal, normal));
}

/// The crossing of a node that moves straight from `start` to `end` and a triangle that moves from `before` to
/// `after`. Distances from its plane count as linear in time.
fn crossing_of(start: vec3f, end: vec3f, before: Corners, after: Corners, triangle: u32) -> Crossing {
    let first = normal_of(before);
    let above = dot3(start - before.a, first);
    let below = dot3(end - after.a, normal_of(after));
    let inward = above >= 0.0;
    if inward == (below >= 0.0) {
        return no_crossing();
    }
    let fraction = above / (above - below);
    let crossed = crossed_at(start, end, before, after, fraction);
    if crossed.squared <= TINY {
        return no_crossing();
    }
    // Slightly wider than the triangle, so that segments do not slip through between two.
    let least = crossed.squared * -PASSED;
    if any(crossed.areas < vec3f(least)) {
        return no_crossing();
    }
    let height = above * above / (dot3(first, first) + TINY);
    return Crossing(fraction, triangle, height, inward);
}

/// The angle at the corner `p` [rad].
fn angle_at(p: vec3f, q: vec3f, r: vec3f) -> f32 {
    let a = q - p;
    let b = r - p;
    let sine = cross3(a, b);
    return angle_of(sqrt(dot3(sine, sine)), dot3(a, b));
}

/// The weight of a triangle's unit normal at a corner or an edge: its angle there, π for an edge. `at` are the
/// corners of the feature.
fn pseudonormal(corners: Corners, at: vec3<bool>) -> vec3f {
    let normal = normal_of(corners);
    let squared = dot3(normal, normal);
    if squared <= TINY {
        return vec3f(0.0);
    }
    var weight = 1.0;
    if corners_in(at) < 2u {
        if at.y {
            weight = angle_at(corners.b, corners.c, corners.a);
        } else if at.z {
            weight = angle_at(corners.c, corners.a, corners.b);
        } else {
            weight = angle_at(corners.a, corners.b, corners.c);
        }
    }
    return normal * (weight / sqrt(squared));
}

/// The number of corners of a feature.
fn corners_in(at: vec3<bool>) -> u32 {
    return u32(at.x) + u32(at.y) + u32(at.z);
}
