//! Bending stiffness that is right on irregular meshes, by a correction of each triangle's matrix on the mesh at rest.
//!
//! Of a plate with a constant curvature K, the moment at every edge is G·K = l n·σ(K)·n, with σ₁₁ = B₁₁K₁₁ + B₁₂K₂₂, σ₂₂ = B₁₂K₁₁ +
//! B₂₂K₂₂, σ₁₂ = 2 B₆₆K₁₂. Triangles whose edges are folded as those of a quadratic surface, F K, have the moments M F K. Where both
//! meet on all edges, nodes are in equilibrium under every constant curvature, and the sheet as a whole is as stiff as the plate. On
//! regular meshes they do. On others M = L Lᵀ becomes L (I + X) Lᵀ with the smallest Σ|X|² + Σ|c|² for which
//!
//! - the moments of both sides of an edge add up to G, but for those that do no work: at a vertex inside, Σ θ t = 0 over its edges
//!   along t, so that moments c·t there are free;
//! - the moments beside a clamp are G;
//! - the moments at a border are 0 for the two K whose G·K is 0.

use crate::elements::bending::build::{Edge, Matrix, cholesky};
use crate::elements::bending::curvature::{Across, Curvature, Side, folds};
use crate::elements::bending::system::{self, End, NO_END, NONE, Rows, System, each};
use crate::elements::fabric::Laid;
use crate::real::{cross, dot, eigen, norm, scale};
use std::f64::consts::{SQRT_2, TAU};

/// What the moments c weigh: many times as cheap as X, without which it has to do more.
const MOMENTS: f64 = 3.0;

/// How far a moment may be off, as a part of G, before it is worth a correction.
const OFF: f64 = 1e-3;

/// Triangles so many edges away from one that is off are corrected with it.
const RINGS: usize = 12;

/// No direction of a triangle loses more of its stiffness.
const MOST_LOST: f64 = 0.9;

/// Share of triangles that would lose more, or of edges that are off, where the mesh does not let itself be balanced.
const TOO_MANY: f64 = 0.2;

/// A triangle's matrix, before borders are left to their least energy, and its edges.
pub struct Plate {
    pub matrix: Matrix,
    pub edges: [Edge; 3],
}

/// Says of a body that stays as it is.
const UNBALANCED: &str = "its triangles lie so that its stiffness in bending cannot be made even, and may be off by up to 30 %; \
                          diagonals in one direction, or an irregular mesh, would do";

/// Corrects the matrices of a body. Says why where it cannot.
pub fn balance(laid: &Laid, plates: &mut [Plate]) -> Option<String> {
    let mut surfaces = vec![Matrix::default(); plates.len()];
    each(&mut surfaces, |t, to| *to = folds(laid.triangles[t].rest, plates[t].edges.map(|edge| edge.across)));
    let body = Body { laid, plates, folds: surfaces };
    let all = body.patches();
    // A mesh that is regular inside stays as it is, at its borders too.
    let uneven = body.uneven(&all);
    if uneven == 0.0 {
        return None;
    }
    let wanted = body.grown(&all);
    let (triangles, system) = body.system(&all, &wanted);
    let corrections = system.least();
    let lost = corrections.iter().filter(|x| !is_above(x, -MOST_LOST)).count() as f64;
    let free = laid.triangles.iter().filter(|triangle| !triangle.is_held).count() as f64;
    if lost > TOO_MANY * free {
        return (uneven > TOO_MANY).then(|| UNBALANCED.into());
    }
    for (&t, mut x) in triangles.iter().zip(corrections) {
        if !is_above(&x, -MOST_LOST) {
            x = raised(x, -MOST_LOST);
        }
        (0..3).for_each(|i| x[i][i] += 1.0);
        let matrix = &mut plates[t].matrix;
        if let Some(l) = cholesky(matrix) {
            let half = l.map(|row| x.map(|column| dot(row, column)));
            *matrix = half.map(|row| l.map(|other| dot(row, other)));
        }
    }
    None
}

/// What is asked at an edge.
struct Patch {
    /// Three times a triangle, and which of its edges.
    sides: [u32; 2],
    /// Curvatures nn, tt, √2 nt under which it is asked.
    tests: Matrix,
    /// Moments that are missing under each [N·m per curvature].
    missing: [f64; 3],
    /// Whether any of them counts.
    is_off: bool,
    is_border: bool,
    is_corner: bool,
}

struct Body<'a> {
    laid: &'a Laid,
    plates: &'a [Plate],
    /// Of each triangle's edges, for the curvatures 11, 22, 12.
    folds: Vec<Matrix>,
}

