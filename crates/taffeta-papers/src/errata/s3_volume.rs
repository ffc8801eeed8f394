//! Errata of S3's volume, its gradient, its multiplier and its weights.

use super::Erratum;
use super::finding::{Finding, NONE, found};
use super::vector::{Vector, add, ball, cross, dot, norm, scale, sub, sum};
use crate::papers::paper::Paper;
use std::f64::consts::PI;
use taffeta::topology::Surface;
use taffeta::topology::measure::volume;

pub fn errata() -> Vec<Erratum> {
    vec![FAR, EQ_10, EQ_10B, EQ_14, EQ_15, WEIGHTS, ALGORITHM_2, ALGORITHM_4]
}

type Corners = [Vector; 3];

/// Eq. 10 as it is printed, letter by letter.
fn eq_10(corners: Corners) -> Corners {
    let [[x1, y1, z1], [x2, y2, z2], [x3, y3, z3]] = corners;
    [
        [0.5 * (y3 * z2 - y2 * z3), 0.5 * (x2 * z3 - x3 * z2), 0.5 * (x3 * y2 - x2 * y3)],
        [0.5 * (y1 * z3 - y3 * z1), 0.5 * (x3 * z1 - x1 * z3), 0.5 * (x3 * y1 - x1 * y3)],
        [0.5 * (y2 * z1 - y1 * z2), 0.5 * (x1 * z2 - x2 * z1), 0.5 * (x2 * y1 - x1 * y2)],
    ]
}

/// Eq. 10 with ∂V/∂z₂ turned over, so that all its parts have one sign.
fn eq_10_even(corners: Corners) -> Corners {
    let mut parts = eq_10(corners);
    parts[1][2] *= -1.0;
    parts
}

/// The derivative, the same for all corners.
fn corrected([a, b, c]: Corners) -> Corners {
    [scale(1.0 / 6.0, cross(sub(b, a), sub(c, a))); 3]
}

/// A vector for each node: what its triangles have for it.
fn gathered(surface: &Surface, parts: fn(Corners) -> Corners) -> Vec<Vector> {
    let mut row = vec![[0.0; 3]; surface.nodes.len()];
    for triangle in &surface.triangles {
        let corners = triangle.map(|i| surface.nodes[i as usize]);
        for (node, part) in triangle.iter().zip(parts(corners)) {
            row[*node as usize] = add(row[*node as usize], part);
        }
    }
    row
}

/// The derivative of the volume by differences.
fn differences(surface: &Surface) -> Vec<Vector> {
    let at = |node: usize, axis: usize, aside: f64| {
        let mut nodes = surface.nodes.clone();
        nodes[node][axis] += aside;
        volume(&nodes, &surface.triangles)
    };
    let by = |node, axis| (at(node, axis, 1e-3) - at(node, axis, -1e-3)) / 2e-3;
    (0..surface.nodes.len()).map(|node| [0, 1, 2].map(|axis| by(node, axis))).collect()
}

fn product(a: &[Vector], b: &[Vector]) -> f64 {
    a.iter().zip(b).map(|(a, b)| dot(*a, *b)).sum()
}

/// The length of a row of vectors taken as one.
fn length(a: &[Vector]) -> f64 {
    product(a, a).sqrt()
}

/// A ball whose centre is elsewhere.
fn ball_at(centre: Vector, radius: f64, subdivisions: u32) -> Surface {
    let mut ball = ball(radius, subdivisions);
    ball.nodes.iter_mut().for_each(|node| *node = add(*node, centre));
    ball
}

const FAR: Erratum = Erratum {
    id: "s3-far",
    paper: Paper::S3,
    place: "eqs. 7 and 10, in the single precision of a shader",
    printed: "`V = 1/9 Σ A_e (a_e + b_e + c_e)ᵀ n_e`, and products of coordinates in eq. 10",
    corrected: "the same with places counted from a node of the body; ∂V/∂a = (b − a)×(c − a)/6",
    why: "Eq. 7 is right, and neither depends on the origin in exact numbers. But what cancels over the \
          surface grows with the distance from the origin, for eq. 10 with its square, and 24 bits lose the \
          rest. Differences of near places lose nothing.",
    setting: "A ball of 0.5 m with 642 nodes, 100 m from the origin, in 32 bits, beside the same places in \
              64 bits. Relative errors. Eq. 10 is taken with the right factor.",
    model: "[volume](models/volume.md#precision)",
    experiment: far,
};

