//! Contact with colliders, and of nodes with each other.

use crate::contact::colliders::gpu_layout::Collider;
use crate::contact::colliders::moving::{ColliderNow, ContactSurface};
use crate::contact::colliders::response::{NARROW, leave_both, respond};
use crate::contact::colliders::rigid::Rigid;
use crate::contact::colliders::shape::{
    BoxNow, CapsuleNow, CylinderNow, OnSolid, PlaneNow, ShapeNow, Solid, SphereNow, entry,
};
use crate::contact::nodes::pair::{self, ContactMaterial};
use crate::parity::formulas::{Case, Output, by_chance, vector, with_awkward};
use crate::real::{add, cross, dot, norm, scale};

/// The collider of a case, as the CPU has it.
fn collider(case: &Case) -> ColliderNow<f32> {
    let c = case.collider;
    let (place, size) = (c.place, c.size);
    let shape = match c.kind {
        0 => ShapeNow::Sphere(SphereNow { center: place, radius: size }),
        2 => ShapeNow::Box(BoxNow {
            center: place,
            axes: [c.axis_u, c.axis_v, c.axis_w],
            half: [c.u, c.v, c.w],
            offset: size,
        }),
        3 => ShapeNow::Capsule(CapsuleNow { a: place, along: c.axis_u, inverse: c.u, radius: size }),
        4 => ShapeNow::Cylinder(CylinderNow {
            center: place,
            axis: c.axis_u,
            half: c.u,
            radius: c.v,
            offset: size,
        }),
        _ => ShapeNow::Plane(PlaneNow { normal: place, level: size }),
    };
    let surface = ContactSurface {
        friction: c.friction,
        restitution: c.restitution,
        spin: [c.spin_x, c.spin_y, c.spin_z],
        drift: c.drift,
        carry: Rigid::rest(),
    };
    ColliderNow { shape, surface }
}

/// Every other case has a half-space.
fn with_planes(mut cases: Vec<Case>) -> Vec<Case> {
    for case in cases.iter_mut().step_by(2) {
        let length = norm(case.c);
        case.collider.kind = 1;
        case.collider.place = case.c.map(|c| c / length);
    }
    cases
}

/// The case with a box (2), a capsule (3) or a cylinder (4), its axes by chance.
fn with_shape(case: &Case, kind: u32) -> Case {
    let unit = |x: [f32; 3]| scale(x, 1.0 / norm(x));
    let u = unit(case.c);
    let v = unit(cross(u, case.d));
    let (w, half) = (cross(u, v), case.b.map(|x| 0.1 + 0.6 * x.abs()));
    let shaped = Collider { kind, size: 0.05 * case.collider.size, ..case.collider };
    let collider = match kind {
        2 => Collider { axis_u: u, u: half[0], axis_v: v, v: half[1], axis_w: w, w: half[2], ..shaped },
        3 => Collider { axis_u: case.c, u: 1.0 / dot(case.c, case.c), size: half[0], ..shaped },
        _ => Collider { axis_u: u, u: half[0], v: half[1], ..shaped },
    };
    Case { collider, ..*case }
}

/// Boxes and bars at rest at the origin: places at their very middle, on and beside faces, edges and ends, and where two
/// faces are equally near.
fn about_edges(base: &Case) -> Vec<Case> {
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let still = Collider { place: [0.0; 3], size: 0.125, ..base.collider };
    let shapes = [
        Collider { kind: 2, axis_u: x, u: 0.5, axis_v: y, v: 0.5, axis_w: z, w: 0.75, ..still },
        Collider { kind: 3, axis_u: x, u: 1.0, ..still },
        Collider { kind: 3, axis_u: [0.0; 3], u: 0.0, ..still },
        Collider { kind: 4, axis_u: y, u: 0.5, v: 0.5, ..still },
        Collider { kind: 4, axis_u: z, u: 0.75, v: 0.5, ..still },
        Collider { kind: 4, axis_u: x, u: 0.5, v: 0.25, ..still },
        Collider { kind: 4, axis_u: [0.6, 0.8, 0.0], u: 0.75, v: 0.5, ..still },
    ];
    let near = [0.0_f32, 0.5_f32.next_down(), 0.5, 0.5_f32.next_up(), -0.5, 0.75, 1.0, 1e-20, 1.1e-15];
    let places: Vec<[f32; 3]> = near
        .iter()
        .flat_map(|&a| near.iter().flat_map(move |&b| [[a, b, 0.25], [b, 0.25, a], [a, 0.0, 0.0]]))
        .collect();
    let at = |collider: Collider| places.iter().map(move |&a| Case { a, collider, ..*base });
    shapes.into_iter().flat_map(at).collect()
}

