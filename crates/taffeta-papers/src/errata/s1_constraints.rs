//! Errata of S1's constraints, implicit and adaptive.

use super::dense::{
    Matrix, basis, conjugate_gradients, divided, dot, guarded, norm, residual, tridiagonal, without,
};
use super::finding::{Finding, NONE, found};
use super::vector::{Chance, STEPS, Vector, add, scale, sheet_springs, sub};
use super::{Erratum, vector};
use crate::papers::paper::Paper;
use std::collections::BTreeSet;

pub fn errata() -> Vec<Erratum> {
    vec![EQ_3, EQ_5, EQ_6, PHI_T, RANK, EQ_13, NO_MASS, COUNTER, ACAD, LARGE_STEP]
}

const EQ_3: Erratum = Erratum {
    id: "s1-eq3",
    paper: Paper::S1,
    place: "eq. 3",
    printed: "`Φ = (x1 − x2)² + (y1 − y2)² + (z1 − z2)² − r²`",
    corrected: "C = |x₁ − x₂| − r",
    why: "Both are 0 at the length r. But eq. 10 goes by the first derivative, and a square is not \
          straight: a pair does not come back to r in a step, and a shortened one is thrown beyond it, to \
          (l + r²/l)/2. C is straight along the pair. Its rows have length 1, and its multipliers are \
          forces.",
    setting: "A pair at rest, 1.2 or 0.5 times as long as it should be, no other force, one step by eqs. 7, \
              8 and 11.",
    model: "[implicit constraints](models/ice.md#formula)",
    experiment: eq_3,
};

/// What each of two ends of 1 kg moves in a step: value and derivative of a constraint.
fn closed(l: f64, value: f64, slope: f64) -> f64 {
    let multiplier = value / (2.0 * slope * slope);
    l - 2.0 * slope * multiplier
}

fn eq_3() -> Vec<Finding> {
    [1.2, 0.5]
        .map(|l: f64| {
            let [printed, corrected] = [closed(l, l * l - 1.0, 2.0 * l), closed(l, l - 1.0, 1.0)];
            found(format!("length after the step, from {l}"), printed, corrected, 1.0)
        })
        .into()
}

const EQ_5: Erratum = Erratum {
    id: "s1-eq5",
    paper: Paper::S1,
    place: "eq. 5",
    printed: "`C = |2(x1 − Cx), 2(y2 − Cy), 2(z2 − Cz)|`, `D = |−2(x1 − Cx), −2(y1 − Cy), −2(z1 − Cz)|`, \
              where \"C_x, C_y, C_z are the fixed position of the node\"",
    corrected: "2 (x_a − x_b) in the columns of a, −2 (x_a − x_b) in those of b, with a and b the two ends of \
             the spring",
    why: "C has one component of x₁ and two of another node, so C + D is not 0 and the constraint pushes \
          the pair as a whole. C_x is the place of the other end, which is as free as the first. The \
          columns are those of the two ends, not those next to the diagonal.",
    setting: "A pair at (0.1, 0.2, 0.3) and (0.6, 0.5, 0.7), which is where y₂ and z₂ are taken from. \
              Exact: differences of eq. 3.",
    model: "[implicit constraints](models/ice.md#what-the-paper-prints-and-what-we-changed)",
    experiment: eq_5,
};

fn eq_5() -> Vec<Finding> {
    let [a, b]: [Vector; 2] = [[0.1, 0.2, 0.3], [0.6, 0.5, 0.7]];
    let row = scale(2.0, sub(a, b));
    let mixed = [a[0], b[1], b[2]];
    let block_c = scale(2.0, sub(mixed, b));
    let block_d = scale(-1.0, row);
    let square = |y: f64| vector::dot(sub([a[0], y, a[2]], b), sub([a[0], y, a[2]], b));
    let difference = (square(a[1] + 1e-3) - square(a[1] - 1e-3)) / 2e-3;
    let pull = vector::norm(row);
    vec![
        found("∂Φ/∂y of the first end", block_c[1], row[1], difference),
        found(
            "force on the pair as a whole over that on an end",
            vector::norm(add(block_c, block_d)) / pull,
            vector::norm(add(row, block_d)) / pull,
            0.0,
        ),
    ]
}

