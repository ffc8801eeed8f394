//! What is known of the triangles around each node, so that few are looked at in a sub-step.
//!
//! Around a place at which the triangles near a node were last searched for, two distances hold: within one, the node touches
//! nothing; within the other, the triangles that were found are all that matter. The second is what a list of the nearest
//! ones leaves. Contacts do not depend on what is known, only the time to find them: it is no part of a snapshot.

use super::column::Column;
use super::shared::Shared;
use super::simd::{Kernel, SimdLevel};
use crate::assembly::Assembly;
use crate::collision::mesh::{Candidates, MeshNow, MeshSurface, MeshTouch};
use crate::collision::moving::{ColliderNow, Rigid};
use crate::collision::press::{Coming, Press};
use crate::collision::shape::ShapeNow;
use crate::collision::triangle::nearest;
use crate::real::{Real, dot, norm, sub};
use std::ops::Range;

/// Most triangles in a list: two rings around a node of a regular mesh, and some more.
const MOST: usize = 20;

/// All meshes of a scene, and what is known of each.
pub struct Meshes<T> {
    surfaces: Vec<MeshSurface<T>>,
}

/// What is known of the triangles of each mesh.
pub struct NearWork<T> {
    meshes: Vec<Known<T>>,
}

/// By node, of one mesh.
struct Known<T> {
    /// Where it was searched [m], in the mesh's frame.
    anchor: [Column<T>; 3],
    /// Within this distance of it, less the mesh's own travel, nothing is touched [m].
    clear: Column<T>,
    /// Within this one, the list is whole [m].
    whole: Column<T>,
    /// The mesh's travel then [m].
    since: Column<T>,
    /// The nearest triangles, nearest first, and their distance from the anchor [m].
    lists: Vec<u32>,
    distances: Vec<T>,
    counts: Vec<u32>,
}

/// What workers share.
pub struct SharedNear<'a, T> {
    meshes: Vec<SharedKnown<'a, T>>,
}

struct SharedKnown<'a, T> {
    anchor: [Shared<'a, T>; 3],
    clear: Shared<'a, T>,
    whole: Shared<'a, T>,
    since: Shared<'a, T>,
    lists: Shared<'a, u32>,
    distances: Shared<'a, T>,
    counts: Shared<'a, u32>,
}

impl<T: Real> Meshes<T> {
    /// Those of a scene.
    pub fn new(assembly: &Assembly) -> Self {
        let meshes = assembly.colliders.iter().filter_map(|collider| collider.mesh());
        Self { surfaces: meshes.map(|mesh| mesh.surface()).collect() }
    }
}

impl<T: Real> NearWork<T> {
    /// Nothing is known yet, of a scene with so many `places`.
    pub fn new(meshes: &Meshes<T>, places: usize) -> Self {
        let known = |_: &MeshSurface<T>| Known {
            anchor: std::array::from_fn(|_| Column::zeros(places)),
            clear: Column::zeros(places),
            whole: Column::zeros(places),
            since: Column::zeros(places),
            lists: vec![0; places * MOST],
            distances: vec![T::ZERO; places * MOST],
            counts: vec![0; places],
        };
        Self { meshes: meshes.surfaces.iter().map(known).collect() }
    }

    /// Forgets what is known of a node. Time may go back then.
    pub fn forget(&mut self, node: usize) {
        for mesh in &mut self.meshes {
            (mesh.clear[node], mesh.whole[node]) = (T::ZERO, T::ZERO);
        }
    }

    /// Lends it to workers.
    pub fn share(&mut self) -> SharedNear<'_, T> {
        SharedNear { meshes: self.meshes.iter_mut().map(Known::share).collect() }
    }
}

impl<T: Real> Known<T> {
    fn share(&mut self) -> SharedKnown<'_, T> {
        SharedKnown {
            anchor: self.anchor.each_mut().map(|column| Shared::new(column)),
            clear: Shared::new(&mut self.clear),
            whole: Shared::new(&mut self.whole),
            since: Shared::new(&mut self.since),
            lists: Shared::new(&mut self.lists),
            distances: Shared::new(&mut self.distances),
            counts: Shared::new(&mut self.counts),
        }
    }
}

