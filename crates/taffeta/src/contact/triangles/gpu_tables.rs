//! Tables of surfaces for the GPU, on the host.

use crate::contact::colliders::lift::{Lift, are_led_apart};
use crate::contact::triangles::carry::{longest_push, longest_way, parts_of};
use crate::contact::triangles::filter::{ALLOWANCE, PROGRESS, SHARE, STRETCH, bound_of};
use crate::contact::triangles::gpu_layout as layout;
use crate::contact::triangles::leaves::{Leaf, Mask};
use crate::contact::triangles::surfaces::{Corners, Surfaces};
use crate::contact::triangles::tangle::{Knot, Pull, Tangle};
use crate::gpu::bodies::Bodies;
use crate::gpu::layout::Four;
use crate::plan::Substep;
use crate::step::{FILTERS, IMPULSES};

/// Room for pairs of leaves, by leaf, and for contacts, by vertex, at the start; rounds of the filter that are written down.
const PAIRS_A_LEAF: usize = 16;
const CONTACTS_A_VERTEX: usize = 1;
const ROUNDS: usize = 1;
/// Rounds of impulses that are written down at the start.
const IMPULSES_WRITTEN: usize = 4;
/// How often nodes that are held back may hold back others, as is written down at the start.
const JAMS_WRITTEN: usize = 1;
/// How often nodes that are pushed may push others, as is written down at the start.
const PUSHES_WRITTEN: usize = 4;

/// Where a place stands that is no node's and no corner's.
const STILL: [f32; 3] = [0.0; 3];

/// How long lists are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Room {
    /// Pairs of leaves.
    pub pairs: usize,
    pub contacts: usize,
    /// Rounds of impulses that are written down.
    pub impulses: usize,
    /// Rounds of the filter that are written down.
    pub rounds: usize,
    /// How often nodes that are held back may hold back others.
    pub jams: usize,
    /// Parts of the motion of colliders that are written down, and how often nodes that are pushed may push others in each.
    pub parts: usize,
    pub pushes: usize,
}

/// Where corners of colliders go in a sub-step.
#[derive(Clone, Debug, Default)]
pub struct CornersMoved {
    /// In how many parts; 0 if they stand still.
    pub parts: u32,
    /// The longest way along each axis that nodes are pushed in one of them [m].
    pub longest_push: f32,
    /// Where they are at its start, and then at its end [m]; empty where no collider ever moves.
    pub corners: Vec<Four>,
}

/// All that kernels know of surfaces before the first sub-step.
#[derive(Clone, Default)]
pub struct SurfaceTables {
    /// As `surface_tables` of surfaces.wgsl.
    pub words: Vec<u32>,
    /// Places before and after a sub-step that are not those of nodes: corners of colliders [m], and then one that always stands still.
    pub corners: Vec<[f32; 3]>,
    /// Places of nodes.
    places: usize,
    leaves: usize,
    vertices: usize,
    /// The least thickness of two surfaces, and the mean length of edges [m].
    thinnest: f64,
    pub mean_edge: f64,
    /// Whether some surfaces start through each other.
    pub start_tangled: bool,
    /// Whether contacts are part of systems that are solved for by nodes.
    pub is_solved: bool,
    /// Whether nodes may be led out of colliders.
    pub leads_out: bool,
    /// The first of the places of nodes among those of the scene.
    pub first: usize,
    /// The first box of each level, and how many it has.
    pub levels: Vec<[usize; 2]>,
    /// The first triangle, edge and vertex of each leaf, by which snapshots name contacts.
    pub firsts: Vec<[u32; 3]>,
}

