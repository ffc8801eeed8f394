//! The reference itself: pairs of nodes by hand, and what backward Euler is by definition.

use super::{any, newton, noise};
use crate::common::primal::{ZERO, block, pull, unit};
use crate::common::reference::{Reference, Spring};
use crate::common::{V, add, dot, near, norm, scale, sub};
use taffeta::scene::Method;

/// Some nodes joined at random, stretched, in motion; the first one is held.
fn net(stretch: f64, newton_steps: u32) -> Reference {
    let mut random = noise(9);
    let x: Vec<V> = (0..9).map(|_| any(&mut random)).collect();
    let mass = (0..9).map(|n| 0.1 + 0.05 * f64::from(n)).collect();
    let mut net = Reference::new(x, mass);
    net.solver.method = Method::Ice;
    net.solver.ice = newton(newton_steps);
    for (a, b) in (0..9).flat_map(|a| (a + 1..9).map(move |b| (a, b))).filter(|(a, b)| (a * b) % 3 != 1) {
        let rest = norm(sub(net.x[b], net.x[a])) / stretch;
        net.springs.push(Spring(a, b, 20.0 + 3.0 * (a + b) as f64, 0.1 * b as f64, rest));
    }
    net.v = (0..9).map(|_| any(&mut random)).collect();
    net.v[0] = [0.0; 3];
    net.held.insert(0);
    net
}

/// Velocity of the second of two nodes, the first of which is held, a step after it was at `x` and at rest, or had `v`
/// along; forces other than the spring's would give it `free`.
fn after(x: V, [v, free]: [V; 2], spring: Spring, newton_steps: u32, h: f64) -> V {
    let mut pair = Reference::new(vec![[0.0; 3], x], vec![1.0, 0.5]);
    pair.solver.method = Method::Ice;
    pair.solver.ice = newton(newton_steps);
    pair.held.insert(0);
    pair.v[1] = v;
    pair.gravity = scale(sub(free, v), 1.0 / h);
    pair.springs.push(spring);
    pair.step(h);
    pair.v[1]
}

#[test]
fn an_oscillator_along_its_spring_is_that_of_backward_euler() {
    // u' = (u − w h k (l − L))/(1 + w h (h k + d)), whatever the number of steps: in one direction springs are linear.
    let (h, k, d, w) = (0.02, 300.0, 0.4, 2.0);
    for steps in 1..4 {
        for (length, u) in [(1.3, 0.2), (0.8, -0.1)] {
            let v = after(
                [0.0, length, 0.0],
                [[0.0, u - 0.3, 0.0], [0.0, u, 0.0]],
                Spring(0, 1, k, d, 1.0),
                steps,
                h,
            );
            let expected = (u - w * h * k * (length - 1.0)) / (1.0 + w * h * (h * k + d));
            near("along", v[1], expected, 1e-14);
            near("across", v[0].hypot(v[2]), 0.0, 1e-16);
        }
    }
}

#[test]
fn across_a_spring_what_pulls_holds_back_and_so_does_what_presses() {
    // u' = u/(1 + w h² g) with g = |T|/l, at most k.
    let (h, k, w) = (0.02, 300.0, 2.0);
    for (length, g) in [(1.5, 100.0), (0.8, 75.0), (1.0, 0.0), (0.25, 300.0)] {
        let v = after([0.0, length, 0.0], [[0.0; 3], [0.7, 0.0, 0.0]], Spring(0, 1, k, 0.4, 1.0), 1, h);
        near("across", v[0], 0.7 / (1.0 + w * h * h * g), 1e-14);
    }
}

#[test]
fn the_second_step_starts_where_the_first_one_ends() {
    // At right angles: l = 1.3 at rest, the first step turns it, the second is linearised there.
    let (h, k, d, w, rest) = (0.1, 50.0, 0.3, 2.0, 1.0);
    let spring = || Spring(0, 1, k, d, rest);
    let (x, v) = ([1.3, 0.0, 0.0], [0.0, 2.0, 0.0]);
    let from_rest = [[0.0; 3], v];
    let g = k * 0.3 / 1.3;
    let first = [-w * h * k * 0.3 / (1.0 + w * h * (h * k + d)), 2.0 / (1.0 + w * h * h * g)];
    let got = after(x, from_rest, spring(), 1, h);
    near("first", got[0], first[0], 1e-14);
    near("first", got[1], first[1], 1e-14);
    // Two unknowns: (m + B) δ = m (v − u) − h (k (l − L) + d u·n) n.
    let place = [1.3 + h * first[0], h * first[1]];
    let l = place[0].hypot(place[1]);
    let n = place.map(|c| c / l);
    let force = k * (l - rest) + d * (n[0] * first[0] + n[1] * first[1]);
    let (g, stiff) = (k * (l - rest).abs() / l, h * h * k + h * d);
    let b =
        |i: usize, j: usize| (stiff - h * h * g) * n[i] * n[j] + if i == j { h * h * g + 0.5 } else { 0.0 };
    let right = [0, 1].map(|i| 0.5 * (v[i] - first[i]) - h * force * n[i]);
    let determinant = b(0, 0) * b(1, 1) - b(0, 1) * b(1, 0);
    let change = [
        (right[0] * b(1, 1) - right[1] * b(0, 1)) / determinant,
        (right[1] * b(0, 0) - right[0] * b(1, 0)) / determinant,
    ];
    let got = after(x, from_rest, spring(), 2, h);
    near("second", got[0], first[0] + change[0], 1e-14);
    near("second", got[1], first[1] + change[1], 1e-14);
}

