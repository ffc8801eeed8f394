//! Rows of the formulas alone, on values by chance and on awkward ones.

use super::bench::{Bench, Given};
use super::fixture::{Arrays, Chance, words};
use super::{Row, Tolerance};
use crate::collision::contact::{NARROW, leave_both, respond};
use crate::collision::moving::{ColliderNow, Rigid, Touching};
use crate::collision::pair::{self, Meeting};
use crate::collision::shape::{
    BoxNow, CapsuleNow, CylinderNow, OnSolid, PlaneNow, ShapeNow, Solid, SphereNow, entry,
};
use crate::constraints::volume::{self, FLAT, Form};
use crate::forces::air::AirNow;
use crate::forces::gust::GustNow;
use crate::forces::{external, hinge, spring};
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Collider, Four};
use crate::integrate::euler;
use crate::real::{Real, add, cross, dot, norm, scale};
use taffeta_gpu::bytemuck::{Pod, Zeroable};

/// Compiled behind the sources of all kernels.
pub const SOURCE: &str = include_str!("formulas.wgsl");

/// `Case` of formulas.wgsl.
#[repr(C)]
#[derive(Clone, Copy, Pod, Zeroable)]
pub struct Case {
    pub a: [f32; 3],
    pub s: f32,
    pub b: [f32; 3],
    pub t: f32,
    pub c: [f32; 3],
    pub u: f32,
    pub d: [f32; 3],
    pub w: f32,
    pub collider: Collider,
}

/// `Answer` of formulas.wgsl.
type Answer = [Four; 4];

const SAME: &str = "the same operations in the same order; hardware may fuse products and sums";
const NEAR: &str = "as above; where numbers nearly cancel, what hardware rounds otherwise is left";

/// One row for each formula. On hardware awkward values are left out.
pub const ROWS: &[Row] = &[
    row("angle_of", Tolerance::new(0.0, 8.0, SAME), |bench| formula(bench, 0, &angles(), angle)),
    row("spring_factor", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = springs(bench.exact);
        formula(bench, 1, &cases, pull)
    }),
    row("fold_of", Tolerance::new(0.0, 512.0, NEAR), |bench| {
        let cases = folds(bench.exact);
        formula(bench, 2, &cases, fold)
    }),
    row("external", Tolerance::new(0.0, 1024.0, NEAR), |bench| {
        let cases = levers(bench.exact);
        formula(bench, 3, &cases, load)
    }),
    row("depth_and_normal", Tolerance::new(0.0, 64.0, SAME), |bench| {
        let cases = places(bench.exact);
        formula(bench, 4, &cases, depth)
    }),
    row("entry_of", Tolerance::new(0.0, 4096.0, NEAR), |bench| {
        let cases = ways(bench.exact);
        formula(bench, 13, &cases, entrance)
    }),
    row("respond", Tolerance::new(0.0, 32.0, NEAR), |bench| {
        let cases = touches(bench.exact);
        formula(bench, 5, &cases, response)
    }),
    row("leave_both", Tolerance::new(0.0, 4096.0, NEAR), |bench| {
        let cases = wedges(bench.exact);
        formula(bench, 6, &cases, way_out)
    }),
    row("multiplier", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = multipliers(bench.exact);
        formula(bench, 8, &cases, lambda)
    }),
    row("solve_symmetric", Tolerance::new(0.0, 4096.0, NEAR), |bench| {
        let cases = tensors(bench.exact);
        formula(bench, 9, &cases, solution)
    }),
    row("exchange", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = exchanges(bench.exact);
        formula(bench, 10, &cases, exchange)
    }),
    row("euler", Tolerance::new(0.0, 8.0, SAME), |bench| {
        let cases = by_chance(7, 300);
        formula(bench, 7, &cases, step)
    }),
    row("corner_force", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = blown(bench.exact);
        formula(bench, 11, &cases, push)
    }),
    row("gust_velocity", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = gusts(bench.exact);
        formula(bench, 12, &cases, gust)
    }),
];

