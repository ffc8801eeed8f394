//! The shape operators of a body: one for each triangle of a fabric that bends.

use crate::assembly::body::BodyAssembly;
use crate::elements::bending::balance::{Plate, balance};
use crate::elements::bending::curvature::{Across, found, of_folds};
use crate::elements::element::Described;
use crate::elements::fabric::{Laid, Triangle};
use crate::elements::hinge::hinge::{STIFFEST, rest};
use crate::real::{dot, sub};
use crate::scene::{Fabric, Scene};

/// A symmetric matrix of three edges.
pub type Matrix = [[f64; 3]; 3];

/// An edge of a triangle, seen from it.
#[derive(Clone, Copy)]
pub struct Edge {
    /// The node on the other side, by the solver's number within the body; none at a border.
    node: Option<u32>,
    /// Three times the triangle on the other side, and which of its edges this is; none at a border.
    pub beyond: Option<u32>,
    pub across: Across,
    /// Angle at rest [rad], and the Σ|∇θ|² past which it gets no stiffer [rad²/m²].
    angle: f64,
    steepest: f64,
}

/// An edge without a triangle on its other side.
const BORDER: Edge = Edge { node: None, beyond: None, across: Across::Border, angle: 0.0, steepest: 0.0 };

/// The shape operators of a body, if it is of a fabric.
pub fn bends(body: &BodyAssembly, _: &Scene, _: usize) -> Described {
    let mut all = Described::default();
    let Some(laid) = body.laid() else { return all };
    let mut plates = plates(laid);
    all.warning = balance(laid, &mut plates);
    for (index, triangle) in laid.in_order(body) {
        let fabric = &laid.fabrics[triangle.fabric];
        let Plate { matrix, edges } = &plates[index];
        let Some(factor) = factor(*matrix, edges) else { continue };
        let [a, b, c] = triangle.nodes;
        let across = [0, 1, 2].map(|e| edges[e].node.unwrap_or([b, c, a][e]));
        let [r, s] = [edges.map(|edge| edge.angle), edges.map(|edge| edge.steepest)];
        let [[l11, _, _], [l21, l22, _], [l31, l32, l33]] = factor;
        all.push(
            &[a, b, c, across[0], across[1], across[2]],
            &[r[0], r[1], r[2], s[0], s[1], s[2], l11, l21, l31, l22, l32, l33, fabric.damping.bending],
        );
    }
    all
}

/// Directions in which a mesh is bent for its factors.
const DIRECTIONS: u32 = 36;

/// How stiff a mesh is against bending to a cylinder, by the fabric's own stiffness: least and largest of all directions. Triangles
/// at borders and clamps, whose stiffness is another matter, are left out; nothing where there are no others.
pub fn factors(laid: &Laid) -> Option<[f64; 2]> {
    // Energy of a sheet with rigidity 1, by pairs of curvatures.
    let mut gram = Matrix::default();
    let mut all = 0.0;
    for (index, triangle) in laid.triangles.iter().enumerate() {
        let across = [0, 1, 2].map(|corner| edge(laid, index, corner).across);
        let inside = across.iter().all(|across| matches!(across, Across::Triangle(_)));
        let (area, found) = (triangle.area(), found(triangle.rest, across));
        if !inside || !found.iter().flatten().all(|part| part.is_finite()) {
            continue;
        }
        all += area;
        for (row, p) in gram.iter_mut().zip(found) {
            for (entry, q) in row.iter_mut().zip(found) {
                *entry += area * (p[0] * q[0] + p[1] * q[1] + 2.0 * p[2] * q[2]);
            }
        }
    }
    let factor = |direction: u32| {
        let (sin, cos) = libm::sincos(std::f64::consts::PI * f64::from(direction) / f64::from(DIRECTIONS));
        let curved = [cos * cos, sin * sin, cos * sin];
        let energy = |i: usize| (0..3).map(|j| gram[i][j] * curved[i] * curved[j]).sum::<f64>();
        (0..3).map(energy).sum::<f64>() / all
    };
    let widest = |[low, high]: [f64; 2], one: f64| [low.min(one), high.max(one)];
    (all > 0.0).then(|| (0..DIRECTIONS).map(factor).fold([f64::INFINITY, 0.0], widest))
}

/// The triangles of a body, each by itself.
pub fn plates(laid: &Laid) -> Vec<Plate> {
    let of = |(index, triangle): (usize, &Triangle)| {
        let edges = [0, 1, 2].map(|corner| edge(laid, index, corner));
        Plate { matrix: matrix(triangle, &laid.fabrics[triangle.fabric], &edges), edges }
    };
    laid.triangles.iter().enumerate().map(of).collect()
}

