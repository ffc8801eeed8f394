//! The arrays of springs that are solved for by nodes, as rows compare them.

use crate::gpu::layout::{Four, Solving};
use crate::parity::bench::Written;
use crate::parity::fixture::{Arrays, Chance, Fixture, words};
use crate::solvers::dual::gpu_layout::{ContactRecord, SolveStatistics};
use crate::solvers::dual::parity::{records, some_contact, statistics};
use crate::solvers::implicit::couplings_twin::{OfElements, any_blocks};
use crate::solvers::implicit::gpu_layout::{
    CoarseEdge, Diagonal, LevelGroup, NodeSolve, PcgState, SUMS, Symmetric, VECTORS,
};
use crate::solvers::implicit::implicit::{LEFT, MOST_STEPS};
use crate::solvers::implicit::twin::{Twin, Work};
use taffeta_gpu::bytemuck::Pod;
use taffeta_gpu::{Access, Kernel};

/// A number that no kernel may take for another.
pub const POISON: u32 = 0x7fff_fff1;

/// Cases of a system's progress, and of all systems' when they are done.
pub const CASES: usize = 12;
pub const DONE: usize = 5;

/// The progress of a system of that case, whose sums are `sums`.
fn descent(chance: &mut Chance, case: usize, sums: Four, solving: &Solving) -> PcgState {
    let mut number = || chance.number().abs();
    let mut some = PcgState {
        passes: 5,
        is_done: 0,
        iterations: 3,
        whole: 1e-9,
        error: number(),
        alpha: number(),
        beta: number(),
    };
    // The tolerance is a power of two: divided and multiplied, a number is the same.
    let limit = |share: f32| share / solving.tolerance_squared;
    match case {
        0 | 1 => (some.passes, some.iterations, some.whole) = (1, 0, case as f32 * some.error),
        2 => (some.passes, some.iterations, some.error, some.alpha) = (2, 0, 0.0, 0.0),
        3 => some.is_done = 1,
        4 => some.whole = 1e9,
        // Without an error before, the system answers.
        5 => (some.whole, some.error) = (limit(sums[0]), 0.0),
        6 => (some.whole, some.error) = (limit(sums[0]).next_down(), 0.0),
        7 => (some.iterations, some.error) = (solving.most_iterations - 1, 0.0),
        8 => (some.passes, some.iterations, some.whole) = (2, 0, 1e9),
        9 => some.error = f32::NAN,
        // The direction before is half of the new one, and the system answers half as much as along the residual.
        11 => (some.error, some.alpha) = (2.0 * sums[0], sums[0] / sums[1]),
        _ => {}
    }
    some
}

