//! A second opinion: the equations of motion as the papers have them, in plain loops over lists, in 64 bits.

use super::lists::{angle, angle_gradient, shared_edges};
use super::{V, add, cross, dot, norm, scale, sub};
use std::collections::BTreeSet;
use taffeta::scene::Solver;

/// A damped spring: ends, stiffness [N/m], damping [kg/s], rest length [m].
pub struct Spring(pub usize, pub usize, pub f64, pub f64, pub f64);

/// A hinge: edge and opposite corners, stiffness, damping, angle at rest.
pub struct Fold(pub [usize; 4], pub f64, pub f64, pub f64);

/// A load on some nodes, its scale over time.
pub struct Load {
    pub nodes: Vec<usize>,
    pub kind: Kind,
    pub scale: fn(f64) -> f64,
}

/// A force [N], or a torque [N·m] about a unit axis through a point.
pub enum Kind {
    Force(V),
    Torque(f64, V, V),
}

/// A steady motion up to a time: turned by `radians` about a unit axis through `pivot`, shifted by `shift`.
#[derive(Clone, Copy)]
pub struct Rigid {
    pub until: f64,
    pub shift: V,
    pub axis: V,
    pub radians: f64,
    pub pivot: V,
}

impl Rigid {
    pub fn turn(&self, x: V, t: f64) -> V {
        let (sin, cos) = (self.radians * (t / self.until).min(1.0)).sin_cos();
        let along = scale(self.axis, dot(self.axis, x) * (1.0 - cos));
        add(add(scale(x, cos), scale(cross(self.axis, x), sin)), along)
    }

    pub fn apply(&self, x: V, t: f64) -> V {
        let shift = scale(self.shift, (t / self.until).min(1.0));
        add(add(self.turn(sub(x, self.pivot), t), self.pivot), shift)
    }

    /// Where the material point that is at `x` at time `t` was at time 0.
    fn undo(&self, x: V, t: f64) -> V {
        let shift = scale(self.shift, (t / self.until).min(1.0));
        let back = Self { radians: -self.radians, ..*self };
        add(back.turn(sub(sub(x, shift), self.pivot), t), self.pivot)
    }
}

/// A ball (radius) or a half-space (outward unit normal), offset included.
pub struct Obstacle {
    pub at: V,
    pub ball: Option<f64>,
    pub normal: V,
    pub friction: f64,
    pub restitution: f64,
    pub motion: Rigid,
}

/// A volume to keep: closed triangles, the volume [m³], and whether nodes are moved to restore it.
pub struct Inside {
    pub triangles: Vec<[u32; 3]>,
    pub volume: f64,
    pub moves: bool,
}

#[derive(Default)]
pub struct Reference {
    pub x: Vec<V>,
    pub v: Vec<V>,
    pub mass: Vec<f64>,
    pub held: BTreeSet<usize>,
    pub springs: Vec<Spring>,
    pub folds: Vec<Fold>,
    pub gravity: V,
    pub wind: V,
    pub drag: f64,
    pub loads: Vec<Load>,
    pub pins: Vec<(usize, V, Rigid)>,
    pub obstacles: Vec<Obstacle>,
    pub inside: Option<Inside>,
    pub solver: Solver,
    /// Springs that ACAD has made constraints in the last step.
    pub active: BTreeSet<usize>,
    /// What each spring pulled with in the last step, where it was a constraint [N].
    pub multipliers: Vec<f64>,
    /// What springs changed of each node's velocity in the last step, where they were solved for by nodes [m/s].
    pub changes: Vec<V>,
    /// At second order: acceleration of each node [m/s²]; then where nodes come to without velocity [m], and by velocity [s].
    pub rates: Vec<V>,
    pub arrive: Option<(Vec<V>, f64)>,
    /// Nodes that met an obstacle in the last step.
    pub touched: u64,
    pub time: f64,
}

impl Reference {
    pub fn new(x: Vec<V>, mass: Vec<f64>) -> Self {
        let v = vec![[0.0; 3]; x.len()];
        Self { x, v, mass, ..Self::default() }
    }

    /// Adds springs at rest as they are, [k, d].
    pub fn join(&mut self, pairs: impl IntoIterator<Item = [usize; 2]>, [k, d]: [f64; 2]) {
        for [a, b] in pairs {
            self.springs.push(Spring(a, b, k, d, norm(sub(self.x[b], self.x[a]))));
        }
    }

    /// Adds hinges at rest as they are, at each edge that two triangles share.
    pub fn hinge(&mut self, triangles: &[[u32; 3]], [k, d]: [f64; 2]) {
        for corners in shared_edges(triangles) {
            self.folds.push(Fold(corners, k, d, angle(corners.map(|n| self.x[n]))));
        }
    }

