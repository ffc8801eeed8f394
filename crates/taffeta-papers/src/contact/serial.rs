//! What S2 ("CUDA Cloth Simulation") calls its CPU: one thread, springs by compressed rows, every node against every other.

use super::sheet::{NODE_MASS, SPACING, SPRINGS, Sheet, THICKNESS, WIND};
use super::timing::{BUDGET, Timed};
use std::time::Instant;
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
    pub now: Vec<Particle>,
    next: Vec<Particle>,
    /// Where the springs of each node begin; one more than there are nodes.
    pub starts: Vec<u32>,
    pub springs: Vec<Spring>,
    /// The first of these are held.
    pub held: usize,
    pub ball: (V, f32),
    pub floor: f32,
    pub h: f32,
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
    /// The sheet as the simulation has it now.
    pub fn new(sheet: &Sheet, simulation: &Simulation) -> Self {
        let side = i64::from(sheet.side);
        // Positions, then velocities, in 32 bits.
        let state = simulation.snapshot().state;
        let numbers: Vec<f32> = state.as_chunks().0.iter().map(|bytes| f32::from_le_bytes(*bytes)).collect();
        let (x, v) = numbers.split_at(numbers.len() / 2);
        let vectors = x.as_chunks().0.iter().zip(v.as_chunks().0);
        let now: Vec<Particle> = vectors.map(|(&x, &v)| Particle { x, v }).collect();
        let (mut starts, mut springs) = (vec![0], Vec::new());
        for (row, col) in (0..side).flat_map(|row| (0..side).map(move |col| (row, col))) {
            for (down, right, kind) in WAYS {
                let (to, at) = (row + down, col + right);
                if (0..side).contains(&to) && (0..side).contains(&at) {
                    let rest = (SPACING * (down as f64).hypot(right as f64)) as f32;
                    let (k, d) = SPRINGS[kind];
                    springs.push(Spring { other: (to * side + at) as u32, rest, k: k as f32, d: d as f32 });
                }
            }
            starts.push(springs.len() as u32);
        }
        let (center, radius) = sheet.kept_from_ball();
        Self {
            next: now.clone(),
            now,
            starts,
            springs,
            held: side as usize,
            ball: (center.map(|x| x as f32), radius as f32),
            floor: sheet.lowest() as f32,
            h: sheet.step() as f32,
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

    /// Times sub-steps for `frames` frames, or as many as the budget allows; each stands for a frame of `substeps`.
    pub fn timed(&mut self, frames: Option<u32>, substeps: u32) -> Timed {
        let most = frames.map_or(30 * substeps, |frames| frames * substeps) as usize;
        let (mut ms, start) = (Vec::new(), Instant::now());
        while ms.is_empty() || (start.elapsed().as_secs_f64() < BUDGET.0 && ms.len() < most) {
            let clock = Instant::now();
            self.step();
            ms.push(clock.elapsed().as_secs_f64() * 1e3 * f64::from(substeps));
        }
        let note = format!("sub-steps timed: {}; a frame has {substeps}", ms.len());
        Timed { frames: (ms.len() as u32).div_ceil(substeps), ms, note: Some(note) }
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