/// Arrays by chance; systems at every case of progress.
pub fn work(fixture: &Fixture, solving: &Solving, shift: usize, in_contact: bool) -> Work {
    let (multigrid, mut chance) = (&fixture.tables.multigrid, Chance::new(17 + shift as u64));
    let (places, [fine, coarse]) = (fixture.tables.len(), multigrid.slot_counts);
    let mut work = Work {
        blocks: (0..fine).map(|_| four(&mut chance, 0.7)).collect(),
        coarse: vec![Symmetric::default(); coarse],
        diagonals: (0..multigrid.nodes).map(|_| some_diagonal(&mut chance)).collect(),
        vectors: (0..VECTORS * multigrid.nodes).map(|_| four(&mut chance, 1.3)).collect(),
        predicted_contacts: vec![ContactRecord { slides: 1.0, ..ContactRecord::default() }; places],
        solves: vec![NodeSolve::default(); multigrid.solves],
        sums: (0..SUMS * multigrid.groups[0].len()).map(|_| four(&mut chance, 0.9).map(f32::abs)).collect(),
        force: fixture.force_fours().iter().map(|&[x, y, z, _]| [x, y, z, 0.0]).collect(),
        new_velocity: fixture.new.velocity.clone(),
        new_position: fixture.new.position.clone(),
        elements: of_elements(fixture, &mut chance),
        statistics: [
            SolveStatistics { iterations: 3, capped: 5, active_fraction: 0.1, residual: 1e-6 },
            SolveStatistics { iterations: 3_000, capped: 0, active_fraction: 1.0, residual: 1e9 },
        ][shift % 2],
        steps: [[3, 2, 7, 0], [7, 9, 4, 0], [0, 0, 5, 1]][(shift + 1) % 3],
    };
    if multigrid.couplings.is_some() {
        // Sums of elements' blocks are never flat; others would be inverted to anything.
        work.diagonals[..places].iter_mut().flat_map(|one| &mut one.own.diagonal).for_each(|one| *one += 1.5);
    }
    for edge in multigrid.edges.iter().flatten() {
        let block = symmetric(&mut chance);
        edge.slots.iter().for_each(|&slot| work.coarse[slot as usize] = block);
    }
    let colliders = fixture.substep().colliders().len();
    for place in 0..places {
        let is_free = fixture.old.position[place][3] > 0.0;
        work.predicted_contacts[place] = some_contact(&mut chance, is_free, colliders);
        if !is_free {
            work.predicted_contacts[place].slides = 0.0;
        }
        work.vectors[place][3] = fixture.old.velocity[place][3].abs();
    }
    let mut twin = Twin { fixture, solving: *solving, in_contact, work };
    at_all_cases(&mut twin, &mut chance, shift);
    twin.work
}

/// Blocks, forces and directions by chance, where elements are solved for.
fn of_elements(fixture: &Fixture, chance: &mut Chance) -> OfElements {
    let tables = &fixture.tables;
    let Some(couplings) = &tables.multigrid.couplings else { return OfElements::default() };
    let mut words = couplings.words.clone();
    any_blocks(&mut words, tables.multigrid.nodes, || 0.3 * chance.number());
    let mut fours = |count: usize| (0..count).map(|_| four(chance, 0.8)).collect();
    OfElements {
        words,
        forces: fours(tables.elements.forces()),
        directions: fours(tables.elements.directions()),
    }
}

fn four(chance: &mut Chance, size: f32) -> Four {
    let [x, y, z] = chance.three(size);
    [x, y, z, size * chance.number()]
}

fn symmetric(chance: &mut Chance) -> Symmetric {
    Symmetric { diagonal: chance.three(0.9).map(f32::abs), mixed: chance.three(0.4), ..Symmetric::default() }
}

fn some_diagonal(chance: &mut Chance) -> Diagonal {
    Diagonal { own: symmetric(chance), inverse: symmetric(chance) }
}

fn at_all_cases(twin: &mut Twin<'_>, chance: &mut Chance, shift: usize) {
    let solving = twin.solving;
    let groups = &twin.fixture.tables.multigrid.groups[0];
    for (at, group) in groups.iter().enumerate() {
        // Motions of all sorts: larger than what is left, smaller, none; none without a mass.
        let (momentum, squares) = (groups.len() + at, 2 * groups.len() + at);
        match (group.solve as usize + shift) % 4 {
            0 => twin.work.sums[squares][1] *= 64.0,
            1 => twin.work.sums[momentum][3] = 0.0,
            2 => twin.work.sums[momentum] = [0.0, 0.0, 0.0, 1.0],
            _ => {}
        }
    }
    for (number, solve) in (0..).zip(&mut twin.work.solves) {
        solve.first = number / 2 * 2;
    }
    for number in 0..twin.work.solves.len() {
        let case = (number + shift) % CASES;
        if case == 0 || case == 10 {
            // A system that answers the other way.
            let groups = twin.fixture.tables.multigrid.groups[0].iter().zip(&mut twin.work.sums);
            groups.filter(|(group, _)| group.solve as usize == number).for_each(|(_, sum)| sum[1] *= -1.0);
        }
        let sums = twin.body_sums(number);
        let solve = &mut twin.work.solves[number];
        solve.before = (shift % 3) as u32;
        (solve.steps, solve.is_met) = ((shift % 3) as u32, u32::from((number + shift) % 4 == 1));
        // A further step at its first product is needed, or not.
        solve.motion = sums[0] * if number % 2 == 0 { 2.0 } else { 0.5 } / LEFT as f32;
        solve.kept = descent(chance, case, sums, &solving);
        solve.next = descent(chance, (case + 4) % CASES, [0.5; 4], &solving);
        let Some(case) = (shift + 1).checked_sub(CASES) else { continue };
        // All are done, as well as they can be: one may go on; none need; none has steps left; one has run out of
        // iterations; one is not done.
        (solve.kept.is_done, solve.next.is_done) = (1, u32::from(case != 4 || number != 1));
        (solve.next.error, solve.next.whole) = if number == 0 { (0.0, 0.0) } else { (0.125, 200.0) };
        (solve.steps, solve.is_met) = (MOST_STEPS - 2 + u32::from(case == 2), 1);
        if case % 3 == 0 && number == 1 || case == 2 {
            solve.is_met = 0;
        }
        if case == 3 {
            solve.next.iterations = solving.most_iterations;
        }
    }
}

