//! Rows of surfaces that touch each other.

use crate::contact::colliders::gpu::Contact;
use crate::contact::nodes::parity::{collided_again, same};
use crate::contact::triangles::gpu::order_of;
use crate::contact::triangles::gpu_layout::{self as layout, FORCE_RECORDS, SolvedContact, SurfaceContact};
use crate::contact::triangles::parity_count::count;
use crate::contact::triangles::parity_scene::fixture;
use crate::contact::triangles::parity_stages::{Before, Solving};
use crate::contact::triangles::slide::{away, part};
use crate::contact::triangles::twin::Twin;
use crate::gpu::kernels::Name;
use crate::gpu::layout::{Four, NONE};
use crate::parity::bench::{Bench, Given, Written};
use crate::parity::fixture::{Arrays, Fixture, State, words};
use crate::parity::row::{Row, Tolerance};
use crate::solvers::explicit::parity::kernel_of;
use taffeta_gpu::bytemuck::Pod;

pub const COPIED: &str = "numbers alone";
pub const MOVED: &str = "the same operations in the same order; hardware may fuse products and sums";
const FOUND: &str = "as above; closest points of pairs that are nearly parallel are where rounding puts them";

/// One row for each kernel.
pub const ROWS: &[Row] = &[
    row("keep_places", 0.0, COPIED, |bench| {
        each(bench, "keep_places", &[Before::Keep], |twin, fixture| twin.keep_places(&fixture.old.position))
    }),
    row("take_places", 0.0, COPIED, |bench| {
        each(bench, "take_places", &[Before::Take], |twin, _| twin.take_places())
    }),
    row("bound_leaves", 0.0, COPIED, |bench| {
        each(bench, "bound_leaves", &[Before::Bounds], |twin, _| twin.bound_leaves())
    }),
    row("bound_level", 0.0, COPIED, |bench| {
        each(bench, "bound_level", &[Before::Levels], |twin, _| twin.bound_level())
    }),
    row("list_leaf_pairs", 0.0, COPIED, list),
    row("take_start", 0.0, COPIED, |bench| {
        while_solving(bench, "take_start", &[Solving::Take], Twin::take_start)
    }),
    row("find_surface_contacts", 4096.0, FOUND, |bench| {
        each(bench, "find_surface_contacts", &[Before::Find], |twin, _| twin.find_surface_contacts())?;
        let stages = [Solving::Find, Solving::FindAgain];
        while_solving(bench, "find_surface_contacts", &stages, Twin::find_surface_contacts)
    }),
    row("keep_solved", 0.0, COPIED, |bench| {
        while_solving(bench, "keep_solved", &[Solving::Keep], Twin::keep_solved)
    }),
    row("add_pulls", 64.0, MOVED, |bench| {
        each(bench, "add_pulls", &[Before::Pulls], |twin, _| twin.add_pulls())?;
        while_solving(bench, "add_pulls", &[Solving::Find, Solving::FindAgain], Twin::add_pulls)
    }),
    row("place_parts", 0.0, COPIED, |bench| {
        each(bench, "place_parts", &[Before::Place], |twin, _| twin.place_parts())
    }),
    row("fill_parts", 0.0, COPIED, |bench| {
        each(bench, "fill_parts", &[Before::Fill], |twin, _| twin.fill_parts())
    }),
    row("sort_parts", 0.0, COPIED, |bench| {
        each(bench, "sort_parts", &[Before::Sort], |twin, _| twin.sort_parts())
    }),
    row("correct_impulses", 512.0, MOVED, |bench| {
        each(bench, "correct_impulses", &[Before::FirstImpulses, Before::Impulses], |twin, _| {
            twin.correct_impulses()
        })?;
        while_solving(bench, "correct_impulses", &[Solving::Impulses], Twin::correct_impulses)
    }),
    row("apply_impulses", 512.0, MOVED, |bench| {
        each(bench, "apply_impulses", &[Before::FirstApply, Before::Apply], apply)
    }),
    row("note_forces", 64.0, MOVED, |bench| {
        each(bench, "note_forces", &[Before::Forces], |twin, _| twin.note_forces())?;
        while_solving(bench, "note_forces", &[Solving::Forces], Twin::note_forces)
    }),
    row("measure_places", 0.0, COPIED, |bench| {
        each(bench, "measure_places", &[Before::Far], |twin, _| twin.measure_places())
    }),
    row("advance_corners", 64.0, MOVED, |bench| {
        each(bench, "advance_corners", &[Before::Corners, Before::NextCorners, Before::AtRest], |twin, _| {
            twin.advance_corners()
        })
    }),
    row("push_nodes", 4096.0, FOUND, |bench| {
        each(
            bench,
            "push_nodes",
            &[Before::Push, Before::NextPush, Before::Squeeze, Before::Stop, Before::LastStop],
            |twin, _| twin.push_nodes(),
        )
    }),
    row("take_pushes", 64.0, MOVED, |bench| {
        each(
            bench,
            "take_pushes",
            &[Before::Stuck, Before::TakePushes, Before::Restart, Before::TakeStops],
            |twin, _| twin.take_pushes(),
        )
    }),
    row("measure_ways", 64.0, MOVED, |bench| {
        each(bench, "measure_ways", &[Before::Measure, Before::NextRound], |twin, _| twin.measure_ways())
    }),
    row("go_part", 64.0, MOVED, |bench| {
        each(bench, "go_part", &[Before::Part, Before::NextRound], |twin, _| twin.go_part())
    }),
    // A direction may be rounded to another step.
    row("limit_ways", 65536.0, FOUND, |bench| {
        each(bench, "limit_ways", &[Before::Limits, Before::LimitsAround, Before::LimitsOfAll], |twin, _| {
            twin.limit_ways()
        })
    }),
    row("mark_held", 0.0, COPIED, |bench| {
        each(bench, "mark_held", &[Before::LimitsAround, Before::NextRound], |twin, _| twin.mark_held())
    }),
    row("hold_back", 64.0, MOVED, |bench| {
        let stages = [Before::LimitsAround, Before::NextRound, Before::LastRound];
        each(bench, "hold_back", &stages, |twin, fixture| {
            let met = fixture.substep().met_colliders();
            twin.hold_back(&|place| met.at(place));
        })
    }),
    row("count_surfaces", 0.0, COPIED, count),
];

