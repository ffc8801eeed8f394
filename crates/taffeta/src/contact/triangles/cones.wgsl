// Which pairs push, so that each contact counts once, in the order of operations of cones.rs.

#import contact/triangles/closest.wgsl
#import contact/triangles/surfaces.wgsl
#import gpu/wgsl/vector.wgsl

/// By how much a cone is wider, as the squared sine of an angle.
const WIDER: f32 = 1e-8;
/// The same for a pair that carried a force.
const WIDER_KEPT: f32 = 1e-4;
/// What rounding adds to that: so much times the squared extent of a face by its squared distance.
const ROUNDED: f32 = 1.6e-13;

/// Whether a way from a point leads away from the face or edge that ends there, given by a vector from its inside, or is off by an
/// angle whose squared sine is no more than `wider`.
fn is_beyond(way: vec3f, out: vec3f, wider: f32) -> bool {
    let along = dot3(way, out);
    let length = dot3(out, out);
    return along >= 0.0 || along * along <= (wider * dot3(way, way) + ROUNDED * length) * length;
}

/// Whether a way from a point of an edge, given by its ends and their weights, leads away from all faces there.
fn leaves_edge(ends: vec2u, weights: vec2f, way: vec3f, wider: f32) -> bool {
    let x = place_at(BEFORE, ends.x);
    let y = place_at(BEFORE, ends.y);
    let items = table(FAN_ITEMS_AT);
    let end = surface_tables[table(FANS_AT) + ends.x + 1u];
    var leaves = true;
    for (var at = surface_tables[table(FANS_AT) + ends.x]; leaves && at < end; at += 2u) {
        let one = surface_tables[items + at];
        let other = surface_tables[items + at + 1u];
        if one == ends.y || other == ends.y {
            let corner = place_at(BEFORE, select(one, other, one == ends.y));
            leaves = leaves && is_beyond(way, (x - corner) * weights.x + (y - corner) * weights.y, wider);
        }
    }
    return leaves;
}

/// Whether a way from a corner leads away from all edges there.
fn leaves_corner(corner: u32, way: vec3f, wider: f32) -> bool {
    let x = place_at(BEFORE, corner);
    let items = table(FAN_ITEMS_AT);
    let end = surface_tables[table(FANS_AT) + corner + 1u];
    var leaves = true;
    for (var at = surface_tables[table(FANS_AT) + corner]; leaves && at < end; at++) {
        leaves = leaves && is_beyond(way, x - place_at(BEFORE, surface_tables[items + at]), wider);
    }
    return leaves;
}

/// Whether each side of a pair stands in the normal cone of the other. A vertex has none of its own.
fn is_in_cones(nodes: vec4u, first: u32, found: Closest, carries: bool) -> bool {
    let wider = select(WIDER, WIDER_KEPT, carries);
    let w = found.weights;
    let has = w != vec4f(0.0);
    if first == 2u {
        if !all(has) {
            return false;
        }
        let first_does = leaves_edge(nodes.xy, w.xy, found.apart * -1.0, wider);
        return first_does && leaves_edge(nodes.zw, w.zw * -1.0, found.apart, wider);
    }
    if has.y && has.z && has.w {
        return true;
    }
    if has.y && has.z {
        return leaves_edge(nodes.yz, w.yz * -1.0, found.apart, wider);
    }
    if has.z && has.w {
        return leaves_edge(nodes.zw, w.zw * -1.0, found.apart, wider);
    }
    if has.y && has.w {
        return leaves_edge(nodes.yw, w.yw * -1.0, found.apart, wider);
    }
    return leaves_corner(select(select(nodes.w, nodes.z, has.z), nodes.y, has.y), found.apart, wider);
}