const EQ_6: Erratum = Erratum {
    id: "s1-eq6",
    paper: Paper::S1,
    place: "eq. 6 and the line below",
    printed: "`M q̈ + Φ_qᵀ λ = F^A`, where F^A \"is the accumulation of gravity force and constraint forces \
              acting on the node\"",
    corrected: "F^A is the sum of all forces *but* those of the constraints: gravity, springs that are no \
             constraints, loads",
    why: "Constraint forces are Φ_qᵀ λ, on the other side of eq. 6. In F^A as well they count twice.",
    setting: "1 kg hangs at rest from one constraint: q̈ = 0 in eq. 6.",
    model: "[implicit constraints](models/ice.md#formula), F",
    experiment: || {
        let weight = 9.81;
        // pull = F^A with F^A = weight − pull, or = weight.
        vec![found("pull of the constraint [N]", weight / 2.0, weight, weight)]
    },
};

const PHI_T: Erratum = Erratum {
    id: "s1-phi-t",
    paper: Paper::S1,
    place: "section 3.2, and the term Φ_t of eqs. 10 and 11",
    printed: "\"computePhi() kernel to compute the Φ_t(q, t), a vector in GPU, and stores in the Phi \
              buffer\"",
    corrected: "the kernel computes Φ(q, t), as table 2 has it; Φ_t = 0",
    why: "Φ_t is the rate of Φ by time alone, with the nodes at rest: 0 where rest lengths do not change. \
          Whoever takes the rate of Φ along the motion, Φ_q q̇, for it counts the velocity twice, for the \
          term after it is the same. Then a constraint does not stop its ends, it throws them back. S3's \
          eq. 14 has the same term, and a fixed volume the same 0. (Eqs. 7 and 8 go into eq. 10, not into \
          eq. 9 as the text says.)",
    setting: "A pair of the right length, whose ends part at 1 m/s, one step of 1 ms.",
    model: "[implicit constraints](models/ice.md#what-the-paper-prints-and-what-we-changed)",
    experiment: phi_t,
};

fn phi_t() -> Vec<Finding> {
    let h = 1e-3;
    let after = |times: f64| {
        let [slope, rate] = [2.0, 1.0];
        let right = times * slope * rate / h;
        let multiplier = right / (slope * slope * 2.0);
        rate - h * 2.0 * slope * multiplier
    };
    let energy = |rate: f64| 0.25 * rate * rate;
    let [printed, corrected] = [after(2.0), after(1.0)];
    vec![
        found("speed at which the ends part after the step [m/s]", printed, corrected, 0.0),
        found(
            "kinetic energy of the pair after it, 0.25 J before [J]",
            energy(printed),
            energy(corrected),
            0.0,
        ),
    ]
}

const RANK: Erratum = Erratum {
    id: "s1-eq11",
    paper: Paper::S1,
    place: "eq. 11",
    printed: "`Φ_q M⁻¹ Φ_qᵀ λ = …`, for all springs of a cloth; \"conjugate gradient is the most \
              well-suited algorithm\", without a criterion to end",
    corrected: "(J M⁻¹ Jᵀ + D) λ = k C/(h (k h + e)) + J v*/h with C = l − L, D = 1/(h (k h + e)): a \
             constraint gives way as its spring of k [N/m] and e [kg/s] does; end at a residual",
    why: "A cloth has more springs than directions in which its nodes can move. The matrix is then \
          singular, and the right side is not in its range: no λ solves it, the residual cannot fall below \
          a share of the right side, and conjugate gradients that go on run away. Nor does any stiffness \
          enter. With compliance the matrix is regular, each constraint pulls with k (l − L) at rest, and \
          more iterations are better.",
    setting: "A sheet of 6 × 6 free nodes of 0.1 kg, 0.1 m apart, each moved by up to 30 mm along each axis \
              by chance; all its springs; steps of 16 ms; k = 20,000 N/m. Residuals are |b − A λ|/|b|.",
    model: "[implicit constraints](models/ice.md#formula), and [more iterations are \
            worse](models/gpu-baselines.md#more-iterations-are-worse)",
    experiment: rank,
};

const STEP: f64 = 0.016;

