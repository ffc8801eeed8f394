//! What S2 ("CUDA Cloth Simulation") calls its CPU: one thread, springs by compressed rows, every node against every other.

use super::{NODE_MASS, SPACING, SPRINGS, THICKNESS, WIND};
use crate::bench::measure::Bench;
use taffeta::Simulation;

type V = [f32; 3];

/// A node.
#[derive(Clone, Copy)]
pub struct Particle {
    pub x: V,
    pub v: V,
}

/// A spring at a node: the other end, rest length [m], stiffness [N/m], damping [kg/s].
#[derive(Clone, Copy)]
pub struct Spring {
    pub other: u32,
    pub rest: f32,
    pub k: f32,
    pub d: f32,
}

/// S2's state and its springs by node.
pub struct Serial {
    pub(super) now: Vec<Particle>,
    next: Vec<Particle>,
    /// Where the springs of each node begin; one more than there are nodes.
    pub(super) starts: Vec<u32>,
    pub(super) springs: Vec<Spring>,
    /// The first of these are held.
    pub(super) held: usize,
    pub(super) ball: (V, f32),
    pub(super) floor: f32,
    pub(super) h: f32,
}

/// The neighbours of a node: rows, columns, kind of spring.
const WAYS: [(i64, i64, usize); 12] = [
    (0, 1, 0),
    (0, -1, 0),
    (1, 0, 0),
    (-1, 0, 0),
    (1, 1, 1),
    (1, -1, 1),
    (-1, 1, 1),
    (-1, -1, 1),
    (0, 2, 2),
    (0, -2, 2),
    (2, 0, 2),
    (-2, 0, 2),
];

fn add(a: V, b: V, s: f32) -> V {
    [a[0] + s * b[0], a[1] + s * b[1], a[2] + s * b[2]]
}

fn dot(a: V, b: V) -> f32 {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

impl Serial {
    /// The bench's sheet as the simulation has it now.
    pub fn new(bench: &Bench, simulation: &Simulation) -> Self {
        let (rows, cols) = (i64::from(bench.n[0]), i64::from(bench.n[1]));
        // Positions, then velocities, in 32 bits.
        let state = simulation.snapshot().state;
        let numbers: Vec<f32> = state.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let (x, v) = numbers.split_at(numbers.len() / 2);
        let vectors = x.as_chunks().0.iter().zip(v.as_chunks().0);
        let now: Vec<Particle> = vectors.map(|(&x, &v)| Particle { x, v }).collect();
        let (mut starts, mut springs) = (vec![0], Vec::new());
        for (row, col) in (0..rows).flat_map(|row| (0..cols).map(move |col| (row, col))) {
            for (down, right, kind) in WAYS {
                let (to, at) = (row + down, col + right);
                if (0..rows).contains(&to) && (0..cols).contains(&at) {
                    let rest = (SPACING * (down as f64).hypot(right as f64)) as f32;
                    let (k, d) = SPRINGS[kind];
                    springs.push(Spring { other: (to * cols + at) as u32, rest, k: k as f32, d: d as f32 });
                }
            }
            starts.push(springs.len() as u32);
        }
        let side = (rows.min(cols) - 1) as f64 * SPACING;
        let ball = ([0.0, 0.18 * side, 0.05 * side].map(|x| x as f32), (0.18 * side + 0.02) as f32);
        Self {
            next: now.clone(),
            now,
            starts,
            springs,
            held: cols as usize,
            ball,
            floor: (0.02 - 0.05 * side) as f32,
            h: bench.scene.time.max_step.unwrap_or(bench.scene.time.dt) as f32,
        }
    }

    /// A sub-step, in the order of S2's list.
    pub fn step(&mut self) {
        for i in self.held..self.now.len() {
            let mut p = self.now[i];
            let mut force = self.spring_force(i);
            let mass = NODE_MASS as f32;
            let wind = WIND.0.map(|f| f as f32);
            force = add(add(force, wind, 1.0), p.v, -WIND.1 as f32);
            force[1] -= 9.81 * mass;
            self.objects(&mut p, &mut force);
            self.others(i, &mut p);
            p.v = add(p.v, force, self.h / mass);
            p.x = add(p.x, p.v, self.h);
            self.next[i] = p;
        }
        std::mem::swap(&mut self.now, &mut self.next);
    }

    fn row(&self, i: usize) -> &[Spring] {
        &self.springs[self.starts[i] as usize..self.starts[i + 1] as usize]
    }

    fn spring_force(&self, i: usize) -> V {
        let p = self.now[i];
        self.row(i).iter().fold([0.0; 3], |sum, spring| {
            let other = self.now[spring.other as usize];
            let (d, v) = (add(other.x, p.x, -1.0), add(other.v, p.v, -1.0));
            let length = dot(d, d).sqrt();
            let pull = spring.k * (length - spring.rest) + spring.d * dot(d, v) / length;
            add(sum, d, pull / length)
        })
    }

    /// Ball and floor: speed and force into them are lost.
    fn objects(&self, p: &mut Particle, force: &mut V) {
        let away = add(p.x, self.ball.0, -1.0);
        let distance = dot(away, away).sqrt();
        if distance < self.ball.1 {
            let normal = away.map(|c| c / distance);
            p.v = add(p.v, normal, -dot(p.v, normal).min(0.0));
            *force = add(*force, normal, -dot(*force, normal).min(0.0));
        }
        if p.x[1] < self.floor {
            p.v[1] = p.v[1].max(0.0);
            force[1] = force[1].max(0.0);
        }
    }

    /// All other nodes: those that are near and no neighbours, and approach, exchange their speeds along the line between
    /// them.
    fn others(&self, i: usize, p: &mut Particle) {
        let own = self.now[i];
        for (j, other) in self.now.iter().enumerate() {
            let d = add(own.x, other.x, -1.0);
            let distance = dot(d, d).sqrt();
            if distance < THICKNESS as f32
                && i != j
                && !self.row(i).iter().any(|spring| spring.other as usize == j)
            {
                let normal = d.map(|c| c / distance);
                let speed = dot(add(own.v, other.v, -1.0), normal);
                p.v = add(p.v, normal, -speed.min(0.0));
            }
        }
    }
}
