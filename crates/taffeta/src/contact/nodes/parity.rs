//! Rows of nodes that touch each other.

use crate::backend::Backend;
use crate::contact::colliders::gpu::Contact;
use crate::contact::colliders::moving::ColliderNow;
use crate::contact::colliders::rigid::Rigid;
use crate::contact::nodes::cells;
use crate::contact::nodes::gpu_layout::FARTHEST;
use crate::contact::nodes::parity_scene;
use crate::contact::nodes::self_contact::Exclusions;
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, GROUP, NONE};
use crate::parity::bench::{Bench, Given, Written};
use crate::parity::fixture::{Chance, Fixture, SUBSTEP, State, words};
use crate::parity::row::{Row, Tolerance};
use crate::real::{Real, dot, sub};
use crate::solvers::explicit::parity::kernel_of;
use crate::step::{self, Line, Op, Parts};
use std::collections::BTreeMap;

const COUNTED: &str = "numbers alone";
const FOUND: &str = "one product and sum after the other, and a quotient; hardware may fuse them";
const MOVED: &str = "as above; contact multiplies what hardware rounds otherwise";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    row("clear_cells", Tolerance::new(0.0, 0.0, COUNTED), clear),
    row("fill_cells", Tolerance::new(0.0, 0.0, COUNTED), fill),
    row("find_self_contacts", Tolerance::new(0.0, 32.0, FOUND), find),
    row("resolve_self_contacts", Tolerance::new(0.0, 128.0, MOVED), resolve),
    row("contact_after_self_collision", Tolerance::new(0.0, 512.0, MOVED), contact_after_self_collision),
    row("measure_self_contacts", Tolerance::new(0.0, 0.0, COUNTED), measure),
];

