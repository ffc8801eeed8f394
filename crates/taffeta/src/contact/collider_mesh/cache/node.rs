//! The contact cache of one node.

use crate::contact::collider_mesh::cache::MOST;
use crate::contact::collider_mesh::cache::lanes::{Closest, LANES, View};
use crate::contact::collider_mesh::surface::{Found, MeshContact, MeshNow};
use crate::contact::collider_mesh::tree::Candidates;
use crate::contact::collider_mesh::triangle::Nearest;
use crate::real::{Real, dot, sub};

/// The list of one node, beside the position of its search.
#[derive(Clone, Copy)]
pub struct Memory<T> {
    /// Within this distance of that position, less the mesh's own travel, the list is complete [m].
    whole: T,
    /// The mesh's travel at that time [m].
    since: T,
    /// The nearest triangles, nearest first, and their distance from that position [m].
    list: [u32; MOST],
    distances: [T; MOST],
    count: u32,
    /// Position of the last search for the nearest triangle [m], and that triangle.
    seen: [T; 3],
    nearest: u32,
    /// Its distance, a lower bound of that of all others, and the mesh's travel at that time [m]; 0 if unknown.
    off: T,
    others: T,
}

/// One node.
pub struct Node<'a, T> {
    /// Position of the last search [m].
    pub anchor: [&'a mut T; 3],
    /// Within this distance of it, less the mesh's own travel, there is no contact [m].
    pub clear: &'a mut T,
    pub memory: &'a mut Memory<T>,
}

impl<T: Real> Memory<T> {
    /// Empty.
    pub fn nothing() -> Self {
        Self {
            whole: T::ZERO,
            since: T::ZERO,
            list: [0; MOST],
            distances: [T::ZERO; MOST],
            count: 0,
            seen: [T::ZERO; 3],
            nearest: 0,
            off: T::ZERO,
            others: T::ZERO,
        }
    }

    /// Adds a triangle to the list by its squared distance.
    fn insert(&mut self, triangle: u32, squared: T) {
        let count = self.count as usize;
        if count == MOST && squared >= self.distances[MOST - 1] {
            return;
        }
        let mut at = count.min(MOST - 1);
        while at > 0 && self.distances[at - 1] > squared {
            (self.list[at], self.distances[at]) = (self.list[at - 1], self.distances[at - 1]);
            at -= 1;
        }
        (self.list[at], self.distances[at]) = (triangle, squared);
        self.count = (count + 1).min(MOST) as u32;
    }

    fn take_roots(&mut self) {
        let count = self.count as usize;
        self.distances[..count].iter_mut().for_each(|squared| *squared = squared.sqrt());
    }
}