impl SurfaceTables {
    /// The tables of some bodies; empty if they have no contact of this form.
    pub fn new(bodies: &Bodies<'_>) -> Self {
        let Some(surfaces) = bodies.assembly.surfaces() else { return Self::default() };
        let is_here = |place: &u32| *place as usize >= surfaces.places || bodies.has(*place);
        if !surfaces.leaves.iter().all(|leaf| is_here(&leaf.nodes[0])) {
            return Self::default();
        }
        let mut all = Self {
            words: vec![0; layout::HEADER],
            corners: surfaces.corners().iter().map(|x| x.map(|x| x as f32)).chain([STILL]).collect(),
            places: bodies.len(),
            leaves: surfaces.leaves.len(),
            vertices: surfaces.vertices.len(),
            thinnest: surfaces.thinnest,
            mean_edge: surfaces.mean_edge,
            start_tangled: surfaces.start_tangled,
            is_solved: is_solved(bodies),
            leads_out: bodies.assembly.leads_out(),
            first: bodies.places.start,
            levels: levels(surfaces.leaves.len()),
            firsts: surfaces.firsts(),
        };
        all.put_sizes(surfaces);
        let local = |place: u32| match place as usize {
            place if place < surfaces.places => bodies.local(place),
            place => (place - surfaces.places + bodies.len()) as u32,
        };
        all.add(layout::LEAVES_AT, surfaces.leaves.iter().flat_map(|leaf| leaf_words(leaf, local)));
        let rings = &surfaces.rings;
        all.add(layout::ROWS_AT, rings.starts.iter().copied());
        all.add(layout::ROW_ITEMS_AT, rings.rows.iter().flat_map(|&(leaf, ring)| [leaf, ring]));
        let of_ring = rings.rings.iter().flat_map(|ring| [mask_words(&ring.same), mask_words(&ring.near)]);
        all.add(layout::RINGS_AT, of_ring.flatten());
        all.add(layout::MATERIALS_AT, materials(surfaces));
        all.add_places(surfaces, bodies);
        all.add_fans(surfaces, bodies, local);
        all
    }

    /// Whether there is no contact of surfaces.
    pub fn is_empty(&self) -> bool {
        self.words.is_empty()
    }

    /// Places, those of corners of colliders among them.
    pub fn all_places(&self) -> usize {
        self.places + self.corners.len()
    }

    /// Number of leaves.
    pub fn leaves(&self) -> usize {
        self.leaves
    }

    /// Places of nodes.
    pub fn places(&self) -> usize {
        self.places
    }

    /// Buckets of forces, a power of two.
    pub fn buckets(&self) -> usize {
        (2 * self.vertices).next_power_of_two().max(64)
    }

    /// Room at the start.
    pub fn room(&self) -> Room {
        Room {
            pairs: PAIRS_A_LEAF * self.leaves,
            contacts: CONTACTS_A_VERTEX * self.vertices,
            impulses: IMPULSES_WRITTEN,
            rounds: ROUNDS,
            jams: JAMS_WRITTEN,
            parts: 0,
            pushes: PUSHES_WRITTEN,
        }
    }

    /// Where corners of colliders go in a sub-step.
    pub fn corners_moved(&self, substep: &Substep<f32>) -> CornersMoved {
        let Some(corners) = substep.extensions.get::<Corners<f32>>() else { return CornersMoved::default() };
        let most = longest_way(corners, 0..corners.before.len().min(corners.after.len()));
        let parts = parts_of(most, self.thinnest);
        CornersMoved {
            parts,
            longest_push: if parts > 0 { longest_push(most, parts) as f32 } else { 0.0 },
            corners: [&corners.before, &corners.after]
                .into_iter()
                .flat_map(|corners| corners.iter().chain([&STILL]).map(|&[x, y, z]| [x, y, z, 0.0]))
                .collect(),
        }
    }

