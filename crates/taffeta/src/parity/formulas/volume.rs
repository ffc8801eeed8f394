//! Volumes that are kept, and the tensors that weights need.

use crate::parity::formulas::{Case, Output, by_chance, vector, with_awkward};
use crate::real::{Real, scale};
use crate::volume::volume::{self, FLAT, Form};

/// Every form; nodes that can move, hardly, not at all and about the least; volumes that are as they should be, and nearly.
pub fn multipliers(exact: bool) -> Vec<Case> {
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
    for (case, &form) in cases.iter_mut().zip(Form::ALL.iter().cycle()) {
        case.collider.kind = form as u32;
    }
    cases
}

pub fn lambda(case: &Case) -> Output {
    let form = Form::ALL.iter().find(|&&form| form as u32 == case.collider.kind).unwrap_or(&Form::Kept);
    let kept = volume::correction(*form, &case.a, case.s, case.t).lambda;
    let projected = volume::projection(&case.a, case.s, <f32 as Real>::PROJECTED);
    // What is restored is not moved; the kernel asks for both.
    let moving = volume::restoring(case.a[0] / 3.0 - case.s, &case.a);
    let moving = projected.map_or(moving, |correction| correction.lambda);
    [vector([kept, moving, if projected.is_none() { 1.0 } else { 0.0 }], 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}

/// Tensors of inertia: round, flat, those of lines and nearly so, without a trace; and others, that have an inverse or none.
pub fn tensors(exact: bool) -> Vec<Case> {
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

pub fn solution(case: &Case) -> Output {
    [vector(volume::solve(case.a, case.b, case.c), 0.0), [0.0; 4], [0.0; 4], [0.0; 4]]
}