/// A way of looking at the meshes around nodes. Each node is looked after by one worker at a time.
#[derive(Clone, Copy)]
pub struct Near<'a, T> {
    pub meshes: &'a Meshes<T>,
    pub shared: &'a SharedNear<'a, T>,
}

/// What is known of one node.
struct One<'a, T> {
    anchor: [&'a mut T; 3],
    clear: &'a mut T,
    whole: &'a mut T,
    since: &'a mut T,
    list: &'a mut [u32],
    distances: &'a mut [T],
    count: &'a mut u32,
}

impl<'a, T: Real> Near<'a, T> {
    /// How many of a run of nodes may touch a mesh. Places at the start of the sub-step are carried along by `carry`.
    pub fn stirred(
        &self,
        level: SimdLevel,
        now: &MeshNow<T>,
        run: &Range<usize>,
        (start, end): ([&[T]; 3], [&[T]; 3]),
        carry: &Rigid<T>,
    ) -> u32 {
        let known = &self.shared.meshes[now.index as usize];
        // SAFETY: a run is that of a tile, which one worker looks after until the next barrier.
        let (anchor, clear) = unsafe {
            (known.anchor.each_ref().map(|c| &*c.write(run.clone())), &*known.clear.write(run.clone()))
        };
        level.run(Stirred { now, start, end, carry, anchor, clear })
    }

    /// How a mesh touches a node that goes from `start` to `end` [m].
    pub fn touch(&self, now: &MeshNow<T>, node: usize, start: [T; 3], end: [T; 3]) -> Option<MeshTouch<T>> {
        let way = [now.local(start), now.local(end)];
        if !is_somewhere(way[1]) {
            return None;
        }
        let surface = &self.meshes.surfaces[now.index as usize];
        let mut one = self.one(now.index, node);
        if one.is_clear(now, way) {
            return None;
        }
        let end = [way[1]; 2];
        if !one.is_whole(now, end) {
            one.search(surface, now, way[1]);
            if one.is_clear(now, way) {
                return None;
            }
        }
        let tree = surface.tree(now);
        let touch = if one.is_whole(now, way) {
            one.follow(surface, now, way[1]);
            let list = one.listed(now, tree.lost(), way[1]);
            let across = one.may_cross(now, tree.lost(), way).then_some(&list);
            surface.touch(now, way, Some(&list), across)
        } else if one.is_whole(now, end) {
            // A long way: what it may go through is not in the list.
            let list = one.listed(now, tree.lost(), way[1]);
            surface.touch(now, way, Some(&list), Some(&tree.along(way)))
        } else {
            let around = tree.far_from(way[1]).is_none().then(|| tree.around(way[1]));
            surface.touch(now, way, around.as_ref(), Some(&tree.along(way)))
        }?;
        Some(MeshTouch {
            normal: now.place.turn(touch.normal),
            velocity: now.place.turn(touch.velocity),
            ..touch
        })
    }

    /// How deep a node at `x` [m] is in the mesh, and which way leads out; `None` only if it is farther off than `most` [m].
    pub fn depth_and_normal(&self, now: &MeshNow<T>, node: usize, x: [T; 3], most: T) -> Option<(T, [T; 3])> {
        let place = now.local(x);
        if !is_somewhere(place) {
            return None;
        }
        let surface = &self.meshes.surfaces[now.index as usize];
        let mut one = self.one(now.index, node);
        if one.holds([place; 2], *one.clear - now.travel - most) {
            return None;
        }
        if !one.is_whole(now, [place; 2]) {
            one.search(surface, now, place);
            if one.holds([place; 2], *one.clear - now.travel - most) {
                return None;
            }
        }
        let touch = if one.is_whole(now, [place; 2]) {
            let list = one.listed(now, surface.tree(now).lost(), place);
            surface.nearest(now, place, &list).map(|found| surface.resting(now, place, &found, &list))
        } else {
            let around = surface.tree(now).around(place);
            surface.nearest(now, place, &around).map(|found| surface.resting(now, place, &found, &around))
        }?;
        Some((touch.depth, now.place.turn(touch.normal)))
    }