    /// Notes how surfaces pass through each other, and which nodes are led out of colliders, and gives what kernels know of it:
    /// `surface_knots`.
    pub fn put_tangle(&mut self, tangle: Option<&Tangle>, lifts: &[Lift], surfaces: &Surfaces) -> Vec<u32> {
        let first = self.first;
        let all_pulls = tangle.map_or(&[][..], |tangle| &tangle.pulls).iter();
        let is_free = |pull: &&Pull| {
            let [a, b, c] = pull.triangle;
            !are_led_apart(lifts, surfaces.places, [pull.node, a, b, c])
        };
        let pulls: Vec<&Pull> = all_pulls.filter(is_free).collect();
        let is_here = |lift: &&Lift| (first..first + self.places).contains(&(lift.node as usize));
        let led: Vec<&Lift> = lifts.iter().filter(is_here).collect();
        self.words[layout::IS_TANGLED] = u32::from(tangle.is_some() || !led.is_empty());
        self.words[layout::PULL_COUNT] = (led.len() + pulls.len()) as u32;
        if self.words[layout::IS_TANGLED] == 0 {
            return Vec::new();
        }
        let knot = |place: usize| tangle.map_or(Knot::default(), |tangle| tangle.knots()[place]);
        let own = (first..first + self.places).chain(surfaces.places..surfaces.all_places()).map(knot);
        let mut words: Vec<u32> = own.chain([Knot::default()]).flat_map(|knot| knot_words(&knot)).collect();
        let local = |place: u32| match place as usize {
            place if place < surfaces.places => (place - first) as u32,
            corner => (corner - surfaces.places + self.places) as u32,
        };
        for lift in &led {
            words[layout::KNOT_WORDS * local(lift.node) as usize + layout::KNOT_LED] = 1;
        }
        let still = (self.all_places() - 1) as u32;
        words.extend(led.iter().flat_map(|lift| lift_words(lift, surfaces, [local(lift.node), still])));
        words.extend(pulls.iter().flat_map(|pull| pull_words(pull, surfaces, local)));
        words
    }

    /// Pulls that lead surfaces back.
    pub fn pulls(&self) -> usize {
        self.words[layout::PULL_COUNT] as usize
    }

    /// Notes how much room there is.
    pub fn put_room(&mut self, room: Room) {
        self.words[layout::PAIR_ROOM] = room.pairs as u32;
        self.words[layout::CONTACT_ROOM] = room.contacts as u32;
        self.words[layout::IMPULSE_ROOM] = room.impulses as u32;
        self.words[layout::ROUND_ROOM] = room.rounds as u32;
        self.words[layout::JAM_ROOM] = room.jams as u32;
        self.words[layout::PUSH_ROOM] = room.pushes as u32;
    }

    /// Words of `surface_work`.
    pub fn work(&self, room: Room) -> usize {
        self.marks_end() + 9 * room.contacts + 2 * self.buckets()
    }

    fn marks_end(&self) -> usize {
        layout::LISTS + 6 * self.all_places() + self.leaves
    }

    /// Where the list of the next forces in buckets begins in it, and where that of the first ones.
    pub fn force_lists(&self, room: Room) -> [usize; 2] {
        [8, 9].map(|lists| self.marks_end() + lists * room.contacts)
    }

    /// `surface_places` at the start: corners of colliders are where they stay.
    pub fn start(&self) -> Vec<Four> {
        let mut all = vec![[0.0; 4]; layout::PLACE_ARRAYS * self.all_places()];
        for array in [layout::BEFORE, layout::AFTER] {
            let first = array * self.all_places() + self.places;
            for (place, [x, y, z]) in all[first..].iter_mut().zip(&self.corners) {
                *place = [*x, *y, *z, 0.0];
            }
        }
        all
    }

    /// Boxes of all levels.
    pub fn boxes(&self) -> usize {
        self.levels.iter().map(|[_, count]| count).sum()
    }

    fn put_sizes(&mut self, surfaces: &Surfaces) {
        let is_solved = self.is_solved;
        let buckets = self.buckets();
        let mut put = |word: usize, number: usize| self.words[word] = number as u32;
        put(layout::NODE_PLACES, self.places);
        put(layout::ALL_PLACES, self.places + self.corners.len());
        put(layout::LEAF_COUNT, self.leaves);
        put(layout::TOP_LEVEL, self.levels.len() - 1);
        for (level, [first, count]) in self.levels.iter().enumerate() {
            put(layout::LEVEL_BOXES + 2 * level, *first);
            put(layout::LEVEL_BOXES + 2 * level + 1, *count);
        }
        put(layout::MATERIAL_COUNT, surfaces.materials.len());
        put(layout::IS_SOLVED, usize::from(is_solved));
        put(layout::BUCKETS, buckets);
        let cap = surfaces.longest_way();
        let allowance = ALLOWANCE * surfaces.mean_edge;
        let change = 0.5 * SHARE * allowance;
        let lengths = [
            (layout::LONGEST_WAY, cap as f32),
            (layout::SQUARED_WAY, last_within(|squared| bound_of(squared.into()) > cap)),
            (
                layout::SQUARED_PROGRESS,
                last_within(|squared| f64::from(squared.sqrt()) >= PROGRESS * cap).next_up(),
            ),
            (layout::SQUARED_CHANGE, (change * change * 0.999) as f32),
            (layout::ALLOWANCE, allowance as f32),
            (layout::THICKEST, surfaces.thickest as f32),
            (layout::LONGEST_EDGE, (STRETCH * surfaces.longest_edge) as f32),
        ];
        for (word, length) in lengths {
            self.words[word] = length.to_bits();
        }
    }

