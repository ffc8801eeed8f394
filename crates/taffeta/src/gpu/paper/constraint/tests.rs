//! The system on the device beside one made here in 64 bits.

use crate::backend::FrameInput;
use crate::build::Assembly;
use crate::contact::collider_mesh::gpu::ColliderMeshes;
use crate::contact::colliders::gpu::Colliders;
use crate::elements::load::gpu::{LoadTables, Loads};
use crate::gpu::bodies::Bodies;
use crate::gpu::feature::{Command, Features, Upload};
use crate::gpu::kernels::{Kernels, Sizes};
use crate::gpu::layout::{Four, Solving};
use crate::gpu::paper::constraint::{ConstraintProduct, Constraints, Triplet, springs};
use crate::gpu::paper::spring_centric::Spring;
use crate::gpu::paper::{Paper, Printed};
use crate::gpu::partition::{Partition, Start};
use crate::plan;
use crate::scene::{Body, Mass, Mesh, Method, Scene, Select};
use taffeta_gpu::{Choice, DispatchList, Gpu};

const ALL: [ConstraintProduct; 4] = [
    ConstraintProduct::Printed,
    ConstraintProduct::Csr,
    ConstraintProduct::Ell,
    ConstraintProduct::MatrixFree,
];

/// Sums of some twenty products in 32 bits, relative to the largest diagonal.
const ROUNDING: f64 = 1e-6;

/// Two sheets out of shape on the device, of which neighbours are held.
struct Device {
    gpu: Gpu,
    partition: Partition,
    springs: Vec<Spring>,
    positions: Vec<Four>,
}

impl Device {
    fn new(product: ConstraintProduct, iterations: u32) -> Self {
        let sheet = |name: &str, x| {
            Body::cloth(name, Mesh::grid(5, 6, [0.5, 0.4]))
                .structural(50.0, 0.1)
                .shear(20.0, 0.0)
                .bend(5.0, 0.0)
                .at([x, 0.0, 0.0])
        };
        let held = sheet("held", 0.0).with_mass(Mass::Node(0.01)).pin(Select::nodes([0, 1, 17]));
        let scene =
            Scene::new("two").body(held).body(sheet("free", 1.0).with_mass(Mass::Node(0.3))).time(0.01, 0.01);
        let mut scene = scene.method(Method::Ice);
        scene.solver.ice.max_iterations = iterations;
        let assembly = Assembly::new(&scene).unwrap();
        let gpu = Gpu::open(&Choice::from_env()).unwrap_or_else(|error| panic!("{error}"));
        let bodies = Bodies::new(&assembly, 0..2);
        let constraints = Constraints::new(&gpu, product, &bodies).unwrap();
        let paper = Paper {
            kernels: Printed::Constraints(Box::new(constraints)),
            groups: 1,
            solving: Solving::of(&assembly.solver),
        };
        let [position, velocity] = bodies.state();
        let start = Start { places: bodies.places.clone(), position, velocity, ..Start::default() };
        let meshes = ColliderMeshes::new(&assembly).0;
        let loads = Loads::new(&gpu, &LoadTables::default(), bodies.len()).unwrap();
        let colliders = Colliders::new(&gpu, &meshes, &[], bodies.len()).unwrap();
        let features = Features::new(vec![Box::new(loads), Box::new(paper), Box::new(colliders)]);
        let sizes = Sizes { kinds: 1, room: 1, steps: 1 };
        let mut partition = Partition::new(&gpu, start, features, sizes).unwrap();
        let (substeps, input) = (plan::frame(&assembly, 0.0), FrameInput::default());
        let places = bodies.places.clone();
        let upload = Upload { gpu: &gpu, assembly: &assembly, substeps: &substeps, input: &input, places };
        partition.upload(&upload).unwrap();
        let mut positions = partition.state().position.read(&gpu).unwrap();
        for (i, place) in positions.iter_mut().enumerate() {
            (0..3).for_each(|axis| place[axis] += 0.02 * ((i * (3 + 2 * axis)) as f32).sin());
        }
        partition.state().position.write(&gpu, 0, &positions);
        Self { springs: springs(&bodies), gpu, partition, positions }
    }

    fn constraints(&self) -> &Constraints {
        constraints_of(&self.partition.features)
    }