type Single = [f32; 3];

fn single_cross(a: Single, b: Single) -> Single {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

fn single_less(a: Single, b: Single) -> Single {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

fn single_dot(a: Single, b: Single) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

/// Eq. 7 with places counted from o.
fn single_volume(triangles: &[[Single; 3]], o: Single) -> f32 {
    let one = |corners: &[Single; 3]| {
        let [a, b, c] = corners.map(|x| single_less(x, o));
        let normal = single_cross(single_less(b, a), single_less(c, a));
        let twice = single_dot(normal, normal).sqrt();
        let middle = [a[0] + b[0] + c[0], a[1] + b[1] + c[1], a[2] + b[2] + c[2]];
        twice / 2.0 * (single_dot(middle, normal) / twice) / 9.0
    };
    triangles.iter().map(one).sum()
}

fn far() -> Vec<Finding> {
    let mut surface = ball_at([100.0, 0.0, 0.0], 0.5, 3);
    surface.nodes.iter_mut().flatten().for_each(|x| *x = f64::from(*x as f32));
    let corner = |i: u32| surface.nodes[i as usize].map(|x| x as f32);
    let triangles: Vec<[Single; 3]> = surface.triangles.iter().map(|t| t.map(corner)).collect();
    let right = volume(&surface.nodes, &surface.triangles);
    let off = |o: Single| (f64::from(single_volume(&triangles, o)) / right - 1.0).abs();
    let exact = gathered(&surface, corrected);
    let error = |part: fn([Single; 3], usize) -> Single| {
        let mut row = vec![[0f32; 3]; surface.nodes.len()];
        for (triangle, corners) in surface.triangles.iter().zip(&triangles) {
            for (which, node) in triangle.iter().enumerate() {
                let part = part(*corners, which);
                row[*node as usize].iter_mut().zip(part).for_each(|(sum, one)| *sum += one / 6.0);
            }
        }
        let left: Vec<Vector> = row.iter().zip(&exact).map(|(a, b)| sub(a.map(f64::from), *b)).collect();
        length(&left) / length(&exact)
    };
    let opposite = |x: [Single; 3], i: usize| single_cross(x[(i + 1) % 3], x[(i + 2) % 3]);
    let edges = |[a, b, c]: [Single; 3], _: usize| single_cross(single_less(b, a), single_less(c, a));
    vec![
        found("error of the volume", off([0.0; 3]), off(corner(0)), NONE),
        found("error of the gradient", error(opposite), error(edges), NONE),
    ]
}

const EQ_10: Erratum = Erratum {
    id: "s3-eq10",
    paper: Paper::S3,
    place: "eqs. 10a to 10c",
    printed: "`∂V/∂x1 = ½ (y3 z2 − y2 z3)`, and so on",
    corrected: "`∂V/∂x1 = ⅙ (y2 z3 − y3 z2)`, and so on: ∂V/∂a = (b × c)/6, or (b − a)×(c − a)/6 at each \
             corner",
    why: "The volume of eq. 7 is Σ a·(b × c)/6, so the factor is ⅙, and for triangles counter-clockwise \
          from outside the sign is the other one: eq. 10 is −3 times the derivative. Put into eqs. 11 to 14 \
          with a derivative J = −3 g, the velocity's part comes out right, for J stands there twice; Φ \
          stands there once, and the step drives the volume away from its goal: Φ' = 4/3 Φ.",
    setting: "A ball of 0.5 m with 162 nodes of 1 kg around (1, 2, 3), ∂V/∂z₂ as in [s3-eq10b](#s3-eq10b) \
              corrected. Exact: differences of the volume. Growth: steps by eqs. 11 to 14 from rest, no other \
              force, with a millionth of the volume too little.",
    model: "[volume](models/volume.md#what-the-paper-prints-and-what-we-changed)",
    experiment: eq_10_against_differences,
};

/// The error of the volume after so many steps, over that before them.
fn growth(parts: fn(Corners) -> Corners, steps: usize) -> f64 {
    let mut surface = ball_at([1.0, 2.0, 3.0], 0.5, 2);
    let goal = volume(&surface.nodes, &surface.triangles) * (1.0 + 1e-6);
    let error = |surface: &Surface| volume(&surface.nodes, &surface.triangles) - goal;
    let first = error(&surface);
    let h = 1e-3;
    for _ in 0..steps {
        let row = gathered(&surface, parts);
        let multiplier = error(&surface) / (h * h) / product(&row, &row);
        // From rest in each step: what is left of the velocity is cancelled by the flux, with either sign.
        for (node, part) in surface.nodes.iter_mut().zip(row) {
            *node = sub(*node, scale(h * h * multiplier, part));
        }
    }
    error(&surface) / first
}

fn eq_10_against_differences() -> Vec<Finding> {
    let surface = ball_at([1.0, 2.0, 3.0], 0.5, 2);
    let right = differences(&surface);
    let by_right = |row: &[Vector]| product(row, &right) / product(&right, &right);
    let off = |row: &[Vector]| {
        let left: Vec<Vector> = row.iter().zip(&right).map(|(a, b)| sub(*a, *b)).collect();
        length(&left) / length(&right)
    };
    let [printed, corrected_row] =
        [eq_10_even as fn(Corners) -> Corners, corrected].map(|parts| gathered(&surface, parts));
    vec![
        found("gradient over the derivative", by_right(&printed), by_right(&corrected_row), 1.0),
        found("its relative error", off(&printed), off(&corrected_row), 0.0),
        found(
            "error of the volume after a step, over that before",
            growth(eq_10_even, 1),
            growth(corrected, 1),
            0.0,
        ),
        found(
            "error of the volume after 30 steps, over that before",
            growth(eq_10_even, 30),
            growth(corrected, 30),
            0.0,
        ),
    ]
}

const EQ_10B: Erratum = Erratum {
    id: "s3-eq10b",
    paper: Paper::S3,
    place: "eq. 10b",
    printed: "`∂V/∂z2 = ½ (x3 y1 − x1 y3)`",
    corrected: "with the sign of its neighbours `½ (x1 y3 − x3 y1)`; right is `⅙ (x3 y1 − x1 y3)`",
    why: "Of the nine parts of eq. 10 eight have the wrong sign, and this one has the right one: its two \
          terms stand the other way round. As it is printed the gradient depends on which corner of a \
          triangle is named second, and its sum is not 0, so that a body under pressure pushes itself \
          along.",
    setting: "The ball of [s3-eq10](#s3-eq10); then its triangles named from their next corner.",
    model: "[volume](models/volume.md#what-the-paper-prints-and-what-we-changed)",
    experiment: eq_10b,
};

fn eq_10b() -> Vec<Finding> {
    let surface = ball_at([1.0, 2.0, 3.0], 0.5, 2);
    let mut turned = surface.clone();
    turned.triangles.iter_mut().for_each(|t| t.rotate_left(1));
    let both = |parts| [gathered(&surface, parts), gathered(&turned, parts)];
    let net = |row: &[Vector]| norm(sum(row.iter().copied())) / row.iter().map(|x| norm(*x)).sum::<f64>();
    let change = |rows: &[Vec<Vector>; 2]| {
        let left: Vec<Vector> = rows[0].iter().zip(&rows[1]).map(|(a, b)| sub(*a, *b)).collect();
        length(&left) / length(&rows[0])
    };
    let [printed, corrected_rows] = [both(eq_10), both(corrected)];
    let triangle = [[1.0, 0.2, 0.1], [0.3, 1.0, 0.4], [0.2, 0.1, 1.0]];
    let right = scale(1.0 / 6.0, cross(triangle[2], triangle[0]));
    let part = eq_10(triangle)[1];
    vec![
        found("∂V/∂x₂ over the derivative", part[0] / right[0], 1.0, 1.0),
        found("∂V/∂z₂ over the derivative", part[2] / right[2], 1.0, 1.0),
        found(
            "force on the whole ball over the sum of all forces",
            net(&printed[0]),
            net(&corrected_rows[0]),
            0.0,
        ),
        found(
            "change when triangles begin at another corner",
            change(&printed),
            change(&corrected_rows),
            0.0,
        ),
    ]
}

const EQ_14: Erratum = Erratum {
    id: "s3-eq14",
    paper: Paper::S3,
    place: "eq. 14, where it is programmed",
    printed: "eq. 14 itself is right with `(1/Δt²) Φ`; programs that have Φ there, as the authors' public \
              shader has by our reading, keep something else",
    corrected: "Φ/h², with the gradient of `s3-eq10`",
    why: "With eq. 10 as printed, Φ in place of Φ/h² hides the growth by 4/3: the error grows by h²/3 a \
          step only. But then nothing gives back what contact or rounding take: the volume is kept at what \
          it happens to be. That is a loss of some per cent where the corrected form loses none.",
    setting: "An error of 1 in the volume, steps of 0.1 ms (S3's) for a second, to first order: Φ' = Φ − h² \
              s Φ with s = −1/(3 h²), −1/3, 1 and 1/h².",
    model: "[volume](models/volume.md#forms)",
    experiment: eq_14,
};

fn eq_14() -> Vec<Finding> {
    let h: f64 = 1e-4;
    let after = |s: f64| (0..10_000).fold(1.0, |error, _| error - h * h * s * error);
    let right = after(1.0 / (h * h));
    vec![
        found("Φ, gradient of eq. 10: error after a second", after(-1.0 / 3.0), right, 0.0),
        found("Φ, right gradient: error after a second", after(1.0), right, 0.0),
        found(
            "Φ/h², gradient of eq. 10: error after 100 steps",
            (0..100).fold(1.0, |error, _| error * 4.0 / 3.0),
            right,
            0.0,
        ),
    ]
}

const EQ_15: Erratum = Erratum {
    id: "s3-eq15",
    paper: Paper::S3,
    place: "eq. 15",
    printed: "`W_i = ½ [cos(‖x_i − c‖/r) + 1]`",
    corrected: "W = ½ [cos(π s/r) + 1] for s = |x − c| < r, else 0",
    why: "\"r is the radius for the affected zone\", but without π the weight is 0.77 there, falls to 0 at \
          π r and is back at 1 at 2π r, for there is no end to it.",
    setting: "The weight at some distances.",
    model: "[volume](models/volume.md#weights)",
    experiment: || {
        let printed = |s: f64| 0.5 * (s.cos() + 1.0);
        let corrected = |s: f64| if s < 1.0 { 0.5 * ((PI * s).cos() + 1.0) } else { 0.0 };
        let distances =
            [("0", 0.0, 1.0), ("r/2", 0.5, 0.5), ("r", 1.0, 0.0), ("π r", PI, 0.0), ("2π r", 2.0 * PI, 0.0)];
        distances
            .map(|(name, s, exact)| found(format!("W at {name}"), printed(s), corrected(s), exact))
            .into()
    },
};

const WEIGHTS: Erratum = Erratum {
    id: "s3-weights",
    paper: Paper::S3,
    place: "section III-A3, the use of W",
    printed: "W_i \"allows the user to control the constraint terms by multiplication in the momentum \
              equations to scale the constraint forces\"",
    corrected: "force −λ u with u = W g − m (A + Ω × (x − x̄)), A and Ω the rigid motion that W g would give \
             to the body; and D = Σ w g·u in eq. 14",
    why: "Scaled in the force alone, and not on the left of eq. 14, λ gives back a part of the volume only. \
          And weighted forces have a resultant, for it is all of them together that cancel on a closed \
          surface: a body at rest flies off.",
    setting: "A ball of 0.5 m with 642 nodes of 1 kg at rest that lacks a millionth of its volume; W by eq. \
              15 corrected, around a place on its surface, r = 0.4 m; a step of 1 ms.",
    model: "[volume](models/volume.md#weights)",
    experiment: weights,
};

/// x with M x = b, for three equations.
fn three([a, b, c]: [Vector; 3], right: Vector) -> Vector {
    let whole = dot(a, cross(b, c));
    [dot(right, cross(b, c)) / whole, dot(a, cross(right, c)) / whole, dot(a, cross(b, right)) / whole]
}

/// Weighted gradients without the rigid motion that they give, for nodes of 1 kg.
fn at_rest(nodes: &[Vector], forces: &[Vector]) -> Vec<Vector> {
    let count = nodes.len() as f64;
    let centre = scale(1.0 / count, sum(nodes.iter().copied()));
    let shift = scale(1.0 / count, sum(forces.iter().copied()));
    let arms: Vec<Vector> = nodes.iter().map(|x| sub(*x, centre)).collect();
    let moment = sum(arms.iter().zip(forces).map(|(arm, f)| cross(*arm, *f)));
    let units = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]];
    let inertia = units.map(|e| sum(arms.iter().map(|arm| cross(*arm, cross(e, *arm)))));
    let turn = three(inertia, moment);
    let rigid = arms.iter().map(|arm| add(shift, cross(turn, *arm)));
    forces.iter().zip(rigid).map(|(f, rigid)| sub(*f, rigid)).collect()
}