    /// Adds a table, and notes where it begins.
    fn add(&mut self, word: usize, words: impl Iterator<Item = u32>) {
        self.words[word] = self.words.len() as u32;
        self.words.extend(words);
    }

    /// Adds a list for each place; what always stands still has none.
    fn add_lists(&mut self, [starts_at, items_at]: [usize; 2], lists: impl Iterator<Item = Vec<u32>>) {
        let (mut starts, mut items) = (vec![0], Vec::new());
        for list in lists.chain([Vec::new()]) {
            items.extend(list);
            starts.push(items.len() as u32);
        }
        self.add(starts_at, starts.into_iter());
        self.add(items_at, items.into_iter());
    }

    /// Adds the triangles around each place.
    fn add_fans(&mut self, surfaces: &Surfaces, bodies: &Bodies<'_>, local: impl Fn(u32) -> u32) {
        let fan = |place: usize| surfaces.fan(place as u32).flatten().map(&local).collect();
        self.add_lists([layout::FANS_AT, layout::FAN_ITEMS_AT], places(surfaces, bodies).map(fan));
    }

    /// Adds what is known of places: their leaves, where they were at the start, and whether they have a surface.
    fn add_places(&mut self, surfaces: &Surfaces, bodies: &Bodies<'_>) {
        let places: Vec<usize> = places(surfaces, bodies).collect();
        let lists = surfaces.leaves_by_place();
        let of_place = |&place: &usize| lists.of(place).to_vec();
        self.add_lists([layout::LEAVES_OF_AT, layout::LEAF_ITEMS_AT], places.iter().map(of_place));
        let start = |&place: &usize| surfaces.start[place].map(|x| (x as f32).to_bits());
        self.add(layout::START_AT, places.iter().flat_map(start).chain([0; 3]));
        let has_surface = |&place: &usize| u32::from(surfaces.surface_of[place] != u32::MAX);
        self.add(layout::HAS_SURFACE_AT, places.iter().map(has_surface).chain([0]));
    }
}

/// The places of some bodies, and then those of corners of colliders.
fn places(surfaces: &Surfaces, bodies: &Bodies<'_>) -> impl Iterator<Item = usize> {
    bodies.places.clone().chain(surfaces.places..surfaces.all_places())
}

/// Whether some bodies have systems that are solved for by nodes.
fn is_solved(Bodies { assembly, range, .. }: &Bodies<'_>) -> bool {
    assembly.solver.is_primal() && range.clone().any(|body| assembly.is_solved_for(body))
}

/// The first box of each level, and how many it has: those of leaves, then each around up to sixteen.
fn levels(leaves: usize) -> Vec<[usize; 2]> {
    let mut all = vec![[0, leaves]];
    while let Some(&[first, count]) = all.last().filter(|[_, count]| *count > 1) {
        all.push([first + count, count.div_ceil(layout::LEAF_GROUP)]);
    }
    all
}

/// The largest number for which a condition that holds from some number on does not hold.
fn last_within(holds: impl Fn(f32) -> bool) -> f32 {
    // Bits of positive numbers have the order of the numbers.
    let (mut low, mut high) = (0, f32::MAX.to_bits());
    while low + 1 < high {
        let middle = low + (high - low) / 2;
        if holds(f32::from_bits(middle)) { high = middle } else { low = middle }
    }
    f32::from_bits(low)
}

