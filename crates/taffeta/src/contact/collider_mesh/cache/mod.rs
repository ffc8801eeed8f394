//! A contact cache: the triangles near each node, so that few are compared in a sub-step.
//!
//! Two distances hold around the position of a node's last search. Within the first one, the node is not in contact.
//! Within the second one, only the triangles in its list matter; a node that moves farther between two sub-steps has
//! no list. The nearest triangle remains the nearest until the node has moved by the difference to the second
//! nearest. Contacts do not depend on the cache, only the time to find them, so it is no part of a snapshot.

mod lanes;
mod node;

use crate::assembly::Assembly;
use crate::contact::collider_mesh::surface::{MeshContact, MeshNow, MeshShape, MeshSurface};
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::predicted_contact::{Approach, Depth, PredictedContact, deepest};
use crate::contact::colliders::rigid::Rigid;
use crate::contact::colliders::shape::{ShapeNow, positive};
use crate::cpu::column::Column;
use crate::cpu::shared::Shared;
use crate::cpu::simd::{Kernel, SimdLevel};
use crate::real::{Real, dot, norm, sub};
use crate::topology::measure;
use lanes::View;
use node::{Memory, Node};
use std::f64::consts::PI;
use std::ops::Range;

/// Most triangles in a list: two rings around a node of a regular mesh, and some more.
const MOST: usize = 20;

/// The meshes of a scene, and the cache of each. One worker at a time uses the cache of a node.
pub struct MeshCache<T> {
    surfaces: Vec<MeshSurface<T>>,
    /// About how far a list reaches on a flat part of each [m].
    reaches: Vec<T>,
    level: SimdLevel,
    known: Vec<Known<T>>,
}

/// The cache of one mesh, by node.
struct Known<T> {
    /// Position of the last search [m], in the mesh's frame.
    anchor: [Shared<T>; 3],
    /// Within this distance of it, less the mesh's own travel, there is no contact [m].
    clear: Shared<T>,
    memories: Shared<Memory<T>>,
}

/// Radius of a disc with the area of a list's triangles [m].
fn reach(mesh: &MeshShape) -> f64 {
    let area: f64 = mesh.triangles.iter().map(|&triangle| measure::area(&mesh.poses[0], triangle)).sum();
    (MOST as f64 * area / (PI * mesh.triangles.len() as f64)).sqrt()
}

impl<T: Real> MeshCache<T> {
    /// Empty caches of the meshes of a scene, for so many `places`.
    pub fn new(assembly: &Assembly, places: usize, level: SimdLevel) -> Self {
        let meshes = assembly.colliders().iter().filter_map(|collider| collider.mesh());
        let (surfaces, reaches): (Vec<_>, Vec<_>) =
            meshes.map(|mesh| (mesh.surface(), T::from_f64(reach(mesh)))).unzip();
        let known = |_: &MeshSurface<T>| Known {
            anchor: std::array::from_fn(|_| Column::zeros(places).into()),
            clear: Column::zeros(places).into(),
            memories: vec![Memory::nothing(); places].into(),
        };
        Self { known: surfaces.iter().map(known).collect(), surfaces, reaches, level }
    }

    /// Clears the cache of a node, because its state was set, or time went back.
    pub fn forget(&mut self, node: usize) {
        for mesh in &mut self.known {
            mesh.clear.get_mut()[node] = T::ZERO;
            mesh.memories.get_mut()[node] = Memory::nothing();
        }
    }
}

impl<T: Real> MeshCache<T> {
    /// How many of a run of nodes may touch a mesh. `carry` moves their starting positions along.
    pub fn stirred(
        &self,
        level: SimdLevel,
        now: &MeshNow<T>,
        run: &Range<usize>,
        (start, end): ([&[T]; 3], [&[T]; 3]),
        carry: &Rigid<T>,
    ) -> u32 {
        let known = &self.known[now.index as usize];
        // SAFETY: a run is that of a tile, which one worker looks after until the next barrier.
        let (anchor, clear) = unsafe {
            (known.anchor.each_ref().map(|c| &*c.write(run.clone())), &*known.clear.write(run.clone()))
        };
        level.run(Stirred { now, start, end, carry, anchor, clear })
    }

    /// The contact of a node that moves from `start` to `end` with a mesh [m].
    pub fn contact(
        &self,
        now: &MeshNow<T>,
        node: usize,
        start: [T; 3],
        end: [T; 3],
    ) -> Option<MeshContact<T>> {
        let way = [now.local(start), now.local(end)];
        if !is_somewhere(way[1]) {
            return None;
        }
        let mut one = self.node(now.index, node);
        if one.is_clear(now, way) {
            return None;
        }
        let (view, reach) = self.view(now, way[1]);
        let from = one.least(now, way[0]);
        let at_end = one.resting(&view, T::ZERO, reach);
        let contact = if keeps_off(now, way, from, at_end.as_ref()) {
            at_end.filter(|at_end| at_end.depth > T::ZERO)
        } else if one.is_whole(now, way) {
            view.surface.contact_on_segment(now, way, at_end, &one.list())
        } else {
            // The motion is long: it may pass through triangles outside the list.
            view.surface.contact_on_segment(now, way, at_end, &view.surface.tree(now).along(way))
        }?;
        Some(MeshContact {
            normal: now.place.turn(contact.normal),
            velocity: now.place.turn(contact.velocity),
            ..contact
        })
    }

