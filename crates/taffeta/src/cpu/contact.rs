//! Contact of a run of nodes with all colliders, one collider after the other over the whole run.

use super::simd::{Kernel, SimdLevel};
use crate::collision::contact::{leave_both, respond};
use crate::collision::shape::{ColliderNow, ShapeNow, Solid, Touching};
use crate::real::{Real, add};

/// Keeps free nodes out of all colliders and returns how many touched one. `state` is position and velocity by axis;
/// `last` is room for one number a node.
///
/// Colliders act in the scene's order. A node that one has pushed into another is then moved out of both, without a
/// further change of velocity.
pub fn contact<T: Real>(
    level: SimdLevel,
    colliders: &[ColliderNow<T>],
    inverse_mass: &[T],
    state: &mut [&mut [T]; 6],
    last: &mut [u32],
    h: T,
) -> u64 {
    last.fill(0);
    let mut touches = 0;
    for (index, collider) in (1..).zip(colliders) {
        let [x, y, z, ..] = &*state;
        if level.run(Inside { collider, place: [x, y, z], last: None }) > 0 {
            level.run(Respond { collider, index, inverse_mass, state: &mut *state, last: &mut *last, h });
            touches += 1;
        }
    }
    if touches == 0 {
        return 0;
    }
    if colliders.len() > 1 {
        part(level, colliders, state, last);
    }
    last.iter().map(|&last| u64::from(last > 0)).sum()
}

/// Moves nodes that have touched a collider, and are now inside another, out of both.
fn part<T: Real>(level: SimdLevel, colliders: &[ColliderNow<T>], state: &mut [&mut [T]; 6], last: &[u32]) {
    let [x, y, z, ..] = state;
    let place: [&[T]; 3] = [x, y, z];
    let pressed = (1..)
        .zip(colliders)
        .any(|(index, collider)| level.run(Inside { collider, place, last: Some((last, index)) }) > 0);
    if pressed {
        let inside_another = |node: usize| {
            let place = [x[node], y[node], z[node]];
            let other = |&(index, _): &(u32, &ColliderNow<T>)| last[node] > 0 && index != last[node];
            (1..)
                .zip(colliders)
                .filter(other)
                .any(|(_, collider)| collider.depth_and_normal(place).0 > T::ZERO)
        };
        let nodes: Vec<usize> = (0..last.len()).filter(|&node| inside_another(node)).collect();
        for node in nodes {
            let moved = push_out(colliders, [x[node], y[node], z[node]]);
            [x[node], y[node], z[node]] = moved;
        }
    }
}

/// Moves a place out of all colliders. In a wedge, going out of one collider goes into the other; so the two that
/// press most are left together.
fn push_out<T: Real>(colliders: &[ColliderNow<T>], mut x: [T; 3]) -> [T; 3] {
    for _ in 0..ROUNDS {
        let mut most = [(-T::FAR, [T::ZERO; 3]); 2];
        for collider in colliders {
            let pressing = collider.depth_and_normal(x);
            if pressing.0 > most[0].0 {
                most = [pressing, most[0]];
            } else if pressing.0 > most[1].0 {
                most[1] = pressing;
            }
        }
        if most[0].0 <= T::ZERO {
            break;
        }
        x = add(x, leave_both(most[0], most[1]));
    }
    x
}

/// Rounds in which a place leaves a wedge between curved colliders: each halves the number of wrong digits.
pub const ROUNDS: usize = 12;

/// Kernel: how many nodes are inside a collider; with `last`, only those that touched another one last. A NaN is not.
struct Inside<'a, T> {
    collider: &'a ColliderNow<T>,
    place: [&'a [T]; 3],
    last: Option<(&'a [u32], u32)>,
}

impl<T: Real> Kernel for Inside<'_, T> {
    type Output = u32;
    #[inline(always)]
    fn run(self) -> u32 {
        match (self.collider.shape, self.last) {
            (ShapeNow::Sphere(sphere), None) => inside(sphere, self.place),
            (ShapeNow::Plane(plane), None) => inside(plane, self.place),
            (ShapeNow::Sphere(sphere), Some((last, index))) => {
                inside_another(sphere, self.place, last, index)
            }
            (ShapeNow::Plane(plane), Some((last, index))) => inside_another(plane, self.place, last, index),
        }
    }
}

#[inline(always)]
fn inside<T: Real>(solid: impl Solid<T>, [x, y, z]: [&[T]; 3]) -> u32 {
    let n = x.len();
    let (y, z) = (&y[..n], &z[..n]);
    let mut count = 0;
    for i in 0..n {
        count += u32::from(solid.depth_and_normal([x[i], y[i], z[i]]).0 > T::ZERO);
    }
    count
}

#[inline(always)]
fn inside_another<T: Real>(solid: impl Solid<T>, [x, y, z]: [&[T]; 3], last: &[u32], index: u32) -> u32 {
    let n = x.len();
    let (y, z, last) = (&y[..n], &z[..n], &last[..n]);
    let mut count = 0;
    for i in 0..n {
        let other = (last[i] != 0) & (last[i] != index);
        count += u32::from(other & (solid.depth_and_normal([x[i], y[i], z[i]]).0 > T::ZERO));
    }
    count
}

/// Kernel: the response of all nodes to one collider.
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
        let Self { collider, index, inverse_mass, state: [x, y, z, u, v, w], last, h } = self;
        let (touching, mark) = (&collider.touching, (last, index));
        match collider.shape {
            ShapeNow::Sphere(sphere) => {
                respond_all(sphere, touching, inverse_mass, (x, y, z), (u, v, w), mark, h)
            }
            ShapeNow::Plane(plane) => {
                respond_all(plane, touching, inverse_mass, (x, y, z), (u, v, w), mark, h)
            }
        }
    }
}

/// Three columns that are written.
type Written<'a, T> = (&'a mut [T], &'a mut [T], &'a mut [T]);

#[inline(always)]
fn respond_all<T: Real>(
    solid: impl Solid<T>,
    touching: &Touching<T>,
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
        let (moved, after) = respond(place, velocity, &touching.touch(place, (depth, normal)), h);
        x[i] = if touches { moved[0] } else { place[0] };
        y[i] = if touches { moved[1] } else { place[1] };
        z[i] = if touches { moved[2] } else { place[2] };
        u[i] = if touches { after[0] } else { velocity[0] };
        v[i] = if touches { after[1] } else { velocity[1] };
        w[i] = if touches { after[2] } else { velocity[2] };
        last[i] = if touches { index } else { last[i] };
    }
}