fn weights() -> Vec<Finding> {
    let surface = ball_at([0.0; 3], 0.5, 3);
    let [v0, h] = [volume(&surface.nodes, &surface.triangles), 1e-3];
    let missing = -1e-6 * v0;
    let row = gathered(&surface, corrected);
    let weight = |x: &Vector| {
        let s = norm(sub(*x, [0.3, 0.4, 0.0])) / 0.4;
        if s < 1.0 { 0.5 * ((PI * s).cos() + 1.0) } else { 0.0 }
    };
    let forces: Vec<Vector> = surface.nodes.iter().zip(&row).map(|(x, g)| scale(weight(x), *g)).collect();
    let after = |forces: &[Vector], divisor: f64| {
        let multiplier = missing / (h * h) / divisor;
        let rates: Vec<Vector> = forces.iter().map(|f| scale(-h * multiplier, *f)).collect();
        let moved: Vec<Vector> =
            surface.nodes.iter().zip(&rates).map(|(x, v)| add(*x, scale(h, *v))).collect();
        let given = (volume(&moved, &surface.triangles) - v0) / -missing;
        [given, 1e3 * norm(sum(rates)) / surface.nodes.len() as f64]
    };
    let still = at_rest(&surface.nodes, &forces);
    let printed = after(&forces, product(&row, &row));
    let corrected_found = after(&still, product(&row, &still));
    vec![
        found("share of what lacks that the step gives back", printed[0], corrected_found[0], 1.0),
        found("speed of the whole ball after it [mm/s]", printed[1], corrected_found[1], 0.0),
    ]
}