    /// How the collider in which a node would be deepest will hold it, and which that is.
    pub fn press(&self, colliders: &[ColliderNow<T>], node: usize, coming: &Coming<T>) -> (Press<T>, u32) {
        Press::deepest(colliders, |collider| match &collider.shape {
            ShapeNow::Mesh(mesh) => {
                // From farther off it does not get there.
                let most = coming.h * norm(coming.free) + coming.fall;
                let touch = self.depth_and_normal(mesh, node, coming.place, most)?;
                Press::of_mesh(&collider.touching, coming, touch)
            }
            _ => Press::of(collider, coming),
        })
    }

    #[inline(always)]
    fn one(&self, mesh: u32, node: usize) -> One<'a, T> {
        let known = &self.shared.meshes[mesh as usize];
        let list = node * MOST..(node + 1) * MOST;
        // SAFETY: a node is looked after by one worker until the next barrier, which holds this for one call.
        unsafe {
            One {
                anchor: known.anchor.each_ref().map(|column| column.item(node)),
                clear: known.clear.item(node),
                whole: known.whole.item(node),
                since: known.since.item(node),
                list: known.lists.write(list.clone()),
                distances: known.distances.write(list),
                count: known.counts.item(node),
            }
        }
    }
}

impl<T: Real> One<'_, T> {
    /// Where it was searched [m].
    fn anchor(&self) -> [T; 3] {
        let [x, y, z] = &self.anchor;
        [**x, **y, **z]
    }

    /// Whether a way stays within `most` of the anchor.
    fn holds(&self, [start, end]: [[T; 3]; 2], most: T) -> bool {
        let near = |place: [T; 3]| {
            let d = sub(place, self.anchor());
            dot(d, d) < most * most
        };
        most > T::ZERO && near(start) && near(end)
    }

    fn is_clear(&self, now: &MeshNow<T>, way: [[T; 3]; 2]) -> bool {
        self.holds(way, *self.clear - now.travel)
    }

    fn is_whole(&self, now: &MeshNow<T>, way: [[T; 3]; 2]) -> bool {
        self.holds(way, *self.whole - now.travel)
    }

    /// How much nearer to `x` a triangle may be than it was to the anchor [m].
    fn moved(&self, now: &MeshNow<T>, lost: T, x: [T; 3]) -> T {
        let d = sub(x, self.anchor());
        dot(d, d).sqrt() + (now.travel - *self.since) + lost
    }

    /// Whether a way may pass through a triangle: it is not shorter than the nearest is off.
    fn may_cross(&self, now: &MeshNow<T>, lost: T, [start, end]: [[T; 3]; 2]) -> bool {
        let off = self.distances[0] - self.moved(now, lost, start);
        let way = sub(end, start);
        !(off > T::ZERO && dot(way, way) < off * off)
    }

    /// The list, as seen from `x`.
    fn listed(&self, now: &MeshNow<T>, lost: T, x: [T; 3]) -> Listed<'_, T> {
        let count = *self.count as usize;
        Listed {
            list: &self.list[..count],
            distances: &self.distances[..count],
            moved: self.moved(now, lost, x),
        }
    }

    /// Looks for the triangles nearest to `x`.
    fn search(&mut self, surface: &MeshSurface<T>, now: &MeshNow<T>, x: [T; 3]) {
        let tree = surface.tree(now);
        // It holds for all of the sub-step.
        *self.since = now.travel - now.stride;
        for (anchor, x) in self.anchor.iter_mut().zip(x) {
            **anchor = x;
        }
        if let Some(far) = tree.far_from(x) {
            *self.count = 0;
            *self.whole = T::ZERO;
            *self.clear = far - now.offset + *self.since;
            return;
        }
        *self.count = 0;
        tree.around(x).visit(|triangle| {
            self.insert(triangle, nearest(x, &surface.corners(now, triangle, now.shares[1])).squared);
            if *self.count < MOST as u32 { T::FAR } else { self.distances[MOST - 1] }
        });
        self.take_roots();
        self.note_reach(surface, now, x);
    }

    /// Adds a triangle to the list by its squared distance.
    fn insert(&mut self, triangle: u32, squared: T) {
        let count = *self.count as usize;
        if count == MOST && squared >= self.distances[MOST - 1] {
            return;
        }
        let mut at = count.min(MOST - 1);
        while at > 0 && self.distances[at - 1] > squared {
            (self.list[at], self.distances[at]) = (self.list[at - 1], self.distances[at - 1]);
            at -= 1;
        }
        (self.list[at], self.distances[at]) = (triangle, squared);
        *self.count = (count + 1).min(MOST) as u32;
    }

    fn take_roots(&mut self) {
        let count = *self.count as usize;
        self.distances[..count].iter_mut().for_each(|squared| *squared = squared.sqrt());
    }

    /// Sorts the list anew as seen from `x`, if the node has gone far enough that too many triangles seem to be near.
    fn follow(&mut self, surface: &MeshSurface<T>, now: &MeshNow<T>, x: [T; 3]) {
        let (two, four) = (T::ONE + T::ONE, T::from_f64(4.0));
        let way = sub(x, self.anchor());
        let (moved, left) = (dot(way, way).sqrt(), *self.whole - now.travel);
        if moved * four < left || *self.count < MOST as u32 {
            return;
        }
        let left = left - moved - surface.tree(now).lost();
        if left * four < (self.distances[MOST - 1] - self.distances[0]) / two {
            return self.search(surface, now, x);
        }
        *self.since = now.travel - now.stride;
        for (anchor, x) in self.anchor.iter_mut().zip(x) {
            **anchor = x;
        }
        let mut list = [0; MOST];
        list.copy_from_slice(self.list);
        *self.count = 0;
        for triangle in list {
            self.insert(triangle, nearest(x, &surface.corners(now, triangle, now.shares[1])).squared);
        }
        self.take_roots();
        *self.whole = left + *self.since;
        *self.clear = *self.since;
    }

    /// How far what was found goes.
    fn note_reach(&mut self, surface: &MeshSurface<T>, now: &MeshNow<T>, x: [T; 3]) {
        let lost = surface.tree(now).lost();
        let count = *self.count as usize;
        let nearest = self.distances[0];
        let whole = if count < MOST {
            T::FAR
        } else {
            let reach = self.distances[MOST - 1] - lost - lost;
            let (by_offset, by_nearest) = (reach - now.offset, (reach - nearest) / (T::ONE + T::ONE));
            if by_offset < by_nearest { by_offset } else { by_nearest }
        };
        *self.whole = whole + *self.since;
        // The pseudonormal at a corner with more triangles than the list holds is not known from it.
        let clear = if whole > T::ZERO && nearest > now.offset {
            let list = self.listed(now, lost, x);
            let found = surface.nearest(now, x, &list);
            found.map_or(T::ZERO, |found| -surface.resting(now, x, &found, &list).depth) - lost - lost
        } else {
            T::ZERO
        };
        *self.clear = clear + *self.since;
    }
}

/// Whether a place is one: what has blown up touches nothing.
fn is_somewhere<T: Real>(x: [T; 3]) -> bool {
    dot(x, x) < T::FAR
}

/// Triangles of a list that are near enough.
struct Listed<'a, T> {
    list: &'a [u32],
    distances: &'a [T],
    moved: T,
}

impl<T: Real> Candidates<T> for Listed<'_, T> {
    fn visit(&self, mut job: impl FnMut(u32) -> T) {
        let mut bound = T::FAR;
        for (&triangle, &distance) in self.list.iter().zip(self.distances) {
            let off = distance - self.moved;
            if off > T::ZERO && off * off > bound {
                break;
            }
            bound = job(triangle);
        }
    }
}

/// Kernel: how many nodes do not stay where nothing is touched.
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