    /// Keeps the volume that there is now.
    pub fn keep_volume(&mut self, triangles: Vec<[u32; 3]>, moves: bool) {
        let volume = self.volume(&triangles).0;
        self.inside = Some(Inside { triangles, volume, moves });
    }

    /// V = Σ a·(b×c)/6 and its derivatives, from the mean of all places.
    fn volume(&self, triangles: &[[u32; 3]]) -> (f64, Vec<V>) {
        let middle = scale(self.x.iter().copied().fold([0.0; 3], add), 1.0 / self.x.len() as f64);
        let (mut volume, mut slopes) = (0.0, vec![[0.0; 3]; self.x.len()]);
        for triangle in triangles {
            let [a, b, c] = triangle.map(|n| sub(self.x[n as usize], middle));
            volume += dot(a, cross(b, c)) / 6.0;
            for (&n, across) in triangle.iter().zip([cross(b, c), cross(c, a), cross(a, b)]) {
                slopes[n as usize] = add(slopes[n as usize], scale(across, 1.0 / 6.0));
            }
        }
        (volume, slopes)
    }

    pub fn inverse_mass(&self, n: usize) -> f64 {
        if self.held.contains(&n) { 0.0 } else { 1.0 / self.mass[n] }
    }

    /// Takes λ times the derivatives from the forces: (Σ w s²) λ = Φ/h² + Σ s·(v/h + w f + g).
    fn correct(&self, f: &mut [V], h: f64) {
        let Some(inside) = &self.inside else { return };
        let (volume, slopes) = self.volume(&inside.triangles);
        let (mut left, mut right) = (0.0, (volume - inside.volume) / (h * h));
        for (n, &slope) in slopes.iter().enumerate() {
            let w = self.inverse_mass(n);
            let falls = if w > 0.0 { self.gravity } else { [0.0; 3] };
            left += w * dot(slope, slope);
            right += dot(slope, add(scale(self.v[n], 1.0 / h), add(scale(f[n], w), falls)));
        }
        for (force, slope) in f.iter_mut().zip(slopes) {
            *force = sub(*force, scale(slope, right / left));
        }
    }

    /// Moves nodes that have met nothing, then keeps all out of obstacles, until the volume is right.
    fn restore(&mut self, in_contact: &mut BTreeSet<usize>, h: f64) {
        let Some((triangles, goal)) =
            self.inside.as_ref().filter(|inside| inside.moves).map(|i| (i.triangles.clone(), i.volume))
        else {
            return;
        };
        for _ in 0..5 {
            let (volume, slopes) = self.volume(&triangles);
            if (volume - goal).abs() <= 1e-10 * goal {
                break;
            }
            let w = |n: usize| if in_contact.contains(&n) { 0.0 } else { self.inverse_mass(n) };
            let all: f64 = slopes.iter().enumerate().map(|(n, &s)| w(n) * dot(s, s)).sum();
            let moves: Vec<V> =
                slopes.iter().enumerate().map(|(n, &s)| scale(s, w(n) * (goal - volume) / all)).collect();
            for (x, by) in self.x.iter_mut().zip(moves) {
                *x = add(*x, by);
            }
            self.resolve_contact(in_contact, h);
        }
    }

    /// Keeps free nodes out of obstacles; adds those that have met one.
    fn resolve_contact(&mut self, in_contact: &mut BTreeSet<usize>, h: f64) {
        for n in (0..self.x.len()).filter(|n| !self.held.contains(n)) {
            let before = self.x[n];
            for obstacle in &self.obstacles {
                (self.x[n], self.v[n]) = obstacle.resolve_contact(self.x[n], self.v[n], self.time, h);
            }
            if self.x[n] != before {
                in_contact.insert(n);
            }
        }
    }

    pub fn forces(&self) -> Vec<V> {
        let mut f: Vec<V> = self.v.iter().map(|&v| sub(self.wind, scale(v, self.drag))).collect();
        let springs = self.springs.iter().enumerate().filter(|&(index, _)| !self.is_constraint(index));
        for (_, &Spring(a, b, k, d, rest)) in springs {
            let (apart, rate) = (sub(self.x[b], self.x[a]), sub(self.v[b], self.v[a]));
            let n = scale(apart, 1.0 / norm(apart));
            let pull = scale(n, k * (norm(apart) - rest) + d * dot(rate, n));
            (f[a], f[b]) = (add(f[a], pull), sub(f[b], pull));
        }
        let folds = if self.solver.is_primal() { &[][..] } else { &self.folds };
        for &Fold(nodes, k, d, rest) in folds {
            let x = nodes.map(|n| self.x[n]);
            let gradient = angle_gradient(x);
            let rate: f64 = (0..4).map(|c| dot(gradient[c], self.v[nodes[c]])).sum();
            let moment = k * (angle(x) - rest) + d * rate;
            for c in 0..4 {
                f[nodes[c]] = sub(f[nodes[c]], scale(gradient[c], moment));
            }
        }
        for Load { nodes, kind, scale: factor } in &self.loads {
            let lever = |n: usize, axis, about| cross(axis, sub(self.x[n], about));
            for &n in nodes {
                let force = match *kind {
                    Kind::Force(force) => force,
                    Kind::Torque(value, axis, about) => {
                        let all: f64 = nodes.iter().map(|&n| lever(n, axis, about)).map(|l| dot(l, l)).sum();
                        scale(lever(n, axis, about), value / all)
                    }
                };
                f[n] = add(f[n], scale(force, factor(self.time)));
            }
        }
        f
    }