pub const fn row(
    name: &'static str,
    hardware: f64,
    why: &'static str,
    check: fn(&mut Bench<'_>) -> Result<(), String>,
) -> Row {
    Row { name, entry: name, tolerance: Tolerance::new(0.0, hardware, why), check }
}

impl Twin {
    /// Puts its arrays among those that kernels are given, but for the state.
    pub fn put_arrays(&self, arrays: &mut Arrays) {
        arrays.extend([
            ("surface_tables", self.tables.clone()),
            ("surface_part", vec![self.part]),
            ("surface_knots", self.knots.clone()),
            ("surface_places", words(&self.places)),
            ("surface_boxes", words(&self.boxes)),
            ("surface_pairs", words(&self.pairs)),
            ("surface_contacts", words(&self.contacts)),
            ("solved_contacts", words(&self.solved)),
            ("surface_forces", words(&self.forces)),
            ("surface_work", self.work.clone()),
            ("surface_counts", self.counts.clone()),
        ]);
    }

    /// Puts the lists of parts of nodes, where they stand without gaps in any order, into the order of nodes.
    fn stand_in_order(&mut self) {
        let [counts, starts, filled] = [0, 1, 2].map(|list| self.list(list));
        let [parts, sorted, ..] = self.lists_of_contacts();
        let mut all: Vec<usize> = (0..self.nodes()).filter(|node| self.work[counts + node] > 0).collect();
        let ends = |twin: &Self, node: usize| {
            let start = twin.work[starts + node];
            [start, start.wrapping_add(twin.work[counts + node])]
        };
        all.sort_by_key(|&node| ends(self, node));
        let whole = all.iter().try_fold(0, |end, &node| {
            let [start, next] = ends(self, node);
            (start == end).then_some(next)
        });
        if whole != Some(self.work[layout::PARTS]) || parts + self.work[layout::PARTS] as usize > sorted {
            return;
        }
        all.sort_unstable();
        let (old, mut at) = (self.work.clone(), 0);
        for node in all {
            let (start, count) = (old[starts + node] as usize, old[filled + node].min(old[counts + node]));
            self.work[starts + node] = at as u32;
            for list in [parts, sorted] {
                let from = list + start..list + start + count as usize;
                self.work[list + at..][..count as usize].copy_from_slice(&old[from]);
            }
            at += old[counts + node] as usize;
        }
    }

    /// Puts lists that are filled in any order into one order, and what only says where these stand. A kernel at fault may count on.
    fn normalise(&mut self) {
        let count = |twin: &Self, word: usize| twin.work[word] as usize;
        let contacts = count(self, layout::CONTACTS).min(self.contacts.len());
        let mut numbers: Vec<usize> = (0..contacts).collect();
        numbers.sort_by_key(|&number| {
            let order = self.contacts[number].order;
            (order[0] != NONE, order_of(order))
        });
        let sorted: Vec<_> =
            numbers.iter().map(|&number| (self.contacts[number], self.solved[number])).collect();
        for (at, sorted) in sorted.into_iter().enumerate() {
            (self.contacts[at], self.solved[at]) = sorted;
        }
        let touched = self.list(5);
        let all_touched = touched..self.list(6).min(touched + count(self, layout::TOUCHED));
        self.work[all_touched].sort_unstable();
        self.stand_in_order();
        let [parts, _, next, first] = self.lists_of_contacts();
        for node in 0..self.tables[layout::NODE_PLACES] as usize {
            let start = (parts + count(self, self.list(1) + node)).min(next);
            let end = (start + count(self, self.list(2) + node)).min(next);
            self.work[start..end].sort_unstable();
        }
        let forces = count(self, layout::FORCES).min(self.forces.len() / FORCE_RECORDS);
        let mut pairs: Vec<_> =
            self.forces[..FORCE_RECORDS * forces].chunks_exact(FORCE_RECORDS).map(<[_]>::to_vec).collect();
        pairs.sort_unstable();
        // Each force is in the list of its bucket. Nobody writes where the lists of the last sub-step begin, whose links are written over.
        let buckets = self.tables[layout::BUCKETS] as usize;
        let start = first + if self.work[layout::IS_ODD] == 0 { buckets } else { 0 };
        let mut chained = 0;
        for at in start..start + buckets {
            let mut number = self.work[at];
            while number != u32::MAX && chained <= 2 * forces {
                chained += 1;
                number = self.work.get(next + number as usize).copied().unwrap_or(u32::MAX);
            }
            self.work[at] = 0;
        }
        self.work[start] = chained as u32;
        self.work[next..next + forces].fill(0);
        for (to, records) in self.forces.chunks_exact_mut(FORCE_RECORDS).zip(pairs) {
            to.copy_from_slice(&records);
        }
    }
}

/// Nodes in contact go where impulses lead them, and colliders act on them again.
pub fn apply(twin: &mut Twin, fixture: &mut Fixture) {
    fixture.new = State { position: twin.position.clone(), velocity: twin.velocity.clone() };
    let (mut moved, states) = (fixture.new.clone(), twin.apply_impulses());
    let mut is_moved = vec![false; moved.position.len()];
    for (node, state) in states {
        moved.position[node][..3].copy_from_slice(&state[..3]);
        moved.velocity[node][..3].copy_from_slice(&state[3..]);
        is_moved[node] = true;
    }
    let after = collided_again(fixture, moved, |place| is_moved[place]);
    (twin.position, twin.velocity) = (after.position, after.velocity);
}

/// Runs a kernel, where it is next in a sub-step, and compares what it and its twin have made of the arrays.
fn each(
    bench: &mut Bench<'_>,
    entry: &'static str,
    stages: &[Before],
    work: impl Fn(&mut Twin, &mut Fixture),
) -> Result<(), String> {
    for &stage in stages {
        let mut fixture = fixture(31 + stage as u64)?;
        let twin = Twin::before(stage, &mut fixture);
        run(bench, entry, &mut fixture, twin, &work)?;
    }
    Ok(())
}

/// The same where contacts are part of a system.
fn while_solving(
    bench: &mut Bench<'_>,
    entry: &'static str,
    stages: &[Solving],
    work: fn(&mut Twin),
) -> Result<(), String> {
    for &stage in stages {
        let mut fixture = fixture(71 + stage as u64)?;
        let twin = Twin::while_solving(stage, &fixture);
        run(bench, entry, &mut fixture, twin, |twin, _| work(twin))?;
    }
    Ok(())
}

/// Compares a kernel with its twin.
pub fn run(
    bench: &mut Bench<'_>,
    entry: &'static str,
    fixture: &mut Fixture,
    twin: Twin,
    work: impl Fn(&mut Twin, &mut Fixture),
) -> Result<(), String> {
    let kernel = kernel_of(bench, Name::new(entry).with(Contact::Solids.choices()), fixture)?;
    let mut arrays = fixture.arrays();
    twin.put_arrays(&mut arrays);
    arrays.insert("new_position", words(&twin.position));
    arrays.insert("new_velocity", words(&twin.velocity));
    let mut wanted = twin.clone();
    work(&mut wanted, fixture);
    // Kernels of leaf pairs have a workgroup for each of these.
    let groups = match entry {
        "count_surfaces" => 1,
        _ => (twin.work[layout::PAIRS] as usize).max(twin.work.len() / 256),
    };
    let records = fixture.records();
    bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
        compare(written, twin, wanted);
    })
}

