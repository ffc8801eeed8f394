//! Surfaces that pass through each other: when they are looked for, and what leads them back.

use super::{NO_KEY, TriangleContact, read};
use crate::assembly::Assembly;
use crate::contact::colliders::cpu::Colliders;
use crate::contact::colliders::lift::{Lift, are_led_apart};
use crate::contact::triangles::cpu::contacts::{Active, Carried};
use crate::contact::triangles::cpu::narrow_phase::Close;
use crate::contact::triangles::impulse::Contact;
use crate::contact::triangles::order::{Candidate, Order, Way};
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

    /// What becomes of a pair. `lifts` are the nodes that are led out of colliders.
    #[inline]
    pub(super) fn rule(&self, lifts: &[Lift], pair: &Close<T>) -> Rule {
        if !lifts.is_empty() && self.is_lifted_out(lifts, pair.nodes) {
            return Rule::Ignored;
        }
        let of = |tangle: &Tangle| tangle.rule(pair.kind(), pair.nodes);
        self.tangle.as_ref().map_or(Rule::Apart, of)
    }

    /// Whether some nodes are corners of colliders, and others are led out of these.
    fn is_lifted_out(&self, lifts: &[Lift], nodes: [u32; 4]) -> bool {
        are_led_apart(lifts, self.surfaces.places, nodes)
    }

    /// Adds contacts that move lines of intersection to those of the first worker, whose contacts come first.
    pub(super) fn pull(&self, worker: &Worker<'_, T>, contacts: &mut Vec<Active<T>>) {
        if worker.index > 0 {
            return;
        }
        let (x, lifts) = (read(&self.before), lifts(worker));
        let pulls = self.tangle.iter().flat_map(|tangle| &tangle.pulls).filter(|pull| {
            let [a, b, c] = pull.triangle;
            !self.is_lifted_out(lifts, [pull.node, a, b, c])
        });
        contacts.extend(pulls.map(|pull| self.pulled(pull, x)));
    }

    /// Adds contacts that lead nodes out of colliders to those of the first worker.
    pub(super) fn lead_out(&self, worker: &Worker<'_, T>, contacts: &mut Vec<Active<T>>) {
        if worker.index == 0 {
            contacts.extend(lifts(worker).iter().map(|lift| self.lifted(lift)));
        }
    }

    /// A node that is led out of a collider, as a contact with what stands still.
    fn lifted(&self, lift: &Lift) -> Active<T> {
        let [gap, thickness] = self.surfaces.gap_of_lift().map(T::from_f64);
        let [one, zero] = [T::ONE, T::ZERO];
        let contact = [lift.way.map(T::from_f64), [gap, thickness, zero]];
        let still = self.surfaces.all_places() as u32;
        leads([lift.node, still, still, still], [one, -one, zero, zero], contact)
    }

    /// A pull as a contact.
    fn pulled(&self, pull: &Pull, x: [&[T]; 3]) -> Active<T> {
        let [a, b, c] = pull.triangle;
        let nodes = [pull.node, a, b, c];
        let [thickness, size] = self.surfaces.thickness_of_pull(pull).map(T::from_f64);
        let weights = pull.weights_of_nodes().map(T::from_f64);
        let normal = pull.direction.map(T::from_f64);
        let at = |node: u32| x.map(|column| column[node as usize]);
        let apart = (0..3)
            .fold([T::ZERO; 3], |sum, node| add(sum, scale(sub(at(nodes[node]), at(c)), weights[node])));
        leads(nodes, weights, [normal, [dot(normal, apart) - thickness, size, T::ZERO]])
    }
}

/// The nodes that are led out of colliders.
pub(super) fn lifts<'w, T: Real>(worker: &Worker<'w, T>) -> &'w [Lift] {
    worker.features.get::<Colliders<T>>().map_or(&[], |colliders| &colliders.lifts)
}

/// A contact that leads nodes where they belong, and keeps no force: its normal; its gap [m], thickness [m] and friction.
fn leads<T: Real>(
    nodes: [u32; 4],
    weights: [T; 4],
    [normal, [gap, thickness, friction]]: [[T; 3]; 2],
) -> Active<T> {
    let order = Order::new([0; 2], Candidate { way: Way::VertexTriangle, one: 0, other: 0 });
    let zero = T::ZERO;
    Active {
        carried: Carried { order, kind: Kind::VertexTriangle, key: NO_KEY, force: [zero; 3], solved: None },
        nodes,
        weights,
        contact: Contact { normal, gap, thickness, friction, grip: zero, advance: zero, mobility: zero },
        impulse: [zero; 3],
    }
}

/// A vertex on the wrong side of a triangle, or just back, as a contact that leads it to the side where it belongs: where the
/// normal points (above), or the other. `x` are all positions [m], and `weights` those of the closest points.
pub(super) fn back<T: Real>(
    x: [&[T]; 3],
    pair: &Close<T>,
    weights: [T; 4],
    above: bool,
) -> Option<Active<T>> {
    let at = |node: u32| x.map(|column| column[node as usize]);
    let [v, a, b, c] = pair.nodes.map(at);
    let normal = cross(sub(b, a), sub(c, a));
    let length = norm(normal);
    if length <= T::TINY {
        return None;
    }
    let normal = scale(normal, if above { T::ONE } else { -T::ONE } / length);
    let gap = dot(normal, sub(v, a)) - pair.thickness;
    Some(leads(pair.nodes, weights, [normal, [gap, pair.thickness, T::ZERO]]))
}
