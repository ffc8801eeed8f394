//! Springs by the classical method of Runge and Kutta, of fourth order: the reference of the tournament, and a baseline in it.
//!
//! It is no part of the engine but one plain thread over a list of springs, written without regard to the engine's kernels. For
//! x' = v, v' = a(x, v), with stages a₁ = a(x, v), a₂ = a(x + h v/2, v + h a₁/2), a₃ = a(x + h v₂/2, v + h a₂/2),
//! a₄ = a(x + h v₃, v + h a₃), where v₂, v₃, v₄ are the velocities of the stages:
//!
//! ```text
//! x⁺ = x + h (v + 2 v₂ + 2 v₃ + v₄)/6,   v⁺ = v + h (a₁ + 2 a₂ + 2 a₃ + a₄)/6
//! ```
//!
//! Source: Kutta, "Beitrag zur näherungsweisen Integration totaler Differentialgleichungen", 1901; springs are those of S1 eq. 1.

use std::ops::{Add, Div, Mul, Sub};
use taffeta::springs::SpringList;

/// A number with 32 bits or 64.
pub trait Number:
    Copy + Add<Output = Self> + Sub<Output = Self> + Mul<Output = Self> + Div<Output = Self>
{
    /// The nearest of its kind.
    fn of(number: f64) -> Self;
    /// As 64 bits.
    fn wide(self) -> f64;
    /// Its root.
    fn root(self) -> Self;
}

impl Number for f32 {
    fn of(number: f64) -> Self {
        number as Self
    }
    fn wide(self) -> f64 {
        f64::from(self)
    }
    fn root(self) -> Self {
        self.sqrt()
    }
}

impl Number for f64 {
    fn of(number: f64) -> Self {
        number
    }
    fn wide(self) -> f64 {
        self
    }
    fn root(self) -> Self {
        self.sqrt()
    }
}

/// What follows from places and velocities.
pub struct System<T> {
    springs: Vec<Spring<T>>,
    /// Mass of a node [kg].
    mass: f64,
    inverse_mass: Vec<T>,
    gravity: [T; 3],
}

/// A spring: stiffness [N/m], damping along it [kg/s], length at rest [m].
struct Spring<T> {
    ends: [u32; 2],
    k: T,
    d: T,
    rest: T,
}

/// Places [m] and velocities [m/s] of all nodes.
#[derive(Clone, Debug, PartialEq)]
pub struct State<T> {
    /// Places [m].
    pub x: Vec<[T; 3]>,
    /// Velocities [m/s].
    pub v: Vec<[T; 3]>,
}

/// Room for the stages of a step: places, velocities and accelerations, and their weighted sums.
pub struct Room<T> {
    x: Vec<[T; 3]>,
    v: Vec<[T; 3]>,
    a: Vec<[T; 3]>,
    sum_v: Vec<[T; 3]>,
    sum_a: Vec<[T; 3]>,
}

fn zeros<T: Number>(nodes: usize) -> Vec<[T; 3]> {
    vec![[T::of(0.0); 3]; nodes]
}

/// a + s b.
#[inline(always)]
fn along<T: Number>(a: [T; 3], s: T, b: [T; 3]) -> [T; 3] {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

#[inline(always)]
fn minus<T: Number>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] - b[0], a[1] - b[1], a[2] - b[2]]
}

#[inline(always)]
fn dot<T: Number>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl<T: Number> State<T> {
    /// Rounded from 64 bits.
    pub fn of(state: &State<f64>) -> Self {
        let round = |all: &[[f64; 3]]| all.iter().map(|a| [T::of(a[0]), T::of(a[1]), T::of(a[2])]).collect();
        Self { x: round(&state.x), v: round(&state.v) }
    }

    /// Places in 64 bits.
    pub fn places(&self) -> Vec<[f64; 3]> {
        self.x.iter().map(|x| [x[0].wide(), x[1].wide(), x[2].wide()]).collect()
    }

    /// Whether all numbers are finite.
    pub fn is_finite(&self) -> bool {
        self.x.iter().chain(&self.v).flatten().all(|number| number.wide().is_finite())
    }
}

impl<T: Number> Room<T> {
    /// For so many nodes.
    pub fn new(nodes: usize) -> Self {
        let zeros = || zeros(nodes);
        Self { x: zeros(), v: zeros(), a: zeros(), sum_v: zeros(), sum_a: zeros() }
    }
}

