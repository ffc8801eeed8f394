// Membranes: forces on their corners, directions of their modes, and energies.

#import diagnostics/few.wgsl
#import elements/directions.wgsl
#import elements/energies.wgsl
#import elements/forces.wgsl
#import elements/membrane/membrane.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/substep.wgsl
#import gpu/wgsl/vector.wgsl
#import memory

/// Corners; Dm⁻¹ row by row [1/m]; C₁₁, C₁₂, C₂₂, G times the area [N·m]; damping time [s]; the Green strain of the limit.
struct Membrane {
    corners: array<u32, 3>,
    inverse_a: f32,
    inverse_b: f32,
    inverse_c: f32,
    inverse_d: f32,
    c11: f32,
    c12: f32,
    c22: f32,
    g: f32,
    damping: f32,
    limit: f32,
}

/// The largest number of 32 bits.
const LARGEST: f32 = 3.40282347e+38;

@group(1) @binding(50) var<storage, read> membranes: array<Membrane>;

fn sheet_of(one: Membrane) -> Sheet {
    let inverse = vec4f(one.inverse_a, one.inverse_b, one.inverse_c, one.inverse_d);
    return Sheet(inverse, vec4f(one.c11, one.c12, one.c22, one.g), one.damping, one.limit);
}

/// F of an element, now.
fn columns_at(corners: array<u32, 3>, inverse: vec4f) -> Columns {
    let first = position_of(corners[0]);
    return columns_of(position_of(corners[1]) - first, position_of(corners[2]) - first, inverse);
}

@compute @workgroup_size(256)
fn pull_membranes(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&membranes) {
        return;
    }
    let one = membranes[index];
    let sheet = sheet_of(one);
    let first = velocity_of(one.corners[0]);
    let rates =
        columns_of(velocity_of(one.corners[1]) - first, velocity_of(one.corners[2]) - first, sheet.inverse);
    let forces = membrane_forces(sheet, columns_at(one.corners, sheet.inverse), rates);
    element_forces[3u * index] = vec4f(forces.a, 0.0);
    element_forces[3u * index + 1u] = vec4f(forces.b, 0.0);
    element_forces[3u * index + 2u] = vec4f(forces.c, 0.0);
}

/// Keeps the directions of a mode over a step `h` [s]: k [N/m], d [kg/s]; and weights of what resists alike in all directions.
fn put_mode(at: u32, directions: Three, k: f32, d: f32, alike: vec3f) {
    let h = substeps[0].solving.inner;
    let root = sqrt(h * (h * k + d));
    element_directions[at] = vec4f(directions.a * root, alike.x);
    element_directions[at + 1u] = vec4f(directions.b * root, alike.y);
    element_directions[at + 2u] = vec4f(directions.c * root, alike.z);
}

/// Weights over the step of what resists across a direction in which a stress `k` pulls.
fn pulling_weights(direction: vec2f, k: f32, inverse: vec4f) -> vec3f {
    let h = substeps[0].solving.inner;
    let root = sqrt(h * (h * k));
    let first = direction.x * inverse.x + direction.y * inverse.y;
    let second = direction.x * inverse.z + direction.y * inverse.w;
    return vec3f(-(first + second), first, second) * root;
}

@compute @workgroup_size(256)
fn membrane_directions(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index >= arrayLength(&membranes) {
        return;
    }
    let sheet = sheet_of(membranes[index]);
    let f = columns_at(membranes[index].corners, sheet.inverse);
    let strain = strain_of(f);
    let c = sheet.stiffness;
    let limited = select(1.0, LIMITED, strain.strain.x > sheet.limit) * c.x;
    let follows = c.y / limited;
    let rest = select(1.0, LIMITED, strain.strain.y > sheet.limit) * c.z - c.y * c.y / limited;
    let viscous_rest = c.z - c.y * c.y / c.x;
    let stretched = columns_times(f, pulled_back(strain, vec3f(1.0, follows, 0.0)));
    let across = columns_times(f, pulled_back(strain, vec3f(0.0, 1.0, 0.0)));
    let sheared = columns_times(f, pulled_back(strain, vec3f(0.0, 0.0, 1.0)));
    let pull = pulling(pulled_back(strain, stress_of(sheet, strain.strain)));
    let major = pulling_weights(pull.xy, pull.z, sheet.inverse);
    let minor = pulling_weights(vec2f(-pull.y, pull.x), pull.w, sheet.inverse);
    let at = 9u * index;
    put_mode(at, on_corners(stretched, sheet.inverse), limited, sheet.damping * c.x, major);
    put_mode(at + 3u, on_corners(across, sheet.inverse), rest, sheet.damping * viscous_rest, minor);
    put_mode(at + 6u, on_corners(sheared, sheet.inverse), c.w, sheet.damping * c.w, vec3f(0.0));
}

@compute @workgroup_size(256)
fn measure_membranes(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    var found = 0.0;
    for (var index = id.x * 256u + lane; index < arrayLength(&membranes); index += counts.x * 256u) {
        let sheet = sheet_of(membranes[index]);
        found += membrane_energy(sheet, strain_of(columns_at(membranes[index].corners, sheet.inverse)).strain);
    }
    let all = gather_few(lane, vec2f(found, 0.0));
    if lane == 0u {
        element_energies[id.x] = all.x;
    }
}

/// Of each workgroup: the largest squared stretch along the warp, its negative, the same along the weft, and the largest squared
/// sine of the shear angle.
@group(3) @binding(9) var<storage, read_write> strains: array<f32>;

var<workgroup> stretches: array<vec4f, 256>;
var<workgroup> shears: array<f32, 256>;

@compute @workgroup_size(256)
fn measure_strains(
    @builtin(workgroup_id) id: vec3u,
    @builtin(num_workgroups) counts: vec3u,
    @builtin(local_invocation_index) lane: u32,
) {
    var stretch = vec4f(0.0, -LARGEST, 0.0, -LARGEST);
    var shear = 0.0;
    for (var index = id.x * 256u + lane; index < arrayLength(&membranes); index += counts.x * 256u) {
        let one = membranes[index];
        let f = columns_at(one.corners, vec4f(one.inverse_a, one.inverse_b, one.inverse_c, one.inverse_d));
        let c11 = dot3(f.warp, f.warp);
        let c22 = dot3(f.weft, f.weft);
        let c12 = dot3(f.warp, f.weft);
        let product = c11 * c22;
        stretch = max(stretch, vec4f(c11, -c11, c22, -c22));
        if product > 0.0 {
            shear = max(shear, c12 * c12 / product);
        }
    }
    stretches[lane] = stretch;
    shears[lane] = shear;
    for (var half = 128u; half > 0u; half /= 2u) {
        workgroupBarrier();
        if lane < half {
            stretches[lane] = max(stretches[lane], stretches[lane + half]);
            shears[lane] = max(shears[lane], shears[lane + half]);
        }
    }
    if lane == 0u {
        let all = stretches[0];
        strains[5u * id.x] = all.x;
        strains[5u * id.x + 1u] = all.y;
        strains[5u * id.x + 2u] = all.z;
        strains[5u * id.x + 3u] = all.w;
        strains[5u * id.x + 4u] = shears[0];
    }
}
