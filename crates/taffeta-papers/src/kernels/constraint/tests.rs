//! The system on the device beside one made here in 64 bits.

use crate::kernels::constraint::{Constraints, Triplet, springs};
use crate::kernels::spring_centric::Spring;
use crate::kernels::tests::gpu;
use crate::kernels::{Product, SHADERS, operations};
use std::fmt;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use taffeta::extension::{Assembly, Bodies, Command, Feature, Features, Fused, ParticleKernels};
use taffeta::scene::{Body, Mass, Mesh, Method, Scene, Select};
use taffeta::taffeta_gpu::{Bindable, Gpu, GpuError, Shader};
use taffeta::{GpuOptions, Options, Simulation, Stage};

const ALL: [Product; 4] = [Product::Printed, Product::Csr, Product::Ell, Product::MatrixFree];

/// Sums of some twenty products in 32 bits, relative to the largest diagonal.
const ROUNDING: f64 = 1e-6;

type Commands = fn(&Constraints) -> Vec<Command<'_>>;

/// Kernels of which some alone are run, and what they work on can be read.
struct Probe {
    product: Product,
    some: Commands,
    /// Whether all of them are run.
    whole: Arc<AtomicBool>,
    seen: OnceLock<Seen>,
}

/// What the kernels work on.
struct Seen {
    constraints: Arc<Constraints>,
    springs: Vec<Spring>,
    /// Of each vertex, one body after the other.
    places: Vec<usize>,
    /// Of each place.
    inverse_masses: Vec<f64>,
}

struct Probed {
    constraints: Arc<Constraints>,
    some: Commands,
    whole: Arc<AtomicBool>,
}

impl fmt::Debug for Probe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "a probe of {:?}", self.product)
    }
}

impl ParticleKernels for Probe {
    fn shaders(&self) -> &'static [Shader] {
        SHADERS
    }

    fn check(&self, _: &Gpu, _: Stage, _: &Assembly) -> Result<(), String> {
        Ok(())
    }

    fn feature(&self, gpu: &Gpu, bodies: &Bodies<'_>) -> Result<Box<dyn Feature>, GpuError> {
        let constraints = Arc::new(Constraints::new(gpu, self.product, bodies)?);
        let mut places = Vec::new();
        for (_, body) in bodies.iter() {
            let (first, before) = (bodies.local(body.first) as usize, places.len());
            places.resize(before + body.nodes, 0);
            (0..body.nodes).for_each(|local| places[before + body.vertex_of_solver(local)] = first + local);
        }
        let inverse_masses = bodies.state()[0].iter().map(|place| f64::from(place[3])).collect();
        let seen =
            Seen { constraints: constraints.clone(), springs: springs(bodies), places, inverse_masses };
        assert!(self.seen.set(seen).is_ok(), "the bodies go to the device together");
        Ok(Box::new(Probed { constraints, some: self.some, whole: self.whole.clone() }))
    }
}

impl Feature for Probed {
    fn buffers(&self, _: usize) -> Vec<(&'static str, &dyn Bindable)> {
        self.constraints.buffers()
    }

    fn kernels<'f>(&'f self, _: &'f Features, _: Stage) -> Vec<Fused<'f>> {
        let commands = if self.whole.load(Ordering::Relaxed) {
            self.constraints.commands(false)
        } else {
            // Nothing has moved.
            (self.some)(&self.constraints).into_iter().chain([Command::SwapStates]).collect()
        };
        vec![Fused::new(operations(false), commands)]
    }
}

/// Two sheets out of shape on the device, of which neighbours are held.
struct Device {
    gpu: Gpu,
    probe: Arc<Probe>,
    simulation: Simulation,
}

impl Device {
    fn new(product: Product, iterations: u32, some: Commands) -> Self {
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
        let gpu = gpu();
        let (whole, seen) = (Arc::default(), OnceLock::new());
        let probe = Arc::new(Probe { product, some, whole, seen });
        let on = GpuOptions { particles: Some(probe.clone()), ..gpu.clone().into() };
        let options = Options { gpu: Some(on), ..Options::default() };
        let mut simulation = Simulation::new(&scene, &options).unwrap();
        simulation.disturb(0.02, 7);
        Self { gpu, probe, simulation }
    }

    fn seen(&self) -> &Seen {
        self.probe.seen.get().expect("it was put there")
    }

    fn constraints(&self) -> &Constraints {
        &self.seen().constraints
    }

    fn springs(&self) -> &[Spring] {
        &self.seen().springs
    }

    /// A frame of one sub-step, by some of the kernels or all.
    fn step(&mut self, whole: bool) {
        self.probe.whole.store(whole, Ordering::Relaxed);
        self.simulation.step().unwrap();
    }