const ALGORITHM_2: Erratum = Erratum {
    id: "s3-algorithm2",
    paper: Paper::S3,
    place: "algorithm 2, lines 6 to 11",
    printed: "`for all nodes j do: … Compute the right-hand side value of (14); Compute the left-hand side \
              value of (14); Solve Lagrange multiplier λ; end loop`",
    corrected: "sum up both sides over all nodes; *then* λ, one number a body; then the forces",
    why: "Both sides of eq. 14 are sums over all nodes. In the loop they are complete in its last round \
          only; in threads, in none. The text on BuildSystem() and AccumulateForce() has it right: the \
          quotient is taken in the next kernel.",
    setting: "A ball of 162 nodes of 1 kg at rest with a wrong volume: λ as the loop has it, over the right \
              λ.",
    model: "[volume](models/volume.md#formula)",
    experiment: || {
        let row = gathered(&ball(0.5, 2), corrected);
        let whole = product(&row, &row);
        let to = |nodes: usize| whole / product(&row[..nodes], &row[..nodes]);
        let count = row.len();
        [("first", 1), ("81st", 81), ("last", count)]
            .map(|(name, nodes)| {
                found(format!("λ at the {name} node, over the right one"), to(nodes), 1.0, 1.0)
            })
            .into()
    },
};

