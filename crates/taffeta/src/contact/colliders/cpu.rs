//! Contact of a run of nodes with all colliders, one collider after the other over the whole run.

use crate::assembly::Assembly;
use crate::backend::SolverState;
use crate::contact::collider_mesh::cache::MeshCache;
use crate::contact::collider_mesh::surface::MeshNow;
use crate::contact::colliders::lift::Lift;
use crate::contact::colliders::moving::{ColliderNow, ContactSurface};
use crate::contact::colliders::response::{leave_both, respond};
use crate::contact::colliders::rigid::Rigid;
use crate::contact::colliders::shape::{OnSolid, ShapeNow, Solid, entry};
use crate::cpu::backend::{Context, padded};
#[cfg(feature = "gpu")]
use crate::cpu::between::Between;
use crate::cpu::feature::Feature;
use crate::cpu::shared::{PerWorker, Shared};
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::cpu::tile::{Moved, Tile};
use crate::cpu::tiles::TilePlan;
use crate::cpu::worker::Worker;
use crate::real::{Real, add, dot, scale, sub};
use crate::report::FrameSums;
use crate::step::{Marks, Op};
use std::ops::Range;

/// The colliders of a scene, and which nodes are in contact with them.
pub struct Colliders<T> {
    /// The triangles of meshes near each node.
    pub cache: MeshCache<T>,
    scratch: PerWorker<ColliderScratch<T>>,
    /// Nodes that a collider carries until a joint breaks, and that joint; ascending. Colliders ignore them until
    /// then.
    carried: Vec<[u32; 2]>,
    /// Whether the joint of each of them is broken.
    released: Shared<bool>,
    /// Nodes that are led out of colliders, ascending: these ignore them until they are out. And whether there may be some:
    /// then they are looked for before each frame.
    pub lifts: Vec<Lift>,
    is_lifting: bool,
    /// For each place of a body that keeps its volume: whether it has touched a collider in this sub-step. Empty if
    /// no body does.
    in_contact: Shared<bool>,
    /// By tile: the number of nodes that have touched a collider in this sub-step.
    contacts: Shared<u64>,
}

/// The scratch memory of a worker.
struct ColliderScratch<T> {
    /// For each node of a tile, the collider that it touched last, from 1; 0: none.
    last: Vec<u32>,
    /// Inverse masses of nodes; 0 for nodes that colliders ignore [1/kg].
    inverse_mass: Vec<T>,
}

impl<T: Real> Colliders<T> {
    /// The colliders of a scene.
    pub fn new(context: &Context<'_, T>) -> Self {
        let assembly = &*context.assembly;
        let attachments = assembly.attachments();
        let rows = (0..).zip(&attachments.joints).filter(|(_, row)| attachments.is_carried(row));
        let mut carried: Vec<[u32; 2]> = rows.map(|(number, row)| [row.ends[0], number]).collect();
        carried.sort_unstable();
        let keeps_volumes = assembly.volumes().next().is_some();
        let scratch = |_| ColliderScratch { last: vec![0; context.largest_tile()], inverse_mass: Vec::new() };
        Self {
            cache: MeshCache::new(assembly, padded(assembly), context.nodes.level),
            scratch: PerWorker::new(context.workers(), scratch),
            released: vec![false; carried.len()].into(),
            carried,
            lifts: Vec::new(),
            is_lifting: assembly.leads_out(),
            in_contact: vec![false; if keeps_volumes { assembly.places } else { 0 }].into(),
            contacts: vec![0; context.nodes.tiles.len()].into(),
        }
    }

    /// Lets colliders act on the node of a broken joint, or stops them if the joint is whole.
    ///
    /// # Safety
    /// No other worker has a tile with the joint's first end.
    pub unsafe fn set_released(&self, joint: u32, released: bool) {
        for index in (0..self.carried.len()).filter(|&index| self.carried[index][1] == joint) {
            // SAFETY: only the worker with the node's tile looks at it, by the caller's promise this one.
            *unsafe { self.released.item(index) } = released;
        }
    }

