//! What is found of pairs does not depend on when it was looked for.

use super::broad_phase::{LeafPair, Leaves, Looked, Pairs, Wanted};
use super::narrow_phase::{Close, Look, Memory};
use crate::assembly::Assembly;
use crate::contact::triangles::closest::{edge_edge, vertex_triangle};
use crate::contact::triangles::surfaces::{Kind, Surfaces};
use crate::cpu::simd::SimdLevel;
use crate::real::{Real, add, cross, norm, sub};
use crate::scene::{
    Body, Collider, ContactForm, Cuboid, Icosphere, Mass, Mesh, Rotation, Scene, SelfCollision,
};
use crate::topology::random::SplitMix64;
use std::collections::BTreeSet;

const STEPS: usize = 60;

/// A pair by its kind and its nodes, with the bits of its thickness.
type Key = (u8, [u32; 4], u64);

fn surfaces() -> Surfaces {
    let touching = |body: Body, thickness: f64| {
        let touch = SelfCollision { form: ContactForm::Triangles, thickness, ..SelfCollision::default() };
        let mut body = Body { self_collision: Some(touch), ..body };
        body.place.rotation = Some(Rotation { axis: [0.3, 1.0, -0.2], degrees: 4000.0 * thickness });
        body.with_mass(Mass::Node(0.1)).structural(10.0, 0.0)
    };
    let ball = Body::soft("", Mesh::Icosphere(Icosphere { radius: 0.1, subdivisions: 2 }));
    let cuboid = Some(Cuboid { center: [0.0, -0.1, 0.0], half: [0.1, 0.05, 0.1] });
    let scene = Scene::new("")
        .body(touching(Body::cloth("", Mesh::grid(17, 23, [0.3, 0.4])), 0.004))
        .body(touching(Body::cloth("", Mesh::grid(9, 9, [0.4, 0.4])).at([0.0, 0.1, 0.0]), 0.03))
        .body(touching(ball.at([0.1, 0.25, 0.0]), 0.01))
        .collider(Collider { cuboid, offset: 0.005, ..Collider::default() })
        .time(0.01, 0.001);
    std::mem::take(Assembly::new(&scene).unwrap().surfaces_mut().unwrap())
}

/// Where all places are before each step, and after the last: bodies turn and drift through each other, nodes tremble.
fn motion(surfaces: &Surfaces) -> Vec<Vec<[f64; 3]>> {
    let mut random = SplitMix64::new(2);
    let mut vector = |size: f64| [0, 1, 2].map(|_| size * (2.0 * random.unit() - 1.0));
    let bodies: Vec<_> = (0..4).map(|_| (vector(0.004), vector(0.03))).collect();
    let mut all = vec![surfaces.start.clone()];
    for step in 0..STEPS {
        let tremble = if step % 7 == 0 { 4e-3 } else { 2e-4 };
        let mut next = all[step].clone();
        for (place, x) in next.iter_mut().enumerate().take(surfaces.places) {
            let Some(&(drift, spin)) = bodies.get(surfaces.surface_of[place] as usize) else { continue };
            *x = add(add(*x, add(drift, cross(spin, *x))), vector(tremble));
        }
        all.push(next);
    }
    all
}

fn columns<T: Real>(x: &[[f64; 3]]) -> [Vec<T>; 3] {
    std::array::from_fn(|axis| x.iter().map(|x| T::from_f64(x[axis])).collect())
}

fn slices<T>(columns: &[Vec<T>; 3]) -> [&[T]; 3] {
    columns.each_ref().map(|column| &column[..])
}

fn key<T: Real>(close: &Close<T>) -> Key {
    (close.kind() as u8, close.nodes, close.thickness.to_f64().to_bits())
}

