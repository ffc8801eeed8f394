use super::*;
use crate::assembly::Assembly;
use crate::elements::bending::build::{factor, plates};
use crate::elements::hinge::hinge::angle_and_gradient;
use crate::scene::{Body as Cloth, Material, Mesh, Scene, Surface};
use crate::topology::random::SplitMix64;
use std::sync::Arc;

type Place = [f64; 2];

/// Which diagonal halves the cells of a grid.
#[derive(Clone, Copy, Debug)]
enum Diagonals {
    Uniform,
    Alternating,
    Random,
}

/// A sheet of some cells, each node inside moved by a part of a cell.
struct Sheet {
    places: Vec<Place>,
    triangles: Vec<[u32; 3]>,
    held: Vec<bool>,
}

impl Sheet {
    fn new([columns, rows]: [u32; 2], cell: f64, clamped: u32, jitter: f64, diagonals: Diagonals) -> Self {
        let mut chance = SplitMix64::new(5);
        let width = columns + clamped + 1;
        let mut sheet = Self { places: Vec::new(), triangles: Vec::new(), held: Vec::new() };
        for j in 0..=rows {
            for i in 0..width {
                let [u, v] = [0; 2].map(|_| jitter * (2.0 * chance.unit() - 1.0));
                let moved = |at: u32, last: u32, by: f64| if at == 0 || at == last { 0.0 } else { by };
                let u = if i == clamped { 0.0 } else { moved(i, width - 1, u) };
                let x = f64::from(i) - f64::from(clamped) + u;
                sheet.places.push([x * cell, (f64::from(j) + moved(j, rows, v)) * cell]);
                sheet.held.push(i <= clamped && clamped > 0);
            }
        }
        for j in 0..rows {
            for i in 0..width - 1 {
                let [a, b, c, d] = [[0, 0], [1, 0], [1, 1], [0, 1]].map(|[p, q]| (j + q) * width + i + p);
                let other = match diagonals {
                    Diagonals::Uniform => false,
                    Diagonals::Alternating => (i + j) % 2 == 1,
                    Diagonals::Random => chance.unit() < 0.5,
                };
                // Counterclockwise seen from above y is clockwise in x, z.
                let cells = if other { [[a, d, b], [b, d, c]] } else { [[a, c, b], [a, d, c]] };
                sheet.triangles.extend(cells);
            }
        }
        sheet
    }

    fn nodes(&self) -> Vec<[f64; 3]> {
        self.places.iter().map(|&[x, z]| [x, 0.0, z]).collect()
    }

    /// The elements' stiffness against moves across the sheet, by pairs of nodes; and what was said.
    fn stiffness(&self, material: &Material, balanced: bool) -> (Vec<Vec<f64>>, Option<String>) {
        let nodes = self.nodes();
        let mesh = Mesh::Surface(Arc::new(Surface::of_triangles(nodes.clone(), self.triangles.clone())));
        let cloth = Cloth::cloth("sheet", mesh).with_material(material.clone());
        let mut body = Assembly::empty(&Scene::new("")).next_body(0, &cloth).unwrap();
        for (node, &held) in self.held.iter().enumerate() {
            let local = body.solver_local(node);
            body.free[local] = !held;
        }
        body.lay_fabric(&cloth).unwrap();
        let laid = body.laid().unwrap();
        let mut plates = plates(laid);
        let said = if balanced { balance(laid, &mut plates) } else { None };
        let mut all = vec![vec![0.0; nodes.len()]; nodes.len()];
        for (triangle, plate) in laid.triangles.iter().zip(&plates).filter(|(triangle, _)| !triangle.is_held)
        {
            let l = factor(plate.matrix, &plate.edges).unwrap();
            let gradients = [0, 1, 2].map(|e| {
                let [own, from, to] = [0, 1, 2].map(|step| triangle.user[(e + step) % 3]);
                let other =
                    plate.edges[e].beyond.map(|at| laid.triangles[at as usize / 3].user[at as usize % 3]);
                let hinge = [from, to, own, other.unwrap_or(own)];
                let up = angle_and_gradient(hinge.map(|node| nodes[node as usize])).1.map(|part| part[1]);
                (hinge, if other.is_some() { up } else { [0.0; 4] })
            });
            for column in [0, 1, 2] {
                let mut mode: Vec<(usize, f64)> = Vec::new();
                for (e, (hinge, up)) in gradients.iter().enumerate() {
                    mode.extend(hinge.iter().zip(up).map(|(&node, up)| (node as usize, l[e][column] * up)));
                }
                for &(i, x) in &mode {
                    mode.iter().for_each(|&(j, y)| all[i][j] += x * y);
                }
            }
        }
        (all, said)
    }

    /// A third of the area around each node that is not held.
    fn load(&self) -> Vec<f64> {
        let mut all = vec![0.0; self.places.len()];
        for triangle in self.triangles.iter().filter(|t| !t.iter().all(|&node| self.held[node as usize])) {
            let [a, b, c] = triangle.map(|node| self.places[node as usize]);
            let area = 0.5 * ((b[0] - a[0]) * (c[1] - a[1]) - (b[1] - a[1]) * (c[0] - a[0])).abs();
            triangle.iter().for_each(|&node| all[node as usize] += area / 3.0);
        }
        all
    }
}