    /// For some places of a body that keeps its volume: whether each has touched a collider in this sub-step.
    ///
    /// # Safety
    /// No other worker has a tile with one of them, and no other reference to them lives.
    #[expect(clippy::mut_from_ref, reason = "the promise above is what makes the reference unique")]
    pub unsafe fn in_contact(&self, run: &Range<usize>) -> &mut [bool] {
        // SAFETY: by the caller's promise.
        unsafe { self.in_contact.write(run.clone()) }
    }

    /// For the places of bodies that keep their volume: whether each has touched a collider. Called between frames.
    #[cfg(feature = "gpu")]
    pub fn all_in_contact(&mut self) -> &mut [bool] {
        self.in_contact.get_mut()
    }

    /// Keeps a run of nodes out of colliders. `at` is where the run begins in the worker's scratch memory. `from` is
    /// the start of a node that was moved.
    fn collide(&self, tile: &Tile<'_, T>, at: usize, run: Range<usize>, from: Option<[T; 3]>) -> u64 {
        let mut state = tile.after(&run);
        let all = at..at + run.len();
        // SAFETY: each worker has its own, and works on one run at a time.
        let ColliderScratch { last, inverse_mass: alone } = unsafe { self.scratch.of(tile.worker) };
        let start = match (&from, &tile.moved) {
            (Some(from), _) => from.each_ref().map(std::slice::from_ref),
            (None, Moved::Any) => tile.scratch.before.each_ref().map(|column| &column[all.clone()]),
            (None, _) => [0, 1, 2].map(|axis| &tile.old[axis][run.clone()]),
        };
        let mut inverse_mass = &tile.nodes.inverse_mass[run.clone()];
        let first = self.carried.partition_point(|&[node, _]| (node as usize) < run.start);
        let end = self.carried.partition_point(|&[node, _]| (node as usize) < run.end);
        let lifts = self.lifts.partition_point(|lift| (lift.node as usize) < run.start)
            ..self.lifts.partition_point(|lift| (lift.node as usize) < run.end);
        if first < end || !lifts.is_empty() {
            alone.clear();
            alone.extend_from_slice(inverse_mass);
            for index in first..end {
                // SAFETY: the node is in this worker's tile.
                if !*unsafe { self.released.item(index) } {
                    alone[self.carried[index][0] as usize - run.start] = T::ZERO;
                }
            }
            for lift in &self.lifts[lifts] {
                alone[lift.node as usize - run.start] = T::ZERO;
            }
            inverse_mass = alone;
        }
        let contacts = Contact {
            level: tile.nodes.level,
            colliders: tile.substep.met_colliders().at(run.start),
            cache: &self.cache,
            run: run.clone(),
            inverse_mass,
            start,
            carried: from.is_none() && !matches!(tile.moved, Moved::Any),
            state: &mut state,
            last: &mut last[all.clone()],
            h: tile.substep.h,
        }
        .act();
        if tile.marks.has(Marks::VOLUME) { self.note_contacts(&run, &last[all]) } else { contacts }
    }

    /// Marks nodes that have touched a collider. Returns how many were not marked before.
    fn note_contacts(&self, run: &Range<usize>, last: &[u32]) -> u64 {
        // SAFETY: the tile is this worker's.
        let in_contact = unsafe { self.in_contact(run) };
        let mut new = 0;
        for (in_contact, &last) in in_contact.iter_mut().zip(last) {
            new += u64::from(last > 0 && !*in_contact);
            *in_contact |= last > 0;
        }
        new
    }
}