    fn submit(&mut self, commands: impl for<'f> FnOnce(&'f Constraints) -> Vec<Command<'f>>) {
        let (mut list, mut kernels) = (DispatchList::new(), Kernels::new(self.gpu.clone()));
        self.partition
            .record_alone(&mut kernels, &mut list, |features| commands(constraints_of(features)))
            .unwrap();
        self.gpu.submit(&list).unwrap();
    }

    /// J M⁻¹ Jᵀ, from the state in 64 bits.
    fn matrix(&self) -> Vec<Vec<f64>> {
        let rows: Vec<Vec<f64>> = self.springs.iter().map(|spring| self.row(spring)).collect();
        let entry = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).enumerate().map(|(at, (a, b))| a * b * f64::from(self.positions[at / 3][3])).sum()
        };
        rows.iter().map(|a| rows.iter().map(|b| entry(a, b)).collect()).collect()
    }

    /// A row of J, all of it.
    fn row(&self, spring: &Spring) -> Vec<f64> {
        let mut row = vec![0.0; 3 * self.positions.len()];
        let [a, b] = [spring.a as usize, spring.b as usize];
        for axis in 0..3 {
            let apart = f64::from(self.positions[a][axis]) - f64::from(self.positions[b][axis]);
            row[3 * a + axis] = 2.0 * apart;
            row[3 * b + axis] = -2.0 * apart;
        }
        row
    }
}

fn constraints_of(features: &Features) -> &Constraints {
    match &features.get::<Paper>().expect("it was put there").kernels {
        Printed::Constraints(constraints) => constraints,
        _ => panic!("they are constraints"),
    }
}

fn largest(matrix: &[Vec<f64>]) -> f64 {
    matrix.iter().enumerate().map(|(i, row)| row[i]).fold(0.0, f64::max)
}

#[test]
fn the_matrix_in_coo_is_that_of_the_equation() {
    let mut device = Device::new(ConstraintProduct::Printed, 3);
    // Twice: the counter starts anew.
    device.submit(|constraints| (0..2).flat_map(|_| constraints.build(false)).collect());
    let constraints = device.constraints();
    let count = constraints.matrix.counter.read(&device.gpu).unwrap()[0] as usize;
    assert!(count <= constraints.matrix.system.len(), "{count} entries found no room");
    let mut entries: Vec<Triplet> = constraints.matrix.system.read(&device.gpu).unwrap();
    entries.truncate(count);
    entries.sort_by_key(|entry| (entry.row as usize, entry.column as usize));
    let places: Vec<(usize, usize)> =
        entries.iter().map(|entry| (entry.row as usize, entry.column as usize)).collect();
    assert!(places.windows(2).all(|two| two[0] < two[1]), "an entry is there twice");
    let matrix = device.matrix();
    let allowed = ROUNDING * largest(&matrix);
    let mut next = entries.iter().peekable();
    for (i, row) in matrix.iter().enumerate() {
        for (j, expected) in row.iter().enumerate() {
            let there = next.next_if(|entry| (entry.row as usize, entry.column as usize) == (i, j));
            let found = there.map_or(0.0, |entry| f64::from(entry.value));
            assert!((found - expected).abs() < allowed, "{i}, {j}: {found} for {expected}");
        }
    }
    assert!(next.next().is_none());
    let held = device.springs.iter().position(|spring| (spring.a, spring.b) == (0, 1)).unwrap();
    assert!(places.iter().all(|&(row, column)| row != held && column != held), "a spring between held nodes");
}

#[test]
fn all_products_are_those_of_the_matrix() {
    for product in ALL {
        let mut device = Device::new(product, 3);
        let p: Vec<f32> = (0..device.springs.len()).map(|i| (i as f32 * 1.7).sin() + 0.1).collect();
        device.constraints().vectors[4].write(&device.gpu, 0, &p);
        device.submit(|constraints| {
            [constraints.build(false), constraints.multiply()].into_iter().flatten().collect()
        });
        let found = device.constraints().vectors[5].read(&device.gpu).unwrap();
        let matrix = device.matrix();
        // Some 23 terms of a row, each at most as large as the largest diagonal.
        let allowed = 5.0 * ROUNDING * largest(&matrix);
        for (i, (row, found)) in matrix.iter().zip(found).enumerate() {
            let expected: f64 = row.iter().zip(&p).map(|(value, p)| value * f64::from(*p)).sum();
            let apart = (expected - f64::from(found)).abs();
            assert!(apart < allowed, "{product:?}, row {i}: {found} for {expected}");
        }
    }
}