pub fn arrays(fixture: &Fixture, work: &Work, groups: &[LevelGroup], edges: &[CoarseEdge]) -> Arrays {
    let multigrid = &fixture.tables.multigrid;
    let mut all = fixture.arrays();
    all.extend([
        ("level_groups", words(groups)),
        ("coarse_edges", words(edges)),
        ("slots", words(&multigrid.slots)),
        ("slot_springs", words(&multigrid.slot_springs)),
        ("parents", words(&multigrid.parents)),
        ("children", words(&multigrid.children)),
        ("edge_weights", words(&multigrid.edge_weights)),
        ("level_sizes", words(&multigrid.counted())),
        ("spring_blocks", words(&work.blocks)),
        ("coarse_blocks", words(&work.coarse)),
        ("diagonals", words(&work.diagonals)),
        ("vectors", words(&work.vectors)),
        ("predicted_contacts", words(&work.predicted_contacts)),
        ("node_solves", words(&work.solves)),
        ("product_sums", words(&work.sums)),
        ("level_counts", vec![POISON; 3 * multigrid.counted().len()]),
        ("force", words(&work.force)),
        ("new_velocity", words(&work.new_velocity)),
        ("new_position", words(&work.new_position)),
        ("statistics", words(&[work.statistics])),
        ("written_steps", work.steps.to_vec()),
    ]);
    if let Some(couplings) = &multigrid.couplings {
        all.extend([
            ("couplings", words(&work.elements.words)),
            ("coupling_sources", words(&couplings.sources)),
            ("element_forces", words(&work.elements.forces)),
            ("element_directions", words(&work.elements.directions)),
        ]);
    }
    all
}

/// Compares all that a kernel may write.
pub fn compare(written: &mut Written<'_>, kernel: &Kernel, wanted: &Work, counts: &[u32]) {
    for one in kernel.bindings().iter().filter(|one| one.access == Access::ReadWrite) {
        match one.name.as_str() {
            "spring_blocks" => all_fours(written, "spring_blocks", &wanted.blocks),
            "coarse_blocks" => matrices(written, "coarse_blocks", &wanted.coarse, |block| [*block; 1]),
            "diagonals" => matrices(written, "diagonals", &wanted.diagonals, |one| [one.own, one.inverse]),
            "vectors" => vectors(written, &wanted.vectors),
            "predicted_contacts" => {
                crate::solvers::dual::parity::compare_contacts(written, &wanted.predicted_contacts)
            }
            "node_solves" => solves(written, &wanted.solves),
            "product_sums" => all_fours(written, "product_sums", &wanted.sums),
            "level_counts" => records(written, "level_counts", counts),
            "force" => written.fours("force", &wanted.force),
            "new_velocity" => written.fours("new_velocity", &wanted.new_velocity),
            "new_position" => written.fours("new_position", &wanted.new_position),
            "statistics" => statistics(written, &wanted.statistics),
            "written_steps" => records(written, "written_steps", &wanted.steps),
            "couplings" => blocks(written, &wanted.elements.words),
            // Kernels of a kind write them.
            "element_forces" => all_fours(written, "element_forces", &wanted.elements.forces),
            "element_directions" => all_fours(written, "element_directions", &wanted.elements.directions),
            _ => {}
        }
    }
}