impl<T: Real> Feature<T> for Colliders<T> {
    fn ops(&self) -> &'static [Op] {
        &[Op::Contact]
    }

    fn begin(&self, worker: &mut Worker<'_, T>) {
        // SAFETY: the tiles are this worker's.
        unsafe { self.contacts.write(worker.tiles.clone()) }.fill(0);
        if self.in_contact.len() > 0 {
            for (_, run) in worker.nodes.tiles[worker.tiles.clone()].iter().flat_map(TilePlan::runs) {
                // SAFETY: as above.
                unsafe { self.in_contact(&run) }.fill(false);
            }
        }
    }

    #[cfg(feature = "gpu")]
    fn begin_apart(&self, tile: &Tile<'_, T>) {
        // SAFETY: each worker has its own, and works on one tile at a time.
        unsafe { self.scratch.of(tile.worker) }.last.fill(0);
    }

    #[cfg(feature = "gpu")]
    fn end_apart(&self, tile: &Tile<'_, T>, between: &mut Between<T>) {
        // SAFETY: as above.
        let last = &unsafe { self.scratch.of(tile.worker) }.last;
        for (at, run) in tile.plan.runs() {
            between.last_collider[run.clone()].copy_from_slice(&last[at..at + run.len()]);
        }
    }

    fn tile(&self, _: Op, tile: &mut Tile<'_, T>) {
        if tile.substep.colliders().is_empty() {
            return;
        }
        if let Moved::Some(moved) = &tile.moved {
            for &(node, from) in moved {
                self.collide(tile, 0, node..node + 1, Some(from));
            }
            return;
        }
        let contacts: u64 = tile.plan.runs().map(|(at, run)| self.collide(tile, at, run, None)).sum();
        // SAFETY: the tile is this worker's; all are read after the frame.
        *unsafe { self.contacts.item(tile.index) } += contacts;
    }

    fn prepare(&mut self, assembly: &Assembly, start: f64, state: [&[T]; 6]) {
        if self.is_lifting {
            let x = |node: usize| [0, 1, 2].map(|axis| state[axis][node].to_f64());
            self.lifts = assembly.lifts(start, &x);
            self.is_lifting = !self.lifts.is_empty();
        }
    }

    fn relocate(&mut self) {
        self.is_lifting = true;
    }

    fn measure(&mut self, _: [&[T]; 6], _: usize, sums: &mut FrameSums) {
        sums.all.contacts = self.contacts.get_mut().iter().sum();
    }

    fn forget(&mut self, node: usize) {
        self.cache.forget(node);
    }

    fn save(&self, state: &mut SolverState) {
        state.is_tangled |= self.is_lifting;
    }

    fn load(&mut self, state: &SolverState) {
        self.is_lifting = state.is_tangled;
        self.lifts.clear();
        for (&[_, joint], released) in self.carried.iter().zip(self.released.get_mut()) {
            *released = state.joints.get(joint as usize) == Some(&false);
        }
    }
}

/// A run of nodes that colliders act on.
pub struct Contact<'a, 'b, T> {
    pub level: SimdLevel,
    pub colliders: &'a [ColliderNow<T>],
    /// The triangles of meshes near each node.
    pub cache: &'a MeshCache<T>,
    /// The nodes.
    pub run: Range<usize>,
    pub inverse_mass: &'a [T],
    /// The start of each node's motion [m], and whether colliders have moved since.
    pub start: [&'a [T]; 3],
    pub carried: bool,
    /// Position and velocity by axis.
    pub state: &'a mut [&'b mut [T]; 6],
    /// Scratch memory, one number for each node.
    pub last: &'a mut [u32],
    /// Length of the sub-step [s].
    pub h: T,
}

/// How often a mesh acts on a node in a groove between triangles.
pub const GROOVES: usize = 4;

/// Tolerance of a depth after a response, in units in the last place of the position.
pub const ROUNDING_ULPS: f64 = 4.0;

impl<T: Real> Contact<'_, '_, T> {
    /// Keeps free nodes out of all colliders and returns how many touched one.
    ///
    /// Colliders act in the scene's order. If one of them pushes a node into another, the node is moved out of both,
    /// and its velocity does not change again.
    pub fn act(mut self) -> u64 {
        self.last.fill(0);
        let mut touches = 0;
        for (index, collider) in (1..).zip(self.colliders) {
            touches += match &collider.shape {
                ShapeNow::Mesh(mesh) => self.collide_mesh(index, collider, mesh),
                _ => self.collide_solid(index, collider),
            };
        }
        if touches == 0 {
            return 0;
        }
        if self.colliders.len() > 1 {
            self.resolve_wedges();
        }
        self.last.iter().map(|&last| u64::from(last > 0)).sum()
    }