/// Rows of J and values of a crumpled sheet's constraints, `[printed, corrected]`.
fn crumpled() -> [(Matrix, Vec<f64>); 2] {
    let mut chance = Chance(1);
    let places: Vec<Vector> = (0..36)
        .map(|i| {
            let flat = [f64::from(i % 6) * 0.1, f64::from(i / 6) * 0.1, 0.0];
            add(flat, scale(0.03, [chance.next(), chance.next(), chance.next()]))
        })
        .collect();
    let flat = |i: usize| [(i % 6) as f64 * 0.1, (i / 6) as f64 * 0.1, 0.0];
    let [mut printed, mut corrected] = [(vec![], vec![]), (vec![], vec![])];
    for [a, b] in sheet_springs(6, 6, &STEPS) {
        let [d, rest] = [sub(places[b], places[a]), sub(flat(b), flat(a))].map(|v| (v, vector::norm(v)));
        let [(d, l), (_, rest)] = [d, rest];
        let row = |along: Vector| {
            let mut row = vec![0.0; 108];
            row[3 * a..3 * a + 3].copy_from_slice(&scale(-1.0, along));
            row[3 * b..3 * b + 3].copy_from_slice(&along);
            row
        };
        printed.0.push(row(scale(2.0, d)));
        printed.1.push((l * l - rest * rest) / (STEP * STEP));
        corrected.0.push(row(scale(1.0 / l, d)));
        corrected.1.push((l - rest) / (STEP * STEP));
    }
    [printed, corrected]
}

/// J M⁻¹ Jᵀ for nodes of 0.1 kg, with compliance on its diagonal.
fn system(rows: &Matrix, compliance: f64) -> Matrix {
    let mut matrix: Matrix = rows.iter().map(|a| rows.iter().map(|b| 10.0 * dot(a, b)).collect()).collect();
    (0..matrix.len()).for_each(|i| matrix[i][i] += compliance);
    matrix
}

fn rank() -> Vec<Finding> {
    let [(printed_rows, printed_b), (corrected_rows, corrected_b)] = crumpled();
    let [printed, corrected] =
        [system(&printed_rows, 0.0), system(&corrected_rows, 1.0 / (20_000.0 * STEP * STEP))];
    let [printed_range, corrected_range] = [&printed, &corrected].map(|matrix| basis(matrix.iter().cloned()));
    let least = |b: &Vec<f64>, range: &[Vec<f64>]| norm(&without(without(b.clone(), range), range)) / norm(b);
    let constraints = printed_b.len();
    let mut findings = vec![
        found(
            format!("rank of the matrix, {constraints} constraints"),
            printed_range.len() as f64,
            corrected_range.len() as f64,
            NONE,
        ),
        found(
            "least residual of any λ",
            least(&printed_b, &printed_range),
            least(&corrected_b, &corrected_range),
            NONE,
        ),
    ];
    for iterations in [10, 30, 100, 300] {
        let of = |matrix: &Matrix, b: &[f64]| {
            residual(matrix, &conjugate_gradients(matrix, b, iterations, guarded), b)
        };
        let what = format!("residual after {iterations} iterations");
        findings.push(found(what, of(&printed, &printed_b), of(&corrected, &corrected_b), NONE));
    }
    findings
}

const EQ_13: Erratum = Erratum {
    id: "s1-eq13",
    paper: Paper::S1,
    place: "eqs. 13 and 16",
    printed: "`α_i = r_iᵀ r_i / (p_iᵀ A p_i)`, `β_i = r_(i+1)ᵀ r_(i+1) / (r_iᵀ r_i)`",
    corrected: "end where r is 0, or take 0 where the divisor is not above 0",
    why: "Where nothing is left to solve both are 0/0. That is not rare: a sheet in free fall has its \
          lengths and no relative velocity, so the right side of eq. 11 is 0 in the very first step.",
    setting: "A chain of three nodes of 0.1 kg in free fall from rest, one step of 16 ms, 10 iterations.",
    model: "[GPU baselines](models/gpu-baselines.md#implicit-constraints)",
    experiment: || {
        let falls = |quotient| {
            let matrix = vec![vec![20.0, -10.0], vec![-10.0, 20.0]];
            let pulls = conjugate_gradients(&matrix, &[0.0, 0.0], 10, quotient);
            -9.81 * STEP + STEP * 10.0 * pulls[0]
        };
        vec![found("velocity after the step [m/s]", falls(divided), falls(guarded), -9.81 * STEP)]
    },
};

