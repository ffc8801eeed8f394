//! Predicted contact: surfaces that support nodes while constraints are solved.
//!
//! Contact is resolved after forces. A solver that does not know of it lets constraints pull nodes into a surface,
//! and finds their forces relaxed. Contact then puts the nodes back, the constraints are under full tension again,
//! and energy is gained. So the surface holds nodes that will be in contact while constraints are solved:
//! - along its normal, or in all directions if friction is sufficient (after Baraff and Witkin, "Large Steps in Cloth
//!   Simulation", SIGGRAPH 1998, section 5);
//! - if friction is not sufficient, it is an external force of the solve. Friction that is subtracted from the solved
//!   velocity would hold cloth that is pulled from far away, because stiff constraints make little velocity where
//!   neighbours lag behind.

use crate::contact::colliders::moving::{ColliderNow, ContactSurface};
use crate::contact::colliders::shape::positive;
use crate::real::{Real, add, dot, norm, scale, sub};

/// Predicted contact of a node in a sub-step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PredictedContact<T> {
    /// Unit normal of the surface; 0: no contact.
    pub normal: [T; 3],
    /// 1 if the node slides, or is free; 0 if it sticks.
    pub slides: T,
    /// Velocity [m/s]. Along the normal: the landing velocity. Along the surface: the surface's velocity if the node
    /// sticks, else the change by friction.
    pub velocity: [T; 3],
    /// Speed of the surface [m/s] in the direction in which the node slides.
    pub surface_speed: T,
}

/// Penetration of a position into a collider.
#[derive(Clone, Copy, Debug)]
pub struct Depth<T> {
    /// Depth [m].
    pub depth: T,
    /// Outward unit normal.
    pub normal: [T; 3],
    /// Velocity of the surface by a change of shape [m/s].
    pub velocity: [T; 3],
}

/// The motion of a node before a sub-step is solved.
#[derive(Clone, Copy, Debug)]
pub struct Approach<T> {
    /// Position at the start of the sub-step [m].
    pub position: [T; 3],
    /// Velocity [m/s] without constraints, and its change by the constraints of the last sub-step.
    pub free: [T; 3],
    pub solver_change: [T; 3],
    /// How far from a surface a node at rest counts as on it [m], by [`reach`].
    pub reach: T,
    /// Length of the sub-step [s].
    pub h: T,
}

/// A node sticks up to this fraction of the friction limit. Dragged cloth is pulled at about the friction limit at
/// every node. If some of the nodes stuck in each sub-step, none of them would move.
pub const STICKS: f64 = 0.95;
/// Fraction of the approach speed that is left to contact, so that contact sees the node. If it were 1, nodes that
/// one sub-step holds and the next one does not would jitter.
pub const LEFT_TO_CONTACT: f64 = 0.0625;

/// A node so near to a surface touches it [m]: where contact has put it may be off by a rounding.
pub const TOUCHES: f64 = 1e-6;

/// How far from a surface a node at rest counts as on it [m]: what it falls in a sub-step `h` [s], or [`TOUCHES`].
pub fn reach<T: Real>(gravity: [T; 3], h: T) -> T {
    let (fall, touches) = (norm(gravity) * h * h, T::from_f64(TOUCHES));
    if fall > touches { fall } else { touches }
}

/// The collider with the deepest contact, by `of`, which gives a depth and a value for each collider. Returns that
/// value and the collider's index.
#[inline(always)]
pub fn deepest<T: Real, P>(
    colliders: &[ColliderNow<T>],
    mut of: impl FnMut(&ColliderNow<T>) -> Option<(T, P)>,
) -> Option<(P, u32)> {
    let (mut deepest, mut found) = (T::ZERO, None);
    for (collider, index) in colliders.iter().zip(0..) {
        if let Some((inside, predicted)) = of(collider).filter(|&(inside, _)| inside > deepest) {
            (deepest, found) = (inside, Some((predicted, index)));
        }
    }
    found
}