    /// Collides all nodes with a convex collider. Returns whether any node is in contact.
    fn collide_solid(&mut self, index: u32, collider: &ColliderNow<T>) -> u32 {
        let carry = self.carry(collider);
        let [x, y, z, ..] = &*self.state;
        let end: [&[T]; 3] = [x, y, z];
        let far = collider.shape.convex(Deepest).unwrap_or(T::FAR);
        let passes = self.level.run(Passing { start: self.start, end, carry: &carry, far }).min(1);
        for node in 0..if passes > 0 { self.last.len() } else { 0 } {
            let way = [carry.apply(self.start.map(|column| column[node])), self.place(node)];
            let long = sub(way[1], way[0]);
            if self.inverse_mass[node] > T::ZERO
                && dot(long, long) > far * far
                && let Some(Some(contact)) = collider.shape.convex(Entry(way))
            {
                self.apply_response(node, index, collider, contact, [T::ZERO; 3]);
            }
        }
        let [x, y, z, ..] = &*self.state;
        if self.level.run(Inside { collider, place: [x, y, z] }) == 0 {
            return passes;
        }
        let Self { level, inverse_mass, state, last, h, .. } = self;
        level.run(Respond { collider, index, inverse_mass, state, last, h: *h });
        1
    }

    /// Collides all nodes with a mesh. Returns whether any node may be in contact.
    fn collide_mesh(&mut self, index: u32, collider: &ColliderNow<T>, mesh: &MeshNow<T>) -> u32 {
        let carry = self.carry(collider);
        let mesh = if self.carried { mesh } else { &mesh.arrived() };
        let [x, y, z, ..] = &*self.state;
        let ends = (self.start, [&**x, &**y, &**z]);
        if self.cache.stirred(self.level, mesh, &self.run, ends, &carry) == 0 {
            return 0;
        }
        let mut touches = 0;
        for node in 0..self.last.len() {
            if self.inverse_mass[node] <= T::ZERO {
                continue;
            }
            let start = carry.apply(self.start.map(|column| column[node]));
            touches |= u32::from(self.collide_triangles((node, start), index, collider, mesh));
        }
        touches
    }

    /// Collides a node that comes from `start` with a mesh. Returns whether it is in contact. In a groove, the node
    /// leaves a triangle along the triangle that it has left before. If that does not converge, it returns to its
    /// start.
    fn collide_triangles(
        &mut self,
        (node, start): (usize, [T; 3]),
        index: u32,
        collider: &ColliderNow<T>,
        mesh: &MeshNow<T>,
    ) -> bool {
        let item = self.run.start + node;
        let mut before = [T::ZERO; 3];
        for round in 0..=GROOVES {
            let Some(contact) = self.cache.contact(mesh, item, start, self.place(node)) else {
                return round > 0;
            };
            // The last response leaves a depth of rounding size.
            let [x, y, z] = self.place(node).map(T::abs);
            let rounding = T::EPSILON * T::from_f64(ROUNDING_ULPS) * (x + y + z);
            if round > 0 && !contact.passed && contact.depth <= rounding {
                break;
            }
            if round == GROOVES {
                if mesh.stride <= T::ZERO && self.was_better(mesh, item, (start, contact.depth)) {
                    self.put(node, start);
                }
                break;
            }
            let penetration = (contact.depth, contact.normal);
            self.apply_response(node, index, collider, penetration, contact.velocity);
            let along = sub(leave_both(penetration, (T::ZERO, before)), scale(contact.normal, contact.depth));
            self.put(node, add(self.place(node), along));
            before = contact.normal;
        }
        true
    }

    /// Whether a node was less deep in a mesh at its start, by more than rounding, and not on its surface.
    fn was_better(&self, mesh: &MeshNow<T>, item: usize, (start, depth): ([T; 3], T)) -> bool {
        let [x, y, z] = start.map(T::abs);
        let slack = mesh.offset * T::from_f64(1e-3) + T::EPSILON * T::from_f64(64.0) * (x + y + z);
        let was = self.cache.depth(mesh, item, start, T::ZERO).map_or(-T::FAR, |was| was.depth);
        depth > slack && was + slack < depth && (was <= T::ZERO || was + slack < mesh.offset)
    }

    /// The motion of a collider since the start of the nodes' motion.
    fn carry(&self, collider: &ColliderNow<T>) -> Rigid<T> {
        if self.carried { collider.surface.carry } else { Rigid::rest() }
    }

