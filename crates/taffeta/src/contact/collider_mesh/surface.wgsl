// Triangle meshes as colliders, by their trees of boxes. Source and proofs: surface.rs, tree.rs. There is no contact
// cache: each node searches the tree.

#import contact/collider_mesh/triangle.wgsl
#import contact/colliders/response.wgsl
#import contact/colliders/shape.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl

/// All meshes, in fours. For each interval between poses: where its triangles are, its nodes at both ends, and its
/// boxes; then the number of triangles, that of leaves (a power of two), whether it is solid, and the squared
/// rounding error [m²]; then where the nodes of the pose before are. Triangles are corners in xyz, nodes are
/// positions [m], boxes are lower and upper corners [m]: box 1 is the root, 2i and 2i + 1 are the halves of box i. Behind all of
/// them, which nodes are led out of colliders, a bit each.
@group(1) @binding(30) var<storage, read> mesh_data: array<vec4u>;

/// Whether a node is led out of colliders, which do not act on it then.
fn is_led_out(place: u32) -> bool {
    let first = substeps[own()].led_out;
    if first == NONE {
        return false;
    }
    return ((mesh_data[first + place / 128u][(place / 32u) % 4u] >> (place % 32u)) & 1u) != 0u;
}

/// The header of one collider.
struct MeshPart {
    triangles: u32,
    start: u32,
    end: u32,
    boxes: u32,
    count: u32,
    width: u32,
    is_solid: bool,
    rounding: f32,
    before: u32,
}

/// The contact of a node, in the mesh's own frame.
struct MeshContact {
    normal: vec3f,
    /// Depth [m]; −FAR: too far away to be known.
    depth: f32,
    /// Velocity of the surface by the change of shape [m/s].
    velocity: vec3f,
    /// Whether the node's segment crosses the mesh.
    passed: bool,
}

/// The nearest point of a triangle.
struct Nearest {
    /// Barycentric coordinates.
    barycentric: vec3f,
    triangle: u32,
    /// From the point to the position [m].
    apart: vec3f,
    /// Squared length of that [m²].
    squared: f32,
}

/// Relative tolerance of squared distances, so that boxes do not hide triangles by rounding.
const LOOSE: f32 = 1.001;
/// Square of the cosine below which a surface is seen at a grazing angle, and another may be nearer.
const GRAZING: f32 = 0.015625;
/// How often a mesh acts on a node in a groove between triangles.
const GROOVES: u32 = 4u;
/// Most boxes and triangles that the walks of a node may visit: software drivers end loops silently.
override TURNS: u32 = 0xffffffffu;
/// The number visited.
var<private> turns: u32;
/// Tolerance of a depth after a response, in units in the last place of the position.
const ROUNDING_ULPS: f32 = 4.0;

fn part_of_mesh(collider: Collider) -> MeshPart {
    let places = mesh_data[collider.mesh];
    let numbers = mesh_data[collider.mesh + 1u];
    return MeshPart(
        places.x, places.y, places.z, places.w, numbers.x, numbers.y, numbers.z != 0u, bitcast<f32>(numbers.w),
        mesh_data[collider.mesh + 2u].x,
    );
}

/// A position in the mesh's frame [m].
fn local_of(collider: Collider, x: vec3f) -> vec3f {
    let d = x - collider.place;
    return collider.axis_u * d.x + collider.axis_v * d.y + collider.axis_w * d.z;
}

/// A direction of the mesh's frame in the scene's.
fn turned(collider: Collider, d: vec3f) -> vec3f {
    return vec3f(dot3(collider.axis_u, d), dot3(collider.axis_v, d), dot3(collider.axis_w, d));
}

fn data_at(index: u32) -> vec3f {
    return bitcast<vec3f>(mesh_data[index].xyz);
}

fn corners_at(nodes: u32, triangle: vec3u) -> Corners {
    return Corners(data_at(nodes + triangle.x), data_at(nodes + triangle.y), data_at(nodes + triangle.z));
}

/// Corners of a triangle [m], at a fraction of the motion to the next pose; below 0, from the pose before.
fn corners_of(mesh: MeshPart, triangle: u32, fraction: f32) -> Corners {
    let nodes = mesh_data[mesh.triangles + triangle].xyz;
    let start = corners_at(mesh.start, nodes);
    if mesh.start == mesh.end {
        return start;
    }
    if fraction < 0.0 {
        return corners_between(corners_at(mesh.before, nodes), start, fraction + 1.0);
    }
    return corners_between(start, corners_at(mesh.end, nodes), fraction);
}

