//! Rows of the formulas alone, on values by chance and on awkward ones.

mod contact;
mod forces;
mod volume;

use crate::contact::colliders::gpu_layout::Collider;
use crate::gpu::kernels::Name;
use crate::gpu::layout::Four;
use crate::parity::bench::{Bench, Given};
use crate::parity::fixture::{Arrays, Chance, words};
use crate::parity::row::{Row, Tolerance};
use taffeta_gpu::bytemuck::{Pod, Zeroable};

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
type Output = [Four; 4];

const SAME: &str = "the same operations in the same order; hardware may fuse products and sums";
const NEAR: &str = "as above; where numbers nearly cancel, what hardware rounds otherwise is left";

/// One row for each formula. On hardware awkward values are left out.
pub const ROWS: &[Row] = &[
    row("angle_of", Tolerance::new(0.0, 8.0, SAME), |bench| {
        formula(bench, 0, &forces::angles(), forces::angle)
    }),
    row("spring_factor", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = forces::springs(bench.exact);
        formula(bench, 1, &cases, forces::pull)
    }),
    row("fold_of", Tolerance::new(0.0, 512.0, NEAR), |bench| {
        let cases = forces::folds(bench.exact);
        formula(bench, 2, &cases, forces::fold)
    }),
    row("external", Tolerance::new(0.0, 1024.0, NEAR), |bench| {
        let cases = forces::levers(bench.exact);
        formula(bench, 3, &cases, forces::load)
    }),
    row("depth_and_normal", Tolerance::new(0.0, 64.0, SAME), |bench| {
        let cases = contact::places(bench.exact);
        formula(bench, 4, &cases, contact::depth)
    }),
    row("entry_of", Tolerance::new(0.0, 4096.0, NEAR), |bench| {
        let cases = contact::ways(bench.exact);
        formula(bench, 13, &cases, contact::entrance)
    }),
    row("respond", Tolerance::new(0.0, 32.0, NEAR), |bench| {
        let cases = contact::touches(bench.exact);
        formula(bench, 5, &cases, contact::response)
    }),
    row("leave_both", Tolerance::new(0.0, 4096.0, NEAR), |bench| {
        let cases = contact::wedges(bench.exact);
        formula(bench, 6, &cases, contact::way_out)
    }),
    row("multiplier", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = volume::multipliers(bench.exact);
        formula(bench, 8, &cases, volume::lambda)
    }),
    row("solve_symmetric", Tolerance::new(0.0, 4096.0, NEAR), |bench| {
        let cases = volume::tensors(bench.exact);
        formula(bench, 9, &cases, volume::solution)
    }),
    row("exchange", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = contact::exchanges(bench.exact);
        formula(bench, 10, &cases, contact::exchange)
    }),
    row("euler", Tolerance::new(0.0, 8.0, SAME), |bench| {
        let cases = by_chance(7, 300);
        formula(bench, 7, &cases, forces::step)
    }),
    row("corner_force", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = forces::blown(bench.exact);
        formula(bench, 11, &cases, forces::push)
    }),
    row("gust_velocity", Tolerance::new(0.0, 64.0, NEAR), |bench| {
        let cases = forces::gusts(bench.exact);
        formula(bench, 12, &cases, forces::gust)
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
    twin: fn(&Case) -> Output,
) -> Result<(), String> {
    let kernel = bench.kernel(Name::new("formulas"), &[("FORMULA", f64::from(number))])?;
    let answers: Vec<Output> = cases.iter().map(twin).collect();
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