/// Blocks, of which the fourth words are only copied; so are the records of nodes, as bits.
fn blocks(written: &mut Written<'_>, wanted: &[[u32; 4]]) {
    let found: Vec<[u32; 4]> = written.take("couplings");
    let numbers = |all: &[[u32; 4]]| -> Vec<f32> {
        all.iter().flat_map(|&[x, y, z, _]| [x, y, z]).map(f32::from_bits).collect()
    };
    let lasts = |all: &[[u32; 4]]| -> Vec<f32> { all.iter().map(|words| words[3] as f32).collect() };
    written.outcome().compare("couplings", &numbers(wanted), &numbers(&found));
    written.outcome().copied("couplings.w", &lasts(wanted), &lasts(&found));
}

fn all_fours(written: &mut Written<'_>, name: &str, wanted: &[Four]) {
    let found: Vec<Four> = written.take(name);
    written.compare_fours(name, wanted, &found);
}

/// Each sort by itself.
fn vectors(written: &mut Written<'_>, wanted: &[Four]) {
    let found: Vec<Four> = written.take("vectors");
    let count = wanted.len() / VECTORS;
    for (sort, (wanted, found)) in wanted.chunks(count).zip(found.chunks(count)).enumerate() {
        written.compare_fours(&format!("vectors {sort}"), wanted, found);
    }
}

fn matrices<R: Pod, const N: usize>(
    written: &mut Written<'_>,
    name: &str,
    wanted: &[R],
    of: impl Fn(&R) -> [Symmetric; N],
) {
    let found: Vec<R> = written.take(name);
    for i in 0..N {
        // Each by itself: those of a node without mass and of a stiff one have little in common.
        for (wanted, found) in wanted.iter().zip(&found) {
            let six = |record: &R| {
                let Symmetric { diagonal, mixed, .. } = of(record)[i];
                [diagonal, mixed].concat()
            };
            written.outcome().compare(&format!("{name}[{i}]"), &six(wanted), &six(found));
        }
    }
    written.outcome().copied(&format!("{name}.len()"), &[wanted.len() as f32], &[found.len() as f32]);
}

fn solves(written: &mut Written<'_>, wanted: &[NodeSolve]) {
    let found: Vec<NodeSolve> = written.take("node_solves");
    let counts = |all: &[NodeSolve]| -> Vec<f32> {
        let of = |s: &NodeSolve| {
            let count = |d: &PcgState| [d.passes, d.is_done, d.iterations].map(|number| number as f32);
            let own = [s.steps, s.before, s.is_met, s.first].map(|number| number as f32);
            [&own[..], &count(&s.kept), &count(&s.next)].concat()
        };
        all.iter().flat_map(of).collect()
    };
    written.outcome().copied("node_solves", &counts(wanted), &counts(&found));
    let numbers = |d: &PcgState| [d.whole, d.error, d.alpha, d.beta];
    for (wanted, found) in wanted.iter().zip(&found) {
        written.outcome().compare("node_solves", &[wanted.motion], &[found.motion]);
        for (wanted, found) in [(&wanted.kept, &found.kept), (&wanted.next, &found.next)] {
            for (a, b) in numbers(wanted).into_iter().zip(numbers(found)) {
                written.outcome().compare("node_solves", &[a], &[b]);
            }
        }
    }
}