    /// The penetration of a node at `x` [m] into the mesh; `None` only if it is farther away than `most` [m].
    pub fn depth(&self, now: &MeshNow<T>, node: usize, x: [T; 3], most: T) -> Option<Depth<T>> {
        let place = now.local(x);
        if !is_somewhere(place) {
            return None;
        }
        let mut one = self.node(now.index, node);
        if one.is_off(now, place, most) {
            return None;
        }
        let (view, reach) = self.view(now, place);
        let MeshContact { depth, normal, velocity, .. } = one.resting(&view, most, reach)?;
        Some(Depth { depth, normal: now.place.turn(normal), velocity: now.place.turn(velocity) })
    }

    /// A mesh relative to `x` [m], and how far a list of it reaches [m].
    fn view<'b>(&'b self, now: &'b MeshNow<T>, x: [T; 3]) -> (View<'b, T>, T) {
        let Self { surfaces, reaches, level, .. } = self;
        let index = now.index as usize;
        (View { level: *level, surface: &surfaces[index], now, x }, reaches[index])
    }

    /// Predicted contact of a node: the deepest one, and its collider.
    pub fn predict(
        &self,
        colliders: &[ColliderNow<T>],
        node: usize,
        approach: &Approach<T>,
    ) -> (PredictedContact<T>, u32) {
        let found = deepest(colliders, |collider| match &collider.shape {
            ShapeNow::Mesh(mesh) => {
                // It does not reach the surface from farther away.
                let most = approach.h * norm(approach.free) + approach.reach;
                let contact = self.depth(mesh, node, approach.position, most)?;
                PredictedContact::of_mesh(&collider.surface, approach, contact)
            }
            _ => PredictedContact::of(collider, approach),
        });
        found.unwrap_or((PredictedContact::FREE, 0))
    }

    #[inline(always)]
    fn node(&self, mesh: u32, node: usize) -> Node<'_, T> {
        let known = &self.known[mesh as usize];
        // SAFETY: a node is looked after by one worker until the next barrier, which holds this for one call.
        unsafe {
            Node {
                anchor: known.anchor.each_ref().map(|column| column.item(node)),
                clear: known.clear.item(node),
                memory: known.memories.item(node),
            }
        }
    }
}

/// Whether a segment passes through no triangle, since none is closer to its start than `from` [m]: each of its
/// points is closer to one of its ends than the mesh is.
fn keeps_off<T: Real>(
    now: &MeshNow<T>,
    [start, end]: [[T; 3]; 2],
    from: T,
    at_end: Option<&MeshContact<T>>,
) -> bool {
    let to = at_end.map_or(T::ZERO, |at_end| (now.offset - at_end.depth).abs() - now.stride);
    let way = sub(end, start);
    let off = positive(from) + positive(to);
    dot(way, way) < off * off
}

/// Whether a position is finite; a diverged node has no contact.
fn is_somewhere<T: Real>(x: [T; 3]) -> bool {
    dot(x, x) < T::FAR
}

/// Kernel: the number of nodes that may be in contact.
struct Stirred<'a, T> {
    now: &'a MeshNow<T>,
    start: [&'a [T]; 3],
    end: [&'a [T]; 3],
    carry: &'a Rigid<T>,
    anchor: [&'a [T]; 3],
    clear: &'a [T],
}

impl<T: Real> Kernel for Stirred<'_, T> {
    type Output = u32;
    #[inline(always)]
    fn run(self) -> u32 {
        let Self { now, start: [a, b, c], end: [x, y, z], carry, anchor: [p, q, r], clear } = self;
        let n = x.len();
        let (a, b, c, y, z) = (&a[..n], &b[..n], &c[..n], &y[..n], &z[..n]);
        let (p, q, r, clear) = (&p[..n], &q[..n], &r[..n], &clear[..n]);
        let mut count = 0;
        for i in 0..n {
            let anchor = [p[i], q[i], r[i]];
            let most = clear[i] - now.travel;
            let from = sub(now.local(carry.apply([a[i], b[i], c[i]])), anchor);
            let to = sub(now.local([x[i], y[i], z[i]]), anchor);
            let (far, limit) = (most > T::ZERO, most * most);
            count += u32::from(!(far & (dot(from, from) < limit) & (dot(to, to) < limit)));
        }
        count
    }
}