/// Takes an array that a kernel may have written.
fn taken<T: Pod>(written: &mut Written<'_>, name: &str, to: &mut Vec<T>) {
    let found = written.take::<T>(name);
    if !found.is_empty() {
        *to = found;
    }
}

/// Compares arrays, of which the kernel has written some and left the others as they were in `found`.
pub fn compare(written: &mut Written<'_>, mut found: Twin, mut wanted: Twin) {
    taken(written, "surface_places", &mut found.places);
    taken(written, "surface_boxes", &mut found.boxes);
    taken(written, "surface_pairs", &mut found.pairs);
    taken(written, "surface_contacts", &mut found.contacts);
    taken(written, "solved_contacts", &mut found.solved);
    taken(written, "surface_forces", &mut found.forces);
    taken(written, "surface_work", &mut found.work);
    taken(written, "surface_counts", &mut found.counts);
    taken(written, "new_position", &mut found.position);
    taken(written, "new_velocity", &mut found.velocity);
    found.normalise();
    wanted.normalise();
    let fours = |written: &mut Written<'_>, name: &str, wanted: &[Four], found: &[Four]| {
        written.compare_fours(name, wanted, found);
    };
    fours(written, "places", &wanted.places, &found.places);
    fours(written, "boxes", &wanted.boxes, &found.boxes);
    fours(written, "new_position", &wanted.position, &found.position);
    fours(written, "new_velocity", &wanted.velocity, &found.velocity);
    same(written, "surface_pairs", wanted.pairs.as_flattened(), found.pairs.as_flattened());
    same(written, "surface_counts", &wanted.counts, &found.counts);
    let floats = |all: &[SurfaceContact], which: usize| -> Vec<f32> {
        let of_one = |one: &SurfaceContact| match which {
            0 => one.weights.to_vec(),
            1 => one.normal.to_vec(),
            2 => vec![one.gap, one.thickness],
            3 => one.impulse.to_vec(),
            4 => one.force.to_vec(),
            5 => vec![one.mobility],
            6 => vec![one.push],
            7 => one.solved.to_vec(),
            8 => vec![one.grip],
            _ => vec![one.friction],
        };
        all.iter().flat_map(of_one).collect()
    };
    for (which, name) in [
        "weights", "normals", "gaps", "impulses", "forces", "mobility", "pushes", "solved", "grip",
        "friction",
    ]
    .iter()
    .enumerate()
    {
        written.outcome().compare(name, &floats(&wanted.contacts, which), &floats(&found.contacts, which));
    }
    let whole = |all: &[SurfaceContact]| -> Vec<u32> {
        all.iter().flat_map(|one| one.nodes.into_iter().chain(one.order).chain([one.leads])).collect()
    };
    same(written, "contacts", &whole(&wanted.contacts), &whole(&found.contacts));
    compare_solved(written, &wanted.solved, &found.solved);
    let orders =
        |all: &[[u32; 4]]| -> Vec<u32> { all.iter().step_by(FORCE_RECORDS).flatten().copied().collect() };
    same(written, "orders of forces", &orders(&wanted.forces), &orders(&found.forces));
    let vectors = |all: &[[u32; 4]]| -> Vec<f32> {
        let of_one = |records: &[[u32; 4]]| records[1..].as_flattened().to_vec();
        all.chunks_exact(FORCE_RECORDS).flat_map(of_one).map(f32::from_bits).collect()
    };
    written.outcome().compare("last forces", &vectors(&wanted.forces), &vectors(&found.forces));
    compare_work(written, &wanted, &found);
}