/// The words of a leaf.
fn leaf_words(leaf: &Leaf, local: impl Fn(u32) -> u32) -> [u32; layout::LEAF_WORDS] {
    let mut all = [0; layout::LEAF_WORDS];
    for (word, &node) in all.iter_mut().zip(&leaf.nodes) {
        *word = local(node);
    }
    all[layout::LEAF_NODES] = leaf.count as u32;
    all[layout::LEAF_MATERIAL] = leaf.material;
    all[layout::LEAF_HELD] = u32::from(leaf.held);
    all[layout::LEAF_COUNTS] = packed(leaf.counts.map(|count| count as u8));
    for (word, &triangle) in all[layout::LEAF_TRIANGLES..].iter_mut().zip(&leaf.triangles) {
        *word = packed(triangle);
    }
    for (word, &[a, b]) in all[layout::LEAF_EDGES..].iter_mut().zip(&leaf.edges) {
        *word = packed([a, b, 0]);
    }
    for (word, four) in all[layout::LEAF_VERTICES..].iter_mut().zip(leaf.vertices.chunks(4)) {
        *word = (0..).zip(four).map(|(at, &lane)| u32::from(lane) << (8 * at)).sum();
    }
    all
}

fn knot_words(knot: &Knot) -> [u32; layout::KNOT_WORDS] {
    let Knot { of, next, astray, above, loose } = *knot;
    let mut words = [0; layout::KNOT_WORDS];
    for (at, two) in [
        (layout::KNOT_OF, of),
        (layout::KNOT_NEXT, next),
        (layout::KNOT_ASTRAY, astray),
        (layout::KNOT_ABOVE, above),
        (layout::KNOT_LOOSE, loose),
    ] {
        words[at..at + 2].copy_from_slice(&two);
    }
    words
}

fn pull_words(pull: &Pull, surfaces: &Surfaces, local: impl Fn(u32) -> u32) -> [u32; layout::PULL_WORDS] {
    let [a, b, c] = pull.triangle;
    let nodes = [pull.node, a, b, c].map(local);
    words_of(nodes, pull.weights_of_nodes(), pull.direction, surfaces.thickness_of_pull(pull))
}

/// A node that is led out of a collider, as a contact with what stands still.
fn lift_words(lift: &Lift, surfaces: &Surfaces, [node, still]: [u32; 2]) -> [u32; layout::PULL_WORDS] {
    let [gap, thickness] = surfaces.gap_of_lift();
    let mut words = words_of([node, still, still, still], [1.0, -1.0, 0.0, 0.0], lift.way, [-gap, thickness]);
    words[layout::PULL_LED] = 1;
    words
}

fn words_of(
    nodes: [u32; 4],
    weights: [f64; 4],
    direction: [f64; 3],
    lengths: [f64; 2],
) -> [u32; layout::PULL_WORDS] {
    let mut words = [0; layout::PULL_WORDS];
    words[..4].copy_from_slice(&nodes);
    let mut put = |at: usize, numbers: &[f64]| {
        for (word, number) in words[at..].iter_mut().zip(numbers) {
            *word = (*number as f32).to_bits();
        }
    };
    put(layout::PULL_WEIGHTS, &weights);
    put(layout::PULL_DIRECTION, &direction);
    put(layout::PULL_THICKNESS, &lengths);
    words
}

fn packed([a, b, c]: [u8; 3]) -> u32 {
    u32::from(a) | u32::from(b) << 8 | u32::from(c) << 16
}

/// Two lanes a word.
fn mask_words(mask: &Mask) -> impl Iterator<Item = u32> + '_ {
    mask.chunks(2).map(|two| u32::from(two[0]) | u32::from(two[1]) << 16)
}

/// Thickness and friction of all pairs of materials; the thickness is below zero where they do not touch.
fn materials(surfaces: &Surfaces) -> impl Iterator<Item = u32> + '_ {
    let count = surfaces.materials.len() as u32;
    let pairs = (0..count).flat_map(move |a| (0..count).map(move |b| [a, b]));
    pairs.flat_map(|pair| {
        surfaces.material(pair).unwrap_or([-1.0, 0.0]).map(|number| (number as f32).to_bits())
    })
}

const _: () = assert!(ROUNDS <= FILTERS && IMPULSES_WRITTEN <= IMPULSES);