/// The pairs that matter in each step, as one worker finds them; from nothing in each step if it `forgets`.
fn found<T: Real>(
    surfaces: &Surfaces,
    steps: &[Vec<[f64; 3]>],
    forgets: bool,
) -> (Vec<BTreeSet<Key>>, usize) {
    let level = SimdLevel::detect();
    let (mut leaves, mut pairs) = (Leaves::<T>::new(surfaces, 1), Pairs::new());
    let (mut memory, mut all, mut looks) = (Memory::new(), Vec::new(), 0);
    let start = columns(&surfaces.start);
    for two in steps.windows(2) {
        if forgets {
            (leaves, pairs) = (Leaves::new(surfaces, 1), Pairs::new());
        }
        let (before, after) = (columns(&two[0]), columns(&two[1]));
        leaves.follow(0, surfaces, [slices(&before), slices(&after)], level);
        leaves.advance(0, &mut pairs, surfaces, level, || ());
        let mut of_step = BTreeSet::new();
        leaves.each_due(&mut pairs, surfaces, level, |pair: &mut LeafPair<T>, wanted: Wanted| {
            looks += 1;
            let look = Look::new(pair, surfaces, (leaves.packed(), slices(&start)), level);
            let x = (slices(&before), surfaces.mean_edge);
            let looked = look.renew(pair, wanted, x, &mut memory);
            let mut nearest = looked.others;
            for close in
                pair.list.iter().flat_map(|sixteen| (0..sixteen.count).map(|lane| sixteen.pair(lane)))
            {
                let at = close.nodes.map(|node| [0, 1, 2].map(|axis| before[axis][node as usize]));
                let relative = at.map(|x| sub(x, at[3]));
                let left = how_far(&close, relative);
                nearest = nearest.min(left);
                if left < wanted.needs {
                    of_step.insert(key(&close));
                }
            }
            Looked { nearest, ..looked }
        });
        all.push(of_step);
    }
    (all, looks)
}

/// How far a pair is from contact [m].
fn how_far<T: Real>(close: &Close<T>, x: [[T; 3]; 4]) -> f64 {
    let apart = match close.kind() {
        Kind::VertexTriangle => vertex_triangle(x).apart,
        Kind::EdgeEdge => edge_edge(x).apart,
    };
    norm(apart).to_f64() * (1.0 - 1e-5) - 1.05 * close.thickness.to_f64()
}

fn finds_the_same<T: Real>() {
    let surfaces = surfaces();
    let steps = motion(&surfaces);
    let (found_afresh, all_looks) = found::<T>(&surfaces, &steps, true);
    let (found, looks) = found::<T>(&surfaces, &steps, false);
    let total: usize = found.iter().map(BTreeSet::len).sum();
    assert!(total > 10_000 && found.iter().all(|step| !step.is_empty()), "{total}");
    assert!(looks < all_looks, "{looks} of {all_looks}");
    for (step, (found, afresh)) in found.iter().zip(&found_afresh).enumerate() {
        assert_eq!(found, afresh, "step {step}");
    }
}

#[test]
fn pairs_that_matter_are_found_whenever_they_were_looked_at() {
    finds_the_same::<f32>();
    finds_the_same::<f64>();
}

/// All pairs, compared with those that are found.
#[test]
fn every_pair_is_found_once() {
    let surfaces = surfaces();
    let x = &motion(&surfaces)[STEPS / 2];
    let (found, _) = found::<f64>(&surfaces, &[x.clone(), x.clone()], true);
    let mut all = BTreeSet::new();
    let at = |node: u32| x[node as usize];
    let is_body = |node: u32| (node as usize) < surfaces.places;
    let mut note = |kind: Kind, nodes: [u32; 4]| {
        let (one, other) = nodes.split_at(kind.first());
        if one.iter().any(|node| other.contains(node)) || !nodes.into_iter().any(is_body) {
            return;
        }
        let thickness = surfaces.material([one[0], other[0]].map(|node| surfaces.surface_of[node as usize]));
        let thickness = thickness.expect("not both of colliders")[0];
        let apart = match kind {
            Kind::VertexTriangle => vertex_triangle(nodes.map(at)).apart,
            Kind::EdgeEdge => edge_edge(nodes.map(at)).apart,
        };
        // Whatever their thickness is, these are near: neighbours are left out.
        if norm(apart) < 0.5 * thickness {
            all.insert((kind as u8, nodes));
        }
    };
    for &vertex in &surfaces.vertices {
        for &[a, b, c] in &surfaces.triangles {
            note(Kind::VertexTriangle, [vertex, a, b, c]);
        }
    }
    for (number, &[a, b]) in surfaces.edges.iter().enumerate() {
        for &[c, d] in &surfaces.edges[number + 1..] {
            note(Kind::EdgeEdge, [a, b, c, d]);
        }
    }
    let found: BTreeSet<(u8, [u32; 4])> = found[0].iter().map(|&(kind, nodes, _)| (kind, nodes)).collect();
    let missing: Vec<_> = all.difference(&found).collect();
    assert!(
        all.len() > 100 && missing.is_empty(),
        "{} of {}: {:?}",
        missing.len(),
        all.len(),
        missing.first()
    );
}