impl<T: Real> PredictedContact<T> {
    /// No contact.
    pub const FREE: Self =
        Self { normal: [T::ZERO; 3], slides: T::ONE, velocity: [T::ZERO; 3], surface_speed: T::ZERO };

    /// Predicted contact with a convex collider, and the predicted depth [m]. A node is in contact if it is on the
    /// surface, or reaches it without constraints, and the constraint forces of the last sub-step do not lift it off.
    /// `None`: no contact.
    #[inline(always)]
    pub fn of(collider: &ColliderNow<T>, node: &Approach<T>) -> Option<(T, Self)> {
        let v = add(node.free, node.solver_change);
        let (inside, _) = collider.depth_and_normal(add(node.position, scale(v, node.h)))?;
        let (depth, normal) = collider.depth_and_normal(node.position)?;
        Self::at_surface(&collider.surface, node, inside, Depth { depth, normal, velocity: [T::ZERO; 3] })
    }

    /// Predicted contact with a mesh. Its surface counts as flat around the node.
    #[inline(always)]
    pub fn of_mesh(surface: &ContactSurface<T>, node: &Approach<T>, contact: Depth<T>) -> Option<(T, Self)> {
        let inside = contact.depth - node.h * dot(add(node.free, node.solver_change), contact.normal);
        Self::at_surface(surface, node, inside, contact)
    }

    /// Predicted contact with a surface, from the present penetration and the predicted depth `inside` [m].
    #[inline(always)]
    fn at_surface(
        surface: &ContactSurface<T>,
        node: &Approach<T>,
        inside: T,
        Depth { depth, normal, velocity }: Depth<T>,
    ) -> Option<(T, Self)> {
        let h = node.h;
        let v = add(node.free, node.solver_change);
        let way = -h * dot(node.free, normal);
        let reach = if way > T::ZERO { way + node.reach } else { node.reach };
        if !(inside > T::ZERO && -depth <= reach) {
            return None;
        }
        let contact = surface.contact_at(node.position, (depth, normal));
        let surface_v = add(contact.surface_velocity, velocity);
        // Contact pushes out a node that is inside already, and gives it no speed.
        let (onto, out) = (depth / h, dot(surface_v, normal));
        let landing = if onto < out { onto } else { out };
        let relative = sub(v, surface_v);
        let friction_limit = contact.friction * positive(landing - dot(v, normal));
        let slip = sub(relative, scale(normal, dot(relative, normal)));
        let speed = norm(slip);
        let predicted = if speed <= friction_limit * T::from_f64(STICKS) && friction_limit > T::ZERO {
            let along = sub(surface_v, scale(normal, dot(surface_v, normal)));
            Self {
                normal,
                slides: T::ZERO,
                velocity: add(scale(normal, landing), along),
                surface_speed: T::ZERO,
            }
        } else {
            let direction = scale(slip, T::ONE / if speed > T::ZERO { speed } else { T::ONE });
            let velocity = sub(scale(normal, landing), scale(direction, friction_limit));
            Self { normal, slides: T::ONE, velocity, surface_speed: dot(surface_v, direction) }
        };
        Some((inside, predicted))
    }

    /// Whether the node is in contact.
    #[inline(always)]
    pub fn in_contact(&self) -> bool {
        self.normal != [T::ZERO; 3]
    }

    /// The part of a velocity change in which the node is free to move.
    #[inline(always)]
    pub fn filtered(&self, v: [T; 3]) -> [T; 3] {
        scale(sub(v, scale(self.normal, dot(v, self.normal))), self.slides)
    }

    /// The velocity change [m/s] of a sliding node by friction.
    #[inline(always)]
    pub fn friction_change(&self) -> [T; 3] {
        scale(sub(self.velocity, scale(self.normal, dot(self.velocity, self.normal))), self.slides)
    }

    /// A rate of velocity [m/s²] in the directions in which the node is free to move, plus the contact's own.
    #[inline(always)]
    pub fn rate(&self, rate: [T; 3], h: T) -> [T; 3] {
        add(self.filtered(rate), scale(self.velocity, T::ONE / h))
    }

