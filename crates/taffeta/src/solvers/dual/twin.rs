//! Constraints on the CPU, kernel by kernel, in the order in which the GPU takes sums.

use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::press::{Coming, Press};
use crate::elements::spring::spring;
use crate::gpu::layout::{Four, GROUP, Solving};
use crate::gpu::parity::fixture::{Fixture, SUBSTEP};
use crate::real::{add, dot, norm, scale, sub};
use crate::scene::ConstraintForm;
use crate::solvers::dual::distance::{Row as SetUp, Softness, noise};
use crate::solvers::dual::gpu_layout::{Link, Met, Progress, Row, Solve, Taken};
use crate::solvers::explicit::euler;

/// The arrays that kernels of constraints work on.
#[derive(Clone)]
pub struct Work {
    pub links: Vec<Link>,
    pub rows: Vec<Row>,
    pub scales: Vec<[f32; 2]>,
    pub met: Vec<Met>,
    pub active_links: Vec<u32>,
    pub active_counts: Vec<u32>,
    pub solves: Vec<Solve>,
    pub sums: Vec<[f32; 4]>,
    pub response: Vec<Four>,
    pub force: Vec<Four>,
    pub new_velocity: Vec<Four>,
    pub taken: Taken,
}

pub fn three([x, y, z, _]: Four) -> [f32; 3] {
    [x, y, z]
}

/// The sum of 256 lanes: the upper half is added to the lower, again and again.
pub fn by_halves(mut lanes: Vec<[f32; 4]>) -> [f32; 4] {
    let mut half = GROUP / 2;
    while half > 0 {
        for lane in 0..half {
            lanes[lane] = [0, 1, 2, 3].map(|i| lanes[lane][i] + lanes[lane + half][i]);
        }
        half /= 2;
    }
    lanes[0]
}

/// Whether a spring becomes a constraint.
pub fn becomes_active(link: &Link, position: &[Four], solving: &Solving) -> bool {
    let [a, b] = [link.a, link.b].map(|end| position[end as usize]);
    let d = sub(three(b), three(a));
    let (squared, rest) = (dot(d, d), link.rest_length * link.rest_length);
    let stays = link.is_active != 0 && squared > solving.release * rest;
    (a[3] > 0.0 || b[3] > 0.0) && (squared > solving.activation * rest || stays)
}

/// How a surface holds a node, as kernels keep it.
pub fn met_of(press: Press<f32>, surface: u32, is_pulled: bool) -> Met {
    let Press { normal, yields, velocity, surface: along } = press;
    Met { normal, yields, velocity, surface, is_pulled: is_pulled.into(), along, ..Met::default() }
}

/// The surface that will hold a node, where `before` is what meshes have found.
pub fn surface_ahead(colliders: &[ColliderNow<f32>], coming: &Coming<f32>, before: &Met) -> Met {
    let free = met_of(Press::FREE, 0, true);
    let mut found = if before.inside > 0.0 { *before } else { free };
    let mut deepest = found.inside;
    for (surface, collider) in (0..).zip(colliders) {
        let Some((inside, press)) = Press::of(collider, coming) else { continue };
        let is_first = inside == deepest && deepest > 0.0 && surface < found.surface;
        if inside > deepest || is_first {
            (deepest, found) = (inside, met_of(press, surface, true));
        }
    }
    found
}

pub fn press_of(met: &Met) -> Press<f32> {
    Press { normal: met.normal, yields: met.yields, velocity: met.velocity, surface: met.along }
}

/// A fixture's work, as its kernels find it.
pub struct Twin<'a> {
    pub fixture: &'a Fixture,
    pub solving: Solving,
    pub work: Work,
}