/// At a ball's very centre and about it, on surfaces and a hair beside them.
pub fn places(exact: bool) -> Vec<Case> {
    let mut cases = with_planes(by_chance(8, 200));
    let shapes = by_chance(17, 300);
    cases.extend(shapes.iter().zip([2, 3, 4].into_iter().cycle()).map(|(case, kind)| with_shape(case, kind)));
    let ball = cases[1];
    let centre = ball.collider.place;
    let mut awkward = vec![Case { a: centre, ..ball }];
    for length in [1e-20_f32, 0.9e-15, 1e-15, 1.1e-15, 1e-10] {
        let mut case = Case { a: [length, 0.0, 0.0], ..ball };
        case.collider.place = [0.0; 3];
        awkward.push(case);
    }
    for level in [0.5_f32.next_down(), 0.5, 0.5_f32.next_up()] {
        let mut case = Case { a: [0.3, 0.5, 0.2], ..cases[0] };
        (case.collider.place, case.collider.size) = ([0.0, 1.0, 0.0], level);
        awkward.push(case);
    }
    awkward.extend(about_edges(&ball));
    with_awkward(cases, exact, awkward)
}

/// Ways through solids of all shapes and past them, from outside and inside; some that end where they enter, and some that
/// only touch.
pub fn ways(exact: bool) -> Vec<Case> {
    let across = |case: &Case, kind: u32| {
        let way = Case {
            a: add(case.collider.place, scale(case.a, 3.0)),
            d: add(case.collider.place, scale(add(scale(case.a, -1.0), scale(case.d, 0.3)), 3.0)),
            ..*case
        };
        let mut shaped = if kind == 0 { way } else { Case { d: way.d, ..with_shape(&way, kind) } };
        shaped.collider.size *= if kind == 0 { 0.3 } else { 1.0 };
        shaped
    };
    let cases: Vec<Case> = by_chance(18, 400)
        .iter()
        .zip([0, 2, 3, 4].into_iter().cycle())
        .flat_map(|(case, kind)| {
            let way = across(case, kind);
            [way, Case { d: way.a, a: way.d, ..way }, Case { d: scale(way.d, 0.2), ..way }]
        })
        .collect();
    let still = Collider { kind: 2, place: [0.0; 3], size: 0.0, ..cases[1].collider };
    let [x, y, z] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let cube = Collider { axis_u: x, u: 0.5, axis_v: y, v: 0.5, axis_w: z, w: 0.5, ..still };
    let way = |a: [f32; 3], d: [f32; 3]| Case { a, d, collider: cube, ..cases[0] };
    let awkward = [
        way([0.25, 2.0, 0.25], [0.25, -2.0, 0.25]),
        way([0.25, 2.0, 0.25], [0.25, 0.5, 0.25]),
        way([0.5, 2.0, 0.25], [0.5, -2.0, 0.25]),
        way([2.0, 2.0, 0.0], [-1.0, -1.0, 0.0]),
        way([0.25, 0.5, 0.25], [0.25, -2.0, 0.25]),
        way([0.25, 0.125, 0.25], [0.25, -2.0, 0.25]),
        way([0.25, 2.0, 0.25], [0.25, 2.0, 0.25]),
    ];
    with_awkward(cases, exact, awkward)
}

/// Where a way enters a solid.
struct Enter([[f32; 3]; 2]);

impl OnSolid<f32> for Enter {
    type Output = Option<(f32, [f32; 3])>;
    fn run<S: Solid<f32>>(self, solid: S) -> Self::Output {
        entry(solid, self.0[0], self.0[1])
    }
}

/// The deepest place of a solid.
struct Deepest;

impl OnSolid<f32> for Deepest {
    type Output = f32;
    fn run<S: Solid<f32>>(self, solid: S) -> f32 {
        solid.deepest()
    }
}

pub fn entrance(case: &Case) -> Output {
    let shape = collider(case).shape;
    let found = shape.convex(Enter([case.a, case.d])).flatten();
    let (depth, normal) = found.unwrap_or((0.0, [0.0; 3]));
    let is_one = if found.is_some() { 1.0 } else { 0.0 };
    let deepest = shape.convex(Deepest).unwrap_or(0.0);
    [vector(normal, depth), vector([is_one, deepest, 0.0], 0.0), [0.0; 4], [0.0; 4]]
}