    /// The velocity [m/s] of a node that had the velocity `before` and moves with the surface.
    #[inline(always)]
    pub fn carried_velocity(&self, before: [T; 3]) -> [T; 3] {
        add(self.filtered(before), sub(self.velocity, self.friction_change()))
    }

    /// The velocity change [m/s] by `solver_change` in contact.
    #[inline(always)]
    pub fn with_contact(&self, free: [T; 3], solver_change: [T; 3], surface: &ContactSurface<T>) -> [T; 3] {
        sub(self.velocity_after(free, solver_change, surface), free)
    }

    /// The same for a force [N]; `kick` is the velocity change by unit force [s/kg].
    #[inline(always)]
    pub fn force_with_contact(
        &self,
        free: [T; 3],
        force: [T; 3],
        kick: T,
        surface: &ContactSurface<T>,
    ) -> [T; 3] {
        scale(self.with_contact(free, scale(force, kick), surface), T::ONE / kick)
    }

    /// The velocity [m/s] of the node after `solver_change`; `free` is the velocity without it. The surface supports
    /// what pushes the node into it. What lifts the node off moves it onto the surface at most: the next sub-step
    /// knows that force. If the node bounces, contact follows. Friction stops a sliding node and does not reverse it.
    /// The friction that contact will apply is left to contact.
    #[inline(always)]
    pub fn velocity_after(&self, free: [T; 3], solver_change: [T; 3], surface: &ContactSurface<T>) -> [T; 3] {
        if !self.in_contact() {
            return add(free, solver_change);
        }
        let normal = self.normal;
        let landing = dot(self.velocity, normal);
        let (inward, changed) = (dot(free, normal), dot(add(free, solver_change), normal));
        let least = if inward < landing { inward } else { landing };
        let kept = if changed < least { least } else { changed };
        let kept = if kept > landing { landing } else { kept };
        let kept = if surface.restitution == T::ZERO {
            landing - (landing - least) * T::from_f64(LEFT_TO_CONTACT)
        } else {
            kept
        };
        if self.slides == T::ZERO {
            return add(self.velocity, scale(normal, kept - landing));
        }
        let moved = add(add(free, solver_change), scale(normal, kept - changed));
        let friction = self.friction_change();
        let friction_limit = norm(friction);
        if friction_limit == T::ZERO {
            return moved;
        }
        // Opposite to the slip.
        let against = scale(friction, T::ONE / friction_limit);
        let slip = -self.surface_speed - dot(moved, against);
        let taken = if slip < friction_limit { slip } else { friction_limit };
        add(moved, scale(against, positive(taken - surface.friction * (landing - kept))))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::contact::colliders::moving::MovingCollider;
    use crate::scene::Collider;

    fn floor(friction: f64) -> ColliderNow<f64> {
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(friction);
        MovingCollider::new(&floor).unwrap().at(0.0, 0.01, &mut 0)
    }

    fn approach(y: f64, solver_change: [f64; 3]) -> Approach<f64> {
        Approach { position: [0.0, y, 0.0], free: [0.0, -0.1, 0.0], solver_change, reach: 1e-3, h: 0.01 }
    }

    #[test]
    fn a_node_is_held_where_it_lies_and_is_not_taken_off() {
        let predicted = |y, solver_change| PredictedContact::of(&floor(0.5), &approach(y, solver_change));
        assert!(predicted(0.0, [0.0; 3]).is_some());
        // Constraints lift the node, or would have to pull it from afar.
        assert!(predicted(0.0, [0.0, 0.2, 0.0]).is_none());
        assert!(predicted(0.1, [0.0, -50.0, 0.0]).is_none());
        // A normal impulse of 0.1 m/s: half of it is the friction limit, and the node sticks up to nearly that.
        assert_eq!(predicted(0.0, [0.047, 0.0, 0.0]).unwrap().1.slides, 0.0);
        assert_eq!(predicted(0.0, [0.048, 0.0, 0.0]).unwrap().1.slides, 1.0);
        assert_eq!(predicted(0.0, [0.06, 0.0, 0.0]).unwrap().1.slides, 1.0);
        // It lands: half a millimetre in 0.01 s.
        assert!((predicted(0.0005, [0.0; 3]).unwrap().1.velocity[1] + 0.05).abs() < 1e-15);
    }

    #[test]
    fn without_gravity_a_pressed_node_is_held_though_it_is_a_rounding_above_the_surface() {
        let reach = reach([0.0; 3], 0.01);
        let pressed = Approach { free: [0.0; 3], reach, ..approach(1e-8, [0.01, -0.1, 0.0]) };
        assert_eq!(PredictedContact::of(&floor(0.5), &pressed).unwrap().1.slides, 0.0);
        let apart = Approach { position: [0.0, 1e-5, 0.0], ..pressed };
        assert!(PredictedContact::of(&floor(0.5), &apart).is_none());
    }

    #[test]
    fn a_surface_bears_pulls_and_rubs_as_much() {
        let node = approach(0.0, [0.5, -0.4, 0.0]);
        let (_, predicted) = PredictedContact::of(&floor(0.5), &node).unwrap();
        let after = |solver_change| predicted.velocity_after(node.free, solver_change, &floor(0.5).surface);
        let (left, friction_limit) = (0.1 * LEFT_TO_CONTACT, 0.05 * LEFT_TO_CONTACT);
        // Friction takes half of 0.5 m/s, and contact takes some of it.
        assert!(norm(sub(predicted.friction_change(), [-0.25, 0.0, 0.0])) < 1e-15);
        assert!(norm(sub(after([0.5, -0.4, 0.0]), [0.25 + friction_limit, -left, 0.0])) < 1e-15);
        // A node that would be lifted off stays on the surface.
        assert!(norm(sub(after([0.5, 0.7, 0.0]), [0.25 + friction_limit, -left, 0.0])) < 1e-15);
        // It stops, and does not turn back.
        assert!(norm(sub(after([0.1, -0.4, 0.0]), [friction_limit, -left, 0.0])) < 1e-15);
        // If it bounces, 0.1 m/s and their friction are left to contact.
        let bouncing = ContactSurface { restitution: 0.5, ..floor(0.5).surface };
        let left = predicted.velocity_after(node.free, [0.5, -0.4, 0.0], &bouncing);
        assert!(norm(sub(left, [0.3, -0.1, 0.0])) < 1e-15);
    }

    #[test]
    fn a_surface_that_moves_takes_a_node_along() {
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(0.5);
        let belt = MovingCollider::new(&floor).unwrap().at::<f64>(0.0, 0.01, &mut 0);
        let node = approach(0.0, [0.0; 3]);
        let by = |speed| {
            let contact = Depth { depth: 0.0, normal: [0.0, 1.0, 0.0], velocity: [speed, 0.0, 0.0] };
            PredictedContact::of_mesh(&belt.surface, &node, contact).unwrap().1
        };
        assert_eq!((by(0.03).slides, by(0.03).velocity), (0.0, [0.03, 0.0, 0.0]));
        // Friction is half of the normal impulse, less the part of contact.
        let by_friction = [0.05 * (1.0 - LEFT_TO_CONTACT), -0.1 * LEFT_TO_CONTACT, 0.0];
        assert!(
            norm(sub(by(2.0).velocity_after(node.free, node.solver_change, &belt.surface), by_friction))
                < 1e-15
        );
    }

    #[test]
    fn a_node_yields_along_the_surface_alone() {
        let (_, predicted) = PredictedContact::of(&floor(0.0), &approach(0.0, [1.0, 0.0, 0.0])).unwrap();
        assert_eq!(predicted.filtered([1.0, 2.0, 3.0]), [1.0, 0.0, 3.0]);
        assert_eq!(PredictedContact::FREE.filtered([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    }
}
