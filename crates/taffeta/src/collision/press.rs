//! Surfaces that bear what constraints press against them.
//!
//! Contact comes after forces: a solver that does not know of it lets nodes on a surface go where they are pulled, finds
//! their pulls relaxed, and contact puts the nodes back under full tension. That is work from nowhere. So nodes that will
//! be pressed against a surface are held by it while pulls are solved for: along its normal, or, where friction is enough,
//! in all directions (after Baraff and Witkin, "Large Steps in Cloth Simulation", SIGGRAPH 1998, section 5).

use super::contact::rub;
use super::moving::{ColliderNow, Touching};
use crate::real::{Real, add, dot, norm, scale, sub};

/// How a surface holds a node in a sub-step.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Press<T> {
    /// Unit normal along which the node does not yield; 0: free.
    pub normal: [T; 3],
    /// Share of what is left in which it yields: 1; 0 where it sticks.
    pub yields: T,
    /// Velocity [m/s] of the directions in which it does not: onto the surface, and with it.
    pub velocity: [T; 3],
}

/// A node as it comes to a surface.
#[derive(Clone, Copy, Debug)]
pub struct Coming<T> {
    /// Place at the start of the sub-step [m].
    pub place: [T; 3],
    /// Velocity [m/s] without pulls, and change of it by those of the last sub-step.
    pub free: [T; 3],
    pub pulls: [T; 3],
    /// Way that gravity goes in a sub-step [m].
    pub fall: T,
    /// Sub-step [s].
    pub h: T,
}

impl<T: Real> Press<T> {
    /// Of a node that nothing holds.
    pub const FREE: Self = Self { normal: [T::ZERO; 3], yields: T::ONE, velocity: [T::ZERO; 3] };

    /// How a collider will hold a node: it is on the surface, or gets there without pulls, and those of the last sub-step do
    /// not take it off. The number is by how much it would be inside [m]; `None`: not held.
    #[inline(always)]
    pub fn of(collider: &ColliderNow<T>, node: &Coming<T>) -> Option<(T, Self)> {
        let v = add(node.free, node.pulls);
        let (inside, _) = collider.depth_and_normal(add(node.place, scale(v, node.h)))?;
        Self::by(&collider.touching, node, inside, collider.depth_and_normal(node.place)?)
    }

    /// How a surface of triangles will hold a node; it is taken to be as flat as where the node is.
    #[inline(always)]
    pub fn of_mesh(touching: &Touching<T>, node: &Coming<T>, touch: (T, [T; 3])) -> Option<(T, Self)> {
        let inside = touch.0 - node.h * dot(add(node.free, node.pulls), touch.1);
        Self::by(touching, node, inside, touch)
    }

    /// How a surface will hold a node that is so deep in it, and would be so far `inside` [m].
    #[inline(always)]
    fn by(
        touching: &Touching<T>,
        node: &Coming<T>,
        inside: T,
        (depth, normal): (T, [T; 3]),
    ) -> Option<(T, Self)> {
        let h = node.h;
        let v = add(node.free, node.pulls);
        let way = -h * dot(node.free, normal);
        let reach = if way > T::ZERO { way + node.fall } else { node.fall };
        if !(inside > T::ZERO && -depth <= reach) {
            return None;
        }
        let touch = touching.touch(node.place, (depth, normal));
        let landing = depth / h;
        let relative = sub(v, touch.surface_velocity);
        let impulse = landing - dot(v, normal);
        let slip = norm(sub(relative, scale(normal, dot(relative, normal))));
        let sticks = slip <= touch.friction * impulse;
        let along = sub(touch.surface_velocity, scale(normal, dot(touch.surface_velocity, normal)));
        let onto = scale(normal, landing);
        let press = if sticks {
            Self { normal, yields: T::ZERO, velocity: add(onto, along) }
        } else {
            Self { normal, yields: T::ONE, velocity: onto }
        };
        Some((inside, press))
    }

    /// How the collider in which a node would be deepest will hold it, and which that is. `of` is [`Self::of`], or knows of
    /// meshes.
    #[inline(always)]
    pub fn deepest(
        colliders: &[ColliderNow<T>],
        mut of: impl FnMut(&ColliderNow<T>) -> Option<(T, Self)>,
    ) -> (Self, u32) {
        let (mut deepest, mut found) = (T::ZERO, (Self::FREE, 0));
        for (collider, index) in colliders.iter().zip(0..) {
            if let Some((inside, press)) = of(collider).filter(|&(inside, _)| inside > deepest) {
                (deepest, found) = (inside, (press, index));
            }
        }
        found
    }