#[test]
fn the_block_of_a_stretched_spring_is_the_derivative_of_its_force() {
    let (spring, h, apart) = (Spring(0, 1, 70.0, 0.0, 0.9), 1.0, [0.7, -0.5, 0.9]);
    let b = block(apart, &spring, h);
    for axis in 0..3 {
        let moved = |by: f64| {
            let mut apart = apart;
            apart[axis] += by;
            pull(apart, [0.0; 3], &spring)
        };
        let slope = scale(sub(moved(1e-5), moved(-1e-5)), 0.5e5);
        for i in 0..3 {
            near("slope", b[i][axis], slope[i], 1e-8);
        }
    }
    // Damping adds its own along the spring.
    let damped = block(apart, &Spring(0, 1, 70.0, 2.0, 0.9), h);
    let n = scale(apart, 1.0 / norm(apart));
    for (i, j) in (0..3).flat_map(|i| (0..3).map(move |j| (i, j))) {
        near("damping", damped[i][j] - b[i][j], 2.0 * n[i] * n[j], 1e-13);
    }
}

/// How far velocities are from those of backward Euler, m (u − v*) = h f(x + h u, u), by the largest of f's.
fn off(before: &Reference, u: &[V], h: f64) -> f64 {
    let x: Vec<V> = before.x.iter().zip(u).map(|(&x, &u)| add(x, scale(u, h))).collect();
    let mut forces = vec![[0.0; 3]; u.len()];
    for spring in &before.springs {
        let (a, b) = (spring.0, spring.1);
        let force = pull(sub(x[b], x[a]), sub(u[b], u[a]), spring);
        (forces[a], forces[b]) = (add(forces[a], force), sub(forces[b], force));
    }
    let most = forces.iter().map(|&f| norm(f)).fold(0.0, f64::max);
    (1..u.len())
        .map(|n| norm(sub(scale(sub(u[n], before.v[n]), before.mass[n] / h), forces[n])) / most)
        .fold(0.0, f64::max)
}

#[test]
fn many_steps_end_at_backward_euler_and_few_come_near_it_fast() {
    // Stretched throughout and undamped, all blocks are exact derivatives and Newton doubles the digits.
    let h = 0.05;
    let left = [1, 2, 3, 4, 5].map(|steps| {
        let mut net = net(1.5, steps);
        net.springs.iter_mut().for_each(|spring| spring.3 = 0.0);
        let before = Reference::new(net.x.clone(), net.mass.clone());
        let before = Reference { v: net.v.clone(), springs: std::mem::take(&mut net.springs), ..before };
        net.springs = before.springs.iter().map(|s| Spring(s.0, s.1, s.2, s.3, s.4)).collect();
        net.step(h);
        off(&before, &net.v, h)
    });
    assert!(left[0] > 1e-4 && left[1] < left[0].powf(1.8) && left[2] < left[1].powf(1.8), "{left:?}");
    assert!(left[4] < 1e-13, "{left:?}");
}

#[test]
fn damping_and_pressure_change_the_way_and_not_the_end() {
    let (h, steps) = (0.01, 60);
    let mut net = net(0.9, steps);
    let before = Reference::new(net.x.clone(), net.mass.clone());
    let springs = net.springs.iter().map(|s| Spring(s.0, s.1, s.2, s.3, s.4)).collect();
    let before = Reference { v: net.v.clone(), springs, ..before };
    net.step(h);
    let off = off(&before, &net.v, h);
    assert!(off < 1e-12, "{off:e}");
}

#[test]
fn what_does_not_yield_stays_and_what_slides_stays_in_its_plane() {
    let net = net(1.3, 2);
    let normal = scale([1.0, -2.0, 2.0], 1.0 / 3.0);
    let plane: [V; 3] =
        std::array::from_fn(|i| std::array::from_fn(|j| f64::from(u8::from(i == j)) - normal[i] * normal[j]));
    let mut yields = vec![unit(1.0); 9];
    (yields[0], yields[4], yields[7]) = (ZERO, ZERO, plane);
    let free = net.v.clone();
    let mut held = free.clone();
    (held[4], held[7]) = ([0.1, 0.2, -0.3], scale(normal, 0.7));
    let motion = net.backward(&free, &held, &yields, 0.01);
    near("held", norm(sub(motion.v[4], held[4])) + norm(sub(motion.v[0], free[0])), 0.0, 1e-15);
    near("across the plane", dot(motion.v[7], normal), 0.7, 1e-14);
    // Nodes that nothing holds go where pulls take them.
    for n in [1, 2, 3, 5, 6, 8] {
        near("changes", norm(sub(sub(motion.v[n], free[n]), motion.changes[n])), 0.0, 1e-13);
    }
    assert!(norm(motion.changes[4]) > 1e-3 && dot(motion.changes[7], normal).abs() > 1e-3);
}