impl<T: Real> Node<'_, T> {
    /// Whether a segment stays within `most` of the anchor.
    fn holds(&self, [start, end]: [[T; 3]; 2], most: T) -> bool {
        let near = |place: [T; 3]| {
            let d = self.way_to(place);
            dot(d, d) < most * most
        };
        most > T::ZERO && near(start) && near(end)
    }

    /// From the anchor to `x` [m].
    fn way_to(&self, x: [T; 3]) -> [T; 3] {
        let [a, b, c] = &self.anchor;
        sub(x, [**a, **b, **c])
    }

    /// Whether a segment has no contact.
    pub fn is_clear(&self, now: &MeshNow<T>, way: [[T; 3]; 2]) -> bool {
        self.holds(way, *self.clear - now.travel)
    }

    /// Whether the mesh at `x` is farther than `most` from contact [m].
    pub fn is_off(&self, now: &MeshNow<T>, x: [T; 3], most: T) -> bool {
        self.holds([x; 2], *self.clear - now.travel - most)
    }

    /// Whether only the triangles of the list matter for a segment.
    pub fn is_whole(&self, now: &MeshNow<T>, way: [[T; 3]; 2]) -> bool {
        self.holds(way, self.memory.whole - now.travel)
    }

    /// How much closer to `x` a triangle may be than to the anchor [m].
    fn moved(&self, now: &MeshNow<T>, x: [T; 3]) -> T {
        let d = self.way_to(x);
        dot(d, d).sqrt() + (now.travel - self.memory.since)
    }

    /// A lower bound of the distance of all triangles from `x` [m].
    pub fn least(&self, now: &MeshNow<T>, x: [T; 3]) -> T {
        self.memory.off - now.travel - self.since_seen(x)
    }

    /// Distance of `x` from the last search for the nearest triangle [m].
    fn since_seen(&self, x: [T; 3]) -> T {
        let d = sub(x, self.memory.seen);
        dot(d, d).sqrt()
    }

    /// The contact of a position by its nearest point; `None` only if it is farther away than the mesh's offset and
    /// `most` [m]. Lists reach about as far as `reach` [m].
    pub fn resting(&mut self, view: &View<'_, T>, most: T, reach: T) -> Option<MeshContact<T>> {
        let (x, now) = (view.x, view.now);
        let last = Found { triangle: self.memory.nearest, at: view.nearest(self.memory.nearest) };
        if self.is_still_nearest(now, x, &last.at) {
            return Some(view.surface.resting(now, x, &last, &List(&[])));
        }
        let tree = view.surface.tree(now);
        let is_rebuilt = if self.is_whole(now, [x; 2]) {
            self.follow(view)
        } else if let Some(far) = tree.far_from(x)
            && far > now.offset + most
        {
            self.start(now, x);
            *self.clear = far - now.offset + self.memory.since;
            return None;
        } else if self.is_slow(now, x, reach) {
            self.search(view);
            true
        } else {
            self.start(now, x);
            true
        };
        let mut closest = Closest::new(last.triangle, last.at.squared);
        let is_whole = self.is_whole(now, [x; 2]);
        if is_whole {
            self.look_at_list(view, &mut closest);
        } else {
            closest.look_around(view);
        }
        let is_last = closest.triangle == last.triangle;
        let at = if is_last { last.at } else { view.nearest(closest.triangle) };
        let found = Found { triangle: closest.triangle, at };
        let contact = if is_whole {
            view.surface.resting(now, x, &found, &self.list())
        } else {
            view.surface.resting(now, x, &found, &tree.around(x, at.squared))
        };
        let lost = tree.lost();
        if is_rebuilt {
            *self.clear = self.memory.since - contact.depth - lost - lost;
        }
        self.note(view, &closest, lost);
        Some(contact)
    }

    /// Whether the last nearest triangle is still the nearest at `x`, with the point `at` inside it.
    fn is_still_nearest(&self, now: &MeshNow<T>, x: [T; 3], at: &Nearest<T>) -> bool {
        let others = self.memory.others - now.travel - self.since_seen(x);
        let [u, v, w] = at.barycentric;
        let is_within = u != T::ZERO && v != T::ZERO && w != T::ZERO;
        is_within && others > T::ZERO && at.squared < others * others
    }

    /// Stores the nearest triangle.
    fn note(&mut self, view: &View<'_, T>, closest: &Closest<T>, lost: T) {
        let (memory, travel) = (&mut *self.memory, view.now.travel);
        (memory.seen, memory.nearest) = (view.x, closest.triangle);
        memory.off = closest.squared.sqrt() - lost + travel;
        memory.others = closest.others.sqrt() - lost + travel;
    }

    /// Whether a list is useful to a node at `x`: the node has moved less, and is closer, than a list reaches.
    fn is_slow(&self, now: &MeshNow<T>, x: [T; 3], reach: T) -> bool {
        let moved = self.moved(now, x);
        moved + moved < reach && self.least(now, x) < now.offset + reach
    }

    /// Empties the cache at `x`. A new search is valid for the whole sub-step.
    fn start(&mut self, now: &MeshNow<T>, x: [T; 3]) {
        for (anchor, x) in self.anchor.iter_mut().zip(x) {
            **anchor = x;
        }
        let since = now.travel - now.stride;
        *self.clear = since;
        (self.memory.since, self.memory.whole, self.memory.count) = (since, since, 0);
    }

    /// The triangles of the list.
    pub fn list(&self) -> List<'_> {
        List(&self.memory.list[..self.memory.count as usize])
    }

    /// Compares the triangles of the list that may be closer than the closest.
    fn look_at_list(&self, view: &View<'_, T>, closest: &mut Closest<T>) {
        let Memory { list, distances, whole, since, .. } = &*self.memory;
        let count = self.memory.count as usize;
        let moved = self.moved(view.now, view.x) + view.surface.tree(view.now).lost();
        let off = |distance: T| {
            let off = distance - moved;
            if off > T::ZERO { off * off } else { T::ZERO }
        };
        let bound = closest.squared;
        let looked = distances[..count].iter().position(|&distance| off(distance) > bound).unwrap_or(count);
        for triangles in list[..looked].chunks(LANES) {
            for (&triangle, squared) in triangles.iter().zip(view.squared(triangles.iter().copied())) {
                closest.consider(triangle, squared);
            }
        }
        // All triangles outside the list are farther away than the nearest, and than twice the list's radius.
        let whole = *whole - *since;
        closest.leave(if looked < count {
            off(distances[looked])
        } else {
            off(whole + whole + distances[0])
        });
    }

    /// Searches for the triangles nearest to the position of the view.
    fn search(&mut self, view: &View<'_, T>) {
        let (tree, now) = (view.surface.tree(view.now), view.now);
        self.start(now, view.x);
        let memory = &mut *self.memory;
        tree.visit_around(view.x, T::FAR, |triangles| {
            for (triangle, squared) in triangles.clone().zip(view.squared(triangles)) {
                memory.insert(triangle, squared);
            }
            if memory.count < MOST as u32 { T::FAR } else { memory.distances[MOST - 1] }
        });
        memory.take_roots();
        let lost = tree.lost();
        let whole = if (memory.count as usize) < MOST {
            T::FAR
        } else {
            let reach = memory.distances[MOST - 1] - lost - lost;
            let (by_offset, by_nearest) =
                (reach - now.offset, (reach - memory.distances[0]) / (T::ONE + T::ONE));
            if by_offset < by_nearest { by_offset } else { by_nearest }
        };
        memory.whole = whole + memory.since;
    }

    /// Sorts the list again by distance from the view, if the node has moved so far that too many triangles may be
    /// near. Returns whether it did.
    fn follow(&mut self, view: &View<'_, T>) -> bool {
        let (now, x) = (view.now, view.x);
        let (two, four) = (T::ONE + T::ONE, T::from_f64(4.0));
        let way = self.way_to(x);
        let (moved, left) = (dot(way, way).sqrt(), self.memory.whole - now.travel);
        if moved * four < left || self.memory.count < MOST as u32 {
            return false;
        }
        let left = left - moved - view.surface.tree(now).lost();
        let distances = &self.memory.distances;
        if left * four < (distances[MOST - 1] - distances[0]) / two {
            self.search(view);
            return true;
        }
        let list = self.memory.list;
        self.start(now, x);
        for triangles in list.chunks(LANES) {
            for (&triangle, squared) in triangles.iter().zip(view.squared(triangles.iter().copied())) {
                self.memory.insert(triangle, squared);
            }
        }
        self.memory.take_roots();
        self.memory.whole = left + self.memory.since;
        true
    }
}

/// Some triangles.
pub struct List<'a>(&'a [u32]);

impl<T: Real> Candidates<T> for List<'_> {
    fn visit(&self, job: impl FnMut(u32)) {
        self.0.iter().copied().for_each(job);
    }
}