/// Velocity of a point of a triangle [m/s] by the change of shape.
fn changing(mesh: MeshPart, triangle: u32, barycentric: vec3f, rate: f32) -> vec3f {
    if mesh.start == mesh.end {
        return vec3f(0.0);
    }
    let nodes = mesh_data[mesh.triangles + triangle].xyz;
    let start = corners_at(mesh.start, nodes);
    let end = corners_at(mesh.end, nodes);
    let moved = Corners((end.a - start.a) * rate, (end.b - start.b) * rate, (end.c - start.c) * rate);
    return mix_of(moved, barycentric);
}

/// Squared distance of a position from a box [m²].
fn box_squared(mesh: MeshPart, index: u32, x: vec3f) -> f32 {
    let lo = data_at(mesh.boxes + 2u * index);
    let hi = data_at(mesh.boxes + 2u * index + 1u);
    let below = lo - x;
    let above = x - hi;
    let beyond = positive(select(above, below, below > above));
    return dot3(beyond, beyond);
}

/// Whether a box intersects the box between two corners.
fn boxes_meet(mesh: MeshPart, index: u32, lo: vec3f, hi: vec3f) -> bool {
    return all(data_at(mesh.boxes + 2u * index) <= hi) && all(lo <= data_at(mesh.boxes + 2u * index + 1u));
}

/// Largest rounding error of a distance [m].
fn lost_in(mesh: MeshPart) -> f32 {
    return sqrt(mesh.rounding);
}

/// Squared rounding error of a position [m²].
fn rounding_at(x: vec3f) -> f32 {
    let lost = EPSILON * 8.0;
    return lost * lost * dot3(x, x) + TINY;
}

/// Whether a position is finite; a diverged node has no contact.
fn is_somewhere(x: vec3f) -> bool {
    return dot3(x, x) < FAR;
}

/// Whether a walk may continue.
fn may_turn() -> bool {
    turns++;
    return turns <= TURNS;
}

/// The contact of a node whose walks did not end: a NaN, so that the frame fails.
fn outward_of(found: MeshContact) -> MeshContact {
    if turns <= TURNS {
        return found;
    }
    let none = f32(turns) * FAR * FAR;
    return MeshContact(vec3f(none), none, vec3f(none), true);
}

/// A walk through a mesh's tree. It has no stack, which would take more registers than all else.
struct Walk {
    /// The box or triangle where it is: box i has the halves 2i and 2i + 1, and a leaf has the four triangles that halves of its halves
    /// would be. 0 behind the last.
    index: u32,
    /// Whether the other half waits, a bit a level, the lowest for this one; the tree has less than 32 levels.
    waiting: u32,
}

/// Into one half of a box; the other waits.
fn down(walk: Walk, half: u32) -> Walk {
    return Walk(2u * walk.index + half, 2u * walk.waiting + 1u);
}

/// To the first triangle of a leaf; the others wait.
fn into_leaf(walk: Walk) -> Walk {
    return Walk(4u * walk.index, 4u * walk.waiting + 3u);
}

/// To the next that waits. Halves of a leaf are no turns of their own.
fn on(walk: Walk, mesh: MeshPart) -> Walk {
    if walk.waiting == 0u {
        return Walk(0u, 0u);
    }
    let levels = countTrailingZeros(walk.waiting);
    let next = Walk((walk.index >> levels) ^ 1u, (walk.waiting >> levels) ^ 1u);
    if next.index >= 2u * mesh.width && next.index < 4u * mesh.width {
        return down(next, 0u);
    }
    return next;
}

/// The nearest point of a triangle.
fn nearest_in(triangle: u32, corners: Corners, x: vec3f) -> Nearest {
    let barycentric = barycentric_of_nearest(x, corners);
    let apart = x - mix_of(corners, barycentric);
    return Nearest(barycentric, triangle, apart, dot3(apart, apart));
}

/// The crossings of a segment.
struct Passage {
    /// That of the triangle that is crossed first.
    hit: Crossing,
    /// Whether any triangle is crossed outward.
    comes_out: bool,
}

/// Whether a crossing comes before all that are known; of two at the same time, that of the first triangle.
fn is_sooner(found: Crossing, known: Crossing) -> bool {
    if found.triangle == NO_TRIANGLE {
        return false;
    }
    let equal = found.fraction == known.fraction && found.triangle < known.triangle;
    return known.triangle == NO_TRIANGLE || found.fraction < known.fraction || equal;
}

/// The crossing of a segment and a triangle while the mesh moves.
fn crossing_in(collider: Collider, mesh: MeshPart, start: vec3f, end: vec3f, triangle: u32) -> Crossing {
    let before = corners_of(mesh, triangle, collider.u);
    return crossing_of(start, end, before, corners_of(mesh, triangle, collider.v), triangle);
}