const NO_MASS: Erratum = Erratum {
    id: "s1-algorithm2-mass",
    paper: Paper::S1,
    place: "algorithm 2",
    printed: "`value ← value + (A[ia] × A[jb])`",
    corrected: "value ← value + A[ia] · w · A[jb], with w the inverse mass of the node of column JA[ia]; 0 for \
             a held node",
    why: "The product is Φ_q Φ_qᵀ; eq. 11 has Φ_q M⁻¹ Φ_qᵀ. The two agree for nodes of 1 kg only. Lighter \
          nodes are thrown beyond the goal, heavier ones hardly move, and a held node counts as if it \
          could.",
    setting: "A pair at rest that is too long; the share of the gap that a step closes (constraint l − L).",
    model: "[implicit constraints](models/ice.md#what-the-paper-prints-and-what-we-changed)",
    experiment: || {
        let cases = [
            ("1 and 1 kg", [1.0, 1.0]),
            ("0.1 and 1 kg", [10.0, 1.0]),
            ("10 and 20 kg", [0.1, 0.05]),
            ("1 kg and a held node", [1.0, 0.0]),
        ];
        let share = |w: [f64; 2], in_matrix: [f64; 2]| (w[0] + w[1]) / (in_matrix[0] + in_matrix[1]);
        let row = |(name, w): (&str, [f64; 2])| found(name, share(w, [1.0; 2]), share(w, w), 1.0);
        cases.map(row).into()
    },
};

const COUNTER: Erratum = Erratum {
    id: "s1-algorithm2-counter",
    paper: Paper::S1,
    place: "algorithm 2",
    printed: "`InterlockAdd(nnzIndex, 1)`, then `COO[nnzIndex] ← float3(i, j, value)`",
    corrected: "`InterlockedAdd(nnz[0], 1, place)`, then `COO[place] ← …`: the place is what the counter was \
             *before*",
    why: "The counter is raised safely, and then read once more. In between other threads have raised it, \
          so several entries go to one place and others stay empty; threads of a warp run in step, so that \
          is the rule and not an accident. Place 0 is never written. Besides, a thread for each pair of \
          springs is far more than there are entries: springs that share a node can be listed once.",
    setting: "32 threads in step, each with an entry: all raise, then all write. Then what the kernel \
              starts for S1's 34 × 34 nodes with 6,598 springs.",
    model: "[implicit constraints](models/ice.md#solution), where no matrix is made",
    experiment: counter,
};

fn counter() -> Vec<Finding> {
    // Each thread finds the counter as those before it have left it, and all read it when the last has raised it.
    let [before, after]: [Vec<u32>; 2] = [(0..32).collect(), vec![32; 32]];
    let kept = |places: Vec<u32>| places.into_iter().collect::<BTreeSet<_>>().len() as f64;
    let [printed, corrected] = [after, before].map(kept);
    let springs = sheet_springs(34, 34, &STEPS);
    let mut degree = vec![0usize; 34 * 34];
    springs.iter().flatten().for_each(|node| degree[*node] += 1);
    let entries = degree.iter().map(|d| d * d).sum::<usize>() - springs.len();
    let m = springs.len() as f64;
    vec![
        found("entries that are kept, of 32", printed, corrected, 32.0),
        found("threads for the matrix", m * m, m, NONE),
        found("entries of the matrix", NONE, entries as f64, NONE),
    ]
}

const ACAD: Erratum = Erratum {
    id: "s1-acad",
    paper: Paper::S1,
    place: "section 3.3",
    printed: "a spring that \"exceeds 10% of the spring rest length\" becomes a constraint by eq. 11, which \
              ends \"after the constraint force is found\"",
    corrected: "with compliance D = ε (w_a + w_b), ε = 0.3; or ε = 0.1 and the threshold 1.1 L as the goal in \
             place of L",
    why: "Solved well, the constraint closes the whole gap in one step, with the kinetic energy that this \
          takes: more than the spring held wherever a sheet of all three kinds of springs is stable by \
          these alone, and the more the shorter the step is. The ends are thrown together, the springs \
          behind them catch them, and so on. Runs of the paper stay bounded where conjugate gradients are \
          cut short, which is compliance by chance.",
    setting: "A pair of 0.15 kg each (the paper prints no mass), at rest at 1.1 L, L = 1 m; kinetic energy \
              after a step over what the spring held: above 1 is energy from nowhere. Fig. 15: 16 ms and \
              200 N/m; the longest step that such springs stand in a sheet, k h² = 4 m/10.125; fig. 13: 5 \
              ms and 1,000 N/m.",
    model: "[adaptive constraints](models/acad.md#what-the-paper-prints-and-what-we-changed)",
    experiment: acad,
};