impl Body<'_> {
    fn side(&self, at: usize) -> (Side, Matrix) {
        let (t, e) = (at / 3, at % 3);
        let side = Side::new(self.laid.triangles[t].rest, e, self.plates[t].edges[e].across);
        let units = units(side.normal);
        (side, units)
    }

    /// G and M F at a triangle's edge, for the curvatures nn, tt, √2 nt.
    fn moments(&self, at: usize) -> [[f64; 3]; 2] {
        let (t, e) = (at / 3, at % 3);
        let (side, units) = self.side(at);
        let [b11, b12, b22, b66] = self.laid.fabrics[self.laid.triangles[t].fabric].plate();
        let [u, v] = side.normal;
        let plate = |[k11, k22, k12]: Curvature| {
            let stress = [b11 * k11 + b12 * k22, b12 * k11 + b22 * k22, 2.0 * b66 * k12];
            side.length * dot([u * u, v * v, 2.0 * u * v], stress)
        };
        let row = self.plates[t].matrix[e];
        let by_unit = [0, 1, 2].map(|k| (0..3).map(|other| row[other] * self.folds[t][other][k]).sum());
        [units.map(plate), units.map(|unit| dot(by_unit, unit))]
    }

    /// The curvature 11, 22, √2 12 that has no moment across either of two borders of a triangle, at a corner of the sheet.
    fn cornered(&self, t: usize) -> Option<[f64; 3]> {
        let borders = (0..3).filter(|&e| self.plates[t].edges[e].beyond.is_none());
        let moments: Vec<[f64; 3]> = borders
            .map(|e| {
                let units = self.side(3 * t + e).1.map(even);
                let [plate, _] = self.moments(3 * t + e);
                [0, 1, 2].map(|k| (0..3).map(|i| plate[i] * units[i][k]).sum())
            })
            .collect();
        let [a, b] = moments[..] else { return None };
        let both = cross(a, b);
        Some(scale(both, 1.0 / norm(both)))
    }

    /// What is asked at all edges of triangles that bend.
    fn patches(&self) -> Vec<Patch> {
        let mut sides = vec![[[[0.0; 3]; 2]; 3]; self.plates.len()];
        each(&mut sides, |t, to| *to = [0, 1, 2].map(|e| self.moments(3 * t + e)));
        let bends = |t: usize| !self.laid.triangles[t].is_held && cholesky(&self.plates[t].matrix).is_some();
        let bends: Vec<bool> = (0..self.plates.len()).map(bends).collect();
        let cornered: Vec<Option<[f64; 3]>> = (0..self.plates.len()).map(|t| self.cornered(t)).collect();
        let only = |at: usize| {
            let units = self.side(at).1.map(even);
            cornered[at / 3].map(|curvature| units.map(|unit| dot(unit, curvature)))
        };
        let of_side = |at: usize| {
            let [plate, here] = sides[at / 3][at % 3];
            if !bends[at / 3] {
                return None;
            }
            match self.plates[at / 3].edges[at % 3] {
                Edge { beyond: None, .. } => Patch::new([at as u32, NONE], plate, here, true, only(at)),
                Edge { across: Across::Clamp, .. } => {
                    Patch::new([at as u32, NONE], plate, here, false, only(at))
                }
                Edge { beyond: Some(beyond), .. } => {
                    let mate = beyond as usize;
                    if mate < at || !bends[mate / 3] || self.is_flipped(at, mate) {
                        return None;
                    }
                    let [other, there] = sides[mate / 3][mate % 3];
                    let plate = [0, 1, 2].map(|i| 0.5 * (plate[i] + other[i]));
                    let here = [0, 1, 2].map(|i| here[i] + there[i]);
                    Patch::new([at as u32, beyond], plate, here, false, only(at).or_else(|| only(mate)))
                }
            }
        };
        (0..3 * self.plates.len()).filter_map(of_side).collect()
    }

    /// Whether two triangles run along their edge the same way, and so face different ways.
    fn is_flipped(&self, at: usize, mate: usize) -> bool {
        let from = |at: usize| self.laid.triangles[at / 3].user[(at % 3 + 1) % 3];
        from(at) == from(mate)
    }

    /// Triangles near edges that are off.
    fn grown(&self, all: &[Patch]) -> Vec<bool> {
        let mut wanted = vec![false; self.plates.len()];
        let of = |patch: &Patch| patch.sides.map(|side| if side == NONE { NONE } else { side / 3 });
        for t in all.iter().filter(|patch| patch.is_off).flat_map(of).filter(|&t| t != NONE) {
            wanted[t as usize] = true;
        }
        for _ in 0..RINGS {
            let before = wanted.clone();
            for [a, b] in
                all.iter().map(of).filter(|pair| pair[1] != NONE).map(|pair| pair.map(|t| t as usize))
            {
                if before[a] || before[b] {
                    (wanted[a], wanted[b]) = (true, true);
                }
            }
        }
        wanted
    }

    /// The share of edges that are off, of those between triangles that are not at a border.
    fn uneven(&self, all: &[Patch]) -> f64 {
        let inside = |t: u32| self.plates[t as usize / 3].edges.iter().all(|edge| edge.beyond.is_some());
        let inner = all.iter().filter(|patch| patch.sides.iter().all(|&side| side == NONE || inside(side)));
        let (off, count) =
            inner.fold((0_u32, 0_u32), |(off, count), patch| (off + u32::from(patch.is_off), count + 1));
        f64::from(off) / f64::from(count.max(1))
    }

    /// The rows of some triangles, and which these are.
    fn system(&self, all: &[Patch], wanted: &[bool]) -> (Vec<usize>, System) {
        let triangles: Vec<usize> = (0..wanted.len()).filter(|&t| wanted[t]).collect();
        let mut number = vec![NONE; wanted.len()];
        triangles.iter().zip(0..).for_each(|(&t, i)| number[t] = i);
        let known = |side: u32| side != NONE && wanted[side as usize / 3];
        let asked: Vec<&Patch> =
            all.iter().filter(|patch| patch.sides.iter().any(|&side| known(side))).collect();
        let mut patch_of = vec![NONE; 3 * wanted.len()];
        for (patch, i) in asked.iter().zip(0..) {
            patch.sides.iter().filter(|&&side| side != NONE).for_each(|&side| patch_of[side as usize] = i);
        }
        let mut sides = vec![[system::Side::default(); 3]; triangles.len()];
        each(&mut sides, |i, to| *to = [0, 1, 2].map(|e| self.read(3 * triangles[i] + e, &patch_of, &asked)));
        let weight = self.weight();
        let rows = |patch: &&Patch| Rows {
            sides: patch
                .sides
                .map(|side| if known(side) { 3 * number[side as usize / 3] + side % 3 } else { NONE }),
            ends: [NO_END; 2],
            weight: if patch.is_border || patch.is_corner { [0.0; 3] } else { [weight; 3] },
            wanted: patch.missing,
        };
        let mut rows: Vec<Rows> = asked.iter().map(rows).collect();
        let vertices = self.ends(&patch_of, &mut rows);
        (triangles, System::new(sides, rows, vertices))
    }

    /// What the rows of an edge read of a triangle: row e of L X Lᵀ F.
    fn read(&self, at: usize, patch_of: &[u32], asked: &[&Patch]) -> system::Side {
        let (t, e, rows) = (at / 3, at % 3, patch_of[at]);
        let (Some(l), false) = (cholesky(&self.plates[t].matrix), rows == NONE) else {
            return system::Side { rows: NONE, ..Default::default() };
        };
        let units = self.side(at).1;
        let c = asked[rows as usize].tests.map(|test| {
            let curvature = [0, 1, 2].map(|k| (0..3).map(|i| test[i] * units[i][k]).sum::<f64>());
            let folds = self.folds[t].map(|row| dot(row, curvature));
            [0, 1, 2].map(|i| (0..3).map(|j| l[j][i] * folds[j]).sum())
        });
        system::Side { rows, l: l[e], c }
    }

    /// Factor on moments c: one for the body, since they belong to no edge [N·m²].
    fn weight(&self) -> f64 {
        let (mut length, mut rigidity, mut count) = (0.0, 0.0, 0.0);
        for (t, triangle) in self.laid.triangles.iter().enumerate().filter(|(_, triangle)| !triangle.is_held)
        {
            let [b11, _, b22, b66] = self.laid.fabrics[triangle.fabric].plate();
            length +=
                (0..3).map(|e| self.side(3 * t + e).0.length).filter(|l| l.is_finite()).sum::<f64>() / 3.0;
            rigidity += (b11 + b22 + 4.0 * b66) / 3.0;
            count += 1.0;
        }
        MOMENTS * length / count * rigidity / count
    }

    /// Finds the vertices that have moments, and their edges' angles around them.
    fn ends(&self, patch_of: &[u32], rows: &mut [Rows]) -> usize {
        let nodes = self
            .laid
            .triangles
            .iter()
            .flat_map(|triangle| triangle.user)
            .max()
            .map_or(0, |most| most as usize + 1);
        let mut first = vec![NONE; nodes];
        for (triangle, t) in self.laid.triangles.iter().zip(0..) {
            (0..3).for_each(|corner| first[triangle.user[corner] as usize] = 3 * t + corner as u32);
        }
        let mut vertices = 0;
        let mut fan = Vec::new();
        for &start in first.iter().filter(|&&start| start != NONE) {
            if let Some(all) = self.walk(start as usize, patch_of, &mut fan)
                && !fan.is_empty()
            {
                for &(row, angle) in &fan {
                    let [a, b] = &mut rows[row as usize].ends;
                    let (sin, cos) = libm::sincos(angle * TAU / all);
                    *(if a.vertex == NONE { a } else { b }) = End { vertex: vertices, outward: [cos, sin] };
                }
                vertices += 1;
            }
        }
        vertices as usize
    }

    /// Edges around a vertex by their rows, with their angles; gives the whole angle, or nothing where it is not closed.
    fn walk(&self, start: usize, patch_of: &[u32], fan: &mut Vec<(u32, f64)>) -> Option<f64> {
        fan.clear();
        let (mut at, mut angle) = (start, 0.0);
        // No fan has more corners than the body.
        for _ in 0..3 * self.plates.len() {
            let (t, corner) = (at / 3, at % 3);
            let corners = self.laid.triangles[t].rest;
            let [out, last] =
                [1, 2].map(|step| [0, 1].map(|i| corners[(corner + step) % 3][i] - corners[corner][i]));
            angle +=
                libm::atan2((out[0] * last[1] - out[1] * last[0]).abs(), out[0] * last[0] + out[1] * last[1]);
            // On to the triangle beyond the last edge, where the vertex is the edge's start.
            let leaving = 3 * t + (corner + 1) % 3;
            let entered = self.plates[t].edges[leaving % 3].beyond? as usize;
            let row = if patch_of[leaving] == NONE { patch_of[entered] } else { patch_of[leaving] };
            let both_held = self.laid.triangles[t].is_held && self.laid.triangles[entered / 3].is_held;
            if self.is_flipped(leaving, entered) || (row == NONE && !both_held) || !angle.is_finite() {
                return None;
            }
            if row != NONE {
                fan.push((row, angle));
            }
            at = entered / 3 * 3 + (entered % 3 + 1) % 3;
            if at == start {
                return Some(angle);
            }
        }
        None
    }
}