/// The crossings of a segment while the mesh moves.
fn passage_of(collider: Collider, mesh: MeshPart, start: vec3f, end: vec3f) -> Passage {
    let lo = select(end, start, start < end);
    let hi = select(start, end, start < end);
    var passage = Passage(no_crossing(), false);
    var walk = Walk(1u, 0u);
    while walk.index > 0u && may_turn() {
        let index = walk.index;
        if index >= 4u * mesh.width {
            let triangle = index - 4u * mesh.width;
            if triangle < mesh.count {
                let found = crossing_in(collider, mesh, start, end, triangle);
                passage.comes_out |= found.triangle != NO_TRIANGLE && !found.inward;
                if is_sooner(found, passage.hit) {
                    passage.hit = found;
                }
            }
            walk = on(walk, mesh);
            continue;
        }
        if !boxes_meet(mesh, index, lo, hi) {
            walk = on(walk, mesh);
            continue;
        }
        if index >= mesh.width {
            walk = into_leaf(walk);
        } else {
            walk = down(walk, 0u);
        }
    }
    return passage;
}

/// Which corners of a triangle are on an edge or a corner, given by its nodes; those that are none are NO_TRIANGLE.
fn corners_on(nodes: vec3u, wanted: vec3u) -> vec3<bool> {
    return vec3<bool>(any(wanted == vec3u(nodes.x)), any(wanted == vec3u(nodes.y)), any(wanted == vec3u(nodes.z)));
}

/// The outward direction, from the triangles around the nearest point.
struct Outward {
    way: vec3f,
    /// Square of the cosine between it and the direction from the nearest point; 0 for a sum.
    faces: f32,
}

/// Adds the pseudonormal of a triangle, if it shares the corner or edge of the nearest one that the nearest point is on: `own` are its
/// corners.
fn with_pseudonormal(
    sum: Outward, mesh: MeshPart, nearest: u32, own: vec3<bool>, triangle: u32, corners: Corners,
) -> Outward {
    let wanted = select(vec3u(NO_TRIANGLE), mesh_data[mesh.triangles + nearest].xyz, own);
    let at = corners_on(mesh_data[mesh.triangles + triangle].xyz, wanted);
    if corners_in(at) == corners_in(own) {
        return Outward(sum.way + pseudonormal(corners, at), 0.0);
    }
    return sum;
}

/// Square of the cosine between the direction from the nearest point and another.
fn facing(apart: vec3f, squared: f32, way: vec3f) -> f32 {
    let along = dot3(apart, way);
    return along * along / (squared * dot3(way, way) + TINY);
}

/// The normal of a triangle, if the triangle is within `bound` [m²] and its normal faces the position more.
fn more_facing(best: Outward, there: Nearest, corners: Corners, bound: f32) -> Outward {
    let normal = normal_of(corners);
    let faces = facing(there.apart, there.squared, normal);
    if there.squared <= bound && faces > best.faces {
        return Outward(normal, faces);
    }
    return best;
}

/// What is sought around a position.
struct Around {
    /// The nearest triangle, the first among those that are equally near; NO_TRIANGLE: none is as near as was asked for.
    nearest: u32,
    /// Squared distance of that [m²].
    squared: f32,
    outward: Outward,
}

/// What a walk looks for: the nearest triangle, the sum of the pseudonormals at its corner or edge, or the triangle that faces the
/// position most.
const SEEK_NEAREST: u32 = 0u;
const SEEK_SUM: u32 = 1u;
const SEEK_FACING: u32 = 2u;

/// Visits all triangles that may be within `bound` [m²] at the end of the sub-step. `own` are the corners of the nearest one that its
/// nearest point is on.
fn sought(
    known: Around, collider: Collider, mesh: MeshPart, x: vec3f, own: vec3<bool>, bound: f32, what: u32,
) -> Around {
    var around = known;
    var walk = Walk(1u, 0u);
    while walk.index > 0u && may_turn() {
        let index = walk.index;
        if index >= 4u * mesh.width {
            let triangle = index - 4u * mesh.width;
            walk = on(walk, mesh);
            if triangle >= mesh.count {
                continue;
            }
            let corners = corners_of(mesh, triangle, collider.v);
            let there = nearest_in(triangle, corners, x);
            if what == SEEK_NEAREST {
                let is_first = there.squared == around.squared && triangle < around.nearest;
                if there.squared < around.squared || is_first {
                    around.nearest = triangle;
                    around.squared = there.squared;
                }
            } else if what == SEEK_SUM {
                around.outward = with_pseudonormal(around.outward, mesh, around.nearest, own, triangle, corners);
            } else {
                around.outward = more_facing(around.outward, there, corners, bound);
            }
            continue;
        }
        let most = select(bound, min(around.squared, bound), what == SEEK_NEAREST);
        if box_squared(mesh, index, x) > most * LOOSE + mesh.rounding {
            walk = on(walk, mesh);
            continue;
        }
        if index >= mesh.width {
            walk = into_leaf(walk);
            continue;
        }
        let right_first = what == SEEK_NEAREST
            && box_squared(mesh, 2u * index + 1u, x) < box_squared(mesh, 2u * index, x);
        walk = down(walk, select(0u, 1u, right_first));
    }
    return around;
}