    fn place(&self, node: usize) -> [T; 3] {
        [0, 1, 2].map(|axis| self.state[axis][node])
    }

    fn put(&mut self, node: usize, place: [T; 3]) {
        for (column, place) in self.state.iter_mut().zip(place) {
            column[node] = place;
        }
    }

    /// Applies the response of a collider to one node in contact.
    fn apply_response(
        &mut self,
        node: usize,
        index: u32,
        collider: &ColliderNow<T>,
        contact: (T, [T; 3]),
        velocity: [T; 3],
    ) {
        let (x, v) = (self.place(node), [3, 4, 5].map(|axis| self.state[axis][node]));
        let mut contact = collider.surface.contact_at(x, contact);
        contact.surface_velocity = add(contact.surface_velocity, velocity);
        let (x, v) = respond(x, v, &contact, self.h);
        for axis in 0..3 {
            self.state[axis][node] = x[axis];
            self.state[3 + axis][node] = v[axis];
        }
        self.last[node] = index;
    }

    /// Moves nodes out of wedges: they have touched one collider, and are now inside another.
    fn resolve_wedges(&mut self) {
        let place = [0, 1, 2].map(|axis| &*self.state[axis]);
        let inside = |collider: &ColliderNow<T>| {
            collider.shape.mesh().is_some() || self.level.run(Inside { collider, place }) > 0
        };
        if !self.colliders.iter().any(inside) {
            return;
        }
        for node in 0..self.last.len() {
            if self.last[node] > 0 && self.inside_another(node) {
                let moved = self.push_out(node);
                for (column, moved) in self.state.iter_mut().zip(moved) {
                    column[node] = moved;
                }
            }
        }
    }

    fn inside_another(&self, node: usize) -> bool {
        let place = self.place(node);
        (1..).zip(self.colliders).any(|(index, collider)| {
            index != self.last[node] && self.depth(collider, node, place).0 > T::ZERO
        })
    }

    /// The penetration of a node at `x` into a collider. For a mesh it is known inside only.
    fn depth(&self, collider: &ColliderNow<T>, node: usize, x: [T; 3]) -> (T, [T; 3]) {
        let far = (-T::FAR, [T::ZERO; 3]);
        match &collider.shape {
            ShapeNow::Mesh(mesh) => {
                let found = self.cache.depth(mesh, self.run.start + node, x, T::ZERO);
                found.map(|of| (of.depth, of.normal)).filter(|(depth, _)| *depth > T::ZERO).unwrap_or(far)
            }
            _ => collider.depth_and_normal(x).unwrap_or(far),
        }
    }

    /// Moves a position out of all colliders. In a wedge, leaving one collider enters the other. So the two deepest
    /// penetrations are resolved together.
    fn push_out(&self, node: usize) -> [T; 3] {
        let mut x = self.place(node);
        for _ in 0..ROUNDS {
            let mut most = [(-T::FAR, [T::ZERO; 3]); 2];
            for collider in self.colliders {
                let penetration = self.depth(collider, node, x);
                if penetration.0 > most[0].0 {
                    most = [penetration, most[0]];
                } else if penetration.0 > most[1].0 {
                    most[1] = penetration;
                }
            }
            if most[0].0 <= T::ZERO {
                break;
            }
            x = add(x, leave_both(most[0], most[1]));
        }
        x
    }
}

/// Rounds in which a position leaves a wedge between curved colliders. Each round halves the number of wrong digits.
pub const ROUNDS: usize = 12;

/// The entry of a swept segment that passes through a convex solid.
struct Entry<T>([[T; 3]; 2]);

impl<T: Real> OnSolid<T> for Entry<T> {
    type Output = Option<(T, [T; 3])>;
    fn run<S: Solid<T>>(self, solid: S) -> Self::Output {
        let [start, end] = self.0;
        entry(solid, start, end)
    }
}

/// The depth of a convex solid's deepest point.
struct Deepest;

impl<T: Real> OnSolid<T> for Deepest {
    type Output = T;
    fn run<S: Solid<T>>(self, solid: S) -> T {
        solid.deepest()
    }
}