    /// A change of velocity, as far as the node yields to it.
    #[inline(always)]
    pub fn yielded(&self, v: [T; 3]) -> [T; 3] {
        scale(sub(v, scale(self.normal, dot(v, self.normal))), self.yields)
    }

    /// Velocity [m/s] of the node after `pulls`; `free` is without them. What they press, the surface bears, and friction
    /// comes with it: where it was enough, the node stays. What takes the node off lets it go no further than onto the
    /// surface: the next sub-step knows these pulls.
    #[inline(always)]
    pub fn after(&self, free: [T; 3], pulls: [T; 3], collider: &ColliderNow<T>, place: [T; 3]) -> [T; 3] {
        if self.normal == [T::ZERO; 3] {
            return add(free, pulls);
        }
        let normal = self.normal;
        let landing = dot(self.velocity, normal);
        let (inward, pulled) = (dot(free, normal), dot(add(free, pulls), normal));
        let least = if inward < landing { inward } else { landing };
        let kept = if pulled < least { least } else { pulled };
        let kept = if kept > landing { landing } else { kept };
        if self.yields == T::ZERO {
            return add(self.velocity, scale(normal, kept - landing));
        }
        let moved = add(add(free, pulls), scale(normal, kept - pulled));
        let impulse = if kept > pulled { kept - pulled } else { T::ZERO };
        let touching = &collider.touching;
        let surface = touching.touch(place, (T::ZERO, normal)).surface_velocity;
        add(moved, rub(sub(moved, surface), normal, touching.friction * impulse))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::collision::moving::MovingCollider;
    use crate::scene::Collider;

    fn floor(friction: f64) -> ColliderNow<f64> {
        let floor = Collider::plane([0.0; 3], [0.0, 1.0, 0.0]).offset(0.0).friction(friction);
        MovingCollider::new(&floor).unwrap().at(0.0, 0.01, &mut 0)
    }

    fn coming(y: f64, pulls: [f64; 3]) -> Coming<f64> {
        Coming { place: [0.0, y, 0.0], free: [0.0, -0.1, 0.0], pulls, fall: 1e-3, h: 0.01 }
    }

    #[test]
    fn a_node_is_held_where_it_lies_and_is_not_taken_off() {
        let press = |y, pulls| Press::of(&floor(0.5), &coming(y, pulls));
        assert!(press(0.0, [0.0; 3]).is_some());
        // Pulls that lift it, and pulls that would fetch it from afar.
        assert!(press(0.0, [0.0, 0.2, 0.0]).is_none());
        assert!(press(0.1, [0.0, -50.0, 0.0]).is_none());
        // 0.1 m/s press, half of it is friction.
        assert_eq!(press(0.0, [0.04, 0.0, 0.0]).unwrap().1.yields, 0.0);
        assert_eq!(press(0.0, [0.06, 0.0, 0.0]).unwrap().1.yields, 1.0);
        // It lands: half a millimetre in 0.01 s.
        assert!((press(0.0005, [0.0; 3]).unwrap().1.velocity[1] + 0.05).abs() < 1e-15);
    }

    #[test]
    fn a_surface_bears_pulls_and_rubs_as_much() {
        let node = coming(0.0, [0.5, 0.0, 0.0]);
        let (_, press) = Press::of(&floor(0.5), &node).unwrap();
        let after = |pulls| press.after(node.free, pulls, &floor(0.5), node.place);
        // 0.4 m/s more are pressed: 0.2 m/s less along it; contact takes the rest.
        assert!(norm(sub(after([0.5, -0.4, 0.0]), [0.3, -0.1, 0.0])) < 1e-15);
        // What would take it off leaves it on the surface.
        assert!(norm(sub(after([0.5, 0.7, 0.0]), [0.5, 0.0, 0.0])) < 1e-15);
    }

    #[test]
    fn a_node_yields_along_the_surface_alone() {
        let (_, press) = Press::of(&floor(0.0), &coming(0.0, [1.0, 0.0, 0.0])).unwrap();
        assert_eq!(press.yielded([1.0, 2.0, 3.0]), [1.0, 0.0, 3.0]);
        assert_eq!(Press::FREE.yielded([1.0, 2.0, 3.0]), [1.0, 2.0, 3.0]);
    }
}