/// Depth and normal of a position by the nearest point.
fn resting(collider: Collider, mesh: MeshPart, x: vec3f, found: Nearest, corners: Corners, outward: vec3f) -> MeshContact {
    let distance = sqrt(found.squared);
    // The side of a sheet from which a segment crosses its plane.
    let away = select(x - corners.a, found.apart, mesh.is_solid);
    let within = dot3(away, outward) < 0.0;
    let side = select(1.0, -1.0, mesh.is_solid && within);
    var normal = found.apart * (side / distance);
    // At rounding distance, the direction from the nearest point is undefined.
    if !(found.squared > rounding_at(x)) {
        let length = norm3(outward);
        let inverse = 1.0 / select(1.0, length, length > 0.0);
        normal = outward * select(inverse, -inverse, within && !mesh.is_solid);
    }
    let velocity = changing(mesh, found.triangle, found.barycentric, collider.w);
    return MeshContact(normal, collider.size - distance * side, velocity, false);
}

/// The contact of a position within `most` [m]: depth and normal in the mesh's frame. A solid is searched from anywhere inside.
///
/// The outward direction of a solid is the normal of the nearest triangle; on an edge or a corner, a sum over the triangles that
/// share it, which are no farther away. A triangle at a grazing angle may be the nearest by rounding, and its normal is meaningless
/// then; so it is that of the triangle at the same distance up to rounding that faces the position most.
fn contact_near(collider: Collider, mesh: MeshPart, x: vec3f, most: f32) -> MeshContact {
    var around = Around(NO_TRIANGLE, FAR, Outward(vec3f(0.0), 0.0));
    // All walks and the end in one loop: compilers have a copy of a function wherever it is called. What is known of the nearest
    // triangle is computed again for each of them, as registers are dear while they last.
    for (var turn = SEEK_NEAREST; turn <= SEEK_FACING + 1u; turn++) {
        var bound = select(most * most, FAR, mesh.is_solid);
        var own = vec3<bool>(true);
        if turn != SEEK_NEAREST {
            if around.nearest == NO_TRIANGLE {
                break;
            }
            let corners = corners_of(mesh, around.nearest, collider.v);
            let found = nearest_in(around.nearest, corners, x);
            own = found.barycentric != vec3f(0.0);
            bound = found.squared;
            if turn == SEEK_SUM {
                let is_on_edge = mesh.is_solid && !all(own);
                around.outward.way = select(normal_of(corners), vec3f(0.0), is_on_edge);
                if !is_on_edge {
                    continue;
                }
            } else if turn == SEEK_FACING {
                around.outward.faces = facing(found.apart, found.squared, around.outward.way);
                bound = found.squared * (1.0 + EPSILON * 16.0);
                let is_grazing = around.outward.faces < GRAZING && found.squared > rounding_at(x);
                if !(mesh.is_solid && is_grazing) {
                    continue;
                }
            } else {
                return outward_of(resting(collider, mesh, x, found, corners, around.outward.way));
            }
        }
        around = sought(around, collider, mesh, x, own, bound, turn);
    }
    return outward_of(MeshContact(vec3f(0.0), -FAR, vec3f(0.0), false));
}

