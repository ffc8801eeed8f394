// Closest points of a vertex and a triangle, and of two edges, in the order of operations of closest.rs.

#import gpu/wgsl/vector.wgsl

/// The closest points of the sides of a pair.
struct Closest {
    /// The sum of weight times position is the vector from the second point to the first.
    weights: vec4f,
    /// That vector [m].
    apart: vec3f,
}

/// A part of a whole, from 0 to 1; 0 of nothing.
fn part_of(some: f32, whole: f32) -> f32 {
    let part = some / select(1.0, whole, whole > TINY);
    let least = select(0.0, part, part > 0.0);
    return select(1.0, least, least < 1.0);
}

fn vertex_triangle(p: vec3f, a: vec3f, b: vec3f, c: vec3f) -> Closest {
    let ab = b - a;
    let bc = c - b;
    let ca = a - c;
    let ap = p - a;
    let bp = p - b;
    let cp = p - c;
    // On each edge.
    let s = part_of(dot3(ap, ab), dot3(ab, ab));
    let t = part_of(dot3(bp, bc), dot3(bc, bc));
    let u = part_of(dot3(cp, ca), dot3(ca, ca));
    var apart = ap - ab * s;
    var squared = dot3(apart, apart);
    var weights = vec3f(1.0 - s, s, 0.0);
    let from_bc = bp - bc * t;
    let of_bc = dot3(from_bc, from_bc);
    let bc_is_nearer = of_bc < squared;
    squared = select(squared, of_bc, bc_is_nearer);
    apart = select(apart, from_bc, bc_is_nearer);
    weights = select(weights, vec3f(0.0, 1.0 - t, t), bc_is_nearer);
    let from_ca = cp - ca * u;
    let ca_is_nearer = dot3(from_ca, from_ca) < squared;
    apart = select(apart, from_ca, ca_is_nearer);
    weights = select(weights, vec3f(u, 0.0, 1.0 - u), ca_is_nearer);
    // Inside.
    let normal = cross3(ab, ca * -1.0);
    let area = dot3(normal, normal);
    let by = select(1.0, area, area > TINY);
    let in_b = dot3(normal, cross3(ca, ap)) / by;
    let in_c = dot3(normal, cross3(ab, ap)) / by;
    let in_a = 1.0 - in_b - in_c;
    let of_two = select(in_c, in_b, in_b < in_c);
    let least = select(of_two, in_a, in_a < of_two);
    let inside = area > TINY && least >= 0.0;
    apart = select(apart, normal * (dot3(normal, ap) / by), inside);
    weights = select(weights, vec3f(in_a, in_b, in_c), inside);
    return Closest(vec4f(1.0, -weights.x, -weights.y, -weights.z), apart);
}

fn edge_edge(x: array<vec3f, 4>) -> Closest {
    let first = x[1] - x[0];
    let second = x[3] - x[2];
    let between = x[0] - x[2];
    let a = dot3(first, first);
    let e = dot3(second, second);
    let b = dot3(first, second);
    let c = dot3(first, between);
    let f = dot3(second, between);
    let across = a * e - b * b;
    // Parallel edges have many closest points; any will do.
    let is_across = across > EPSILON * a * e;
    let along = (b * f - c * e) / select(1.0, across, is_across);
    let least = select(0.0, along, along > 0.0);
    let start = select(0.0, select(1.0, least, least < 1.0), is_across);
    let s = part_of(b * part_of(b * start + f, e) - c, a);
    let t = part_of(b * s + f, e);
    return Closest(vec4f(1.0 - s, s, t - 1.0, -t), between + first * s - second * t);
}

/// Of four nodes, of which the first side has `first`: 1 of a vertex and a triangle, 2 of two edges.
fn closest_of(x: array<vec3f, 4>, first: u32) -> Closest {
    if first == 1u {
        return vertex_triangle(x[0], x[1], x[2], x[3]);
    }
    return edge_edge(x);
}

/// Positions relative to the last. `zero` is 0 that compilers do not know: knowing that the last is 0 they would reorder sums.
fn relative_to_last(x: array<vec3f, 4>, zero: f32) -> array<vec3f, 4> {
    return array<vec3f, 4>(x[0] - x[3], x[1] - x[3], x[2] - x[3], vec3f(zero));
}