impl<T: Number> System<T> {
    /// Nodes of one `mass` [kg] with springs between them, of which some are held; gravity [m/s²] pulls at the others.
    pub fn new(lists: &[SpringList], mass: f64, held: &[bool], gravity: [f64; 3]) -> Self {
        let of_list = |list: &SpringList| {
            let [k, d] = [T::of(list.k), T::of(list.d)];
            let ends = list.pairs.iter().zip(&list.rest);
            ends.map(|(&ends, &rest)| Spring { ends, k, d, rest: T::of(rest) }).collect::<Vec<_>>()
        };
        let inverse = |&held: &bool| T::of(if held { 0.0 } else { 1.0 / mass });
        Self {
            springs: lists.iter().flat_map(of_list).collect(),
            mass,
            inverse_mass: held.iter().map(inverse).collect(),
            gravity: [T::of(gravity[0]), T::of(gravity[1]), T::of(gravity[2])],
        }
    }

    /// Number of springs.
    pub fn springs(&self) -> usize {
        self.springs.len()
    }

    /// Accelerations [m/s²]; held nodes have none.
    pub fn accelerate(&self, x: &[[T; 3]], v: &[[T; 3]], out: &mut [[T; 3]]) {
        out.fill([T::of(0.0); 3]);
        for spring in &self.springs {
            let [a, b] = [spring.ends[0] as usize, spring.ends[1] as usize];
            let (d, dv) = (minus(x[b], x[a]), minus(v[b], v[a]));
            let length = dot(d, d).root();
            let inverse = T::of(1.0) / length;
            let damping = spring.d * (dot(dv, d) * inverse);
            let pull = (spring.k * (length - spring.rest) + damping) * inverse;
            out[a] = along(out[a], pull, d);
            out[b] = along(out[b], T::of(0.0) - pull, d);
        }
        for (acceleration, &inverse) in out.iter_mut().zip(&self.inverse_mass) {
            let gravity = if inverse.wide() > 0.0 { self.gravity } else { [T::of(0.0); 3] };
            *acceleration = along(gravity, inverse, *acceleration);
        }
    }

    /// A step of `h` [s].
    pub fn step(&self, state: &mut State<T>, room: &mut Room<T>, h: T) {
        let Room { x, v, a, sum_v, sum_a } = room;
        x.copy_from_slice(&state.x);
        v.copy_from_slice(&state.v);
        sum_v.fill([T::of(0.0); 3]);
        sum_a.fill([T::of(0.0); 3]);
        // What the stage counts for, and how far the next one goes along it.
        for (weight, next) in [(1.0, 0.5), (2.0, 0.5), (2.0, 1.0), (1.0, 0.0)] {
            self.accelerate(x, v, a);
            let (weight, next) = (T::of(weight), h * T::of(next));
            for node in 0..x.len() {
                sum_v[node] = along(sum_v[node], weight, v[node]);
                sum_a[node] = along(sum_a[node], weight, a[node]);
                x[node] = along(state.x[node], next, v[node]);
                v[node] = along(state.v[node], next, a[node]);
            }
        }
        let sixth = h / T::of(6.0);
        for node in 0..x.len() {
            state.x[node] = along(state.x[node], sixth, sum_v[node]);
            state.v[node] = along(state.v[node], sixth, sum_a[node]);
        }
    }

    /// Kinetic energy [J].
    pub fn kinetic(&self, state: &State<T>) -> f64 {
        0.5 * self.mass * state.v.iter().map(|&v| dot(v, v).wide()).sum::<f64>()
    }

    /// Energy of motion, height and springs [J].
    pub fn energy(&self, state: &State<T>) -> f64 {
        let height: f64 = state.x.iter().map(|&x| dot(self.gravity, x).wide()).sum();
        let spring = |spring: &Spring<T>| {
            let longer = (self.length(spring, state) - spring.rest).wide();
            0.5 * spring.k.wide() * longer * longer
        };
        self.kinetic(state) - self.mass * height + self.springs.iter().map(spring).sum::<f64>()
    }

    /// The largest length by that at rest.
    pub fn max_stretch(&self, state: &State<T>) -> f64 {
        let stretch = |spring: &Spring<T>| (self.length(spring, state) / spring.rest).wide();
        self.springs.iter().map(stretch).fold(0.0, f64::max)
    }

