//! Forces, and the step that they make.

use crate::elements::aero::aero::AirNow;
use crate::elements::aero::gust::GustNow;
use crate::elements::hinge::hinge;
use crate::elements::load::load as external;
use crate::elements::spring::spring;
use crate::parity::formulas::{Case, Output, by_chance, vector, with_awkward};
use crate::real::{Real, norm, scale, wrap};
use crate::solvers::explicit::euler;

/// All octants and sizes, the seams between them, and half a turn and more to wrap.
pub fn angles() -> Vec<Case> {
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

pub fn angle(case: &Case) -> Output {
    let wrapped = [wrap(case.s), wrap(case.t), 0.0];
    [vector(wrapped, Real::atan2(case.s, case.t)), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Triangles and flows of about the least size that counts; along each other, and across.
pub fn blown(exact: bool) -> Vec<Case> {
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

pub fn push(case: &Case) -> Output {
    let air = AirNow { density: case.s, exposure: case.t, drag: case.u, lift: case.w, ..AirNow::default() };
    [vector(air.corner_force(case.a, case.b, case.c[0]), 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Places some cells around, on lattice points and between them, and where cells are no longer told apart.
pub fn gusts(exact: bool) -> Vec<Case> {
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

pub fn gust(case: &Case) -> Output {
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
pub fn springs(exact: bool) -> Vec<Case> {
    let cases = by_chance(4, 200);
    let lengths = [0.0, 1e-30, 1e-20, 0.9e-15, 1e-15, 1.1e-15, 1e-14, 1e-10, 1e3, 1e9, 1e15];
    let bases = cases.clone();
    let awkward = lengths.into_iter().zip(bases).flat_map(|(length, base)| {
        let along = Case { a: [length, 0.0, 0.0], ..base };
        [along, Case { a: scale(base.a, length), ..base }]
    });
    with_awkward(cases, exact, awkward)
}

pub fn pull(case: &Case) -> Output {
    let factor = spring::factor(case.a, case.b, case.s, case.t, case.u);
    let numbers = [factor, spring::energy(case.w, case.s, case.u), norm(case.a)];
    [vector(numbers, 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Slivers, triangles without area, an edge without length or of about the least; flat, and folded onto itself.
pub fn folds(exact: bool) -> Vec<Case> {
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

pub fn fold(case: &Case) -> Output {
    let corners = [case.a, case.b, case.c, case.d];
    let (theta, gradient) = hinge::angle_and_gradient(corners);
    let [a, b, c, d] = gradient;
    let energy = hinge::energy(corners, case.s, case.t);
    [vector(a, theta), vector(b, energy), vector(c, hinge::steepness(&gradient)), vector(d, 0.0)]
}

/// Levers of no length and of about the least.
pub fn levers(exact: bool) -> Vec<Case> {
    let cases = by_chance(6, 200);
    let lengths = [0.0_f32, 1e-20, 0.9e-15, 1e-15, 1.1e-15, 1e-8];
    let bases = cases.clone();
    let awkward = lengths.into_iter().zip(bases).map(|(length, base)| {
        let along = Case { a: [length, 0.0, 0.0], b: [0.0, 0.0, 1.0], c: [0.0; 3], ..base };
        if length > 0.0 { along } else { Case { c: base.a, ..base } }
    });
    with_awkward(cases, exact, awkward)
}

pub fn load(case: &Case) -> Output {
    let arm = external::lever(case.a, case.b, case.c);
    let factor = external::torque_factor(case.s, std::iter::once(arm));
    let load = std::array::from_fn(|i| external::wind_and_drag(case.a[i], case.t, case.b[i]));
    [vector(arm, factor), vector(load, 0.0), [0.0; 4], [0.0; 4]]
}

pub fn step(case: &Case) -> Output {
    let v = std::array::from_fn(|i| euler::velocity(case.a[i], case.b[i], case.s, case.c[i], case.t));
    let x = std::array::from_fn(|i| euler::position(case.d[i], v[i], case.t));
    [vector(v, 0.0), vector(x, 0.0), [0.0; 4], [0.0; 4]]
}