impl Twin<'_> {
    fn h(&self) -> f32 {
        self.fixture.substep().h
    }

    /// The nodes of the segment with the number of their system.
    fn nodes(&self) -> Vec<(usize, usize)> {
        let groups = &self.fixture.tables.linked.node_groups;
        let nodes = |first: u32, count: u32| first as usize..(first + count) as usize;
        groups.iter().flat_map(|g| nodes(g.first, g.count).map(|node| (node, g.solve as usize))).collect()
    }

    /// For each node the constraints at it, with their signs.
    fn incident(&self) -> Vec<Vec<(usize, f32)>> {
        let mut all = vec![Vec::new(); self.fixture.tables.len()];
        for (number, link) in self.work.links.iter().enumerate() {
            all[link.a as usize].push((number, -1.0));
            all[link.b as usize].push((number, 1.0));
        }
        all
    }

    pub fn mark(&mut self) {
        let position = &self.fixture.old.position;
        for link in &mut self.work.links {
            link.is_active = becomes_active(link, position, &self.solving).into();
        }
        let groups = &self.fixture.tables.linked.link_groups;
        self.work.active_counts = groups
            .iter()
            .map(|g| self.work.links[g.first as usize..(g.first + g.count) as usize].iter())
            .map(|links| links.map(|link| link.is_active).sum())
            .collect();
    }

    pub fn free(&mut self) {
        let (old, gravity) = (&self.fixture.old, self.fixture.records()[SUBSTEP].gravity);
        let incident = self.incident();
        for (node, _) in self.nodes() {
            let (x, v) = (old.position[node], old.velocity[node]);
            let active = incident[node].iter().map(|&(number, _)| self.work.links[number]);
            let active: Vec<Link> = active.filter(|link| link.is_active != 0).collect();
            let mut force = three(self.work.force[node]);
            for link in active.iter().filter(|_| self.solving.is_adaptive != 0) {
                let other = if link.a as usize == node { link.b } else { link.a } as usize;
                let d = sub(three(old.position[other]), three(x));
                let dv = sub(three(old.velocity[other]), three(v));
                let factor = spring::factor(d, dv, link.k, link.damping, link.rest_length);
                force = sub(force, scale(d, factor));
            }
            let u = [0, 1, 2].map(|i| euler::velocity(v[i], force[i], x[3], gravity[i], self.h()));
            self.work.force[node] = [force[0], force[1], force[2], 0.0];
            self.work.new_velocity[node] = [u[0], u[1], u[2], v[3].abs()];
            self.work.met[node] = met_of(Press::FREE, 0, !active.is_empty());
        }
    }

    fn softness(&self, link: &Link) -> Softness<f32> {
        let (Solving { epsilon, form, is_adaptive, .. }, h) = (self.solving, self.h());
        let printed = form == ConstraintForm::Printed as u32;
        let form = if printed { ConstraintForm::Printed } else { ConstraintForm::Compliant };
        if printed || is_adaptive != 0 {
            let epsilon = if printed { 0.0 } else { epsilon };
            return Softness { compliance: 0.0, rate: 1.0 / (h * h), epsilon, form };
        }
        let compliance = 1.0 / (h * (link.k * h + link.damping));
        Softness { compliance, rate: link.k * compliance, epsilon, form }
    }

    pub fn set_up(&mut self) {
        for number in 0..self.work.links.len() {
            let link = self.work.links[number];
            let pull = self.work.rows[number].x * self.work.scales[number][0];
            (self.work.rows[number], self.work.scales[number]) = (Row::default(), [0.0; 2]);
            if link.is_active == 0 {
                continue;
            }
            let [a, b] = [link.a, link.b].map(|end| self.fixture.old.position[end as usize]);
            let softness = self.softness(&link);
            let aim = self.solving.aim * link.rest_length;
            let row = softness.row(sub(three(b), three(a)), a[3] + b[3], aim);
            let SetUp { direction, compliance, right, scale } = row;
            let start = if scale > 0.0 { pull / scale } else { 0.0 };
            let s = noise(&row, softness.rate, three(a));
            self.work.rows[number] = Row { direction, r: start, w: 0.0, s, p: right, x: start };
            self.work.scales[number] = [scale, compliance];
        }
        for solve in &mut self.work.solves {
            if solve.links > 0 {
                (solve.kept, solve.next) = (Progress::default(), Progress::default());
            }
        }
    }

    /// What pulls do to a node at which these constraints are.
    fn gathered(&self, incident: &[(usize, f32)]) -> [f32; 3] {
        let mut sum = [0.0_f32; 3];
        for &(number, sign) in incident {
            let pull = scale(self.work.rows[number].direction, self.work.rows[number].x);
            sum = [0, 1, 2].map(|axis| sum[axis] + sign * pull[axis]);
        }
        sum
    }

    /// The surface that will hold a node.
    fn ahead(&self, coming: &Coming<f32>, before: &Met) -> Met {
        surface_ahead(&self.fixture.substep().colliders, coming, before)
    }

    /// A node as it comes to surfaces.
    fn coming(&self, node: usize, incident: &[(usize, f32)]) -> Coming<f32> {
        let (x, free) = (self.fixture.old.position[node], three(self.work.new_velocity[node]));
        let h = self.h();
        let pulls = scale(scale(self.gathered(incident), x[3]), -h);
        let fall = norm(self.fixture.records()[SUBSTEP].gravity) * h * h;
        Coming { place: three(x), free, pulls, fall, h }
    }

    pub fn meet_meshes(&mut self) {
        let incident = self.incident();
        for (node, _) in self.nodes() {
            let is_free = self.fixture.old.position[node][3] > 0.0;
            if self.work.met[node].is_pulled != 0 && is_free && self.solving.is_adaptive == 0 {
                self.work.met[node] = self.fixture.mesh_ahead(&self.coming(node, &incident[node]));
            }
        }
    }

    pub fn meet(&mut self) {
        let (incident, h) = (self.incident(), self.h());
        let held = !self.fixture.substep().colliders.is_empty() && self.solving.is_adaptive == 0;
        for (node, _) in self.nodes() {
            if self.work.met[node].is_pulled == 0 {
                continue;
            }
            let (x, free) = (self.fixture.old.position[node], three(self.work.new_velocity[node]));
            let mut rate = free.map(|c| c / h);
            if held && x[3] > 0.0 {
                let coming = self.coming(node, &incident[node]);
                self.work.met[node] = self.ahead(&coming, &self.work.met[node]);
            }
            if held {
                let press = press_of(&self.work.met[node]);
                rate = add(press.yielded(rate), scale(press.velocity, 1.0 / h));
            }
            self.work.response[node] = [rate[0], rate[1], rate[2], 0.0];
        }
    }

    pub fn start(&mut self) {
        for (link, row) in
            self.work.links.iter().zip(&mut self.work.rows).filter(|(link, _)| link.is_active != 0)
        {
            let [a, b] = [link.a, link.b].map(|end| three(self.work.response[end as usize]));
            row.p += dot(sub(b, a), row.direction);
        }
        if self.solving.is_warm == 0 {
            self.work.rows.iter_mut().for_each(|row| (row.x, row.r) = (0.0, 0.0));
        }
    }

    fn judged(&self, kept: Progress, sums: [f32; 4]) -> Progress {
        let [first, second, along, curvature] = sums;
        let mut next = Progress { alpha: 0.0, beta: 0.0, ..kept };
        match kept.passes {
            0 => {}
            1 => {
                (next.right, next.limit) = (first, (self.solving.tolerance_squared * first).max(second));
                next.alpha = if along > 0.0 && curvature > 0.0 { along / curvature } else { 0.0 };
            }
            passes => {
                next.gamma = first;
                let is_first = kept.gamma == 0.0;
                next.beta = if is_first { 0.0 } else { first / kept.gamma };
                let curvature = if is_first { second } else { second - next.beta * first / kept.alpha };
                next.alpha = first / curvature;
                let is_left = first > next.limit && passes - 2 < self.solving.most_iterations;
                next.is_done = u32::from(!(is_left && curvature > 0.0 && next.alpha.is_finite()));
            }
        }
        next
    }

    fn body_sums(&self, solve: usize) -> [f32; 4] {
        let groups = &self.fixture.tables.linked.link_groups;
        let Some(first) = groups.iter().position(|g| g.solve as usize == solve) else { return [0.0; 4] };
        let count = self.work.solves[solve].active_links.div_ceil(GROUP as u32) as usize;
        let mut lanes = vec![[0.0; 4]; GROUP];
        for i in 0..count {
            lanes[i % GROUP] = [0, 1, 2, 3].map(|k| lanes[i % GROUP][k] + self.work.sums[first + i][k]);
        }
        by_halves(lanes)
    }

    fn is_open(&self, solve: usize) -> bool {
        self.work.solves[solve].active_links > 0 && self.work.solves[solve].kept.is_done == 0
    }

    pub fn step_nodes(&mut self) {
        let open: Vec<usize> = (0..self.work.solves.len()).filter(|&solve| self.is_open(solve)).collect();
        for &solve in &open {
            self.work.solves[solve].next = self.judged(self.work.solves[solve].kept, self.body_sums(solve));
        }
        let incident = self.incident();
        for (node, solve) in self.nodes() {
            let next = self.work.solves[solve].next;
            if !open.contains(&solve) || next.is_done != 0 || self.work.met[node].is_pulled == 0 {
                continue;
            }
            let mut sum = [0.0_f32; 3];
            for &(number, sign) in &incident[node] {
                let row = self.work.rows[number];
                let left = match self.work.solves[solve].kept.passes {
                    1 => row.p - next.alpha * row.w,
                    _ => row.r - next.alpha * (row.w + next.beta * row.s),
                };
                let pull = scale(row.direction, left);
                sum = [0, 1, 2].map(|axis| sum[axis] + sign * pull[axis]);
            }
            let answer = scale(sum, self.fixture.old.position[node][3]);
            let [x, y, z] = press_of(&self.work.met[node]).yielded(answer);
            self.work.response[node] = [x, y, z, 0.0];
        }
    }

    pub fn step_rows(&mut self) {
        let groups = self.fixture.tables.linked.link_groups.clone();
        for (index, group) in groups.iter().enumerate() {
            let solve = &mut self.work.solves[group.solve as usize];
            let next = solve.next;
            if index == group.first_group as usize {
                solve.kept = Progress { passes: next.passes + 1, ..next };
            }
            let (active, first) = (solve.active_links as usize, GROUP * (index - group.first_group as usize));
            if next.is_done != 0 || first >= active {
                continue;
            }
            let base = groups[group.first_group as usize].first as usize;
            let mut lanes = vec![[0.0; 4]; GROUP];
            for (lane, terms) in lanes.iter_mut().enumerate().take(active - first) {
                let number = self.work.active_links[base + first + lane] as usize;
                *terms = self.advance(number, &next);
            }
            self.work.sums[index] = by_halves(lanes);
        }
    }

    fn advance(&mut self, number: usize, step: &Progress) -> [f32; 4] {
        let (before, link) = (self.work.rows[number], self.work.links[number]);
        let [a, b] = [link.a, link.b].map(|end| three(self.work.response[end as usize]));
        let Row { r, w, s, p, x, .. } = before;
        let mut row = match step.passes {
            0 => before,
            1 => Row { r: p - step.alpha * w, x: x * step.alpha, p: 0.0, s: 0.0, ..before },
            _ => {
                let (p, s) = (r + step.beta * p, w + step.beta * s);
                Row { p, s, x: x + step.alpha * p, r: r - step.alpha * s, ..before }
            }
        };
        row.w = dot(sub(b, a), row.direction) + self.work.scales[number][1] * row.r;
        self.work.rows[number] = row;
        match step.passes {
            0 => [p * p, s * s, x * p, x * row.w],
            _ => [row.r * row.r, row.r * row.w, 0.0, 0.0],
        }
    }

    pub fn pull(&mut self) {
        let incident = self.incident();
        for (node, _) in self.nodes() {
            let met = self.work.met[node];
            if met.is_pulled == 0 {
                continue;
            }
            let mut pull = self.gathered(&incident[node]).map(|c| -c);
            if met.normal != [0.0; 3] {
                pull = self.borne(node, &met, pull);
            }
            let [x, y, z] = add(three(self.work.force[node]), pull);
            self.work.force[node] = [x, y, z, 0.0];
        }
    }

    /// The force of pulls on a node with what a surface does about it.
    fn borne(&self, node: usize, met: &Met, pull: [f32; 3]) -> [f32; 3] {
        let (x, free) = (self.fixture.old.position[node], three(self.work.new_velocity[node]));
        let kick = self.h() * x[3];
        let collider = &self.fixture.substep().colliders[met.surface as usize];
        let after = press_of(met).after(free, scale(pull, kick), &collider.touching);
        scale(sub(after, free), 1.0 / kick)
    }

    /// Workgroups of the next iterations.
    pub fn counts(&self) -> Vec<u32> {
        let any = (0..self.work.solves.len()).any(|solve| self.is_open(solve));
        let linked = &self.fixture.tables.linked;
        let of = |groups: usize| if any { [groups as u32, 1, 1] } else { [0, 1, 1] };
        [of(linked.node_groups.len()), of(linked.link_groups.len())].concat()
    }

    pub fn note(&mut self) {
        let solves = self.work.solves.clone();
        let taken = &mut self.work.taken;
        let (mut links, mut active, mut capped) = (0, 0, false);
        for solve in &solves {
            (links, active) = (links + solve.links, active + solve.active_links);
            if solve.active_links == 0 {
                continue;
            }
            let done = solve.next;
            let right = done.right.max(done.limit / self.solving.tolerance_squared);
            capped |= done.gamma > done.limit;
            taken.iterations = taken.iterations.max(done.passes.max(2) - 2);
            taken.residual = taken.residual.max(if right > 0.0 { done.gamma / right } else { 0.0 });
        }
        taken.capped += u32::from(capped);
        taken.active_share = taken.active_share.max(active as f32 / links.max(1) as f32);
    }
}
