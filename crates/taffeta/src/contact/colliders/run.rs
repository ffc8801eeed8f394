//! A run of nodes that colliders act on, on the CPU: contact.wgsl is its twin.

use crate::contact::collider_mesh::cache::MeshCache;
use crate::contact::collider_mesh::surface::MeshNow;
use crate::contact::colliders::moving::{ColliderNow, ContactSurface};
use crate::contact::colliders::response::{leave_both, respond};
use crate::contact::colliders::rigid::Rigid;
use crate::contact::colliders::shape::{OnSolid, ShapeNow, Solid, entry};
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::real::{Real, add, dot, scale, sub};
use std::ops::Range;

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