    /// Numbers of all vertices by place.
    fn by_place(&self, of_vertices: &[[f64; 3]]) -> Vec<[f64; 3]> {
        let mut by_place = vec![[0.0; 3]; self.seen().inverse_masses.len()];
        self.seen().places.iter().zip(of_vertices).for_each(|(&place, &numbers)| by_place[place] = numbers);
        by_place
    }

    fn positions(&self) -> Vec<[f64; 3]> {
        let mut positions = Vec::new();
        self.simulation.positions_f64(&mut positions);
        self.by_place(&positions)
    }

    fn velocities(&self) -> Vec<[f64; 3]> {
        let mut velocities: Vec<[f32; 3]> = Vec::new();
        self.simulation.velocities_f32(&mut velocities);
        self.by_place(&velocities.iter().map(|v| v.map(f64::from)).collect::<Vec<_>>())
    }

    /// J M⁻¹ Jᵀ, from the state in 64 bits.
    fn matrix(&self) -> Vec<Vec<f64>> {
        let (positions, weights) = (self.positions(), &self.seen().inverse_masses);
        let rows: Vec<Vec<f64>> = self.springs().iter().map(|spring| row(&positions, spring)).collect();
        let entry = |a: &[f64], b: &[f64]| {
            a.iter().zip(b).enumerate().map(|(at, (a, b))| a * b * weights[at / 3]).sum()
        };
        rows.iter().map(|a| rows.iter().map(|b| entry(a, b)).collect()).collect()
    }
}

/// A row of J, all of it.
fn row(positions: &[[f64; 3]], spring: &Spring) -> Vec<f64> {
    let mut row = vec![0.0; 3 * positions.len()];
    let [a, b] = [spring.a as usize, spring.b as usize];
    for axis in 0..3 {
        let apart = positions[a][axis] - positions[b][axis];
        row[3 * a + axis] = 2.0 * apart;
        row[3 * b + axis] = -2.0 * apart;
    }
    row
}

fn largest(matrix: &[Vec<f64>]) -> f64 {
    matrix.iter().enumerate().map(|(i, row)| row[i]).fold(0.0, f64::max)
}

#[test]
fn the_matrix_in_coo_is_that_of_the_equation() {
    // Twice: the counter starts again.
    let twice: Commands = |constraints| (0..2).flat_map(|_| constraints.build(false)).collect();
    let mut device = Device::new(Product::Printed, 3, twice);
    device.step(false);
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
    let held = device.springs().iter().position(|spring| (spring.a, spring.b) == (0, 1)).unwrap();
    assert!(places.iter().all(|&(row, column)| row != held && column != held), "a spring between held nodes");
}

#[test]
fn all_products_are_those_of_the_matrix() {
    for product in ALL {
        let some: Commands =
            |constraints| [constraints.build(false), constraints.multiply()].into_iter().flatten().collect();
        let mut device = Device::new(product, 3, some);
        let p: Vec<f32> = (0..device.springs().len()).map(|i| (i as f32 * 1.7).sin() + 0.1).collect();
        device.constraints().vectors[4].write(&device.gpu, 0, &p);
        device.step(false);
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
        let mut device = Device::new(product, 12, |_| Vec::new());
        let matrix = device.matrix();
        device.step(true);
        let constraints = device.constraints();
        let read = |at: usize| -> Vec<f64> {
            constraints.vectors[at].read(&device.gpu).unwrap().into_iter().map(f64::from).collect()
        };
        let [rhs, lambda, residual] = [1, 2, 3].map(read);
        let [expected, r] = conjugate_gradients(&matrix, &rhs, 12);
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
    let mut device = Device::new(Product::Printed, 3, |constraints| constraints.build(false));
    device.step(true);
    let (positions, velocities) = (device.positions(), device.velocities());
    assert!(velocities.iter().any(|v| v[0].abs() > 0.1), "it does not move");
    device.step(false);
    let rhs = device.constraints().vectors[1].read(&device.gpu).unwrap();
    let (h, weights) = (0.01, &device.seen().inverse_masses);
    let vect = |at: usize| {
        let (node, axis) = (at / 3, at % 3);
        let falls = axis == 1 && weights[node] > 0.0;
        velocities[node][axis] / h - if falls { 9.81 } else { 0.0 }
    };
    for (i, (spring, found)) in device.springs().iter().zip(rhs).enumerate() {
        let row = row(&positions, spring);
        let [a, b] = [spring.a as usize, spring.b as usize];
        let moves = weights[a] + weights[b] > 0.0;
        let length2: f64 = (0..3).map(|axis| (positions[a][axis] - positions[b][axis]).powi(2)).sum();
        let phi = (length2 - f64::from(spring.rest_length).powi(2)) / (h * h);
        let expected = phi + row.iter().enumerate().map(|(at, value)| value * vect(at)).sum::<f64>();
        let expected = if moves { expected } else { 0.0 };
        assert!((expected - f64::from(found)).abs() < 1e-3, "{i}: {found} for {expected}");
    }
}