const fn row(
    name: &'static str,
    tolerance: Tolerance,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> Row {
    Row { name, entry: "formulas", tolerance, check }
}

fn formula(
    bench: &mut Bench<'_>,
    number: u32,
    cases: &[Case],
    twin: fn(&Case) -> Answer,
) -> Result<(), String> {
    let kernel = bench.kernel(Name::new("formulas"), &[SOURCE], &[("FORMULA", f64::from(number))])?;
    let answers: Vec<Answer> = cases.iter().map(twin).collect();
    let poison = vec![f32::NAN.to_bits(); 16 * (cases.len() + 1)];
    let arrays = Arrays::from([("cases", words(cases)), ("answers", poison)]);
    let given = Given { arrays: &arrays, records: &[], groups: cases.len().div_ceil(256) };
    bench.run(&kernel, &given, |written| {
        let found: Vec<f32> = written.take("answers");
        let (found, rest) = found.split_at(16 * cases.len());
        let (wanted, found) = (answers.as_flattened(), found.as_chunks::<4>().0);
        for (quantity, name) in ["a", "b", "c", "d"].into_iter().enumerate() {
            let of = |fours: &[Four]| fours.iter().skip(quantity).step_by(4).copied().collect::<Vec<_>>();
            written.compare_fours(name, &of(wanted), &of(found));
        }
        written.outcome().copied("answers, past their end", &[f32::NAN; 16], rest);
    })
}

/// A case of numbers that are neither zero nor one, with a ball.
fn chance_case(chance: &mut Chance) -> Case {
    let [x, y, z] = chance.three(0.5);
    Case {
        a: chance.three(0.9),
        s: 0.3 + 0.2 * chance.number(),
        b: chance.three(0.9),
        t: 0.4 + 0.3 * chance.number(),
        c: chance.three(0.9),
        u: 0.5 + 0.4 * chance.number(),
        d: chance.three(0.9),
        w: 0.6 + 0.3 * chance.number(),
        collider: Collider {
            place: [x, y, z],
            size: 1.1 + 0.5 * chance.number(),
            spin_x: chance.three(2.0),
            friction: 0.5 + 0.4 * chance.number(),
            spin_y: chance.three(2.0),
            restitution: 0.5 + 0.4 * chance.number(),
            spin_z: chance.three(2.0),
            kind: 0,
            drift: chance.three(1.5),
            ..Collider::zeroed()
        },
    }
}

fn by_chance(seed: u64, count: usize) -> Vec<Case> {
    let mut chance = Chance::new(seed);
    (0..count).map(|_| chance_case(&mut chance)).collect()
}

/// Awkward cases, which a fused product may send the other way at a branch, behind those by chance.
fn with_awkward(mut cases: Vec<Case>, exact: bool, awkward: impl IntoIterator<Item = Case>) -> Vec<Case> {
    cases.extend(awkward.into_iter().filter(|_| exact));
    cases
}

fn vector([x, y, z]: [f32; 3], w: f32) -> Four {
    [x, y, z, w]
}

/// All octants and sizes, the seams between them, and half a turn and more to wrap.
fn angles() -> Vec<Case> {
    use std::f32::consts::PI;
    let [base] = by_chance(3, 1)[..] else { return Vec::new() };
    let tan = 0.414_213_57_f32;
    let sizes =
        [0.0, 1e-30, 1e-20, 1e-6, 0.1, tan.next_down(), tan, tan.next_up(), 0.7, 1.0, 2.414_2, 50.0, 1e12];
    let mut cases = Vec::new();
    for y in sizes.iter().flat_map(|&size| [size, -size]) {
        cases.extend(sizes.iter().flat_map(|&size| [size, -size]).map(|x| Case { s: y, t: x, ..base }));
    }
    for turn in [PI.next_down(), PI, PI.next_up(), 6.2, 6.5] {
        cases.push(Case { s: turn, t: -turn, ..base });
    }
    cases
}

fn angle(case: &Case) -> Answer {
    let wrapped = [hinge::wrap(case.s), hinge::wrap(case.t), 0.0];
    [vector(wrapped, Real::atan2(case.s, case.t)), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Panels and flows of about the least size that counts; along each other, and across.
fn blown(exact: bool) -> Vec<Case> {
    let cases = by_chance(12, 300);
    let sizes = [0.0, 1e-20, 0.9e-15, 1e-15, 1.1e-15, 1e-10, 1e3, 1e9];
    let bases = cases.clone();
    let awkward = sizes.into_iter().zip(bases).flat_map(|(size, base)| {
        let along = [size, 0.0, 0.0];
        [
            Case { a: along, ..base },
            Case { b: along, ..base },
            Case { a: along, b: along, ..base },
            Case { a: along, b: [0.0, 2.0, 0.0], ..base },
            Case { a: base.b, b: scale(base.b, size), ..base },
        ]
    });
    with_awkward(cases, exact, awkward)
}

fn push(case: &Case) -> Answer {
    let air = AirNow { density: case.s, exposure: case.t, drag: case.u, lift: case.w, ..AirNow::default() };
    [vector(air.corner_force(case.a, case.b, case.c[0]), 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Places some cells around, on lattice points and between them, and where cells are no longer told apart.
fn gusts(exact: bool) -> Vec<Case> {
    let around = |case: Case| Case { a: scale(case.a, 20.0), s: 1.7 * case.s, ..case };
    let cases: Vec<Case> = by_chance(13, 300).into_iter().map(around).collect();
    let places = [0.0, -0.0, 1.0, -1.0, 1.5, -7.0, -1e-8, 1.0 - 1e-7, 16_777_215.0, 9.9e8, 1e9, 1.1e9, -3e20];
    let bases = cases.clone();
    let awkward = places.into_iter().zip(bases).flat_map(|(place, base)| {
        let on = Case { b: [0.0; 3], s: 1.0, ..base };
        [Case { a: [place; 3], ..on }, Case { a: [place, 0.3, -place], ..on }]
    });
    with_awkward(cases, exact, awkward)
}

fn gust(case: &Case) -> Answer {
    let gust = GustNow {
        cells_a_metre: case.s,
        offset: case.b,
        keys: [case.c[0].to_bits(), case.c[1].to_bits()],
        weights: [case.t, case.u],
    };
    let [[x], [y], [z]] = gust.velocities(&case.a.map(|c| [c]));
    [vector([x, y, z], 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Ends at one place, at about the length below which none is told from it, and very far.
fn springs(exact: bool) -> Vec<Case> {
    let cases = by_chance(4, 200);
    let lengths = [0.0, 1e-30, 1e-20, 0.9e-15, 1e-15, 1.1e-15, 1e-14, 1e-10, 1e3, 1e9, 1e15];
    let bases = cases.clone();
    let awkward = lengths.into_iter().zip(bases).flat_map(|(length, base)| {
        let along = Case { a: [length, 0.0, 0.0], ..base };
        [along, Case { a: scale(base.a, length), ..base }]
    });
    with_awkward(cases, exact, awkward)
}

fn pull(case: &Case) -> Answer {
    let factor = spring::factor(case.a, case.b, case.s, case.t, case.u);
    let numbers = [factor, spring::energy(case.w, case.s, case.u), norm(case.a)];
    [vector(numbers, 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Slivers, triangles without area, an edge without length or of about the least; flat, and folded onto itself.
fn folds(exact: bool) -> Vec<Case> {
    let cases = by_chance(5, 300);
    let mut awkward = Vec::new();
    for base in &cases[..8] {
        awkward.extend([
            Case { c: base.a, ..*base },
            Case { d: base.b, ..*base },
            Case { b: base.a, ..*base },
            Case { d: base.c, ..*base },
            Case {
                c: std::array::from_fn(|i| 0.499 * base.a[i] + 0.5 * base.b[i] + 0.001 * base.c[i]),
                ..*base
            },
        ]);
        for length in [1e-20, 0.9e-15, 1e-15, 1.1e-15, 1e-8, 1e-7, 1e3, 1e6] {
            let small = |x: [f32; 3]| scale(x, length);
            awkward.push(Case {
                a: small(base.a),
                b: small(base.b),
                c: small(base.c),
                d: small(base.d),
                ..*base
            });
        }
        let flat = |[x, y, _]: [f32; 3]| [x, y, 0.0];
        awkward.push(Case { a: flat(base.a), b: flat(base.b), c: flat(base.c), d: flat(base.d), ..*base });
    }
    with_awkward(cases, exact, awkward)
}

fn fold(case: &Case) -> Answer {
    let corners = [case.a, case.b, case.c, case.d];
    let (theta, gradient) = hinge::angle_and_gradient(corners);
    let [a, b, c, d] = gradient;
    let energy = hinge::energy(corners, case.s, case.t);
    [vector(a, theta), vector(b, energy), vector(c, hinge::steepness(&gradient)), vector(d, 0.0)]
}

/// Levers of no length and of about the least.
fn levers(exact: bool) -> Vec<Case> {
    let cases = by_chance(6, 200);
    let lengths = [0.0_f32, 1e-20, 0.9e-15, 1e-15, 1.1e-15, 1e-8];
    let bases = cases.clone();
    let awkward = lengths.into_iter().zip(bases).map(|(length, base)| {
        let along = Case { a: [length, 0.0, 0.0], b: [0.0, 0.0, 1.0], c: [0.0; 3], ..base };
        if length > 0.0 { along } else { Case { c: base.a, ..base } }
    });
    with_awkward(cases, exact, awkward)
}

fn load(case: &Case) -> Answer {
    let arm = external::lever(case.a, case.b, case.c);
    let factor = external::torque_factor(case.s, std::iter::once(arm));
    let load = std::array::from_fn(|i| external::wind_and_drag(case.a[i], case.t, case.b[i]));
    [vector(arm, factor), vector(load, 0.0), [0.0; 4], [0.0; 4]]
}

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
    let touching = Touching {
        friction: c.friction,
        restitution: c.restitution,
        spin: [c.spin_x, c.spin_y, c.spin_z],
        drift: c.drift,
        carry: Rigid::rest(),
    };
    ColliderNow { shape, touching }
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
fn places(exact: bool) -> Vec<Case> {
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
fn ways(exact: bool) -> Vec<Case> {
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

fn entrance(case: &Case) -> Answer {
    let shape = collider(case).shape;
    let found = shape.convex(Enter([case.a, case.d])).flatten();
    let (depth, normal) = found.unwrap_or((0.0, [0.0; 3]));
    let is_one = if found.is_some() { 1.0 } else { 0.0 };
    let deepest = shape.convex(Deepest).unwrap_or(0.0);
    [vector(normal, depth), vector([is_one, deepest, 0.0], 0.0), [0.0; 4], [0.0; 4]]
}

fn depth(case: &Case) -> Answer {
    let (depth, normal) = collider(case).depth_and_normal(case.a).unwrap();
    [vector(normal, depth), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Coming, leaving and neither; slipping as fast as friction can stop, and a hair faster and slower.
fn touches(exact: bool) -> Vec<Case> {
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

fn response(case: &Case) -> Answer {
    let collider = collider(case);
    let touch = collider.touching.touch(case.a, collider.depth_and_normal(case.a).unwrap());
    let (x, v) = respond(case.a, case.b, &touch, case.s);
    [vector(x, 0.0), vector(v, 0.0), [0.0; 4], [0.0; 4]]
}

/// Faces at all angles: one of which is left with the other, or faces it, and about these.
fn wedges(exact: bool) -> Vec<Case> {
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

fn way_out(case: &Case) -> Answer {
    let way = leave_both((case.s, case.a), (case.t, case.b));
    [vector(way, 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

fn step(case: &Case) -> Answer {
    let v = std::array::from_fn(|i| euler::velocity(case.a[i], case.b[i], case.s, case.c[i], case.t));
    let x = std::array::from_fn(|i| euler::position(case.d[i], v[i], case.t));
    [vector(v, 0.0), vector(x, 0.0), [0.0; 4], [0.0; 4]]
}

const FORMS: [Form; 4] = [Form::Kept, Form::PaperShader, Form::Printed, Form::Pressure];

/// Every form; nodes that can move, hardly, not at all and about the least; volumes that are as they should be, and nearly.
fn multipliers(exact: bool) -> Vec<Case> {
    let mut cases = by_chance(12, 200);
    let tiny = <f32 as Real>::TINY;
    let (bases, mut awkward) = (cases.clone(), Vec::new());
    for (base, response) in bases.iter().zip([0.0, -0.5, tiny.next_down(), tiny, tiny.next_up()]) {
        awkward.extend((0..4).map(|_| Case { a: [base.a[0], base.a[1], response], ..*base }));
    }
    // A volume of which the error that is tolerated is exactly 9 units in the last place.
    let goal = (8_990_000..9_010_000).map(|goal: i32| goal as f32);
    let goal = goal.clone().find(|goal| <f32 as Real>::PROJECTED * goal == 9.0).unwrap_or(9e6);
    for off in [0.0, 8.0, 9.0, 10.0, 20.0] {
        awkward.extend([off, -off].map(|off| Case {
            a: [3.0 * (goal + off), 0.3, 0.7],
            s: goal,
            ..bases[0]
        }));
    }
    // Many nodes, few, and hardly any that may be moved.
    awkward.extend([0.7, 0.063, 0.062, 0.0].map(|free| Case { a: [3.0, 1.0, free], s: 0.7, ..bases[0] }));
    cases = with_awkward(cases, exact, awkward);
    for (case, kind) in cases.iter_mut().zip((0..4).cycle()) {
        case.collider.kind = kind;
    }
    cases
}

fn lambda(case: &Case) -> Answer {
    let kept = volume::push(FORMS[case.collider.kind as usize], &case.a, case.s, case.t).lambda;
    let projected = volume::projection(&case.a, case.s, <f32 as Real>::PROJECTED);
    // What is restored is not moved; the kernel asks for both.
    let off = case.a[0] / 3.0 - case.s;
    let response = case.a[2].max(volume::FEW as f32 * case.a[1]);
    let moving = if response > <f32 as Real>::TINY { off / response } else { 0.0 };
    let moving = projected.map_or(moving, |push| push.lambda);
    [vector([kept, moving, if projected.is_none() { 1.0 } else { 0.0 }], 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Tensors of inertia: round, flat, those of lines and nearly so, without a trace; and others, that have an inverse or none.
fn tensors(exact: bool) -> Vec<Case> {
    let cases = by_chance(13, 300)
        .into_iter()
        .map(|case| Case { a: case.a.map(|x| 1.2 + x), b: scale(case.b, 0.3), ..case })
        .collect::<Vec<_>>();
    let mut awkward = by_chance(14, 50);
    for base in &cases[..4] {
        awkward.extend([[0.0; 3], [-0.3, 0.1, 0.1], [0.1, -0.1, 0.0]].map(|a| Case { a, ..*base }));
        // The determinant of diag(1, 1, x) is about x/8.
        for near in (0..20).map(|i| 8.0 * FLAT as f32 * (0.95 + 0.005 * i as f32)) {
            awkward.push(Case { a: [1.0, 1.0, near], b: [0.0; 3], ..*base });
        }
        awkward.push(Case { a: [0.0, 1.0, 1.0], b: [0.0; 3], ..*base });
        awkward.extend([1e-9, 1e6].map(|size| Case {
            a: scale(base.a, size),
            b: scale(base.b, size),
            ..*base
        }));
    }
    with_awkward(cases, exact, awkward)
}

fn solution(case: &Case) -> Answer {
    [vector(volume::solve(case.a, case.b, case.c), 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Coming, leaving and neither; slipping as fast as friction can stop, and a hair faster and slower; at one place, at the
/// distance that is kept, and parting as fast as that; held on both sides.
fn exchanges(exact: bool) -> Vec<Case> {
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

fn exchange(case: &Case) -> Answer {
    let meeting = |[thickness, friction, restitution]: [f32; 3]| Meeting { thickness, friction, restitution };
    let done = pair::exchange(case.a, case.b, case.s, &meeting(case.c), (case.t, case.u));
    let met = pair::meeting(&meeting(case.c), &meeting(case.d));
    let met = [met.thickness, met.friction, met.restitution];
    [vector(done.impulse, 0.0), vector(done.shift, 0.0), vector(met, 0.0), [0.0; 4]]
}