    /// A step; at second order the first one is preceded by a short one, which finds accelerations.
    pub fn step(&mut self, h: f64) {
        if self.solver.is_second_order() && self.time == 0.0 {
            self.part(h / 64.0);
            return self.part(h - h / 64.0);
        }
        self.part(h);
    }

    /// Constraints, symplectic Euler, then pins, then contact and the volume.
    fn part(&mut self, h: f64) {
        self.activate();
        let mut forces = self.forces();
        self.constrain(&mut forces, h);
        self.correct(&mut forces, h);
        for (n, force) in forces.into_iter().enumerate() {
            if !self.held.contains(&n) {
                self.v[n] = add(self.v[n], scale(add(scale(force, 1.0 / self.mass[n]), self.gravity), h));
            }
            self.x[n] = match &self.arrive {
                Some((rest, reach)) if !self.held.contains(&n) => add(rest[n], scale(self.v[n], *reach)),
                _ => add(self.x[n], scale(self.v[n], h)),
            };
        }
        for &(n, start, path) in &self.pins {
            let [from, to] = [self.time, self.time + h].map(|t| path.apply(start, t));
            (self.x[n], self.v[n]) = (to, scale(sub(to, from), 1.0 / h));
        }
        let mut in_contact = BTreeSet::new();
        self.resolve_contact(&mut in_contact, h);
        self.restore(&mut in_contact, h);
        self.touched = in_contact.len() as u64;
        self.time += h;
    }

    /// Kinetic, gravitational, spring and hinge energy [J].
    pub fn energies(&self) -> [f64; 4] {
        let sum = |of: &dyn Fn(usize) -> f64| (0..self.x.len()).map(of).sum::<f64>();
        let stretch = |s: &Spring| norm(sub(self.x[s.1], self.x[s.0])) - s.4;
        let fold = |f: &Fold| angle(f.0.map(|n| self.x[n])) - f.3;
        [
            sum(&|n| 0.5 * self.mass[n] * dot(self.v[n], self.v[n])),
            sum(&|n| -self.mass[n] * dot(self.gravity, self.x[n])),
            self.springs.iter().map(|s| 0.5 * s.2 * stretch(s) * stretch(s)).sum(),
            self.folds.iter().map(|f| 0.5 * f.1 * fold(f) * fold(f)).sum(),
        ]
    }
}

impl Obstacle {
    /// How deep [m] a place is inside, and the outward unit normal there, at a time.
    pub fn depth(&self, x: V, t: f64) -> (f64, V) {
        let from = sub(x, self.motion.apply(self.at, t));
        match self.ball {
            Some(radius) => (radius - norm(from), scale(from, 1.0 / norm(from))),
            None => (-dot(self.motion.turn(self.normal, t), from), self.motion.turn(self.normal, t)),
        }
    }

    /// Velocity [m/s] in the step from `t` to `t + h` of what is at `x` at its end.
    pub fn velocity(&self, x: V, t: f64, h: f64) -> V {
        let before = self.motion.apply(self.motion.undo(x, t + h), t);
        scale(sub(x, before), 1.0 / h)
    }

    /// Projection to the surface, restitution, Coulomb friction relative to the surface's own motion.
    fn resolve_contact(&self, x: V, v: V, t: f64, h: f64) -> (V, V) {
        let (depth, n) = self.depth(x, t + h);
        if depth <= 0.0 {
            return (x, v);
        }
        let relative = sub(v, self.velocity(x, t, h));
        let (out, inward) = (add(x, scale(n, depth)), -dot(relative, n));
        if inward <= 0.0 {
            return (out, v);
        }
        let slip = add(relative, scale(n, inward));
        let most = self.friction * (1.0 + self.restitution) * inward;
        let lost = if norm(slip) > most { scale(slip, most / norm(slip)) } else { slip };
        let bounced = add(v, scale(n, (1.0 + self.restitution) * inward));
        (sub(out, scale(lost, h)), sub(bounced, lost))
    }
}