/// Compares contacts as systems know them.
fn compare_solved(written: &mut Written<'_>, wanted: &[SolvedContact], found: &[SolvedContact]) {
    let whole = |all: &[SolvedContact]| -> Vec<u32> {
        all.iter().flat_map(|one| one.nodes.into_iter().chain([one.system, one.is_held])).collect()
    };
    same(written, "contacts of systems", &whole(wanted), &whole(found));
    let numbers = |one: &SolvedContact, which: usize| -> Vec<f32> {
        match which {
            0 => one.weights.to_vec(),
            1 => one.normal.to_vec(),
            2 => vec![one.gap, one.lead],
            3 => one.first.to_vec(),
            4 => one.impulse.to_vec(),
            5 => one.applied.to_vec(),
            6 => vec![one.along, one.across, one.stiffness],
            _ => vec![one.friction],
        }
    };
    // Each by itself: those of contacts that give way and of others have little in common.
    for (wanted, found) in wanted.iter().zip(found) {
        for which in 0..8 {
            let name = format!("contacts of systems, {which}");
            written.outcome().compare(&name, &numbers(wanted, which), &numbers(found, which));
        }
    }
}

/// Compares what is counted: numbers, and the bits of lengths.
fn compare_work(written: &mut Written<'_>, wanted: &Twin, found: &Twin) {
    let limits = wanted.list(3)..wanted.list(4);
    let lengths = [
        layout::SINKS,
        layout::NEAREST,
        layout::WAY,
        layout::CHANGE_OF_WAY,
        layout::FARTHEST_PLACE,
        layout::PROGRESS,
        layout::WAY_TAKEN,
        layout::MOST_WAY_TAKEN,
    ];
    for word in lengths {
        let [wanted, found] = [wanted, found].map(|twin| [f32::from_bits(twin.work[word])]);
        written.outcome().compare(&format!("length {word}"), &wanted, &found);
    }
    let limited = |twin: &Twin| {
        let words = twin.work[limits.clone()].iter();
        words.flat_map(|&word| away(word).into_iter().chain([part(word)])).collect::<Vec<f32>>()
    };
    written.outcome().compare("limits", &limited(wanted), &limited(found));
    // Where colliders push nodes, the first lists are keys of ways, or parts of ways.
    let ways = if wanted.work[layout::LISTED] == layout::CARRIED as u32 {
        wanted.list(0)..wanted.list(3)
    } else {
        0..0
    };
    let [pushes, of_found] = [wanted, found]
        .map(|twin| twin.work[ways.clone()].iter().map(|&key| twin.sent(key)).collect::<Vec<_>>());
    written.outcome().compare("pushes", &pushes, &of_found);
    let numbers = |twin: &Twin| {
        let mut all = twin.work.clone();
        lengths.iter().for_each(|&word| all[word] = 0);
        all[limits.clone()].fill(0);
        all[ways.clone()].fill(0);
        all
    };
    same(written, "surface_work", &numbers(wanted), &numbers(found));
}

