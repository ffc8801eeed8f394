use super::*;
use crate::assembly::Assembly;
use crate::elements::bending::NAME;
use crate::real::{cross, sub};
use crate::scene::{Body, Material, Mesh, Scene};
use crate::topology::random::SplitMix64;

const MATERIAL: [f64; 13] = [0.1, -0.2, 0.05, 1e9, 1e9, 1e9, 0.03, 0.01, -0.005, 0.02, 0.004, 0.025, 0.0];

const X: [[f64; 3]; 6] = [
    [0.0, 0.0, 0.02],
    [0.1, 0.01, 0.0],
    [0.04, 0.09, 0.01],
    [0.12, 0.11, -0.02],
    [-0.06, 0.08, 0.03],
    [0.05, -0.07, 0.01],
];

#[test]
fn forces_are_minus_the_energys_derivative_and_keep_momentum() {
    let force = ShapeOperator::forces(X, [[0.0; 3]; 6], MATERIAL);
    let (mut net, mut moment) = ([0.0; 3], [0.0; 3]);
    for node in 0..6 {
        net = add(net, force[node]);
        moment = add(moment, cross(X[node], force[node]));
        for axis in 0..3 {
            let at = |by: f64| {
                let mut x = X;
                x[node][axis] += by;
                ShapeOperator::energy(x, MATERIAL)
            };
            let numeric = -(at(1e-6) - at(-1e-6)) / 2e-6;
            assert!((numeric - force[node][axis]).abs() < 1e-8, "{numeric} {}", force[node][axis]);
        }
    }
    assert!(net.iter().chain(&moment).all(|part| part.abs() < 1e-12));
}

#[test]
fn damping_takes_power_also_where_triangles_are_squashed() {
    let mut chance = SplitMix64::new(9);
    for steepest in [1e9, 50.0] {
        let mut still = MATERIAL;
        still[3..6].copy_from_slice(&[steepest, 2.0 * steepest, 0.5 * steepest]);
        let mut damped = still;
        damped[12] = 0.01;
        for _ in 0..20 {
            let v: [[f64; 3]; 6] =
                std::array::from_fn(|_| std::array::from_fn(|_| 2.0 * chance.unit() - 1.0));
            let [all, elastic] = [damped, still].map(|numbers| ShapeOperator::forces(X, v, numbers));
            let power: f64 = (0..6).map(|node| dot(sub(all[node], elastic[node]), v[node])).sum();
            assert!(power < 0.0, "{power} W");
        }
    }
}

/// The energy of a fabric on a mesh whose nodes lie on the height z(x, y) of a shallow surface [J/m²].
fn energy_per_area(mesh: Mesh, material: Material, height: impl Fn(f64, f64) -> f64) -> f64 {
    let body = Body::cloth("sheet", mesh).with_material(material);
    let assembly = Assembly::new(&Scene::new("").body(body)).unwrap();
    let body = &assembly.bodies[0];
    let list = assembly.elements().iter().find(|list| list.kind.name == NAME).unwrap();
    let x: Vec<[f64; 3]> = body.start.iter().map(|&[x, _, z]| [x, height(x, z), z]).collect();
    let energy = |(nodes, numbers): (&[u32], &[f64])| {
        let corners: [[f64; 3]; 6] = std::array::from_fn(|i| x[nodes[i] as usize - body.first]);
        ShapeOperator::energy(corners, numbers.try_into().unwrap())
    };
    list.of(0..list.len()).map(energy).sum::<f64>()
}

/// Curvatures along and across the grid's diagonal, a twist, and a saddle: ½ (B₁₁κ₁² + B₂₂κ₂² + 2 B₁₂κ₁κ₂ + 4 B₆₆κ₁₂²).
#[test]
fn the_inside_of_a_grid_has_the_energy_of_an_orthotropic_plate() {
    let material = Material {
        bending: Some([3.0, 2.0].into()),
        bending_poisson: Some(0.2),
        twist: Some(0.7),
        ..Material::default()
    };
    let [b11, b12, b22, b66] = material.fabric().plate();
    for [k1, k2, k12] in
        [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.5, 0.5, 0.5], [0.5, 0.5, -0.5], [1.0, -1.0, 0.3]]
    {
        let scale = 1e-3;
        let height = |x: f64, z: f64| scale * (0.5 * k1 * x * x + 0.5 * k2 * z * z + k12 * x * z);
        // Two grids of one spacing: their difference has no border.
        let grid = |n: u32| {
            let side = f64::from(n) * 0.1;
            energy_per_area(Mesh::grid(n + 1, n + 1, [side, side]), material.clone(), height)
        };
        let [small, middle, large] = [10, 11, 12].map(grid);
        // A border grows with n, the inside with n²: the second difference is twice a square of 0.1 m.
        let found = (large - 2.0 * middle + small) / (2.0 * 0.01);
        let wanted = 0.5
            * scale
            * scale
            * (b11 * k1 * k1 + b22 * k2 * k2 + 2.0 * b12 * k1 * k2 + 4.0 * b66 * k12 * k12);
        assert!((found - wanted).abs() < 2e-3 * wanted, "{k1} {k2} {k12}: {found} J/m², not {wanted}");
    }
}

/// A cylinder whose axis is across the warp: border triangles have its energy, too.
#[test]
fn a_bent_strip_has_the_energy_of_a_beam() {
    let material = Material { bending: Some(2.0.into()), bending_poisson: Some(0.0), ..Material::default() };
    let height = |x: f64, _: f64| 1e-3 * 0.5 * x * x;
    let energy =
        |n: u32| energy_per_area(Mesh::grid(3, n + 1, [f64::from(n) * 0.1, 0.2]), material.clone(), height);
    let found = (energy(21) - energy(20)) / (0.1 * 0.2);
    let wanted = 0.5 * 2.0 * 1e-6;
    assert!((found - wanted).abs() < 1e-3 * wanted, "{found} J/m², not {wanted}");
}

#[test]
fn modes_are_the_energys_second_derivative_at_rest() {
    let mut numbers = MATERIAL;
    let folds = Folds::of(X, [1e9; 3]);
    numbers[..3].copy_from_slice(&[folds.a.angle, folds.b.angle, folds.c.angle]);
    let mut chance = SplitMix64::new(1);
    let u: [[f64; 3]; 6] = std::array::from_fn(|_| std::array::from_fn(|_| 2.0 * chance.unit() - 1.0));
    let moved = |by: f64| {
        let x: [[f64; 3]; 6] = std::array::from_fn(|node| add(X[node], scale(u[node], by)));
        ShapeOperator::energy(x, numbers)
    };
    let numeric = (moved(1e-4) + moved(-1e-4)) / 1e-8;
    let mut product = 0.0;
    for mode in ShapeOperator::modes(X, numbers) {
        let along: f64 = (0..6).map(|node| dot(mode.directions[node], u[node])).sum();
        product += mode.k * along * along;
    }
    assert!((numeric - product).abs() < 1e-3 * product, "{numeric} {product}");
}
