//! Where a surface is, and which way leads out of it, at many places: against formulas of its own.

use super::reference::{Faces, Form, turn};
use crate::common::state::{any, noise, put};
use crate::common::{V, add, build_as, norm, positions, run, scale, sub, weightless};
use std::sync::Arc;
use taffeta::Precision;
use taffeta::scene::{Body, Collider, Cube, Cylinder, Icosphere, Mass, Mesh, Place, Rotation, Torus};
use taffeta::topology::Surface;

/// Where a collider moves nodes that are put at places.
pub fn pushed(collider: Collider, x: &[V], precision: Precision) -> Vec<V> {
    // Out of a groove it may take some sub-steps.
    let frames = if Form::of(&collider).is_convex() { 1 } else { 4 };
    let links = x.len() as u32 - 1;
    let body = Body::cloth("nodes", Mesh::chain(links, 1.0)).with_mass(Mass::Node(1.0));
    let mut simulation = build_as(&weightless("put", 0.01, 0.01).body(body).collider(collider), precision, 1);
    put(&mut simulation, x);
    run(&mut simulation, frames);
    positions(&simulation)
}

/// A surface given as data.
pub fn data(nodes: Vec<V>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh::Surface(Arc::new(Surface::of_triangles(nodes, triangles)))
}

pub fn shapes() -> Vec<(&'static str, Collider)> {
    let mut random = noise(5);
    let cloud: Vec<V> = (0..24).map(|_| any(&mut random)).collect();
    let hills =
        (0..6).map(|row| (0..7).map(|col| 0.2 * f64::from((row * 5 + col * 3) % 4)).collect()).collect();
    let can = Cylinder { radius: 0.7, height: 1.2, segments: 64, rings: 2, capped: true };
    vec![
        ("sphere", Collider::sphere([0.1, 0.2, -0.1], 0.8)),
        ("plane", Collider::plane([0.1, 0.2, 0.0], [0.3, 2.0, -0.4])),
        ("box", Collider::cuboid([0.1, 0.0, -0.2], [0.4, 0.9, 0.6])),
        ("capsule", Collider::capsule([-0.5, -0.3, 0.1], [0.6, 0.4, -0.2], 0.4)),
        ("point", Collider::capsule([0.1, 0.2, 0.3], [0.1, 0.2, 0.3], 0.7)),
        ("upright capsule", Collider::capsule([0.0, -0.5, 0.0], [0.0, 0.5, 0.0], 0.3)),
        ("cylinder", Collider::cylinder([-0.5, -0.3, 0.1], [0.6, 0.4, -0.2], 0.7)),
        ("coin", Collider::cylinder([0.0, -0.1, 0.0], [0.0, 0.1, 0.0], 0.9)),
        ("icosphere", Collider::mesh(Mesh::Icosphere(Icosphere { radius: 0.9, subdivisions: 2 }))),
        ("torus", Collider::mesh(Mesh::Torus(Torus { major: 0.8, minor: 0.3, rings: 18, segments: 10 }))),
        ("cube", Collider::mesh(Mesh::Cube(Cube { size: 1.3, divisions: 3 }))),
        ("can with poles of 64", Collider::mesh(Mesh::Cylinder(can))),
        ("sheet", Collider::mesh(Mesh::grid(7, 9, [1.7, 1.5]))),
        ("tube", Collider::mesh(Mesh::Cylinder(Cylinder { capped: false, segments: 12, ..can }))),
        ("hull", Collider::convex(data(cloud, vec![[0, 1, 2]]))),
        ("hull of a cube", Collider::convex(Mesh::Cube(Cube { size: 1.3, divisions: 2 }))),
        ("height field", Collider::heightfield([1.8, 1.6], hills)),
    ]
}

pub const OFFSET: f64 = 0.03;

/// Places at random, and near all places where formulas change.
fn places(form: &Form) -> Vec<V> {
    let mut random = noise(17);
    let mut places: Vec<V> = (0..3000).map(|_| scale(any(&mut random), 1.3)).collect();
    let corners = form.corners();
    let every = corners.len().div_ceil(300);
    for corner in corners.into_iter().step_by(every) {
        places.push(corner);
        for far in [1e-16, 1e-15, 1e-13, 1e-10, 1e-7, 1e-4, OFFSET] {
            let way = any(&mut random);
            places.push(add(corner, scale(way, far / norm(way))));
        }
    }
    places
}