const ALGORITHM_4: Erratum = Erratum {
    id: "s3-algorithm4",
    paper: Paper::S3,
    place: "algorithm 4",
    printed: "`area = ((p2 − p1) × (p3 − p1))/2`, `tmp = area × (p1 + p2 + p3)`, `normal_normalized = ((p2 \
              − p1) × (p3 − p1))/9`, `volume = (tmp · normal_normalized)/9`",
    corrected: "`area = |(p2 − p1) × (p3 − p1)|/2`, `normal_normalized = (p2 − p1) × (p3 − p1)/|(p2 − p1) × \
             (p3 − p1)|`; or in one: `volume = p1 · (p2 × p3)/6`",
    why: "Eq. 7 has a unit normal and a number for the area. Divided by 9 in place of its length the normal \
          has the size of an area, so that the sum has the unit m⁵ and is no volume: on a body twice as \
          large it is 32 times as large. Taken by the letter, with `area` a vector and × the vector \
          product, each term is 0, for the normal stands in it twice.",
    setting: "A ball of 1 m with 162 nodes, and one of 2 m. Exact: Σ p₁·(p₂ × p₃)/6 and 2³.",
    model: "[volume](models/volume.md#what-the-paper-prints-and-what-we-changed), \
            [diagnostics](models/diagnostics.md#the-report-of-a-frame)",
    experiment: algorithm_4,
};

