//! Whatever moves how, pairs in contact are those that looking at all pairs finds.

use crate::contact::nodes::cpu::*;
use crate::cpu::column::Column;
use crate::cpu::team::Team;
use crate::cpu::tiles;
use crate::real::{dot, sub};
use crate::scene::{Body, Icosphere, Mass, Mesh, Scene};
use std::collections::BTreeSet;
use std::sync::Mutex;

const STEPS: usize = 60;

/// Grids of all kinds of edges, a mesh, and a chain, with different thickness.
fn assembly() -> Assembly {
    let cloth = |mesh, thickness: f64| {
        Body::cloth("", mesh).with_mass(Mass::Node(0.1)).structural(10.0, 0.0).collide_nodes(thickness)
    };
    let ball = Body::soft("", Mesh::Icosphere(Icosphere { radius: 0.4, subdivisions: 2 }))
        .with_mass(Mass::Node(0.1))
        .structural(10.0, 0.0)
        .collide_nodes(0.06);
    let free = Body::cloth("", Mesh::grid(9, 9, [0.1, 0.1])).with_mass(Mass::Node(0.1));
    let scene = Scene::new("")
        .body(cloth(Mesh::grid(23, 13, [1.2, 2.2]), 0.1))
        .body(free)
        .body(cloth(Mesh::grid(160, 3, [0.2, 8.0]), 0.07))
        .body(ball)
        .body(cloth(Mesh::chain(37, 1.5), 0.03))
        .time(0.01, 0.001);
    Assembly::new(&scene).unwrap()
}

/// Numbers from 0 to 1 (SplitMix64: Steele et al. 2014).
struct Random(u64);