/// Kinetic energy after a step by what the spring held, for a way that the pair closes [m], at 0.15 kg.
fn injected(way: f64, gap: f64, [h, k]: [f64; 2]) -> f64 {
    let rate = way / h;
    0.25 * 0.15 * rate * rate / (0.5 * k * gap * gap)
}

fn acad() -> Vec<Finding> {
    let longest = (4.0 * 0.15 / 10.125 / 200.0f64).sqrt();
    let steps = [
        ("16 ms, 200 N/m", [0.016, 200.0]),
        ("longest step, 200 N/m", [longest, 200.0]),
        ("5 ms, 1,000 N/m", [0.005, 1000.0]),
    ];
    let printed = |l: f64, step| injected(l - closed(l, l * l - 1.0, 2.0 * l), l - 1.0, step);
    let mut findings: Vec<Finding> = steps
        .map(|(name, step)| {
            found(format!("{name}, 1.1 L; ε = 0.3"), printed(1.1, step), injected(0.1 / 1.3, 0.1, step), NONE)
        })
        .into();
    let short = steps[2].1;
    let to_threshold = injected(0.1 / 1.1, 0.2, short);
    findings.push(found("5 ms, 1,000 N/m, 1.2 L; ε = 0.1 to 1.1 L", printed(1.2, short), to_threshold, NONE));
    findings
}

const LARGE_STEP: Erratum = Erratum {
    id: "s1-large-step",
    paper: Paper::S1,
    place: "section 5",
    printed: "the constraint-based method \"provides stable and effective control of cloth behavior even \
              with collision objects, and can be used with a large integration time-step\"",
    corrected: "\"… with steps up to h² T/(m L) = 1\", T the pull of a spring; for n rows that hang, h² n g/L \
             < 1",
    why: "A constraint pulls along the line between its ends as it was before the step. Across that line \
          nothing is implicit: a wave across a taut line grows once h² ω² > 4, and the shortest wave has ω² \
          = 4 T/(m L). No mass, stiffness or care of the solver changes that. Sub-steps do, or constraints \
          whose directions are solved for as well.",
    setting: "A chain of ten links of 0.1 m hangs from one end, pushed aside by 0.1 µm at its lower end; \
              constraints l − L, each system solved exactly; 400 steps. The limit of its fastest wave is \
              known (ω² = 29.92 g/L, from the zeros of a Laguerre polynomial). Printed: a step 5 % above \
              it; corrected: 5 % below.",
    model: "[implicit constraints](models/ice.md#across-them-h-tm-l--1)",
    experiment: large_step,
};

/// The largest way aside of a hanging chain of ten links, by the first push.
fn swings(h: f64) -> f64 {
    let (n, g, push) = (10, 9.81, 1e-7);
    let mut x: Vec<Vector> = (0..=n).map(|i| [0.0, -0.1 * i as f64, 0.0]).collect();
    x[n][0] = push;
    let mut v = vec![[0.0; 3]; n + 1];
    let mut aside = 0.0f64;
    for _ in 0..400 {
        (1..=n).for_each(|i| v[i][1] -= h * g);
        let link = |i: usize| sub(x[i + 1], x[i]);
        let along: Vec<Vector> = (0..n).map(|i| vector::normalize(link(i))).collect();
        let diagonal: Vec<f64> = (0..n).map(|i| if i == 0 { 1.0 } else { 2.0 }).collect();
        let beside: Vec<f64> = (1..n).map(|i| -vector::dot(along[i - 1], along[i])).collect();
        let value = |i: usize| (vector::norm(link(i)) - 0.1) / h;
        let right: Vec<f64> =
            (0..n).map(|i| (value(i) + vector::dot(along[i], sub(v[i + 1], v[i]))) / h).collect();
        let pulls = tridiagonal(&diagonal, &beside, &right);
        for i in 1..=n {
            v[i] = sub(v[i], scale(h * pulls[i - 1], along[i - 1]));
            if i < n {
                v[i] = add(v[i], scale(h * pulls[i], along[i]));
            }
            x[i] = add(x[i], scale(h, v[i]));
            aside = aside.max(x[i][0].abs());
        }
    }
    aside / push
}