impl Patch {
    /// With moments of the plate and of the triangles. At a corner of the sheet, only one curvature counts.
    fn new(
        sides: [u32; 2],
        plate: [f64; 3],
        here: [f64; 3],
        is_border: bool,
        only: Option<[f64; 3]>,
    ) -> Option<Self> {
        let size = norm(plate);
        let tests = match (only, is_border) {
            (Some(only), _) => [only, [0.0; 3], [0.0; 3]],
            (None, true) => beside(plate),
            (None, false) => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
        };
        let missing = if is_border { here.map(|part| -part) } else { [0, 1, 2].map(|i| plate[i] - here[i]) };
        let missing = tests.map(|test| dot(test, missing));
        let is_off = norm(missing) > OFF * size;
        (size > 0.0 && norm(missing).is_finite()).then_some(Self {
            sides,
            tests,
            missing,
            is_off,
            is_border,
            is_corner: only.is_some(),
        })
    }
}

/// Curvatures 11, 22, 12 as 11, 22, √2 12, whose squares add up to the same in any frame.
fn even([k11, k22, k12]: Curvature) -> [f64; 3] {
    [k11, k22, SQRT_2 * k12]
}

/// Two directions across one, and none.
fn beside(direction: [f64; 3]) -> Matrix {
    let least =
        (0..3).fold(0, |least, i| if direction[i].abs() < direction[least].abs() { i } else { least });
    let mut axis = [0.0; 3];
    axis[least] = 1.0;
    let unit = |one: [f64; 3]| scale(one, 1.0 / norm(one));
    let first = unit(cross(direction, axis));
    [first, unit(cross(direction, first)), [0.0; 3]]
}

/// The curvatures nn, tt, √2 nt of an edge as 11, 22, 12.
fn units([u, v]: [f64; 2]) -> [Curvature; 3] {
    [
        [u * u, v * v, u * v],
        [v * v, u * u, -u * v],
        [-SQRT_2 * u * v, SQRT_2 * u * v, (u * u - v * v) / SQRT_2],
    ]
}

/// Whether no eigenvalue is below `least`.
fn is_above(x: &Matrix, least: f64) -> bool {
    let mut left = *x;
    (0..3).for_each(|i| left[i][i] -= least);
    let [a, b, c] = left;
    a[0] > 0.0 && a[0] * b[1] - a[1] * b[0] > 0.0 && dot(a, cross(b, c)) > 0.0
}

/// The same matrix with its eigenvalues raised to `least`.
fn raised(x: Matrix, least: f64) -> Matrix {
    let (values, vectors) = eigen(x);
    let values = values.map(|value| value.max(least));
    [0, 1, 2].map(|i| [0, 1, 2].map(|j| (0..3).map(|k| values[k] * vectors[k][i] * vectors[k][j]).sum()))
}

#[cfg(test)]
mod tests;