impl Random {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mixed = (self.0 ^ (self.0 >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        let mixed = (mixed ^ (mixed >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        (mixed ^ (mixed >> 31)) as f64 / u64::MAX as f64
    }
}

/// Places of all nodes after each step: bodies drift through each other, nodes tremble, some leap, some get lost.
fn motion(assembly: &Assembly, lost: f64) -> Vec<Vec<[f64; 3]>> {
    let mut random = Random(1);
    let drift: Vec<[f64; 3]> =
        assembly.bodies.iter().map(|_| [0; 3].map(|_| (random.next() - 0.5) * 0.04)).collect();
    let mut now: Vec<[f64; 3]> = vec![[0.0; 3]; assembly.places];
    for body in &assembly.bodies {
        now[body.solver_range()].copy_from_slice(&body.start);
    }
    let mut steps = Vec::new();
    for step in 0..STEPS {
        for (body, drift) in assembly.bodies.iter().zip(&drift) {
            for place in &mut now[body.solver_range()] {
                let leap = if random.next() < 1e-3 { 0.5 } else { 0.003 };
                *place = [0, 1, 2].map(|axis| {
                    // Flatter from step to step, so that sheets fold.
                    let flat = if axis == 0 { 0.97 } else { 1.0 };
                    (place[axis] + drift[axis] + (random.next() - 0.5) * leap) * flat
                });
                if step > STEPS / 2 && random.next() < lost {
                    place[2] = [f64::NAN, f64::INFINITY, 0.2, 1e300][(random.next() * 4.0) as usize % 4];
                }
            }
        }
        steps.push(now.clone());
    }
    steps
}

/// Both ends of all pairs in contact, by looking at all pairs.
fn all_ends<T: Real>(assembly: &Assembly, state: &[Column<T>; 6]) -> BTreeSet<[u32; 2]> {
    let mut exclusions = BTreeSet::new();
    let mut nodes = Vec::new();
    for (body, self_contact) in assembly.self_colliding() {
        for local in 0..body.nodes {
            nodes.push((body.first + local, T::from_f64(self_contact.surface.thickness) * T::from_f64(0.5)));
            self_contact.exclusions.each(body.grid_layout, local, |other| {
                exclusions.insert([body.first + local, body.first + other]);
            });
        }
    }
    let place = |node: usize| [0, 1, 2].map(|axis: usize| state[axis][node]);
    let mut ends = BTreeSet::new();
    for &(a, first) in &nodes {
        for &(b, second) in &nodes {
            let d = sub(place(a), place(b));
            let reach = first + second;
            if a != b && dot(d, d) < reach * reach && !exclusions.contains(&[a, b]) {
                ends.insert([a as u32, b as u32]);
            }
        }
    }
    ends
}

/// What a team finds, step by step: both ends of all pairs, and how often it has searched.
fn found<T: Real>(
    assembly: &Assembly,
    steps: &[Vec<[f64; 3]>],
    threads: usize,
    level: SimdLevel,
    margin: f64,
) -> (Vec<BTreeSet<[u32; 2]>>, u64) {
    let plans = tiles::tiles(assembly);
    let chunks = tiles::chunks_by_nodes(&plans, threads);
    let mut setup = ContactSetup::<T>::new(assembly, &plans, &chunks).unwrap();
    setup.diagonals = setup.diagonals.map(|diagonal| diagonal * margin);
    let mut work = ContactWork::new(&setup, threads);
    let scratch: Vec<_> =
        chunks.iter().map(|chunk| Mutex::new(ContactScratch::new(assembly.places, chunk.len()))).collect();
    let mut next: Fields<T> = std::array::from_fn(|_| Column::zeros(assembly.places).into());
    let inverse_mass = vec![T::ONE; assembly.places];
    let (team, mut found, mut searches) = (Team::new(threads), Vec::new(), 0);
    for places in steps {
        for (node, place) in places.iter().enumerate() {
            (0..3).for_each(|axis| next[axis].get_mut()[node] = T::from_f64(place[axis]));
        }
        team.run(|index, barrier| {
            let mut worker = ContactWorker {
                setup: &setup,
                shared: &work,
                scratch: &mut scratch[index].lock().unwrap(),
                first_tile: chunks[index].start,
                index,
                next: &next,
                inverse_mass: &inverse_mass,
                level,
            };
            worker.update_motion_bounds();
            barrier.wait();
            if worker.is_stale() {
                worker.search(|| barrier.wait());
            }
            worker.find_contacts();
            barrier.wait();
        });
        let mut ends = BTreeSet::new();
        for (scratch, chunk) in scratch.iter().zip(&chunks) {
            let ContactScratch { contact_list, search, .. } = &*scratch.lock().unwrap();
            searches = search.searches;
            for tile in 0..chunk.len() {
                for number in contact_list.of_tile(tile) {
                    let (node, others) = (contact_list.owners()[number], contact_list.others(number));
                    assert!(others.is_sorted_by(|a, b| a < b));
                    assert_eq!(setup.tile[node as usize] as usize, chunk.start + tile);
                    assert_eq!(*work.contacts[node as usize].get_mut() as usize, others.len());
                    ends.extend(others.iter().map(|&other| [node, other]));
                }
            }
        }
        assert_eq!(work.found()[0] as usize, ends.len());
        found.push(ends);
    }
    (found, searches)
}

fn compare<T: Real>(lost: f64) {
    let assembly = assembly();
    let steps = motion(&assembly, lost);
    let mut fields: [Column<T>; 6] = std::array::from_fn(|_| Column::zeros(assembly.places));
    let mut expected = Vec::new();
    for places in &steps {
        for (node, place) in places.iter().enumerate() {
            (0..3).for_each(|axis| fields[axis][node] = T::from_f64(place[axis]));
        }
        expected.push(all_ends(&assembly, &fields));
    }
    assert!(expected.iter().all(|ends| ends.len() > 10) && expected[STEPS - 1].len() > 1000);
    for (threads, level, margin) in [
        (1, SimdLevel::detect(), 1.0),
        (2, SimdLevel::detect(), 0.2),
        (3, SimdLevel::Base, 1.0),
        (4, SimdLevel::detect(), 10.0),
    ] {
        let (found, searches) = found::<T>(&assembly, &steps, threads, level, margin);
        for (step, (found, expected)) in found.iter().zip(&expected).enumerate() {
            let wrong: Vec<_> = found.symmetric_difference(expected).take(5).collect();
            assert!(wrong.is_empty(), "{threads} threads, step {step}: {wrong:?}");
        }
        assert!(lost > 0.0 || searches < STEPS as u64, "{searches} searches");
    }
}

#[test]
fn all_pairs_in_contact_are_found_at_every_step() {
    compare::<f32>(0.0);
    compare::<f64>(0.0);
}

#[test]
fn nodes_that_get_lost_hide_no_others() {
    compare::<f32>(1e-4);
    compare::<f64>(1e-4);
}
