// Formulas alone, from numbers to numbers: an invocation takes a case of the formula that the pipeline is made for.

#import contact/colliders/response.wgsl
#import contact/colliders/shape.wgsl
#import contact/nodes/pair.wgsl
#import elements/aero/aero.wgsl
#import elements/aero/gust.wgsl
#import elements/hinge/hinge.wgsl
#import elements/load/load.wgsl
#import elements/spring/spring.wgsl
#import gpu/wgsl/angle.wgsl
#import gpu/wgsl/index.wgsl
#import gpu/wgsl/vector.wgsl
#import solvers/explicit/euler.wgsl
#import volume/volume.wgsl

override FORMULA: u32 = 0u;

/// What a formula is given, as far as it takes numbers and vectors.
struct Case {
    a: vec3f,
    s: f32,
    b: vec3f,
    t: f32,
    c: vec3f,
    u: f32,
    d: vec3f,
    w: f32,
    collider: Collider,
}

/// What it gives; what is left is 0.
struct Output {
    a: vec4f,
    b: vec4f,
    c: vec4f,
    d: vec4f,
}

@group(2) @binding(16) var<storage, read> cases: array<Case>;
@group(3) @binding(16) var<storage, read_write> answers: array<Output>;

fn one_vector(x: vec3f, s: f32) -> Output {
    return Output(vec4f(x, s), vec4f(0.0), vec4f(0.0), vec4f(0.0));
}

fn numbers(s: f32, t: f32, u: f32) -> Output {
    return one_vector(vec3f(s, t, u), 0.0);
}

fn output(case_of: Case) -> Output {
    let a = case_of.a;
    let b = case_of.b;
    switch FORMULA {
        case 0u: {
            return one_vector(vec3f(wrap(case_of.s), wrap(case_of.t), 0.0), angle_of(case_of.s, case_of.t));
        }
        case 1u: {
            let factor = spring_factor(a, b, case_of.s, case_of.t, case_of.u);
            return numbers(factor, spring_energy(case_of.w, case_of.s, case_of.u), norm3(a));
        }
        case 2u: {
            let fold = fold_of(a, b, case_of.c, case_of.d);
            return Output(
                vec4f(fold.at_a, fold.theta), vec4f(fold.at_b, hinge_energy(fold, case_of.s, case_of.t)),
                vec4f(fold.at_c, steepness(fold)), vec4f(fold.at_d, 0.0),
            );
        }
        case 3u: {
            let arm = lever(a, b, case_of.c);
            let load = wind_and_drag(a, case_of.t, b);
            return Output(vec4f(arm, torque_factor(case_of.s, dot3(arm, arm))), vec4f(load, 0.0), vec4f(0.0), vec4f(0.0));
        }
        case 4u: {
            let contact = depth_and_normal(case_of.collider, a);
            return one_vector(contact.normal, contact.depth);
        }
        case 5u: {
            let contact = depth_and_normal(case_of.collider, a);
            let after = respond(ContactState(a, 0u, b), case_of.collider, contact, case_of.s);
            return Output(vec4f(after.x, 0.0), vec4f(after.v, 0.0), vec4f(0.0), vec4f(0.0));
        }
        case 6u: {
            return one_vector(leave_both(Depth(a, case_of.s), Depth(b, case_of.t)), 0.0);
        }
        case 8u: {
            let form = case_of.collider.kind;
            return numbers(multiplier(form, a, case_of.s, case_of.t), projection(a, case_of.s), f32(is_restored(a, case_of.s)));
        }
        case 9u: {
            return one_vector(solve_symmetric(a, b, case_of.c), 0.0);
        }
        case 10u: {
            let material = ContactMaterial(case_of.c.x, case_of.c.y, case_of.c.z);
            let done = exchange(a, b, case_of.s, material, case_of.t, case_of.u);
            let met = combine_materials(material, ContactMaterial(case_of.d.x, case_of.d.y, case_of.d.z));
            return Output(
                vec4f(done.impulse, 0.0), vec4f(done.shift, 0.0),
                vec4f(met.thickness, met.friction, met.restitution, 0.0), vec4f(0.0),
            );
        }
        case 11u: {
            let none = Gusts(vec3f(0.0), 0.0, vec2u(0u), vec2f(0.0));
            let air = Air(vec3f(0.0), case_of.s, case_of.t, case_of.u, case_of.w, none);
            return one_vector(corner_force(air, a, b, case_of.c.x), 0.0);
        }
        case 12u: {
            let keys = vec2u(bitcast<u32>(case_of.c.x), bitcast<u32>(case_of.c.y));
            let gusts = Gusts(b, case_of.s, keys, vec2f(case_of.t, case_of.u));
            return one_vector(gust_velocity(gusts, a), 0.0);
        }
        case 13u: {
            let found = entry_of(case_of.collider, a, case_of.d);
            let more = vec4f(f32(found.is_one), deepest_in(case_of.collider), 0.0, 0.0);
            return Output(vec4f(found.contact.normal, found.contact.depth), more, vec4f(0.0), vec4f(0.0));
        }
        default: {
            let v = new_velocity_of(a, b, case_of.s, case_of.c, case_of.t);
            return Output(vec4f(v, 0.0), vec4f(new_position_of(case_of.d, v, case_of.t), 0.0), vec4f(0.0), vec4f(0.0));
        }
    }
}

@compute @workgroup_size(256)
fn formulas(@builtin(workgroup_id) id: vec3u, @builtin(local_invocation_index) lane: u32) {
    let index = workgroup_index(id) * 256u + lane;
    if index < arrayLength(&cases) {
        answers[index] = output(cases[index]);
    }
}
