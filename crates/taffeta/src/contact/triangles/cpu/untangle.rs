//! Surfaces that pass through each other: when they are looked for, and what leads them back.

use super::{NO_KEY, TriangleContact, read};
use crate::assembly::Assembly;
use crate::contact::triangles::cpu::contacts::{Active, Carried, Order};
use crate::contact::triangles::cpu::narrow_phase::{Candidate, Close, Look, Way};
use crate::contact::triangles::impulse::Contact;
use crate::contact::triangles::surfaces::{Kind, corners_at};
use crate::contact::triangles::tangle::{Pull, Rule, Tangle};
use crate::cpu::worker::Worker;
use crate::real::{Real, add, cross, dot, norm, scale, sub};

impl<T: Real> TriangleContact<T> {
    /// Sets the corners of colliders where they are at a time [s].
    pub(super) fn set_corners(&mut self, assembly: &Assembly, time: f64) {
        let first = self.surfaces.places;
        for (corner, x) in corners_at(assembly, time).enumerate() {
            for (axis, x) in x.into_iter().enumerate() {
                let x = T::from_f64(x);
                self.before[axis].get_mut()[first + corner] = x;
                self.after[axis].get_mut()[first + corner] = x;
            }
        }
    }

    /// Looks how surfaces pass through each other, with nodes where `state` has them.
    pub(super) fn find_tangle(&mut self, state: [&[T]; 6]) {
        let (surfaces, [x, y, z]) = (&self.surfaces, self.after.each_mut().map(|column| &*column.get_mut()));
        let of_nodes = (0..surfaces.places).map(|place| [state[0], state[1], state[2]].map(|one| one[place]));
        let of_corners = (surfaces.places..surfaces.all_places()).map(|place| [x[place], y[place], z[place]]);
        let all: Vec<[f64; 3]> = of_nodes.chain(of_corners).map(|x| x.map(T::to_f64)).collect();
        self.tangle = Tangle::of(surfaces, &all);
        self.is_tangled = self.tangle.is_some();
    }

    /// What becomes of a pair.
    #[inline]
    pub(super) fn rule(&self, pair: &Close<T>) -> Rule {
        let of = |tangle: &Tangle| tangle.rule(pair.kind(), pair.nodes);
        self.tangle.as_ref().map_or(Rule::Apart, of)
    }

    /// Adds contacts that move lines of intersection to those of the first worker, whose contacts come first.
    pub(super) fn pull(&self, worker: &Worker<'_, T>) {
        let Some(tangle) = self.tangle.as_ref().filter(|_| worker.index == 0) else { return };
        let x = read(&self.before);
        let contacts = &mut self.scratch(worker).contacts;
        contacts.extend(tangle.pulls.iter().map(|pull| self.pulled(pull, x)));
    }

    /// A pull as a contact.
    fn pulled(&self, pull: &Pull, x: [&[T]; 3]) -> Active<T> {
        let [a, b, c] = pull.triangle;
        let nodes = [pull.node, a, b, c];
        let surfaces = [pull.node, a].map(|node| self.surfaces.surface_of[node as usize]);
        let [thickness, _] = self.surfaces.material(surfaces).unwrap_or_default();
        let weights = [1.0, -pull.weights[0], -pull.weights[1], -pull.weights[2]].map(T::from_f64);
        let normal = pull.direction.map(T::from_f64);
        let at = |node: u32| x.map(|column| column[node as usize]);
        let apart = (0..3)
            .fold([T::ZERO; 3], |sum, node| add(sum, scale(sub(at(nodes[node]), at(c)), weights[node])));
        let none = Order::new([0; 2], Candidate { way: Way::VertexTriangle, one: 0, other: 0 });
        Active {
            carried: Carried { order: none, kind: Kind::VertexTriangle, key: NO_KEY, force: [T::ZERO; 3] },
            nodes,
            weights,
            contact: Contact {
                normal,
                gap: dot(normal, apart) - T::from_f64(thickness),
                // It goes as fast as a contact of this thickness separates.
                thickness: T::from_f64(thickness.max(self.surfaces.mean_edge)),
                friction: T::ZERO,
                advance: T::ZERO,
                mobility: T::ZERO,
            },
            impulse: [T::ZERO; 3],
        }
    }
}

impl<T: Real> Look<'_, T> {
    /// A vertex on the wrong side of a triangle, or just back, as a contact that leads it to the side where it belongs: where
    /// the normal points (above), or the other.
    pub(super) fn back(
        &self,
        x: [&[T]; 3],
        (pair, weights): (&Close<T>, [T; 4]),
        (order, force): (Order, [T; 3]),
        (above, h): (bool, T),
    ) -> Option<Active<T>> {
        let at = |node: u32| x.map(|column| column[node as usize]);
        let [v, a, b, c] = pair.nodes.map(at);
        let normal = cross(sub(b, a), sub(c, a));
        let length = norm(normal);
        if length <= T::TINY {
            return None;
        }
        let normal = scale(normal, if above { T::ONE } else { -T::ONE } / length);
        Some(Active {
            carried: Carried { order, kind: pair.kind(), key: pair.candidate.key(self.leaves), force },
            nodes: pair.nodes,
            weights,
            contact: Contact {
                normal,
                gap: dot(normal, sub(v, a)) - pair.thickness,
                thickness: pair.thickness,
                friction: T::ZERO,
                advance: T::ZERO,
                mobility: T::ZERO,
            },
            impulse: scale(force, h),
        })
    }
}