/// Where nodes go under a load, some of them held.
fn solved(mut stiffness: Vec<Vec<f64>>, mut load: Vec<f64>, held: &[bool]) -> Vec<f64> {
    let n = load.len();
    for i in (0..n).filter(|&i| held[i]) {
        for row in &mut stiffness {
            row[i] = 0.0;
        }
        stiffness[i] = vec![0.0; n];
        stiffness[i][i] = 1.0;
        load[i] = 0.0;
    }
    for i in 0..n {
        let (done, left) = stiffness.split_at_mut(i + 1);
        for (row, k) in left.iter_mut().zip(i + 1..) {
            let by = row[i] / done[i][i];
            if by != 0.0 {
                (i..n).for_each(|j| row[j] -= by * done[i][j]);
                load[k] -= by * load[i];
            }
        }
    }
    for i in (0..n).rev() {
        let sum: f64 = (i + 1..n).map(|j| stiffness[i][j] * load[j]).sum();
        load[i] = (load[i] - sum) / stiffness[i][i];
    }
    load
}

fn material(bending: f64, poisson: f64) -> Material {
    Material { bending: Some(bending.into()), bending_poisson: Some(poisson), ..Material::default() }
}

/// How far the tip of a cantilever of length 1 is from where a beam's would be.
fn tip(sheet: &Sheet, balanced: bool) -> (f64, Option<String>) {
    let (stiffness, said) = sheet.stiffness(&material(1.0, 0.0), balanced);
    let moved = solved(stiffness, sheet.load(), &sheet.held);
    let end: Vec<f64> =
        (0..moved.len()).filter(|&i| (sheet.places[i][0] - 1.0).abs() < 1e-9).map(|i| moved[i]).collect();
    (8.0 * end.iter().sum::<f64>() / end.len() as f64 - 1.0, said)
}

/// How far the corner of a square plate twisted by forces at its corners is from where a plate's would be.
fn twisted(n: u32, jitter: f64, diagonals: Diagonals, balanced: bool) -> (f64, Option<String>) {
    let sheet = Sheet::new([n, n], 1.0 / f64::from(n), 0, jitter, diagonals);
    let (stiffness, said) = sheet.stiffness(&material(1.0, 0.3), balanced);
    let side = n as usize + 1;
    let [a, b, c, d] = [0, side - 1, side * side - 1, side * (side - 1)];
    let mut load = vec![0.0; side * side];
    [(a, 1.0), (b, -1.0), (c, 1.0), (d, -1.0)].iter().for_each(|&(node, force)| load[node] = force);
    let held: Vec<bool> = (0..side * side).map(|i| i == a || i == b || i == c).collect();
    (-solved(stiffness, load, &held)[d] * 4.0 * 0.35 - 1.0, said)
}

#[test]
fn an_irregular_cantilever_sags_as_a_beam() {
    let sheet = Sheet::new([20, 5], 0.05, 2, 0.3, Diagonals::Uniform);
    let [before, after] = [false, true].map(|balanced| tip(&sheet, balanced).0);
    assert!(after.abs() < 0.005 && before.abs() > 0.01, "{after}, without balance {before}");
}

#[test]
fn an_irregular_plate_twists_as_a_plate() {
    let [before, after] = [false, true].map(|balanced| twisted(16, 0.1, Diagonals::Random, balanced).0);
    assert!(after.abs() < 0.02 && before.abs() > 0.1, "{after}, without balance {before}");
}

#[test]
fn a_grid_keeps_its_numbers() {
    let sheet = Sheet::new([12, 9], 0.1, 2, 0.0, Diagonals::Uniform);
    let [before, after] = [false, true].map(|balanced| sheet.stiffness(&material(1.0, 0.3), balanced));
    assert_eq!(before, after);
}

/// Six nodes around each triangle lie on a conic.
#[test]
fn alternating_diagonals_keep_their_numbers_and_are_told() {
    let sheet = Sheet::new([12, 12], 0.1, 0, 0.0, Diagonals::Alternating);
    let [(before, _), (after, said)] =
        [false, true].map(|balanced| sheet.stiffness(&material(1.0, 0.3), balanced));
    assert_eq!(before, after);
    assert!(said.is_some_and(|said| said.contains("diagonals in one direction")));
}

#[test]
fn eigenvalues_are_raised_and_no_others_changed() {
    let x = [[-2.0, 0.3, 0.1], [0.3, 0.5, -0.2], [0.1, -0.2, 1.0]];
    let raised = raised(x, -0.9);
    assert!(!is_above(&x, -0.9) && is_above(&raised, -0.9 - 1e-9) && !is_above(&raised, -0.9 + 1e-9));
    let kept = super::raised(x, -3.0);
    assert!((0..9).all(|i| (kept[i / 3][i % 3] - x[i / 3][i % 3]).abs() < 1e-12));
}