fn algorithm_4() -> Vec<Finding> {
    let total = |radius: f64, one: fn(Vector, Vector) -> f64| {
        let surface = ball(radius, 2);
        let corners = surface.triangles.iter().map(|t| t.map(|i| surface.nodes[i as usize]));
        corners.map(|[a, b, c]| one(cross(sub(b, a), sub(c, a)), sum([a, b, c]))).sum::<f64>()
    };
    let printed =
        |normal: Vector, middle: Vector| norm(normal) / 2.0 * dot(middle, scale(1.0 / 9.0, normal)) / 9.0;
    let letter = |normal: Vector, middle: Vector| {
        dot(cross(scale(0.5, normal), middle), scale(1.0 / 9.0, normal)) / 9.0
    };
    let corrected = |normal: Vector, middle: Vector| {
        norm(normal) / 2.0 * dot(middle, scale(1.0 / norm(normal), normal)) / 9.0
    };
    let right = {
        let surface = ball(1.0, 2);
        volume(&surface.nodes, &surface.triangles)
    };
    let scaled = |one| total(2.0, one) / total(1.0, one);
    vec![
        found("volume, `area` as a number [m³]", total(1.0, printed), total(1.0, corrected), right),
        found("volume, `area` as a vector [m³]", total(1.0, letter), total(1.0, corrected), right),
        found("volume of the larger ball over that of the smaller", scaled(printed), scaled(corrected), 8.0),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use taffeta::scene::{Body, Icosphere, Mass, Mesh, Scene, Volume, VolumeForm};
    use taffeta::{Options, Precision, Simulation};

    #[test]
    fn eq_10_is_minus_three_times_the_derivative_and_its_error_grows_by_a_third() {
        let [ratio, off, once, often] = eq_10_against_differences().try_into().unwrap();
        assert!((ratio.printed.unwrap() + 3.0).abs() < 1e-9 && (off.printed.unwrap() - 4.0).abs() < 1e-9);
        assert!(off.corrected.unwrap() < 1e-9);
        assert!((once.printed.unwrap() - 4.0 / 3.0).abs() < 1e-5);
        assert!((often.printed.unwrap() / (4f64 / 3.0).powi(30) - 1.0).abs() < 0.01);
        assert!(often.corrected.unwrap().abs() < 1e-5);
    }

    /// What the engine makes of an error of a millionth of the volume in so many steps.
    fn by_engine(form: VolumeForm, steps: usize) -> f64 {
        let mesh = Mesh::Icosphere(Icosphere { radius: 0.5, subdivisions: 2 });
        let mut body = Body::soft("ball", mesh).with_mass(Mass::Node(1.0)).keep_volume(form);
        let goal = Some(1.0 + 1e-6);
        body.volume = body.volume.map(|volume| Volume { target: goal, ..volume });
        let scene = Scene::new("growth").time(1e-3, 1e-3).body(body);
        let options = Options { precision: Precision::F64, ..Options::default() };
        let mut simulation = Simulation::new(&scene, &options).unwrap();
        let goal = volume(&ball(0.5, 2).nodes, &ball(0.5, 2).triangles) * (1.0 + 1e-6);
        let after = (0..steps).map(|_| simulation.step().unwrap().volumes[0].unwrap()).last().unwrap();
        (goal - after) / (goal * 1e-6)
    }

    #[test]
    fn the_forms_of_the_engine_do_the_same() {
        let near = |a: f64, b: f64, error: f64| assert!((a - b).abs() < error, "{a}, {b}");
        near(by_engine(VolumeForm::Printed, 1), 4.0 / 3.0, 1e-5);
        near(by_engine(VolumeForm::Printed, 20) / (4f64 / 3.0).powi(20), 1.0, 1e-3);
        near(by_engine(VolumeForm::PaperShader, 20), 1.0, 1e-4);
        near(by_engine(VolumeForm::Corrected, 1), 0.0, 1e-5);
    }

    #[test]
    fn one_part_of_eq_10_has_the_other_sign() {
        let triangle = [[0.3, -0.2, 0.5], [0.7, 0.9, -0.4], [-0.1, 0.6, 0.8]];
        let right = [0, 1, 2].map(|i| scale(1.0 / 6.0, cross(triangle[(i + 1) % 3], triangle[(i + 2) % 3])));
        for (corner, axis) in (0..3).flat_map(|corner| (0..3).map(move |axis| (corner, axis))) {
            let wanted = if [corner, axis] == [1, 2] { 3.0 } else { -3.0 };
            assert!((eq_10(triangle)[corner][axis] / right[corner][axis] - wanted).abs() < 1e-12);
        }
        let found = eq_10b();
        assert!(found[2].printed.unwrap() > 0.01 && found[2].corrected.unwrap() < 1e-12);
        assert!(found[3].printed.unwrap() > 0.1 && found[3].corrected.unwrap() < 1e-12);
    }

    #[test]
    fn far_from_the_origin_products_of_coordinates_lose_their_digits() {
        let [volume, gradient] = far().try_into().unwrap();
        assert!(volume.printed.unwrap() > 10.0 * volume.corrected.unwrap());
        assert!(gradient.printed.unwrap() > 1e3 * gradient.corrected.unwrap());
        assert!(volume.corrected.unwrap() < 1e-5 && gradient.corrected.unwrap() < 1e-6);
    }

    #[test]
    fn without_the_square_of_the_step_nothing_is_given_back() {
        let [shader, gradient, growing] = eq_14().try_into().unwrap();
        assert!((shader.printed.unwrap() - (1e-4f64 / 3.0).exp()).abs() < 1e-9);
        assert!((gradient.printed.unwrap() - (-1e-4f64).exp()).abs() < 1e-9);
        assert!(growing.printed.unwrap() > 3e12 && shader.corrected == Some(0.0));
    }

    #[test]
    fn weights_end_at_their_radius_and_move_no_body() {
        let found = (EQ_15.experiment)();
        assert!(found[2].printed.unwrap() > 0.77 && found[4].printed.unwrap() > 0.999);
        let [share, speed] = weights().try_into().unwrap();
        assert!(share.printed.unwrap() < 0.5 && speed.printed.unwrap() > 0.0);
        assert!((share.corrected.unwrap() - 1.0).abs() < 1e-4 && speed.corrected.unwrap() < 1e-12);
    }

    #[test]
    fn a_multiplier_in_the_loop_is_too_large_by_the_share_that_is_missing() {
        let ratios: Vec<f64> = (ALGORITHM_2.experiment)().iter().map(|one| one.printed.unwrap()).collect();
        assert!(ratios[0] > 100.0 && (1.9..2.4).contains(&ratios[1]) && ratios[2] == 1.0, "{ratios:?}");
    }

    #[test]
    fn algorithm_4_sums_up_no_volume() {
        let [number, vector, scaled] = algorithm_4().try_into().unwrap();
        assert!((number.corrected.unwrap() - 4.047_045).abs() < 1e-6);
        assert!(number.printed.unwrap() < 0.1 && vector.printed.unwrap().abs() < 1e-12);
        assert!((scaled.printed.unwrap() - 32.0).abs() < 1e-9);
    }
}