/// Pairs of leaves that matter are listed, each once, and none that are far apart.
fn list(bench: &mut Bench<'_>) -> Result<(), String> {
    // By kind, the last one while a system is solved for.
    let stages =
        [Some(Before::List), Some(Before::LimitsAround), Some(Before::LimitsOfAll), Some(Before::Push), None];
    for (kind, stage) in stages.into_iter().enumerate() {
        let mut fixture = fixture(41 + kind as u64)?;
        let mut twin = match stage {
            Some(stage) => Twin::before(stage, &mut fixture),
            None => Twin::while_solving(Solving::Find, &fixture),
        };
        (twin.work[layout::PAIRS], twin.work[layout::LISTED]) = (0, kind as u32);
        let kernel = kernel_of(bench, Name::new("list_leaf_pairs"), &fixture)?;
        let mut arrays = fixture.arrays();
        arrays.insert("surface_tables", twin.tables.clone());
        arrays.insert("surface_boxes", words(&twin.boxes));
        arrays.insert("surface_pairs", words(&twin.pairs));
        arrays.insert("surface_work", twin.work.clone());
        let (records, groups) = (fixture.records(), 4);
        bench.run(&kernel, &Given { arrays: &arrays, records: &records, groups }, |written| {
            let boxes: Vec<Four> = written.take("surface_boxes");
            written.compare_fours("surface_boxes", &twin.boxes, &boxes);
            let pairs: Vec<[u32; 4]> = written.take("surface_pairs");
            let work: Vec<u32> = written.take("surface_work");
            let mut listed: Vec<[u32; 3]> = pairs
                .iter()
                .take(work[layout::PAIRS] as usize)
                .map(|&[a, b, ring, _]| [a, b, ring])
                .collect();
            listed.sort_unstable();
            let [least, most] = twin.listed_pairs();
            // What is neither listed for certain nor certainly not is taken as it is.
            listed.retain(|pair| !most.contains(pair) || least.contains(pair));
            same(written, &format!("pairs of kind {kind}"), least.as_flattened(), listed.as_flattened());
            let apart = |word: usize| word != layout::PAIRS;
            let rest = |all: &[u32]| {
                (0..all.len()).filter(|&word| apart(word)).map(|word| all[word]).collect::<Vec<_>>()
            };
            same(written, "surface_work", &rest(&twin.work), &rest(&work));
        })?;
    }
    Ok(())
}