/// The edge across from a corner of a triangle.
fn edge(laid: &Laid, index: usize, corner: usize) -> Edge {
    let own = &laid.triangles[index];
    let [from, to] = [1, 2].map(|step| own.user[(corner + step) % 3]);
    let Ok(found) = laid.edges.pairs.binary_search(&[from.min(to), from.max(to)]) else {
        return BORDER;
    };
    let Some([a, b, left, right]) = laid.hinges[found] else { return BORDER };
    let [first, second] = laid.edges.triangles[found];
    let is_left = first as usize == index;
    let beyond = if is_left { second } else { first };
    let other = &laid.triangles[beyond as usize];
    let apex = other.user.iter().position(|&node| node != from && node != to);
    let Some(apex) = apex else { return BORDER };
    // As seen along the own edge, which may run from b to a.
    let own_side = if is_left { left } else { right };
    let other_side = if is_left { right } else { left };
    let ends = if from < to { [a, b] } else { [b, a] };
    let at_rest = rest([ends[0], ends[1], own_side, other_side]);
    // A triangle that is held does not bend: the angle is between the clamp and the free triangle, all of it the latter's.
    let across = match (own.is_held, other.is_held) {
        (true, false) => Across::Border,
        (false, true) => Across::Clamp,
        _ => Across::Triangle(beside(ends, other_side)),
    };
    Edge {
        node: Some(other.nodes[apex]),
        beyond: Some(3 * beyond + apex as u32),
        across,
        angle: if laid.is_curved { at_rest.angle } else { 0.0 },
        steepest: STIFFEST * at_rest.steepness,
    }
}

/// Where a place is along a line and away from it, in lengths of the line.
fn beside([from, to]: [[f64; 3]; 2], place: [f64; 3]) -> [f64; 2] {
    let (line, out) = (sub(to, from), sub(place, from));
    let squared = dot(line, line);
    let along = dot(out, line) / squared;
    [along, (dot(out, out) / squared - along * along).max(0.0).sqrt()]
}

/// M, where ½ θᵀ M θ is the energy of a triangle whose edges are folded by θ.
fn matrix(triangle: &Triangle, fabric: &Fabric, edges: &[Edge; 3]) -> Matrix {
    let area = triangle.area();
    let parts = of_folds(triangle.rest, edges.map(|edge| edge.across));
    let [b11, b12, b22, b66] = fabric.plate();
    let form = |[p11, p22, p12]: [f64; 3], [q11, q22, q12]: [f64; 3]| {
        area * (b11 * p11 * q11 + b22 * p22 * q22 + b12 * (p11 * q22 + p22 * q11) + 4.0 * b66 * p12 * q12)
    };
    parts.map(|p| parts.map(|q| form(p, q)))
}

/// L with M = L Lᵀ; nothing where M is 0.
pub fn factor(mut matrix: Matrix, edges: &[Edge; 3]) -> Option<Matrix> {
    // Across a border no moment acts, so that the fold that is missing there is the one of least energy (Schur's complement).
    for e in (0..3).filter(|&e| edges[e].across == Across::Border) {
        eliminate(&mut matrix, e);
    }
    cholesky(&matrix)
}

/// Leaves an unknown to its least energy.
fn eliminate(matrix: &mut Matrix, gone: usize) {
    let row = matrix[gone];
    let pivot = row[gone];
    let left = |i: usize, j: usize| match (i == gone || j == gone, pivot > 0.0) {
        (true, _) => 0.0,
        (false, true) => matrix[i][j] - row[i] * row[j] / pivot,
        (false, false) => matrix[i][j],
    };
    *matrix = [0, 1, 2].map(|i| [0, 1, 2].map(|j| left(i, j)));
}

/// The lower factor of a matrix that is positive semidefinite but for rounding; nothing of what is 0 or no number.
pub fn cholesky(matrix: &Matrix) -> Option<Matrix> {
    let trace: f64 = (0..3).map(|i| matrix[i][i]).sum();
    if !(trace > 0.0 && trace.is_finite()) {
        return None;
    }
    let mut factor = Matrix::default();
    for j in 0..3 {
        let squared = matrix[j][j] - (0..j).map(|k| factor[j][k] * factor[j][k]).sum::<f64>();
        if squared <= 1e-12 * trace {
            continue;
        }
        factor[j][j] = squared.sqrt();
        for i in j + 1..3 {
            let dot: f64 = (0..j).map(|k| factor[i][k] * factor[j][k]).sum();
            factor[i][j] = (matrix[i][j] - dot) / factor[j][j];
        }
    }
    Some(factor)
}