const fn row(
    name: &'static str,
    tolerance: Tolerance,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> Row {
    Row { name, entry: name, tolerance, check }
}

/// Nodes in lists, and what is found of each place: contacts, and the nearest.
pub struct Work {
    pub heads: Vec<u32>,
    pub next: Vec<u32>,
    pub contacts: Vec<Vec<u32>>,
    pub nearest: Vec<f32>,
}

const POISON: u32 = 0x7fff_fff1;

impl Work {
    /// Of the state after the sub-step; nodes are linked in an order by chance. Contacts are looked for among all pairs.
    pub fn new(fixture: &Fixture) -> Self {
        let (places, buckets) = (fixture.tables.len(), fixture.tables.self_collision.buckets());
        let mut work = Self {
            heads: vec![NONE; buckets],
            next: vec![POISON; places],
            contacts: vec![Vec::new(); places],
            nearest: vec![f32::FAR; places],
        };
        let mut nodes = nodes_in_contact(fixture);
        let mut chance = Chance::new(99);
        nodes.sort_by_cached_key(|_| chance.number().to_bits());
        for (node, bucket) in nodes {
            work.next[node as usize] = std::mem::replace(&mut work.heads[bucket], node);
        }
        work.find(fixture);
        work
    }

    fn find(&mut self, fixture: &Fixture) {
        let nodes: Vec<u32> = nodes_in_contact(fixture).into_iter().map(|(node, _)| node).collect();
        for &a in &nodes {
            let exclusions = excluded_nodes(fixture, a);
            let radius = radius(fixture, a);
            for &b in nodes.iter().filter(|&&b| b != a && !exclusions.contains(&b)) {
                let d = sub(place(fixture, a), place(fixture, b));
                let (squared, reach) = (dot(d, d), radius + self::radius(fixture, b));
                if squared < reach * reach && do_meet(fixture, a, b) {
                    let nearest = &mut self.nearest[a as usize];
                    *nearest = nearest.min(squared / (reach * reach));
                    self.contacts[a as usize].push(b);
                }
            }
        }
    }

    fn lists(&self) -> Vec<u32> {
        [&self.heads[..], &self.next].concat()
    }

    fn counts(&self) -> Vec<u32> {
        self.contacts.iter().map(|list| list.len() as u32).collect()
    }

    /// As `contact_work` has it.
    fn words(&self) -> Vec<u32> {
        [self.lists(), self.counts(), words(&self.nearest)].concat()
    }
}

fn place(fixture: &Fixture, node: u32) -> [f32; 3] {
    let [x, y, z, _] = fixture.new.position[node as usize];
    [x, y, z]
}

/// Half the thickness at a node that touches others.
fn radius(fixture: &Fixture, node: u32) -> f32 {
    let of_node = |first: u32, count: u32| (first..first + count).contains(&node);
    let surface =
        fixture.tables.self_collision.surfaces.iter().find(|surface| of_node(surface.first, surface.count));
    surface.map_or(0.0, |surface| surface.material.thickness * 0.5)
}

/// Whether the bodies of two nodes meet, as the assembly says.
fn do_meet(fixture: &Fixture, a: u32, b: u32) -> bool {
    let assembly = fixture.cpu.assembly();
    let [a, b] = [a, b].map(|node| assembly.number_of_body(node));
    assembly.meetings().bodies(a, b)
}

/// Nodes that one does not touch, as the assembly says.
fn excluded_nodes(fixture: &Fixture, node: u32) -> Vec<u32> {
    let (node, mut all) = (node as usize, Vec::new());
    for (body, self_contact) in fixture.cpu.assembly().self_colliding() {
        if body.solver_range().contains(&node) {
            let exclusions: &Exclusions = &self_contact.exclusions;
            exclusions
                .each(body.grid_layout, node - body.first, |other| all.push((body.first + other) as u32));
        }
    }
    all
}

/// Nodes whose places are numbers, each with its bucket.
fn nodes_in_contact(fixture: &Fixture) -> Vec<(u32, usize)> {
    let mask = fixture.tables.self_collision.buckets() as u32 - 1;
    let mut nodes = Vec::new();
    for surface in &fixture.tables.self_collision.surfaces {
        for node in surface.first..surface.first + surface.count {
            let x = place(fixture, node);
            let cell = x.map(|x| (x * surface.cells_a_metre).clamp(-FARTHEST, FARTHEST).floor() as i32);
            if place(fixture, node).iter().all(|x| x.is_finite()) {
                nodes.push((node, cells::bucket(cell, mask)));
            }
        }
    }
    nodes
}

fn fixtures(bench: &Bench<'_>) -> Result<[Fixture; 2], String> {
    Ok([parity_scene::fixture(21, bench.exact, false)?, parity_scene::fixture(22, bench.exact, false)?])
}

/// Runs a kernel on the state after the sub-step, with those words.
fn run(
    bench: &mut Bench<'_>,
    entry: &'static str,
    fixture: &Fixture,
    (work, groups): (Vec<u32>, usize),
    compare: impl FnOnce(&mut Written<'_>),
) -> Result<(), String> {
    let kernel = kernel_of(bench, Name::new(entry), fixture)?;
    let mut arrays = fixture.arrays();
    arrays.insert("old_position", words(&fixture.new.position));
    arrays.insert("old_velocity", words(&fixture.new.velocity));
    arrays.insert("surfaces", words(&fixture.tables.self_collision.surfaces));
    arrays.insert("exclusions", fixture.tables.self_collision.exclusions.clone());
    arrays.insert("cell_links", work.clone());
    arrays.insert("contact_work", work);
    arrays.insert("contact_sums", vec![POISON; 2 * groups]);
    bench.run(&kernel, &Given { arrays: &arrays, records: &fixture.records(), groups }, compare)
}

/// Words as numbers, which are only compared to be the same.
fn numbers(words: &[u32]) -> Vec<f32> {
    words.iter().flat_map(|word| [(word >> 16) as f32, (word & 0xffff) as f32]).collect()
}

pub fn same(written: &mut Written<'_>, name: &str, wanted: &[u32], found: &[u32]) {
    written.outcome().copied(name, &numbers(wanted), &numbers(found));
}

fn clear(bench: &mut Bench<'_>) -> Result<(), String> {
    for fixture in fixtures(bench)? {
        let buckets = fixture.tables.self_collision.buckets();
        let work = vec![POISON; fixture.tables.self_collision.words()];
        let mut wanted = work.clone();
        wanted[..buckets].fill(NONE);
        // A workgroup more than there are buckets for.
        run(bench, "clear_cells", &fixture, (work, buckets.div_ceil(GROUP) + 1), |written| {
            let found: Vec<u32> = written.take("contact_work");
            same(written, "contact_work", &wanted, &found);
        })?;
    }
    Ok(())
}

/// Nodes by bucket, as their lists say: ascending, for their order is that of chance.
fn by_bucket(lists: &[u32], buckets: usize) -> Vec<u32> {
    let (heads, next) = lists.split_at(buckets.min(lists.len()));
    let mut all = Vec::new();
    for (bucket, &head) in (0..).zip(heads) {
        let follow = |node: &u32| next.get(*node as usize).copied().filter(|next| *next != NONE);
        let list = std::iter::successors(Some(head).filter(|head| *head != NONE), follow);
        let mut list: Vec<u32> = list.take(next.len() + 1).collect();
        list.sort_unstable();
        all.push(bucket);
        all.extend(list);
    }
    all
}

fn fill(bench: &mut Bench<'_>) -> Result<(), String> {
    for fixture in fixtures(bench)? {
        let (buckets, places) = (fixture.tables.self_collision.buckets(), fixture.tables.len());
        let wanted = Work::new(&fixture);
        let mut work = vec![POISON; fixture.tables.self_collision.words()];
        work[..buckets].fill(NONE);
        run(bench, "fill_cells", &fixture, (work.clone(), fixture.place_groups()), |written| {
            let found: Vec<u32> = written.take("cell_links");
            let (lists, rest) = found.split_at(found.len().min(buckets + places));
            same(written, "lists", &by_bucket(&wanted.lists(), buckets), &by_bucket(lists, buckets));
            let untouched = |next: &[u32]| next.iter().map(|&next| u32::from(next == POISON)).collect();
            let next: Vec<u32> = untouched(&lists[buckets.min(lists.len())..]);
            same(written, "places in no list", &untouched(&wanted.next), &next);
            same(written, "past the lists", &work[buckets + places..], rest);
        })?;
    }
    Ok(())
}

fn find(bench: &mut Bench<'_>) -> Result<(), String> {
    for fixture in fixtures(bench)? {
        let (all, places) = (Work::new(&fixture), fixture.tables.len());
        let lists = all.lists();
        let work = [lists.clone(), vec![POISON; 2 * places]].concat();
        run(bench, "find_self_contacts", &fixture, (work, fixture.place_groups()), |written| {
            let found: Vec<u32> = written.take("contact_work");
            let (left, found) = found.split_at(found.len().min(lists.len()));
            let (counts, nearest) = found.split_at(found.len().min(places));
            same(written, "lists", &lists, left);
            same(written, "contacts", &all.counts(), counts);
            let nearest: Vec<f32> = nearest.iter().map(|&bits| f32::from_bits(bits)).collect();
            let near = |all: &[f32]| -> Vec<f32> { all.iter().map(|&one| one.min(1.0)).collect() };
            written.outcome().compare("nearest", &near(&all.nearest), &near(&nearest));
        })?;
    }
    Ok(())
}

/// Nodes part on the CPU, without colliders.
fn part_once() -> Vec<Line> {
    let parts = Parts { self_contact: true, ..Parts::default() };
    step::part_of(&parts, &[Op::SelfContact, Op::ApplySelfContact])
}

/// The state that the CPU comes to: colliders act again on those that touch another. Also that before they do.
fn parted(fixture: &mut Fixture, contacts: &[u32]) -> ([Vec<Four>; 2], State) {
    let start = fixture.new.clone();
    let Fixture { cpu, substeps, new, .. } = fixture;
    for (place, (x, v)) in new.position.iter().zip(&new.velocity).enumerate() {
        cpu.set_after(place, [x[0], x[1], x[2], v[0], v[1], v[2]]);
    }
    cpu.passes(&substeps[SUBSTEP], &part_once());
    for (place, (x, v)) in new.position.iter_mut().zip(&mut new.velocity).enumerate() {
        let after = cpu.after(place);
        x[..3].copy_from_slice(&after[..3]);
        v[..3].copy_from_slice(&after[3..]);
    }
    let moved = std::mem::replace(&mut fixture.new, start.clone());
    let after = collided_again(fixture, moved.clone(), |place| contacts[place] > 0);
    ([after.position, after.velocity], moved)
}

/// The state after some nodes have been moved from the state after the sub-step, and colliders have acted on them again. The others
/// are as they were.
pub fn collided_again(fixture: &mut Fixture, moved: State, is_moved: impl Fn(usize) -> bool) -> State {
    // Colliders act on the way that they have moved, and have not moved meanwhile.
    let start = std::mem::replace(&mut fixture.new, moved);
    let old = std::mem::replace(&mut fixture.old, start.clone());
    let carries: Vec<_> =
        fixture.substep().colliders().iter().map(|collider| collider.surface.carry).collect();
    let carry = |fixture: &mut Fixture, by: &dyn Fn(usize) -> Rigid<f32>| {
        let each = |(index, collider): (usize, &mut ColliderNow<f32>)| collider.surface.carry = by(index);
        fixture.substeps[SUBSTEP].edit_colliders(|all| all.iter_mut().enumerate().for_each(each));
    };
    carry(fixture, &|_| Rigid::rest());
    fixture.put_old();
    let (_, mut after) = fixture.on_cpu(&[Op::Contact]);
    carry(fixture, &|index| carries[index]);
    fixture.old = old;
    fixture.put_old();
    for place in 0..start.position.len() {
        if !is_moved(place) {
            after.position[place] = start.position[place];
            after.velocity[place] = start.velocity[place];
        } else if start.velocity[place][3] < 0.0 {
            after.velocity[place][3] = -after.velocity[place][3].abs();
        }
    }
    fixture.new = start;
    after
}

/// On states after resolve_self_contacts, in scenes with meshes.
fn contact_after_self_collision(bench: &mut Bench<'_>) -> Result<(), String> {
    // On hardware there are no meshes: near one, other roundings turn the way out.
    let mut fixture = parity_scene::fixture(23, bench.exact, bench.exact)?;
    let work = Work::new(&fixture);
    let ([position, velocity], moved) = parted(&mut fixture, &work.counts());
    let name = Name::new("contact_after_self_collision").with(Contact::Meshes.choices());
    let kernel = kernel_of(bench, name, &fixture)?;
    let mut arrays = fixture.arrays();
    arrays.insert("old_position", words(&fixture.new.position));
    arrays.insert("old_velocity", words(&fixture.new.velocity));
    arrays.insert("new_position", words(&moved.position));
    arrays.insert("new_velocity", words(&moved.velocity));
    arrays.insert("contact_work", work.words());
    let (records, groups) = (fixture.records(), fixture.place_groups());
    bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
        written.fours("new_position", &position);
        written.fours("new_velocity", &velocity);
        let found: Vec<u32> = written.take("contact_work");
        same(written, "contact_work", &work.words(), &found);
    })
}

