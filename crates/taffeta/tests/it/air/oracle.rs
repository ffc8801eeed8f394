//! A crumpled sheet against the formula written once more: by angles, and with the step's equations solved as such.

use super::{AIR, blown};
use crate::common::state::{any, noise, set, state};
use crate::common::{V, add, build, cross, dot, norm, run, scale, sub};
use std::sync::Arc;
use taffeta::scene::{Body, Mass, Mesh};
use taffeta::topology::Surface;
use taffeta::topology::shapes::grid_surface;

/// Impulse [N·s] of the air on a triangle of mass `mass` [kg] in the flow `w`, over a step.
fn impulse([a, b, c]: [V; 3], w: V, mass: f64, h: f64) -> V {
    let normal = cross(sub(b, a), sub(c, a));
    let (area, speed) = (0.5 * norm(normal), norm(w));
    let along = scale(w, 1.0 / speed);
    // The side to which the flow presses.
    let normal = scale(normal, dot(normal, w).signum() / norm(normal));
    let attack = dot(normal, along).asin();
    let up = sub(normal, scale(along, attack.sin()));
    let up = scale(up, 1.0 / norm(up));
    let rate = h * 0.5 * 1.3 * area * speed / mass;
    let (d, l) = (rate * 1.1 * attack.sin(), rate * 0.9 * attack.sin() * attack.cos());
    // Up to a half the flow is as it is, from one on as it will be.
    let share = (2.0 - 1.0 / d.hypot(l)).clamp(0.0, 1.0);
    // [1 + βd, -βl; βl, 1 + βd] · (forward, aside) = (speed, 0), by Cramer's rule, is the flow that counts.
    let (d, l) = (share * d, share * l);
    let determinant = (1.0 + d) * (1.0 + d) + l * l;
    let (forward, aside) = (speed * (1.0 + d) / determinant, -speed * l / determinant);
    let (drag, lift) = (rate * 1.1 * attack.sin(), rate * 0.9 * attack.sin() * attack.cos());
    let forced = add(scale(along, drag * forward - lift * aside), scale(up, drag * aside + lift * forward));
    scale(forced, mass)
}

fn check(surface: &Surface, mesh: Mesh, h: f64) {
    let body = Body::cloth("sheet", mesh).with_mass(Mass::Area(0.3));
    let mut simulation = build(&blown(body, AIR, h));
    let mut random = noise(5);
    let (rest, _) = state(&simulation);
    let x: Vec<V> = rest.iter().map(|x| add(*x, scale(any(&mut random), 0.1))).collect();
    let v: Vec<V> = rest.iter().map(|_| scale(any(&mut random), 4.0)).collect();
    set(&mut simulation, &x, &v);
    run(&mut simulation, 1);
    let (_, after) = state(&simulation);
    let (mut given, mut mass) = (vec![[0.0; 3]; x.len()], vec![0.0; x.len()]);
    for triangle in &surface.triangles {
        let corners = triangle.map(|node| node as usize);
        let [a, b, c] = corners.map(|node| rest[node]);
        let own = 0.3 * 0.5 * norm(cross(sub(b, a), sub(c, a)));
        let mean = scale(corners.iter().fold([0.0; 3], |sum, &node| add(sum, v[node])), 1.0 / 3.0);
        let third = scale(impulse(corners.map(|node| x[node]), sub(AIR.velocity, mean), own, h), 1.0 / 3.0);
        for node in corners {
            given[node] = add(given[node], third);
            mass[node] += own / 3.0;
        }
    }
    for node in 0..x.len() {
        let wanted = add(v[node], scale(given[node], 1.0 / mass[node]));
        assert!(norm(sub(after[node], wanted)) < 1e-12, "{node}: {:?}, expected {wanted:?}", after[node]);
    }
}

#[test]
fn a_crumpled_sheet_gets_the_sum_of_what_its_triangles_get() {
    for h in [1e-4, 0.01, 1.0] {
        for [rows, cols] in [[5, 4], [2, 40], [37, 70]] {
            let surface = grid_surface(rows, cols, [0.5, 0.4]);
            check(&surface, Mesh::grid(rows, cols, [0.5, 0.4]), h);
            check(&surface, Mesh::Surface(Arc::new(surface.clone())), h);
        }
    }
}

#[test]
fn it_does_not_matter_which_way_around_triangles_are() {
    let surface = grid_surface(9, 7, [0.5, 0.4]);
    let mut turned = surface.clone();
    turned.triangles.iter_mut().step_by(2).for_each(|[_, b, c]| std::mem::swap(b, c));
    check(&surface, Mesh::Surface(Arc::new(turned)), 0.01);
}