/// The contact of a node that moves straight from `start` to `end`, both in the mesh's frame.
fn contact_on_segment(collider: Collider, mesh: MeshPart, start: vec3f, end: vec3f) -> MeshContact {
    let none = MeshContact(vec3f(0.0), -FAR, vec3f(0.0), false);
    let reach = vec3f(collider.size + lost_in(mesh));
    if !is_somewhere(end) || !boxes_meet(mesh, 1u, min(start, end) - reach, max(start, end) + reach) {
        return none;
    }
    let passage = passage_of(collider, mesh, start, end);
    let at_end = contact_near(collider, mesh, end, collider.size);
    if turns > TURNS {
        return at_end;
    }
    let hit = passage.hit;
    if hit.triangle != NO_TRIANGLE {
        // Whether it is on the wrong side, so that the direction to the nearest point does not lead back. It leads
        // on, or the node has come out again, for example to enter another part of the mesh. The side of a sheet is
        // unknown if the node started on it up to rounding.
        let leads_on = at_end.depth <= 0.0 || dot3(at_end.normal, end - start) > 0.0;
        let has_passed = hit.inward && (passage.comes_out || leads_on);
        if select(hit.height > rounding_at(start), has_passed, mesh.is_solid) {
            let before = corners_of(mesh, hit.triangle, collider.u);
            let after = corners_of(mesh, hit.triangle, collider.v);
            let crossed = crossed_at(start, end, before, after, hit.fraction);
            let barycentric = crossed.areas * (1.0 / crossed.squared);
            let unit = 1.0 / sqrt(crossed.squared);
            let normal = crossed.normal * select(-unit, unit, hit.inward);
            let depth = collider.size - dot3(end - mix_of(after, barycentric), normal);
            return MeshContact(normal, depth, changing(mesh, hit.triangle, barycentric, collider.w), true);
        }
    }
    return MeshContact(at_end.normal, select(-FAR, at_end.depth, at_end.depth > 0.0), at_end.velocity, false);
}

/// The contact of a position; −FAR if it is farther away than `most` [m].
fn mesh_contact(collider: Collider, x: vec3f, most: f32) -> MeshContact {
    let mesh = part_of_mesh(collider);
    let place = local_of(collider, x);
    let reach = vec3f(most + lost_in(mesh));
    if !is_somewhere(place) || !boxes_meet(mesh, 1u, place - reach, place + reach) {
        return MeshContact(vec3f(0.0), -FAR, vec3f(0.0), false);
    }
    let found = contact_near(collider, mesh, place, most);
    return MeshContact(turned(collider, found.normal), found.depth, turned(collider, found.velocity), false);
}

/// The penetration of a position into a mesh, known inside only.
fn mesh_penetration(collider: Collider, x: vec3f) -> Depth {
    let found = mesh_contact(collider, x, collider.size);
    if found.depth > 0.0 {
        return Depth(found.normal, found.depth);
    }
    return Depth(vec3f(0.0), -FAR);
}

/// The same for nodes that start at its final position.
fn arrived(collider: Collider) -> Collider {
    var now = collider;
    now.u = now.v;
    return now;
}

/// Whether a node was less deep in a mesh at its start, by more than rounding, and not on its surface. `was` is how deep.
fn was_better(collider: Collider, start: vec3f, was: f32, depth: f32) -> bool {
    let lengths = abs(start.x) + abs(start.y) + abs(start.z);
    let slack = collider.size * 1e-3 + EPSILON * 64.0 * lengths;
    return depth > slack && was + slack < depth && (was <= 0.0 || was + slack < collider.size);
}

/// Collides a node with a mesh. In a groove, the node leaves a triangle along the triangle that it has left before.
/// If that does not converge, it returns to its start.
fn collide_mesh(start: ContactState, origin: Origin, given: Collider, number: u32, h: f32) -> ContactState {
    var collider = given;
    if !origin.is_carried {
        collider = arrived(given);
    }
    let mesh = part_of_mesh(collider);
    let place = seen_from(collider, origin);
    let come = local_of(collider, place);
    var node = start;
    var before = vec3f(0.0);
    var left = 0.0;
    for (var round = 0u; round <= GROOVES + 1u; round++) {
        // What comes last is where it started: all walks in one place, as in contact_near.
        let is_start = round > GROOVES;
        let found = contact_on_segment(collider, mesh, come, local_of(collider, select(node.x, place, is_start)));
        if is_start {
            if turns > TURNS {
                // None, so that the frame fails.
                node.x = found.normal;
            } else if was_better(collider, place, found.depth, left) {
                node.x = place;
            }
            break;
        }
        // The last response leaves a depth of rounding size.
        let rounding = EPSILON * ROUNDING_ULPS * (abs(node.x.x) + abs(node.x.y) + abs(node.x.z));
        let is_left = round > 0u && !found.passed && found.depth <= rounding;
        if found.depth == -FAR || is_left {
            break;
        }
        if round == GROOVES {
            if collider.u != collider.v {
                break;
            }
            left = found.depth;
            continue;
        }
        let contact = Depth(turned(collider, found.normal), found.depth);
        let surface = surface_velocity(collider, node.x) + turned(collider, found.velocity);
        node = respond_to_surface(node, collider, contact, surface, h);
        node.x = node.x + (leave_both(contact, Depth(before, 0.0)) - contact.normal * contact.depth);
        before = contact.normal;
        node.last = number;
    }
    return node;
}