/// Kernel: the number of nodes that move farther than `far` [m].
struct Passing<'a, T> {
    start: [&'a [T]; 3],
    end: [&'a [T]; 3],
    carry: &'a Rigid<T>,
    far: T,
}

impl<T: Real> Kernel for Passing<'_, T> {
    type Output = u32;
    #[inline(always)]
    fn run(self) -> u32 {
        let Self { start: [a, b, c], end: [x, y, z], carry, far } = self;
        let n = x.len();
        let (a, b, c, y, z) = (&a[..n], &b[..n], &c[..n], &y[..n], &z[..n]);
        let mut count = 0;
        for i in 0..n {
            let way = sub([x[i], y[i], z[i]], carry.apply([a[i], b[i], c[i]]));
            count += u32::from(dot(way, way) > far * far);
        }
        count
    }
}

/// Kernel: the number of nodes inside a convex collider. A NaN is outside.
struct Inside<'a, T> {
    collider: &'a ColliderNow<T>,
    place: [&'a [T]; 3],
}

impl<T: Real> Kernel for Inside<'_, T> {
    type Output = u32;
    #[inline(always)]
    fn run(self) -> u32 {
        self.collider.shape.convex(self).unwrap_or(0)
    }
}

impl<T: Real> OnSolid<T> for Inside<'_, T> {
    type Output = u32;
    #[inline(always)]
    fn run<S: Solid<T>>(self, solid: S) -> u32 {
        let [x, y, z] = self.place;
        let n = x.len();
        let (y, z) = (&y[..n], &z[..n]);
        let mut count = 0;
        for i in 0..n {
            count += u32::from(solid.depth_and_normal([x[i], y[i], z[i]]).0 > T::ZERO);
        }
        count
    }
}

/// Kernel: the response of all nodes to one convex collider.
struct Respond<'a, 'b, T> {
    collider: &'a ColliderNow<T>,
    index: u32,
    inverse_mass: &'a [T],
    state: &'a mut [&'b mut [T]; 6],
    last: &'a mut [u32],
    h: T,
}

impl<T: Real> Kernel for Respond<'_, '_, T> {
    type Output = ();
    #[inline(always)]
    fn run(self) {
        self.collider.shape.convex(self);
    }
}

impl<T: Real> OnSolid<T> for Respond<'_, '_, T> {
    type Output = ();
    #[inline(always)]
    fn run<S: Solid<T>>(self, solid: S) {
        let Self { collider, index, inverse_mass, state: [x, y, z, u, v, w], last, h } = self;
        respond_all(solid, &collider.surface, inverse_mass, (x, y, z), (u, v, w), (last, index), h);
    }
}

/// Three columns that are written.
type Written<'a, T> = (&'a mut [T], &'a mut [T], &'a mut [T]);

#[inline(always)]
fn respond_all<T: Real>(
    solid: impl Solid<T>,
    surface: &ContactSurface<T>,
    inverse_mass: &[T],
    (x, y, z): Written<T>,
    (u, v, w): Written<T>,
    (last, index): (&mut [u32], u32),
    h: T,
) {
    let n = inverse_mass.len();
    let (x, y, z) = (&mut x[..n], &mut y[..n], &mut z[..n]);
    let (u, v, w, last) = (&mut u[..n], &mut v[..n], &mut w[..n], &mut last[..n]);
    for i in 0..n {
        let (place, velocity) = ([x[i], y[i], z[i]], [u[i], v[i], w[i]]);
        let (depth, normal) = solid.depth_and_normal(place);
        let touches = (depth > T::ZERO) & (inverse_mass[i] > T::ZERO);
        let (moved, after) = respond(place, velocity, &surface.contact_at(place, (depth, normal)), h);
        x[i] = if touches { moved[0] } else { place[0] };
        y[i] = if touches { moved[1] } else { place[1] };
        z[i] = if touches { moved[2] } else { place[2] };
        u[i] = if touches { after[0] } else { velocity[0] };
        v[i] = if touches { after[1] } else { velocity[1] };
        w[i] = if touches { after[2] } else { velocity[2] };
        last[i] = if touches { index } else { last[i] };
    }
}