fn resolve(bench: &mut Bench<'_>) -> Result<(), String> {
    for mut fixture in fixtures(bench)? {
        let work = Work::new(&fixture);
        let ([position, velocity], _) = parted(&mut fixture, &work.counts());
        let words = work.words();
        run(bench, "resolve_self_contacts", &fixture, (words.clone(), fixture.place_groups()), |written| {
            written.fours("new_position", &position);
            written.fours("new_velocity", &velocity);
            let found: Vec<u32> = written.take("contact_work");
            same(written, "contact_work", &words, &found);
        })?;
    }
    Ok(())
}

fn measure(bench: &mut Bench<'_>) -> Result<(), String> {
    for fixture in fixtures(bench)? {
        let (work, groups) = (Work::new(&fixture), 2);
        let mut wanted: BTreeMap<usize, [u32; 2]> =
            (0..groups).map(|group| (group, [0, f32::FAR.to_bits()])).collect();
        for (place, (count, nearest)) in work.counts().into_iter().zip(&work.nearest).enumerate() {
            let one = wanted.entry(place / GROUP % groups).or_default();
            *one = [one[0] + count, one[1].min(nearest.to_bits())];
        }
        let (wanted, words) = (wanted.into_values().collect::<Vec<_>>().concat(), work.words());
        run(bench, "measure_self_contacts", &fixture, (words.clone(), groups), |written| {
            let sums: Vec<u32> = written.take("contact_sums");
            same(written, "contact_sums", &wanted, &sums);
            let left: Vec<u32> = written.take("contact_work");
            same(written, "contact_work", &words, &left);
        })?;
    }
    Ok(())
}