    fn length(&self, spring: &Spring<T>, state: &State<T>) -> T {
        let d = minus(state.x[spring.ends[1] as usize], state.x[spring.ends[0] as usize]);
        dot(d, d).root()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use taffeta::scene::{Body, Mass, Mesh, Scene, Select};
    use taffeta::springs::SpringKind;
    use taffeta::{Options, Precision, Simulation, springs_of};

    /// A mass on a spring of k = 100 N/m and d = 2 kg/s along x, 0.1 m too long.
    fn oscillator() -> (System<f64>, State<f64>) {
        let list = SpringList {
            kind: SpringKind::Structural,
            pairs: vec![[0, 1]],
            rest: vec![1.0],
            k: 100.0,
            d: 2.0,
        };
        let state = State { x: vec![[0.0; 3], [1.1, 0.0, 0.0]], v: zeros(2) };
        (System::new(&[list], 1.0, &[true, false], [0.0; 3]), state)
    }

    #[test]
    fn a_damped_oscillator_is_followed_to_fourth_order() {
        let omega = 99.0_f64.sqrt();
        let exact = 0.1 * (-1.0_f64).exp() * (omega.cos() + omega.sin() / omega);
        let off = |steps: u32| {
            let (system, mut state) = oscillator();
            let mut room = Room::new(2);
            (0..steps).for_each(|_| system.step(&mut state, &mut room, 1.0 / f64::from(steps)));
            assert_eq!(state.x[0], [0.0; 3]);
            state.x[1][0] - 1.0 - exact
        };
        let [a, b, c] = [100, 200, 400].map(off);
        assert!((a / b - 16.0).abs() < 0.8 && (b / c - 16.0).abs() < 0.4, "{a:e}, {b:e}, {c:e}");
    }

    #[test]
    fn energy_of_a_chain_is_kept_to_fourth_order_and_in_32_bits_to_rounding() {
        let scene = Scene::new("").body(
            Body::cloth("chain", Mesh::chain(4, 1.0)).with_mass(Mass::Node(0.1)).structural(200.0, 0.0),
        );
        let lists = springs_of(&scene, 0).unwrap();
        let held = [true, false, false, false, false];
        let start =
            State { x: (0..5).map(|i| [0.25 * f64::from(i), 0.0, 0.0]).collect(), v: zeros::<f64>(5) };
        fn gained<T: Number>(lists: &[SpringList], held: &[bool], start: &State<f64>, steps: u32) -> f64 {
            let system = System::<T>::new(lists, 0.1, held, [0.0, -9.81, 0.0]);
            let (mut state, mut room) = (State::of(start), Room::new(5));
            let before = system.energy(&state);
            (0..steps).for_each(|_| system.step(&mut state, &mut room, T::of(0.2 / f64::from(steps))));
            assert!(system.kinetic(&state) > 0.1 && system.max_stretch(&state) > 1.001);
            system.energy(&state) - before
        }
        let [coarse, fine] = [50, 100].map(|steps| gained::<f64>(&lists, &held, &start, steps));
        assert!(coarse.abs() < 1e-3 && fine.abs() < coarse.abs() / 12.0, "{coarse:e}, {fine:e}");
        assert!(gained::<f32>(&lists, &held, &start, 400).abs() < 1e-5);
    }

    #[test]
    fn a_step_of_the_engine_has_the_same_forces() {
        let sheet = Body::cloth("sheet", Mesh::grid(4, 5, [0.4, 0.3]))
            .with_mass(Mass::Node(0.02))
            .structural(30.0, 0.05)
            .shear(20.0, 0.03)
            .bend(10.0, 0.01)
            .pin(Select::rows(0, 0));
        let scene = Scene::new("").time(0.01, 0.01).body(sheet);
        let mut engine =
            Simulation::new(&scene, &Options { precision: Precision::F64, ..Options::default() }).unwrap();
        engine.disturb(0.02, 7);
        // Two frames, so that nodes move.
        engine.advance(2).unwrap();
        let before = engine.snapshot();
        engine.step().unwrap();
        let held: Vec<bool> = (0..20).map(|node| before.held.contains(&node)).collect();
        let system = System::<f64>::new(&springs_of(&scene, 0).unwrap(), 0.02, &held, [0.0, -9.81, 0.0]);
        let [start, end] = [&before, &engine.snapshot()].map(state);
        let mut a = zeros(20);
        system.accelerate(&start.x, &start.v, &mut a);
        for ((a, start), end) in a.iter().zip(&start.v).zip(&end.v) {
            let change = minus(*end, *start);
            let off = (0..3).map(|axis| (change[axis] / 0.01 - a[axis]).abs()).fold(0.0, f64::max);
            assert!(off < 1e-10, "{change:?} in 0.01 s, where {a:?} acts");
        }
        assert!(a.iter().flatten().any(|a| a.abs() > 10.0) && start.v[7][0].abs() > 1e-3);
    }

    fn state(snapshot: &taffeta::Snapshot) -> State<f64> {
        let numbers: Vec<f64> =
            snapshot.state.as_chunks().0.iter().map(|bytes| f64::from_le_bytes(*bytes)).collect();
        let (x, v) = numbers.as_chunks().0.split_at(snapshot.nodes as usize);
        State { x: x.to_vec(), v: v.to_vec() }
    }
}