pub fn depth(case: &Case) -> Output {
    let (depth, normal) = collider(case).depth_and_normal(case.a).unwrap();
    [vector(normal, depth), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Coming, leaving and neither; slipping as fast as friction can stop, and a hair faster and slower.
pub fn touches(exact: bool) -> Vec<Case> {
    let cases = with_planes(by_chance(9, 400));
    let mut still = cases[0];
    still.collider = Collider {
        place: [0.0, 1.0, 0.0],
        size: 0.25,
        friction: 0.5,
        restitution: 0.25,
        spin_x: [0.0; 3],
        spin_y: [0.0; 3],
        spin_z: [0.0; 3],
        drift: [0.0; 3],
        ..still.collider
    };
    // Impulse (1 + 1/4) · 2 = 5/2, of which friction can take half.
    let slips = [0.0, 1.25_f32.next_down(), 1.25, 1.25_f32.next_up(), 3.0];
    let mut awkward = Vec::new();
    for speed in [-2.0, -1e-30, 0.0, 1e-30, 2.0] {
        awkward.extend(slips.map(|slip| Case { a: [0.1, 0.2, 0.3], b: [slip, speed, 0.0], ..still }));
    }
    with_awkward(cases, exact, awkward)
}

pub fn response(case: &Case) -> Output {
    let collider = collider(case);
    let contact = collider.surface.contact_at(case.a, collider.depth_and_normal(case.a).unwrap());
    let (x, v) = respond(case.a, case.b, &contact, case.s);
    [vector(x, 0.0), vector(v, 0.0), [0.0; 4], [0.0; 4]]
}

/// Faces at all angles: one of which is left with the other, or faces it, and about these.
pub fn wedges(exact: bool) -> Vec<Case> {
    let unit = |x: [f32; 3]| scale(x, 1.0 / norm(x));
    let cases: Vec<Case> =
        by_chance(10, 400).iter().map(|c| Case { a: unit(c.a), b: unit(c.b), ..*c }).collect();
    let mut awkward = Vec::new();
    for base in &cases[..5] {
        let limit = base.s * dot(base.a, base.b);
        awkward.extend([limit.next_down(), limit, limit.next_up()].map(|t| Case { t, ..*base }));
        awkward.extend([base.a, base.a.map(|c| -c)].map(|b| Case { b, ..*base }));
        // Rooms about the narrowest, the squared sine of the angle between the faces.
        for sine in (0..20).map(|i| (NARROW as f32).sqrt() * (0.95 + 0.005 * i as f32)) {
            let b = [-(1.0 - sine * sine).sqrt(), sine, 0.0];
            awkward.push(Case { a: [1.0, 0.0, 0.0], b, ..*base });
        }
    }
    with_awkward(cases, exact, awkward)
}

pub fn way_out(case: &Case) -> Output {
    let way = leave_both((case.s, case.a), (case.t, case.b));
    [vector(way, 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Coming, leaving and neither; slipping as fast as friction can stop, and a hair faster and slower; at one place, at the
/// distance that is kept, and parting as fast as that; held on both sides.
pub fn exchanges(exact: bool) -> Vec<Case> {
    let positive = |case: Case| Case { c: case.c.map(f32::abs), d: case.d.map(f32::abs), ..case };
    // Far inside of the distance that is kept, and limited in how far they may go apart.
    let near =
        |case: Case| Case { a: scale(case.a, 0.2), t: case.t.abs(), u: 0.3 * case.u.abs(), ..positive(case) };
    let far = by_chance(15, 400).into_iter().map(positive);
    let cases: Vec<Case> = far.chain(by_chance(16, 400).into_iter().map(near)).collect();
    // Impulse (1 + 1/4) · 2 = 5/2, of which friction can take half.
    let still = Case { a: [0.0, 0.25, 0.0], c: [0.5, 0.5, 0.25], s: 0.5, t: 0.0625, u: 0.25, ..cases[0] };
    let slips = [0.0, 1.25_f32.next_down(), 1.25, 1.25_f32.next_up(), 3.0];
    let mut awkward = vec![Case { a: [0.0; 3], ..still }, Case { s: 0.0, ..still }];
    for speed in [-2.0, -1e-30, 0.0, 1e-30, 2.0] {
        awkward.extend(slips.map(|slip| Case { b: [slip, speed, 0.0], ..still }));
    }
    awkward.extend([0.5, 0.6, 0.375, 0.374, 1e-15].map(|y| Case { a: [0.0, y, 0.0], ..still }));
    with_awkward(cases, exact, awkward)
}

pub fn exchange(case: &Case) -> Output {
    let material =
        |[thickness, friction, restitution]: [f32; 3]| ContactMaterial { thickness, friction, restitution };
    let done = pair::exchange(case.a, case.b, case.s, &material(case.c), (case.t, case.u));
    let met = pair::combine_materials(&material(case.c), &material(case.d));
    let met = [met.thickness, met.friction, met.restitution];
    [vector(done.impulse, 0.0), vector(done.shift, 0.0), vector(met, 0.0), [0.0; 4]]
}
