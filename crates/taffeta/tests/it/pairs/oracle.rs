//! The engine against every pair in plain loops, in 64 bits.

use super::{cloud, random, set_velocities, touch, velocities};
use crate::common::{V, add, build, dot, farthest, norm, positions, run, scale, sub};
use taffeta::scene::{Scene, SelfCollision};

const H: f64 = 0.002;
const GRAVITY: V = [0.3, -2.0, 0.1];

/// A node of the second opinion.
#[derive(Clone)]
struct Node {
    x: V,
    v: V,
    mass: f64,
    how: SelfCollision,
}

/// Change of momentum and of mass times place that `a` gets from `b`, where they have so many contacts.
fn exchange(a: &Node, b: &Node, contacts: [usize; 2]) -> (V, V) {
    let thickness = (a.how.thickness + b.how.thickness) / 2.0;
    let friction = (a.how.friction * b.how.friction).sqrt();
    let e = a.how.restitution.max(b.how.restitution);
    let way = sub(a.x, b.x);
    let missing = thickness - norm(way);
    let line = scale(way, 1.0 / norm(way));
    let relative = sub(a.v, b.v);
    let before = dot(relative, line);
    // What the impact makes of it: a bounce, or the speed that makes up for a fifth of what was missing already.
    let fresh = (-before * H).max(0.0).min(missing);
    let release = (1.0 - e) * (0.2 * (missing - fresh)).min(thickness * H / 0.02) / H;
    let after = before.max(-e * before).max(release);
    let slip = sub(relative, scale(line, before));
    let stopped = (friction * (after - before)).min(norm(slip));
    let rubbed = if stopped > 0.0 { scale(slip, -stopped / norm(slip)) } else { [0.0; 3] };
    let apart = (1.0 - e) * fresh + (e * (0.5 * missing).min(thickness * H / 0.02) - H * after).max(0.0);
    // Each contact has its share of the node's mass.
    let inverse = [a.mass, b.mass].iter().zip(contacts).map(|(m, n)| n as f64 / m).sum::<f64>();
    let impulse = add(scale(line, after - before), rubbed);
    let shift = add(scale(line, apart), scale(rubbed, H));
    (scale(impulse, 1.0 / inverse), scale(shift, 1.0 / inverse))
}

/// A step; returns how many pairs touch.
fn step(nodes: &mut [Node]) -> usize {
    for node in nodes.iter_mut() {
        node.v = add(node.v, scale(GRAVITY, H));
        node.x = add(node.x, scale(node.v, H));
    }
    let before = nodes.to_vec();
    let touches = |i: usize, j: usize| {
        let [a, b]: [&Node; 2] = [&before[i], &before[j]];
        i != j && norm(sub(a.x, b.x)) < (a.how.thickness + b.how.thickness) / 2.0
    };
    let of: Vec<Vec<usize>> =
        (0..before.len()).map(|i| (0..before.len()).filter(|&j| touches(i, j)).collect()).collect();
    for (i, others) in of.iter().enumerate() {
        for &j in others {
            let (impulse, shift) = exchange(&before[i], &before[j], [others.len(), of[j].len()]);
            nodes[i].v = add(nodes[i].v, scale(impulse, 1.0 / nodes[i].mass));
            nodes[i].x = add(nodes[i].x, scale(shift, 1.0 / nodes[i].mass));
        }
    }
    of.iter().map(Vec::len).sum::<usize>() / 2
}

#[test]
fn nodes_do_to_each_other_what_plain_loops_say() {
    for (e, friction) in [(0.0, 0.0), (0.0, 0.6), (0.5, 0.3), (1.0, 0.1)] {
        let mut number = random(9);
        let mut nodes = Vec::new();
        let mut scene = Scene::new("oracle").time(H, H);
        scene.world.gravity = GRAVITY;
        for (name, mass, thickness) in [("light", 0.02, 0.08), ("heavy", 0.3, 0.12)] {
            let how = touch(thickness, friction, e);
            let x: Vec<V> = (0..60).map(|_| std::array::from_fn(|_| 0.4 * number())).collect();
            scene = scene.body(cloud(name, &x, mass, how.clone()));
            nodes.extend(x.into_iter().map(|x| {
                let v = std::array::from_fn(|axis| 3.0 * (0.2 - x[axis]) + number() - 0.5);
                Node { x, v, mass, how: how.clone() }
            }));
        }
        let mut simulation = build(&scene);
        let v: Vec<V> = nodes[..60].iter().map(|node| node.v).collect();
        let w: Vec<V> = nodes[60..].iter().map(|node| node.v).collect();
        set_velocities(&mut simulation, &[&v[..], &[[0.0; 3]], &w[..]].concat());
        for frame in 1..=25 {
            run(&mut simulation, 1);
            let pairs = step(&mut nodes);
            let free = |all: Vec<V>| [&all[..60], &all[61..121]].concat();
            let [x, v] = [positions(&simulation), velocities(&simulation)].map(free);
            let apart = farthest(&x, &nodes.iter().map(|node| node.x).collect::<Vec<_>>());
            let slower = farthest(&v, &nodes.iter().map(|node| node.v).collect::<Vec<_>>());
            assert!(pairs > 30, "{pairs}");
            assert_eq!(simulation.report().pairs, pairs as u64, "e = {e}, frame {frame}");
            assert!(apart < 1e-10 && slower < 1e-8, "e = {e}, frame {frame}: {apart:e} m, {slower:e} m/s");
        }
    }
}