/// The step at which the fastest wave of that chain begins to grow [s].
fn limit() -> f64 {
    // The largest zero of the Laguerre polynomial of degree 10.
    let zero: f64 = 29.920_697_012_273_89;
    (4.0 * 0.1 / (zero * 9.81)).sqrt()
}

fn large_step() -> Vec<Finding> {
    let steps = [1.05, 0.95].map(|share| share * limit());
    let [printed, corrected] = steps.map(swings);
    let hanging = steps.map(|h| h * h * 10.0 * 9.81 / 0.1);
    vec![
        found("step [ms]", 1e3 * steps[0], 1e3 * steps[1], NONE),
        found("h² n g/L, safe below 1", hanging[0], hanging[1], NONE),
        found("largest way aside over the push", printed, corrected, NONE),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_does_not_close_a_gap_in_a_step() {
        let [long, short] = eq_3().try_into().unwrap();
        assert!((long.printed.unwrap() - (1.2 + 1.0 / 1.2) / 2.0).abs() < 1e-12);
        assert!((short.printed.unwrap() - 1.25).abs() < 1e-12);
    }

    #[test]
    fn mixed_indices_push_the_pair() {
        let [slope, push] = eq_5().try_into().unwrap();
        assert_eq!(slope.printed, Some(0.0));
        assert!(push.printed.unwrap() > 0.5 && push.corrected == Some(0.0));
    }

    #[test]
    fn a_velocity_that_counts_twice_is_thrown_back() {
        assert_eq!([phi_t()[0].printed, phi_t()[0].corrected], [Some(-1.0), Some(0.0)]);
    }

    #[test]
    fn the_matrix_is_singular_and_conjugate_gradients_run_away() {
        let found = rank();
        // 36 nodes have 108 directions, 6 of them rigid.
        assert_eq!([found[0].printed, found[0].corrected], [Some(102.0), Some(158.0)]);
        let least = found[1].printed.unwrap();
        assert!(least > 0.1 && found[1].corrected.unwrap() < 1e-9, "{least}");
        assert!(found[2..].iter().all(|one| one.printed.unwrap() >= least));
        let last = &found[5];
        assert!(last.printed.unwrap() > 1.0 && last.corrected.unwrap() < 1e-9, "{last:?}");
    }

    #[test]
    fn free_fall_is_not_a_number_as_printed() {
        let fall = (EQ_13.experiment)()[0].clone();
        assert!(fall.printed.unwrap().is_nan() && fall.corrected == fall.exact);
    }

    #[test]
    fn without_masses_a_light_pair_overshoots_and_a_heavy_one_stays() {
        let [even, light, heavy, held] = (NO_MASS.experiment)().try_into().unwrap();
        let printed = [even, light, heavy, held].map(|one| one.printed.unwrap());
        assert!(
            printed.iter().zip([1.0, 5.5, 0.075, 0.5]).all(|(a, b)| (a - b).abs() < 1e-12),
            "{printed:?}"
        );
    }

    #[test]
    fn entries_of_a_warp_go_to_one_place() {
        let [kept, threads, entries] = counter().try_into().unwrap();
        assert_eq!([kept.printed, kept.corrected], [Some(1.0), Some(32.0)]);
        assert_eq!(threads.printed, Some(43_533_604.0));
        assert!((145e3..147e3).contains(&entries.corrected.unwrap()));
    }

    #[test]
    fn adaptive_constraints_as_printed_win_energy_wherever_springs_are_stable() {
        let found = acad();
        assert!(found.iter().all(|one| one.printed.unwrap() > 1.0));
        let [at_16, longest, at_5, to_threshold] = [0, 1, 2, 3].map(|i| found[i].corrected.unwrap());
        assert!(at_16 < 1.0 && longest < 1.0 && to_threshold < 1.0 && at_5 > 1.0);
    }

    #[test]
    fn a_hanging_chain_swings_up_above_its_limit_alone() {
        let aside = large_step()[2].clone();
        assert!(aside.printed.unwrap() > 1e3 && aside.corrected.unwrap() < 30.0, "{aside:?}");
    }
}