/// Every node is moved out by the nearest way, and by no more; `tolerance` [m].
fn moves_out(name: &str, collider: &Collider, precision: Precision, tolerance: f64) {
    let (axis, degrees, position) = ([0.4, 1.0, -0.3], 50.0, [0.7, -0.4, 0.2]);
    let form = Form::of(collider);
    let place =
        Place { position, rotation: Some(Rotation { axis, degrees }), scale: Some(1.5), ..Place::default() };
    let own = |x: V| scale(turn(axis, -degrees, sub(x, position)), 1.0 / 1.5);
    let distance = |x: V| 1.5 * form.distance(own(x));
    let single = |x: V| if precision == Precision::F32 { x.map(|c| f64::from(c as f32)) } else { x };
    let places: Vec<V> =
        places(&form).iter().map(|x| single(add(turn(axis, degrees, scale(*x, 1.5)), position))).collect();
    let moved = pushed(collider.clone().placed(place).offset(OFFSET), &places, precision);
    let mut inside = 0;
    for (x, y) in places.iter().zip(moved) {
        let (before, after) = (distance(*x), distance(y));
        let what = format!("{name}, {precision}: {x:?}, {before:e} m off, went to {y:?}, {after:e} m off");
        assert!(after >= OFFSET - tolerance, "{what}");
        if before > OFFSET + tolerance {
            assert_eq!(*x, y, "{what}");
        } else if before < OFFSET - tolerance {
            inside += 1;
            let way = norm(sub(y, *x));
            assert!(way >= OFFSET - before - tolerance, "{what}");
            if form.is_convex() {
                // On a surface to rounding, the way out has no exact direction, and a sheet no exact side.
                let blurred = if before.abs() < 1e3 * tolerance { 5.0 * OFFSET } else { tolerance };
                assert!((way - (OFFSET - before)).abs() < blurred, "{what}, by {way}");
                assert!(after < OFFSET + blurred, "{what}");
            }
        }
    }
    assert!(inside > 100, "{name}: {inside} inside");
}

#[test]
fn nodes_are_moved_out_of_every_shape_by_the_nearest_way() {
    for (name, collider) in shapes() {
        moves_out(name, &collider, Precision::F64, 1e-12);
    }
}

#[test]
fn nodes_are_moved_out_in_32_bits() {
    for (name, collider) in shapes() {
        moves_out(name, &collider, Precision::F32, 3e-6);
    }
}

#[test]
fn an_inside_out_solid_is_as_solid_as_another() {
    let faces = Faces::of(&Mesh::Torus(Torus { major: 0.8, minor: 0.3, rings: 18, segments: 10 }));
    let turned = faces.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    moves_out("torus", &Collider::mesh(data(faces.nodes, turned)), Precision::F64, 1e-12);
}

/// Two halves of a moved place.
fn scaled(collider: &Collider, size: f64, far: V) -> Collider {
    collider.clone().placed(Place { position: far, scale: Some(size), ..Place::default() })
}

#[test]
fn small_and_large_shapes_are_moved_out_of_alike() {
    for (name, collider) in shapes() {
        let form = Form::of(&collider);
        for size in [1e-3, 1e2] {
            let places: Vec<V> = places(&form).iter().step_by(7).map(|x| scale(*x, size)).collect();
            let offset = OFFSET * size;
            let moved = pushed(scaled(&collider, size, [0.0; 3]).offset(offset), &places, Precision::F64);
            for (x, y) in places.iter().zip(moved) {
                let [before, after] = [*x, y].map(|x| form.distance(scale(x, 1.0 / size)));
                assert!(after >= OFFSET - 1e-12, "{name} × {size}: {x:?} → {y:?}, {before:e} {after:e}");
                assert!(before < OFFSET + 1e-12 || *x == y, "{name} × {size}: {x:?} → {y:?}");
            }
        }
    }
}

#[test]
fn shapes_far_from_the_origin_are_moved_out_of_as_far_as_numbers_tell() {
    let far = [1000.0, -2000.0, 1500.0];
    for (name, collider) in shapes() {
        let form = Form::of(&collider);
        for (precision, tolerance) in [(Precision::F64, 2e-12), (Precision::F32, 2e-3)] {
            let places: Vec<V> =
                places(&form).iter().step_by(11).map(|x| add(*x, far).map(|c| f64::from(c as f32))).collect();
            let moved = pushed(scaled(&collider, 1.0, far).offset(OFFSET), &places, precision);
            for (x, y) in places.iter().zip(moved) {
                let after = form.distance(sub(y, far));
                assert!(after >= OFFSET - tolerance, "{name}, {precision}: {x:?} → {y:?}, {after:e}");
            }
        }
    }
}