/// Eqs. 12 to 17: λ and r after some iterations on `matrix` λ = b.
fn conjugate_gradients(matrix: &[Vec<f64>], b: &[f64], iterations: u32) -> [Vec<f64>; 2] {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let (mut lambda, mut r, mut p) = (vec![0.0; b.len()], b.to_vec(), b.to_vec());
    for _ in 0..iterations {
        let ap: Vec<f64> = matrix.iter().map(|row| dot(row, &p)).collect();
        let rr = dot(&r, &r);
        let alpha = rr / dot(&p, &ap);
        for i in 0..b.len() {
            lambda[i] += alpha * p[i];
            r[i] -= alpha * ap[i];
        }
        let beta = dot(&r, &r) / rr;
        p.iter_mut().zip(&r).for_each(|(p, r)| *p = r + beta * *p);
    }
    [lambda, r]
}

fn norm(vector: &[f64]) -> f64 {
    vector.iter().map(|x| x * x).sum::<f64>().sqrt()
}

#[test]
fn iterations_are_those_of_conjugate_gradients() {
    for product in ALL {
        let mut device = Device::new(product, 12);
        device.submit(|constraints| constraints.commands(false));
        let constraints = device.constraints();
        let read = |at: usize| -> Vec<f64> {
            constraints.vectors[at].read(&device.gpu).unwrap().into_iter().map(f64::from).collect()
        };
        let [rhs, lambda, residual] = [1, 2, 3].map(read);
        let [expected, r] = conjugate_gradients(&device.matrix(), &rhs, 12);
        let apart =
            |a: &[f64], b: &[f64]| norm(&a.iter().zip(b).map(|(a, b)| a - b).collect::<Vec<f64>>()) / norm(b);
        // Rounding grows with each iteration, by some units in the last place.
        let (off, left) = (apart(&lambda, &expected), apart(&residual, &r));
        assert!(off < 1e-3 && left < 1e-3, "{product:?}: λ {off:e}, r {left:e}");
        assert!(norm(&r) > 1e-3 * norm(&rhs), "nothing is left to compare");
        let sums = constraints.sums.read(&device.gpu).unwrap();
        let told = (f64::from(sums[2]) / f64::from(sums[3])).sqrt() * norm(&rhs) / norm(&residual);
        assert!((told - 1.0).abs() < 1e-4, "{product:?}: {told}");
    }
}

/// Φ/h² + J (v/h + M⁻¹ F) with gravity alone, from the state in 64 bits.
#[test]
fn the_right_side_is_that_of_the_equation() {
    let mut device = Device::new(ConstraintProduct::Printed, 3);
    let velocities: Vec<Four> =
        (0..device.positions.len()).map(|i| [(i as f32).sin(), (i as f32 * 3.0).cos(), 0.3, 1.0]).collect();
    device.partition.state().velocity.write(&device.gpu, 0, &velocities);
    device.submit(|constraints| constraints.build(false));
    let rhs = device.constraints().vectors[1].read(&device.gpu).unwrap();
    let h = 0.01;
    let vect = |at: usize| {
        let (node, axis) = (at / 3, at % 3);
        let falls = axis == 1 && device.positions[node][3] > 0.0;
        f64::from(velocities[node][axis]) / h - if falls { 9.81 } else { 0.0 }
    };
    for (i, (spring, found)) in device.springs.iter().zip(rhs).enumerate() {
        let row = device.row(spring);
        let [a, b] = [spring.a, spring.b].map(|node| device.positions[node as usize]);
        let moves = a[3] + b[3] > 0.0;
        let length2: f64 = (0..3).map(|axis| (f64::from(a[axis]) - f64::from(b[axis])).powi(2)).sum();
        let phi = (length2 - f64::from(spring.rest_length).powi(2)) / (h * h);
        let expected = phi + row.iter().enumerate().map(|(at, value)| value * vect(at)).sum::<f64>();
        let expected = if moves { expected } else { 0.0 };
        assert!((expected - f64::from(found)).abs() < 1e-3, "{i}: {found} for {expected}");
    }
}
